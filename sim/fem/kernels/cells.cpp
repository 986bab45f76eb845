// The one loop that visits the material (element_system.h has the formulas).
//
// A cell here, a cell to a lane in cells_wide.cpp (of one stencil, or of one each): the two share no line, and every
// number of a cell goes through the same operations in the same order in both, so that the result does not tell which
// of the two ran (tests).
#include "sim/fem/kernels/parts.h"

namespace limberg::fem::LIMBERG_SET {
namespace {

inline v4 cross(v4 a, v4 b) {
  const v4 a1 = __builtin_shufflevector(a, a, 1, 2, 0, 3), b1 = __builtin_shufflevector(b, b, 1, 2, 0, 3);
  const v4 c = a * b1 - a1 * b;
  return __builtin_shufflevector(c, c, 1, 2, 0, 3);
}
inline float dot3(v4 a, v4 b) {
  const v4 m = a * b;
  return m[0] + m[1] + m[2];
}

/// f = K u + f0 for the eight nodes, of which the first does not move: even columns and odd ones in a sum each, in
/// order. Returns sum of u . (f + f0), spread over the lanes.
#if LIMBERG_LANES == 512
inline v4 deviatoric(const KernelStencil& s, const v4* un, v4* f) {
  const v16* f0 = reinterpret_cast<const v16*>(s.f0);
  const v16* K = reinterpret_cast<const v16*>(s.K);
  const v16 x = in_every_lane(un + 1);
  v16 a0 = f0[0], b0 = f0[1], a1 = LIMBERG_QUAD(K[0], 2) * x, b1 = LIMBERG_QUAD(K[0], 3) * x;
  for (int j = 1; j < 4; ++j) {
    const v16 k = K[j];  // columns 2 j and 2 j + 1
    const v16 x0 = in_every_lane(un + 2 * j), x1 = in_every_lane(un + 2 * j + 1);
    a0 += LIMBERG_QUAD(k, 0) * x0, b0 += LIMBERG_QUAD(k, 1) * x0;
    a1 += LIMBERG_QUAD(k, 2) * x1, b1 += LIMBERG_QUAD(k, 3) * x1;
  }
  reinterpret_cast<v16*>(f)[0] = a0 + a1, reinterpret_cast<v16*>(f)[1] = b0 + b1;
#else
inline v4 deviatoric(const KernelStencil& s, const v4* un, v4* f) {
  for (int half = 0; half < 2; ++half) {  // four nodes each
    const float* K = s.K + 4 * half;
    const v16 x = in_every_lane(un + 1);
    v16 a = get(s.f0 + 16 * half), b = spread(K + 8) * x;
    for (int j = 2; j < 8; j += 2) {
      a += spread(K + 8 * j) * in_every_lane(un + j);
      b += spread(K + 8 * j + 8) * in_every_lane(un + j + 1);
    }
    put(f + 4 * half, a + b);
  }
#endif
  const v4* f0s = reinterpret_cast<const v4*>(s.f0);
  v4 w = (f[1] + f0s[1]) * un[1];
  for (int a = 2; a < 8; ++a) w += (f[a] + f0s[a]) * un[a];
  return w;
}

/// Columns of G = F - I at the sample point off the centre; n[0] is zero.
LIMBERG_INLINE void gradients(const KernelStencil& s, const v4* n, v4& gx, v4& gy, v4& gz) {
  gx = n[1] * s.bx[0] + (n[3] - n[2]) * s.bx[1] + ((n[5] - n[4]) * s.bx[2] + (n[7] - n[6]) * s.bx[3]);
  gy = n[2] * s.by[0] + (n[3] - n[1]) * s.by[1] + ((n[6] - n[4]) * s.by[2] + (n[7] - n[5]) * s.by[3]);
  gz = n[4] * s.bz[0] + (n[5] - n[1]) * s.bz[1] + ((n[6] - n[2]) * s.bz[2] + (n[7] - n[3]) * s.bz[3]);
}
/// f += V P grad N there, columns of V P in h.
LIMBERG_INLINE void spread_to_corners(const KernelStencil& s, v4 hx, v4 hy, v4 hz, v4* f) {
  f[0] -= hx * s.bx[0] + hy * s.by[0] + hz * s.bz[0], f[1] += hx * s.bx[0] - hy * s.by[1] - hz * s.bz[1];
  f[2] += hy * s.by[0] - hx * s.bx[1] - hz * s.bz[2], f[3] += hx * s.bx[1] + hy * s.by[1] - hz * s.bz[3];
  f[4] += hz * s.bz[0] - hx * s.bx[2] - hy * s.by[2], f[5] += hx * s.bx[2] + hz * s.bz[1] - hy * s.by[3];
  f[6] += hy * s.by[2] + hz * s.bz[2] - hx * s.bx[3], f[7] += hx * s.bx[3] + hy * s.by[3] + hz * s.bz[3];
}

/// How the plane of the layers is stretched at a place: columns of G = F - I in, and without subtracting numbers near 1
struct LayerPlane {
  v4 r1, r2;                    // d(|n|^2/2)/dF = (T1 + r1) T1^T + (T2 + r2) T2^T, n = cof F N
  float in_plane, bend, sigma;  // T1.G T1 + T2.G T2;  |n|^2 - 1 = sigma = 2 in_plane + bend
};
LIMBERG_INLINE LayerPlane layer_plane(v4 t1, v4 t2, v4 N, v4 gx, v4 gy, v4 gz) {
  const v4 g1 = gx * t1[0] + gy * t1[1] + gz * t1[2], g2 = gx * t2[0] + gy * t2[1] + gz * t2[2];
  const v4 g12 = cross(g1, g2);
  const v4 m = cross(g1, t2) + cross(t1, g2) + g12;  // n - N
  LayerPlane p;
  p.r1 = cross(g2, N) + cross(t2, m) + cross(g2, m), p.r2 = cross(N, g1) + cross(m, t1) + cross(m, g1);
  p.in_plane = dot3(g1, t1) + dot3(g2, t2);
  p.bend = 2 * dot3(g12, N) + dot3(m, m);
  p.sigma = 2 * p.in_plane + p.bend;
  return p;
}
/// mu L sigma / (2 (L + lambda sigma)) with a minus (layer_slide.h)
/// less its linear part; `q1`, `q2`: its slope's columns there.
LIMBERG_INLINE float layer_stretch(const KernelStencil& s, const LayerPlane& p, v4 t1, v4 t2, v4& q1, v4& q2) {
  const float L = s.rest + s.rest_lambda, D = L + s.rest_lambda * p.sigma, inv = 1 / D;
  const float c1 = -s.rest_lambda * p.sigma * (L + D) * inv * inv, c = 1 + c1;  // (L / D)^2 less 1
  q1 = -s.rest * (c1 * t1 + c * p.r1), q2 = -s.rest * (c1 * t2 + c * p.r2);
  return -0.5f * s.rest * (L * p.bend - 2 * p.in_plane * s.rest_lambda * p.sigma) * inv;
}

/// What layers that share a cell add (layer_slide.h), without the part that
/// is linear in the displacement: that is in f0. g, C: columns of G = F - I
/// and of cof F - I at the centre; th = J - 1, second = th - tr G; their
/// forces go to h, those at the sample point to f. Apart from the loop, so
/// that cells without layers are not touched by it. Returns the energy.
[[gnu::noinline]] float add_layers(const KernelStencil& s, const v4* n, const v4* g, const v4* C, float th,
                                   float second, v4* h, v4* f) {
  const v4 t1 = {s.along[0], s.along[1], s.along[2], 0}, t2 = {s.across[0], s.across[1], s.across[2], 0},
           N = {s.normal[0], s.normal[1], s.normal[2], 0};
  const LayerPlane p = layer_plane(t1, t2, N, g[0], g[1], g[2]);
  const v4 gN = g[0] * N[0] + g[1] * N[1] + g[2] * N[2];
  const float gnn = dot3(gN, N), J = 1 + th, area2 = 1 + p.sigma;
  float energy, a1, b1;  // a - 1 and b - 1 of dW/dF = a cof F - b (q1 T1^T + q2 T2^T)
  if (area2 >= slide_least) {
    const float inv = 1 / area2;
    energy = (2 * second - p.bend + th * th - 2 * p.sigma * gnn) * inv;
    a1 = (th - p.sigma) * inv;
    b1 = a1 * (J + area2) * inv;
  } else {  // the parabola in area2 that goes on from there
    constexpr float i = 1 / slide_least;
    const float d = (area2 - slide_least) * i, value = i * (1 - d + d * d), slope = -i * i * (1 - 2 * d);
    energy = J * J * value - 1 - 2 * gnn;
    a1 = J * value - 1;
    b1 = -J * J * slope - 1;
  }
  // Slip x = |F N|^2 - J^2 g, less as it grows: slide/2 x^2 / (x + limit) on top.
  const float slip = dot3(gN, gN) - energy;
  const float below = 1 / (slip + slip_limit), share = slip * (slip + 2 * slip_limit) * below * below;
  const float stiffer = slip * slip * below;
  v4 c1, c2, at1, at2;  // slopes of the stretch energy here and at the sample point
  const float here = layer_stretch(s, p, t1, t2, c1, c2);
  v4 sx, sy, sz;
  gradients(s, n, sx, sy, sz);
  const float there = layer_stretch(s, layer_plane(t1, t2, N, sx, sy, sz), t1, t2, at1, at2);

  const float V = s.volume, slide = s.slide, b = 1 + b1;
  const float left = slide * (1 - share), back = slide * share, la = left * (1 + a1);
  const v4 q1 = left * (b1 * t1 + b * p.r1) + c1, q2 = left * (b1 * t2 + b * p.r2) + c2;
  for (int i = 0; i < 3; ++i) {
    v4 column = la * C[i] - q1 * t1[i] - q2 * t2[i] + back * N[i] * gN;
    column[i] += left * a1;
    h[i] += V * column;
  }
  at1 *= V, at2 *= V;
  spread_to_corners(s, at1 * t1[0] + at2 * t2[0], at1 * t1[1] + at2 * t2[1], at1 * t1[2] + at2 * t2[2], f);
  return V * (0.5f * slide * (energy + stiffer) + (there - here));
}

template <bool Measure>
CellSums run(const CellView& d, const Tile& tile, const Node4* u, const float* q, Node4* slots, float* theta) {
  alignas(64) v4 local[max_tile_nodes];
  v4* out = reinterpret_cast<v4*>(slots + tile.first_slot);
  const int nodes = tile.last_slot - tile.first_slot;
  for (int i = 0; i < nodes; ++i) {
    local[i] = load(u[d.slot_node[tile.first_slot + i]]);
    out[i] = v4{};
  }
  CellSums sums;
  LaneForces apart[LaneBlock::none];  // of the block that each kind is at, and how many of its cells were taken
  int taken[LaneBlock::none] = {16, 16, 16};
  const LaneBlock* next = tile.lanes.block;
  for (int c = tile.first_cell; c < tile.last_cell; ++c) {
    const KernelCell& cell = d.cells[c];
    if (const int kind = next ? tile.lanes.kind[c - tile.first_cell] : LaneBlock::none; kind != LaneBlock::none) {
      LaneForces& block = apart[kind];
      if (taken[kind] == 16) cells_apart(d, tile.first_cell, *next++, local, q, theta, Measure, block), taken[kind] = 0;
      const int l = taken[kind]++;
      for (int k = 0; k < 8; ++k) out[cell.node[k]] += block.force[l][k];
      const double w = double(cell.scale), e1 = 0.5 * double(block.work[l]), e2 = double(block.bulk[l]),
                   e3 = double(block.pre[l]);
      sums.energy += w * (e1 + e2 - e3), sums.magnitude += w * (__builtin_fabs(e1) + e2 + __builtin_fabs(e3));
      if (kind == LaneBlock::layers) {
        const double e4 = double(block.layers[l]);
        sums.energy += w * e4, sums.magnitude += w * __builtin_fabs(e4);
      }
      continue;
    }
    const KernelStencil& s = d.stencils[cell.stencil];
    int same = c + 1;
    while (same < tile.last_cell && d.cells[same].stencil == cell.stencil) ++same;
    if (same - c >= least_wide) {
      cells_wide(d, c, same, local, out, q, theta, Measure, sums);
      c = same - 1;
      continue;
    }
    const float ix = s.inv4h[0], iy = s.inv4h[1], iz = s.inv4h[2];
    alignas(64) v4 n[8], f[8];
    // Relative to the first corner: a translation costs nothing, and its digits would be lost by those of the strain.
    const v4 base = local[cell.node[0]];
    for (int a = 0; a < 8; ++a) n[a] = local[cell.node[a]] - base;
    const v4 work = deviatoric(s, n, f);

    // Columns of G = F - I at the sample point.
    v4 gx, gy, gz;
    if (s.centred) {
      const v4 s1 = n[2] + n[3], s2 = n[4] + n[5], s3 = n[6] + n[7];
      gx = ((n[1] + (n[3] - n[2])) + ((n[5] - n[4]) + (n[7] - n[6]))) * ix;
      gy = ((s1 - n[1]) + (s3 - s2)) * iy;
      gz = ((s2 + s3) - (n[1] + s1)) * iz;
    } else {
      gradients(s, n, gx, gy, gz);
    }
    // Columns of cof F - I = (tr G) I - G^T + cof G, without ever subtracting numbers near 1.
    const v4 mx = cross(gy, gz), my = cross(gz, gx), mz = cross(gx, gy);
    const float xx = gx[0], yy = gy[1], zz = gz[2];
    const v4 cx = mx + v4{yy + zz, -gy[0], -gz[0], 0};
    const v4 cy = my + v4{-gx[1], xx + zz, -gz[1], 0};
    const v4 cz = mz + v4{-gx[2], -gy[2], xx + yy, 0};
    const float trace = xx + yy + zz;
    const float second = mx[0] + dot3(gx, cx);  // theta - tr G
    const float th = trace + second;
    theta[c] = th;
    const float x = th + q[c];
    const float p = s.ke * x;
    const float vol = s.volume;
    const float bulk = 0.5f * vol * p * x, pre = s.p0 * vol * second;
    const double e1 = 0.5 * double(work[0] + work[1] + work[2]), e2 = double(bulk), e3 = double(pre);
    sums.energy += double(cell.scale) * (e1 + e2 - e3);
    sums.magnitude += double(cell.scale) * (__builtin_fabs(e1) + e2 + __builtin_fabs(e3));

    const float pm = p - s.p0;
    v4 hx = (pm * cx + v4{p, 0, 0, 0}) * vol;
    v4 hy = (pm * cy + v4{0, p, 0, 0}) * vol;
    v4 hz = (pm * cz + v4{0, 0, p, 0}) * vol;
    if (s.slide != 0) {
      const v4 g[3] = {gx, gy, gz}, C[3] = {cx, cy, cz};
      v4 h[3] = {hx, hy, hz};
      const double e4 = double(add_layers(s, n, g, C, th, second, h, f));
      hx = h[0], hy = h[1], hz = h[2];
      sums.energy += double(cell.scale) * e4;
      sums.magnitude += double(cell.scale) * __builtin_fabs(e4);
    }
    if (s.centred) {
      hx *= ix, hy *= iy, hz *= iz;
      const v4 a = hx + hy, b = hx - hy;
      f[0] -= a + hz, f[1] += b - hz, f[2] -= b + hz, f[3] += a - hz;
      f[4] += hz - a, f[5] += b + hz, f[6] += hz - b, f[7] += a + hz;
    } else {
      spread_to_corners(s, hx, hy, hz, f);
    }
    for (int k = 0; k < 8; ++k) {
      v4 g = f[k] * cell.scale;
      if (Measure) g[3] = __builtin_sqrtf(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
      out[cell.node[k]] += g;
    }
  }
  return sums;
}

}  // namespace

CellSums evaluate_tile(const CellView& data, const Tile& tile, const Node4* u, const float* q, Node4* slots,
                       float* theta, bool measure) {
  return measure ? run<true>(data, tile, u, q, slots, theta) : run<false>(data, tile, u, q, slots, theta);
}

void sum_slots(const CellView& data, const Node4* slots, size_t begin, size_t end, Node4* out) {
  const int32_t* first = data.node_slots_begin;
  const int32_t* list = data.node_slots;
  for (size_t i = begin; i < end; ++i) {
    v4 s = {};
    for (int32_t j = first[i]; j < first[i + 1]; ++j) s += load(slots[list[j]]);
    store(out[i], s);
  }
}

// Measured choices: an unlimited increment diverges for nearly incompressible material, and a cell that is flattened or
// blown up (a scrambled start) has no useful pressure, so its multiplier fades until the cell has a shape again.
void update_multipliers(const CellView& data, const float* theta, float* q, float scale_of_increment, size_t first,
                        size_t last) {
  constexpr float limit = 0.15f;
  for (size_t c = first; c < last; ++c) {
    const float r = data.stencils[data.cells[c].stencil].r;
    if (r == 0) continue;
    const float th = theta[c];
    if (th < -0.7f || th > 2.0f) {
      q[c] *= 0.5f;
      continue;
    }
    float dq = scale_of_increment * (r * (th + q[c]) - q[c]);
    dq = dq > limit ? limit : dq < -limit ? -limit : dq;
    q[c] += dq;
  }
}

}  // namespace limberg::fem::LIMBERG_SET
