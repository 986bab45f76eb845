#pragma once
// Soft tissue between a patient's skin and bones: how far it can be laid so that the scene that is left behind runs,
// what its columns are like, and how thick the picture says that it is.
#include <string>
#include <vector>

#include "sim/base/workers.h"
#include "sim/imaging/anatomy/patient_model.h"
#include "sim/skull/simplex/tissue.h"

namespace limberg {

constexpr double kWholeFace_mm = 400;  // a reach about the nose that no face goes beyond

struct ThicknessAt {
  std::string landmark;  // on the skin
  double mm = 0;
};

struct LaidTissue {
  double reach_mm = 0;  // about the landmark sn; 0: none could be laid
  std::string why;      // of the last that could not, if any
  int over_bone = 0;    // vertices of the skin within reach that have bone under them,
  int covered = 0;      // and of these the ones with tissue: the others follow the skin around them
  simplex::TissueQuality quality;
  int steps = 0;            // until it was at rest, once the mandible had moved by a millimetre,
  double most_move_mm = 0;  // and how far the face had gone then
  // From skin to bone along the normal of the skin, in the meshes: over all of that skin, and at landmarks.
  double true_p5_mm = 0, true_median_mm = 0, true_p95_mm = 0;
  std::vector<ThicknessAt> at;
};

/// Of some reaches (the whole face first) the largest at which a head with that tissue can be built, comes to rest once
/// the first bone that may move (the mandible) is moved by a millimetre, and has no place of the face moved by more
/// than five.
LaidTissue lay_soft_tissue(const PatientModel& patient, double young_kPa, int layers, Workers& workers);

}  // namespace limberg
