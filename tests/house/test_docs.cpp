// README and docs: short enough to be read, and true of the tree: files that they name exist, commands that they call
// are commands of the program.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "app/program/places.h"

namespace fs = std::filesystem;

namespace test_docs {

using limberg::source_dir;

std::string slurp(const fs::path& p) {
  std::ifstream in(p, std::ios::binary);
  std::ostringstream s;
  s << in.rdbuf();
  return s.str();
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

struct Page {
  std::string name;  // path from the root of the tree
  std::string text;
};

std::vector<Page> pages() {
  std::vector<Page> found;
  for (const char* name : {"README.md", "CONTRIBUTING.md", "recordings/README.md"})
    found.push_back({name, slurp(fs::path(source_dir()) / name)});
  for (const auto& e : fs::directory_iterator(fs::path(source_dir()) / "docs"))
    if (e.path().extension() == ".md") found.push_back({"docs/" + e.path().filename().string(), slurp(e.path())});
  std::sort(found.begin(), found.end(), [](const Page& a, const Page& b) { return a.name < b.name; });
  return found;
}

std::vector<std::string> matches(const std::string& text, const char* pattern) {
  const std::regex expression(pattern);
  std::vector<std::string> found;
  for (std::sregex_iterator i(text.begin(), text.end(), expression), end; i != end; ++i) found.push_back((*i)[1]);
  return found;
}

/// Lines that are longer than `most` bytes; tables, links and examples stay as they are.
std::string long_lines(const Page& page, size_t most) {
  std::string found;
  int number = 0;
  for (const std::string& line : lines_of(page.text)) {
    ++number;
    const bool free = line.starts_with("|") || line.starts_with("![") || line.starts_with("    ");
    if (line.size() > most && !free)
      found += page.name + ":" + std::to_string(number) + ": " + std::to_string(line.size()) + " bytes\n";
  }
  return found;
}

/// Links and `paths/of/files` of a page that lead nowhere in `root`.
std::string dead_ends(const Page& page, const fs::path& root) {
  std::string found;
  for (std::string link : matches(page.text, R"(\]\(([^)]+)\))")) {
    if (link.starts_with("http") || link.starts_with("#")) continue;
    link = link.substr(0, link.find('#'));
    if (!fs::exists(root / fs::path(page.name).parent_path() / link)) found += page.name + ": " + link + "\n";
  }
  // Names of files of the tree stand in `...` or in an example; NAME and * stand for several.
  for (
      std::string path : matches(
          page.text,
          R"((?:^|[^\w./~-])((?:app|calibration|devices|docs|library|recordings|render|sim|tests)/[\w./*-]*[\w*/]))")) {
    if (path.find('*') != std::string::npos || std::regex_search(path, std::regex("[A-Z]{2,}(?!\\.md|ME)"))) continue;
    if (!fs::exists(root / path)) found += page.name + ": " + path + "\n";
  }
  return found;
}

/// The commands of the program, by the files that add them to its command line.
std::set<std::string> commands(const fs::path& folder) {
  std::set<std::string> found;
  for (const auto& e : fs::directory_iterator(folder))
    if (e.path().extension() == ".cpp")
      for (const std::string& name : matches(slurp(e.path()), R"(add_subcommand\(\s*"([a-z]+)\")")) found.insert(name);
  return found;
}

/// The commands that examples and tables of a page call.
std::set<std::string> called(const Page& page) {
  std::set<std::string> found;
  for (const std::string& name : matches(page.text, R"((?:`|\n {4}|&& |/)limberg ([a-z]+))")) found.insert(name);
  return found;
}

TEST(Docs, ReadmeIsShort) {
  const std::string readme = slurp(fs::path(source_dir()) / "README.md");
  EXPECT_LE(lines_of(readme).size(), 160u);
  EXPECT_LE(readme.size(), 10'000u);
  EXPECT_GT(readme.size(), 4'000u);
}

TEST(Docs, NoLineIsLongerThanAPersonReads) {
  std::string text;
  for (const Page& page : pages()) text += long_lines(page, 200);
  EXPECT_EQ(text, "");
}

TEST(Docs, FilesThatPagesNameExist) {
  std::string text;
  for (const Page& page : pages()) text += dead_ends(page, source_dir());
  EXPECT_EQ(text, "");
}

TEST(Docs, CommandsThatPagesCallExist) {
  const std::set<std::string> known = commands(fs::path(source_dir()) / "app/commands");
  ASSERT_GE(known.size(), 15u);
  std::string text;
  for (const Page& page : pages())
    for (const std::string& name : called(page))
      if (!known.contains(name)) text += page.name + ": limberg " + name + "\n";
  EXPECT_EQ(text, "");
}

TEST(Docs, ReadmeAndCommandsPageNameEveryCommand) {
  const fs::path root = source_dir();
  for (const char* name : {"README.md", "docs/commands.md"}) {
    const std::set<std::string> shown = called({name, slurp(root / name)});
    for (const std::string& command : commands(root / "app/commands"))
      EXPECT_TRUE(shown.contains(command)) << name << " does not show limberg " << command;
  }
}

// The rules themselves see what is wrong.
TEST(Docs, WrongPagesAreSeen) {
  const fs::path root = source_dir();
  const Page good{"docs/x.md", "see [it](../README.md#install), `sim/patient/world.h` and\n    build/limberg run\n"};
  EXPECT_EQ(dead_ends(good, root), "");
  EXPECT_EQ(called(good), std::set<std::string>{"run"});
  EXPECT_EQ(dead_ends({"docs/x.md", "[it](README.md)"}, root), "docs/x.md: README.md\n");
  EXPECT_EQ(dead_ends({"README.md", "`sim/patient/nobody.h`"}, root), "README.md: sim/patient/nobody.h\n");
  EXPECT_EQ(dead_ends({"README.md", "`recordings/*.jsonl`, app/scenes/NAME.toml"}, root), "");
  EXPECT_EQ(called({"README.md", "| `limberg fly` | `build/limberg swim x` |"}),
            (std::set<std::string>{"fly", "swim"}));
  EXPECT_EQ(long_lines({"x", "short\n" + std::string(201, 'a') + "\n| " + std::string(300, 'b') + "\n"}, 200),
            "x:2: 201 bytes\n");
}

}  // namespace test_docs
