#pragma once
// Material points carried by the lattice: the cell copy that holds a point of the surface, and its trilinear weights.
//
// Weights come from the rest position and the cell alone. A cut changes only which node copies they point to, and node
// copies start at their parents' positions: no existing point moves when a cut is made.
#include <array>
#include <span>
#include <vector>

#include "sim/lattice/topology.h"

namespace limberg {

/// Fills view.cell_copy and returns one EmbeddedPoint per vertex of the view. Each vertex lies, exactly, in one cell;
/// the copy is that of the class which holds the sided faces around it.
SharedArray<EmbeddedPoint> embed_surface(const LatticeTopology& topology, const MaterialSurface& surface,
                                         SurfaceView& view);

/// The same from an earlier version of both: vertices that were there, in a cell copy that has not come apart, keep
/// their weights. `change` as Arrangement::surface_view gives it; topology.cell_parent must index the earlier topology.
/// Costs what has changed, unless that is everything.
struct EarlierEmbedding {
  const LatticeTopology& topology;
  const SurfaceView& view;
  const SharedArray<EmbeddedPoint>& embedding;
  const ViewChange& change;
};
SharedArray<EmbeddedPoint> embed_surface(const LatticeTopology& topology, const MaterialSurface& surface,
                                         SurfaceView& view, const EarlierEmbedding& before);

/// A point of view triangle `tri` by barycentric coordinates; rest position returned through X_mm when asked for.
EmbeddedPoint embed_point(const LatticeTopology& topology, const SurfaceView& view, int32_t tri,
                          const std::array<double, 3>& bary, Vec3* X_mm = nullptr);

/// The cell copy that carries a point of view triangle `tri`.
int32_t copy_of_point(const LatticeTopology& topology, const SurfaceView& view, int32_t tri,
                      const std::array<double, 3>& bary, Vec3* X_mm = nullptr);

/// The point X (on or next to the surface) as carried by cell copy `copy`, whatever its cell: weights extrapolate when
/// X lies outside.
EmbeddedPoint embed_in_copy(const LatticeTopology& topology, int32_t copy, const Vec3& X_mm);

/// Undivided cell (id) that contains X by its double coordinates, clamped to the lattice.
int32_t cell_of(const LatticeTopology& topology, const Vec3& X_mm);

}  // namespace limberg
