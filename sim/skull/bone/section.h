#pragma once
// Where a surface (a plane, a ribbon) crosses the edges of a bone, and the closed curves that the crossings make.
//
// A crossing belongs to an edge: which end lies on the left (the side that the surface's normal points to), and where.
// Two crossings in one face are joined. A face that is crossed more than twice is mended: the curve is led round the
// vertex that it lies nearest to (the vertex changes sides, its three edges are crossed or not the other way round), so
// that the curve moves by less than an edge there. What cannot be mended is refused later by t4_edges, with its reason.
#include <cstdint>
#include <span>
#include <vector>

#include "sim/skull/simplex/operators.h"

namespace limberg::bone {

class Section {
 public:
  explicit Section(const simplex::Mesh& mesh) : m_(mesh), share_(3 * mesh.nbr.size(), -1) {}
  /// The edge of h = left -> right is crossed at that share of the way from left, 0..1.
  void cross(int32_t h, double share) { share_[size_t(h)] = share; }
  bool crossed(int32_t h) const { return share_[size_t(h)] >= 0 || share_[size_t(m_.twin(h))] >= 0; }
  /// Leads the curves round single vertices where a face is crossed more than twice. Returns how often.
  int mend();

  struct Curves {
    std::vector<std::vector<simplex::Crossing>> closed;  // by smallest vertex on the left
    int open = 0;                                        // ends within a face
    int over_ends = 0;                                   // runs over a hole
  };
  /// Where a ribbon folds, single crossings have their sides the wrong way round: a curve has the sides of most of its
  /// crossings (a surface that is closed has two sides along any curve).
  Curves curves() const;

 private:
  std::vector<double> one_sided() const;
  void turn(int32_t v);
  const simplex::Mesh& m_;
  std::vector<double> share_;  // per half-edge; < 0: not crossed
};

/// The plane through the vertices that `in` marks. A vertex on the plane counts as on the side of the normal.
Section section_of_plane(const simplex::Mesh& mesh, std::span<const uint8_t> in, const Vec3& point_mm,
                         const Vec3& normal);

/// A ribbon of triangles (normals to the left), an odd number of times through an edge counts as once.
Section section_of_ribbon(const simplex::Mesh& mesh, std::span<const uint8_t> in, const std::vector<Vec3>& X_mm,
                          const std::vector<Tri>& tri);

}  // namespace limberg::bone
