// What a replay goes through calls no function of the C library whose last bit depends on the machine
// (sim/base/elementary.h), neither directly nor by Eigen.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

#include "app/program/places.h"

namespace fs = std::filesystem;

namespace test_same_bits {

std::string found_in(std::istream& in, const std::string& name) {
  static const std::regex forbidden(
      R"(std::(sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|exp|exp2|expm1|log|log2|log10|log1p|pow|cbrt|hypot|fma|erf|lgamma|tgamma)f?\(|std::(normal|exponential|gamma|poisson)_distribution|Eigen::(AngleAxis|Rotation2D)|\.slerp\(|\.eulerAngles\()");
  std::string text, line;
  for (int n = 1; std::getline(in, line); ++n) {
    const size_t comment = line.find("//");
    if (std::regex_search(line.begin(), comment == std::string::npos ? line.end() : line.begin() + long(comment),
                          forbidden))
      text += name + ":" + std::to_string(n) + ": " + line + "\n";
  }
  return text;
}

TEST(SameBits, NoFunctionOfTheLibraryThatDiffersByMachine) {
  const fs::path root = limberg::source_dir();
  std::string text;
  for (const char* part : {"sim", "devices", "app/session", "app/assembly", "app/scene"})
    for (const auto& e : fs::recursive_directory_iterator(root / part)) {
      if ((e.path().extension() != ".h" && e.path().extension() != ".cpp") || e.path().filename() == "elementary.h")
        continue;
      // A driver is a program of its own, of which a recording keeps what it said.
      if (e.path().parent_path().filename() == "drivers") continue;
      std::ifstream in(e.path());
      text += found_in(in, fs::relative(e.path(), root).generic_string());
    }
  EXPECT_EQ(text, "");
}

TEST(SameBits, ACallIsSeen) {
  std::istringstream in(
      "x = std::sin(y);\n// std::sin(y)\nstd::sqrt(x); elementary::sin(x);\nEigen::AngleAxisd(a, b);\n");
  EXPECT_EQ(found_in(in, "f"), "f:1: x = std::sin(y);\nf:4: Eigen::AngleAxisd(a, b);\n");
}

}  // namespace test_same_bits
