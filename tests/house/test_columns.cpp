// Comments end where the code ends: clang-format wraps code at 120 columns and leaves comments as they were written.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "app/program/places.h"

namespace fs = std::filesystem;

namespace test_columns {

constexpr int kColumns = 120;

/// Characters, not bytes, of UTF-8.
int columns(const std::string& line) {
  return int(std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string long_comments(std::istream& in, const std::string& name) {
  std::string found;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const size_t text = line.find_first_not_of(" \t");
    if (text != std::string::npos && line.compare(text, 2, "//") == 0 && columns(line) > kColumns)
      found += name + ":" + std::to_string(number) + ": " + std::to_string(columns(line)) + " columns\n";
  }
  return found;
}

TEST(Columns, NoCommentIsWiderThanTheCode) {
  const fs::path root = limberg::source_dir();
  std::string text;
  for (const char* wing : {"app", "calibration", "devices", "library", "render", "sim", "tests"})
    for (const auto& e : fs::recursive_directory_iterator(root / wing))
      if (e.path().extension() == ".h" || e.path().extension() == ".cpp") {
        std::ifstream in(e.path());
        text += long_comments(in, fs::relative(e.path(), root).generic_string());
      }
  EXPECT_EQ(text, "");
}

TEST(Columns, AWideCommentIsSeen) {
  std::istringstream in("  // " + std::string(116, 'x') + "\n// " + std::string(117, 'y') + "\n" +
                        std::string(130, 'z') + "\n// " + std::string(113, 'a') + "→→→→\n");
  EXPECT_EQ(long_comments(in, "f"), "f:1: 121 columns\n");
}

}  // namespace test_columns
