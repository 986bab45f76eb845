// Sparse rows times nodes: the loops of the multilevel cycle.
#include "sim/fem/kernels/parts.h"

namespace limberg::fem::LIMBERG_SET {
namespace {

/// Four rows of A x, in two sums.
inline v16 product(const GroupView& A, const Node4* x, size_t group) {
  const int32_t end = A.begin[group + 1];
  int32_t s = A.begin[group];
  const float* number = A.number + 4 * size_t(s);
  v16 a = {}, b = {};
  for (; s + 1 < end; s += 2, number += 8) {
    a += spread(number) * get(x + A.base[size_t(s)]);
    b += spread(number + 4) * get(x + A.base[size_t(s) + 1]);
  }
  if (s < end) a += spread(number) * get(x + A.base[size_t(s)]);
  return a + b;
}

inline v4 weighted(const int32_t* column, const float* weight, int32_t from, int32_t to, const Node4* in) {
  v4 a = {}, b = {};
  int32_t e = from;
  for (; e + 1 < to; e += 2) a += weight[e] * load(in[column[e]]), b += weight[e + 1] * load(in[column[e + 1]]);
  if (e < to) a += weight[e] * load(in[column[e]]);
  return a + b;
}

}  // namespace

void scale_nodes(const float* scale, const Node4* r, Node4* x, size_t first, size_t last) {
  for (size_t k = first; k < last; ++k) put(x + 4 * k, spread(scale + 4 * k) * get(r + 4 * k));
}

void residual(const GroupView& A, const Node4* r, const Node4* x, Node4* t, size_t first, size_t last) {
  for (size_t k = first; k < last; ++k) put(t + 4 * k, get(r + 4 * k) - product(A, x, k));
}

void relax(const GroupView& A, const float* scale, const Node4* r, const Node4* x, Node4* z, size_t first,
           size_t last) {
  for (size_t k = first; k < last; ++k)
    put(z + 4 * k, get(x + 4 * k) + spread(scale + 4 * k) * (get(r + 4 * k) - product(A, x, k)));
}

void weigh(const int32_t* begin, const int32_t* column, const float* weight, const Node4* in, Node4* out, size_t first,
           size_t last) {
  for (size_t i = first; i < last; ++i) store(out[i], weighted(column, weight, begin[i], begin[i + 1], in));
}

void weigh_add(const int32_t* begin, const int32_t* column, const float* weight, const Node4* in, Node4* out,
               size_t first, size_t last) {
  for (size_t i = first; i < last; ++i)
    store(out[i], load(out[i]) + weighted(column, weight, begin[i], begin[i + 1], in));
}

}  // namespace limberg::fem::LIMBERG_SET
