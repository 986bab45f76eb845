#pragma once
// How far from the nose soft tissue can be laid between a patient's face and bones: a scene that is left behind runs.
#include "sim/base/workers.h"
#include "sim/imaging/anatomy/patient_model.h"

namespace limberg {

/// The largest of some radii about the landmark sn (mm) at which a head with that tissue can be built, and at which its
/// face does not run away when the first bone that may move (the mandible) is moved by a millimetre. 0: none, or there
/// is no sn.
double tissue_reach_mm(const PatientModel& patient, double young_kPa, int layers, Workers& workers);

}  // namespace limberg
