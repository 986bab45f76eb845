#include "app/window/run_window.h"

#include "app/pictures/pictures.h"
#include "app/session/clock.h"
#include "app/window/glfw_screen.h"
#include "app/window/input_router.h"
#include "app/window/pointer_source.h"
#include "app/window/waiting.h"
#include "app/window/window_frames.h"

namespace limberg {

namespace {

DeskFacts facts(const Scene& scene, const WindowCall& call) {
  DeskFacts f;
  f.scene = scene.name;
  f.w = call.w;
  f.device = call.device.empty() ? english("mouse") : call.device;
  f.own_device = call.own_device, f.calibrated = call.calibrated;
  f.recording = call.recording;
  f.goal = call.w(call.lesson ? call.lesson->goal : scene.note);
  f.head = scene.head.has_value(), f.skin = scene.flesh;
  if (scene.head) f.normal_files = scene.head->normal_files;
  f.max_depth_mm = scene.tools.max_depth_mm;
  f.word = call.w.said(call.word);
  return f;
}

std::optional<LessonPlan> plan(const WindowCall& call) {
  if (call.script.empty()) return std::nullopt;
  return make_lesson_plan(call.lesson ? &*call.lesson : nullptr, call.script, call.w);
}

class MouseWindow final : public SessionWindow {
 public:
  MouseWindow(const Scene& scene, const WindowCall& call)
      : mouse_(call.mouse),
        screen_(open_glfw_screen("Limberg: " + scene.name, 1280, 720)),
        router_(*screen_, feed_, call.mouse),
        headset_(call.headset),
        frames_(*screen_, feed_, &gauges_,
                {facts(scene, call), scene_camera(scene), call.picture_dir, plan(call), call.mode, desk_memory_file(),
                 call.headset}) {
    show_words(*screen_, call.w(scene.head ? english("Making the head ...") : english("Making the patient ...")));
    screen_->on_event = [this](const WindowEvent& e) { router_.take(e); };
  }
  PictureSink& sink() override { return frames_; }
  std::unique_ptr<Source> pointer(Channels& channels) override {
    router_.look_with([&channels](bool wanted) -> const Snapshot* {
      channels.want_patient_shown.store(wanted, std::memory_order_relaxed);
      if (!wanted) return nullptr;
      channels.patient_to_main.update();
      return &channels.patient_to_main.reading().snapshot;
    });
    return std::make_unique<PointerSource>(feed_, mouse_);
  }
  LaneGauges& gauges() override { return gauges_; }
  void pump() override {
    screen_->pump();
    if (headset_) hear_tablet();
    router_.pump(RealClock::monotonic_ns());
  }
  bool keep_recording() const override { return feed_.keep_recording.load(); }

 private:
  // Who points at the tablet points at the window.
  void hear_tablet() {
    for (TabletEvent t; headset_->events.pop(t);) {
      WindowEvent e;
      e.kind = t.button ? WindowEvent::button : WindowEvent::pointer;
      e.x = t.u * float(screen_->width), e.y = t.v * float(screen_->height);
      e.code = 0, e.down = t.down;
      router_.take(e);
    }
  }

  bool mouse_;
  LaneGauges gauges_;
  HandFeed feed_;
  std::unique_ptr<DesktopScreen> screen_;
  InputRouter router_;
  std::shared_ptr<HeadsetShared> headset_;
  WindowFrames frames_;
};

}  // namespace

std::unique_ptr<SessionWindow> open_window(const Scene& scene, const WindowCall& call) {
  return std::make_unique<MouseWindow>(scene, call);
}

}  // namespace limberg
