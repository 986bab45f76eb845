#include "app/pictures/pen_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "render/render_scene.h"

namespace limberg {

namespace {

constexpr float kTrail_mm = 0.42f, kOverPlan_mm = 0.4f;  // above the line of a plan that is followed
constexpr float kLine_mm = 0.32f, kDot_mm = 0.7f, kOverSkin_mm = 0.1f;
constexpr double kStep_mm = 0.6, kShort_mm = 2;  // a shorter line is a dot, and no length
const PropLook kInk{{0.11f, 0.02f, 0.28f}, 0, 0}, kTrail{{0.90f, 0.95f, 1.0f}, 0, 0};

/// Whether a line and a swab's way come within `reach_mm` of one another, at rest.
bool near(const std::vector<SkinTouch>& line, const std::vector<SkinTouch>& swab, double reach_mm) {
  for (const SkinTouch& p : line)
    for (const SkinTouch& q : swab)
      if (p.triangle >= 0 && q.triangle >= 0 && (p.X_mm - q.X_mm).norm() <= reach_mm) return true;
  return false;
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
  auto line = skin_line(command);
  if (!line) return;
  wet_.clear();
  heard_.push_back(*std::move(line));
}

void PenSheet::lay(const Snapshot& s) {
  if (!chart_.built_for(s)) {
    chart_.build(*s.topology);
    for (Line& line : lines_) line.at = laid_on_skin(s, chart_, line.drawn);
  }
  for (SkinLine& drawn : heard_) {
    std::vector<SkinTouch> at = laid_on_skin(s, chart_, drawn);
    if (drawn.wipes)
      std::erase_if(lines_, [&](const Line& line) { return near(line.at, at, Mark::kWiped_mm); });
    else
      lines_.push_back({std::move(drawn), std::move(at)});
  }
  heard_.clear();
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
  if (lines_.empty() && heard_.empty()) return;
  lay(s);
  for (const Line& line : lines_) {
    std::vector<Vec3f> way;
    Vec3f end = Vec3f::Zero();
    Vec3 before = Vec3::Zero();
    double now_mm = 0, rest_mm = 0;
    bool seen = false;
    for (const SkinTouch& laid : line.at) {
      if (laid.triangle < 0) {
        tube(props_, way), way.clear();
        continue;
      }
      const SkinTouch at = touch_at(s, laid.triangle, laid.bary, 0);
      const Vec3f x = (at.x_mm + double(kOverSkin_mm) * at.normal).cast<float>();
      if (!way.empty()) now_mm += double((x - way.back()).norm()), rest_mm += (at.X_mm - before).norm();
      way.push_back(x), end = x, before = at.X_mm, seen = true;
    }
    tube(props_, way);
    if (seen && rest_mm < kShort_mm)
      add_ellipsoid(props_, end, kDot_mm * Vec3f::UnitX(), kDot_mm * Vec3f::UnitY(), kDot_mm * Vec3f::UnitZ(), kInk, 5);
    else if (seen)
      lengths_.push_back({end, std::abs(now_mm - rest_mm) < 0.05 ? w("{:.1f} mm", now_mm)
                                                                 : w("{:.1f} mm ({:.1f} at rest)", now_mm, rest_mm)});
  }
}

}  // namespace limberg
