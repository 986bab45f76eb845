#include "sim/contact/collider_contacts.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "sim/base/elementary.h"
#include "sim/contact/contact_constants.h"
#include "sim/contact/contact_stiffness.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

namespace constant = contact_constants;

// Tissue that lies farther away at rest comes to no collider: nothing that is sewn is drawn so far.
constexpr double kReach_mm = 30;
// What lies deeper in it at rest belongs there: nothing says which way is out.
constexpr double kWithin_mm = 1;
constexpr int kWholeProjections = 2, kMostSteps = 8;
constexpr double kRounding = 1e-9;

struct Way {
  double depth_mm = -std::numeric_limits<double>::infinity();  // below 0 outside
  Vec3 out = Vec3::Zero(), foot_mm = Vec3::Zero();
};

const Vec3 kNoFoot = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());

/// From x to the surface of the collider that it is nearest to, or deepest in. `feet`: a point of each, or kNoFoot;
/// takes the nearest ones.
Way way_to(std::span<const SidedPatch> patches, const Vec3& x, double far_mm, std::span<Vec3> feet) {
  Way best;
  for (size_t k = 0; k < patches.size(); ++k) {
    const SidedPatch& patch = patches[k];
    const double to_foot_mm = (x - feet[k]).norm() * (1 + kRounding) + kRounding;
    const Bvh::Closest c = patch.bvh().closest(x, to_foot_mm < far_mm ? to_foot_mm : far_mm);
    if (c.triangle < 0) continue;
    feet[k] = c.point_mm;
    const Vec3 side = patch.side_normal(c), from = x - c.point_mm;
    const bool inside = from.dot(side) < 0;
    if (const double depth = inside ? c.distance_mm : -c.distance_mm; depth > best.depth_mm) {
      best.depth_mm = depth, best.foot_mm = c.point_mm;
      // On the surface itself the way is the side's normal; elsewhere it is the line to the foot.
      constexpr double kOn_mm = 1e-6;
      best.out = c.distance_mm > kOn_mm ? Vec3((inside ? -1.0 : 1.0) * from / c.distance_mm) : Vec3(side.normalized());
    }
  }
  return best;
}

Vec3 displacement(const EmbeddedPoint& e, std::span<const Vec3f> u) {
  Vec3 sum = Vec3::Zero();
  double all = 0;
  for (size_t i = 0; i < 8; ++i)
    if (e.w[i] != 0) sum += double(e.w[i]) * u[size_t(e.node[i])].cast<double>(), all += double(e.w[i]);
  return all > 0 ? Vec3(sum / all) : sum;
}

}  // namespace

ColliderContacts::ColliderContacts(std::shared_ptr<const Body> body, const SurfaceView& view,
                                   std::span<const EmbeddedPoint> embedding, const FemModel& model, double friction)
    : body_(std::move(body)), friction_{friction} {
  for (const auto& c : body_->colliders) patch_.emplace_back(c->mesh);
  if (patch_.empty()) return;
  std::vector<double> area(view.X_mm.size(), 0);  // of the free surface that each vertex stands for
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] == FaceKind::fixed) continue;
    const Tri& c = view.tri[t];
    const double a =
        0.5 * area_vector2(view.X_mm[size_t(c[0])], view.X_mm[size_t(c[1])], view.X_mm[size_t(c[2])]).norm();
    for (const int32_t v : c) area[size_t(v)] += a / 3;
  }
  const double cell_mm = elementary::cbrt(model.cell_mm.prod());
  std::vector<Vec3> feet;
  for (size_t v = 0; v < area.size(); ++v) {
    if (!(area[v] > 0)) continue;
    feet.assign(patch_.size(), kNoFoot);
    const Way way = way_to(patch_, view.X_mm[v], kReach_mm, feet);
    if (!(way.depth_mm > -kReach_mm) || way.depth_mm > kWithin_mm) continue;
    Place p{int32_t(v), embedding[v], view.X_mm[v], 0, std::max(0.0, way.depth_mm)};
    p.k_N_per_mm = contact_stiffness_N_per_mm(1, young_kPa(model, view.cell_copy[v]), area[v], cell_mm);
    place_.push_back(p);
    foot_mm_.insert(foot_mm_.end(), feet.begin(), feet.end());
  }
  state_.resize(place_.size());
}

void ColliderContacts::project(size_t i, const Vec3& x) {
  State& s = state_[i];
  const Way way = way_to(patch_, x, kReach_mm, std::span(foot_mm_).subspan(i * patch_.size(), patch_.size()));
  s.asked_mm = x;
  s.clear_mm = std::max(0.0, std::min(-way.depth_mm, kReach_mm) - constant::guard_mm);
  const bool held = s.holds;
  s.holds = way.depth_mm > -constant::guard_mm;
  if (!s.holds) return;
  HeldByCollider& h = s.held;
  const double plane_mm = way.out.dot(way.foot_mm) - place_[i].deep_mm;
  if (!held) {
    h = {int32_t(i), 0, Vec3::Zero(), way.out, plane_mm, x, {}};
    return;
  }
  const Vec3 slid = x - h.at_mm;
  h.slid_mm += slid - h.normal.dot(slid) * h.normal;
  if (h.slid_mm.norm() > constant::neighbourhood_mm) h.slid_mm = Vec3::Zero(), h.projections = 0;
  const double part = h.projections < kWholeProjections ? 1 : 1.0 / (h.projections - kWholeProjections + 2);
  // Of two planes: what lies between them at the place.
  const double before_mm = h.normal.dot(x) - h.plane_mm, now_mm = way.out.dot(x) - plane_mm;
  h.normal = (h.normal + part * (way.out - h.normal)).normalized();
  h.plane_mm = h.normal.dot(x) - (before_mm + part * (now_mm - before_mm));
  h.at_mm = x;
  ++h.projections;
}

bool ColliderContacts::follow_place(size_t i, std::span<const Vec3f> u) {
  State& s = state_[i];
  const Vec3 x = place_[i].X_mm + displacement(place_[i].embedded, u);
  if (!s.holds && (x - s.asked_mm).norm() < s.clear_mm) return false;
  if (s.holds) {
    const HeldByCollider& h = s.held;
    const double apart_mm = h.normal.dot(x) - h.plane_mm;
    const Vec3 way = x - h.at_mm, slid = way - h.normal.dot(way) * h.normal;
    const bool still = h.projections > kMostSteps && (h.slid_mm + slid).norm() < constant::neighbourhood_mm;
    if (still || slid.norm() < constant::slide_mm + std::max(0.0, apart_mm)) return false;
  }
  const bool held = s.holds;
  project(i, x);
  return held || s.holds;
}

Contact ColliderContacts::contact(size_t i) const {
  const HeldByCollider& held = state_[i].held;
  Contact c;
  c.a = place_[i].embedded;
  c.normal = held.normal.cast<float>().normalized();
  c.gap_mm = float(held.plane_mm - constant::slack_mm);
  c.soft_mm = float(constant::soft_mm);
  c.k_N_per_mm = float(place_[i].k_N_per_mm);
  if (friction_.coefficient > 0) take_grip(held.grip, friction_, c);
  return c;
}

bool ColliderContacts::follow(std::span<const Vec3f> u, Workers& workers, bool step_begins) {
  friction_.step_begins = step_begins;
  std::atomic<bool> changed = resumed_;
  resumed_ = false;
  constexpr size_t kGrain = 64;
  workers.parallel_for(place_.size(), kGrain, [&](size_t begin, size_t end) {
    bool any = false;
    for (size_t i = begin; i < end; ++i) {
      any |= follow_place(i, u);
      if (!(friction_.coefficient > 0) || !state_[i].holds) continue;
      Contact now = contact(i);
      any |= follow_grip(state_[i].held.grip, place_[i].X_mm + displacement(place_[i].embedded, u), friction_, now);
    }
    if (any) changed.store(true, std::memory_order_relaxed);
  });
  if (!changed) return false;
  contacts_.clear();
  for (size_t i = 0; i < place_.size(); ++i)
    if (state_[i].holds) contacts_.push_back(contact(i));
  return true;
}

std::vector<HeldByCollider> ColliderContacts::memory() const {
  std::vector<HeldByCollider> out;
  for (const State& s : state_)
    if (s.holds) out.push_back(s.held);
  return out;
}

void ColliderContacts::resume(std::span<const HeldByCollider> memory) {
  state_.assign(place_.size(), {});
  for (const HeldByCollider& h : memory)
    if (h.place >= 0 && size_t(h.place) < place_.size())
      state_[size_t(h.place)].held = h, state_[size_t(h.place)].holds = true;
  resumed_ = true;
}

}  // namespace limberg
