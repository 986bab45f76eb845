#include "sim/imaging/anatomical/anatomical_head.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "sim/base/error.h"
#include "sim/imaging/anatomical/bone_shape.h"

namespace limberg {
namespace {

using anatomical::BoneShape;
using anatomical::SkinShape;

constexpr double kSpread = 0.22;  // how fast edges grow away from what is fine
constexpr double kBoneCell_mm = 2.4, kSkinCell_mm = 3.5;
const Vec3 kLow(-105, -122, -118), kHigh(105, 138, 142);

struct Fine {
  Vec3 c;
  double r, edge;
};
const Fine kFineSkin[] = {{{31.5, 80, 15}, 19, 1.15}, {{0, 103, -54}, 15, 1.5}, {{18, 98, -55}, 13, 1.5},
                          {{0, 110, -28}, 18, 1.6},   {{78, -14, 3}, 30, 1.6},  {{0, 100, 0}, 20, 2.4},
                          {{0, 90, -90}, 20, 2.6},    {{30, 85, -25}, 25, 3.0}};
const Fine kFineBone[] = {{{51, 12, -7}, 16, 1.7},  {{0, 97, -12}, 22, 2.0}, {{31, 78, 12}, 22, 2.2},
                          {{24, 62, -15}, 16, 2.0}, {{9, 86, 30}, 12, 1.7},  {{5, 78, 12}, 14, 2.0},
                          {{17, 42, -22}, 16, 2.0}, {{0, 66, -32}, 30, 2.4}, {{50, 40, -6}, 22, 2.4},
                          {{0, 80, -82}, 26, 2.6}};

template <size_t N>
double finest(const Fine (&zones)[N], const Vec3& p, double coarse) {
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  double edge = coarse;
  for (const Fine& z : zones) edge = std::min(edge, z.edge + kSpread * std::max(0., (q - z.c).norm() - z.r));
  return edge;
}

simplex::Mesh surface_of(std::function<double(const Vec3&)> f, double lipschitz, const Vec3& low, const Vec3& high,
                         double grid, double edge, std::function<double(const Vec3&)> edge_at, Workers& workers,
                         LevelSetReport& report) {
  LevelSet s;
  s.distance_mm = std::move(f), s.lipschitz = lipschitz, s.low_mm = low, s.high_mm = high;
  LevelSetSettings settings;
  settings.grid_mm = std::min(grid, 0.9 * edge), settings.edge_mm = edge, settings.edge_at = std::move(edge_at);
  return mesh_level_set(s, settings, workers, &report);
}

std::vector<std::pair<std::string, Vec3>> landmarks_on(const SkinShape& skin, const BoneShape& bone) {
  std::vector<std::pair<std::string, Vec3>> out =
      landmarks_by(anatomical_landmark_rules(), {[&](const Vec3& p) { return bone.skull(p); },
                                                 [&](const Vec3& p) { return bone.mandible(p); },
                                                 [&](const Vec3& p) { return skin(p); },
                                                 BoneShape::kLipschitz,
                                                 {}});
  out.insert(out.begin(), {"S", Vec3(0, 20, 15.5)});
  return out;
}

}  // namespace

std::vector<std::pair<std::string, Vec3>> anatomical_landmarks() {
  const SkinShape skin;
  return landmarks_on(skin, BoneShape(skin));
}

HeadModel make_anatomical_head(const HeadSpec& spec, Workers& workers) {
  for (const double e : {spec.edge_mm, spec.face_edge_mm})
    if (!(e >= 1.5 && e <= 12)) throw InputError("", 0, "edges of an anatomical head of 1.5 to 12 mm were expected");
  const SkinShape skin;
  const BoneShape bone(skin);
  HeadModel out;
  const auto at_teeth = [&](double teeth, const Vec3& p) {
    return std::min(finest(kFineBone, p, spec.edge_mm), 1.1 + 0.3 * std::max(0., teeth - 0.5));
  };
  out.cranium =
      surface_of([&](const Vec3& p) { return bone.skull(p); }, BoneShape::kLipschitz, {kLow.x(), kLow.y(), -66}, kHigh,
                 kBoneCell_mm, spec.edge_mm, [&](const Vec3& p) { return at_teeth(bone.upper_teeth(p), p); }, workers,
                 out.cranium_report);
  out.mandible =
      surface_of([&](const Vec3& p) { return bone.mandible(p); }, BoneShape::kLipschitz, {-72, -12, -112}, {72, 116, 4},
                 kBoneCell_mm, spec.edge_mm, [&](const Vec3& p) { return at_teeth(bone.lower_teeth(p), p); }, workers,
                 out.mandible_report);
  out.face = surface_of([&](const Vec3& p) { return skin(p); }, SkinShape::kLipschitz, kLow, kHigh, kSkinCell_mm,
                        spec.face_edge_mm, [&](const Vec3& p) { return finest(kFineSkin, p, spec.face_edge_mm); },
                        workers, out.face_report);
  out.landmarks = landmarks_on(skin, bone);
  return out;
}

}  // namespace limberg
