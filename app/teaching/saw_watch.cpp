#include "app/teaching/saw_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "sim/base/elementary.h"

namespace limberg {
namespace {

constexpr double kMeant_mm = 40;  // a saw that is farther from a planned cut is not meant for it

double degrees_between(const Vec3& a, const Vec3& b) {  // of lines: 0 to 90
  return std::abs(elementary::atan2(a.cross(b).norm(), std::abs(a.dot(b)))) * 180 / std::numbers::pi;
}

}  // namespace

std::optional<Vec3> plane_near(const HeadCommand& planned, const Vec3& p) {
  const std::vector<SawPlane> planes = planes_of(planned);
  const SawPlane* k = nearest_plane(planes, p);
  return k ? std::optional<Vec3>(k->normal) : std::nullopt;
}

int32_t bone_meant(const SurfaceTopology& s, const HeadCommand& cut) {
  const auto* c = std::get_if<CutBone>(&cut);
  const auto* blade = std::get_if<CutBoneByBlade>(&cut);
  if (!c && !blade) return -1;
  const std::optional<FragmentPick>& of = c ? c->of : blade->of;
  const Vec3 at = of ? of->at_mm : blade ? blade->corner_mm : c->contour_mm.empty() ? c->point_mm : c->contour_mm[0];
  int32_t best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (size_t t = 0; t < s.view.tri.size(); ++t) {
    if (t >= s.object.size() || !s.is_ground(t, Ground::bone)) continue;
    const Tri& k = s.view.tri[t];
    const Vec3 middle = (s.view.X_mm[size_t(k[0])] + s.view.X_mm[size_t(k[1])] + s.view.X_mm[size_t(k[2])]) / 3;
    if (const double d = (middle - at).squaredNorm(); d < least) least = d, best = s.object[t];
  }
  return best;
}

std::vector<Vec3> line_on_bone(const SurfaceTopology& s, const HeadCommand& cut) {
  constexpr double kApart_mm = 1;
  std::vector<Vec3> line;
  std::set<std::array<int, 3>> taken;
  const auto add = [&](const Vec3& a, const Vec3& b) {
    const int steps = std::max(1, int(std::ceil((b - a).norm() / kApart_mm)));
    for (int k = 0; k < steps; ++k) {
      const Vec3 p = a + (b - a) * ((k + 0.5) / steps);
      const Vec3 cell = (p / kApart_mm).array().floor();
      if (taken.insert({int(cell.x()), int(cell.y()), int(cell.z())}).second) line.push_back(p);
    }
  };
  if (const auto* c = std::get_if<CutBone>(&cut); c && !c->contour_mm.empty()) {
    for (size_t i = 0; i < c->contour_mm.size(); ++i)
      add(c->contour_mm[i], c->contour_mm[(i + 1) % c->contour_mm.size()]);
    return line;
  }
  std::vector<SawPlane> planes = planes_of(cut);
  for (SawPlane& p : planes)
    if (p.u.isZero(0)) p.reach = 0;  // its reach chooses lines, and ends none
  const int32_t bone = planes.empty() ? -1 : bone_meant(s, cut);
  for (size_t t = 0; bone >= 0 && t < s.view.tri.size(); ++t) {
    if (t >= s.object.size() || s.object[t] != bone || !s.is_ground(t, Ground::bone)) continue;
    std::array<Vec3, 3> x;
    for (size_t k = 0; k < 3; ++k) x[k] = s.view.X_mm[size_t(s.view.tri[t][k])];
    for (const SawPlane& plane : planes)
      if (const auto on = plane.through(x); on && plane.reaches(0.5 * (on->first + on->second)))
        add(on->first, on->second);
  }
  return line;
}

void find_lines_on_bone(LessonPlan& plan, const SurfaceTopology& s) {
  for (PlannedAct& a : plan.acts)
    if (const auto* bone = std::get_if<HeadCommand>(&a.command)) a.on_bone_mm = line_on_bone(s, *bone);
}

std::optional<Vec3> beside_line(const PlannedAct& planned, const Vec3& p) {
  const auto* cut = std::get_if<HeadCommand>(&planned.command);
  if (!cut) return std::nullopt;
  const auto* ring = std::get_if<CutBone>(cut);
  if (planned.on_bone_mm.empty() || (ring && !ring->contour_mm.empty())) return beside_cut(*cut, p);
  constexpr double kNear_mm = 25;  // nearer than this its plane says best where to lead the saw
  const Vec3 near =
      *std::min_element(planned.on_bone_mm.begin(), planned.on_bone_mm.end(),
                        [&](const Vec3& a, const Vec3& b) { return (a - p).squaredNorm() < (b - p).squaredNorm(); });
  HeadCommand whole = *cut;
  if (auto* plane = std::get_if<CutBone>(&whole)) plane->radius_mm = 0;  // it chooses lines, and ends none
  const auto off = beside_cut(whole, p);
  return off && (p - near).norm() < kNear_mm ? off : Vec3(p - near);
}

const PlannedAct* sawn_for(const LessonPlan& plan, std::span<const size_t> open, const Vec3& tip) {
  const PlannedAct* best = nullptr;
  double least = kMeant_mm;
  for (const size_t i : open) {
    const auto* act = std::get_if<HeadCommand>(&plan.acts[i].command);
    const auto off = act ? beside_line(plan.acts[i], tip) : std::nullopt;
    if (off && off->norm() < least) least = off->norm(), best = &plan.acts[i];
  }
  return best;
}

std::vector<LiveRow> saw_rows(const LessonPlan& plan, const PlannedAct& planned, const SawSeen& saw) {
  std::vector<LiveRow> rows;
  const auto off = beside_line(planned, saw.tip_mm);
  if (!off) return rows;
  const Words& w = plan.w;
  rows.push_back({w("saw"), w("{:.1f} mm beside", off->norm()), off->norm() / kSawBeside_mm});
  if (const auto n = plane_near(std::get<HeadCommand>(planned.command), saw.tip_mm)) {
    const double leans = 90 - degrees_between(saw.shaft.normalized(), *n);
    rows.push_back({w("blade"), w("leans by {:.0f}°", leans), leans / kSawLeans_deg});
  }
  double most = 0;
  for (const Vec3& p : saw.sawn_mm)
    if (const auto d = beside_line(planned, p)) most = std::max(most, d->norm());
  if (saw.sawn_mm.size() > 1) rows.push_back({w("line"), w("{:.1f} mm at most", most), most / kSawBeside_mm});
  for (const SafeLimit& l : plan.limits) {
    if (l.bone_line.empty()) continue;
    double near = 1e9;
    for (size_t i = 0; i + 1 < l.bone_line.size(); ++i) {
      const Vec3 &a = l.bone_line[i], e = l.bone_line[i + 1] - a;
      const double t = std::clamp((saw.tip_mm - a).dot(e) / std::max(1e-12, e.squaredNorm()), 0.0, 1.0);
      near = std::min(near, (saw.tip_mm - a - t * e).norm());
    }
    rows.push_back({w("limit"), w("{:.0f} mm away", near), l.nearest_mm / std::max(near, 0.1)});
  }
  return rows;
}

std::string saw_word(const PlannedAct& planned, const Vec3& tip, const Words& w) {
  const auto off = beside_line(planned, tip);
  if (!off || off->norm() <= kSawBeside_mm) return "";
  Eigen::Index axis = 0;
  off->cwiseAbs().maxCoeff(&axis);
  const bool high = (*off)[axis] > 0;
  const double mm = off->norm();
  if (axis == 0)
    return high ? w("The saw is {:.0f} mm to the right of the line that is drawn: lead it to the left.", mm)
                : w("The saw is {:.0f} mm to the left of the line that is drawn: lead it to the right.", mm);
  if (axis == 1)
    return high ? w("The saw is {:.0f} mm before the line that is drawn: lead it back.", mm)
                : w("The saw is {:.0f} mm behind the line that is drawn: lead it forwards.", mm);
  return high ? w("The saw is {:.0f} mm above the line that is drawn: lead it down.", mm)
              : w("The saw is {:.0f} mm below the line that is drawn: lead it up.", mm);
}

std::vector<LiveRow> plane_rows(const HeadCommand& planned, const std::array<Vec3, 3>& picked, const Words& w) {
  const Vec3 n = (picked[1] - picked[0]).cross(picked[2] - picked[0]), mid = (picked[0] + picked[1] + picked[2]) / 3;
  if (n.norm() < 1e-6) return {{w("plane"), w("the three places lie in one line"), 2}};
  const auto off = beside_cut(planned, mid);
  const auto wanted = plane_near(planned, mid);
  if (!off || !wanted) return {};
  const double leans = degrees_between(n.normalized(), *wanted);
  return {{w("plane"), w("{:.1f} mm beside", off->norm()), off->norm() / kSawBeside_mm},
          {w("leans"), w("{:.0f}° off", leans), leans / kSawLeans_deg}};
}

std::optional<Offs> plane_against(const HeadCommand& want, const HeadCommand& got, const Words& w) {
  const std::vector<SawPlane> planned = planes_of(want), sawn = planes_of(got);
  if (planned.empty() || sawn.empty()) return std::nullopt;
  // Each plane that was sawn against the planned one that it lies along best.
  double most_mm = 0, most_deg = 0;
  for (const SawPlane& s : sawn) {
    const SawPlane* best = &planned[0];
    for (const SawPlane& k : planned)
      if (degrees_between(k.normal, s.normal) < degrees_between(best->normal, s.normal)) best = &k;
    most_deg = std::max(most_deg, degrees_between(best->normal, s.normal));
    most_mm = std::max(most_mm, std::abs((best->at - s.at).dot(s.normal)));
  }
  if (most_mm > kMeant_mm || most_deg > 60) return std::nullopt;
  return Offs{
      {Off::line, most_mm, kSawBeside_mm, w("the plane lies {:.1f} mm beside the one that is drawn", most_mm)},
      {Off::angle, most_deg, kSawLeans_deg, w("the plane leans by {:.0f}° from the one that is drawn", most_deg)}};
}

}  // namespace limberg
