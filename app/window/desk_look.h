#pragma once
// How the window's panels look: colours, flags, and the few shapes that several of them share. For .cpp files of the
// desk only.
#include <imgui.h>

#include <initializer_list>
#include <string>
#include <vector>

#include "app/words/words.h"

namespace limberg::desk_look {

/// The colours of words. They stand in the style (window_style.h), in places that belong to widgets which no panel has,
/// so that a set of colours is chosen once for all panels.
namespace ink {
inline ImVec4 of(ImGuiCol slot) { return ImGui::GetStyle().Colors[slot]; }
inline constexpr ImGuiCol kSlot[] = {ImGuiCol_TextDisabled,     ImGuiCol_PlotLines, ImGuiCol_PlotLinesHovered,
                                     ImGuiCol_DragDropTarget,   ImGuiCol_Text,      ImGuiCol_NavWindowingHighlight,
                                     ImGuiCol_NavWindowingDimBg};
inline ImVec4 quiet() { return of(kSlot[0]); }
inline ImVec4 good() { return of(kSlot[1]); }
inline ImVec4 warn() { return of(kSlot[2]); }
inline ImVec4 bad() { return of(kSlot[3]); }
inline ImVec4 plain() { return of(kSlot[4]); }
inline ImVec4 shown() { return of(kSlot[5]); }
inline ImVec4 hint() { return of(kSlot[6]); }
}  // namespace ink

inline constexpr ImGuiWindowFlags kPanel = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                                           ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                                           ImGuiWindowFlags_NoTitleBar;

/// Of those that stand round the patient: what lies over them stays there when they are clicked.
inline constexpr ImGuiWindowFlags kGround = kPanel | ImGuiWindowFlags_NoBringToFrontOnFocus;

/// What a thing does, while the mouse rests on it.
inline void tip(const std::string& words) {
  if (!ImGui::IsItemHovered()) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(300);
  ImGui::TextUnformatted(words.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

inline void heading(const char* text) {
  ImGui::Spacing();
  ImGui::TextColored(ink::quiet(), "%s", text);
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

inline void text(const std::string& words) { ImGui::TextUnformatted(words.c_str()); }
inline void text(const ImVec4& colour, const std::string& words) { ImGui::TextColored(colour, "%s", words.c_str()); }
inline void wrapped(const std::string& words) { ImGui::TextWrapped("%s", words.c_str()); }
/// A button of its place's name in another language: what it is called has no part in what it is.
inline bool button(const Words& w, const char* english, float width = 0) {
  return ImGui::Button(w(english), {width, 0});
}

/// A choice of words.
inline bool choice(const char* id, int& value, const Words& w, std::initializer_list<const char*> english) {
  std::vector<const char*> shown;
  for (const char* e : english) shown.push_back(w(e));
  return ImGui::Combo(id, &value, shown.data(), int(shown.size()));
}

}  // namespace limberg::desk_look
