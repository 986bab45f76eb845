#include "app/window/window_style.h"

#include <imgui.h>

#include "app/window/desk_look.h"
#include "app/window/screen.h"

namespace limberg {

int imgui_key(int32_t code) {
  switch (code) {
    case WindowEvent::tab:
      return ImGuiKey_Tab;
    case WindowEvent::arrow_left:
      return ImGuiKey_LeftArrow;
    case WindowEvent::arrow_right:
      return ImGuiKey_RightArrow;
    case WindowEvent::arrow_up:
      return ImGuiKey_UpArrow;
    case WindowEvent::arrow_down:
      return ImGuiKey_DownArrow;
    case WindowEvent::home:
      return ImGuiKey_Home;
    case WindowEvent::end:
      return ImGuiKey_End;
    case WindowEvent::remove:
      return ImGuiKey_Delete;
    case WindowEvent::backspace:
      return ImGuiKey_Backspace;
    case WindowEvent::enter:
      return ImGuiKey_Enter;
    case WindowEvent::space:
      return ImGuiKey_Space;
    case WindowEvent::page_up:
      return ImGuiKey_PageUp;
    case WindowEvent::page_down:
      return ImGuiKey_PageDown;
    case WindowEvent::escape:
      return ImGuiKey_Escape;
    case 'A':
      return ImGuiKey_A;  // Ctrl: all of a text field
    default:
      return -1;
  }
}

namespace {

ImVec4 grey(float v) { return {v, v, v, 1}; }

/// Words: quiet, good, warn, bad, plain, shown, hint.
void set_inks(const ImVec4 (&words)[7]) {
  for (int i = 0; i < 7; ++i) ImGui::GetStyle().Colors[desk_look::ink::kSlot[i]] = words[i];
}

void dark() {
  ImVec4* c = ImGui::GetStyle().Colors;
  c[ImGuiCol_WindowBg] = c[ImGuiCol_MenuBarBg] = {0.07f, 0.10f, 0.115f, 1};
  c[ImGuiCol_Header] = {0.16f, 0.42f, 0.48f, 1};
  c[ImGuiCol_HeaderHovered] = {0.20f, 0.48f, 0.55f, 1};
  c[ImGuiCol_Button] = {0.16f, 0.30f, 0.34f, 1};
  c[ImGuiCol_ButtonHovered] = {0.22f, 0.42f, 0.48f, 1};
  c[ImGuiCol_FrameBg] = {0.14f, 0.20f, 0.22f, 1};
  c[ImGuiCol_TitleBg] = c[ImGuiCol_TitleBgActive] = {0.11f, 0.24f, 0.28f, 1};
  c[ImGuiCol_CheckMark] = {0.55f, 0.85f, 0.60f, 1};
  c[ImGuiCol_FrameBgHovered] = c[ImGuiCol_FrameBgActive] = {0.18f, 0.28f, 0.31f, 1};
  c[ImGuiCol_ButtonActive] = c[ImGuiCol_HeaderActive] = {0.26f, 0.52f, 0.58f, 1};
  c[ImGuiCol_Tab] = {0.11f, 0.20f, 0.23f, 1};
  c[ImGuiCol_TabActive] = {0.16f, 0.42f, 0.48f, 1};
  c[ImGuiCol_TabHovered] = {0.20f, 0.48f, 0.55f, 1};
  c[ImGuiCol_SliderGrab] = c[ImGuiCol_SliderGrabActive] = {0.35f, 0.65f, 0.70f, 1};
  c[ImGuiCol_TextSelectedBg] = {0.16f, 0.42f, 0.48f, 0.7f};
  c[ImGuiCol_PlotHistogram] = {0.25f, 0.52f, 0.58f, 1}, c[ImGuiCol_PlotHistogramHovered] = {0.75f, 0.45f, 0.20f, 1};
  set_inks({{0.66f, 0.72f, 0.74f, 1},
            {0.55f, 0.85f, 0.60f, 1},
            {0.97f, 0.72f, 0.35f, 1},
            {0.98f, 0.45f, 0.40f, 1},
            {0.96f, 0.97f, 0.97f, 1},
            {0.55f, 0.76f, 0.95f, 1},
            {0.95f, 0.88f, 0.55f, 1}});
}

/// Black on white: what a weak projector in a light room still shows.
void light() {
  ImGui::StyleColorsLight();
  ImVec4* c = ImGui::GetStyle().Colors;
  c[ImGuiCol_WindowBg] = c[ImGuiCol_MenuBarBg] = c[ImGuiCol_PopupBg] = grey(1);
  c[ImGuiCol_FrameBg] = grey(0.90f), c[ImGuiCol_Border] = grey(0.3f);
  c[ImGuiCol_PlotHistogram] = {0.35f, 0.65f, 0.85f, 1}, c[ImGuiCol_PlotHistogramHovered] = {0.95f, 0.60f, 0.25f, 1};
  set_inks({grey(0.27f),
            {0.0f, 0.36f, 0.06f, 1},
            {0.62f, 0.24f, 0.0f, 1},
            {0.72f, 0.0f, 0.0f, 1},
            grey(0),
            {0.0f, 0.22f, 0.62f, 1},
            {0.42f, 0.30f, 0.0f, 1}});
}

/// White and yellow on black.
void contrast() {
  dark();
  ImVec4* c = ImGui::GetStyle().Colors;
  c[ImGuiCol_WindowBg] = c[ImGuiCol_MenuBarBg] = c[ImGuiCol_PopupBg] = grey(0);
  c[ImGuiCol_Header] = c[ImGuiCol_HeaderHovered] = c[ImGuiCol_HeaderActive] = {0, 0.35f, 0.75f, 1};
  c[ImGuiCol_Button] = grey(0.22f), c[ImGuiCol_ButtonHovered] = c[ImGuiCol_ButtonActive] = {0, 0.35f, 0.75f, 1};
  c[ImGuiCol_FrameBg] = grey(0.20f), c[ImGuiCol_Border] = grey(1), c[ImGuiCol_CheckMark] = {1, 1, 0, 1};
  c[ImGuiCol_PlotHistogram] = {0, 0.45f, 0.85f, 1}, c[ImGuiCol_PlotHistogramHovered] = {0.85f, 0.35f, 0, 1};
  set_inks({grey(0.88f),
            {0.45f, 1, 0.5f, 1},
            {1, 0.8f, 0.2f, 1},
            {1, 0.55f, 0.5f, 1},
            grey(1),
            {0.6f, 0.85f, 1, 1},
            {1, 1, 0.35f, 1}});
}

}  // namespace

void set_style(DeskColours colours) {
  ImGui::StyleColorsDark();
  ImGuiStyle& s = ImGui::GetStyle();
  s.FrameRounding = 3, s.ItemSpacing = {6, 4}, s.WindowPadding = {9, 8};
  if (colours == DeskColours::light)
    light();
  else if (colours == DeskColours::contrast)
    contrast();
  else
    dark();
}

}  // namespace limberg
