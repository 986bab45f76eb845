#pragma once
// The files that a patient from a CT leaves: a scene that runs, and a first operation on it.
#include <string>

#include "sim/imaging/anatomy/patient_model.h"

namespace limberg {

constexpr int kPatientTissueLayers = 2;
constexpr double kPatientTissue_kPa = 15;  // as in the shipped heads

/// A scene of the meshes cranium.simplex, mandible.simplex, ... and face.simplex beside it: landmarks, camera, and
/// tissue between bone and the skin over it within `reach_mm` of the landmark sn (soft_tissue.h; 0: none). `note`: one
/// line on where it comes from.
std::string patient_scene(const PatientModel& patient, double reach_mm, const std::string& note);

/// A genioplasty as a script: the chin cut off below the front teeth and carried 6 mm forwards. Empty: no mandible, or
/// its landmarks are missing.
std::string genioplasty_script(const PatientModel& patient);

}  // namespace limberg
