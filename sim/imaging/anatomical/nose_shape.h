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
    d = smin(d, tip, 8);
    d = smin(d, ala_(q), 3.6);
    d = carve(d, groove_, q, 5);
    return carve(d, nostril_, q, 1.6);
  }

 private:
  Ball near_{{0, 100, -8}, 60};
  Tube dorsum_{{0, 92.0, 24, 5.0}, {0, 93.0, 15, 4.6}, {0, 102.0, 0, 5.0}, {0, 110.4, -14, 6.0}, {0, 114.6, -22, 7}};
  Tube side_{{4, 82.5, 22, 5}, {6.5, 88.5, 4, 7}, {8.5, 94, -10, 8.5}, {9, 97, -20, 9}};
  Tube tip_{{0, 115.4, -24.2, 7.6}, {0, 111, -26, 8}};
  Tube dome_{{3.6, 114.0, -24.2, 7.2}, {8, 107.5, -25, 7.0}};
  Turned ala_{{11.4, 104.3, -27.6}, {5.9, 9.6, 7.4}, (Mat3() << 0.94, 0.34, 0, -0.34, 0.94, 0, 0, 0, 1).finished()};
  Tube columella_{{0, 117, -29.4, 3.6}, {0, 110, -32.2, 3.3}, {0, 102, -33.8, 3.8}};
  Tube groove_{{12.6, 115, -20.5, 1.6}, {18.0, 107, -16.4, 2.2}, {21.2, 99, -20.5, 2.0}, {22, 97, -28, 1.4}};
  Tube nostril_{{7.6, 105.8, -36.5, 3.0}, {7.4, 107.5, -31, 3.3}, {6.6, 107, -25, 3.0}};
};

}  // namespace limberg::anatomical
