#pragma once
// A head as the snapshot's surface: fans of face and bones as
// triangles, the tissue between as lines, landmarks by name.
//
// Vertices in this order: of the face (slot by slot), the middles of its faces, of the bones, the middles of their
// faces, of the tissue. What only changes with the topology is worked out in build(); places() costs one pass.
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/patient/snapshot.h"
#include "sim/skull/bone/bones.h"
#include "sim/skull/head/face_texture.h"
#include "sim/skull/simplex/tissue.h"

namespace limberg {

/// Colour of a place at rest on face or bone: sRGB, and how much of it is seen.
using SurfaceColour = std::function<std::array<uint8_t, 4>(const Vec3& X_mm, Organ organ)>;

class HeadView {
 public:
  /// `face` as it was at first. Makes a new version of the topology. `texture`: of the face, over its colour, or null.
  void build(const simplex::Mesh& face_at_rest, const bone::Bones& bones,
             const std::vector<const simplex::Tissue*>& tissue, const std::vector<std::string>& landmarks,
             const SurfaceColour& colour = {}, const FaceTexture* texture = nullptr);
  std::shared_ptr<const SurfaceTopology> topology() const { return topology_; }

  /// Where every vertex is now.
  void places(const simplex::Mesh& face, const bone::Bones& bones, const std::vector<const simplex::Tissue*>& tissue,
              std::vector<Vec3f>& x_mm) const;
  /// Of the face's vertices, how far they are from where they were at first; of the middle of a face of its mesh, how
  /// far that face's vertices have moved in the mean (the middle itself lies where their tangent planes meet, which
  /// swings where skin folds). 0 for all
  /// others.
  void moved(const simplex::Mesh& face, const std::vector<Vec3f>& x_mm, std::vector<float>& moved_mm) const;

 private:
  /// How the face looks, which changes with its mesh only: a saw's work does not pay for it.
  struct Worn {
    uint64_t face = 0;                               // topology_hash() of the mesh that it is for
    std::vector<std::array<Eigen::Vector2f, 3>> uv;  // per triangle of the face
    std::vector<std::array<uint8_t, 4>> rgba;        // per vertex
  };
  void put_on(SurfaceTopology& top, const simplex::Mesh& face, const FaceTexture& texture);

  std::shared_ptr<SurfaceTopology> topology_;
  Worn worn_;
  std::vector<int32_t> face_middle_, bone_middle_;  // faces of the meshes, per middle
  std::vector<Vec3> bone_middle_mm_;                // at rest
  std::vector<int32_t> fragment_;  // per vertex of the bones' mesh, then per middle: index into fragments()
  size_t face_slots_ = 0, bone_slots_ = 0, tissue_vertices_ = 0, face_vertices_ = 0;
  uint64_t version_ = 0;
};

}  // namespace limberg
