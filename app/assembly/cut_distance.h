#pragma once
// How far places are from a cut of bone, planned or sawn. In mm in the frame of the head, on the bones where they were
// at first.
#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "app/assembly/lesson_steps.h"
#include "sim/commands/head_command.h"

namespace limberg {

/// The planes of a cut: through `at`, between the rays u and v, or all round within `reach` (0: without end).
struct SawPlane {
  Vec3 at = Vec3::Zero(), normal = Vec3::UnitZ(), u = Vec3::Zero(), v = Vec3::Zero();
  double reach = 0;
  bool reaches(const Vec3& p) const {
    const Vec3 r = p - at - (p - at).dot(normal) * normal;
    if (reach > 0 && r.norm() > reach) return false;
    if (u.isZero(0)) return true;
    const Vec3 w = u.cross(v);
    return u.cross(r).dot(w) >= 0 && r.cross(v).dot(w) >= 0;
  }
  /// Where it runs through a triangle, however far it reaches; nothing: beside it.
  std::optional<std::pair<Vec3, Vec3>> through(const std::array<Vec3, 3>& triangle) const;
};
std::vector<SawPlane> planes_of(const HeadCommand& cut);
/// Of those that reach there; null: none does.
const SawPlane* nearest_plane(const std::vector<SawPlane>& planes, const Vec3& place_mm);

/// From the cut to a place: the nearest place of the cut is at `place - off`. Nothing: it is no cut, or its plane does
/// not reach there.
std::optional<Vec3> beside_cut(const HeadCommand& cut, const Vec3& place_mm);

/// How near a cut comes to a limit on bone; nothing: the limit is not one of bone, or this is no cut.
std::optional<double> nearest_to_limit_mm(const SafeLimit& limit, const HeadCommand& cut);

}  // namespace limberg
