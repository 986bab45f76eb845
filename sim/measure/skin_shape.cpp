#include "sim/measure/skin_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "sim/geometry/bvh.h"
#include "sim/geometry/polyline.h"
#include "sim/geometry/triangle.h"
#include "sim/measure/attached.h"
#include "sim/measure/corners.h"
#include "sim/measure/skin_strain.h"

namespace limberg {
namespace {

// Skin triangles' edges (triangle, first corner) that a wall triangle has across.
std::vector<std::pair<size_t, size_t>> rim_edges(const SurfaceView& view) {
  std::vector<std::pair<int32_t, int32_t>> wall;  // directed
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (view.kind[t] == FaceKind::wall)
      for (size_t k = 0; k < 3; ++k) wall.push_back({view.tri[t][k], view.tri[t][(k + 1) % 3]});
  std::sort(wall.begin(), wall.end());
  std::vector<std::pair<size_t, size_t>> rim;
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (view.kind[t] == FaceKind::skin)
      for (size_t k = 0; k < 3; ++k)
        if (std::binary_search(wall.begin(), wall.end(), std::pair(view.tri[t][(k + 1) % 3], view.tri[t][k])))
          rim.push_back({t, k});
  return rim;
}

}  // namespace

std::vector<Vec3> rim_mm(const SurfaceView& view) {
  std::vector<Vec3> places;
  for (const auto& [t, k] : rim_edges(view)) {
    const auto X = corners_at_rest(view, t);
    places.push_back(0.5 * (X[k] + X[(k + 1) % 3]));
  }
  return places;
}

DogEar dog_ear(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin, std::span<const Vec3> centres_mm,
               double radius_mm) {
  DogEar d;
  const auto near = [&](const Vec3& X) {
    return centres_mm.empty() || std::any_of(centres_mm.begin(), centres_mm.end(),
                                             [&](const Vec3& c) { return (X - c).norm() <= radius_mm; });
  };
  std::vector<float> height(view.X_mm.size(), std::numeric_limits<float>::quiet_NaN());  // asked for once per vertex
  const auto height_at = [&](int32_t v) {
    float& h = height[size_t(v)];
    if (std::isnan(h)) h = float(-skin.depth_mm(x_mm[size_t(v)].cast<double>()));
    return double(h);
  };
  const std::vector<uint8_t> is_attached = attached(view);
  double area = 0, square = 0;
  bool any = false;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin || !is_attached[size_t(view.tri[t][0])]) continue;
    const auto X = corners_at_rest(view, t);
    if (!near((X[0] + X[1] + X[2]) / 3)) continue;
    const auto x = corners_now(view, x_mm, t);
    std::array<double, 3> h;
    for (size_t k = 0; k < 3; ++k) {
      h[k] = height_at(view.tri[t][k]);
      if (!any || h[k] > d.height_mm) {
        d.height_mm = h[k];
        d.at_mm = X[k];
        any = true;
      }
    }
    const Vec3 a = 0.5 * area_vector2(x[0], x[1], x[2]);
    const double mean = (h[0] + h[1] + h[2]) / 3;
    area += a.norm();
    square += a.norm() * mean * mean;
    if (std::max({h[0], h[1], h[2]}) <= 0) continue;
    const double projected = std::max(0.0, a.dot(skin.nearest((x[0] + x[1] + x[2]) / 3).normal));
    d.volume_mm3 += projected * (std::max(0.0, h[0]) + std::max(0.0, h[1]) + std::max(0.0, h[2])) / 3;
  }
  d.height_mm = std::max(0.0, d.height_mm);
  if (area > 0) d.rms_mm = std::sqrt(square / area);
  return d;
}

namespace {

/// Of the skin at rest, what has a corner in the box.
Bvh skin_within(const SurfaceView& view, const Vec3& low_mm, const Vec3& high_mm) {
  std::vector<Tri> tri;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    const Tri& c = view.tri[t];
    const auto inside = [&](int32_t v) {
      const Vec3& X = view.X_mm[size_t(v)];
      return (X.array() >= low_mm.array()).all() && (X.array() <= high_mm.array()).all();
    };
    if (view.kind[t] == FaceKind::skin && std::any_of(c.begin(), c.end(), inside)) tri.push_back(c);
  }
  return Bvh(view.X_mm.flat(), tri);
}

}  // namespace

WoundGape wound_gape(const SurfaceView& view, std::span<const Vec3f> x_mm) {
  constexpr double kOwn_mm = 3, kTouch_mm = 2, kCos = 0.5, kFar_mm = 100;
  constexpr double kBehind_mm = 3, kBehindCos = 0.05, kSame_mm = 0.1;  // at rest
  // The middle of a strip's width lies on its skin, but for its bend: that of a quarter circle is .2 of its chord off.
  constexpr double kStrip = 0.25;
  constexpr double kBefore_mm = 0.2;
  struct Rim {
    int32_t a, b;
    Vec3 p, q, out;  // now
    Vec3 up = Vec3::Zero();
    Vec3 rest_middle = Vec3::Zero(), rest_out = Vec3::Zero();
    double length = 0;   // at rest
    int32_t piece = -1;  // of one that nothing holds
    int32_t loop = -1;
    double s = 0;  // arc length at rest of its middle along the loop
  };
  UnionFind pieces = pieces_of(view);
  const std::vector<uint8_t> is_attached = attached(view);
  std::vector<Rim> rim;
  for (const auto& [t, k] : rim_edges(view)) {
    const int32_t a = view.tri[t][k], b = view.tri[t][(k + 1) % 3];
    const auto x = corners_now(view, x_mm, t);
    Rim r{a, b, x[k], x[(k + 1) % 3], Vec3::Zero()};
    const Vec3 n = area_vector2(x[0], x[1], x[2]);
    if (n.norm() > 0) r.up = n.normalized();
    if (n.norm() > 0 && (r.q - r.p).norm() > 0) r.out = (r.q - r.p).cross(n).normalized();
    const auto X = corners_at_rest(view, t);
    const Vec3 N = area_vector2(X[0], X[1], X[2]), E = X[(k + 1) % 3] - X[k];
    r.rest_middle = X[k] + 0.5 * E, r.length = E.norm();
    if (!is_attached[size_t(a)]) r.piece = int32_t(pieces.find(a));
    if (N.norm() > 0 && E.norm() > 0) r.rest_out = E.cross(N).normalized();
    rim.push_back(r);
  }
  // Loops: each rim edge is followed by one that starts where it ends.
  std::sort(rim.begin(), rim.end(),
            [](const Rim& p, const Rim& q) { return std::pair(p.a, p.b) < std::pair(q.a, q.b); });
  std::vector<int32_t> ends;
  for (const Rim& r : rim) ends.push_back(r.b);
  std::sort(ends.begin(), ends.end());
  std::vector<size_t> starts;  // open chains from their beginning, then closed loops from anywhere
  for (bool open : {true, false})
    for (size_t i = 0; i < rim.size(); ++i)
      if (std::binary_search(ends.begin(), ends.end(), rim[i].a) != open) starts.push_back(i);
  std::vector<double> loop_length;
  for (size_t i : starts) {
    if (rim[i].loop >= 0) continue;
    double s = 0;
    for (size_t j = i; rim[j].loop < 0;) {
      rim[j].loop = int32_t(loop_length.size());
      rim[j].s = s + 0.5 * rim[j].length;
      s += rim[j].length;
      auto next = std::lower_bound(rim.begin(), rim.end(), rim[j].b, [](const Rim& r, int32_t v) { return r.a < v; });
      while (next != rim.end() && next->a == rim[j].b && next->loop >= 0) ++next;
      if (next == rim.end() || next->a != rim[j].b) break;
      j = size_t(next - rim.begin());
    }
    loop_length.push_back(s);
  }

  std::optional<Bvh> skin_at_rest;
  const auto skin_near = [&](const Vec3& X, double within_mm) {
    if (!skin_at_rest) {
      Vec3 low = Vec3::Constant(INFINITY), high = -low;
      for (const Rim& r : rim) low = low.cwiseMin(r.rest_middle), high = high.cwiseMax(r.rest_middle);
      const Vec3 around = Vec3::Constant(2 * kBehind_mm);
      skin_at_rest.emplace(skin_within(view, low - around, high + around));
    }
    return skin_at_rest->closest(X, within_mm).triangle >= 0;
  };
  WoundGape g;
  std::vector<std::pair<double, double>> gapes, steps;
  std::vector<std::pair<double, Vec3>> at;
  Vec3 lost_at = Vec3::Zero();
  double sum = 0;
  const auto look = [&](const Rim& r) {  // gape and step
    const Vec3 m = 0.5 * (r.p + r.q);
    double best = kFar_mm, step = 0;
    for (const Rim& o : rim) {
      if (r.piece >= 0 && o.piece == r.piece) continue;
      if ((0.5 * (o.p + o.q) - m).norm() - 0.5 * (o.q - o.p).norm() > best) continue;
      const Vec3 D = o.rest_middle - r.rest_middle;
      // Round the end of a cut the other bank is near along the edge. A crumpled triangle there may turn its edge any
      // way: what lay before this edge at rest, and looked at it, is still the other bank.
      const bool faced =
          o.rest_out.dot(r.rest_out) < 0 && D.dot(r.rest_out) > -kSame_mm && D.dot(o.rest_out) < kSame_mm;
      if (o.loop == r.loop && o.out.dot(r.out) >= 0 && !faced) {
        const double along = std::abs(o.s - r.s);
        if (std::min(along, loop_length[size_t(r.loop)] - along) < kOwn_mm) continue;  // the same bank
      }
      // The other side of a flap's tip, or of a narrow strip, is no bank: at rest it lies behind one's back, with skin
      // between. (What lies there beyond a slit, as the other lip does at the mouth's corner, is one.)
      if (D.norm() < kBehind_mm && -D.dot(r.rest_out) > std::max(kSame_mm, kBehindCos * D.norm()) &&
          skin_near(0.5 * (r.rest_middle + o.rest_middle), kStrip * D.norm()))
        continue;
      const Vec3 e = o.q - o.p;
      const double ee = e.squaredNorm(), t = ee > 0 ? std::clamp((m - o.p).dot(e) / ee, 0.0, 1.0) : 0;
      const Vec3 d = o.p + t * e - m;
      const double distance = d.norm();
      if (distance < best && (distance < kTouch_mm || d.dot(r.out) >= kCos * distance))
        best = distance, step = std::abs(d.dot(r.up));
    }
    return std::pair(best, step);
  };
  // Over or under skin: some lies before the edge, above or below it, and the edge of that is near, on whatever side.
  const auto lies_over = [&](const Rim& r) {
    const Vec3 m = 0.5 * (r.p + r.q), before = m + kBefore_mm * r.out;
    const bool near = std::any_of(rim.begin(), rim.end(), [&](const Rim& o) {
      const Vec3 D = o.rest_middle - r.rest_middle;  // the other side of a tip is no other edge
      return o.out.dot(r.out) < 0 && (D.norm() > kOver_mm || D.dot(r.rest_out) > -kSame_mm) &&
             (0.5 * (o.p + o.q) - m).norm() - 0.5 * (o.q - o.p).norm() < kOver_mm;
    });
    if (!near) return false;
    for (size_t t = 0; t < view.tri.size(); ++t) {
      if (view.kind[t] != FaceKind::skin) continue;
      const auto x = corners_now(view, x_mm, t);
      const Vec3 n = area_vector2(x[0], x[1], x[2]);
      const double rise = n.dot(r.up);
      if (!(rise > 0.5 * n.norm())) continue;  // looks another way
      const double way = n.dot(x[0] - before) / rise;
      if (std::abs(way) > kTouch_mm) continue;
      const Vec3 foot = before + way * r.up;
      bool inside = true;
      for (size_t k = 0; k < 3; ++k) inside = inside && n.dot((x[(k + 1) % 3] - x[k]).cross(foot - x[k])) >= 0;
      if (inside) return true;
    }
    return false;
  };
  std::vector<std::pair<double, double>> looks;
  for (const Rim& r : rim) looks.push_back(look(r));
  // A short stretch of edge between edges that are apposed looks wherever a crumpled triangle turns it. What its
  // neighbours look at is no farther from it than from them and the way to them.
  constexpr double kStretch_mm = 1;
  std::vector<size_t> along(rim.size());
  std::iota(along.begin(), along.end(), size_t(0));
  std::sort(along.begin(), along.end(),
            [&](size_t i, size_t j) { return std::pair(rim[i].loop, rim[i].s) < std::pair(rim[j].loop, rim[j].s); });
  const auto apposed = [&](size_t k) { return looks[along[k]].first <= kOpen_mm; };
  std::vector<double> known(rim.size(), kFar_mm);
  for (size_t k = 0; k < along.size(); ++k) {
    if (apposed(k)) continue;
    size_t end = k;
    double length = 0;
    for (; end < along.size() && rim[along[end]].loop == rim[along[k]].loop && !apposed(end); ++end)
      length += rim[along[end]].length;
    const bool between = k > 0 && rim[along[k - 1]].loop == rim[along[k]].loop && end < along.size() &&
                         rim[along[end]].loop == rim[along[k]].loop;
    for (size_t i = k; between && length <= kStretch_mm && i < end; ++i)
      for (const size_t j : {along[k - 1], along[end]}) {
        const Rim &r = rim[along[i]], &o = rim[j];
        known[along[i]] = std::min(known[along[i]], looks[j].first + 0.5 * (o.p + o.q - r.p - r.q).norm());
      }
    k = end - 1;
  }
  for (size_t i = 0; i < rim.size(); ++i) looks[i].first = std::min(looks[i].first, known[i]);
  // A piece that nothing holds, and that lies at no other, was taken out: it may lie anywhere.
  std::map<int32_t, double> nearest;
  for (size_t i = 0; i < rim.size(); ++i) {
    double& n = nearest.try_emplace(rim[i].piece, kFar_mm).first->second;
    n = std::min(n, looks[i].first);
  }
  for (size_t i = 0; i < rim.size(); ++i) {
    const Rim& r = rim[i];
    auto [best, step] = looks[i];
    if (r.piece >= 0 && nearest[r.piece] > kOpen_mm) continue;
    const Vec3 middle = 0.5 * (view.X_mm[size_t(r.a)] + view.X_mm[size_t(r.b)]);
    if (best > kOpen_mm && lies_over(r)) best = 0, g.over_mm += r.length, g.over_at_mm = middle;
    if (best >= kFar_mm) g.lost_mm += r.length, lost_at = middle;
    if (best > kOpen_mm) g.open_mm += r.length;
    if (best < kFar_mm && best > g.widest_mm) g.widest_mm = best, g.widest_at_mm = middle;
    gapes.push_back({best, r.length});
    at.push_back({gapes.back().first, middle});
    steps.push_back({step, r.length});
    g.step_mean_mm += step * r.length;
    g.rim_now_mm += (r.q - r.p).norm();
    g.rim_length_mm += r.length;
  }
  // What looks at no other edge is as far from it as the widest place, at least.
  for (size_t i = 0; i < gapes.size(); ++i) {
    if (gapes[i].first >= kFar_mm) gapes[i].first = at[i].first = g.widest_mm;
    sum += gapes[i].first * gapes[i].second;
  }
  if (g.rim_length_mm > 0) g.mean_mm = sum / g.rim_length_mm, g.step_mean_mm /= g.rim_length_mm;
  g.step_mm = weighted_percentile(steps, 0.95);
  std::sort(gapes.begin(), gapes.end());
  double passed = 0;
  for (const auto& [v, w] : gapes) {
    g.gape_mm = v;
    if ((passed += w) >= 0.95 * g.rim_length_mm) break;
  }
  for (const auto& [v, X] : at)
    if (v == g.gape_mm) g.gape_at_mm = X;
  if (g.widest_mm == 0) g.widest_at_mm = lost_at;
  return g;
}

TurnedSkin turned_skin(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin) {
  constexpr double kTurned = -0.5, kSame = 0.5;  // cos 120 and 60 degrees
  TurnedSkin out;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    const auto x = corners_now(view, x_mm, t);
    const Vec3 n = area_vector2(x[0], x[1], x[2]);
    if (!(n.norm() > 0)) continue;
    const auto X = corners_at_rest(view, t);
    const Vec3 before = area_vector2(X[0], X[1], X[2]);
    if (n.dot(before) > kSame * n.norm() * before.norm()) continue;
    if (n.normalized().dot(skin.nearest((x[0] + x[1] + x[2]) / 3).normal) >= kTurned) continue;
    const double area = 0.5 * before.norm();
    out.area_mm2 += area;
    out.at_mm += area * (X[0] + X[1] + X[2]) / 3;
  }
  if (out.area_mm2 > 0) out.at_mm /= out.area_mm2;
  return out;
}

double compression(const SurfaceView& view, std::span<const Vec3f> x_mm) {
  double before = 0, after = 0;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    const auto X = corners_at_rest(view, t), x = corners_now(view, x_mm, t);
    before += X[0].dot(X[1].cross(X[2]));
    after += x[0].dot(x[1].cross(x[2]));
  }
  return before != 0 ? after / before - 1 : 0;
}

double skin_area_mm2(const SurfaceView& view, std::span<const Vec3f> x_mm, const Body& body,
                     std::span<const ChartPoint> polygon) {
  if (polygon.size() < 3) return 0;
  double area = 0;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    const auto X = corners_at_rest(view, t);
    if (!inside_polygon(polygon, body.to_chart((X[0] + X[1] + X[2]) / 3))) continue;
    const auto x = corners_now(view, x_mm, t);
    area += 0.5 * area_vector2(x[0], x[1], x[2]).norm();
  }
  return area;
}

std::optional<Vec3> corner_position_mm(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin,
                                       const ChartPoint& p, const ChartPoint& towards) {
  constexpr double kReach_mm = 1, kSame_mm = 0.05;
  const auto hit = skin.at(p);
  if (!hit) return std::nullopt;
  const Vec2 wanted = (towards - p).normalized();
  double nearest = kReach_mm;
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (view.kind[t] == FaceKind::skin)
      for (int32_t v : view.tri[t]) nearest = std::min(nearest, (view.X_mm[size_t(v)] - hit->X_mm).norm());
  if (nearest >= kReach_mm) return std::nullopt;
  double best = -2;
  std::optional<Vec3> x;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    const auto X = corners_at_rest(view, t);
    const Vec2 centre = skin.body().to_chart((X[0] + X[1] + X[2]) / 3);
    for (size_t k = 0; k < 3; ++k) {
      if ((X[k] - hit->X_mm).norm() > nearest + kSame_mm) continue;
      const Vec2 d = centre - p;
      const double match = d.norm() > 0 ? d.normalized().dot(wanted) : 0;
      if (match > best) {
        best = match;
        x = x_mm[size_t(view.tri[t][k])].cast<double>();
      }
    }
  }
  return x;
}

std::optional<LimbEnds> limb_ends(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin,
                                  const CentralLimb& limb) {
  const auto& [C, A, B, D] = limb;
  const auto a0 = skin.at(A), b0 = skin.at(B);
  // The outer skin at A lies opposite the bisector of the flap's corner CAB; at B opposite that of ABD.
  const Vec2 at_A = (C - A).normalized() + (B - A).normalized(), at_B = (A - B).normalized() + (D - B).normalized();
  const auto a = corner_position_mm(view, x_mm, skin, A, A - at_A),
             b = corner_position_mm(view, x_mm, skin, B, B - at_B);
  if (!a0 || !b0 || !a || !b || !((a0->X_mm - b0->X_mm).norm() > 0)) return std::nullopt;
  return LimbEnds{*a, *b, (a0->X_mm - b0->X_mm).norm()};
}

std::optional<double> elongation(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin,
                                 const CentralLimb& limb) {
  const auto ends = limb_ends(view, x_mm, skin, limb);
  return ends ? std::optional((ends->a - ends->b).norm() / ends->before_mm) : std::nullopt;
}

}  // namespace limberg
