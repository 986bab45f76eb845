#pragma once
// What regions (body/region.h) take of a cell: the parts of its layers that are theirs.
//
// Points of the layers in the cell (cut_cells.h) go to the last region that holds them. The depths between which a
// region lies part them as the layers' borders do, exactly. Beside its other borders, within half a spacing of the
// points, a point goes to both in proportion, so that what a region takes changes evenly with its place.
#include <span>
#include <vector>

#include "sim/body/skin.h"
#include "sim/lattice/cut_cells.h"

namespace limberg {

/// A piece of a cell of one matter: an index into what layer_matter() gives, the layers first and then the regions.
struct CellPart {
  int layer = 0;
  size_t matter = 0;
  StretchFrame frame;
  CellMoments moments;
};

class RegionCells {
 public:
  /// `end_mm`: the depth at which each layer ends but for the last, ascending.
  RegionCells(const Skin& skin, std::span<const double> end_mm);
  /// Whether any region may reach to within `reach_mm` of a place.
  bool reach(const Vec3& X_mm, const Skin::Place& place, double reach_mm) const;
  /// What a cell is made of.
  std::vector<LayerPoint> points(const Vec3& low_mm, const Vec3& cell_mm, const CellSamples& samples) const;
  /// Index into layer_matter() of what is at a place of a layer.
  size_t matter(const Vec3& X_mm, const Skin::Place& place, int layer) const;
  /// The axes of each matter at the cell's centre: the skin's, or along a region's fibres.
  std::vector<StretchFrame> frames(const Vec3& centre_mm, const StretchFrame& skin) const;

 private:
  const Skin& skin_;
  std::vector<double> border_mm_;  // ends of layers and regions, ascending
  std::vector<int> layer_;         // between these borders
};

/// Points of the same layer and matter together, in their order.
std::vector<CellPart> parts_of(std::span<const LayerPoint> points, std::span<const StretchFrame> frames);

/// What the body is made of at a place, and the axes of its prestretch and fibres there.
struct MatterAt {
  size_t matter = 0;  // as CellPart::matter
  const Material* material = nullptr;
  StretchFrame frame;
};
MatterAt matter_at(const Skin& skin, const Vec3& X_mm, int layer, Skin::Near& near);

}  // namespace limberg
