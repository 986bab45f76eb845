#include "sim/imaging/anatomical/ear_shape.h"

namespace limberg::anatomical {

Ear::Ear() : origin_(70.5, -3.5, 1) {
  // The plate stands off the head by 28 degrees, and the long axis leans backwards by 16.
  const Vec3 v = Vec3(0.10, -0.275, 0.956).normalized();
  Vec3 u(0.47, -0.883, 0);
  u = (u - u.dot(v) * v).normalized();
  axes_.col(0) = u, axes_.col(1) = v, axes_.col(2) = -u.cross(v);
  if (axes_.col(2).x() < 0) axes_.col(2) *= -1;
}

}  // namespace limberg::anatomical
