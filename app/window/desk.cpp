#include "app/window/desk.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "app/window/desk_look.h"
#include "sim/measure/table.h"

namespace limberg {

using namespace desk_look;

namespace {
constexpr size_t kNotices = 200;
}  // namespace

void Desk::panel(const char* name, const FrameRect& r) {
  ImGui::SetNextWindowPos({r.x0, r.y0});
  ImGui::SetNextWindowSize({wide(r), high(r)});
  ImGui::SetNextWindowBgAlpha(1);
  ImGui::Begin(name, nullptr, kGround);
  covered_.push_back(r);
}

void Desk::notice(const Notice& n) {
  if (n.kind == Notice::done) state.head.hear(n.text.data());
  if (n.command)
    if (const auto* shown = std::get_if<Shown>(n.command.get())) {
      shown_ = shown->begins;
      return;
    }
  // A further piece of the same stroke.
  const auto stroke = [](const Notice& x) {
    const auto* piece = x.command ? std::get_if<InciseMore>(x.command.get()) : nullptr;
    return piece ? piece->stroke : 0;
  };
  if (!notices_.empty() && n.kind == Notice::done && stroke(n) > 0 && stroke(n) == stroke(notices_.back().notice))
    return;
  const Words& w = facts_.w;
  const auto* stage = n.command ? std::get_if<Stage>(n.command.get()) : nullptr;
  std::string text = stage ? w("stage: {}", w(stage->name)) : w.said(n.text.data());
  if (shown_ && n.kind == Notice::done) text = w("shown: {}", text);
  if (n.kind == Notice::refused) text = w("{} refused: {}", w(n.action.data()), text);
  notices_.push_back({n, text});
  ++heard_;
  if (notices_.size() > kNotices) notices_.pop_front();
  last_word_ = n.kind == Notice::refused || n.kind == Notice::dropped ? text : "";
  if (n.kind == Notice::done && n.command && std::holds_alternative<LetThreadGo>(*n.command))
    last_word_ = w("The thread is not tied: the edges part again.");
}

void Desk::patient(const DeskReading& r, const FrameRect& at) {
  const Words& w = facts_.w;
  const float height = high(at);
  panel("patient", at);
  const Snapshot& s = *r.shown;
  if (!facts_.goal.empty()) {
    ImGui::TextWrapped("%s", facts_.goal.c_str());
    ImGui::Spacing();
  }
  if (r.coach && !r.coach->plan().steps.empty())
    state.lesson.steps(*r.coach, r.coach->plan().title.empty() ? w("LESSON") : r.coach->plan().title.c_str(), height,
                       r.showing, state.next, state.next_clean, state.summary);

  if (!s.figures.empty()) {
    heading(w("HEAD"));
    for (const LiveFigure& k : s.figures) text(w("{} {:.1f} {}", w.said(k.name), double(k.value), k.unit));
  }
  if (facts_.head && r.measures) {
    if (s.figures.empty()) heading(w("HEAD"));
    state.head.draw(*r.measures, !s.moved_mm.empty(), height, w);
  }
  if (facts_.skin) heading(w("SUTURES"));
  if (!facts_.skin)
    ImGui::Spacing();
  else if (s.sutures.empty())
    text(ink::quiet(), w("none yet"));
  else {
    double sum = 0;
    for (const SutureState& x : s.sutures) sum += double(x.force_N);
    const int n = int(s.sutures.size());
    wrapped(w.counted(n, "{} stitch, {:.2f} N", "{} stitches, {:.2f} N together", n, sum));
    if (ImGui::BeginTable("sutures", 3, ImGuiTableFlags_RowBg | ImGuiTableFlags_ScrollY,
                          {0, std::min(0.25f * height, 26.0f + 21.0f * float(s.sutures.size()))})) {
      ImGui::TableSetupScrollFreeze(0, 1);
      ImGui::TableSetupColumn(w("no."), ImGuiTableColumnFlags_WidthFixed, 34);
      ImGui::TableSetupColumn(w("force N"));
      ImGui::TableSetupColumn(w("gap mm"));
      ImGui::TableHeadersRow();
      for (const SutureState& x : s.sutures) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::Text("%d", x.id);
        ImGui::TableNextColumn();
        const double force = double(x.force_N);
        text(force < kSutureForce_N.warn  ? ink::good()
             : force < kSutureForce_N.bad ? ink::warn()
                                          : ink::bad(),
             w("{:.2f}", force));
        ImGui::TableNextColumn();
        text(w("{:.2f}", double(x.gap_mm)));
      }
      ImGui::EndTable();
    }
    text(ink::quiet(), w("limits {:.3g} and {:.3g} N", kSutureForce_N.warn, kSutureForce_N.bad));
  }
  hooks(s);
  done_list();
  ImGui::End();
}

void Desk::hooks(const Snapshot& s) {
  if (s.hooks.empty()) return;
  const Words& w = facts_.w;
  heading(w("HOOKS"));
  for (const HookState& h : s.hooks) {
    ImGui::PushID(h.id);
    ImGui::AlignTextToFramePadding();
    text(w("{}   {:.2f} N", h.id, double(h.force_N.norm())));
    ImGui::SameLine(110);
    if (ImGui::SmallButton(w("let go"))) state.release_hook = h.id;
    ImGui::PopID();
  }
}

void Desk::done_list() {
  const Words& w = facts_.w;
  heading(w("DONE"));
  constexpr float kLeast = 92;  // four lines are seen, if need be by scrolling the panel
  ImGui::BeginChild("done", {0, std::max(kLeast, ImGui::GetContentRegionAvail().y - 2)});
  for (const auto& [n, text] : notices_) {
    const char* mark = n.kind == Notice::undone   ? w("taken back")
                       : n.kind == Notice::redone ? w("done again")
                                                  : text.c_str();
    listed(n.kind == Notice::refused   ? ink::bad()
           : n.kind == Notice::dropped ? ink::warn()
                                       : ImGui::GetStyleColorVec4(ImGuiCol_Text),
           58, w("{:.1f} s", n.t_s).c_str(), mark);
  }
  // The newest is seen, however high the list is by now; who scrolls back is left there until something is done.
  if (listed_ != heard_ || ImGui::GetScrollMaxY() != scroll_most_) ImGui::SetScrollHereY(1);
  listed_ = heard_, scroll_most_ = ImGui::GetScrollMaxY();
  ImGui::EndChild();
}

void Desk::help(int width, int height) {
  if (!state.help) return;
  ImGui::SetNextWindowPos({0.5f * float(width), 0.5f * float(height)}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowBgAlpha(0.97f);
  const float width_most = std::min(float(width) - 16, 720.0f);
  ImGui::SetNextWindowSize({width_most, std::min(float(height) - 16, 40 + 20 * float(desk_keys().size()))});
  const Words& w = facts_.w;
  ImGui::Begin((std::string(w("Keys and mouse")) + "###Keys and mouse").c_str(), &state.help,
               ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoResize);
  const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  covered_.push_back({at.x, at.y, at.x + size.x, at.y + size.y});
  if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_RowBg | ImGuiTableFlags_ScrollY)) {
    ImGui::TableSetupColumn("key", ImGuiTableColumnFlags_WidthFixed, 176);
    ImGui::TableSetupColumn("what", ImGuiTableColumnFlags_WidthStretch);
    for (const DeskKey& k : desk_keys()) {
      if (!*k.keys) continue;
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      wrapped(w(k.keys));
      ImGui::TableNextColumn();
      wrapped(k.hand == HandKey::tool ? tools_in_words(w) : w(k.what));
    }
    ImGui::EndTable();
  }
  ImGui::End();
}

void Desk::draw(const DeskReading& r, const std::vector<Vec3f>& ruler_px, int width, int height) {
  covered_.clear();
  const DeskLayout at = desk_layout(float(width), float(height), r.acts != nullptr);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
  if (keys_shown_ != state.keys) {  // the panel whose the keys are
    keys_shown_ = state.keys;
    ImGui::SetWindowFocus(state.keys == DeskState::Keys::tools    ? "tools"
                          : state.keys == DeskState::Keys::beside ? "patient"
                                                                  : nullptr);
  }
  menu(float(width));
  tools(r, at.tools);
  patient(r, at.patient);
  if (r.acts)
    if (const auto wanted = history_.draw(*r.acts, at.history, r.act_picture, covered_, facts_.w)) state.go_to = wanted;
  stage_top_ = at.stage.y0;
  if (r.coach)
    stage_top_ =
        state.lesson.next_step(*r.coach, at.stage.x0, at.stage.y0, wide(at.stage), 0.45f * high(at.stage), covered_);
  lanes(r, at);
  words(r, at.stage);
  legend(r, at.stage);
  ImGui::PopStyleVar(2);
  help(width, height);
  if (r.coach) state.lesson.summary(*r.coach, width, height, state.summary, covered_);
  state.tour.draw(at, covered_, facts_.w);
  popup_ = ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup);
  compared(r, at.stage);
  marks(r, at.stage);
  ruler(r, ruler_px);
  if (r.pointed) {  // a cross where keys have led the tool
    ImDrawList& d = *ImGui::GetBackgroundDrawList();
    for (const float turned : {0.0f, 1.0f}) {
      const ImVec2 arm(9 * (1 - turned), 9 * turned);
      d.AddLine({r.point_x - arm.x, r.point_y - arm.y}, {r.point_x + arm.x, r.point_y + arm.y},
                IM_COL32(20, 20, 20, 255), 4);
      d.AddLine({r.point_x - arm.x, r.point_y - arm.y}, {r.point_x + arm.x, r.point_y + arm.y},
                IM_COL32(255, 235, 90, 255), 2);
    }
  }
}

}  // namespace limberg
