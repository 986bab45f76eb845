#pragma once
// `limberg bench head`: the face that follows the bones of the synthetic head.
//
//   - operations of head_cases.h: each mode of the tissue against
//     the finite elements at equilibrium, error of the face over run
//     time (warm start of one move, one core). The constants of the
//     modes were chosen on the first case; the others are unseen;
//   - a session at its whole size (head_session.cpp): what a cut,
//     and each step while a fragment is carried, cost with a face of
//     5,000, tissue of about 20,000 and bones of 10,000 vertices.
#include <functional>
#include <string>
#include <vector>

#include "app/operating_point/bench.h"
#include "app/report/svg_chart.h"

namespace limberg {
struct HeadModel;
class Workers;
}  // namespace limberg

namespace limberg::bench {

struct HeadSettings {
  bool quick = false;                                // fewer cases and iterations
  std::string only;                                  // modes or session; empty: both
  std::function<void(const std::string&)> progress;  // empty: silent
};

/// A mode of the tissue on a case after so many iterations.
struct HeadTrial {
  std::string situation, mode;
  int iterations = 0;
  double cpu_ms = 0, rms_mm = 0, p95_mm = 0, max_mm = 0;
  bool at_rest = false;
};

struct HeadReport {
  Result result;
  std::vector<HeadTrial> trials;
  std::vector<std::string> situations() const;
  std::string csv() const;
  LineChart chart(const std::string& situation) const;  // error against run time, a line per mode
};

HeadReport head_suite(const HeadSettings& settings);
/// Cut, carry and join with the whole head; adds rows and bars.
void head_session(Result& out, const HeadModel& head, const HeadSettings& settings, Workers& workers);

}  // namespace limberg::bench
