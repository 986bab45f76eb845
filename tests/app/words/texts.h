#pragma once
// All texts of the program that are shown in another language: those that the code marks (english, w(...), counted,
// as), and those of its data (lessons, measures, acts).
#include <string>
#include <string_view>
#include <vector>

namespace limberg::testing {

struct MarkedText {
  std::string file, context, text, many;  // many: of texts for one and for several
};

/// The marked texts of a source of C++ or JavaScript.
std::vector<MarkedText> marked_texts(std::string_view source, const std::string& file);
/// Of the whole program, each once, in the order of files.
std::vector<MarkedText> all_texts();
/// As a template of gettext's.
std::string pot_of(const std::vector<MarkedText>& texts);

}  // namespace limberg::testing
