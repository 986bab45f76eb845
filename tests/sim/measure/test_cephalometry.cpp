// Lengths, angles, asymmetry, motion of fragments, snapping.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "sim/imaging/synthetic/synthetic_head.h"
#include "sim/measure/cephalometry.h"
#include "sim/skull/simplex/generators.h"

namespace limberg {
namespace test_cephalometry {

std::vector<NamedPoint> of_head(const HeadSpec& spec = {}) {
  std::vector<NamedPoint> out;
  for (const auto& [name, p] : head_landmarks(HeadShape(spec))) out.push_back({name, p, 1});
  return out;
}

double value(const std::vector<CephalometricRow>& rows, const std::string& name) {
  for (const CephalometricRow& r : rows)
    if (r.measure->name == name) return r.value.value();
  throw std::runtime_error("no row " + name);
}

TEST(Cephalometry, EveryRowOfASyntheticHeadHasAValueNearItsNorm) {
  const auto rows = cephalometry(of_head());
  EXPECT_EQ(rows.size(), cephalometric_measures().size());
  std::set<std::string> names;
  for (const CephalometricRow& r : rows) {
    names.insert(r.measure->name);
    ASSERT_TRUE(r.value) << r.measure->name;
    EXPECT_TRUE(r.missing.empty());
    EXPECT_GT(r.sd, 0.1);
    EXPECT_LT(r.sd, 15);
    EXPECT_FALSE(r.measure->definition.empty());
    EXPECT_EQ(r.measure->norm.has_value(), !r.measure->source.empty());
    std::printf("%-22s %8.2f %-3s +- %.2f  norm %s\n", r.measure->name.c_str(), *r.value, r.measure->unit.c_str(), r.sd,
                r.measure->norm ? std::to_string(*r.measure->norm).c_str() : "-");
  }
  EXPECT_EQ(names.size(), rows.size());
  EXPECT_NEAR(value(rows, "SNA"), 82, 4);
  EXPECT_NEAR(value(rows, "SNB"), 80, 4);
  EXPECT_NEAR(value(rows, "FMA"), 25, 8);
  EXPECT_NEAR(value(rows, "bizygomatic"), 132, 3);
}

TEST(Cephalometry, KnownPlacesGiveKnownFigures) {
  std::vector<NamedPoint> p = {{"S", {0, 0, 0}, 1},
                               {"N", {0, 70, 0}, 1},
                               {"A", {0, 70 - 50 * std::cos(82 * M_PI / 180), -50 * std::sin(82 * M_PI / 180)}, 1},
                               {"B", {0, 70 - 90 * std::cos(78 * M_PI / 180), -90 * std::sin(78 * M_PI / 180)}, 1},
                               {"PNS", {0, 20, -40}, 1},
                               {"ANS", {0, 70, -40 - 50 * std::tan(8 * M_PI / 180)}, 1},
                               {"Is", {0, 75, -70}, 1},
                               {"Ii", {0, 72, -68}, 1},
                               {"prn", {0, 100, -20}, 1},
                               {"pog'", {0, 80, -100}, 1},
                               {"ls", {0, 90, -60 + 5}, 1}};
  const auto rows = cephalometry(p);
  EXPECT_NEAR(value(rows, "SNA"), 82, 1e-9);
  EXPECT_NEAR(value(rows, "SNB"), 78, 1e-9);
  EXPECT_NEAR(value(rows, "ANB"), 4, 1e-9);
  EXPECT_NEAR(value(rows, "SN-palatal"), 8, 1e-9);  // the palate falls towards the front
  EXPECT_NEAR(value(rows, "overjet"), 3, 1e-12);
  EXPECT_NEAR(value(rows, "overbite"), 2, 1e-12);
  EXPECT_NEAR(value(rows, "S-N"), 70, 1e-12);
  // The line from (100, -20) to (80, -100) is at y = 91.25 at z = -55: ls lies 1.25 behind it, across 1.213.
  EXPECT_NEAR(value(rows, "upper lip to E-line"), -1.25 * 80 / std::hypot(20, 80), 1e-9);
  for (const CephalometricRow& r : rows)
    if (r.measure->name == "S-N") {
      EXPECT_NEAR(r.sd, std::sqrt(2.), 0.02);  // both ends along the line
    }
  // What is missing is named.
  for (const CephalometricRow& r : rows) {
    if (r.measure->name != "FMA") continue;
    EXPECT_FALSE(r.value);
    EXPECT_EQ(r.missing.size(), 7u);
  }
  const std::string csv = to_csv(rows);
  EXPECT_EQ(size_t(std::count(csv.begin(), csv.end(), '\n')), rows.size() + 1);
  EXPECT_NE(csv.find("\"Po_L Po_R Or_L Or_R Go_L Go_R Me\""), std::string::npos);
  // Retrognathia and its correction are seen.
  EXPECT_LT(value(cephalometry(of_head({.mandible_scale = 0.85})), "SNB"), value(cephalometry(of_head()), "SNB") - 3);
}

TEST(Cephalometry, AsymmetryIsThatOfTheHead) {
  const Asymmetry none = asymmetry(of_head());
  EXPECT_TRUE(none.rows.size() >= 12);
  EXPECT_LT(none.rms_mm, 1e-2);
  const Asymmetry ramus = asymmetry(of_head({.ramus_left = 0.8}));
  for (const AsymmetryRow& r : ramus.rows) {
    if (r.name == "Go") {
      EXPECT_NEAR(r.difference_mm.z(), -8.2, 1.5);
    }
    if (r.name == "Zy") {
      EXPECT_LT(r.distance_mm, 1e-2);
    }
  }
  // Turned and moved with the head, it is the same.
  std::vector<NamedPoint> p = of_head({.ramus_left = 0.8});
  const Eigen::Isometry3d T = Eigen::Translation3d(5, -3, 8) * Eigen::AngleAxisd(0.2, Vec3(1, 2, 3).normalized());
  for (NamedPoint& q : p) q.at_mm = T * q.at_mm;
  const Asymmetry turned = asymmetry(p);
  EXPECT_TRUE(turned.fitted);
  EXPECT_NEAR(turned.rms_mm, ramus.rms_mm, 0.05);
}

TEST(Cephalometry, MotionOfAFragmentGivesItsAnglesBack) {
  const double yaw = 12, pitch = -7, roll = 4, d = M_PI / 180;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = (Eigen::AngleAxisd(yaw * d, Vec3::UnitZ()) * Eigen::AngleAxisd(pitch * d, Vec3::UnitX()) *
                Eigen::AngleAxisd(roll * d, Vec3::UnitY()))
                   .toRotationMatrix();
  const Vec3 c(3, 60, -40), by(1, 8, -2);
  T.translation() = c + by - T.linear() * c;
  const FragmentMotion m = fragment_motion(T, c);
  EXPECT_NEAR(m.yaw_deg, yaw, 1e-9);
  EXPECT_NEAR(m.pitch_deg, pitch, 1e-9);
  EXPECT_NEAR(m.roll_deg, roll, 1e-9);
  EXPECT_LT((m.translation_mm - by).norm(), 1e-9);
  EXPECT_GT(m.angle_deg, 12);
}

TEST(Cephalometry, PicksSnapToTheMesh) {
  const simplex::Mesh m = simplex::make_sphere({0, 0, 0}, 50, 3);
  const auto a = snap(m, m.x_mm[7] * 1.1);
  ASSERT_TRUE(a);
  EXPECT_EQ(a->vertex, 7);
  EXPECT_EQ(a->at_mm, m.x_mm[7]);
  EXPECT_NEAR(a->moved_mm, 5, 1e-9);
  const auto b = snap(m, {0, 0, 55}, 0);
  ASSERT_TRUE(b);
  EXPECT_NEAR(b->at_mm.norm(), 50, 1);
  EXPECT_FALSE(snap(m, {0, 0, 200}));
  EXPECT_FALSE(snap(m, {NAN, 0, 0}));
}

}  // namespace test_cephalometry
}  // namespace limberg
