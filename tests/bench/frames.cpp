#include "tests/bench/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <thread>

#include "app/assembly/assembly.h"
#include "app/assembly/operation.h"
#include "app/operating_point/cpu_clock.h"
#include "app/pictures/pictures.h"
#include "app/session/clock.h"
#include "app/session/drawing_share.h"
#include "app/session/thread.h"
#include "app/session/workers_pool.h"
#include "render/renderer.h"

namespace limberg::bench {

namespace {

double frame_wall_ms() {
  return 1e-6 * double(std::chrono::duration_cast<std::chrono::nanoseconds>(
                           std::chrono::steady_clock::now().time_since_epoch())
                           .count());
}

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

/// Loops on one of two pools, or alone.
class ChosenWorkers final : public Workers {
 public:
  explicit ChosenWorkers(int most) : alone_(1), all_(most), now_(&alone_) {}
  void use(int n) { now_ = n > 1 ? &all_ : &alone_; }
  int count() const override { return now_->count(); }
  void parallel_for(size_t n, size_t grain, const std::function<void(size_t, size_t)>& body) override {
    now_->parallel_for(n, grain, body);
  }
  std::shared_ptr<Job> submit(std::function<void()> job) override { return now_->submit(std::move(job)); }

 private:
  WorkersPool alone_, all_;
  WorkersPool* now_;
};

/// Draws the newest snapshot as often as a session does (realtime.cpp), on a thread of its own, while it is asked to.
class Painter {
 public:
  Painter(const Scene& scene, const Snapshot& first, DrawingShare& share) : share_(share), shown_(first) {
    thread_ = std::make_unique<ScheduledThread>([this, camera = scene_camera(scene)] {
      be_nice(5);
      Renderer renderer(make_offscreen_context(0));
      SceneBuilder builder;
      for (double due = frame_wall_ms(); !stop_;) {
        std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(std::max(1.0, due - frame_wall_ms())));
        if (!paint_) continue;
        const int64_t cpu = thread_cpu_ns();
        share_.picture_begins(RealClock::monotonic_ns());
        Snapshot s;
        {
          const std::lock_guard lock(mutex_);
          s = shown_;
        }
        const View view = camera.view(640.0 / 480);
        renderer.paint(builder.build(s), std::span(&view, 1), draw_options(kQualityLevels[size_t(level_)], 640, 480));
        renderer.compose(640, 480);
        renderer.read();
        ++frames_;
        const int64_t pause = share_.picture_ended(RealClock::monotonic_ns(), thread_cpu_ns() - cpu);
        due = std::max(due + 33, frame_wall_ms() + double(pause) * 1e-6);
      }
    });
  }
  ~Painter() { stop_ = true; }
  void paint(bool on) { paint_ = on; }
  void level(int l) { level_ = l; }
  void show(const Snapshot& s) {
    const std::lock_guard lock(mutex_);
    shown_ = s;
  }
  int frames() const { return frames_; }

 private:
  DrawingShare& share_;
  std::mutex mutex_;
  Snapshot shown_;
  std::atomic<bool> stop_{false}, paint_{false};
  std::atomic<int> frames_{0}, level_{kFastLevel};
  std::unique_ptr<ScheduledThread> thread_;  // last: joined before what it uses goes
};

struct Loss {
  double share = 0, pictures_per_s = 0;  // of the solver's step
  int pictures = 0;
};

/// Steps of a drag with and without pictures, in turns.
Loss solver_beside(World& world, const Scene& scene, Snapshot& snapshot, int level, int blocks, const std::string& who,
                   Result& out) {
  DrawingShare share;
  Painter painter(scene, snapshot, share);
  painter.level(level);
  world.apply(SetHook{901, {0, 0}});
  StepSettings step = step_settings(scene, false);
  step.tolerance = 0;  // every step does all its iterations
  Times alone, beside;
  double painted_ms = 0;
  int k = 0, pictures_before = 0;
  // First until the share is known (drawing_share.h), uncounted.
  for (int block = -6; block < 2 * blocks; ++block) {
    const bool drawn = block % 2 != 0;
    painter.paint(drawn);
    std::this_thread::sleep_for(std::chrono::milliseconds(40));
    if (block == 0) pictures_before = painter.frames();
    const double block_began = frame_wall_ms();
    for (int i = 0; i < 15; ++i, ++k) {
      world.apply(MoveHook{901, {0, 0, 4 + 3 * std::sin(0.1 * k)}, 0});
      const double began = frame_wall_ms();
      share.step_begins(RealClock::monotonic_ns());
      const StepReport report = world.step(step);
      share.step_ended(RealClock::monotonic_ns(), report.iterations);
      if (block >= 0) (drawn ? beside : alone).add(frame_wall_ms() - began);
      if (drawn) world.fill(snapshot), painter.show(snapshot);
      std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(
          std::max(0.0, 1000 / scene.steps_per_s - (frame_wall_ms() - began))));
    }
    if (drawn && block >= 0) painted_ms += frame_wall_ms() - block_began;
  }
  painter.paint(false);
  world.apply(ReleaseHook{901});
  for (const auto& [name, t] : {std::pair<const char*, const Times&>{"alone", alone}, {"beside pictures", beside}}) {
    double sum = 0;
    for (const double ms : t.ms) sum += ms;
    Row r;
    r.name = "solver step, " + who;
    r.method = name;
    r.time_ms = sum / double(std::max<size_t>(1, t.ms.size())), r.error_unit = "ms", r.reference = "wall time, mean",
    r.settings = std::to_string(t.ms.size()) + " steps";
    out.rows.push_back(r);
  }
  Loss loss;
  const auto mean = [](const Times& t) {  // without the slowest twentieth: those met something else on the machine
    std::vector<double> v = t.ms;
    std::sort(v.begin(), v.end());
    v.resize(v.size() - v.size() / 20);
    double sum = 0;
    for (const double ms : v) sum += ms;
    return v.empty() ? 0.0 : sum / double(v.size());
  };
  loss.share = mean(alone) > 0 ? std::max(0.0, mean(beside) / mean(alone) - 1) : 0;
  loss.pictures = painter.frames() - pictures_before;
  loss.pictures_per_s = 1000.0 * loss.pictures / std::max(1.0, painted_ms);
  const std::string note = fmt::format(
      "{}: {:.1f} pictures a second beside it ({}); drawing may take {:.0f} % of the time, at a measured loss of "
      "{:.0f} % while it draws",
      who, loss.pictures_per_s, loss.pictures, 100 * share.share(), 100 * std::max(0.0, share.loss()));
  out.notes.push_back(note);
  return loss;
}

}  // namespace

Result frames(const Scene& scene, const Script* script, const FramesSettings& set) {
  Result out;
  const auto say = [&](const std::string& line) {
    if (set.progress) set.progress(line);
  };
  software_drawing_threads(0);
  const int cores = std::max(1, int(std::thread::hardware_concurrency()));
  ChosenWorkers workers(cores);
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
  const std::vector<std::array<int, 2>> sizes =
      set.quick ? std::vector<std::array<int, 2>>{{64, 48}, {640, 480}}
                : std::vector<std::array<int, 2>>{{64, 48}, {640, 480}, {1280, 720}, {1920, 1080}};
  for (const auto& [width, height] : sizes)
    for (const QualityLevel& q : kQualityLevels) {
      say(std::to_string(width) + " x " + std::to_string(height) + ", " + q.name);
      const View view = camera.view(double(width) / height);
      Times wall, cpu;
      for (int i = 0; i < (set.quick ? 3 : 7); ++i) {
        const double c = cpu_ms(), w = frame_wall_ms();
        const RenderScene& shown = builder.build(snapshot);
        const DrawOptions o = draw_options(q, width, height);
        if (q.supersample > 1)
          renderer.draw(shown, view, o);
        else
          renderer.paint(shown, std::span(&view, 1), o), renderer.compose(width, height), renderer.read();
        if (i > 0) wall.add(frame_wall_ms() - w), cpu.add(cpu_ms() - c);  // the first one warms up
      }
      Row r;
      r.name = std::to_string(width) + " x " + std::to_string(height);
      r.method = q.name;
      r.time_ms = cpu.median(), r.error = wall.median(), r.error_unit = "ms";
      r.reference = "wall time beside it";
      r.settings = std::to_string(triangles) + " triangles; right: wall time";
      out.rows.push_back(r);
    }

  out.notes.push_back("renderer: " + renderer.describe());

  const int blocks = set.quick ? 4 : 10;
  for (const int n : cores > 1 ? std::vector<int>{1, cores} : std::vector<int>{1}) {
    workers.use(n);
    const std::string who = std::to_string(n) + (n == 1 ? " worker" : " workers");
    say("the solver beside pictures, " + who);
    const Loss loss = solver_beside(world, scene, snapshot, 0, blocks, who, out);
    Bar b;
    b.name = "solver's loss beside pictures of 640 x 480, share of its step, " + who;
    b.value = loss.share;
    b.bar = 0.2, b.larger_is_better = false,
    b.pass = b.value <= b.bar && loss.pictures >= blocks;  // without pictures it says nothing
    b.source = "rendering must not take more than its share from the solver: 20 %";
    out.bars.push_back(b);
    Bar p;
    p.name = "pictures a second that remain, " + who;
    p.value = loss.pictures_per_s;
    p.bar = 10, p.larger_is_better = true, p.pass = p.value >= p.bar;
    p.source = "fewer than 10 a second are no motion";
    out.bars.push_back(p);
  }
  return out;
}

}  // namespace limberg::bench
