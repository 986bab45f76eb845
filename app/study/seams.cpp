#include "app/study/seams.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/commands/plan_numbers.h"
#include "sim/geometry/vec.h"

namespace limberg::study {

namespace {

constexpr double kInside_mm = 3, kEdge_mm = 0.08, kAlong_mm = 1, kWithin = 0.7;

/// One bank of a stitch now: its edge, the skin inside it, the skin's normal.
struct Side {
  std::optional<Vec3> edge, inside, ahead, behind;
  bool complete() const { return edge && inside && ahead && behind; }
  Vec3 normal(int sign) const { return sign * (*ahead - *behind).cross(*inside - *edge); }
};

void judge(SeamsLie& out, const Side& a, const Side& b) {
  ++out.stitches;
  if (!a.complete() || !b.complete()) {
    out.least_opening_deg = 0;
    return;
  }
  const Vec3 middle = 0.5 * (*a.edge + *b.edge), u = *a.inside - middle, v = *b.inside - middle;
  out.least_opening_deg = std::min(out.least_opening_deg, std::atan2(u.cross(v).norm(), u.dot(v)) * kDeg);
  const Vec3 n = a.normal(1).normalized() + b.normal(-1).normalized();
  // Normals that face each other have no mean: the banks lie on one another, and all of the way between them is a step.
  const double step = n.norm() > 0.3 ? std::abs((*a.edge - *b.edge).dot(n.normalized())) : (*a.edge - *b.edge).norm();
  out.most_step_mm = std::max(out.most_step_mm, step);
}

/// Bank at arc length s; side +1: the tissue lies to the left of `path`, -1: to its right.
Side side_of(const SkinMap& skin, const std::vector<Vec2>& path, double s, int side) {
  const Vec2 on = beside(path, s, 0), in = beside(path, s, side) - on;
  const double inside = std::min(kInside_mm, kWithin * skin.free_mm(on + kEdge_mm * in, in));
  return {skin.now_mm(on + kEdge_mm * in), skin.now_mm(on + inside * in),
          skin.now_mm(beside(path, s + kAlong_mm, side * 0.5 * inside)),
          skin.now_mm(beside(path, s - kAlong_mm, side * 0.5 * inside))};
}

Side corner_of(const SkinMap& skin, const Figure& f, const Corner& c) {
  const Vec2 in = tissue_bisector(f, c), at = place(f, c), across(-in.y(), in.x());
  const double narrow = std::min(0.5, 0.5 * std::tan(std::min(80.0, tissue_deg(f, c) / 2) / kDeg));
  // Seen from the edge's end inwards, "ahead" lies to the right, as with tissue to the left of a path.
  return {skin.now_mm(at + kEdge_mm * in), skin.now_mm(at + kInside_mm * in),
          skin.now_mm(at + kInside_mm * (in - narrow * across)), skin.now_mm(at + kInside_mm * (in + narrow * across))};
}

}  // namespace

SeamsLie seams_lie(const SkinMap& skin, const Figure& f, double spacing) {
  SeamsLie out;
  for (const Seam& s : f.seams) {
    const auto a = bank(f, s.a_from, s.a_to, true), b = bank(f, s.b_from, s.b_to, false);
    const double la = path_length(a), lb = path_length(b);
    const int n = int(parts_of_row(std::max(la, lb), spacing)) - 1;
    for (int i = 1; i <= n; ++i) {
      const double t = double(i) / (n + 1);
      judge(out, side_of(skin, a, t * la, 1), side_of(skin, b, t * lb, -1));
    }
  }
  for (const KeyStitch& k : f.keys) {
    const Side a = corner_of(skin, f, k.a);
    Side b = corner_of(skin, f, k.b);
    std::swap(b.ahead, b.behind);  // as for a bank whose tissue lies to the right
    judge(out, a, b);
    if (a.edge && b.edge) out.most_tip_mm = std::max(out.most_tip_mm, (*a.edge - *b.edge).norm());
  }
  return out;
}

}  // namespace limberg::study
