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
    {english("The patient"),
     english("The right mouse button turns the view, the wheel comes nearer, the middle one shifts. Without a mouse: "
             "arrows "
             "lead "
             "the tool, Enter presses and lets go, Ctrl+arrows turn the view."),
     &DeskLayout::stage, english("Try it: turn the view.")},
    {english("Tools"),
     english("Choose one here or by its number, and use it with the left button. Rest the mouse on a tool: it says "
             "what the "
             "hand "
             "does. Depth, angle and spacing stand below."),
     &DeskLayout::tools, english("Try it: choose the scalpel, 2.")},
    {english("What to do"),
     english("The lesson's steps, with what was off. N shows the next act. Below stand stitches with their forces, "
             "hooks, and "
             "all "
             "that was done."),
     &DeskLayout::patient, english("Try it: let the first act be shown, N.")},
    {english("Back and forth"),
     english("Ctrl+Z takes an act back, Ctrl+Y does it again. U shows every act with its picture: click on one to go "
             "there."),
     &DeskLayout::stage, english("Try it: take it back, Ctrl+Z.")},
    {english("How the session runs"),
     english("How fast hand, patient and pictures are, and whether the tissue has come to rest: measure when it has."),
     &DeskLayout::lanes},
    {english("Everything else"),
     english(
         "The menus hold every choice with its key; F1 lists the keys. Larger letters and colours for a projector are "
         "under "
         "View. This tour is under Help."),
     &DeskLayout::menu, english("Try it: open the list of keys, F1.")}};

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

void DeskTour::draw(const DeskLayout& l, std::vector<FrameRect>& covered, const Words& w) {
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
  text(ink::quiet(), w("A tour of one minute, {} of {}", card_, int(kCards)));
  text(ink::hint(), w(c.title));
  wrapped(w(c.words));
  ImGui::PushTextWrapPos(0);
  if (*c.ask) text(praises() ? ink::good() : ink::warn(), praises() ? w("Done.") : w(c.ask));
  ImGui::PopTextWrapPos();
  ImGui::Spacing();
  if (button(w, "Skip  Esc")) end();
  ImGui::SameLine();
  if (card_ > 1 && button(w, "Back")) back();
  if (card_ > 1) ImGui::SameLine();
  if (button(w, card_ < kCards ? english("Next  Enter") : english("Begin  Enter"))) next();
  const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  covered.push_back({at.x, at.y, at.x + size.x, at.y + size.y});
  ImGui::End();
}

}  // namespace limberg
