#pragma once
// What kind of flap a script draws, read from its cuts alone: as typed, or as a hand drew them (with a tremor).
#include <optional>
#include <span>
#include <vector>

#include "sim/commands/command.h"

namespace limberg {

/// The corners of a stroke: its ends and every point that matters by more than tolerance_mm (Douglas and Peucker 1973).
std::vector<ChartPoint> corners_of_path(std::span<const ChartPoint> path, double tolerance_mm = 1.5);
/// The same of a closed outline; corners in order, none repeated.
std::vector<ChartPoint> corners_of_outline(std::span<const ChartPoint> outline, double tolerance_mm = 1.5);

/// The first incision that is a Z: three straight strokes C-A-B-D, C and D on opposite sides of the central limb AB.
struct CentralLimb {
  ChartPoint C{0, 0}, A{0, 0}, B{0, 0}, D{0, 0};
};
std::optional<CentralLimb> find_central_limb(std::span<const Command> script);

/// A transposition flap beside a quadrangular defect: the first incision of two strokes D-E-F that starts within 2 mm
/// of a corner D of a four-cornered excision before it. C is the neighbour of D in the outline that lies nearer to F;
/// the flap is CDEF with its base CF.
struct TranspositionFlap {
  ChartPoint C{0, 0}, D{0, 0}, E{0, 0}, F{0, 0};
};
std::optional<TranspositionFlap> find_transposition_flap(std::span<const Command> script);

}  // namespace limberg
