#include "sim/geometry/bvh.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <utility>

#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

float below(double v) {
  const float f = float(v);
  return double(f) <= v ? f : std::nextafter(f, -kInf);
}
float above(double v) {
  const float f = float(v);
  return double(f) >= v ? f : std::nextafter(f, kInf);
}

v4 larger(v4 a, v4 b) { return a > b ? a : b; }

/// A place, and by how much less than what floats say of it a distance along each axis may be.
struct FourOf {
  v4 at[3], off[3];
  explicit FourOf(const Vec3& p) {
    for (int a = 0; a < 3; ++a) {
      const float x = float(p[a]), e = std::abs(x) * 0x1p-22f;  // p to x, and x to the box
      at[a] = x - v4{}, off[a] = e - v4{};
    }
  }
};

/// Squared distances to four boxes, never more than they are.
v4 distances2(const v4 (&lo)[3], const v4 (&hi)[3], const FourOf& p) {
  v4 sum = {};
  for (int a = 0; a < 3; ++a) {
    const v4 out = larger(lo[a] - p.at[a], p.at[a] - hi[a]) - p.off[a];
    const v4 d = larger(out, v4{});
    sum += d * d;
  }
  return sum * (1 - 0x1p-20f);
}

}  // namespace

Bvh::Bvh(std::span<const Vec3> X_mm, std::span<const Tri> tri, std::span<const int32_t> subset)
    : x_(X_mm.begin(), X_mm.end()), tri_(tri.begin(), tri.end()), order_(subset.begin(), subset.end()) {
  if (subset.empty()) {
    order_.resize(tri_.size());
    std::iota(order_.begin(), order_.end(), 0);
  }
  if (order_.empty()) return;
  std::vector<Vec3> centre(tri_.size());
  for (size_t t = 0; t < tri_.size(); ++t)
    centre[t] = (x_[size_t(tri_[t][0])] + x_[size_t(tri_[t][1])] + x_[size_t(tri_[t][2])]) / 3;
  node_.reserve(order_.size());
  build(0, int32_t(order_.size()), centre);
  node_.shrink_to_fit();
  four_.reserve(order_.size() / 2 + 1);
  widen(0);
  four_.shrink_to_fit();
  fit();
}

// A node's children and, as far as there is room, theirs; of a leaf its triangles.
int32_t Bvh::widen(int32_t at) {
  const int32_t self = int32_t(four_.size());
  four_.emplace_back();
  const Node& node = node_[size_t(at)];
  Four four;
  if (node.count > 0) {
    for (int32_t i = node.first; i < node.first + node.count; ++i, ++four.count)
      four.child[size_t(four.count)] = ~order_[size_t(i)];
  } else {
    for (const int32_t child : {at + 1, node.second}) {
      const Node& c = node_[size_t(child)];
      if (c.count > 0) {
        four.node[size_t(four.count++)] = child;
      } else {
        four.node[size_t(four.count++)] = child + 1;
        four.node[size_t(four.count++)] = c.second;
      }
    }
    for (int32_t k = 0; k < four.count; ++k) four.child[size_t(k)] = widen(four.node[size_t(k)]);
  }
  four_[size_t(self)] = four;
  return self;
}

void Bvh::fit_fours() {
  for (Four& f : four_)
    for (int k = 0; k < 4; ++k)
      for (int a = 0; a < 3; ++a) {
        float lo = kInf, hi = -kInf;
        const int32_t child = f.child[size_t(k)];
        if (k < f.count && child >= 0) {
          const Node& n = node_[size_t(f.node[size_t(k)])];
          lo = n.lo[a], hi = n.hi[a];
        } else if (k < f.count) {
          double from = double(kInf), to = -double(kInf);
          for (int32_t v : tri_[size_t(~child)])
            from = std::min(from, x_[size_t(v)][a]), to = std::max(to, x_[size_t(v)][a]);
          lo = below(from), hi = above(to);
        }
        f.lo[a][k] = lo, f.hi[a][k] = hi;
      }
}

int32_t Bvh::build(int32_t first, int32_t count, std::span<const Vec3> centre) {
  const int32_t self = int32_t(node_.size());
  node_.emplace_back();
  if (count <= kLeaf) {
    node_[size_t(self)].count = count;
    node_[size_t(self)].first = first;
    return self;
  }
  Vec3 lo = centre[size_t(order_[size_t(first)])], hi = lo;
  for (int32_t i = first; i < first + count; ++i) {
    lo = lo.cwiseMin(centre[size_t(order_[size_t(i)])]);
    hi = hi.cwiseMax(centre[size_t(order_[size_t(i)])]);
  }
  int axis = 0;
  (hi - lo).maxCoeff(&axis);
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count, [&](int32_t a, int32_t b) {
    return std::pair(centre[size_t(a)][axis], a) < std::pair(centre[size_t(b)][axis], b);
  });
  build(first, count / 2, centre);
  const int32_t second = build(first + count / 2, count - count / 2, centre);
  node_[size_t(self)].second = second;
  return self;
}

void Bvh::fit() {
  for (size_t k = node_.size(); k-- > 0;) {  // children stand after their parent
    Node& n = node_[k];
    if (n.count > 0) {
      Vec3 lo = x_[size_t(tri_[size_t(order_[size_t(n.first)])][0])], hi = lo;
      for (int32_t i = n.first; i < n.first + n.count; ++i)
        for (int32_t v : tri_[size_t(order_[size_t(i)])]) {
          lo = lo.cwiseMin(x_[size_t(v)]);
          hi = hi.cwiseMax(x_[size_t(v)]);
        }
      n.lo = {below(lo.x()), below(lo.y()), below(lo.z())};
      n.hi = {above(hi.x()), above(hi.y()), above(hi.z())};
    } else {
      const Node &a = node_[k + 1], &b = node_[size_t(n.second)];
      n.lo = a.lo.cwiseMin(b.lo);
      n.hi = a.hi.cwiseMax(b.hi);
    }
  }
  fit_fours();
}

void Bvh::refit(std::span<const Vec3> x_mm) {
  assert(x_mm.size() == x_.size());
  std::copy(x_mm.begin(), x_mm.end(), x_.begin());
  fit();
}

void Bvh::refit(std::span<const Vec3f> x_mm) {
  assert(x_mm.size() == x_.size());
  for (size_t i = 0; i < x_.size(); ++i) x_[i] = x_mm[i].cast<double>();
  fit();
}

bool Bvh::triangle_meets(int32_t t, const Vec3& lo, const Vec3& hi) const {
  const Tri& c = tri_[size_t(t)];
  const Vec3 &a = x_[size_t(c[0])], &b = x_[size_t(c[1])], &d = x_[size_t(c[2])];
  for (int k = 0; k < 3; ++k)
    if (std::max({a[k], b[k], d[k]}) < lo[k] || std::min({a[k], b[k], d[k]}) > hi[k]) return false;
  return true;
}

Bvh::Closest Bvh::closest(const Vec3& p, double max_distance_mm) const {
  Closest best;
  if (node_.empty()) return best;
  double best2 = max_distance_mm * max_distance_mm;
  const auto look_at = [&](int32_t t) {
    const Tri& c = tri_[size_t(t)];
    const TrianglePoint q = closest_on_triangle(p, x_[size_t(c[0])], x_[size_t(c[1])], x_[size_t(c[2])]);
    const double d2 = (q.point - p).squaredNorm();
    if (d2 < best2 || (d2 == best2 && (best.triangle < 0 || t < best.triangle))) {
      best2 = d2;
      best.triangle = t;
      best.point_mm = q.point;
      best.bary = q.bary;
    }
  };
  const FourOf at(p);
  struct Item {
    int32_t child;
    float d2;
  } stack[kStack];
  int n = 0;
  stack[n++] = {0, 0};
  while (n > 0) {
    const Item it = stack[--n];
    if (double(it.d2) > best2) continue;
    if (it.child < 0) {
      look_at(~it.child);
      continue;
    }
    const Four& f = four_[size_t(it.child)];
    const v4 d2 = distances2(f.lo, f.hi, at);
    const int first = n;
    for (int k = 0; k < f.count; ++k) {  // the nearest one is looked at first
      if (double(d2[k]) > best2) continue;
      int to = n++;
      for (; to > first && stack[to - 1].d2 < d2[k]; --to) stack[to] = stack[to - 1];
      stack[to] = {f.child[size_t(k)], d2[k]};
    }
  }
  if (best.triangle >= 0) best.distance_mm = std::sqrt(best2);
  return best;
}

// Watertight line-triangle test: the triangle is sheared so that the line becomes the axis of largest direction, then
// the three edge functions decide. A neighbour computes exactly the negative value for a shared edge, so a line can
// never slip through between two triangles.
template <class Visit>
void Bvh::walk_line(const Vec3& o, const Vec3& d, double t0, double t1, Visit&& visit) const {
  if (node_.empty() || !(d.squaredNorm() > 0) || !o.allFinite() || !d.allFinite()) return;
  int kz = 0;
  d.cwiseAbs().maxCoeff(&kz);
  const int kx = (kz + 1) % 3, ky = (kz + 2) % 3;
  const double sx = d[kx] / d[kz], sy = d[ky] / d[kz], sz = 1 / d[kz];
  // A sheared coordinate errs by a few ulps of the coordinates; boxes grow by that much so that none is missed.
  const Vec3f &root_lo = node_[0].lo, &root_hi = node_[0].hi;
  const double slack =
      1e-12 * (o.cwiseAbs().maxCoeff() + double(root_lo.cwiseAbs().maxCoeff()) + double(root_hi.cwiseAbs().maxCoeff()));
  int32_t stack[kStack];
  int n = 0;
  stack[n++] = 0;
  while (n > 0) {
    const Node& node = node_[size_t(stack[--n])];
    double a = t0, b = t1;
    bool miss = false;
    for (int k = 0; k < 3 && !miss; ++k) {
      const double lo = double(node.lo[k]) - slack - o[k], hi = double(node.hi[k]) + slack - o[k];
      if (d[k] == 0) {
        miss = lo > 0 || hi < 0;
      } else {
        const double u = lo / d[k], v = hi / d[k];
        a = std::max(a, std::min(u, v) - 1e-9 * std::abs(u));
        b = std::min(b, std::max(u, v) + 1e-9 * std::abs(v));
      }
    }
    if (miss || a > b) continue;
    if (node.count == 0) {
      stack[n++] = node.second;
      stack[n++] = int32_t(&node - node_.data()) + 1;
      continue;
    }
    for (int32_t i = node.first; i < node.first + node.count; ++i) {
      const int32_t t = order_[size_t(i)];
      std::array<Vec3, 3> p;
      for (int c = 0; c < 3; ++c) {
        const Vec3 q = x_[size_t(tri_[size_t(t)][size_t(c)])] - o;
        p[size_t(c)] = {q[kx] - sx * q[kz], q[ky] - sy * q[kz], sz * q[kz]};
      }
      const double u = p[2].x() * p[1].y() - p[2].y() * p[1].x();
      const double v = p[0].x() * p[2].y() - p[0].y() * p[2].x();
      const double w = p[1].x() * p[0].y() - p[1].y() * p[0].x();
      if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) continue;
      const double det = u + v + w;
      if (det == 0) continue;
      const double t_hit = (u * p[0].z() + v * p[1].z() + w * p[2].z()) / det;
      if (!(t_hit >= t0 && t_hit <= t1)) continue;
      // The edge functions are taken clockwise, in axes that keep handedness when d[kz] > 0.
      visit(LineHit{t_hit, t, {u / det, v / det, w / det}, (det > 0) == (d[kz] > 0)});
    }
  }
}

namespace {
bool earlier(const Bvh::LineHit& a, const Bvh::LineHit& b) {
  return std::pair(a.t, a.triangle) < std::pair(b.t, b.triangle);
}
}  // namespace

int Bvh::line(const Vec3& o, const Vec3& d, double t0, double t1, std::span<LineHit> out) const {
  int count = 0;
  size_t kept = 0;
  walk_line(o, d, t0, t1, [&](const LineHit& h) {
    ++count;
    if (kept == out.size() && (kept == 0 || !earlier(h, out[kept - 1]))) return;
    size_t i = kept < out.size() ? kept++ : kept - 1;
    for (; i > 0 && earlier(h, out[i - 1]); --i) out[i] = out[i - 1];
    out[i] = h;
  });
  return count;
}

std::vector<Bvh::LineHit> Bvh::line(const Vec3& o, const Vec3& d, double t0, double t1) const {
  std::vector<LineHit> hits;
  walk_line(o, d, t0, t1, [&](const LineHit& h) { hits.push_back(h); });
  std::sort(hits.begin(), hits.end(), earlier);
  return hits;
}

}  // namespace limberg
