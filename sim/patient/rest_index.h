#pragma once
// Where on the current surface is a material point? An index over one SurfaceView.
//
// A chart point names a place on the original skin. After cuts that place may carry several sheets: the two banks of an
// incision meet there in rest space. `locate` finds the sub-triangle of the named original triangle that holds the
// point; `snap_to_rim` moves a point that lies beside a wound's edge onto that edge, on the bank where the point lies.
// Everything is decided on rest positions, so the answers do not depend on the deformation.
#include <optional>
#include <vector>

#include "sim/base/short_lists.h"
#include "sim/cutting/arrangement/surface_view.h"

namespace limberg {

/// A point of the surface: a triangle of the view and barycentric weights (sum 1).
struct SurfacePoint {
  int32_t triangle = -1;
  Vec3 bary = Vec3::Zero();
};

class RestIndex {
 public:
  RestIndex(const SurfaceView& view, size_t body_triangles);
  /// The same from the index of the view before, at the cost of what has changed and of the length of the rim.
  RestIndex(const SurfaceView& view, const RestIndex& before, const ViewChange& change);

  /// The live triangle that descends from original triangle `origin` and holds X_mm (nearest of them within
  /// slack_mm otherwise); nothing when the place has been cut away.
  std::optional<SurfacePoint> locate(const Vec3& X_mm, int32_t origin, double slack_mm) const;

  /// The nearest live skin triangle within reach_mm of X_mm,
  /// whatever its origin. Linear in the number of skin triangles.
  std::optional<SurfacePoint> nearest_skin(const Vec3& X_mm, double reach_mm) const;

  /// The nearest point of a wound's rim within reach_mm, on the bank that `p` belongs to. Nothing if no rim is near.
  std::optional<SurfacePoint> snap_to_rim(const SurfacePoint& p, double reach_mm) const;

  Vec3 rest_mm(const SurfacePoint& p) const;
  /// Barycentric weights of the point of triangle t closest to X_mm.
  Vec3 weights(int32_t t, const Vec3& X_mm) const;
  /// Whether both hold the same triangles and rim edges in the same order. O(triangles), for tests.
  bool same_as(const RestIndex& other) const { return by_origin_ == other.by_origin_ && rim_ == other.rim_; }
  size_t rim_edges() const { return rim_.size(); }
  /// Total length of the rim in mm (both banks counted).
  double rim_length_mm() const;

 private:
  struct RimEdge {
    int32_t triangle;  // the skin triangle
    int32_t corner;    // the edge runs from this corner to the next
    bool operator==(const RimEdge&) const = default;
  };
  /// Triangles by the names of their sided faces: what comes first does not depend on how a view was numbered.
  int32_t name(int32_t t) const { return view_.sided_face.empty() ? t : view_.sided_face[size_t(t)]; }
  Vec3 corner(int32_t t, int k) const { return view_.X_mm[size_t(view_.tri[size_t(t)][size_t(k % 3)])]; }
  void find_all(size_t body_triangles);
  SurfacePoint closest_in(int32_t t, const Vec3& X, double& distance2) const;

  struct Mesh {  // what is read of a view; shares what it holds
    explicit Mesh(const SurfaceView& v);
    SharedArray<Vec3> X_mm;
    SharedArray<Tri> tri;
    SharedArray<FaceKind> kind;
    SharedArray<int32_t> sided_face, origin;
    SharedArray<uint8_t> rim;
  };
  const Mesh view_;
  ShortLists by_origin_;      // triangles of each original triangle, by name
  std::vector<RimEdge> rim_;  // by name
};

}  // namespace limberg
