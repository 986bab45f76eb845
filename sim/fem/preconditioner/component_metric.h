#pragma once
// The minimiser's metric where nodes are held along some axes only.
//
// Preconditioner (preconditioner.h) is one scalar operator for x, y and z, over the nodes that move. A node that slides
// moves in x and not in z, say, so the operators of the components differ: each is that of a scalar model of its own,
// the same model with the nodes held that are held along this axis. Components for which the same nodes are held share
// one. So z = M^-1 r has no part along a held axis, and every component converges as it does with whole nodes held.
// (One operator that takes sliding nodes for free ones, with its answer projected, has the wrong boundary: a block on
// rollers, which comes to rest in 36 iterations, was not there after 2000, 2026-11-25.)
//
// As long as no node slides there is one Preconditioner, which is given the model itself: same bits, same cost. With
// two or three the step costs so many applications, and their factors so much memory.
#include <array>
#include <memory>
#include <vector>

#include "sim/fem/preconditioner/preconditioner.h"

namespace limberg::fem {

class ComponentMetric {
 public:
  explicit ComponentMetric(Workers& workers, MetricPolicy policy = {}) : workers_(workers), policy_(policy) {}

  /// All of these as in Preconditioner; rows of springs leave out nodes that are held whole, and may name others.
  void set_model(std::shared_ptr<const FemModel> model, const ParentList& cell_parent);
  void set_springs(const std::vector<Preconditioner::SpringEntry>& springs);
  void begin_step(double mass_per_s2, int adopt_after, bool when_ready,
                  const std::function<bool(bool)>& adopt_now = {});
  void make_ready(double mass_per_s2);
  /// r must be zero along held axes; so will z be.
  void apply(const NodeArray& r, NodeArray& z);

  using Past = std::vector<std::shared_ptr<const MetricPast>>;  // one for each operator
  Past past() const;
  void take_up(const Past& past);

  bool pending() const;   // any
  bool on_cycle() const;  // any
  std::string describe() const;
  /// Of the x component.
  const Preconditioner& first() const { return *parts_.front().metric; }
  size_t operators() const { return parts_.size(); }

 private:
  struct Part {
    unsigned axes = 0;                      // bits: the components that it serves
    std::shared_ptr<const FemModel> model;  // every node held whole or not at all
    std::unique_ptr<Preconditioner> metric;
  };
  Workers& workers_;
  MetricPolicy policy_;
  std::vector<Part> parts_;
  NodeArray r_, z_;  // of one part; empty while there is one
};

}  // namespace limberg::fem
