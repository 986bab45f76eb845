// How far skin goes for bone, along the bone's move, and which papers stand beside it.
#include <gtest/gtest.h>

#include "app/head/soft_ratios.h"

namespace limberg {
namespace test_soft_ratios {

const SoftRatio* find(const std::vector<SoftRatio>& all, const std::string& soft) {
  for (const SoftRatio& r : all)
    if (r.soft == soft) return &r;
  return nullptr;
}

const NamedPlaces kBefore = {{"Pog", {0, 90, -90}}, {"pog'", {0, 100, -90}}, {"Ii", {0, 88, -59}},
                             {"li", {0, 103, -62}}, {"Is", {0, 92, -54}},    {"ls", {0, 106, -51}}};

TEST(SoftRatios, AreTakenAlongTheBonesMove) {
  NamedPlaces now = kBefore;
  now[0].second += Vec3(0, 6, 0), now[1].second += Vec3(2, 4.5, -1);  // what goes across does not count
  const std::vector<SoftRatio> r = soft_ratios(kBefore, now);
  ASSERT_EQ(r.size(), 1u);  // the others' bone has not moved
  EXPECT_DOUBLE_EQ(r[0].bone_mm, 6);
  EXPECT_DOUBLE_EQ(r[0].soft_mm, 4.5);
  EXPECT_DOUBLE_EQ(r[0].ratio, 0.75);
  EXPECT_EQ(r[0].of, "chin");                           // the teeth have stayed
  EXPECT_NEAR(r[0].known_high, (11 - 0.8) / 11, 0.01);  // Veltkamp's means
}

TEST(SoftRatios, AMandibleIsNoChin) {
  NamedPlaces now = kBefore;
  for (size_t i : {0, 1, 2, 3}) now[i].second += Vec3(0, i == 3 ? 3 : 6, 0);
  const std::vector<SoftRatio> r = soft_ratios(kBefore, now);
  ASSERT_EQ(r.size(), 2u);
  EXPECT_EQ(find(r, "pog'")->of, "mandible");
  EXPECT_DOUBLE_EQ(find(r, "pog'")->known_low, 1);
  EXPECT_DOUBLE_EQ(find(r, "li")->ratio, 0.5);
  EXPECT_NEAR(find(r, "li")->known_low, (6 - 2.8) / 6, 0.04);
}

TEST(SoftRatios, ASetbackCountsAsAMoveForwards) {
  NamedPlaces now = kBefore;
  now[4].second -= Vec3(0, 4, 0), now[5].second -= Vec3(0, 2.2, 0);
  const std::vector<SoftRatio> r = soft_ratios(kBefore, now);
  ASSERT_EQ(r.size(), 1u);
  EXPECT_NEAR(r[0].ratio, 0.55, 1e-12);
  EXPECT_EQ(r[0].of, "maxilla");
}

TEST(SoftRatios, PapersStandBesideSagittalMovesOnly) {
  NamedPlaces now = kBefore;
  now[4].second += Vec3(0, 1, -4), now[5].second += Vec3(0, 1, -4);
  const std::vector<SoftRatio> r = soft_ratios(kBefore, now);
  ASSERT_EQ(r.size(), 1u);
  EXPECT_DOUBLE_EQ(r[0].ratio, 1);
  EXPECT_EQ(r[0].known_high, 0);
  EXPECT_TRUE(soft_ratios(kBefore, kBefore).empty());
  EXPECT_TRUE(soft_ratios({}, now).empty());
}

}  // namespace test_soft_ratios
}  // namespace limberg
