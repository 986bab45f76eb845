#pragma once
// Where a head's landmarks are, and which way it looks: the frame of a head from surfaces of its bone and skin.
//
//   laid upon   the synthetic head's skull is laid upon the patient's from five tilts (trimmed ICP), its mandible on
//               the mandible, each with the size that lies between what the one says of the other and the other of the
//               one; every landmark has a first place then
//   by rule     each landmark is sought on the patient's own surface near that place by the rule that defines it
//               (landmark_search.h); along a profile they follow one another
//   porion      the upper rim of the bony ear canal where the picture shows one; of one canal its mirror image; else
//               that of the laid skull
//   pairs       one that no ray meets is sought on bone where its fellow's mirror image lies, and said to be so
//   frame       x across the plane of symmetry of the skull (laid upon its own mirror image), the Frankfort horizontal
//               through both porions and the orbitals flat, origin midway between the porions; then rules once more
//
// How far a landmark may be off (`sd_mm` per coordinate) is stated from how far its rule moved it from where the laid
// skull has it, how level the surface is on which it was sought, the size of a voxel, and how unlike the shapes are
// where it is as the laid skull has it.
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/workers.h"
#include "sim/imaging/io/volume.h"
#include "sim/imaging/register/superposition.h"
#include "sim/imaging/synthetic/synthetic_head.h"

namespace limberg {

struct AnatomySurfaces {
  Surface skull, mandible, skin;  // right, forwards, up, about upright; mandible and skin may be empty
  Vec3 brain_mm = Vec3::Zero();   // the middle of its hollow
  double voxel_mm = 1;            // the longest side
  // The picture, left, posterior, superior: ear canals are looked for in it (ear_canal.h). May be null.
  const Volume* volume = nullptr;
  double offset = 0, bone_HU = 250;  // what its numbers are above Hounsfield units; above it is bone
};

struct FoundLandmark {
  std::string name;  // as measure/cephalometry.h has them
  Vec3 at_mm = Vec3::Zero();
  double sd_mm = 0;
  bool on_skin = false;
  bool mirrored = false;  // not met: the mirror image of its fellow, brought to the surface
};

/// The one of that name; null: there is none.
inline const FoundLandmark* find_landmark(std::span<const FoundLandmark> all, std::string_view name) {
  for (const FoundLandmark& l : all)
    if (l.name == name) return &l;
  return nullptr;
}

struct Anatomy {
  Eigen::Isometry3d to_head = Eigen::Isometry3d::Identity();  // from the frame of the surfaces to that of the head
  std::vector<FoundLandmark> landmark;                        // in the frame of the head
  std::vector<std::string> missing;                           // names of landmarks that no ray met
  double skull_rms_mm = 0;                                    // of the laid skull, over the pairs that ICP kept
  double pitch_deg = 0, roll_deg = 0, yaw_deg = 0;            // of the head in the picture, from the frame of the head
  double symmetry_rms_mm = 0;                                 // of the skull against its mirror image
  int ear_canals = 0;                                         // that porions were taken from
};

/// `atlas`: make_head({}). Throws InputError where the skull cannot be laid upon, with ICP's reason.
Anatomy find_anatomy(const AnatomySurfaces& patient, const HeadModel& atlas, Workers& workers);

}  // namespace limberg
