#pragma once
// The panel of the acts that undo and redo go through: a picture of each, and a slider over all.
#include <functional>
#include <optional>
#include <vector>

#include "app/window/act_history.h"
#include "app/window/desk_layout.h"
#include "app/words/words.h"

namespace limberg {

class DeskHistory {
 public:
  static constexpr int kPictureWidth = 84, kPictureHeight = 54;
  /// A picture as Dear ImGui knows it; null: there is none yet.
  using Picture = std::function<void*(const ActHistory::Entry&)>;
  /// How many acts are to stand, when that was chosen.
  std::optional<size_t> draw(const ActHistory& acts, const FrameRect& at, const Picture& picture,
                             std::vector<FrameRect>& covered, const Words& words);

 private:
  size_t last_ = 0;  // standing in the last frame: the list follows
};

}  // namespace limberg
