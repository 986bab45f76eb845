#pragma once
// Where the tissue under a face stands on bone: three vertices of the bone carry a place and a turn, which is how both
// follow the fragment that owns these vertices, and how they are found again after a cut.
#include <cstdint>
#include <span>
#include <vector>

#include "sim/geometry/bvh.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/mesh.h"
#include "sim/skull/simplex/tissue.h"

namespace limberg::simplex {

struct Foot {
  BoneAnchor at;
  Vec3 rest_mm = Vec3::Zero();   // where it stands on the bones at rest
  Mat3 turn = Mat3::Identity();  // of its bone from rest to when it was connected
  Vec3 now_mm = Vec3::Zero();    // place and turn (since connected) of the last carry
  Mat3 now_turn = Mat3::Identity();
};

Vec3 place_of(const BoneAnchor& anchor, const Mesh& bones);
Foot make_foot(const BoneAnchor& anchor, const Mesh& bones_now, const Mesh& bones_at_rest);

/// The map x -> Q x + c of what stands over a foot, since the last
/// carry; how far the foot itself went, mm. The foot is then there.
struct Carry {
  Mat3 Q = Mat3::Identity();
  Vec3 c = Vec3::Zero();
  double far_mm = 0;
  bool moved() const { return far_mm > 1e-9 || !Q.isIdentity(1e-12); }
  Vec3 operator()(const Vec3& x) const { return Q * x + c; }
};
Carry carry(Foot& foot, const Mesh& bones_now);

/// The surface of bones as triangles to stand on: cut faces and holes are none.
class Standing {
 public:
  /// `region`: vertices around whose faces alone there is ground; empty: all of it.
  Standing(const Mesh& bones, std::span<const int32_t> region);
  /// Only the faces that reach into a box.
  Standing(const Mesh& bones, const Vec3& lo_mm, const Vec3& hi_mm);
  bool empty() const { return bvh_.empty(); }
  /// The place of the ground nearest to p: three vertices of the face it
  /// lies in carry p. How far it is, mm; less than 0: there is no ground.
  double stand(const Vec3& p_mm, BoneAnchor& anchor) const;

 private:
  void build(const std::vector<uint8_t>& in);
  const Mesh& bones_;
  FanTriangles fan_;
  Bvh bvh_;
};

/// The whole of `now` moved as one rigid body from `was`: the map; false when it did not move, or not as one (1e-9 mm).
bool moved_as_one(const std::vector<Vec3>& was_mm, const Mesh& now, Eigen::Isometry3d& map);

}  // namespace limberg::simplex
