#pragma once
// The mean of several surfaces of one kind: a normal skull made of skulls.
//
//   laid upon each other  each upon the mean by ICP (superposition.h), which at first is the first of them; the
//                         mean of all of them is the next one, until it stands still (generalised Procrustes, Gower
//                         1975, with nearest places instead of landmarks)
//   mean                  every vertex of it goes along its normal until its distances to the nearest places on all
//                         surfaces that look the same way sum to nothing; the steps are evened out over neighbours.
//                         It keeps the first surface's triangles, so walls stay walls where surfaces lie apart by more
//                         than these are thick (a mean of signed distances would open them)
//   spread                of the distances along the mean's normals, per vertex
//
// The mean has no part that the first surface lacks. A part that other surfaces lack is made of those that have it,
// where these are half of them or more.
#include <string>
#include <vector>

#include "sim/base/workers.h"
#include "sim/imaging/register/superposition.h"

namespace limberg {

struct AverageSettings {
  // Share of the pairs that count while they are laid upon each other. All: of a wider and a narrower skull the 70 %
  // that differ least are those of one side, and the other is then twice as far.
  double keep = 1;
  bool with_scale = false;  // all as large as their (geometric) mean
  double far_mm = 25;       // what is farther away, or looks another way by 60 degrees, is no place of the same kind
  double still_mm = 0.05;   // rms of the motion of the last round
  int rounds = 20;
};

struct AverageSurface {
  Surface mean;
  std::vector<double> spread_mm;  // standard deviation at each vertex, of the surfaces that have it; 0: fewer than half
  struct One {
    Similarity map;                 // of the surface upon the mean
    double rms_mm = 0, p95_mm = 0;  // of the mean's vertices from it, along their normals
    double reached = 0;             // share of the vertices that have a place on it
  };
  std::vector<One> of;
  double half = 0;  // share of the vertices that half of the surfaces or more have
  int rounds = 0;
  bool still = false;
  std::string reason;  // why there is none; empty: good
  explicit operator bool() const { return reason.empty(); }
};

/// Of two surfaces or more, each with triangles whose sides point outwards and with a shape (lacks_shape). Throws
/// InputError on settings out of range.
AverageSurface average_surface(const std::vector<Surface>& surfaces, const AverageSettings& settings, Workers& workers);

}  // namespace limberg
