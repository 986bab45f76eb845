// Z-plasties: one, several in a row, four flaps.
#include "sim/commands/procedures/figures.h"
#include "sim/commands/procedures/shapes.h"

namespace limberg::figures {

Figure z_plasty(double L, double a_deg, double b_deg) {
  const Vec2 A(0, L / 2), B(0, -L / 2), C = A + L * turned({0, -1}, -a_deg), D = B + L * turned({0, 1}, -b_deg);
  Figure f;
  Walk w;
  const int c = w(C), a0 = w(A), b2 = w(B), d = w(D), b0 = w(B), a1 = w(A);
  f.incisions = {{C, A, B, D}};
  f.wounds = {w.at};
  f.exchanged = true;
  f.carries = {{{0, a1}, {0, d}}, {{0, b2}, {0, c}}};
  f.keys = {{{0, a1}, {0, d}}, {{0, b2}, {0, c}}};
  f.seams = {seam(b0, a1, b0, d), seam(a0, b2, a0, c), seam(a1, c, d, b2)};
  return f;
}

Figure multiple_z(double length, int count, double angle_deg) {
  const double L = length / count;
  const auto P = [&](int j) -> Vec2 { return {0, length / 2 - L * j}; };
  const auto C = [&](int j) -> Vec2 {
    return P(j - 1) + L * turned({0, -1}, -angle_deg);
  };  // of the j-th, from its upper end
  const auto D = [&](int j) -> Vec2 { return P(j) + L * turned({0, 1}, -angle_deg); };
  Figure f;
  f.incisions.push_back({C(1)});
  for (int j = 0; j <= count; ++j) f.incisions[0].push_back(P(j));
  f.incisions[0].push_back(D(count));
  for (int j = 1; j < count; ++j) f.incisions.push_back({P(j), D(j)}), f.incisions.push_back({P(j), C(j + 1)});

  // Down the right side with its limbs, up the left one. At P(j):
  // `in` the flap's tip or the outer corner that comes first.
  const auto n = size_t(count) + 1;
  std::vector<int> right_in(n), right_out(n), left_in(n), left_out(n), c(n), d(n);
  Walk w;
  c[1] = w(C(1));
  right_out[0] = w(P(0));
  for (int j = 1; j <= count; ++j) {
    const auto k = size_t(j);
    right_in[k] = w(P(j)), d[k] = w(D(j));  // the right flap's tip, then its limb and back
    right_out[k] = w(P(j));
  }
  for (int j = count; j >= 1; --j) {
    const auto k = size_t(j) - 1;
    left_in[k] = w(P(j - 1));  // the left flap's tip
    if (j > 1) c[size_t(j)] = w(C(j)), left_out[k] = w(P(j - 1));
  }
  f.wounds = {w.at};
  f.exchanged = true;
  for (int j = 1; j <= count; ++j) {
    const auto k = size_t(j);
    const int a_tip = left_in[k - 1], b_tip = right_in[k];
    // the upper end's corner with the bank above the left limb
    const int a_outer = j == 1 ? right_out[0] : left_out[k - 1];
    const int b_outer = right_out[k];
    const int a_below = right_out[k - 1], b_above = j == count ? right_out[k] : left_out[k];
    f.carries.push_back({{0, a_tip}, {0, d[k]}});
    f.carries.push_back({{0, b_tip}, {0, c[k]}});
    f.keys.push_back({{0, a_tip}, {0, d[k]}});
    f.keys.push_back({{0, b_tip}, {0, c[k]}});
    f.seams.push_back(seam(b_above, a_tip, b_outer, d[k]));
    f.seams.push_back(seam(a_below, b_tip, a_outer, c[k]));
    f.seams.push_back(seam(a_tip, c[k], d[k], b_tip));
  }
  return f;
}

Figure four_flap_z(double L, double t) {
  const Vec2 A(0, L / 2), B(0, -L / 2);
  const Vec2 C = A + L * turned({0, -1}, -2 * t), E = A + L * turned({0, -1}, -t), D = B + L * turned({0, 1}, -2 * t),
             G = B + L * turned({0, 1}, -t);
  Figure f;
  f.incisions = {{C, A, B, D}, {A, E}, {B, G}};
  Walk w;
  const int c = w(C), a0 = w(A), b3 = w(B), g = w(G), b4 = w(B), d = w(D), b0 = w(B), a1 = w(A), e = w(E), a2 = w(A);
  f.wounds = {w.at};
  f.exchanged = true;
  // Like a zip from the upper end: B3 to C, A2 to G, B4 to E, A1 to D.
  f.carries = {{{0, a1}, {0, d}}, {{0, b3}, {0, c}}, {{0, a2}, {0, g}}, {{0, b4}, {0, e}}};
  f.keys = {{{0, a1}, {0, d}}, {{0, b3}, {0, c}}, {{0, a2}, {0, g}}, {{0, b4}, {0, e}}};
  f.seams = {seam(b0, a1, b0, d), seam(a0, b3, a0, c), seam(a2, c, g, b3), seam(e, a2, b4, g), seam(a1, e, d, b4)};
  return f;
}

}  // namespace limberg::figures
