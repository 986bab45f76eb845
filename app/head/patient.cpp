#include "app/head/patient.h"

#include <algorithm>

#include "sim/base/hash.h"

namespace limberg {

namespace {

/// Skin first, then face and bones; lists that only the skin has are as long as the skin.
std::shared_ptr<const SurfaceTopology> joined(const SurfaceTopology& skin, const SurfaceTopology& head,
                                              uint64_t version) {
  auto both = std::make_shared<SurfaceTopology>(skin);
  both->version = version;
  Hash64 h;
  h.add(skin.hash), h.add(head.hash);
  both->hash = h.value();
  const auto base = int32_t(skin.view.X_mm.size());
  both->organ.assign(skin.view.tri.size(), Organ::flesh);
  both->object.assign(skin.view.tri.size(), -1);
  for (size_t v = 0; v < head.view.X_mm.size(); ++v) {
    both->view.X_mm.push_back(head.view.X_mm[v]);
    both->embedding.push_back({});
  }
  both->depth_mm = LazyArray<float>([of_skin = skin.depth_mm, others = head.view.X_mm.size()] {
    SharedArray<float> depth = of_skin.all();
    for (size_t v = 0; v < others; ++v) depth.push_back(0);
    return depth;
  });
  for (size_t t = 0; t < head.view.tri.size(); ++t) {
    const Tri& k = head.view.tri[t];
    both->view.tri.push_back({k[0] + base, k[1] + base, k[2] + base});
    both->view.kind.push_back(head.view.kind[t]);
    both->organ.push_back(head.organ[t]);
    both->object.push_back(head.object[t]);
  }
  for (const auto& [a, b] : head.strand) both->strand.push_back({a + base, b + base});
  both->landmark = head.landmark;
  return both;
}

}  // namespace

HeadPatient::HeadPatient(Head& head, World* world, double max_depth_mm, double dt_s, double carries_skin_mm)
    : head_(head),
      world_(world),
      skin_(world ? std::make_unique<WorldPatient>(*world, max_depth_mm) : nullptr),
      dt_s_(dt_s),
      carries_skin_mm_(carries_skin_mm) {}

Outcome HeadPatient::apply(const Command& c) {
  if (std::holds_alternative<Undo>(c)) return go_back(c, done_, undone_);
  if (std::holds_alternative<Redo>(c)) return go_back(c, undone_, done_);
  if (std::holds_alternative<Stage>(c) || std::holds_alternative<Wait>(c))
    return skin_ ? skin_->apply(c) : head_.apply(c);
  if (const auto* h = std::get_if<HeadCommand>(&c)) {
    const Outcome o = head_.apply(c);
    if (o.done && !std::holds_alternative<GrabFragment>(*h) && !std::holds_alternative<DragFragment>(*h) &&
        !std::holds_alternative<Superpose>(*h))
      done_.push_back(By::head), undone_.clear(), stroke_ = 0;
    return o;
  }
  if (!skin_) return head_.apply(c);  // says what is wrong
  const Outcome o = skin_->apply(c);
  if (!o.done) return o;
  stale_ = true;
  const bool hook = std::holds_alternative<SetHook>(c) || std::holds_alternative<MoveHook>(c) ||
                    std::holds_alternative<ReleaseHook>(c);
  const auto* more = std::get_if<InciseMore>(&c);
  if (hook || (more && more->stroke == stroke_)) return o;
  stroke_ = more ? more->stroke : 0;
  done_.push_back(By::skin), undone_.clear();
  return o;
}

Outcome HeadPatient::go_back(const Command& c, std::vector<By>& from, std::vector<By>& to) {
  if (from.empty())
    return {false, std::holds_alternative<Undo>(c) ? "there is nothing to undo" : "there is nothing to do again"};
  const By by = from.back();
  const Outcome o = by == By::head ? head_.apply(c) : skin_->apply(c);
  if (!o.done) return o;
  from.pop_back(), to.push_back(by);
  stale_ = true, stroke_ = 0;
  return o;
}

void HeadPatient::carry_skin() {
  const auto& fragments = head_.bones().fragments();
  std::vector<Eigen::Isometry3d> poses;
  for (const bone::Fragment& f : fragments) poses.push_back(f.pose);
  const bool moved = poses.size() != poses_.size() ||
                     !std::equal(poses.begin(), poses.end(), poses_.begin(),
                                 [](const auto& a, const auto& b) { return a.matrix() == b.matrix(); });
  const bool other = carried_world_ != world_->topology()->version || carried_bones_ != head_.bones().version();
  if (!moved && !other && !stale_) return;
  poses_ = std::move(poses);
  size_t at = 0;
  if (other) carrier_.clear(), carried_world_ = world_->topology()->version, carried_bones_ = head_.bones().version();
  world_->hold_at([&](const Vec3& X) {
    if (other) {
      Vec3 on = Vec3::Zero();
      const int32_t id = head_.bones().nearest_fragment(X, &on);
      carrier_.emplace_back(X, id >= 0 && (on - X).norm() <= carries_skin_mm_ ? id : -1);
    }
    const bone::Fragment* f = head_.bones().fragment(carrier_[at++].second);
    return f ? Vec3(f->pose * X) : X;
  });
  stale_ = false;
}

StepReport HeadPatient::step(const StepSettings& settings) {
  const HeadStep h = head_.step(dt_s_);
  StepReport r;
  if (skin_) {
    carry_skin();
    r = skin_->step(settings);
  }
  if (!h.at_rest)
    r.residual = std::max({double(r.residual), h.max_move_mm, kMoving}),
    r.distance_mm = std::max(double(r.distance_mm), h.max_move_mm);
  return r;
}

std::shared_ptr<const SurfaceTopology> HeadPatient::topology() const {
  if (!skin_) return head_.topology();
  const auto skin = world_->topology(), head = head_.topology();
  if (skin != of_skin_ || head != of_head_) of_skin_ = skin, of_head_ = head, both_ = joined(*skin, *head, ++version_);
  return both_;
}

void HeadPatient::fill(Snapshot& s, bool with_field) const {
  if (!skin_) return head_.fill(s);
  world_->fill(s, with_field);
  head_.fill(bone_);
  const size_t n = s.x_mm.size();
  s.x_mm.insert(s.x_mm.end(), bone_.x_mm.begin(), bone_.x_mm.end());
  if (!s.field.empty()) s.field.resize(s.x_mm.size(), 0.0f);
  s.moved_mm.clear();
  if (!bone_.moved_mm.empty())
    s.moved_mm.assign(n, 0.0f), s.moved_mm.insert(s.moved_mm.end(), bone_.moved_mm.begin(), bone_.moved_mm.end());
  s.plate_mm = bone_.plate_mm;
  s.landmark_mm = bone_.landmark_mm;
  s.figures = bone_.figures;
  s.residual = std::max(s.residual, bone_.residual);
  s.topology = topology();
  s.topology_version = s.topology->version;
}

bool HeadPatient::press(const PressQuestion& question, PressAnswer& answer) {
  // The triangles of the skin are the first of the joined surface, in their own order.
  if (!skin_ || question.topology_version != topology()->version) return false;
  const SurfaceTopology& skin = *world_->topology();
  if (question.triangle < 0 || size_t(question.triangle) >= skin.view.tri.size()) return false;
  PressQuestion of_skin = question;
  of_skin.topology_version = skin.version;
  const bool told = skin_->press(of_skin, answer);
  answer.topology_version = question.topology_version;
  return told;
}

uint64_t HeadPatient::topology_hash() const {
  if (!skin_) return head_.topology_hash();
  Hash64 h;
  h.add(world_->topology_hash()), h.add(head_.topology_hash());
  return h.value();
}

uint64_t HeadPatient::state_hash() const {
  if (!skin_) return head_.state_hash();
  Hash64 h;
  h.add(world_->state_hash()), h.add(head_.state_hash());
  return h.value();
}

}  // namespace limberg
