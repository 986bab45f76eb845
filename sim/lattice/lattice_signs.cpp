#include "sim/lattice/lattice_signs.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace limberg {
namespace {

int sign(double v) { return v > 0 ? 1 : v < 0 ? -1 : 0; }

int32_t floor_of(double v) {
  const int32_t i = int32_t(v);
  return v < i ? i - 1 : i;
}

// Sign of p[axis] - c for an integer c.
int compare_with(const Homogeneous& p, int axis, int64_t c) {
  return (p.x[size_t(axis)] - multiply<4>(p.w, Int256(c))).sign();
}

// Exact edge_about_corner, before ties are broken. Everything times w_p w_q 2^48 > 0.
int edge_about_corner_exact(const PointRef& p, const PointRef& q, size_t i, size_t j, const SubPoint& corner) {
  const Homogeneous P = p.exact(), Q = q.exact();
  const Int256 scale(int64_t(1) << kSubUnitBits);
  // a = 2^24 (P - c) w_p, b = 2^24 (Q - c) w_q; sign of (P - c) x (Q - c).
  auto from_corner = [&](const Homogeneous& H, size_t k) {
    return multiply<4>(H.x[k], scale) - multiply<4>(H.w, Int256(corner[k]));
  };
  const Int256 ai = from_corner(P, i), aj = from_corner(P, j), bi = from_corner(Q, i), bj = from_corner(Q, j);
  return (multiply<8>(ai, bj) - multiply<8>(aj, bi)).sign();
}

// The corner is moved by (-e_i, -e_j): d/de_i of the determinant is q_j - p_j, d/de_j is p_i - q_i.
int break_tie(const PointRef& p, const PointRef& q, int i, int j) {
  const int by_i = compare_coordinate(j, q, p), by_j = compare_coordinate(i, p, q);
  if (i < j) return by_i ? by_i : by_j;
  return by_j ? by_j : by_i;
}

int128 line_numerator(const Plane& p, int axis, const SubPoint& c) {
  const size_t j = size_t(axis + 1) % 3, k = size_t(axis + 2) % 3;
  return (p.d << kSubUnitBits) - int128(p.n[j]) * c[j] - int128(p.n[k]) * c[k];
}

}  // namespace

int32_t layer_of(const PointRef& p, int axis, int32_t origin, int32_t pitch) {
  const double x = (*p.approx)[axis];
  // Integers below 2^23: the quotient cannot round up to a whole number that it does not reach.
  if (!p.implicit()) return floor_of((x - origin) / pitch);
  const int64_t near =
      floor_of((x - origin) / pitch + 0.5);  // the nearest plane is the only one that x can be unsure of
  const double plane = double(origin) + double(near) * pitch;
  const int64_t c = int64_t(origin) + near * pitch;
  if (std::abs(x - plane) > kApproximationError) return int32_t(x >= plane ? near : near - 1);
  return int32_t(compare_with(p.exact(), axis, c) >= 0 ? near : near - 1);
}

int edge_about_corner(const PointRef& p, const PointRef& q, int axis, const SubPoint& corner) {
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const double ci = sub_to_half(corner[size_t(i)]), cj = sub_to_half(corner[size_t(j)]);
  const double ai = (*p.approx)[i] - ci, aj = (*p.approx)[j] - cj;
  const double bi = (*q.approx)[i] - ci, bj = (*q.approx)[j] - cj;
  const double l = ai * bj, r = aj * bi, det = l - r;
  // Each difference: rounding 2^-53 relative (|.| < 2^23, so below 2^-29), plus the approximation's own error.
  constexpr double kDelta = 2 * kApproximationError;
  const double error = kDelta * (std::abs(ai) + std::abs(aj) + std::abs(bi) + std::abs(bj)) * 1.0000001 +
                       2 * kDelta * kDelta + 0x1p-51 * (std::abs(l) + std::abs(r));
  int s;
  if (std::abs(det) > error) {
    s = sign(det);
  } else {
    s = edge_about_corner_exact(p, q, size_t(i), size_t(j), corner);
  }
  return s ? s : break_tie(p, q, i, j);
}

EdgeSigns edge_about_corners(const PointRef& p, const PointRef& q, int parallel, const CellBounds& cell) {
  using Two = double __attribute__((vector_size(16)));  // low and high bound of a coordinate
  using Bits = int64_t __attribute__((vector_size(16)));
  Two a[3], b[3];
  double far = 0;
  for (int k = 0; k < 3; ++k) {
    const double pk = (*p.approx)[k], qk = (*q.approx)[k], low = cell.half[size_t(k)][0],
                 high = cell.half[size_t(k)][1];
    a[k] = Two{pk - low, pk - high};
    b[k] = Two{qk - low, qk - high};
    far = std::max(
        far, std::max(std::max(std::abs(a[k][0]), std::abs(a[k][1])), std::max(std::abs(b[k][0]), std::abs(b[k][1]))));
  }
  // One bound for all of them, as in edge_about_corner. Integers below 2^23 have exact products and differences.
  const bool exact = !p.implicit() && !q.implicit();
  constexpr double kDelta = 2 * kApproximationError;
  const double error = exact ? 0 : 4.000001 * kDelta * far + 2 * kDelta * kDelta + 0x1p-50 * far * far;
  const Two above{error, error}, below{-error, -error};
  Bits left{0, 0}, right{0, 0};  // one part per bound of the first coordinate
  for (int axis = 0; axis < 3; ++axis) {
    const int i = axis == 2 ? 0 : axis + 1, j = axis == 0 ? 2 : axis - 1;
    for (int second = 0; second < 2; ++second) {
      const Two aj{a[j][second], a[j][second]}, bj{b[j][second], b[j][second]};
      const Two det = a[i] * bj - aj * b[i];
      const int bit = 4 * axis + 2 * second;
      const Bits here{int64_t(1) << bit, int64_t(2) << bit};
      left |= (det > above) & here;
      right |= (det < below) & here;
    }
  }
  EdgeSigns out;
  out.left = uint16_t(left[0] | left[1]);
  out.right = uint16_t(right[0] | right[1]);
  if (parallel >= 0) {
    const uint16_t others = uint16_t(0xfff & ~(0xf << 4 * parallel));
    out.left &= others, out.right &= others;
  }
  uint32_t doubt = 0xfffu & ~uint32_t(out.left | out.right);
  if (parallel >= 0) doubt &= ~(0xfu << 4 * parallel);
  for (; doubt; doubt &= doubt - 1) {
    const int bit = std::countr_zero(doubt), axis = bit / 4, corner = bit % 4;
    const int i = axis == 2 ? 0 : axis + 1, j = axis == 0 ? 2 : axis - 1;
    int s =
        exact ? 0 : edge_about_corner_exact(p, q, size_t(i), size_t(j), cell.edge_corner[size_t(axis)][size_t(corner)]);
    if (!s) s = break_tie(p, q, i, j);
    if (s > 0) out.left |= uint16_t(1 << bit);
    if (s < 0) out.right |= uint16_t(1 << bit);
  }
  return out;
}

int plane_at_corner(const Plane& plane, const SubPoint& c) {
  int128 v = -(plane.d << kSubUnitBits);
  for (size_t k = 0; k < 3; ++k) v += int128(plane.n[k]) * c[k];
  if (v) return sign_of(v);
  for (size_t k = 0; k < 3; ++k)
    if (plane.n[k]) return plane.n[k] > 0 ? -1 : 1;
  return 0;
}

double hit_on_line(const Plane& plane, int axis, const SubPoint& on_line) {
  return double(line_numerator(plane, axis, on_line)) / double(plane.n[size_t(axis)]) * 0x1p-24;
}

int order_on_line(const Plane& a, const Plane& b, int axis, const SubPoint& on_line) {
  const size_t i = size_t(axis);
  const double ta = hit_on_line(a, axis, on_line), tb = hit_on_line(b, axis, on_line);
  if (std::abs(ta - tb) > 0x1p-50 * (std::abs(ta) + std::abs(tb))) return ta < tb ? -1 : 1;
  const int flip = (a.n[i] < 0) != (b.n[i] < 0) ? -1 : 1;
  auto cross = [&](const int128& na, const int128& nb) {  // sign of na / a.n - nb / b.n
    return flip * (multiply<4>(Int256(na), Int256(b.n[i])) - multiply<4>(Int256(nb), Int256(a.n[i]))).sign();
  };
  if (const int s = cross(line_numerator(a, axis, on_line), line_numerator(b, axis, on_line))) return s;
  // The line is moved by (-e_j, -e_k): the hit moves by (n_j e_j + n_k e_k) / n_axis.
  for (size_t k = 0; k < 3; ++k) {
    if (k == i) continue;
    if (const int s = cross(a.n[k], b.n[k])) return s;
  }
  return 0;
}

}  // namespace limberg
