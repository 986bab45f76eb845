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
    const int32_t* rows = rows_.data() + p.rows_begin - p.columns;
    const int nc = p.columns, nr = p.rows;
    std::memcpy(static_cast<void*>(b), y + p.first, size_t(nc) * sizeof(Node4));
    for (int r0 = 0; r0 < nr; r0 += 16, M += nc) {
      v16 s0 = {}, s1 = {}, s2 = {};
      for (int j = 0; j < nc; ++j) {
        const v16 m = M[j];
        s0 += m * b[j].x, s1 += m * b[j].y, s2 += m * b[j].z;
      }
      alignas(64) v16 t[4];
      to_rows(s0, s1, s2, t);
      const v4* out = reinterpret_cast<const v4*>(t);
      const int end = std::min(16, nr - r0);
      int i = 0;
      for (; i < end && r0 + i < nc; ++i) store(y[p.first + r0 + i], out[(i & 3) * 4 + (i >> 2)]);
      for (; i < end; ++i) {
        Node4& target = y[rows[r0 + i]];
        store(target, load(target) + out[(i & 3) * 4 + (i >> 2)]);
      }
    }
  }
  v4* gathered = reinterpret_cast<v4*>(row_store.data());
  v16* x = reinterpret_cast<v16*>(x_store.data());
  for (size_t k = panels_.size(); k-- > 0;) {
    const Panel& p = panels_[k];
    const v16* M = reinterpret_cast<const v16*>(values_.data() + p.values);
    const int32_t* rows = rows_.data() + p.rows_begin - p.columns;
    const int nc = p.columns, nr = p.rows, nb = (nr + 15) / 16;
    for (int i = 0; i < nb * 16; ++i) {
      const v4 v = i < nc ? load(y[p.first + i]) : i < nr ? load(y[rows[i]]) : v4{};
      gathered[(i & ~15) + (i & 3) * 4 + ((i >> 2) & 3)] = v;
    }
    for (int i = 0; i < nb; ++i) from_rows(reinterpret_cast<const v16*>(gathered) + 4 * i, x[3 * i], x[3 * i + 1], x[3 * i + 2]);
    for (int j = 0; j < nc; ++j) {
      v16 s0 = {}, s1 = {}, s2 = {};
      for (int i = 0; i < nb; ++i) {
        const v16 m = M[i * nc + j];
        s0 += m * x[3 * i], s1 += m * x[3 * i + 1], s2 += m * x[3 * i + 2];
      }
      alignas(64) v16 t[4];
      to_rows(s0, s1, s2, t);
      const v16 sum = (t[0] + t[1]) + (t[2] + t[3]);
      alignas(64) v4 part[4];
      *reinterpret_cast<v16*>(part) = sum;
      store(y[p.first + j], (part[0] + part[1]) + (part[2] + part[3]));
    }
  }
}

}  // namespace limberg::fem
