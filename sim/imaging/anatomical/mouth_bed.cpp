#include "sim/imaging/anatomical/mouth_bed.h"

#include <algorithm>

#include "sim/imaging/anatomical/fields.h"
#include "sim/imaging/fit/graded_grid.h"
#include "sim/imaging/fit/thinning.h"

namespace limberg {
namespace {

using anatomical::smax;
using anatomical::smin;

// Gums are so thick over bone, leave the crowns of teeth bare and so much tissue before them. As far from the middle as
// this nothing of the bed is seen or touched.
constexpr double kGums_mm = 1.2, kBareTooth_mm = 0.05, kLeastTissue_mm = 6;
constexpr double kBedWide_mm = 36, kBedBack_mm = 58, kBedLow_mm = -88, kBedHigh_mm = -30, kBedRound_mm = 1.5;
constexpr double kEnough_mm = 6;  // farther away a rough distance will do
constexpr double kToothCell_mm = 1, kToothEdge_mm = 1.1, kGumCell_mm = 2, kGumEdge_mm = 2.2;

double beyond_bed(const Vec3& p) {
  return std::max({std::abs(p.x()) - kBedWide_mm, kBedBack_mm - p.y(), kBedLow_mm - p.z(), p.z() - kBedHigh_mm});
}

TriMesh mesh_of(std::function<double(const Vec3&)> f, double cell_mm, double edge_mm, Workers& workers) {
  LevelSet set;
  set.distance_mm = std::move(f);
  set.lipschitz = MouthBed::kLipschitz;
  set.low_mm = {-kBedWide_mm - 4, kBedBack_mm - 4, kBedLow_mm - 4},
  set.high_mm = {kBedWide_mm + 4, 112, kBedHigh_mm + 4};
  TriMesh m;
  march_graded(
      set, [&](const Vec3&) { return cell_mm; }, workers, m.X_mm, m.tri);
  thin_edges(m.X_mm, m.tri, set, [&](const Vec3&) { return edge_mm; });
  return m;
}

}  // namespace

MouthBed::MouthBed(const anatomical::SkinShape& skin)
    : skin_(&skin), bone_(std::make_shared<anatomical::BoneShape>(skin)) {}

double MouthBed::teeth(const Vec3& p) const {
  const double far = beyond_bed(p);
  return far > kEnough_mm ? far : smax(smin(bone_->upper_teeth(p), bone_->lower_teeth(p), 0.1), far, kBedRound_mm);
}

double MouthBed::gums(const Vec3& p) const {
  const double far = std::max(beyond_bed(p), (*skin_)(p) + kLeastTissue_mm);
  if (far > kEnough_mm) return far;
  const double over_bone = smin(bone_->skull(p), bone_->mandible(p), 2) - kGums_mm;
  return smax(smax(over_bone, kBareTooth_mm - teeth(p), 0.1), far, kBedRound_mm);
}

double MouthBed::operator()(const Vec3& p) const { return std::min(teeth(p), gums(p)); }

MouthBedMeshes make_mouth_bed(const MouthBed& bed, Workers& workers) {
  MouthBedMeshes m;
  m.teeth = mesh_of([&](const Vec3& p) { return bed.teeth(p); }, kToothCell_mm, kToothEdge_mm, workers);
  m.gums = mesh_of([&](const Vec3& p) { return bed.gums(p); }, kGumCell_mm, kGumEdge_mm, workers);
  keep_largest(m.gums.X_mm, m.gums.tri);
  return m;
}

}  // namespace limberg
