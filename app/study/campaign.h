#pragma once
// All members of a study, run to their end: handed to an engine, looked for as files, and handed over again when they
// were lost with a node or cut short.
//
//   1. What the engine has of an earlier program for the same folder is waited for.
//   2. What has no file then is submitted.
//   3. A member that was cut short (a limit, a signal) or left nothing (a node went down) is submitted again, so many
//      times; one that failed in its own words is not: the solver would say the same again, to the bit.
//
// It may be ended at any time and begun again: whatever is there counts, and no more is run than is missing.
#include <functional>
#include <string>
#include <vector>

#include "app/study/engine.h"

namespace limberg::study {

struct Counts {
  size_t all = 0, done = 0, failed = 0, running = 0;
  size_t lost = 0, cut_short = 0, retried = 0;  // lost: left no file when the engine was through with them
  double seconds = 0, left_s = -1;              // left_s < 0: not known yet
  std::string note;                             // of the engine
};

struct CampaignSettings {
  std::string dir;
  int retries = 2;
  std::function<bool()> interrupted = {};
  std::function<void(const Counts&)> show = {};
  /// A member's file is there, or it is given up (`why`: in words).
  std::function<void(size_t job, bool done, const std::string& why)> ended = {};
};

Counts run_campaign(const std::vector<Job>& jobs, Engine& engine, const CampaignSettings& settings);

/// A file that gets a line every ten seconds, and one at the end, each with the time of day.
class CampaignLog {
 public:
  CampaignLog(std::string file, std::string label) : file_(std::move(file)), label_(std::move(label)) {}
  void note(const std::string& words);
  void end(const std::string& words);

 private:
  std::string file_, label_;
  double last_s_ = -1;
};

/// "612 of 2048 done, 2 running, 3 failed, about 4 min left"
std::string in_words(const Counts& counts);

}  // namespace limberg::study
