#pragma once
// The files that a patient from a CT leaves: a scene that runs, and a first operation on it.
#include <string>

#include "sim/imaging/anatomy/patient_model.h"

namespace limberg {

/// A scene of the meshes cranium.simplex, mandible.simplex, ... and face.simplex beside it: landmarks, tissue between all
/// bone and the skin over it, camera. `note`: one line on where it comes from.
std::string patient_scene(const PatientModel& patient, const std::string& note);

/// A genioplasty as a script: the chin cut off below the front teeth and carried 6 mm forwards. Empty: no mandible, or
/// its landmarks are missing.
std::string genioplasty_script(const PatientModel& patient);

}  // namespace limberg
