// A short slice of the fuzzer of readers; `limberg bench fuzz
// --readers` runs a hundred thousand. And that it sees what it is for.
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <stdexcept>

#include "sim/base/error.h"
#include "tests/bench/fuzz/readers.h"

namespace limberg::bench {
namespace test_readers_fuzz {

TEST(ReadersFuzz, DamagedFilesAreRefusedOrSound) {
  ReadersFuzzSettings s;
  s.cases = 6'000;
  s.seed = 2026;
  const ReadersFuzzReport r = readers_fuzz(s, readers());
  EXPECT_EQ(r.cases(), s.cases);
  EXPECT_EQ(r.violations(), 0) << (r.violation.empty() ? "" : r.violation.front());
  EXPECT_EQ(r.family.size(), 10u);
  for (const auto& f : r.family) {
    EXPECT_EQ(f.taken + f.refused, f.cases) << f.name;
    EXPECT_GT(f.taken, 0) << f.name;  // some damage does not matter
    EXPECT_GT(f.refused, f.cases / 20) << f.name;
  }
}

/// What a reader with this defect is reported as.
std::string seen(const std::function<std::string(const std::string&)>& read, int64_t cases = 3) {
  ReadersFuzzSettings s;
  s.cases = cases, s.most_s = 1;
  const ReadersFuzzReport r = readers_fuzz(s, {{"planted", {{{{"a.txt", "one 2 three 4\n"}}, "a.txt"}}, read}});
  EXPECT_EQ(r.violations(), cases);
  EXPECT_FALSE(r.result().bars.front().pass);
  return r.violation.empty() ? "nothing" : r.violation.front();
}

TEST(ReadersFuzz, PlantedDefectsAreSeen) {
  EXPECT_NE(seen([](const std::string&) -> std::string {
              std::signal(SIGSEGV, SIG_DFL);  // a sanitizer has a handler of its own
              std::raise(SIGSEGV);
              return "";
            }).find("signal 11"),
            std::string::npos);
  EXPECT_NE(seen([](const std::string&) -> std::string { throw std::out_of_range("at"); }).find("no InputError: at"),
            std::string::npos);
  EXPECT_NE(seen([](const std::string&) { return std::string("odd"); }).find("odd"), std::string::npos);
  EXPECT_NE(seen([](const std::string&) -> std::string {
              throw InputError("b.txt", 1, "is wrong somehow or other");
            }).find("without the file's name"),
            std::string::npos);
  EXPECT_NE(seen([](const std::string& p) -> std::string { throw InputError(p, 1, "bad"); }).find("without a reason"),
            std::string::npos);
  EXPECT_NE(seen([](const std::string& p) -> std::string {
              throw InputError(p, 1, std::string(5000, 'a'));
            }).find("reason of"),
            std::string::npos);
  EXPECT_NE(seen(
                [](const std::string&) -> std::string {
                  volatile bool stop = false;
                  while (!stop) {
                  }
                  return "never";
                },
                1)
                .find("CPU time"),
            std::string::npos);
}

TEST(ReadersFuzz, MemoryThatAHeaderClaimsIsSeen) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer has the memory for itself";
#else
  EXPECT_NE(seen([](const std::string& p) -> std::string {
              std::vector<char> claimed;
              claimed.reserve(size_t(16) << 30);  // asked for, never touched
              throw InputError(p, 0, "the data are cut short after all");
            }).find("memory: asked for more than 256 MB"),
            std::string::npos);
#endif
}

}  // namespace test_readers_fuzz
}  // namespace limberg::bench
