#pragma once
// Where this build's sources and programs lie: what is shipped is found there until it is installed.
#include <string>

namespace limberg {

std::string source_dir();
std::string binary_dir();

}  // namespace limberg
