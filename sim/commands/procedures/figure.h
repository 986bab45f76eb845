#pragma once
// The figure of a skin operation in its own plane: what is cut, and which edge is sewn to which.
//
// A wound is a closed line of corners with the tissue on its left. A slit is walked there and back, so each of its
// banks has corners of its own: the Z-plasty's wound is C, A0, B2, D, B0, A1 - six corners in four places. The tissue
// angle of a corner is what lies between its two edges on the left, 360 degrees at the end of a slit.
//
// A seam joins two stretches of wound, proportionally to arc length. From the seams alone follow
//   - whether the plan closes: every edge is sewn exactly once;
//   - where it will not lie flat: at a point where tissue angles of sum S meet, the skin becomes a cone of charge
//     q = 360 - S. A dog-ear is to be expected where q > 0, a saddle (and tension) where q < 0 (Limberg). Over a whole
//     plan
//     that closes to one sheet the charges add up to nothing (Gauss and Bonnet).
// Lengths are mm. Angles are degrees, counter-clockwise.
#include <string>
#include <vector>

#include "sim/geometry/polyline.h"
#include "sim/geometry/vec.h"

namespace limberg {

/// A corner: number of the wound, number in it.
struct Corner {
  int wound = 0, at = 0;
  auto operator<=>(const Corner&) const = default;
};

/// Bank a, walked forward along its wound from corner `a_from` to `a_to`, sewn to bank b, walked backward from `b_from`
/// (which meets a_from) to `b_to`.
struct Seam {
  Corner a_from, a_to, b_from, b_to;
  bool from_middle = false;  // the middle first, then the middles of what is left; otherwise from end to end
  bool no_key = false;       // where it begins three edges meet and no key joins these two: the row begins near there
};

/// One stitch that joins two corners.
struct KeyStitch {
  Corner a, b;
  bool while_raised = false;  // before the flaps are brought to their places
};

/// A corner of a flap that is hooked, lifted and brought to the corner `to`.
struct Carry {
  Corner tip, to;
};

struct Figure {
  std::vector<std::vector<Vec2>> excisions;  // outlines
  std::vector<std::vector<Vec2>> incisions;  // paths
  std::vector<std::vector<Vec2>> wounds;     // as above
  std::vector<Seam> seams;                   // in the order of closure
  std::vector<KeyStitch> keys;               // in their order
  std::vector<Carry> carries;
  bool exchanged = false;  // the flaps change places: each is folded back until it is its turn (operation.h)
  bool undermined = true;  // under and around the figure; false: flaps stay on their bed
  double deeper = 1;       // incisions, of the depth of the excision: a flap on its bed needs a tall stalk
};

/// Tissue angle at a corner, 0 < angle <= 360.
double tissue_deg(const Figure& figure, const Corner& c);
/// Unit, from the corner into the middle of its tissue.
Vec2 tissue_bisector(const Figure& figure, const Corner& c);
const Vec2& place(const Figure& figure, const Corner& c);

/// A stretch of wound as a polyline with tissue on its left when walked forward; given backward, it is listed backward.
std::vector<Vec2> bank(const Figure& figure, const Corner& from, const Corner& to, bool forward);
/// Point at arc length s, moved by `inset_mm` to the left.
Vec2 beside(const std::vector<Vec2>& path, double s_mm, double inset_mm);

/// How far the tissue reaches from a place of a wound's edge in a direction (unit): to the next edge of any wound.
/// Infinite where there is none.
double tissue_mm(const Figure& figure, const Vec2& at, const Vec2& direction);

/// The tissue that one corner (or straight bank) brings to a meeting: between two directions, counter-clockwise.
struct TissueSector {
  double from_deg = 0, sweep_deg = 0;
};

struct Charge {
  double q_deg = 0;
  std::vector<Vec2> meeting;         // the places, on the uncut skin, that the seams bring together
  std::vector<TissueSector> sector;  // of each of them
};
/// Of every point of the closed plan where |q| > 1e-6 degrees. A seam of unequal lengths or curvatures spreads its
/// charge over its corners.
std::vector<Charge> charges(const Figure& figure);

/// Empty when every edge of every wound is sewn exactly once and all corners exist; otherwise what is wrong.
std::string why_open(const Figure& figure);

}  // namespace limberg
