#pragma once
// A patient at one moment as files that other programs read: surfaces as binary STL and PLY in mm, and for a head
// plan.json, which says how each fragment has been moved, with what is printed for the operation.
//
//   NAME.stl, NAME.ply      each fragment of bone (closed), plates, face, skin, as they lie at that moment
//   mirror-NAME.stl, .ply   each fragment as it lay before it was moved, mirrored in the skull's plane of symmetry
//   guide-NAME-1.stl, ...   for the cuts of a fragment that has been moved, where the bone was at first
//   splint.stl, .ply        between the teeth as they lie at that moment
//   plan.json               frames, and of each fragment the map from where it was to where it is: in the head's frame
//                           (x right, y forwards, z up) and, of a patient from a CT, in the picture's (left, posterior,
//                           superior), in which the CT has its places
#include <optional>
#include <string>
#include <vector>

#include "app/scene/scene.h"
#include "sim/base/workers.h"
#include "sim/patient/world.h"

namespace limberg {

struct ExportSettings {
  bool guides = true, splint = true, mirror = true;
  bool in_picture = false;  // surfaces in the picture's frame instead of the head's
};

struct ExportedFile {
  std::string file;  // without its folder
  int64_t triangles = 0;
  bool closed = false;
  double volume_mm3 = 0;  // of a closed one
};

struct ExportedMoment {
  std::string name, folder;  // of the stage; where the files are
  std::vector<ExportedFile> files;
  std::vector<std::string> left_out;  // what could not be made, and why
};

/// Writes into `folder`, which is made. InputError: a file cannot be written; the picture's frame is asked for and the
/// scene does not know it.
ExportedMoment export_moment(const World& world, const Scene& scene, const std::string& name, const std::string& folder,
                             const ExportSettings& settings, Workers& workers);

/// A file's name of any text: letters, digits, hyphens.
std::string file_name_of(const std::string& text);

}  // namespace limberg
