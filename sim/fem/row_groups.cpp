#include "sim/fem/row_groups.h"

namespace limberg::fem {

RowGroups group_rows(int32_t rows, const int32_t* begin, const int32_t* column, const float* value) {
  RowGroups g;
  g.rows = rows;
  const size_t groups = size_t(rows + 3) / 4;
  g.begin.resize(groups + 1);
  std::vector<float> number;
  number.reserve(size_t(begin[rows]) + size_t(begin[rows]) / 4);
  g.base.reserve(size_t(begin[rows]) / 3);
  for (size_t k = 0; k < groups; ++k) {
    const int32_t r0 = int32_t(4 * k), count = rows - r0 < 4 ? rows - r0 : 4;
    int32_t at[4], end[4];
    for (int32_t i = 0; i < 4; ++i) at[i] = begin[i < count ? r0 + i : rows], end[i] = i < count ? begin[r0 + i + 1] : at[i];
    for (;;) {  // the next diagonal of any of the rows
      int32_t base = INT32_MAX;
      for (int32_t i = 0; i < count; ++i)
        if (at[i] < end[i] && column[at[i]] - i < base) base = column[at[i]] - i;
      if (base == INT32_MAX) break;
      g.base.push_back(base);
      for (int32_t i = 0; i < 4; ++i) number.push_back(i < count && at[i] < end[i] && column[at[i]] - i == base ? value[at[i]++] : 0.0f);
    }
    g.begin[k + 1] = int32_t(g.base.size());
  }
  g.number.resize(number.size());
  if (!number.empty()) std::memcpy(g.number.data(), number.data(), number.size() * sizeof(float));
  return g;
}

namespace {

#ifdef __AVX512F__

inline v16 spread(const float* four) {
  const v16i lanes = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
  return __builtin_shuffle((v16)_mm512_castps128_ps512(_mm_loadu_ps(four)), lanes);
}
inline v16 get(const Node4* p) { return (v16)_mm512_loadu_ps(p); }
inline void put(Node4* p, v16 v) { _mm512_storeu_ps(p, (__m512)v); }

/// Four rows of A x.
inline v16 product(const RowGroups& A, const Node4* x, size_t group) {
  const int32_t end = A.begin[group + 1];
  int32_t s = A.begin[group];
  const float* number = A.number.data() + 4 * size_t(s);
  v16 a = {}, b = {}, c = {}, d = {};
  for (; s + 3 < end; s += 4, number += 16) {
    a += spread(number) * get(x + A.base[size_t(s)]);
    b += spread(number + 4) * get(x + A.base[size_t(s) + 1]);
    c += spread(number + 8) * get(x + A.base[size_t(s) + 2]);
    d += spread(number + 12) * get(x + A.base[size_t(s) + 3]);
  }
  for (; s < end; ++s, number += 4) a += spread(number) * get(x + A.base[size_t(s)]);
  return (a + b) + (c + d);
}

#endif

}  // namespace

#ifdef __AVX512F__

void scale_nodes(const float* scale, const Node4* r, Node4* x, size_t first, size_t last) {
  for (size_t k = first; k < last; ++k) put(x + 4 * k, spread(scale + 4 * k) * get(r + 4 * k));
}

void residual(const RowGroups& A, const Node4* r, const Node4* x, Node4* t, size_t first, size_t last) {
  for (size_t k = first; k < last; ++k) put(t + 4 * k, get(r + 4 * k) - product(A, x, k));
}

void relax(const RowGroups& A, const float* scale, const Node4* r, const Node4* x, Node4* z, size_t first, size_t last) {
  for (size_t k = first; k < last; ++k)
    put(z + 4 * k, get(x + 4 * k) + spread(scale + 4 * k) * (get(r + 4 * k) - product(A, x, k)));
}

#else

namespace {

struct Rows4 {
  v4 row[4];
};
inline Rows4 product(const RowGroups& A, const Node4* x, size_t group) {
  Rows4 p = {};
  for (int32_t s = A.begin[group]; s < A.begin[group + 1]; ++s) {
    const float* number = A.number.data() + 4 * size_t(s);
    const Node4* from = x + A.base[size_t(s)];
    for (int i = 0; i < 4; ++i) p.row[i] += number[i] * load(from[i]);
  }
  return p;
}

}  // namespace

void scale_nodes(const float* scale, const Node4* r, Node4* x, size_t first, size_t last) {
  for (size_t i = 4 * first; i < 4 * last; ++i) store(x[i], scale[i] * load(r[i]));
}

void residual(const RowGroups& A, const Node4* r, const Node4* x, Node4* t, size_t first, size_t last) {
  for (size_t k = first; k < last; ++k) {
    const Rows4 p = product(A, x, k);
    for (size_t i = 0; i < 4; ++i) store(t[4 * k + i], load(r[4 * k + i]) - p.row[i]);
  }
}

void relax(const RowGroups& A, const float* scale, const Node4* r, const Node4* x, Node4* z, size_t first, size_t last) {
  for (size_t k = first; k < last; ++k) {
    const Rows4 p = product(A, x, k);
    for (size_t i = 0; i < 4; ++i)
      store(z[4 * k + i], load(x[4 * k + i]) + scale[4 * k + i] * (load(r[4 * k + i]) - p.row[i]));
  }
}

#endif

namespace {

inline v4 weighted(const int32_t* column, const float* weight, int32_t from, int32_t to, const Node4* in) {
  v4 a = {}, b = {};
  int32_t e = from;
  for (; e + 1 < to; e += 2) a += weight[e] * load(in[column[e]]), b += weight[e + 1] * load(in[column[e + 1]]);
  if (e < to) a += weight[e] * load(in[column[e]]);
  return a + b;
}

}  // namespace

void weigh(const int32_t* begin, const int32_t* column, const float* weight, const Node4* in, Node4* out, size_t first, size_t last) {
  for (size_t i = first; i < last; ++i) store(out[i], weighted(column, weight, begin[i], begin[i + 1], in));
}

void weigh_add(const int32_t* begin, const int32_t* column, const float* weight, const Node4* in, Node4* out, size_t first, size_t last) {
  for (size_t i = first; i < last; ++i) store(out[i], load(out[i]) + weighted(column, weight, begin[i], begin[i + 1], in));
}

}  // namespace limberg::fem
