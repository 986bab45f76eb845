#pragma once
// The plain data of the arrangement: what the body's surface and all walls are made of.
//
// Names of things are indices. A face has corners 0, 1, 2 and edges 0, 1, 2; edge k runs from corner k to corner k + 1.
// A face has two sides, 0 = the positive side of its original triangle's plane, 1 = the negative side:
//
//   sided face       2 * face + side
//   sided half-edge  3 * sided_face + k
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/cutting/arrangement/surface_view.h"
#include "sim/cutting/strokes/blade.h"
#include "sim/geometry/exact/point.h"

namespace limberg {

inline constexpr uint8_t kMaterialPlus = 1;   // material on the positive side
inline constexpr uint8_t kMaterialMinus = 2;  // material on the negative side

inline int32_t sided_face(int32_t face, int side) { return 2 * face + side; }
inline int32_t sided_half_edge(int32_t sided, int k) { return 3 * sided + k; }
inline int32_t face_of_half_edge(int32_t h) { return h / 6; }
inline int32_t sided_of_half_edge(int32_t h) { return h / 3; }

/// A piece of an original triangle, with the same orientation. Skin has one material bit, a crack wall two, a piece
/// that belongs to nothing any more none. Faces are never renumbered: a face that a later cut divides is retired.
struct Face {
  std::array<int32_t, 3> v{};  // point ids
  int32_t orig = -1;           // its original triangle
  uint8_t mat = 0;             // kMaterialPlus | kMaterialMinus
  bool retired = false;        // replaced by others (and in no list any more)
  uint8_t inner = 0;  // bit k: across edge k lies a piece of the same triangle, and nothing else can ever meet there

  bool live() const { return !retired && mat != 0; }
  bool has_side(int side) const { return !retired && (mat >> side & 1); }
  uint8_t outer() const { return uint8_t(~inner & 7); }  // the other edges
};

/// An immutable triangle of the body (op 0) or of the blade of operation op >= 1. Its plane decides everything that
/// happens on it.
struct OrigTri {
  std::array<int32_t, 3> v{};  // explicit point ids
  Plane plane;
  int32_t op = 0;
  int32_t live = 0;    // live faces on it
  int32_t whole = -1;  // its one face, or -1 when it is divided
  int32_t split = -1;  // index into the division table when divided
};

/// A junction on an original triangle: the sub-edge a-b lies also on original triangle `partner`.
struct Constraint {
  int32_t a = -1, b = -1, partner = -1;
};

/// The complete current triangulation of a divided original triangle, pieces without material included: ranges of the
/// store's division_face and division_constraint.
struct Division {
  uint32_t first_face = 0, faces = 0, first_constraint = 0, constraints = 0;
};

/// One closed component of the sided surface.
struct SurfaceComponent {
  int32_t first_sided_face = -1;  // the smallest; orders components
  int32_t sided_faces = 0;
  double volume_mm3 = 0;       // enclosed, outward positive; a cavity is negative
  bool touches_fixed = false;  // holds a face of the body tagged `fixed`
};

struct CutResult {
  enum Status : uint8_t {
    done,
    nothing_to_cut,  // the blade meets no material that is not cut already; nothing changed
    refused          // see reason; nothing changed
  };
  Status status = refused;
  std::string reason;
  int32_t op = -1;  // number of the cut: SurfaceView::origin of its walls
  int tries = 0;    // 1 + redraws of the jitter
  int wall_faces = 0;
  int patches = 0, patches_kept = 0;
  std::vector<int32_t> blade_point;  // per blade vertex: its explicit point, for Blade::shared_point of a later blade
  bool ok() const { return status == done; }
};

struct ExciseResult {
  bool done = false;
  std::string reason;
  int32_t sided_faces = 0;
  double volume_mm3 = 0;
};

struct DebrisResult {
  int pieces = 0;
  double volume_mm3 = 0;
};

/// What the last operation (cut, excision or undo) did to faces; ids ascending.
struct LastOperation {
  enum Kind : uint8_t { none, cut, excision, undone };
  Kind kind = none;
  std::vector<int32_t> removed;    // faces that were live before and are not any more (divided or taken away)
  std::vector<int32_t> added;      // live faces that were not there (or not live) before
  std::vector<int32_t> changed;    // faces whose material bits changed and that are still live
  std::vector<int32_t> new_walls;  // cut: the subset of `added` that is new wall
};

}  // namespace limberg
