#pragma once
// `limberg bench live`: recordings played in real time (`limberg replay --realtime`), each many times: alone, and
// beside one and two threads that only use time. Every run has two cores to itself and its neighbours; a machine with
// more cores has several runs at once, on pairs of their own. What is asked:
//
//   came out    the exit status is that of lockstep, all its acts are done, none more
//   as lockstep figures of the end (kLiveFigures) within 5 % of lockstep's, of the figure or of its floor
//   how live    steps and age of the picture at p50, p95, p99, events lost, steps skipped, how long the hand waited
//
// A recorded hand waits for a slow patient (session.h), so that a busy machine takes longer and does no worse; this
// suite says whether that is so, and how much longer. A hand that cannot wait is `limberg run --slow-motion`.
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/bench/suite.h"

namespace limberg::bench {

/// A figure that a live run shares with lockstep. A difference is counted in shares of lockstep's value, and no smaller
/// value than `floor`: 5 % of a fifth of a millimetre is less than the hand's own noise.
struct LiveFigure {
  const char* name;  // in result.json, under metrics
  double floor;      // in its own unit
};
extern const std::vector<LiveFigure> kLiveFigures;
constexpr double kLiveShare = 0.05;  // issue of real time: all figures within 5 % of lockstep

/// What one run ended with.
struct LiveRun {
  int status = -1, acts = 0;
  std::map<std::string, double> figures;  // of kLiveFigures, those that it has
  double step_p50_ms = 0, step_p95_ms = 0, step_p99_ms = 0;
  double age_p50_ms = 0, age_p99_ms = 0;  // of the snapshot that the device thread finds
  double waited_s = 0;                    // the hand, for the patient
  double memory_mb = 0;
  int64_t skipped = 0, lost = 0;  // solver steps; events
};

/// The runs of one recording beside so many busy threads.
struct LiveRow {
  std::string recording;
  int neighbours = 0;
  double lasts_s = 0;  // by the session's clock
  std::vector<LiveRun> runs;
};

/// The largest difference from lockstep, as a share (kLiveFigures), and the figure that has it; 0 and "" of none.
std::pair<double, std::string> live_difference(const LiveRun& run, const LiveRun& lockstep);
bool came_out(const LiveRun& run, const LiveRun& lockstep);

/// Rows and bars. `lockstep`: by recording.
Result judge_live(const std::vector<LiveRow>& rows, const std::map<std::string, LiveRun>& lockstep);

struct LiveSettings {
  std::string recording;  // one of one's own; empty: those that are shipped, and a bilobed flap
  std::string only;       // recordings whose name contains this
  bool quick = false;     // the rhomboid only, once, alone
  int64_t runs = 10;      // of each
  std::function<void(const std::string&)> progress;
  std::function<bool()> stop;
};

Result live(const LiveSettings& settings);

}  // namespace limberg::bench
