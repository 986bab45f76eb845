// Random histories with every invariant after every operation. Coordinates are snapped so that coincidences are common.
#include <gtest/gtest.h>

#include <random>

#include "sim/cutting/store.h"
#include "tests/sim/cutting/scenes.h"

namespace limberg::test {
namespace {

struct Fuzzer {
  Arrangement a;
  std::mt19937_64 random;
  double snap;  // mm; 0 = none
  std::vector<Blade> past;
  int done = 0, refused = 0, nothing = 0, tries = 0, debris = 0;

  Fuzzer(uint64_t seed, double snap_mm)
      : a(wavy_slab(40, 10, 10, snap_mm > 0 ? 0 : 0.7), grid()), random(seed), snap(snap_mm) {}

  double uniform(double lo, double hi) {
    const double x = lo + (hi - lo) * double(random() >> 11) * 0x1p-53;
    return snap > 0 ? std::round(x / snap) * snap : x;
  }
  Vec2 point(double r) { return {uniform(-r, r), uniform(-r, r)}; }

  Blade make() {
    switch (random() % 7) {
      case 0:
        return strip({point(18), point(18)}, 2, -uniform(1, 8), false, 3);
      case 1:
        return strip({point(18), point(18), point(18)}, 2, -uniform(1, 8), false, 3);
      case 2: {  // through everything
        const Vec2 p = point(15), d = Vec2(uniform(-1, 1), uniform(-1, 1) + 0.013).normalized() * 80;
        return strip({p - d, p + d}, 5, -15, false, 10);
      }
      case 3:
        return sheet({uniform(-18, 0), uniform(-18, 0), -uniform(1, 7)},
                     {uniform(6, 18), uniform(-3, 3), uniform(-2, 2)}, {uniform(-3, 3), uniform(6, 18), uniform(-2, 2)},
                     5, 5);
      case 4: {
        const Vec2 c = point(12);
        const double r = std::max(1.0, uniform(2, 7));
        return open_box({c + Vec2(r, 0), c + Vec2(0, r), c - Vec2(r, 0), c - Vec2(0, r)}, 2, -uniform(1, 8));
      }
      case 5:
        if (!past.empty()) {  // an old cut again, the same or a little deeper
          Blade again = past[random() % past.size()];
          if (random() % 4 != 0)
            for (Int3& p : again.vertex) p.z -= 4096;
          return again;
        }
        [[fallthrough]];
      default: {
        const Vec2 c = point(12);
        const double r = std::max(1.0, uniform(2, 6));
        return strip({c + Vec2(r, r), c + Vec2(-r, r), c - Vec2(r, r), c + Vec2(r, -r)}, 2, -uniform(2, 9), true, 3);
      }
    }
  }

  void step() {
    const uint64_t before = a.hash(), volume = a.store().volume_residue;
    const int pieces = a.pieces();
    if (random() % 9 == 0 && a.operations() > 0) {
      a.undo();
      ASSERT_EQ(a.check_all(), "");
      return;
    }
    if (random() % 6 == 0 && a.components().size() > 1) {
      const int32_t c = int32_t(random() % a.components().size());
      if (a.components()[size_t(c)].touches_fixed && random() % 4 != 0) return;
      const bool positive = a.components()[size_t(c)].volume_mm3 > 0;
      ASSERT_TRUE(a.excise(c).done);
      ASSERT_EQ(a.check_all(), "");
      ASSERT_EQ(a.pieces(), pieces - positive);
      return;
    }
    const Blade blade = make();
    const CutResult r = a.cut(blade, random());
    tries += r.tries;
    if (r.ok()) {
      ++done;
      past.push_back(blade);
      ASSERT_EQ(a.store().volume_residue, volume);
      ASSERT_GE(a.pieces(), pieces);
      ASSERT_EQ(a.check_all(), "");
      if (random() % 4 == 0) {
        const DebrisResult swept = a.sweep_debris(2);
        ASSERT_EQ(a.check_all(), "");
        ASSERT_EQ(a.sweep_debris(2).pieces, 0);
        debris += swept.pieces;
      }
    } else {
      ASSERT_FALSE(r.reason.empty());
      (r.status == CutResult::refused ? refused : nothing)++;
      ASSERT_EQ(a.hash(), before);
      ASSERT_EQ(a.check_all(), "");
    }
  }
};

void history(uint64_t seed, double snap, int steps, Fuzzer* total) {
  Fuzzer f(seed, snap);
  const uint64_t initial = f.a.full_hash();
  for (int i = 0; i < steps; ++i) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << " step " << i);
    f.step();
    if (::testing::Test::HasFatalFailure()) return;
  }
  while (f.a.undo()) {
  }
  EXPECT_EQ(f.a.full_hash(), initial);
  total->done += f.done;
  total->refused += f.refused;
  total->nothing += f.nothing;
  total->tries += f.tries;
  total->debris += f.debris;
}

TEST(CutFuzz, GeneralPosition) {
  Fuzzer total(0, 0);
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    history(seed, 0, 40, &total);
    if (HasFatalFailure()) return;
  }
  std::printf("done %d, refused %d, nothing %d, tries %d, debris %d\n", total.done, total.refused, total.nothing,
              total.tries, total.debris);
  EXPECT_LT(total.refused, total.done / 4);  // sheets that reach no surface are refused by rule
}

TEST(CutFuzz, CoincidencesEverywhere) {
  Fuzzer total(0, 0);
  for (uint64_t seed = 101; seed <= 106; ++seed) {
    history(seed, 2, 40, &total);
    if (HasFatalFailure()) return;
  }
  std::printf("done %d, refused %d, nothing %d, tries %d, debris %d\n", total.done, total.refused, total.nothing,
              total.tries, total.debris);
}

TEST(CutFuzz, SameSeedSameBits) {
  const auto run = [] {
    Fuzzer f(7, 2);
    for (int i = 0; i < 30; ++i) f.step();
    return f.a.full_hash();
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace limberg::test
