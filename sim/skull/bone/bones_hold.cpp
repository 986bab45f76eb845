// Fragments held by the hand, and the gaps between them.
#include <algorithm>
#include <cmath>

#include "sim/geometry/rotation.h"
#include "sim/skull/bone/bones.h"
#include "sim/skull/bone/gaps.h"
#include "sim/skull/bone/held.h"
#include "sim/skull/bone/shape.h"
#include "sim/skull/bone/words.h"

namespace limberg::bone {
namespace {

constexpr double kBone_g_per_mm3 = 1.9e-3;  // cortical bone

}  // namespace

Bones::~Bones() = default;
Bones::Bones(Bones&&) noexcept = default;
Bones& Bones::operator=(Bones&&) noexcept = default;

const FragmentShape& Bones::shape(int32_t id) const {
  for (const auto& s : shapes_)
    if (s->id == id) return *s;
  shapes_.push_back(std::make_unique<FragmentShape>(fragment_shape(mesh_, fragment(id)->vertex)));
  shapes_.back()->id = id;
  return *shapes_.back();
}

bool Bones::holds(int32_t id) const {
  return hold_ && (id < 0 || std::any_of(hold_->in_hand.begin(), hold_->in_hand.end(),
                                         [&](const Held::InHand& h) { return h.id == id; }));
}

Outcome Bones::grab(int32_t id) {
  if (const std::string why = why_no_physics(); !why.empty()) return refused(why);
  const Fragment* f = fragment(id);
  if (!f) return refused(no_fragment(id));
  for (int32_t i : plated(id)) {
    const Fragment& g = now_.fragments[size_t(i)];
    if (holds(g.id))
      return refused(g.id == id ? "fragment " + std::to_string(id) + " is held already"
                                : "it is plated to " + g.name + ", which is held already");
    if (g.fixed) return refused(g.id == id ? g.name + " is fixed" : "it is plated to " + g.name + ", which is fixed");
  }
  std::vector<int32_t> all;
  if (hold_)
    for (const Held::InHand& h : hold_->in_hand) all.push_back(h.id);
  all.push_back(id);
  auto hold = make_hold(all);
  hold->before = hold_ ? std::move(hold_->before) : now_;
  hold_ = std::move(hold);
  return {true, ""};
}

std::unique_ptr<Bones::Held> Bones::make_hold(const std::vector<int32_t>& in_hand) const {
  auto hold = std::make_unique<Held>();
  std::vector<RigidPart> parts;
  std::vector<uint8_t> seen(now_.fragments.size(), 0);
  std::vector<size_t> part_of(in_hand.size(), 0);
  for (size_t i = 0; i < now_.fragments.size(); ++i) {
    if (seen[i]) continue;
    const Fragment& first = now_.fragments[i];
    RigidPart p;
    p.pose = first.pose, p.mass_g = 0;
    hold->ids.emplace_back(), hold->offset.emplace_back();
    double volume = 0;
    for (int32_t k : plated(first.id)) {
      const Fragment& g = now_.fragments[size_t(k)];
      seen[size_t(k)] = 1;
      for (size_t h = 0; h < in_hand.size(); ++h)
        if (g.id == in_hand[h]) part_of[h] = parts.size();
      FragmentShape& s = const_cast<FragmentShape&>(shape(g.id));
      if (s.prisms.empty()) s.prisms = prisms_of(mesh_, s);
      hold->ids.back().push_back(g.id);
      hold->offset.back().push_back(first.id == g.id ? Eigen::Isometry3d::Identity()
                                                     : Eigen::Isometry3d(first.pose.inverse() * g.pose));
      p.prisms.push_back(&s.prisms), p.offset.push_back(hold->offset.back().back());
      p.centre_mm += g.volume_mm3 * (hold->offset.back().back() * g.centre_mm), volume += g.volume_mm3;
      p.mass_g += kBone_g_per_mm3 * g.volume_mm3, p.fixed |= g.fixed;
    }
    p.centre_mm /= volume;
    parts.push_back(std::move(p));
  }
  hold->world = make_rigid_world(parts, part_of);
  for (size_t h = 0; h < in_hand.size(); ++h) {
    hold->in_hand.push_back({in_hand[h], part_of[h], parts[part_of[h]].pose});
    // The other hand goes on wanting what it wanted.
    if (!hold_) continue;
    for (const Held::InHand& k : hold_->in_hand)
      if (k.id == in_hand[h]) hold->in_hand.back().wanted = k.wanted, hold->world->want(part_of[h], k.wanted);
  }
  return hold;
}

void Bones::drag(int32_t id, const Eigen::Isometry3d& wanted) {
  if (!hold_ || !wanted.matrix().allFinite()) return;
  for (Held::InHand& h : hold_->in_hand) {
    if (h.id != id) continue;
    const auto& ids = hold_->ids[h.part];
    const size_t k = size_t(std::find(ids.begin(), ids.end(), id) - ids.begin());
    h.wanted = wanted * hold_->offset[h.part][k].inverse();
    hold_->world->want(h.part, h.wanted);
  }
}

void Bones::step(double dt) {
  if (!hold_) return;
  hold_->world->step(dt);
  for (size_t p = 0; p < hold_->ids.size(); ++p)
    for (size_t k = 0; k < hold_->ids[p].size(); ++k) {
      Fragment& f = now_.fragments[size_t(index(hold_->ids[p][k]))];
      f.pose = k == 0 ? hold_->world->pose(p) : Eigen::Isometry3d(hold_->world->pose(p) * hold_->offset[p][k]);
    }
}

ActedOnBone Bones::release(int32_t id, bool snap) {
  if (id < 0 || !holds(id)) return refused("fragment " + std::to_string(id) + " is not held");
  std::string words;
  BonesState then = now_;
  if (snap) {
    // The neighbour by a cut that it lies nearest to where it fits: there both have one pose.
    const Fragment& f = *fragment(id);
    const std::vector<int32_t> group = plated(id);
    double least = kSnap_mm, nearest = 1e300, nearest_deg = 0;
    Eigen::Isometry3d to = f.pose;
    const Fragment *into = nullptr, *beside = nullptr;
    for (const Fragment& g : now_.fragments) {
      if (std::find(group.begin(), group.end(), index(g.id)) != group.end() || !(seam_mm2(shape(id), shape(g.id)) > 0))
        continue;
      const double far = (g.pose * f.centre_mm - f.pose * f.centre_mm).norm();
      const double deg = axis_angle(g.pose.linear() * f.pose.linear().transpose()).angle * 180 / M_PI;
      if (far < nearest) nearest = far, nearest_deg = deg, beside = &g;
      if (far <= least && deg <= kSnap_deg) least = far, to = g.pose, into = &g;
    }
    if (into)
      words = f.name + " fits into its cut in " + into->name + text(": moved by %.1f mm", least);
    else if (beside)
      words = f.name + text(" stays: %.1f mm and %.0f degrees from fitting ", nearest, nearest_deg) + beside->name +
              text("; at most %.0f mm and %.0f degrees was expected", kSnap_mm, kSnap_deg);
    else
      words = f.name + " stays: it was cut from no other fragment";
    const Eigen::Isometry3d by = to * f.pose.inverse();
    for (int32_t i : group) {
      Fragment& g = then.fragments[size_t(i)];
      g.pose = g.id == id ? to : by * g.pose;
    }
  }
  // A release is an act even where everything lies as before: the hand has done something.
  BoneChange change;
  if (hold_->in_hand.size() == 1) {
    change.before = std::move(hold_->before);
    now_ = std::move(then);
    hold_.reset();
    return finish(std::move(change), std::move(words));
  }
  // The other hand goes on: as far as the history is concerned only this fragment, and what is plated to it, has moved.
  std::vector<int32_t> others;
  for (const Held::InHand& h : hold_->in_hand)
    if (h.id != id) others.push_back(h.id);
  change.before = hold_->before, change.after = hold_->before;
  for (const int32_t i : plated(id)) change.after.fragments[size_t(i)].pose = then.fragments[size_t(i)].pose;
  BonesState left = change.after;
  std::swap(now_, then);
  try {
    auto hold = make_hold(others);
    hold->before = std::move(left);
    hold_ = std::move(hold);
  } catch (...) {
    std::swap(now_, then);
    throw;
  }
  return {{true, std::move(words)}, std::move(change)};
}

RigidFigures Bones::physics_figures() const { return hold_ ? hold_->world->figures() : RigidFigures{}; }

std::vector<Gap> Bones::gaps() const {
  std::vector<Gap> out;
  for (const Fragment& a : now_.fragments)
    for (const Fragment& b : now_.fragments) {
      if (b.id <= a.id) continue;
      const FragmentShape &s = shape(a.id), &t = shape(b.id);
      const Eigen::Isometry3d b_in_a = a.pose.inverse() * b.pose;
      // Far apart and never one: nothing to say. The box of b about its middle, as a sphere.
      const Vec3 middle = b_in_a * (0.5 * (t.lo_mm + t.hi_mm));
      const double reach = 0.5 * (t.hi_mm - t.lo_mm).norm();
      const bool near = (middle.cwiseMax(s.lo_mm).cwiseMin(s.hi_mm) - middle).norm() <= reach;
      const bool seam = !s.wall.empty() && !t.wall.empty() && seam_mm2(s, t) > 0;
      if (!near && !seam) continue;
      const Gap g = measure_gap(s, t, b_in_a);
      if (seam || g.overlap_mm3 > 0) out.push_back(g);
    }
  return out;
}

}  // namespace limberg::bone
