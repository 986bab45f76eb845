#pragma once
// Sessions that were killed, crashed or lost their machine left a recording without its end: the next start says so.
#include <string>
#include <vector>

namespace limberg {

/// Says one line for each of these folders in which such a recording lies, and how to go on with it; returns the first
/// of them, or nothing. A folder may be named twice, be empty or not exist.
std::string offer_to_continue(const std::vector<std::string>& folders);

/// The first of NAME-2.lcm, NAME-3.lcm, ... beside a recording that does not exist yet.
std::string name_of_continuation(const std::string& recording);

}  // namespace limberg
