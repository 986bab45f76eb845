#include "app/window/desk_history.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>

#include "app/window/desk_look.h"

namespace limberg {

using namespace desk_look;

std::optional<size_t> DeskHistory::draw(const ActHistory& acts, const FrameRect& at, const Picture& picture,
                                        std::vector<FrameRect>& covered, const Words& w) {
  ImGui::SetNextWindowPos({at.x0, at.y0});
  ImGui::SetNextWindowSize({wide(at), high(at)});
  ImGui::SetNextWindowBgAlpha(1);
  ImGui::Begin("history", nullptr, kGround);
  covered.push_back(at);
  std::optional<size_t> wanted;
  const std::vector<ActHistory::Entry>& all = acts.entries();
  const int n = int(all.size());
  if (n == 0) {
    text(ink::quiet(), w("Acts stand here with a picture each, to go back to and forth."));
    ImGui::End();
    return wanted;
  }
  int standing = int(acts.standing());
  const std::string words = standing == n ? w("all {} stand", n) : w("{} of {} stand", standing, n);
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(words.c_str());
  ImGui::SameLine(std::max(110.0f, ImGui::CalcTextSize(words.c_str()).x + 20));
  ImGui::PushItemWidth(-1);
  if (ImGui::SliderInt("##standing", &standing, 0, n, "", ImGuiSliderFlags_AlwaysClamp)) wanted = size_t(standing);
  ImGui::PopItemWidth();
  tip(w("Undo to the left, redo to the right. Ctrl+Z and Ctrl+Y go by one act."));
  ImGui::BeginChild("acts", {0, 0}, false, ImGuiWindowFlags_HorizontalScrollbar);
  for (int i = 0; i <= n; ++i) {
    ImGui::PushID(i);
    if (i > 0) ImGui::SameLine();
    const bool now = size_t(i) == acts.standing();
    const ImVec2 size(kPictureWidth, kPictureHeight), from = ImGui::GetCursorScreenPos();
    if (ImGui::InvisibleButton("act", {size.x, size.y + 2})) wanted = size_t(i);
    tip(i == 0 ? std::string(w("Before the first act"))
        : size_t(i) > acts.standing()
            ? w("{}. {}, {:.0f} s (undone)", i, w.said(all[size_t(i) - 1].text), all[size_t(i) - 1].t_s)
            : w("{}. {}, {:.0f} s", i, w.said(all[size_t(i) - 1].text), all[size_t(i) - 1].t_s));
    ImDrawList& d = *ImGui::GetWindowDrawList();
    void* const shown = picture(i > 0 ? all[size_t(i) - 1] : acts.start());
    const ImVec2 to(from.x + size.x, from.y + size.y);
    const bool undone = size_t(i) > acts.standing();
    if (shown)
      d.AddImage(shown, from, to, {0, 0}, {1, 1}, undone ? IM_COL32(255, 255, 255, 110) : IM_COL32_WHITE);
    else
      d.AddRectFilled(from, to, ImGui::GetColorU32(ImGuiCol_FrameBg));
    const std::string name = i == 0 ? w("start") : std::to_string(i);
    d.AddRectFilled(from, {from.x + ImGui::CalcTextSize(name.c_str()).x + 6, from.y + 16}, IM_COL32(10, 16, 20, 200));
    d.AddText({from.x + 3, from.y + 1}, IM_COL32_WHITE, name.c_str());
    if (now || ImGui::IsItemFocused())
      d.AddRect(from, to, ImGui::ColorConvertFloat4ToU32(now ? ink::hint() : ink::shown()), 0, 0, 2.5f);
    if (now && acts.standing() != last_) ImGui::SetScrollHereX(0.5f);
    ImGui::PopID();
  }
  last_ = acts.standing();
  ImGui::EndChild();
  ImGui::End();
  return wanted;
}

}  // namespace limberg
