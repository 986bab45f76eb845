#include "app/bench/frames.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <thread>

#include "app/assembly.h"
#include "app/bench/cpu_clock.h"
#include "app/operation.h"
#include "app/pictures.h"
#include "app/session/thread.h"
#include "app/session/workers_pool.h"
#include "render/renderer.h"

namespace limberg::bench {

namespace {

double wall_ms() { return 1e-6 * double(std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count()); }

/// The script up to its first stitch.
Script opened(const Script& script) {
  Script s = script;
  for (size_t i = 0; i < s.lines.size(); ++i)
    if (std::holds_alternative<Suture>(s.lines[i].command) || std::holds_alternative<SutureRow>(s.lines[i].command)) {
      s.lines.resize(i);
      break;
    }
  return s;
}

/// Draws the newest snapshot 30 times a second on a thread of its own, as a session does, while it is asked to.
class Painter {
 public:
  Painter(const Scene& scene, const Snapshot& first) : shown_(first) {
    thread_ = std::make_unique<Thread>([this, camera = scene_camera(scene)] {
      be_nice(5);
      Renderer renderer(make_offscreen_context(0));
      SceneBuilder builder;
      for (double next = wall_ms(); !stop_; next = std::max(next + 1000.0 / 30, wall_ms())) {
        if (paint_) {
          Snapshot s;
          {
            const std::lock_guard lock(mutex_);
            s = shown_;
          }
          const View view = camera.view(640.0 / 480);
          renderer.paint(builder.build(s), std::span(&view, 1), draw_options(kQualityLevels[kFastLevel], 640, 480));
          renderer.read();
          ++frames_;
        }
        std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(std::max(1.0, next + 1000.0 / 30 - wall_ms())));
      }
    });
  }
  ~Painter() { stop_ = true; }
  void paint(bool on) { paint_ = on; }
  void show(const Snapshot& s) {
    const std::lock_guard lock(mutex_);
    shown_ = s;
  }
  int frames() const { return frames_; }

 private:
  std::mutex mutex_;
  Snapshot shown_;
  std::atomic<bool> stop_{false}, paint_{false};
  std::atomic<int> frames_{0};
  std::unique_ptr<Thread> thread_;  // last: joined before what it uses goes
};

}  // namespace

Result frames(const Scene& scene, const Script* script, const FramesSettings& set) {
  Result out;
  const auto say = [&](const std::string& line) {
    if (set.progress) set.progress(line);
  };
  WorkersPool workers(1);
  World world(world_spec(scene, build_body(scene)), workers);
  if (script) {
    OperationSettings quickly;
    quickly.rest_residual = 1e-3, quickly.final_residual = 1e-3, quickly.final_steps = 60;
    say("the patient is prepared");
    operate(world, scene.tools.max_depth_mm, opened(*script), quickly);
  }
  Snapshot snapshot;
  world.fill(snapshot);
  const size_t triangles = snapshot.topology->view.tri.size();

  Renderer renderer(make_offscreen_context());
  SceneBuilder builder;
  const Camera camera = scene_camera(scene);
  const std::vector<std::array<int, 2>> sizes = set.quick ? std::vector<std::array<int, 2>>{{640, 480}} : std::vector<std::array<int, 2>>{{640, 480}, {1280, 720}, {1920, 1080}};
  for (const auto& [width, height] : sizes)
    for (const QualityLevel& q : kQualityLevels) {
      say(std::to_string(width) + " x " + std::to_string(height) + ", " + q.name);
      const View view = camera.view(double(width) / height);
      Times wall, cpu;
      for (int i = 0; i < (set.quick ? 3 : 7); ++i) {
        const double c = cpu_ms(), w = wall_ms();
        const Image image = renderer.draw(builder.build(snapshot), view, draw_options(q, width, height));
        if (i > 0) wall.add(wall_ms() - w), cpu.add(cpu_ms() - c);  // the first one warms up
      }
      Row r;
      r.name = std::to_string(width) + " x " + std::to_string(height);
      r.method = q.name;
      r.time_ms = cpu.median(), r.error = wall.median(), r.error_unit = "ms";
      r.reference = "wall time beside it";
      r.settings = std::to_string(triangles) + " triangles; right: wall time";
      out.rows.push_back(r);
    }

  // The solver beside a picture: blocks of steps in turns.
  say("the solver beside a picture");
  Painter painter(scene, snapshot);
  world.apply(SetHook{901, {0, 0}});
  const StepSettings step = [&] {
    StepSettings s = step_settings(scene, false);
    s.tolerance = 0;  // every step does all its iterations
    return s;
  }();
  Times alone, beside;
  int k = 0;
  const int blocks = set.quick ? 4 : 12;
  for (int block = 0; block < 2 * blocks; ++block) {
    const bool drawn = block % 2 == 1;
    painter.paint(drawn);
    std::this_thread::sleep_for(std::chrono::milliseconds(40));
    for (int i = 0; i < 15; ++i, ++k) {
      world.apply(MoveHook{901, {0, 0, 4 + 3 * std::sin(0.1 * k)}, 0});
      const double began = wall_ms();
      world.step(step);
      (drawn ? beside : alone).add(wall_ms() - began);
      if (drawn) world.fill(snapshot), painter.show(snapshot);
      std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(std::max(0.0, 1000 / scene.steps_per_s - (wall_ms() - began))));
    }
  }
  for (const auto& [name, t] : {std::pair<const char*, const Times&>{"alone", alone}, {"beside 30 frames a second", beside}}) {
    Row r;
    r.name = "solver step";
    r.method = name;
    r.time_ms = t.median(), r.error_unit = "ms", r.reference = "wall time, median", r.settings = std::to_string(t.ms.size()) + " steps";
    out.rows.push_back(r);
  }
  Bar b;
  b.name = "solver's loss beside a picture of 640 x 480, share of its step";
  b.value = alone.median() > 0 ? std::max(0.0, beside.median() / alone.median() - 1) : 0;
  const int least = blocks * 15 / 8;  // a block takes a quarter of a second or more: at least four frames a second
  b.bar = 0.2, b.larger_is_better = false, b.pass = b.value <= b.bar && painter.frames() >= least;
  b.source = "rendering must not take more than its share from the solver: 20 %";
  out.bars.push_back(b);
  out.notes.push_back("renderer: " + renderer.describe());
  out.notes.push_back(std::to_string(painter.frames()) + " frames were drawn beside the solver" +
                      (painter.frames() < least ? ": too few for the bar to say anything, the machine is busy with other things" : ""));
  return out;
}

}  // namespace limberg::bench
