#pragma once
// The same operation closed in another order. Where the stitches are tied does not change, only when.
#include <string>
#include <vector>

#include "sim/commands/script.h"

namespace limberg {

/// The script with its stitches and rows tied in another order: each takes the place
/// of another, everything else stays where it is. `how`: as-written; reversed;
/// alternating (first, last, second, last but one, ...); or numbers of its suture
/// lines, "3-1-2". InputError on another word, on numbers that are no order, and on
/// a script whose later lines name stitches by number or take actions back.
Script reordered(const Script& script, const std::string& how);

}  // namespace limberg
