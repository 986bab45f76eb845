// Incisions that open while they are drawn: piece by piece, each atomic, undone as one.
#include "sim/world/operating_table.h"

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
  if (!stroke_ || stroke_->id != c.stroke) stroke_ = Stroke{c.stroke, DrawnIncision(c.depth_mm, c.angle_deg)};
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
  const BladeResult blade = stroke_->drawn.next(blade_context(), last);
  if (!blade.blade) return {blade.reason.empty(), blade.reason};
  Moment before;
  if (!stroke_->cut) before = moment();
  CutStep step;
  CutResult made;
  if (const Outcome o = cut_arrangement(*blade.blade, false, Vec3::Zero(), step, made); !o.done) {
    if (made.status != CutResult::nothing_to_cut) return o;
    stroke_->drawn.was_nothing(blade_context());  // over a hole, or along an earlier cut
    return {true, {}};
  }
  if (const Outcome built = rebuild(); !built.done) {
    take_back({&step, 1});
    return built;
  }
  stroke_->drawn.was_cut(made);
  ++cuts_;
  removed_volume_mm3_ += step.debris.volume_mm3;
  volume_mm3_ = arrangement_->volume_mm3();
  std::vector<int32_t> ancestor = version_.model->parent;
  if (!stroke_->cut) {
    Done done;
    done.before = std::move(before);
    done.steps.push_back(std::move(step));
    done.ancestor = std::move(ancestor);
    remember(std::move(done));
    stroke_->cut = true;
    return {true, {}};
  }
  Done& done = done_.back();
  done.steps.push_back(std::move(step));
  for (int32_t& a : ancestor)
    if (a >= 0) a = done.ancestor[size_t(a)];
  done.ancestor = std::move(ancestor);
  return {true, {}};
}

}  // namespace limberg
