#pragma once
// Models of cells that are no boxes: hexahedra with eight free corners, plane-strain quadrilaterals, linear tetrahedra.
//
// For comparison with other codes, curved bodies whose mesh follows their shape, and imported meshes; a patient's
// lattice has none of them. Such a cell is a HexCell whose stencil has neither K nor lambda: all of its energy is
// in material points that carry their own gradients (MaterialPoint::gradients), so the same minimiser, metric and
// reference solver work on it, in double, without the lattice's fast kernel. Unused corners of a tetrahedron or a
// quadrilateral repeat the first node with a gradient of zero. The multilevel cycle reads places on a lattice:
// give such models to a solver that always factors (MetricPolicy::factor_up_to_nodes).
//
// Integration:
//   hex   shape law at 2 x 2 x 2 Gauss points; volume law once, with the
//         gradients' mean over the cell (Flanagan and Belytschko 1981),
//         so that a patch of distorted cells stretches evenly. Without a
//         volume law: everything at the Gauss points (full integration)
//   quad  the same in the plane; every particle moves in it
//         only: F e3 = e3 (out-of-plane nodal motion has
//         its own, decoupled stiffness and stays zero)
//   tet   one point
#include <array>
#include <span>
#include <vector>

#include "sim/fem/model/fem_model.h"

namespace limberg {

class ShapedModel {
 public:
  /// Returns the node's index.
  int32_t add_node(const Vec3& X_mm, bool fixed = false);
  /// Returns the law's index, for the cells.
  int32_t add_law(LawPtr law);

  /// Corner order of fem_model.h. `volume` < 0: full integration of `shape`. InputError when the Jacobian is not
  /// positive at a Gauss point, or for an index that does not exist. The same holds for the others.
  void add_hex(const std::array<int32_t, 8>& nodes, int32_t shape, int32_t volume = -1);
  /// Corners in the order (0,0), (1,0), (0,1), (1,1); z is not used.
  void add_quad(const std::array<int32_t, 4>& nodes, double thickness_mm, int32_t shape, int32_t volume = -1);
  /// Any order of corners; of positive volume after sorting it.
  void add_tet(std::array<int32_t, 4> nodes, int32_t law);

  /// Lumped masses; the cells' own modulus for the metric is taken from their laws at rest.
  FemModel finish(double density_kg_mm3 = 1e-6) const;

 private:
  using Gradients = Eigen::Matrix<double, 8, 3>;
  struct Point {
    Gradients gradients;
    double volume_mm3;
    int32_t law;
  };
  void add_cell(const std::array<int32_t, 8>& nodes, const std::vector<Point>& points, double volume_mm3);
  void check(std::span<const int32_t> nodes, int32_t law) const;
  FemModel m_;
};

}  // namespace limberg
