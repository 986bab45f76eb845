#pragma once
// Weight and loads: forces of given size and direction, whatever the tissue does.
//
//   f_i = m_i g + sum over loads of w_i f        mN = kg mm / s^2;  w_i: the mean of the load's places, as of a spring
//   E   = - sum_i f_i . u_i                      zero at rest;  dE/du_i = - f_i
//
// Masses are the lumped ones of the model; those of hanging nodes go to their masters with everything else. The list
// of forces is made once for a model, its springs and its loads.
//
// A piece that nothing holds along an axis has no place of rest under a force along it. So a quasi-static step leaves
// out, of each piece (cells that share nodes, springs that tie two of them), the components along axes in which neither
// a held node nor a hook holds it. A dynamic step takes all of it: such a piece falls.
#include <span>

#include "sim/base/simd.h"
#include "sim/fem/model/fem_model.h"

namespace limberg::fem {

class DeadLoads {
 public:
  DeadLoads() = default;  // none
  DeadLoads(const FemModel& model, const Vec3& gravity_m_s2, std::span<const DeadLoad> loads,
            std::span<const Spring> springs);

  bool empty() const { return all_.empty(); }
  /// Of the steps to come.
  void dynamic(bool on) { dynamic_ = on; }
  /// Adds the gradient (held nodes included); returns the energy and, in `magnitude`, the sum of the sizes of its
  /// terms. `measure`: also adds the norm of each force to w.
  double add(const NodeArray& u, NodeArray& g, bool measure, double& magnitude) const;
  Vec3 sum_mN() const;

 private:
  const NodeArray& acting() const { return dynamic_ || held_.empty() ? all_ : held_; }
  NodeArray all_;   // mN per node; empty: no weight and no load
  NodeArray held_;  // without what nothing holds; empty: the same
  bool dynamic_ = false;
};

}  // namespace limberg::fem
