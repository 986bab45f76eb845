#pragma once
// Where earlier cuts lie on the surface at rest: drawn once more on the uncut model, to find what a later act of the
// peer's means: the nearest cut, the way along cuts from one to another, what a place on the skin is enclosed by.
#include <optional>
#include <vector>

#include "app/import/peer_model.h"

namespace limberg {

/// A line on the surface, its points at most CutLines::step_mm() apart.
using SurfaceLine = std::vector<SurfaceSpot>;

class CutLines {
 public:
  explicit CutLines(const PeerModel& model);

  double step_mm() const { return step_mm_; }

  /// Straight on the surface from one spot to another, both included: points of the chord, each laid on the surface
  /// beside the one before it.
  SurfaceLine between(const SurfaceSpot& a, const SurfaceSpot& b) const;
  SurfaceLine through(const std::vector<SurfaceSpot>& posts) const;

  /// `blade_through`: the cut goes through the body, and may have a line on its other side too.
  void add(const SurfaceLine& line, bool blade_through);
  bool empty() const { return line_.empty(); }

  struct Near {
    int line = -1, point = -1;  // -1: none
    Vec3 at_mm = Vec3::Zero();
    double distance_mm = 0;
    bool blade_through = false;
  };
  /// The nearest point of any line within reach_mm.
  std::optional<Near> nearest(const Vec3& X_mm, double reach_mm) const;
  /// The shortest way along lines, of which those that touch within two steps are joined; empty: none.
  std::vector<Vec3> way(const Near& from, const Near& to) const;

  /// Where a short piece of a line from a to b, on skin with this normal, first crosses a cut.
  struct Crossing {
    Vec3 at_mm = Vec3::Zero();
    double share = 0;  // of the piece
    bool blade_through = false;
  };
  std::optional<Crossing> crossing(const Vec3& a_mm, const Vec3& b_mm, const Vec3& normal) const;

  /// What the cuts enclose around a spot.
  struct Region {
    double area_mm2 = 0;
    bool blade_through = false;  // a cut through the body is part of its border
    std::vector<Vec3> outline;   // its longest border, counter-clockwise seen from outside, on the cuts
  };
  /// Nothing where the spot's side is more than half of the skin: nothing encloses it.
  std::optional<Region> region(const SurfaceSpot& spot) const;

 private:
  struct Line {
    std::vector<Vec3> at_mm;
    bool blade_through = false;
  };
  const PeerModel& model_;
  double step_mm_ = 0.5;
  std::vector<Line> line_;
};

}  // namespace limberg
