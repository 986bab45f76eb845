// A flap carried by a hook in a body of many cells: what is solved for near it, with contact, is what the whole gives.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/patient/small_block.h"

namespace limberg {
namespace test_focus {

WorldSpec long_block() {
  WorldSpec spec = test::small_block({.side_mm = 120, .skin_cell_mm = 4, .cell_mm = 4});
  spec.contact = ContactChoice::automatic;
  spec.focus.from_nodes = 1000;
  return spec;
}

StepSettings live(bool focus) {
  StepSettings s;
  s.max_iterations = 10, s.tolerance = 1e-5, s.focus = focus;
  return s;
}

/// A tongue of skin of 14 x 12 mm, raised from its bed, with a hook at its tip.
void raise_flap(World& world, bool focus) {
  for (const Command& c :
       {Command(Incise{{{-37, -6}, {-23, -6}, {-23, 6}, {-37, 6}}, 4}),
        Command(Undermine{{{-37, -6}, {-23, -6}, {-23, 6}, {-37, 6}}, 3}), Command(SetHook{1, {-24.5, 0}})}) {
    const Outcome o = world.apply(c);
    ASSERT_TRUE(o.done) << o.reason;
    for (int i = 0; i < 12; ++i) world.step(live(focus));
  }
}

/// Of the surface; a node of nearly empty cells is no place in the tissue.
double apart(const World& a, const World& b) {
  Snapshot s, t;
  a.fill(s), b.fill(t);
  EXPECT_EQ(s.x_mm.size(), t.x_mm.size());
  double d = 0;
  for (size_t i = 0; i < s.x_mm.size(); ++i) d = std::max(d, double((s.x_mm[i] - t.x_mm[i]).norm()));
  return d;
}

TEST(Focus, AFlapIsCarriedOverItsBedAsInTheWhole) {
  InlineWorkers workers;
  World focus(long_block(), workers), whole(long_block(), workers);
  raise_flap(focus, true), raise_flap(whole, false);
  double worst = 0;
  // Lifted and drawn over its bed, where its deep side touches the bank. Pressed into the wound's corner it would jam
  // in one of several ways: whole and whole, with 10 and with 14 iterations a step, end .1 to .4 mm apart there.
  for (int i = 0; i < 50; ++i) {
    const double t = 0.02 * (i + 1);
    const MoveHook to{1, {-24.5 + 4 * t, 4 * t, 1 + 6 * std::sin(2 * t)}, 0};
    for (World* w : {&focus, &whole}) {
      ASSERT_TRUE(w->apply(to).done);
      w->step(live(w == &focus));
    }
    if (i >= 5) worst = std::max(worst, apart(focus, whole));  // the first jerk of the hand: neither is near
  }
  const std::string solved = focus.skin()->solver().describe();
  EXPECT_NE(solved.find("steps near what was carried"), std::string::npos) << solved;
  EXPECT_LT(worst, 0.1);  // twice the budget
  for (int i = 0; i < 150; ++i) focus.step(live(true)), whole.step(live(false));
  EXPECT_LT(apart(focus, whole), 0.02);  // contacts hold at other places of the same surfaces (contact_finder.h)
  // Back to before the cut, and on again, while the hand carries.
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(focus.apply(MoveHook{1, {-18 + 0.4 * i, 4, 3}, 0}).done);
    focus.step(live(true));
  }
  ASSERT_TRUE(focus.apply(Undo{}).done);
  ASSERT_TRUE(focus.apply(Redo{}).done);
  for (int i = 0; i < 5; ++i) focus.step(live(true));
}

}  // namespace test_focus
}  // namespace limberg
