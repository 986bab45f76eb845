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
    all += (all.empty() ? "" : ", ") + name;
  }
  return all;
}

template <class T>
void turn_on(T& value, int n) {
  value = T((int(value) + 1) % n);
}

}  // namespace

std::vector<ToolSlider> tool_sliders(Tool tool, double max_depth_mm) {
  static constexpr std::pair<std::string_view, float HandChoice::*> kSettings[] = {
      {"depth_mm", &HandChoice::depth_mm},
      {"angle_deg", &HandChoice::angle_deg},
      {"spacing_mm", &HandChoice::spacing_mm}};
  std::vector<ToolSlider> sliders;
  for (const DeskTool& t : kDeskTools) {
    if (t.tool != tool || !t.action[0]) continue;
    for (const auto& [key, value] : kSettings)
      for (const ActionField& f : action_fields(t.action)) {
        if (f.field.key != key || f.field.usual_to <= 0) continue;
        const double to = value == &HandChoice::depth_mm ? std::min(max_depth_mm, f.field.to) : f.field.usual_to;
        sliders.push_back({value, float(f.field.usual_from), float(to), std::string(key.substr(0, key.rfind('_'))),
                           f.unit == "degrees" ? "%.0f\u00b0" : "%.1f " + f.unit, f.field.help});
      }
  }
  return sliders;
}

ControlSample control_of(const HandChoice& h) {
  ControlSample c;
  c.kind = ControlSample::select_tool;
  c.tool = h.tool;
  c.value[kDepth] = h.tool == Tool::suture || h.tool == Tool::suture_row ? 0 : double(h.depth_mm);
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
       [](Desk& d, uint32_t) { d.state.headset = true; }},
      {"1 to 9, 0", tools_in_words(), {}, false, HandKey::tool},
      {"Esc",
       "look around; close this list",
       {E::escape},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) {
         if (d.state.help || d.state.summary)
           d.state.help = d.state.summary = false;
         else
           d.choose(Tool::none), d.state.ruler = false;
       }},
      {"F",
       "the face over the bones: solid, clear, hidden",
       {'F'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { turn_on(d.state.face, 3); }},
      {"Ctrl+Z", "undo; with Shift: redo", {'Z'}, true, HandKey::undo},
      {"Ctrl+Y", "redo", {'Y'}, true, HandKey::redo},
      {"N, Shift+N",
       "show me the next act of the lesson, from what I have done; with Shift: from the plan, what is off taken back",
       {'N'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t mods) { (mods & WindowEvent::shift ? d.state.next_clean : d.state.next) = true; }},
      {"J",
       "how this try went, beside earlier ones",
       {'J'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.summary = !d.state.summary; }},
      {"T",
       "colours: tension of the skin (of a head: how far the face has moved), off",
       {'T'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.choose_field(d.state.field == SkinField::none ? d.first_field() : SkinField::none); }},
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
       }},
      {"I",
       "iso-lines of the colours",
       {'I'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.iso_lines = !d.state.iso_lines; }},
      {"D",
       "directions in which the skin is stretched most and least",
       {'D'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.directions = !d.state.directions; }},
      {"L",
       "tension lines of the skin",
       {'L'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.tension_lines = !d.state.tension_lines; }},
      {"X",
       "lattice; cells of which there are several copies in orange",
       {'X'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.lattice = !d.state.lattice; }},
      {"B",
       "before and after: wipe, side by side, off",
       {'B'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { turn_on(d.state.compare, 3); }},
      {"M",
       "measure: two points a length, three an angle",
       {'M'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) {
         d.state.ruler = !d.state.ruler;
         if (d.state.ruler) d.choose(Tool::none);
       }},
      {"K",
       "pick the place under the mouse, on bone or face; beside the patient: where the tool touches. \"Bones\" saws, "
       "moves, plates and joins by what was picked",
       {'K'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.head.pick = d.facts_.head; }},
      {"C",
       "the skull beside a normal one, beside its mirror image, alone",
       {'C'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) {
         if (d.facts_.head) turn_on(d.state.head.beside, 3);
       }},
      {"W",
       "triangles",
       {'W'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.wireframe = !d.state.wireframe; }},
      {"S",
       "quality: by frame time, half size, fast, fine skin, shadows, occlusion",
       {'S'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { turn_on(d.state.quality, 1 + kLiveLevels); }},
      {"A",
       "stereo: side by side, red-cyan, off",
       {'A'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { turn_on(d.state.stereo, 3); }},
      {"P", "picture into a file", {'P'}, false, HandKey::none, [](Desk& d, uint32_t) { d.state.picture = true; }},
      {"R",
       "keep the recording of this session, or do not",
       {'R'},
       false,
       HandKey::none,
       [](Desk& d, uint32_t) { d.state.keep_recording = d.facts_.recording.empty() && !d.state.keep_recording; }},
      {"Home", "the first view again", {E::home}, false, HandKey::none, [](Desk& d, uint32_t) { d.state.home = true; }},
      {"? or F1", "this list", {E::question, E::f1}, false, HandKey::none, [](Desk& d, uint32_t) {
         d.state.help = !d.state.help;
       }}};
  return all;
}

const std::vector<DeskKey>& desk_keys() { return Desk::keys(); }

const DeskTool* tool_of_key(int32_t code) {
  const auto* const t =
      std::find_if(kDeskTools.begin(), kDeskTools.end(), [&](const DeskTool& d) { return d.key == code; });
  return t == kDeskTools.end() ? nullptr : t;
}

const DeskKey* desk_key(int32_t code, uint32_t mods) {
  const bool control = mods & WindowEvent::control;
  for (const DeskKey& k : desk_keys()) {
    const bool tool = k.hand == HandKey::tool && tool_of_key(code);
    if (k.control == control && code != 0 && (tool || k.code[0] == code || k.code[1] == code)) return &k;
  }
  return nullptr;
}

void Desk::key(int32_t code, uint32_t mods) {
  if (const DeskKey* k = desk_key(code, mods); k && k->act) k->act(*this, mods);
}

void Desk::took(Tool tool) {
  state.tool = tool;
  if (tool != Tool::none) state.ruler = false;
}

}  // namespace limberg
