#include "app/assembly/desk_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iterator>

#include "app/result/output.h"
#include "app/scene/toml_table.h"
#include "sim/base/whole_file.h"

namespace limberg {

std::string desk_memory_file() {
  for (const auto& [variable, below] : {std::pair("XDG_CONFIG_HOME", ""), std::pair("HOME", "/.config")})
    if (const char* folder = std::getenv(variable); folder && folder[0] == '/')
      return std::string(folder) + below + "/limberg/window.toml";
  return "";
}

DeskMemory read_desk_memory(const std::string& file) {
  DeskMemory m;
  std::error_code ec;
  if (file.empty() || !std::filesystem::exists(file, ec)) return m;
  constexpr size_t kMost = 1 << 16;
  const auto bytes = read_whole_file(file, kMost, "what a window remembers");
  const toml::table root = parse_toml(std::string(bytes.begin(), bytes.end()), file, "what a window remembers");
  Table t(&root, "", file);
  t.boolean("toured", m.toured);
  t.integer("letters_percent", 75, DeskMemory::kLargest_percent, [&](int64_t v) { m.letters_percent = int(v); });
  std::string colours = kDeskColours[int(m.colours)];
  t.text("colours", colours);
  const auto* const known = std::find(std::begin(kDeskColours), std::end(kDeskColours), colours);
  if (known == std::end(kDeskColours))
    t.fail("colours", "is \"" + colours + "\"; expected \"dark\", \"light\" or \"contrast\"");
  m.colours = DeskColours(known - std::begin(kDeskColours));
  t.finish();
  return m;
}

void write_desk_memory(const std::string& file, const DeskMemory& m) {
  prepare_folder(std::filesystem::path(file).parent_path().string());
  write_whole_file(file, fmt::format("# What limberg's window remembers.\ntoured = {}\nletters_percent = {}\n"
                                     "colours = \"{}\"\n",
                                     m.toured, m.letters_percent, kDeskColours[int(m.colours)]));
}

}  // namespace limberg
