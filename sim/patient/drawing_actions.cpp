// Incisions that open while they are drawn: piece by piece, each atomic, undone as one.
#include "sim/patient/operating_table.h"

namespace limberg {

Outcome OperatingTable::stop_stroke(int id, const std::string& why) {
  stroke_.reset();
  stopped_stroke_ = id;
  why_stopped_ = why;
  return {false, why};
}

Outcome OperatingTable::act(const InciseMore& c) {
  if (!arrangement_) return {false, "this scene cannot be cut; can_cut = true was expected in the scene"};
  if (c.stroke <= 0) return {false, "stroke number " + std::to_string(c.stroke) + "; a positive number was expected"};
  if (stopped_stroke_ == c.stroke) {
    if (c.last) stopped_stroke_ = 0;
    return {false, "stroke " + std::to_string(c.stroke) + " has stopped: " + why_stopped_};
  }
  if (!stroke_ || stroke_->id != c.stroke) stroke_ = Stroke{c.stroke, DrawnStroke(c.depth_mm, c.angle_deg)};
  if (const std::string why = stroke_->drawn.draw(blade_context(), c.path); !why.empty()) {
    stop_stroke(c.stroke, why);
    if (c.last) stopped_stroke_ = 0;
    return {false, why};
  }
  Outcome o = cut_on(c.last);
  if (o.done && c.last && !stroke_->cut) o = {false, "nothing of the stroke lies on uncut skin"};
  if (!o.done) stop_stroke(c.stroke, o.reason);
  if (c.last) {
    stroke_.reset();
    stopped_stroke_ = 0;
  }
  return o;
}

Outcome OperatingTable::cut_on(bool last) {
  constexpr size_t kMostCuts = 2000;  // of one act: far more than a path of 2000 points needs
  const BladeContext context = blade_context();
  std::vector<CutStep> steps;
  const auto refuse = [&](const Outcome& o) {
    take_back(steps);
    return o;
  };
  for (;;) {
    const BladeResult blade = stroke_->drawn.next(context, last);
    if (!blade.blade && blade.reason.empty()) break;
    if (!blade.blade) return refuse({false, blade.reason});
    CutStep step;
    CutResult made;
    const Outcome o = cut_arrangement(*blade.blade, false, Vec3::Zero(), step, made);
    if (o.done) {
      steps.push_back(std::move(step));
      stroke_->drawn.was_cut(made);
    } else if (made.status == CutResult::nothing_to_cut) {
      stroke_->drawn.was_nothing(context);  // over a hole, or along an earlier cut
    } else if (!stroke_->drawn.was_refused()) {
      return refuse(o);
    }
    if (steps.size() > kMostCuts)
      return refuse({false, "one piece of a stroke makes too many cuts; shorter pieces were expected"});
  }
  if (steps.empty()) return {true, {}};
  Moment before;
  if (!stroke_->cut) before = moment();
  if (const Outcome built = rebuild(); !built.done) return refuse(built);
  ++cuts_;
  for (const CutStep& s : steps) removed_volume_mm3_ += s.debris.volume_mm3;
  volume_mm3_ = arrangement_->volume_mm3();
  ParentList ancestor = version_.model->parent;
  if (!stroke_->cut) {
    remember({std::move(before), std::move(steps), std::move(ancestor)});
    stroke_->cut = true;
    return {true, {}};
  }
  Done& done = done_.back();
  std::move(steps.begin(), steps.end(), std::back_inserter(done.steps));
  done.ancestor = ancestor.through(done.ancestor);
  return {true, {}};
}

}  // namespace limberg
