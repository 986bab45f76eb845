#include "devices/old_controls.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <optional>

namespace limberg {

namespace {

std::shared_ptr<const Command> head_act(HeadCommand c) { return std::make_shared<const Command>(std::move(c)); }

/// The first numbers of a text; nothing when there are fewer.
std::vector<double> numbers_in(const ShortText& text, size_t wanted) {
  std::vector<double> out;
  const std::string all = text.str();
  for (const char* at = all.c_str(); out.size() < wanted;) {
    char* end = nullptr;
    const double v = std::strtod(at, &end);
    if (end == at || !std::isfinite(v)) return {};
    out.push_back(v), at = end;
  }
  return out;
}

std::optional<ConnectTissue> tissue_of(const ControlSample& c, const Snapshot& s) {
  std::string names = c.text.str();
  ConnectTissue t;
  const size_t cut = std::min(names.find('/'), names.size());
  if (const size_t second = names.find('/', std::min(cut + 1, names.size())); second != std::string::npos) {
    const auto* const known = std::find(std::begin(kTissueKinds), std::end(kTissueKinds), names.substr(second + 1));
    if (known == std::end(kTissueKinds)) return {};
    t.mode = TissueKind(known - std::begin(kTissueKinds)), names.resize(second);
  }
  const auto place = [&](const std::string& name, Vec3& to) {
    if (!s.topology) return false;
    const auto& all = s.topology->landmark;
    const size_t k = size_t(std::find(all.begin(), all.end(), name) - all.begin());
    if (k < s.landmark_mm.size()) to = s.landmark_mm[k].cast<double>();
    return k < s.landmark_mm.size();
  };
  if (cut == names.size() || !place(names.substr(0, cut), t.face_mm) || !place(names.substr(cut + 1), t.bone_mm))
    return {};
  t.name = names.substr(0, cut) + "-" + names.substr(cut + 1);
  t.face_radius_mm = c.value[0], t.bone_radius_mm = c.value[1];
  t.layers = int(std::clamp(c.value[2], 0.0, 99.0)), t.young_kPa = c.value[3];
  return t;
}

}  // namespace

OldControls::Told OldControls::read(const ControlSample& c, const Snapshot& s) {
  Told told;
  const Vec3 at(c.value[0], c.value[1], c.value[2]);
  const FragmentPick fragment{-1, at};
  const auto say = [&](HeadCommand command) { told.understood = true, told.events.push_back(head_act(command)); };
  told.stops_hand = c.kind >= shift;
  switch (c.kind) {
    case landmark:
      say(PlaceLandmark{c.text.str(), at, c.value[3] >= 2});
      break;
    case tissue:
      if (const auto t = tissue_of(c, s)) say(*t);
      break;
    case beside:
      say(Superpose{SkullBeside(int(std::clamp(c.value[0], 0.0, double(std::size(kSkullBeside) - 1)))), c.text.str()});
      break;
    case shift:
      if (const auto n = numbers_in(c.text, 6); !n.empty()) {
        RigidMove by;
        by.translation_mm = {n[0], n[1], n[2]}, by.rotation_deg = {n[3], n[4], n[5]};
        say(MoveFragment{fragment, by, 0});
      }
      break;
    case snap:
      say(GrabFragment{fragment, 0});
      say(LetGo{true, 0});
      break;
    case corner:
      if (c.value[3] < 1) corners_.clear();
      corners_.push_back(at);
      told.understood = true;
      if (c.value[3] < 2) {
        told.events.emplace_back();
      } else {
        CutBone cut;
        cut.contour_mm = std::move(corners_);
        corners_.clear();
        say(std::move(cut));
      }
      break;
    case plane:
      if (const auto n = numbers_in(c.text, 3); !n.empty()) {
        CutBone cut;
        cut.point_mm = at, cut.normal = {n[0], n[1], n[2]}, cut.radius_mm = std::max(0.0, c.value[3]);
        say(std::move(cut));
      }
      break;
    case plate:
      if (const auto n = numbers_in(c.text, 3); !n.empty()) say(PlateFragments{at, Vec3(n[0], n[1], n[2])});
      break;
    case join:
      if (const auto n = numbers_in(c.text, 3); !n.empty())
        say(JoinFragments{fragment, FragmentPick{-1, Vec3(n[0], n[1], n[2])}});
      break;
    default:
      break;
  }
  return told;
}

}  // namespace limberg
