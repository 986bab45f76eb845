#include "devices/command_builder.h"

#include <algorithm>

#include "devices/bone_contour.h"
#include "devices/rigid_grip.h"
#include "sim/geometry/polyline.h"

namespace limberg {

namespace {

constexpr double kPiece_mm = 5;     // of a stroke, told at once
constexpr double kBehind_mm = 2.5;  // what lies this near to the hand may still turn out to be a corner

}  // namespace

void CommandBuilder::stop_stroke() { stroke_.clear(); }

std::optional<Command> CommandBuilder::draw_on(const ToolEvent& e) {
  if (path_length(stroke_) < kPiece_mm + kBehind_mm) return {};
  std::vector<ChartPoint> path = simplify_path(stroke_, path_);
  path.front() = stroke_.front();
  double left = path_length(path) - kBehind_mm;
  if (left < kPiece_mm / 2) return {};  // mostly tremor
  InciseMore piece;
  if (!in_pieces_) ++stroke_number_, piece.path.push_back(path.front());
  for (size_t i = 1; i < path.size() && left > 0; ++i) {
    const double edge = (path[i] - path[i - 1]).norm();
    piece.path.push_back(edge <= left ? path[i] : ChartPoint(path[i - 1] + (path[i] - path[i - 1]) * (left / edge)));
    left -= edge;
  }
  in_pieces_ = true;
  // What the hand drew behind the place where the piece ends is told; the rest goes on from there.
  const ChartPoint end = piece.path.back();
  size_t keep = stroke_.size() - 1;
  for (size_t i = stroke_.size() - 1; i > 0; --i)
    if ((stroke_[i] - end).norm() < (stroke_[keep] - end).norm()) keep = i;
  std::vector<ChartPoint> rest{end};
  for (size_t i = keep + 1; i < stroke_.size(); ++i) rest.push_back(stroke_[i]);
  stroke_ = std::move(rest);
  piece.stroke = stroke_number_, piece.depth_mm = e.depth_mm, piece.angle_deg = e.angle_deg;
  return piece;
}

Command CommandBuilder::finish_drawing(const ToolEvent& e, const std::vector<ChartPoint>& drawn) {
  InciseMore piece;
  piece.path = simplify_path(drawn, path_);
  if (piece.path.size() > 1) piece.path.erase(piece.path.begin());
  piece.stroke = stroke_number_, piece.depth_mm = e.depth_mm, piece.angle_deg = e.angle_deg, piece.last = true;
  return piece;
}

Command CommandBuilder::deep_stitch(const Vec3& b_rest_mm, HeldSide side_b) const {
  const Vec3 &a = suture_a_rest_mm_, &b = b_rest_mm;
  return InSpace{Suture{{a.x(), a.y()}, {b.x(), b.y()}, 0, side_a_, side_b}, {a.z(), b.z()}};
}

std::optional<Command> CommandBuilder::feed(const ToolEvent& e) {
  const ChartPoint here(e.chart_x, e.chart_y);
  const Vec3 rest(e.rest_mm[0], e.rest_mm[1], e.rest_mm[2]), world(e.world_mm[0], e.world_mm[1], e.world_mm[2]);
  const Tool tool = Tool(e.tool);
  // Anything but a second stroke along the other edge gives a begun row up; what the program shows has its own edges.
  const auto* shown = e.kind == ToolEvent::told && e.command ? std::get_if<Shown>(e.command.get()) : nullptr;
  const bool of_a_row = sews_along(tool) && e.kind <= ToolEvent::stroke_cancel;
  if (have_row_a_ && !of_a_row &&
      (e.kind == ToolEvent::stroke_begin || e.kind == ToolEvent::undo || e.kind == ToolEvent::redo ||
       (shown && shown->begins))) {
    have_row_a_ = false;
    ++dropped_;
  }
  switch (e.kind) {
    case ToolEvent::stroke_begin:
      bone_stroke_.assign(1, rest);
      stroke_.assign(1, here);
      in_pieces_ = false;
      stroke_begin_ = world;
      return {};
    case ToolEvent::stroke_point:
      if (tool == Tool::saw) bone_stroke_.push_back(rest);
      if (!stroke_.empty()) stroke_.push_back(here);
      if (progressive_ && tool == Tool::scalpel) return draw_on(e);
      return {};
    case ToolEvent::stroke_cancel:
      stroke_.clear();
      return {};
    case ToolEvent::stroke_end: {
      if (tool == Tool::saw) {
        CutBone cut;
        cut.contour_mm = bone_contour(bone_stroke_);
        cut.must_divide = false;  // it may be one of several lines that free a piece together
        stroke_.clear();
        if (cut.contour_mm.empty()) return ++dropped_, std::nullopt;
        return HeadCommand(std::move(cut));
      }
      const Vec3 end = world;
      const std::vector<ChartPoint> drawn = std::move(stroke_);
      stroke_.clear();
      if (in_pieces_ && drawn.empty()) return {};  // it was stopped
      if (in_pieces_) return finish_drawing(e, drawn);
      if (tool == Tool::marker || tool == Tool::swab)
        return Mark{drawn.size() > 1 ? simplify_path(drawn, path_) : drawn, tool == Tool::swab};
      const bool outline = tool == Tool::undermine || tool == Tool::excise;
      std::vector<ChartPoint> path = outline ? simplify_outline(drawn, path_) : simplify_path(drawn, path_);
      if (path.size() < (outline ? 3u : 2u) || path_length(path) < path_.min_edge_mm) {
        ++dropped_;
        return {};
      }
      if (tool == Tool::excise) return Excise{std::move(path), e.depth_mm};
      if (tool == Tool::undermine) return Undermine{std::move(path), e.depth_mm};
      if (tool == Tool::scalpel) return Incise{std::move(path), e.depth_mm, e.angle_deg};
      if (tool == Tool::scissors) return Incise{std::move(path), e.depth_mm, 90};
      if (!sews_along(tool)) return {};
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
      return SutureRow{std::move(row_a_), std::move(path), e.spacing_mm,
                       tool == Tool::suture_row_buried ? e.depth_mm : 0, tool == Tool::suture_running};
    }
    case ToolEvent::hook_set:
      return SetHook{e.id, here};
    case ToolEvent::hook_leave:
      return MoveHook{e.id, world, 0};
    case ToolEvent::hook_release:
      return ReleaseHook{e.id};
    case ToolEvent::suture_a:
      suture_a_ = here, suture_a_rest_mm_ = rest, side_a_ = HeldSide(e.side);
      have_suture_a_ = true, have_tip_ = false;
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
      if (tool == Tool::suture_corner) {
        if (!have_tip_) return ++dropped_, std::nullopt;
        return SutureCorner{suture_tip_, suture_a_, here, e.depth_mm};
      }
      if (tool == Tool::suture_bites) return SutureBite{suture_a_, here};
      if (side_a_ != HeldSide::skin || HeldSide(e.side) != HeldSide::skin) return deep_stitch(rest, HeldSide(e.side));
      return Suture{suture_a_, here, tool == Tool::suture_buried ? e.depth_mm : 0};
    case ToolEvent::suture_tip:
      suture_tip_ = here, have_tip_ = have_suture_a_;
      return {};
    case ToolEvent::suture_knot:
      return TieSuture{};
    case ToolEvent::suture_let_go:
      return LetThreadGo{};
    case ToolEvent::suture_cut:
      return CutSuture{{0, here}};
    case ToolEvent::bone_grab:
      return HeadCommand(GrabFragment{{-1, rest}, e.hand});
    case ToolEvent::bone_drag: {
      Carried c;
      std::copy(std::begin(e.quat), std::end(e.quat), c.quat);
      std::copy(std::begin(e.world_mm), std::end(e.world_mm), c.shift_mm);
      return HeadCommand(DragFragment{as_move(motion_of(c)), 0, e.hand});
    }
    case ToolEvent::bone_release:
      return HeadCommand(LetGo{false, e.hand});
    case ToolEvent::name_place:
      return HeadCommand(PlaceLandmark{e.text.str(), rest, e.id == 1});
    case ToolEvent::told:
      if (!e.command) return {};
      return *e.command;
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
