#include "app/window/desk_head.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "devices/pick.h"

namespace limberg {

void DeskHead::draw(const std::vector<HeadMeasure>& measures, bool has_face, float height) {
  ImGui::PushItemWidth(72);
  ImGui::InputText("##name", name.data(), name.size());
  ImGui::PopItemWidth();
  ImGui::SameLine();
  if (ImGui::Button("Pick   K")) pick = true;
  if (!ImGui::BeginTabBar("head")) return;
  if (ImGui::BeginTabItem("Figures")) figures(measures, height), ImGui::EndTabItem();
  if (ImGui::BeginTabItem("Bones")) bones(), ImGui::EndTabItem();
  if (has_face && ImGui::BeginTabItem("Tissue")) tissue(has_face), ImGui::EndTabItem();
  ImGui::EndTabBar();
}

// A button that says why it cannot be pressed yet.
bool DeskHead::button_for(size_t places, const char* what) {
  if (placed_.size() >= places) return ImGui::Button((what + (" " + named(places))).c_str(), {-1, 0});
  ImGui::TextDisabled("%s: pick %zu places on bone", what, places);
  return false;
}

void DeskHead::bones() {
  ImGui::TextDisabled("saw through what was picked last");
  ImGui::PushItemWidth(72);
  ImGui::InputInt("places of a ring", &ring, 1, 1);
  ring = std::clamp(ring, 3, 40);
  ImGui::PopItemWidth();
  if (button_for(size_t(ring), "Saw round")) ask = Ask::saw_round;
  if (button_for(3, "Saw plane")) ask = Ask::saw_plane;
  ImGui::PushItemWidth(100);
  ImGui::SliderFloat("reach of the plane", &saw_radius_mm, 0, 120, saw_radius_mm > 0 ? "within %.0f mm" : "all");
  ImGui::PopItemWidth();
  ImGui::Separator();
  if (placed_.empty()) {
    ImGui::TextDisabled("pick a place on a fragment to move it");
    return;
  }
  ImGui::Text("fragment at %s: right, forward, up", placed_.back().name.c_str());
  ImGui::PushItemWidth(200);
  ImGui::InputFloat3("mm", shift_mm.data(), "%.2f");
  ImGui::InputFloat3("\u00b0", turn_deg.data(), "%.2f");
  ImGui::PopItemWidth();
  const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  if (ImGui::Button("Move it by these", {half, 0})) ask = Ask::shift;
  ImGui::SameLine();
  if (ImGui::Button("Snap into its cut", {half, 0})) ask = Ask::snap;
  if (button_for(2, "Plate")) ask = Ask::plate;
  if (button_for(2, "Join")) ask = Ask::join;
}

void DeskHead::tissue(bool has_face) {
  if (on_face_.empty() || on_bone_.empty()) {
    if (has_face) ImGui::TextDisabled("pick a place on the face and one on bone");
    return;
  }
  ImGui::PushItemWidth(72);
  ImGui::SliderFloat("on the face, mm", &face_radius_mm, 8, 80, "%.0f");
  ImGui::SliderFloat("on bone, mm", &bone_radius_mm, 0, 120, bone_radius_mm > 0 ? "%.0f" : "all of it");
  ImGui::SliderInt("layers", &layers, 1, 6);
  ImGui::SliderFloat("kPa", &young_kPa, 1, 60, "%.0f");
  ImGui::PopItemWidth();
  ImGui::PushItemWidth(-1);
  ImGui::Combo("##mode", &mode, "Smoothing: the face does not feel it\0Springs\0Shape\0Finite elements\0");
  ImGui::PopItemWidth();
  if (ImGui::Button(("Tissue " + on_face_.back().name + " - " + on_bone_.back().name).c_str(), {-1, 0})) tie = true;
}

void DeskHead::figures(const std::vector<HeadMeasure>& measures, float height) {
  int with = int(beside);
  ImGui::PushItemWidth(-1);
  if (ImGui::Combo("##beside", &with, "The skull alone\0Beside a normal skull\0Beside its mirror image\0"))
    beside = SkullBeside(with);
  ImGui::PopItemWidth();
  if (beside != SkullBeside::off && !skull_word.empty()) ImGui::TextWrapped("%s", skull_word.c_str());
  if (measures.empty()) return;
  if (ImGui::BeginTable("measures", 3, ImGuiTableFlags_RowBg | ImGuiTableFlags_ScrollY, {0, 0.30f * height})) {
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn("measure", ImGuiTableColumnFlags_WidthStretch, 1.5f);
    ImGui::TableSetupColumn("now, mm");
    ImGui::TableSetupColumn("change");
    ImGui::TableHeadersRow();
    // What was picked first, then what has changed most: the eye is on the fragment.
    for (const bool of_interest : {true, false})
      for (const HeadMeasure& m : measures) {
        const bool first = m.group == HeadMeasure::Group::picked || std::abs(m.change()) >= 0.05;
        if (first != of_interest) continue;
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::Text("%s%s", m.group == HeadMeasure::Group::asymmetry ? "L/R " : "", m.name.c_str());
        ImGui::TableNextColumn();
        ImGui::Text("%.1f%s", m.now, m.unit == "deg" ? "\u00b0" : "");
        ImGui::TableNextColumn();
        if (std::abs(m.change()) >= 0.05) ImGui::Text("%+.1f", m.change());
      }
    ImGui::EndTable();
  }
}

void DeskHead::see(const std::vector<std::string>& landmarks) {
  on_face_.clear(), on_bone_.clear(), placed_.clear();
  for (const Pick& p : picked_) {
    if (std::find(landmarks.begin(), landmarks.end(), p.name) == landmarks.end()) continue;
    (p.on == Pick::On::face ? on_face_ : on_bone_).push_back(p);
    if (p.on == Pick::On::bone) placed_.push_back(p);
  }
}

ControlSample DeskHead::picked(const Snapshot& s, int32_t triangle, const Vec3f& bary) {
  ControlSample c;
  c.kind = pick::landmark;
  const std::string called(name.data());
  c.text = ShortText(called);
  Pick made;
  if (triangle >= 0 && s.topology) {
    const Tri& t = s.topology->view.tri[size_t(triangle)];
    Vec3 X = Vec3::Zero();
    for (size_t k = 0; k < 3; ++k) X += double(bary[Eigen::Index(k)]) * s.topology->view.X_mm[size_t(t[k])];
    const bool face = s.topology->organ_of(size_t(triangle)) == Organ::face;
    c.value = {X.x(), X.y(), X.z(), double(face ? pick::face : pick::bone)};
    made = {called, X, face ? Pick::On::face : Pick::On::bone};
  } else {
    c.value = {0, 0, 0, double(pick::touched)};
    made = {called, Vec3::Zero(), Pick::On::touched};
  }
  // A name has one place.
  std::erase_if(picked_, [&](const Pick& p) { return p.name == called; });
  picked_.push_back(made);
  // M1, M2, ...; after a name of another kind the next number that was not given.
  if (const int number = picked_number(called)) next_ = std::max(next_, number + 1);
  const std::string next = "M" + std::to_string(next_);
  name.fill(0);
  next.copy(name.data(), name.size() - 1);
  return c;
}

std::optional<ControlSample> DeskHead::tied() const {
  if (on_face_.empty() || on_bone_.empty()) return std::nullopt;
  ControlSample c;
  c.kind = pick::tissue;
  c.text = ShortText(on_face_.back().name + "/" + on_bone_.back().name + "/" + kTissueKinds[size_t(mode)]);
  c.value = {double(face_radius_mm), double(bone_radius_mm), double(layers), double(young_kPa)};
  return c;
}

std::string DeskHead::named(size_t last) const {
  const size_t n = placed_.size(), from = n - std::min(n, last);
  std::string s = n == 0 ? std::string() : placed_[from].name;
  if (last > 1 && n > 0) s += (last == 2 ? " - " : " ... ") + placed_.back().name;
  return s;
}

std::vector<ControlSample> DeskHead::asked() const {
  const auto at = [&](size_t back) { return placed_[placed_.size() - 1 - back].X_mm; };
  const auto control = [](int32_t kind, const Vec3& X, double last = 0) {
    ControlSample c;
    c.kind = kind, c.value = {X.x(), X.y(), X.z(), last};
    return c;
  };
  const auto text = [](const char* format, auto... v) {
    char s[96];
    std::snprintf(s, sizeof s, format, double(v)...);
    return ShortText(s);
  };
  // As the panel shows it, to a hundredth: six of them fit into a text.
  const auto shown = [](float v) { return std::round(100 * std::clamp(double(v), -999.99, 999.99)) / 100 + 0.0; };
  const size_t places = placed_.size(), round = size_t(ring);
  const size_t wanted = ask == Ask::saw_round                   ? round
                        : ask == Ask::saw_plane                 ? 3
                        : ask == Ask::plate || ask == Ask::join ? 2
                                                                : 1;
  if (ask == Ask::nothing || places < wanted) return {};
  std::vector<ControlSample> out;
  switch (ask) {
    case Ask::saw_round:
      for (size_t k = 0; k < round; ++k)
        out.push_back(control(pick::corner, at(round - 1 - k), k == 0 ? 0 : k + 1 < round ? 1 : 2));
      break;
    case Ask::saw_plane: {
      const Vec3 n = (at(1) - at(2)).cross(at(0) - at(2)).normalized();
      out.push_back(control(pick::plane, (at(0) + at(1) + at(2)) / 3, double(saw_radius_mm)));
      out.back().text = text("%.9f %.9f %.9f", n.x(), n.y(), n.z());
      break;
    }
    case Ask::shift:
      out.push_back(control(pick::shift, at(0)));
      out.back().text = text("%.5g %.5g %.5g %.5g %.5g %.5g", shown(shift_mm[0]), shown(shift_mm[1]),
                             shown(shift_mm[2]), shown(turn_deg[0]), shown(turn_deg[1]), shown(turn_deg[2]));
      break;
    case Ask::snap:
      out.push_back(control(pick::snap, at(0)));
      break;
    default:
      out.push_back(control(ask == Ask::plate ? pick::plate : pick::join, at(1)));
      out.back().text = text("%.4f %.4f %.4f", at(0).x(), at(0).y(), at(0).z());
      break;
  }
  return out;
}

std::optional<ControlSample> DeskHead::laid_upon() {
  if (beside == told_) return std::nullopt;
  told_ = beside;
  ControlSample c;
  c.kind = pick::beside;
  c.value[0] = double(beside);
  return c;
}

void DeskHead::hear(const std::string& words) {
  for (size_t k = 0; k < std::size(kSkullBesideWords); ++k)
    if (words == kSkullBesideWords[k]) beside = told_ = SkullBeside(k);
}

}  // namespace limberg
