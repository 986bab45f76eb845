#include "devices/command_builder.h"

#include <algorithm>

#include "devices/bone_contour.h"
#include "devices/rigid_grip.h"
#include "sim/geometry/polyline.h"

namespace limberg {

namespace {

constexpr double kPiece_mm = 5;          // of a stroke, told at once
constexpr double kBehind_mm = 2.5;       // what lies this near to the hand may still turn out to be a corner
constexpr double kShortestRow_mm = 0.3;  // of an edge that is sewn: in the point of a V two stitches lie that near
constexpr double kBlade_mm = 2;  // of a cut right through, the blade's direction is the mean over so far each way

/// The act at these places in space, which are as many as it has.
Command in_space(SkinAct act, std::span<const Vec3> places) {
  InSpace c{std::move(act), {}};
  std::vector<ChartPoint> flat;
  for (const Vec3& X : places) flat.emplace_back(X.x(), X.y()), c.z_mm.push_back(X.z());
  c.act = with_points(c, flat);
  return c;
}

/// `act`, where its places on the chart say enough, else the same act at `places`.
template <class A>
Command placed(A act, std::span<const Vec3> places, bool on_chart) {
  return on_chart ? Command(std::move(act)) : in_space(SkinAct(std::move(act)), places);
}

/// Their mean, but for what looks far away from it: a lip's skin rolls over into its margin.
Vec3 mean_direction(std::span<const Vec3> out) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& n : out) mean += n;
  if (!(mean.norm() > 1e-9)) return out.front();
  Vec3 most = Vec3::Zero();
  for (const Vec3& n : out)
    if (n.dot(mean.normalized()) >= 0.5) most += n;
  return (most.norm() > 1e-9 ? most : mean).normalized();
}

}  // namespace

double CommandBuilder::Way::length_mm() const { return X_mm.empty() ? path_length(chart) : path_length(X_mm); }

bool CommandBuilder::on_chart(const Drawn& d) const {
  for (size_t i = 0; i < d.chart.size(); ++i)
    if (!means(d.chart[i], d.X_mm[i])) return false;
  return true;
}

CommandBuilder::Way CommandBuilder::meant(const Drawn& d, bool outline, bool in_space) const {
  if (in_space) {
    std::vector<Vec3> X = simplify_in_space(d.X_mm, d.out, outline, path_);
    return {std::vector<ChartPoint>(X.size(), ChartPoint(0, 0)), std::move(X)};
  }
  return {outline ? simplify_outline(d.chart, path_) : simplify_path(d.chart, path_), {}};
}

// Both edges are meant to be drawn the same way. The second is turned only when it was plainly drawn the other way,
// seen on the patient as it lies: at rest a flap's edge and the edge it is sewn to may lie anyhow.
std::optional<Command> CommandBuilder::row_with(Drawn b, const ToolEvent& e) {
  const Vec3 end(e.world_mm[0], e.world_mm[1], e.world_mm[2]);
  if (!have_row_a_) {
    row_a_ = std::move(b);
    row_a_ends_ = {stroke_begin_, end};
    have_row_a_ = true;
    return {};
  }
  have_row_a_ = false;
  const double same = (row_a_ends_[0] - stroke_begin_).norm() + (row_a_ends_[1] - end).norm();
  const double crossed = (row_a_ends_[0] - end).norm() + (row_a_ends_[1] - stroke_begin_).norm();
  const bool off = !on_chart(row_a_) || !on_chart(b);
  Way ways[2] = {meant(row_a_, false, off), meant(b, false, off)};
  if (crossed < 0.5 * same) {
    std::reverse(ways[1].chart.begin(), ways[1].chart.end());
    std::reverse(ways[1].X_mm.begin(), ways[1].X_mm.end());
  }
  std::vector<Vec3> places = ways[0].X_mm;
  places.insert(places.end(), ways[1].X_mm.begin(), ways[1].X_mm.end());
  const Tool tool = Tool(e.tool);
  return placed(SutureRow{std::move(ways[0].chart), std::move(ways[1].chart), e.spacing_mm,
                          tool == Tool::suture_row_buried ? e.depth_mm : 0, tool == Tool::suture_running},
                places, !off);
}

// The hand begins and ends on the margin as often as before it: what looks away from the blade there is left to the
// open end.
std::optional<Command> CommandBuilder::cut_through(const Drawn& d, const ToolEvent& e) {
  constexpr double kFaces = 0.4;  // cosine between skin and blade; sim/body/skin_view.h asks for half of it
  const Vec3 across = mean_direction(d.out);
  const bool as_held = !(e.angle_deg > 0);
  size_t first = 0, last = d.X_mm.size();
  if (ground_) {
    const auto faces = [&](size_t i) { return ground_->normal(d.X_mm[i]).dot(as_held ? d.out[i] : across) >= kFaces; };
    while (first + 2 < last && !faces(first)) ++first;
    while (last > first + 2 && !faces(last - 1)) --last;
  }
  const auto part = [&](const std::vector<Vec3>& all) {
    return std::vector<Vec3>(all.begin() + std::ptrdiff_t(first), all.begin() + std::ptrdiff_t(last));
  };
  const std::vector<Vec3> X = part(d.X_mm), out = part(d.out);
  CutThrough cut;
  cut.path = simplify_in_space(X, out, false, path_);
  if (cut.path.size() < 2 || path_length(cut.path) < path_.min_edge_mm) return ++dropped_, std::nullopt;
  for (const Vec3& post : cut.path) {
    Vec3 held = Vec3::Zero();
    for (size_t i = 0; i < X.size() && as_held; ++i)
      if ((X[i] - post).norm() <= kBlade_mm) held += out[i];
    cut.normals.push_back(held.norm() > 1e-6 ? Vec3(held.normalized()) : across);
  }
  const auto open = [&](size_t end, size_t before) {
    const Vec3 way = cut.path[end] - cut.path[before], &to_hand = cut.normals[end];
    const Vec3 on = way - way.dot(to_hand) * to_hand;
    return ground_ && on.norm() > 1e-6 && ground_->margin_beyond(cut.path[end], to_hand, on.normalized());
  };
  cut.open_start = open(0, 1);
  cut.open_end = open(cut.path.size() - 1, cut.path.size() - 2);
  return cut;
}

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

std::optional<Command> CommandBuilder::feed(const ToolEvent& e) {
  const ChartPoint here(e.chart_x, e.chart_y);
  const Vec3 rest(e.rest_mm[0], e.rest_mm[1], e.rest_mm[2]), world(e.world_mm[0], e.world_mm[1], e.world_mm[2]),
      out(e.out[0], e.out[1], e.out[2]);
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
      stroke_.assign(1, here), stroke_X_.assign(1, rest), stroke_out_.assign(1, out);
      off_chart_ = tool == Tool::scalpel && !means(here, rest);
      in_pieces_ = false;
      stroke_begin_ = world;
      return {};
    case ToolEvent::stroke_point:
      if (tool == Tool::saw) bone_stroke_.push_back(rest);
      if (progressive_ && tool == Tool::scalpel && !means(here, rest)) {
        if (in_pieces_) return {};  // where the chart does not see it, it goes no further
        off_chart_ = true;
      }
      if (!stroke_.empty()) stroke_.push_back(here), stroke_X_.push_back(rest), stroke_out_.push_back(out);
      if (progressive_ && tool == Tool::scalpel && !off_chart_) return draw_on(e);
      return {};
    case ToolEvent::stroke_cancel:
      if (sews_along(tool) && have_row_a_) have_row_a_ = false, ++dropped_;
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
      Drawn drawn{std::move(stroke_), std::move(stroke_X_), std::move(stroke_out_)};
      stroke_.clear();
      if (in_pieces_ && drawn.chart.empty()) return {};  // it was stopped
      if (in_pieces_) return finish_drawing(e, drawn.chart);
      if (drawn.chart.empty()) return ++dropped_, std::nullopt;
      if (tool == Tool::marker || tool == Tool::swab) {
        const bool off = !on_chart(drawn), dot = drawn.chart.size() < 2;
        Way way = dot ? Way{std::move(drawn.chart), std::move(drawn.X_mm)} : meant(drawn, false, off);
        return placed(Mark{std::move(way.chart), tool == Tool::swab}, way.X_mm, !off);
      }
      if (tool == Tool::scalpel_through) return cut_through(drawn, e);
      const bool outline = tool == Tool::undermine || tool == Tool::excise, off = !on_chart(drawn);
      if (tool == Tool::excise && ground_ && path_length(drawn.X_mm) < path_.min_edge_mm)
        return placed(ExcisePiece{drawn.chart[0]}, std::span(drawn.X_mm).first(1), !off);
      Way way = meant(drawn, outline, off);
      const double least_mm = sews_along(tool) && ground_ ? kShortestRow_mm : path_.min_edge_mm;
      if (way.chart.size() < (outline ? 3u : 2u) || way.length_mm() < least_mm) return ++dropped_, std::nullopt;
      if (sews_along(tool)) return row_with(std::move(drawn), e);
      if (tool == Tool::excise) return placed(Excise{std::move(way.chart), e.depth_mm}, way.X_mm, !off);
      if (tool == Tool::undermine) return placed(Undermine{std::move(way.chart), e.depth_mm}, way.X_mm, !off);
      if (tool == Tool::scalpel) return placed(Incise{std::move(way.chart), e.depth_mm, e.angle_deg}, way.X_mm, !off);
      if (tool == Tool::scissors) return placed(Incise{std::move(way.chart), e.depth_mm, 90}, way.X_mm, !off);
      return {};
    }
    case ToolEvent::hook_set:
      return placed(SetHook{e.id, here}, std::array{rest}, means(here, rest));
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
        const bool on =
            means(suture_tip_, suture_tip_rest_mm_) && means(suture_a_, suture_a_rest_mm_) && means(here, rest);
        return placed(SutureCorner{suture_tip_, suture_a_, here, e.depth_mm},
                      std::array{suture_tip_rest_mm_, suture_a_rest_mm_, rest}, on);
      }
      {
        const bool of_skin = side_a_ == HeldSide::skin && HeldSide(e.side) == HeldSide::skin;
        const bool on = of_skin && means(suture_a_, suture_a_rest_mm_) && means(here, rest);
        const std::array places{suture_a_rest_mm_, rest};
        if (tool == Tool::suture_bites) return placed(SutureBite{suture_a_, here}, places, on);
        return placed(Suture{suture_a_, here, tool == Tool::suture_buried ? e.depth_mm : 0, side_a_, HeldSide(e.side)},
                      places, on);
      }
    case ToolEvent::suture_tip:
      suture_tip_ = here, suture_tip_rest_mm_ = rest, have_tip_ = have_suture_a_;
      return {};
    case ToolEvent::suture_knot:
      return TieSuture{};
    case ToolEvent::suture_let_go:
      return LetThreadGo{};
    case ToolEvent::suture_cut:
      return placed(CutSuture{{0, here}}, std::array{rest}, means(here, rest));
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
