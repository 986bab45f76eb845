// How the session runs, in figures, and what is said over the patient.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>

#include "app/session/pace_watch.h"
#include "app/window/desk.h"
#include "app/window/desk_look.h"

namespace limberg {

using namespace desk_look;

namespace {

// A lane's figure against its period: a bar and its number.
void lane(const Words& w, const char* name, double ms, double period_ms, std::string note, bool may_last = false) {
  const float share = float(std::clamp(ms / period_ms, 0.0, 1.0));
  const bool narrow = ImGui::GetWindowWidth() < 560;
  if (narrow) note = note.substr(0, std::min(note.find(", "), note.find("; ")));  // the first thing alone
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(name);
  ImGui::SameLine(68);
  const std::string text = ms < 1 ? w("{:.2f} of {:.3g} ms", ms, period_ms) : w("{:.1f} of {:.3g} ms", ms, period_ms);
  ImGui::PushStyleColor(ImGuiCol_PlotHistogram,
                        share < 0.85f || may_last ? ImVec4(0.25f, 0.52f, 0.58f, 1) : ImVec4(0.75f, 0.45f, 0.20f, 1));
  ImGui::ProgressBar(share, {narrow ? 112.0f : 170.0f, 0}, text.c_str());
  ImGui::PopStyleColor();
  ImGui::SameLine();
  ImGui::TextColored(ink::quiet(), "%s", note.c_str());
}

/// How far the tissue is from where it comes to rest.
bool is_at_rest(double distance_mm) { return distance_mm < 0.05; }
std::string rest_in_words(const Words& w, double distance_mm) {
  constexpr double kFar_mm = 50;  // beyond it the estimate says no more than that
  if (!(distance_mm < kFar_mm)) return w("moving, far from rest");
  return is_at_rest(distance_mm) ? w("at rest") : w("moving, about {:.1f} mm from rest", distance_mm);
}

}  // namespace

void Desk::lanes(const DeskReading& r, const DeskLayout& at) {
  panel("lanes", at.lanes);
  const Snapshot& s = *r.shown;
  const Words& w = facts_.w;
  if (r.gauges && at.narrow) {  // one line: what a person must know
    const int64_t behind = std::max<int64_t>(0, LaneGauges::get(r.gauges->tick) - s.device_tick);
    const double off_mm = double(s.distance_mm);
    text(is_at_rest(off_mm) ? ink::good() : ink::quiet(), rest_in_words(w, off_mm));
    tip(w("The tissue: measure when it is at rest."));
    ImGui::SameLine();
    const bool late = behind > 100;
    text(late ? ink::warn() : ink::quiet(), w("shows {} ms ago", std::min<int64_t>(behind, 99999)));
  } else if (r.gauges) {
    const LaneGauges& g = *r.gauges;
    const auto ms = [](const std::atomic<int64_t>& v) { return double(LaneGauges::get(v)) * 1e-6; };
    lane(
        w, w("hand"), ms(g.device_ns), 1,
        w("{} late of {}, {:.0f} samples/s", LaneGauges::get(g.device_late), LaneGauges::get(g.tick), r.samples_per_s));
    const double pace = 1e-3 * double(LaneGauges::get(g.pace_permille));
    const std::string rest = w("{}; residual {:.1e}", rest_in_words(w, double(s.distance_mm)), s.residual);
    lane(w, w("patient"), ms(g.solver_ns), 16,
         rest + (pace < SlowWatch::kSlowed ? "; " + w.said(SlowWatch::words(pace)) : ""));
    const std::string seen =
        w("shows what was {} ms ago", std::max<int64_t>(0, LaneGauges::get(g.tick) - s.device_tick));
    std::string note = w("at rest, drawn finely; {}", seen);
    if (!r.at_leisure) {
      note = w("{}, {:.0f} pictures/s", seen, r.pictures_per_s);
      // Beside other programs steps take several times as long: that is no figure of the pictures.
      if (const int64_t loss = LaneGauges::get(g.loss_permille); loss > 1000)
        note += std::string(", ") + w("the machine is busy");
      else if (loss >= 0)
        note += ", " + w("the patient loses {:.0f} %", 0.1 * double(loss));
    }
    lane(w, w("picture"), ms(g.frame_ns), 33, note, r.at_leisure);
  }
  ImGui::End();
}

void Desk::words(const DeskReading& r, const FrameRect& stage) {
  const float w = wide(stage);
  float word_height = 0;
  const CoachSays* says = r.coach ? &r.coach->says() : nullptr;
  const std::string& word = says && !says->word.empty() ? says->word : last_word_;
  if (!word.empty() && !state.summary) {
    ImGui::SetNextWindowPos({stage.x0 + 0.5f * w, stage.y1 - 8}, ImGuiCond_Always, {0.5f, 1});
    ImGui::SetNextWindowBgAlpha(0.85f);
    ImGui::SetNextWindowSizeConstraints({std::min(200.0f, 0.9f * w), 0}, {0.9f * w, 0.3f * high(stage)});
    ImGui::Begin("word", nullptr, kPanel | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoInputs);
    ImGui::PushTextWrapPos(0.86f * w);
    const bool coached = says && &word == &says->word;
    ImGui::PushStyleColor(ImGuiCol_Text, !coached ? ink::plain() : says->word_is_praise ? ink::good() : ink::warn());
    ImGui::TextUnformatted(word.c_str());
    ImGui::PopStyleColor();
    ImGui::PopTextWrapPos();
    word_height = ImGui::GetWindowHeight() + 6;
    ImGui::End();
  }
  stage_bottom_ = stage.y1 - 8 - word_height;
  if (r.coach) state.lesson.stroke(*r.coach, stage.x0, w, stage_bottom_);
}

}  // namespace limberg
