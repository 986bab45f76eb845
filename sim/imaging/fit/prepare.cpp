#include "sim/imaging/fit/prepare.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/imaging/fit/grid_reach.h"
#include "sim/imaging/fit/mouths.h"
#include "sim/imaging/fit/thin_walls.h"
#include "sim/imaging/solid/even_grid.h"

namespace limberg {
namespace {

using namespace imaging;
using Size = GridSize;
constexpr double kBeyondBorder = 4;  // voxels: how far the object goes on beyond a border that it crosses
constexpr double kBlur = 0.5;        // of the longest side of a voxel: scale at which crests are looked for
// below the crests' threshold, times from there to the isovalue: -125 HU for 100 and 250, less than fat
constexpr double kAirLevel = 1.5;
// longest sides of a voxel: so deep a ball that rolls over a gap may reach into its wall
constexpr double kShallow = 1.5;
// With thin walls what is left of a gap is frayed: a wider ball must pass on
// the way into a cavity, and sees less of the depth of a pit. Of a real CT and
// of the synthetic head's, both of voxels of 3.2 mm, any ball from 7.5 to 8 mm
// tells orbits, nose and foramen from temples and lost walls (2026-11-22).
constexpr double kWayWithWalls = 0.43;  // of mouth_width_mm
constexpr double kDeepWithWalls = 0.7;  // widths of the mouth
constexpr double kGate = 2.5;           // steps: the sealed surface at a mouth is not farther from its throat
constexpr float kFar = std::numeric_limits<float>::infinity();

/// Calls line(first index, stride, length) for every line along `axis`.
template <class Line>
void lines(const Size& n, int axis, Workers& workers, Line&& line) {
  const size_t stride[3] = {1, size_t(n[0]), size_t(n[0]) * size_t(n[1])};
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  workers.parallel_for(size_t(n[size_t(a)]) * size_t(n[size_t(b)]), 64, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      line((i % size_t(n[size_t(a)])) * stride[a] + (i / size_t(n[size_t(a)])) * stride[b], stride[axis],
           size_t(n[size_t(axis)]));
  });
}

/// Lower envelope of the parabolas (x - i)^2 + f(i).
void envelope(float* f, size_t stride, size_t n, std::vector<float>& g, std::vector<int32_t>& top,
              std::vector<float>& from) {
  g.resize(n), top.resize(n), from.resize(n + 1);
  for (size_t i = 0; i < n; ++i) g[i] = f[i * stride];
  int32_t k = -1;
  for (size_t i = 0; i < n; ++i) {
    if (g[i] == kFar) continue;
    float s = -kFar;
    while (k >= 0) {
      const float q = float(i), p = float(top[size_t(k)]);
      s = ((g[i] + q * q) - (g[size_t(top[size_t(k)])] + p * p)) / (2 * (q - p));
      if (s > from[size_t(k)]) break;
      --k;
    }
    if (k < 0) s = -kFar;
    top[size_t(++k)] = int32_t(i), from[size_t(k)] = s;
  }
  if (k < 0) return;
  int32_t j = 0;
  for (size_t i = 0; i < n; ++i) {
    while (j < k && from[size_t(j) + 1] < float(i)) ++j;
    const float d = float(i) - float(top[size_t(j)]);
    f[i * stride] = d * d + g[size_t(top[size_t(j)])];
  }
}

/// Marks what is reached from `seeds` through nodes that may be entered.
void flood(const Size& n, const std::vector<uint8_t>& may, std::vector<size_t> seeds, std::vector<uint8_t>& reached) {
  while (!seeds.empty()) {
    const size_t i = seeds.back();
    seeds.pop_back();
    neighbours(n, i, [&](size_t j) {
      if (may[j] && !reached[j]) reached[j] = 1, seeds.push_back(j);
    });
  }
}

/// Keeps the 6-connected parts that have at least `share` of the nodes of the largest. Returns how many there were.
int largest_parts(const Size& n, std::vector<uint8_t>& set, double share, int64_t& kept, int64_t& dropped,
                  int& kept_parts) {
  const GridParts parts = parts_of(n, set);
  const std::vector<int64_t>& size = parts.nodes;
  kept = dropped = 0, kept_parts = 0;
  if (size.empty()) return 0;
  const size_t first = size_t(std::max_element(size.begin(), size.end()) - size.begin());
  const auto keep = [&](size_t part) {
    return part == first || (share < 1 && double(size[part]) >= share * double(size[first]));
  };
  for (size_t part = 0; part < size.size(); ++part)
    if (keep(part))
      kept += size[part], ++kept_parts;
    else
      dropped += size[part];
  for (size_t i = 0; i < set.size(); ++i) set[i] = set[i] && keep(size_t(parts.of[i]));
  return int(size.size());
}

/// Closes the object where it leaves the volume: what a disc does not reach in the outermost slice goes on outside, for
/// `layers` nodes, so that the sealed surface leaves the volume as the object does.
void add_lids(const Size& n, const Size& first, const Size& last, double radius, int32_t layers,
              std::vector<uint8_t>& set, Workers& workers) {
  const size_t stride[3] = {1, size_t(n[0]), size_t(n[0]) * size_t(n[1])};
  std::vector<size_t> lid;
  for (int k = 0; k < 3; ++k)
    for (int s : {-1, 1}) {
      const int a = (k + 1) % 3, b = (k + 2) % 3;
      const int32_t slice = s < 0 ? first[size_t(k)] : last[size_t(k)];
      const Size flat{n[size_t(a)], n[size_t(b)], 1};
      std::vector<uint8_t> in(nodes(flat), 0);
      bool any = false;
      const auto at = [&](int32_t i, int32_t j) { return size_t(i) * stride[a] + size_t(j) * stride[b]; };
      for (int32_t j = 0; j < flat[1]; ++j)
        for (int32_t i = 0; i < flat[0]; ++i)
          any |= in[size_t(i) + size_t(flat[0]) * size_t(j)] = set[at(i, j) + size_t(slice) * stride[k]];
      if (!any) continue;
      const Reach r = reach(flat, in, radius, workers);
      for (int32_t j = first[size_t(b)]; j <= last[size_t(b)]; ++j)
        for (int32_t i = first[size_t(a)]; i <= last[size_t(a)]; ++i)
          if (!r.air(size_t(i) + size_t(flat[0]) * size_t(j)))
            for (int32_t l = 1; l <= layers; ++l) lid.push_back(at(i, j) + size_t(slice + s * l) * stride[k]);
    }
  for (size_t i : lid) set[i] = 1;  // (after all six: a lid is no ground for another)
}

}  // namespace

namespace imaging {

Reach reach(const GridSize& n, const std::vector<uint8_t>& set, double radius, Workers& workers) {
  Reach r;
  r.radius = radius;
  r.to_set = squared_distance(n, set, workers);
  std::vector<uint8_t> may(set.size());
  const double least = radius > 0 ? (radius + 0.5) * (radius + 0.5) : 0.5;
  for (size_t i = 0; i < may.size(); ++i) may[i] = double(r.to_set[i]) >= least;
  r.centre.assign(set.size(), 0);
  if (!may.empty() && may[0]) r.centre[0] = 1, flood(n, may, {0}, r.centre);
  r.to_centres = squared_distance(n, r.centre, workers);
  return r;
}

}  // namespace imaging

std::vector<float> squared_distance(const Size& n, const std::vector<uint8_t>& set, Workers& workers) {
  std::vector<float> d(set.size());
  for (size_t i = 0; i < d.size(); ++i) d[i] = set[i] ? 0 : kFar;
  for (int axis = 0; axis < 3; ++axis)
    lines(n, axis, workers, [&](size_t first, size_t stride, size_t length) {
      thread_local std::vector<float> g, from;
      thread_local std::vector<int32_t> top;
      envelope(d.data() + first, stride, length, g, top, from);
    });
  return d;
}

Volume smoothed(const Volume& v, double sigma, Workers& workers) {
  Volume out = v;
  if (sigma <= 0) return out;
  const int reach = std::max(1, int(std::ceil(3 * sigma)));
  std::vector<float> w(size_t(reach) + 1);
  float sum = 0;
  for (int i = 0; i <= reach; ++i)
    w[size_t(i)] = float(elementary::exp(-0.5 * i * i / (sigma * sigma))), sum += (i ? 2 : 1) * w[size_t(i)];
  for (float& x : w) x /= sum;
  for (int axis = 0; axis < 3; ++axis)
    lines(v.size, axis, workers, [&](size_t first, size_t stride, size_t length) {
      thread_local std::vector<float> g;
      g.resize(length);
      float* f = out.value.data() + first;
      for (size_t i = 0; i < length; ++i) g[i] = f[i * stride];
      const int n = int(length);
      for (int i = 0; i < n; ++i) {
        float s = w[0] * g[size_t(i)];
        for (int k = 1; k <= reach; ++k)
          s += w[size_t(k)] * (g[size_t(std::max(0, i - k))] + g[size_t(std::min(n - 1, i + k))]);
        f[size_t(i) * stride] = s;
      }
    });
  return out;
}

Prepared prepare(const Volume& v, const PrepareSettings& s, Workers& workers) {
  if (!std::isfinite(s.iso)) throw InputError("", 0, "the isovalue must be a finite number");
  if (!(s.sigma_voxels >= 0 && s.sigma_voxels <= 10))
    throw InputError("", 0, "the standard deviation of the smoothing must be 0 to 10 voxels");
  if (!(s.seal_mm >= 0 && s.seal_mm <= 100))
    throw InputError("", 0, "the ball that seals openings must have a radius of 0 to 100 mm");
  if (!(s.mouth_mm >= 0 && s.mouth_mm <= 100))
    throw InputError("", 0, "the ball that finds the mouths of cavities must have a radius of 0 to 100 mm");
  if (s.thin && !(*s.thin < s.iso && s.thin_mm > 0 && s.thin_mm <= 100))
    throw InputError("", 0, "crests of thin walls must lie below the isovalue and at most 100 mm from the object");
  if (!(s.least_part > 0 && s.least_part <= 1))
    throw InputError("", 0, "the share of the parts that are kept must be above 0 and at most 1");
  if (v.value.empty()) throw InputError("", 0, "the volume is empty");
  Prepared p;
  p.iso = s.iso, p.seal_mm = s.seal_mm, p.mouth_mm = s.mouth_mm > s.seal_mm ? s.mouth_mm : 0;
  p.volume = smoothed(v, s.sigma_voxels, workers);
  double longest = 0;
  Vec3 side;
  for (int k = 0; k < 3; ++k)
    side[k] = v.step_mm.col(k).norm(), longest = std::max(longest, side[k] * v.size[size_t(k)]);
  p.voxel_mm = side.minCoeff();
  // An even grid along the voxel axes (made orthogonal, which they nearly always are), around the whole volume.
  const auto [Q, lo, hi] = voxel_box(v);
  const Vec3 span = (hi - lo).cwiseMax(p.voxel_mm);
  const bool mouths = s.mouth_mm > s.seal_mm;
  const double beyond = kBeyondBorder * side.maxCoeff(), widest = std::max(beyond, mouths ? s.mouth_mm : s.seal_mm);
  const auto count = [&](double h) {
    const double pad = 2 * (std::ceil(widest / h) + 4);
    return (span.x() / h + pad) * (span.y() / h + pad) * (span.z() / h + pad);
  };
  double h = p.voxel_mm;
  while (count(h) > double(s.guide_nodes)) h *= 1.1;
  p.guide_mm = h;
  const double r = s.seal_mm / h;  // in steps
  const int32_t pad = int32_t(std::ceil(widest / h)) + 4;
  Size n, first, last;
  for (size_t k = 0; k < 3; ++k) {
    const int32_t inner = int32_t(std::floor(span[int(k)] / h + 1e-9)) + 1;
    first[k] = pad, last[k] = pad + inner - 1, n[k] = inner + 2 * pad;
  }
  p.guide.size = n, p.guide.step_mm = h * Q, p.guide.origin_mm = Q * (lo - Vec3::Constant(pad * h));
  const VolumeSampler sampler(p.volume);
  std::vector<uint8_t> set(nodes(n), 0);
  workers.parallel_for(size_t(n[2]), 1, [&](size_t k0, size_t k1) {
    for (int32_t k = std::max(first[2], int32_t(k0)); k < std::min(last[2] + 1, int32_t(k1)); ++k)
      for (int32_t j = first[1]; j <= last[1]; ++j)
        for (int32_t i = first[0]; i <= last[0]; ++i)
          set[p.guide.index(i, j, k)] = sampler.value(p.guide.place(Vec3(i, j, k))) >= s.iso;
  });
  p.parts = largest_parts(n, set, s.least_part, p.object_nodes, p.dropped_nodes, p.kept_parts);
  if (p.parts == 0) {
    const auto [a, b] = std::minmax_element(p.volume.value.begin(), p.volume.value.end());
    throw InputError("", 0,
                     "nothing in the volume is above the isovalue " + std::to_string(s.iso) + ": its numbers are " +
                         std::to_string(*a) + " to " + std::to_string(*b) +
                         "; expected an isovalue between them (--iso, --offset)");
  }
  if (p.object_nodes == int64_t(last[0] - first[0] + 1) * (last[1] - first[1] + 1) * (last[2] - first[2] + 1))
    throw InputError("", 0,
                     "the whole volume is above the isovalue " + std::to_string(s.iso) +
                         "; expected air around the object (--iso, --offset)");
  p.low_mm = Vec3::Constant(1e300), p.high_mm = -p.low_mm;
  for (int32_t k = first[2]; k <= last[2]; ++k)
    for (int32_t j = first[1]; j <= last[1]; ++j)
      for (int32_t i = first[0]; i <= last[0]; ++i)
        if (set[p.guide.index(i, j, k)]) {
          const Vec3 x = p.guide.place(Vec3(i, j, k));
          p.low_mm = p.low_mm.cwiseMin(x), p.high_mm = p.high_mm.cwiseMax(x);
        }
  add_lids(n, first, last, mouths ? s.mouth_mm / h : r, int32_t(std::ceil(beyond / h)), set, workers);
  std::vector<size_t> wall;
  std::vector<uint8_t> within(set.size(), 0);  // the volume's own nodes
  for (int32_t k = first[2]; k <= last[2]; ++k)
    for (int32_t j = first[1]; j <= last[1]; ++j)
      std::fill_n(within.begin() + std::ptrdiff_t(p.guide.index(first[0], j, k)), last[0] - first[0] + 1, uint8_t(1));
  if (s.thin && mouths) {
    Volume even = p.guide;  // not smoothed: that takes more off a thin wall than off anything else
    even.value.resize(set.size());
    const VolumeSampler raw(v);
    workers.parallel_for(size_t(n[2]), 1, [&](size_t k0, size_t k1) {
      for (int32_t k = int32_t(k0); k < int32_t(k1); ++k)
        for (int32_t j = 0; j < n[1]; ++j)
          for (int32_t i = 0; i < n[0]; ++i)
            even.value[even.index(i, j, k)] = float(raw.value(even.place(Vec3(i, j, k))));
    });
    WallRule rule;
    rule.above = *s.thin, rule.blur = kBlur * side.maxCoeff() / h, rule.across = s.thin_mm / h;
    rule.air = *s.thin - kAirLevel * (s.iso - *s.thin), rule.beside = side.maxCoeff() / h;
    // Not in the open: what lies deep in the way of a ball that does not pass through the widest gap (vessels,
    // cartilage) closes nothing.
    const Reach open = reach(n, set, s.thin_mm / h, workers);
    const double shallow = open.radius - kShallow * side.maxCoeff() / h;
    std::vector<uint8_t> may = within;
    for (size_t i = 0; i < may.size(); ++i)
      may[i] = may[i] && double(open.to_centres[i]) >= shallow * std::abs(shallow);
    wall = thin_walls(even, set, may, rule, workers);
    for (const size_t i : wall) set[i] = 1;
  }
  Reach narrow = reach(n, set, r, workers);
  if (mouths) {
    MouthRule rule;
    if (s.thin) rule.depth_width = kDeepWithWalls;
    rule.threshold = s.mouth_depth_mm / h, rule.least_width = s.mouth_width_mm / h,
    rule.most_width = 2.5 * s.mouth_mm / h;
    std::vector<uint8_t> fill;
    for (const GridMouth& g :
         find_mouths(n, set, within, reach(n, set, (s.thin ? kWayWithWalls : 1. / 3) * s.mouth_width_mm / h, workers),
                     reach(n, set, s.mouth_mm / h, workers), rule, fill, workers))
      p.mouth.push_back({p.guide.place(g.centre), h * g.width, h * g.depth});
    bool any = false;
    // The walls have said where the mouths are; over what is left of their gaps the sealing ball spans.
    for (const size_t i : wall) set[i] = 0;
    for (size_t i = 0; i < set.size(); ++i)
      if (fill[i]) set[i] = 1, any = true;
    if (any || !wall.empty()) narrow = reach(n, set, r, workers);
    if (any) {
      for (uint8_t& f : fill) f = f == 2;
      const std::vector<float> to_fill = squared_distance(n, fill, workers);
      p.gate.resize(set.size());
      for (size_t i = 0; i < set.size(); ++i) p.gate[i] = double(to_fill[i]) <= kGate * kGate;
    }
  }
  p.guide.value.resize(set.size());
  // Nodes lie half a step beside the surface on either side of it, on average.
  for (size_t i = 0; i < set.size(); ++i)
    p.guide.value[i] = float(h * (narrow.centre[i] ? std::sqrt(double(narrow.to_set[i])) - 0.5
                                                   : r + 0.5 - std::sqrt(double(narrow.to_centres[i]))));
  for (const size_t i : wall) {
    const auto at = node_at(n, i);
    const Vec3 x = p.guide.place(Vec3(at[0], at[1], at[2]));
    if (std::abs(p.guide.value[i]) <= h) p.wall_mm.push_back(x);
  }
  // Places of the isosurface on the edges between voxels, where it is the sealed surface.
  const VolumeSampler guide(p.guide);
  for (int32_t k = 0; k < v.size[2]; ++k)
    for (int32_t j = 0; j < v.size[1]; ++j)
      for (int32_t i = 0; i < v.size[0]; ++i) {
        const double a = p.volume.value[v.index(i, j, k)] - s.iso;
        const int32_t up[3][3] = {{i + 1, j, k}, {i, j + 1, k}, {i, j, k + 1}};
        for (int e = 0; e < 3; ++e) {
          if (up[e][e] >= v.size[size_t(e)]) continue;
          const double b = p.volume.value[v.index(up[e][0], up[e][1], up[e][2])] - s.iso;
          if ((a >= 0) == (b >= 0)) continue;
          const Vec3 x = p.volume.place(Vec3(i, j, k) + a / (a - b) * Vec3::Unit(e));
          if (std::abs(guide.value(x)) <= h) p.surface_mm.push_back(x);
        }
      }
  return p;
}

}  // namespace limberg
