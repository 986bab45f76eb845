#pragma once
// A row of pictures that takes long: how far it is, and whether a person has had enough of it.
#include <fmt/format.h>

#include "app/program/interrupt.h"
#include "app/result/progress.h"

namespace limberg {

class PicturesDrawn {
 public:
  explicit PicturesDrawn(int total) : total_(total) {}

  /// Before each picture; false: it is not to be drawn. Who was interrupted before the first picture gets them all:
  /// they show what was done by then.
  bool next() {
    if (stopped_) return false;
    if (!before_ && interrupted()) {
      stopped_ = true;
      progress_.clear();
      say(fmt::format("interrupted; {} of {} pictures are drawn", drawn_, total_));
      return false;
    }
    progress_.note(fmt::format("picture {} of {}", ++drawn_, total_));
    return true;
  }
  bool all() const { return !stopped_; }

 private:
  const int total_;
  const bool before_ = interrupted();
  int drawn_ = 0;
  bool stopped_ = false;
  Progress progress_{"drawing"};
};

}  // namespace limberg
