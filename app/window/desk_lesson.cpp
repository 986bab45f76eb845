#include "app/window/desk_lesson.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>

#include "app/window/desk_look.h"

namespace limberg {

using namespace desk_look;

void DeskLesson::steps(const Coach& c, const char* title, float height, bool showing, bool& next, bool& clean,
                       bool& summary_open) {
  const CoachSays& says = c.says();
  const Words& w = c.plan().w;
  heading(title);
  int m = int(c.mode());
  ImGui::PushItemWidth(-1);
  if (c.mode() == LessonMode::examination) {
    text(ink::warn(), w("Examination: nothing is shown"));
  } else if (choice("##mode", m, w,
                    {english("Guided lesson"), english("Free: no plan, no hints"), english("Examination")})) {
    mode = LessonMode(m);
  }
  ImGui::PopItemWidth();
  constexpr float kLine = 18;
  ImGui::BeginChild("steps", {0, std::min(0.24f * height, 8 + kLine * float(says.steps.size()))});
  for (size_t i = 0; i < says.steps.size(); ++i) {
    const StepSeen& s = says.steps[i];
    const bool plain = c.mode() == LessonMode::guided;
    const ImVec4& colour = s.state == StepSeen::now     ? ink::plain()
                           : s.state == StepSeen::ahead ? ink::quiet()
                           : !plain                     ? ink::plain()
                           : s.state == StepSeen::off   ? ink::warn()
                           : s.state == StepSeen::shown ? ink::shown()
                                                        : ink::good();
    const char* word = !plain                       ? ""
                       : s.state == StepSeen::done  ? w("as planned")
                       : s.state == StepSeen::off   ? w.as("of a step", "off")
                       : s.state == StepSeen::shown ? w.as("of a step", "shown")
                                                    : "";
    listed(colour, 22, std::to_string(i + 1).c_str(), (s.name + (*word ? "  " : "") + word).c_str());
    if (s.state == StepSeen::now) ImGui::SetScrollHereY(0.3f);
  }
  ImGui::EndChild();
  if (c.mode() == LessonMode::examination) return;
  // Two buttons beside one another where their words have room.
  const float whole = ImGui::GetContentRegionAvail().x, part = 0.5f * (whole - ImGui::GetStyle().ItemSpacing.x);
  const bool pairs = ImGui::CalcTextSize(w("... from the plan")).x + 10 < part;
  const float half = pairs ? part : whole;
  const auto beside = [&] {
    if (pairs) ImGui::SameLine();
  };
  if (showing) {
    text(ink::shown(), w("being shown ..."));
    ImGui::Dummy({0, ImGui::GetFrameHeight() - ImGui::GetTextLineHeight() - ImGui::GetStyle().ItemSpacing.y});
  } else if (!says.finished) {
    const int undos = says.undos_to_plan;
    if (button(w, "Show me   N", undos > 0 ? half : -1)) next = true;
    if (undos > 0) {
      beside();
      if (button(w, "... from the plan", half)) clean = true;
      tip(w.counted(undos, "takes back what is off ({} act), then shows",
                    "takes back what is off ({} acts), then shows", undos));
    }
  }
  if (button(w, "How it went   J", half)) summary_open = !summary_open;
  beside();
  if (button(w, "Try again", half) && !showing) again = true;
}

float DeskLesson::next_step(const Coach& c, float x, float y, float width, float most,
                            std::vector<FrameRect>& covered) {
  const CoachSays& says = c.says();
  const Words& w = c.plan().w;
  if (c.mode() != LessonMode::guided || c.plan().steps.empty()) return y;
  ImGui::SetNextWindowPos({x + 6, y + 6});
  ImGui::SetNextWindowSizeConstraints({width - 12, 0}, {width - 12, most});
  ImGui::SetNextWindowBgAlpha(0.82f);
  ImGui::Begin("next step", nullptr, kGround | ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::PushTextWrapPos(width - 26);
  if (says.finished) {
    text(ink::good(), w("All steps are done. J shows how it went."));
  } else {
    const TeachingStep& t = c.plan().steps[says.step];
    text(ink::quiet(), w("Step {} of {}", says.step + 1, c.plan().steps.size()));
    ImGui::SameLine();
    text(ink::plain(), t.name);
    if (says.tool) {
      const DeskTool& tool = *desk_tool(*says.tool);
      ImGui::SameLine(0, 24);
      text(ink::hint(), w("Tool: {}  {}", w(tool.name), key_words(tool, w)));
    }
    if (says.question) {
      text(w("Before you go on:"));
      ImGui::SameLine();
      ImGui::TextWrapped("%s", says.question->ask.c_str());
      asked(*says.question, w);
      for (size_t i = 0; i < says.question->answers.size(); ++i) {
        ImGui::PushID(int(i));
        if (ImGui::Button(fmt::format("{}", char('a' + int(i))).c_str(), {22, 0})) answer = int(i) + 1;
        ImGui::SameLine();
        ImGui::TextWrapped("%s", says.question->answers[i].c_str());
        ImGui::PopID();
      }
    } else {
      if (!says.answer.empty())
        ImGui::TextColored(says.answer_right ? ink::good() : ink::warn(), "%s", says.answer.c_str());
      ImGui::TextUnformatted(says.say.c_str());
      if (!says.why.empty()) text(ink::quiet(), w("Why: {}", says.why));
      if (t.acts > 1 && says.act != says.say) text(ink::plain(), w("Now: {}.", says.act));
      if (!says.limit.empty()) ImGui::TextColored(ink::quiet(), "%s", says.limit.c_str());
      if (!says.hint.empty()) text(ink::hint(), w("Hint: {}", says.hint));
    }
  }
  ImGui::PopTextWrapPos();
  const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  covered.push_back({at.x, at.y, at.x + size.x, at.y + size.y});
  ImGui::End();
  return at.y + size.y;
}

void DeskLesson::stroke(const Coach& c, float x, float w, float bottom) {
  const CoachSays& says = c.says();
  if (says.stroke.empty()) return;
  const float width = std::min(w - 12, 300.0f);
  ImGui::SetNextWindowPos({x + 6, bottom - 6}, ImGuiCond_Always, {0, 1});
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, 300});
  ImGui::SetNextWindowBgAlpha(0.85f);
  ImGui::Begin("stroke", nullptr, kPanel | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoInputs);
  constexpr float kName = 72;
  for (const LiveRow& r : says.stroke) {
    const ImVec4& colour = r.share <= 0.7 ? ink::good() : r.share <= 1 ? ink::warn() : ink::bad();
    ImGui::TextColored(ink::quiet(), "%s", r.name.c_str());
    ImGui::SameLine(kName);
    ImGui::TextColored(colour, "%s", r.words.c_str());
    ImGui::SameLine(0.62f * width);
    // A bar: its end is what may be off.
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float whole = 0.33f * width, part = whole * float(std::clamp(r.share, 0.02, 1.0));
    ImDrawList& d = *ImGui::GetWindowDrawList();
    d.AddRectFilled({at.x, at.y + 3}, {at.x + whole, at.y + 13}, IM_COL32(60, 78, 84, 255), 2);
    d.AddRectFilled({at.x, at.y + 3}, {at.x + part, at.y + 13}, ImGui::ColorConvertFloat4ToU32(colour), 2);
    ImGui::NewLine();
  }
  ImGui::End();
}

void DeskLesson::summary(const Coach& c, int width, int height, bool& open, std::vector<FrameRect>& covered) {
  if (!open) return;
  constexpr size_t kMostTries = 3;  // so many fit beside one another
  std::vector<Attempt> tries(c.earlier());
  tries.push_back(c.present());
  const size_t first = tries.size() > kMostTries ? tries.size() - kMostTries : 0;
  const float wide = std::min(float(width) - 20, 420 + 190 * float(tries.size() - first - 1));
  ImGui::SetNextWindowPos({0.5f * float(width), 0.5f * float(height)}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSizeConstraints({wide, 0}, {wide, float(height) - 20});
  ImGui::SetNextWindowBgAlpha(0.96f);
  const Words& w = c.plan().w;
  ImGui::Begin((std::string(w("How it went")) + "###How it went").c_str(), &open,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoCollapse);
  const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  covered.push_back({at.x, at.y, at.x + size.x, at.y + size.y});
  const Attempt& now = tries.back();
  // As high as its rows were in the last frame: how their words wrap is known then.
  const float rows = rows_high_ > 0 ? rows_high_ : 26 + 21 * float(now.rows.size());
  const float table_height = std::min(rows, float(height) - 230);
  if (ImGui::BeginTable("tries", 1 + int(tries.size() - first),
                        ImGuiTableFlags_RowBg | ImGuiTableFlags_ScrollY | ImGuiTableFlags_BordersInnerV,
                        {0, std::max(table_height, 80.0f)})) {
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn(w("step or figure"), ImGuiTableColumnFlags_WidthStretch, 0.8f);
    for (size_t k = first; k < tries.size(); ++k) {
      const std::string name = k + 1 < tries.size() ? w("try {}", k + 1) : w("this try");
      ImGui::TableSetupColumn(name.c_str(), ImGuiTableColumnFlags_WidthStretch, 1);
    }
    ImGui::TableHeadersRow();
    for (const Attempt::Row& row : now.rows) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::TextWrapped("%s", row.what.c_str());
      for (size_t k = first; k < tries.size(); ++k) {
        ImGui::TableNextColumn();
        const auto same = std::find_if(tries[k].rows.begin(), tries[k].rows.end(),
                                       [&](const Attempt::Row& r) { return r.what == row.what; });
        if (same == tries[k].rows.end()) {
          ImGui::TextColored(ink::quiet(), "-");
          continue;
        }
        ImGui::PushStyleColor(ImGuiCol_Text, !same->judged      ? (same->shown ? ink::shown() : ink::quiet())
                                             : same->share <= 1 ? ink::good()
                                                                : ink::warn());
        ImGui::TextWrapped("%s", same->value.c_str());
        ImGui::PopStyleColor();
      }
    }
    ImGui::TableNextRow();
    rows_high_ = ImGui::GetCursorPosY();
    ImGui::EndTable();
  }
  ImGui::Spacing();
  if (now.better.empty()) {
    text(ink::good(),
         w(c.says().finished ? english("Nothing to mend in this try.") : english("Nothing to mend so far.")));
  } else {
    text(ink::quiet(), w("To do better"));
    for (size_t i = 0; i < now.better.size(); ++i) ImGui::TextWrapped("%d  %s", int(i) + 1, now.better[i].c_str());
  }
  ImGui::Spacing();
  ImGui::PushStyleColor(ImGuiCol_Text, ink::quiet());
  wrapped(w("What the program has shown is not judged. The whole verdict comes when the session ends."));
  ImGui::PopStyleColor();
  ImGui::End();
}

}  // namespace limberg
