#include "app/assembly/bone_lesson.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "app/assembly/cut_distance.h"
#include "sim/commands/authorship.h"
#include "sim/geometry/rotation.h"
#include "sim/imaging/register/superposition.h"
#include "sim/measure/cephalometry.h"

namespace limberg {
namespace {

/// A landmark on bone: where it lay at first and lies now, and on which fragment.
struct Place {
  Vec3 first_mm = Vec3::Zero(), now_mm = Vec3::Zero();
  int32_t fragment = -1;
};
using Places = std::map<std::string, Place>;

Places places_of(const Head& head) {
  Places all;
  for (const HeadLandmark& l : head.first_landmarks())
    if (!l.on_face) all[l.name].first_mm = l.X_mm;
  for (const HeadLandmark& l : head.landmarks())
    if (const auto it = all.find(l.name); it != all.end() && !l.on_face)
      it->second.now_mm = head.landmark_mm(l), it->second.fragment = l.fragment;
  return all;
}

bool in_the_middle(const std::string& name) { return !name.ends_with("_R") && !name.ends_with("_L"); }

Vec3 middle(const std::vector<std::string>& names, const Places& at) {
  Vec3 sum = Vec3::Zero();
  for (const std::string& n : names) sum += at.at(n).first_mm;
  return sum / double(names.size());
}

/// Keeps the largest of a name, and where it was.
void largest(LessonValues& v, const char* name, double value, const std::string& place) {
  const auto it = v.value.find(name);
  if (it != v.value.end() && it->second >= value) return;
  v.value[name] = value, v.place[name] = place;
}

void count_wrong(LessonValues& v, const BonePlan& plan, const Head& head, const Places& at) {
  std::vector<std::string> wrong;
  for (const PlannedPiece& p : plan.pieces) {
    std::map<int32_t, int> on;
    for (const std::string& n : p.holds) ++on[at.at(n).fragment];
    const int32_t most =
        std::max_element(on.begin(), on.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
    for (const std::string& n : p.holds)
      if (at.at(n).fragment != most) wrong.push_back(n + " does not lie on the " + p.name);
    for (const std::string& n : p.apart_from)
      if (at.at(n).fragment == most) wrong.push_back(n + " lies on the " + p.name);
  }
  const auto have = int(head.bones().fragments().size());
  double count = double(wrong.size());
  if (plan.fragments && have != *plan.fragments) {
    count += std::abs(have - *plan.fragments);
    wrong.push_back(fmt::format("{} fragments where {} were expected", have, *plan.fragments));
  }
  v.value["pieces_wrong"] = count, v.place["pieces_wrong"] = fmt::format("{}", fmt::join(wrong, "; "));
}

void follow_piece(LessonValues& v, const PlannedPiece& p, const Places& at, const Asymmetry& symmetry) {
  RigidMove move = p.move;
  move.about_mm = middle(p.about.empty() ? p.holds : p.about, at);
  const Eigen::Isometry3d meant = isometry(move, *move.about_mm);
  std::vector<Vec3> first, now;
  Vec3 off = Vec3::Zero();
  for (const std::string& n : p.holds) {
    const Place& x = at.at(n);
    const Vec3 d = x.now_mm - meant * x.first_mm;
    largest(v, "piece_mm", d.norm(), n);
    off += d / double(p.holds.size());
    first.push_back(x.first_mm), now.push_back(x.now_mm);
    if (in_the_middle(n)) largest(v, "midline_mm", std::abs(symmetry.normal.dot(x.now_mm - symmetry.point_mm)), n);
  }
  largest(v, "sideways_mm", std::abs(off.x()), p.name + (off.x() < 0 ? ", left" : ", right"));
  largest(v, "forwards_mm", std::abs(off.y()), p.name + (off.y() < 0 ? ", too little" : ", too much"));
  largest(v, "upwards_mm", std::abs(off.z()), p.name + (off.z() < 0 ? ", low" : ", high"));
  if (const LandmarkFit fit = fit_landmarks(first, now, false))
    largest(v, "piece_deg", axis_angle(fit.map.R * meant.linear().transpose()).angle * kDeg, p.name);
  else
    v.why_not["piece_deg"] = "three landmarks of the " + p.name + " that are not on one line were looked for";
}

void look_at_cuts(LessonValues& v, const BonePlan& plan, const Head& head, const Places& at) {
  const auto named = [&](const bone::Gap& g) {
    return head.bones().fragment(g.a)->name + " and " + head.bones().fragment(g.b)->name;
  };
  v.value["osteotomy_overlap_mm"] = 0;
  for (const bone::Gap& g : head.bones().gaps())
    for (const PlannedPiece& p : plan.pieces) {
      const int32_t id = at.at(p.holds.front()).fragment;
      if (g.a != id && g.b != id) continue;
      largest(v, "osteotomy_gap_mm", g.gap_mean_mm, named(g));
      largest(v, "osteotomy_overlap_mm", g.overlap_max_mm, named(g));
    }
  if (!v.value.count("osteotomy_gap_mm")) v.why_not["osteotomy_gap_mm"] = "a cut was looked for; nothing was cut";
}

void look_at_limits(LessonValues& v, std::span<const Command> done, std::span<const SafeLimit> limits) {
  v.value["too_near_mm"] = 0;
  for (const StandingAct& a : standing_acts(done))
    for (const SafeLimit& l : limits)
      if (const auto* h = std::get_if<HeadCommand>(&a.command))
        if (const auto near = nearest_to_limit_mm(l, *h))
          largest(v, "too_near_mm", std::max(0.0, l.nearest_mm - *near),
                  fmt::format("{} {:.1f} mm away", l.name, *near));
}

void compare_figures(LessonValues& v, const BonePlan& plan, const Head& head) {
  std::vector<NamedPoint> points;
  for (const auto& [name, x] : head.landmarks_now()) points.push_back({name, x, 0});
  const std::vector<CephalometricRow> rows = cephalometry(points);
  for (const auto& [name, wanted] : plan.cephalometry)
    for (const CephalometricRow& r : rows) {
      if (r.measure->name != name) continue;
      const std::string tolerance = "cephalometry_" + r.measure->unit;
      if (r.value)
        largest(v, tolerance.c_str(), std::abs(*r.value - wanted),
                fmt::format("{} {:.2f} {}, {:g} was planned", name, *r.value, r.measure->unit, wanted));
      else
        v.why_not[tolerance] = name + " is not defined here: landmarks are missing";
    }
}

/// Those of the plan that were placed anew by what was done.
std::vector<std::string> placed_anew(std::span<const Command> done) {
  std::vector<std::string> all;
  for (const Command& c : done)
    if (const auto* h = std::get_if<HeadCommand>(&c))
      if (const auto* p = std::get_if<PlaceLandmark>(h)) all.push_back(p->name);
  return all;
}

std::set<std::string> names_of(const BonePlan& plan) {
  std::set<std::string> all(plan.stays.begin(), plan.stays.end());
  for (const PlannedPiece& p : plan.pieces)
    for (const auto* list : {&p.holds, &p.apart_from, &p.about}) all.insert(list->begin(), list->end());
  return all;
}

}  // namespace

std::string plan_lacks(const BonePlan& plan, std::span<const HeadLandmark> landmarks) {
  std::string missing;
  const auto lacks = [&](const std::string& what) { missing += (missing.empty() ? "" : ", ") + what; };
  for (const std::string& n : names_of(plan))
    if (std::none_of(landmarks.begin(), landmarks.end(),
                     [&](const HeadLandmark& l) { return l.name == n && !l.on_face; }))
      lacks("landmark " + n + " on bone");
  std::vector<NamedPoint> points;
  for (const HeadLandmark& l : landmarks) points.push_back({l.name, l.X_mm, 0});
  const std::vector<CephalometricRow> rows = cephalometry(points);
  for (const auto& [name, wanted] : plan.cephalometry)
    if (std::none_of(rows.begin(), rows.end(),
                     [&, n = name](const CephalometricRow& r) { return r.measure->name == n && r.value; }))
      lacks("figure " + name);
  return missing;
}

LessonValues bone_values(const BonePlan& plan, const Head& head, const std::optional<BoneOutside>& outside,
                         std::span<const Command> done, std::span<const SafeLimit> limits) {
  LessonValues v;
  const std::set<std::string> names = names_of(plan);
  for (const std::string& n : placed_anew(done))
    if (names.count(n)) {
      for (const char* all : {"pieces_wrong", "piece_mm", "piece_deg", "sideways_mm", "forwards_mm", "upwards_mm",
                              "stays_mm", "midline_mm", "osteotomy_gap_mm", "osteotomy_overlap_mm", "cephalometry_mm",
                              "cephalometry_deg", "bone_outside_mm"})
        v.why_not[all] = "the landmark " + n + " was looked for where the scene has it; the operation placed it anew";
      return v;
    }
  const Places at = places_of(head);
  std::vector<NamedPoint> first;
  for (const auto& [name, x] : at) first.push_back({name, x.first_mm, 0});
  const Asymmetry symmetry = asymmetry(first);
  count_wrong(v, plan, head, at);
  for (const PlannedPiece& p : plan.pieces) follow_piece(v, p, at, symmetry);
  for (const std::string& n : plan.stays) largest(v, "stays_mm", (at.at(n).now_mm - at.at(n).first_mm).norm(), n);
  look_at_cuts(v, plan, head, at);
  look_at_limits(v, done, limits);
  compare_figures(v, plan, head);
  if (outside)
    v.value["bone_outside_mm"] = outside->depth_mm;
  else
    v.why_not["bone_outside_mm"] = "a face over the bones was looked for; there is none";
  for (const auto& [name, why] : v.why_not) v.value.erase(name);  // of another piece, say
  return v;
}

}  // namespace limberg
