#include "sim/skull/bone/section.h"

#include <algorithm>
#include <array>

#include "sim/geometry/bvh.h"

namespace limberg::bone {
namespace {

using simplex::Mesh;

double volume6(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return (b - a).cross(c - a).dot(d - a); }

/// A line against an edge of the ribbon, with the same answer turned round for the triangle on the other side.
bool passes(const Vec3& u, const Vec3& v, const std::vector<Vec3>& X, int32_t a, int32_t b) {
  return a < b ? volume6(u, v, X[size_t(a)], X[size_t(b)]) >= 0 : !(volume6(u, v, X[size_t(b)], X[size_t(a)]) >= 0);
}

}  // namespace

void Section::turn(int32_t v) {
  bool was_left = false;
  for (int32_t k = 0; k < 3; ++k) was_left |= share_[size_t(3 * v + k)] >= 0;
  constexpr double kBeside = 0.02;
  for (int32_t k = 0; k < 3; ++k) {
    const int32_t h = 3 * v + k, g = m_.twin(h);
    if (crossed(h))
      share_[size_t(h)] = share_[size_t(g)] = -1;
    else if (was_left)
      share_[size_t(g)] = 1 - kBeside;  // v lies on the right now
    else
      share_[size_t(h)] = kBeside;
  }
}

int Section::mend() {
  int turned = 0;
  for (int pass = 0; pass < 8; ++pass) {
    bool any = false;
    for (int32_t f = 0; f < m_.face_slots(); ++f) {
      if (!m_.alive_face(f)) continue;
      int n = 0;
      m_.around(f, [&](int32_t h) { n += crossed(h); });
      if (n <= 2) continue;
      // The vertex between two crossed edges of this face whose crossings lie nearest to it.
      int32_t best = -1;
      double least = 0;
      m_.around(f, [&](int32_t h) {
        const int32_t g = m_.next(h), v = m_.to(h);
        if (!crossed(h) || !crossed(g) || (m_.flags[size_t(v)] & (simplex::kLocked | simplex::kOnContour))) return;
        const auto from_v = [&](int32_t e, int32_t back) {  // e leaves v
          const double s = share_[size_t(e)] >= 0 ? share_[size_t(e)] : 1 - share_[size_t(back)];
          return s * (m_.x_mm[size_t(m_.to(e))] - m_.x_mm[size_t(v)]).norm();
        };
        const double far = std::max(from_v(g, m_.twin(g)), from_v(m_.twin(h), h));
        if (best < 0 || far < least) best = v, least = far;
      });
      if (best < 0) continue;
      turn(best);
      ++turned, any = true;
    }
    if (!any) break;
  }
  return turned;
}

std::vector<double> Section::one_sided() const {
  std::vector<double> share = share_;
  std::vector<uint8_t> done(share_.size(), 0);
  std::vector<int32_t> walk;  // half-edges, each from the left of the walk to its right
  for (int32_t h0 = 0; h0 < int32_t(share_.size()); ++h0) {
    if (share_[size_t(h0)] < 0 || done[size_t(h0)]) continue;
    walk.clear();
    int as_said = 0;
    for (int32_t h = h0; !done[size_t(h)];) {
      done[size_t(h)] = done[size_t(m_.twin(h))] = 1;
      walk.push_back(h);
      as_said += share_[size_t(h)] >= 0 ? 1 : -1;
      int32_t e = m_.next(h);
      while (e != h && !crossed(e)) e = m_.next(e);
      if (e == h) break;  // nothing to go on to: open, whatever its sides
      h = m_.twin(e);
    }
    if (as_said == int(walk.size()) || -as_said == int(walk.size())) continue;
    for (int32_t h : walk) {
      const int32_t g = m_.twin(h);
      const double from_h = share[size_t(h)] >= 0 ? share[size_t(h)] : 1 - share[size_t(g)];
      share[size_t(h)] = as_said >= 0 ? from_h : -1, share[size_t(g)] = as_said >= 0 ? -1 : 1 - from_h;
    }
  }
  return share;
}

Section::Curves Section::curves() const {
  Curves out;
  const std::vector<double> share = one_sided();
  std::vector<uint8_t> done(share.size(), 0);
  for (int32_t h0 = 0; h0 < int32_t(share.size()); ++h0) {
    if (share[size_t(h0)] < 0 || done[size_t(h0)]) continue;
    std::vector<simplex::Crossing> curve;
    bool open = false, end = false;
    for (int32_t h = h0; !done[size_t(h)];) {
      done[size_t(h)] = 1;
      curve.push_back({m_.from(h), m_.to(h), share[size_t(h)]});
      end |= is_end(m_.kind(m_.face(h)));
      int32_t e = m_.next(h);
      while (e != h && !crossed(e)) e = m_.next(e);
      const int32_t ahead = m_.twin(e);
      if (e == h || share[size_t(ahead)] < 0) {  // nothing to go on to, or from right to right
        open = true;
        break;
      }
      h = ahead;
      if (done[size_t(h)] && h != h0) open = true;
    }
    if (open)
      ++out.open;
    else if (end)
      ++out.over_ends;
    else
      out.closed.push_back(std::move(curve));
  }
  return out;
}

Section section_of_plane(const Mesh& m, std::span<const uint8_t> in, const Vec3& point, const Vec3& normal) {
  Section out(m);
  const Vec3 n = normal.normalized();
  std::vector<double> s(m.nbr.size(), 0);
  for (int32_t v = 0; v < m.slots(); ++v) s[size_t(v)] = n.dot(m.x_mm[size_t(v)] - point);
  for (int32_t v = 0; v < m.slots(); ++v) {
    if (!m.alive(v) || !in[size_t(v)] || !(s[size_t(v)] >= 0)) continue;
    for (int32_t k = 0; k < 3; ++k)
      if (const double t = s[size_t(m.nbr[size_t(v)][size_t(k)])]; t < 0)
        out.cross(3 * v + k, s[size_t(v)] / (s[size_t(v)] - t));
  }
  return out;
}

Section section_of_ribbon(const Mesh& m, std::span<const uint8_t> in, const std::vector<Vec3>& X,
                          const std::vector<Tri>& tri) {
  Section out(m);
  const Bvh bvh(X, tri);
  struct Hit {
    double t;
    bool from_left;
  };
  std::vector<Hit> hits;
  for (int32_t u = 0; u < m.slots(); ++u) {
    if (!m.alive(u) || !in[size_t(u)]) continue;
    for (int32_t k = 0; k < 3; ++k) {
      const int32_t v = m.nbr[size_t(u)][size_t(k)];
      if (v < u) continue;
      const Vec3 &p = m.x_mm[size_t(u)], &q = m.x_mm[size_t(v)];
      hits.clear();
      bvh.box(p.cwiseMin(q), p.cwiseMax(q), [&](int32_t t) {
        const Vec3 &a = X[size_t(tri[size_t(t)][0])], &b = X[size_t(tri[size_t(t)][1])],
                   &c = X[size_t(tri[size_t(t)][2])];
        const double dp = volume6(a, b, c, p), dq = volume6(a, b, c, q);
        if ((dp >= 0) == (dq >= 0)) return;
        const Tri& i = tri[size_t(t)];
        const bool e0 = passes(p, q, X, i[0], i[1]);
        if (passes(p, q, X, i[1], i[2]) != e0 || passes(p, q, X, i[2], i[0]) != e0) return;
        hits.push_back({dp / (dp - dq), dp >= 0});
      });
      if (hits.size() % 2 == 0) continue;
      std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.t < b.t; });
      const double t = std::clamp(hits[hits.size() / 2].t, 0., 1.);
      const int32_t h = 3 * u + k;
      if (hits[0].from_left)
        out.cross(h, t);
      else
        out.cross(m.twin(h), 1 - t);
    }
  }
  return out;
}

}  // namespace limberg::bone
