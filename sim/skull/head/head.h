#pragma once
// A head: bones that can be cut and moved, the face over them, the tissue between, and named places on both.
//
//   Head head(parts, workers);
//   head.apply(CutBone{...});          // atomic: done, or refused with a reason and nothing changed
//   head.step(dt_s);                   // fragments that are held (Bullet), then the face a little nearer to rest
//   head.fill(snapshot);
//
// Frame: mm, x to the right, y forwards, z upwards, origin midway between the ears, z = 0 the Frankfurt plane. Places
// of commands are on the bones at rest, where they were at first; a fragment's pose takes them to where they are now.
//
// Undo and redo go through osteotomies, moves, plates, joins, tissue and landmarks in the order in which they were
// done. The face is never set back by a move: it follows the bones to where they are.
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/workers.h"
#include "sim/commands/command.h"
#include "sim/patient/snapshot.h"
#include "sim/skull/bone/bones.h"
#include "sim/skull/face/face_model.h"
#include "sim/skull/head/head_view.h"

namespace limberg {

/// A named place; at rest, on bone or face.
struct HeadLandmark {
  std::string name;
  Vec3 X_mm = Vec3::Zero();
  bool on_face = false;
  int32_t vertex = -1;    // face: the nearest one; it carries the place
  int32_t fragment = -1;  // bone
};

/// What a head is made of; from the synthetic head or from files.
struct HeadParts {
  std::vector<bone::NamedMesh> bones;
  simplex::Mesh face;                   // no vertices: there is none
  std::vector<HeadLandmark> landmarks;  // name, X_mm, on_face
  std::vector<ConnectTissue> tissues;   // connected in this order; one that cannot be is an InputError
  int face_iterations = 12;             // of one step
};

/// The bones when the skull was laid upon another (Superpose).
struct SkullMoment {
  std::string name;  // "1", "2", ... where none was given
  SkullBeside on = SkullBeside::normal;
  std::shared_ptr<const simplex::Mesh> rest;           // shared with other moments of the same mesh
  std::vector<Vec3> now_mm;                            // per vertex slot
  std::vector<int32_t> fragment;                       // per vertex slot; -1 none
  std::vector<std::pair<int32_t, std::string>> names;  // of fragments, by number
};

struct HeadStep {
  double max_move_mm = 0;  // of the face, in the last iteration
  bool at_rest = true;     // nothing is held, and the face has come to rest
};

class Head {
 public:
  Head(HeadParts parts, Workers& workers);
  ~Head();

  /// Acts on bone and face, undo, redo, stage and wait. What acts on skin is refused.
  Outcome apply(const Command& command);
  HeadStep step(double dt_s);
  /// Reuses the snapshot's memory.
  void fill(Snapshot& snapshot) const;
  std::shared_ptr<const SurfaceTopology> topology() const { return view_.topology(); }
  uint64_t topology_hash() const;
  uint64_t state_hash() const;

  const bone::Bones& bones() const { return bones_; }
  const simplex::Mesh& face() const { return face_.face(); }
  const simplex::FaceModel& face_model() const { return face_; }
  bool has_face() const { return has_face_; }
  /// Bones where they are now.
  const simplex::Mesh& bones_now() const { return placed_; }
  const HeadView& view() const { return view_; }
  const std::vector<HeadLandmark>& landmarks() const { return landmarks_; }
  /// Where a landmark is now, and where it was at first.
  Vec3 landmark_mm(const HeadLandmark& l) const;
  std::vector<std::pair<std::string, Vec3>> landmarks_now() const;
  std::vector<std::pair<std::string, Vec3>> landmarks_at_rest() const;
  const std::vector<ConnectTissue>& tissues() const { return tissues_; }
  /// When the skull was laid upon another, and what it is shown upon now.
  const std::vector<SkullMoment>& skull_moments() const { return moments_; }
  SkullBeside beside() const { return beside_; }
  bool can_undo() const { return !done_.empty() && bones_.held() < 0; }
  int refused() const { return refused_; }
  uint64_t steps() const { return steps_; }

 private:
  struct Done {
    bool bones = false;                   // an act of Bones
    std::vector<HeadLandmark> landmarks;  // before it
    std::vector<ConnectTissue> tissues;
    std::unique_ptr<simplex::FaceModel> face;  // before it, where it changed what the tissue is tied to
  };

  Outcome act(const HeadCommand& command);
  Outcome act(const CutBone&);
  Outcome act(const MoveFragment&);
  Outcome act(const GrabFragment&);
  Outcome act(const DragFragment&);
  Outcome act(const LetGo&);
  Outcome act(const PlateFragments&);
  Outcome act(const JoinFragments&);
  Outcome act(const ConnectTissue&);
  Outcome act(const PlaceLandmark&);
  Outcome act(const Superpose&);
  Outcome act(const Unplate&);
  Outcome act(const SortFragments&);
  Outcome undo();
  Outcome redo();
  Outcome connect(const ConnectTissue& tissue);
  Done moment(bool bones, bool with_face) const;
  void remember(Done before);
  void swap_with(Done& other);  // of undo and redo
  Outcome go(std::vector<Done>& from, std::vector<Done>& to, const std::function<Outcome()>& bones);
  int32_t find(const FragmentPick& pick, std::string& reason) const;
  Vec3 centre_now(int32_t fragment) const;
  void tie(HeadLandmark& landmark) const;
  void bones_changed(uint64_t version_before);
  void place_bones();
  void topology_changed();

  Workers& workers_;
  bone::Bones bones_;
  simplex::FaceModel face_;
  bool has_face_ = false;
  int face_iterations_ = 12;
  simplex::Mesh placed_;                  // the bones' mesh with x_mm where they are now
  std::vector<Eigen::Isometry3d> poses_;  // that placed_ and the face have been told
  uint64_t placed_version_ = 0;
  std::vector<HeadLandmark> landmarks_;
  std::vector<ConnectTissue> tissues_;
  std::vector<SkullMoment> moments_;
  uint64_t moment_version_ = 0;  // of the bones, in the last of them
  SkullBeside beside_ = SkullBeside::off;
  HeadView view_;
  Eigen::Isometry3d grabbed_at_ = Eigen::Isometry3d::Identity();
  Vec3 grabbed_centre_ = Vec3::Zero();
  int held_by_ = -1;  // which hand
  std::vector<Done> done_, undone_;
  HeadStep last_;
  uint64_t steps_ = 0;
  int refused_ = 0;
};

}  // namespace limberg
