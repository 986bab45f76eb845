#include "sim/imaging/anatomical/teeth_shape.h"

#include "sim/base/elementary.h"

namespace limberg::anatomical {
namespace {

struct Size {
  double wide, deep, high, root;
  int kind;
  double lean_deg;  // of the crown, its edge outwards
};
const Size kUpper[] = {{8.5, 7, 10.5, 13, 0, 24}, {6.5, 6, 9.4, 13, 0, 22}, {7.6, 8, 10, 17, 1, 14},
                       {7.0, 9, 8.5, 13, 2, 4},   {6.8, 9, 8.2, 13, 2, 2},  {10, 11, 7.5, 12, 3, 0},
                       {9, 11, 7, 11, 3, 0}};
const Size kLower[] = {{5.2, 6, 9.2, 12, 0, 14},   {5.6, 6.4, 9.4, 13, 0, 12}, {7.0, 7.6, 10.6, 15, 1, 6},
                       {7.0, 7.6, 8.6, 13, 2, -4}, {7.0, 8, 8.0, 13, 2, -8},   {11, 10.4, 7.5, 13, 3, -12},
                       {10.5, 10, 7, 12, 3, -14}};

/// Half an ellipse through the middles of the edges: half its width, its depth, and y of its ends.
struct Arch {
  double a, b, y0;
};
constexpr Arch kUpperArch{26.5, 42, 52.5}, kLowerArch{24.6, 40.5, 52.6};
/// Where the teeth meet, rising backwards.
double occlusal(double y) { return -50.6 - 0.115 * (y - 55); }
constexpr double kBite_mm = -0.4;  // half the gap between rows; below 0 cusps reach into fossae

}  // namespace

Teeth::Teeth(Jaw jaw) {
  const bool upper = jaw == Jaw::upper;
  const Arch& arch = upper ? kUpperArch : kLowerArch;
  const Vec3 edgewards = upper ? Vec3(0, 0, -1) : Vec3(0, 0, 1);
  double phi = 0, walked = 0, at = 0;
  const auto on = [&](double f) { return Vec3(arch.a * elementary::sin(f), arch.y0 + arch.b * elementary::cos(f), 0); };
  for (size_t i = 0; i < 7; ++i) {
    const Size& s = upper ? kUpper[i] : kLower[i];
    for (at += 0.5 * s.wide; walked < at; phi += 1e-3) walked += (on(phi + 1e-3) - on(phi)).norm();
    at += 0.5 * s.wide;
    const Vec3 middle = on(phi), along = (on(phi + 1e-3) - on(phi)).normalized();
    Vec3 buccal(along.y(), -along.x(), 0);
    if (buccal.dot(middle - Vec3(0, 50, 0)) < 0) buccal = -buccal;
    const double lean = s.lean_deg * M_PI / 180;
    const Vec3 axis = (elementary::cos(lean) * edgewards + elementary::sin(lean) * buccal).normalized();
    Tooth t;
    t.axes.col(0) = along, t.axes.col(2) = axis, t.axes.col(1) = (buccal - buccal.dot(axis) * axis).normalized();
    // Edges of front teeth reach past the level where the others meet: overbite.
    const double over = (i < 2 ? 2.0 : i == 2 ? 1.6 : 0) * (upper ? 1 : 0.1);
    Vec3 edge = middle;
    edge.z() = occlusal(middle.y()) + (upper ? kBite_mm : -kBite_mm) + over * edgewards.z();
    t.neck = edge - s.high * axis;
    t.wide = s.wide, t.deep = s.deep, t.high = s.high, t.root = s.root, t.kind = s.kind;
    if (i == 0) incisal_ = Vec3(0, edge.y(), edge.z());
    const Vec3 from = t.neck + 1.5 * axis, to = t.neck - s.root * axis;
    root_.push_back(
        Tube{{from.x(), from.y(), from.z(), 0.4 * std::min(s.wide, s.deep) + 0.3}, {to.x(), to.y(), to.z(), 1.6}});
    tooth_.push_back(t);
  }
}

double Teeth::Tooth::operator()(const Vec3& p) const {
  const Vec3 l = axes.transpose() * (p - neck);
  const double t = std::clamp(l.z() / high, 0., 1.);
  const bool front = kind < 2;
  const double half_wide = 0.5 * wide * (0.78 + 0.20 * ramp(0, 0.6, t)),
               half_deep =
                   0.5 * deep * (front ? 0.92 - 0.52 * t : 0.88 + 0.10 * ramp(0, .4, t) - 0.22 * ramp(.5, 1, t));
  // An incisor's back is hollow, its front bulges a little.
  const double shift = front ? 0.30 * deep * 0.5 * (t - 0.3) + 0.5 * elementary::sin(M_PI * t) * 0.6 : 0;
  double top = high;
  if (kind == 1) top -= 0.55 * std::abs(l.x());
  if (kind >= 2) top -= 1.3;
  const double r = front ? 1.0 : 1.4;
  const Vec3 b(std::abs(l.x()) - half_wide + r, std::abs(l.y() - shift) - half_deep + r,
               std::abs(l.z() - 0.5 * top + 1) - 0.5 * top - 1 + r);
  double d = b.cwiseMax(0.).norm() + std::min(b.maxCoeff(), 0.) - r;
  if (kind >= 2) {
    const double cx = kind == 3 ? 0.25 * wide : 0, cy = 0.26 * deep;
    const double cusp = (Vec3(std::abs(l.x()) - cx, std::abs(l.y()) - cy, l.z() - high + 2.4)).norm() - 2.4;
    d = smin(d, cusp, 1.0);
    d = smax(d, -((Vec3(0.7 * l.x() * 4 / wide, l.y(), l.z() - high - 0.6)).norm() - 2.2), 1.2);
  }
  return 0.8 * d;
}

bool Teeth::near(const Vec3& q, double d) const {
  const Vec3 c(14, 74, -52);
  return (q - c).norm() < 42 + d;
}

double Teeth::crowns(const Vec3& q) const {
  double d = 15;
  for (const Tooth& t : tooth_)
    if ((q - t.neck - 0.5 * t.high * t.axes.col(2)).norm() - 9.5 < d) d = smin(d, t(q), 0.8);
  return d;
}

double Teeth::roots(const Vec3& q) const {
  double d = 30;
  for (const Tube& c : root_) d = join(d, c, q, 1.5);
  return d;
}

}  // namespace limberg::anatomical
