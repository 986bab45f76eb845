#include "app/patient/tissue_reach.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/skull/head/head.h"

namespace limberg {

namespace {

constexpr double kReaches_mm[] = {150, 130, 110, 95, 80, 65, 50, 35};
constexpr double kTry_mm = 1, kStepTime_s = 1. / 60;
constexpr int kTrySteps = 60;
constexpr double kMostMove_mm = 5;  // of the face, for a bone that has moved by one: more runs away

bool holds(const PatientModel& p, const ConnectTissue& tissue, Workers& workers) {
  HeadParts parts;
  for (const PatientBone& b : p.bone) parts.bones.push_back({b.name, b.mesh, b.name != "mandible"});
  parts.face = p.face;
  parts.tissues.push_back(tissue);
  try {
    Head head(std::move(parts), workers);
    const auto jaw = std::find_if(head.bones().fragments().begin(), head.bones().fragments().end(),
                                  [](const bone::Fragment& f) { return !f.fixed; });
    if (jaw == head.bones().fragments().end()) return true;  // nothing will move
    MoveFragment m;
    m.fragment.id = jaw->id;
    m.by.translation_mm = {0, kTry_mm, 0};
    if (!head.act(HeadCommand(m)).done) return false;
    for (int i = 0; i < kTrySteps; ++i) head.step(kStepTime_s);
    double most = 0;
    for (int32_t v = 0; v < head.face().slots(); ++v)
      if (head.face().alive(v)) most = std::max(most, (head.face().x_mm[size_t(v)] - p.face.x_mm[size_t(v)]).norm());
    return most < kMostMove_mm;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

double tissue_reach_mm(const PatientModel& p, double young_kPa, int layers, Workers& workers) {
  const auto sn = std::find_if(p.anatomy.landmark.begin(), p.anatomy.landmark.end(),
                               [](const FoundLandmark& l) { return l.name == "sn"; });
  if (sn == p.anatomy.landmark.end() || p.face.slots() == 0) return 0;
  ConnectTissue t;
  t.name = "soft tissue", t.face_mm = t.bone_mm = sn->at_mm;
  t.layers = layers, t.young_kPa = young_kPa, t.mode = TissueKind::finite_elements;
  for (const double reach : kReaches_mm) {
    t.face_radius_mm = reach;
    if (holds(p, t, workers)) return reach;
  }
  return 0;
}

}  // namespace limberg
