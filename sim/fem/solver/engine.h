#pragma once
// What the float arithmetic runs on: which instructions (kernels/kernels.h) and whose threads (sim/base/workers.h).
//
// Loops are cut into the same chunks and sums are added in the same order whatever the number of workers, so that
// results have the same bits. Small vectors stay on the calling thread: waking another costs more than they do.
#include <string>
#include <vector>

#include "sim/base/simd.h"
#include "sim/base/workers.h"
#include "sim/fem/kernels/kernels.h"

namespace limberg::fem {

/// The widest set that this machine has, or the one that the environment
/// names: LIMBERG_SIMD=plain|avx2|avx512. Chosen once. Throws InputError
/// for a name that is none of these, or a set that this machine has not.
const Kernels& default_kernels();
/// By name; nullptr when this machine, or this build, does not have it.
const Kernels* find_kernels(const std::string& name);
/// All that this machine has, the plain ones first.
std::vector<const Kernels*> available_kernels();

class Engine {
 public:
  explicit Engine(Workers& workers, const Kernels& kernels = default_kernels())
      : workers_(workers), kernels_(kernels) {}
  const Kernels& kernels() const { return kernels_; }
  Workers& workers() const { return workers_; }

  /// body(begin, end) over [0, n) in chunks of `grain`; all at once when there is one worker or one chunk.
  template <class Body>
  void run(size_t n, size_t grain, const Body& body) const {
    if (n <= grain || workers_.count() == 1)
      body(size_t(0), n);
    else
      workers_.parallel_for(n, grain, body);
  }

  double dot(const NodeArray& a, const NodeArray& b) const;
  /// y += s * x
  void add_scaled(NodeArray& y, double s, const NodeArray& x) const;
  /// y += s * x, returns z . y (of the new y)
  double add_scaled_dot(NodeArray& y, double s, const NodeArray& x, const NodeArray& z) const;
  /// out = a + s * b
  void combine(NodeArray& out, const NodeArray& a, double s, const NodeArray& b) const;
  /// out = a - b
  void subtract(NodeArray& out, const NodeArray& a, const NodeArray& b) const;
  /// y -= sum_j column_j s_j: columns of `count` scalar fields (each one float per node), s_j one Node4 each.
  void subtract_outer(NodeArray& y, const float* const* columns, const Node4* s, int count) const;
  /// Largest Euclidean norm of a node; not a number if any entry is.
  double max_node(const NodeArray& a) const;
  bool all_finite(const NodeArray& a) const;

 private:
  template <class Body>
  double sum_blocks(size_t nodes, const Body& body) const;

  Workers& workers_;
  const Kernels& kernels_;
  mutable std::vector<double> sums_;  // per block; one thread uses an engine
};

}  // namespace limberg::fem
