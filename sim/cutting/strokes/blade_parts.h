#pragma once
// What the blades of incisions, plugs and sheets have in common: cleaned strokes, columns on the skin, strips.
#include <array>

#include "sim/cutting/arrangement/wound.h"
#include "sim/cutting/strokes/blade_build.h"
#include "sim/cutting/strokes/stroke.h"

namespace limberg {

inline constexpr double kSimplify = 0.1;   // tremor and tracker noise; corners are much larger
inline constexpr double kRowHeight = 2.5;  // of the rows of a strip, along the blade's depth
inline constexpr double kShortest = 1.0;   // of a stroke
inline constexpr double kKnot = 0.5;       // points of a stroke nearer than this are one

inline BladeResult refuse(std::string why) { return {std::nullopt, std::move(why)}; }

/// Finite numbers and a positive depth? Empty when all is well, as everywhere here.
std::string check_stroke(std::span<const ChartPoint> path, double depth_mm);
/// Vertices within the rest grid's domain, with room for the jitter?
std::string fits_grid(const BladeContext& context, const Blade& blade);

/// An outline without what runs on beyond its own beginning (geometry/overrun.h); as it is where nothing does.
std::vector<Vec2> closed_outline(std::span<const ChartPoint> outline);
/// A simple counter-clockwise outline without its repeated last point; empty, with a reason, when there is none.
std::vector<Vec2> clean_outline(std::span<const ChartPoint> outline, std::string& why);

/// A skin point with a normal smoothed over 2 mm: what a held blade follows.
struct Column {
  Vec3 X = Vec3::Zero(), normal = Vec3::UnitZ();
};
std::optional<Column> column_at(const BladeContext& context, const ChartPoint& p);
/// Columns at all points, or which point is not on the skin.
std::string columns_at(const BladeContext& context, std::span<const Vec2> path, std::vector<Column>& columns);

/// Normals turned towards their common mean: 0 as they are, 1 all parallel. Under a strongly curved skin a blade that
/// follows every normal runs through itself; a stiffer one does not.
std::vector<Column> stiffened(std::span<const Column> columns, double share);
inline constexpr std::array<double, 3> kStiffness{0, 0.6, 1};  // tried in turn

/// Per segment of the path (from column i to i + 1): how far the blade leans to the right, per mm of depth. `lean`
/// itself where the tissue lies as at rest; else what comes of it there, evened out over 3 mm of nearly straight path,
/// because cells are as large.
std::vector<double> leans_at_rest(const BladeContext& context, std::span<const Vec2> path,
                                  std::span<const Column> columns, double lean);

/// The first corner of a path, behind `after` along it, into which a blade leans so far that it would run through
/// itself there: its place along the path, or -1. The stroke is made in legs, each with its own lean to its end: one
/// goes kEndClearance past the corner, the next begins on its wall there and crosses it down to its own foot, kLegStep
/// higher, in one line that begins at the skin: so no bridge is left between them, and what of it lies beyond that
/// line, the corner's bisector, is not cut. A corner
/// nearer than kLeastLeg to an end is none.
double leg_end(std::span<const Vec2> path, double lean, double depth_mm, double after = 0);
/// The path up to there, and past the corner.
std::vector<Vec2> leg_of(std::span<const Vec2> path, double to);
inline constexpr double kEndClearance = 0.4;  // from the free end of an earlier cut, when joining it
inline constexpr double kLeastLeg = 1.5;
inline constexpr double kLegStep = 0.02;  // more than the jitter

/// How far an incision reaches below the depth asked, and how far blades stick out. Both vary a little from operation
/// to operation: two walls of one nominal depth then join with a clean end instead of a coincidence.
double wall_extra(const BladeContext& context);
double margin_of(const BladeContext& context);
/// How far past a wall a joining stroke is pushed.
double overshoot_of(const BladeContext& context);

/// Adds a closed ring: columns x rows of quads from above the skin to `depth` below, seeds 1 in the row that crosses
/// the skin. direction[i] points into the tissue, its length is the way along the blade per mm of depth.
/// Vertex of column i, row r: i * (rows + 1) + r. Returns the number of rows.
int add_ring(Blade& blade, const BladeContext& context, std::span<const Column> columns,
             std::span<const Vec3> direction, double depth);

/// Cosine: a stroke that leaves a wall by turning back along its own way.
inline constexpr double kDoublesBack = -0.96;

/// Lets a stroke's first point end on an earlier cut when it was meant to. True when path[0] now lies past a wall.
bool attach_start(const BladeContext& context, const WoundMap& wounds, std::vector<Vec2>& path, double overshoot);

}  // namespace limberg
