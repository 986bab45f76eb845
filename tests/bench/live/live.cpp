#include "tests/bench/live/live.h"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/program/shipped.h"
#include "app/program/temporary_folder.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "tests/bench/devices/hogs.h"
#include "tests/bench/start/child.h"

namespace limberg::bench {

namespace {

/// Two cores, and who is started from here stays on them.
class OnTwoCores {
 public:
  explicit OnTwoCores(const std::vector<int>& cores) {
    sched_getaffinity(0, sizeof before_, &before_);
    cpu_set_t these;
    CPU_ZERO(&these);
    for (const int c : cores) CPU_SET(c, &these);
    sched_setaffinity(0, sizeof these, &these);
  }
  ~OnTwoCores() { sched_setaffinity(0, sizeof before_, &before_); }
  OnTwoCores(const OnTwoCores&) = delete;
  OnTwoCores& operator=(const OnTwoCores&) = delete;

 private:
  cpu_set_t before_{};
};

/// The cores that this process may use, in pairs; what has only one has it alone.
std::vector<std::vector<int>> pairs_of_cores() {
  cpu_set_t mine;
  CPU_ZERO(&mine);
  sched_getaffinity(0, sizeof mine, &mine);
  std::vector<std::vector<int>> pairs;
  for (int c = 0; c < CPU_SETSIZE; ++c) {
    if (!CPU_ISSET(c, &mine)) continue;
    if (pairs.empty() || pairs.back().size() == 2) pairs.emplace_back();
    pairs.back().push_back(c);
  }
  if (pairs.size() > 1 && pairs.back().size() < 2) pairs.pop_back();
  return pairs;
}

using Json = nlohmann::json;

double number(const Json& result, const char* pointer) {
  const Json::json_pointer at(pointer);
  return result.contains(at) && result.at(at).is_number() ? result.at(at).get<double>() : 0;
}

struct Ended {
  LiveRun run;
  double lasts_s = 0;
};

Ended read_run(int status, const std::string& json_file) {
  Ended e;
  e.run.status = status;
  if (!std::filesystem::exists(json_file)) return e;
  const Json r = Json::parse(read_whole_file(json_file), nullptr, false);
  if (r.is_discarded()) return e;
  LiveRun& x = e.run;
  x.acts = int(number(r, "/commands"));
  for (const LiveFigure& f : kLiveFigures)
    if (r.contains("metrics") && r["metrics"].contains(f.name))
      x.figures[f.name] = number(r, (std::string("/metrics/") + f.name).c_str());
  x.step_p50_ms = number(r, "/solver/step_ms/p50"), x.step_p95_ms = number(r, "/solver/step_ms/p95");
  x.step_p99_ms = number(r, "/solver/step_ms/p99");
  x.age_p50_ms = number(r, "/device/snapshot_age_ms/p50"), x.age_p99_ms = number(r, "/device/snapshot_age_ms/p99");
  x.waited_s = 1e-3 * number(r, "/solver/waited_ms");
  x.skipped = int64_t(number(r, "/solver/skipped_steps")), x.lost = int64_t(number(r, "/device/events_lost"));
  x.memory_mb = number(r, "/memory_mb");
  e.lasts_s = number(r, "/duration_s");
  return e;
}

/// `limberg replay RECORDING ...` as a child of this thread.
Ended played(const std::string& program, const std::string& recording, bool real_time, const std::string& folder) {
  std::filesystem::create_directories(folder);
  const std::string json = folder + "/result.json";
  std::filesystem::remove(json);
  std::vector<std::string> words{program, "replay", recording, "--json", json, "--workers", "2"};
  words.push_back(real_time ? "--realtime" : "--lockstep");
  return read_run(run_child(words, folder + "/loader").status, json);
}

struct Recording {
  std::string name, file;
};

/// An operation that is not shipped as a recording: carried out by an emulated hand first. A hand that does not do well
/// (3) leaves a recording, too.
Recording emulated(const std::string& program, const std::string& name, const std::string& scene,
                   const std::string& script, const std::string& folder) {
  const std::string log = folder + "/" + name + ".lcm";
  const int status =
      run_child({program, "emulate", scene, script, "--out", log, "--seed", "1"}, folder + "/loader").status;
  if (status != 0 && status != 3)
    throw InputError(program, 0, "the operation " + name + " cannot be emulated; expected exit status 0 or 3");
  return {name, log};
}

/// A bilobed flap, planned on a block.
Recording bilobed(const std::string& program, const std::string& folder) {
  const std::string script = folder + "/bilobed.jsonl";
  if (run_child({program, "procedure", "bilobed", "--at", "0,5", "--out", script}, folder + "/loader").status != 0)
    throw InputError(program, 0, "the bilobed flap cannot be planned; expected exit status 0");
  return emulated(program, "bilobed", "rhomboid", script, folder);
}

}  // namespace

Result live(const LiveSettings& set) {
  std::error_code ec;
  const std::string program = (std::filesystem::read_symlink("/proc/self/exe", ec).parent_path() / "limberg").string();
  const TemporaryFolder folder;
  const auto say = [&](const std::string& line) {
    if (set.progress) set.progress(line);
  };
  std::vector<Recording> recordings;
  const auto wanted = [&](const char* name) { return std::string(name).find(set.only) != std::string::npos; };
  if (!set.recording.empty()) {
    if (!std::filesystem::exists(set.recording))
      throw InputError(set.recording, 0, "no such file; expected a recording, or nothing for those that are shipped");
    recordings.push_back({std::filesystem::path(set.recording).stem().string(), set.recording});
  } else {
    for (const char* name : {"rhomboid", "zplasty", "craniofacial"})
      if (wanted(name) && (!set.quick || std::string(name) == "rhomboid"))
        recordings.push_back({name, shipped_file(std::string("recordings/") + name + ".lcm")});
    if (wanted("bilobed") && !set.quick) {
      say("a bilobed flap");
      recordings.push_back(bilobed(program, folder.path().string()));
    }
    if (wanted("cheek") && !set.quick) {
      say("a rhomboid flap on the cheek of a face");
      recordings.push_back(
          emulated(program, "cheek", "face", shipped_file("recordings/cheek-rhomboid.jsonl"), folder.path().string()));
    }
  }

  // Lockstep first: what the live runs are compared with. Then the runs, each by the next pair of cores that is free.
  std::map<std::string, LiveRun> lockstep;
  std::vector<LiveRow> rows;
  std::deque<size_t> due;  // of which row the next run is
  for (const Recording& r : recordings) {
    say(r.name + ", lockstep");
    const Ended e = played(program, r.file, false, (folder.path() / "lockstep").string());
    if (e.run.status != 0 && e.run.status != 3)
      throw InputError(r.file, 0,
                       "cannot be replayed in lockstep; expected a recording that limberg replay carries out");
    lockstep[r.name] = e.run;
    for (const int neighbours : {0, 1, 2}) {
      if (set.quick && neighbours > 0) continue;
      rows.push_back({r.name, neighbours, e.lasts_s, {}});
      for (int64_t k = 0; k < (set.quick ? 1 : set.runs); ++k) due.push_back(rows.size() - 1);
    }
  }
  std::mutex guard;  // of due, rows and what is said
  const auto lane = [&](const std::vector<int>& cores, size_t number) {
    const OnTwoCores pinned(cores);
    const std::string mine = (folder.path() / ("lane-" + std::to_string(number))).string();
    for (;;) {
      size_t at = 0;
      std::string file;
      {
        const std::lock_guard lock(guard);
        if (due.empty() || (set.stop && set.stop())) return;
        at = due.front(), due.pop_front();
        for (const Recording& r : recordings)
          if (r.name == rows[at].recording) file = r.file;
        say(fmt::format("{} beside {} busy threads; {} runs after it", rows[at].recording, rows[at].neighbours,
                        due.size()));
      }
      const Hogs busy(rows[at].neighbours);
      const Ended e = played(program, file, true, mine);
      const std::lock_guard lock(guard);
      rows[at].runs.push_back(e.run);
    }
  };
  std::vector<std::thread> lanes;
  const std::vector<std::vector<int>> pairs = pairs_of_cores();
  for (size_t k = 0; k < pairs.size(); ++k) lanes.emplace_back(lane, pairs[k], k);
  for (std::thread& t : lanes) t.join();
  std::erase_if(rows, [](const LiveRow& r) { return r.runs.empty(); });
  Result out = judge_live(rows, lockstep);
  out.notes.push_back(fmt::format("{} runs at once, on two cores each", pairs.size()));
  return out;
}

}  // namespace limberg::bench
