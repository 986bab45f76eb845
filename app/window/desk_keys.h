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
#include "devices/sample.h"

namespace limberg {

struct DeskTool {
  Tool tool = Tool::none;
  int32_t key = 0;
  const char* name = "";
  const char* action = "";  // what the hand does with it, as the table of acts has it; empty: no sliders
};
inline constexpr std::array<DeskTool, 10> kDeskTools{{{Tool::none, '1', "Look around"},
                                                      {Tool::scalpel, '2', "Scalpel", "incise"},
                                                      {Tool::undermine, '3', "Undermine", "undermine"},
                                                      {Tool::excise, '4', "Excise", "excise"},
                                                      {Tool::hook, '5', "Hook"},
                                                      {Tool::suture, '6', "Stitch"},
                                                      {Tool::suture_row, '7', "Row of stitches", "suture_row"},
                                                      {Tool::saw, '8', "Saw"},
                                                      {Tool::grab, '9', "Grab"},
                                                      {Tool::scissors, '0', "Scissors"}}};

/// The tool that the hand has, and how it is set.
struct HandChoice {
  Tool tool = Tool::none;  // none: look around
  float depth_mm = 4, angle_deg = 90, spacing_mm = 4;
};
/// A setting of a tool, as the panels offer it.
struct ToolSlider {
  float HandChoice::*value = nullptr;
  float from = 0, to = 0;
  std::string name, format, help;
};
/// Of the fields of a tool's action (sim/commands/table.h) those that a hand sets, over what the table calls usual.
/// max_depth_mm: how deep the scene allows.
std::vector<ToolSlider> tool_sliders(Tool tool, double max_depth_mm);
/// As the control that tells the device side of it.
ControlSample control_of(const HandChoice& choice);

enum class HandKey { none, tool, undo, redo, clutch, glove, gain };

class Desk;

/// A line of the help. Those that are heard as keys have their codes.
struct DeskKey {
  std::string keys, what;
  std::array<int32_t, 2> code{};  // 0: none
  bool control = false;           // with the control key held
  HandKey hand = HandKey::none;
  void (*act)(Desk& desk, uint32_t mods) = nullptr;  // what the panels do, on the render thread
};
const std::vector<DeskKey>& desk_keys();
/// The line of a key; null: it does nothing.
const DeskKey* desk_key(int32_t code, uint32_t mods);
/// The tool of a number key; null: none.
const DeskTool* tool_of_key(int32_t code);

}  // namespace limberg
