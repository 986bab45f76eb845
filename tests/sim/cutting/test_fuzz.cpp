// The stateful fuzzer: what it ever found, for ever, and a slice of new operations.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "app/program/places.h"
#include "sim/base/error.h"
#include "tests/bench/fuzz.h"
#include "tests/bench/fuzz/generator.h"
#include "tests/sim/cutting/compilers/history.h"

namespace limberg {
namespace test_fuzz {

std::vector<std::string> corpus() {
  std::vector<std::string> files;
  for (const auto& f : std::filesystem::directory_iterator(source_dir() + "/tests/sim/cutting/corpus"))
    files.push_back(f.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

// Each of these broke an invariant once.
TEST(FuzzCorpus, WhatWasFoundStaysMended) {
  ASSERT_GE(corpus().size(), 4u);
  for (const std::string& file : corpus()) {
    const fuzz::Outcome o = fuzz::run_case(fuzz::read_case(file), {});
    EXPECT_EQ(o.violation, "") << file << " at operation " << o.op;
  }
}

// A blade goes on from where another ran out of the body, and a third has a corner on
// the edge that it shares: no try can move that edge. But no wall is there to continue,
// so the edge need not be shared, and the answer is that there is nothing to cut.
TEST(FuzzCorpus, AnEdgeOutsideTheBodyIsNotShared) {
  const fuzz::Case c = fuzz::read_case(source_dir() + "/tests/sim/cutting/corpus/continued_outside_the_body.json");
  fuzz::Runner runner(c, {});
  for (const fuzz::Op& op : c.ops) ASSERT_EQ(runner.apply(op), "");
  EXPECT_EQ(runner.last_cut.status, CutResult::nothing_to_cut) << runner.last_cut.reason;
  EXPECT_EQ(runner.counts().refused, 0);
}

// LIMBERG_FUZZ_OPERATIONS and LIMBERG_FUZZ_SEED lengthen and vary the run.
int64_t number(const char* name, int64_t otherwise) {
  const char* v = std::getenv(name);
  return v ? std::atoll(v) : otherwise;
}

void slice(bool adversarial) {
  bench::FuzzSettings s;
  s.operations = number("LIMBERG_FUZZ_OPERATIONS", 7000);  // 30 s of CPU (2026-11-21)
  s.seed = uint64_t(number("LIMBERG_FUZZ_SEED", 20261121));
  s.generic = !adversarial;
  s.adversarial = adversarial;
  s.out_dir = binary_dir() + "/fuzz";
  const bench::FuzzReport r = bench::fuzz_run(s);
  const fuzz::Counts& c = adversarial ? r.adversarial : r.generic;
  for (const auto& v : r.violations) ADD_FAILURE() << v.what << "; written to " << v.file;
  EXPECT_EQ(c.operations, s.operations);
  EXPECT_GT(c.done, c.operations / 3);
  EXPECT_GT(c.faults_rolled_back, 0);
  if (!adversarial) {
    EXPECT_LE(c.refused, c.cuts / 10000);
  }
  std::printf("%lld operations, %lld cuts made, %lld refused, mean tries %.3f, %.1f s\n", (long long)c.operations,
              (long long)c.done, (long long)c.refused, double(c.tries) / double(c.done + c.refused), r.cpu_s);
}

TEST(Fuzz, DividedFronts) {  // 4 s of CPU (2026-11-21)
  bench::FuzzSettings s;
  s.operations = number("LIMBERG_FUZZ_OPERATIONS_DIVIDED", 250);
  s.seed = uint64_t(number("LIMBERG_FUZZ_SEED", 20261121));
  s.front_levels = 3;
  s.out_dir = binary_dir() + "/fuzz";
  const bench::FuzzReport r = bench::fuzz_run(s);
  for (const auto& v : r.violations) ADD_FAILURE() << v.what << "; written to " << v.file;
  EXPECT_EQ(r.operations(), s.operations);
}

// Fronts are divided in one history of so many, of either kind; a run that is told to stop reports what it has done.
TEST(Fuzz, DividesAShareOfHistoriesAndStopsWhenTold) {
  bench::FuzzSettings s;
  s.operations = 240;
  s.check_every = 100;
  s.front_levels = 3;
  s.divide_every = 4;
  const bench::FuzzReport r = bench::fuzz_run(s);  // ten histories of 24, of which 0, 1, 8 and 9 are divided
  EXPECT_EQ(r.operations(), 240);
  EXPECT_EQ(r.divided, 4 * 24);
  int asked = 0;
  s.stop = [&] { return ++asked > 3; };
  EXPECT_EQ(bench::fuzz_run(s).operations(), 3 * 24);
}

TEST(Fuzz, GeneralPosition) { slice(false); }
TEST(Fuzz, Adversarial) { slice(true); }

TEST(Fuzz, SameSeedSameOperationsSameHashes) {
  const auto run = [] {
    fuzz::Generator g(99, true);
    fuzz::Case c = g.start();
    fuzz::Runner r(c, {0, true, false});
    for (int32_t i = 0; i < 40; ++i) EXPECT_EQ(r.apply(g.next(r, i)), "");
    return std::pair(r.arrangement().full_hash(), r.lattice()->hash());
  };
  const auto first = run();
  EXPECT_EQ(run(), first);
  EXPECT_EQ(run(), first);
}

// The same as every other compiler makes of it: compilers/compilers.sh.
TEST(Fuzz, FixedHistoryHasItsCommittedHash) { EXPECT_EQ(test::history_hash(), test::kHistoryHash); }

TEST(Fuzz, CasesGoThroughFilesUnchanged) {
  fuzz::Generator g(5, false);
  fuzz::Case c = g.start();
  fuzz::Runner r(c, {0, false, false});
  for (int32_t i = 0; i < 20; ++i) {
    c.ops.push_back(g.next(r, i));
    r.apply(c.ops.back());
  }
  const std::string text = fuzz::to_json(c);
  EXPECT_EQ(fuzz::to_json(fuzz::case_from_json(text, "x.json")), text);
  EXPECT_THROW(fuzz::case_from_json("{\"ops\": 3}", "x.json"), InputError);
  EXPECT_THROW(fuzz::read_case("/nowhere/x.json"), InputError);
}

}  // namespace test_fuzz
}  // namespace limberg
