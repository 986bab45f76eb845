#include "app/study/campaign.h"

#include <fmt/format.h>

#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <optional>

#include "app/study/member_file.h"
#include "app/study/processes.h"
#include "sim/base/error.h"

namespace limberg::study {

namespace {

namespace fs = std::filesystem;

// Every member that is open is looked for: a disk is not asked for thousands of files fifty times a second.
constexpr double kLook_s = 0.2;

class Campaign {
 public:
  Campaign(const std::vector<Job>& jobs, Engine& engine, const CampaignSettings& set)
      : jobs_(jobs), engine_(engine), set_(set), tries_(jobs.size(), 0), cut_(jobs.size()) {
    for (size_t i = 0; i < jobs.size(); ++i) open_.push_back(i);
    counts_.all = jobs.size();
  }

  Counts run() {
    bool asked = false;
    double shown = -1, looked = -kLook_s;
    while (true) {
      const EngineState state = engine_.poll();
      const bool stop = set_.interrupted && set_.interrupted();
      counts_.running = state.running, counts_.note = state.note, counts_.seconds = elapsed_s();
      if (state.over || stop || counts_.seconds - looked >= kLook_s) look(), looked = counts_.seconds;
      const size_t ended = counts_.done + counts_.failed;
      if (ended > 0) counts_.left_s = counts_.seconds / double(ended) * double(open_.size());
      if (set_.show && counts_.seconds - shown > 0.1) set_.show(counts_), shown = counts_.seconds;
      if (stop && !asked && !(asked = engine_.stop())) break;
      if (state.over) {
        if (stop || open_.empty()) break;
        submit_again();
        if (open_.empty()) break;
        continue;
      }
      rest(engine_.poll_every_s());
    }
    counts_.running = 0;
    return counts_;
  }

 private:
  double elapsed_s() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

  /// Wakes up when a person has had enough.
  void rest(double seconds) const {
    for (; seconds > 0 && !(set_.interrupted && set_.interrupted()); seconds -= 0.1) nap(std::min(seconds, 0.1));
  }

  std::optional<MemberResult> file_of(const Job& job) const {
    const std::string file = member_file(set_.dir, *job.family, job.values, ".json");
    std::error_code ec;
    if (!fs::is_regular_file(file, ec)) return std::nullopt;
    try {
      return read_member(file, *job.family, job.values);
    } catch (const InputError&) {
      return std::nullopt;
    }
  }

  void end(size_t i, bool done, const std::string& why) {
    ++(done ? counts_.done : counts_.failed);
    if (set_.ended) set_.ended(i, done, why);
  }

  /// Which files have come.
  void look() {
    std::erase_if(open_, [this](size_t i) {
      if (!cut_[i].empty()) return false;
      const auto m = file_of(jobs_[i]);
      if (!m) return false;
      if (m->program != program_hash()) {
        cut_[i] = "was run by another program than this one; expected the same on all nodes";
      } else if (m->cut_short) {
        cut_[i] = m->failure;
        ++counts_.cut_short;
      } else {
        end(i, m->failure.empty(), m->failure);
        return true;
      }
      return false;
    });
  }

  /// Those that have not left a result, and may be tried once more.
  void submit_again() {
    std::vector<size_t> again;
    std::vector<Job> jobs;
    for (const size_t i : open_) {
      const bool lost = tries_[i] > 0 && cut_[i].empty();
      counts_.lost += lost;
      if (tries_[i] > set_.retries) {
        const std::string said = first_line_of(member_file(set_.dir, *jobs_[i].family, jobs_[i].values, ".log"));
        end(i, false, !cut_[i].empty() ? cut_[i] : !said.empty() ? said : "left no result, " + tried(tries_[i]));
        continue;
      }
      if (!cut_[i].empty()) {
        std::error_code ignored;
        fs::remove(member_file(set_.dir, *jobs_[i].family, jobs_[i].values, ".json"), ignored);
        cut_[i].clear();
      }
      counts_.retried += tries_[i]++ > 0;
      again.push_back(i);
      jobs.push_back(jobs_[i]);
    }
    open_ = std::move(again);
    if (!jobs.empty()) engine_.submit(jobs);
  }

  static std::string tried(int times) { return times == 1 ? "tried once" : fmt::format("tried {} times", times); }

  const std::vector<Job>& jobs_;
  Engine& engine_;
  const CampaignSettings& set_;
  std::vector<size_t> open_;  // neither done nor given up
  std::vector<int> tries_;
  std::vector<std::string> cut_;  // per job: why it was cut short; empty: it was not
  Counts counts_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::string time_left(double s) {
  if (s < 90) return fmt::format("{:.0f} s", s);
  if (s < 5400) return fmt::format("{:.0f} min", s / 60);
  return fmt::format("{:.1f} h", s / 3600);
}

}  // namespace

Counts run_campaign(const std::vector<Job>& jobs, Engine& engine, const CampaignSettings& settings) {
  return Campaign(jobs, engine, settings).run();
}

void CampaignLog::note(const std::string& words) {
  const double now = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  constexpr double kEvery_s = 10;
  if (last_s_ >= 0 && now - last_s_ < kEvery_s) return;
  last_s_ = now;
  end(words);
}

void CampaignLog::end(const std::string& words) {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  ::gmtime_r(&now, &parts);
  char time[32] = "";
  std::strftime(time, sizeof time, "%Y-%m-%dT%H:%M:%SZ", &parts);
  // Words that are lost are no loss.
  std::ofstream(file_, std::ios::app) << time << " " << label_ << ": " << words << "\n";
}

std::string in_words(const Counts& c) {
  std::string text = fmt::format("{} of {} done, {} running, {} failed", c.done, c.all, c.running, c.failed);
  if (c.retried > 0) text += fmt::format(", {} tried again", c.retried);
  if (c.left_s >= 0 && c.done + c.failed < c.all) text += ", about " + time_left(c.left_s) + " left";
  return c.note.empty() ? text : text + " (" + c.note + ")";
}

}  // namespace limberg::study
