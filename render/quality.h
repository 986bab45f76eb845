#pragma once
// How finely frames are drawn, chosen from how long they took: finer while there is time, plainer when there is not.
//
// A level is left downwards when the median of the last frames is above the budget, and upwards
// when the next level is expected to need at most 0.7 of it: what it took when it was tried
// last, else twice what this one takes. A level that has just failed is not tried again for a
// while, which doubles each time, so that the picture does not flicker between two levels.
#include <algorithm>
#include <array>

namespace limberg {

struct QualityLevel {
  const char* name;
  bool fine_skin, shadow;
  bool occlusion;   // creases and corners that little of the room's light reaches are darker
  bool still;       // for pictures that are kept: sixteen taps of a larger shadow map, textures sharp when seen aslant
  int shrink;       // of a window: the patient is drawn this many times smaller and enlarged
  int supersample;  // of pictures read back; a window's frames are not
};
inline constexpr std::array<QualityLevel, 6> kQualityLevels{{{"half size", false, false, false, false, 2, 1},
                                                             {"fast", false, false, false, false, 1, 1},
                                                             {"fine skin", true, false, false, false, 1, 1},
                                                             {"shadows", true, true, false, false, 1, 1},
                                                             {"shadows, occlusion", true, true, true, false, 1, 1},
                                                             {"best", true, true, true, true, 1, 2}}};
inline constexpr int kLiveLevels = 5;  // those that a window uses
inline constexpr int kFastLevel = 1;   // the first at full size
inline constexpr int kFilmLevel = 4;   // the light of the best, without its smooth edges

class QualityLadder {
 public:
  /// budget_ms: what a frame may take. levels: how many of kQualityLevels may be chosen; start: the first of them.
  explicit QualityLadder(double budget_ms, int levels = kLiveLevels, int start = kFastLevel)
      : budget_ms_(budget_ms), levels_(levels), level_(start) {}

  int level() const { return level_; }
  /// After a frame that was drawn at level().
  void frame(double ms) {
    recent_[size_t(seen_++ % kFrames)] = ms;
    if (seen_ < kFrames) return;
    std::array<double, kFrames> sorted = recent_;
    std::nth_element(sorted.begin(), sorted.begin() + kFrames / 2, sorted.end());
    const double median = sorted[kFrames / 2];
    took_[size_t(level_)] = median;
    ++here_;
    if (here_ > kSettled) wait_[size_t(level_)] = 0;  // it has proved itself
    if (median > budget_ms_ && level_ > 0) {
      wait_[size_t(level_)] = std::min(2 * std::max(wait_[size_t(level_)], kPatience), kLongest);
      go(level_ - 1);
    } else if (level_ + 1 < levels_) {
      const size_t next = size_t(level_) + 1;
      const double expected = took_[next] > 0 && here_ < wait_[next] ? took_[next] : 2 * median;
      if (here_ >= kPatience && expected <= kRoom * budget_ms_) go(level_ + 1);
    }
  }

 private:
  static constexpr int kFrames = 8, kPatience = 30, kLongest = 3000, kSettled = 600;  // frames
  static constexpr double kRoom = 0.7;
  void go(int level) { level_ = level, seen_ = 0, here_ = 0; }

  double budget_ms_;
  int levels_, level_, seen_ = 0, here_ = 0;
  std::array<double, kFrames> recent_{};
  std::array<double, kQualityLevels.size()> took_{};
  std::array<int, kQualityLevels.size()> wait_{};
};

}  // namespace limberg
