#pragma once
// All bones of a head, and what the surgeon does to them: osteotomies, fragments moved by hand or by numbers, plates.
//
// All bones lie in one simplex mesh, at rest; each component of it is a fragment with a pose, which takes it from rest
// to where it is now. Cut: the largest piece keeps number, name and whether it is fixed; the others get new numbers and
// the same pose. Pieces keep zones, flags and kept contours.
//
// Physics: from grab to release the fragments are rigid bodies of a Bullet world (rigid_world.h), which is built at the
// grab from the poses and thrown away at the release (and made anew when a second hand grabs or lets go). So what
// happens depends on the poses and the drags alone, never on what was done before; and where nothing is held there is
// no Bullet world.
//
// Every act returns what takes it back (BoneChange), for the patient's history (patient/history.h): the mesh to the bit
// (simplex::Delta; again by doing it again), fragments, poses and plates from copies.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/base/workers.h"
#include "sim/commands/acted.h"
#include "sim/skull/bone/osteotomy.h"
#include "sim/skull/bone/seam.h"
#include "sim/skull/bone/surface_work.h"
#include "sim/skull/simplex/edit.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg::bone {

struct FragmentShape;

/// Of the last step of the Bullet world (rigid_world.h).
struct RigidFigures {
  int substeps = 0, pairs = 0, contacts = 0;
  double deepest_mm = 0;  // overlap of the bodies' convex pieces at its end
};

/// `mesh` may have several parts: each becomes a bone of that
/// name. Closed cavities (parts turned inside out) are filled.
struct NamedMesh {
  std::string name;
  simplex::Mesh mesh;
  bool fixed = false;  // cannot be moved
};

struct Fragment {
  int32_t id = -1;  // never given twice
  std::string name;
  int32_t vertex = -1;  // the smallest of its vertices
  bool fixed = false;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  // from rest to now
  double volume_mm3 = 0;
  Vec3 centre_mm = Vec3::Zero();  // of its volume, at rest
};

/// Between the cut surfaces of two fragments that were cut from each other, or wherever two fragments overlap.
struct Gap {
  int32_t a = -1, b = -1;                  // fragments, a < b
  double gap_mean_mm = 0, gap_max_mm = 0;  // from a's cut surface to b's; where one lies within the other it is 0
  double overlap_max_mm = 0;               // how deep a place of one surface lies within the other
  double overlap_mm3 = 0;
};

struct Plate {
  int32_t a = -1, b = -1;                         // fragments
  Vec3 a_mm = Vec3::Zero(), b_mm = Vec3::Zero();  // its ends, at rest
};

/// Fragments and plates; the mesh aside.
struct BonesState {
  std::vector<Fragment> fragments;
  std::vector<Plate> plates;
  int32_t next_id = 0;
};

template <class V>
void fields(const Fragment& f, V&& v) {
  const auto& [id, name, vertex, fixed, pose, volume_mm3, centre_mm] = f;
  v(id, name, vertex, fixed, pose.matrix(), volume_mm3, centre_mm);
}
template <class V>
void fields(const Plate& p, V&& v) {
  const auto& [a, b, a_mm, b_mm] = p;
  v(a, b, a_mm, b_mm);
}
template <class V>
void fields(const BonesState& s, V&& v) {
  const auto& [fragments, plates, next_id] = s;
  v(fragments, plates, next_id);
}

/// What takes an act on bone back, and makes it again. Changes are taken back in the reverse order of their making.
struct BoneChange {
  enum class Kind { cut, join, work, state } kind = Kind::state;
  Osteotomy what;          // cut: the fragment is named
  int32_t a = -1, b = -1;  // join
  double smooth_mm = 0;
  SeamReport seam;
  SurfaceWork work;
  int32_t worked = -1;  // work: the fragment
  simplex::Delta delta;
  BonesState before, after;
};
using ActedOnBone = Acted<BoneChange>;

class Bones {
 public:
  /// Throws InputError: no mesh, or one that find_fault finds fault with.
  Bones(std::vector<NamedMesh> bones, Workers& workers);
  ~Bones();
  Bones(Bones&&) noexcept;
  Bones& operator=(Bones&&) noexcept;

  const simplex::Mesh& mesh() const { return mesh_; }                        // at rest
  uint64_t version() const { return version_; }                              // grows when the mesh changes
  const std::vector<Fragment>& fragments() const { return now_.fragments; }  // by number
  const Fragment* fragment(int32_t id) const;                                // null: there is none
  int32_t fragment_of(int32_t vertex) const;                                 // -1: no such vertex
  const std::vector<Plate>& plates() const { return now_.plates; }
  /// Where a vertex is now.
  Vec3 now_mm(int32_t vertex) const;
  /// The fragment whose surface at rest is nearest, and that place.
  int32_t nearest_fragment(const Vec3& rest_mm, Vec3* on_bone_mm = nullptr) const;

  /// Refused: see osteotomy.h; while a fragment is held.
  ActedOnBone cut(const Osteotomy& what);
  /// Makes one bone of two where they are now (T3 between the cut surfaces that face each other); a fixed one keeps its
  /// place, else the one with the smaller number does, and the other one's rest is set anew. Its number goes.
  /// smooth_mm: the seam is smoothed in a band of that reach (seam.h); 0: not.
  ActedOnBone join(int32_t a, int32_t b, double smooth_mm = 0);
  /// Work on a fragment's surface that cuts nothing (surface_work.h). Refused with its reasons.
  ActedOnBone work(int32_t id, const SurfaceWork& what);
  /// Six numbers; contact is not asked. What is plated to it moves along.
  ActedOnBone move(int32_t id, const Eigen::Isometry3d& pose);
  /// A plate between two fragments (places at rest): from now on they move as one.
  ActedOnBone plate(const Vec3& a_mm, const Vec3& b_mm);
  /// Takes all plates off a fragment. Refused: there is none on it.
  ActedOnBone unplate(int32_t id);
  /// Puts together what fits by its cut rings, wherever it lies (sorting.h; some 0.1 s a pair): of each group that
  /// verified pairs join, the fixed one stays, or the one with the smallest number. One act; in words what went where,
  /// and what fits nothing.
  /// Refused, with the reasons: nothing fits; all that fits lies so already; two fixed ones fit each other; a plate
  /// would be bent.
  ActedOnBone sort();

  /// One in each hand may be held at a time. Refused: it moves with one that is held.
  Outcome grab(int32_t id);
  void drag(int32_t id, const Eigen::Isometry3d& wanted_pose);
  /// Leaves it where it is. snap: when within kSnap_mm (of its centre) and
  /// kSnap_deg of fitting a fragment that it was cut from, it is put where it fits; to the nearest of several. In words
  /// which, or why not.
  ActedOnBone release(int32_t id, bool snap = false);
  void step(double dt_s);
  bool physics() const { return hold_ != nullptr; }
  RigidFigures physics_figures() const;
  bool holds(int32_t id) const;  // that fragment; -1: any
  static constexpr double kSnap_mm = 3, kSnap_deg = 10;

  /// Refused while a fragment is held.
  Outcome take_back(BoneChange& change);
  Outcome make_again(BoneChange& change);

  std::vector<Gap> gaps() const;
  /// Over mesh, fragments, poses and plates.
  uint64_t hash() const;
  uint64_t full_hash() const;  // and what follows from them

 private:
  int32_t index(int32_t id) const;
  std::string cut_mesh(const Osteotomy& what, simplex::Delta& delta);
  std::string join_mesh(BoneChange& join);
  WorkedSurface work_mesh(BoneChange& work);
  void find_vertex_of(int32_t id);  // whose smallest vertex may have gone
  void recount();                   // components after the mesh changed
  /// What the act answers. Whatever it throws, mesh and fragments are as they were.
  template <class Act>
  std::string all_of(Act&& act);
  ActedOnBone finish(BoneChange&& change, std::string words = {});
  std::vector<int32_t> plated(int32_t id) const;  // indices, itself included
  const FragmentShape& shape(int32_t id) const;   // at rest, kept until the mesh changes

  simplex::Mesh mesh_;
  BonesState now_;
  uint64_t version_ = 1;
  std::vector<int32_t> component_;  // per vertex slot
  std::vector<int32_t> id_of_component_;
  mutable std::vector<std::unique_ptr<FragmentShape>> shapes_;
  struct Held;
  /// A Bullet world of how things lie, with these in hands.
  std::unique_ptr<Held> make_hold(const std::vector<int32_t>& in_hand) const;
  std::unique_ptr<Held> hold_;  // while something is held
  Workers* workers_ = nullptr;
};

}  // namespace limberg::bone
