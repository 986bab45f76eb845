#include "sim/imaging/anatomy/landmark_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace limberg {

namespace {

constexpr double kSlack_mm = 1;       // a rule looks so much farther than on the synthetic head
constexpr double kPastPlace_mm = 25;  // and a ray goes on so far behind it
constexpr double kProfile = 0.7;      // of a rule's reach: half of the parabola's width
constexpr double kProfileStep_mm = 0.5;
constexpr double kUnseen = 0.1;  // of a voxel: what falls by less is level
constexpr double kMostFlat_mm = 15;

/// Where a rule's rays begin: across `look`, u along the first reach and v along the second.
struct Window {
  Vec3 place, look, score, u, v;
  double most_a, most_b, back_mm;
  Vec3 from(double a, double b) const { return place + a * u + b * v - back_mm * look; }
};

Window window_of(const LandmarkRule& r, const Vec3& place, double side) {
  Window w;
  w.place = place, w.back_mm = r.back_mm;
  w.look = Vec3(side * r.look.x(), r.look.y(), r.look.z()).normalized();
  w.score = Vec3(side * r.score.x(), r.score.y(), r.score.z()).normalized();
  const Vec3 helper = std::abs(w.look.x()) > 0.9 ? Vec3::UnitY() : Vec3::UnitX();
  w.u = (helper - helper.dot(w.look) * w.look).normalized(), w.v = w.look.cross(w.u);
  w.most_a = r.reach_mm[0] > 0 ? r.reach_mm[0] + kSlack_mm : 0;
  w.most_b = r.reach_mm[1] > 0 ? r.reach_mm[1] + kSlack_mm : 0;
  return w;
}

struct Rays {
  const Bvh& surface;
  Eigen::Isometry3d back;  // from the frame of the head to that of the surface
  double voxel_mm;

  /// What a ray of a rule meets first from outside.
  std::optional<Vec3> meet(const Vec3& from, const Window& w) const {
    std::array<Bvh::LineHit, 8> hit;
    const int hits = surface.line(back * from, back.linear() * w.look, 0, w.back_mm + kPastPlace_mm, hit);
    for (int k = 0; k < std::min(hits, 8); ++k)
      if (hit[size_t(k)].from_outside) return from + hit[size_t(k)].t * w.look;
    return std::nullopt;
  }
  std::optional<Vec3> meet(const Window& w, double a, double b) const { return meet(w.from(a, b), w); }

  /// Where the rule's profile has its top: the highest of the places that are higher than what lies on both their
  /// sides. Nothing: it only rises towards an end of the window, so that its top is elsewhere and not known.
  std::optional<Vec3> top_of_profile(const Window& w) const {
    const int n = int(std::ceil(w.most_b / kProfileStep_mm));
    constexpr double kNone = -1e30;
    std::vector<double> height;
    for (int i = -n; i <= n; ++i) {
      const auto p = meet(w, 0, w.most_b * i / n);
      height.push_back(p ? p->dot(w.score) : kNone);
    }
    const auto falls = [&](size_t top, int step) {  // how far, before it rises above the top
      double low = height[top];
      for (size_t i = top + size_t(step); i < height.size() && height[i] <= height[top]; i += size_t(step))
        low = std::min(low, height[i]);
      return height[top] - low;
    };
    const double least = kUnseen * voxel_mm;
    size_t best = height.size();
    for (size_t i = 1; i + 1 < height.size(); ++i)
      if (height[i] > kNone && (best == height.size() || height[i] > height[best]) && falls(i, 1) > least &&
          falls(i, -1) > least)
        best = i;
    if (best == height.size()) return std::nullopt;
    double b = w.most_b * (int(best) - n) / n;
    std::optional<Vec3> top = meet(w, 0, b);
    for (double step = 0.5 * w.most_b / n; step > kProfileStep_mm / 50; step *= 0.5)
      for (const double to : {b - step, b + step})
        if (const auto p = meet(w, 0, to); p && p->dot(w.score) > top->dot(w.score)) top = p, b = to;
    return top;
  }

  /// Along v the place where a parabola through the heights around `best` is highest, `wide_mm` to either side; three
  /// lines beside one another take part. `best` where it has no top there, or the profile is none (an edge, a tip).
  Vec3 top_of_parabola(Vec3 best, const Window& w, double wide, double& flat_mm) const {
    constexpr int kTo = 6, kRounds = 3;
    constexpr double kBeside_mm = 3, kLeaves_mm = 0.35;
    const Vec3 first = best;
    for (int round = 0; round < kRounds; ++round) {
      Mat3 A = Mat3::Zero();
      Vec3 b = Vec3::Zero();
      double square = 0;
      int count = 0;
      for (const double beside : {-kBeside_mm, 0., kBeside_mm})
        for (int i = -kTo; i <= kTo; ++i) {
          const double t = double(i) / kTo;
          const auto p = meet(best + beside * w.u + t * wide * w.v - w.back_mm * w.look, w);
          if (!p) continue;
          const Vec3 J(1, t, t * t);
          const double s = (*p - first).dot(w.score);
          A += J * J.transpose(), b += s * J, square += s * s, ++count;
        }
      if (count < 2 * kTo) return first;
      const Vec3 c = A.ldlt().solve(b);
      const double left = std::sqrt(std::max(0., square - b.dot(c)) / count);
      if (!(c[2] < 0) || !(left < kLeaves_mm)) return first;
      flat_mm = std::min(kMostFlat_mm, wide * std::sqrt(kUnseen * voxel_mm / -c[2]));
      const double t = std::clamp(-0.5 * c[1] / c[2], -1., 1.);
      const auto p = meet(best + t * wide * w.v - w.back_mm * w.look, w);
      if (!p) return first;
      best = *p;
      if (std::abs(t) < 0.02) break;
    }
    return (best - first).norm() <= 2 * wide ? best : first;
  }

  /// The same of a rule that looks across an area: its farthest place, unless that lies at the border of the window,
  /// and from there the middle of what is level with it.
  std::optional<Vec3> top_of_area(const Window& w, double& flat_mm) const {
    double a0 = 0, b0 = 0, ra = w.most_a, rb = w.most_b;
    std::optional<Vec3> best;
    for (int round = 0; round < 7; ++round) {
      double best_a = a0, best_b = b0;
      constexpr int na = 5, nb = 7;
      for (int i = -na; i <= na; ++i)
        for (int j = -nb; j <= nb; ++j) {
          const double a = std::clamp(a0 + ra * i / na, -w.most_a, w.most_a),
                       b = std::clamp(b0 + rb * j / nb, -w.most_b, w.most_b);
          const auto p = meet(w, a, b);
          if (p && (!best || p->dot(w.score) > best->dot(w.score))) best = p, best_a = a, best_b = b;
        }
      a0 = best_a, b0 = best_b, ra *= 0.5, rb *= 0.4;
    }
    const bool border = std::abs(a0) > w.most_a - kProfileStep_mm || std::abs(b0) > w.most_b - kProfileStep_mm;
    if (border || !best) return std::nullopt;
    const double level = best->dot(w.score) - kUnseen * voxel_mm;
    const auto reaches = [&](bool along_v, double step, double most) {  // from the top, before it falls
      double t = 0;
      for (; std::abs(t) < 2 * most; t += step) {
        const auto p = along_v ? meet(w, a0, b0 + t + step) : meet(w, a0 + t + step, b0);
        if (!p || p->dot(w.score) < level) break;
      }
      return t;
    };
    for (const bool along_v : {false, true}) {
      const double most = along_v ? w.most_b : w.most_a;
      const double to = reaches(along_v, kProfileStep_mm, most), back_to = reaches(along_v, -kProfileStep_mm, most);
      (along_v ? b0 : a0) += 0.5 * (to + back_to);
      flat_mm = std::max(flat_mm, 0.5 * (to - back_to));
    }
    const auto middle = meet(w, a0, b0);
    return middle ? middle : best;
  }
};

SoughtLandmark at_first_place(const Rays& rays, const Window& w) {
  SoughtLandmark out{rays.meet(w, 0, 0), std::max(w.most_a, w.most_b), true};
  if (out.at_mm) return out;
  const Bvh::Closest c = rays.surface.closest(rays.back * w.place, LandmarkSearch::kReach_mm);
  if (c.triangle >= 0) out.at_mm = rays.back.inverse() * c.point_mm;
  return out;
}

}  // namespace

SoughtLandmark LandmarkSearch::as_laid(const LandmarkRule& rule, const Vec3& place, double side) const {
  return at_first_place({surface, to_head.inverse(), voxel_mm}, window_of(rule, place, side));
}

SoughtLandmark LandmarkSearch::by_rule(const LandmarkRule& rule, const Vec3& place, double side) const {
  const Rays rays{surface, to_head.inverse(), voxel_mm};
  const Window w = window_of(rule, place, side);
  SoughtLandmark out;
  const bool profile = w.most_a == 0;
  out.at_mm = profile ? rays.top_of_profile(w) : rays.top_of_area(w, out.flat_mm);
  if (!out.at_mm) return at_first_place(rays, w);
  if (profile) out.at_mm = rays.top_of_parabola(*out.at_mm, w, kProfile * rule.reach_mm[1], out.flat_mm);
  return out;
}

}  // namespace limberg
