#include "app/window/desk_layout.h"

#include <algorithm>
#include <cmath>

namespace limberg {

float desk_scale(int width, int height, int letters_percent) {
  constexpr float kLines = 1080, kColumns = 1500, kLargest = 3, kLeastWidth = 760, kLeastHeight = 560;
  const float by_screen =
      std::clamp(std::floor(4 * std::min(float(height) / kLines, float(width) / kColumns)) / 4, 1.0f, kLargest);
  const float most = std::min(float(width) / kLeastWidth, float(height) / kLeastHeight);
  return std::max(0.5f, std::min(by_screen * float(letters_percent) / 100, most));
}

DeskLayout desk_layout(float w, float h, bool history_open) {
  constexpr float kMenu = 22, kHistory = 128;
  DeskLayout l;
  l.narrow = w < 1000 || h < 640;
  const float tools = l.narrow ? 168 : 172, patient = w < 1000 ? 214 : 268, lanes = l.narrow ? 34 : 84;
  l.menu = {0, 0, w, kMenu};
  l.tools = {0, kMenu, tools, h};
  l.patient = {w - patient, kMenu, w, h};
  l.lanes = {tools, h - lanes, w - patient, h};
  const float above = history_open ? h - lanes - kHistory : h - lanes;
  if (history_open) l.history = {tools, above, w - patient, h - lanes};
  l.stage = {tools, kMenu, std::max(tools + 40, w - patient), std::max(kMenu + 40, above)};
  return l;
}

DeskStage desk_stage(int width, int height, float scale, bool history_open) {
  const float w = float(width) / scale, h = float(height) / scale;
  const FrameRect stage = desk_layout(w, h, history_open).stage;
  DeskStage s;
  s.u0 = stage.x0 / w, s.u1 = stage.x1 / w, s.v0 = stage.y0 / h, s.v1 = stage.y1 / h;
  s.aspect = double(s.u1 - s.u0) * double(width) / (double(s.v1 - s.v0) * double(height));
  return s;
}

}  // namespace limberg
