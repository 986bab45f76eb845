// Volumes of the classes of a cell, by the divergence theorem applied three times.
//
// With the cell at [0,W] x [0,D] x [0,H], a region R in it and n its outward normal:
//   vol(R)                    = integral of z n_z over its faces inside the cell  +  H * area of R on the square z = H
//   area(R on z = H)          = integral of x nu_x over its curves on that square +  W * length of R on the edge x = W
//   length(R on x = W, z = H) = sum of y nu_y over its hits on that edge          +  D * [corner (W,D,H) in R]
// Every term belongs to one sided face or to the corner, and the two sides of a face differ in sign, so a face that has
// the same class on both sides contributes nothing. Doubles throughout: the terms are continuous, rounding stays
// rounding. One is not: a curve that runs along the edge x = W counts in full on this side of it and not at all beyond.
// On which side its ends lie is decided exactly, as the hits on that edge are.
#include <algorithm>
#include <cmath>

#include "sim/lattice/cell_builder.h"

namespace limberg {
namespace {

struct Polygon {
  Vec3 v[9];
  int n = 0;
};

// The part of p with sign * (coordinate - at) >= 0, into r; false: that is all of p.
template <int kAxis>
bool clip(const Polygon& p, double at, double sign, Polygon& r) {
  double inside[9];
  bool all = true;
  for (int i = 0; i < p.n; ++i) {
    inside[i] = sign * (p.v[i][kAxis] - at);
    all = all && inside[i] >= 0;
  }
  if (all) return false;
  r.n = 0;
  for (int i = 0; i < p.n; ++i) {
    const int next = i + 1 < p.n ? i + 1 : 0;
    const Vec3 &a = p.v[i], &b = p.v[next];
    const double da = inside[i], db = inside[next];
    if (da >= 0) r.v[r.n++] = a;
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
      Vec3& c = r.v[r.n++];
      c = a + (b - a) * (da / (da - db));
      c[kAxis] = at;
    }
  }
  return true;
}

/// A triangle clipped to the box from 0 to `size`.
class Clipped {
 public:
  explicit Clipped(const std::array<Vec3, 3>& corner)
      : low_(corner[0].cwiseMin(corner[1]).cwiseMin(corner[2])),
        high_(corner[0].cwiseMax(corner[1]).cwiseMax(corner[2])) {
    for (size_t k = 0; k < 3; ++k) now_->v[k] = corner[k];
    now_->n = 3;
  }
  template <int kAxis>
  void along(double size) {
    if (now_->n < 3) return;
    constexpr double kClear = 1e-3;  // half-units, far above what clipping along another axis can move
    if (low_[kAxis] < kClear) keep<kAxis>(0, 1);
    if (high_[kAxis] > size - kClear) keep<kAxis>(size, -1);
  }
  const Polygon& polygon() const { return *now_; }

 private:
  template <int kAxis>
  void keep(double at, double sign) {
    if (clip<kAxis>(*now_, at, sign, *other_)) std::swap(now_, other_);
  }
  Polygon polygon_[2];
  Polygon *now_ = &polygon_[0], *other_ = &polygon_[1];
  Vec3 low_, high_;
};

// Integral of z n_z over the polygon, n along its counter-clockwise side.
double z_flux(const Polygon& p) {
  double sum = 0;
  for (int i = 1; i + 1 < p.n; ++i) {
    const Vec3 &a = p.v[0], &b = p.v[i], &c = p.v[i + 1];
    const double area2 = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    sum += area2 * (a.z() + b.z() + c.z());
  }
  return sum / 6;
}

// Integral of x |dy| along the segment a-b clipped to [0,W] x [0,D].
double x_sweep(Vec3 a, Vec3 b, double W, double D) {
  for (int axis = 0; axis < 2; ++axis)
    for (int high = 0; high < 2; ++high) {
      const double at = high ? (axis ? D : W) : 0, s = high ? -1 : 1;
      const double da = s * (a[axis] - at), db = s * (b[axis] - at);
      if (da < 0 && db < 0) return 0;
      if (da < 0)
        a += (b - a) * (da / (da - db));
      else if (db < 0)
        b += (a - b) * (db / (db - da));
    }
  return 0.5 * (a.x() + b.x()) * std::abs(b.y() - a.y());
}

}  // namespace

// What a face adds to the volume behind it (where its normal comes from), and takes from that before it.
double CellBuilder::flux_of(LocalFace& f) {
  Vec3 low;
  for (int a = 0; a < 3; ++a) low[a] = sub_to_half(bound_[size_t(a)][0]);
  const double W = grid_.pitch.x, D = grid_.pitch.y, H = grid_.pitch.z;
  Shape& s = shape(f);
  std::array<Vec3, 3> corner;
  for (size_t k = 0; k < 3; ++k) corner[k] = *s.p[k].approx - low;
  Clipped clipped(corner);
  if (!f.in.inside()) {
    clipped.along<0>(W);
    clipped.along<1>(D);
    clipped.along<2>(H);
  }
  double flux = z_flux(clipped.polygon());
  if (!(f.in.squares() >> 5 & 1) || f.plane->n[0] == 0) return flux;  // not through the plane z high
  // The lattice edge along y at x and z high: seen along y the coordinates are (z, x), both high: corner 3.
  const SubPoint line = edge_corner(1, 3);
  const int32_t top = index_[2] + 1;
  layered_shape(f);
  Vec3 end[2];
  bool beyond[2] = {false, false};
  int n = 0;
  for (size_t e = 0; e < 3 && n < 2; ++e) {
    const size_t next = e == 2 ? 0 : e + 1;
    const bool rises = s.layer[e][2] < top;
    if (rises == (s.layer[next][2] < top)) continue;
    const Vec3 &a = corner[e], &b = corner[next];
    // Seen along y the coordinates are (z, x): an edge that rises in z has the line to its left when it passes at
    // smaller x. Both ends within the low side of x high need no sign.
    if (s.layer[e][0] > index_[0] || s.layer[next][0] > index_[0]) {
      const EdgeInCell* known = s.edge[e] >= 0 && edge_[size_t(s.edge[e])].known ? &edge_[size_t(s.edge[e])] : nullptr;
      const int about =
          known ? (s.turned[e] ? -1 : 1) * known->about.of(1, 3) : edge_about_corner(s.p[e], s.p[next], 1, line);
      beyond[n] = (about > 0) == !rises;
    }
    end[n] = a + (b - a) * ((H - a.z()) / (b.z() - a.z()));
    if (!beyond[n]) end[n].x() = std::min(end[n].x(), W);
    ++n;
  }
  if (n == 2 && beyond[0] != beyond[1] && f.plane->n[1] != 0) {
    const double y = hit_on_line(*f.plane, 1, line) - low.y();
    end[beyond[0] ? 0 : 1] =
        Vec3(W, std::clamp(y, std::min(end[0].y(), end[1].y()), std::max(end[0].y(), end[1].y())), H);
    beyond[0] = beyond[1] = false;
  }
  if (n == 2 && !beyond[0]) flux += (f.plane->n[0] > 0 ? H : -H) * x_sweep(end[0], end[1], W, D);
  return flux;
}

void CellBuilder::measure(CellComponents& out) {
  const double W = grid_.pitch.x, D = grid_.pitch.y, H = grid_.pitch.z;
  volume_.assign(out.classes.size(), 0);
  auto add = [&](size_t local, double along_normal) {
    // Side 0 has its material where the normal points: its outward normal is the opposite.
    if (out.of_side[local][0] >= 0) volume_[size_t(out.of_side[local][0])] -= along_normal;
    if (out.of_side[local][1] >= 0) volume_[size_t(out.of_side[local][1])] += along_normal;
  };
  for (size_t l = 0; l < face_.size(); ++l) {
    double& flux = out.flux[l];
    if (out.of_side[l][0] == out.of_side[l][1]) continue;
    if (std::isnan(flux)) flux = flux_of(face_[l]);
    add(l, flux);
  }
  const SubPoint line = edge_corner(1, 3);
  for (int32_t h : hit_[4 * 1 + 3]) {
    const Plane& plane = *face_[size_t(h)].plane;
    const double y = hit_on_line(plane, 1, line) - sub_to_half(bound_[1][0]);
    add(size_t(h), (plane.n[1] > 0 ? 1.0 : -1.0) * y * W * H);
  }
  if (out.of_corner[7] >= 0) volume_[size_t(out.of_corner[7])] += W * D * H;
  for (size_t c = 0; c < volume_.size(); ++c) out.classes[c].fraction = volume_[c] / (W * D * H);
}

}  // namespace limberg
