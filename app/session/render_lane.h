#pragma once
// The render thread's work on one frame, without the thread: the newest patient goes to the picture sink; nothing is
// drawn when neither patient nor hand changed. Every stage that was passed gets its picture, once.
#include <deque>
#include <string>
#include <vector>

#include "app/session/channels.h"
#include "app/session/picture_sink.h"
#include "app/session/visible.h"

namespace limberg {

class RenderLane {
 public:
  /// `sink` may be null: then nothing is drawn.
  /// `frames`: false draws stages only.
  RenderLane(Channels& channels, PictureSink* sink, bool frames) : ch_(channels), sink_(sink), frames_(frames) {}

  void prepare() {
    ch_.patient_to_render.update();
    const Snapshot& s = ch_.patient_to_render.reading().snapshot;
    if (sink_ && s.topology) sink_->prepare(*s.topology);
  }

  /// After the last frame, on the thread that prepared.
  void finish() {
    if (sink_) sink_->finish();
  }

  /// True when something was drawn.
  bool frame() {
    const bool new_patient = ch_.patient_to_render.update(), new_hand = ch_.hand_to_render.update();
    const Snapshot& s = ch_.patient_to_render.reading().snapshot;
    for (StageMark m; ch_.stages.pop(m);) waiting_.push_back(m);
    bool drawn = false;
    if (sink_ && s.topology) {
      while (!waiting_.empty() && waiting_.front().number <= s.stage) {
        sink_->stage(waiting_.front().name.str(), s);
        waiting_.pop_front();
        drawn = true;
      }
      for (Notice n; ch_.notices.pop(n);) sink_->notice(n);
      for (MissedPress m; ch_.missed.pop(m);) sink_->missed(m, s);
      ch_.want_lattice.store(sink_->wants_lattice(), std::memory_order_relaxed);
      ch_.want_field.store(sink_->wants_field(), std::memory_order_relaxed);
      if (frames_ && (sink_->wants_frame() || (new_patient && patient_changed(s)) || (new_hand && hand_changed()))) {
        if (sink_->wants_lattice()) sink_->lattice(ch_.patient_to_render.reading().lattice);
        sink_->second_hand(ch_.hand_to_render.reading().glove, ch_.hand_to_render.reading().other_glove);
        sink_->frame(s, ch_.hand_to_render.reading().tool);
        drawn = true;
        ++frames_drawn_;
        remember(s);
      } else if (frames_ && frames_drawn_ > 0) {
        sink_->same_frame();
      }
    }
    return drawn;
  }

  uint64_t frames() const { return frames_drawn_; }
  int64_t sample_ns() const { return ch_.patient_to_render.reading().sample_ns; }
  int64_t device_tick() const { return ch_.patient_to_render.reading().snapshot.device_tick; }
  bool open() const { return !sink_ || sink_->open(); }

 private:
  bool hand_changed() const {
    const ToolState& t = ch_.hand_to_render.reading().tool;
    return visibly_moved(t.tip_mm, shown_tool_.tip_mm) || t.tool != shown_tool_.tool ||
           t.pressed != shown_tool_.pressed || t.valid != shown_tool_.valid ||
           glove_changed(ch_.hand_to_render.reading().glove, shown_glove_) ||
           glove_changed(ch_.hand_to_render.reading().other_glove, shown_other_);
  }
  static bool glove_changed(const SecondHand& g, const SecondHand& old) {
    if (g.valid != old.valid) return true;
    if (!g.valid) return false;
    constexpr double kRay_mm = 60;  // as long is a ray that meets nothing
    return g.closed != old.closed || g.points != old.points || g.held_hook != old.held_hook ||
           g.carried.holds != old.carried.holds || visibly_moved(g.forefinger_mm, old.forefinger_mm) ||
           visibly_moved(g.thumb_mm, old.thumb_mm) || (g.points && visibly_moved(g.pointed_mm, old.pointed_mm)) ||
           visibly_moved(g.pointing, old.pointing, kRay_mm);
  }
  bool patient_changed(const Snapshot& s) const {
    return frames_drawn_ == 0 || s.topology_version != shown_version_ || s.hooks.size() != shown_hooks_ ||
           s.sutures.size() != shown_sutures_ || s.field.empty() != shown_plain_ || visibly_moved(s.x_mm, shown_x_);
  }
  void remember(const Snapshot& s) {
    shown_tool_ = ch_.hand_to_render.reading().tool, shown_glove_ = ch_.hand_to_render.reading().glove;
    shown_other_ = ch_.hand_to_render.reading().other_glove;
    shown_version_ = s.topology_version;
    shown_hooks_ = s.hooks.size(), shown_sutures_ = s.sutures.size();
    shown_x_ = s.x_mm;
    shown_plain_ = s.field.empty();
  }

  Channels& ch_;
  PictureSink* sink_;
  bool frames_;
  std::deque<StageMark> waiting_;
  uint64_t frames_drawn_ = 0;
  // What the last frame showed.
  ToolState shown_tool_;
  SecondHand shown_glove_, shown_other_;
  uint64_t shown_version_ = 0;
  size_t shown_hooks_ = 0, shown_sutures_ = 0;
  std::vector<Vec3f> shown_x_;
  bool shown_plain_ = true;  // without the tension
};

}  // namespace limberg
