// Dense blocks of a supernodal Cholesky factor, in double (preconditioner/supernodal.h). A number's sum runs over the
// columns one after the other; registers only hold several rows of it side by side.
#include "sim/fem/kernels/parts.h"

namespace limberg::fem::LIMBERG_SET {
namespace {

typedef double lane __attribute__((vector_size(LIMBERG_LANES / 8)));
typedef lane loose_lane __attribute__((aligned(8)));
constexpr int lanes = LIMBERG_LANES / 64;
constexpr int rows_at_once = 2 * lanes;  // divides leading_step

LIMBERG_INLINE lane get(const double* p) { return *reinterpret_cast<const loose_lane*>(p); }
LIMBERG_INLINE void put(double* p, lane v) { *reinterpret_cast<loose_lane*>(p) = v; }

/// What becomes of the sums of a block of rows and columns.
enum class To { assign, subtract };

template <To to>
LIMBERG_INLINE void give(double* c, lane s) {
  put(c, to == To::assign ? s : get(c) - s);
}

/// Rows [0, rows_at_once) of four columns (or one) of C: += or -= sum over k of A(i, k) B(j, k).
template <To to>
LIMBERG_INLINE void four_columns(const double* A, size_t lda, const double* B, size_t ldb, int depth, double* C,
                                 size_t ldc) {
  lane a0 = {}, a1 = {}, b0 = {}, b1 = {}, c0 = {}, c1 = {}, d0 = {}, d1 = {};
  for (int k = 0; k < depth; ++k, A += lda, B += ldb) {
    const lane x = get(A), y = get(A + lanes);
    a0 += x * B[0], a1 += y * B[0], b0 += x * B[1], b1 += y * B[1];
    c0 += x * B[2], c1 += y * B[2], d0 += x * B[3], d1 += y * B[3];
  }
  give<to>(C, a0), give<to>(C + lanes, a1), give<to>(C + ldc, b0), give<to>(C + ldc + lanes, b1);
  give<to>(C + 2 * ldc, c0), give<to>(C + 2 * ldc + lanes, c1), give<to>(C + 3 * ldc, d0);
  give<to>(C + 3 * ldc + lanes, d1);
}
template <To to>
LIMBERG_INLINE void one_column(const double* A, size_t lda, const double* B, size_t ldb, int depth, double* C) {
  lane a0 = {}, a1 = {};
  for (int k = 0; k < depth; ++k, A += lda, B += ldb) a0 += get(A) * B[0], a1 += get(A + lanes) * B[0];
  give<to>(C, a0), give<to>(C + lanes, a1);
}

template <To to>
void columns(const double* A, size_t lda, const double* B, size_t ldb, int rows, int count, int depth, double* C,
             size_t ldc) {
  if (count == 4)
    for (int i = 0; i < rows; i += rows_at_once) four_columns<to>(A + i, lda, B, ldb, depth, C + i, ldc);
  else
    for (int j = 0; j < count; ++j)
      for (int i = 0; i < rows; i += rows_at_once)
        one_column<to>(A + i, lda, B + j, ldb, depth, C + size_t(j) * ldc + i);
}

}  // namespace

void multiply_transposed(const double* A, size_t leading, int rows, int count, int depth, double* C, size_t ldc) {
  for (int j = 0; j < count; j += 4) {
    const int above = j / rows_at_once * rows_at_once;  // rows above the diagonal are nobody's
    columns<To::assign>(A + above, leading, A + j, leading, rows - above, count - j < 4 ? count - j : 4, depth,
                        C + size_t(j) * ldc + above, ldc);
  }
}

bool factor_panel(double* L, size_t leading, int rows, int count) {
  for (int j = 0; j < count; j += 4) {
    const int n = count - j < 4 ? count - j : 4, above = j / rows_at_once * rows_at_once;
    double* here = L + size_t(j) * leading;
    columns<To::subtract>(L + above, leading, L + j, leading, rows - above, n, j, here + above, leading);
    // The diagonal block.
    double d[4][4], inverse[4];
    for (int c = 0; c < n; ++c)
      for (int r = c; r < n; ++r) d[c][r] = here[size_t(c) * leading + size_t(j + r)];
    for (int c = 0; c < n; ++c) {
      for (int k = 0; k < c; ++k)
        for (int r = c; r < n; ++r) d[c][r] -= d[k][r] * d[k][c];
      if (!(d[c][c] > 0)) return false;
      d[c][c] = __builtin_sqrt(d[c][c]);
      inverse[c] = 1 / d[c][c];
      for (int r = c + 1; r < n; ++r) d[c][r] *= inverse[c];
    }
    // Rows below it, and with them whatever shares their registers.
    for (int i = above; i < rows; i += lanes) {
      lane x[4];
      for (int c = 0; c < n; ++c) {
        double* at = here + size_t(c) * leading + size_t(i);
        x[c] = get(at);
        for (int k = 0; k < c; ++k) x[c] -= x[k] * d[k][c];
        x[c] = x[c] * inverse[c];
        put(at, x[c]);
      }
    }
    for (int c = 0; c < n; ++c)
      for (int r = c; r < n; ++r) here[size_t(c) * leading + size_t(j + r)] = d[c][r];
  }
  return true;
}

}  // namespace limberg::fem::LIMBERG_SET
