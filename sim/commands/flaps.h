#pragma once
// Two classical flaps as operation scripts, from a few lengths and angles.
//
// Both are drawn in a local frame whose unit is the side L, then turned, mirrored and moved onto the chart of the skin.
// Suture points lie `inset_mm` beside their edge, in the tissue that they hold; key stitches hold corners `corner_mm`
// along the edge or along the bisector of the corner, so that each names one edge without doubt. Hook places assume the
// flat skin of a block (z = 0). Coordinates are rounded to 1/1000 mm.
#include <vector>

#include "sim/commands/script.h"

namespace limberg {

/// Where and how large. The chart point of local p (units of side_mm) is origin + turn(mirror(p)) * side_mm.
struct FlapFrame {
  ChartPoint origin{0, 0};
  double side_mm = 20;
  double turn_deg = 0;    // counter-clockwise
  bool mirrored = false;  // y -> -y, before turning

  ChartPoint chart(const Vec2& local) const;
};

struct FlapSettings {
  double depth_mm = 4;
  double undermine_radius = 1.8;  // of the disc around the figure's centre, in sides
  double spacing_mm = 4;          // of stitches in a row
  double inset_mm = 0.7, corner_mm = 0.9;
  double lift_mm = 10;  // height of the hooks while the flap is carried over
};

/// Limberg's rhomboid flap. Rhombus ABCD with 60 degrees at A and C, sides L; its short diagonal BD, prolonged by L,
/// gives E; EF is parallel to DC. The flap CDEF keeps its base CF and turns by 60 degrees about C: its corner D comes
/// to
/// B, E to A. The donor wound closes edge to edge about E, D to F, and there the tension is greatest; the line DF
/// should run along the most extensible direction, across the relaxed skin tension lines (Limberg; Lister and Gibson
/// 1972).
/// The local frame has its origin at D, which is 1 L from all other corners.
struct Rhomboid {
  FlapFrame frame;
  Vec2 A{-0.5, 0.8660254037844386}, B{-1, 0}, C{-0.5, -0.8660254037844386}, D{0, 0}, E{1, 0},
      F{0.5, -0.8660254037844386};
};

/// Z-plasty with equal limbs L and equal angles. AB is the central limb (the contracted scar, along local y), AC and BD
/// the lateral limbs at angle_deg to it; the flaps CAB and DBA exchange places: corner A comes to D, B to C. The ends
/// of the central limb move apart by sqrt(5 - 4 cos angle) in the ideal plane figure.
struct ZPlasty {
  FlapFrame frame;
  double angle_deg = 60;
  Vec2 A() const { return {0, 0.5}; }
  Vec2 B() const { return {0, -0.5}; }
  Vec2 C() const;
  Vec2 D() const;
};

/// Excision, incision, undermining, hooks, stitches and stages in a surgeon's order.
std::vector<Command> operation(const Rhomboid& plan, const FlapSettings& settings = {});
std::vector<Command> operation(const ZPlasty& plan, const FlapSettings& settings = {});

/// The shipped scripts recordings/NAME.jsonl for the shipped scenes of the same names ("rhomboid", "zplasty").
Rhomboid shipped_rhomboid();
ZPlasty shipped_zplasty();
Script shipped_script(const std::string& name);  // throws InputError for another name

}  // namespace limberg
