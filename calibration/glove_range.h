#pragma once
// How far apart the finger tips of this user's open and closed hand are, from a hand that opens and closes some times.
//
// The distances fall into two heaps; the threshold between them is the one that leaves the least variance within the
// heaps (Otsu 1979). The open and the closed distance are the medians of the heaps; the user must have held both.
#include <string>
#include <vector>

namespace limberg {

struct GloveLimits {
  int cycles = 3;         // closings, counted with hysteresis
  double range_mm = 25;   // open minus closed
  double band_sigma = 6;  // the band between grab and release against the spread of a held hand
  double held_s = 1.0;    // in either heap
  double grab_share = 0.25, release_share = 0.40;
};

struct GloveResult {
  double closed_mm = 0, open_mm = 0;
  double spread_mm = 0;  // of the closed hand: median distance from its median, as a standard deviation
  int cycles = 0;
  bool accepted = false;
  std::string advice;
};

/// `aperture_mm`: distances of the tips at a steady rate of `rate_hz`, while both fingers were tracked.
GloveResult calibrate_glove(const std::vector<double>& aperture_mm, double rate_hz, const GloveLimits& limits = {});

}  // namespace limberg
