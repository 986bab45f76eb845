#pragma once
// How a range scan lies: the plane that fits it best, the side that it is seen from, and its heights over that plane.
// A mesh that starts as a plane lies before the scan in this frame, wherever the scan was turned, and comes down upon
// its heights as a cloth would; beyond the scan's edge it goes on as an apron, which is opened at the end.
#include <vector>

#include "sim/geometry/point_tree.h"
#include "sim/geometry/vec.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg {

struct ScanView {
  Vec3 middle_mm = Vec3::Zero();
  Vec3 across = Vec3::UnitX(), up = Vec3::UnitY(),
       front = Vec3::UnitZ();   // right-handed; front: towards who looks at the scan
  Vec3 half_mm = Vec3::Zero();  // of the scan along the three
  Vec3 local(const Vec3& x) const {
    return {across.dot(x - middle_mm), up.dot(x - middle_mm), front.dot(x - middle_mm)};
  }
  Vec3 place(const Vec3& q) const { return middle_mm + q.x() * across + q.y() * up + q.z() * front; }
  /// Half sides of the sheet that starts before it: larger than the scan, so that its edge is within.
  Vec2 sheet_mm() const;
};

/// `front` is the principal axis of least spread (triangles, if there are any, count by their area and points alike),
/// or the one along which its silhouette is clearly largest; on the side that the triangles look to. Without triangles,
/// or with ones that look to either side alike, it is the side to which the scan bulges. Where `from` is not zero the
/// scan is seen from there: front is its direction. Throws InputError with fewer than 3 points, at places that are not
/// finite, when all are the same, or when `from` is not finite.
ScanView view_of(const std::vector<Vec3>& points_mm, const std::vector<Tri>& tri = {}, const Vec3& from = Vec3::Zero());

/// Median distance to the fourth nearest: about the spacing of a scan, whatever its pattern. For an empty scan 0.
double spacing_of(const std::vector<Vec3>& points_mm);

/// The same around each point: the median over it and its eight nearest,
/// so that a stray point far from the scan has no large one of its own.
std::vector<double> spacings_of(const PointTree& points_mm);

/// The points that are seen from the front, in their order. Hidden are those behind a triangle by more than a spacing;
/// of a cloud those with a gap of four spacings in the column of points above them; most of the eight neighbours decide
/// for points whose own answer differs from theirs.
std::vector<Vec3> seen_from_front(const std::vector<Vec3>& points_mm, const std::vector<Tri>& tri,
                                  const ScanView& view);

/// Points of a scan, and which way the surface looks at each of them (unit; empty: not known).
struct SeenScan {
  std::vector<Vec3> x_mm, looks;
};

/// The points that are seen from around, in their order. What looks at
/// other parts of the scan, as the deep side of a shell does, is
/// hidden: three quarters of the directions within 60 degrees of its
/// normal meet a triangle. Neighbouring triangles must agree which side
/// is which; the volume that they bound says which one is outside.
/// Otherwise, and in a cloud, every point counts and none has a normal.
SeenScan seen_from_around(const std::vector<Vec3>& points_mm, const std::vector<Tri>& tri);

/// A sheet of about 2000 vertices before the scan, its normal along `front`.
simplex::Mesh start_plane(const ScanView& view);

/// Height along `front` of what is seen first, by cells; cells
/// without points have the height of the nearest one that has some.
class ScanHeights {
 public:
  /// cell_mm: wanted side of a cell; there are at most 512 x 512.
  ScanHeights(const std::vector<Vec3>& points_mm, const ScanView& view, double cell_mm);
  const ScanView& view() const { return view_; }
  /// Bilinear; q in the view's frame, clamped to the sheet.
  double at(const Vec3& q) const;

 private:
  ScanView view_;
  Vec2 low_;
  double cell_ = 1;
  int nx_ = 1, ny_ = 1;
  std::vector<double> height_;
};

/// Whether the neighbours of a point (itself among them) leave a gap of 120 degrees or more around it; `outward`: into
/// the gap, in their plane. Neighbours of a place within a scan are all around it.
bool at_edge(const Vec3& x, const std::vector<Vec3>& around, Vec3& outward);

}  // namespace limberg
