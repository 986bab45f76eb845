#include "sim/imaging/solid/bone_solid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/base/error.h"
#include "sim/geometry/point_tree.h"
#include "sim/imaging/fit/prepare.h"
#include "sim/imaging/fit/thin_walls.h"
#include "sim/imaging/solid/even_grid.h"
#include "sim/imaging/solid/wall_sheets.h"

namespace limberg {

namespace {

using namespace imaging;

constexpr int32_t kSolidPad = 4;     // nodes beyond the volume, so that bone is closed where the volume ends
constexpr double kBeyondHU = -1000;  // what lies beyond
constexpr double kLeastStep_mm = 0.8;
constexpr double kNearBand = 1.5;    // steps: so near the surface the distance is that of the values
constexpr double kLeastSlope = 0.1;  // of the cortical density over a mm: below it a value says little of a distance
constexpr double kDense = 0.95;      // cortical bone is this quantile of what is above the isovalue
constexpr double kMetalHU = 2000;    // above it is no bone
constexpr double kCrestBlur =
    0.5;  // of the longest side of a voxel: scale at which crests are looked for (prepare.cpp)
constexpr double kOpenLevel = 1.5, kShallowGap = 1.5;  // (prepare.cpp)
constexpr double kWallContrast = 0.2;                  // of the isovalue below cortical bone: less is no wall but noise
constexpr double kSheetStep = 1.1;                     // steps: no wall is drawn thinner, or the grid loses it
constexpr double kSteepestSolid = 3;                   // of the distance, a mm

struct SolidMaker {
  const Volume& v;
  const BoneSolidSettings& s;
  Workers& workers;
  BoneSolid out;
  EvenGrid g;
  double h = 1, longest = 0;
  std::vector<float> value, f;  // smoothed values, and the distance
  std::vector<uint8_t> bone;    // above the isovalue, in the body, in pieces that are kept

  BoneSolid run() {
    longest = longest_step_mm(v);
    g = even_grid(v, s.step_mm > 0 ? s.step_mm : std::max(kLeastStep_mm, shortest_step_mm(v)), kSolidPad, s.most_nodes);
    h = out.step_mm = g.step_mm;
    const Volume smooth = smoothed(v, s.sigma_voxels, workers);
    value = sampled(smooth, g, float(kBeyondHU), workers);
    find_bone();
    by_values();
    if (s.thin) add_walls();
    settle_cavities();
    finish();
    return std::move(out);
  }

  const GridSize& n() const { return g.nodes.size; }
  Vec3 place(size_t i) const {
    const auto at = node_at(n(), i);
    return g.nodes.place(Vec3(at[0], at[1], at[2]));
  }

  void find_bone() {
    std::vector<uint8_t> body(value.size());
    for (size_t i = 0; i < body.size(); ++i) body[i] = value[i] > s.body;
    const GridParts bodies = parts_of(n(), body);
    bone.assign(value.size(), 0);
    if (!bodies.nodes.empty()) {
      const auto largest = int32_t(std::max_element(bodies.nodes.begin(), bodies.nodes.end()) - bodies.nodes.begin());
      for (size_t i = 0; i < bone.size(); ++i) bone[i] = value[i] >= s.iso && bodies.of[i] == largest;
    }
    const GridParts pieces = parts_of(n(), bone);
    const double node = h * h * h;
    for (const int64_t c : pieces.nodes)
      if (double(c) * node >= s.least_part_mm3)
        ++out.pieces;
      else
        ++out.dropped, out.dropped_mm3 += double(c) * node;
    if (out.pieces == 0) {
      const auto [a, b] = std::minmax_element(v.value.begin(), v.value.end());
      throw InputError("", 0,
                       "no bone: nothing larger than " + std::to_string(int64_t(s.least_part_mm3)) +
                           " mm3 in the volume is above the isovalue " + std::to_string(s.iso) + "; its numbers are " +
                           std::to_string(*a) + " to " + std::to_string(*b));
    }
    std::vector<float> dense;
    for (size_t i = 0; i < bone.size(); ++i) {
      if (!bone[i]) continue;
      bone[i] = double(pieces.nodes[size_t(pieces.of[i])]) * node >= s.least_part_mm3;
      if (bone[i] && double(value[i]) < kMetalHU) dense.push_back(value[i]);
    }
    const auto at = dense.begin() + std::ptrdiff_t(kDense * double(dense.size() - 1));
    std::nth_element(dense.begin(), at, dense.end());
    out.cortical = double(*at);
  }

  /// f = (iso - I) / |grad I|, no farther than the band; > 0 where no bone is kept.
  void by_values() {
    const size_t stride[3] = {1, size_t(n()[0]), size_t(n()[0]) * size_t(n()[1])};
    const double least = kLeastSlope * (out.cortical - s.iso);
    std::vector<float> slope(value.size(), 0);
    workers.parallel_for(value.size(), 65536, [&](size_t b, size_t e) {
      for (size_t i = b; i < e; ++i) {
        const auto at = node_at(n(), i);
        double sum = 0;
        for (size_t k = 0; k < 3; ++k) {
          const double up = at[k] + 1 < n()[k] ? value[i + stride[k]] : value[i],
                       down = at[k] > 0 ? value[i - stride[k]] : value[i];
          sum += (up - down) * (up - down);
        }
        slope[i] = float(std::sqrt(sum) / (2 * h));
      }
    });
    f.assign(value.size(), float(kNearBand * h));
    workers.parallel_for(value.size(), 65536, [&](size_t b, size_t e) {
      for (size_t i = b; i < e; ++i) {
        const double over = double(value[i]) - s.iso;
        double steepest = std::max(least, double(slope[i]));
        all_around(n(), i, [&](size_t j, int) { steepest = std::max(steepest, double(slope[j])); });
        const double d = std::clamp(-over / steepest, -kNearBand * h, kNearBand * h);
        f[i] = float(bone[i] ? std::min(d, -1e-3 * h) : over >= 0 ? 0.5 * h : std::max(d, 1e-3 * h));
      }
    });
  }

  void add_walls() {
    Volume raw = g.nodes;  // not smoothed: that takes more off a thin wall than off anything else
    raw.value = sampled(v, g, float(kBeyondHU), workers);
    WallRule rule;
    rule.above = *s.thin, rule.blur = kCrestBlur * longest / h, rule.across = s.thin_across_mm / h;
    rule.air = *s.thin - kOpenLevel * (s.iso - *s.thin), rule.beside = longest / h;
    const Reach open = reach(n(), bone, s.thin_across_mm / h, workers);
    const double shallow = open.radius - kShallowGap * longest / h;
    std::vector<uint8_t> may(value.size());
    for (size_t i = 0; i < may.size(); ++i)
      may[i] = g.within(node_at(n(), i)) && double(open.to_centres[i]) >= shallow * std::abs(shallow);
    const std::vector<size_t> crest = thin_walls(raw, bone, may, rule, workers);
    const Volume blurred = smoothed(raw, rule.blur, workers);
    const VolumeSampler sampler(v);
    const Mat3 turn = g.nodes.step_mm / h;
    std::vector<WallSheet> sheet(crest.size());
    workers.parallel_for(crest.size(), 256, [&](size_t b, size_t e) {
      for (size_t c = b; c < e; ++c) {
        Vec3 across;
        if (crest_passes(blurred, crest[c], across))
          sheet[c] = wall_sheet(sampler, place(crest[c]), turn * across, 1.5 * longest, out.cortical);
      }
    });
    const double contrast = kWallContrast * (out.cortical - s.iso);
    std::erase_if(sheet, [&](const WallSheet& w) { return !(w.thickness_mm > 0 && w.contrast >= contrast); });
    if (sheet.empty()) return;
    std::vector<double> thickness;
    std::vector<Vec3> middle;
    for (WallSheet& w : sheet) {
      thickness.push_back(w.thickness_mm), middle.push_back(w.middle_mm);
      if (w.thickness_mm < kSheetStep * h)
        w.thickness_mm = kSheetStep * h, out.drawn_thicker += 1. / double(sheet.size());
    }
    std::nth_element(thickness.begin(), thickness.begin() + std::ptrdiff_t(thickness.size() / 2), thickness.end());
    out.thin_median_mm = thickness[thickness.size() / 2], out.as_mm = kSheetStep * h;
    out.thin_mm2 = double(sheet.size()) * h * h;
    // A node near a wall has the distance to the slab of its nearest sheet, rounded where the sheet ends.
    const PointTree tree(middle);
    std::vector<uint8_t> seed(value.size(), 0);
    for (const size_t i : crest) seed[i] = 1;
    const std::vector<float> far = squared_distance(n(), seed, workers);
    workers.parallel_for(value.size(), 4096, [&](size_t b, size_t e) {
      for (size_t i = b; i < e; ++i) {
        if (double(far[i]) > 9) continue;
        const Vec3 x = place(i);
        const auto near = tree.nearest(x, 4 * h);
        if (near.index < 0) continue;
        const WallSheet& w = sheet[size_t(near.index)];
        const double over = w.normal.dot(x - w.middle_mm), off = std::abs(over) - 0.5 * w.thickness_mm,
                     along = (x - w.middle_mm - over * w.normal).norm() - h;
        const double d = along <= 0 ? off : std::sqrt(along * along + std::max(0., off) * std::max(0., off));
        f[i] = std::min(f[i], float(std::clamp(d, -kNearBand * h, kNearBand * h)));
      }
    });
  }

  void settle_cavities() {
    std::vector<uint8_t> solid(value.size()), hollow(value.size());
    for (size_t i = 0; i < solid.size(); ++i) solid[i] = f[i] < 0, hollow[i] = !solid[i];
    const GridParts parts = parts_of(n(), hollow);
    if (parts.nodes.size() < 2) return;
    const std::vector<float> to_solid = squared_distance(n(), solid, workers);
    const int32_t outside = parts.of[0];
    std::vector<double> widest(parts.nodes.size(), 0);
    std::vector<Vec3> centre(parts.nodes.size(), Vec3::Zero());
    for (size_t i = 0; i < hollow.size(); ++i)
      if (const int32_t p = parts.of[i]; p >= 0 && p != outside) {
        widest[size_t(p)] = std::max(widest[size_t(p)], h * std::sqrt(double(to_solid[i])));
        centre[size_t(p)] += place(i) / double(parts.nodes[size_t(p)]);
      }
    const double node = h * h * h;
    std::vector<uint8_t> kept(parts.nodes.size(), 0);
    for (size_t p = 0; p < kept.size(); ++p) {
      if (int32_t(p) == outside) continue;
      const double volume = double(parts.nodes[p]) * node;
      kept[p] = volume >= s.least_cavity_mm3 && widest[p] >= s.narrow_mm;
      if (kept[p])
        out.cavity.push_back({centre[p], volume, 2 * widest[p]});
      else
        out.filled_mm3 += volume;
    }
    for (size_t i = 0; i < hollow.size(); ++i)
      if (const int32_t p = parts.of[i]; p >= 0 && p != outside && !kept[size_t(p)]) f[i] = float(-kNearBand * h);
    std::sort(out.cavity.begin(), out.cavity.end(),
              [](const BoneCavity& a, const BoneCavity& b) { return a.volume_mm3 > b.volume_mm3; });
    std::vector<uint8_t> opened(kept.size(), 0);
    opened[size_t(outside)] = 1;
    for (size_t round = 0; round < kept.size(); ++round) {  // from the outermost inwards: one opens into another
      int32_t next = -1;
      std::vector<size_t> way;
      for (size_t p = 0; p < kept.size(); ++p) {
        if (!kept[p] || opened[p]) continue;
        std::vector<size_t> found = way_out(parts, int32_t(p), opened);
        if (!found.empty() && (next < 0 || found.size() < way.size())) next = int32_t(p), way = std::move(found);
      }
      if (next < 0) break;
      drill(place(way.front()), place(way.back()));
      opened[size_t(next)] = 1;
    }
  }

  /// Nodes from a cavity to the nearest one of what is open, by steps along the axes.
  std::vector<size_t> way_out(const GridParts& parts, int32_t from, const std::vector<uint8_t>& opened) const {
    std::vector<size_t> ring, next;
    std::vector<std::pair<size_t, size_t>> came;  // node, from
    std::vector<uint8_t> seen(value.size(), 0);
    for (size_t i = 0; i < value.size(); ++i)
      if (parts.of[i] == from) seen[i] = 1, ring.push_back(i);
    while (!ring.empty()) {
      next.clear();
      for (const size_t i : ring) {
        size_t end = SIZE_MAX;
        neighbours(n(), i, [&](size_t j) {
          if (seen[j]) return;
          seen[j] = 1, came.push_back({j, i});
          if (parts.of[j] >= 0 && opened[size_t(parts.of[j])] && end == SIZE_MAX) end = j;
          next.push_back(j);
        });
        if (end != SIZE_MAX) {
          std::vector<size_t> way{end};
          for (size_t k = came.size(); k-- > 0;)
            if (came[k].first == way.back()) way.push_back(came[k].second);
          return way;
        }
      }
      ring.swap(next);
    }
    return {};
  }

  void drill(const Vec3& from, const Vec3& to) {
    const double radius = std::max(0.5 * s.passage_mm, 1.2 * h);
    const Vec3 along = to - from;
    const double length = along.norm();
    const Vec3 u = length > 0 ? Vec3(along / length) : Vec3(Vec3::UnitZ());
    workers.parallel_for(value.size(), 65536, [&](size_t b, size_t e) {
      for (size_t i = b; i < e; ++i) {
        const Vec3 x = place(i) - from;
        const double t = std::clamp(u.dot(x), -0.5 * h, length + 0.5 * h), d = (x - t * u).norm();
        if (d < radius + kNearBand * h) f[i] = std::max(f[i], float(std::min(radius - d, kNearBand * h)));
      }
    });
  }

  /// Beyond the band the distance is that of the nodes.
  void finish() {
    std::vector<uint8_t> solid(value.size()), hollow(value.size());
    int64_t count = 0;
    for (size_t i = 0; i < solid.size(); ++i) solid[i] = f[i] < 0, hollow[i] = !solid[i], count += solid[i];
    out.volume_cm3 = double(count) * h * h * h * 1e-3;
    const std::vector<float> to_solid = squared_distance(n(), solid, workers),
                             to_hollow = squared_distance(n(), hollow, workers);
    for (size_t i = 0; i < f.size(); ++i) {
      const double d = h * (solid[i] ? 0.5 - std::sqrt(double(to_hollow[i])) : std::sqrt(double(to_solid[i])) - 0.5);
      if (std::abs(d) > kNearBand * h) f[i] = float(d);
    }
    out.distance = std::move(g.nodes);
    out.distance.value = std::move(f), out.value = std::move(value);
  }
};

}  // namespace

BoneSolid bone_solid(const Volume& v, const BoneSolidSettings& s, Workers& workers) {
  if (!std::isfinite(s.iso) || !std::isfinite(s.body) || !(s.body < s.iso))
    throw InputError("", 0, "the isovalue of bone must be a number above that of the body");
  if (!(s.sigma_voxels >= 0 && s.sigma_voxels <= 10))
    throw InputError("", 0, "the standard deviation of the smoothing must be 0 to 10 voxels");
  if (s.thin && !(*s.thin < s.iso && s.thin_across_mm > 0 && s.thin_across_mm <= 100))
    throw InputError("", 0, "crests of thin walls must lie below the isovalue and at most 100 mm from bone");
  if (!(s.least_part_mm3 >= 0 && s.least_cavity_mm3 >= 0 && s.narrow_mm >= 0 && s.passage_mm > 0 && s.step_mm >= 0 &&
        s.most_nodes > 0))
    throw InputError("", 0, "sizes of parts, cavities and steps must not be negative");
  if (v.value.empty()) throw InputError("", 0, "the volume is empty");
  return SolidMaker{v, s, workers, {}, {}, 1, 0, {}, {}, {}}.run();
}

LevelSet surface_of(const BoneSolid& solid) {
  const Volume& d = solid.distance;
  LevelSet out;
  out.lipschitz = kSteepestSolid;
  out.low_mm = Vec3::Constant(1e300), out.high_mm = -out.low_mm;
  for (int c = 0; c < 8; ++c) {
    const Vec3 x = d.place(Vec3((c & 1) * (d.size[0] - 1), (c >> 1 & 1) * (d.size[1] - 1), (c >> 2) * (d.size[2] - 1)));
    out.low_mm = out.low_mm.cwiseMin(x), out.high_mm = out.high_mm.cwiseMax(x);
  }
  out.distance_mm = [sampler = VolumeSampler(d)](const Vec3& x) { return sampler.value(x); };
  return out;
}

}  // namespace limberg
