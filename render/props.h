#pragma once
// Things that are drawn but have no mechanics: threads with knots and bite marks, skin hooks, the tool in the hand.
// Plain triangles with a colour each; lines are tubes, because wide GL lines are not portable.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "render/tool_pose.h"
#include "sim/patient/snapshot.h"

namespace limberg {

struct PropVertex {
  Vec3f x_mm, normal;
  Vec3f colour;     // linear RGB
  float metal = 0;  // 0 plastic or thread, 1 steel, -1 cloth
  uint32_t id = 0;  // Part << 24 | number
};

struct PropMesh {
  std::vector<PropVertex> vertex;
  std::vector<std::array<uint32_t, 3>> tri;
  void clear() { vertex.clear(), tri.clear(); }
};

struct PropLook {
  Vec3f colour{0.5f, 0.5f, 0.5f};
  float metal = 0;
  uint32_t id = 0;
};

/// A tube along a polyline with a radius per point and round ends. Repeated points are skipped.
void add_tube(PropMesh& mesh, std::span<const Vec3f> path, std::span<const float> radius, const PropLook& look,
              int sides = 10);
/// An ellipsoid with half axes a, b, c (orthogonal vectors, mm).
void add_ellipsoid(PropMesh& mesh, const Vec3f& centre, const Vec3f& a, const Vec3f& b, const Vec3f& c,
                   const PropLook& look, int rings = 8);

/// A stitch over the wound: thread, knot with two tails (not where it is one of a thread's), bite marks. `skin_mm`: the
/// way over the skin from the entry to the exit,
/// at least these two; `up`: the outward unit normal of the skin there.
void add_suture(PropMesh& mesh, const SutureState& suture, std::span<const Vec3f> skin_mm, const Vec3f& up);
/// A sharp skin hook whose point is in the tissue and whose shaft leads to the handle.
void add_hook(PropMesh& mesh, const HookState& hook, const Vec3f& up);
/// A plate of titanium on bone, bent over the three places,
/// with a screw at each end and one between them and the
/// middle. `up`: outward unit normals there.
void add_plate(PropMesh& mesh, const std::array<Vec3f, 3>& on_bone_mm, const std::array<Vec3f, 3>& up);
/// The needle is in the hand, and not in the tissue.
bool holds_needle(const ToolPose& tool);
/// The thread of a running stitch from its last bite to the needle in the hand; without one along `lying_mm`, the way
/// that its end lies on the skin.
void add_sewn_thread(PropMesh& mesh, const Vec3f& end_mm, const Vec3f& up, std::span<const Vec3f> lying_mm,
                     const ToolPose& tool);
void add_tool(PropMesh& mesh, const ToolPose& tool);
/// The hand of a glove (hand_shape.h), whole or only the last joints of forefinger and thumb with a line between their
/// tips, blue while open and orange while closed; dots from the forefinger to the place that it points at, with a ring
/// there. Nothing where it is not visible.
void add_glove(PropMesh& mesh, const GlovePose& glove);

}  // namespace limberg
