#pragma once
// The nose upon a face: dorsum, tip, alae, columella, nostrils. Right half.
#include "sim/imaging/anatomical/fields.h"

namespace limberg::anatomical {

class Nose {
 public:
  double upon(double face, const Vec3& q) const {
    if (!near_.holds(q)) return face;
    double d = join(face, side_, q, 12);
    d = join(d, dorsum_, q, 10);
    double tip = join(tip_(q), dome_, q, 4);
    tip = join(tip, columella_, q, 4);
    d = smin(d, tip, 4.5);
    d = smin(d, ala_(q), 3.6);
    d = carve(d, groove_, q, 5);
    return carve(d, nostril_, q, 1.6);
  }

 private:
  Ball near_{{0, 100, -8}, 60};
  Tube dorsum_{{0, 90.6, 24, 4.6}, {0, 91.8, 15, 4.4}, {0, 101.4, 0, 4.8}, {0, 109.8, -14, 5.8}, {0, 113.4, -23, 6.6}};
  Tube side_{{4, 82.5, 22, 5}, {6.5, 88.5, 4, 7}, {8.5, 94, -10, 8.5}, {9, 97, -20, 9}};
  Tube tip_{{0, 114.4, -25.6, 7.4}, {0, 110, -26.5, 7.6}};
  Tube dome_{{3.6, 113.4, -25.6, 7.0}, {8, 107, -25.6, 6.8}};
  Turned ala_{{11.0, 104.3, -27.6}, {5.9, 9.6, 7.4}, (Mat3() << 0.94, 0.34, 0, -0.34, 0.94, 0, 0, 0, 1).finished()};
  Tube columella_{{0, 116, -29.2, 3.3}, {0, 110, -30.6, 3.0}, {0, 102, -31.0, 3.2}};
  Tube groove_{{12.6, 115, -20.5, 1.6}, {18.0, 107, -16.4, 2.2}, {21.2, 99, -20.5, 2.0}, {22, 97, -28, 1.4}};
  Tube nostril_{{7.4, 105.2, -36.5, 3.0}, {7.2, 107.2, -31, 3.2}, {6.4, 107, -25, 2.8}};
};

}  // namespace limberg::anatomical
