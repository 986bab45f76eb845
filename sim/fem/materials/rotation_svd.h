#pragma once
// F = U diag(s) V^T with U and V rotations: s[0] >= s[1] >= |s[2]|, and s[2] < 0 exactly when F is inverted.
#include "sim/geometry/vec.h"

namespace limberg {

struct RotationSvd {
  Mat3 U = Mat3::Identity(), V = Mat3::Identity();
  Vec3 s = Vec3::Ones();
};

/// Defined for every finite F, the zero matrix included. Jacobi rotations on F^T F, then columns of U from F V.
RotationSvd rotation_svd(const Mat3& F);

}  // namespace limberg
