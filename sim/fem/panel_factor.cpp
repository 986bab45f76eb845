#include "sim/fem/panel_factor.h"

#include <algorithm>

namespace limberg::fem {

PanelFactor::PanelFactor(const SupernodalView& L) : n_(L.n) {
  size_t total = 0, tails = 0;
  for (int32_t s = 0; s < L.supernodes; ++s) {
    const size_t nc = size_t(L.super[s + 1] - L.super[s]), nr = size_t(L.rows_begin[s + 1] - L.rows_begin[s]);
    total += (nr + 15) / 16 * 16 * nc;
    tails += nr - nc;
  }
  values_.resize(total);
  rows_.reserve(tails);
  panels_.reserve(size_t(L.supernodes));
  size_t at = 0;
  std::vector<double> M;
  for (int32_t s = 0; s < L.supernodes; ++s) {
    Panel p;
    p.first = L.super[s];
    p.columns = L.super[s + 1] - p.first;
    p.rows = L.rows_begin[s + 1] - L.rows_begin[s];
    p.rows_begin = int32_t(rows_.size());
    p.values = at;
    const int32_t* rows = L.rows + L.rows_begin[s];
    rows_.insert(rows_.end(), rows + p.columns, rows + p.rows);
    max_columns_ = std::max(max_columns_, p.columns), max_rows_ = std::max(max_rows_, p.rows);
    const size_t nc = size_t(p.columns), nr = size_t(p.rows);
    const double* l = L.values + L.values_begin[s];  // l(i, j) = l[i + j nr]

    // M is the solution of M D = [I ; -L21]: columns from the last to the first.
    M.assign(nr * nc, 0);
    for (size_t j = 0; j < nc; ++j) {
      M[j + j * nr] = 1;
      for (size_t i = nc; i < nr; ++i) M[i + j * nr] = -l[i + j * nr];
    }
    for (size_t j = nc; j-- > 0;) {
      double* mj = &M[j * nr];
      for (size_t k = j + 1; k < nc; ++k) {
        const double f = l[k + j * nr];
        if (f == 0) continue;
        const double* mk = &M[k * nr];
        for (size_t i = k; i < nr; ++i) mj[i] -= f * mk[i];
      }
      const double inv = 1 / l[j + j * nr];
      for (size_t i = j; i < nr; ++i) mj[i] *= inv;
    }
    for (size_t i = 0; i < nr; ++i)
      for (size_t j = 0; j < nc; ++j) values_[at + (i / 16 * nc + j) * 16 + i % 16] = float(M[i + j * nr]);
    at += (nr + 15) / 16 * 16 * nc;
    panels_.push_back(p);
  }
}

namespace {

/// Rows r0 .. r0+15 of M b to y: the supernode's own rows are assigned, the others added.
inline void scatter(v16 s0, v16 s1, v16 s2, Node4* y, int first, int nc, int nr, const int32_t* rows, int r0) {
  alignas(64) v16 t[4];
  to_rows(s0, s1, s2, t);
  const v4* out = reinterpret_cast<const v4*>(t);
  const int end = nr - r0 < 16 ? nr - r0 : 16;
  int i = 0;
  for (; i < end && r0 + i < nc; ++i) store(y[first + r0 + i], out[(i & 3) * 4 + (i >> 2)]);
  for (; i < end; ++i) {
    Node4& target = y[rows[r0 + i - nc]];
    store(target, load(target) + out[(i & 3) * 4 + (i >> 2)]);
  }
}

/// Sum over the 16 rows.
inline v4 total(v16 s0, v16 s1, v16 s2) {
  alignas(64) v16 t[4];
  to_rows(s0, s1, s2, t);
  alignas(64) v4 part[4];
  *reinterpret_cast<v16*>(part) = (t[0] + t[1]) + (t[2] + t[3]);
  return (part[0] + part[1]) + (part[2] + part[3]);
}

}  // namespace

// Several row blocks (forward) or columns (backward) at a time keep enough independent sums in flight.
void PanelFactor::solve(Node4* y) const {
  const size_t blocks = size_t(max_rows_ + 15) / 16;
  static thread_local NodeArray b_store, row_store;
  static thread_local AlignedArray<float> x_store;
  if (b_store.size() < size_t(max_columns_)) b_store.resize(size_t(max_columns_));
  if (row_store.size() < 16 * blocks) row_store.resize(16 * blocks);
  if (x_store.size() < 48 * blocks) x_store.resize(48 * blocks);

  Node4* b = b_store.data();
  for (const Panel& p : panels_) {
    const v16* M = reinterpret_cast<const v16*>(values_.data() + p.values);
    const int32_t* rows = rows_.data() + p.rows_begin;
    const int nc = p.columns, nr = p.rows;
    std::memcpy(static_cast<void*>(b), y + p.first, size_t(nc) * sizeof(Node4));
    int r0 = 0;
    for (; r0 + 32 < nr; r0 += 48, M += 3 * nc) {
      v16 s0 = {}, s1 = {}, s2 = {}, t0 = {}, t1 = {}, t2 = {}, u0 = {}, u1 = {}, u2 = {};
      for (int j = 0; j < nc; ++j) {
        const v16 m = M[j], n = M[nc + j], o = M[2 * nc + j];
        const float x = b[j].x, yy = b[j].y, z = b[j].z;
        s0 += m * x, s1 += m * yy, s2 += m * z;
        t0 += n * x, t1 += n * yy, t2 += n * z;
        u0 += o * x, u1 += o * yy, u2 += o * z;
      }
      scatter(s0, s1, s2, y, p.first, nc, nr, rows, r0);
      scatter(t0, t1, t2, y, p.first, nc, nr, rows, r0 + 16);
      scatter(u0, u1, u2, y, p.first, nc, nr, rows, r0 + 32);
    }
    for (; r0 < nr; r0 += 16, M += nc) {
      v16 s0 = {}, s1 = {}, s2 = {}, t0 = {}, t1 = {}, t2 = {};
      int j = 0;
      for (; j + 1 < nc; j += 2) {
        const v16 m = M[j], n = M[j + 1];
        s0 += m * b[j].x, s1 += m * b[j].y, s2 += m * b[j].z;
        t0 += n * b[j + 1].x, t1 += n * b[j + 1].y, t2 += n * b[j + 1].z;
      }
      if (j < nc) s0 += M[j] * b[j].x, s1 += M[j] * b[j].y, s2 += M[j] * b[j].z;
      scatter(s0 + t0, s1 + t1, s2 + t2, y, p.first, nc, nr, rows, r0);
    }
  }
  v4* gathered = reinterpret_cast<v4*>(row_store.data());
  v16* x = reinterpret_cast<v16*>(x_store.data());
  for (size_t k = panels_.size(); k-- > 0;) {
    const Panel& p = panels_[k];
    const v16* M = reinterpret_cast<const v16*>(values_.data() + p.values);
    const int32_t* rows = rows_.data() + p.rows_begin;
    const int nc = p.columns, nr = p.rows, nb = (nr + 15) / 16;
    const auto slot = [](int i) { return (i & ~15) + (i & 3) * 4 + ((i >> 2) & 3); };
    for (int i = 0; i < nc; ++i) gathered[slot(i)] = load(y[p.first + i]);
    for (int i = nc; i < nr; ++i) gathered[slot(i)] = load(y[rows[i - nc]]);
    for (int i = nr; i < nb * 16; ++i) gathered[slot(i)] = v4{};
    for (int i = 0; i < nb; ++i) from_rows(reinterpret_cast<const v16*>(gathered) + 4 * i, x[3 * i], x[3 * i + 1], x[3 * i + 2]);
    int j = 0;
    for (; j + 3 < nc; j += 4) {
      v16 a0 = {}, a1 = {}, a2 = {}, b0 = {}, b1 = {}, b2 = {}, c0 = {}, c1 = {}, c2 = {}, d0 = {}, d1 = {}, d2 = {};
      for (int i = 0; i < nb; ++i) {
        const v16* m = M + i * nc + j;
        const v16 x0 = x[3 * i], x1 = x[3 * i + 1], x2 = x[3 * i + 2];
        a0 += m[0] * x0, a1 += m[0] * x1, a2 += m[0] * x2;
        b0 += m[1] * x0, b1 += m[1] * x1, b2 += m[1] * x2;
        c0 += m[2] * x0, c1 += m[2] * x1, c2 += m[2] * x2;
        d0 += m[3] * x0, d1 += m[3] * x1, d2 += m[3] * x2;
      }
      store(y[p.first + j], total(a0, a1, a2)), store(y[p.first + j + 1], total(b0, b1, b2));
      store(y[p.first + j + 2], total(c0, c1, c2)), store(y[p.first + j + 3], total(d0, d1, d2));
    }
    for (; j < nc; ++j) {
      v16 s0 = {}, s1 = {}, s2 = {};
      for (int i = 0; i < nb; ++i) {
        const v16 m = M[i * nc + j];
        s0 += m * x[3 * i], s1 += m * x[3 * i + 1], s2 += m * x[3 * i + 2];
      }
      store(y[p.first + j], total(s0, s1, s2));
    }
  }
}

}  // namespace limberg::fem
