#include "app/window/desk_tour.h"

#include <imgui.h>

#include <algorithm>

#include "app/window/desk_look.h"

namespace limberg {

using namespace desk_look;

namespace {

struct Card {
  const char *title, *words;
  FrameRect DeskLayout::*panel;
  const char* ask = "";  // done, the tour goes on
};
constexpr Card kCard[DeskTour::kCards] = {
    {"The patient",
     "The right mouse button turns the view, the wheel comes nearer, the middle one shifts. Without a mouse: arrows "
     "lead "
     "the tool, Enter presses and lets go, Ctrl+arrows turn the view.",
     &DeskLayout::stage, "Try it: turn the view."},
    {"Tools",
     "Choose one here or by its number, and use it with the left button. Rest the mouse on a tool: it says what the "
     "hand "
     "does. Depth, angle and spacing stand below.",
     &DeskLayout::tools, "Try it: choose the scalpel, 2."},
    {"What to do",
     "The lesson's steps, with what was off. N shows the next act. Below stand stitches with their forces, hooks, and "
     "all "
     "that was done.",
     &DeskLayout::patient, "Try it: let the first act be shown, N."},
    {"Back and forth",
     "Ctrl+Z takes an act back, Ctrl+Y does it again. U shows every act with its picture: click on one to go there.",
     &DeskLayout::stage, "Try it: take it back, Ctrl+Z."},
    {"How the session runs",
     "How fast hand, patient and pictures are, and whether the tissue has come to rest: measure when it has.",
     &DeskLayout::lanes},
    {"Everything else",
     "The menus hold every choice with its key; F1 lists the keys. Larger letters and colours for a projector are "
     "under "
     "View. This tour is under Help.",
     &DeskLayout::menu, "Try it: open the list of keys, F1."}};

}  // namespace

bool DeskTour::see(const TourSeen& seen) {
  if (!open()) return false;
  const bool done[kCards] = {seen.turned, seen.chose, seen.acted, seen.took_back, false, seen.looked_up};
  if (praise_ > 0) {
    if (--praise_ == 0) next();
  } else if (done[card_ - 1]) {
    praise_ = kPraiseFrames;
  }
  return praise_ > 0;
}

void DeskTour::draw(const DeskLayout& l, std::vector<FrameRect>& covered) {
  if (!open()) return;
  constexpr float kWidth = 320;
  const Card& c = kCard[card_ - 1];
  const FrameRect& r = l.*c.panel;
  ImDrawList& d = *ImGui::GetForegroundDrawList();
  d.AddRect({r.x0 + 2, r.y0 + 2}, {r.x1 - 2, r.y1 - 2}, ImGui::ColorConvertFloat4ToU32(ink::hint()), 4, 0, 3);
  ImGui::SetNextWindowPos({0.5f * (l.stage.x0 + l.stage.x1), 0.5f * (l.stage.y0 + l.stage.y1)}, ImGuiCond_Always,
                          {0.5f, 0.5f});
  const float width = std::min(kWidth, wide(l.stage) - 16);
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, high(l.stage)});
  ImGui::SetNextWindowBgAlpha(0.96f);
  ImGui::Begin("tour", nullptr, kPanel | ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::TextColored(ink::quiet(), "A tour of one minute, %d of %d", card_, kCards);
  ImGui::TextColored(ink::hint(), "%s", c.title);
  ImGui::TextWrapped("%s", c.words);
  if (*c.ask) ImGui::TextColored(praises() ? ink::good() : ink::warn(), "%s", praises() ? "Done." : c.ask);
  ImGui::Spacing();
  if (ImGui::Button("Skip  Esc")) end();
  ImGui::SameLine();
  if (card_ > 1 && ImGui::Button("Back")) back();
  if (card_ > 1) ImGui::SameLine();
  if (ImGui::Button(card_ < kCards ? "Next  Enter" : "Begin  Enter")) next();
  const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  covered.push_back({at.x, at.y, at.x + size.x, at.y + size.y});
  ImGui::End();
}

}  // namespace limberg
