#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/bench/live/live.h"

namespace limberg::bench {

// Floors: what a hand's noise moves (stitches lie within .2 mm of where they were meant, validation.md) of lengths, and
// of areas and volumes that along a wound of 90 mm; a tenth of the smaller closure force.
const std::vector<LiveFigure> kLiveFigures{{"closure_force_N", 0.1},
                                           {"elongation", 0.1},
                                           {"scar_length_mm", 1},
                                           {"wound_gape_max_mm", 1},
                                           {"wound_gape_mean_mm", 1},
                                           {"dog_ear_mm", 1},
                                           {"flap_area_mm2", 50},
                                           {"undermined_mm2", 50},
                                           {"removed_volume_mm3", 100},
                                           {"stretch_p99", 0.1},
                                           {"stress_p95_kPa", 5},
                                           {"face_moved_max_mm", 1},
                                           {"fragments", 1},
                                           {"inverted_cells", 0.1},
                                           {"penetration_p99_mm", 1},
                                           {"fragment_moved_max_mm", 1}};

std::pair<double, std::string> live_difference(const LiveRun& run, const LiveRun& lockstep) {
  std::pair<double, std::string> worst{0, ""};
  for (const LiveFigure& f : kLiveFigures) {
    const auto want = lockstep.figures.find(f.name);
    if (want == lockstep.figures.end()) continue;
    const auto have = run.figures.find(f.name);
    double off = INFINITY;  // also of what is no number
    if (have != run.figures.end() && std::isfinite(have->second))
      off = std::abs(have->second - want->second) / std::max(std::abs(want->second), f.floor);
    if (off > worst.first) worst = {off, f.name};
  }
  return worst;
}

bool came_out(const LiveRun& run, const LiveRun& lockstep) {
  return run.status == lockstep.status && run.acts == lockstep.acts;
}

namespace {

/// The median over runs of what `of` reads.
template <class F>
double middle(const std::vector<LiveRun>& runs, F of) {
  std::vector<double> v;
  for (const LiveRun& r : runs) v.push_back(of(r));
  if (v.empty()) return 0;
  std::nth_element(v.begin(), v.begin() + int64_t(v.size() / 2), v.end());
  return v[v.size() / 2];
}

Bar at_most(const std::string& name, double value, double bar) {
  Bar b;
  b.name = name, b.value = value, b.bar = bar, b.larger_is_better = false, b.pass = value <= bar;
  b.source = "issue 28";
  return b;
}

}  // namespace

Result judge_live(const std::vector<LiveRow>& rows, const std::map<std::string, LiveRun>& lockstep) {
  Result out;
  for (const LiveRow& row : rows) {
    const LiveRun& reference = lockstep.at(row.recording);
    int out_n = 0;
    int64_t lost = 0, skipped = 0;
    std::pair<double, std::string> worst{0, ""};
    double most_waited = 0;
    for (const LiveRun& r : row.runs) {
      out_n += came_out(r, reference);
      lost += r.lost, skipped += r.skipped;
      const auto d = live_difference(r, reference);
      if (d.first > worst.first) worst = d;
      most_waited = std::max(most_waited, r.waited_s);
    }
    const int n = int(row.runs.size());
    Row line;
    line.name = row.recording;
    line.method = row.neighbours == 0   ? "alone"
                  : row.neighbours == 1 ? "beside one busy thread"
                                        : fmt::format("beside {} busy threads", row.neighbours);
    line.time_ms = middle(row.runs, [](const LiveRun& r) { return r.step_p95_ms; });
    line.error = 100 * worst.first, line.error_unit = "%";
    line.reference = "time: a step at p95, by the clock; error: worst figure against lockstep";
    line.pass = out_n == n;
    line.settings = fmt::format(
        "{} of {} came out; step {:.1f}, {:.1f}, {:.1f} ms; picture {:.0f}, {:.0f} ms old; the hand waited {:.1f} s of "
        "{:.0f}, {:.1f} at most; {} lost, {} skipped; {}; {:.0f} MB",
        out_n, n, middle(row.runs, [](const LiveRun& r) { return r.step_p50_ms; }), line.time_ms,
        middle(row.runs, [](const LiveRun& r) { return r.step_p99_ms; }),
        middle(row.runs, [](const LiveRun& r) { return r.age_p50_ms; }),
        middle(row.runs, [](const LiveRun& r) { return r.age_p99_ms; }),
        middle(row.runs, [](const LiveRun& r) { return r.waited_s; }), row.lasts_s, most_waited, lost, skipped,
        worst.second.empty() ? "no figure differs" : worst.second + " differs most",
        middle(row.runs, [](const LiveRun& r) { return r.memory_mb; }));
    out.rows.push_back(line);
    const std::string name = fmt::format("{}, {}: ", row.recording, line.method);
    out.bars.push_back(at_most(name + "runs that did not come out", n - out_n, 0));
    out.bars.push_back(at_most(name + "largest difference from lockstep, share", worst.first, kLiveShare));
    out.bars.push_back(at_most(name + "events lost", double(lost), 0));
  }
  return out;
}

}  // namespace limberg::bench
