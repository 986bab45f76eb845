#include "sim/imaging/anatomical/face_lines.h"

#include "sim/geometry/bvh.h"

namespace limberg {
namespace {

/// A place on the right half, seen along an axis: its other two coordinates, and the way.
struct Seen {
  double a, b;
  Vec3 along;
};

// From in front: x and z.
const Seen kFront[] = {
    // forehead, between the brows
    {0, 100, {1, 0, 0}},
    {30, 98, {1, 0, -0.2}},
    {0, 78, {1, 0, 0}},
    {25, 76, {1, 0, -0.05}},
    {45, 72, {1, 0, -0.25}},
    {0, 58, {1, 0, 0}},
    {22, 58, {1, 0, 0.02}},
    {44, 54, {1, 0, -0.2}},
    {0, 40, {1, 0, 0}},
    {14, 40, {1, 0, 0.1}},
    {30, 38, {1, 0, 0.02}},
    {47, 34, {1, 0, -0.25}},
    // lids, outer corner of the eye
    {17, 24, {1, 0, 0.45}},
    {31, 25, {1, 0, 0.05}},
    {44, 23, {1, 0, -0.3}},
    {12, 13, {0.4, 0, -1}},
    {20, 5, {1, 0, -0.35}},
    {31, 2, {1, 0, -0.05}},
    {43, 5, {1, 0, 0.3}},
    {52, 15, {1, -1, 0}},
    {53, 24, {1, -1, 0.15}},
    {52, 5, {1, -1, -0.25}},
    // nose
    {0, 20, {1, 0, 0}},
    {0, 5, {1, 0, 0}},
    {7, 5, {1, 0, -0.5}},
    {0, -10, {1, 0, 0}},
    {9, -8, {1, 0, -0.7}},
    {0, -22, {1, 0, 0}},
    {14, -20, {0.6, 0, -1}},
    {19, -29, {0.25, 0, -1}},
    // cheek
    {18, -4, {0.8, 0, -0.6}},
    {30, -8, {1, 0, -0.55}},
    {44, -4, {1, 0, -0.55}},
    {24, -22, {0.55, 0, -1}},
    {36, -22, {0.7, 0, -1}},
    {48, -18, {0.7, -0.3, -1}},
    {28, -36, {0.4, 0, -1}},
    {40, -38, {0.5, 0, -1}},
    {52, -38, {0.35, -0.2, -1}},
    {33, -54, {0.25, 0, -1}},
    {44, -56, {0.3, 0, -1}},
    // lips
    {0, -42, {0, 0, 1}},
    {8, -43, {0.1, 0, -1}},
    {17, -45, {0.4, 0, -1}},
    {24, -50, {0.5, 0, -1}},
    {0, -54, {0, 0, 1}},
    {14, -55, {0.25, 0, -1}},
    {0, -62, {0, 0, 1}},
    {12, -63, {0.2, 0, -1}},
    {0, -68, {0, 0, 1}},
    {13, -69, {0.25, 0, -1}},
    {25, -66, {0.05, 0, -1}},
    // chin, jaw
    {0, -80, {1, 0, 0}},
    {11, -81, {1, 0, -0.45}},
    {22, -82, {0.15, 0, -1}},
    {36, -76, {0.15, 0, -1}},
    {0, -93, {1, 0, 0}},
    {13, -93, {1, 0, -0.25}},
    {26, -92, {-0.3, 0, -1}},
};

// From the right: y and z.
const Seen kSide[] = {
    {48, 58, {0.3, -1, -0.3}}, {30, 70, {0.1, -1, -0.25}}, {40, 30, {0.3, -1, -0.25}}, {22, 40, {0.1, -1, -0.5}},
    {45, 14, {0.4, -1, -0.1}}, {38, 0, {0.3, -0.8, -0.6}}, {40, -20, {0.2, -0.2, -1}}, {22, -8, {0, 0.05, -1}},
    {14, -25, {0, 0.1, -1}},   {30, -38, {0.1, 0, -1}},    {14, -45, {0, 0.15, -1}},   {36, -62, {0.1, 0.1, -1}},
    {18, -64, {0, 0.25, -1}},  {45, -82, {0, 0.4, -1}},    {22, -82, {0, 0.6, -1}},    {4, 20, {0, 0, 1}},
    {-14, 20, {0, 0.1, 1}},    {-20, 0, {0, 0.1, 1}},      {-14, -18, {0, -0.1, 1}},
};

}  // namespace

std::vector<FaceLine> face_tension_lines(std::span<const Vec3> X_mm, std::span<const Tri> tri) {
  const Bvh surface(X_mm, tri);
  constexpr double kFar_mm = 300;
  std::vector<FaceLine> out;
  const auto add = [&](const Vec3& from, const Vec3& towards, const Vec3& along) {
    const std::vector<Bvh::LineHit> hits = surface.line(from, towards, 0, kFar_mm);
    if (hits.empty()) return;  // the surface ends before
    const Vec3 X = from + hits[0].t * towards, d = along.normalized();
    out.push_back({X, d});
    if (std::abs(X.x()) > 1e-6) out.push_back({{-X.x(), X.y(), X.z()}, {-d.x(), d.y(), d.z()}});
  };
  for (const Seen& s : kFront) add({s.a, kFar_mm / 2, s.b}, {0, -1, 0}, s.along);
  for (const Seen& s : kSide) add({kFar_mm / 2, s.a, s.b}, {-1, 0, 0}, s.along);
  return out;
}

}  // namespace limberg
