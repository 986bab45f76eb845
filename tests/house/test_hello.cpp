// The example of sim/ as a library: it stays short, uses nothing but sim/, and does what it says.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "app/program/places.h"

namespace test_hello {

std::string printed_by(const std::string& program) {
  std::string text;
  if (std::FILE* pipe = popen(program.c_str(), "r")) {
    char part[256];
    while (std::fgets(part, sizeof part, pipe)) text += part;
    if (pclose(pipe) != 0) text += "(exit status is not 0)\n";
  }
  return text;
}

struct Stitch {
  int id = 0;
  double gap_mm = 0, force_N = 0;
};

std::vector<Stitch> stitches(const std::string& text) {
  const std::regex line(R"(stitch (\d+): gap ([\d.]+) mm, ([\d.]+) N)");
  std::vector<Stitch> found;
  for (std::sregex_iterator i(text.begin(), text.end(), line), end; i != end; ++i)
    found.push_back({std::stoi((*i)[1]), std::stod((*i)[2]), std::stod((*i)[3])});
  return found;
}

TEST(Hello, AWoundGapesAndItsStitchesCloseIt) {
  const std::string text = printed_by(limberg::binary_dir() + "/limberg_hello");
  EXPECT_NE(text.find("incise: done\n"), std::string::npos) << text;
  EXPECT_NE(text.find("sew: done\n"), std::string::npos) << text;
  EXPECT_EQ(text.find("exit status"), std::string::npos) << text;
  const std::vector<Stitch> seen = stitches(text);  // before and after the threads were drawn tight
  ASSERT_EQ(seen.size(), 6u) << text;
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(seen[i].id, seen[i + 3].id);
    EXPECT_GT(seen[i].gap_mm, 0.5) << text;
    EXPECT_LT(seen[i + 3].gap_mm, 0.05) << text;
    EXPECT_GT(seen[i + 3].force_N, 0.02) << text;
    EXPECT_LT(seen[i + 3].force_N, 1.0) << text;
  }
}

TEST(Hello, IsShortAndUsesNothingButSim) {
  std::ifstream in(limberg::source_dir() + "/sim/examples/hello.cpp");
  int lines = 0;
  for (std::string line; std::getline(in, line); ++lines)
    EXPECT_TRUE(!line.starts_with("#include \"") || line.starts_with("#include \"sim/")) << line;
  EXPECT_GT(lines, 20);
  EXPECT_LE(lines, 60);
}

}  // namespace test_hello
