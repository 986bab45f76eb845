#pragma once
// The tissue of a peer's scene in mm, with what its places are looked up in: the texture of every triangle, its
// material, and how deep the skin is.
//
// Materials are numbers in the peer's OBJ files: 1 the periphery, 2 skin and mucosa, 7 periosteum; 5 a bed that is
// bare from the beginning. While it operates it makes others: 3 the cut side of skin, 4 the underside of a flap, 5 its
// bed, 6 cut muscle, 8 undermined periosteum. Those keep the texture of what they were: the unoperated model suffices.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/import/peer_files.h"
#include "sim/geometry/bvh.h"
#include "sim/geometry/tri_mesh.h"

namespace limberg {

namespace peer_material {
inline constexpr int periphery = 1, skin = 2, cut_side = 3, underside = 4, bed = 5, muscle = 6, periosteum = 7,
                     undermined_periosteum = 8;
}

struct PeerModel {
  std::string file;                            // of the OBJ
  double unit_mm = 1;                          // of its numbers
  double history_mm = 1;                       // of a history's displacements: an edge of the peer's lattice
  TriMesh mesh;                                // mm, uv; untagged, vertices as in the file
  std::vector<int> material;                   // per triangle
  std::vector<std::array<int32_t, 3>> across;  // per triangle, over the edge from corner k to k + 1; -1: none
  std::vector<Vec3> normal;                    // per vertex, outwards, unit
  std::vector<Vec3> deep_mm;                   // per vertex: where the skin ends below it; NaN: not known
  Bvh all;
  Vec3 low_mm = Vec3::Zero(), high_mm = Vec3::Zero();

  Vec3 at(int32_t triangle, const std::array<double, 3>& bary) const;
  Vec3 normal_at(int32_t triangle, const std::array<double, 3>& bary) const;
  /// Depth of the skin, or nothing where no deep point is known at one of the corners.
  std::optional<double> depth_mm(int32_t triangle, const std::array<double, 3>& bary) const;
  double median_depth_mm() const;  // of all deep points; 0: there are none
};

/// Throws InputError: broken, not of triangles, materials that are no numbers, no skin, no texture. `bed` may be null.
PeerModel parse_peer_model(std::string_view obj, const std::string& file, const PeerScene& scene, const PeerBed* bed,
                           const std::string& bed_file, double unit_mm);

/// A place on the surface.
struct SurfaceSpot {
  int32_t triangle = -1;
  std::array<double, 3> bary{};
  Vec3 at_mm = Vec3::Zero();
};

/// The point nearest to `to` on the part of the surface, of the start's material, that hangs together with `start`
/// within reach_mm of it: on a lid or a lip not the one on its other side.
SurfaceSpot walk_to(const PeerModel& m, const SurfaceSpot& start, const Vec3& to_mm, double reach_mm);

struct FoundPlace {
  SurfaceSpot start, spot;  // where the texture says; that walked on by the displacement
  double moved_mm = 0;      // the displaced point lay so far off the surface
  bool inner = false;       // of a cut face: `inner_mm` is the place, `spot` the skin above it
  Vec3 inner_mm = Vec3::Zero();
};
/// Nothing, with a reason, when no triangle holds the place.
std::optional<FoundPlace> find_place(const PeerModel& m, const PeerPlace& place, std::string& reason);

}  // namespace limberg
