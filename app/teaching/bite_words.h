#pragma once
// A bite of a running stitch, in words: how far from the edges it lies, how far from the bite before, and what to do.
#include <optional>
#include <string>

#include "app/words/words.h"
#include "sim/commands/skin_acts.h"
#include "sim/patient/snapshot.h"

namespace limberg {

struct BiteWord {
  std::string words;
  bool praise = false;
};

/// Of bite number `number`. `before`, `spacing_mm`: the bite before it, and how far apart the two before were (0: there
/// were none). Empty words: the skin has no edge there. O(triangles)
BiteWord bite_word(const Snapshot& patient, int number, const SutureBite& bite, const SutureBite* before,
                   double spacing_mm, const Words& words = {});

/// How far two bites are apart, along the wound.
double bites_apart_mm(const SutureBite& a, const SutureBite& b);

}  // namespace limberg
