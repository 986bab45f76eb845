#pragma once
// How the window's panels look: colours, flags, and the few shapes that several of them share. For .cpp files of the
// desk only.
#include <imgui.h>

namespace limberg::desk_look {

inline const ImVec4 kQuiet{0.66f, 0.72f, 0.74f, 1}, kGood{0.55f, 0.85f, 0.60f, 1}, kWarn{0.97f, 0.72f, 0.35f, 1},
    kBad{0.98f, 0.45f, 0.40f, 1}, kNow{0.96f, 0.97f, 0.97f, 1}, kShown{0.55f, 0.76f, 0.95f, 1},
    kHint{0.95f, 0.88f, 0.55f, 1};

inline constexpr ImGuiWindowFlags kPanel = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                                           ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                                           ImGuiWindowFlags_NoTitleBar;

inline void heading(const char* text) {
  ImGui::Spacing();
  ImGui::TextColored(kQuiet, "%s", text);
  ImGui::Separator();
}

/// A line of a list: what goes before it stands alone on the left, its words wrap beside it.
inline void listed(const ImVec4& colour, float indent, const char* before, const char* words) {
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::TextUnformatted(before);
  ImGui::SameLine(indent);
  ImGui::TextWrapped("%s", words);
  ImGui::PopStyleColor();
}

}  // namespace limberg::desk_look
