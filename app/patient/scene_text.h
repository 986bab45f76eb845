#pragma once
// The scenes that a patient from a CT leaves: they run (operations.h: what is done on them).
#include <string>

#include "sim/imaging/anatomy/patient_flesh.h"
#include "sim/imaging/anatomy/patient_model.h"

namespace limberg {

constexpr int kPatientTissueLayers = 2;
constexpr double kPatientTissue_kPa = 15;  // as in the shipped heads

/// A scene of the meshes cranium.simplex, mandible.simplex, ... and face.simplex beside it: landmarks, camera, and
/// tissue between bone and the skin over it within `reach_mm` of the landmark sn (soft_tissue.h; 0: none). `note`: one
/// line on where it comes from.
std::string patient_scene(const PatientModel& patient, double reach_mm, const std::string& note);

/// A scene of the same bones and of soft tissue over them that is cut and sewn, flesh.obj beside it: held on bone, held
/// softly where none was met, at its sides held. Its layers are those of the shipped face. `flesh_obj`: the text of
/// that file.
std::string patient_flesh_scene(const PatientModel& patient, const std::string& note);
std::string flesh_obj(const PatientFlesh& flesh);

}  // namespace limberg
