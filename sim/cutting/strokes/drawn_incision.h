#pragma once
// A free way of a stroke (one that runs along no earlier wall) as it is drawn: its blade, handed out piece by piece.
//
//   DrawnIncision drawn(4, 90);
//   drawn.follow(path);                          // the whole path so far, as often as the hand has moved on
//   BladeResult b = drawn.next(context, false);  // what can be cut by now, if anything; again until there is nothing
//   if (b.blade) drawn.was_cut(arrangement.cut(*b.blade, seed));
//   drawn.next(context, true);                   // the rest, with its end
//
// The pieces are pieces of one blade. Columns stand where the path alone puts them, so
// that the same path gives the same columns however it is divided; a piece begins with
// the last column of the one before, whose points it shares by number
// (Blade::shared_point). What lies less than a hold before the path's end is kept back:
// there an end that is drawn onto an earlier cut is still pushed through its wall or goes
// on from a wall's end, and a corner still gets its mitre. Skin that has been removed is
// crossed only when the path comes out of the hole again. No piece crosses itself: a loop
// ends between its two passages, and the next piece crosses what is there then. Leaning
// into a sharp corner the blade ends, and the next leg begins on it (leg_end).
#include "sim/cutting/strokes/blade_continue.h"

namespace limberg {

class DrawnIncision {
 public:
  static constexpr double kHold = 3.2;  // mm: an end can move back by 1.1; two quads of at most 1.95 must remain
  // more for a leaning blade: the quad behind a corner tells whether it can turn
  static constexpr double kHoldLeaning = 2.0;

  /// angle_deg as for DrawnStroke.
  DrawnIncision(double depth_mm, double angle_deg) : depth_(depth_mm), angle_deg_(angle_deg) {}

  /// The path so far, at least one point: the one of before and what has come since. Its last hold may have changed.
  void follow(std::vector<Vec2> path);

  /// The next piece. No blade and no reason: nothing new can be cut now. `last`: the path ends here.
  BladeResult next(const BladeContext& context, bool last);
  /// That piece was cut, or met nothing to cut: then the next one begins a blade of its own.
  void was_cut(const CutResult& result);
  void was_nothing(const BladeContext& context);
  /// That piece was refused. True: there is another way to do it, ask for the next piece again. An end that went on
  /// from a wall is pushed through it instead; a piece that would run through the one before begins on it.
  bool was_refused();

  /// The topmost point of its first column; -1 as long as there is none or when it is that of an earlier wall.
  int32_t start_point() const { return start_point_; }
  double left_mm() const;                              // of the path, not cut yet
  double level_mm() const { return depth_ + extra_; }  // of its foot, once it has begun

 private:
  struct Place {  // a column of the blade
    Vec2 at = Vec2::Zero();
    double arc = 0;    // along the path
    double share = 1;  // of the lean: less near a corner that a leaning blade cannot turn
  };
  struct Piece {  // what was handed out last
    std::vector<Column> column;
    std::vector<double> arc_mm;
    size_t end = 0;          // columns cut with it
    int32_t end_vertex = 0;  // of the blade: the top of its last own column
    bool closing = false, joins_start = false, joins_end = false;
    double leg = -1;  // closing: the corner behind which the next leg begins, along the path
    Vec2 end_at = Vec2::Zero();
    double end_arc = 0;
  };
  bool begin(const BladeContext& context, bool last);
  std::vector<Place> places(std::span<const Vec2> path, double arc, std::vector<double>& corner_arc) const;
  std::vector<Vec3> directions(const BladeContext& context, std::span<const Column> columns,
                               std::span<const Place> place, size_t first) const;
  size_t uncrossed(std::span<const Place> place, size_t first, size_t count) const;
  void end_leg();
  double lean() const;
  double hold_mm() const { return angle_deg_ == 90 ? kHold : kHold + kHoldLeaning; }
  /// The columns of a piece: those in [first, count) are cut, `first` is the last of the piece before.
  struct Way {
    std::vector<Place> place;
    size_t first = 0, count = 0;
    bool closing = false, past_end = false;  // the path ends with it; ... and lies past a wall
    std::optional<WallColumn> end_wall;      // or goes on from this one
    double leg = -1;                         // closing: the corner behind which the next leg begins, along the path
  };
  Way way_ahead(const BladeContext& context, bool last) const;
  void settle_end(const BladeContext& context, std::span<const Vec2> path, size_t hold, std::vector<double>& corner,
                  Way& way) const;
  std::optional<Blade> embedded(const BladeContext& context, const Way& way);
  Blade strip(const BladeContext& context, std::span<const Column> columns, std::span<const Vec3> direction,
              const Way& way);
  void begin_again(const Vec2& at, double arc);

  double depth_, angle_deg_;
  double margin_ = 0, extra_ = 0, overshoot_ = 0;  // fixed when the stroke begins, as those of one blade
  int rows_ = 0;
  bool begun_ = false;       // its start is settled
  bool past_start_ = false;  // ... and lies past a wall
  bool later_leg_ = false;   // it begins on the leg before
  bool finished_ = false;
  bool may_join_start_ = true, may_join_end_ = true;
  bool may_go_back_ = true;  // the start may lie before the path's, on a wall that is there
  double nothing_at_ = -1;   // how far along the path, since the last cut, pieces have met nothing to cut
  // The path as it was followed, and as it is cut: a settled start (if any) and so many of its last points.
  static constexpr size_t kAll = SIZE_MAX;
  struct Start {
    Vec2 at = Vec2::Zero();
    size_t kept = kAll;
  };
  void start_at(const Start& start);
  std::vector<Vec2> drawn_, path_;
  Start start_, start_before_;            // of a blade; before it was joined or attached to what is there
  std::optional<WallColumn> start_wall_;  // the start goes on from this one
  size_t committed_ = 0;                  // columns handed out and cut; the last of them begins the next piece
  std::vector<Column> column_;            // of those
  std::vector<double> arc_mm_;            // of those, along the skin
  // Where the committed blade ends, from above the skin down; empty: a new blade begins.
  std::vector<int32_t> end_point_;
  int32_t start_point_ = -1;
  Vec2 last_at_ = Vec2::Zero();  // the last committed column, and its place along path_
  double last_arc_ = 0;
  Piece offered_;
};

}  // namespace limberg
