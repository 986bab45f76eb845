#pragma once
// What the lattice reads of the boundary of the material: a view of an Arrangement's arrays, valid until it changes.
//
// Faces carry two material bits and are glued along sided half-edges (arrangement_types.h); points are exact. Tests may
// fill the arrays by hand.
#include <span>

#include "sim/cutting/arrangement/arrangement_types.h"
#include "sim/geometry/exact/predicates.h"
#include "sim/geometry/rest_grid.h"
#include "sim/geometry/tri_mesh.h"

namespace limberg {

class Arrangement;
class PointStore;
struct OperationDelta;

struct MaterialSurface {
  RestGrid grid;
  std::span<const Face> faces;                   // retired and dead ones included; index = face id
  std::span<const std::array<int32_t, 6>> mate;  // per face, [3 * side + edge]: sided half-edge or -1
  std::span<const OrigTri> orig;
  std::span<const SurfaceTag> tag;  // per triangle of the body; originals of op 0 come first
  const PointStore* points = nullptr;
  const std::vector<OperationDelta>* history = nullptr;  // what each operation has changed; null: not recorded
  int32_t operations() const;                            // so far

  /// Those of the first `faces_then` faces that may have changed since there were so many operations, ascending: a few,
  /// when there is a history, else all.
  std::vector<int32_t> suspects(int32_t operations_then, size_t faces_then) const;

  const Plane& plane(int32_t face) const { return orig[size_t(faces[size_t(face)].orig)].plane; }
  bool is_fixed(int32_t face) const {
    const int32_t o = faces[size_t(face)].orig;
    return orig[size_t(o)].op == 0 && size_t(o) < tag.size() && tag[size_t(o)] == SurfaceTag::fixed;
  }
};

MaterialSurface material_surface(const Arrangement& arrangement);

}  // namespace limberg
