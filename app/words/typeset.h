#pragma once
// Numbers and units as they are printed: "4 mm" with a thin space that no line breaks at, "60 °" as "60°".
#include <string>
#include <string_view>

namespace limberg {

/// Between a number and a unit of ours (mm, mm², cm³, N, kPa, s, %, ...) the space becomes thin; before ° it goes.
std::string thin_spaces(std::string_view text);

/// Points between the digits of a number become the mark; of versions, names and addresses (1.2.3, p99.9, 10.1/x) not.
std::string with_decimals(std::string_view text, char mark);

/// Both, on the words of a page: not in code, scripts, styles, what is shown as it stands, and its foot.
std::string typeset_page(std::string_view html, char mark);

}  // namespace limberg
