// Flaps that slide or turn: V-Y, keystone, advancement, rotation, banner, bilobed, O-to-Z.
#include <algorithm>

#include "sim/base/elementary.h"
#include "sim/commands/procedures/figures.h"
#include "sim/commands/procedures/shapes.h"

namespace limberg::figures {

namespace {}

// The island has walls of its own all around: wound 0 is the outer skin's edge, wound 1 the island's.
Figure v_y(double W, double H, double advance) {
  const Vec2 left(-W / 2, 0), right(W / 2, 0), apex(0, -H), up(0, advance);
  const double side = (apex - left).norm(),
               keep = side - advance;  // the outer side keeps so much of its V for the island
  const Vec2 u_left = left + (apex - left) * (keep / side), u_right = right + (apex - right) * (keep / side);
  Figure f;
  f.excisions = {{left, right, right + up, left + up}};
  f.incisions = {{left, apex, right}};
  Walk o;
  const int tl = o(left + up), tr = o(right + up);
  o(right);
  const int ur = o(u_right), ap = o(apex), ul = o(u_left);
  o(left);
  Walk i;
  const int il = i(left), ia = i(apex), ir = i(right);
  f.wounds = {o.at, i.at};
  f.undermined = false;  // it lives on the fat below
  f.deeper = 2;
  f.keys = {{{1, il}, {0, tl}}, {{1, ir}, {0, tr}}, {{0, ul}, {0, ur}}, {{1, ia}, {0, ul}}};
  f.seams = {{{0, ur}, {0, ap}, {0, ul}, {0, ap}},  // the stem of the Y
             {{1, ir}, {1, il}, {0, tr}, {0, tl}},  // the island's base to the defect's far edge
             {{1, il}, {1, ia}, {0, tl}, {0, ul}},
             {{1, ia}, {1, ir}, {0, ur}, {0, tr}}};
  return f;
}

// Wound 0 is the outer skin's edge, wound 1 the island's, as of the V-Y.
Figure keystone(double width, double ratio, double flap_ratio, double v_mm) {
  // Both arcs of the defect have this radius; the lower one's centre lies above it, and the island's far side is
  // concentric with it, so that its ends stand at right angles to the defect's edge.
  const double length = width * ratio, R = (length * length + width * width) / (4 * width), flap = flap_ratio * width,
               half_deg = elementary::asin(length / 2 / R) * kDeg, v_deg = v_mm / (R + flap) * kDeg;
  const Vec2 above(0, R - width / 2), below(0, width / 2 - R);
  const int n = 12;
  const auto top = arc(below, R, 90 + half_deg, 90 - half_deg, n);
  const auto inner = arc(above, R, 270 - half_deg, 270 + half_deg, n);  // the defect's lower edge, to the right
  const auto on_far = [&](double deg) -> Vec2 { return above + (R + flap) * along(deg); };
  const auto on_end = [&](double deg) -> Vec2 { return above + (R + flap - v_mm) * along(deg); };
  const double left = 270 - half_deg, right = 270 + half_deg;
  // The far side with the corners where each V begins.
  const auto middle = arc(above, R + flap, left + v_deg, right - v_deg, n);

  Figure f;
  Walk hole;
  for (const Vec2& p : top) hole(p);
  hole.between(reversed(inner));
  f.excisions = {hole.at};
  f.incisions = {{inner.front(), on_far(left)}};
  f.incisions[0].insert(f.incisions[0].end(), middle.begin(), middle.end());
  f.incisions[0].insert(f.incisions[0].end(), {on_far(right), inner.back()});

  Walk o;
  const int p0 = o(top.front()), p1 = o.on(top), e1 = o(on_end(right)), q1 = o(on_far(right)), m1 = o(middle.back()),
            m0 = o.on(reversed(middle)), q0 = o(on_far(left)), e0 = o(on_end(left));
  Walk i;
  const int iq0 = i(on_far(left));
  for (const Vec2& p : middle) i(p);
  const int iq1 = i(on_far(right)), ip1 = i(inner.back()), ip0 = i.on(reversed(inner));
  f.wounds = {o.at, i.at};
  f.undermined = false;  // it lives on the fat below
  f.deeper = 2;
  const Corner crown{1, (ip0 + ip1) / 2}, top_of{0, (p0 + p1) / 2};  // they meet first
  f.keys = {{crown, top_of}, {{0, e0}, {0, m0}}, {{0, e1}, {0, m1}}, {{1, iq0}, {0, e0}}, {{1, iq1}, {0, e1}}};
  f.seams = {{{1, ip1}, crown, {0, p1}, top_of},                                            // over the defect
             {crown, {1, ip0}, top_of, {0, p0}},     {{0, e1}, {0, q1}, {0, m1}, {0, q1}},  // the stems of the Vs
             {{0, q0}, {0, e0}, {0, q0}, {0, m0}},   {{1, iq1}, {1, ip1}, {0, e1}, {0, p1}},
             {{1, ip0}, {1, iq0}, {0, p0}, {0, e0}}, {{1, iq0}, {1, iq1}, {0, m0}, {0, m1}}};
  return f;
}

Figure advancement(double w, double l, double h) {
  const Vec2 a(-w, w / 2), b(l - w, w / 2), t(l - w / 2, w / 2 + h), c(l, w / 2), d(0, w / 2);
  const auto low = [](const Vec2& p) -> Vec2 { return {p.x(), -p.y()}; };
  Figure f;
  Walk k;
  const int A = k(a), B = k(b), T = k(t), C = k(c), D = k(d), D2 = k(low(d)), C2 = k(low(c)), T2 = k(low(t)),
            B2 = k(low(b)), A2 = k(low(a));
  f.wounds = {k.at};
  f.excisions = {{a, d, low(d), low(a)}, {b, t, c}, {low(c), low(t), low(b)}};
  f.incisions = {{d, b}, {low(d), low(b)}};
  f.carries = {{{0, D}, {0, A}}, {{0, D2}, {0, A2}}};
  f.keys = {{{0, D}, {0, A}}, {{0, D2}, {0, A2}}, {{0, C}, {0, B}}, {{0, C2}, {0, B2}}};
  f.seams = {seam(D, D2, A, A2), seam(B, T, C, T), seam(C2, T2, B2, T2), seam(A, B, D, C), seam(D2, C2, A2, B2)};
  return f;
}

Figure rotation(double R, double defect_deg, double arc_deg) {
  // The circle's centre is the pivot; the flap's corner Q stands at `first`, so that defect and flap lie around +y.
  const double first = 90 - arc_deg / 2;
  const Vec2 O(0, 0), Q = R * along(first);
  const auto back = arc(O, R, first + arc_deg, first, int(std::ceil(arc_deg / 8)));
  const auto out = arc(O, R, first, first - defect_deg, std::max(2, int(std::ceil(defect_deg / 8))));
  Figure f;
  Walk w;
  const int o = w(O), q = w(Q), end = w.on(reversed(back));
  w.on(back);
  const int s = w.on(out);
  f.wounds = {w.at};
  f.excisions = {{O}};
  for (const Vec2& p : reversed(out)) f.excisions[0].push_back(p);
  f.incisions = {reversed(back)};
  f.carries = {{{0, q}, {0, s}}};
  f.keys = {{{0, q}, {0, s}}};
  f.seams = {seam(o, q, o, s), seam(q, end, s, end)};
  return f;
}

Figure bilobed(double diameter, double turn) {
  // In polar coordinates about the pivot P: the defect fills -turn/2..turn/2,
  // the first lobe turn/2..3 turn/2, the second up to 5 turn/2. The circle of
  // the defect touches the rays at `edge` from the pivot.
  const double r = diameter / 2, d = r / elementary::sin(turn / 2 / kDeg), edge = d * elementary::cos(turn / 2 / kDeg);
  const auto cap = [&](int lobe) {  // the lobe's outer arc, from its lower ray to its upper one
    return arc(d * along(turn * lobe), r, turn * lobe - 90 - turn / 2, turn * lobe + 90 + turn / 2, 10);
  };
  const auto ray = [&](double k) -> Vec2 { return edge * along(turn * k); };
  // The second lobe's cap is a triangle: its two sides close against each other.
  const Vec2 P(0, 0), t1 = ray(0.5), t2 = ray(1.5), t3 = ray(2.5), X = (d + 1.6 * r) * along(2 * turn), end = 0.45 * t3;
  Figure f;
  Walk w;
  const int p = w(P), q1 = w(t1), q2 = w.on(cap(1));
  w(X);
  const int q3 = w(t3), e = w(end), o3 = w(t3), ox = w(X), o2 = w(t2), o1 = w.on(reversed(cap(1)));
  const int o0 = w.on(reversed(cap(0)));
  f.wounds = {w.at};
  f.excisions = {{P}};
  for (const Vec2& v : cap(0)) f.excisions[0].push_back(v);
  f.incisions = {cap(1)};
  f.incisions[0].insert(f.incisions[0].end(), {X, t3, end});
  const int flap_x = q2 + 1;
  f.carries = {{{0, q1}, {0, o0}}, {{0, flap_x}, {0, (o1 + o2) / 2}}};
  f.keys = {{{0, o3}, {0, o2}, true}, {{0, q1}, {0, o0}}, {{0, q2}, {0, o1}}};
  f.seams = {seam(o3, ox, o2, ox), seam(p, q1, p, o0), seam(q1, q2, o0, o1), seam(q2, q3, o1, o2), seam(q3, e, o3, e)};
  // Drawn to the flap as well, o2 would be caught beneath the bank o3: of five hands two could not see it any more.
  f.seams.back().no_key = true;
  return f;
}

Figure banner(double diameter, double turn, double tip_ratio) {
  // In polar coordinates about the pivot P, as the bilobed flap: the defect fills -turn/2..turn/2, the flap the angle
  // up to 3 turn/2, drawn out to a point so that its bed closes.
  const double r = diameter / 2, d = r / elementary::sin(turn / 2 / kDeg), edge = d * elementary::cos(turn / 2 / kDeg);
  const Vec2 P(0, 0), t1 = edge * along(turn / 2), t2 = edge * along(1.5 * turn), X = (d + tip_ratio * r) * along(turn),
                      end = 0.45 * t2;
  const auto cap = arc({d, 0}, r, -90 - turn / 2, 90 + turn / 2, 10);  // the defect's outer arc
  Figure f;
  Walk w;
  const int p = w(P), q1 = w(t1), x = w(X), q2 = w(t2), e = w(end), o2 = w(t2), ox = w(X), o1 = w(t1);
  const int o0 = w.on(reversed(cap));
  f.wounds = {w.at};
  f.excisions = {{P}};
  for (const Vec2& v : cap) f.excisions[0].push_back(v);
  f.incisions = {{t1, X, t2, end}};
  f.carries = {{{0, q1}, {0, o0}}, {{0, x}, {0, (o1 + o0) / 2}}};
  f.keys = {{{0, o2}, {0, o1}, true}, {{0, q1}, {0, o0}}, {{0, x}, {0, (o1 + o0) / 2}}, {{0, q2}, {0, o1}}};
  const int m = (o1 + o0) / 2;
  f.seams = {seam(o2, ox, o1, ox), seam(p, q1, p, o0), seam(q1, x, o0, m), seam(x, q2, m, o1), seam(q2, e, o2, e)};
  return f;
}

Figure o_to_z(double diameter, double cut_ratio, double tip) {
  const double r = diameter / 2, cut = cut_ratio * diameter, big = 1.25 * diameter;  // radius of the cuts
  const double turn = cut / big * kDeg;
  // The first cut leaves the top of the circle towards +x, `tip` degrees off its tangent, and bends down; the second is
  // its image, turned half around. Along the tangent the flaps' tips would be horns in which no stitch holds.
  const auto first = arc(Vec2(0, r) + big * along(tip - 90), big, 90 + tip, 90 + tip - turn, int(std::ceil(turn / 8)));
  const auto half = [](std::vector<Vec2> p) {
    for (Vec2& v : p) v = -v;
    return p;
  };
  // The tips slide by 1/5 of the circle over each other's edges, and so draw the Z.
  const double slide_deg = 72;
  const auto left_low = arc({0, 0}, r, 270, 90 + slide_deg, 6), left_top = arc({0, 0}, r, 90 + slide_deg, 90, 4);
  Figure f;
  Walk w;
  const int b2 = w(left_low.front()), m2 = w.on(left_low);
  w.on(left_top);
  const int e1 = w.on(first), t1 = w.on(reversed(first)), m1 = w.on(half(left_low));
  w.on(half(left_top));
  const int e2 = w.on(half(first));
  w.between(reversed(half(first)));
  f.wounds = {w.at};
  Walk circle;
  circle(left_low.front());
  for (const auto& part : {left_low, left_top, half(left_low)}) circle.on(part);
  circle.between(half(left_top));
  f.excisions = {circle.at};
  f.incisions = {first, half(first)};
  f.carries = {{{0, t1}, {0, m2}}, {{0, b2}, {0, m1}}};
  f.keys = {{{0, t1}, {0, m2}}, {{0, b2}, {0, m1}}};
  // Middle limb: tip to tip; then each arc, its outer bank longer by the slide.
  f.seams = {seam(t1, m1, m2, b2), seam(m2, e1, t1, e1), seam(m1, e2, b2, e2)};
  return f;
}

}  // namespace limberg::figures
