#pragma once
// A head: bones that can be cut and moved, the face over them, the tissue between, and named places on both.
//
//   Head head(parts, workers);
//   head.act(CutBone{...});            // atomic: done, or refused with a reason and nothing changed
//   head.step(dt_s);                   // fragments that are held (Bullet), then the face a little nearer to rest
//   head.fill(snapshot);
//
// Frame: mm, x to the right, y forwards, z upwards, origin midway between the ears, z = 0 the Frankfurt plane. Places
// of commands are on the bones at rest, where they were at first; a fragment's pose takes them to where they are now.
//
// Osteotomies, moves, plates, joins, tissue and landmarks give what takes them back to the patient's history
// (patient/history.h); one that fails half-way is taken back with it. The face is never set back by a move: it follows
// the bones to where they are.
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/workers.h"
#include "sim/commands/acted.h"
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
  simplex::Mesh face;                          // no vertices: there is none
  std::vector<HeadLandmark> landmarks;         // name, X_mm, on_face
  SurfaceColour colour;                        // may be empty
  std::shared_ptr<const FaceTexture> texture;  // of the face, instead; may be null
  std::vector<ConnectTissue> tissues;          // connected in this order; one that cannot be is an InputError
  std::vector<simplex::FaceBundle> muscles;
  std::vector<simplex::FaceSlide> slides;
  int face_iterations = 12;  // of one step
};

/// Skin with no bone nearer lies over none, and tissue ends before it. Six tenths of what is nearest, and 5 mm, may be
/// added where the way is along the normal (tissue.h: way_to_bone), and no tissue is thicker than 60.
inline constexpr double kSkinOverBone_mm = 34;

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

/// What acts change beside bones and face.
struct HeadState {
  std::vector<HeadLandmark> landmarks;
  std::vector<ConnectTissue> tissues;
};

template <class V>
void fields(const HeadLandmark& l, V&& v) {
  const auto& [name, X_mm, on_face, vertex, fragment] = l;
  v(name, X_mm, on_face, vertex, fragment);
}
template <class V>
void fields(const ConnectTissue& t, V&& v) {
  const auto& [name, face_mm, bone_mm, face_radius_mm, bone_radius_mm, face_outline_mm, layers, young_kPa, mode] = t;
  v(name, face_mm, bone_mm, face_radius_mm, bone_radius_mm, face_outline_mm, layers, young_kPa, mode);
}
template <class V>
void fields(const HeadState& s, V&& v) {
  const auto& [landmarks, tissues] = s;
  v(landmarks, tissues);
}

/// What takes an act on a head back, and makes it again: the bones' own change, and copies of the rest, which change
/// places with what is there.
struct HeadChange {
  std::optional<bone::BoneChange> bones;
  HeadState state;
  std::unique_ptr<simplex::FaceModel> face;  // where the act changed what the tissue is tied to
};
using ActedOnHead = Acted<HeadChange>;

class Head {
 public:
  Head(HeadParts parts, Workers& workers);
  ~Head();

  ActedOnHead act(const HeadCommand& command);
  /// Refused while a fragment is held.
  Outcome take_back(HeadChange& change);
  Outcome make_again(HeadChange& change);
  HeadStep step(double dt_s);
  /// Reuses the snapshot's memory.
  void fill(Snapshot& snapshot) const;
  std::shared_ptr<const SurfaceTopology> topology() const { return view_.topology(); }
  uint64_t topology_hash() const;
  uint64_t state_hash() const;
  /// Over all that undo and redo bring back, and what follows from it. For tests.
  uint64_t full_hash() const;

  const bone::Bones& bones() const { return bones_; }
  const simplex::Mesh& face() const { return face_.face(); }
  const simplex::FaceModel& face_model() const { return face_; }
  bool has_face() const { return has_face_; }
  /// Bones where they are now.
  const simplex::Mesh& bones_now() const { return placed_; }
  const HeadView& view() const { return view_; }
  const std::vector<HeadLandmark>& landmarks() const { return state_.landmarks; }
  /// As the head was made: before any was placed anew, and before joins set the rest of a bone anew.
  const std::vector<HeadLandmark>& first_landmarks() const { return first_landmarks_; }
  /// Where a landmark is now, and where it was at first.
  Vec3 landmark_mm(const HeadLandmark& l) const;
  std::vector<std::pair<std::string, Vec3>> landmarks_now() const;
  std::vector<std::pair<std::string, Vec3>> landmarks_at_rest() const;
  const std::vector<ConnectTissue>& tissues() const { return state_.tissues; }
  /// When the skull was laid upon another, and what it is shown upon now.
  const std::vector<SkullMoment>& skull_moments() const { return moments_; }
  SkullBeside beside() const { return beside_; }
  uint64_t steps() const { return steps_; }

 private:
  ActedOnHead act(const CutBone&);
  ActedOnHead act(const CutBoneByBlade&);
  ActedOnHead cut(const bone::Osteotomy& what);
  ActedOnHead act(const MoveFragment&);
  ActedOnHead act(const GrabFragment&);
  ActedOnHead act(const DragFragment&);
  ActedOnHead act(const LetGo&);
  ActedOnHead act(const PlateFragments&);
  ActedOnHead act(const JoinFragments&);
  ActedOnHead act(const ConnectTissue&);
  ActedOnHead act(const PlaceLandmark&);
  ActedOnHead act(const Superpose&);
  ActedOnHead act(const Unplate&);
  ActedOnHead act(const SortFragments&);
  ActedOnHead act(const SplitFace&);
  ActedOnHead act(const MergeFaces&);
  ActedOnHead act(const SmoothSurface&);
  ActedOnHead act(const PushSurface&);
  ActedOnHead work(const std::optional<FragmentPick>& of, const bone::SurfaceWork& what);
  Outcome connect(const ConnectTissue& tissue);
  HeadChange before(bool with_face) const;  // of an act: what it may change, as it is now
  template <class Rest>
  ActedOnHead finish(HeadChange& change, Rest&& rest);
  void swap_with(HeadChange& change);  // once the bones have gone their way
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
  HeadState state_;
  std::vector<HeadLandmark> first_landmarks_;
  std::vector<SkullMoment> moments_;
  uint64_t moment_version_ = 0;  // of the bones, in the last of them
  SkullBeside beside_ = SkullBeside::off;
  HeadView view_;
  SurfaceColour colour_;
  std::shared_ptr<const FaceTexture> texture_;
  struct Grabbed {
    int32_t fragment = -1;  // none
    Eigen::Isometry3d at = Eigen::Isometry3d::Identity();
    Vec3 centre_mm = Vec3::Zero();
  };
  std::array<Grabbed, kHands> grabbed_;  // by hand
  HeadStep last_;
  uint64_t steps_ = 0;
};

}  // namespace limberg
