#include "app/session/solver_lane.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/session/clock.h"
#include "app/words/words.h"
#include "devices/rigid_grip.h"
#include "sim/base/hash.h"
#include "sim/commands/kinds.h"
#include "sim/commands/script.h"
#include "sim/commands/words.h"
#include "sim/geometry/triangle.h"

namespace limberg {

namespace {
double seconds(int64_t tick) { return double(tick) * 1e-3; }
constexpr double kMoved_mm = 2;  // a stitch finds the edge this near (kStitchReach_mm): farther it takes other skin
constexpr double kSamePlace_mm = 0.05;  // at rest
constexpr int32_t kByCommand = -1;      // in carried_: held, and not by a hand
constexpr int kChances = 64;            // bits of SolverTake::adopted; later chances in one step are let pass
Vec3 vec(const double (&p)[3]) { return {p[0], p[1], p[2]}; }
}  // namespace

SolverLane::SolverLane(Patient& patient, Channels& channels, const SolverSettings& settings, OnCommand on_command,
                       OnRefusal on_refusal)
    : patient_(patient),
      ch_(channels),
      settings_(settings),
      on_command_(std::move(on_command)),
      on_refusal_(std::move(on_refusal)),
      builder_(PathSettings{.curves = settings.as_meant}, settings.progressive_cut,
               settings.in_space ? patient.ground() : nullptr) {
  series_.reserve(1 << 16);
}

void SolverLane::start() { publish(0); }

void SolverLane::step(int64_t tick, const std::function<bool()>& stop_early) {
  if (ch_.hand_to_solver.update()) hand_ = ch_.hand_to_solver.reading(), hand_known_ = true;
  for (ToolEvent e; ch_.events.pop(e);) take(e, tick);
  StepSettings s = settings_.step;
  s.adopt_when_ready &= bool(stop_early);
  if (!settings_.schedule) {
    if (stop_early) s.should_stop = stop_early;
    return advance(tick, s);
  }
  SolverTake found{int64_t(steps_) + 1, tick, hand_known_ ? hand_.tool.tick : -1, int64_t(events_)};
  int64_t asked = 0;
  if (stop_early)
    s.should_stop = [&] {
      ++asked;
      if (found.stop_at == 0 && stop_early()) found.stop_at = asked;
      return found.stop_at != 0;
    };
  int chance = 0;
  if (s.adopt_when_ready)
    s.adopt_now = [&](bool there) {
      const bool now = there && chance < kChances;
      if (now) found.adopted |= uint64_t(1) << chance;
      ++chance;
      return now;
    };
  advance(tick, s);
  pass_on(found);
}

void SolverLane::pass_on(SolverTake take) {
  const bool hashed = settings_.hash_every > 0 && steps_ % uint64_t(settings_.hash_every) == 0;
  take.hash = hashed ? state_hash() : 0;
  ch_.solver_takes.push(take);
}

void SolverLane::step_as(const SolverTake& as, const HandState* hand) {
  if (hand) hand_ = *hand, hand_known_ = true;
  for (ToolEvent e; int64_t(events_) < as.events && ch_.events.pop(e);) take(e, as.tick);
  StepSettings s = settings_.step;
  int64_t asked = 0;
  s.should_stop = [&] { return ++asked >= as.stop_at && as.stop_at > 0; };
  int chance = 0;
  s.adopt_when_ready = true;
  s.adopt_now = [&](bool) {
    const int k = chance++;
    return k < kChances && (as.adopted >> k & 1) != 0;
  };
  advance(as.tick, s);
  if (settings_.schedule) pass_on(as);
}

// On every other step: an answer costs about as much as a step, and is faded in over longer than one. A question that
// came before the patient's newest cut is about a surface that is no longer there: no answer.
void SolverLane::answer_press() {
  if (!ch_.press || steps_ % 2 != 0) return;
  const PressQuestion* question = ch_.press->asked();
  if (PressAnswer answer; question && patient_.press(*question, answer)) ch_.press->answer(answer);
}

void SolverLane::advance(int64_t tick, const StepSettings& s) {
  follow_hand();
  last_ = patient_.step(s);
  if (settings_.after_step) settings_.after_step(seconds(tick), hand_);
  ++steps_;
  motion_.add(seconds(tick), hand_.tool);
  if (settings_.series_every > 0 && steps_ % uint64_t(settings_.series_every) == 0) {
    series_.t_s.push_back(float(seconds(tick)));
    series_.residual.push_back(float(last_.residual));
    series_.distance_mm.push_back(float(last_.distance_mm));
  }
  publish(tick);
  answer_press();
}

void SolverLane::sample_state(const Snapshot& shown) {
  while (next_expected_ < expected_.size() && expected_[next_expected_].step < int64_t(steps_)) ++next_expected_;
  const bool compare = next_expected_ < expected_.size() && expected_[next_expected_].step == int64_t(steps_);
  const bool record = settings_.sample_states && steps_ > 0 && steps_ % uint64_t(settings_.hash_every) == 0;
  if (!compare && !record) return;
  StateSample s;
  s.step = int64_t(steps_), s.topology = shown.topology ? shown.topology->hash : 0;
  s.vertices = int32_t(shown.x_mm.size()), s.n = std::min(StateSample::kPlaces, s.vertices);
  for (int32_t k = 0; k < s.n; ++k) {
    const Vec3f& x = shown.x_mm[size_t(int64_t(k) * s.vertices / s.n)];
    s.at_mm[size_t(k)] = {x.x(), x.y(), x.z()};
  }
  for (const SutureState& t : shown.sutures) s.sutures_N += t.force_N;
  for (const HookState& h : shown.hooks) s.hooks_N += h.force_N.norm();
  if (compare) add(difference_, expected_[next_expected_], s);
  if (record) ch_.states.push(s);
}

void SolverLane::note_closure(const Snapshot& s) {
  float sum = 0, most = 0;
  for (const SutureState& k : s.sutures) sum += k.force_N, most = std::max(most, k.force_N);
  while (series_.closure_N.size() < series_.t_s.size())
    series_.closure_N.push_back(sum), series_.suture_max_N.push_back(most);
}

void SolverLane::take(const ToolEvent& e, int64_t tick) {
  ++events_;
  if (e.seq > next_event_) event_gaps_ += e.seq - next_event_;
  next_event_ = e.seq + 1;
  const int dropped = builder_.dropped();
  std::optional<Command> c = builder_.feed(e);
  if (builder_.dropped() > dropped) notify_dropped(e, tick);
  const size_t hand = size_t(std::clamp(e.hand, 0, kHands - 1));
  if (e.kind == ToolEvent::hook_set || e.kind == ToolEvent::hook_take || e.kind == ToolEvent::bone_grab)
    held_since_[hand] = e.tick;
  // What was not taken up (the grab was refused) is neither carried nor let go.
  if ((e.kind == ToolEvent::bone_drag || e.kind == ToolEvent::bone_release) && carried_[hand] == 0) return;
  if (e.kind == ToolEvent::told) {
    if (c) take(*c, tick);
    return;
  }
  bool done = false;
  if (e.kind == ToolEvent::suture_a) a_moved_ = moved_away(e);
  if (e.kind == ToolEvent::suture_tip && a_moved_.empty()) a_moved_ = moved_away(e);
  std::string moved;
  if (c && (e.kind == ToolEvent::suture_b || e.kind == ToolEvent::hook_set)) moved = moved_away(e);
  if (c && e.kind == ToolEvent::suture_b && moved.empty()) moved = a_moved_;
  if (!moved.empty()) {
    refuse(*c, moved, tick);
  } else if (c) {
    // A hook that was carried is put down: say how long the way took, for whoever carries the script out again.
    const double carried_s = seconds(std::max<int64_t>(0, e.tick - held_since_[hand]));
    if (auto* m = std::get_if<MoveHook>(&*c)) m->seconds = carried_s;
    if (auto* h = std::get_if<HeadCommand>(&*c))
      if (auto* d = std::get_if<DragFragment>(h)) d->seconds = carried_s;
    done = apply(*c, tick);
  }
  switch (e.kind) {
    case ToolEvent::hook_set:
    case ToolEvent::hook_take:
      held_hook_[hand] = e.id;
      break;
    case ToolEvent::hook_leave:
    case ToolEvent::hook_release:
      held_hook_[hand] = 0;
      break;
    case ToolEvent::bone_grab:
      carried_[hand] = done ? e.id : 0;
      break;
    case ToolEvent::bone_release:
      carried_[hand] = 0;
      break;
    default:
      break;
  }
}

// A panel's grab and let go, which say a snap, go together as a hand's: what was not grabbed is not let go.
void SolverLane::take(const Command& c, int64_t tick) {
  const auto* of_head = std::get_if<HeadCommand>(&c);
  const auto* grab = of_head ? std::get_if<GrabFragment>(of_head) : nullptr;
  const auto* let_go = of_head ? std::get_if<LetGo>(of_head) : nullptr;
  if (let_go && carried_[size_t(let_go->hand)] == 0) return;
  const bool done = apply(c, tick);
  if (grab) carried_[size_t(grab->hand)] = done ? kByCommand : 0;
  if (let_go) carried_[size_t(let_go->hand)] = 0;
}

void SolverLane::refuse(const Command& c, const std::string& reason, int64_t tick) {
  refused_.push_back({seconds(tick), action_name(c), reason});
  notify(Notice::refused, c, reason, tick);
  if (std::holds_alternative<InciseMore>(c)) builder_.stop_stroke();
  if (on_refusal_) on_refusal_(c, reason);
}

// A step that takes long leaves the hand with a patient that is not there any more. In lockstep an act comes to the
// very state that was shown.
std::string SolverLane::moved_away(const ToolEvent& e) {
  if (e.snapshot == uint64_t(steps_)) return "";
  patient_.fill(now_);
  if (!has_surface(now_) || now_.topology->organ_of(0) != Organ::flesh) return "";
  const SurfaceView& view = now_.topology->view;
  const Vec3 X = vec(e.rest_mm), seen = vec(e.seen_mm);
  double moved = std::numeric_limits<double>::infinity();
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (!now_.topology->is_ground(t, Ground::skin)) continue;
    const Tri& c = view.tri[t];
    const TrianglePoint p =
        closest_on_triangle(X, view.X_mm[size_t(c[0])], view.X_mm[size_t(c[1])], view.X_mm[size_t(c[2])]);
    if (!((p.point - X).norm() <= kSamePlace_mm)) continue;
    Vec3 x = Vec3::Zero();
    for (size_t k = 0; k < 3; ++k) x += p.bary[k] * now_.x_mm[size_t(c[k])].cast<double>();
    moved = std::min(moved, (x - seen).norm());  // of the banks that meet there the one that was shown
  }
  if (moved <= kMoved_mm || !std::isfinite(moved)) return "";
  return fmt::format(
      "the skin there is {:.1f} mm from where it was shown: the patient is behind the hand; expected at most {:g} mm",
      moved, kMoved_mm);
}

bool SolverLane::apply(const Command& c, int64_t tick) {
  const auto* bone = std::get_if<HeadCommand>(&c);
  const bool saws = bone && (std::holds_alternative<CutBone>(*bone) || std::holds_alternative<CutBoneByBlade>(*bone));
  const int pieces = saws ? patient_.pieces_of_bone() : -1;
  const Outcome o = patient_.apply(c);
  if (!o.done) return refuse(c, o.reason, tick), false;
  ++commands_;
  if (is_of_pen(c)) pen_.push_back(c);
  if (const auto* s = std::get_if<Stage>(&c)) {
    StageRow row;
    row.number = int32_t(stages_.size()) + 1;
    row.name = s->name;
    row.t_s = seconds(tick);
    row.pen = pen_;
    stages_.push_back(row);
    ch_.stages.push({row.number, ShortText(s->name)});
  }
  const bool undo = std::holds_alternative<Undo>(c), redo = std::holds_alternative<Redo>(c);
  notify(undo   ? Notice::undone
         : redo ? Notice::redone
                : Notice::done,
         c, undo || redo ? "" : in_words(c) + (o.reason.empty() ? "" : ": " + o.reason), tick,
         pieces < 0 ? -1 : patient_.pieces_of_bone() - pieces);
  if (on_command_) on_command_(c);
  return true;
}

void SolverLane::notify(int32_t kind, const Command& c, const std::string& text, int64_t tick, int32_t freed) {
  Notice n;
  n.kind = kind, n.freed = freed;
  n.t_s = seconds(tick);
  Notice::put(n.action, action_name(c));
  Notice::put(n.text, text);
  n.command = std::make_shared<const Command>(c);
  ch_.notices.push(n);
}

// What the hand drew, and what the command builder found no act in.
void SolverLane::notify_dropped(const ToolEvent& e, int64_t tick) {
  Notice n;
  n.kind = Notice::dropped;
  n.t_s = seconds(tick);
  const bool stroke = e.kind == ToolEvent::stroke_end, row = sews_along(Tool(e.tool));
  Notice::put(
      n.text,
      !stroke || row
          ? english("the row is given up: its second edge was not drawn; draw along both edges, one after the other")
      : Tool(e.tool) == Tool::saw
          ? english("the line on the bone is too short, or does not close; draw once round, with the button held")
          : english("the stroke was too short to be a cut; hold the button and draw from one end to the other"));
  ch_.notices.push(n);
}

void SolverLane::follow_hand() {
  // The hand state may be a moment older or newer than the events: a hook follows only when both say that it is held.
  const auto follow = [&](size_t hand, bool valid, int32_t hook, const Vec3& hook_mm, const Carried& c) {
    if (held_hook_[hand] != 0 && hook == held_hook_[hand] && valid)
      patient_.apply(MoveHook{held_hook_[hand], hook_mm, 0});
    if (carried_[hand] != 0 && c.holds == carried_[hand] && valid)
      patient_.apply(HeadCommand(DragFragment{as_move(motion_of(c)), 0, int(hand)}));
  };
  follow(0, hand_.tool.valid, hand_.tool.held_hook, vec(hand_.tool.tip_mm), hand_.tool.carried);
  for (size_t hand = 1; const SecondHand* g : {&hand_.glove, &hand_.other_glove}) {
    follow(hand, g->valid, g->held_hook, vec(g->hook_mm), g->carried);
    ++hand;
  }
}

// The device thread finds what it searches on, and makes nothing.
void SolverLane::make_indices() {
  const std::shared_ptr<const SurfaceTopology> topology = patient_.topology();
  if (!topology) return;
  for (const Ground g : {Ground::skin, Ground::flesh, Ground::bone}) topology->index(g);
}

void SolverLane::publish(int64_t tick) {
  make_indices();
  new_sample_ = hand_.sample_ns != shown_sample_ns_;
  shown_sample_ns_ = hand_.sample_ns;
  PatientState& out = ch_.patient_to_device.writing();
  if (ch_.want_field.load(std::memory_order_relaxed))
    patient_.fill_with_field(out.snapshot);
  else
    patient_.fill(out.snapshot);
  note_closure(out.snapshot);
  out.snapshot.device_tick = tick;
  out.snapshot.stage = int32_t(stages_.size());
  out.sample_ns = hand_.sample_ns;
  sample_state(out.snapshot);
  for (; shown_stages_ < stages_.size(); ++shown_stages_) stages_[shown_stages_].shown = out.snapshot;
  PatientState& shown = ch_.patient_to_render.writing();
  shown.snapshot = out.snapshot, shown.sample_ns = out.sample_ns;
  if (ch_.want_lattice.load(std::memory_order_relaxed))
    patient_.fill_lattice(shown.lattice);
  else if (shown.lattice.edges)
    shown.lattice = {};
  if (ch_.want_patient_shown.load(std::memory_order_relaxed)) {
    ch_.patient_to_main.writing().snapshot = out.snapshot;
    ch_.patient_to_main.publish();
  }
  if (ch_.want_headset.load(std::memory_order_relaxed)) {
    ch_.patient_to_headset.writing().snapshot = out.snapshot;
    ch_.patient_to_headset.publish();
  }
  ch_.patient_to_device.publish();
  ch_.patient_to_render.publish();
}

uint64_t SolverLane::state_hash() const {
  Hash64 h;
  h.add(patient_.state_hash());
  h.add(patient_.topology_hash());
  for (const double v : hand_.tool.tip_mm) h.add(v);
  for (const double v : hand_.tool.shaft) h.add(v);
  h.add(hand_.tool.tool), h.add(hand_.tool.held_hook), h.add(hand_.tool.pressed), h.add(hand_.tool.valid);
  h.add(hand_.tool.tick);
  for (const SecondHand* g : {&hand_.glove, &hand_.other_glove}) {
    if (!g->valid && g->held_hook == 0) continue;
    for (const double v : g->hook_mm) h.add(v);
    h.add(g->held_hook), h.add(g->closed);
  }
  for (const Carried* c : {&hand_.tool.carried, &hand_.glove.carried, &hand_.other_glove.carried}) {
    if (c->holds == 0) continue;
    for (const double v : c->quat) h.add(v);
    for (const double v : c->shift_mm) h.add(v);
    h.add(c->holds);
  }
  return h.value();
}

}  // namespace limberg
