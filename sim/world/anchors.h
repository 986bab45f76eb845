#pragma once
// Hooks and stitches: what holds the tissue from outside, and how it keeps its place when the topology changes.
#include <optional>
#include <vector>

#include "sim/fem/elastic_solver.h"
#include "sim/snapshot.h"
#include "sim/world/rest_index.h"

namespace limberg {

/// A material point that a hook or a stitch holds. `hint_mm` lies a little inside its triangle, so that the bank of a
/// cut stays the same when triangles are split again.
struct Anchor {
  Vec3 X_mm = Vec3::Zero();
  Vec3 hint_mm = Vec3::Zero();
  int32_t origin = -1;  // triangle of the body's original surface
  SurfacePoint at;
  EmbeddedPoint embedded;
};

struct Hook {
  int32_t id = 0;      // as scripts name it
  int32_t spring = 0;  // as the solver names it
  Anchor anchor;
  Vec3 handle_mm = Vec3::Zero();
};

struct Stitch {
  int32_t id = 0;      // 1, 2, ... in order of placing
  int32_t spring = 0;
  Anchor a, b;
  Vec3 slack_mm = Vec3::Zero();  // a - b still left open while the thread is drawn tight
};

/// Finds the anchor of a surface point; `point` comes from the RestIndex of the same view.
Anchor make_anchor(const SurfaceView& view, const RestIndex& index, const SurfacePoint& point);

/// The same material point on a newer view; nothing when its tissue was removed.
std::optional<Anchor> carry_anchor(const Anchor& anchor, const SurfaceView& view, const RestIndex& index);

/// n points of a polyline, equally spaced by arc length, ends included (n >= 2; path.size() >= 2).
std::vector<Vec2> resample(const std::vector<Vec2>& path, int n);
double path_length_mm(const std::vector<Vec2>& path);

}  // namespace limberg
