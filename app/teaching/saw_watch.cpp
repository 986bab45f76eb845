#include "app/teaching/saw_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

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

const PlannedAct* sawn_for(const LessonPlan& plan, std::span<const size_t> open, const Vec3& tip) {
  const PlannedAct* best = nullptr;
  double least = kMeant_mm;
  for (const size_t i : open) {
    const auto* act = std::get_if<HeadCommand>(&plan.acts[i].command);
    const auto off = act ? beside_cut(*act, tip) : std::nullopt;
    if (off && off->norm() < least) least = off->norm(), best = &plan.acts[i];
  }
  return best;
}

std::vector<LiveRow> saw_rows(const LessonPlan& plan, const HeadCommand& planned, const SawSeen& saw) {
  std::vector<LiveRow> rows;
  const auto off = beside_cut(planned, saw.tip_mm);
  if (!off) return rows;
  const Words& w = plan.w;
  rows.push_back({w("saw"), w("{:.1f} mm beside", off->norm()), off->norm() / kSawBeside_mm});
  if (const auto n = plane_near(planned, saw.tip_mm)) {
    const double leans = 90 - degrees_between(saw.shaft.normalized(), *n);
    rows.push_back({w("blade"), w("leans by {:.0f}°", leans), leans / kSawLeans_deg});
  }
  double most = 0;
  for (const Vec3& p : saw.sawn_mm)
    if (const auto d = beside_cut(planned, p)) most = std::max(most, d->norm());
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

std::string saw_word(const HeadCommand& planned, const Vec3& tip, const Words& w) {
  const auto off = beside_cut(planned, tip);
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
