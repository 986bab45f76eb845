// One and two workers: wall time of an iteration, the second core free, and taken by another job.
#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "app/operating_point/cpu_clock.h"
#include "app/session/workers_pool.h"
#include "tests/bench/speed_parts.h"

namespace limberg::bench {
namespace {

double wall_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Measured {
  Times ms;  // per iteration
  std::vector<Vec3f> u;
};

void measure(Workers& w, const std::shared_ptr<const FemModel>& model, const BenchScene& scene, int iterations,
             Measured& m) {
  auto solver = ready(w, scene.springs, model);
  StepSettings s;
  s.max_iterations = iterations;
  const double start = wall_ms();
  const StepReport r = solver->step(s);
  m.ms.add((wall_ms() - start) / std::max(1, r.iterations));
  m.u.assign(solver->displacement_mm().begin(), solver->displacement_mm().end());
}

/// Threads that keep every core busy until told to stop.
class OtherJob {
 public:
  explicit OtherJob(int threads) {
    for (int i = 0; i < threads; ++i)
      threads_.emplace_back([this] {
        volatile double x = 1;
        while (!stop_.load(std::memory_order_relaxed)) x = x * 1.0000001;
      });
  }
  ~OtherJob() {
    stop_ = true;
    for (std::thread& t : threads_) t.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

/// How much more two threads of this machine get done than one, at this moment, with nothing shared: arithmetic alone,
/// and streaming 64 MB each. No program can gain more.
double own_gain(bool streaming) {
  const auto job = [streaming] {
    if (!streaming) {
      volatile double x = 1;
      for (long k = 0; k < 20'000'000; ++k) x = x * 1.0000001;
      return;
    }
    std::vector<uint64_t> a(8u << 20, 1);
    volatile uint64_t sum = 0;
    for (int pass = 0; pass < 3; ++pass) {
      uint64_t s = 0;
      for (uint64_t v : a) s += v;
      sum = sum + s;
    }
  };
  Times one, two;
  for (int repeat = 0; repeat < 3; ++repeat) {
    double start = wall_ms();
    job();
    one.add(wall_ms() - start);
    start = wall_ms();
    std::thread other(job);
    job();
    other.join();
    two.add(wall_ms() - start);
  }
  return 2 * one.best() / two.best();
}

}  // namespace

void speed_workers(const SpeedRun& run) {
  const struct {
    const char* name;
    int side, layers, iterations;
  } sizes[] = {{"8k", 44, 3, 60}, {"30k", 66, 6, 40}, {"100k", 100, 9, 15}};
  double load = 0;
  getloadavg(&load, 1);
  std::string note = fmt::format(
      "Second core: wall time; the machine's load was {:.1f} for {} cores. Beside other work the speed-up says "
      "nothing; the fall-back does.",
      load, std::thread::hardware_concurrency());
  run.out.notes.push_back(note);
  for (bool streaming : {false, true}) {
    const double gain = own_gain(streaming);
    note = fmt::format("{}, wall time, best of 3, load {:.1f}",
                       streaming ? "64 MB streamed by each" : "arithmetic alone", load);
    run.out.rows.push_back({"second core, the machine itself", "two threads that share nothing", note, 0, false, gain,
                            "x", "one thread twice", true});
  }
  for (const auto& size : sizes) {
    run.say(std::string("one and two workers, ") + size.name + " nodes");
    const BenchScene scene = pulled_scene(size.side, size.layers, 0.49);
    const auto model = std::make_shared<FemModel>(scene.model);
    InlineWorkers inline_one;
    WorkersPool two(2);
    for (bool taken : {false, true}) {
      if (taken && size.side > 66) continue;
      Measured one_m, two_m;
      const auto before = two.pace();
      {
        OtherJob other(taken ? 1 : 0);
        for (int repeat = 0; repeat < 3; ++repeat) {
          measure(inline_one, model, scene, size.iterations, one_m);
          measure(two, model, scene, size.iterations, two_m);
        }
      }
      const auto after = two.pace();
      const bool same = one_m.u.size() == two_m.u.size() &&
                        std::memcmp(one_m.u.data(), two_m.u.data(), one_m.u.size() * sizeof(Vec3f)) == 0;
      const double speed_up = one_m.ms.best() / two_m.ms.best();
      const std::string name = fmt::format("second core{}, {} nodes", taken ? " taken" : "", size.name);
      std::string how = fmt::format("{} nodes, best of 3 runs of {} iterations, load {:.1f}", model->X_mm.size(),
                                    size.iterations, load);
      run.out.rows.push_back(
          {name, "one worker, wall time an iteration", how, one_m.ms.best(), false, 1, "x", "one worker", true});
      how = fmt::format(
          "{} loops shared, {} alone after {} long waits; {}", (unsigned long long)(after.shared - before.shared),
          (unsigned long long)(after.alone - before.alone), (unsigned long long)(after.long_waits - before.long_waits),
          same ? "the same bits" : "OTHER BITS");
      run.out.rows.push_back(
          {name, "two workers", how, two_m.ms.best(), false, speed_up, "x", "one worker in the same run", same});
      if (taken)
        run.bar(std::string(name) + ": median time with two workers / one", two_m.ms.median() / one_m.ms.median(), 1.25,
                false, "the fall-back: hardly slower than alone (prototype without it: up to 100 times)");
    }
  }
}

}  // namespace limberg::bench
