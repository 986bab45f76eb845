#pragma once
// Where the files that come with the program are: scenes, scripts and recordings, the library of tissues.
#include <string>
#include <vector>

namespace limberg {

/// The folders to look in for app/scenes, recordings and the like, best first: $LIMBERG_DATA where it is set, the
/// working folder (a checkout), the share folder of an installation that the running program or the shared library with
/// this code belongs to, the source that it was built from.
std::vector<std::string> shipped_roots();

/// A shipped file by its path in the tree ("recordings/rhomboid.jsonl"); empty when no root has it.
std::string shipped_file(const std::string& path);
/// The path as it was given when there is such a file, else the shipped file of that name, else as given: an installed
/// program finds recordings/rhomboid.lcm from any folder.
std::string given_or_shipped(const std::string& path);

}  // namespace limberg
