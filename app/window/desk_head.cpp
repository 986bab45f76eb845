#include "app/window/desk_head.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "app/window/desk_look.h"
#include "sim/commands/actions.h"

namespace limberg {

using namespace desk_look;

namespace {

// A slider over what the table of acts calls usual; `at_least`: in words, what the least value means.
void field_slider(const char* label, const ActionField& f, double& value, const char* format,
                  const char* at_least = nullptr) {
  const bool least = at_least && value <= f.field.usual_from;
  ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &f.field.usual_from, &f.field.usual_to,
                      least ? at_least : format);
}

// A choice by the words of the table of acts.
template <class E>
void field_choice(const char* label, const ActionField& f, E& value, const Words& w) {
  if (!ImGui::BeginCombo(label, w(f.field.words[size_t(value)]))) return;
  for (size_t k = 0; k < f.field.words.size(); ++k)
    if (ImGui::Selectable(w(f.field.words[k]), size_t(value) == k)) value = E(k);
  ImGui::EndCombo();
}

}  // namespace

void DeskHead::draw(const std::vector<HeadMeasure>& measures, bool has_face, float height, const Words& w) {
  ImGui::PushItemWidth(72);
  ImGui::InputText("##name", name.data(), name.size());
  ImGui::PopItemWidth();
  ImGui::SameLine();
  if (button(w, "Pick   K")) pick = true;
  if (!ImGui::BeginTabBar("head")) return;
  if (ImGui::BeginTabItem(w("Figures"))) figures(measures, height, w), ImGui::EndTabItem();
  if (ImGui::BeginTabItem(w("Bones"))) bones(w), ImGui::EndTabItem();
  if (has_face && ImGui::BeginTabItem(w("Tissue"))) between(has_face, w), ImGui::EndTabItem();
  ImGui::EndTabBar();
}

// A button that says why it cannot be pressed yet.
bool DeskHead::button_for(const Words& w, size_t places, const char* what) {
  if (placed_.size() >= places) return ImGui::Button((w(what) + (" " + named(places))).c_str(), {-1, 0});
  ImGui::PushStyleColor(ImGuiCol_Text, ink::quiet());
  wrapped(w("{}: pick {} places on bone", w(what), places));
  ImGui::PopStyleColor();
  return false;
}

void DeskHead::bones(const Words& w) {
  text(ink::quiet(), w("saw through what was picked last"));
  ImGui::PushItemWidth(72);
  ImGui::InputInt(w("places of a ring"), &ring, 1, 1);
  ring = std::clamp(ring, 3, 40);
  ImGui::PopItemWidth();
  if (button_for(w, size_t(ring), english("Saw round"))) ask = Ask::saw_round;
  if (button_for(w, 3, english("Saw plane"))) ask = Ask::saw_plane;
  ImGui::PushItemWidth(100);
  ImGui::SliderFloat(w("reach of the plane"), &saw_radius_mm, 0, 120,
                     saw_radius_mm > 0 ? w("within {:.0f} mm", saw_radius_mm).c_str() : w("all"));
  ImGui::PopItemWidth();
  ImGui::Separator();
  if (placed_.empty()) {
    text(ink::quiet(), w("pick a place on a fragment to move it"));
    return;
  }
  wrapped(w("fragment at {}: right, forward, up", placed_.back().name));
  ImGui::PushItemWidth(200);
  ImGui::InputFloat3("mm", shift_mm.data(), "%.2f");
  ImGui::InputFloat3("\u00b0", turn_deg.data(), "%.2f");
  ImGui::PopItemWidth();
  const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  if (button(w, "Move it by these", half)) ask = Ask::shift;
  ImGui::SameLine();
  if (button(w, "Snap into its cut", half)) ask = Ask::snap;
  if (button_for(w, 2, english("Plate"))) ask = Ask::plate;
  if (button_for(w, 2, english("Join"))) ask = Ask::join;
}

void DeskHead::between(bool has_face, const Words& w) {
  if (on_face_.empty() || on_bone_.empty()) {
    if (has_face) text(ink::quiet(), w("pick a place on the face and one on bone"));
    return;
  }
  ImGui::PushItemWidth(72);
  const auto field = [](const char* key) -> const ActionField& { return action_field("connect_tissue", key); };
  if (on_face_.size() >= 3) ImGui::Checkbox(w("within the {} places on the face", on_face_.size()).c_str(), &outlined);
  if (on_face_.size() < 3 || !outlined)
    field_slider(w("on the face, mm"), field("face_radius_mm"), tissue.face_radius_mm, "%.0f");
  field_slider(w("on bone, mm"), field("bone_radius_mm"), tissue.bone_radius_mm, "%.0f", w("all of it"));
  const Field& layers = field("layers").field;
  ImGui::SliderInt(w("layers"), &tissue.layers, int(layers.usual_from), int(layers.usual_to));
  field_slider("kPa", field("young_kPa"), tissue.young_kPa, "%.0f");
  ImGui::PopItemWidth();
  ImGui::PushItemWidth(-1);
  field_choice("##mode", field("mode"), tissue.mode, w);
  ImGui::PopItemWidth();
  if (ImGui::Button(w("Tissue {} - {}", on_face_.back().name, on_bone_.back().name).c_str(), {-1, 0})) tie = true;
}

void DeskHead::figures(const std::vector<HeadMeasure>& measures, float height, const Words& w) {
  ImGui::PushItemWidth(-1);
  field_choice("##beside", action_field("superpose", "on"), beside, w);
  ImGui::PopItemWidth();
  if (beside != SkullBeside::off && !skull_word.empty()) wrapped(w.said(skull_word));
  if (measures.empty()) return;
  if (ImGui::BeginTable("measures", 3, ImGuiTableFlags_RowBg | ImGuiTableFlags_ScrollY, {0, 0.30f * height})) {
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn(w("measure"), ImGuiTableColumnFlags_WidthStretch, 1.5f);
    ImGui::TableSetupColumn(w("now, mm"));
    ImGui::TableSetupColumn(w("change"));
    ImGui::TableHeadersRow();
    // What was picked first, then what has changed most: the eye is on the fragment.
    for (const bool of_interest : {true, false})
      for (const HeadMeasure& m : measures) {
        const bool first = m.group == HeadMeasure::Group::picked || std::abs(m.change()) >= 0.05;
        if (first != of_interest) continue;
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        text(m.group == HeadMeasure::Group::asymmetry ? w("L/R {}", w.said(m.name)) : w.said(m.name));
        ImGui::TableNextColumn();
        text(m.unit == "deg" ? w("{:.1f}\u00b0", m.now) : w("{:.1f}", m.now));
        ImGui::TableNextColumn();
        if (std::abs(m.change()) >= 0.05) text(w("{:+.1f}", m.change()));
      }
    ImGui::EndTable();
  }
}

void DeskHead::see(const std::vector<std::string>& landmarks, std::span<const Vec3f> now_mm) {
  on_face_.clear(), on_bone_.clear(), placed_.clear();
  for (Pick& p : picked_) {
    const auto at = size_t(std::find(landmarks.begin(), landmarks.end(), p.name) - landmarks.begin());
    if (at == landmarks.size()) continue;
    p.now_mm = at < now_mm.size() ? Vec3(now_mm[at].cast<double>()) : p.X_mm;
    (p.on == Pick::On::face ? on_face_ : on_bone_).push_back(p);
    if (p.on == Pick::On::bone) placed_.push_back(p);
  }
}

std::variant<Command, ControlSample> DeskHead::picked(const Snapshot& s, int32_t triangle, const Vec3f& bary) {
  std::variant<Command, ControlSample> said;
  const std::string called(name.data());
  Pick made{called, Vec3::Zero(), Vec3::Zero(), Pick::On::touched};
  if (triangle >= 0 && s.topology) {
    const Tri& t = s.topology->view.tri[size_t(triangle)];
    for (size_t k = 0; k < 3; ++k) made.X_mm += double(bary[Eigen::Index(k)]) * s.topology->view.X_mm[size_t(t[k])];
    const bool face = s.topology->organ_of(size_t(triangle)) == Organ::face;
    made.on = face ? Pick::On::face : Pick::On::bone;
    said = HeadCommand(PlaceLandmark{called, made.X_mm, face});
  } else {
    ControlSample c;
    c.kind = ControlSample::name_place, c.text = ShortText(called), c.value[3] = kTouchedBone;
    said = c;
  }
  // A name has one place.
  std::erase_if(picked_, [&](const Pick& p) { return p.name == called; });
  picked_.push_back(made);
  // M1, M2, ...; after a name of another kind the next number that was not given.
  if (const int number = picked_number(called)) next_ = std::max(next_, number + 1);
  const std::string next = "M" + std::to_string(next_);
  name.fill(0);
  next.copy(name.data(), name.size() - 1);
  return said;
}

std::optional<Command> DeskHead::tied() const {
  if (on_face_.empty() || on_bone_.empty()) return std::nullopt;
  ConnectTissue t = tissue;
  t.name = on_face_.back().name + "-" + on_bone_.back().name;
  t.face_mm = on_face_.back().now_mm, t.bone_mm = on_bone_.back().now_mm;
  if (outlined && on_face_.size() >= 3) {
    for (const Pick& p : on_face_) t.face_outline_mm.push_back(p.now_mm);
    t.face_mm = middle_of(t.face_outline_mm);
  }
  return HeadCommand(std::move(t));
}

std::string DeskHead::named(size_t last) const {
  const size_t n = placed_.size(), from = n - std::min(n, last);
  std::string s = n == 0 ? std::string() : placed_[from].name;
  if (last > 1 && n > 0) s += (last == 2 ? " - " : " ... ") + placed_.back().name;
  return s;
}

std::vector<Command> DeskHead::asked() const {
  const auto at = [&](size_t back) { return placed_[placed_.size() - 1 - back].X_mm; };
  // As the panel shows it, to a hundredth.
  const auto shown = [](const std::array<float, 3>& v) {
    Vec3 r;
    for (size_t i = 0; i < 3; ++i)
      r[Eigen::Index(i)] = std::round(100 * std::clamp(double(v[i]), -999.99, 999.99)) / 100 + 0.0;
    return r;
  };
  const size_t places = placed_.size(), round = size_t(ring);
  const size_t wanted = ask == Ask::saw_round                   ? round
                        : ask == Ask::saw_plane                 ? 3
                        : ask == Ask::plate || ask == Ask::join ? 2
                                                                : 1;
  if (ask == Ask::nothing || places < wanted) return {};
  const FragmentPick last{-1, at(0)};
  switch (ask) {
    case Ask::saw_round: {
      CutBone cut;
      for (size_t k = round; k-- > 0;) cut.contour_mm.push_back(at(k));
      return {HeadCommand(std::move(cut))};
    }
    case Ask::saw_plane: {
      CutBone cut;
      cut.point_mm = (at(0) + at(1) + at(2)) / 3, cut.normal = (at(1) - at(2)).cross(at(0) - at(2)).normalized();
      cut.radius_mm = double(saw_radius_mm);
      return {HeadCommand(std::move(cut))};
    }
    case Ask::shift: {
      RigidMove by;
      by.translation_mm = shown(shift_mm), by.rotation_deg = shown(turn_deg);
      return {HeadCommand(MoveFragment{last, by, 0})};
    }
    case Ask::snap:
      return {HeadCommand(GrabFragment{last, 0}), HeadCommand(LetGo{true, 0})};
    case Ask::plate:
      return {HeadCommand(PlateFragments{at(1), at(0)})};
    default:
      return {HeadCommand(JoinFragments{{-1, at(1)}, last})};
  }
}

std::optional<Command> DeskHead::laid_upon() {
  if (beside == told_) return std::nullopt;
  told_ = beside;
  return HeadCommand(Superpose{beside, ""});
}

void DeskHead::hear(const std::string& words) {
  for (size_t k = 0; k < std::size(kSkullBesideWords); ++k)
    if (words == kSkullBesideWords[k]) beside = told_ = SkullBeside(k);
}

}  // namespace limberg
