#pragma once
// The parts of `bench verification`, and what they share.
#include <functional>
#include <string>
#include <vector>

#include "sim/fem/solver/elastic_solver.h"
#include "sim/testing/reference_newton.h"
#include "tests/bench/verification.h"

namespace limberg::bench {

void even_states(Result& out, const VerificationSettings& settings);
void cook(Result& out, const VerificationSettings& settings);
void thick_sphere(Result& out, const VerificationSettings& settings);
void elastica(Result& out, const VerificationSettings& settings);
void manufactured(Result& out, const VerificationSettings& settings);
void bent_strip(Result& out, const VerificationSettings& settings);
void calculix_block(Result& out, const VerificationSettings& settings);
void thickness(Result& out, const VerificationSettings& settings);
void live_error(Result& out, const VerificationSettings& settings);
void live_operations(Result& out, const VerificationSettings& settings);

/// Frames after one disturbance: what each stated, and where it was.
/// Stated / true: by the node that is farthest off, and by the farthest vertex of the surface, which is what one sees.
struct LiveRatios {
  std::vector<double> nodes, seen;
};
class LiveFrames {
 public:
  /// `surface`: carried by the solver's nodes; none: nothing is seen.
  void add(const ElasticSolver& solver, const StepReport& report, const SharedArray<EmbeddedPoint>& surface = {});
  /// The solver is at rest now. Adds the frames that were far enough off to tell, and forgets them.
  void end(const ElasticSolver& solver, LiveRatios& ratios, const SharedArray<EmbeddedPoint>& surface = {});

 private:
  std::vector<std::vector<Vec3f>> u_, seen_mm_;
  std::vector<double> stated_mm_;
};
/// A hundred iterations at a time, at most 80 times, to a residual of 2e-6; one ten times that is rest enough.
bool comes_to_rest(const std::function<StepReport(const StepSettings&)>& step);
/// One row and its bars: how often the truth was more than three times what was stated, and the median.
void report_live(Result& out, const std::string& name, std::vector<double> ratios, double cpu_ms);
void report_live(Result& out, const std::string& name, const LiveRatios& ratios, double cpu_ms);

/// A force that does not follow: a spring so soft and so far away that its force is F wherever the node goes. It is
/// exactly F at X + `expected` and changes by k a mm.
Spring dead_load(const FemModel& model, int32_t id, int32_t node, const Vec3& force_mN, double k_mN_per_mm,
                 const Vec3& expected_mm = Vec3::Zero());

/// log(e_coarse / e_fine) / log(h_coarse / h_fine)
double observed_order(double error_coarse, double error_fine, double ratio_of_sizes);

/// One bar: `value` at most `bar`.
void at_most(Result& out, const std::string& name, double value, double bar, const std::string& source);
void at_least(Result& out, const std::string& name, double value, double bar, const std::string& source);

}  // namespace limberg::bench
