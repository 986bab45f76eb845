// A cell to a lane of a register: the same operations on every cell as in cells.cpp, without its fourth lane of zeros
// and its shuffles. Cells of one stencil share its numbers; cells that each have their own read them from a block
// (LaneBlock), where they lie as the lanes do.
#include "sim/fem/kernels/parts.h"

namespace limberg::fem::LIMBERG_SET {
namespace {

struct Three {
  part x, y, z;
};
LIMBERG_INLINE Three operator+(Three a, Three b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
LIMBERG_INLINE Three operator-(Three a, Three b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
LIMBERG_INLINE Three operator*(Three a, float s) { return {a.x * s, a.y * s, a.z * s}; }
LIMBERG_INLINE Three operator*(Three a, part s) { return {a.x * s, a.y * s, a.z * s}; }
LIMBERG_INLINE Three cross(Three a, Three b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
LIMBERG_INLINE part dot(Three a, Three b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

/// A stencil that all lanes share.
struct OneStencil {
  const KernelStencil& s;
  const float *K = s.K, *f0 = s.f0, *bx = s.bx, *by = s.by, *bz = s.bz, *inv4h = s.inv4h;
  const float *along = s.along, *across = s.across, *normal = s.normal;
  float volume = s.volume, p0 = s.p0, ke = s.ke, slide = s.slide, rest = s.rest, rest_lambda = s.rest_lambda;
  bool centred() const { return s.centred; }
  bool layers() const { return s.slide != 0; }
};
/// Those of the lanes of a block from `o` on.
struct OwnStencils {
  struct Rows {
    const float* first;
    LIMBERG_INLINE part operator[](int i) const { return *reinterpret_cast<const part*>(first + 16 * i); }
  };
  const LaneBlock& b;
  int o;
  Rows K{b.K + o}, f0{b.f0 + o}, bx{b.bx + o}, by{b.by + o}, bz{b.bz + o}, inv4h{b.inv4h + o};
  Rows along{b.along + o}, across{b.across + o}, normal{b.normal + o};
  part volume = Rows{b.volume + o}[0], p0 = Rows{b.p0 + o}[0], ke = Rows{b.ke + o}[0], slide = Rows{b.slide + o}[0],
       rest = Rows{b.rest + o}[0], rest_lambda = Rows{b.rest_lambda + o}[0];
  bool centred() const { return b.kind != LaneBlock::off_centre; }
  bool layers() const { return b.kind == LaneBlock::layers; }
};

/// A number less zero is that number, the sign of its own zero included.
template <class Numbers>
LIMBERG_INLINE Three everywhere(const Numbers& v) {
  const part o = {};
  return {v[0] - o, v[1] - o, v[2] - o};
}

/// Columns of G = F - I at a sample point off the centre; n[0] is zero.
template <class S>
LIMBERG_INLINE void gradients(const S& s, const Three* n, Three* g) {
  g[0] = n[1] * s.bx[0] + (n[3] - n[2]) * s.bx[1] + ((n[5] - n[4]) * s.bx[2] + (n[7] - n[6]) * s.bx[3]);
  g[1] = n[2] * s.by[0] + (n[3] - n[1]) * s.by[1] + ((n[6] - n[4]) * s.by[2] + (n[7] - n[5]) * s.by[3]);
  g[2] = n[4] * s.bz[0] + (n[5] - n[1]) * s.bz[1] + ((n[6] - n[2]) * s.bz[2] + (n[7] - n[3]) * s.bz[3]);
}
/// f += V P grad N there, columns of V P in h.
template <class S>
LIMBERG_INLINE void spread_to_corners(const S& s, Three hx, Three hy, Three hz, Three* f) {
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
  part in_plane, bend, sigma;
};
template <class S>
LIMBERG_INLINE LayerPlane layer_plane(const S& s, const Three* g) {
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
template <class S>
LIMBERG_INLINE part layer_stretch(const S& s, const LayerPlane& p, Three& q1, Three& q2) {
  const auto L = s.rest + s.rest_lambda;
  const part D = L + s.rest_lambda * p.sigma, inv = 1.0f / D;
  const part c1 = -s.rest_lambda * p.sigma * (L + D) * inv * inv, c = 1.0f + c1;
  q1 = (everywhere(s.along) * c1 + p.r1 * c) * -s.rest, q2 = (everywhere(s.across) * c1 + p.r2 * c) * -s.rest;
  return (-0.5f * s.rest) * (L * p.bend - 2.0f * s.rest_lambda * p.in_plane * p.sigma) * inv;
}
template <class S>
[[gnu::noinline]] part add_layers(const S& s, const Three* n, const Three* g, const Three* C, part th, part second,
                                  Three* h, Three* f) {
  const LayerPlane p = layer_plane(s, g);
  const Three gN = g[0] * s.normal[0] + g[1] * s.normal[1] + g[2] * s.normal[2];
  const part gnn = gN.x * s.normal[0] + gN.y * s.normal[1] + gN.z * s.normal[2], J = 1.0f + th, area2 = 1.0f + p.sigma;
  const part inv = 1.0f / area2;
  constexpr float i = 1 / slide_least;
  const part d = (area2 - slide_least) * i, value = i * (1.0f - d + d * d), slope = (-i * i) * (1.0f - 2.0f * d);
  const part full = (2.0f * second - p.bend + th * th - 2.0f * p.sigma * gnn) * inv, full_a1 = (th - p.sigma) * inv;
  const parti flat = area2 < slide_least;
  const part energy = flat ? J * J * value - 1.0f - 2.0f * gnn : full;
  const part a1 = flat ? J * value - 1.0f : full_a1, b1 = flat ? -J * J * slope - 1.0f : full_a1 * (J + area2) * inv;
  const part slip = dot(gN, gN) - energy;
  const part below = 1.0f / (slip + slip_limit), share = slip * (slip + 2 * slip_limit) * below * below,
             stiffer = slip * slip * below;
  Three c1, c2, at1, at2;
  const part here = layer_stretch(s, p, c1, c2);
  Three there_g[3];
  gradients(s, n, there_g);
  const part there = layer_stretch(s, layer_plane(s, there_g), at1, at2);

  const part left = s.slide * (1.0f - share), back = s.slide * share, b = 1.0f + b1, la = left * (1.0f + a1),
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

/// Corner `a` of all cells.
LIMBERG_INLINE Three gather(const KernelCell* const* cell, int a, const v4* local) {
  part r[4];
  for (int k = 0; k < 4; ++k) {
#if LIMBERG_LANES == 512
    const __m256 low = _mm256_set_m128((__m128)local[cell[4 + k]->node[a]], (__m128)local[cell[k]->node[a]]);
    const __m256 high = _mm256_set_m128((__m128)local[cell[12 + k]->node[a]], (__m128)local[cell[8 + k]->node[a]]);
    r[k] = (part)_mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
#elif LIMBERG_LANES == 256
    r[k] = (part)_mm256_set_m128((__m128)local[cell[4 + k]->node[a]], (__m128)local[cell[k]->node[a]]);
#else
    r[k] = local[cell[k]->node[a]];
#endif
  }
  Three t;
  from_rows(r, t.x, t.y, t.z);
  return t;
}

LIMBERG_INLINE part root(part v) {
#if LIMBERG_LANES == 512
  return (part)_mm512_sqrt_ps((__m512)v);
#elif LIMBERG_LANES == 256
  return (part)_mm256_sqrt_ps((__m256)v);
#else
  return part{__builtin_sqrtf(v[0]), __builtin_sqrtf(v[1]), __builtin_sqrtf(v[2]), __builtin_sqrtf(v[3])};
#endif
}

/// What a cell adds to the sums; added up in the order of the cells.
struct Energies {
  alignas(64) float scale[part_lanes], work[part_lanes], bulk[part_lanes], pre[part_lanes], layers[part_lanes];
};
LIMBERG_INLINE void add(const Energies& e, int count, bool layers, CellSums& sums) {
  double energy[part_lanes], magnitude[part_lanes];
  for (int l = 0; l < part_lanes; ++l) {
    const double w = double(e.scale[l]), e1 = 0.5 * double(e.work[l]), e2 = double(e.bulk[l]), e3 = double(e.pre[l]);
    energy[l] = w * (e1 + e2 - e3), magnitude[l] = w * (__builtin_fabs(e1) + e2 + __builtin_fabs(e3));
  }
  for (int l = 0; l < count; ++l) {
    sums.energy += energy[l], sums.magnitude += magnitude[l];
    if (!layers) continue;
    const double w = double(e.scale[l]), e4 = double(e.layers[l]);
    sums.energy += w * e4, sums.magnitude += w * __builtin_fabs(e4);
  }
}

/// Up to part_lanes cells: forces by corner (rows as to_rows leaves them) and energies, scale not applied to these.
template <bool Measure, class S>
LIMBERG_INLINE void lanes(const S& s, const KernelCell* const* cell, const float* qs, const v4* local, float* thetas,
                          v4 (*forces)[part_lanes], Energies& sum) {
  const part zero = {};
  const part scale = *reinterpret_cast<const part*>(sum.scale);

  // Relative to the first corner, as there.
  Three n[8];
  const Three base = gather(cell, 0, local);
  for (int a = 1; a < 8; ++a) n[a] = gather(cell, a, local) - base;
  alignas(64) Three f[8];
  Three work;
  for (int a = 0; a < 8; ++a) {
    const auto x0 = s.f0[4 * a], y0 = s.f0[4 * a + 1], z0 = s.f0[4 * a + 2];
    Three even = {x0 - zero, y0 - zero, z0 - zero}, odd = n[1] * s.K[8 + a];
    for (int b = 2; b < 8; b += 2) even = even + n[b] * s.K[8 * b + a], odd = odd + n[b + 1] * s.K[8 * b + 8 + a];
    const Three t = f[a] = even + odd;
    if (a == 0) continue;
    const Three w = {(t.x + x0) * n[a].x, (t.y + y0) * n[a].y, (t.z + z0) * n[a].z};
    work = a == 1 ? w : work + w;
  }

  // Columns of G = F - I at the sample point.
  Three g[3];
  if (s.centred()) {
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
  const part minor = cx.x;
  cx.x += gy.y + gz.z, cx.y -= gy.x, cx.z -= gz.x;
  cy.x -= gx.y, cy.y += gx.x + gz.z, cy.z -= gz.y;
  cz.x -= gx.z, cz.y -= gy.z, cz.z += gx.x + gy.y;
  const part second = minor + dot(gx, cx), th = gx.x + gy.y + gz.z + second;
  *reinterpret_cast<part*>(thetas) = th;
  const part x = th + *reinterpret_cast<const part*>(qs), p = s.ke * x, pm = p - s.p0;
  *reinterpret_cast<part*>(sum.work) = work.x + work.y + work.z;
  *reinterpret_cast<part*>(sum.bulk) = (0.5f * s.volume) * p * x;
  *reinterpret_cast<part*>(sum.pre) = (s.p0 * s.volume) * second;

  Three h[3] = {cx * pm + Three{p, zero, zero}, cy * pm + Three{zero, p, zero}, cz * pm + Three{zero, zero, p}};
  for (Three& column : h) column = column * s.volume;
  if (s.layers()) {
    const Three C[3] = {cx, cy, cz};
    *reinterpret_cast<part*>(sum.layers) = add_layers(s, n, g, C, th, second, h, f);
  }
  if (s.centred()) {
    const Three hx = h[0] * s.inv4h[0], hy = h[1] * s.inv4h[1], hz = h[2] * s.inv4h[2], a = hx + hy, b = hx - hy;
    f[0] = f[0] - (a + hz), f[1] = f[1] + (b - hz), f[2] = f[2] - (b + hz), f[3] = f[3] + (a - hz);
    f[4] = f[4] + (hz - a), f[5] = f[5] + (b + hz), f[6] = f[6] + (hz - b), f[7] = f[7] + (a + hz);
  } else {
    spread_to_corners(s, h[0], h[1], h[2], f);
  }
  for (int a = 0; a < 8; ++a) {
    const Three force = f[a] * scale;
    to_rows(force.x, force.y, force.z, Measure ? root(dot(force, force)) : zero, reinterpret_cast<part*>(forces[a]));
  }
}
/// Where to_rows puts lane l.
LIMBERG_INLINE int row_of(int l) { return (l & 3) * (part_lanes / 4) + (l >> 2); }

template <bool Measure>
void run(const CellView& d, int first, int last, const v4* local, v4* out, const float* q, float* theta,
         CellSums& sums) {
  const OneStencil s{d.stencils[d.cells[first].stencil]};
  for (int c = first; c < last; c += part_lanes) {
    const int count = last - c < part_lanes ? last - c : part_lanes;
    const KernelCell* cell[part_lanes];
    Energies sum;
    alignas(64) float qs[part_lanes], thetas[part_lanes];
    for (int l = 0; l < part_lanes; ++l) {
      const int at = c + (l < count ? l : count - 1);
      cell[l] = d.cells + at, sum.scale[l] = cell[l]->scale, qs[l] = q[at];
    }
    alignas(64) v4 forces[8][part_lanes];
    lanes<Measure>(s, cell, qs, local, thetas, forces, sum);
    for (int l = 0; l < count; ++l) theta[c + l] = thetas[l];
    add(sum, count, s.layers(), sums);
    for (int l = 0; l < count; ++l)
      for (int a = 0; a < 8; ++a) out[cell[l]->node[a]] += forces[a][row_of(l)];
  }
}

template <bool Measure>
void run_apart(const CellView& d, int first_cell, const LaneBlock& b, const v4* local, const float* q, float* theta,
               LaneForces& out) {
  for (int o = 0; o < b.count; o += part_lanes) {
    const OwnStencils s{b, o};
    const KernelCell* cell[part_lanes];
    Energies sum;
    alignas(64) float qs[part_lanes], thetas[part_lanes];
    for (int l = 0; l < part_lanes; ++l) {
      const int at = first_cell + b.cell[o + l];
      cell[l] = d.cells + at, sum.scale[l] = cell[l]->scale, qs[l] = q[at];
    }
    alignas(64) v4 forces[8][part_lanes];
    lanes<Measure>(s, cell, qs, local, thetas, forces, sum);
    for (int l = 0; l < part_lanes; ++l) {
      theta[first_cell + b.cell[o + l]] = thetas[l];
      for (int a = 0; a < 8; ++a) out.force[o + l][a] = forces[a][row_of(l)];
      out.work[o + l] = sum.work[l], out.bulk[o + l] = sum.bulk[l], out.pre[o + l] = sum.pre[l];
      if (s.layers()) out.layers[o + l] = sum.layers[l];
    }
  }
}

}  // namespace

void cells_wide(const CellView& data, int first, int last, const v4* local, v4* out, const float* q, float* theta,
                bool measure, CellSums& sums) {
  measure ? run<true>(data, first, last, local, out, q, theta, sums)
          : run<false>(data, first, last, local, out, q, theta, sums);
}

void cells_apart(const CellView& data, int first_cell, const LaneBlock& block, const v4* local, const float* q,
                 float* theta, bool measure, LaneForces& out) {
  measure ? run_apart<true>(data, first_cell, block, local, q, theta, out)
          : run_apart<false>(data, first_cell, block, local, q, theta, out);
}

}  // namespace limberg::fem::LIMBERG_SET
