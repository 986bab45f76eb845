#include "sim/contact/contact_finder.h"

#include <cmath>

namespace limberg {
namespace {

constexpr size_t kGrain = 256;

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

}  // namespace

ContactFinder::ContactFinder(std::shared_ptr<const ContactSurface> surface, const Vec3& cell_mm, const ContactSettings& settings)
    : surface_(std::move(surface)), settings_(settings), cell_mm_(std::cbrt(cell_mm.prod())),
      tree_(surface_->X_mm, surface_->tri), neighbours_(surface_), x_(surface_->X_mm.size()) {
  const size_t n = surface_->place.size();
  found_.resize(n), guess_.assign(n, -1);
  pair_.assign(n, -1), pair_X_mm_.resize(n), pair_normal_.resize(n);
}

// The nearest facing point of another sheet, if the place is truly before or behind it; near_X_mm: only within hold_mm of it.
ContactFinder::Found ContactFinder::foot(size_t i, double within_mm, const Vec3* near_X_mm) {
  const ContactSurface& s = *surface_;
  const ContactPlace& place = s.place[i];
  const Tri& own = s.tri[size_t(place.triangle)];
  FacingTree::Query q;
  q.p_mm = (x_[size_t(own[0])] + x_[size_t(own[1])] + x_[size_t(own[2])]) / 3;
  q.n = tree_.normal(place.triangle);
  q.within_mm = within_mm;
  q.guess = guess_[i];
  const Neighbours::Place self{i, place.triangle, place.X_mm, tree_.rest_normal(place.triangle)};
  const FacingTree::Foot at = tree_.nearest(q, [&](int32_t t, const std::array<double, 3>& bary) {
    const Vec3 X = s.rest_mm(t, bary);
    if (near_X_mm && !((X - *near_X_mm).squaredNorm() < settings_.hold_mm * settings_.hold_mm)) return false;
    return neighbours_.other(self, t, X, tree_.rest_normal(t));
  });
  guess_[i] = at.triangle;
  Found f;
  if (at.triangle < 0) return f;
  const Vec3 r = q.p_mm - at.point_mm;
  f.normal = tree_.normal(at.triangle);
  f.s_mm = f.normal.dot(r);
  // On an edge or at a corner, some triangles around it may have the place in front of them: then it is outside, and what
  // parts it from the edge is the way to it. From within, the nearest point lies there only where the surface is hollow.
  bool outside = false;
  if (at.bary[0] == 0 || at.bary[1] == 0 || at.bary[2] == 0) {
    const Tri& c = s.tri[size_t(at.triangle)];
    const auto touches = [&](const Tri& t) {  // it holds every corner that the foot lies between
      for (size_t j = 0; j < 3; ++j)
        if (at.bary[j] != 0 && t[0] != c[j] && t[1] != c[j] && t[2] != c[j]) return false;
      return true;
    };
    const size_t k = at.bary[0] != 0 ? 0 : at.bary[1] != 0 ? 1 : 2;
    for (int32_t t : s.triangles_around(c[k])) outside = outside || (tree_.normal(t).dot(r) > 0 && touches(s.tri[size_t(t)]));
  }
  const double distance = r.norm();
  if (outside && distance > 1e-3) {
    f.normal = r / distance, f.s_mm = distance;
    if (!(q.n.dot(f.normal) < -0.2)) return f;
  }
  f.triangle = at.triangle, f.bary = at.bary;
  return f;
}

ContactFinder::Found ContactFinder::look(size_t i) {
  if (pair_[i] >= 0) {
    Found held = foot(i, settings_.within_mm, &pair_X_mm_[i]);
    if (held.triangle >= 0 && held.s_mm < settings_.release_mm) {
      held.normal = (settings_.turn * held.normal + (1 - settings_.turn) * pair_normal_[i]).normalized();
      pair_[i] = held.triangle, pair_X_mm_[i] = surface_->rest_mm(held.triangle, held.bary), pair_normal_[i] = held.normal;
      return held;
    }
    pair_[i] = -1;
  }
  Found f = foot(i, std::max(ahead_mm_, new_mm_), nullptr);
  if (f.s_mm < -new_mm_ || f.s_mm > ahead_mm_) f.triangle = -1;
  if (f.triangle >= 0 && f.s_mm < -settings_.slack_mm)
    pair_[i] = f.triangle, pair_X_mm_[i] = surface_->rest_mm(f.triangle, f.bary), pair_normal_[i] = f.normal;
  return f;
}

std::span<const Contact> ContactFinder::find(std::span<const Vec3f> u, Workers& workers) {
  const ContactSurface& s = *surface_;
  constexpr size_t chunk = 4 * kGrain;
  move2_.assign(x_.size() / chunk + 1, 0);
  workers.parallel_for(x_.size(), chunk, [&](size_t begin, size_t end) {
    double move2 = 0;
    for (size_t v = begin; v < end; ++v) {
      const Vec3 x = s.X_mm[v] + displaced(s.embedding[v], u);
      move2 = std::max(move2, (x - x_[v]).squaredNorm());
      x_[v] = x;
    }
    move2_[begin / chunk] = move2;
  });
  const double move = std::sqrt(*std::max_element(move2_.begin(), move2_.end()));
  ahead_mm_ = first_ ? settings_.ahead_mm : std::clamp(2 * move, settings_.ahead_least_mm, settings_.ahead_mm);
  new_mm_ = first_ ? settings_.new_mm : std::clamp(2 * move, settings_.new_mm, settings_.new_most_mm);
  first_ = false;
  tree_.refit(x_);
  workers.parallel_for(s.place.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) found_[i] = look(i);
  });
  contacts_.clear();
  for (size_t i = 0; i < s.place.size(); ++i) {
    const Found& f = found_[i];
    if (f.triangle < 0) continue;
    const ContactPlace& place = s.place[i];
    const ContactSurface::Carrier& carrier = s.carrier[size_t(f.triangle)];
    Contact c;
    c.a = place.embedded;
    c.b.node = carrier.node;
    const Vec3 Xb = s.rest_mm(f.triangle, f.bary);
    for (size_t k = 0; k < 3; ++k)
      for (size_t j = 0; j < 8; ++j) c.b.w[j] += float(f.bary[k]) * carrier.w[k][j];
    const Vec3& n = f.normal;
    c.normal = n.cast<float>();
    // What the surfaces show is linear in their triangles, what the springs feel is trilinear in the cells: the gap makes
    // up the difference, so that a contact begins where it is seen to begin.
    const double felt = n.dot(place.X_mm - Xb + displaced(c.a, u) / weight(c.a) - displaced(c.b, u) / weight(c.b));
    c.gap_mm = float(felt - f.s_mm - settings_.slack_mm);
    c.k_N_per_mm = float(1e-3 * settings_.stiffness * place.stiffness_kPa * place.area_mm2 / cell_mm_);
    contacts_.push_back(c);
  }
  return contacts_;
}

}  // namespace limberg
