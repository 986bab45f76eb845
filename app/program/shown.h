#pragma once
// What a terminal is given: text only. A name or a note out of a file may hold bytes that a terminal obeys (colours,
// its title, a cleared screen); they are shown as '?'.
#include <string>
#include <string_view>

namespace limberg {

/// Without control characters but line ends and tabs: those below the blank, DEL, and U+0080 to U+009F.
std::string shown(std::string_view text);

/// From now on all that goes to standard output goes through shown(). Once, before anything is printed.
void show_standard_output();

}  // namespace limberg
