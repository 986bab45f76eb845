#include "tests/bench/soak/soak.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "app/commands/command_line.h"
#include "app/operating_point/cpu_clock.h"
#include "app/program/shipped.h"
#include "app/program/temporary_folder.h"
#include "app/result/read_result.h"
#include "app/result/run_result.h"
#include "app/session/clock.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "tests/bench/soak/acts.h"

namespace limberg::bench {

namespace {

constexpr const char* kScenes[] = {"rhomboid", "craniofacial", "zplasty"};
constexpr uint64_t kSeeds = 2;

/// What the commands print is not the bench's: standard output goes nowhere, and comes back.
class Quiet {
 public:
  Quiet() : kept_(dup(STDOUT_FILENO)) {
    std::fflush(stdout);
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(nowhere, STDOUT_FILENO);
    close(nowhere);
  }
  ~Quiet() {
    std::fflush(stdout);
    dup2(kept_, STDOUT_FILENO);
    close(kept_);
  }

 private:
  int kept_;
};

/// A command of the program, in this process.
int call(const std::vector<std::string>& words) {
  const Quiet quiet;
  CLI::App app("soak", "limberg");
  Chosen chosen;
  add_emulate(app, chosen), add_run(app, chosen), add_replay(app, chosen);
  return run_command_line(app, words, chosen, "");
}

struct SoakTold {
  ResultRun run;
  int64_t compared = 0, equal = 0;
};
SoakTold soak_told(const std::string& json_file) {
  const auto json = nlohmann::json::parse(read_whole_file(json_file, size_t(1) << 28), nullptr, false);
  SoakTold t;
  result_json::read(json, t.run);
  const auto& c = result_json::member(json, "checkpoints");
  result_json::read(result_json::member(c, "compared"), t.compared);
  result_json::read(result_json::member(c, "equal"), t.equal);
  return t;
}

class Soaking {
 public:
  explicit Soaking(const SoakSettings& set) : set_(set), began_ns_(RealClock::monotonic_ns()) {
    // Whatever the commands put aside, they put here.
    std::filesystem::create_directory(temporary_);
    setenv("TMPDIR", temporary_.c_str(), 1);
    unsetenv("DISPLAY"), unsetenv("WAYLAND_DISPLAY");
  }
  double minutes() const { return double(RealClock::monotonic_ns() - began_ns_) / 6e10; }

  /// Rounds of a part, until this minute.
  void rounds(const std::string& part, double until_min) {
    for (int64_t k = 0; minutes() < until_min && !set_.stop(); ++k) {
      SoakRound r;
      const size_t scenes = std::size(kScenes);
      r.part = part, r.scene = kScenes[size_t(k) % scenes], r.seed = 1 + uint64_t(k / int64_t(scenes)) % kSeeds;
      const double cpu = cpu_ms();
      const SoakTold t = part == "live" ? live(r) : lockstep(r);
      r.hash = t.run.state_hash.value_or("");
      const double steps = double(t.run.solver.steps.value_or(0));
      if (part == "lockstep" && steps > 0) r.cpu_ms = (cpu_ms() - cpu) / steps;
      r.median_ms = t.run.solver.step_ms.p50.value_or(0), r.p95_ms = t.run.solver.step_ms.p95.value_or(0);
      if (set_.stop()) return;  // this round was cut short
      r.after = process_state(temporary_), r.at_min = minutes();
      r.after.allocated_mb -= own_mb();
      done.push_back(r);
      if (set_.progress)
        set_.progress(fmt::format("{:.1f} min: {} {} seed {}: {:.1f} MB, {:.2f} ms a step", r.at_min, part, r.scene,
                                  r.seed, r.after.trimmed_mb, r.median_ms));
      if (!set_.out_dir.empty()) write_whole_file(set_.out_dir + "/soak.csv", soak_csv(done));
    }
  }

  std::vector<SoakRound> done;

 private:
  /// What this list of rounds takes: a tenth of a MB in an hour, and nothing of the program's.
  double own_mb() const {
    size_t bytes = done.capacity() * sizeof(SoakRound);
    for (const SoakRound& r : done) bytes += r.hash.capacity() + 1;
    return 1e-6 * double(bytes);
  }
  std::string file(const char* name) const { return (folder_.path() / name).string(); }
  static std::string script(const std::string& scene) { return shipped_file("recordings/" + scene + ".jsonl"); }

  SoakTold lockstep(SoakRound& r) const {
    const std::string json = file("emulate.json");
    const int status = call({"emulate", r.scene, script(r.scene), "--out", file("stream.lcm"), "--replace", "--seed",
                             std::to_string(r.seed), "--json", json});
    r.as_expected = status == kDone || status == kGoalMissed;  // of an operation that a verdict finds fault with
    return soak_told(json);
  }

  /// The stream that the last lockstep round of this scene and seed would leave is the hand.
  SoakTold live(SoakRound& r) const {
    SoakRound hand = r;
    lockstep(hand);
    const std::string json = file("run.json"), again = file("replay.json"), live = file("live.lcm");
    const double cpu = cpu_ms();
    const int status = call({"run", r.scene, "--headless", "--device", "log:" + file("stream.lcm"), "--record", live,
                             "--replace", "--json", json});
    SoakTold t = soak_told(json);
    if (const double steps = double(t.run.solver.steps.value_or(0)); steps > 0) r.cpu_ms = (cpu_ms() - cpu) / steps;
    const int replayed = call({"replay", live, "--json", again});
    const SoakTold back = soak_told(again);
    r.as_expected = hand.as_expected && status == replayed && back.compared > 0 && back.equal == back.compared;
    return t;
  }

  const SoakSettings& set_;
  const int64_t began_ns_;
  const TemporaryFolder folder_;
  const std::filesystem::path temporary_ = folder_.path() / "temporary";
};

LineChart memory_chart(const std::vector<SoakRound>& rounds) {
  LineChart c;
  c.description = "Memory of the process after each emulated operation, against time.";
  c.x.title = "min", c.y.title = "MB resident after a round", c.y.min = 0;
  for (const char* part : {"lockstep", "live"})
    for (const char* scene : kScenes) {
      ChartSeries s;
      s.name = std::string(part) + ", " + scene, s.markers = true;
      for (const SoakRound& r : rounds)
        if (r.part == part && r.scene == scene) s.x.push_back(r.at_min), s.y.push_back(r.after.trimmed_mb);
      if (!s.x.empty()) c.series.push_back(s);
    }
  c.x_marks = {{kSettledMin, "ten minutes"}};
  return c;
}

LineChart time_chart(const std::vector<SoakRound>& rounds) {
  LineChart c = memory_chart(rounds);
  c.description = "CPU time of a solver step in each emulated operation, against time.";
  c.y.title = "ms CPU a step";
  for (ChartSeries& s : c.series) s.y.clear();
  for (ChartSeries& s : c.series)
    for (const SoakRound& r : rounds)
      if (s.name == r.part + ", " + r.scene) s.y.push_back(r.cpu_ms);
  return c;
}

void add(Result& to, const Result& more) {
  to.rows.insert(to.rows.end(), more.rows.begin(), more.rows.end());
  to.bars.insert(to.bars.end(), more.bars.begin(), more.bars.end());
  to.notes.insert(to.notes.end(), more.notes.begin(), more.notes.end());
}

}  // namespace

SuiteOutcome soak(const SoakSettings& set) {
  const auto wanted = [&](const char* part) { return std::string(part).find(set.only) != std::string::npos; };
  SuiteOutcome out;
  Soaking soaking(set);
  const bool lockstep = wanted("lockstep"), live = wanted("live");
  if (lockstep) soaking.rounds("lockstep", live ? set.minutes * 2 / 3 : set.minutes);
  if (live) soaking.rounds("live", set.minutes);
  const std::vector<SoakRound>& rounds = soaking.done;
  if (!rounds.empty()) {
    add(out.result, judge_soak(rounds));
    out.charts.emplace_back("Memory", memory_chart(rounds));
    out.charts.emplace_back("Time of a step", time_chart(rounds));
    if (!set.out_dir.empty()) {
      write_whole_file(set.out_dir + "/soak-memory.svg", in_plain_colours(svg(out.charts[0].second)));
      write_whole_file(set.out_dir + "/soak-time.svg", in_plain_colours(svg(out.charts[1].second)));
    }
  }
  if (wanted("acts") && !set.stop()) add(out.result, soak_acts(set));
  if (set.stop()) out.interrupted = "before its end; what was done until then is reported";
  return out;
}

}  // namespace limberg::bench
