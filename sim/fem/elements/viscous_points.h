#pragma once
// Resistance that fades: stress relaxation of layers with a Prony series, in dynamic steps.
//
// At a viscous point (fem_model.h) a layer of law W carries, beside W itself, one branch per term with the stiffness
// ratio_i W. A branch's stress follows every change of the layer's own shape stress S and forgets it with its time
// (Simo 1987, in second Piola stresses; a = exp(-dt/t_i), h = exp(-dt/2 t_i): second order in dt):
//
//   H_i(n+1) = a_i H_i(n) + ratio_i h_i (S(n+1) - S(n)),    S = 2 dW/dC - s C^-1,  s = (2 dW/dC : C)/3   (no pressure
//                                                                                                        in it)
//
// W and C in the law's axes: F M. During a step that is the energy
//
//   V [ G W + 1/2 B : C - G s(n) L(J) ],    G = sum ratio_i h_i,   B = sum a_i H_i(n) - G S(n),   L = ln J
//
// so one minimiser serves; the last term takes off the pressure that W brings along, so tissue
// at rest stays at rest (L goes on as a parabola below J = 0.2). For a neo-Hookean layer the
// sum of all terms in C is positive definite whatever has happened before: B is a sum of S's
// neo-Hookean part, which G W cancels, and of C^-1's of the past with positive weights.
//
// Where the law is neo-Hookean, W = mu/2 (I1 - 3), the shape's part of it all is half a constant tensor times the
// change of C; such cells have a loop of their own (kernels/viscous.cpp). Other laws are asked point by point.
//
// A quasi-static step knows no time: it is the relaxed tissue, and leaves all branches empty. What S was at its end is
// worked out when somebody asks (a dynamic step, a saved state), with the bits that it would have had at once. A model
// without viscous points has no list here and costs nothing. Closed forms: tests/sim/fem/materials/test_viscous.cpp.
#include <span>
#include <vector>

#include "sim/base/parent_list.h"
#include "sim/fem/elements/cell_scatter.h"
#include "sim/fem/model/fem_model.h"
#include "sim/fem/solver/engine.h"

namespace limberg::fem {

class ViscousPoints {
 public:
  ViscousPoints() = default;
  explicit ViscousPoints(const FemModel& model);
  bool empty() const { return cells_.empty(); }
  bool in_no_stencil() const { return points_.empty(); }

  /// The branches of the model before, by cell_parent and law; what is new starts relaxed at u (of this model).
  void carry(const ViscousPoints& before, const ParentList& cell_parent, const NodeArray& u);

  void begin_step(double dt_s);  // dynamic
  bool in_step() const { return in_step_; }
  CellSums add(const NodeArray& u, NodeArray& g, bool measure, const Engine& engine) const;
  void end_step(const NodeArray& u);  // branches to the new state
  void relax(const NodeArray& u);     // quasi-static: branches empty

  const std::vector<float>& memory() const;  // empty: no point
  bool fits(const std::vector<float>& state) const;
  void restore(const std::vector<float>& state);  // empty: as at rest

 private:
  using Mat83 = Eigen::Matrix<double, 8, 3>;
  struct Point {
    Mat83 B;  // grad N
    Mat3 M;
    double volume_mm3 = 0, rest_kPa = 0;
    const MaterialLaw* law = nullptr;
    double mu_kPa = 0;  // not 0: neo-Hookean
    int32_t law_index = 0;
    std::vector<ViscousPoint::Term> term;
    std::vector<double> a, h;  // of this step
    double G = 0;
  };
  struct Cell {
    std::array<int32_t, 8> node{};
    int32_t cell = 0, first = 0, last = 0;  // of the model; points
    int32_t state = 0;                      // first number of its state
    bool neo_hookean = false;               // all of its points are
    double scale = 1;
  };
  struct Shape {
    Mat3 S = Mat3::Zero();  // without pressure
    double s = 0;
    bool sound = false;  // a cell turned inside out has no such stress
  };
  static Mat83 gather(const Cell& c, const NodeArray& u);
  static Shape shape_stress(const Point& p, const Mat83& U);
  /// State of a point: S of the last step, its s, and H per term: 6 + 1 + 6 per term.
  static size_t state_size(const Point& p) { return 7 + 6 * p.term.size(); }

  static Mat3 remembered(const Point& p, const float* state);  // B above
  CellSums force(const Cell& cell, const NodeArray& u, CellForce& out) const;
  void hold(const Cell& cell, size_t index);
  void settle() const;  // the state of the last quasi-static step

  std::vector<LawPtr> laws_;
  std::vector<Point> points_;  // per stencil, in order
  std::vector<Cell> cells_;
  std::vector<int32_t> place_;  // per cell of the model: of cells_, or -1
  mutable std::vector<float> state_;
  std::vector<float> rest_;
  NodeArray relaxed_at_;
  mutable bool owed_ = false;  // state_ is to be that of tissue relaxed at relaxed_at_
  bool in_step_ = false;
  AlignedArray<ViscousGroup> groups_;      // for the kernel: per stencil its points by fours
  AlignedArray<ViscousCell> kernel_cell_;  // per cell
  AlignedArray<float> held_;               // of this step
  CellScatter scatter_;
  mutable std::vector<CellForce> force_;
  mutable std::vector<CellSums> sums_;
};

}  // namespace limberg::fem
