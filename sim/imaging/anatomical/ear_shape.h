#pragma once
// The auricle upon a head: helix, antihelix with two crura, tragus, antitragus, concha, lobule. Right half.
#include "sim/imaging/anatomical/fields.h"

namespace limberg::anatomical {

/// In axes of the ear: u backwards along the plate, v up along its long axis, w outwards; origin at the canal.
class Ear {
 public:
  Ear();
  double upon(double head, const Vec3& q) const {
    if (!near_.holds(q)) return head;
    const Vec3 e = axes_.transpose() * (q - origin_);
    double plate = Vec2(std::max(ellipse(e), 0.), std::max(std::abs(e.z() - sheet(e)) - 1.0, 0.)).norm() +
                   std::min(std::max(ellipse(e), std::abs(e.z() - sheet(e)) - 1.0), 0.) - 1.0;
    plate = smin(plate, back_(e), 5);
    plate = smax(plate, -concha_(e), 3);
    plate = smin(plate, lobule_(e), 4);
    plate = join(plate, antihelix_, e, 3);
    plate = smin(plate, std::min(upper_crus_(e), lower_crus_(e)), 3);
    plate = join(plate, helix_, e, 2.0);
    plate = join(plate, antitragus_, e, 3);
    double d = smin(head, plate, 3.5);
    d = carve(d, canal_, e, 2);
    return join(d, tragus_, e, 3.2);
  }

 private:
  static double ellipse(const Vec3& e) {
    static const Ellipsoid o({14.5, 3.5, 0}, {14.5, 28, 1000});
    return o(Vec3(e.x(), e.y(), 0));
  }
  static double sheet(const Vec3& e) { return 0.010 * (e.x() - 10) * (e.x() - 10) - 1; }
  Vec3 origin_;
  Mat3 axes_;
  Ball near_{{74, -14, 2}, 48};
  Tube helix_{{8, 0.5, 1.5, 1.6},   {3.5, 4, 2, 2.0},    {0.5, 11, 2.2, 2.3}, {0.6, 20, 1.8, 2.5},
              {5, 28, 2, 2.6},      {13, 32, 2.6, 2.7},  {22, 30, 3.0, 2.7},  {28.6, 23, 3.4, 2.6},
              {30.8, 13, 3.6, 2.4}, {29.8, 3, 3.4, 2.2}, {26, -8, 2.6, 2.0},  {20.5, -17, 1.2, 1.8},
              {16, -23, 0.6, 1.6}};
  Tube antihelix_{
      {10.5, -14.5, 3, 2.2}, {17, -9.5, 4.0, 2.4}, {21, -1, 4.6, 2.6}, {21, 7, 4.4, 2.7}, {19.5, 13, 3.8, 2.6}};
  Tube upper_crus_{{19.5, 13, 3.8, 2.6}, {16, 20, 2.6, 2.4}, {12, 26, 1.4, 1.8}};
  Tube lower_crus_{{19.5, 13, 3.8, 2.4}, {12, 14.5, 2.0, 2.0}, {4, 14, 0.6, 1.6}};
  Tube antitragus_{{8.5, -14.8, 2.4, 2.6}, {11, -14.4, 3, 2.2}};
  Tube tragus_{{-0.5, -1, 1.6, 2.6}, {0.6, -5.5, 2.2, 2.8}, {0.2, -9, 1.0, 2.4}};
  Tube canal_{{6, -3, 0, 3.4}, {1.5, -3, -8, 3.0}};
  Ellipsoid concha_{{9.8, -3.0, 5.0}, {9.2, 13.0, 8.6}};
  Ellipsoid lobule_{{8.0, -22.5, 0.2}, {8.6, 9.2, 3.4}};
  Ellipsoid back_{{8, 0, -6}, {10, 19, 7.5}};
};

}  // namespace limberg::anatomical
