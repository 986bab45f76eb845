#include "app/window/desk_head.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "devices/pick.h"

namespace limberg {

void DeskHead::draw(const std::vector<HeadMeasure>& measures, bool has_face, float height) {
  ImGui::PushItemWidth(72);
  ImGui::InputText("##name", name.data(), name.size());
  ImGui::PopItemWidth();
  ImGui::SameLine();
  if (ImGui::Button("Pick   K")) pick = true;
  if (on_face_.empty() || on_bone_.empty()) {
    if (has_face) ImGui::TextDisabled("tissue: pick on face and on bone");
  } else {
    ImGui::PushItemWidth(72);
    ImGui::SliderFloat("on the face, mm", &face_radius_mm, 8, 80, "%.0f");
    ImGui::SliderFloat("on bone, mm", &bone_radius_mm, 0, 120, bone_radius_mm > 0 ? "%.0f" : "all of it");
    ImGui::SliderInt("layers", &layers, 1, 6);
    ImGui::SliderFloat("kPa", &young_kPa, 1, 60, "%.0f");
    ImGui::PopItemWidth();
    ImGui::PushItemWidth(-1);
    ImGui::Combo("##mode", &mode, "Smoothing: the face does not feel it\0Springs\0Shape\0Finite elements\0");
    ImGui::PopItemWidth();
    if (ImGui::Button(("Tissue " + on_face_ + " - " + on_bone_).c_str())) tie = true;
  }
  int with = int(beside);
  ImGui::PushItemWidth(-1);
  if (ImGui::Combo("##beside", &with, "The skull alone\0Beside a normal skull\0Beside its mirror image\0")) beside = SkullBeside(with);
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

ControlSample DeskHead::picked(const Snapshot& s, int32_t triangle, const Vec3f& bary) {
  ControlSample c;
  c.kind = pick::landmark;
  const std::string called(name.data());
  c.text = ShortText(called);
  if (triangle >= 0 && s.topology) {
    const Tri& t = s.topology->view.tri[size_t(triangle)];
    Vec3 X = Vec3::Zero();
    for (size_t k = 0; k < 3; ++k) X += double(bary[Eigen::Index(k)]) * s.topology->view.X_mm[size_t(t[k])];
    const bool face = s.topology->organ_of(size_t(triangle)) == Organ::face;
    c.value = {X.x(), X.y(), X.z(), double(face ? pick::face : pick::bone)};
    (face ? on_face_ : on_bone_) = called;
  } else {
    c.value = {0, 0, 0, double(pick::touched)};
    on_bone_ = called;
  }
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
  c.text = ShortText(on_face_ + "/" + on_bone_ + "/" + kTissueKinds[size_t(mode)]);
  c.value = {double(face_radius_mm), double(bone_radius_mm), double(layers), double(young_kPa)};
  return c;
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
