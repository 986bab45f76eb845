#pragma once
// A window that is drawn into memory, between a snapshot and whoever presses keys.
#include <memory>

#include "app/assembly/lesson.h"
#include "app/program/places.h"
#include "app/scene/scene.h"
#include "app/teaching/lesson_plan.h"
#include "app/window/input_router.h"
#include "app/window/window_frames.h"
#include "render/gl_context.h"
#include "sim/commands/script.h"

namespace limberg::testing {

class MemoryScreen final : public Screen {
 public:
  std::unique_ptr<GlContext> context() override { return make_osmesa_context({.threads = 0}); }
};

/// Down and up again; nothing looks at what comes of it yet.
inline void press_key(InputRouter& router, int32_t code, uint32_t mods = 0) {
  WindowEvent e;
  e.kind = WindowEvent::key, e.code = code, e.down = 1, e.mods = mods;
  router.take(e);
  e.down = 0;
  router.take(e);
}

/// A shipped lesson with its scene and the plan of its recorded script.
struct ShippedLesson {
  Lesson lesson;
  Scene scene;
  LessonPlan plan;
  explicit ShippedLesson(const std::string& name, const Words& words = {})
      : lesson(open_lesson(source_dir() + "/app/lessons/" + name + ".toml")),
        scene(load_scene(source_dir() + "/app/scenes/" + lesson.scene + ".toml")) {
    std::vector<Command> script;
    for (const ScriptLine& l : load_script(source_dir() + "/recordings/" + name + ".jsonl").lines)
      script.push_back(l.command);
    plan = make_lesson_plan(&lesson, script, words);
  }
};

struct DrawnWindow {
  MemoryScreen screen;
  HandFeed feed;
  InputRouter router{screen, feed};
  Snapshot s;
  std::unique_ptr<WindowFrames> frames;

  explicit DrawnWindow(Snapshot patient) : s(std::move(patient)) {}
  void open(const WindowSettings& set, const LaneGauges* gauges) {
    frames = std::make_unique<WindowFrames>(screen, feed, gauges, set);
    frames->prepare(*s.topology);
    settle();
  }
  void settle() {
    for (int i = 0; i < 4; ++i) router.pump(0), frames->wants_frame(), frames->frame(s, ToolState{});
    router.pump(0);
  }
  void key(int32_t code, uint32_t mods = 0) {
    press_key(router, code, mods);
    settle();
  }
};

}  // namespace limberg::testing
