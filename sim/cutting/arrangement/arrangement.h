#pragma once
// The exact arrangement of the body's surface and every wall cut into it, in rest space.
//
//   Arrangement a(body.surface, body.grid);
//   CutResult r = a.cut(blade, seed);      // atomic: done, or nothing has changed (same hash)
//   a.excise(component); a.undo();
//
// What holds the house together
//  * Every point is a corner of an original triangle or an intersection of original triangles (point.h). So no number
//    ever grows, and every decision is the sign of a small integer determinant.
//  * A crack is ONE face with material on both sides. Nothing is ever moved apart: the two banks are the two sides.
//  * One gluing rule: sort the live faces around an edge; two consecutive ones bound a sector; either both face
//    material there, then these two sided half-edges are mates, or neither does. A crack front is the case of one face.
//    The sided faces so glued are the closed oriented surface of the material; its components are what can be taken
//    away.
//  * New intersections are computed between original triangles only, then divided at stored junctions.
//  * A blade cuts where it is in material AND drawn: its pieces between junctions with what exists (patches) are kept
//    when every junction says "inside" and one of its triangles is a seed. So a blade stops at the far wall of a
//    pocket.
//
// The steps of a cut (cut_builder.h): jitter, embedding test, broad and narrow phase, scratch division, barriers,
// patches, selection, division by what is needed, commit, check. A coincidence (an exact zero) is never decided: the
// blade is redrawn within 8 micrometres and tried again, 8 times at most.
#include <memory>
#include <span>

#include "sim/cutting/arrangement/arrangement_types.h"
#include "sim/geometry/exact/predicates.h"
#include "sim/geometry/rest_grid.h"
#include "sim/geometry/tri_mesh.h"

namespace limberg {

struct ArrangementStore;
struct FaultPlan;

class Arrangement {
 public:
  /// The surface must be closed and oriented, with vertices on the even grid (Body::surface is); else InputError.
  Arrangement(const TriMesh& surface, const RestGrid& grid);
  ~Arrangement();
  Arrangement(Arrangement&&) noexcept;
  Arrangement& operator=(Arrangement&&) noexcept;

  /// `first_try`: redraws of the jitter to pass over. With CutResult::tries - 1 of a cut that was made and taken back,
  /// on the same state, it is made again bit for bit.
  CutResult cut(const Blade& blade, uint64_t seed, int first_try = 0);
  /// Takes one component of the sided surface away: its material bits are cleared. Index into components().
  ExciseResult excise(int32_t component);
  /// Takes away every loose piece (no `fixed` face) smaller than this, as part of the last operation: its undo brings
  /// them back. Blades that nearly coincide leave such slivers; a solver cannot hold them.
  DebrisResult sweep_debris(double below_mm3);
  DebrisResult find_debris(double below_mm3) const;  // what that would take
  /// Takes the last cut or excision back, exactly. False when there is none.
  bool undo();
  /// So many undo() in a row then need no more memory.
  void make_room_to_undo(int32_t operations);
  int32_t operations() const;  // that undo() could take back

  /// Of the live faces with their bits and exact corners: equal before and after a refused cut, or a cut and its undo.
  /// Independent of memory addresses and machine. O(1).
  uint64_t hash() const;
  /// The same over every array, gluing included. O(N), for tests.
  uint64_t full_hash() const;

  // --- Points -------------------------------------------------------------------------------------------------------
  int32_t point_count() const;
  Vec3 point_mm(int32_t point) const;
  /// Half-units: double approximation and, for implicit points, the exact form. Valid until the next cut or undo.
  PointRef point(int32_t point) const;
  bool is_explicit(int32_t point) const;
  Int3 explicit_point(int32_t point) const;  // half-units, even
  const RestGrid& grid() const;

  // --- Faces --------------------------------------------------------------------------------------------------------
  std::span<const Face> faces() const;  // all ever made; skip those that are not live()
  std::span<const OrigTri> orig_tris() const;
  /// The sided half-edge glued to this one (-1 where the side has no material). Its end points are the same two.
  int32_t mate(int32_t sided_half_edge) const;
  FaceKind kind_of_orig(int32_t orig) const;
  /// Junctions on an original triangle (empty when it is undivided).
  std::span<const Constraint> constraints_of(int32_t orig) const;
  std::span<const int32_t> faces_of_orig(int32_t orig) const;  // its triangulation, dead faces included
  const LastOperation& last_operation() const;

  // --- Components of the sided surface ------------------------------------------------------------------------------
  /// In order of their smallest sided face. O(N) once per version.
  const std::vector<SurfaceComponent>& components() const;
  int32_t component_of(int32_t sided_face) const;
  /// The component without `fixed` faces whose surface is nearest to a picked point (mm). If there is none within
  /// max_distance_mm, any component but the largest (a plug cut out through the held side of a thin part). Else -1.
  int32_t loose_component_near(const Vec3& at_mm, double max_distance_mm) const;
  int pieces() const;         // components of positive volume
  double volume_mm3() const;  // of all material

  /// The boundary of the material as a closed oriented mesh; cell_copy is left empty for the lattice to fill.
  SurfaceView surface_view() const;
  /// The same mesh from `before`: the view when there had been `operations_then` operations, of a state that the
  /// present one has come from by cuts and excisions alone. Costs what has changed, unless something was taken away.
  SurfaceView surface_view(const SurfaceView& before, int32_t operations_then, ViewChange& change) const;

  /// Empty when every invariant holds everywhere; else the first violation. O(N), for tests and for finding defects.
  std::string check_all() const;

  const ArrangementStore& store() const { return *store_; }  // to read: store.h
  /// Lets steps of later operations fail as planned (fault.h); null: none does. For tests.
  void set_fault(FaultPlan* plan);

 private:
  std::unique_ptr<ArrangementStore> store_;
};

}  // namespace limberg
