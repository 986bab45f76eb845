// What a place finds when it looks around (contact_finder.h).
#include <algorithm>
#include <cmath>

#include "sim/contact/contact_finder.h"

namespace limberg {
namespace {

constexpr double kOn_mm = 0.02;      // so near to a sheet a place lies on it
constexpr double kJudged_mm = 0.05;  // nearer than this it is worth while to ask whether the place is inside
constexpr double kNothing = 1e-4;    // a pair of this weight is left out: its force is below single precision
constexpr std::array<double, 3> kMiddle{1.0 / 3, 1.0 / 3, 1.0 / 3};

/// 0 up to `from`, 1 after `to`; value and slope are continuous.
double smooth_step(double x, double from, double to) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

Vec3 ContactFinder::smooth_normal(int32_t t, const std::array<double, 3>& bary) const {
  const ContactSurface& s = *surface_;
  Vec3 n = Vec3::Zero();
  for (size_t k = 0; k < 3; ++k) {
    if (bary[k] == 0) continue;
    Vec3 fan = Vec3::Zero();
    for (int32_t i : s.sheets.triangles_of_fan(s.sheets.fan[size_t(t)][k])) {
      const Tri& c = s.tri[size_t(i)];
      fan += area_vector2(x_[size_t(c[0])], x_[size_t(c[1])], x_[size_t(c[2])]);
    }
    const double l = fan.norm();
    if (l > 0) n += bary[k] / l * fan;
  }
  const double l = n.norm();
  return l > 1e-6 ? Vec3(n / l) : tree_.normal(t);
}

/// Is p behind the sheet, or rather beyond its border or about to leave through a sheet beside it? 1: behind; 0: beyond.
double ContactFinder::inside(const Neighbours::Place& self, const Vec3& p, const FacingTree::Foot& foot) {
  const ContactSurface& s = *surface_;
  const Vec3 apart = p - foot.point_mm;
  const double wide = std::max(settings_.border_mm, 1.5 * std::abs(tree_.normal(foot.triangle).dot(apart)));
  const auto across = [&](int32_t t, const Vec3& r) {  // what of r is not along the normal of t: none over its inner part
    const Vec3& n = tree_.normal(t);
    return (r - n.dot(r) * n).norm();
  };
  double weight = 1 - smooth_step(across(foot.triangle, apart), 0, wide);
  if (weight == 0) return 0;
  std::array<FacingTree::Foot, 12> beside;  // the nearest point of each other sheet; more never meet in one place
  size_t count = 0;
  tree_.near(p, wide, [&](int32_t t, const TrianglePoint& at, double d2) {
    const int32_t sheet = s.sheets.of[size_t(t)];
    size_t k = 0;
    while (k < count && beside[k].sheet != sheet) ++k;
    if (k == beside.size() || (k < count && (d2 > beside[k].distance_mm || (d2 == beside[k].distance_mm && t > beside[k].triangle)))) return;
    if (sheet == foot.sheet || !neighbours_.other(self, t, s.rest_mm(t, at.bary), tree_.rest_normal(t))) return;
    count = std::max(count, k + 1);
    beside[k] = {t, sheet, at.point, at.bary, d2};
  });
  for (size_t k = 0; k < count; ++k) {
    const Vec3 r = p - beside[k].point_mm;
    const double d = std::sqrt(beside[k].distance_mm);
    const double within = smooth_normal(beside[k].triangle, beside[k].bary).dot(r) < 0 ? d : 0;
    // 1 where p is over or under the sheet itself; what is nearer than kOn_mm has no direction.
    const double over = 1 - smooth_step(across(beside[k].triangle, r) / std::max(d, kOn_mm), 0.3, 0.7);
    // A sheet that is not part of the same edge says something only to a place that lies on it: banks that still coincide.
    const double counts = s.sheets.adjacent(beside[k].sheet, foot.sheet) ? 1 : 1 - smooth_step(d, kOn_mm, 5 * kOn_mm);
    weight *= 1 - counts * over * (1 - smooth_step(within, 0, wide));
  }
  return weight;
}

// `sheet`: the only one asked about, or -1: all; then looked_[i].free_mm is set.
void ContactFinder::look(size_t i, int32_t sheet, std::vector<HeldContact>& found) {
  const ContactSurface& s = *surface_;
  const ContactPlace& place = s.place[i];
  const Tri& own = s.tri[size_t(place.triangle)];
  FacingTree::Query q;
  q.p_mm = (x_[size_t(own[0])] + x_[size_t(own[1])] + x_[size_t(own[2])]) / 3;
  q.n = smooth_normal(place.triangle, kMiddle);
  q.near_mm = sheet < 0 ? settings_.far_mm : settings_.guard_mm, q.deep_mm = settings_.deep_none_mm;
  q.sheet = sheet;
  q.guess = guess_[i];
  const Neighbours::Place self{i, place.triangle, place.X_mm, tree_.rest_normal(place.triangle)};
  FacingTree::Feet feet;
  const size_t count = tree_.nearest(q, [&](int32_t t, const std::array<double, 3>& bary) {
    return neighbours_.other(self, t, s.rest_mm(t, bary), tree_.rest_normal(t));
  }, feet);
  if (sheet >= 0 && count > 0)
    for (int32_t& t : guess_[i])
      if (t >= 0 && s.sheets.of[size_t(t)] == sheet) t = feet[0].triangle;
  if (sheet < 0) {
    looked_[i].free_mm = count == FacingTree::kFeet ? feet[count - 1].distance_mm : settings_.far_mm;
    guess_[i].fill(-1);
    for (size_t k = 0; k < count; ++k) guess_[i][k] = feet[k].triangle;
  }
  for (size_t k = 0; k < count; ++k) {
    HeldContact f;
    f.place = int32_t(i), f.sheet = feet[k].sheet, f.triangle = feet[k].triangle, f.bary = feet[k].bary;
    const Vec3 r = q.p_mm - feet[k].point_mm;
    if (feet[k].distance_mm > settings_.guard_mm && q.n.dot(r) < 0) {  // it lies before the place
      looked_[i].free_mm = std::min(looked_[i].free_mm, feet[k].distance_mm);
      continue;
    }
    f.normal = smooth_normal(f.triangle, f.bary), f.facet = tree_.normal(f.triangle);
    const double s_mm = f.normal.dot(r);
    f.gap_mm = -s_mm;  // for the time being: it needs to know how the cells carry both (merge)
    f.weight = smooth_step(-q.n.dot(f.normal), settings_.facing_none, settings_.facing_full);
    f.judged = s_mm < kJudged_mm;
    if (f.judged) {
      f.weight *= 1 - smooth_step(feet[k].distance_mm, settings_.deep_full_mm, settings_.deep_none_mm);
      if (-s_mm > settings_.most_mm) f.weight *= settings_.most_mm / -s_mm;
      if (f.weight > kNothing) f.weight *= inside(self, q.p_mm, feet[k]);
    }
    found.push_back(f);
  }
  if (sheet < 0) std::sort(found.begin(), found.end(), [](const HeldContact& a, const HeldContact& b) { return a.sheet < b.sheet; });
}

}  // namespace limberg
