#pragma once
// How far skin goes for a bone beneath it: the move of a landmark on the face along the move of one on bone, over that,
// beside what papers found in patients.
#include <string>
#include <vector>

#include "app/head/measures.h"

namespace limberg {

struct SoftRatio {
  std::string soft, bone;           // names of the landmarks
  double bone_mm = 0, soft_mm = 0;  // of the bone; of the skin, along the bone's move
  double ratio = 0;
  std::string of;                        // what was moved: chin, mandible, maxilla; empty: nothing that papers tell of
  double known_low = 0, known_high = 0;  // 0, 0: none is known here
  std::string source;
};

/// Of every pair whose landmarks both lists name and whose bone has moved by a millimetre or more.
std::vector<SoftRatio> soft_ratios(const NamedPlaces& before, const NamedPlaces& now);

}  // namespace limberg
