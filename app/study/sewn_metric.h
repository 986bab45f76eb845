#pragma once
// The rest metric of wounds as they have been cut and sewn, measured; no plan is asked.
//
// Which places of the edge a stitch joins is told by where both lie now. Sewn edges lie
// together there, three or four of them beside a corner, and both banks of a slit do
// over its last cell: of the edges within reach, the edges named by the stitch count.
//
// The skin's edge runs round a wound with tissue on its left, and stitches pair places of it.
// Going along it from stitch to stitch, and at each over to the other bank, one comes back
// after m stitches: round a gap. The gap sewn shut is a point of the sewn skin, and encloses
// what Gauss and Bonnet ask of its boundary, whose corners at the stitches are cusps:
//
//   q = 2 pi - m pi + sum of (pi - s),   s the angles of the rest triangles that
//                                        meet at a vertex of the edge on the way.
//
// Between two stitches of a straight seam q is 0; around what a plan
// calls a point of charge q it is q, however far off its stitches are.
// Over wounds that are sewn up to one sheet all add up to nothing;
// where seams cross, so that the sheet has a handle, to -720 degrees.
#include <optional>
#include <span>
#include <vector>

#include "sim/commands/command.h"
#include "sim/commands/procedures/figure.h"
#include "sim/patient/snapshot.h"

namespace limberg::study {

struct SewnGap {
  struct Turn {  // a vertex of the edge that is not straight
    ChartPoint at;
    double tissue_deg = 180;
    Vec2 inward = Vec2::Zero();  // unit, along the middle of its tissue
  };
  int stitches = 0;
  double charge_deg = 0;
  double unequal_mm = 0;  // between two stitches: how much longer one bank is than the other
  std::vector<Turn> turns;
};

struct SewnSkin {
  std::vector<SewnGap> gaps;
  // stitches whose ends lie on no edge (buried ones); all of them when others are there than were asked for
  int unpaired = 0;
  double sum_deg() const;
  /// The largest, without its sign, of a gap along straight banks.
  double stray_deg() const;
  /// Of the gaps that hold these corners, each once: stitches beside a point may divide its charge among two or three.
  /// Nothing where a corner is in no gap.
  std::optional<double> charge_deg(const Figure& figure, const std::vector<Corner>& corners) const;
};

/// Of a skin that was flat, or whose corners' rest angles add up to a
/// full turn; sewn by these commands, with single stitches and rows.
SewnSkin sewn_skin(const Snapshot& snapshot, std::span<const Command> commands);

}  // namespace limberg::study
