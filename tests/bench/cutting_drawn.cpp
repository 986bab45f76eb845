// An incision of a patient's length that is drawn on a face: what the steps cost in which the cut goes on.
//
// As a live hand draws it: 60 mm a second, a step of the solver for every millimetre, each with the one iteration that
// a step has left which is late already. The tissue gives way to the blade, so the wound opens on the way; contact and
// divided fronts are the scene's. By the clock on the wall, with the machine's workers, as the solver thread has them.
#include <fmt/format.h>

#include <chrono>
#include <thread>

#include "app/assembly/operation.h"
#include "app/program/shipped.h"
#include "app/scene/scene.h"
#include "app/session/workers_pool.h"
#include "sim/commands/script.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/bench/cutting_parts.h"

namespace limberg::bench {
namespace {

constexpr double kPiece_mm = 1;
constexpr const char* kIssue = "issue 28: the update of an incision that is drawn live on a face";

double wall_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The longest incision of a script, a point every kPiece_mm.
std::vector<ChartPoint> longest_incision(const Script& script, double at_most_mm) {
  std::vector<ChartPoint> best;
  for (const ScriptLine& line : script.lines)
    if (const auto* cut = std::get_if<Incise>(&line.command); cut && cut->path.size() > best.size()) best = cut->path;
  std::vector<ChartPoint> out;
  double along = 0, next = 0;
  for (size_t i = 1; i < best.size(); ++i) {
    const double length = (best[i] - best[i - 1]).norm();
    for (; next <= along + length && next <= at_most_mm; next += kPiece_mm)
      out.push_back(best[i - 1] + (next - along) / length * (best[i] - best[i - 1]));
    along += length;
  }
  return out;
}

}  // namespace

void drawn_incision(Result& out, const CuttingSettings& settings) {
  say(settings, "drawn on a face: scene");
  const Scene scene = load_scene(shipped_file("app/scenes/face_side.toml"));
  const Script script = load_script(shipped_file("recordings/cheek-cervicofacial.jsonl"));
  const std::vector<ChartPoint> path = longest_incision(script, settings.quick ? 12 : 1000);
  WorkersPool workers(std::max(1, int(std::thread::hardware_concurrency())));
  World world(world_spec(scene, build_body(scene)), workers);
  StepSettings late;
  late.max_iterations = 1, late.adopt_when_ready = true;
  for (int i = 0; i < 20; ++i) world.step(late);

  say(settings, "drawn on a face: incision");
  Times act, step, other;
  uint64_t version = world.topology()->version;
  for (size_t i = 1; i < path.size(); ++i) {
    InciseMore more;
    more.path = {path[i - 1], path[i]}, more.last = i + 1 == path.size();
    const double start = wall_ms();
    if (const Outcome o = world.apply(more); !o.done)
      throw std::runtime_error("bench cutting: an incision that is drawn was refused: " + o.reason);
    const double cut = wall_ms();
    world.step(late);
    const double end = wall_ms();
    const bool went_on = world.topology()->version != version;
    version = world.topology()->version;
    if (went_on) act.add(cut - start);
    (went_on ? step : other).add(end - start);
  }
  const std::string how = fmt::format("{:.0f} mm drawn at {:g} mm a step, {} nodes at its end, {} workers",
                                      double(path.size() - 1) * kPiece_mm, kPiece_mm,
                                      world.skin()->solver().model().X_mm.size(), workers.count());
  const auto add = [&](const char* method, const Times& t) {
    add_row(out, "incision drawn on a face", method,
            how + fmt::format("; 95 % {:.1f} ms, longest {:.1f}", t.percentile(0.95), t.percentile(1)), t);
  };
  add("the cut goes on: topology, model, what holds", act);
  add("the whole step in which it does, with contact and metric", step);
  add("a step in which it does not", other);
  if (settings.quick) return;
  add_bar(out, "a cut that goes on, drawn on a face, 95 % by the clock (ms)", act.percentile(0.95), 8, false, kIssue);
  add_bar(out, "the whole step of it, 95 % by the clock (ms)", step.percentile(0.95), 8, false, kIssue);
}

}  // namespace limberg::bench
