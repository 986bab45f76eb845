#include "app/assembly/operation.h"

#include <cmath>
#include <map>
#include <utility>

#include "app/session/clock.h"
#include "sim/base/error.h"
#include "sim/commands/kinds.h"
#include "sim/fem/solver/stall_watch.h"
#include "sim/patient/soft_tissue.h"

namespace limberg {

namespace {

class Operation {
 public:
  Operation(Patient& patient, const OperationSettings& set) : patient_(patient), set_(set) {}

  OperationOutcome out;

  Outcome apply(const Command& c, int line) {
    if (const auto* m = std::get_if<MoveHook>(&c)) return move(*m);
    if (const auto* h = std::get_if<HeadCommand>(&c)) {
      if (const auto* d = std::get_if<DragFragment>(h)) return drag(*d);
      dragged_ = {};  // whatever is held from now on is where it is
    }
    const Outcome o = patient_.apply(c);
    if (!o.done) return o;
    if (const auto* h = std::get_if<SetHook>(&c)) note_handle(h->id);
    if (const auto* r = std::get_if<ReleaseHook>(&c)) handle_.erase(r->id);
    if (is_of_pen(c)) pen_.push_back(c);
    if (const auto* s = std::get_if<Stage>(&c)) {
      StageRow row;
      row.number = int32_t(out.stages.size()) + 1;
      row.name = s->name;
      row.t_s = line;
      row.pen = pen_;
      patient_.fill(row.shown);
      out.stages.push_back(std::move(row));
    }
    bones_ |= std::holds_alternative<HeadCommand>(c);
    // Skin that is taken back is at rest already, as it was before the act: a further step would make the patient
    // depend on acts that were undone.
    const bool back = (std::holds_alternative<Undo>(c) || std::holds_alternative<Redo>(c)) && !bones_;
    if (!std::holds_alternative<Stage>(c) && !back) rest(set_.rest_residual, set_.rest_steps);
    return o;
  }

  void note_closure(const Command& c, int line) {
    if (leaves_patient(c)) return;
    patient_.fill(now_);
    if (now_.sutures.empty() && out.closure.empty()) return;
    ClosureForce f{line, action_name(c), 0, 0, int(now_.sutures.size()), 0};
    for (const SutureState& s : now_.sutures) {
      f.sum_N += double(s.force_N);
      if (double(s.force_N) > f.max_N) f.max_N = double(s.force_N), f.max_id = s.id;
    }
    out.closure.push_back(f);
  }

  void rest(double residual, int steps) {
    afresh_ = true;
    fem::StallWatch watch;
    for (int i = 0; i < steps; ++i) {
      step(residual);
      const bool there = out.last.residual <= residual, stalls = watch.look(out.last.residual, out.last.iterations);
      out.stalled = !there && (stalls || out.last.at_floor);
      if (((there || out.last.at_floor) && patient_.settled()) || (set_.interrupted && set_.interrupted())) return;
    }
  }

 private:
  void step(double tolerance) {
    StepSettings s;
    s.max_iterations = set_.iterations;
    s.tolerance = tolerance;
    // Where an act leads must not depend on acts before it that were undone.
    s.afresh = std::exchange(afresh_, false);
    const int64_t before = RealClock::monotonic_ns();
    out.last = patient_.step(s);
    out.iterations += out.last.iterations;
    out.solve_ms += double(RealClock::monotonic_ns() - before) * 1e-6;
    out.series.t_s.push_back(float(++steps_));
    out.series.residual.push_back(float(out.last.residual));
    out.series.distance_mm.push_back(float(out.last.distance_mm));
  }

  void note_handle(int id) {
    Snapshot s;
    patient_.fill(s);
    for (const HookState& h : s.hooks)
      if (h.id == id) handle_[id] = h.handle_mm.cast<double>();
  }

  /// In steps, as a hand would: the minimiser follows a path instead of guessing over a large jump.
  Outcome move(const MoveHook& m) {
    const auto at = handle_.find(m.id);
    if (at == handle_.end()) return patient_.apply(m);  // World says what is wrong
    const Vec3 from = at->second;
    afresh_ = true;
    const int n = std::max(1, int(std::ceil((m.to_mm - from).norm() / set_.hook_step_mm)));
    for (int i = 1; i <= n; ++i) {
      const Outcome o = patient_.apply(MoveHook{m.id, from + (m.to_mm - from) * (double(i) / n), 0});
      if (!o.done) return o;
      step(set_.rest_residual);
    }
    at->second = m.to_mm;
    rest(set_.rest_residual, set_.rest_steps);
    return {true, {}};
  }

  /// In steps of 0.5 mm and half a degree: what lies in the way has to be met.
  Outcome drag(const DragFragment& d) {
    const RigidMove from = dragged_;
    const double way =
        std::max((d.to.translation_mm - from.translation_mm).norm(), (d.to.rotation_deg - from.rotation_deg).norm());
    const int n = std::max(1, int(std::ceil(way / 0.5)));
    for (int i = 1; i <= n; ++i) {
      DragFragment part = d;
      const double s = double(i) / n;
      part.to.translation_mm = from.translation_mm + s * (d.to.translation_mm - from.translation_mm);
      part.to.rotation_deg = from.rotation_deg + s * (d.to.rotation_deg - from.rotation_deg);
      const Outcome o = patient_.apply(HeadCommand(part));
      if (!o.done) return o;
      step(set_.rest_residual);
    }
    dragged_ = d.to;
    for (int i = 0; i < 30; ++i) step(set_.rest_residual);  // half a second for what follows the hand to arrive
    return {true, {}};
  }

  Patient& patient_;
  RigidMove dragged_;    // since the grab
  bool bones_ = false;   // were acted on
  bool afresh_ = false;  // the next step is the first of an act
  const OperationSettings& set_;
  Snapshot now_;
  std::map<int, Vec3> handle_;
  std::vector<Command> pen_;
  int64_t steps_ = 0;
};

}  // namespace

OperationOutcome operate(World& world, double max_depth_mm, const Script& script, const OperationSettings& set) {
  WorldPatient patient(world, max_depth_mm);
  const size_t cells = world.skin()->solver().model().cells.size();
  OperationOutcome out = operate(patient, script, set);
  out.cells = cells;
  return out;
}

OperationOutcome operate(Patient& patient, const Script& script, const OperationSettings& set) {
  Operation op(patient, set);
  op.rest(set.rest_residual, set.rest_steps);
  size_t begun = 0;
  for (const ScriptLine& l : script.lines) {
    if (set.interrupted && set.interrupted()) {
      op.out.interrupted = true;
      return std::move(op.out);
    }
    if (set.progress) set.progress(begun++, script.lines.size());
    const Outcome o = op.apply(l.command, l.line);
    if (!o.done) {
      if (set.on_refusal) set.on_refusal(l.command, o.reason);
      if (!set.keep_going)
        throw InputError(script.name, l.line, std::string(action_name(l.command)) + " refused: " + o.reason);
      op.out.refused.push_back({l.line, action_name(l.command), o.reason});
      continue;
    }
    ++op.out.done;
    if (set.on_done) set.on_done(l, o.reason);
    op.note_closure(l.command, l.line);
  }
  op.rest(set.final_residual, set.final_steps);
  op.out.interrupted = set.interrupted && set.interrupted();
  return std::move(op.out);
}

}  // namespace limberg
