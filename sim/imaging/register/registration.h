#pragma once
// A second image of the same head laid upon the first (MR upon CT): rigid, by what one image says about the other.
//
// Measure: normalised mutual information (H(A) + H(B)) / H(A, B) of a joint histogram (Studholme, Hill and Hawkes
// 1999), which asks for no likeness of the numbers, only that one foretells the other. Samples lie on an even grid of
// the first image, shifted within their cells by a fixed hash, so that the same call gives the same bits; a sample's
// second value is shared between its two nearest bins, so that the measure is smooth. Coarse to fine: both images
// smoothed and fewer samples at first. Search: a step along each of the three shifts and turns (about the middle of the
// first image), the best kept, and the same way again; halved when none helps.
#include <string>

#include "sim/base/workers.h"
#include "sim/imaging/io/volume.h"
#include "sim/imaging/register/superposition.h"

namespace limberg {

struct RegistrationSettings {
  int levels = 3;
  int bins = 32;
  int samples = 12000;                  // at the finest level
  double shift_mm = 12, turn_deg = 12;  // first steps of the search
  Similarity start;                     // of `moved` onto `fixed`
};

struct RegistrationResult {
  Similarity map;                        // of places in `moved` onto places in `fixed`
  double information = 1, at_start = 1;  // the measure, 1 (nothing) to 2 (everything)
  double overlap = 0;                    // part of the samples that lie in both
  int evaluations = 0;
  std::string reason;  // why there is none; empty: good
  explicit operator bool() const { return reason.empty(); }
};

/// Throws InputError on settings out of range or empty volumes.
/// Refused with a reason: an image without contrast, no overlap.
RegistrationResult register_volumes(const Volume& fixed, const Volume& moved, const RegistrationSettings& settings,
                                    Workers& workers);

/// `moved` as it lies upon `fixed`, on the voxels of `fixed`; `outside` where it has nothing.
Volume resampled(const Volume& fixed, const Volume& moved, const Similarity& map, float outside, Workers& workers);

/// As NRRD with raw floats.
std::string to_nrrd(const Volume& volume);

}  // namespace limberg
