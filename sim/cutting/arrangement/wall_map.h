#pragma once
// The walls of earlier strokes as columns and the strips between them: where a new stroke can continue one.
//
// A wall made of several strokes (deepened, lengthened) is one wall here: strokes that share points share columns.
//
//      skin   o-----o-----o-----o      each o at the skin is a column: explicit points of the arrangement, downwards
//             |     |     |     |
//             o-----o-----o-----o      each strip between two columns ends below in one edge, its front,
//                   |     |            as long as nothing else was cut there
//                   o-----o
#include <array>
#include <vector>

#include "sim/cutting/strokes/blade_build.h"

namespace limberg {

struct WallPoint {
  int32_t point = -1;  // explicit point of the arrangement
  double level = 0;    // mm below the skin along the blade, per unit of WallColumn::down; negative above the skin
};

struct WallColumn {
  std::vector<WallPoint> point;                     // by level
  Vec3 X_mm = Vec3::Zero(), down = -Vec3::UnitZ();  // where it meets the skin; how it goes on, per mm of depth
  Vec2 chart = Vec2::Zero();
  std::array<int32_t, 2> strip{-1, -1};  // one: it is an end
  bool is_end() const { return strip[1] < 0; }
};

struct WallStrip {
  std::array<int32_t, 2> column{-1, -1};
  std::array<int32_t, 2> front{-1, -1};  // points of its lowest edge, at either column
  double level = 0;                      // of the shallower of the two
  bool live = false;                     // some part of that edge is the end of a crack
};

class WallMap {
 public:
  /// Reads the blades of all operations whose blade was a stroke's strip,
  /// or of those before number `end` alone. Cost: their triangles.
  explicit WallMap(const BladeContext& context, int32_t end = INT32_MAX);

  std::span<const WallColumn> columns() const { return column_; }
  std::span<const WallStrip> strips() const { return strip_; }
  bool empty() const { return strip_.empty(); }

  /// The end of a wall nearest to p within `reach` at which the crack ends all the way down to the level asked (or to
  /// the wall's own foot): a stroke can go on there without a joint. -1 if there is none.
  /// `not_point`: a column that has it does not count.
  int32_t open_end_near(const Vec2& p, double reach, double level, int32_t not_point = -1) const;
  /// Unit direction in the chart in which the wall ends at this end column.
  Vec2 outward(int32_t end_column) const;

  struct Along {
    int32_t strip = -1;
    double t = 0;       // 0 at its first column, 1 at its second
    double offset = 0;  // signed distance, positive to the left of column 0 -> 1
    Vec2 direction = Vec2::UnitX();
  };
  /// The strip whose line on the skin is nearest to p; strip -1 when none is within reach.
  Along nearest(const Vec2& p, double reach) const;

 private:
  bool is_front(int32_t a, int32_t b) const;
  BladeContext context_;
  std::vector<WallColumn> column_;
  std::vector<WallStrip> strip_;
  std::vector<std::array<Vec2, 2>> line_;     // per strip: its ends on the chart
  std::vector<std::array<int32_t, 3>> edge_;  // ends ascending, original triangle; sorted
};

}  // namespace limberg
