// A script does not depend on acts that it takes back: strokes, stitches, rows, hooks and threads cut, undone at once
// or several together, undone and done again, anywhere between the acts that stay.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "app/assembly/operation.h"
#include "app/result/result.h"
#include "sim/base/error.h"
#include "sim/commands/table.h"
#include "sim/patient/soft_tissue.h"
#include "tests/bench/fuzz/random.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_undone_acts {

WorldSpec patient() {
  WorldSpec spec =
      test::small_block({.thickness_mm = 8, .skin_cell_mm = 2.5, .cell_mm = 4, .along = 1.1, .across = 1.06});
  spec.can_cut = true;
  return spec;
}

using fuzz::Random;

Command random_act(Random& r) {
  const auto point = [&] { return ChartPoint{r.real(-20, 20), r.real(-20, 20)}; };
  const ChartPoint p = point();
  const auto near = [&](double far) { return ChartPoint(p + ChartPoint(r.real(-far, far), r.real(-far, far))); };
  switch (r.below(10)) {
    case 0:
    case 1:
    case 2:
      return Incise{{p, point(), point()}, 3, r.real(60, 120)};
    case 3:
      return Undermine{{p, p + Vec2(12, 0), p + Vec2(12, 9), p + Vec2(0, 9)}, 3};
    case 4:
      return Excise{{p, p + Vec2(7, 1), p + Vec2(6, 7), p + Vec2(-1, 6)}, 3};
    case 5:
      return SetHook{1 + r.below(2), p};
    case 6:
      return MoveHook{1 + r.below(2), {p.x(), p.y(), r.real(2, 6)}, 0};
    case 7:
      return CutSuture{{1 + r.below(4), Vec2::Zero()}};
    default:
      return Suture{p, near(9)};
  }
}

bool undoable(const Command& c) {
  return !std::holds_alternative<SetHook>(c) && !std::holds_alternative<MoveHook>(c) &&
         !std::holds_alternative<ReleaseHook>(c);
}

struct End {
  std::string hashes, refused;
};

End end_of(const std::vector<Command>& acts) {
  InlineWorkers workers;
  World world(patient(), workers);
  Script script;
  script.name = "script";
  for (const Command& c : acts) script.lines.push_back({int(script.lines.size()) + 1, c});
  OperationSettings set;
  set.rest_steps = 40, set.final_steps = 60;
  try {
    operate(world, 7, script, set);
  } catch (const InputError& e) {
    return {"", e.what()};
  }
  const SoftTissue& skin = *world.skin();  // its figures are no part of the hashes
  return {fmt::format("{} {}, {} mm3, {} mm3 taken out, {} uJ", hex(world.topology_hash()), hex(world.state_hash()),
                      skin.volume_mm3(), skin.removed_volume_mm3(), skin.closure_energy_uJ().value_or(-1)),
          ""};
}

class UndoneActs : public testing::TestWithParam<int> {};

TEST_P(UndoneActs, LeaveNoTrace) {
  Random r{uint64_t(GetParam()) * 7919};
  // Acts that stay, and between them some that do not: those that this patient does not refuse.
  std::vector<Command> plain, mixed;
  const auto taken = [&](const Command& c) {
    std::vector<Command> with = plain;
    with.push_back(c);
    return end_of(with).refused.empty();
  };
  int undone = 0;
  for (int tries = 0; tries < 60 && (plain.size() < 7 || undone < 3); ++tries) {
    const Command c = random_act(r);
    if (!taken(c)) continue;
    if (undoable(c) && r.one_in(2)) {
      mixed.push_back(c);
      if (const Command d = random_act(r); r.one_in(3) && undoable(d)) {  // two together, where the second is taken
        std::vector<Command> both = plain;
        both.push_back(c), both.push_back(d);
        if (end_of(both).refused.empty()) mixed.push_back(d), mixed.push_back(Undo{});
      }
      mixed.push_back(Undo{});
      if (r.one_in(4)) mixed.push_back(Redo{}), mixed.push_back(Undo{});
      ++undone;
    } else {
      plain.push_back(c), mixed.push_back(c);
    }
  }
  ASSERT_GT(plain.size(), 3u);
  ASSERT_GT(undone, 0);
  const End a = end_of(plain), b = end_of(mixed);
  std::string story;
  RecordProperty("undone", undone);
  for (const Command& c : mixed) story += std::string(action_name(c)) + " ";
  EXPECT_EQ(b.refused, "") << story;
  EXPECT_EQ(a.hashes, b.hashes) << story;
}

INSTANTIATE_TEST_SUITE_P(Seeds, UndoneActs, testing::Range(1, 13));

}  // namespace test_undone_acts
}  // namespace limberg
