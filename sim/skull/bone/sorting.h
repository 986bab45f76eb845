#pragma once
// Sorting of bone fragments: which cut surfaces belong together, and how the fragments lie to each other.
//
// A fragment is described by its cut rings: the creases between its surface
// and its cut walls, walked with the surface on the left. Two fragments
// that were one run along the same curve in opposite directions, with the
// same surface normal. All cyclic shifts of every ring of one against every
// ring of the other are tried, run against run (ring_ways.h); parts of
// rings are enough. The best are fitted nearest place to nearest line over
// all rings of both (both tables, so that the thickness has to agree too).
//
// Verified, or refused: enough length together; a residual that the noise of the rings explains (how
// far their corners jump, rings.h); cut surfaces that touch, with a residual of their own; no bone
// within bone. What fits in one way only is put together first, the best (length over residual) first.
// What fits in several (a circle in a sphere fits at every angle) is put where its neighbours fit as
// well, if that is clearly one way, else refused. Then all pieces settle together: each in turn is
// moved to where it fits all its neighbours best. In the end every pair is looked at where it lies.
#include <string>
#include <vector>

#include "sim/skull/simplex/mesh.h"

namespace limberg::bone {

class Bones;

struct SortingRules {
  double least_length_mm = 30;    // of rings that run together
  double most_residual_mm = 0.4;  // rms
  double most_depth_mm = 1;       // of one within the other
};

struct Match {
  int32_t a = -1, b = -1;  // pieces
  Eigen::Isometry3d b_in_a = Eigen::Isometry3d::Identity();
  double length_mm = 0, residual_mm = 0;
};
struct Unmatched {
  int32_t a = -1, b = -1;
  std::string reason;
};

struct Sorting {
  std::vector<Match> matches;           // verified, the longest first
  std::vector<Unmatched> refused;       // pairs that came near, with the reason
  std::vector<Eigen::Isometry3d> pose;  // per piece: into the frame of the first of its group
  std::vector<int32_t> group;           // the smallest piece that it was put together with (itself, when alone)
};

/// Pieces: closed meshes with cut walls, each wherever it is. Deterministic. Of a
/// skull of 10,000 vertices in five pieces 0.1 s of CPU time a pair on average:
/// .3 at most, where rings of 600 mm run together, and thousandths where none do.
Sorting sort_fragments(const std::vector<simplex::Mesh>& pieces, const SortingRules& rules = {});

/// The fragments of a head as they lie now, as pieces; `ids` (may be null) receives which.
std::vector<simplex::Mesh> pieces_of(const Bones& bones, std::vector<int32_t>* ids = nullptr);

}  // namespace limberg::bone
