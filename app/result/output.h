#pragma once
// Where results go: checked before work starts, written whole or not at all (sim/base/whole_file.h).
#include <string>

#include "sim/base/whole_file.h"

namespace limberg {

/// Makes the folder (and its parents) if need be and makes sure that a file can be created in it. InputError otherwise.
void prepare_folder(const std::string& dir);

/// Makes sure that `file` can be written: its folder exists and takes files, and it is no folder itself. An existing
/// file is left alone. InputError otherwise.
void check_writable(const std::string& file);

/// Before work, and beside check_writable: a slip of the hand must not cost a script
/// or a recording. InputError when `file` holds something already that does not
/// begin as what will be written there, blanks left out; `kind` says what that is.
void check_replaces(const std::string& file, const std::string& begins, const std::string& kind);
inline void check_replaces_result(const std::string& file) { check_replaces(file, "{\"limberg\":", "a result"); }
inline void check_replaces_drawing(const std::string& file) { check_replaces(file, "<svg", "an SVG drawing"); }
inline void check_replaces_recording(const std::string& file) {
  check_replaces(file, "\xED\xA1\xDA\x01", "a recording");
}

}  // namespace limberg
