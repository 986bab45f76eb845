#include "app/window/desk_keys.h"

#include <algorithm>
#include <string_view>
#include <tuple>

#include "app/window/desk.h"
#include "sim/commands/actions.h"

namespace limberg {

std::string key_words(const DeskTool& t, const Words& w) {
  const std::string key(1, char(t.key));
  return t.shift ? w("Shift+{}", key) : key;
}

std::string tools_in_words(const Words& w) {
  std::string all;
  for (const DeskTool& t : kDeskTools) {
    std::string name = w(t.name);
    if (w.language() == "en") name[0] = char(name[0] - 'A' + 'a');
    all += (all.empty() ? "" : ", ") + name + (t.shift ? " (" + key_words(t, w) + ")" : "");
  }
  return all;
}

std::vector<ToolSlider> tool_sliders(Tool tool, double max_depth_mm, const Words& w) {
  static constexpr const char* kDepth = english("depth");
  static constexpr const char* kAngle = english("angle");
  static constexpr const char* kSpacing = english("spacing");
  static constexpr float kDeepestBite_mm = 4;
  std::vector<ToolSlider> sliders;
  const DeskTool& t = *desk_tool(tool);
  const bool bites = sews_bites(tool) || tool == Tool::suture_row_buried;
  const std::tuple<std::string_view, const char*, float HandChoice::*> settings[] = {
      {"depth_mm", kDepth, bites ? &HandChoice::bite_mm : &HandChoice::depth_mm},
      {"angle_deg", kAngle, &HandChoice::angle_deg},
      {"spacing_mm", kSpacing, &HandChoice::spacing_mm}};
  for (const auto& [key, name, value] : settings)
    for (const ActionField& f : t.action[0] ? action_fields(t.action) : std::vector<ActionField>()) {
      if (f.field.key != key || (tool == Tool::scissors && key == "angle_deg") ||
          (!bites && sews_along(tool) && key == "depth_mm"))
        continue;
      const bool bite = value == &HandChoice::bite_mm;
      if (!bite && f.field.usual_to <= 0) continue;
      double to = value == &HandChoice::depth_mm ? std::min(max_depth_mm, f.field.to) : f.field.usual_to;
      if (bite) to = std::min(double(kDeepestBite_mm), max_depth_mm);
      sliders.push_back({value, bite ? 0.5f : float(f.field.usual_from), float(to), w(name),
                         f.unit == "degrees" ? "%.0f\u00b0" : "%.1f\u202f" + f.unit, w(f.field.help)});
    }
  return sliders;
}

ControlSample control_of(const HandChoice& h) {
  ControlSample c;
  c.kind = ControlSample::select_tool;
  c.tool = h.tool;
  const bool buried =
      h.tool == Tool::suture_buried || h.tool == Tool::suture_corner || h.tool == Tool::suture_row_buried;
  c.value[kDepth] = buried ? double(h.bite_mm) : sews_bites(h.tool) || sews_along(h.tool) ? 0 : double(h.depth_mm);
  c.value[kAngle] = double(h.angle_deg);
  c.value[kSpacing] = double(h.spacing_mm);
  return c;
}

const std::vector<DeskKey>& desk_keys() { return Desk::keys(); }

const DeskTool* tool_of_key(int32_t code, uint32_t mods) {
  const bool shift = mods & WindowEvent::shift;
  const auto* const t = std::find_if(kDeskTools.begin(), kDeskTools.end(),
                                     [&](const DeskTool& d) { return d.key == code && d.shift == shift; });
  return t == kDeskTools.end() ? nullptr : t;
}

const DeskTool* desk_tool(Tool tool) {
  const auto* const t =
      std::find_if(kDeskTools.begin(), kDeskTools.end(), [&](const DeskTool& d) { return d.tool == tool; });
  return t == kDeskTools.end() ? kDeskTools.begin() : t;
}

const DeskKey* desk_key(int32_t code, uint32_t mods) {
  const bool control = mods & WindowEvent::control;
  for (const DeskKey& k : desk_keys()) {
    const bool tool = k.hand == HandKey::tool && tool_of_key(code, mods);
    if (k.control == control && code != 0 && (tool || std::find(k.code.begin(), k.code.end(), code) != k.code.end()))
      return &k;
  }
  return nullptr;
}

void Desk::key(int32_t code, uint32_t mods) {
  if (state.tour.open() && (code == WindowEvent::enter || code == WindowEvent::escape))
    return code == WindowEvent::enter ? state.tour.next() : state.tour.end();
  if (const DeskKey* k = desk_key(code, mods); k && k->act) return k->act(*this, mods);
  constexpr float kTurn_px = 12;
  const bool control = mods & WindowEvent::control;
  if (code == '[' || code == ']') set_by_key(code == ']' ? 1 : -1);
  if (code == WindowEvent::page_up || code == WindowEvent::page_down)
    state.nearer += code == WindowEvent::page_up ? 1 : -1;
  if (!control) return;
  if (code == WindowEvent::arrow_left || code == WindowEvent::arrow_right)
    state.turn_x += code == WindowEvent::arrow_right ? kTurn_px : -kTurn_px;
  if (code == WindowEvent::arrow_up || code == WindowEvent::arrow_down)
    state.turn_y += code == WindowEvent::arrow_down ? kTurn_px : -kTurn_px;
  if (code == '=' || code == '-')
    state.memory.letters_percent =
        std::clamp(state.memory.letters_percent + (code == '=' ? 25 : -25), 75, DeskMemory::kLargest_percent);
}

void Desk::set_by_key(int steps) {
  const std::vector<ToolSlider> all = tool_sliders(state.tool, facts_.max_depth_mm);
  if (all.empty()) return;
  const ToolSlider& k = all.front();
  float& value = state.*k.value;
  value = std::clamp(value + float(steps) * 0.5f, k.from, k.to);
  state.tool_changed = true;
}

void Desk::took(Tool tool) {
  state.tool = tool;
  if (tool != Tool::none) state.ruler = false;
}

}  // namespace limberg
