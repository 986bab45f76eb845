#include "sim/patient/world.h"

#include <algorithm>
#include <variant>

#include "sim/base/hash.h"
#include "sim/commands/kinds.h"
#include "sim/patient/carried_skin.h"
#include "sim/patient/history.h"
#include "sim/patient/joined_surface.h"
#include "sim/patient/press.h"
#include "sim/patient/soft_tissue.h"
#include "sim/skull/head/head.h"

namespace limberg {

struct World::Past : History<std::variant<TissueChange, HeadChange>> {};

struct World::Joined {
  CarriedSkin carried;
  JoinedSurface surface;
  Snapshot head;
};

World::World(WorldSpec spec, Workers& workers)
    : skin_(std::make_unique<SoftTissue>(std::move(spec), workers)), past_(std::make_unique<Past>()) {}

World::World(HeadParts parts, Workers& workers, const HeadSettings& settings)
    : head_(std::make_unique<Head>(std::move(parts), workers)), past_(std::make_unique<Past>()), dt_s_(settings.dt_s) {}

World::World(WorldSpec spec, HeadParts parts, Workers& workers, const HeadSettings& settings)
    : skin_(std::make_unique<SoftTissue>(std::move(spec), workers)),
      head_(std::make_unique<Head>(std::move(parts), workers)),
      past_(std::make_unique<Past>()),
      joined_(new Joined{CarriedSkin(settings.carries_skin_mm), {}, {}}),
      dt_s_(settings.dt_s) {}

World::~World() = default;
World::World(World&&) noexcept = default;

// ---- acts and their history ----

Outcome World::apply(const Command& command) {
  Outcome o;
  try {
    o = act(command);
  } catch (const std::bad_alloc& e) {
    o = {false, std::string("the act failed inside (") + e.what() + "); nothing has changed", true};
  }
  if (!o.done) ++refused_;
  return o;
}

Outcome World::act(const Command& command) {
  if (std::holds_alternative<Undo>(command)) return undo();
  if (std::holds_alternative<Redo>(command)) return redo();
  if (std::holds_alternative<Stage>(command)) return ++stage_, Outcome{true, {}};
  if (std::holds_alternative<Wait>(command) || std::holds_alternative<Shown>(command)) return {true, {}};
  if (is_of_pen(command) && skin_) return skin_->draw_on(command);
  past_->make_room();
  const auto take = [&](auto&& acted) -> Outcome {
    if (acted.ends_redo) past_->end_redo();
    if (acted.change && !acted.goes_on) past_->push(std::move(*acted.change));
    return std::move(acted);
  };
  if (const auto* h = std::get_if<HeadCommand>(&command)) {
    if (!head_) return {false, "there is no bone here; expected a scene with a [head]"};
    Acted<HeadChange> acted = head_->act(*h);
    if (acted.change && skin_) skin_->another_act();
    return take(std::move(acted));
  }
  if (!skin_) return {false, "there is no skin with flap tools here; expected a scene with a [body]"};
  Acted<TissueChange> acted = skin_->act(command);
  if (acted.done && joined_) joined_->carried.skin_changed();
  if (acted.change && acted.goes_on) {
    try {
      std::get<TissueChange>(past_->last()).append(*acted.change);
    } catch (...) {
      skin_->take_back(*acted.change);
      skin_->stop_stroke("a piece of it failed");
      throw;
    }
  }
  return take(std::move(acted));
}

Outcome World::undo() {
  if (!past_->can_undo())
    return {false, "there is nothing to undo; a cut, a stitch or another act on the patient was expected before it"};
  past_->make_room();
  if (auto* of_head = std::get_if<HeadChange>(&past_->last())) {
    if (Outcome o = head_->take_back(*of_head); !o.done) return o;
  }
  if (skin_) skin_->stop_stroke("it was taken back");
  if (auto* of_skin = std::get_if<TissueChange>(&past_->last())) skin_->take_back(*of_skin);
  if (joined_) joined_->carried.skin_changed();
  past_->went_back();
  return {true, {}};
}

Outcome World::redo() {
  if (!past_->can_redo()) return {false, "there is nothing to redo; an undo as the last act was expected"};
  past_->make_room();
  if (auto* of_head = std::get_if<HeadChange>(&past_->last_undone())) {
    if (Outcome o = head_->make_again(*of_head); !o.done) return o;
  }
  if (skin_) skin_->stop_stroke("another act came between");
  if (auto* of_skin = std::get_if<TissueChange>(&past_->last_undone()))
    if (Outcome o = skin_->make_again(*of_skin); !o.done) return o;
  if (joined_) joined_->carried.skin_changed();
  past_->went_forth();
  return {true, {}};
}

// ---- steps ----

StepReport World::step(const StepSettings& settings) {
  HeadStep h;
  if (head_) h = head_->step(dt_s_);
  StepReport r;
  if (joined_) joined_->carried.carry(*skin_, *head_);
  if (skin_) r = skin_->step(settings);
  if (!h.at_rest) {
    r.residual = std::max({r.residual, h.max_move_mm, kMoving});
    r.distance_mm = std::max(r.distance_mm, h.max_move_mm);
  }
  ++steps_;
  return r;
}

void World::hold_at(const std::function<Vec3(const Vec3&)>& where) { skin_->hold_at(where); }
bool World::settled() const { return !skin_ || skin_->settled(); }

// ---- what is shown ----

std::shared_ptr<const SurfaceTopology> World::topology() const {
  if (joined_) return joined_->surface.of(skin_->topology(), head_->topology());
  return skin_ ? skin_->topology() : head_->topology();
}

void World::fill(Snapshot& s, bool with_field) const {
  if (skin_)
    skin_->fill(s, with_field);
  else
    head_->fill(s);
  if (joined_) {
    head_->fill(joined_->head);
    JoinedSurface::append(s, joined_->head, topology());
  }
  s.step = steps_, s.stage = stage_;
}

PressAnswer World::press(const PressQuestion& question, int iterations) {
  if (!skin_) return {};
  if (!joined_) return skin_->press(question, iterations);
  // The triangles of the skin are the first of the joined surface, in their own order.
  const SurfaceTopology& skin = *skin_->topology();
  if (question.topology_version != topology()->version || question.triangle < 0 ||
      size_t(question.triangle) >= skin.view.tri.size())
    return {};
  PressQuestion of_skin = question;
  of_skin.topology_version = skin.version;
  PressAnswer answer = skin_->press(of_skin, iterations);
  answer.topology_version = question.topology_version;
  return answer;
}

// ---- hashes ----

namespace {

uint64_t one_hash(const SoftTissue* skin, const Head* head, uint64_t (SoftTissue::*of_skin)() const,
                  uint64_t (Head::*of_head)() const) {
  if (!head) return (skin->*of_skin)();
  if (!skin) return (head->*of_head)();
  Hash64 h;
  h.add((skin->*of_skin)()), h.add((head->*of_head)());
  return h.value();
}

}  // namespace

uint64_t World::topology_hash() const {
  return one_hash(skin(), head(), &SoftTissue::topology_hash, &Head::topology_hash);
}
uint64_t World::state_hash() const { return one_hash(skin(), head(), &SoftTissue::state_hash, &Head::state_hash); }
uint64_t World::full_hash() const { return one_hash(skin(), head(), &SoftTissue::full_hash, &Head::full_hash); }

}  // namespace limberg
