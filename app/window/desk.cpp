#include "app/window/desk.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "app/session/pace_watch.h"
#include "app/window/desk_look.h"
#include "render/colour_map.h"
#include "render/overlay.h"
#include "sim/commands/kinds.h"
#include "sim/measure/table.h"

namespace limberg {

using namespace desk_look;

namespace {

constexpr float kToolsWidth = 168, kPatientWidth = 268, kLanesHeight = 84;
constexpr size_t kNotices = 200;
constexpr ImGuiWindowFlags kFixed = kPanel;

// A lane's figure against its period: a bar and its number.
void lane(const char* name, double ms, double period_ms, std::string note, bool may_last = false) {
  const float share = float(std::clamp(ms / period_ms, 0.0, 1.0));
  const bool narrow = ImGui::GetWindowWidth() < 560;
  if (narrow) note = note.substr(0, note.find_first_of(",;"));  // the first thing alone
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(name);
  ImGui::SameLine(64);
  const std::string text = fmt::format("{:.{}f} of {:.3g} ms", ms, ms < 1 ? 2 : 1, period_ms);
  ImGui::PushStyleColor(ImGuiCol_PlotHistogram,
                        share < 0.85f || may_last ? ImVec4(0.25f, 0.52f, 0.58f, 1) : ImVec4(0.75f, 0.45f, 0.20f, 1));
  ImGui::ProgressBar(share, {narrow ? 112.0f : 170.0f, 0}, text.c_str());
  ImGui::PopStyleColor();
  ImGui::SameLine();
  ImGui::TextColored(kQuiet, "%s", note.c_str());
}

/// How far the tissue is from where it comes to rest.
std::string rest_in_words(double distance_mm) {
  constexpr double kAtRest_mm = 0.05, kFar_mm = 50;  // beyond it the estimate says no more than that
  if (!(distance_mm < kFar_mm)) return "moving, far from rest";
  return distance_mm < kAtRest_mm ? "at rest" : fmt::format("moving, about {:.1f} mm from rest", distance_mm);
}

// Two buttons side by side, as wide as there is room.
float half_width() { return 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x); }

}  // namespace

void Desk::panel(const char* name, float x, float y, float w, float h) {
  ImGui::SetNextWindowPos({x, y});
  ImGui::SetNextWindowSize({w, h});
  ImGui::SetNextWindowBgAlpha(1);
  ImGui::Begin(name, nullptr, kFixed);
  covered_.push_back({x, y, x + w, y + h});
}

float desk_scale(int width, int height) {
  constexpr float kLines = 1080, kColumns = 1500, kLargest = 3;
  return std::clamp(std::floor(4 * std::min(float(height) / kLines, float(width) / kColumns)) / 4, 1.0f, kLargest);
}

DeskStage desk_stage(int width, int height) {
  const float scale = desk_scale(width, height), w = float(width) / scale, h = float(height) / scale;
  DeskStage s;
  s.u0 = kToolsWidth / w, s.u1 = std::max(s.u0 + 0.05f, 1 - kPatientWidth / w),
  s.v1 = std::max(0.05f, 1 - kLanesHeight / h);
  s.aspect = double(s.u1 - s.u0) * double(width) / (double(s.v1) * double(height));
  return s;
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
  if (!notices_.empty() && n.kind == Notice::done && stroke(n) > 0 && stroke(n) == stroke(notices_.back())) return;
  notices_.push_back(n);
  if (shown_ && n.kind == Notice::done) Notice::put(notices_.back().text, "shown: " + std::string(n.text.data()));
  if (notices_.size() > kNotices) notices_.pop_front();
  last_word_ = n.kind == Notice::refused   ? std::string(n.action.data()) + " refused: " + n.text.data()
               : n.kind == Notice::dropped ? n.text.data()
                                           : "";
}

// What the device does, and what to do when it does nothing.
void Desk::device(const DeskReading& r) {
  ImGui::TextWrapped("%s", facts_.device.c_str());
  if (!facts_.own_device) return;
  const auto warn = [](const char* text) {
    ImGui::PushStyleColor(ImGuiCol_Text, kWarn);
    ImGui::TextWrapped("%s", text);
    ImGui::PopStyleColor();
  };
  const bool begun = r.gauges && LaneGauges::get(r.gauges->tick) > 2500;
  if (begun && r.samples_per_s < 1)
    warn("silent: no sample for a second. Is it connected and switched on? limberg devices --watch shows what comes");
  else if (begun)
    ImGui::TextColored(kGood, "%.0f samples/s", r.samples_per_s);
  if (!facts_.calibrated) warn("not calibrated: limberg calibrate stylus, then --calibration FILE");
}

void Desk::choose_field(SkinField field) {
  state.field = facts_.skin || field == SkinField::moved ? field : SkinField::none;
}

void Desk::choose(Tool tool) {
  state.tool_changed |= tool != state.tool;
  state.tool = tool;
  if (tool != Tool::none) state.ruler = false;
}

void Desk::tools(const DeskReading& r, int height) {
  panel("tools", 0, 0, kToolsWidth, float(height));
  ImGui::TextUnformatted(facts_.scene.c_str());
  heading("TOOLS");
  for (const DeskTool& t : kDeskTools)
    if ((t.tool == Tool::none || (acts_on_bone(t.tool) ? facts_.head : facts_.skin)) &&
        ImGui::Selectable(fmt::format("{}  {}", char(t.key), t.name).c_str(),
                          r.hand_tool.value_or(state.tool) == t.tool && !state.ruler))
      choose(t.tool);
  ImGui::PushItemWidth(-1);
  for (const ToolSlider& k : tool_sliders(state.tool, facts_.max_depth_mm)) {
    ImGui::TextColored(kQuiet, "%s", k.name.c_str());
    state.tool_changed |=
        ImGui::SliderFloat(("##" + k.name).c_str(), &(state.*k.value), k.from, k.to, k.format.c_str());
    if (ImGui::IsItemHovered()) {
      ImGui::BeginTooltip();
      ImGui::PushTextWrapPos(2 * kToolsWidth);
      ImGui::TextUnformatted(k.help.c_str());
      ImGui::PopTextWrapPos();
      ImGui::EndTooltip();
    }
  }
  ImGui::PopItemWidth();
  ImGui::Spacing();
  const float half = half_width();
  if (ImGui::Button("Undo", {half, 0})) state.undo = true;
  ImGui::SameLine();
  if (ImGui::Button("Redo", {half, 0})) state.redo = true;

  heading("VIEW");
  ImGui::PushItemWidth(-1);
  if (ImGui::BeginCombo("##field", state.field == SkinField::none ? "No colours" : look_of(state.field).name)) {
    for (int k = 0; k < kSkinFields; ++k)
      if (k == 0 || facts_.skin || SkinField(k) == SkinField::moved)
        if (ImGui::Selectable(k == 0 ? "No colours" : look_of(SkinField(k)).name, int(state.field) == k))
          choose_field(SkinField(k));
    ImGui::EndCombo();
  }
  ImGui::PopItemWidth();
  if (state.field != SkinField::none) ImGui::Checkbox("Iso-lines", &state.iso_lines);
  if (facts_.skin) {
    ImGui::Checkbox("Directions", &state.directions);
    ImGui::Checkbox("Tension lines", &state.tension_lines);
    ImGui::Checkbox("Lattice", &state.lattice);
  }
  if (facts_.head)
    ImGui::PushItemWidth(-1), ImGui::Combo("##face", &state.face, "Face\0Clear face\0No face\0"), ImGui::PopItemWidth();
  if (facts_.head) ImGui::Checkbox("Landmarks", &state.landmarks);
  ImGui::Checkbox("Triangles", &state.wireframe);
  if (ImGui::Checkbox("Measure", &state.ruler) && state.ruler) choose(Tool::none);
  ImGui::PushItemWidth(-1);
  int compare = int(state.compare), stereo = int(state.stereo);
  if (ImGui::Combo("##compare", &compare, "No comparison\0Before | after: wipe\0Before, after\0"))
    state.compare = Compare(compare);
  if (state.compare == Compare::wipe) ImGui::SliderFloat("##wipe", &state.wipe, 0, 1, "");
  if (ImGui::Combo("##stereo", &stereo, "One eye\0Stereo side by side\0Stereo red-cyan\0"))
    state.stereo = Stereo(stereo);
  ImGui::Combo("##quality", &state.quality,
               "Quality: automatic\0Half size\0Fast\0Fine skin\0Shadows\0Shadows, occlusion\0");
  ImGui::PopItemWidth();
  if (ImGui::Button("Picture", {half, 0})) state.picture = true;
  ImGui::SameLine();
  if (ImGui::Button("Home", {half, 0})) state.home = true;
  if (ImGui::Button("Keys and mouse  ?", {-1, 0})) state.help = !state.help;

  heading("DEVICE");
  device(r);
  if (facts_.recording.empty()) {
    ImGui::Checkbox("Keep the recording", &state.keep_recording);
  } else {
    ImGui::TextColored(kBad, "REC");
    ImGui::SameLine();
    ImGui::TextWrapped("%s", facts_.recording.c_str());
  }
  ImGui::End();
}

void Desk::patient(const DeskReading& r, int width, int height) {
  panel("patient", float(width) - kPatientWidth, 0, kPatientWidth, float(height));
  const Snapshot& s = *r.shown;
  if (!facts_.goal.empty()) {
    ImGui::TextWrapped("%s", facts_.goal.c_str());
    ImGui::Spacing();
  }
  if (r.coach && !r.coach->plan().steps.empty())
    state.lesson.steps(*r.coach, r.coach->plan().title.empty() ? "LESSON" : r.coach->plan().title.c_str(),
                       float(height), r.showing, state.next, state.next_clean, state.summary);

  if (!s.figures.empty()) {
    heading("HEAD");
    for (const LiveFigure& k : s.figures) ImGui::Text("%s %.1f %s", k.name.c_str(), double(k.value), k.unit);
  }
  if (facts_.head && r.measures) {
    if (s.figures.empty()) heading("HEAD");
    state.head.draw(*r.measures, !s.moved_mm.empty(), float(height));
  }
  if (facts_.skin) heading("SUTURES");
  if (!facts_.skin)
    ImGui::Spacing();
  else if (s.sutures.empty())
    ImGui::TextColored(kQuiet, "none yet");
  else {
    double sum = 0;
    for (const SutureState& x : s.sutures) sum += double(x.force_N);
    const int n = int(s.sutures.size());
    ImGui::Text("%d %s, %.2f N%s", n, n == 1 ? "stitch" : "stitches", sum, n == 1 ? "" : " together");
    if (ImGui::BeginTable("sutures", 3, ImGuiTableFlags_RowBg | ImGuiTableFlags_ScrollY,
                          {0, std::min(0.25f * float(height), 26.0f + 21.0f * float(s.sutures.size()))})) {
      ImGui::TableSetupScrollFreeze(0, 1);
      ImGui::TableSetupColumn("no.");
      ImGui::TableSetupColumn("force N");
      ImGui::TableSetupColumn("gap mm");
      ImGui::TableHeadersRow();
      for (const SutureState& x : s.sutures) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::Text("%d", x.id);
        ImGui::TableNextColumn();
        const double force = double(x.force_N);
        ImGui::TextColored(force < kSutureForce_N.warn  ? kGood
                           : force < kSutureForce_N.bad ? kWarn
                                                        : kBad,
                           "%.2f", double(x.force_N));
        ImGui::TableNextColumn();
        ImGui::Text("%.2f", double(x.gap_mm));
      }
      ImGui::EndTable();
    }
    ImGui::TextColored(kQuiet, "limits %.3g and %.3g N", kSutureForce_N.warn, kSutureForce_N.bad);
  }
  hooks(s);
  done_list();
  ImGui::End();
}

void Desk::hooks(const Snapshot& s) {
  if (s.hooks.empty()) return;
  heading("HOOKS");
  for (const HookState& h : s.hooks) {
    ImGui::PushID(h.id);
    ImGui::AlignTextToFramePadding();
    ImGui::Text("%d   %.2f N", h.id, double(h.force_N.norm()));
    ImGui::SameLine(110);
    if (ImGui::SmallButton("let go")) state.release_hook = h.id;
    ImGui::PopID();
  }
}

void Desk::done_list() {
  heading("DONE");
  ImGui::BeginChild("done", {0, -2});
  for (const Notice& n : notices_) {
    const char* mark = n.kind == Notice::undone   ? "taken back"
                       : n.kind == Notice::redone ? "done again"
                                                  : n.text.data();
    const std::string when = fmt::format("{:.1f} s", n.t_s);
    const bool refused = n.kind == Notice::refused, dropped = n.kind == Notice::dropped;
    listed(refused   ? kBad
           : dropped ? kWarn
                     : ImGui::GetStyleColorVec4(ImGuiCol_Text),
           58, when.c_str(), refused ? (std::string(n.action.data()) + " refused: " + n.text.data()).c_str() : mark);
  }
  if (ImGui::GetScrollY() >= ImGui::GetScrollMaxY() - 4) ImGui::SetScrollHereY(1);
  ImGui::EndChild();
}

void Desk::lanes(const DeskReading& r, int width, int height) {
  const float x = kToolsWidth, w = float(width) - kToolsWidth - kPatientWidth;
  if (w < 200) return;
  panel("lanes", x, float(height) - kLanesHeight, w, kLanesHeight);
  const Snapshot& s = *r.shown;
  if (r.gauges) {
    const LaneGauges& g = *r.gauges;
    const auto ms = [](const std::atomic<int64_t>& v) { return double(LaneGauges::get(v)) * 1e-6; };
    lane("hand", ms(g.device_ns), 1,
         fmt::format("{} late of {}, {:.0f} samples/s", LaneGauges::get(g.device_late), LaneGauges::get(g.tick),
                     r.samples_per_s));
    const double pace = 1e-3 * double(LaneGauges::get(g.pace_permille));
    lane("patient", ms(g.solver_ns), 16,
         fmt::format("{}; residual {:.1e}{}{}", rest_in_words(double(s.distance_mm)), s.residual,
                     pace < SlowWatch::kSlowed ? "; " : "", pace < SlowWatch::kSlowed ? SlowWatch::words(pace) : ""));
    const std::string seen =
        fmt::format("shows what was {} ms ago", std::max<int64_t>(0, LaneGauges::get(g.tick) - s.device_tick));
    std::string note = "at rest, drawn finely; " + seen;
    if (!r.at_leisure) {
      note = fmt::format("{}, {:.0f} pictures/s", seen, r.pictures_per_s);
      // Beside other programs steps take several times as long: that is no figure of the pictures.
      if (const int64_t loss = LaneGauges::get(g.loss_permille); loss > 1000)
        note += ", the machine is busy";
      else if (loss >= 0)
        note += fmt::format(", the patient loses {:.0f} %", 0.1 * double(loss));
    }
    lane("picture", ms(g.frame_ns), 33, note, r.at_leisure);
  }
  ImGui::End();
  float word_height = 0;
  const CoachSays* says = r.coach ? &r.coach->says() : nullptr;
  const std::string& word = says && !says->word.empty() ? says->word : last_word_;
  if (!word.empty() && !state.summary) {
    ImGui::SetNextWindowPos({x + 0.5f * w, float(height) - kLanesHeight - 8}, ImGuiCond_Always, {0.5f, 1});
    ImGui::SetNextWindowBgAlpha(0.85f);
    ImGui::SetNextWindowSizeConstraints({200, 0}, {0.9f * w, 200});
    ImGui::Begin("word", nullptr, kFixed | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoInputs);
    ImGui::PushTextWrapPos(0.86f * w);
    const bool coached = says && &word == &says->word;
    ImGui::PushStyleColor(ImGuiCol_Text, !coached ? kNow : says->word_is_praise ? kGood : kWarn);
    ImGui::TextUnformatted(word.c_str());
    ImGui::PopStyleColor();
    ImGui::PopTextWrapPos();
    word_height = ImGui::GetWindowHeight() + 6;
    ImGui::End();
  }
  if (r.coach) state.lesson.stroke(*r.coach, x, w, float(height) - kLanesHeight - 8 - word_height);
}

void Desk::legend(const DeskReading& r, int width, int height) {
  if (!r.field || r.field->value.empty()) return;
  const SkinFieldLook& look = r.look ? *r.look : look_of(state.field);
  const float left = float(width) - kPatientWidth - 128, top = std::max(0.16f * float(height), stage_top_ + 8),
              bar = 0.42f * float(height);
  ImGui::SetNextWindowPos({left, top});
  ImGui::SetNextWindowSize({120, bar + 108});
  ImGui::SetNextWindowBgAlpha(0.88f);
  ImGui::Begin("legend", nullptr, kFixed | ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoScrollbar);
  ImGui::TextWrapped("%s", look.title);
  ImGui::TextColored(kQuiet, "%s", look.unit);
  ImDrawList& d = *ImGui::GetWindowDrawList();
  const float x0 = left + 12, y0 = top + 84, x1 = x0 + 18;
  const auto at = [&](double t) {
    const Rgb8 c = colour_of(look.scale, t);
    return IM_COL32(c.r, c.g, c.b, 255);
  };
  constexpr int kSteps = 64;
  for (int i = 0; i < kSteps; ++i)
    d.AddRectFilled({x0, y0 + bar * float(i) / kSteps}, {x1, y0 + bar * float(i + 1) / kSteps + 1},
                    at(1 - (i + 0.5) / kSteps));
  const double range = r.field->hi - r.field->lo, step = range / std::max(1, r.field->intervals);
  // Values lie beyond the scale: a triangle says so.
  if (r.field->above) d.AddTriangleFilled({x0, y0 - 3}, {x1, y0 - 3}, {0.5f * (x0 + x1), y0 - 12}, at(1));
  if (r.field->below)
    d.AddTriangleFilled({x0, y0 + bar + 4}, {x1, y0 + bar + 4}, {0.5f * (x0 + x1), y0 + bar + 13}, at(0));
  for (int k = 0; k <= r.field->intervals; ++k) {
    const double v = r.field->lo + k * step;
    const float y = y0 + bar * float(1 - (v - r.field->lo) / range);
    d.AddLine({x1, y}, {x1 + 5, y}, IM_COL32(240, 245, 245, 255));
    d.AddText({x1 + 9, y - 8}, IM_COL32(240, 245, 245, 255), tick_label(v, step).c_str());
  }
  ImGui::End();
}

void Desk::help(int width, int height) {
  if (!state.help) return;
  ImGui::SetNextWindowPos({0.5f * float(width), 0.5f * float(height)}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowBgAlpha(0.95f);
  ImGui::Begin("Keys and mouse", &state.help,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoCollapse);
  const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  covered_.push_back({at.x, at.y, at.x + size.x, at.y + size.y});
  if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_RowBg)) {
    for (const DeskKey& k : desk_keys()) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(k.keys.c_str());
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(k.what.c_str());
    }
    ImGui::EndTable();
  }
  ImGui::End();
}

void Desk::draw(const DeskReading& r, const std::vector<Vec3f>& ruler_px, int width, int height) {
  covered_.clear();
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
  tools(r, height);
  patient(r, width, height);
  stage_top_ = 0;
  if (const float w = float(width) - kToolsWidth - kPatientWidth; r.coach && w >= 200)
    stage_top_ = state.lesson.next_step(*r.coach, kToolsWidth, 0, w, covered_);
  lanes(r, width, height);
  legend(r, width, height);
  ImGui::PopStyleVar(2);
  help(width, height);
  if (r.coach) state.lesson.summary(*r.coach, width, height, state.summary, covered_);
  popup_ = ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup);

  if (state.compare != Compare::off) {
    const DeskStage g = desk_stage(width, height);
    const bool wipe = state.compare == Compare::wipe;
    const char *const earlier = r.earlier_try ? "earlier try" : "before", *const later =
                                                                              r.earlier_try ? "this try" : "after";
    const float left = g.u0 * float(width), right = g.u1 * float(width),
                border = wipe ? left + state.wipe * (right - left) : 0.5f * (left + right);
    ImDrawList& d = *ImGui::GetBackgroundDrawList();
    const ImU32 ink = IM_COL32(240, 245, 245, 230);
    d.AddLine({border, 0}, {border, g.v1 * float(height)}, ink, 1.5f);
    for (const auto& [word, x] :
         {std::pair(earlier, border - 10 - ImGui::CalcTextSize(earlier).x), std::pair(later, border + 10)}) {
      const ImVec2 size = ImGui::CalcTextSize(word);
      if (x < left || x + size.x > right) continue;
      const float y = stage_top_;
      d.AddRectFilled({x - 5, y + 7}, {x + size.x + 5, y + 13 + size.y}, IM_COL32(15, 22, 26, 170), 3);
      d.AddText({x, y + 10}, ink, word);
    }
  }
  for (const DeskMark& m : r.marks) {
    ImDrawList& d = *ImGui::GetBackgroundDrawList();
    if (m.kind != DeskMark::Kind::landmark) {  // a letter beside its corner, the name of a limit
      if (m.hidden) continue;
      const ImVec2 size = ImGui::CalcTextSize(m.name.c_str());
      const ImU32 paper = m.kind == DeskMark::Kind::limit ? IM_COL32(120, 12, 12, 225) : IM_COL32(62, 24, 98, 225);
      const float x = m.x + 7, y = m.y - 20;
      d.AddRectFilled({x - 4, y - 1}, {x + size.x + 4, y + size.y + 1}, paper, 4);
      d.AddText({x, y}, IM_COL32(250, 250, 250, 255), m.name.c_str());
      continue;
    }
    const ImU32 ink = m.hidden ? IM_COL32(140, 225, 255, 110) : IM_COL32(140, 225, 255, 255);
    if (m.hidden)
      d.AddCircle({m.x, m.y}, 4, ink, 12, 1.5f);
    else
      d.AddCircleFilled({m.x, m.y}, 4, IM_COL32(10, 30, 40, 255)), d.AddCircleFilled({m.x, m.y}, 3, ink);
    const ImVec2 size = ImGui::CalcTextSize(m.name.c_str());
    d.AddRectFilled({m.x + 6, m.y - 8}, {m.x + 12 + size.x, m.y - 4 + size.y},
                    IM_COL32(15, 22, 26, m.hidden ? 70 : 150), 3);
    d.AddText({m.x + 9, m.y - 6}, ink, m.name.c_str());
  }
  if (!ruler_px.empty()) {
    ImDrawList& d = *ImGui::GetBackgroundDrawList();
    const ImU32 ink = IM_COL32(255, 240, 120, 255);
    for (size_t i = 0; i < ruler_px.size(); ++i) {
      if (i > 0) d.AddLine({ruler_px[i - 1].x(), ruler_px[i - 1].y()}, {ruler_px[i].x(), ruler_px[i].y()}, ink, 2);
      d.AddCircleFilled({ruler_px[i].x(), ruler_px[i].y()}, 4, ink);
    }
    std::string text = "second point?";
    if (ruler_px.size() >= 2) text = fmt::format("{:.1f} mm ({:.1f} at rest)", r.ruler.length_mm, r.ruler.rest_mm);
    if (ruler_px.size() == 3) text += fmt::format(", {:.1f}\u00b0", r.ruler.angle_deg);
    const Vec3f& p = ruler_px.back();
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    d.AddRectFilled({p.x() + 8, p.y() + 4}, {p.x() + 16 + size.x, p.y() + 10 + size.y}, IM_COL32(15, 22, 26, 200), 3);
    d.AddText({p.x() + 12, p.y() + 7}, ink, text.c_str());
  }
}

}  // namespace limberg
