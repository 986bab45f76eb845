#pragma once
// Says in words when the patient falls behind the hand, and when it keeps up again; in slow motion how fast the
// session's clock runs, and when as fast as the wall's again. Not at every flicker.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "app/words/words.h"

namespace limberg {

class PaceWatch {
 public:
  /// Behind from so many ms on (MacKenzie and Ware 1993: a lag begins to cost there), keeping up again below two thirds
  /// of it.
  static constexpr int64_t kBehind_ms = 75, kKeepsUp_ms = 50;
  static constexpr int64_t kAfter_ms = 200, kAgainAfter_ms = 1000;  // that long without a break

  /// At a time, how old what the hand has of the patient is. Returns what is to be said; mostly nothing.
  std::string look(int64_t now_ms, int64_t behind_ms) {
    if (behind_ms >= kBehind_ms) {
      kept_up_since_ = now_ms;
      if (fell_at_ < 0) fell_at_ = now_ms, worst_ms_ = 0;
      worst_ms_ = std::max(worst_ms_, behind_ms);
      const bool longer = now_ms - fell_at_ >= kAfter_ms, worse = worst_ms_ >= 2 * said_ms_;
      if (!longer || (behind_ && (!worse || now_ms - said_at_ < 2 * kAgainAfter_ms))) return "";
      behind_ = true, said_at_ = now_ms, said_ms_ = worst_ms_;
      return fmt::format(english("the patient is {} ms behind your hand"), worst_ms_);
    }
    if (!behind_) fell_at_ = -1;
    if (behind_ms >= kKeepsUp_ms) kept_up_since_ = now_ms;
    if (!behind_ || now_ms - kept_up_since_ < kAgainAfter_ms) return "";
    behind_ = false, fell_at_ = -1, said_ms_ = 0;
    return english("the patient keeps up with your hand again");
  }
  bool behind() const { return behind_; }

 private:
  bool behind_ = false;
  int64_t fell_at_ = -1, worst_ms_ = 0, said_ms_ = 0, said_at_ = 0, kept_up_since_ = 0;
};

class SlowWatch {
 public:
  /// Slowed below, and as fast as the wall's again above; said again when it differs by so much, and not too often.
  static constexpr double kSlowed = 0.95, kReal = 0.98, kOther = 0.095;
  static constexpr int64_t kAgainAfter_ms = 2000;

  /// At a time of the wall, the pace over the last second. Returns what is to be said; mostly nothing.
  std::string look(int64_t now_ms, double pace) {
    const bool slowed = said_ < 1 ? pace < kReal : pace < kSlowed;
    if (slowed ? std::abs(pace - said_) < kOther && said_ < 1 : said_ == 1) return "";
    if (said_at_ms_ >= 0 && now_ms - said_at_ms_ < kAgainAfter_ms) return "";
    said_at_ms_ = now_ms;
    said_ = slowed ? pace : 1;
    return slowed ? words(pace) : english("in real time again");
  }
  static std::string words(double pace) {
    return fmt::format(english("slowed: {:.1f} of real time"), std::min(pace, 0.9));
  }

 private:
  double said_ = 1;
  int64_t said_at_ms_ = -1;
};

}  // namespace limberg
