#pragma once
// What the marker pen has drawn on the skin: lines of the skin, which go with it, and how long each is. A swab wipes
// off what it passes.
#include <string>
#include <vector>

#include "app/pictures/skin_line.h"
#include "app/words/words.h"
#include "devices/skin_chart.h"
#include "devices/tool_event.h"
#include "render/props.h"

namespace limberg {

class PenSheet {
 public:
  /// An act of the pen or of the swab, seen when it is next drawn; every other is passed over.
  void hear(const Command& command);
  /// The pen is here: what it draws is seen at once, and is a line when the act is heard of. Of every other tool that
  /// is drawn along a line the way is seen as long as it is pressed; of a row of stitches that along the first edge
  /// until the second was drawn too.
  void follow(const ToolState& hand);

  struct Length {
    Vec3f at_mm = Vec3f::Zero();  // the line's end
    std::string text;             // along the skin under the line, now and at rest
  };
  /// What is to be drawn over this patient. Over a hole a line is broken.
  void draw(const Snapshot& patient, const Words& words);
  const PropMesh& props() const { return props_; }
  const std::vector<Length>& lengths() const { return lengths_; }
  size_t lines() const { return lines_.size(); }
  /// How many places of the present stroke's way are drawn.
  size_t trail() const;

 private:
  struct Line {
    SkinLine drawn;
    std::vector<SkinTouch> at;  // on the skin of the present topology; of each only where it is at rest holds
  };
  void trace(const ToolState& hand, const Vec3f& tip);
  /// All lines on this patient's skin; then what was heard of since.
  void lay(const Snapshot& patient);
  std::vector<Line> lines_;
  std::vector<SkinLine> heard_;            // since the last drawing
  std::vector<Vec3f> wet_;                 // of the line that is being drawn
  std::vector<std::vector<Vec3f>> trail_;  // of another tool's present stroke, and of a row's first
  int32_t traced_ = 0;                     // which tool
  bool pressed_ = false;
  SkinChart chart_;
  PropMesh props_;
  std::vector<Length> lengths_;
};

}  // namespace limberg
