// What the desk writes over the patient: the legend of the colours, before and after, names and letters, the ruler.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "app/window/desk.h"
#include "app/window/desk_look.h"
#include "render/colour_map.h"
#include "render/overlay.h"

namespace limberg {

using namespace desk_look;

void Desk::legend(const DeskReading& r, const FrameRect& stage) {
  if (!r.field || r.field->value.empty()) return;
  const SkinFieldLook& look = r.look ? *r.look : look_of(state.field);
  constexpr float kAround = 108, kLeast = 60;
  const float left = stage.x1 - 128, top = std::max(stage.y0 + 0.1f * high(stage), stage_top_ + 8),
              bar = std::min(0.5f * high(stage), stage_bottom_ - 8 - top - kAround);
  if (bar < kLeast) return;  // there is no room beside what is said
  ImGui::SetNextWindowPos({left, top});
  ImGui::SetNextWindowSize({120, bar + 108});
  ImGui::SetNextWindowBgAlpha(0.88f);
  ImGui::Begin("legend", nullptr, kPanel | ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoScrollbar);
  const Words& w = facts_.w;
  wrapped(w(look.title));
  text(ink::quiet(), w(look.unit));
  ImDrawList& d = *ImGui::GetWindowDrawList();
  const float x0 = left + 12, y0 = top + 84, x1 = x0 + 18;
  const auto at = [&](double t) {
    const Rgb8 c = colour_of(look.scale, t);
    return IM_COL32(c.r, c.g, c.b, 255);
  };
  constexpr int kSteps = 64;
  for (int i = 0; i < kSteps; ++i)
    d.AddRectFilled({x0, y0 + bar * float(i) / kSteps}, {x1, y0 + bar * float(i + 1) / kSteps + 1},
                    at(1 - (i + 0.5) / kSteps));
  const double range = r.field->hi - r.field->lo, step = range / std::max(1, r.field->intervals);
  // Values lie beyond the scale: a triangle says so.
  if (r.field->above) d.AddTriangleFilled({x0, y0 - 3}, {x1, y0 - 3}, {0.5f * (x0 + x1), y0 - 12}, at(1));
  if (r.field->below)
    d.AddTriangleFilled({x0, y0 + bar + 4}, {x1, y0 + bar + 4}, {0.5f * (x0 + x1), y0 + bar + 13}, at(0));
  constexpr float kApart = 14;  // so high is a number
  const int every = std::max(1, int(std::ceil(kApart * float(std::max(1, r.field->intervals)) / bar)));
  for (int k = 0; k <= r.field->intervals; k += every) {
    const double v = r.field->lo + k * step;
    const float y = y0 + bar * float(1 - (v - r.field->lo) / range);
    d.AddLine({x1, y}, {x1 + 5, y}, IM_COL32(240, 245, 245, 255));
    d.AddText({x1 + 9, y - 8}, IM_COL32(240, 245, 245, 255), w.said(tick_label(v, step)).c_str());
  }
  ImGui::End();
}

void Desk::compared(const DeskReading& r, const FrameRect& stage) {
  if (state.compare != Compare::off) {
    const bool wipe = state.compare == Compare::wipe;
    const Words& w = facts_.w;
    const char *const earlier = r.earlier_try ? w("earlier try") : w("before"), *const later = r.earlier_try
                                                                                                   ? w("this try")
                                                                                                   : w("after");
    const float left = stage.x0, right = stage.x1,
                border = wipe ? left + state.wipe * (right - left) : 0.5f * (left + right);
    ImDrawList& d = *ImGui::GetBackgroundDrawList();
    const ImU32 ink = IM_COL32(240, 245, 245, 230);
    d.AddLine({border, stage.y0}, {border, stage.y1}, ink, 1.5f);
    for (const auto& [word, x] :
         {std::pair(earlier, border - 10 - ImGui::CalcTextSize(earlier).x), std::pair(later, border + 10)}) {
      const ImVec2 size = ImGui::CalcTextSize(word);
      if (x < left || x + size.x > right) continue;
      const float y = stage_top_;
      d.AddRectFilled({x - 5, y + 7}, {x + size.x + 5, y + 13 + size.y}, IM_COL32(15, 22, 26, 170), 3);
      d.AddText({x, y + 10}, ink, word);
    }
  }
}

void Desk::marks(const DeskReading& r, const FrameRect& stage) {
  ImDrawList& d = *ImGui::GetBackgroundDrawList();
  d.PushClipRect({stage.x0, std::min(stage_top_, stage.y1)}, {stage.x1, stage.y1});  // none shines through words
  std::vector<FrameRect> taken;                                                      // by letters
  const auto is_free = [&](const FrameRect& a) {
    return std::none_of(taken.begin(), taken.end(),
                        [&](const FrameRect& b) { return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1; });
  };
  for (const DeskMark& m : r.marks) {
    if (m.kind != DeskMark::Kind::landmark) {  // a letter beside its corner, the name of a limit
      if (m.hidden) continue;
      const ImVec2 size = ImGui::CalcTextSize(m.name.c_str());
      const ImU32 paper = m.kind == DeskMark::Kind::limit    ? IM_COL32(120, 12, 12, 225)
                          : m.kind == DeskMark::Kind::length ? IM_COL32(18, 26, 30, 225)
                                                             : IM_COL32(62, 24, 98, 225);
      // On the upper right of its place, or where there is room: corners that were sewn together have one place.
      float x = m.x + 7, y = m.y - 20;
      const float left = m.x - 7 - size.x, below = m.y + 6;
      FrameRect on;
      for (const auto& [tx, ty] : {std::pair(x, y), {left, y}, {left, below}, {x, below}}) {
        on = {tx - 4, ty - 1, tx + size.x + 4, ty + size.y + 1};
        if (is_free(on)) {
          x = tx, y = ty;
          break;
        }
      }
      on = {x - 4, y - 1, x + size.x + 4, y + size.y + 1};
      taken.push_back(on);
      d.AddRectFilled({on.x0, on.y0}, {on.x1, on.y1}, paper, 4);
      d.AddText({x, y}, IM_COL32(250, 250, 250, 255), m.name.c_str());
      continue;
    }
    const ImU32 ink = m.hidden ? IM_COL32(140, 225, 255, 110) : IM_COL32(140, 225, 255, 255);
    if (m.hidden)
      d.AddCircle({m.x, m.y}, 4, ink, 12, 1.5f);
    else
      d.AddCircleFilled({m.x, m.y}, 4, IM_COL32(10, 30, 40, 255)), d.AddCircleFilled({m.x, m.y}, 3, ink);
    const ImVec2 size = ImGui::CalcTextSize(m.name.c_str());
    d.AddRectFilled({m.x + 6, m.y - 8}, {m.x + 12 + size.x, m.y - 4 + size.y},
                    IM_COL32(15, 22, 26, m.hidden ? 70 : 150), 3);
    d.AddText({m.x + 9, m.y - 6}, ink, m.name.c_str());
  }
  d.PopClipRect();
}

void Desk::ruler(const DeskReading& r, const std::vector<Vec3f>& ruler_px) {
  if (!ruler_px.empty()) {
    ImDrawList& d = *ImGui::GetBackgroundDrawList();
    const ImU32 ink = IM_COL32(255, 240, 120, 255);
    for (size_t i = 0; i < ruler_px.size(); ++i) {
      if (i > 0) d.AddLine({ruler_px[i - 1].x(), ruler_px[i - 1].y()}, {ruler_px[i].x(), ruler_px[i].y()}, ink, 2);
      d.AddCircleFilled({ruler_px[i].x(), ruler_px[i].y()}, 4, ink);
    }
    const Words& w = facts_.w;
    std::string text = w("second point?");
    if (ruler_px.size() >= 2) text = w("{:.1f} mm ({:.1f} at rest)", r.ruler.length_mm, r.ruler.rest_mm);
    if (ruler_px.size() == 3) text += w(", {:.1f}\u00b0", r.ruler.angle_deg);
    const Vec3f& p = ruler_px.back();
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    d.AddRectFilled({p.x() + 8, p.y() + 4}, {p.x() + 16 + size.x, p.y() + 10 + size.y}, IM_COL32(15, 22, 26, 200), 3);
    d.AddText({p.x() + 12, p.y() + 7}, ink, text.c_str());
  }
}

}  // namespace limberg
