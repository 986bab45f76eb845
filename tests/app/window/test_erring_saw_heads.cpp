// A hand that errs with the saw on the shipped heads: what the window says at each error.
#include "tests/app/window/sawn_head.h"
#include "tests/sim/skull/needs_bullet.h"

namespace limberg {
namespace test_erring_saw_heads {

using namespace sawn_head;

TEST(ErringSawOnHeads, TheChinIsSawnWrongInFiveWaysAndThenRight) {
  LIMBERG_NEEDS_BULLET();
  try {
    make_osmesa_context();
  } catch (const RenderUnavailable&) {
    GTEST_SKIP() << "no OSMesa here";
  }
  const Told told = say_of("genioplasty", [](const SurfaceTopology& t, const HeadCommand& planned) {
    const CutBone& cut = std::get<CutBone>(planned);
    const Vec3 n = cut.normal.normalized();
    int32_t jaw = -1;
    double least = 1e9;
    for (size_t k = 0; k < t.view.tri.size(); ++k)
      if (const Vec3& p = t.view.X_mm[size_t(t.view.tri[k][0])];
          t.organ_of(k) == Organ::bone && (p - cut.point_mm).norm() < least)
        least = (p - cut.point_mm).norm(), jaw = t.object[k];
    const auto ring = [&](double up_mm) { return foremost(section(t, jaw, cut.point_mm + up_mm * n, n)); };
    std::vector<Vec3> off = front(ring(0), 12), eight = front(ring(3), 14), back = front(ring(-3), 14), plug = eight;
    off.push_back(off.back() + Vec3(10, 30, 0));  // into the air
    // On its way back it crosses the way there.
    for (size_t i = 0; i < eight.size(); ++i) eight[i] += Vec3(0, 0, -6.0 * double(i) / double(eight.size()));
    std::vector<Vec3> reverse(back.rbegin(), back.rend());
    for (size_t i = 0; i < reverse.size(); ++i) reverse[i] += Vec3(0, 0, -3 + 9.0 * double(i) / double(reverse.size()));
    eight.insert(eight.end(), reverse.begin(), reverse.end());
    plug.insert(plug.end(), back.rbegin(), back.rend());
    plug.push_back(plug.front());
    return std::vector<Deed>{{round(ring(8)), {}},
                             {{}, Undo{}},  // through the roots
                             {off, {}},     // the way ends in the air
                             {eight, {}},   // over itself
                             {plug, {}},    // in the front alone: it does not go through
                             {{cut.point_mm + Vec3(0, 60, 0), cut.point_mm + Vec3(5, 60, 0)}, {}},  // on nothing
                             {round(ring(0)), {}}};
  });
  expect_in_order(told.all,
                  {"mm above the line that is drawn: lead it down", "Too near: the cut comes within",
                   "Ctrl+Z takes it back", "Not done: the contour is too small", "Lead the saw once all round the bone",
                   "Not done: the swept surface meets the other table in several curves",
                   "Not done: the cut does not divide the bone", "Lead the saw once all round the bone",
                   "There is no bone under the saw", "As planned"});
  EXPECT_TRUE(told.first_done) << told.all;
}

}  // namespace test_erring_saw_heads
}  // namespace limberg
