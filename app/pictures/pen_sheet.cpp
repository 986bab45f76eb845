#include "app/pictures/pen_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "render/render_scene.h"
#include "sim/geometry/polyline.h"

namespace limberg {

namespace {

constexpr float kTrail_mm = 0.42f, kOverPlan_mm = 0.4f;  // above the line of a plan that is followed
constexpr float kLine_mm = 0.32f, kDot_mm = 0.7f, kOverSkin_mm = 0.1f;
constexpr double kStep_mm = 0.6, kSlack_mm = 0.3, kShort_mm = 2;  // a shorter line is a dot, and no length
const PropLook kInk{{0.11f, 0.02f, 0.28f}, 0, 0}, kTrail{{0.90f, 0.95f, 1.0f}, 0, 0};

bool near(const std::vector<ChartPoint>& line, const std::vector<ChartPoint>& swab, double reach_mm) {
  const auto any = [&](const std::vector<ChartPoint>& points, const std::vector<ChartPoint>& path) {
    for (const ChartPoint& p : points)
      for (size_t i = 0; i < path.size(); ++i)
        if (distance_to_segment(p, path[i > 0 ? i - 1 : 0], path[i]) <= reach_mm) return true;
    return false;
  };
  return any(line, swab) || any(swab, line);
}

std::vector<ChartPoint> finely(const std::vector<ChartPoint>& path) {
  std::vector<ChartPoint> fine{path.front()};
  for (size_t i = 1; i < path.size(); ++i) {
    const int n = std::max(1, int(std::ceil((path[i] - path[i - 1]).norm() / kStep_mm)));
    for (int k = 1; k <= n; ++k) fine.push_back(path[i - 1] + double(k) / n * (path[i] - path[i - 1]));
  }
  return fine;
}

void tube(PropMesh& mesh, const std::vector<Vec3f>& way, const PropLook& look = kInk, float radius_mm = kLine_mm) {
  const std::vector<float> radius(way.size(), radius_mm);
  add_tube(mesh, way, radius, look, 6);
}

/// A stroke of it is a line on what it touches. Scissors are drawn too, but begin at a stitch or an edge.
bool is_drawn(Tool t) {
  return t == Tool::scalpel || t == Tool::scalpel_through || t == Tool::undermine || t == Tool::excise ||
         t == Tool::saw || sews_along(t);
}

}  // namespace

void PenSheet::hear(const Command& command) {
  if (std::holds_alternative<Shown>(command) || std::holds_alternative<Undo>(command) ||
      std::holds_alternative<Redo>(command))
    trail_.clear();  // a row that was begun is given up
  const auto* m = std::get_if<Mark>(&command);
  if (!m || m->path.empty()) return;
  wet_.clear();
  if (m->wipes)
    std::erase_if(lines_, [&](const auto& line) { return near(finely(line), m->path, Mark::kWiped_mm); });
  else
    lines_.push_back(m->path);
}

void PenSheet::trace(const ToolState& hand, const Vec3f& tip) {
  const Tool tool = Tool(hand.tool);
  const bool presses = hand.valid && hand.pressed, draws = presses && is_drawn(tool);
  const bool waits =
      sews_along(Tool(traced_)) && trail_.size() == 1;  // for the second edge, whatever is held meanwhile
  const bool gives_up = presses && (tool == Tool::marker || tool == Tool::swab || tool == Tool::scissors);
  if (draws && !pressed_) {
    if (!waits || !sews_along(tool)) trail_.clear();
    trail_.emplace_back();
    traced_ = hand.tool;
  }
  if (draws && (trail_.back().empty() || (tip - trail_.back().back()).norm() > float(kStep_mm)))
    trail_.back().push_back(tip);
  if (!draws && (!waits || gives_up)) trail_.clear();
  pressed_ = draws;
}

size_t PenSheet::trail() const {
  size_t n = 0;
  for (const std::vector<Vec3f>& way : trail_) n += way.size();
  return n;
}

void PenSheet::follow(const ToolState& hand) {
  const Vec3f tip(float(hand.tip_mm[0]), float(hand.tip_mm[1]), float(hand.tip_mm[2]));
  const Vec3f shaft(float(hand.shaft[0]), float(hand.shaft[1]), float(hand.shaft[2]));
  trace(hand, tip + kOverPlan_mm * shaft);
  if (Tool(hand.tool) != Tool::marker || !hand.valid) return wet_.clear();
  if (hand.pressed && (wet_.empty() || (tip - wet_.back()).norm() > float(kStep_mm))) wet_.push_back(tip);
}

void PenSheet::draw(const Snapshot& s, const Words& w) {
  props_.clear(), lengths_.clear();
  for (const std::vector<Vec3f>& way : trail_)
    if (way.size() > 1) tube(props_, way, kTrail, kTrail_mm);
  if (!has_surface(s) || !s.topology->body) return;
  if (wet_.size() > 1) tube(props_, wet_);
  if (lines_.empty()) return;
  if (!chart_.built_for(s)) chart_.build(*s.topology);
  for (const std::vector<ChartPoint>& line : lines_) {
    std::vector<Vec3f> way;
    Vec3f end = Vec3f::Zero();
    double now_mm = 0;
    bool seen = false;
    for (const ChartPoint& p : finely(line)) {
      const SkinTouch at = chart_.at(s, p, kSlack_mm);
      if (at.triangle < 0) {
        tube(props_, way), way.clear();
        continue;
      }
      const Vec3f x = (at.x_mm + double(kOverSkin_mm) * at.normal).cast<float>();
      if (!way.empty()) now_mm += double((x - way.back()).norm());
      way.push_back(x), end = x, seen = true;
    }
    tube(props_, way);
    const double rest_mm = path_length(line);
    if (seen && rest_mm < kShort_mm)
      add_ellipsoid(props_, end, kDot_mm * Vec3f::UnitX(), kDot_mm * Vec3f::UnitY(), kDot_mm * Vec3f::UnitZ(), kInk, 5);
    else if (seen)
      lengths_.push_back({end, std::abs(now_mm - rest_mm) < 0.05 ? w("{:.1f} mm", now_mm)
                                                                 : w("{:.1f} mm ({:.1f} at rest)", now_mm, rest_mm)});
  }
}

}  // namespace limberg
