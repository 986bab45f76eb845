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
                             {{}, Undo{}},
                             {{cut.point_mm + Vec3(0, 60, 0), cut.point_mm + Vec3(5, 60, 0)}, {}},  // on nothing
                             {round(ring(0)), {}}};
  });
  expect_in_order(told.all,
                  {"mm above the line that is drawn: lead it down", "Too near: the cut comes within",
                   "Ctrl+Z takes it back", "Not done: the contour is too small", "Lead the saw once all round the bone",
                   "Not done: the swept surface meets the other table in several curves", "So far as planned: ",
                   "lead the saw all round at once", "There is no bone under the saw", "As planned"});
  EXPECT_TRUE(told.first_done) << told.all;
}

TEST(ErringSawOnHeads, AMaxillaIsSawnFreeByTwoLinesAndNoOtherBoneCounts) {
  LIMBERG_NEEDS_BULLET();
  try {
    make_osmesa_context();
  } catch (const RenderUnavailable&) {
    GTEST_SKIP() << "no OSMesa here";
  }
  const Told told = say_of("le_fort_1", [](const SurfaceTopology& t, const HeadCommand& planned) {
    const auto halves = planned_lines(t, planned);
    EXPECT_EQ(halves.size(), 2u) << "the maxilla hangs on both sides of the nose";
    std::vector<Vec3> low = halves[0], ramus;
    for (Vec3& p : low) p += Vec3(0, 0, -3.8);
    // On the plane behind the palate, where that meets the mandible.
    for (const auto& line : section(t, 1, std::get<CutBoneByBlade>(planned).corner_mm, Vec3(0, 1, -0.019)))
      if (line.size() > 20) ramus = line;
    return std::vector<Deed>{{round(ramus), {}},
                             {{}, Undo{}},
                             {round(low), {}},
                             {{}, Undo{}},
                             {{halves[0][0], halves[0][1], halves[0][2], halves[0][3]}, {}},
                             {{Vec3(0, 160, 0), Vec3(5, 160, 0)}, {}},
                             {round(halves[0]), {}},
                             {round(halves[1]), {}}};
  });
  expect_in_order(told.all, {"elsewhere than planned", "Too near: the cut comes within", "too short, or does not close",
                             "There is no bone under the saw", "So far as planned: ", "As planned"});
  EXPECT_EQ(told.all.find("As planned"), told.all.rfind("As planned")) << "once, of the second half\n" << told.all;
  EXPECT_TRUE(told.first_done) << told.all;
  EXPECT_EQ(told.bones, 3u);
  EXPECT_TRUE(told.refused.empty());
}

TEST(ErringSawOnHeads, BothRamiAreSplitByHandAndAMidfaceByThreeLines) {
  LIMBERG_NEEDS_BULLET();
  try {
    make_osmesa_context();
  } catch (const RenderUnavailable&) {
    GTEST_SKIP() << "no OSMesa here";
  }
  const auto all_lines = [](const std::string& lesson, size_t lines, bool chin_first) {
    return say_of(lesson, [=](const SurfaceTopology& t, const HeadCommand&) {
      std::vector<Deed> deeds;
      if (chin_first) {
        deeds.push_back({round(foremost(section(t, 1, Vec3(0, 77.3, -90.2), Vec3(0, 0.08, 0.997)))), {}});
        deeds.push_back({{}, Undo{}});
      }
      size_t n = 0;
      for (const Command& c : test::shipped_commands(lesson))
        if (const auto* h = std::get_if<HeadCommand>(&c); h && std::holds_alternative<CutBoneByBlade>(*h))
          for (const auto& line : planned_lines(t, *h)) deeds.push_back({round(line), {}}), ++n;
      EXPECT_EQ(n, lines);
      return deeds;
    });
  };
  const Told split = all_lines("sagittal_split", 2, true);
  expect_in_order(split.all, {"elsewhere than planned", "Ctrl+Z takes it back", "As planned", "As planned"});
  EXPECT_EQ(split.bones, 4u);
  const Told midface = all_lines("le_fort_3", 3, false);
  expect_in_order(midface.all, {"So far as planned: 8", "So far as planned: 94 %", "As planned"});
  EXPECT_EQ(midface.bones, 3u);
  EXPECT_TRUE(midface.first_done);
}

TEST(ErringSawOnHeads, AForeheadIsSawnBesideItsLineThenAlongIt) {
  LIMBERG_NEEDS_BULLET();
  try {
    make_osmesa_context();
  } catch (const RenderUnavailable&) {
    GTEST_SKIP() << "no OSMesa here";
  }
  const Told told = say_of("craniofacial", [](const SurfaceTopology&, const HeadCommand& planned) {
    const std::vector<Vec3>& line = std::get<CutBone>(planned).contour_mm;
    std::vector<Vec3> high = line;
    for (Vec3& p : high) p += Vec3(0, 0, 8);
    return std::vector<Deed>{{{line[0], line[1], line[2]}, {}}, {round(high), {}}, {round(line), {}}};
  });
  expect_in_order(told.all, {"too short, or does not close", "above the line that is drawn: lead it down",
                             "Not done: ", "Lead the saw once all round the bone", "As planned"});
  EXPECT_TRUE(told.first_done) << told.all;
}

// The panel's saw, whose plane reaches all of the bone: Le Fort I cuts more loose than the maxilla.
TEST(ErringSawOnHeads, APlaneWithoutAnEndFreesMoreThanIsPlanned) {
  LIMBERG_NEEDS_BULLET();
  try {
    make_osmesa_context();
  } catch (const RenderUnavailable&) {
    GTEST_SKIP() << "no OSMesa here";
  }
  const Told told = say_of("le_fort_1", [](const SurfaceTopology&, const HeadCommand& planned) {
    const auto& blade = std::get<CutBoneByBlade>(planned);
    CutBone all;
    all.point_mm = {0, blade.corner_mm.y() + 50, blade.corner_mm.z()}, all.normal = {0, 0.019, 1};
    return std::vector<Deed>{{{}, HeadCommand(all)}};
  });
  EXPECT_GT(told.bones, 3u) << "two are there at first, and one more is planned";
  expect_in_order(told.all, {"pieces came free, and one is planned", "Ctrl+Z takes it back"});
  EXPECT_EQ(told.all.find("As planned"), std::string::npos) << told.all;
}

}  // namespace test_erring_saw_heads
}  // namespace limberg
