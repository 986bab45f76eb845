// Flaps beside a rhombic defect: Limberg, Dufourmentel, Webster.
#include "sim/commands/procedures/figures.h"
#include "sim/commands/procedures/shapes.h"

namespace limberg::figures {

namespace {

// Rhombus ABCD around a corner D at the origin, its short diagonal along x. The flap CDEF goes over: D to B, E to A.
Figure rhombic(double L, double angle_deg, const Vec2& E, const Vec2& F) {
  const Vec2 half = L * along(90 - angle_deg / 2);  // from C to D: (sin, cos) of half the angle
  const Vec2 D(0, 0), A(-half.x(), half.y()), C(-half.x(), -half.y()), B(-2 * half.x(), 0);
  Figure f;
  Walk w;
  const int a = w(A), d2 = w(D), e2 = w(E), fF = w(F), e1 = w(E), d1 = w(D), c = w(C), b = w(B);
  f.excisions = {{A, B, C, D}};
  f.incisions = {{D, E, F}};
  f.wounds = {w.at};
  // The donor wound first: it carries the tension.
  f.keys = {{{0, d2}, {0, fF}, true}, {{0, d1}, {0, b}}, {{0, e1}, {0, a}}};
  f.carries = {{{0, e1}, {0, a}}, {{0, d1}, {0, b}}};
  f.seams = {seam(d2, e2, fF, e2), seam(b, a, d1, e1), seam(a, d2, e1, fF), seam(c, b, c, d1)};
  return f;
}

}  // namespace

Figure rhomboid(double L, double angle_deg) {
  const Vec2 E(L, 0);
  return rhombic(L, angle_deg, E, E - L * along(90 - angle_deg / 2));
}

Figure dufourmentel(double L, double angle_deg) {
  const Vec2 E = L * along((90 - angle_deg / 2) / 2);
  return rhombic(L, angle_deg, E, E - Vec2(0, L));
}

Figure webster(double L, double tip_deg) {
  const double out_deg = (90 - 60.0 / 2) / 2;
  const Vec2 E = L * along(out_deg);
  return rhombic(L, 60, E, E + L * along(out_deg + 180 + tip_deg));
}

}  // namespace limberg::figures
