// The fuzzer at the height of a patient: what it ever found, for ever, and a slice of new acts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/program/places.h"
#include "sim/base/error.h"
#include "tests/bench/fuzz/world_generator.h"

namespace limberg {
namespace test_world_fuzz {

int64_t number(const char* name, int64_t otherwise) {
  const char* v = std::getenv(name);
  return v ? std::atoll(v) : otherwise;
}

std::string read(const std::string& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

// Each of these broke an invariant once, or was refused because something inside failed.
TEST(WorldFuzz, WhatWasFoundStaysMended) {
  std::vector<std::string> files;
  for (const auto& f : std::filesystem::directory_iterator(source_dir() + "/tests/sim/patient/corpus"))
    files.push_back(f.path().string());
  std::sort(files.begin(), files.end());
  ASSERT_FALSE(files.empty());
  for (const std::string& file : files) {
    const fuzz::WorldOutcome o = fuzz::run_world_case(fuzz::world_case(read(file), file));
    EXPECT_EQ(o.violation, "") << file << " at act " << o.act;
    for (const std::string& why : o.defects) ADD_FAILURE() << file << ": " << why;
  }
}

// LIMBERG_FUZZ_ACTS and LIMBERG_FUZZ_SEED lengthen and vary the run.
TEST(WorldFuzz, ASlice) {
  fuzz::WorldFuzzSettings s;
  s.acts = number("LIMBERG_FUZZ_ACTS", 160);
  s.seed = uint64_t(number("LIMBERG_FUZZ_SEED", 20261121));
  s.out_dir = binary_dir() + "/fuzz";
  const fuzz::WorldFuzzReport r = fuzz::world_fuzz(s);
  for (const auto& v : r.violations) ADD_FAILURE() << v.what << "; written to " << v.file;
  const fuzz::WorldCounts& c = r.counts;
  std::printf("%lld acts, %lld done, %lld cuts, %lld refused, %lld undone, %lld redone\n", (long long)c.acts,
              (long long)c.done, (long long)c.cuts, (long long)c.refused, (long long)c.undone, (long long)c.redone);
  for (const std::string& why : r.defects) ADD_FAILURE() << "refused since something inside failed: " << why;
  EXPECT_GT(c.cuts, s.acts / 5);
}

TEST(WorldFuzz, CasesGoThroughTextUnchanged) {
  fuzz::WorldGenerator g(7);
  fuzz::WorldCase c = g.start();
  for (int i = 0; i < 30; ++i) c.acts.push_back(g.next());
  c.violation = "I7: an example";
  const std::string text = fuzz::to_text(c);
  EXPECT_EQ(fuzz::to_text(fuzz::world_case(text, "x.jsonl")), text);
  const auto with_scene = [](const std::string& scene) {
    return fuzz::world_case("{\"limberg_script\":1,\"scene\":\"" + scene + "\",\"note\":\"\"}\n", "x.jsonl");
  };
  EXPECT_NO_THROW(with_scene("fuzz size=50 seed=3"));
  for (const char* scene :
       {"rhomboid", "fuzz size", "fuzz size=", "fuzz size=x", "fuzz size=3", "fuzz cell=0", "fuzz colour=4"})
    EXPECT_THROW(with_scene(scene), InputError) << scene;
}

}  // namespace test_world_fuzz
}  // namespace limberg
