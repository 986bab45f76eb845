#pragma once
// What the elasticity solver is given: trilinear hexahedra on copies of lattice nodes, with everything that is constant
// in a cell computed once, exactly, at set-up.
//
// Energy of a cell (stable neo-Hookean without the logarithm; Smith, de Goes, Kim 2018; reparametrised, so that
// lambda below = lambda_Lame + mu), selective reduced integration:
//
//   E = scale * [ 1/2 sum_ab K_ab (x_a . x_b)  +  V ( lambda/2 (J_c - 1)^2 - p0 (J_c - 1) ) ]
//
//   K_ab = integral over the full cell of mu(X) grad N_a . A(X) grad N_b,  A = F0 F0^T,  F0 the prestretch, det F0 = 1
//   J_c  = det F at the stencil's sample point, p0 = mean of mu n.A
//        n (n the skin normal). The sample point is the centroid
//          of mu n.A n: then the pressure balances the layers through the cell,
//          not only on average, a flat prestretched layer rests under a free
//          surface, and a cut through tissue without prestretch stays shut.
//
// mu/2 |F F0|^2 is quadratic in x, so K carries layers thinner than a cell, prestretch and full integration
// (hourglass control included) at no run-time cost; sub-cell quadrature fills it.
// A cell that layers share (slide > 0) takes J_c at its centre, where it is the cell's mean: what flows
// out of one layer must flow somewhere. layer_slide.h has what is added there, so that its layers give
// way to each other along their planes and that their stretch is still that at the sample point.
// Corner order: bit 0 = +x, bit 1 = +y, bit 2 = +z.
//
// Cells of a lattice that is finer in places have a level: their edges are FemModel::cell_mm / 2^level, and so are
// those of the stencils they name. Where levels meet (never by more than one, over squares, edges and corners) the
// nodes of the finer cells that are no corner of the coarser one hang: they are not unknowns but lie where the coarser
// cell's nodes, their masters, put them. With P from unknowns to all nodes, the minimiser works on E(P x):
// displacements are spread to the hanging nodes before the cells are visited, forces are gathered from them afterwards
// (hanging_nodes.h), and the scalar matrix is P^T A P (scalar_matrix.h), so that the metric never meets a hanging node.
// Displacements, velocities and reports still have one entry per node, and points may be embedded in hanging ones.
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "sim/base/parent_list.h"
#include "sim/base/shared_array.h"
#include "sim/fem/materials/law.h"
#include "sim/fem/model/held.h"
#include "sim/geometry/vec.h"

namespace limberg {

using Mat8 = Eigen::Matrix<double, 8, 8>;

/// A quadrature point of a cell at which a law of its own adds volume_mm3 * W(F M). Laws
/// come beside the quadratic part K (matrix in K, fibres here) or instead of it (K = 0).
/// M holds prestretch and axes: the law sees F M, so its first axis lies along M e1.
struct MaterialPoint {
  Vec3 at = Vec3::Constant(0.5);  // in cell units
  double volume_mm3 = 0;
  int32_t law = 0;  // of FemModel::laws
  Mat3 M = Mat3::Identity();
  // Not null: grad N_a (1/mm) at this point, of a cell that is
  // no box of the lattice (shaped_cells.h); `at` is unused then.
  std::shared_ptr<const Eigen::Matrix<double, 8, 3>> gradients;
};

/// A place of a cell where resistance to change of shape fades after a strain (dynamic steps; viscous_points.h). The
/// law is the whole of the layer there, matrix included, as it is once relaxed.
struct ViscousPoint {
  struct Term {
    double ratio = 0, time_s = 1;  // stiffness that fades over the relaxed one; its time
  };
  Vec3 at = Vec3::Constant(0.5);
  double volume_mm3 = 0;
  int32_t law = 0;
  Mat3 M = Mat3::Identity();
  std::vector<Term> terms;
};

/// The constants of one kind of full cell; many cells share one.
struct Stencil {
  Mat8 K = Mat8::Zero();  // mN/mm, symmetric, rows sum to 0
  double volume_mm3 = 0;  // of the full cell
  double mu_kPa = 0;      // volume mean, for the preconditioner weight and for reports
  double lambda_kPa = 0;  // reparametrised, volume mean
  double p0_kPa = 0;
  // where J is evaluated, in cell units (0..1 per axis); the centre when homogeneous
  Vec3 sample = Vec3::Constant(0.5);
  double density_kg_mm3 = 0;
  double slide_kPa = 0;                // 0: one layer, or none thinner than the cell
  Mat3 slide_axes = Mat3::Identity();  // columns: two along the layers, their normal
  uint8_t level = 0;                   // of the cells that it is for; all lengths here are theirs
  // Not null: the forces at rest (mN), rows of sum zero, of a cell whose K is no integral of trilinear gradients
  // (held_cells.h); else they are those of K and p0.
  std::shared_ptr<const Eigen::Matrix<double, 8, 3>> rest_mN;
  // Not null: the gradients (1/mm) that the volume is measured with instead of those at `sample`. In a cell that the
  // body cuts askew the mean of trilinear gradients is that of no place, and a body under no load would not rest.
  std::shared_ptr<const Eigen::Matrix<double, 8, 3>> mean_gradients;
  std::vector<MaterialPoint> points;  // empty for cells whose whole shape energy is in K, and then costs nothing
  std::vector<ViscousPoint> viscous;  // empty where nothing relaxes, and then costs nothing
};

/// Edges of a cell of that level.
inline Vec3 cell_size_mm(const Vec3& cell_mm, int level) { return cell_mm / double(1 << level); }

/// grad N_a (1/mm) at a place in cell units, one row per corner. `cell_mm`: of the undivided cell.
inline Eigen::Matrix<double, 8, 3> trilinear_gradients(const Stencil& s, const Vec3& at, const Vec3& cell_mm) {
  const Vec3 h = cell_size_mm(cell_mm, s.level);
  Eigen::Matrix<double, 8, 3> B;
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i) {
      B(a, i) = ((a >> i & 1) ? 1 : -1) / h[i];
      for (int j = 0; j < 3; ++j)
        if (j != i) B(a, i) *= (a >> j & 1) ? at[j] : 1 - at[j];
    }
  return B;
}

/// The same at a material point.
inline Eigen::Matrix<double, 8, 3> point_gradients(const Stencil& s, const MaterialPoint& p, const Vec3& cell_mm) {
  return p.gradients ? *p.gradients : trilinear_gradients(s, p.at, cell_mm);
}

/// The same at the stencil's sample point, or their mean; in a cell that is no box, at its first material point.
inline Eigen::Matrix<double, 8, 3> sample_gradients(const Stencil& s, const Vec3& cell_mm) {
  if (!s.points.empty() && s.points[0].gradients) return *s.points[0].gradients;
  return s.mean_gradients ? *s.mean_gradients : trilinear_gradients(s, s.sample, cell_mm);
}

/// The same where the volume is sampled, if the stencil has lambda.
inline Eigen::Matrix<double, 8, 3> volume_gradients(const Stencil& s, const Vec3& cell_mm) {
  return s.slide_kPa != 0 ? trilinear_gradients(s, Vec3::Constant(0.5), cell_mm) : sample_gradients(s, cell_mm);
}

struct HexCell {
  std::array<int32_t, 8> node{};
  int32_t stencil = 0;
  // volume of this copy of the cell over what its stencil stands for (the whole cell, or the body's part of a cell that
  // the body does not fill), floored for conditioning; 0: absent (all its nodes are held)
  float scale = 1;
  std::array<int16_t, 3>
      at{};           // its low corner on the lattice, in halves of an undivided cell (rounded down from level 2)
  uint8_t level = 0;  // 0: undivided; 1: one of the eight parts of a divided cell; 2, 3: one of eight of such
  bool operator==(const HexCell&) const = default;
};

/// A node in the middle of an edge or a square of a coarser neighbour: not free, but where its masters put it.
struct HangingNode {
  int32_t node = -1;
  int32_t count = 0;  // 2 or 4 masters, none of them hanging
  std::array<int32_t, 4> master{};
  std::array<float, 4> weight{};  // sum 1
};

/// A node that was not there before: its state is an average of that of nodes of the previous model, so that a point in
/// a cell that has been divided moves with the parts exactly as it did with the whole.
struct BornNode {
  int32_t node = -1;
  std::vector<std::pair<int32_t, float>> from;  // previous node, weight; sum 1
};

/// Versions of a model share what a cut has not changed.
struct FemModel {
  Vec3 cell_mm = Vec3::Ones();  // of an undivided cell (level 0)
  SharedArray<Vec3> X_mm;       // rest positions of node copies
  SharedArray<Held> fixed;      // per node: what of it is Dirichlet (stays at X)
  SharedArray<double> mass_kg;  // per node, lumped, exact fractions (no floor)
  SharedArray<HexCell> cells;
  SharedArray<Stencil> stencils;
  std::vector<LawPtr> laws;  // named by the material and viscous points of stencils
  // Per node: its index in the previous model (state is carried from it); -1 only at start. For a node in `born`: the
  // first of the previous nodes with the largest weight.
  ParentList parent;
  std::vector<BornNode> born;  // ascending by node
  std::vector<HangingNode>
      hanging;          // ascending by node; empty on a lattice without divided cells, and then costs nothing
  bool graded = false;  // many of its cells are parts: the multilevel cycle puts them together step by step
};

/// A material point carried by one cell copy: position = sum w_i x[node_i]; weights are rest-only and sum to 1.
struct EmbeddedPoint {
  std::array<int32_t, 8> node{};
  std::array<float, 8> w{};
  bool operator==(const EmbeddedPoint&) const = default;
};

/// One of the places that hold or bear something together. In their mean it counts `share`, in units of all shares;
/// shares below 0 are allowed (a mean that stands for a place beside the others), their sum is above 0.
struct HeldPlace : EmbeddedPoint {
  double share = 1;
  HeldPlace() = default;
  HeldPlace(const EmbeddedPoint& point, double counts = 1) : EmbeddedPoint(point), share(counts) {}
  bool operator==(const HeldPlace&) const = default;
};

/// A zero-length embedded spring: point a to point b (a suture), or point a to a place in the world (a hook).
struct Spring {
  int32_t id = 0;
  HeldPlace a, b;
  // Not empty: this end holds the mean of these places instead of one (a point load has no limit as cells get smaller).
  std::vector<HeldPlace> a_wide, b_wide;
  std::span<const HeldPlace> held_a() const { return a_wide.empty() ? std::span(&a, 1) : std::span(a_wide); }
  std::span<const HeldPlace> held_b() const { return b_wide.empty() ? std::span(&b, 1) : std::span(b_wide); }
  bool to_world = false;
  bool lasting = false;  // it never moves and stays as long as the model: the metric takes it for a part of the tissue
  // to_world: the place that pulls a. Otherwise the gap still allowed, a - b at rest: zero once a stitch is tight.
  Vec3 target_mm = Vec3::Zero();
  double k_N_per_mm = 1;
  // Springs of one number above 0 are the spans of one thread that slides through its bites: together thread_mm long
  // (the same in all of them) without tension, of which a span keeps |target_mm|. See spring_forces.h.
  // ReferenceElasticity knows none.
  int32_t thread = 0;
  double thread_mm = 0;
};

/// A dead force on the tissue: it keeps size and direction, whatever moves. Its places share it (a point load has no
/// limit as cells get smaller).
struct DeadLoad {
  std::vector<HeldPlace> at;  // one at least
  Vec3 force_mN = Vec3::Zero();
};

/// A one-sided spring between two places of the tissue that must not pass through each other. With the overlap
/// p = gap - n.(x_a - x_b): no energy for p <= 0, k p^3 / (6 soft) up to p = soft, from there a parabola of curvature k
/// that continues it with force and slope: k ((p - soft/2)^2 / 2 + soft^2 / 24). It pushes, never pulls.
///
/// Friction: what of x_a - x_b - stick lies across the normal, y, is drawn back by grip y, up to hold: energy
/// grip y^2 / 2 to y = hold / grip, from there hold (y - hold / (2 grip)). The hold stands still while a minimiser
/// works (it is a share of a push that was found before), so that there is an energy.
struct Contact {
  EmbeddedPoint a, b;
  Vec3f normal = Vec3f::UnitZ();  // unit, from b's surface towards a
  float gap_mm = 0;
  float soft_mm = 0;  // overlap over which the stiffness sets in; 0: at once
  float k_N_per_mm = 1;
  Vec3f stick_mm = Vec3f::Zero();
  float hold_mN = 0, grip_N_per_mm = 0;  // hold 0: no friction
};

}  // namespace limberg
