#include "devices/command_builder.h"

#include <algorithm>

namespace limberg {

namespace {

double length_of(const std::vector<ChartPoint>& path) {
  double sum = 0;
  for (size_t i = 1; i < path.size(); ++i) sum += (path[i] - path[i - 1]).norm();
  return sum;
}

}  // namespace

std::optional<Command> CommandBuilder::feed(const ToolEvent& e) {
  const ChartPoint here(e.chart_x, e.chart_y);
  const Tool tool = Tool(e.tool);
  // Anything but a second stroke along the other edge gives a begun row up.
  const bool of_a_row = tool == Tool::suture_row && e.kind <= ToolEvent::stroke_cancel;
  if (have_row_a_ && !of_a_row && (e.kind == ToolEvent::stroke_begin || e.kind == ToolEvent::undo || e.kind == ToolEvent::redo)) {
    have_row_a_ = false;
    ++dropped_;
  }
  switch (e.kind) {
    case ToolEvent::stroke_begin:
      stroke_.assign(1, here);
      stroke_begin_ = Vec3(e.world_mm[0], e.world_mm[1], e.world_mm[2]);
      return {};
    case ToolEvent::stroke_point:
      if (!stroke_.empty()) stroke_.push_back(here);
      return {};
    case ToolEvent::stroke_cancel:
      stroke_.clear();
      return {};
    case ToolEvent::stroke_end: {
      const Vec3 end(e.world_mm[0], e.world_mm[1], e.world_mm[2]);
      const std::vector<ChartPoint> drawn = std::move(stroke_);
      stroke_.clear();
      const bool outline = tool == Tool::undermine || tool == Tool::excise;
      std::vector<ChartPoint> path = outline ? simplify_outline(drawn, path_) : simplify_path(drawn, path_);
      if (path.size() < (outline ? 3u : 2u) || length_of(path) < path_.min_edge_mm) {
        ++dropped_;
        return {};
      }
      if (tool == Tool::excise) return Excise{std::move(path), e.depth_mm};
      if (tool == Tool::undermine) return Undermine{std::move(path), e.depth_mm};
      if (tool == Tool::scalpel) return Incise{std::move(path), e.depth_mm, e.angle_deg};
      if (tool != Tool::suture_row) return {};
      if (!have_row_a_) {
        row_a_ = std::move(path);
        row_a_ends_ = {stroke_begin_, end};
        have_row_a_ = true;
        return {};
      }
      have_row_a_ = false;
      // Both edges are meant to be drawn the same way. The second is turned only when it was plainly drawn the other
      // way, seen on the patient as it lies: at rest a flap's edge and the edge it is sewn to may lie anyhow.
      const double same = (row_a_ends_[0] - stroke_begin_).norm() + (row_a_ends_[1] - end).norm();
      const double crossed = (row_a_ends_[0] - end).norm() + (row_a_ends_[1] - stroke_begin_).norm();
      if (crossed < 0.5 * same) std::reverse(path.begin(), path.end());
      return SutureRow{std::move(row_a_), std::move(path), e.spacing_mm};
    }
    case ToolEvent::hook_set:
      return SetHook{e.id, here};
    case ToolEvent::hook_leave:
      return MoveHook{e.id, Vec3(e.world_mm[0], e.world_mm[1], e.world_mm[2]), 0};
    case ToolEvent::hook_release:
      return ReleaseHook{e.id};
    case ToolEvent::suture_a:
      suture_a_ = here;
      have_suture_a_ = true;
      return {};
    case ToolEvent::suture_cancel:
      have_suture_a_ = false;
      return {};
    case ToolEvent::suture_b:
      if (!have_suture_a_) {
        ++dropped_;
        return {};
      }
      have_suture_a_ = false;
      return Suture{suture_a_, here};
    case ToolEvent::undo:
      return Undo{};
    case ToolEvent::redo:
      return Redo{};
    case ToolEvent::stage:
      return Stage{e.text.str()};
    default:
      return {};
  }
}

}  // namespace limberg
