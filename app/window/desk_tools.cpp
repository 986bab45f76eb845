// The menus, and the panel of tools, their settings and the choices of the view.
#include <fmt/format.h>
#include <imgui.h>

#include <array>

#include "app/window/desk.h"
#include "app/window/desk_look.h"

namespace limberg {

using namespace desk_look;

namespace {

// Two buttons side by side, as wide as there is room.
float half_width() { return 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x); }

void button(const char* name, float width, bool& asked, const char* help) {
  if (ImGui::Button(name, {width, 0})) asked = true;
  tip(help);
}

}  // namespace

void Desk::choose_field(SkinField field) {
  state.field = facts_.skin || field == SkinField::moved ? field : SkinField::none;
}

void Desk::choose(Tool tool) {
  state.tool_changed |= tool != state.tool;
  state.tool = tool;
  if (tool != Tool::none) state.ruler = false;
}

// Of the keys those that stand in this menu: a choice is what its key does.
void Desk::menu_items(const char* menu) {
  for (const DeskKey& k : desk_keys()) {
    if (std::string_view(k.menu) != menu) continue;
    const bool letters = k.code[0] == '=';
    if (ImGui::MenuItem(k.title, k.keys.c_str())) {
      if (k.act)
        k.act(*this, 0);
      else if (letters)
        key('=', WindowEvent::control);
    }
    tip(k.what);
    if (letters && ImGui::MenuItem("Smaller letters")) key('-', WindowEvent::control);
  }
}

void Desk::menu(float width) {
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({width, 0});
  if (!ImGui::BeginMainMenuBar()) return;
  const ImVec2 size = ImGui::GetWindowSize();
  covered_.push_back({0, 0, size.x, size.y});
  if (ImGui::BeginMenu("Session")) {
    if (ImGui::MenuItem("Undo", "Ctrl+Z")) state.undo = true;
    tip("The last act that changed the patient is taken back.");
    if (ImGui::MenuItem("Redo", "Ctrl+Y")) state.redo = true;
    tip("What was undone last is done again.");
    menu_items("Session");
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu("Tools")) {
    for (const DeskTool& t : kDeskTools) {
      if (!offered(t.tool)) continue;
      if (ImGui::MenuItem(t.name, key_words(t).c_str(), state.tool == t.tool && !state.ruler)) choose(t.tool);
      tip(t.help);
    }
    ImGui::Separator();
    menu_items("Tools");
    ImGui::EndMenu();
  }
  for (const char* name : {"View", "Lesson", "Help"})
    if (ImGui::BeginMenu(name)) {
      menu_items(name);
      ImGui::EndMenu();
    }
  const std::string scene = facts_.scene;
  ImGui::SameLine(width - ImGui::CalcTextSize(scene.c_str()).x - 12);
  ImGui::TextColored(ink::quiet(), "%s", scene.c_str());
  ImGui::EndMainMenuBar();
}

bool Desk::offered(Tool tool) const { return tool == Tool::none || (acts_on_bone(tool) ? facts_.head : facts_.skin); }

void Desk::tool_row(const DeskTool& t, const DeskReading& r) {
  const bool has = r.hand_tool.value_or(state.tool) == t.tool && !state.ruler;
  if (ImGui::Selectable(fmt::format("{}{}  {}", t.shift ? "\u21e7" : "  ", char(t.key), t.name).c_str(), has))
    choose(t.tool);
  tip(std::string(t.help) + "  Key: " + key_words(t) + ".");
}

void Desk::settings(Tool tool) {
  ImGui::PushItemWidth(-1);
  for (const ToolSlider& k : tool_sliders(tool, facts_.max_depth_mm)) {
    ImGui::TextColored(ink::quiet(), "%s", k.name.c_str());
    state.tool_changed |=
        ImGui::SliderFloat(("##" + k.name).c_str(), &(state.*k.value), k.from, k.to, k.format.c_str());
    tip(k.help);
  }
  ImGui::PopItemWidth();
}

void Desk::view_choices() {
  ImGui::PushItemWidth(-1);
  if (ImGui::BeginCombo("##field", state.field == SkinField::none ? "No colours" : look_of(state.field).name)) {
    for (int k = 0; k < kSkinFields; ++k)
      if (k == 0 || facts_.skin || SkinField(k) == SkinField::moved)
        if (ImGui::Selectable(k == 0 ? "No colours" : look_of(SkinField(k)).name, int(state.field) == k))
          choose_field(SkinField(k));
    ImGui::EndCombo();
  }
  ImGui::PopItemWidth();
  if (state.field != SkinField::none) ImGui::Checkbox("Iso-lines", &state.iso_lines);
  if (facts_.skin) {
    ImGui::Checkbox("Directions", &state.directions);
    tip("In which the skin is stretched most and least.");
    ImGui::Checkbox("Tension lines", &state.tension_lines);
    ImGui::Checkbox("Lattice", &state.lattice);
    tip("The cells of the tissue; those of which a cut has made several copies in orange.");
  }
  if (facts_.head)
    ImGui::PushItemWidth(-1), ImGui::Combo("##face", &state.face, "Face\0Clear face\0No face\0"), ImGui::PopItemWidth();
  if (facts_.head) ImGui::Checkbox("Landmarks", &state.landmarks);
  ImGui::Checkbox("Triangles", &state.wireframe);
  if (ImGui::Checkbox("Measure", &state.ruler) && state.ruler) choose(Tool::none);
  tip("Two points a length, three an angle.");
  ImGui::PushItemWidth(-1);
  int compare = int(state.compare), stereo = int(state.stereo);
  if (ImGui::Combo("##compare", &compare, "No comparison\0Before | after: wipe\0Before, after\0"))
    state.compare = Compare(compare);
  if (state.compare == Compare::wipe) ImGui::SliderFloat("##wipe", &state.wipe, 0, 1, "");
  if (ImGui::Combo("##stereo", &stereo, "One eye\0Stereo side by side\0Stereo red-cyan\0"))
    state.stereo = Stereo(stereo);
  ImGui::Combo("##quality", &state.quality,
               "Quality: automatic\0Half size\0Fast\0Fine skin\0Shadows\0Shadows, occlusion\0");
  ImGui::PopItemWidth();
  const float half = half_width();
  button("Picture", half, state.picture, "The patient alone, into a file.");
  ImGui::SameLine();
  button("Home", half, state.home, "The first view again.");
}

void Desk::tools(const DeskReading& r, const FrameRect& at) {
  constexpr float kRoomForView = 760;
  panel("tools", at);
  ImGui::TextColored(ink::quiet(), "TOOLS");
  ImGui::Separator();
  for (const DeskTool& t : kDeskTools)
    if (offered(t.tool)) tool_row(t, r);
  if (r.hand_tool.value_or(state.tool) == state.tool) settings(state.tool);  // another hand's are its own
  ImGui::Spacing();
  const float half = half_width();
  button("Undo", half, state.undo, "Ctrl+Z. U shows all acts.");
  ImGui::SameLine();
  button("Redo", half, state.redo, "Ctrl+Y");
  ImGui::SetNextItemOpen(high(at) > kRoomForView, ImGuiCond_Once);
  if (ImGui::CollapsingHeader("View")) view_choices();

  heading("DEVICE");
  device(r);
  if (facts_.recording.empty()) {
    ImGui::Checkbox("Keep the recording", &state.keep_recording);
  } else {
    ImGui::TextColored(ink::bad(), "REC");
    ImGui::SameLine();
    ImGui::TextWrapped("%s", facts_.recording.c_str());
  }
  ImGui::End();
}

// What the device does, and what to do when it does nothing.
void Desk::device(const DeskReading& r) {
  ImGui::TextWrapped("%s", facts_.device.c_str());
  if (!facts_.own_device) return;
  const auto warn = [](const char* text) {
    ImGui::PushStyleColor(ImGuiCol_Text, ink::warn());
    ImGui::TextWrapped("%s", text);
    ImGui::PopStyleColor();
  };
  const bool begun = r.gauges && LaneGauges::get(r.gauges->tick) > 2500;
  if (begun && r.samples_per_s < 1)
    warn("silent: no sample for a second. Is it connected and switched on? limberg devices --watch shows what comes");
  else if (begun)
    ImGui::TextColored(ink::good(), "%.0f samples/s", r.samples_per_s);
  if (!facts_.calibrated) warn("not calibrated: limberg calibrate stylus, then --calibration FILE");
}

}  // namespace limberg
