#pragma once
// Hooks and stitches: what holds the tissue from outside, and how it keeps its place when the topology changes.
#include <optional>
#include <string>
#include <vector>

#include "sim/body/skin.h"
#include "sim/commands/skin_acts.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/patient/rest_index.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// A material point that a hook or a stitch holds. `hint_mm` lies a little inside its triangle, so that the bank of a
/// cut stays the same when triangles are split again. A buried bite lies in the wall of a wound.
struct Anchor {
  Vec3 X_mm = Vec3::Zero();
  Vec3 hint_mm = Vec3::Zero();
  int32_t origin = -1;  // triangle of the body's original surface
  SurfacePoint at;
  EmbeddedPoint embedded;
  double bite_mm = 0;  // of a stitch: how far from it, along its wound's edge and behind it, it holds
  // places whose mean it holds, of a stitch in its bite, of a hook under its tip; empty: one place
  std::vector<HeldPlace> wide;
  // of a wall at rest, out of the tissue: tells the two walls of a cut apart. Zero: on the skin
  Vec3 wall_normal = Vec3::Zero();
  bool in_wall() const { return !wall_normal.isZero(0); }
};

struct Hook {
  int32_t id = 0;      // as scripts name it
  int32_t spring = 0;  // as the solver names it
  Anchor anchor;
  Vec3 handle_mm = Vec3::Zero();
};

/// A stitch, or a span of a thread: across the wound, where it counts as a stitch, or along its edges.
struct Stitch {
  int32_t id = 0;  // 1, 2, ... in order of placing; 0: a span along the wound
  int32_t spring = 0;
  Anchor a, b;
  // a - b still left open while the thread is drawn tight. Of a thread's span along the wound: the way from bite to
  // bite when it was sewn, which it keeps (spring_forces.h).
  Vec3 slack_mm = Vec3::Zero();
  int32_t thread = 0;              // its number; 0: this stitch has a thread of its own
  double tied_N = -1, peak_N = 0;  // of states at rest (snapshot.h)
  double own_mm = -1;              // of a thread that was let go: so much of it lies in this span; else less than 0
  bool across() const { return id > 0; }
  bool drawn() const { return thread > 0 || slack_mm.isZero(0); }  // as far as it depends on itself
};

/// One thread through several bites (spring_forces.h). It is drawn until the wound is closed.
struct Thread {
  int32_t id = 0;
  double length_mm = 0;  // now, without tension
  double slack_mm = 0;   // given back once it is closed
  bool corner = false;   // closed when it runs straight; else when the edges meet at every stitch of it
  bool closing = true;
  bool open = false;  // the needle is on it: it is sewn bite after bite, and not tied yet
  // Open, and nobody holds its end: it slips through its bites (sutures.h). `closing`: it is slipping now.
  bool let_go = false;
};

/// A load of the scene on the patch of skin around its anchor.
struct PlacedLoad {
  Anchor anchor;
  Vec3 force_N = Vec3::Zero();
  double radius_mm = 0;
};

/// Finds the anchor of a surface point; `point` comes from the RestIndex of the same view.
Anchor make_anchor(const SurfaceView& view, const RestIndex& index, const SurfacePoint& point);

/// The bite `depth_mm` below a point of a wound's rim, in the wall of its own bank: of the places of that depth the one
/// nearest to the rim point. Nothing when the wound is not so deep there. O(triangles)
std::optional<Anchor> make_buried_anchor(const SurfaceTopology& surface, const RestIndex& index,
                                         const SurfacePoint& rim, double depth_mm);

/// The nearest place of that kind of cut face within kWallReach_mm of a place at rest: of a flap's underside and its
/// bed, which lie in one place there, the one that looks away from the skin or towards it. O(triangles)
std::optional<Anchor> make_wall_anchor(const SurfaceView& view, const RestIndex& index, const Skin& skin,
                                       const Vec3& X_mm, HeldSide side);
inline constexpr double kWallReach_mm = 4.0;

/// The same material point on a newer view; nothing when its tissue was removed. O(triangles) for one in a wall.
std::optional<Anchor> carry_anchor(const Anchor& anchor, const SurfaceView& view, const RestIndex& index);

/// n points of a polyline, equally spaced by arc length, ends included (n >= 2; path.size() >= 2).
std::vector<Vec2> resample(const std::vector<Vec2>& path, int n);
/// How many stitches a row along two edges has, its ends included: as many as that spacing wants along the longer one,
/// two at least.
double row_stitches(const std::vector<Vec2>& a, const std::vector<Vec2>& b, double spacing_mm);

inline constexpr double kStitchReach_mm = 2.0;  // a stitch placed this near to a wound's edge goes through the edge

/// "(1.00, 2.00) mm"
std::string at_text(const ChartPoint& p);

}  // namespace limberg
