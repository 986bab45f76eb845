#pragma once
// Which program this is.
#include <string>

namespace limberg {

const char* version();       // "0.1.0"
const char* commit();        // abbreviated git commit, "-dirty" when files differ from it, or "unknown"
std::string program_name();  // "limberg 0.1.0 (commit)"

}  // namespace limberg
