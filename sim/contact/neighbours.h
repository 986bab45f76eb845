#pragma once
// May a triangle press on a place at all, or are they the same piece of tissue? Decided at rest, once and for all.
//
// Two points of the surface that are farther than 5 mm apart at rest are always others. Nearer ones are
//   others      when their rest normals are opposed (N . N_T < -0.5) and they lie in one another's rest plane or before it: the
//               banks of a cut, which coincide at rest, up to the line where the cut ends;
//   neighbours  when normals are opposed and each lies behind the other: the two sides of a thin flap;
//   others      when one cannot get from one to the other over the surface within 5 mm: a flap's wall and the bed below it;
//   neighbours  otherwise: the two sides of a flap's tip, the wall and the floor of a defect, a wall and its surroundings.
// The walk over the surface is made only for the few places that ask, once each.
#include <cstdint>
#include <memory>
#include <vector>

#include "sim/contact/contact_surface.h"

namespace limberg {

class Neighbours {
 public:
  explicit Neighbours(std::shared_ptr<const ContactSurface> surface);

  struct Place {
    size_t index = 0;
    int32_t triangle = 0;  // it lies on
    Vec3 X_mm, N;
  };
  /// Is the point X_mm of triangle t, whose rest normal is N, another's? Different places may be asked about at the same time.
  bool other(const Place& place, int32_t t, const Vec3& X_mm, const Vec3& N);

 private:
  const std::vector<int32_t>& reached(const Place& place);
  std::shared_ptr<const ContactSurface> surface_;
  std::vector<Vec3> middle_;                   // of each triangle, at rest
  std::vector<std::vector<int32_t>> reached_;  // per place, sorted; empty: not asked yet
};

}  // namespace limberg
