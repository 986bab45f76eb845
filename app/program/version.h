#pragma once
// Which program this is.
#include <string>

namespace limberg {

const char* version();       // "0.1.0"
const char* commit();        // abbreviated git commit, "-dirty" when files differ from it, or "unknown"
std::string program_name();  // "limberg 0.1.0 (commit)"
std::string compiler();      // "g++ 12.2.0", "clang 14.0.6"
const char* processor();     // what this program was compiled for: "x86_64", "aarch64"

}  // namespace limberg
