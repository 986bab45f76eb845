// Sixteen cells of one stencil at a time, a cell to a lane: the
// same formulas as cells.cpp without its fourth lane of zeros,
// its shuffles, and a load of the stencil for every cell. For
// registers of 64 bytes: the displacements of a cell fill 21.
#include "sim/fem/kernels/parts.h"

namespace limberg::fem::LIMBERG_SET {
#if LIMBERG_LANES == 512
namespace {

struct Three {
  v16 x, y, z;
};
LIMBERG_INLINE Three operator+(Three a, Three b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
LIMBERG_INLINE Three operator-(Three a, Three b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
LIMBERG_INLINE Three operator*(Three a, float s) { return {a.x * s, a.y * s, a.z * s}; }
LIMBERG_INLINE Three operator*(Three a, v16 s) { return {a.x * s, a.y * s, a.z * s}; }
LIMBERG_INLINE Three cross(Three a, Three b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
LIMBERG_INLINE v16 dot(Three a, Three b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

LIMBERG_INLINE Three everywhere(const float* v) {
  const v16 o = {};
  return {o + v[0], o + v[1], o + v[2]};
}

/// Columns of G = F - I at a sample point off the centre; n[0] is zero.
LIMBERG_INLINE void gradients(const KernelStencil& s, const Three* n, Three* g) {
  g[0] = n[1] * s.bx[0] + (n[3] - n[2]) * s.bx[1] + ((n[5] - n[4]) * s.bx[2] + (n[7] - n[6]) * s.bx[3]);
  g[1] = n[2] * s.by[0] + (n[3] - n[1]) * s.by[1] + ((n[6] - n[4]) * s.by[2] + (n[7] - n[5]) * s.by[3]);
  g[2] = n[4] * s.bz[0] + (n[5] - n[1]) * s.bz[1] + ((n[6] - n[2]) * s.bz[2] + (n[7] - n[3]) * s.bz[3]);
}
/// f += V P grad N there, columns of V P in h.
LIMBERG_INLINE void spread_to_corners(const KernelStencil& s, Three hx, Three hy, Three hz, Three* f) {
  f[0] = f[0] - (hx * s.bx[0] + hy * s.by[0] + hz * s.bz[0]),
  f[1] = f[1] + (hx * s.bx[0] - hy * s.by[1] - hz * s.bz[1]);
  f[2] = f[2] + (hy * s.by[0] - hx * s.bx[1] - hz * s.bz[2]),
  f[3] = f[3] + (hx * s.bx[1] + hy * s.by[1] - hz * s.bz[3]);
  f[4] = f[4] + (hz * s.bz[0] - hx * s.bx[2] - hy * s.by[2]),
  f[5] = f[5] + (hx * s.bx[2] + hz * s.bz[1] - hy * s.by[3]);
  f[6] = f[6] + (hy * s.by[2] + hz * s.bz[2] - hx * s.bx[3]),
  f[7] = f[7] + (hx * s.bx[3] + hy * s.by[3] + hz * s.bz[3]);
}

/// What layers that share a cell add: as in cells.cpp, line by line.
struct LayerPlane {
  Three r1, r2;
  v16 in_plane, bend, sigma;
};
LIMBERG_INLINE LayerPlane layer_plane(const KernelStencil& s, const Three* g) {
  const Three t1 = everywhere(s.along), t2 = everywhere(s.across), N = everywhere(s.normal);
  const Three g1 = g[0] * s.along[0] + g[1] * s.along[1] + g[2] * s.along[2],
              g2 = g[0] * s.across[0] + g[1] * s.across[1] + g[2] * s.across[2];
  const Three g12 = cross(g1, g2), m = cross(g1, t2) + cross(t1, g2) + g12;
  LayerPlane p;
  p.r1 = cross(g2, N) + cross(t2, m) + cross(g2, m), p.r2 = cross(N, g1) + cross(m, t1) + cross(m, g1);
  p.in_plane = dot(g1, t1) + dot(g2, t2);
  p.bend = 2.0f * dot(g12, N) + dot(m, m);
  p.sigma = 2.0f * p.in_plane + p.bend;
  return p;
}
LIMBERG_INLINE v16 layer_stretch(const KernelStencil& s, const LayerPlane& p, Three& q1, Three& q2) {
  const float L = s.rest + s.rest_lambda;
  const v16 D = L + s.rest_lambda * p.sigma, inv = 1.0f / D;
  const v16 c1 = -s.rest_lambda * p.sigma * (L + D) * inv * inv, c = 1.0f + c1;
  q1 = (everywhere(s.along) * c1 + p.r1 * c) * -s.rest, q2 = (everywhere(s.across) * c1 + p.r2 * c) * -s.rest;
  return (-0.5f * s.rest) * (L * p.bend - 2.0f * s.rest_lambda * p.in_plane * p.sigma) * inv;
}
[[gnu::noinline]] v16 add_layers(const KernelStencil& s, const Three* n, const Three* g, const Three* C, v16 th,
                                 v16 second, Three* h, Three* f) {
  const LayerPlane p = layer_plane(s, g);
  const Three gN = g[0] * s.normal[0] + g[1] * s.normal[1] + g[2] * s.normal[2];
  const v16 gnn = gN.x * s.normal[0] + gN.y * s.normal[1] + gN.z * s.normal[2], J = 1.0f + th, area2 = 1.0f + p.sigma;
  const v16 inv = 1.0f / area2;
  constexpr float i = 1 / slide_least;
  const v16 d = (area2 - slide_least) * i, value = i * (1.0f - d + d * d), slope = (-i * i) * (1.0f - 2.0f * d);
  const v16 full = (2.0f * second - p.bend + th * th - 2.0f * p.sigma * gnn) * inv, full_a1 = (th - p.sigma) * inv;
  const v16i flat = area2 < slide_least;
  const v16 energy = flat ? J * J * value - 1.0f - 2.0f * gnn : full;
  const v16 a1 = flat ? J * value - 1.0f : full_a1, b1 = flat ? -J * J * slope - 1.0f : full_a1 * (J + area2) * inv;
  const v16 slip = dot(gN, gN) - energy;
  const v16 below = 1.0f / (slip + slip_limit), share = slip * (slip + 2 * slip_limit) * below * below,
            stiffer = slip * slip * below;
  Three c1, c2, at1, at2;
  const v16 here = layer_stretch(s, p, c1, c2);
  Three there_g[3];
  gradients(s, n, there_g);
  const v16 there = layer_stretch(s, layer_plane(s, there_g), at1, at2);

  const v16 left = s.slide * (1.0f - share), back = s.slide * share, b = 1.0f + b1, la = left * (1.0f + a1),
            extra = left * a1;
  const Three q1 = (everywhere(s.along) * b1 + p.r1 * b) * left + c1,
              q2 = (everywhere(s.across) * b1 + p.r2 * b) * left + c2;
  for (int k = 0; k < 3; ++k) {
    Three column = C[k] * la - q1 * s.along[k] - q2 * s.across[k] + gN * (back * s.normal[k]);
    (k == 0 ? column.x : k == 1 ? column.y : column.z) += extra;
    h[k] = h[k] + column * s.volume;
  }
  at1 = at1 * s.volume, at2 = at2 * s.volume;
  spread_to_corners(s, at1 * s.along[0] + at2 * s.across[0], at1 * s.along[1] + at2 * s.across[1],
                    at1 * s.along[2] + at2 * s.across[2], f);
  return s.volume * (0.5f * s.slide * (energy + stiffer) + (there - here));
}

/// Corner `a` of sixteen cells.
LIMBERG_INLINE Three gather(const KernelCell* const* cell, int a, const v4* local) {
  alignas(64) v16 r[4];
  for (int k = 0; k < 4; ++k) {
    const __m256 low = _mm256_set_m128((__m128)local[cell[4 + k]->node[a]], (__m128)local[cell[k]->node[a]]);
    const __m256 high = _mm256_set_m128((__m128)local[cell[12 + k]->node[a]], (__m128)local[cell[8 + k]->node[a]]);
    r[k] = (v16)_mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
  }
  Three t;
  from_rows(r, t.x, t.y, t.z);
  return t;
}

/// to_rows with a fourth number.
LIMBERG_INLINE void to_nodes(Three f, v16 w, v16 r[4]) {
  const v16i lo = {0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29};
  const v16i hi = {2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31};
  const v16i first = {0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29};
  const v16i second = {2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31};
  const v16 a = __builtin_shuffle(f.x, f.y, lo), b = __builtin_shuffle(f.x, f.y, hi);
  const v16 c = __builtin_shuffle(f.z, w, lo), d = __builtin_shuffle(f.z, w, hi);
  r[0] = __builtin_shuffle(a, c, first), r[1] = __builtin_shuffle(a, c, second);
  r[2] = __builtin_shuffle(b, d, first), r[3] = __builtin_shuffle(b, d, second);
}

LIMBERG_INLINE v8d low_half(v16 v) { return (v8d)_mm512_cvtps_pd(_mm512_castps512_ps256((__m512)v)); }
LIMBERG_INLINE v8d high_half(v16 v) { return (v8d)_mm512_cvtps_pd(_mm512_extractf32x8_ps((__m512)v, 1)); }
LIMBERG_INLINE v8d size(v8d v) { return (v8d)_mm512_abs_pd((__m512d)v); }
LIMBERG_INLINE double total(v8d v) { return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7])); }

template <bool Measure>
void run(const CellView& d, int first, int last, const v4* local, v4* out, const float* q, float* theta,
         CellSums& sums) {
  const KernelStencil& s = d.stencils[d.cells[first].stencil];
  v8d energy = {}, magnitude = {};
  for (int c = first; c < last; c += 16) {
    const int count = last - c < 16 ? last - c : 16;
    const KernelCell* cell[16];
    alignas(64) float scales[16];
    for (int l = 0; l < 16; ++l)
      cell[l] = d.cells + c + (l < count ? l : count - 1), scales[l] = l < count ? cell[l]->scale : 0;
    const __mmask16 used = __mmask16((1u << count) - 1);
    const v16 scale = get(scales);

    // Relative to the first corner, as there.
    Three n[8];
    const Three base = gather(cell, 0, local);
    for (int a = 1; a < 8; ++a) n[a] = gather(cell, a, local) - base;
    alignas(64) Three f[8];
    v16 work = {};
    for (int a = 0; a < 8; ++a) {
      const v16 zero = {};
      const float x0 = s.f0[4 * a], y0 = s.f0[4 * a + 1], z0 = s.f0[4 * a + 2];
      Three t = {zero + x0, zero + y0, zero + z0};
      for (int b = 1; b < 8; ++b) {
        const float k = s.K[8 * b + a];
        t.x += k * n[b].x, t.y += k * n[b].y, t.z += k * n[b].z;
      }
      f[a] = t;
      if (a > 0) work += (t.x + x0) * n[a].x + (t.y + y0) * n[a].y + (t.z + z0) * n[a].z;
    }

    // Columns of G = F - I at the sample point.
    Three g[3];
    if (s.centred) {
      const Three s1 = n[2] + n[3], s2 = n[4] + n[5], s3 = n[6] + n[7];
      g[0] = ((n[1] + (n[3] - n[2])) + ((n[5] - n[4]) + (n[7] - n[6]))) * s.inv4h[0];
      g[1] = ((s1 - n[1]) + (s3 - s2)) * s.inv4h[1];
      g[2] = ((s2 + s3) - (n[1] + s1)) * s.inv4h[2];
    } else {
      gradients(s, n, g);
    }
    const Three &gx = g[0], &gy = g[1], &gz = g[2];
    // Columns of cof F - I = (tr G) I - G^T + cof G.
    Three cx = cross(gy, gz), cy = cross(gz, gx), cz = cross(gx, gy);
    const v16 minor = cx.x;
    cx.x += gy.y + gz.z, cx.y -= gy.x, cx.z -= gz.x;
    cy.x -= gx.y, cy.y += gx.x + gz.z, cy.z -= gz.y;
    cz.x -= gx.z, cz.y -= gy.z, cz.z += gx.x + gy.y;
    const v16 second = minor + dot(gx, cx), th = gx.x + gy.y + gz.z + second;
    _mm512_mask_storeu_ps(theta + c, used, (__m512)th);
    const v16 x = th + (v16)_mm512_maskz_loadu_ps(used, q + c), p = s.ke * x, pm = p - s.p0;
    const v16 bulk = (0.5f * s.volume) * p * x, pre = (s.p0 * s.volume) * second;
    for (int half = 0; half < 2; ++half) {
      const v8d w = half ? high_half(scale) : low_half(scale);
      const v8d e1 = 0.5 * (half ? high_half(work) : low_half(work)), e2 = half ? high_half(bulk) : low_half(bulk),
                e3 = half ? high_half(pre) : low_half(pre);
      energy += w * (e1 + e2 - e3), magnitude += w * (size(e1) + e2 + size(e3));
    }

    Three h[3] = {cx * pm, cy * pm, cz * pm};
    h[0].x += p, h[1].y += p, h[2].z += p;
    for (Three& column : h) column = column * s.volume;
    if (s.slide != 0) {
      const Three C[3] = {cx, cy, cz};
      const v16 e4 = add_layers(s, n, g, C, th, second, h, f);
      for (int half = 0; half < 2; ++half) {
        const v8d w = half ? high_half(scale) : low_half(scale), e = half ? high_half(e4) : low_half(e4);
        energy += w * e, magnitude += w * size(e);
      }
    }
    if (s.centred) {
      const Three hx = h[0] * s.inv4h[0], hy = h[1] * s.inv4h[1], hz = h[2] * s.inv4h[2], a = hx + hy, b = hx - hy;
      f[0] = f[0] - (a + hz), f[1] = f[1] + (b - hz), f[2] = f[2] - (b + hz), f[3] = f[3] + (a - hz);
      f[4] = f[4] + (hz - a), f[5] = f[5] + (b + hz), f[6] = f[6] + (hz - b), f[7] = f[7] + (a + hz);
    } else {
      spread_to_corners(s, h[0], h[1], h[2], f);
    }
    for (int a = 0; a < 8; ++a) {
      const Three force = f[a] * scale;
      v16 w = {};
      if (Measure) w = (v16)_mm512_sqrt_ps((__m512)dot(force, force));
      alignas(64) v16 r[4];
      to_nodes(force, w, r);
      const v4* rows = reinterpret_cast<const v4*>(r);
      for (int l = 0; l < count; ++l) out[cell[l]->node[a]] += rows[(l & 3) * 4 + (l >> 2)];
    }
  }
  sums.energy += total(energy), sums.magnitude += total(magnitude);
}

}  // namespace

void cells_wide(const CellView& data, int first, int last, const v4* local, v4* out, const float* q, float* theta,
                bool measure, CellSums& sums) {
  measure ? run<true>(data, first, last, local, out, q, theta, sums)
          : run<false>(data, first, last, local, out, q, theta, sums);
}
#endif
}  // namespace limberg::fem::LIMBERG_SET
