#pragma once
// What an end of a spring holds: the mean of its places, as weights of nodes.
#include <span>

#include "sim/fem/model/fem_model.h"

namespace limberg::fem {

/// Calls visit(node, weight) for the nodes of every place; a node that carries two places comes twice. The weights sum
/// to 1 in double precision (those of a place, in single precision, only nearly do).
template <class Visit>
void for_each_weight(std::span<const HeldPlace> end, Visit&& visit) {
  double all = 0;
  for (const HeldPlace& p : end) all += p.share;
  for (const HeldPlace& p : end) {
    double sum = 0;
    for (float x : p.w) sum += double(x);
    for (size_t i = 0; i < 8; ++i)
      if (p.w[i] != 0) visit(p.node[i], p.share * double(p.w[i]) / (sum * all));
  }
}

}  // namespace limberg::fem
