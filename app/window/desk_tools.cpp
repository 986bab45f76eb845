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

void asked_by(const Words& w, const char* name, float width, bool& asked, const char* help) {
  if (button(w, name, width)) asked = true;
  tip(w(help));
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
  const Words& w = facts_.w;
  for (const DeskKey& k : desk_keys()) {
    if (std::string_view(k.menu) != menu) continue;
    const bool letters = k.code[0] == '=';
    if (ImGui::MenuItem(w(k.title), w(k.keys))) {
      if (k.act)
        k.act(*this, 0);
      else if (letters)
        key('=', WindowEvent::control);
    }
    tip(w(k.what));
    if (letters && ImGui::MenuItem(w("Smaller letters"))) key('-', WindowEvent::control);
  }
}

void Desk::menu(float width) {
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({width, 0});
  if (!ImGui::BeginMainMenuBar()) return;
  const ImVec2 size = ImGui::GetWindowSize();
  covered_.push_back({0, 0, size.x, size.y});
  const Words& w = facts_.w;
  if (ImGui::BeginMenu(w("Session"))) {
    if (ImGui::MenuItem(w("Undo"), w("Ctrl+Z"))) state.undo = true;
    tip(w("The last act that changed the patient is taken back."));
    if (ImGui::MenuItem(w("Redo"), w("Ctrl+Y"))) state.redo = true;
    tip(w("What was undone last is done again."));
    menu_items("Session");
    ImGui::EndMenu();
  }
  if (ImGui::BeginMenu(w("Tools"))) {
    for (const DeskTool& t : kDeskTools) {
      if (!offered(t.tool)) continue;
      if (ImGui::MenuItem(w(t.name), key_words(t, w).c_str(), state.tool == t.tool && !state.ruler)) choose(t.tool);
      tip(w(t.help));
    }
    ImGui::Separator();
    menu_items("Tools");
    ImGui::EndMenu();
  }
  for (const char* name : {english("View"), english("Lesson"), english("Help")})
    if (ImGui::BeginMenu(w(name))) {
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
  const Words& w = facts_.w;
  const bool asked = !has && r.coach && r.coach->says().tool == t.tool && !r.showing;  // the next act is its
  if (asked) ImGui::PushStyleColor(ImGuiCol_Text, ink::hint());
  if (ImGui::Selectable(fmt::format("{}{}  {}", t.shift ? "\u21e7" : "  ", char(t.key), w(t.name)).c_str(), has))
    choose(t.tool);
  if (asked) ImGui::PopStyleColor();
  tip(w("{}  Key: {}.", w(t.help), key_words(t, w)));
}

void Desk::settings(Tool tool) {
  ImGui::PushItemWidth(-1);
  for (const ToolSlider& k : tool_sliders(tool, facts_.max_depth_mm, facts_.w)) {
    ImGui::TextColored(ink::quiet(), "%s", k.name.c_str());
    state.tool_changed |=
        ImGui::SliderFloat(("##" + k.name).c_str(), &(state.*k.value), k.from, k.to, k.format.c_str());
    tip(k.help);
  }
  ImGui::PopItemWidth();
}

void Desk::view_choices() {
  const Words& w = facts_.w;
  ImGui::PushItemWidth(-1);
  if (ImGui::BeginCombo("##field",
                        w(state.field == SkinField::none ? english("No colours") : look_of(state.field).name))) {
    for (int k = 0; k < kSkinFields; ++k)
      if (k == 0 || facts_.skin || SkinField(k) == SkinField::moved)
        if (ImGui::Selectable(w(k == 0 ? english("No colours") : look_of(SkinField(k)).name), int(state.field) == k))
          choose_field(SkinField(k));
    ImGui::EndCombo();
  }
  ImGui::PopItemWidth();
  if (state.field != SkinField::none) ImGui::Checkbox(w("Iso-lines"), &state.iso_lines);
  if (facts_.skin) {
    ImGui::Checkbox(w("Directions"), &state.directions);
    tip(w("In which the skin is stretched most and least."));
    ImGui::Checkbox(w("Tension lines"), &state.tension_lines);
    ImGui::Checkbox(w("Lattice"), &state.lattice);
    tip(w("The cells of the tissue; those of which a cut has made several copies in orange."));
  }
  if (facts_.head)
    ImGui::PushItemWidth(-1),
        choice("##face", state.face, w, {english("Face"), english("Clear face"), english("No face")}),
        ImGui::PopItemWidth();
  if (facts_.head) ImGui::Checkbox(w("Landmarks"), &state.landmarks);
  ImGui::Checkbox(w("Triangles"), &state.wireframe);
  if (ImGui::Checkbox(w("Measure"), &state.ruler) && state.ruler) choose(Tool::none);
  tip(w("Two points a length, three an angle."));
  ImGui::PushItemWidth(-1);
  int compare = int(state.compare), stereo = int(state.stereo);
  if (choice("##compare", compare, w,
             {english("No comparison"), english("Before | after: wipe"), english("Before, after")}))
    state.compare = Compare(compare);
  if (state.compare == Compare::wipe) ImGui::SliderFloat("##wipe", &state.wipe, 0, 1, "");
  if (choice("##stereo", stereo, w, {english("One eye"), english("Stereo side by side"), english("Stereo red-cyan")}))
    state.stereo = Stereo(stereo);
  choice("##quality", state.quality, w,
         {english("Quality: automatic"), english("Half size"), english("Fast"), english("Fine skin"),
          english("Shadows"), english("Shadows, occlusion")});
  ImGui::PopItemWidth();
  const float half = half_width();
  asked_by(w, english("Picture"), half, state.picture, english("The patient alone, into a file."));
  ImGui::SameLine();
  asked_by(w, english("Home"), half, state.home, english("The first view again."));
}

void Desk::tools(const DeskReading& r, const FrameRect& at) {
  constexpr float kRoomForView = 760;
  const Words& w = facts_.w;
  panel("tools", at);
  text(ink::quiet(), w("TOOLS"));
  ImGui::Separator();
  for (const DeskTool& t : kDeskTools)
    if (offered(t.tool)) tool_row(t, r);
  if (r.hand_tool.value_or(state.tool) == state.tool) settings(state.tool);  // another hand's are its own
  ImGui::Spacing();
  const float half = half_width();
  asked_by(w, english("Undo"), half, state.undo, english("Ctrl+Z. U shows all acts."));
  ImGui::SameLine();
  asked_by(w, english("Redo"), half, state.redo, english("Ctrl+Y"));
  ImGui::SetNextItemOpen(high(at) > kRoomForView, ImGuiCond_Once);
  if (ImGui::CollapsingHeader(w("View"))) view_choices();

  heading(w("DEVICE"));
  device(r);
  if (facts_.recording.empty()) {
    ImGui::Checkbox(w("Keep the recording"), &state.keep_recording);
  } else {
    text(ink::bad(), w("REC"));
    ImGui::SameLine();
    ImGui::TextWrapped("%s", facts_.recording.c_str());
  }
  ImGui::End();
}

// What the device does, and what to do when it does nothing.
void Desk::device(const DeskReading& r) {
  const Words& w = facts_.w;
  wrapped(w.said(facts_.device));
  if (!facts_.own_device) return;
  const auto warn = [&](const char* words) {
    ImGui::PushStyleColor(ImGuiCol_Text, ink::warn());
    wrapped(w(words));
    ImGui::PopStyleColor();
  };
  const bool begun = r.gauges && LaneGauges::get(r.gauges->tick) > 2500;
  if (begun && r.samples_per_s < 1)
    warn(
        english("silent: no sample for a second. Is it connected and switched on? limberg devices --watch shows what "
                "comes"));
  else if (begun)
    text(ink::good(), w("{:.0f} samples/s", r.samples_per_s));
  if (!facts_.calibrated) warn(english("not calibrated: limberg calibrate stylus, then --calibration FILE"));
}

}  // namespace limberg
