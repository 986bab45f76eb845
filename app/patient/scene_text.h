#pragma once
// The scene that a patient from a CT leaves: one that runs (operations.h: what is done on it).
#include <string>

#include "sim/imaging/anatomy/patient_model.h"

namespace limberg {

constexpr int kPatientTissueLayers = 2;
constexpr double kPatientTissue_kPa = 15;  // as in the shipped heads

/// A scene of the meshes cranium.simplex, mandible.simplex, ... and face.simplex beside it: landmarks, camera, and
/// tissue between bone and the skin over it within `reach_mm` of the landmark sn (soft_tissue.h; 0: none). `note`: one
/// line on where it comes from.
std::string patient_scene(const PatientModel& patient, double reach_mm, const std::string& note);

}  // namespace limberg
