#pragma once
// What the layers of a body take of a lattice cell: their volumes and moments in it, nothing of what lies outside.
//
// A cell is looked at on the corners of kSplit^3 boxes: the distance to the body's surface (negative outside) and the
// depth below its skin (Skin::place, as the layers count it). A box in which one layer is certain counts whole,
// exactly. Any other is cut in six tetrahedra, in which both fields are taken as linear; each is clipped by the surface
// and by the layers' borders, and the pieces are integrated with the four-point rule of degree two. So a layer between
// flat borders has its exact volume, centroid and second moments wherever the borders fall in the cell. Where corners
// of a tetrahedron lie below skins that face different ways (a fold) it has both depths, each of them linear, and a
// layer is where the lesser is: two skins nearer to each other than a cell are both seen. On a sphere of radius R the
// error of a depth is at most that of its chords, 3 (h / kSplit)^2 / 8R (h 5 mm, R 30: .02 mm), the same for both
// borders of a layer. Edges of the surface are rounded by a part of a box: at the rim of a flat slab of 60 mm up to .8
// % of its skin at 5 mm is lost.
#include <array>
#include <vector>

#include "sim/body/skin.h"
#include "sim/lattice/shared_cells.h"

namespace limberg {

/// Of the box [lo, hi] (cell units), exactly.
CellMoments box_cell_moments(const Vec3& cell_mm, const Vec3& lo, const Vec3& hi);

/// Points (cell units) with volumes (mm^3) of one layer.
struct LayerPoint {
  int layer = 0;
  double volume_mm3 = 0;
  Vec3 at = Vec3::Zero();
  size_t matter = 0;  // what it is made of: the layer, or a region (region_cells.h)
  double edge = 0;    // of a cube that it stands for, in cell units; 0: none
};

class CellCutter {
 public:
  /// `end_mm`: the depth at which each layer ends but for the last, ascending.
  CellCutter(const Vec3& cell_mm, std::vector<double> end_mm);
  const Vec3& cell_mm() const { return cell_mm_; }
  /// Per layer.
  std::vector<CellMoments> moments(const CellSamples& samples) const;
  /// The same as points: of a box or a piece of it its centroid.
  std::vector<LayerPoint> points(const CellSamples& samples) const;
  /// The same with the moments of moments(): of a box eight cubes, of a piece four points.
  std::vector<LayerPoint> fine_points(const CellSamples& samples) const;

 private:
  struct Tet;
  template <class Box, class Piece>
  void visit(const CellSamples& samples, Box&& box, Piece&& piece) const;
  template <class Piece>
  void layers_of(const Tet& t, size_t layer, Piece&& piece) const;
  Vec3 cell_mm_;
  std::vector<double> end_mm_;
  std::vector<CellMoments> box_;  // of each box
};

/// The moments as share_cell() takes them.
LayerMoments layer_moments(const Vec3& cell_mm, const CellMoments& m);

}  // namespace limberg
