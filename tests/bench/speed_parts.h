#pragma once
// The parts of `limberg bench speed`, and what they share. Each adds its rows and bars.
#include <memory>
#include <span>
#include <string>

#include "sim/fem/model/box_model.h"
#include "sim/fem/solver/elastic_solver.h"
#include "tests/bench/speed.h"

namespace limberg::bench {

struct SpeedRun {
  Result& out;
  const SpeedSettings& settings;
  void say(const std::string& text) const {
    if (settings.progress) settings.progress(text);
  }
  void bar(const std::string& name, double value, double wanted, bool larger, const char* source,
           bool at_least = false) const {
    out.bars.push_back({name, value, at_least, wanted, larger, larger ? value >= wanted : value <= wanted, source});
  }
};

double largest_error(std::span<const Vec3f> u, std::span<const Vec3> exact);
double largest_error(std::span<const Vec3> u, std::span<const Vec3> exact);

/// The scene with the hook pulled by 29.6 mm.
BenchScene pulled_scene(int side, int layers, double poisson);
/// A solver at rest with its factor or cycle made.
std::unique_ptr<ElasticSolver> ready(Workers& w, std::span<const Spring> springs,
                                     const std::shared_ptr<const FemModel>& model, bool estimate_error = true);
/// The equilibrium from rest: this solver to its floor, polished by Newton in double.
std::vector<Vec3> equilibrium(const std::shared_ptr<const FemModel>& model, std::span<const Spring> springs);

/// CPU time from rest until the largest error stays below 1 mm and 0.1 mm.
struct PullTimes {
  double ms[2] = {0, 0}, error[2] = {0, 0};
  int iterations[2] = {-1, -1};         // -1: not reached
  double with_estimate_ms[2] = {0, 0};  // the same and the error that frames carry (MinimiserPolicy::estimate_error)
  bool cycle = false;
};
PullTimes our_pull(const std::shared_ptr<const FemModel>& model, std::span<const Spring> springs,
                   std::span<const Vec3> exact);

/// What reading so many bytes, the half of them twice, takes at least.
double solve_floor_ms(size_t bytes);

/// A displacement that the metric is told the stiffness of: w with
/// w . metric w = 1, and the stiffness over the metric there.
struct KnownMode {
  std::vector<Vec3> w;
  double quotient = 1;
};
/// Iterations of L-BFGS(8) in scalar double from rest until the largest error stays below to_mm, -1: not within 400.
/// The metric is M^-1 + sum (1 / quotient - 1) w w^T.
int scalar_double_steps(const FemModel& model, std::span<const Spring> springs, std::span<const Vec3> exact,
                        double to_mm, std::span<const KnownMode> known);

void speed_kernels(const SpeedRun& run);        // instruction sets; three right-hand sides against CHOLMOD
void speed_profile(const SpeedRun& run);        // where an iteration's time goes, beside the machine's floor
void speed_flap(const SpeedRun& run);           // the undermined flap, and why it is slow
void speed_scalar_double(const SpeedRun& run);  // the same pull by a scalar double solver
void speed_workers(const SpeedRun& run);        // a second core
void speed_region(const SpeedRun& run);         // tissue far from the operation: whole, absent, condensed
void speed_locking(const SpeedRun& run);        // energy error at two cells thickness
void speed_slab(const SpeedRun& run);           // the peers' slab
void speed_bullet(const SpeedRun& run);         // Bullet's deformable body

}  // namespace limberg::bench
