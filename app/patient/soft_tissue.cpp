#include "app/patient/soft_tissue.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/base/error.h"
#include "sim/geometry/bvh.h"
#include "sim/skull/head/head.h"
#include "sim/skull/simplex/dual.h"

namespace limberg {

namespace {

constexpr double kReaches_mm[] = {kWholeFace_mm, 150, 130, 110, 95, 80, 65, 50, 35};
constexpr double kTry_mm = 1, kStepTime_s = 1. / 60;
constexpr int kTrySteps = 300;      // no tissue that rested took more than 110 (2026-11-27)
constexpr double kMostMove_mm = 5;  // of the face, for a bone that has moved by one: more runs away

/// Fills `out` and says whether the scene runs.
bool holds(const PatientModel& p, const ConnectTissue& tissue, Workers& workers, LaidTissue& out) {
  HeadParts parts;
  for (const PatientBone& b : p.bone) parts.bones.push_back({b.name, b.mesh, b.name != "mandible"});
  parts.face = p.face;
  parts.tissues.push_back(tissue);
  try {
    Head head(std::move(parts), workers);
    const simplex::Tissue& laid = *head.face_model().tissues().front();
    out.quality = simplex::quality_of(laid), out.covered = int(laid.link.size());
    const auto jaw = std::find_if(head.bones().fragments().begin(), head.bones().fragments().end(),
                                  [](const bone::Fragment& f) { return !f.fixed; });
    out.steps = 0, out.most_move_mm = 0;
    if (jaw == head.bones().fragments().end()) return true;  // nothing will move
    MoveFragment m;
    m.fragment.id = jaw->id;
    m.by.translation_mm = {0, kTry_mm, 0};
    if (const ActedOnHead o = head.act(HeadCommand(m)); !o.done) return out.why = o.reason, false;
    bool rests = false;
    while (!rests && out.steps < kTrySteps) rests = head.step(kStepTime_s).at_rest, ++out.steps;
    for (int32_t v = 0; v < head.face().slots(); ++v)
      if (head.face().alive(v))
        out.most_move_mm = std::max(out.most_move_mm, (head.face().x_mm[size_t(v)] - p.face.x_mm[size_t(v)]).norm());
    if (rests && out.most_move_mm < kMostMove_mm) return true;
    out.why = rests ? "the face ran away" : "the face did not come to rest";
  } catch (const InputError& e) {
    out.why = e.what();
  }
  return false;
}

/// Along the normal of the skin, where bone is not much farther there than at the nearest place (tissue.h).
double thickness_mm(const Bvh& bone, const Vec3& x, const Vec3& normal) {
  Vec3 way;
  return simplex::way_to_bone(bone, x, normal, kSkinOverBone_mm, way) ? way.norm() : 0;
}

void measure(const PatientModel& p, const Vec3& about_mm, LaidTissue& out) {
  Surface bones;
  for (const PatientBone& b : p.bone) append(bones, triangles_of(b.mesh));
  const Bvh bone(bones.x_mm, bones.tri);
  int32_t nose = -1;
  double nearest = 1e300;
  std::vector<double> all;
  for (int32_t v = 0; v < p.face.slots(); ++v)
    if (p.face.alive(v))
      if (const double d = (p.face.x_mm[size_t(v)] - about_mm).norm(); d < nearest) nearest = d, nose = v;
  for (const int32_t v : simplex::region_around(p.face, nose, out.reach_mm > 0 ? out.reach_mm : kWholeFace_mm)) {
    const bool rim = std::any_of(p.face.left[size_t(v)].begin(), p.face.left[size_t(v)].end(),
                                 [&](int32_t f) { return simplex::is_end(p.face.kind(f)); });
    if (rim) continue;
    if (const double d = thickness_mm(bone, p.face.x_mm[size_t(v)], p.face.frame(v).N); d > 0) all.push_back(d);
  }
  out.over_bone = int(all.size());
  if (all.empty()) return;
  std::sort(all.begin(), all.end());
  out.true_p5_mm = all[all.size() / 20], out.true_median_mm = all[all.size() / 2],
  out.true_p95_mm = all[all.size() * 19 / 20];
  for (const FoundLandmark& l : p.anatomy.landmark) {
    if (!l.on_skin) continue;
    int32_t at = -1;
    double least = 1e300;
    for (int32_t v = 0; v < p.face.slots(); ++v)
      if (p.face.alive(v))
        if (const double d = (p.face.x_mm[size_t(v)] - l.at_mm).norm(); d < least) least = d, at = v;
    if (at < 0) continue;
    if (const double d = thickness_mm(bone, l.at_mm, p.face.frame(at).N); d > 0) out.at.push_back({l.name, d});
  }
}

}  // namespace

LaidTissue lay_soft_tissue(const PatientModel& p, double young_kPa, int layers, Workers& workers) {
  LaidTissue out;
  const FoundLandmark* sn = find_landmark(p.anatomy.landmark, "sn");
  if (!sn || p.face.slots() == 0) {
    out.why = p.face.slots() == 0 ? "there is no skin" : "the landmark sn was not found";
    return out;
  }
  ConnectTissue t;
  t.name = "soft tissue", t.face_mm = t.bone_mm = sn->at_mm;
  t.layers = layers, t.young_kPa = young_kPa, t.mode = TissueKind::finite_elements;
  for (const double reach : kReaches_mm) {
    t.face_radius_mm = reach;
    if (holds(p, t, workers, out)) {
      out.reach_mm = reach;
      break;
    }
  }
  if (out.reach_mm == 0) out.covered = 0, out.quality = {};
  measure(p, sn->at_mm, out);
  return out;
}

}  // namespace limberg
