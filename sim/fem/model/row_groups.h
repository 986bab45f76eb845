#pragma once
// A sparse matrix for products with nodes (three right-hand sides and a lane of zeros), four rows at a time.
//
// Four rows that follow each other are stored by diagonals: a slot has the first of four
// consecutive nodes and four numbers, so its product is one load of 64 bytes times one spread
// of four numbers. On a lattice the diagonals of neighbouring rows coincide; where a cut has
// doubled nodes they do not, and the group just has more slots, filled up with zeros.
//
// Vectors that are multiplied have four nodes of room on either side (slots may begin before 0): PaddedNodes.
#include <vector>

#include "sim/base/simd.h"
#include "sim/fem/kernels/kernels.h"

namespace limberg::fem {

struct RowGroups {
  int32_t rows = 0;
  std::vector<int32_t> begin{0};  // per group, in slots
  std::vector<int32_t> base;      // per slot: node of its first row, from -3
  AlignedArray<float> number;     // 4 per slot
  GroupView view() const { return {begin.data(), base.data(), number.data()}; }
  size_t bytes() const { return 4 * (begin.size() + base.size() + number.size()); }
};
/// `begin`, `column`, `value`: rows + 1, and the entries, columns ascending.
RowGroups group_rows(int32_t rows, const int32_t* begin, const int32_t* column, const float* value);

/// Zero on both sides of what is used.
class PaddedNodes {
 public:
  void resize(size_t n) { store_.resize(n + 8); }
  Node4* data() { return store_.data() + 4; }
  const Node4* data() const { return store_.data() + 4; }

 private:
  NodeArray store_;
};

}  // namespace limberg::fem
