// The operators that change the topology of the surface: t3, t4 and their variants across edges.
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/skull/simplex/operators.h"

namespace limberg::simplex {
namespace {

using Ring = std::vector<int32_t>;

bool has_duplicate(Ring v) {
  std::sort(v.begin(), v.end());
  return std::adjacent_find(v.begin(), v.end()) != v.end();
}

Answer kept(const Mesh& m, int32_t v) {
  if (m.flags[size_t(v)] & kLocked) return Answer::locked;
  if (m.flags[size_t(v)] & kOnContour) return Answer::on_contour;
  return Answer::done;
}

bool connected(const Mesh& m, int32_t a, int32_t b) {
  std::vector<uint8_t> seen(m.nbr.size(), 0);
  Ring stack{a};
  seen[size_t(a)] = 1;
  while (!stack.empty()) {
    const int32_t v = stack.back();
    stack.pop_back();
    if (v == b) return true;
    for (int32_t u : m.nbr[size_t(v)])
      if (!seen[size_t(u)]) seen[size_t(u)] = 1, stack.push_back(u);
  }
  return false;
}

/// Ends a cut that `d` holds: obeys the policy or takes the cut back.
OperatorResult conclude(Mesh& m, int32_t left, int32_t right, int32_t mouth_left, int32_t mouth_right, CutPolicy policy,
                        Delta& d, Delta& delta) {
  OperatorResult o;
  o.divided = !connected(m, left, right);
  if (policy == CutPolicy::must_divide && !o.divided) o.answer = Answer::does_not_divide;
  if (policy == CutPolicy::must_not_divide && o.divided) o.answer = Answer::divides;
  if (!o) {
    undo(m, d);
    return o;
  }
  o.face[0] = mouth_left, o.face[1] = mouth_right;
  ++m.version;
  delta.append(std::move(d));
  return o;
}

/// Two faces that are about to be joined, each with the faces
/// around it. Rings run along the contour: x reversed, y as it is.
struct Mouths {
  Ring l, r;  // ring vertices
  Ring G, H;  // face behind l[i] - l[i + 1], and behind r[i] - r[i + 1]
};

Answer open_mouths(const Mesh& m, int32_t x, int32_t y, Mouths& o) {
  if (!m.alive_face(x) || !m.alive_face(y)) return Answer::no_such_face;
  if (x == y) return Answer::same_face;
  o.l = m.ring(x), o.r = m.ring(y);
  std::reverse(o.l.begin(), o.l.end());
  for (const Ring* ring : {&o.l, &o.r})
    for (int32_t v : *ring) {
      if (const Answer a = kept(m, v); a != Answer::done) return a;
      const Row& f = m.left[size_t(v)];
      if (std::count(f.begin(), f.end(), x) && std::count(f.begin(), f.end(), y)) return Answer::shared_vertex;
    }
  for (size_t i = 0; i < o.l.size(); ++i) o.G.push_back(m.face(m.edge(o.l[i], o.l[(i + 1) % o.l.size()])));
  for (size_t i = 0; i < o.r.size(); ++i) o.H.push_back(m.face(m.edge(o.r[(i + 1) % o.r.size()], o.r[i])));
  Ring all = o.G;
  all.insert(all.end(), o.H.begin(), o.H.end());
  if (has_duplicate(all)) return Answer::common_face;
  for (int32_t f : all)
    if (is_end(m.kind(f))) return Answer::end_face;
  return Answer::done;
}

bool share_edge(const Mesh& m, int32_t a, int32_t b) {
  bool found = false;
  m.around(a, [&](int32_t h) { found |= m.face(m.twin(h)) == b; });
  return found;
}

/// Turns ring `of` so that it begins with its first vertex in `order`; true when `order` then holds it as it is.
bool runs_through(const Ring& ring, const Ring& order) {
  if (ring.size() != order.size()) return false;
  const auto at = std::find(ring.begin(), ring.end(), order[0]);
  if (at == ring.end()) return false;
  for (size_t i = 0; i < order.size(); ++i)
    if (ring[(size_t(at - ring.begin()) + i) % ring.size()] != order[i]) return false;
  return true;
}

/// Share of the ring's length at which each vertex comes, from vertex `start` on.
std::vector<double> shares(const Mesh& m, const Ring& ring, size_t start) {
  std::vector<double> s{0};
  for (size_t i = 0; i < ring.size(); ++i)
    s.push_back(
        s.back() +
        (m.x_mm[size_t(ring[(start + i + 1) % ring.size()])] - m.x_mm[size_t(ring[(start + i) % ring.size()])]).norm());
  const double all = s.back();
  s.pop_back();
  for (size_t i = 0; i < s.size(); ++i) s[i] = all > 0 ? s[i] / all : double(i) / double(s.size());
  return s;
}

Ring interleave(const Mesh& m, const Mouths& o) {
  size_t bi = 0, bj = 0;
  double best = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < o.l.size(); ++i)
    for (size_t j = 0; j < o.r.size(); ++j)
      if (const double d = (m.x_mm[size_t(o.l[i])] - m.x_mm[size_t(o.r[j])]).squaredNorm(); d < best)
        best = d, bi = i, bj = j;
  Ring c;
  size_t i = 0, j = 0;
  if (o.l.size() == o.r.size()) {  // in turns
    for (; i < o.l.size(); ++i) c.push_back(o.l[(bi + i) % o.l.size()]), c.push_back(o.r[(bj + i) % o.r.size()]);
    return c;
  }
  const std::vector<double> s = shares(m, o.l, bi), t = shares(m, o.r, bj);
  while (i < s.size() || j < t.size()) {
    if (j == t.size() || (i < s.size() && s[i] <= t[j]))
      c.push_back(o.l[(bi + i++) % o.l.size()]);
    else
      c.push_back(o.r[(bj + j++) % o.r.size()]);
  }
  return c;
}

}  // namespace

OperatorResult t4(Mesh& m, std::span<const int32_t> c, CutPolicy policy, Delta& delta) {
  const size_t k = c.size();
  if (k < 3) return no(Answer::too_short);
  for (int32_t v : c)
    if (!m.alive(v)) return no(Answer::no_such_vertex, v);
  if (has_duplicate(Ring(c.begin(), c.end()))) return no(Answer::repeated_vertex);
  for (size_t j = 0; j < k; ++j) {
    const int32_t v = c[j], w = c[(j + 1) % k];
    if (m.slot(v, w) < 0) return no(Answer::not_a_cycle, v, w);
    if (const Answer a = kept(m, v); a != Answer::done) return no(a, v);
    if (is_end(m.kind(m.face(m.edge(v, w)))) || is_end(m.kind(m.face(m.edge(w, v))))) return no(Answer::end_face, v, w);
  }
  // Which side each spoke leaves on, and the faces that run along the contour.
  Ring l, r, G, H, all;
  std::vector<size_t> at_l, at_r;
  for (size_t j = 0; j < k; ++j) {
    const int32_t before = c[(j + k - 1) % k], v = c[j], after = c[(j + 1) % k];
    const bool left = m.nbr[size_t(v)][size_t(m.slot(v, before) + 2) % 3] != after;
    if (left)
      l.push_back(v), at_l.push_back(j), G.push_back(m.face(m.edge(v, after)));
    else
      r.push_back(v), at_r.push_back(j), H.push_back(m.face(m.edge(after, v)));
  }
  if (l.size() < 3) return no(Answer::too_few_left);
  if (r.size() < 3) return no(Answer::too_few_right);
  all = G;
  all.insert(all.end(), H.begin(), H.end());
  if (has_duplicate(all)) return no(Answer::touches_face_twice);
  for (const bool side : {true, false}) {
    const Ring &ring = side ? l : r, &face = side ? G : H;
    const std::vector<size_t>& at = side ? at_l : at_r;
    for (size_t i = 0; i < ring.size(); ++i) {
      const size_t n = (i + 1) % ring.size(), step = (at[n] + k - at[i]) % k;
      if (m.face_size[size_t(face[i])] - int32_t(step) + 1 < 3) return no(Answer::face_too_small, ring[i], ring[n]);
      if (step > 1 && m.slot(ring[i], ring[n]) >= 0) return no(Answer::already_neighbours, ring[i], ring[n]);
    }
  }
  Delta d;
  Edit e(m, d);
  for (const bool side : {true, false}) {
    const Ring& ring = side ? l : r;
    const std::vector<size_t>& at = side ? at_l : at_r;
    std::vector<Row> fresh;
    for (size_t i = 0; i < ring.size(); ++i) {
      const int32_t v = ring[i];
      Row row = m.nbr[size_t(v)];
      const size_t before = size_t(m.slot(v, c[(at[i] + k - 1) % k])), after = size_t(m.slot(v, c[(at[i] + 1) % k]));
      row[before] = ring[(i + ring.size() - 1) % ring.size()], row[after] = ring[(i + 1) % ring.size()];
      fresh.push_back(row);
    }
    for (size_t i = 0; i < ring.size(); ++i) e.save_vertex(ring[i]), m.nbr[size_t(ring[i])] = fresh[i];
  }
  const int32_t x = e.add_face(FaceKind::cut), y = e.add_face(FaceKind::cut);
  for (size_t i = 0; i < l.size(); ++i) e.mark_face(G[i], m.edge(l[i], l[(i + 1) % l.size()]));
  for (size_t i = 0; i < r.size(); ++i) e.mark_face(H[i], m.edge(r[(i + 1) % r.size()], r[i]));
  e.mark_face(x, m.edge(l[1], l[0])), e.mark_face(y, m.edge(r[0], r[1]));
  for (int32_t v : c) e.reshape(v);
  return conclude(m, l[0], r[0], x, y, policy, d, delta);
}

OperatorResult t3(Mesh& m, int32_t x, int32_t y, Delta& delta) {
  Mouths o;
  if (const Answer a = open_mouths(m, x, y, o); a != Answer::done) return no(a);
  return t3(m, x, y, interleave(m, o), delta);
}

OperatorResult t3(Mesh& m, int32_t x, int32_t y, std::span<const int32_t> c, Delta& delta) {
  Mouths o;
  if (const Answer a = open_mouths(m, x, y, o); a != Answer::done) return no(a);
  const size_t k = c.size();
  Ring l, r, face(k);  // face[j]: of c[j] - c[j + 1] on the side of c[j]
  std::vector<uint8_t> left(k);
  for (size_t j = 0; j < k; ++j) {
    if (!m.alive(c[j])) return no(Answer::no_such_vertex, c[j]);
    const auto at_l = std::find(o.l.begin(), o.l.end(), c[j]), at_r = std::find(o.r.begin(), o.r.end(), c[j]);
    left[j] = at_l != o.l.end();
    if (left[j])
      l.push_back(c[j]), face[j] = o.G[size_t(at_l - o.l.begin())];
    else if (at_r != o.r.end())
      r.push_back(c[j]), face[j] = o.H[size_t(at_r - o.r.begin())];
    else
      return no(Answer::not_interleaved, c[j]);
  }
  if (!runs_through(o.l, l) || !runs_through(o.r, r)) return no(Answer::not_interleaved);
  // Along the contour the faces of one side meet those of the other; they may not have met before.
  int32_t now[2] = {-1, -1};
  for (size_t j = 0; j < 2 * k; ++j) {
    now[left[j % k]] = face[j % k];
    if (now[0] >= 0 && now[1] >= 0 && j >= k && share_edge(m, now[0], now[1]))
      return no(Answer::faces_meet_twice, c[j % k]);
  }
  Edit e(m, delta);
  std::vector<Row> fresh;
  for (size_t j = 0; j < k; ++j) {
    const int32_t v = c[j];
    const Ring& ring = left[j] ? o.l : o.r;
    const size_t i = size_t(std::find(ring.begin(), ring.end(), v) - ring.begin()), n = ring.size();
    Row row = m.nbr[size_t(v)];
    row[size_t(m.slot(v, ring[(i + n - 1) % n]))] = c[(j + k - 1) % k];
    row[size_t(m.slot(v, ring[(i + 1) % n]))] = c[(j + 1) % k];
    fresh.push_back(row);
  }
  for (size_t j = 0; j < k; ++j) e.save_vertex(c[j]), m.nbr[size_t(c[j])] = fresh[j];
  e.free_face(y), e.free_face(x);
  for (size_t j = 0; j < k; ++j)
    e.mark_face(face[j], left[j] ? m.edge(c[j], c[(j + 1) % k]) : m.edge(c[(j + 1) % k], c[j]));
  for (int32_t v : c) e.reshape(v);
  ++m.version;
  return {};
}

OperatorResult t4_edges(Mesh& m, std::span<const Crossing> curve, CutPolicy policy, Delta& delta) {
  const size_t n = curve.size();
  if (n < 3) return no(Answer::too_short);
  Ring face(n);
  for (size_t j = 0; j < n; ++j) {
    const auto [a, b, t] = curve[j];
    if (!m.alive(a) || !m.alive(b)) return no(Answer::no_such_vertex, a, b);
    if (m.slot(a, b) < 0 || !std::isfinite(t)) return no(Answer::no_such_edge, a, b);
    if ((m.flags[size_t(a)] & kLocked) && (m.flags[size_t(b)] & kLocked)) return no(Answer::locked, a, b);
    if ((m.flags[size_t(a)] & kOnContour) && (m.flags[size_t(b)] & kOnContour)) return no(Answer::on_contour, a, b);
    face[j] = m.face(m.edge(a, b));  // the one ahead
    if (is_end(m.kind(face[j]))) return no(Answer::end_face, a, b);
  }
  for (size_t j = 0; j < n; ++j) {
    const Crossing& next = curve[(j + 1) % n];
    if (m.face(m.edge(next.right, next.left)) != face[j]) return no(Answer::not_a_cycle, next.left, next.right);
  }
  if (has_duplicate(face)) return no(Answer::touches_face_twice);
  Delta d;
  Edit e(m, d);
  Ring s(n), t(n), other(n);
  constexpr double kInside = 1e-3;  // a crossing stays this far (of the edge) from its ends
  for (size_t j = 0; j < n; ++j) {
    const size_t a = size_t(curve[j].left), b = size_t(curve[j].right);
    const double w = std::clamp(curve[j].t, kInside, 1 - kInside);
    s[j] = e.add_vertex(curve[j].left), t[j] = e.add_vertex(curve[j].right);
    for (int32_t v : {s[j], t[j]}) {
      m.x_mm[size_t(v)] = (1 - w) * m.x_mm[a] + w * m.x_mm[b];
      m.before_mm[size_t(v)] = (1 - w) * m.before_mm[a] + w * m.before_mm[b];
    }
  }
  for (size_t j = 0; j < n; ++j) {
    const size_t before = (j + n - 1) % n, after = (j + 1) % n;
    const auto [a, b, w] = curve[j];
    m.nbr[size_t(s[j])] = {a, s[before], s[after]};
    m.nbr[size_t(t[j])] = {b, t[after], t[before]};
    e.replace_neighbour(a, b, s[j]), e.replace_neighbour(b, a, t[j]);
  }
  for (size_t j = 0; j < n; ++j) other[j] = e.add_face(m.kind(face[j]));
  const int32_t x = e.add_face(FaceKind::cut), y = e.add_face(FaceKind::cut);
  for (size_t j = 0; j < n; ++j) {
    const size_t after = (j + 1) % n;
    e.mark_face(face[j], m.edge(s[j], s[after])), e.mark_face(other[j], m.edge(t[after], t[j]));
  }
  e.mark_face(x, m.edge(s[1], s[0])), e.mark_face(y, m.edge(t[0], t[1]));
  for (size_t j = 0; j < n; ++j)
    for (int32_t v : {s[j], t[j], curve[j].left, curve[j].right}) e.reshape(v);
  return conclude(m, s[0], t[0], x, y, policy, d, delta);
}

OperatorResult t3_spokes(Mesh& m, int32_t x, int32_t y, Delta& delta, int32_t start_x, int32_t start_y) {
  Mouths o;
  if (const Answer a = open_mouths(m, x, y, o); a != Answer::done) return no(a);
  const size_t k = o.l.size();
  if (o.r.size() != k) return no(Answer::sizes_differ);
  const auto ix = std::find(o.l.begin(), o.l.end(), start_x), iy = std::find(o.r.begin(), o.r.end(), start_y);
  size_t i0 = 0, j0 = 0;
  if (start_x >= 0 || start_y >= 0) {
    if (ix == o.l.end() || iy == o.r.end()) return no(Answer::no_such_vertex, start_x, start_y);
    i0 = size_t(ix - o.l.begin()), j0 = size_t(iy - o.r.begin());
  } else {
    double best = std::numeric_limits<double>::infinity();
    for (size_t j = 0; j < k; ++j) {
      double sum = 0;
      for (size_t i = 0; i < k; ++i) sum += (m.x_mm[size_t(o.l[i])] - m.x_mm[size_t(o.r[(i + j) % k])]).squaredNorm();
      if (sum < best) best = sum, j0 = j;
    }
  }
  std::rotate(o.l.begin(), o.l.begin() + std::ptrdiff_t(i0), o.l.end()),
      std::rotate(o.G.begin(), o.G.begin() + std::ptrdiff_t(i0), o.G.end());
  std::rotate(o.r.begin(), o.r.begin() + std::ptrdiff_t(j0), o.r.end()),
      std::rotate(o.H.begin(), o.H.begin() + std::ptrdiff_t(j0), o.H.end());
  auto spoke = [&](int32_t v, const Ring& ring, size_t i) {
    for (int32_t u : m.nbr[size_t(v)])
      if (u != ring[(i + 1) % k] && u != ring[(i + k - 1) % k]) return u;
    return -1;
  };
  Ring a(k), b(k);
  std::vector<std::pair<int32_t, int32_t>> joined(k);
  for (size_t i = 0; i < k; ++i) {
    a[i] = spoke(o.l[i], o.l, i), b[i] = spoke(o.r[i], o.r, i);
    if (a[i] < 0 || b[i] < 0) return no(Answer::already_neighbours, o.l[i], o.r[i]);
    if (a[i] == b[i] || m.slot(a[i], b[i]) >= 0) return no(Answer::already_neighbours, a[i], b[i]);
    if (m.face_size[size_t(o.G[i])] + m.face_size[size_t(o.H[i])] < 7) return no(Answer::face_too_small, a[i], b[i]);
    joined[i] = std::minmax(a[i], b[i]);
  }
  std::sort(joined.begin(), joined.end());
  if (std::adjacent_find(joined.begin(), joined.end()) != joined.end()) return no(Answer::already_neighbours);
  Delta d;
  Edit e(m, d);
  for (size_t i = 0; i < k; ++i) e.replace_neighbour(a[i], o.l[i], b[i]), e.replace_neighbour(b[i], o.r[i], a[i]);
  e.free_face(y), e.free_face(x);
  for (size_t i = k; i-- > 0;) e.free_face(o.H[i]);
  for (size_t i = k; i-- > 0;) e.free_vertex(o.r[i]), e.free_vertex(o.l[i]);
  for (size_t i = 0; i < k; ++i) e.mark_face(o.G[i], m.edge(a[i], b[i]));
  // Each merged face against all it touches now.
  for (size_t i = 0; i < k; ++i) {
    Ring beside;
    m.around(o.G[i], [&](int32_t h) { beside.push_back(m.face(m.twin(h))); });
    beside.push_back(o.G[i]);
    if (beside.size() < 4 || has_duplicate(beside)) {
      const Answer why = beside.size() < 4 ? Answer::face_too_small : Answer::faces_meet_twice;
      undo(m, d);
      return no(why, a[i], b[i]);
    }
  }
  for (size_t i = 0; i < k; ++i) e.reshape(a[i]), e.reshape(b[i]);
  ++m.version;
  delta.append(std::move(d));
  return {};
}

OperatorResult remove_component(Mesh& m, int32_t v, Delta& delta) {
  if (!m.alive(v)) return no(Answer::no_such_vertex, v);
  std::vector<int32_t> of;
  components(m, of);
  Edit e(m, delta);
  const int32_t c = of[size_t(v)];
  if (std::any_of(m.contour.begin(), m.contour.end(), [&](const Ring& r) { return of[size_t(r[0])] == c; })) {
    e.save_contours();
    std::erase_if(m.contour, [&](const Ring& r) { return of[size_t(r[0])] == c; });
  }
  for (int32_t f = m.face_slots(); f-- > 0;)
    if (m.alive_face(f) && of[size_t(m.face_edge[size_t(f)] / 3)] == c) e.free_face(f);
  for (int32_t u = m.slots(); u-- > 0;)
    if (of[size_t(u)] == c) e.free_vertex(u);
  ++m.version;
  return {};
}

}  // namespace limberg::simplex
