#pragma once
// What the window remembers from one session to the next: how large its letters are, its colours, and that the tour was
// seen. A small TOML file of the person's, $XDG_CONFIG_HOME/limberg/window.toml.
#include <cstdint>
#include <string>

namespace limberg {

enum class DeskColours : uint8_t { dark, light, contrast };
inline constexpr const char* kDeskColours[] = {"dark", "light", "contrast"};

struct DeskMemory {
  static constexpr int kLargest_percent = 200;
  bool toured = false;
  int letters_percent = 100;  // 75 to kLargest_percent
  DeskColours colours = DeskColours::dark;
  bool operator==(const DeskMemory&) const = default;
};

/// Where it is kept; empty: the person has no home.
std::string desk_memory_file();
/// What is missing is as it is by default, and so is all of a file that is not there.
/// InputError: the file is no such one.
DeskMemory read_desk_memory(const std::string& file);
/// Makes the folder. InputError: it cannot be written.
void write_desk_memory(const std::string& file, const DeskMemory& memory);

}  // namespace limberg
