// The cutting benchmark as a program part: behaviour, not time.
#include <gtest/gtest.h>

#include <set>

#include "sim/cutting/arrangement/arrangement.h"
#include "tests/bench/cutting.h"
#include "tests/bench/cutting_scene.h"

namespace limberg::bench {

TEST(BenchCutting, QuickRunHasEveryPartAndNeedsNoCgal) {
  CuttingSettings s;
  s.quick = true;
  s.cgal_program = "/nowhere/limberg_bench_cgal";
  const Result r = cutting(s);
  std::set<std::string> names;
  for (const Row& row : r.rows) {
    names.insert(row.name);
    EXPECT_GE(row.time_ms, 0) << row.name << ", " << row.method;
    EXPECT_TRUE(row.pass);
  }
  for (const char* n : {"arrangement, 2 k", "arrangement, 7 k", "history", "crossing", "incision drawn on a face"})
    EXPECT_TRUE(names.count(n)) << n;
  ASSERT_FALSE(r.bars.empty());  // small sizes say nothing about time, but where a slit ends is none of it
  for (const Bar& b : r.bars)
    EXPECT_TRUE(b.pass && b.name.find("slit") != std::string::npos) << b.name << " " << b.value;
  ASSERT_FALSE(r.notes.empty());
  EXPECT_NE(r.notes.back().find("libcgal-dev"), std::string::npos);
}

TEST(BenchCutting, TheSlabIsClosedAndTheBladeHasItsSize) {
  const Body body = wavy_slab(20);
  EXPECT_EQ(body.surface.tri.size(), size_t(2 * 20 * 20 + 12 * 20));
  Arrangement a(body.surface, body.grid);  // throws when it is open or turned inside out
  EXPECT_GT(a.volume_mm3(), 0.95 * 200 * 200 * 20);
  const Blade blade = curved_blade(body, {});
  EXPECT_EQ(blade.tri.size(), 200u);
  const CutResult r = a.cut(blade, 1);
  ASSERT_TRUE(r.ok()) << r.reason;
  EXPECT_EQ(r.tries, 1);  // no coincidence: a second try would be timed twice
  EXPECT_EQ(a.check_all(), "");
}

}  // namespace limberg::bench
