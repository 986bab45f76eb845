// Random strokes, sheets and plugs as a hand might draw them: on flat and wavy skin,
// across themselves, again and deeper, further from where another ended. Whatever is
// asked, every invariant holds, refusals change nothing, undo takes all back.
#include <random>

#include "tests/sim/cutting/patient.h"

namespace limberg::test {
namespace test_stroke_fuzz {

std::shared_ptr<const Body> wavy_body() {
  Body b;
  b.name = "wavy";
  b.surface = wavy_slab(100, 12, 50, 3.0);
  b.layers = {{"skin", 1.5, {}}, {"fat", 10, {}}};
  b.box_min_mm = {-50, -50, -12};
  b.box_max_mm = {50, 50, 3};
  return std::make_shared<const Body>(std::move(b));
}

class Hand {
 public:
  explicit Hand(unsigned seed) : random_(seed) {}
  double real(double a, double b) { return a + (b - a) * double(random_() % 100000) / 100000; }
  int below(int n) { return int(random_() % unsigned(n)); }
  Vec2 point() {
    const Vec2 p(real(-32, 32), real(-32, 32));
    return below(3) == 0 ? Vec2(4 * std::round(p.x() / 4), 4 * std::round(p.y() / 4)) : p;  // coincidences are common
  }
  std::vector<Vec2> ring(const Vec2& c, double least, double most) {
    std::vector<Vec2> out;
    const int n = 3 + below(7);
    const double r = real(least, most);
    for (int i = 0; i < n; ++i)
      out.push_back(c + r * real(0.6, 1.2) * Vec2(std::cos(2 * M_PI * i / n), std::sin(2 * M_PI * i / n)));
    return out;
  }

 private:
  std::mt19937 random_;
};

void operate(unsigned seed, const std::shared_ptr<const Body>& body, int operations, int& done) {
  Hand hand(seed);
  const Skin skin(body);
  Arrangement a(body->surface, body->grid);
  const uint64_t start = a.full_hash();
  BladeContext context;
  context.body = body.get();
  context.arrangement = &a;
  context.skin = [&](const ChartPoint& p) { return skin.at(p); };
  std::vector<std::vector<Vec2>> drawn;
  for (int k = 0; k < operations; ++k) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << " operation " << k);
    const uint64_t before = a.full_hash(), cut_seed = 1000 * seed + unsigned(k);
    const double depth = hand.below(10) == 0 ? 14 : hand.below(2) ? std::round(hand.real(1, 8)) : hand.real(1, 8);
    CutResult r;
    const auto cut = [&](const BladeResult& b) {
      r = b.blade ? a.cut(*b.blade, cut_seed) : CutResult{};
      if (!b.blade) r.reason = b.reason;
    };
    const int kind = hand.below(10);
    if (kind < 5 || drawn.empty()) {
      std::vector<Vec2> path;
      for (int i = 2 + hand.below(4); i > 0; --i) path.push_back(hand.point());
      if (hand.below(4) == 0) path.push_back(path[0]);
      if (!drawn.empty() && hand.below(3) == 0)
        path[0] = (hand.below(2) ? drawn.back().front() : drawn.back().back()) +
                  Vec2(hand.real(-0.5, 0.5), hand.real(-0.5, 0.5));
      r = incise(a, context, path, depth, hand.below(3) ? 90 : hand.real(40, 140), cut_seed, hand.below(5) == 0);
      if (r.ok()) drawn.push_back(path);
    } else if (kind < 7) {
      std::vector<Vec2> path = drawn[size_t(hand.below(int(drawn.size())))];
      for (Vec2& p : path) p += Vec2(hand.real(-0.2, 0.2), hand.real(-0.2, 0.2));
      path.back() += (path.back() - path[path.size() - 2]).normalized() * hand.real(-8, 8);
      r = incise(a, context, path, depth, 90, cut_seed);
    } else if (kind < 9) {
      cut(build_undermining(context, hand.ring(hand.below(2) ? drawn.back()[0] : hand.point(), 3, 14), depth));
    } else {
      cut(build_plug(context, hand.ring(hand.point(), 3, 9), depth));
    }
    EXPECT_EQ(a.check_all(), "");
    if (!r.ok()) {
      EXPECT_EQ(a.full_hash(), before);
      EXPECT_NE(r.reason, "");
    }
    done += r.ok();
    if (hand.below(12) == 0) a.undo();
  }
  while (a.undo()) {
  }
  EXPECT_EQ(a.full_hash(), start);
}

TEST(StrokeFuzz, InvariantsHoldWhateverIsDrawn) {
  BlockSpec spec;
  spec.size_mm = {100, 100, 10};
  spec.skin_cell_mm = 2;
  const auto flat = std::make_shared<const Body>(make_block(spec)), wavy = wavy_body();
  int done = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) operate(seed, seed % 2 ? wavy : flat, 20, done);
  EXPECT_GT(done, 50);  // of 80: most of what a hand asks is done
}

}  // namespace test_stroke_fuzz
}  // namespace limberg::test
