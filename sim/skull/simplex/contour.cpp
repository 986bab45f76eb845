#include "sim/skull/simplex/contour.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "sim/base/error.h"

namespace limberg::simplex {
namespace {

/// Vertices of a shortest way from a to b, a left out; empty: there is none.
std::vector<int32_t> way(const Mesh& m, int32_t a, int32_t b) {
  std::vector<double> far(m.nbr.size(), std::numeric_limits<double>::infinity());
  std::vector<int32_t> from(m.nbr.size(), -1);
  using Item = std::pair<double, int32_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
  far[size_t(a)] = 0;
  open.push({0, a});
  while (!open.empty()) {
    const auto [d, v] = open.top();
    open.pop();
    if (d > far[size_t(v)]) continue;
    if (v == b) break;
    for (int32_t u : m.nbr[size_t(v)]) {
      const double w = d + (m.x_mm[size_t(u)] - m.x_mm[size_t(v)]).norm();
      if (w < far[size_t(u)]) far[size_t(u)] = w, from[size_t(u)] = v, open.push({w, u});
    }
  }
  std::vector<int32_t> path;
  if (from[size_t(b)] < 0) return path;
  for (int32_t v = b; v != a; v = from[size_t(v)]) path.push_back(v);
  std::reverse(path.begin(), path.end());
  return path;
}

std::string fault_of_cycle(const Mesh& m, std::span<const int32_t> c) {
  if (c.size() < 3) return sentence(Answer::too_short);
  for (size_t i = 0; i < c.size(); ++i) {
    if (!m.alive(c[i])) return sentence(Answer::no_such_vertex);
    if (m.slot(c[i], c[(i + 1) % c.size()]) < 0) return sentence(Answer::not_a_cycle);
  }
  std::vector<int32_t> sorted(c.begin(), c.end());
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return sentence(Answer::repeated_vertex);
  return "";
}

}  // namespace

ContourResult contour_through(const Mesh& m, std::span<const int32_t> picks) {
  ContourResult out;
  std::vector<int32_t> p;
  for (int32_t v : picks) {
    if (!m.alive(v)) {
      out.reason = sentence(Answer::no_such_vertex);
      return out;
    }
    if (p.empty() || p.back() != v) p.push_back(v);
  }
  while (p.size() > 1 && p.front() == p.back()) p.pop_back();
  if (p.size() < 2) {
    out.reason = "at least two different vertices are needed";
    return out;
  }
  std::vector<int32_t> c;
  for (size_t i = 0; i < p.size(); ++i) {
    const std::vector<int32_t> part = way(m, p[i], p[(i + 1) % p.size()]);
    if (part.empty()) {
      out.reason = "the picked vertices lie on different parts";
      return out;
    }
    for (int32_t v : part) {
      if (c.size() > 1 && c[c.size() - 2] == v)
        c.pop_back();  // there and back again
      else
        c.push_back(v);
    }
  }
  while (c.size() > 2 && c[1] == c.back()) c.erase(c.begin()), c.pop_back();
  while (c.size() > 2 && c[0] == c[c.size() - 2]) c.pop_back(), c.pop_back();
  out.reason = fault_of_cycle(m, c);
  if (out) out.contour = std::move(c);
  return out;
}

ContourResult contour_of_faces(const Mesh& m, std::span<const int32_t> faces) {
  ContourResult out;
  std::vector<uint8_t> in(m.face_edge.size(), 0);
  for (int32_t f : faces) {
    if (!m.alive_face(f)) {
      out.reason = sentence(Answer::no_such_face);
      return out;
    }
    in[size_t(f)] = 1;
  }
  int32_t first = -1;
  size_t edges = 0;
  for (int32_t f = 0; f < m.face_slots(); ++f)
    if (in[size_t(f)])
      m.around(f, [&](int32_t h) {
        if (in[size_t(m.face(m.twin(h)))]) return;
        ++edges;
        if (first < 0) first = h;
      });
  if (first < 0) {
    out.reason = "the region is a whole part or nothing; it has no border";
    return out;
  }
  // Region on the left: at the end of a border edge, the next border edge is the first, from the region's face on,
  // whose other side lies outside.
  int32_t h = first;
  do {
    out.contour.push_back(m.from(h));
    h = m.next(h);
    while (in[size_t(m.face(m.twin(h)))]) h = m.next(m.twin(h));
  } while (h != first && out.contour.size() <= edges);
  if (out.contour.size() != edges)
    out.reason = "the region has more than one border";
  else
    out.reason = fault_of_cycle(m, out.contour);
  if (!out) out.contour.clear();
  return out;
}

PlaneCurves curves_of_plane(const Mesh& m, const Vec3& point, const Vec3& normal) {
  if (!point.allFinite() || !normal.allFinite() || !(normal.norm() > 0))
    throw InputError("", 0, "a plane needs a finite point and a finite normal that is not zero");
  PlaneCurves out;
  std::vector<double> s(m.nbr.size());
  const Vec3 n = normal.normalized();
  for (int32_t v = 0; v < m.slots(); ++v) s[size_t(v)] = n.dot(m.x_mm[size_t(v)] - point);
  const auto above = [&](int32_t v) { return s[size_t(v)] >= 0; };
  std::vector<uint8_t> done(m.nbr.size() * 3, 0);
  for (int32_t v = 0; v < m.slots(); ++v) {
    if (!m.alive(v) || !above(v)) continue;
    for (int32_t k = 0; k < 3; ++k) {
      // A crossed edge, from above (left) to below (right); the face on its left is ahead.
      int32_t h = 3 * v + k;
      if (done[size_t(h)] || above(m.to(h))) continue;
      std::vector<Crossing> curve;
      bool open = false;
      do {
        done[size_t(h)] = 1;
        const int32_t a = m.from(h), b = m.to(h);
        curve.push_back({a, b, s[size_t(a)] / (s[size_t(a)] - s[size_t(b)])});
        open |= is_end(m.kind(m.face(h)));
        int32_t e = m.next(h);
        while (!above(m.to(e))) e = m.next(e);  // the first edge of that face that comes up again
        h = m.twin(e);
      } while (!done[size_t(h)]);
      if (open)
        ++out.open;
      else
        out.curve.push_back(std::move(curve));
    }
  }
  return out;
}

std::string keep_contour(Mesh& m, std::span<const int32_t> c) {
  if (std::string bad = fault_of_cycle(m, c); !bad.empty()) return bad;
  for (int32_t v : c)
    if (m.flags[size_t(v)] & kOnContour) return "it meets another contour";
  for (int32_t v : c) m.flags[size_t(v)] |= kOnContour;
  m.contour.emplace_back(c.begin(), c.end());
  return "";
}

void release_contour(Mesh& m, size_t index) {
  if (index >= m.contour.size()) throw InputError("", 0, "there is no contour " + std::to_string(index));
  for (int32_t v : m.contour[index]) m.flags[size_t(v)] &= uint8_t(~kOnContour);
  m.contour.erase(m.contour.begin() + std::ptrdiff_t(index));
}

int32_t fill_zone(Mesh& m, int32_t v, uint16_t zone) {
  if (!m.alive(v)) throw InputError("", 0, "there is no vertex " + std::to_string(v));
  if (m.flags[size_t(v)] & kOnContour) return 0;
  ++m.version;
  std::vector<uint8_t> seen(m.nbr.size(), 0);
  std::vector<int32_t> stack{v};
  seen[size_t(v)] = 1;
  int32_t n = 0;
  while (!stack.empty()) {
    const int32_t u = stack.back();
    stack.pop_back();
    m.zone[size_t(u)] = zone, ++n;
    for (int32_t w : m.nbr[size_t(u)])
      if (!seen[size_t(w)] && !(m.flags[size_t(w)] & kOnContour)) seen[size_t(w)] = 1, stack.push_back(w);
  }
  return n;
}

std::vector<EndContour> end_contours(const Mesh& m) {
  std::vector<EndContour> all;
  for (int32_t f = 0; f < m.face_slots(); ++f)
    if (m.alive_face(f) && is_end(m.kind(f))) all.push_back({f, m.kind(f), m.ring(f)});
  for (EndContour& c : all) std::rotate(c.rim.begin(), std::min_element(c.rim.begin(), c.rim.end()), c.rim.end());
  std::sort(all.begin(), all.end(), [](const EndContour& a, const EndContour& b) {
    return a.rim[0] != b.rim[0] ? a.rim[0] < b.rim[0] : a.rim[1] < b.rim[1];
  });
  return all;
}

OperatorResult open_hole(Mesh& m, std::span<const int32_t> faces, Delta& delta) {
  const ContourResult border = contour_of_faces(m, faces);
  if (!border) {
    OperatorResult o;
    o.answer = Answer::not_a_cycle;
    return o;
  }
  Delta d;
  OperatorResult o = t4(m, border.contour, CutPolicy::must_divide, d);
  if (!o) return o;
  const int32_t hole = o.face[1], piece = m.from(m.face_edge[size_t(o.face[0])]);
  remove_component(m, piece, d);
  Edit e(m, d);
  e.save_face(hole);
  m.face_kind[size_t(hole)] = FaceKind::hole;
  delta.append(std::move(d));
  OperatorResult done;
  done.face[0] = hole, done.divided = true;
  return done;
}

}  // namespace limberg::simplex
