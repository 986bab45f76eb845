#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>

#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/result.h"
#include "app/study/engine.h"
#include "app/study/processes.h"
#include "app/study/slurm_words.h"
#include "app/study/task_file.h"
#include "sim/base/error.h"
#include "sim/base/hash.h"

namespace limberg::study {

namespace {

namespace fs = std::filesystem;

constexpr double kAsk_s = 2;

std::string one_line(std::string words) {
  while (!words.empty() && words.back() == '\n') words.pop_back();
  std::replace(words.begin(), words.end(), '\n', ' ');
  return words;
}

std::string doubled_percent(const std::string& path) {  // sbatch puts numbers in the place of %a
  std::string out;
  for (const char c : path) out += c == '%' ? std::string("%%") : std::string(1, c);
  return out;
}

/// Words of a controller that is away for a while.
bool passes(const std::string& words) {
  return words.find("ontact") != words.npos || words.find("timed out") != words.npos ||
         words.find("temporarily") != words.npos;
}

class SlurmEngine : public Engine {
 public:
  SlurmEngine(const std::string& dir, MemberLimits limits, SlurmSettings settings)
      : dir_(fs::absolute(dir).lexically_normal().string()), limits_(std::move(limits)), set_(std::move(settings)) {
    const Answer config = ask_program({"scontrol", "show", "config"});
    if (config.status == kNotRun || ask_program({"sbatch", "--version"}).status == kNotRun)
      throw InputError("", 0,
                       "--engine slurm: there is no sbatch, scontrol or squeue in PATH; expected Slurm's commands, or "
                       "--engine local");
    if (config.status != 0)
      throw InputError("", 0,
                       "--engine slurm: Slurm does not answer (" + one_line(config.words) +
                           "); expected a cluster that runs, or --engine local");
    max_array_ = read_max_array(config.output);
    Hash64 h;
    h.add(dir_), h.add(set_.study);
    name_ = "limberg-" + hex(h.value());
  }

  void submit(const std::vector<Job>& jobs) override {
    const size_t per_task = members_of_task(jobs.size());
    const std::string round = new_round();
    size_t tasks = 0;
    for (size_t at = 0; at < jobs.size(); at += per_task, ++tasks)
      write_whole_file(round + "/" + std::to_string(tasks),
                       task_text({jobs.begin() + std::ptrdiff_t(at),
                                  jobs.begin() + std::ptrdiff_t(std::min(at + per_task, jobs.size()))}));
    write_whole_file(round + "/task.sh", script(round));
    const std::string job = send(round, tasks, per_task);
    say(fmt::format("Slurm job {}: {} members in {} tasks", job, jobs.size(), tasks));
    empty_ = 0, state_ = {0, false, {}}, asked_ = {};
  }

  EngineState poll() override {
    const auto now = std::chrono::steady_clock::now();
    if (asked_ && std::chrono::duration<double>(now - *asked_).count() < kAsk_s) return state_;
    const Answer a = ask_program({"squeue", "--noheader", "--array", "--name=" + name_,
                                  "--user=" + std::to_string(::getuid()), "--format=%t|%r"});
    asked_ = now;
    if (a.status != 0) {  // a controller that starts anew has not lost its queue
      state_.over = false, state_.note = "Slurm does not answer";
      return state_;
    }
    const Queue q = read_queue(a.output);
    // Twice nothing: a file of the last task may come a little after its end, through the network.
    empty_ = q.running + q.waiting == 0 ? empty_ + 1 : 0;
    state_ = {q.running, empty_ >= (submitted_ ? 2 : 1), q.held.empty() ? "" : "Slurm holds tasks: " + q.held};
    if (!submitted_ && !state_.over && !told_) {
      told_ = true;
      say(fmt::format("{} tasks of this study are in Slurm's queue already; they are waited for",
                      q.running + q.waiting));
    }
    return state_;
  }

  bool stop() override {
    if (!state_.over)
      say("the tasks go on; the same call takes them up again, and scancel --name=" + name_ + " ends them");
    return false;
  }
  double poll_every_s() const override { return kAsk_s; }

 private:
  size_t members_of_task(size_t jobs) const {
    const size_t wanted = set_.per_task > 0 ? size_t(set_.per_task) : (jobs - 1) / SlurmSettings::kTasks + 1;
    return std::max(wanted, (jobs - 1) / size_t(max_array_) + 1);
  }

  std::string new_round() const {
    std::error_code ec;
    for (int i = 1;; ++i) {
      const std::string folder = dir_ + "/tasks/" + std::to_string(i);
      if (fs::exists(folder, ec)) continue;
      prepare_folder(folder);
      return folder;
    }
  }

  std::string script(const std::string& round) const {
    std::vector<std::string> words{
        this_program(), "study", set_.study, "--out", dir_, "--workers", std::to_string(limits_.workers)};
    if (limits_.seconds > 0) words.insert(words.end(), {"--limit", fmt::format("{:g}", limits_.seconds)});
    if (limits_.memory_MB > 0) words.insert(words.end(), {"--memory", std::to_string(limits_.memory_MB)});
    if (!limits_.simd.empty()) words.insert(words.end(), {"--simd", limits_.simd});
    std::string line = "exec";
    for (const std::string& w : words) line += " " + quoted(w);
    return "#!/bin/sh\n" + line + " --task " + quoted(round + "/") + "\"$SLURM_ARRAY_TASK_ID\"\n";
  }

  std::string send(const std::string& round, size_t tasks, size_t per_task) {
    std::string array = "--array=0-" + std::to_string(tasks - 1);
    if (set_.tasks_at_once > 0) array += "%" + std::to_string(set_.tasks_at_once);
    std::vector<std::string> words{"sbatch",
                                   "--parsable",
                                   "--requeue",
                                   "--open-mode=append",
                                   "--job-name=" + name_,
                                   array,
                                   "--cpus-per-task=" + std::to_string(limits_.workers),
                                   "--output=" + doubled_percent(round) + "/%a.log"};
    if (limits_.seconds > 0)
      words.push_back(fmt::format("--time={:.0f}", std::ceil(limits_.seconds * double(per_task) / 60) + 1));
    // What the member may have, and this program's own beside it.
    if (limits_.memory_MB > 0) words.push_back(fmt::format("--mem={}M", limits_.memory_MB + 200));
    words.insert(words.end(), set_.more.begin(), set_.more.end());
    words.push_back(round + "/task.sh");
    for (int times = 1;; ++times) {
      const Answer a = ask_program(words);
      const std::string job = a.status == 0 ? read_job(a.output) : "";
      if (!job.empty()) {
        submitted_ = true;
        return job;
      }
      if (times == 5 || !passes(a.words))
        throw InputError("", 0,
                         "sbatch refuses the study: " + one_line(a.words) +
                             "; expected a job that the cluster takes (--sbatch gives it other options)");
      nap(5);
    }
  }

  std::string dir_;
  MemberLimits limits_;
  SlurmSettings set_;
  std::string name_;
  int max_array_ = 0, empty_ = 0;
  bool submitted_ = false, told_ = false;
  EngineState state_;
  std::optional<std::chrono::steady_clock::time_point> asked_;
};

}  // namespace

std::unique_ptr<Engine> slurm_engine(const std::string& dir, const MemberLimits& limits,
                                     const SlurmSettings& settings) {
  return std::make_unique<SlurmEngine>(dir, limits, settings);
}

}  // namespace limberg::study
