#include "sim/imaging/anatomy/patient_model.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/imaging/fit/prepare.h"
#include "sim/imaging/fit/shape_interpolation.h"
#include "sim/skull/simplex/dual.h"

namespace limberg {

namespace {

constexpr double kBin = 20, kAirWithin = 130;  // HU
constexpr int kThinTissuePercent = 50;         // the one real head at hand has 14 (2026-11-29)
constexpr double kTallSlice = 1.5,
                 kTallSlice_mm = 1.8;    // slices are interpolated when longer than this times a pixel, and this
constexpr double kThinWallVoxel_mm = 2;  // in longer voxels crests of soft tissue pass for walls
// Compact bone in Hounsfield units, of which the one is taken that fits (cortex_fit.h).
constexpr double kCompact_HU[] = {1000, 1100, 1200, 1300};
constexpr double kLeastBone_cm3 = 2;  // smaller parts are left out

void move(simplex::Mesh& m, const Eigen::Isometry3d& by) {
  for (std::vector<Vec3>* places : {&m.x_mm, &m.before_mm})
    for (Vec3& x : *places) x = by * x;
}

}  // namespace

/// Of a head's tissue in a CT most has the density of water, give or take; what lies between that and air is hair, the
/// skin's outermost voxels and the rims of cavities. In an MRI whose air is 0, taken for a CT, it is the other way
/// round. In percent; 0 where nothing is denser than air.
int thin_tissue_percent(const Volume& v, double offset) {
  int64_t thin = 0, soft = 0;
  for (const float x : v.value) {
    const double hu = double(x) - offset;
    thin += hu > -850 && hu < -250, soft += hu >= -250;
  }
  return thin + soft > 0 ? int(100 * thin / (thin + soft)) : 0;
}

double hounsfield_offset(const Volume& v, std::string& why) {
  const auto [low, high] = std::minmax_element(v.value.begin(), v.value.end());
  const double least = double(*low);
  std::vector<int64_t> count(size_t(std::min(400., (double(*high) - least) / kBin)) + 1, 0);
  for (const float x : v.value)
    if (const double b = (double(x) - least) / kBin; b < double(count.size())) ++count[size_t(b)];
  // Air is the value that most voxels have within 1500 of the least one.
  size_t best = 0;
  for (size_t b = 0; b < count.size() && double(b) * kBin < 1500; ++b)
    if (count[b] > count[best]) best = b;
  const double air = least + (double(best) + 0.5) * kBin;
  if (std::abs(air + 1000) <= kAirWithin) {
    why = "air lies near " + std::to_string(int(air)) + ": Hounsfield units";
    return 0;
  }
  if (std::abs(air) <= kAirWithin) {
    if (const int thin = thin_tissue_percent(v, 1024); thin > kThinTissuePercent)
      throw InputError("", 0,
                       "these are no numbers of a CT: with air at " + std::to_string(int(air)) + " " +
                           std::to_string(thin) +
                           " % of what is not air would be thinner than fat; expected a CT of a head (--offset says "
                           "otherwise; an MRI does not show bone, its skin alone is fitted by limberg fit --iso)");
    why = "air lies near " + std::to_string(int(air)) + ": the numbers are taken for Hounsfield units and 1024";
    return 1024;
  }
  throw InputError(
      "", 0,
      "these are no numbers of a CT: most of the darkest voxels have about " + std::to_string(int(air)) +
          "; expected air at -1000 Hounsfield units or at 0 (--offset says otherwise; an MRI does not show "
          "bone)");
}

PatientModel make_patient(const Volume& given, const PatientSettings& s, const HeadModel& atlas, Workers& workers) {
  PatientModel out;
  const auto say = [&](const std::string& what) {
    if (s.progress) s.progress(what);
  };
  if (s.offset)
    out.offset = *s.offset, out.offset_why = "as asked";
  else
    out.offset = hounsfield_offset(given, out.offset_why);
  out.bone_volume = out.skin_volume = given;
  const double longest = longest_step_mm(given), shortest = shortest_step_mm(given);
  if (longest > kTallSlice * shortest && longest > kTallSlice_mm) {
    say("slices between tall ones");
    const double step = std::max(shortest, 1.);
    out.bone_volume = interpolated_by_shape(given, s.bone_HU + out.offset, step, workers);
    out.skin_volume = interpolated_by_shape(given, s.skin_HU + out.offset, step, workers);
    if (out.bone_volume.size != given.size)
      out.notes.push_back("slices of " + std::to_string(longest).substr(0, 4) +
                          " mm are tall: ones in between were made by shape");
  }
  say("bone");
  BoneSolidSettings q;
  q.iso = s.bone_HU + out.offset, q.body = s.skin_HU + out.offset, q.step_mm = s.step_mm;
  if (longest <= kThinWallVoxel_mm)
    q.thin = s.thin_HU + out.offset;
  else
    out.notes.push_back("voxels are longer than 2 mm: walls of bone thinner than one are lost where they fall below " +
                        std::to_string(int(s.bone_HU)) + " HU");
  BoneSolid solid = bone_solid(out.bone_volume, q, workers);
  say("skull, mandible, spine");
  out.parts = part_bones(solid, q.iso, workers);
  std::vector<double> compact;
  for (const double c : kCompact_HU) compact.push_back(c + out.offset);
  for (const BonePart part : {BonePart::skull, BonePart::mandible, BonePart::spine}) {
    const double cm3 = part == BonePart::skull      ? out.parts.skull_cm3
                       : part == BonePart::mandible ? out.parts.mandible_cm3
                                                    : out.parts.spine_cm3;
    if (cm3 < kLeastBone_cm3) continue;
    PatientBone b;
    b.name = part == BonePart::skull ? "cranium" : part == BonePart::mandible ? "mandible" : "spine";
    say("surface of the " + b.name);
    const BoneSolid own = only(solid, out.parts, part, workers);
    LevelSetSettings l;
    l.grid_mm = own.step_mm, l.edge_mm = s.edge_mm;
    b.mesh = mesh_level_set(surface_of(own), l, workers, &b.surface);
    // The picture between voxels that were there, not smoothed: smoothing is one more blur.
    b.cortex = out.bone_volume.size == given.size
                   ? put_on_cortex(b.mesh, given, compact, std::max(4., 2.5 * longest), workers)
                   : put_on_cortex_in_slices(b.mesh, given, compact, out.offset, workers,
                                             out.bone.empty() ? nullptr : &out.bone.front().cortex);
    b.mesh.axes = simplex::Axes::left_posterior_superior;
    simplex::turn_to_head(b.mesh);
    b.volume_cm3 = 1e-3 * simplex::extent(b.mesh).volume_mm3, b.genus = simplex::census(b.mesh).genus;
    out.bone.push_back(std::move(b));
  }
  if (!out.bone.empty() && out.bone.front().cortex.cortical_sd > 0)
    out.notes.push_back("compact bone is taken to have " +
                        std::to_string(int(out.bone.front().cortex.cortical - out.offset)) + " HU; within " +
                        std::to_string(int(out.bone.front().cortex.cortical_sd)) +
                        " HU of that the slices are explained as well, and 100 HU are 0.1 mm all around");
  out.parts.of.clear();
  solid.distance = {}, solid.value = {};
  out.solid = std::move(solid);
  say("skin");
  PrepareSettings p;
  p.iso = s.skin_HU + out.offset, p.seal_mm = 6;
  const Prepared prepared = prepare(out.skin_volume, p, workers);
  FitSettings f;
  f.iso = p.iso, f.edge_mm = s.face_edge_mm, f.range_mm = 0.25 * (prepared.high_mm - prepared.low_mm).maxCoeff();
  out.face = start_mesh(Start::sphere, prepared.low_mm, prepared.high_mm);
  out.skin = fit(out.face, prepared, f, workers);
  simplex::turn_to_head(out.face);
  say("landmarks");
  AnatomySurfaces a;
  for (const PatientBone& b : out.bone) {
    if (b.name == "cranium") a.skull = triangles_of(b.mesh);
    if (b.name == "mandible") a.mandible = triangles_of(b.mesh);
  }
  a.skin = triangles_of(out.face);
  a.brain_mm = Vec3(-out.parts.brain_mm.x(), -out.parts.brain_mm.y(), out.parts.brain_mm.z()), a.voxel_mm = longest;
  a.volume = &given, a.offset = out.offset, a.bone_HU = s.bone_HU;
  out.anatomy = find_anatomy(a, atlas, workers);
  for (PatientBone& b : out.bone) move(b.mesh, out.anatomy.to_head);
  move(out.face, out.anatomy.to_head);
  for (const std::string& n : out.parts.notes) out.notes.push_back(n);
  out.notes.push_back(out.anatomy.ear_canals == 2 ? "the porions are the upper rims of both ear canals"
                      : out.anatomy.ear_canals == 1
                          ? "one ear canal is seen, its upper rim a porion; the other porion is by rule"
                          : "no ear canals are seen: the porions are where those of a laid skull meet bone");
  for (const FoundLandmark& l : out.anatomy.landmark)
    if (l.mirrored) out.notes.push_back(l.name + " was not met: the mirror image of its fellow, brought to bone");
  return out;
}

}  // namespace limberg
