#pragma once
// Sorting by signs of predicates.
#include <algorithm>

namespace limberg {

/// Sorts by `before`. A test may make a predicate fail, so that the signs contradict each other: then the order is any,
/// but all stays within bounds (std::sort reads beyond the ends of its range if a comparison changes its mind).
template <class It, class Before>
void sort_by_signs(It first, It last, Before&& before) {
  for (It i = first; i != last; ++i) std::rotate(std::upper_bound(first, i, *i, before), i, i + 1);
}

}  // namespace limberg
