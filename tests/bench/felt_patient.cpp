#include "tests/bench/felt_patient.h"

#include <fmt/format.h>

#include <cmath>

#include "app/assembly/assembly.h"
#include "app/operating_point/cpu_clock.h"
#include "tests/bench/felt_hand.h"

namespace limberg::bench {
namespace {

/// Answers like the patient behind it, and keeps the time that it took.
class Timed final : public Patient {
 public:
  explicit Timed(Patient& patient) : patient_(patient) {}
  Outcome apply(const Command& c) override { return patient_.apply(c); }
  StepReport step(const StepSettings& s) override {
    const double before = cpu_ms();
    const StepReport r = patient_.step(s);
    steps.add(cpu_ms() - before);
    return r;
  }
  bool settled() const override { return patient_.settled(); }
  void fill(Snapshot& s) const override { patient_.fill(s); }
  bool press(const PressQuestion& q, PressAnswer& a) override {
    const double before = cpu_ms();
    const bool told = patient_.press(q, a);
    questions.add(cpu_ms() - before);
    return told;
  }
  std::shared_ptr<const SurfaceTopology> topology() const override { return patient_.topology(); }
  uint64_t topology_hash() const override { return patient_.topology_hash(); }
  uint64_t state_hash() const override { return patient_.state_hash(); }

  Times steps, questions;

 private:
  Patient& patient_;
};

/// Comes down onto the middle of the skin, presses 4 mm deep, strokes 8 mm to and fro and taps.
SimulatedHand hand() {
  SimulatedHand h;
  h.target = [](double t) {
    Vec3 to(2, 1, 6 - 10 * std::min(1.0, t));
    if (t > 1.5) to += Vec3(8 * std::sin(2 * t), 0, 3 * std::sin(9 * t));
    return to;
  };
  return h;
}

}  // namespace

void add_felt_patient(Result& out, const Scene& scene, bool quick,
                      const std::function<void(const std::string&)>& progress) {
  for (const bool asks : {true, false}) {
    if (progress) progress(std::string("felt, ") + (asks ? "asking the solver" : "half space"));
    AssemblyOptions o;
    Assembly a(scene, Calibration{}, o);
    Timed patient(*a.patient);
    SolverLane solver(patient, a.channels, SolverSettings{step_settings(a.scene, false)});
    if (asks) a.channels.press = std::make_shared<PressLine>();
    FeltHand felt(hand(), a.front, a.channels.press);
    solver.start();
    const int every = ticks_per_solver_step(a.scene);
    for (int tick = 1; tick < (quick ? 3000 : 8000); ++tick) {
      a.device.tick(tick), felt.watch();
      if (tick % every == 0) solver.step(tick);
    }
    const double least = felt.least_mJ, step = felt.largest_step_N;
    const std::string text = fmt::format(
        "{:.3f} to {:.3f} N/mm, {:.2f} N at most, least energy {:.2f} mJ; {} answers, a question {:.1f} ms of CPU at "
        "the median, {:.1f} at p95 (a step {:.1f})",
        felt.softest_N_mm, felt.hardest_N_mm, felt.largest_N, least, felt.force().answers(),
        patient.questions.percentile(0.5), patient.questions.percentile(0.95), patient.steps.percentile(0.5));
    Row r;
    r.name = "felt patient, " + a.scene.name, r.method = asks ? "stiffness from the solver" : "half space of skin";
    r.settings = text, r.error = step, r.error_unit = "N/ms", r.reference = "from tick to tick";
    out.rows.push_back(r);
    if (!asks) continue;
    out.bars.push_back({"felt patient: least energy, mJ", least, false, -0.15, true, least >= -0.15,
                        "the observer's spare of 0.1 mJ and a tick of the damper"});
    out.bars.push_back(
        {"felt patient: largest step, N/ms", step, false, 0.2 + 1e-9, false, step <= 0.2 + 1e-9, "no felt step"});
  }
}

}  // namespace limberg::bench
