// The fuzzers' entry points stay alive: each takes its sound inputs, and refuses or survives what is left of them when
// they are cut off or hit.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <sstream>

#include "tests/fuzz/entries.h"

namespace limberg {
namespace test_entries {

TEST(FuzzEntries, TakeTheirSoundInputs) {
  std::set<std::string> names;
  for (const fuzz::Entry& e : fuzz::entries()) {
    EXPECT_TRUE(names.insert(e.name).second) << e.name << " is there twice";
    ASSERT_FALSE(e.sound.empty()) << e.name;
    for (const std::string& s : e.sound) {
      bool taken = false;
      EXPECT_EQ(e.run(s, taken), "") << e.name;
      EXPECT_TRUE(taken) << e.name;
    }
  }
  EXPECT_GT(names.size(), 40u);
}

TEST(FuzzEntries, SurviveWhatIsCutOffOrHit) {
  std::mt19937_64 random(20261123);
  for (const fuzz::Entry& e : fuzz::entries()) {
    int refused = 0;
    for (const std::string& s : e.sound)
      for (int n = 0; n < 40; ++n) {
        std::string hit = s;
        if (n % 4 == 0) hit.resize(size_t(random() % (s.size() + 1)));
        for (int k = 0; k <= n % 3 && !hit.empty(); ++k) hit[size_t(random() % hit.size())] = char(random());
        bool taken = false;
        const std::string fault = e.run(hit, taken);
        EXPECT_EQ(fault, "") << e.name << ", case " << n;
        refused += !taken;
      }
    // Of a damaged recording what is whole is kept: nothing is refused as long as its beginning is there. And what is
    // shown, listed or pushed is never refused as a whole. A material is read for the one line that names a picture,
    // and what a cluster's programs say for the lines that are known.
    if (e.name != "recording" && e.name != "material" && e.name != "slurm") {
      EXPECT_GT(refused, 0) << e.name << " takes everything";
    }
  }
}

/// What fuzzers have found so far, and what was once read wrongly: a file of a few bytes each.
TEST(FuzzEntries, TakeOrRefuseTheirCorpora) {
  namespace fs = std::filesystem;
  size_t files = 0, bytes = 0;
  for (const fuzz::Entry& e : fuzz::entries()) {
    std::error_code none;
    for (const auto& f : fs::directory_iterator(fuzz::corpus_of(e), none)) {
      std::ifstream in(f.path(), std::ios::binary);
      std::ostringstream content;
      content << in.rdbuf();
      bool taken = false;
      EXPECT_EQ(e.run(content.str(), taken), "") << f.path();
      ++files, bytes += content.str().size();
    }
  }
  EXPECT_GT(files, 300u);
  EXPECT_LT(bytes, size_t(1) << 20) << "expected corpora that are kept small";
}

}  // namespace test_entries
}  // namespace limberg
