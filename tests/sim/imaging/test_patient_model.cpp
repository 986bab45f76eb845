// A patient from the CT of a head whose shape is known, lying turned in the scanner: bone, parts, landmarks, frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/base/error.h"
#include "sim/geometry/bvh.h"
#include "sim/geometry/validate.h"
#include "sim/imaging/anatomy/patient_flesh.h"
#include "sim/imaging/anatomy/patient_model.h"
#include "sim/skull/simplex/dual.h"

namespace limberg {
namespace test_patient_model {

constexpr double kVoxel_mm = 2;

Mat3 turn_of(double pitch_deg, double roll_deg, double yaw_deg) {
  const double d = M_PI / 180;
  return (Eigen::AngleAxisd(yaw_deg * d, Vec3::UnitZ()) * Eigen::AngleAxisd(roll_deg * d, Vec3::UnitY()) *
          Eigen::AngleAxisd(pitch_deg * d, Vec3::UnitX()))
      .toRotationMatrix();
}

/// A jaw that is short and lower on the left, in voxels of 2 mm, the head turned in the picture; numbers as HU + 1024.
struct Case {
  HeadSpec spec{.mandible_scale = 0.92, .ramus_left = 0.95};
  HeadShape shape{spec};
  Volume ct;
  PatientModel patient;
  std::map<std::string, Vec3> truth;  // in the frame that its porions and orbitals say
  Eigen::Isometry3d frame;            // of the truth, from that of head_shape.h
};

const Case& turned() {
  static const Case c = [] {
    Case out;
    InlineWorkers w;
    out.ct = head_ct(out.spec, kVoxel_mm, w);
    const Mat3 R = turn_of(9, 4, -6);
    out.ct.step_mm = R * out.ct.step_mm, out.ct.origin_mm = R * out.ct.origin_mm + Vec3(20, -110, 300);
    for (float& x : out.ct.value) x += 1024;
    out.patient = make_patient(out.ct, {}, make_head({}, w), w);
    for (const auto& [name, x] : head_landmarks(out.shape)) out.truth[name] = x;
    const Vec3 po = 0.5 * (out.truth["Po_L"] + out.truth["Po_R"]), orb = 0.5 * (out.truth["Or_L"] + out.truth["Or_R"]);
    const Vec3 x = Vec3::UnitX(), y = (orb - po - x * x.dot(orb - po)).normalized();
    Mat3 F;
    F.row(0) = x, F.row(1) = y, F.row(2) = x.cross(y);
    out.frame.linear() = F, out.frame.translation() = -F * po;
    for (auto& [name, at] : out.truth) at = out.frame * at;
    return out;
  }();
  return c;
}

/// Signed distance to the true bone (air in the sinuses is none) at a place in the frame of the head.
double to_bone(const Case& c, const Vec3& x, bool mandible) {
  const Vec3 p = c.frame.inverse() * x;
  return mandible ? c.shape.mandible(p) : std::max(c.shape.skull(p), -c.shape.sinus(p));
}

void numbers_are_recognised() {
  std::string why;
  EXPECT_EQ(turned().patient.offset, 1024);
  Volume v = turned().ct;
  for (float& x : v.value) x -= 1024;
  EXPECT_EQ(hounsfield_offset(v, why), 0);
  for (float& x : v.value) x = 3 * x + 7000;
  EXPECT_THROW(hounsfield_offset(v, why), InputError);
  // As an MRI would show it: air and bone dark, fat brightest, muscle grey, and a coil that sees one side better.
  v = turned().ct;
  for (size_t i = 0; i < v.value.size(); ++i) {
    const double hu = double(v.value[i]) - 1024, near = 1 + double(i % size_t(v.size[0])) / v.size[0];
    v.value[i] = float(near * (hu < -500 ? 12 : hu < -20 ? 420 : hu < 150 ? 260 : 25));
  }
  EXPECT_THROW(hounsfield_offset(v, why), InputError);
}

void skull_and_mandible_are_parted_as_they_are() {
  const PatientModel& p = turned().patient;
  ASSERT_EQ(p.bone.size(), 2u);
  EXPECT_EQ(p.bone[0].name, "cranium");
  EXPECT_EQ(p.bone[1].name, "mandible");
  EXPECT_TRUE(p.parts.mandible.made);
  EXPECT_FALSE(p.parts.spine.made);
  // Every vertex lies on the bone it is said to be of: far from the other one but at the joints, which touch.
  for (size_t b = 0; b < 2; ++b) {
    EXPECT_EQ(simplex::find_fault(p.bone[b].mesh).value_or(""), "");
    EXPECT_EQ(simplex::census(p.bone[b].mesh).end_contours, 0);
    int64_t wrong = 0, all = 0;
    for (const Vec3& x : p.bone[b].mesh.x_mm)
      wrong += std::abs(to_bone(turned(), x, b == 1)) > std::abs(to_bone(turned(), x, b == 0)) + kVoxel_mm, ++all;
    EXPECT_LT(double(wrong), 0.005 * double(all)) << p.bone[b].name;
  }
}

void surfaces_lie_on_bone_to_a_tenth_of_a_voxel_at_the_median() {
  // Half a voxel is the bar for thickness (both surfaces), a quarter for a surface.
  for (size_t b = 0; b < 2; ++b) {
    std::vector<double> off;
    for (const Vec3& x : turned().patient.bone[b].mesh.x_mm) off.push_back(std::abs(to_bone(turned(), x, b == 1)));
    std::sort(off.begin(), off.end());
    EXPECT_LT(off[off.size() / 2], 0.25 * kVoxel_mm);
    EXPECT_LT(off[off.size() * 9 / 10], 0.5 * kVoxel_mm);
  }
}

void volumes_are_right_within_five_percent() {
  const double h = 1;
  double skull = 0, mandible = 0;
  const Vec3 lo = HeadShape::low_mm(), hi = HeadShape::high_mm();
  const HeadShape& s = turned().shape;
  for (double x = lo.x(); x < hi.x(); x += h)
    for (double y = lo.y(); y < hi.y(); y += h)
      for (double z = lo.z(); z < hi.z(); z += h) {
        const Vec3 p(x, y, z);
        skull += std::max(s.skull(p), -s.sinus(p)) < 0, mandible += s.mandible(p) < 0;
      }
  EXPECT_NEAR(turned().patient.bone[0].volume_cm3, 1e-3 * skull, 0.05 * 1e-3 * skull);
  EXPECT_NEAR(turned().patient.bone[1].volume_cm3, 1e-3 * mandible, 0.05 * 1e-3 * mandible);
}

void the_vault_is_as_thick_as_it_is() {
  const simplex::FanTriangles fan = simplex::fan_triangles(turned().patient.bone[0].mesh);
  const Bvh bvh(fan.X_mm, fan.tri);
  const Vec3 middle = turned().frame * Vec3(0, 0, 55);
  double sum = 0;
  int count = 0;
  for (int i = 0; i < 200; ++i) {  // directions over the upper half (Fibonacci)
    const double z = 0.2 + 0.8 * (i + 0.5) / 200, a = 2.39996322972865 * i, r = std::sqrt(1 - z * z);
    const Vec3 d(r * std::cos(a), r * std::sin(a), z);
    const auto hit = bvh.line(middle, d, 0, 200);
    double inner = 0, outer = 0;
    for (double t = 0; t < 160; t += 0.05) {
      const bool in = to_bone(turned(), middle + t * d, false) < 0;
      if (in && inner == 0) inner = t;
      if (in) outer = t;
    }
    if (hit.size() != 2 || inner == 0) continue;
    sum += std::abs(hit[1].t - hit[0].t - (outer - inner)), ++count;
  }
  EXPECT_GT(count, 150);
  EXPECT_LT(sum / count, 0.5 * kVoxel_mm);  // the bar of the issue: .3 mm or half a voxel
}

void landmarks_and_frame_are_found() {
  const Anatomy& a = turned().patient.anatomy;
  double sum[2] = {0, 0};  // on bone, on the skin
  int count[2] = {0, 0}, within[2] = {0, 0};
  std::map<std::string, Vec3> at;
  for (const FoundLandmark& l : a.landmark) {
    at[l.name] = l.at_mm;
    const auto t = turned().truth.find(l.name);
    if (t == turned().truth.end()) continue;
    const double off = (l.at_mm - t->second).norm();
    sum[l.on_skin] += off, ++count[l.on_skin], within[l.on_skin] += off < 2 * std::sqrt(3.) * l.sd_mm;
  }
  for (const int skin : {0, 1}) {
    std::printf("%s: mean %.2f mm of %d landmarks, %d within twice what is stated\n", skin ? "skin" : "bone",
                sum[skin] / count[skin], count[skin], within[skin]);
    EXPECT_GE(count[skin], 24);
    EXPECT_GE(within[skin], count[skin] - 1);
  }
  EXPECT_LT(sum[0] / count[0], 1.5);  // the bar of the issue; on the skin the nose's wings are as laid
  EXPECT_LT((sum[0] + sum[1]) / (count[0] + count[1]), 1.5);
  // Sides and signs.
  EXPECT_GT(at["Po_R"].x(), 50);
  EXPECT_LT(at["Po_L"].x(), -50);
  EXPECT_GT(at["N"].y(), 60);
  EXPECT_LT(at["Me"].z(), -60);
  const double overjet = at["Is"].y() - at["Ii"].y(), truth = turned().truth.at("Is").y() - turned().truth.at("Ii").y();
  EXPECT_GT(truth, 3);
  EXPECT_NEAR(overjet, truth, 2 * 1.5);  // two landmarks
}

/// What can be cut lies within the skin and before bone, nearly as deep as bone lies where that is not far.
void flesh_lies_between_skin_and_bone() {
  InlineWorkers w;
  const PatientModel& p = turned().patient;
  const PatientFlesh f = make_patient_flesh(p, w);
  ASSERT_EQ(f.part.size(), f.tri.size());
  TriMesh mesh;
  mesh.X_mm = f.X_mm, mesh.tri = f.tri;
  const RestGrid grid{{0, 60, 0}};
  for (Vec3& x : mesh.X_mm) x = grid.to_mm(grid.to_grid(x));
  const SurfaceReport r = validate_surface(mesh, grid, "flesh");  // closed, of one part, nowhere in itself
  EXPECT_EQ(r.genus, 0);
  const simplex::FanTriangles skin = simplex::fan_triangles(p.face);
  const Bvh on_skin(skin.X_mm, skin.tri);
  double off_skin = 0, off_bone = 0;
  size_t of_skin = 0, of_bone = 0;
  for (size_t k = 0; k < f.tri.size(); ++k) {
    const Vec3 x = (f.X_mm[size_t(f.tri[k][0])] + f.X_mm[size_t(f.tri[k][1])] + f.X_mm[size_t(f.tri[k][2])]) / 3;
    EXPECT_GT(x.y(), kFleshBack_mm - 0.5);
    if (f.part[k] == FleshPart::skin) off_skin += on_skin.closest(x).distance_mm, ++of_skin;
    if (f.part[k] == FleshPart::bone)
      off_bone += std::abs(std::min(to_bone(turned(), x, false), to_bone(turned(), x, true))), ++of_bone;
  }
  EXPECT_GT(of_skin, 2000u);
  EXPECT_GT(of_bone, 500u);
  EXPECT_LT(off_skin / double(of_skin), 0.2);
  EXPECT_LT(off_bone / double(of_bone), kVoxel_mm);
  EXPECT_GT(f.over_bone, 0.3);
}

// One test: the patient is made once, in half a minute.
TEST(PatientModel, IsTheHeadThatWasInTheScanner) {
  {
    SCOPED_TRACE("numbers are recognised");
    numbers_are_recognised();
  }
  {
    SCOPED_TRACE("skull and mandible are parted as they are");
    skull_and_mandible_are_parted_as_they_are();
  }
  {
    SCOPED_TRACE("surfaces lie on bone to a tenth of a voxel at the median");
    surfaces_lie_on_bone_to_a_tenth_of_a_voxel_at_the_median();
  }
  {
    SCOPED_TRACE("volumes are right within five percent");
    volumes_are_right_within_five_percent();
  }
  {
    SCOPED_TRACE("the vault is as thick as it is");
    the_vault_is_as_thick_as_it_is();
  }
  {
    SCOPED_TRACE("flesh lies between skin and bone");
    flesh_lies_between_skin_and_bone();
  }
  {
    SCOPED_TRACE("landmarks and frame are found");
    landmarks_and_frame_are_found();
  }
}

}  // namespace test_patient_model
}  // namespace limberg
