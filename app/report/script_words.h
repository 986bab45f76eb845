#pragma once
// What was done between two stages of an operation script, as one sentence for a caption.
#include <string>
#include <utility>
#include <vector>

namespace limberg {

/// Per stage of the script, in order: its name and what led to it ("Excision 4 mm deep. Incision of 40 mm ..."). Lines
/// that are not understood are passed over.
std::vector<std::pair<std::string, std::string>> stage_words(const std::vector<std::string>& script);

}  // namespace limberg
