#pragma once
// An incision that opens while it is drawn: the blade of a stroke, handed out piece by piece.
//
//   DrawnIncision drawn(4, 90);
//   drawn.draw(context, points);                 // as often as the hand has moved on
//   BladeResult b = drawn.next(context, false);  // what can be cut by now, if anything
//   if (b.blade) drawn.was_cut(arrangement.cut(*b.blade, seed));
//   drawn.next(context, true);                   // the rest, with its end
//
// The pieces are pieces of one blade. Columns stand where the path alone puts them, so that the same path gives the same
// columns however it is divided; a piece begins with the last column of the one before, whose points it shares by
// number (Blade::shared_point). What lies less than a hold before the path's end is kept back: there an end that is drawn
// onto an earlier cut is still pushed through its wall, and a corner still gets its mitre. Skin that has been removed is
// crossed only when the path comes out of the hole again.
#include "sim/cutting/blade_parts.h"

namespace limberg {

class DrawnIncision {
 public:
  static constexpr double kHold = 3.2;         // mm: an end can move back by 1.1; two quads of at most 1.95 must remain
  static constexpr double kHoldLeaning = 2.0;  // more for a leaning blade: the quad behind a corner tells whether it can turn

  /// angle_deg as for build_incision.
  DrawnIncision(double depth_mm, double angle_deg) : depth_(depth_mm), angle_deg_(angle_deg) {}

  /// More of the path. Not empty: why it cannot be taken; nothing was.
  std::string draw(const BladeContext& context, std::span<const ChartPoint> points);

  /// The next piece. No blade and no reason: nothing new can be cut yet.
  BladeResult next(const BladeContext& context, bool last);
  /// That piece was cut, or met nothing to cut: then the next one begins a blade of its own.
  void was_cut(const CutResult& result);
  void was_nothing(const BladeContext& context);

  double length_mm() const;  // of the path so far

 private:
  struct Place {  // a column of the blade
    Vec2 at = Vec2::Zero();
    double arc = 0;    // along the path
    double share = 1;  // of the lean: less near a corner that a leaning blade cannot turn
  };
  bool begin(const BladeContext& context, bool last);
  std::vector<Place> places(std::span<const Vec2> path, double arc, std::vector<double>& corner_arc) const;
  std::vector<Vec3> directions(std::span<const Column> columns, std::span<const Place> place, size_t first) const;
  double lean() const;
  double hold_mm() const { return angle_deg_ == 90 ? kHold : kHold + kHoldLeaning; }
  Blade strip(const BladeContext& context, std::span<const Column> columns, std::span<const Vec3> direction, size_t first, bool closing);

  double depth_, angle_deg_;
  double margin_ = 0, extra_ = 0, overshoot_ = 0;  // fixed when the stroke begins, as those of one blade
  int rows_ = 0;
  bool begun_ = false;           // its start is settled
  bool past_start_ = false;      // ... and lies past a wall
  std::vector<Vec2> path_;       // from the settled start on
  size_t committed_ = 0;         // columns handed out and cut; the last of them begins the next piece
  std::vector<Column> column_;   // of those
  std::vector<double> arc_mm_;   // of those, along the skin
  // Where the committed blade ends, from above the skin down; empty: a new blade begins.
  std::vector<int32_t> end_point_;
  // Of the piece that was handed out last.
  std::vector<Column> offered_column_;
  std::vector<double> offered_arc_mm_;
  size_t offered_ = 0;
};

}  // namespace limberg
