#pragma once
// The few vector operations of the minimiser, over arrays of 16-byte nodes. Sums run in float over short blocks and in
// double over blocks, always in the same order.
#include "sim/fem/simd.h"

namespace limberg::fem {

double dot(const NodeArray& a, const NodeArray& b);
/// y += s * x
void add_scaled(NodeArray& y, double s, const NodeArray& x);
/// y += s * x, returns z . y (of the new y)
double add_scaled_dot(NodeArray& y, double s, const NodeArray& x, const NodeArray& z);
/// out = a + s * b
void combine(NodeArray& out, const NodeArray& a, double s, const NodeArray& b);
/// out = a - b
void subtract(NodeArray& out, const NodeArray& a, const NodeArray& b);
/// y -= sum_j column_j s_j: columns of `count` scalar fields (each one float per node), s_j one Node4 each.
void subtract_outer(NodeArray& y, const float* const* columns, const Node4* s, int count);
/// Largest Euclidean norm of a node; not a number if any entry is.
double max_node(const NodeArray& a);
bool all_finite(const NodeArray& a);

}  // namespace limberg::fem
