#pragma once
// The part of a scene that is a head.
//
//   [head]           source = "synthetic" | "anatomical" | "files"
//                    synthetic: mandible_scale, ramus_left, vault_wide,
//                    vault_long, forehead_flat, edge_mm, face_edge_mm
//                    (sim/imaging/synthetic/head_shape.h)
//                    anatomical: edge_mm, face_edge_mm
//                    (sim/imaging/anatomical/anatomical_head.h)
//                    files: bones = ["cranium.txt", ...] simplex meshes
//                    relative to the scene file, the first of them fixed
//                    unless "fixed" says otherwise; face = "face.txt"; axes = "lps" | "head" of meshes that do not say
//                    which way theirs point (a fitted one does): left, posterior, superior, or right, forwards, up
//                    all: face_texture = "scan.obj", a surface that lies where the face does, in the frame of its file:
//                    with texture coordinates and a picture (its material's, or face_picture = "FILE"), or (PLY, OBJ)
//                    colours of its vertices; face_texture_scale_to_mm (sim/skull/head/face_texture.h)
//                    offset_mm = [x, y, z], by which the head is shifted (to where the skin of a [body] lies),
//                    fixed = ["cranium", ...] names of bones that do not
//                    move (of a file: its stem), face = true | false,
//                    iterations_per_step of the face, show_face = "solid" | "clear" | "hidden" at the beginning,
//                    picture_from_head = [[r, r, r, t], ...] three rows of the map from the head's frame to that of
//                    the picture (left, posterior, superior, mm) that it was made from: of a patient from a CT,
//                    normal_skull = "FILE" or ["FILE", ...], the skull that it is laid upon, not the built-in one,
//                    carries_skin_mm: with a [body], its fixed nodes that are at most so far from bone move with it
//   [[head.tissue]]  name, face and bone: a place [x, y, z] or a landmark's
//                    name; face_radius_mm, or for both face_outline = [places, or landmarks] round the region;
//                    bone_radius_mm (0: all bone), layers,
//                    young_kPa, mode = "smoothing" | "springs" | "shape" | "finite_elements"
//   [[head.muscle]]  in tissues of finite elements, beneath the skin: name, path = two places or names of landmarks or
//                    more, radius_mm, young_kPa between the fibres, and of these k1_kPa, k2
//                    (sim/fem/materials/fibres.h); without k1_kPa a ligament
//   [[head.slide]]   where skin slides on bone, in the lowest of two layers or more of finite elements: name,
//                    at = a place or a landmark, radius_mm, kPa_per_mm (sim/skull/face/face_slide.h)
//   [head.landmarks] NAME = [x, y, z] on bone;  [head.face_landmarks] the same on the face
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/commands/head_command.h"
#include "sim/skull/face/face_bundle.h"
#include "sim/skull/face/face_slide.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg {

enum class FaceShown : uint8_t { solid, clear, hidden };

struct HeadScene {
  enum class Source { synthetic, anatomical, files } source = Source::synthetic;
  double mandible_scale = 1, ramus_left = 1, vault_wide = 1, vault_long = 1, forehead_flat = 0, edge_mm = 4,
         face_edge_mm = 5;
  std::vector<std::string> bone_files;  // resolved against the scene's folder
  std::string face_file;
  std::string texture_file, picture_file;  // how the face looks; neither patient nor hash depend on them
  double texture_scale_to_mm = 1;
  std::vector<std::string> normal_files;  // none: the built-in normal skull. Neither patient nor hash depend on them
  simplex::Axes axes = simplex::Axes::unsaid;  // of meshes from files that do not say it
  std::vector<std::string> fixed{"cranium"};
  bool face = true;
  int iterations_per_step = 12;
  FaceShown shown = FaceShown::solid;
  double carries_skin_mm = 6;
  Vec3 offset_mm{0, 0, 0};
  std::optional<Eigen::Isometry3d> picture_from_head;

  struct TissueAt {
    ConnectTissue tissue;                    // its places are filled in when the head is built
    std::string face_name, bone_name;        // landmarks; empty: the place is given
    std::vector<std::string> outline_names;  // of each place of face_outline_mm, likewise
  };
  std::vector<TissueAt> tissues;
  struct MuscleAt {
    simplex::FaceBundle bundle;      // its path is filled in when the head is built
    std::vector<std::string> names;  // of landmarks, per place of the path; empty: the place is given
  };
  std::vector<MuscleAt> muscles;
  struct SlideAt {
    simplex::FaceSlide slide;  // its place is filled in when the head is built
    std::string landmark;      // empty: the place is given
  };
  std::vector<SlideAt> slides;
  std::vector<std::pair<std::string, Vec3>> landmarks, face_landmarks;
};

}  // namespace limberg
