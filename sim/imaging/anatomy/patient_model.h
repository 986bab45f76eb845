#pragma once
// A patient from a CT: skull with two tables, mandible and spine as solids, skin, landmarks, in the frame of the head.
//
//   numbers     where air lies says what the numbers are above Hounsfield units (0 or 1024)
//   slices      tall ones are interpolated by shape, for bone and for skin (fit/shape_interpolation.h)
//   bone        a solid (solid/bone_solid.h), parted (bone_parts.h), each part a closed mesh (fit/level_set.h) whose
//               vertices lie where the cortex begins (cortex_fit.h)
//   skin        a mesh wrapped around it (fit/fit.h), open where the volume ends
//   frame       landmarks and Frankfort's horizontal (anatomy.h)
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/imaging/anatomy/anatomy.h"
#include "sim/imaging/fit/fit.h"
#include "sim/imaging/solid/bone_parts.h"
#include "sim/imaging/solid/cortex_fit.h"

namespace limberg {

struct PatientSettings {
  std::optional<double> offset;  // the volume's numbers above Hounsfield units; nothing: found
  double bone_HU = 250, skin_HU = -300, thin_HU = 100;
  double edge_mm = 3.5, face_edge_mm = 5;
  double step_mm = 0;                                // of the bone's grid; 0: that of the voxels
  std::function<void(const std::string&)> progress;  // may be empty
};

struct PatientBone {
  std::string name;  // cranium, mandible, spine
  simplex::Mesh mesh;
  LevelSetReport surface;
  CortexReport cortex;
  double volume_cm3 = 0;  // that the mesh encloses
  int64_t genus = 0;
};

struct PatientModel {
  double offset = 0;
  std::string offset_why;
  Volume bone_volume, skin_volume;  // what the surfaces were taken from (tall slices interpolated)
  BoneSolid solid;                  // its figures; no nodes any more
  BoneParts parts;
  std::vector<PatientBone> bone;  // cranium first
  simplex::Mesh face;             // may be empty: there is no skin in the volume
  FitReport skin;
  Anatomy anatomy;
  std::vector<std::string> notes;
};

/// What the numbers of a CT are above Hounsfield units, by the value that most voxels of air have. Throws InputError:
/// air lies neither at -1000 nor at 0 (no CT, say), with where it lies; or at 0, and most tissue would be thinner than
/// fat, as in an MRI.
double hounsfield_offset(const Volume& volume, std::string& why);

/// Meshes and landmarks in the frame of the head (x right, y forwards, z up, origin between the porions). Throws
/// InputError: as bone_solid, part_bones, prepare and find_anatomy do.
PatientModel make_patient(const Volume& volume, const PatientSettings& settings, const HeadModel& atlas,
                          Workers& workers);

}  // namespace limberg
