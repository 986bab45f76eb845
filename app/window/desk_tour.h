#pragma once
// The tour of one minute that the first start begins with: six cards, each beside the panel that it speaks of.
#include <vector>

#include "app/window/desk_layout.h"
#include "app/words/words.h"

namespace limberg {

class DeskTour {
 public:
  static constexpr int kCards = 6;
  bool open() const { return card_ > 0; }
  void begin() { card_ = 1; }
  void end() { card_ = 0; }
  void next() { card_ = card_ < kCards ? card_ + 1 : 0; }
  void back() { card_ = card_ > 1 ? card_ - 1 : card_; }
  int card() const { return card_; }
  /// What the card covers goes into `covered`.
  void draw(const DeskLayout& layout, std::vector<FrameRect>& covered, const Words& words);

 private:
  int card_ = 0;  // 0: closed
};

}  // namespace limberg
