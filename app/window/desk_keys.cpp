// The mouse is that of radiology and surgery viewers: the left button does what is chosen, the right one turns, the
// middle one shifts, the wheel comes nearer.
#include "app/window/desk_keys.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "app/window/desk.h"
#include "render/quality.h"
#include "sim/commands/actions.h"

namespace limberg {

namespace {

/// "look around, scalpel, ...", in the order of their keys.
std::string tools_in_words() {
  std::string all;
  for (const DeskTool& t : kDeskTools) {
    std::string name = t.name;
    name[0] = char(name[0] - 'A' + 'a');
    all += (all.empty() ? "" : ", ") + name + (t.shift ? " (" + key_words(t) + ")" : "");
  }
  return all;
}

template <class T>
void turn_on(T& value, int n) {
  value = T((int(value) + 1) % n);
}

}  // namespace

std::string key_words(const DeskTool& t) { return (t.shift ? "Shift+" : "") + std::string(1, char(t.key)); }

std::vector<ToolSlider> tool_sliders(Tool tool, double max_depth_mm) {
  static constexpr float kDeepestBite_mm = 4;
  std::vector<ToolSlider> sliders;
  const DeskTool& t = *desk_tool(tool);
  const bool bites = sews_bites(tool);
  const std::pair<std::string_view, float HandChoice::*> settings[] = {
      {"depth_mm", bites ? &HandChoice::bite_mm : &HandChoice::depth_mm},
      {"angle_deg", &HandChoice::angle_deg},
      {"spacing_mm", &HandChoice::spacing_mm}};
  for (const auto& [key, value] : settings)
    for (const ActionField& f : t.action[0] ? action_fields(t.action) : std::vector<ActionField>()) {
      if (f.field.key != key || (tool == Tool::scissors && key == "angle_deg")) continue;
      const bool bite = value == &HandChoice::bite_mm;
      if (!bite && f.field.usual_to <= 0) continue;
      double to = value == &HandChoice::depth_mm ? std::min(max_depth_mm, f.field.to) : f.field.usual_to;
      if (bite) to = std::min(double(kDeepestBite_mm), max_depth_mm);
      sliders.push_back({value, bite ? 0.5f : float(f.field.usual_from), float(to),
                         std::string(key.substr(0, key.rfind('_'))),
                         f.unit == "degrees" ? "%.0f\u00b0" : "%.1f " + f.unit, f.field.help});
    }
  return sliders;
}

ControlSample control_of(const HandChoice& h) {
  ControlSample c;
  c.kind = ControlSample::select_tool;
  c.tool = h.tool;
  c.value[kDepth] = h.tool == Tool::suture || sews_along(h.tool) ? 0
                    : sews_bites(h.tool)                         ? double(h.bite_mm)
                                                                 : double(h.depth_mm);
  c.value[kAngle] = double(h.angle_deg);
  c.value[kSpacing] = double(h.spacing_mm);
  return c;
}

const std::vector<DeskKey>& Desk::keys() {
  using E = WindowEvent;
  static const std::vector<DeskKey> all{
      {"left button", "use the tool; without a tool: turn"},
      {"right button", "turn the view"},
      {"middle button, Shift + right", "shift the view"},
      {"wheel", "nearer, farther; with a hook held: lift"},
      {"Space held",
       "clutch: the hands move, what they hold stays; then it follows from there",
       {E::space},
       false,
       HandKey::clutch},
      {"G",
       "glove: point and grab, or the tool at the surface cursor, which the forefinger pushes",
       {'G'},
       false,
       HandKey::glove},
      {"H, Shift+H",
       "glove: how far its hand goes for one mm of yours: 1, 0.5, 0.25, 2; with Shift: where it is in the room",
       {'H'},
       false,
       HandKey::gain},
      {"E",
       "the headset on or off, where a runtime of OpenXR is installed",
       {'E'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.headset = true; },
       "Session",
       "Headset"},
      {"1 to 9, 0, with Shift", tools_in_words(), {}, false, HandKey::tool},
      {"Esc",
       "look around; close this list",
       {E::escape},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) {
         if (d.state.keys != DeskState::Keys::patient)
           d.state.keys = DeskState::Keys::patient;
         else if (d.state.help || d.state.summary)
           d.state.help = d.state.summary = false;
         else
           d.choose(Tool::none), d.state.ruler = false;
       }},
      {"F",
       "the face over the bones: solid, clear, hidden",
       {'F'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { turn_on(d.state.face, 3); },
       "View",
       "Face over the bones"},
      {"Ctrl+Z", "undo; with Shift: redo", {'Z'}, true, HandKey::undo},
      {"Ctrl+Y", "redo", {'Y'}, true, HandKey::redo},
      {"N, Shift+N",
       "show me the next act of the lesson, from what I have done; with Shift: from the plan, what is off taken back",
       {'N'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t mods) { (mods & WindowEvent::shift ? d.state.next_clean : d.state.next) = true; },
       "Lesson",
       "Show me the next act"},
      {"J",
       "how this try went, beside earlier ones",
       {'J'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.summary = !d.state.summary; },
       "Lesson",
       "How it went"},
      {"T",
       "colours: tension of the skin (of a head: how far the face has moved), off",
       {'T'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.choose_field(d.state.field == SkinField::none ? d.first_field() : SkinField::none); },
       "View",
       "Tension in colours"},
      {"V, Shift+V",
       "the next field in colours, the one before: stretch, area, stress, height, displacement, perfusion",
       {'V'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t mods) {
         const SkinField f = d.state.field;
         if (!d.facts_.skin)
           d.choose_field(f == SkinField::none ? SkinField::moved : SkinField::none);
         else
           d.choose_field(SkinField((int(f) + (mods & WindowEvent::shift ? kSkinFields - 1 : 1)) % kSkinFields));
       },
       "View",
       "Next colours"},
      {"I",
       "iso-lines of the colours",
       {'I'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.iso_lines = !d.state.iso_lines; },
       "View",
       "Iso-lines"},
      {"D",
       "directions in which the skin is stretched most and least",
       {'D'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.directions = !d.state.directions; },
       "View",
       "Directions of stretch"},
      {"L",
       "tension lines of the skin",
       {'L'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.tension_lines = !d.state.tension_lines; },
       "View",
       "Tension lines"},
      {"X",
       "lattice; cells of which there are several copies in orange",
       {'X'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.lattice = !d.state.lattice; },
       "View",
       "Lattice"},
      {"B",
       "before and after: wipe, side by side, off",
       {'B'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { turn_on(d.state.compare, 3); },
       "View",
       "Before and after"},
      {"M",
       "measure: two points a length, three an angle",
       {'M'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) {
         d.state.ruler = !d.state.ruler;
         if (d.state.ruler) d.choose(Tool::none);
       },
       "Tools",
       "Measure"},
      {"K",
       "pick the place under the mouse, on bone or face; beside the patient: where the tool touches. \"Bones\" saws, "
       "moves, plates and joins by what was picked",
       {'K'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.head.pick = d.facts_.head; },
       "Tools",
       "Pick a place"},
      {"C",
       "the skull beside a normal one, beside its mirror image, alone",
       {'C'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) {
         if (d.facts_.head) turn_on(d.state.head.beside, 3);
       },
       "View",
       "Skull beside another"},
      {"W",
       "triangles",
       {'W'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.wireframe = !d.state.wireframe; },
       "View",
       "Triangles"},
      {"S",
       "quality: by frame time, half size, fast, fine skin, shadows, occlusion",
       {'S'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { turn_on(d.state.quality, 1 + kLiveLevels); },
       "View",
       "Quality"},
      {"A",
       "stereo: side by side, red-cyan, off",
       {'A'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { turn_on(d.state.stereo, 3); },
       "View",
       "Stereo"},
      {"P",
       "picture into a file",
       {'P'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.picture = true; },
       "Session",
       "Picture into a file"},
      {"R",
       "keep the recording of this session, or do not",
       {'R'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.keep_recording = d.facts_.recording.empty() && !d.state.keep_recording; },
       "Session",
       "Keep the recording"},
      {"Home",
       "the first view again",
       {E::home},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.home = true; },
       "View",
       "First view"},
      {"U",
       "every act with its picture, to go back to and forth",
       {'U'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.history = !d.state.history; },
       "Session",
       "History of acts"},
      {"O", "surface cursor of a stylus: its gain 1, 0.5, 0.25, off", {'O'}, false, HandKey::cursor},
      {"arrows, with Shift finely",
       "lead the tool",
       {E::arrow_left, E::arrow_right, E::arrow_up, E::arrow_down},
       false,
       HandKey::lead},
      {"Enter", "press the tool, and let it go", {E::enter}, false, HandKey::press},
      {"Ctrl+arrows", "turn the view", {E::arrow_left, E::arrow_right, E::arrow_up, E::arrow_down}, true},
      {"Page up, Page down", "nearer, farther", {E::page_up, E::page_down}, false, HandKey::none, nullptr},
      {"[ ]", "less, more: the first setting of the tool", {'[', ']'}, false, HandKey::none, nullptr},
      {"Ctrl++, Ctrl+-",
       "larger letters, smaller ones",
       {'=', '-'},
       true,
       HandKey::none,
       nullptr,
       "View",
       "Larger letters"},
      {"Ctrl+K",
       "colours of the panels: dark, light for a projector, high contrast",
       {'K'},
       true,
       HandKey::none,
       [](Desk& d, uint32_t) { turn_on(d.state.memory.colours, 3); },
       "View",
       "Colours of the panels"},
      {"F10",
       "the keys are the tools', then the other panel's, then the hand's again",
       {E::f10},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { turn_on(d.state.keys, 3); },
       "Help",
       "Lead the panels by keys"},
      {"", "", {}, false, HandKey::none, [](Desk& d, uint32_t) { d.state.tour.begin(); }, "Help", "Tour of one minute"},
      {"? or F1",
       "this list",
       {E::question, E::f1},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.help = !d.state.help; },
       "Help",
       "Keys and mouse"}};
  return all;
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
