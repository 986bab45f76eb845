#pragma once
// Slow motion for a live hand: how fast the session's clock may run, so that the patient is never far behind it.
//
// A hand that is emulated or recorded waits for the patient; a live one cannot. In slow motion the clock waits, evenly:
// time on which everything rests (ticks, steps, dwell, stamps of samples) passes more slowly, the hand seems the faster
// for it, and no step is skipped. Two things slow it:
//
//   pace   goes by how long the last steps took of the wall's time, once the patient was more than kLag behind; it is
//          kSpare of what they allow, so that the lag is made up for
//   brake  from kLag on the clock runs at the least pace until the step that takes so long is done
//
// A patient that is kMost behind all the same loses steps, as without slow motion, and the person is told.
//
// No clock: times are handed in.
#include <algorithm>
#include <cstdint>

#include "devices/session_time.h"

namespace limberg {

class SlowMotion {
 public:
  /// Of session time: a lag that costs a hand nothing yet, and one at which its errors have doubled (MacKenzie and Ware
  /// 1993: 75 and 225 ms).
  static constexpr int64_t kLag_ns = 50'000'000, kMost_ns = 200'000'000;
  static constexpr double kSpare = 0.9;

  explicit SlowMotion(int64_t period_ns) : period_(period_ns), mean_ns_(double(period_ns) / 2) {}

  /// Of a step that begins so late: how many periods are given up.
  int64_t given_up(int64_t late_ns) const { return late_ns < kMost_ns ? 0 : late_ns / period_; }
  /// A step is done that took so much of the wall's time, and until then the patient was so far behind. The pace from
  /// now on, in thousandths.
  int64_t pace_after(int64_t took_wall_ns, int64_t behind_ns) {
    const double longest = double(period_) * double(SlowedTime::kWhole) / double(SlowedTime::kLeast);
    mean_ns_ += (std::min(double(took_wall_ns), longest) - mean_ns_) / kSteps;
    const double bearable = kSpare * double(period_) / std::max(mean_ns_, 1.0);
    if (behind_ns > kLag_ns) slow_ = true;
    if (bearable >= 1) slow_ = false;
    if (!slow_) return SlowedTime::kWhole;
    return std::clamp(int64_t(bearable * double(SlowedTime::kWhole)), SlowedTime::kLeast, SlowedTime::kWhole);
  }
  /// The session time from which on the clock is held back, when the patient shown is of that time.
  static int64_t brake_ns(int64_t shown_ns) { return shown_ns + kLag_ns; }

 private:
  static constexpr double kSteps = 8;  // over which the mean is taken
  int64_t period_;
  double mean_ns_;  // of a step
  bool slow_ = false;
};

/// What the solver's thread does to a session's clock.
class Slowing {
 public:
  /// `time`: null: nothing. `shown_ns`: session time of the patient that is there at the beginning.
  Slowing(SlowedTime* time, int64_t period_ns, int64_t shown_ns, int64_t wall_ns)
      : time_(time), motion_(period_ns), shown_ns_(shown_ns), ended_wall_ns_(wall_ns) {
    if (time_) time_->bend(wall_ns, pace_, SlowMotion::brake_ns(shown_ns_));
  }
  int64_t given_up(int64_t late_ns) const { return motion_.given_up(late_ns); }
  /// A step has ended that was due at `due_ns` of the session and began `late_ns` of it later.
  void ended(int64_t due_ns, int64_t late_ns, int64_t began_wall_ns, int64_t wall_ns) {
    if (!time_) return;
    // What kept it from beginning when it was due counts as its own; but nothing before the last one's end.
    const int64_t due_wall_ns = began_wall_ns - late_ns * SlowedTime::kWhole / pace_;
    pace_ = motion_.pace_after(wall_ns - std::max(due_wall_ns, ended_wall_ns_), time_->at(wall_ns) - shown_ns_);
    shown_ns_ = due_ns, ended_wall_ns_ = wall_ns;
    time_->bend(wall_ns, pace_, SlowMotion::brake_ns(shown_ns_));
  }
  /// Nobody operates any more: the clock keeps the wall's pace.
  void let_go(int64_t wall_ns) {
    if (time_) time_->bend(wall_ns, SlowedTime::kWhole, SlowedTime::kNever);
    time_ = nullptr;
  }

 private:
  SlowedTime* time_;
  SlowMotion motion_;
  int64_t shown_ns_, ended_wall_ns_, pace_ = SlowedTime::kWhole;
};

/// How fast session time went by over about a second, and the slowest such second.
class PaceOverASecond {
 public:
  /// At growing times of the wall, some hundred a second at most.
  void look(int64_t wall_ns, int64_t session_ns) {
    if (n_ == 0 || wall_ns - wall_[(n_ - 1) % kKept] >= 1'000'000'000 / int64_t(kKept - 1)) {
      wall_[n_ % kKept] = wall_ns, session_[n_ % kKept] = session_ns;
      ++n_;
    }
    const size_t oldest = n_ >= kKept ? n_ % kKept : 0;
    const int64_t passed = wall_ns - wall_[oldest];
    if (passed < 900'000'000) return;  // less says little
    pace_ = double(session_ns - session_[oldest]) / double(passed);
    slowest_ = std::min(slowest_, pace_);
  }
  double pace() const { return pace_; }
  double slowest() const { return slowest_; }

 private:
  static constexpr size_t kKept = 51;
  int64_t wall_[kKept]{}, session_[kKept]{};
  size_t n_ = 0;
  double pace_ = 1, slowest_ = 1;
};

}  // namespace limberg
