#pragma once
// The tools and keys of the window, each listed once: the palette, the help and whoever hears a key read these tables.
//
// A key does one of two things. Some mean the hand (a tool, undo, redo, the clutch, "show me"): they are carried out by
// the InputRouter, in their order among the clicks. All others mean the picture and the panels (Desk::key).
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "app/window/screen.h"
#include "app/words/words.h"
#include "devices/sample.h"

namespace limberg {

struct DeskTool {
  Tool tool = Tool::none;
  int32_t key = 0;  // a digit, or a letter that no other line has
  bool shift = false;
  const char* name = "";
  const char* help = "";    // what the hand does
  const char* action = "";  // what comes of it, as the table of acts has it; empty: no sliders
};
inline constexpr std::array<DeskTool, 21> kDeskTools{
    {{Tool::none, '1', false, english("Look around"), english("The left button turns the view.")},
     {Tool::marker, '1', true, english("Marker pen"),
      english("Draw on the skin; the line is measured and goes with the skin.")},
     {Tool::scalpel, '2', false, english("Scalpel"), english("Press on the skin, draw, let go: a cut along the way."),
      "incise"},
     {Tool::scalpel_through, 'Q', false, english("Right through"),
      english("Scalpel: press on a lip, a lid or an ear, draw, let go. It comes out on the other side, and over the "
              "margin.")},
     {Tool::swab, '2', true, english("Swab"),
      english("Shows the bed under a flap while it is held. Pressed and drawn it wipes the pen off.")},
     {Tool::undermine, '3', false, english("Undermine"), english("Draw once round what is to come off its bed."),
      "undermine"},
     {Tool::excise, '4', false, english("Excise"),
      english("Draw once round what is to be taken away, or press on a piece that is loose."), "excise"},
     {Tool::hook, '5', false, english("Hook"),
      english("Press on the skin and carry it. Press at its handle to carry it on.")},
     {Tool::hook_out, '5', true, english("Hook out"), english("Press at a hook or at its handle: it is taken out.")},
     {Tool::suture, '6', false, english("Stitch"), english("Press beside one edge, let go beside the other.")},
     {Tool::suture_buried, '6', true, english("Buried stitch"),
      english("The same; the bites lie in the walls of the wound."), "suture"},
     {Tool::suture_deep, '4', true, english("Deep stitch"),
      english("Press and let go on skin or on a cut face: a flap's underside, its bed, a wall of the wound.")},
     {Tool::suture_corner, '8', true, english("Corner stitch"),
      english("Press on one bank, let go in the flap's tip, then press on the other bank."), "suture_corner"},
     {Tool::suture_row, '7', false, english("Row of stitches"), english("Draw along one edge, then along the other."),
      "suture_row"},
     {Tool::suture_row_buried, '3', true, english("Buried row"),
      english("Draw along one edge, then along the other: the bites lie in the walls of the wound."), "suture_row"},
     {Tool::suture_running, '7', true, english("Running stitch"),
      english("Draw along one edge, then along the other: one thread."), "suture_row"},
     {Tool::suture_bites, '9', true, english("Running, by bites"),
      english("Press beside one edge, let go beside the other: one bite of a thread. The next one goes on with it.")},
     {Tool::suture_knot, '0', true, english("Knot"),
      english("Press beside the last bite of the running stitch: it is tied there.")},
     {Tool::saw, '8', false, english("Saw"), english("Draw once round on the bone.")},
     {Tool::grab, '9', false, english("Grab"), english("Press on a piece of bone and carry it.")},
     {Tool::scissors, '0', false, english("Scissors"),
      english("Press beside a stitch: its thread is cut. Press at an edge of the wound and draw: tissue is."),
      "incise"}}};
/// "Shift+6".
std::string key_words(const DeskTool& tool, const Words& words = {});
/// "look around, scalpel, ...", in the order of their keys.
std::string tools_in_words(const Words& words);

/// The tool that the hand has, and how it is set.
struct HandChoice {
  Tool tool = Tool::none;  // none: look around
  float depth_mm = 4, angle_deg = 90, spacing_mm = 4;
  float bite_mm = 1;  // how deep the bites of a buried or a corner's stitch lie
};
/// A setting of a tool, as the panels offer it.
struct ToolSlider {
  float HandChoice::*value = nullptr;
  float from = 0, to = 0;
  std::string name, format, help;
};
/// Of the fields of a tool's action (sim/commands/table.h) those that a hand sets, over what the table calls usual.
/// max_depth_mm: how deep the scene allows.
std::vector<ToolSlider> tool_sliders(Tool tool, double max_depth_mm, const Words& words = {});
/// As the control that tells the device side of it.
ControlSample control_of(const HandChoice& choice);

enum class HandKey { none, tool, undo, redo, clutch, glove, gain, cursor, lead, press };

class Desk;

/// A line of the help. Those that are heard as keys have their codes.
struct DeskKey {
  const char *keys = "", *what = "";  // what: empty for the keys of the tools, which tools_in_words() tells
  std::array<int32_t, 4> code{};      // 0: none
  bool control = false;               // with the control key held
  HandKey hand = HandKey::none;
  void (*act)(Desk& desk, uint32_t mods) = nullptr;  // what the panels do, on the render thread
  const char* menu = "";                             // where it stands; empty: in none
  const char* title = "";                            // there
};
const std::vector<DeskKey>& desk_keys();
/// The line of a key; null: it does nothing.
const DeskKey* desk_key(int32_t code, uint32_t mods);
/// The tool of a number key, with Shift or without; null: none.
const DeskTool* tool_of_key(int32_t code, uint32_t mods);
/// Of a tool; never null.
const DeskTool* desk_tool(Tool tool);

}  // namespace limberg
