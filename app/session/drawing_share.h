#pragma once
// How much of the time pictures may be drawn while the patient's
// solver works, so that it loses at most a given share of its speed.
//
// What drawing takes from a solver is a matter of the machine: nothing where a graphics card draws, a few
// percent where a core is spare, much where a software driver shares the cores. So it is measured while the
// session runs: the time of an iteration in steps that a picture was drawn beside, against those without,
// medians of the last kKept of each. With a loss L (0.3: an iteration takes 30 % longer) pictures may take
// allowed / L of the time, and after each there is a pause of that length. Counted is the processor time of
// the drawing thread, which with a graphics card is next to nothing and with a software driver everything,
// when the driver is kept to that thread (software_drawing_threads, render/gl_context.h).
//
// While the patient rests there is nothing to lose, and pictures are drawn as fast as they are asked for.
//
// step_begins() and step_ended() are for the solver's thread, picture_begins()
// and picture_ended() for the drawing one; the others for any.
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace limberg {

class DrawingShare {
 public:
  explicit DrawingShare(double allowed_loss = 0.15) : allowed_(allowed_loss) {}

  void step_begins(int64_t now_ns) { step_began_ = now_ns, drawn_before_ = drawn_until(now_ns); }
  /// iterations: of this step.
  void step_ended(int64_t now_ns, int iterations) {
    const int64_t took_ns = now_ns - step_began_, beside_ns = drawn_until(now_ns) - drawn_before_;
    const bool works = iterations >= kWorking;
    busy_ += (double(works) - busy_) / 16;
    if (!works || took_ns <= 0) return publish();
    const double each = double(took_ns) / iterations;
    const double share = double(beside_ns) / double(took_ns);
    if (share < 0.05)
      alone_.add(each);
    else if (share > 0.6)
      beside_.add(each);
    publish();
  }

  void picture_begins(int64_t now_ns) { since_.store(now_ns); }
  /// How long no further picture may begin, ns. cpu_ns: processor time of this one.
  int64_t picture_ended(int64_t now_ns, int64_t cpu_ns) {
    const int64_t began = since_.exchange(0);
    if (began > 0) drawn_.fetch_add(std::max<int64_t>(0, now_ns - began));
    return std::min(int64_t(double(cpu_ns) * (1 / share() - 1)), kLongestPause_ns);
  }

  /// Of the solver's speed while a picture is drawn; less than 0: not known yet.
  double loss() const { return loss_.load(std::memory_order_relaxed); }
  /// Of the time that drawing may take.
  double share() const { return share_.load(std::memory_order_relaxed); }

 private:
  static constexpr size_t kKept = 24;
  static constexpr int kWorking = 4;  // iterations of a step that is more than looking whether anything is to be done
  static constexpr double kUnknown = 0.4;              // share until both kinds of steps have been seen
  static constexpr double kLeast = 0.1, kMost = 0.85;  // at most: some steps must be seen without a picture
  static constexpr int64_t kLongestPause_ns = 400'000'000;

  struct Recent {
    std::array<double, kKept> value{};
    size_t seen = 0;
    void add(double v) { value[seen++ % kKept] = v; }
    bool full() const { return seen >= kKept; }
    double median() const {
      std::array<double, kKept> sorted = value;
      std::nth_element(sorted.begin(), sorted.begin() + kKept / 2, sorted.end());
      return sorted[kKept / 2];
    }
  };

  int64_t drawn_until(int64_t now_ns) const {
    const int64_t began = since_.load();
    return drawn_.load() + (began > 0 ? std::max<int64_t>(0, now_ns - began) : 0);
  }
  void publish() {
    double loss = -1, share = kUnknown;
    if (alone_.full() && beside_.full()) {
      loss = std::max(0.0, beside_.median() / alone_.median() - 1);
      share = std::clamp(allowed_ / std::max(loss, 1e-6), kLeast, kMost);
    }
    if (busy_ < 0.25) share = 1;
    loss_.store(loss, std::memory_order_relaxed);
    share_.store(share, std::memory_order_relaxed);
  }

  const double allowed_;
  std::atomic<int64_t> since_{0}, drawn_{0};  // when the picture began that is being drawn, 0: none; all before it
  std::atomic<double> loss_{-1}, share_{1};
  // The solver's own.
  int64_t step_began_ = 0, drawn_before_ = 0;
  double busy_ = 0;
  Recent alone_, beside_;
};

}  // namespace limberg
