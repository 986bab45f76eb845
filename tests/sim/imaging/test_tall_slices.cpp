// A patient from slices of 3 mm in which ear canals are seen: as large as it is, porions in the canals' rims.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "sim/geometry/bvh.h"
#include "sim/imaging/anatomy/ear_canal.h"
#include "sim/imaging/anatomy/patient_model.h"
#include "sim/skull/simplex/dual.h"

namespace limberg {
namespace test_tall_slices {

TEST(EarCanal, IsFoundWhereItIsAndNotWhereNoneIs) {
  InlineWorkers w;
  std::map<std::string, Vec3> truth;
  for (const auto& [name, x] : head_landmarks(HeadShape({}))) truth[name] = x;
  Mat3 head = Mat3::Identity();
  head(0, 0) = head(1, 1) = -1;  // the picture's frame is left, posterior, superior
  for (const bool canals : {true, false}) {
    HeadCt c;
    c.ear_canals = canals;
    const Volume ct = head_ct({}, 2, w, c);
    for (const double side : {1., -1.}) {
      const Vec3 po = truth.at(side > 0 ? "Po_R" : "Po_L"), off(4, -5, 6);  // as a laid skull may be off
      const auto found = find_ear_canal(ct, 0, 250, head * (po + off), head, side);
      ASSERT_EQ(found.has_value(), canals) << side;
      if (!canals) continue;
      // Upwards and outwards the rim thins out to nothing: its last millimetre or two are below what a voxel of 2 mm
      // shows (1.3 and 1.4 mm up, 2026-11-27).
      const Vec3 at = head.transpose() * found->porion_mm;
      EXPECT_NEAR(at.z(), po.z(), 1.6) << side;
      EXPECT_NEAR(at.y(), po.y(), 1.5) << side;
      EXPECT_NEAR(at.x(), po.x(), 4) << side;
      EXPECT_LT(found->air_HU, -500);
    }
  }
}

TEST(TallSlices, OfThreeMillimetresMakeABoneOfItsSize) {
  InlineWorkers w;
  HeadCt c;
  c.slices_in_one = 2, c.ear_canals = true;
  const HeadSpec spec;
  const HeadShape shape(spec);
  const PatientModel p = make_patient(head_ct(spec, 1.5, w, c), {}, make_head({}, w), w);
  ASSERT_EQ(p.bone.size(), 2u);
  double skull = 0, mandible = 0;
  const Vec3 lo = HeadShape::low_mm(), hi = HeadShape::high_mm();
  for (double x = lo.x(); x < hi.x(); ++x)
    for (double y = lo.y(); y < hi.y(); ++y)
      for (double z = lo.z(); z < hi.z(); ++z) {
        const Vec3 q(x, y, z);
        skull += std::max(shape.skull(q), -shape.sinus(q)) < 0, mandible += shape.mandible(q) < 0;
      }
  EXPECT_NEAR(p.bone[0].volume_cm3, 1e-3 * skull, 0.05 * 1e-3 * skull);  // the bar of the issue
  // 5.0 % too small in pixels of 1.5 mm, .7 % in such of 1 mm, for which a test has no time (2026-11-27).
  EXPECT_NEAR(p.bone[1].volume_cm3, 1e-3 * mandible, 0.06 * 1e-3 * mandible);
  const Eigen::Isometry3d back = p.anatomy.to_head.inverse();
  for (const PatientBone& b : p.bone) {
    EXPECT_GT(b.cortex.found, 0.9 * b.cortex.vertices) << b.name;
    std::vector<double> off;
    for (const Vec3& x : b.mesh.x_mm) {
      const Vec3 q = back * x;
      off.push_back(std::abs(b.name == "mandible" ? shape.mandible(q) : std::max(shape.skull(q), -shape.sinus(q))));
    }
    std::sort(off.begin(), off.end());
    EXPECT_LT(off[off.size() / 2], 0.3) << b.name;
    EXPECT_LT(off[off.size() * 9 / 10], 0.75) << b.name;  // a quarter of a slice
  }
  EXPECT_EQ(p.anatomy.ear_canals, 2);
  // In the frame of the surfaces, which is that of the shape here.
  std::map<std::string, Vec3> truth;
  for (const auto& [name, x] : head_landmarks(shape)) truth[name] = x;
  int seen = 0;
  for (const FoundLandmark& l : p.anatomy.landmark) {
    const double off = truth.contains(l.name) ? (back * l.at_mm - truth[l.name]).norm() : 0;
    if (l.name == "Po_R" || l.name == "Po_L") {
      EXPECT_LT(off, 4) << l.name;
      ++seen;
    }
    // What level profiles hide is stated.
    if (l.name == "N" || l.name == "G") {
      EXPECT_LT(off, 2 * std::sqrt(3.) * l.sd_mm) << l.name;
      ++seen;
    }
  }
  EXPECT_EQ(seen, 4);
}

}  // namespace test_tall_slices
}  // namespace limberg
