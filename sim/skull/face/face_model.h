#pragma once
// The face that follows: a face mesh that keeps its shape, tied to the bones by tissues between opposite regions.
//
//   FaceModel model(face, workers);
//   model.connect(bones, {"jaw", face_region, bone_region, 3, 10, TissueKind::finite_elements});
//   model.follow(bones_now);            // as often as a fragment moves
//   model.step(20);                     // so many iterations a frame, until at_rest
//
// Quasi-static: every step goes on from where the last one stopped. When a bone moves,
// each column of tissue (what lies under one vertex of the face) is first carried
// along with the piece of bone under it; what the iterations do is to even that out.
//
//   smoothing         the tissue fills the space, the face does not feel it
//   springs           along the edges, stiffer with elongation; what they leave
//                     free (tissue.h) is held by a share of the shape force
//   shape             the rest shape of the tissue, turned as it turns
//   finite_elements   the same tetrahedra as an elastic body (face_elasticity.h); all such regions are one body
//
// Stiffness per edge of the first two comes from Young's modulus and the tissue's
// sections; their top layer is skin and fat, as that of the finite elements.
//
// Vertices of the face that no region covers follow by the shape constraint alone up to `transition_mm` from
// a region; those farther off stay where they are. Vertices over finite elements go where these put them. Where the
// shape constraint alone does not come to rest (feet outside of their neighbours' triangles, as along ears and rims of
// fitted skin: a disturbance grows from iteration to iteration), these vertices move as the mean of their neighbours
// does (Laplace's equation for the displacement, which has one solution and always comes to rest).
//
// Bones that all move as one rigid body take the whole face with them as it is: a head that turns.
//
// Bones are one mesh whose components are the fragments; x_mm in it is where they are now. Anchors name
// three vertices of the bone each, so they follow the fragment that owns these. After an osteotomy `rebind`
// finds them again by their place at rest, and `warnings` says which regions now hang on several fragments.
#include <memory>
#include <string>
#include <vector>

#include "sim/base/workers.h"
#include "sim/commands/command.h"
#include "sim/skull/face/face_elasticity.h"
#include "sim/skull/face/face_feet.h"
#include "sim/skull/simplex/mesh.h"
#include "sim/skull/simplex/tissue.h"

namespace limberg::simplex {

struct FaceTissuePlan {
  std::string name;
  std::vector<int32_t> face_region, skull_region;  // vertices; of the skull none: all of it
  int layers = 1;
  double young_kPa = 10;
  TissueKind mode = TissueKind::finite_elements;
  TissueFloor floor = {};  // of finite elements; TissueSettings has the meaning of both
  bool mend = false;
  double leave_out = 0;  // share of face_region, at most, that is left out where columns cannot be mended
};

/// What the shipped heads' tissues meet without mending, and what every tissue has met that was seen to rest: a mean
/// ratio of .05 and 1 mm (2026-11-27). The thinnest skin of a face, that of the lids, is .5 to 1 mm thick.
inline constexpr TissueFloor kSoundTissue{0.05, 1};

struct FaceModelSettings {
  ElasticitySettings elasticity;
  double transition_mm = 25;
  double alpha = 0.03, beta = 0.9,
         gamma = 0.35;  // of the face's motion (law.h): its own shape, the tissues' pull, damping
  // Mode springs: share of the shape force; 0: the paper's springs
  // alone. (On the mandible's advance of `bench head` the error is
  // .66 to .68 mm for any share of .2 to .6, 2026-11-21.)
  double hold = 0.5;
  SpringLaw spring;
  double still_mm = 1e-3;   // at rest when no vertex of the face moves farther in an iteration, five times in a row...
  double tolerance = 1e-4;  // ...and the relative residual of the finite elements is below this
  double max_thickness_mm = 60;
};

class FaceModel {
 public:
  /// A face without vertices is allowed: then nothing can be connected.
  FaceModel(Mesh face, Workers& workers, const FaceModelSettings& settings = {});
  FaceModel(const FaceModel& other);
  FaceModel& operator=(const FaceModel& other);
  FaceModel(FaceModel&&) noexcept;
  FaceModel& operator=(FaceModel&&) noexcept;
  ~FaceModel();

  /// Ties a region of the face to the bones as they are now. Refused with the reason (build_tissue's; a name used
  /// twice; a vertex that another region has) and nothing changed. `bones_at_rest`: when the bones have moved already.
  Outcome connect(const Mesh& bones_now, FaceTissuePlan plan, const Mesh* bones_at_rest = nullptr);

  /// The bones have moved: ends of the tissues go along. Costs little when none of them concerns the face.
  void follow(const Mesh& bones_now);

  struct Report {
    double max_move_mm = 0;  // of a vertex of the face or tissue, in the last iteration
    int iterations = 0;
    bool at_rest = true;
    double residual = 0, distance_mm = 0;  // of the finite elements; 0 without
    int inverted = 0;                      // of their tetrahedra
  };
  /// At most so many iterations; of the finite elements one for every four (they cost more and get farther).
  Report step(int iterations);

  /// After vertices of the bones have changed (cut, join, undo). `bones_at_rest`: x_mm where they were at first.
  void rebind(const Mesh& bones_at_rest);
  /// The rest of some bones is set anew, as a join does: what stands on `vertices` of the bones (a flag per slot, as
  /// they were at the last rebind) stands at `by` times its place at rest. To be called before rebind.
  void rest_set_anew(std::span<const uint8_t> vertices, const Eigen::Isometry3d& by);

  const Mesh& face() const { return face_; }
  const std::vector<Vec3>& rest_mm() const { return rest_mm_; }  // of the face, per vertex slot
  std::vector<const Tissue*> tissues() const;
  /// One line per region: its mode, vertices, thickness, and what its springs leave free.
  std::vector<std::string> describe() const;
  /// Of a region in springs or shape: "its springs leave 84 of 396 motions free (0.64 per free vertex), held by the
  /// shape force"; see zero_energy_modes for the count.
  std::string free_motions(size_t region, int64_t dense_up_to = 1500) const;
  /// Regions that hang on several fragments since the last rebind, a sentence each.
  const std::vector<std::string>& warnings() const { return warnings_; }
  bool at_rest() const { return at_rest_; }
  /// Displacement of the face: rms over the vertices that may move, and the largest.
  struct Moved {
    double rms_mm = 0, max_mm = 0;
  };
  Moved moved() const;
  uint64_t hash() const;

 private:
  struct Region {
    FaceTissuePlan plan;
    Tissue tissue;
    std::vector<Foot> anchor;                 // of the tissue's vertices, as Tissue::anchor
    std::vector<Foot> under;                  // of the nodes of its lowest layer (finite elements)
    std::vector<int32_t> column;              // per vertex of the tissue: which vertex of the region it lies under
    std::vector<int32_t> foot;                // per column: its anchor
    std::vector<std::array<int32_t, 3>> top;  // per column: the nodes of its triangle on the skin...
    std::vector<LocalFrame> over;  // ...and where over it the face's vertex was when it was connected (finite elements)
    std::vector<int32_t> face_vertex;  // per column
    int fragments = 1;                 // that it hangs on
  };
  struct Scratch;
  void zones();
  bool shape_rests() const;
  double even_out();
  void turn_as_one(const Mesh& bones_now, const Eigen::Isometry3d& by);
  void make_elasticity();
  void place_elastic();
  Report step_elastic(int iterations);
  Report step_simplex(int iterations);
  bool any(bool elastic) const;

  Workers* workers_;
  FaceModelSettings settings_;
  Mesh face_;
  std::vector<Vec3> rest_mm_;
  std::vector<Region> region_;
  std::vector<std::string> warnings_;
  std::vector<Vec3> u_mm_;  // displacements of the finite elements' nodes
  Eigen::Isometry3d frame_ =
      Eigen::Isometry3d::Identity();         // of the elastic bodies: their nodes are at frame_ * (rest + u_mm_)
  std::vector<Vec3> bones_mm_;               // at the last follow; empty: not known
  std::shared_ptr<FaceElasticity> elastic_;  // shared with copies: it is given its state at every step
  std::unique_ptr<Scratch> scratch_;
  bool at_rest_ = true, elastic_rest_ = true, simplex_rest_ = true;
  int still_ = 0;
};

}  // namespace limberg::simplex
