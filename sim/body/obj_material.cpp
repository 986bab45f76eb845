#include "sim/body/obj_material.h"

namespace limberg {

namespace {

constexpr std::string_view kBlank = " \t\r";

/// What follows a key on the first line that begins with it, without blanks around.
std::string_view after_key(std::string_view text, std::string_view key) {
  while (!text.empty()) {
    const size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    const size_t first = line.find_first_not_of(kBlank);
    if (first == std::string_view::npos) continue;
    line.remove_prefix(first);
    if (!line.starts_with(key)) continue;
    line.remove_prefix(key.size());
    const size_t name = line.find_first_not_of(kBlank);
    if (name == 0 || name == std::string_view::npos) continue;
    line.remove_prefix(name);
    return line.substr(0, line.find_last_not_of(kBlank) + 1);
  }
  return {};
}

}  // namespace

std::string materials_of_obj(std::string_view text) { return std::string(after_key(text, "mtllib")); }

std::string picture_of_material(std::string_view text) {
  std::string_view name = after_key(text, "map_Kd");
  // Options (-s 1 1 1 ...) come before the name: then a name with blanks in it cannot be told.
  if (name.starts_with('-')) name = name.substr(name.find_last_of(kBlank) + 1);
  return std::string(name);
}

}  // namespace limberg
