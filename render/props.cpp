#include "render/props.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "render/hand_shape.h"
#include "render/render_scene.h"

namespace limberg {

namespace {

constexpr float kPi = 3.14159265f;

Vec3f any_normal(const Vec3f& d) {
  const Vec3f a = std::abs(d.z()) < 0.8f ? Vec3f(Vec3f::UnitZ()) : Vec3f(Vec3f::UnitX());
  return (a - a.dot(d) * d).normalized();
}

Vec3f direction(const Vec3f& v, const Vec3f& otherwise) {
  const float n = v.norm();
  return n > 1e-6f && std::isfinite(n) ? Vec3f(v / n) : otherwise;
}

uint32_t vertex(PropMesh& m, const Vec3f& x, const Vec3f& n, const PropLook& look) {
  m.vertex.push_back({x, n, look.colour, look.metal, look.id});
  return uint32_t(m.vertex.size() - 1);
}

void strip(PropMesh& m, uint32_t a, uint32_t b, int sides) {
  for (int i = 0; i < sides; ++i) {
    const uint32_t j = uint32_t((i + 1) % sides), k = uint32_t(i);
    m.tri.push_back({a + k, a + j, b + j});
    m.tri.push_back({a + k, b + j, b + k});
  }
}

uint32_t id_of(Part part, int32_t number) { return uint32_t(part) << 24 | (uint32_t(number) & 0xffffffu); }

// A smooth curve through control points: Catmull-Rom, `n` pieces per span.
std::vector<Vec3f> smooth(std::span<const Vec3f> p, int n) {
  std::vector<Vec3f> out;
  for (size_t i = 0; i + 1 < p.size(); ++i) {
    const Vec3f &b = p[i], &c = p[i + 1];
    const Vec3f a = i > 0 ? p[i - 1] : Vec3f(2 * b - c), d = i + 2 < p.size() ? p[i + 2] : Vec3f(2 * c - b);
    for (int k = 0; k < n; ++k) {
      const float t = float(k) / float(n), t2 = t * t, t3 = t2 * t;
      out.push_back(0.5f * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t2 + (3 * b - 3 * c + d - a) * t3));
    }
  }
  out.push_back(p.back());
  return out;
}

void smooth_tube(PropMesh& m, std::span<const Vec3f> control, float radius, const PropLook& look, int sides = 8) {
  const std::vector<Vec3f> path = smooth(control, 8);
  const std::vector<float> radii(path.size(), radius);
  add_tube(m, path, radii, look, sides);
}

}  // namespace

void add_tube(PropMesh& mesh, std::span<const Vec3f> path, std::span<const float> radius, const PropLook& look,
              int sides) {
  // Repeated points give no direction; they are left out.
  std::vector<Vec3f> p;
  std::vector<float> r;
  for (size_t i = 0; i < path.size(); ++i)
    if (path[i].allFinite() && (p.empty() || (path[i] - p.back()).norm() > 1e-4f))
      p.push_back(path[i]), r.push_back(radius[i]);
  if (p.size() < 2) return;

  // The frame is carried along by the smallest rotation, so the tube does not twist.
  Vec3f side = any_normal(direction(p[1] - p[0], Vec3f::UnitX()));
  uint32_t before = 0;
  bool first = true;
  const auto ring = [&](const Vec3f& at, const Vec3f& along, float rad, float lean) {
    const Vec3f other = along.cross(side);
    const uint32_t begin = uint32_t(mesh.vertex.size());
    for (int k = 0; k < sides; ++k) {
      const float w = 2 * kPi * float(k) / float(sides);
      const Vec3f out = std::cos(w) * side + std::sin(w) * other;
      vertex(mesh, at + rad * out, direction(out + lean * along, out), look);
    }
    if (!first) strip(mesh, before, begin, sides);
    before = begin, first = false;
  };
  for (size_t i = 0; i < p.size(); ++i) {
    const Vec3f into = i > 0 ? Vec3f((p[i] - p[i - 1]).normalized()) : Vec3f((p[1] - p[0]).normalized());
    const Vec3f outof = i + 1 < p.size() ? Vec3f((p[i + 1] - p[i]).normalized()) : into;
    const Vec3f along = direction(into + outof, into);
    side = direction(side - side.dot(along) * along, any_normal(along));
    if (i == 0)  // round start
      for (const float a : {0.02f, 0.4f, 0.75f})
        ring(p[0] - std::sqrt(1 - a * a) * r[0] * along, along, a * r[0], -std::sqrt(1 - a * a) / a);
    const float slope = i + 1 < p.size() ? (r[i] - r[i + 1]) / (p[i + 1] - p[i]).norm() : 0;
    ring(p[i], along, r[i], slope);
    if (i + 1 == p.size())  // round end
      for (const float a : {0.75f, 0.4f, 0.02f})
        ring(p[i] + std::sqrt(1 - a * a) * r[i] * along, along, a * r[i], std::sqrt(1 - a * a) / a);
  }
}

void add_ellipsoid(PropMesh& mesh, const Vec3f& centre, const Vec3f& a, const Vec3f& b, const Vec3f& c,
                   const PropLook& look, int rings) {
  const int sides = 2 * rings;
  uint32_t before = 0;
  const bool mirrored = a.cross(b).dot(c) < 0;
  for (int i = 0; i <= rings; ++i) {
    const float v = kPi * float(i) / float(rings), s = std::max(std::sin(v), 1e-3f), z = -std::cos(v);
    const uint32_t begin = uint32_t(mesh.vertex.size());
    for (int k = 0; k < sides; ++k) {
      const float w = 2 * kPi * float(k) / float(sides) * (mirrored ? -1.0f : 1.0f);
      const float ca = s * std::cos(w), cb = s * std::sin(w);
      const Vec3f n = ca * a / a.squaredNorm() + cb * b / b.squaredNorm() + z * c / c.squaredNorm();
      vertex(mesh, centre + ca * a + cb * b + z * c, n.normalized(), look);
    }
    if (i > 0) strip(mesh, before, begin, sides);
    before = begin;
  }
}

void add_suture(PropMesh& mesh, const SutureState& suture, std::span<const Vec3f> skin_mm, const Vec3f& up) {
  if (skin_mm.size() < 2) return;
  const Vec3f in_mm = skin_mm.front(), out_mm = skin_mm.back();
  const uint32_t id = id_of(Part::suture, suture.id);
  const PropLook thread{{0.016f, 0.035f, 0.13f}, 0.12f, id};  // blue monofilament
  const PropLook bite{{0.16f, 0.020f, 0.018f}, 0, id};
  const float r = 0.125f;  // a thread of 3-0: a quarter of a millimetre
  const Vec3f span = out_mm - in_mm, across = direction(span, any_normal(up)), along = up.cross(across);

  for (const Vec3f& p : {in_mm, out_mm})  // bite marks: flat red discs around the holes
    add_ellipsoid(mesh, p + 0.01f * up, 0.28f * across, 0.25f * along, 0.05f * up, bite, 6);

  // Out of the skin, over the wound, in again. A taut thread lies flat over an open wound.
  const float lift = 0.16f;
  std::vector<Vec3f> over{in_mm - 0.30f * up, in_mm + 0.10f * across + lift * up};
  for (const Vec3f& p : skin_mm.subspan(1, skin_mm.size() - 2)) over.push_back(p + lift * up);
  if (over.size() == 2) over.push_back(in_mm + 0.5f * span + (lift + 0.06f) * up);
  over.push_back(out_mm - 0.10f * across + lift * up), over.push_back(out_mm - 0.30f * up);
  smooth_tube(mesh, over, r, thread);
  if (suture.thread != 0) return;  // one of a thread's: that is tied at its ends

  // The knot lies over the entry, beside the wound: two throws, each a turn about the thread, and two tails. No two
  // hands' tails lie alike: they follow the stitch's number.
  const auto wish = [&](uint32_t k) {
    return float(((uint32_t(suture.id) + 1) * 2654435761u >> (4 * k)) & 255u) / 255.0f - 0.5f;
  };
  const Vec3f k = in_mm + 0.42f * across + (lift + 0.04f) * up;
  for (const float throw_at : {-0.15f, 0.15f}) {
    std::vector<Vec3f> turn;
    const Vec3f lean = direction(across + (throw_at > 0 ? 0.45f : -0.45f) * along, across),
                side = direction(up.cross(lean), along);
    for (int i = 0; i <= 10; ++i) {
      const float w = 2 * kPi * float(i) / 10;
      turn.push_back(k + throw_at * across + 0.27f * std::cos(w) * side + 0.22f * std::sin(w) * up);
    }
    std::vector<float> radii(turn.size(), r);
    add_tube(mesh, turn, radii, thread, 8);
  }
  const auto tail = [&](float sign, uint32_t seed) {
    const Vec3f out = direction(sign * along + (-0.35f + 0.7f * wish(seed)) * across, along), bend = up.cross(out);
    const float length = 2.0f + 0.8f * wish(seed + 1), curl = 1.4f * wish(seed + 2);
    const std::array<Vec3f, 5> path{
        k, k + 0.28f * length * out + 0.18f * up,
        k + 0.55f * length * out + (0.36f + 0.2f * wish(seed + 3)) * up + 0.10f * curl * bend,
        k + 0.80f * length * out + (0.46f + 0.4f * wish(seed + 3)) * up + 0.32f * curl * bend,
        k + length * out + (0.50f + 0.7f * wish(seed + 3)) * up + 0.62f * curl * bend};
    smooth_tube(mesh, path, 0.92f * r, thread, 6);
  };
  tail(1, 0), tail(-1, 3);
}

void add_plate(PropMesh& mesh, const std::array<Vec3f, 3>& on_bone, const std::array<Vec3f, 3>& up) {
  const PropLook titanium{{0.50f, 0.52f, 0.56f}, 1, 0}, screw{{0.30f, 0.32f, 0.36f}, 1, 0};
  constexpr float kHalf_mm = 0.75f, kEye_mm = 2.1f, kScrew_mm = 1.15f, kThin_mm = 0.5f;
  std::array<Vec3f, 3> p;
  for (size_t k = 0; k < 3; ++k) p[k] = on_bone[k] + kHalf_mm * up[k];
  smooth_tube(mesh, p, kHalf_mm, titanium);
  for (const float t : {0.0f, 0.5f, 1.5f, 2.0f}) {  // along the two halves
    const size_t k = t < 1 ? 0 : 1;
    const float s = t - float(k);
    const Vec3f at = (1 - s) * p[k] + s * p[k + 1], n = ((1 - s) * up[k] + s * up[k + 1]).normalized();
    const Vec3f along = direction(p[k + 1] - p[k], any_normal(n)),
                a = direction(along - along.dot(n) * n, any_normal(n)), b = n.cross(a);
    add_ellipsoid(mesh, at, kEye_mm * a, kEye_mm * b, kThin_mm * n, titanium);
    add_ellipsoid(mesh, at + 0.35f * n, kScrew_mm * a, kScrew_mm * b, kThin_mm * n, screw);
  }
}

void add_hook(PropMesh& mesh, const HookState& hook, const Vec3f& up) {
  const uint32_t id = id_of(Part::hook, hook.id);
  const PropLook steel{{0.56f, 0.57f, 0.58f}, 1, id};
  const PropLook mark{{0.02f, 0.16f, 0.20f}, 0.1f, id};
  const Vec3f pull = hook.handle_mm - hook.at_mm;
  const Vec3f flat = pull - pull.dot(up) * up;
  // The shaft rises at about 40 degrees towards where the hand pulls.
  const Vec3f away = flat.norm() > 0.5f ? Vec3f(flat.normalized()) : any_normal(up);
  const Vec3f shaft = (0.77f * away + 0.64f * up).normalized(), bend = shaft.cross(away.cross(up)).normalized();
  const Vec3f p = hook.at_mm;
  // A half turn of the sharp end, then neck, then handle. The point is in the tissue, under its edge.
  const float c = 1.3f;
  std::vector<Vec3f> path;
  std::vector<float> radius;
  for (int i = 0; i <= 10; ++i) {
    const float w = kPi * float(i) / 10;
    path.push_back(p + 0.5f * shaft + c * (1 - std::cos(w)) * (bend.dot(up) > 0 ? bend : Vec3f(-bend)) -
                   c * std::sin(w) * shaft);
    radius.push_back(0.10f + 0.02f * float(i));
  }
  const Vec3f neck = path.back();
  for (const auto& [d, r] : {std::pair{6.0f, 0.34f}, {14.0f, 0.42f}, {15.0f, 0.85f}, {34.0f, 0.95f}, {36.0f, 0.6f}}) {
    path.push_back(neck + d * shaft);
    radius.push_back(r);
  }
  add_tube(mesh, path, radius, steel, 14);
  for (int i = 0; i < 5; ++i) {  // grip rings: low ridges of the handle
    const Vec3f a = neck + (18.0f + 2.6f * float(i)) * shaft;
    const std::array<Vec3f, 4> ridge{a, a + 0.15f * shaft, a + 0.95f * shaft, a + 1.1f * shaft};
    const std::array<float, 4> rr{0.80f, 1.10f, 1.10f, 0.80f};
    add_tube(mesh, ridge, rr, mark, 14);
  }
  // The line to where the hand holds it, when that is away from the hook.
  if (pull.norm() > 1.0f) {
    const std::array<Vec3f, 2> line{hook.at_mm, hook.handle_mm};
    const std::array<float, 2> rr{0.09f, 0.09f};
    add_tube(mesh, line, rr, {{0.85f, 0.75f, 0.15f}, 0, id}, 6);
    add_ellipsoid(mesh, hook.handle_mm, 0.5f * Vec3f::UnitX(), 0.5f * Vec3f::UnitY(), 0.5f * Vec3f::UnitZ(),
                  {{0.85f, 0.70f, 0.12f}, 0, id}, 6);
  }
}

namespace {

constexpr float kNeedleRadius_mm = 4.5f;
constexpr Vec3f::Scalar kThread_mm = 0.14f;
PropLook thread_look() { return {{0.016f, 0.035f, 0.13f}, 0.12f, id_of(Part::suture, 0)}; }

/// A needle of three eighths of a circle in the jaws, its point at the tip, and the thread of a stitch that is begun:
/// from its tail outside of the skin, through the bites, to the needle.
void add_needle(PropMesh& mesh, const ToolPose& tool, const Vec3f& shaft, const Vec3f& wide, uint32_t id) {
  constexpr float kRadius_mm = kNeedleRadius_mm, kArc = 0.75f * kPi;
  std::vector<Vec3f> arc;
  std::vector<float> thick;
  for (int i = 0; i <= 12; ++i) {
    const float w = kArc * float(i) / 12;
    arc.push_back(tool.tip_mm + kRadius_mm * (std::sin(w) * wide + (1 - std::cos(w)) * shaft));
    thick.push_back(std::min(0.28f, 0.05f + 0.09f * float(i)));
  }
  add_tube(mesh, arc, thick, {{0.72f, 0.73f, 0.75f}, 1, id}, 8);
  if (tool.bites == 0) return;
  std::vector<Vec3f> way{tool.bite_mm[0] + 5 * shaft - 6 * wide, tool.bite_mm[0] + 1.2f * shaft - 2.5f * wide};
  for (int b = 0; b < tool.bites; ++b) {
    if (b > 0) way.push_back(0.5f * (tool.bite_mm[0] + tool.bite_mm[1]) + 0.8f * shaft);
    way.push_back(tool.bite_mm[size_t(b)]);
  }
  way.push_back(0.5f * (way.back() + arc.back()) + 1.5f * shaft);  // it hangs loose
  way.push_back(arc.back());
  smooth_tube(mesh, way, kThread_mm, thread_look());
}

}  // namespace

bool holds_needle(const ToolPose& tool) {
  return tool.visible && tool.kind == ToolPose::Kind::needle_holder && tool.bites == 0;
}

void add_sewn_thread(PropMesh& mesh, const Vec3f& end_mm, const Vec3f& up, std::span<const Vec3f> lying_mm,
                     const ToolPose& tool) {
  std::vector<Vec3f> way{end_mm - 0.3f * up, end_mm + 0.2f * up};
  if (holds_needle(tool)) {
    const Vec3f s = direction(tool.shaft, Vec3f::UnitZ()), wide = s.cross(any_normal(s));
    const Vec3f eye = tool.tip_mm + kNeedleRadius_mm * (std::sin(0.75f * kPi) * wide + (1 - std::cos(0.75f * kPi)) * s);
    way.push_back(0.5f * (end_mm + eye) + 1.5f * up);  // it hangs loose
    way.push_back(eye);
  } else {
    way.insert(way.end(), lying_mm.begin(), lying_mm.end());
  }
  smooth_tube(mesh, way, kThread_mm, thread_look());
}

void add_tool(PropMesh& mesh, const ToolPose& tool) {
  if (!tool.visible || !tool.tip_mm.allFinite() || !tool.shaft.allFinite()) return;
  const uint32_t id = id_of(Part::tool, int32_t(tool.kind));
  const Vec3f s = direction(tool.shaft, Vec3f::UnitZ()), side = any_normal(s), wide = s.cross(side);
  const PropLook steel{{0.56f, 0.57f, 0.58f}, 1, id}, grip{{0.03f, 0.05f, 0.06f}, 0.1f, id};
  const auto body = [&](std::initializer_list<std::pair<float, float>> profile, const PropLook& look) {
    std::vector<Vec3f> path;
    std::vector<float> radius;
    for (const auto& [d, r] : profile) path.push_back(tool.tip_mm + d * s), radius.push_back(r);
    add_tube(mesh, path, radius, look, 16);
  };
  // A straight piece from so far beside the shaft's line at one height to another, in the tool's plane.
  const auto arm = [&](float beside, float from, float then, float to, float radius) {
    add_tube(mesh, std::array{Vec3f(tool.tip_mm + from * s + beside * wide), Vec3f(tool.tip_mm + to * s + then * wide)},
             std::array{0.7f * radius, radius}, steel, 10);
  };
  const auto ring = [&](float beside, float at) {  // for a finger
    std::array<Vec3f, 17> path;
    std::array<float, 17> thick;
    for (size_t i = 0; i < path.size(); ++i) {
      const float w = 2 * kPi * float(i) / 16;
      path[i] = tool.tip_mm + (at + 11 * std::cos(w)) * s + (beside + 8 * std::sin(w)) * wide, thick[i] = 1.3f;
    }
    add_tube(mesh, path, thick, steel, 8);
  };
  switch (tool.kind) {
    case ToolPose::Kind::scalpel: {
      // A No. 15 blade: thin, bellied edge; then the flat handle.
      const std::array<std::array<float, 2>, 7> edge{
          {{0, 0}, {2, 1.1f}, {5, 1.7f}, {9, 1.9f}, {13, 1.5f}, {16, 1.4f}, {18, 1.4f}}};
      for (const float t : {-0.18f, 0.18f}) {
        const uint32_t begin = uint32_t(mesh.vertex.size());
        const Vec3f n = t > 0 ? side : Vec3f(-side);
        for (const auto& [d, w] : edge) {
          vertex(mesh, tool.tip_mm + d * s + t * side * std::min(1.0f, d / 3) - 0.4f * w * wide, n, steel);
          vertex(mesh, tool.tip_mm + d * s + 0.05f * t * side + w * wide, direction(n + 0.5f * wide, n), steel);
        }
        for (uint32_t i = 0; i + 1 < edge.size(); ++i) {
          const uint32_t q = begin + 2 * i;
          mesh.tri.push_back({q, q + 1, q + 3});
          mesh.tri.push_back({q, q + 3, q + 2});
        }
      }
      const size_t handle = mesh.vertex.size();
      body({{16, 1.5f}, {20, 2.1f}, {34, 2.7f}, {40, 3.4f}, {60, 3.7f}, {104, 3.3f}, {116, 3.6f}, {122, 2.4f}}, steel);
      for (int i = 0; i < 9; ++i) body({{40 + 2.4f * float(i), 3.6f}, {41 + 2.4f * float(i), 3.6f}}, grip);
      constexpr float kFlat = 0.38f;  // the handle is a flat bar
      for (size_t i = handle; i < mesh.vertex.size(); ++i) {
        PropVertex& v = mesh.vertex[i];
        v.x_mm -= (1 - kFlat) * (v.x_mm - tool.tip_mm).dot(side) * side;
        v.normal = direction(v.normal + (1 / kFlat - 1) * v.normal.dot(side) * side, side);
      }
      break;
    }
    case ToolPose::Kind::hook:
      body({{0, 0.12f}, {2, 0.3f}, {18, 0.5f}, {20, 1.1f}, {60, 1.3f}, {64, 0.8f}}, steel);
      break;
    case ToolPose::Kind::needle_holder:
      for (const float jaw : {-1.0f, 1.0f}) arm(jaw * 0.35f, 5, jaw * 0.5f, 24, 0.8f);
      body({{23, 1.5f}, {26, 2.6f}, {30, 1.8f}}, steel);
      for (const float branch : {-1.0f, 1.0f}) arm(branch * 0.9f, 28, branch * 7, 112, 1.2f);
      for (const float branch : {-1.0f, 1.0f}) ring(branch * 10, 121);
      add_needle(mesh, tool, s, wide, id);
      break;
    case ToolPose::Kind::dissector:  // a periosteal elevator: a thin, blunt blade on a round handle
      add_ellipsoid(mesh, tool.tip_mm + 6 * s, 6 * s, 2.6f * wide, 0.4f * side, steel, 10);
      body({{10, 0.9f}, {34, 1.4f}, {40, 2.8f}, {118, 3.2f}, {124, 2}}, steel);
      break;
    case ToolPose::Kind::scissors: {
      const float open = tool.closed ? 0.3f : 3.2f;
      for (const float blade : {-1.0f, 1.0f}) arm(blade * open, 0, 0, 26, 0.8f), arm(0, 26, -blade * 8, 96, 1.3f);
      for (const float blade : {-1.0f, 1.0f}) ring(blade * 11, 106);
      add_ellipsoid(mesh, tool.tip_mm + 26 * s, 1.6f * s, 1.6f * wide, 1.3f * side, steel, 6);
      break;
    }
    case ToolPose::Kind::marker:
      body({{0, 0.35f}, {4, 1}}, {{0.10f, 0.02f, 0.24f}, 0, id});
      body({{4, 2.4f}, {12, 4}, {100, 4.2f}}, {{0.62f, 0.62f, 0.66f}, 0.1f, id});
      body({{100, 4.4f}, {132, 4.4f}, {135, 3}}, {{0.10f, 0.02f, 0.24f}, 0.1f, id});
      break;
    case ToolPose::Kind::swab:  // a folded swab in the jaws of a clamp
      add_ellipsoid(mesh, tool.tip_mm + 5 * s, 5 * s, 6 * wide, 3 * side, {{0.78f, 0.76f, 0.70f}, -1, id}, 10);
      for (const float jaw : {-1.0f, 1.0f})
        arm(jaw * 1.2f, 5, jaw * 0.8f, 34, 1.1f), arm(jaw * 0.8f, 34, jaw * 7, 118, 1.3f);
      for (const float jaw : {-1.0f, 1.0f}) ring(jaw * 10, 127);
      break;
    case ToolPose::Kind::saw:  // a reciprocating blade and its handpiece
      body({{0, 0.4f}, {3, 1.1f}, {32, 1.2f}}, steel);
      body({{32, 4}, {40, 8}, {120, 9}, {126, 5}}, grip);
      break;
    case ToolPose::Kind::stylus:
      body({{0, 0.15f}, {3, 0.6f}, {10, 1.6f}, {24, 3.2f}, {30, 3.6f}}, steel);
      body({{30, 3.7f}, {36, 4.2f}, {120, 4.6f}, {140, 4.3f}, {146, 2.5f}}, grip);
      break;
  }
}

namespace {

/// The last joints of each finger, thinner than they are so that they hide little. The thumb's station says where its
/// tip is; it comes from where the hand is.
void add_last_joints(PropMesh& mesh, const GlovePose& g, const Vec3f& d, const PropLook& finger, const PropLook& sign) {
  const Vec3f palm = 0.5f * (g.forefinger_mm + g.thumb_mm) - 30 * d;
  for (const auto& [tip, back, thick] :
       {std::tuple{g.forefinger_mm, Vec3f(-d), 2.0f}, {g.thumb_mm, direction(palm - g.thumb_mm, -d), 2.3f}}) {
    const std::array<Vec3f, 3> path{tip + thick * back, tip + 8 * back, tip + 18 * back};
    const std::array<float, 3> radius{thick, 1.15f * thick, 1.25f * thick};
    add_tube(mesh, path, radius, finger, 12);
  }
  add_tube(mesh, std::array{g.forefinger_mm, g.thumb_mm}, std::array{0.6f, 0.6f}, sign, 6);
}

/// A gloved hand: each bone a capsule, knuckles a little thicker, the palm filled between them.
void add_whole_hand(PropMesh& mesh, const HandJoints& h, const PropLook& look) {
  constexpr float kThick_mm[HandJoints::kFingers][4] = {{13, 10.5f, 9, 6.5f},
                                                        {10, 8.6f, 7.4f, 5.6f},
                                                        {10, 8.8f, 7.6f, 5.8f},
                                                        {9.5f, 8.2f, 7.1f, 5.4f},
                                                        {8.5f, 7.2f, 6.2f, 4.8f}};
  const auto bone = [&](const Vec3f& a, const Vec3f& b, float ra, float rb) {
    if ((b - a).norm() > 1e-3f) add_tube(mesh, std::array{a, b}, std::array{ra, rb}, look, 14);
  };
  const auto joint = [&](const Vec3f& at, float r) {
    add_ellipsoid(mesh, at, r * Vec3f::UnitX(), r * Vec3f::UnitY(), r * Vec3f::UnitZ(), look, 8);
  };
  for (size_t f = 0; f < HandJoints::kFingers; ++f) {
    const auto& p = h.finger[f];
    const auto& r = kThick_mm[f];
    // The tip that is tracked is that of the skin: the last ball ends there.
    const Vec3f end = p[3] - r[3] * direction(p[3] - p[2], Vec3f::UnitX());
    bone(p[0], p[1], r[0], r[1]), bone(p[1], p[2], r[1], r[2]), bone(p[2], end, r[2], r[3]);
    joint(p[0], r[0]), joint(p[1], r[1]), joint(p[2], r[2]), joint(end, r[3]);
    if (f > 0) bone(h.wrist + 0.34f * (p[0] - h.finger[2][0]), p[0], 11, r[0]);
    if (f > 1) bone(h.finger[f - 1][0], p[0], 9.5f, 9.5f);
  }
  // Ball of the thumb, the web to the forefinger, heel of the hand.
  const Vec3f &root = h.finger[0][0], &first = h.finger[0][1], &knuckle = h.finger[1][0];
  bone(h.wrist, root, 14, 13), bone(0.4f * root + 0.6f * first, 0.45f * h.wrist + 0.55f * knuckle, 9, 10);
  const Vec3f along = direction(h.finger[2][0] - h.wrist, Vec3f::UnitX()), across = h.dorsal.cross(along);
  add_ellipsoid(mesh, h.wrist + 0.5f * (h.finger[2][0] - h.wrist) - 0.12f * (h.finger[1][0] - h.finger[4][0]),
                38 * along, 30 * across, 12 * h.dorsal, look, 12);
  bone(h.forearm, h.wrist, 15, 15);
}

}  // namespace

void add_glove(PropMesh& mesh, const GlovePose& g) {
  if (!g.visible || !g.forefinger_mm.allFinite() || !g.thumb_mm.allFinite() || !g.pointing.allFinite()) return;
  constexpr int32_t kNumber = 100;  // beyond the kinds of a tool
  const uint32_t id = id_of(Part::tool, kNumber);
  const Vec3f d = direction(g.pointing, Vec3f::UnitX());
  const Vec3f colour = g.closed ? Vec3f(0.75f, 0.24f, 0.03f) : Vec3f(0.08f, 0.30f, 0.52f);
  const PropLook finger{colour, 0, id}, sign{g.closed ? Vec3f(1.0f, 0.42f, 0.04f) : Vec3f(0.30f, 0.85f, 0.25f), 0, id};
  const auto ball = [&](const Vec3f& at, float r, const PropLook& look, int rings) {
    add_ellipsoid(mesh, at, r * Vec3f::UnitX(), r * Vec3f::UnitY(), r * Vec3f::UnitZ(), look, rings);
  };
  if (g.whole)
    add_whole_hand(mesh, hand_joints(g), finger);
  else
    add_last_joints(mesh, g, d, finger, sign);

  const bool there = g.points && g.pointed_mm.allFinite();
  if (g.closed && !g.holds) return;
  const Vec3f from = g.holds ? Vec3f(0.5f * (g.forefinger_mm + g.thumb_mm)) : g.forefinger_mm,
              to = there ? g.pointed_mm : Vec3f(from + 60 * d);
  const Vec3f way = to - from;
  const int dots = std::clamp(int(way.norm() / 5), 1, 40);
  for (int i = 1; i <= dots; ++i) ball(from + float(i) / float(dots + 1) * way, 0.6f, sign, 4);
  if (!there) return;
  ball(to, 1.1f, sign, 5);
  const Vec3f n = direction(way, d), a = any_normal(n), b = n.cross(a);
  std::array<Vec3f, 25> ring;
  for (size_t i = 0; i < ring.size(); ++i)
    ring[i] = to - 0.8f * n + 3.2f * (std::cos(kPi * float(i) / 12) * a + std::sin(kPi * float(i) / 12) * b);
  std::array<float, 25> thin;
  thin.fill(0.4f);
  add_tube(mesh, ring, thin, sign, 6);
}

}  // namespace limberg
