#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "app/result/output.h"
#include "app/study/engine.h"
#include "app/study/member_file.h"
#include "app/study/processes.h"
#include "sim/base/error.h"

namespace limberg::study {

namespace {

std::string why(int status, double limit_s, const std::string& said) {
  if (status == kOverLimit) return fmt::format("took longer than {:g} s", limit_s);
  if (!said.empty()) return said;
  if (status == kNotRun) return "could not be started";
  return status >= 1000 ? "ended by signal " + std::to_string(status - 1000)
                        : "ended with exit status " + std::to_string(status) + " and left no file";
}

class LocalEngine : public Engine {
 public:
  LocalEngine(std::string dir, MemberLimits limits, int at_once, bool in_groups)
      : dir_(std::move(dir)), limits_(std::move(limits)), in_groups_(in_groups), pool_(at_once) {}

  void submit(const std::vector<Job>& jobs) override {
    for (const Job& job : jobs) {
      pool_.add(jobs_.size(), {member_call(job, dir_, limits_),
                               member_file(dir_, *job.family, job.values, ".log"),
                               {},
                               limits_.seconds,
                               in_groups_});
      jobs_.push_back(job);
    }
  }

  EngineState poll() override {
    pool_.turn([this](size_t i, int status) { ended(jobs_[i], status); });
    return {pool_.running(), pool_.idle(), {}};
  }

  bool stop() override {
    stopped_ = true;
    pool_.stop();
    return true;
  }
  double poll_every_s() const override { return 0.02; }

 private:
  void ended(const Job& job, int status) {
    const std::string log = member_file(dir_, *job.family, job.values, ".log");
    const std::string said = first_line_of(log);
    std::error_code ec;
    if (said.empty()) std::filesystem::remove(log, ec);
    if (stopped_) return;
    const std::string file = member_file(dir_, *job.family, job.values, ".json");
    if (status != kOverLimit && std::filesystem::exists(file, ec)) return;  // it has spoken for itself
    MemberResult m;
    m.program = program_hash(), m.failure = why(status, limits_.seconds, said), m.cut_short = true;
    try {
      write_whole_file(file, member_text(*job.family, job.values, m));
    } catch (const InputError&) {
      // no room for a file: its log says why, and whoever gathers finds none
    }
  }

  std::string dir_;
  MemberLimits limits_;
  bool in_groups_, stopped_ = false;
  std::vector<Job> jobs_;
  ProcessPool pool_;
};

}  // namespace

std::unique_ptr<Engine> local_engine(const std::string& dir, const MemberLimits& limits, int at_once, bool in_groups) {
  return std::make_unique<LocalEngine>(dir, limits, at_once, in_groups);
}

std::vector<std::string> member_call(const Job& job, const std::string& dir, const MemberLimits& limits) {
  const Family& f = *job.family;
  std::vector<std::string> words{this_program(), "study", f.name};
  for (size_t i = 0; i < job.values.size(); ++i) {
    const double v = job.values[i];
    const std::string brief = fmt::format("{:g}", v);  // where it means the same
    const std::string t = "=" + (std::strtod(brief.c_str(), nullptr) == v ? brief : fmt::format("{:.17g}", v));
    words.insert(words.end(), {"--set", f.parameters[i].name + t});
  }
  words.insert(words.end(), {"--member", "--workers", std::to_string(limits.workers), "--out", dir});
  if (limits.memory_MB > 0) words.insert(words.end(), {"--memory", std::to_string(limits.memory_MB)});
  if (!limits.simd.empty()) words.insert(words.end(), {"--simd", limits.simd});
  return words;
}

}  // namespace limberg::study
