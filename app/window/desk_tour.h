#pragma once
// The tour of one minute that the first start begins with: six cards, each beside the panel that it speaks of. A card
// that asks for something goes on by itself once that was done, by mouse, device or keys; Enter goes on in any case.
#include <vector>

#include "app/window/desk_layout.h"
#include "app/words/words.h"

namespace limberg {

/// What the learner has done since the last frame.
struct TourSeen {
  bool turned = false;     // the view
  bool chose = false;      // a tool
  bool acted = false;      // an act was done, or is being shown
  bool took_back = false;  // an act was undone, or the list of acts opened
  bool looked_up = false;  // the keys, or a menu
};

class DeskTour {
 public:
  static constexpr int kCards = 6;
  static constexpr int kPraiseFrames = 24;  // so long a card says that it was done
  bool open() const { return card_ > 0; }
  void begin() { card_ = 1, praise_ = 0; }
  void end() { card_ = 0; }
  void next() { card_ = card_ < kCards ? card_ + 1 : 0, praise_ = 0; }
  void back() { card_ = card_ > 1 ? card_ - 1 : card_, praise_ = 0; }
  int card() const { return card_; }
  /// Once a frame. True: the tour wants to be drawn again soon.
  bool see(const TourSeen& seen);
  bool praises() const { return praise_ > 0; }
  /// What the card covers goes into `covered`.
  void draw(const DeskLayout& layout, std::vector<FrameRect>& covered, const Words& words);

 private:
  int card_ = 0;    // 0: closed
  int praise_ = 0;  // frames that are left of it
};

}  // namespace limberg
