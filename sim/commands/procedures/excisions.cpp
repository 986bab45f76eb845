// Fusiform excision and M-plasty.
#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/commands/procedures/figures.h"
#include "sim/commands/procedures/shapes.h"

namespace limberg::figures {

namespace {
constexpr int kPieces = 12;  // of an arc

// The upper arc from left to right, |x| <= half.
struct Arc {
  Vec2 centre;
  double radius, tip_deg;  // the arc runs from 90 + tip_deg to 90 - tip_deg
  Arc(double width, double length) : radius((length * length + width * width) / (4 * width)) {
    centre = {0, width / 2 - radius};
    tip_deg = elementary::asin(length / 2 / radius) * kDeg;
  }
};
Vec2 below(const Vec2& p) { return {p.x(), -p.y()}; }
}  // namespace

Figure fusiform(double width, double ratio) {
  const Arc a(width, width * ratio);
  Figure f;
  Walk w;
  const auto top = arc(a.centre, a.radius, 90 + a.tip_deg, 90 - a.tip_deg, kPieces);
  const int left = w(top.front()), right = w.on(top);
  std::vector<Vec2> bottom;
  for (const Vec2& p : reversed(top)) bottom.push_back(below(p));
  w.between(bottom);
  f.excisions = {w.at};
  f.wounds = {w.at};
  f.seams = {seam(left, right, left, right)};
  f.seams[0].from_middle = true;
  return f;
}

Figure m_plasty(double width, double ratio, double tip_share, double tip_deg) {
  const Arc a(width, width * ratio);
  // P: where the arc stands tip_share * width / 2 high; at_deg is its angle from the top, and the arc's slope there.
  const double h = tip_share * width / 2, at_deg = elementary::acos((h - a.centre.y()) / a.radius) * kDeg;
  const Vec2 P = a.centre + a.radius * along(90 - at_deg);
  // The small tip at P lies between the arc's tangent, which runs back to the middle, and the line to Q on the axis.
  const double down_deg = tip_deg - at_deg;
  if (down_deg < 5)
    throw InputError(
        "m_plasty", 0,
        "a tip of " + std::to_string(int(tip_deg)) + " degrees never meets the axis, since the arcs still close by " +
            std::to_string(int(at_deg + 0.5)) + " degrees there; expected a larger tip_deg, tip_share or ratio");
  const double tongue = h / elementary::sin(down_deg / kDeg);
  const Vec2 Q = P - tongue * along(down_deg);
  const double s_deg = at_deg - tongue / a.radius * kDeg;  // S: as far back along the arc as the tongue is long
  if (s_deg < -a.tip_deg + 5)
    throw InputError("m_plasty", 0,
                     "the tongue is longer than the wound; expected a larger tip_deg or ratio, or a smaller tip_share");

  const auto flipped = [](std::vector<Vec2> p) {
    for (Vec2& v : p) v = below(v);
    return p;
  };
  const auto body = arc(a.centre, a.radius, 90 + a.tip_deg, 90 - s_deg, kPieces),
             tail = arc(a.centre, a.radius, 90 - s_deg, 90 - at_deg, 6);
  Figure f;
  Walk w;
  const int left = w(body.front()), top_S = w.on(body), top_P = w.on(tail), q = w(Q), low_P = w(below(P)),
            low_S = w.on(reversed(flipped(tail)));
  w.between(reversed(flipped(body)));
  f.excisions = {w.at};
  f.wounds = {w.at};
  f.keys = {{{0, q}, {0, top_S}}, {{0, q}, {0, low_S}}};
  f.seams = {seam(left, top_S, left, low_S), seam(top_S, top_P, q, top_P), seam(q, low_P, low_S, low_P)};
  f.seams[0].from_middle = true;
  return f;
}

}  // namespace limberg::figures
