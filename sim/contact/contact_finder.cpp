#include "sim/contact/contact_finder.h"

#include <algorithm>
#include <cmath>

#include "sim/error.h"

namespace limberg {
namespace {

constexpr size_t kGrain = 128, kVertexGrain = 1024;
constexpr double kOn_mm = 0.02;    // so near to a sheet a place lies on it
constexpr double kBirth = 0.25;    // rate of a new pair
constexpr double kSlowest = 0.004;  // rate of a pair that swings to and fro
constexpr double kNothing = 1e-4;  // a pair of this weight is left out: its force is below single precision
constexpr std::array<double, 3> kMiddle{1.0 / 3, 1.0 / 3, 1.0 / 3};

Vec3 displaced(const EmbeddedPoint& e, std::span<const Vec3f> u) {
  Vec3 d = Vec3::Zero();
  for (size_t i = 0; i < 8; ++i)
    if (e.w[i] != 0) d += double(e.w[i]) * u[size_t(e.node[i])].cast<double>();
  return d;
}

double weight(const EmbeddedPoint& e) {
  double sum = 0;
  for (float w : e.w) sum += double(w);
  return sum;
}

/// 0 up to `from`, 1 after `to`; value and slope are continuous.
double smooth_step(double x, double from, double to) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

ContactFinder::ContactFinder(std::shared_ptr<const ContactSurface> surface, const Vec3& cell_mm, const ContactSettings& settings)
    : surface_(std::move(surface)), settings_(settings), cell_mm_(std::cbrt(cell_mm.prod())),
      tree_(surface_->X_mm, surface_->tri, surface_->sheets.of), neighbours_(surface_), x_(surface_->X_mm.size()) {
  Guess none;
  none.fill(-1);
  guess_.assign(surface_->place.size(), none);
  found_.resize((surface_->place.size() + kGrain - 1) / kGrain);
  before_.resize(found_.size());
}

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

void ContactFinder::look(size_t i, std::vector<HeldContact>& out) {
  const ContactSurface& s = *surface_;
  const ContactPlace& place = s.place[i];
  const Tri& own = s.tri[size_t(place.triangle)];
  FacingTree::Query q;
  q.p_mm = (x_[size_t(own[0])] + x_[size_t(own[1])] + x_[size_t(own[2])]) / 3;
  q.n = smooth_normal(place.triangle, kMiddle);
  q.near_mm = settings_.ahead_mm, q.deep_mm = settings_.deep_none_mm;
  q.guess = guess_[i];
  const Neighbours::Place self{i, place.triangle, place.X_mm, tree_.rest_normal(place.triangle)};
  FacingTree::Feet feet;
  const size_t count = tree_.nearest(q, [&](int32_t t, const std::array<double, 3>& bary) {
    return neighbours_.other(self, t, s.rest_mm(t, bary), tree_.rest_normal(t));
  }, feet);
  std::array<double, FacingTree::kFeet> facing{};
  std::array<Vec3, FacingTree::kFeet> normal;
  for (size_t k = 0; k < FacingTree::kFeet; ++k) {
    guess_[i][k] = k < count ? feet[k].triangle : -1;
    if (k >= count) continue;
    normal[k] = smooth_normal(feet[k].triangle, feet[k].bary);
    facing[k] = smooth_step(-q.n.dot(normal[k]), settings_.facing_none, settings_.facing_full);
  }
  for (size_t k = 0; k < count; ++k) {
    const Vec3 r = q.p_mm - feet[k].point_mm;
    HeldContact f{int32_t(i), feet[k].sheet, feet[k].triangle, feet[k].bary, normal[k], normal[k].dot(r), facing[k]};
    if (f.s_mm > ahead_mm_) continue;
    const double d = feet[k].distance_mm;
    f.weight *= 1 - smooth_step(d, settings_.deep_full_mm, settings_.deep_none_mm);
    if (-f.s_mm > settings_.most_mm) f.weight *= settings_.most_mm / -f.s_mm;
    if (f.weight > kNothing) f.weight *= inside(self, q.p_mm, feet[k]);
    if (f.weight > kNothing) out.push_back(f);
  }
}

// `found`, by place, goes from what was held before towards what is found now.
void ContactFinder::follow(const std::vector<HeldContact>& before, std::vector<HeldContact>& found) const {
  const auto by = [](const HeldContact& a, const HeldContact& b) { return std::pair(a.place, a.sheet) < std::pair(b.place, b.sheet); };
  std::sort(found.begin(), found.end(), by);
  std::vector<HeldContact> out;
  out.reserve(found.size() + before.size() / 8);
  const auto go = [&](HeldContact h, double weight, const Vec3& normal) {  // h: how it was, with its new foot
    const double change = weight - h.weight;
    const Vec3 turn = normal - h.normal;
    const bool back = change * h.change < 0 || turn.dot(h.turn) < 0;
    h.rate = std::clamp(h.rate * (back ? 0.5 : 1.5), kSlowest, weight > 0 ? 1.0 : 0.5);
    h.change = change, h.turn = turn;
    h.weight += h.rate * change;
    h.normal = (h.normal + h.rate * turn).normalized();
    const ContactPlace& place = surface_->place[size_t(h.place)];
    const Tri &own = surface_->tri[size_t(place.triangle)], &c = surface_->tri[size_t(h.triangle)];
    const Vec3 p = (x_[size_t(own[0])] + x_[size_t(own[1])] + x_[size_t(own[2])]) / 3;
    h.s_mm = h.normal.dot(p - h.bary[0] * x_[size_t(c[0])] - h.bary[1] * x_[size_t(c[1])] - h.bary[2] * x_[size_t(c[2])]);
    if (h.weight > kNothing && h.s_mm <= ahead_mm_) out.push_back(h);
  };
  size_t i = 0, j = 0;
  while (i < before.size() || j < found.size()) {
    if (j == found.size() || (i < before.size() && by(before[i], found[j]))) {
      go(before[i], 0, before[i].normal);
      ++i;
    } else if (i == before.size() || by(found[j], before[i])) {
      HeldContact h = found[j++];
      h.change = h.weight;
      if (h.s_mm < -settings_.slack_mm) h.weight *= kBirth, h.rate = kBirth;  // it presses already: it must not come at once
      out.push_back(h);
    } else {
      HeldContact h = before[i++];
      h.triangle = found[j].triangle, h.bary = found[j].bary;
      go(h, found[j].weight, found[j].normal);
      ++j;
    }
  }
  found.swap(out);
}

bool ContactFinder::presses() const {
  return std::any_of(found_.begin(), found_.end(), [&](const std::vector<HeldContact>& f) {
    return std::any_of(f.begin(), f.end(), [&](const HeldContact& h) { return h.s_mm < -settings_.slack_mm; });
  });
}

std::vector<HeldContact> ContactFinder::held() const {
  std::vector<HeldContact> all;
  for (const std::vector<HeldContact>& f : found_) all.insert(all.end(), f.begin(), f.end());
  return all;
}

void ContactFinder::resume(std::span<const HeldContact> held) {
  for (std::vector<HeldContact>& f : found_) f.clear();
  first_ = true;
  for (const HeldContact& h : held) {
    if (h.place < 0 || size_t(h.place) >= surface_->place.size() || h.triangle < 0 || size_t(h.triangle) >= surface_->tri.size())
      throw InputError("", 0, "a held contact is of another surface");
    found_[size_t(h.place) / kGrain].push_back(h);
  }
}

Contact ContactFinder::contact(const HeldContact& f, std::span<const Vec3f> u) const {
  const ContactPlace& place = surface_->place[size_t(f.place)];
  Contact c;
  c.a = place.embedded;
  c.b = surface_->embedded(f.triangle, f.bary);
  c.normal = f.normal.cast<float>();
  // What the surfaces show is linear in their triangles, what the springs feel is trilinear in the cells: the gap makes up
  // the difference, so that a contact begins where it is seen to begin.
  const Vec3 apart = place.X_mm - surface_->rest_mm(f.triangle, f.bary);
  const double felt = f.normal.dot(apart + displaced(c.a, u) / weight(c.a) - displaced(c.b, u) / weight(c.b));
  c.gap_mm = float(felt - f.s_mm - settings_.slack_mm);
  c.soft_mm = float(settings_.soft_mm);
  c.k_N_per_mm = float(1e-3 * f.weight * settings_.stiffness * place.stiffness_kPa * place.area_mm2 / cell_mm_);
  return c;
}

std::span<const Contact> ContactFinder::find(std::span<const Vec3f> u, Workers& workers) {
  const ContactSurface& s = *surface_;
  move2_.assign(x_.size() / kVertexGrain + 1, 0);
  workers.parallel_for(x_.size(), kVertexGrain, [&](size_t begin, size_t end) {
    double move2 = 0;
    for (size_t v = begin; v < end; ++v) {
      const Vec3 x = s.X_mm[v] + displaced(s.embedding[v], u);
      move2 = std::max(move2, (x - x_[v]).squaredNorm());
      x_[v] = x;
    }
    move2_[begin / kVertexGrain] = move2;
  });
  const double move = std::sqrt(*std::max_element(move2_.begin(), move2_.end()));
  ahead_mm_ = first_ ? settings_.ahead_mm : std::clamp(2 * move, settings_.ahead_least_mm, settings_.ahead_mm);
  first_ = false;
  tree_.refit(x_, workers);
  workers.parallel_for(s.place.size(), kGrain, [&](size_t begin, size_t end) {
    std::vector<HeldContact>& out = found_[begin / kGrain];
    out.swap(before_[begin / kGrain]);
    out.clear();
    for (size_t i = begin; i < end; ++i) look(i, out);
    follow(before_[begin / kGrain], out);
  });
  size_t total = 0;
  for (const std::vector<HeldContact>& f : found_) total += f.size();
  contacts_.resize(total);
  workers.parallel_for(found_.size(), 1, [&](size_t begin, size_t end) {
    for (size_t chunk = begin; chunk < end; ++chunk) {
      size_t at = 0;
      for (size_t k = 0; k < chunk; ++k) at += found_[k].size();
      for (const HeldContact& f : found_[chunk]) contacts_[at++] = contact(f, u);
    }
  });
  return contacts_;
}

}  // namespace limberg
