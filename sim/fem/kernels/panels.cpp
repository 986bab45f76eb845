// Triangular solves by panels, three right-hand sides at once (panel_factor.h).
#include "sim/fem/kernels/parts.h"

namespace limberg::fem::LIMBERG_SET {
namespace {

/// Rows r0 .. r0+15 of M b: the supernode's own are assigned to
/// y, the others added there or, outside, put down in the log.
inline void scatter(v16 s0, v16 s1, v16 s2, Node4* y, const Panel& p, const int32_t* rows, int r0, Node4* log) {
  alignas(64) v16 t[4];
  to_rows(s0, s1, s2, t);
  const v4* out = reinterpret_cast<const v4*>(t);
  const int nc = p.columns, nr = p.rows;
  const int end = nr - r0 < 16 ? nr - r0 : 16;
  const int inside = p.inside - r0 < end ? p.inside - r0 : end;
  int i = 0;
  for (; i < end && r0 + i < nc; ++i) store(y[p.first + r0 + i], out[(i & 3) * 4 + (i >> 2)]);
  for (; i < inside; ++i) {
    Node4& target = y[rows[r0 + i - nc]];
    store(target, load(target) + out[(i & 3) * 4 + (i >> 2)]);
  }
  for (; i < end; ++i) store(log[r0 + i - p.inside], out[(i & 3) * 4 + (i >> 2)]);
}

/// Sum over the 16 rows.
inline v4 total(v16 s0, v16 s1, v16 s2) {
  alignas(64) v16 t[4];
  to_rows(s0, s1, s2, t);
  alignas(64) v4 part4[4];
  *reinterpret_cast<v16*>(part4) = (t[0] + t[1]) + (t[2] + t[3]);
  return (part4[0] + part4[1]) + (part4[2] + part4[3]);
}

/// Numbers that are soon wanted. Panels are short and lie in an order that no prefetcher guesses: without this half of
/// the time is spent waiting for them once the factor has left the second cache.
[[maybe_unused]] LIMBERG_INLINE void ask_for(const v16* p) { __builtin_prefetch(p, 0, 3); }
[[maybe_unused]] constexpr int ahead = 32;  // vectors

inline int slot(int i) { return (i & ~15) + (i & 3) * 4 + ((i >> 2) & 3); }

}  // namespace

// A sum is taken in the order of the columns (forward) or row blocks (backward), whatever the registers. Several row
// blocks or columns at a time keep enough sums in flight: nine and twelve of 64 bytes with AVX-512, three elsewhere.
void panels_forward(const PanelView& f, size_t first, size_t last, Node4* y, Node4* log, const PanelScratch& scratch) {
  Node4* b = scratch.columns;
  for (size_t k = first; k < last; ++k) {
    const Panel& p = f.panels[k];
    const v16* M = reinterpret_cast<const v16*>(f.values + p.values);
    const int32_t* rows = f.rows + p.rows_begin;
    const int nc = p.columns, nr = p.rows;
    for (int j = 0; j < nc; ++j) b[j] = y[p.first + j];
    int r0 = 0;
#if LIMBERG_LANES == 512
    for (; r0 + 32 < nr; r0 += 48, M += 3 * nc) {
      v16 s0 = {}, s1 = {}, s2 = {}, t0 = {}, t1 = {}, t2 = {}, u0 = {}, u1 = {}, u2 = {};
      for (int j = 0; j < nc; ++j) {
        const v16 m = M[j], n = M[nc + j], o = M[2 * nc + j];
        ask_for(M + 3 * nc + j), ask_for(M + 4 * nc + j), ask_for(M + 5 * nc + j);
        const float x = b[j].x, yy = b[j].y, z = b[j].z;
        s0 += m * x, s1 += m * yy, s2 += m * z;
        t0 += n * x, t1 += n * yy, t2 += n * z;
        u0 += o * x, u1 += o * yy, u2 += o * z;
      }
      scatter(s0, s1, s2, y, p, rows, r0, log);
      scatter(t0, t1, t2, y, p, rows, r0 + 16, log);
      scatter(u0, u1, u2, y, p, rows, r0 + 32, log);
    }
#endif
    for (; r0 < nr; r0 += 16, M += nc) {
      v16 s0 = {}, s1 = {}, s2 = {};
      for (int j = 0; j < nc; ++j) {
        const v16 m = M[j];
#if LIMBERG_LANES == 512
        ask_for(M + nc + j + ahead);
#endif
        s0 += m * b[j].x, s1 += m * b[j].y, s2 += m * b[j].z;
      }
      scatter(s0, s1, s2, y, p, rows, r0, log);
    }
    log += nr - p.inside;
  }
}

void panels_backward(const PanelView& f, size_t first, size_t last, Node4* y, const PanelScratch& scratch) {
  v4* gathered = reinterpret_cast<v4*>(scratch.rows);
  v16* x = reinterpret_cast<v16*>(scratch.x);
  for (size_t k = last; k-- > first;) {
    const Panel& p = f.panels[k];
    const v16* M = reinterpret_cast<const v16*>(f.values + p.values);
    const int32_t* rows = f.rows + p.rows_begin;
    const int nc = p.columns, nr = p.rows, nb = (nr + 15) / 16;
    for (int i = 0; i < nc; ++i) gathered[slot(i)] = load(y[p.first + i]);
    for (int i = nc; i < nr; ++i) gathered[slot(i)] = load(y[rows[i - nc]]);
    for (int i = nr; i < nb * 16; ++i) gathered[slot(i)] = v4{};
    for (int i = 0; i < nb; ++i)
      from_rows(reinterpret_cast<const v16*>(gathered) + 4 * i, x[3 * i], x[3 * i + 1], x[3 * i + 2]);
    int j = 0;
#if LIMBERG_LANES == 512
    const v16* next = reinterpret_cast<const v16*>(f.values + (k > first ? f.panels[k - 1].values : p.values));
    for (; j + 3 < nc; j += 4) {
      v16 a0 = {}, a1 = {}, a2 = {}, b0 = {}, b1 = {}, b2 = {}, c0 = {}, c1 = {}, c2 = {}, d0 = {}, d1 = {}, d2 = {};
      for (int i = 0; i < nb; ++i) {
        const v16* m = M + i * nc + j;
        const v16 x0 = x[3 * i], x1 = x[3 * i + 1], x2 = x[3 * i + 2];
        ask_for(next), ask_for(next + 1), ask_for(next + 2), ask_for(next + 3);
        next += 4;
        a0 += m[0] * x0, a1 += m[0] * x1, a2 += m[0] * x2;
        b0 += m[1] * x0, b1 += m[1] * x1, b2 += m[1] * x2;
        c0 += m[2] * x0, c1 += m[2] * x1, c2 += m[2] * x2;
        d0 += m[3] * x0, d1 += m[3] * x1, d2 += m[3] * x2;
      }
      store(y[p.first + j], total(a0, a1, a2)), store(y[p.first + j + 1], total(b0, b1, b2));
      store(y[p.first + j + 2], total(c0, c1, c2)), store(y[p.first + j + 3], total(d0, d1, d2));
    }
#endif
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

}  // namespace limberg::fem::LIMBERG_SET
