// Layers that relax, where their law is neo-Hookean (viscous_points.h): four points of a cell at a time, in double.
//
// Of such a layer the step's energy is half a constant tensor times the change of C, and the pressure taken off again:
//
//   V [ 1/2 H : (grad^T grad - I) - g L(J) ],   H = M (G mu I + B) M^T,  g = G s,  grad = I + sum u_a grad N_a^T
//
// so a point needs no law, no axes and no prestretch while the step lasts: seven numbers that the step's begin leaves.
#include "sim/fem/kernels/parts.h"

namespace limberg::fem::LIMBERG_SET {
namespace {

typedef double v4d __attribute__((vector_size(32)));
typedef int64_t v4l __attribute__((vector_size(32)));

constexpr double least_J = 0.2;  // as in viscous_points.cpp
constexpr double log_least_J = -1.6094379124341003;

LIMBERG_INLINE v4d all(double x) { return v4d{x, x, x, x}; }
LIMBERG_INLINE v4d widen(const float* p) { return __builtin_convertvector(*reinterpret_cast<const v4*>(p), v4d); }

/// ln x of normal positive numbers: x = 2^e m, m in [sqrt 1/2, sqrt 2), ln m = 2 artanh r, r = (m - 1) / (m + 1).
LIMBERG_INLINE v4d logarithm(v4d x) {
  const v4l bits = (v4l)x;
  v4l e = (bits >> 52) - 1023;
  v4d m = (v4d)((bits & 0x000fffffffffffffL) | 0x3ff0000000000000L);
  const v4l large = m > all(1.4142135623730951);
  m = large ? 0.5 * m : m, e -= large;
  const v4d exponent = (v4d)(e + 0x4338000000000000L) - 6755399441055744.0;  // both hold e in their low bits
  const v4d r = (m - 1) / (m + 1), q = r * r;  // q < 0.03: the eleventh term is below 1e-17
  v4d p = all(1.0 / 21);
  p = p * q + 1.0 / 19, p = p * q + 1.0 / 17, p = p * q + 1.0 / 15, p = p * q + 1.0 / 13, p = p * q + 1.0 / 11;
  p = p * q + 1.0 / 9, p = p * q + 1.0 / 7, p = p * q + 1.0 / 5, p = p * q + 1.0 / 3, p = p * q + 1.0;
  return exponent * 0.6931471805599453 + 2 * r * p;
}

/// L and L' at J: ln J, a parabola below least_J, a straight line where the pressure is negative.
LIMBERG_INLINE void log_volume(v4d J, v4d g, v4d& L, v4d& slope) {
  const v4l low = J < all(least_J), line = g < all(0);
  const v4d at = low ? all(least_J) : J, x = (J - least_J) * (1 / least_J);
  L = logarithm(at), slope = 1 / at;
  L = low ? log_least_J + x - 0.5 * x * x : L;
  slope = low ? (1 - x) * (1 / least_J) : slope;
  L = line ? J - 1 : L;
  slope = line ? all(1) : slope;
}

LIMBERG_INLINE v4d size(v4d x) { return x < all(0) ? -x : x; }
LIMBERG_INLINE double lanes(v4d x) { return (x[0] + x[1]) + (x[2] + x[3]); }

/// Sums over the lanes of three vectors, as a node.
LIMBERG_INLINE v4d totals(v4d x, v4d y, v4d z) {
  const v4d o = {};
  const v4d a = __builtin_shufflevector(x, y, 0, 4, 2, 6) + __builtin_shufflevector(x, y, 1, 5, 3, 7);
  const v4d b = __builtin_shufflevector(z, o, 0, 4, 2, 6) + __builtin_shufflevector(z, o, 1, 5, 3, 7);
  return __builtin_shufflevector(a, b, 0, 1, 4, 5) + __builtin_shufflevector(a, b, 2, 3, 6, 7);
}

}  // namespace

void viscous_cells(const ViscousView& d, const Node4* u, size_t first, size_t last, CellSums* sums, float* force) {
  for (size_t c = first; c < last; ++c) {
    const ViscousCell& cell = d.cells[c];
    alignas(32) double n[8][4];
    for (int a = 0; a < 8; ++a) *reinterpret_cast<v4d*>(n[a]) = __builtin_convertvector(load(u[cell.node[a]]), v4d);
    v4d f[24] = {};
    v4d energy = {}, magnitude = {};
    for (int k = 0; k < cell.groups; ++k) {
      const ViscousGroup& group = d.groups[cell.group + k];
      const v4d* B = reinterpret_cast<const v4d*>(group.B);
      const v4d V = *reinterpret_cast<const v4d*>(group.volume);
      v4d D[9] = {};  // 3 i + j
      for (int a = 0; a < 8; ++a) {
        const v4d b0 = B[3 * a], b1 = B[3 * a + 1], b2 = B[3 * a + 2];
        for (int i = 0; i < 3; ++i)
          D[3 * i] += n[a][i] * b0, D[3 * i + 1] += n[a][i] * b1, D[3 * i + 2] += n[a][i] * b2;
      }
      const float* held = d.held + 28 * size_t(cell.held + k);
      const v4d H00 = widen(held), H11 = widen(held + 4), H22 = widen(held + 8), H01 = widen(held + 12),
                H12 = widen(held + 16), H20 = widen(held + 20);
      const v4d g = widen(held + 24);
      const v4d H[9] = {H00, H01, H20, H01, H11, H12, H20, H12, H22};
      v4d Q[9];  // grad H
      v4d twice = {};
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          Q[3 * i + j] = H[3 * i + j] + D[3 * i] * H[j] + D[3 * i + 1] * H[3 + j] + D[3 * i + 2] * H[6 + j];
          twice += (Q[3 * i + j] + H[3 * i + j]) * D[3 * i + j];
        }
      const v4d G[9] = {D[0] + 1, D[1], D[2], D[3], D[4] + 1, D[5], D[6], D[7], D[8] + 1};
      const v4d C[9] = {G[4] * G[8] - G[5] * G[7], G[5] * G[6] - G[3] * G[8], G[3] * G[7] - G[4] * G[6],
                        G[2] * G[7] - G[1] * G[8], G[0] * G[8] - G[2] * G[6], G[1] * G[6] - G[0] * G[7],
                        G[1] * G[5] - G[2] * G[4], G[2] * G[3] - G[0] * G[5], G[0] * G[4] - G[1] * G[3]};
      v4d L, slope;
      log_volume(G[0] * C[0] + G[1] * C[1] + G[2] * C[2], g, L, slope);
      const v4d pressure = g * L, shape = 0.5 * twice, w = g * slope;
      energy += V * (shape - pressure), magnitude += V * (size(shape) + size(pressure));
      for (int i = 0; i < 9; ++i) Q[i] = V * (Q[i] - w * C[i]);
      for (int a = 0; a < 8; ++a) {
        const v4d b0 = B[3 * a], b1 = B[3 * a + 1], b2 = B[3 * a + 2];
        for (int i = 0; i < 3; ++i) f[3 * a + i] += b0 * Q[3 * i] + b1 * Q[3 * i + 1] + b2 * Q[3 * i + 2];
      }
    }
    const double scale = double(cell.scale);
    for (int a = 0; a < 8; ++a) {
      v4 t = __builtin_convertvector(scale * totals(f[3 * a], f[3 * a + 1], f[3 * a + 2]), v4);
      t[3] = __builtin_sqrtf(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
      *reinterpret_cast<v4*>(force + 32 * c + 4 * size_t(a)) = t;
    }
    sums[c].energy = scale * lanes(energy), sums[c].magnitude = scale * lanes(magnitude);
  }
}

}  // namespace limberg::fem::LIMBERG_SET
