#include "sim/skull/simplex/mesh.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/hash.h"

namespace limberg::simplex {
namespace {

std::string name(int32_t v) { return std::to_string(v); }

/// Rows alone: numbers in range, mutual, distinct.
std::optional<std::string> fault_of_rows(const std::vector<Row>& nbr) {
  const int32_t n = int32_t(nbr.size());
  for (int32_t v = 0; v < n; ++v) {
    const Row& r = nbr[size_t(v)];
    if (r == Row{-1, -1, -1}) continue;
    for (size_t k = 0; k < 3; ++k) {
      if (r[k] < 0 || r[k] >= n)
        return "vertex " + name(v) + " names the neighbour " + name(r[k]) + ", which does not exist";
      if (r[k] == v) return "vertex " + name(v) + " is its own neighbour";
      if (r[k] == r[(k + 1) % 3]) return "vertex " + name(v) + " has the neighbour " + name(r[k]) + " twice";
    }
  }
  for (int32_t v = 0; v < n; ++v) {
    const Row& r = nbr[size_t(v)];
    for (size_t k = 0; k < 3 && r[0] >= 0; ++k) {
      const Row& q = nbr[size_t(r[k])];
      if (q[0] != v && q[1] != v && q[2] != v)
        return "vertex " + name(v) + " has the neighbour " + name(r[k]) + ", which does not have it in turn";
    }
  }
  return std::nullopt;
}

void resize_vertices(Mesh& m, size_t n) {
  m.nbr.resize(n, Row{-1, -1, -1}), m.left.resize(n, Row{-1, -1, -1});
  m.x_mm.resize(n, Vec3::Zero()), m.before_mm.resize(n, Vec3::Zero());
  m.shape.resize(n), m.metric.resize(n, {1. / 3, 1. / 3});
  m.zone.resize(n, 0), m.flags.resize(n, 0);
}

/// Walks all faces of live vertices; sizes and edges; kinds are left alone where a face exists already.
void walk_faces(Mesh& m) {
  for (Row& r : m.left) r = Row{-1, -1, -1};
  m.face_edge.clear(), m.face_size.clear(), m.face_kind.clear(), m.free_face.clear();
  for (int32_t v = 0; v < m.slots(); ++v) {
    if (!m.alive(v)) continue;
    for (int32_t k = 0; k < 3; ++k) {
      if (m.left[size_t(v)][size_t(k)] >= 0) continue;
      const int32_t f = m.face_slots(), h0 = 3 * v + k;
      int32_t h = h0, size = 0;
      do {
        m.left[size_t(h / 3)][size_t(h % 3)] = f;
        ++size;
        h = m.next(h);
      } while (h != h0);
      m.face_edge.push_back(h0), m.face_size.push_back(size), m.face_kind.push_back(FaceKind::surface);
    }
  }
}

}  // namespace

std::vector<int32_t> Mesh::ring(int32_t f) const {
  std::vector<int32_t> v;
  around(f, [&](int32_t h) { v.push_back(from(h)); });
  return v;
}

Mesh make_mesh(std::vector<Row> nbr, std::vector<Vec3> x_mm) {
  if (nbr.size() != x_mm.size())
    throw InputError("", 0, "a simplex mesh needs one position for every row of neighbours");
  if (nbr.size() > size_t(INT32_MAX / 3)) throw InputError("", 0, "a simplex mesh holds at most 715 million vertices");
  if (const auto bad = fault_of_rows(nbr)) throw InputError("", 0, *bad);
  Mesh m;
  m.nbr = std::move(nbr), m.x_mm = std::move(x_mm);
  m.before_mm = m.x_mm;
  resize_vertices(m, m.nbr.size());
  for (int32_t v = 0; v < m.slots(); ++v)
    if (!m.alive(v)) m.free_vertex.push_back(v);
  walk_faces(m);
  if (const auto bad = find_fault(m)) throw InputError("", 0, *bad);
  record_shape(m);
  return m;
}

std::optional<std::string> find_fault(const Mesh& m) {
  const size_t n = m.nbr.size();
  if (m.left.size() != n || m.x_mm.size() != n || m.before_mm.size() != n || m.shape.size() != n ||
      m.metric.size() != n || m.zone.size() != n || m.flags.size() != n)
    return "the arrays of the vertices differ in length";
  if (m.face_size.size() != m.face_edge.size() || m.face_kind.size() != m.face_edge.size())
    return "the arrays of the faces differ in length";
  if (auto bad = fault_of_rows(m.nbr)) return bad;
  size_t dead = 0;
  for (int32_t v = 0; v < m.slots(); ++v) {
    dead += !m.alive(v);
    if (!m.x_mm[size_t(v)].allFinite() || !m.before_mm[size_t(v)].allFinite())
      return "vertex " + name(v) + " is not at a finite place";
  }
  if (dead != m.free_vertex.size()) return "the list of free vertices does not match the rows";
  for (int32_t v : m.free_vertex)
    if (v < 0 || v >= m.slots() || m.alive(v))
      return "the list of free vertices names " + name(v) + ", which is in use";
  std::vector<int32_t> beside(m.face_edge.size(), -1);
  int64_t walked = 0;
  dead = 0;
  for (int32_t f = 0; f < m.face_slots(); ++f) {
    const int32_t h0 = m.face_edge[size_t(f)];
    if (h0 < 0) {
      ++dead;
      continue;
    }
    if (h0 >= 3 * m.slots() || !m.alive(h0 / 3)) return "face " + name(f) + " begins at a vertex that does not exist";
    int32_t h = h0, size = 0;
    do {
      if (m.face(h) != f)
        return "face " + name(f) + " passes from vertex " + name(m.from(h)) + " to " + name(m.to(h)) +
               ", which is marked as face " + name(m.face(h));
      const int32_t g = m.face(m.twin(h));
      if (g < 0 || g >= m.face_slots())
        return "the half-edge from " + name(m.to(h)) + " to " + name(m.from(h)) + " has no face";
      if (g == f)
        return "face " + name(f) + " lies on both sides of the edge " + name(m.from(h)) + " - " + name(m.to(h));
      if (beside[size_t(g)] == f) return "faces " + name(f) + " and " + name(g) + " share more than one edge";
      beside[size_t(g)] = f;
      if (++size > m.face_size[size_t(f)])
        return "face " + name(f) + " is longer than the " + name(m.face_size[size_t(f)]) +
               " vertices it is said to have";
      h = m.next(h);
    } while (h != h0);
    if (size != m.face_size[size_t(f)])
      return "face " + name(f) + " has " + name(size) + " vertices; it is said to have " + name(m.face_size[size_t(f)]);
    if (size < 3) return "face " + name(f) + " has only " + name(size) + " vertices";
    walked += size;
  }
  if (dead != m.free_face.size()) return "the list of free faces does not match the faces";
  for (int32_t f : m.free_face)
    if (f < 0 || f >= m.face_slots() || m.alive_face(f))
      return "the list of free faces names " + name(f) + ", which is in use";
  if (walked != 3 * int64_t(m.vertices())) return "some edges belong to no face";
  std::vector<uint8_t> on(n, 0);
  for (const auto& c : m.contour)
    for (size_t i = 0; i < c.size(); ++i) {
      if (!m.alive(c[i])) return "a contour names vertex " + name(c[i]) + ", which does not exist";
      if (on[size_t(c[i])]++) return "vertex " + name(c[i]) + " is on two contours, or twice on one";
      if (m.slot(c[i], c[(i + 1) % c.size()]) < 0)
        return "a contour goes from vertex " + name(c[i]) + " to one that is not its neighbour";
    }
  for (int32_t v = 0; v < m.slots(); ++v)
    if (m.alive(v) && bool(m.flags[size_t(v)] & kOnContour) != bool(on[size_t(v)]))
      return "the contour mark of vertex " + name(v) + " is wrong";
  return std::nullopt;
}

int32_t components(const Mesh& m, std::vector<int32_t>& of) {
  of.assign(m.nbr.size(), -1);
  std::vector<int32_t> stack;
  int32_t count = 0;
  for (int32_t s = 0; s < m.slots(); ++s) {
    if (!m.alive(s) || of[size_t(s)] >= 0) continue;
    stack.push_back(s);
    of[size_t(s)] = count;
    while (!stack.empty()) {
      const int32_t v = stack.back();
      stack.pop_back();
      for (int32_t u : m.nbr[size_t(v)])
        if (of[size_t(u)] < 0) of[size_t(u)] = count, stack.push_back(u);
    }
    ++count;
  }
  return count;
}

Census census(const Mesh& m) {
  Census c;
  c.vertices = m.vertices(), c.edges = 3 * c.vertices / 2, c.faces = m.faces();
  for (int32_t f = 0; f < m.face_slots(); ++f) c.end_contours += m.alive_face(f) && is_end(m.kind(f));
  std::vector<int32_t> of;
  c.components = components(m, of);
  c.chi = c.vertices - c.edges + c.faces;
  c.genus = (2 * c.components - c.chi) / 2;
  return c;
}

std::vector<int32_t> compact(Mesh& m, bool by_nearness) {
  std::vector<int32_t> order;
  order.reserve(size_t(m.vertices()));
  std::vector<int32_t> renamed(m.nbr.size(), -1);
  for (int32_t s = 0; s < m.slots(); ++s) {
    if (!m.alive(s) || renamed[size_t(s)] >= 0) continue;
    size_t at = order.size();
    renamed[size_t(s)] = int32_t(at), order.push_back(s);
    for (; by_nearness && at < order.size(); ++at)
      for (int32_t u : m.nbr[size_t(order[at])])
        if (renamed[size_t(u)] < 0) renamed[size_t(u)] = int32_t(order.size()), order.push_back(u);
  }
  Mesh out;
  resize_vertices(out, order.size());
  std::vector<int32_t> face(m.face_edge.size(), -1);
  for (int32_t f = 0; f < m.face_slots(); ++f) {
    if (!m.alive_face(f)) continue;
    face[size_t(f)] = out.face_slots();
    const int32_t h = m.face_edge[size_t(f)];
    out.face_edge.push_back(3 * renamed[size_t(h / 3)] + h % 3);
    out.face_size.push_back(m.face_size[size_t(f)]), out.face_kind.push_back(m.face_kind[size_t(f)]);
  }
  for (size_t i = 0; i < order.size(); ++i) {
    const size_t v = size_t(order[i]);
    for (size_t k = 0; k < 3; ++k)
      out.nbr[i][k] = renamed[size_t(m.nbr[v][k])], out.left[i][k] = face[size_t(m.left[v][k])];
    out.x_mm[i] = m.x_mm[v], out.before_mm[i] = m.before_mm[v], out.shape[i] = m.shape[v], out.metric[i] = m.metric[v];
    out.zone[i] = m.zone[v], out.flags[i] = m.flags[v];
  }
  out.contour = std::move(m.contour);
  for (auto& c : out.contour)
    for (int32_t& v : c) v = renamed[size_t(v)];
  out.axes = m.axes;
  out.version = m.version + 1;
  m = std::move(out);
  return renamed;
}

void turn_to_head(Mesh& m) {
  if (m.axes == Axes::left_posterior_superior)
    for (std::vector<Vec3>* places : {&m.x_mm, &m.before_mm})
      for (Vec3& x : *places) x = Vec3(-x.x(), -x.y(), x.z());
  m.axes = Axes::right_forwards_up;
}

Mesh extract_component(const Mesh& m, int32_t v, std::vector<int32_t>* old_vertex) {
  if (!m.alive(v)) throw InputError("", 0, "there is no vertex " + name(v));
  std::vector<int32_t> of;
  components(m, of);
  Mesh out = m;
  for (int32_t u = 0; u < m.slots(); ++u)
    if (m.alive(u) && of[size_t(u)] != of[size_t(v)]) {
      for (int32_t f : m.left[size_t(u)])
        if (out.face_edge[size_t(f)] >= 0) out.face_edge[size_t(f)] = -1, out.free_face.push_back(f);
      out.nbr[size_t(u)] = out.left[size_t(u)] = Row{-1, -1, -1};
      out.free_vertex.push_back(u);
    }
  std::erase_if(out.contour, [&](const std::vector<int32_t>& c) { return of[size_t(c[0])] != of[size_t(v)]; });
  const std::vector<int32_t> renamed = compact(out);
  if (old_vertex) {
    old_vertex->assign(size_t(out.slots()), -1);
    for (size_t u = 0; u < renamed.size(); ++u)
      if (renamed[u] >= 0) (*old_vertex)[size_t(renamed[u])] = int32_t(u);
  }
  return out;
}

int32_t append(Mesh& m, const Mesh& other) {
  if (!other.free_vertex.empty() || !other.free_face.empty())
    throw InputError("", 0, "only a mesh without free slots can be appended");
  const int32_t base = m.slots(), base_face = m.face_slots();
  if (size_t(base) + other.nbr.size() > size_t(INT32_MAX / 3))
    throw InputError("", 0, "a simplex mesh holds at most 715 million vertices");
  auto add = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  add(m.nbr, other.nbr), add(m.left, other.left), add(m.x_mm, other.x_mm), add(m.before_mm, other.before_mm);
  add(m.shape, other.shape), add(m.metric, other.metric), add(m.zone, other.zone), add(m.flags, other.flags);
  add(m.face_edge, other.face_edge), add(m.face_size, other.face_size), add(m.face_kind, other.face_kind);
  for (size_t v = size_t(base); v < m.nbr.size(); ++v)
    for (size_t k = 0; k < 3; ++k) m.nbr[v][k] += base, m.left[v][k] += base_face;
  for (size_t f = size_t(base_face); f < m.face_edge.size(); ++f) m.face_edge[f] += 3 * base;
  for (std::vector<int32_t> c : other.contour) {
    for (int32_t& v : c) v += base;
    m.contour.push_back(std::move(c));
  }
  ++m.version;
  return base;
}

void record_shape(Mesh& m, ShapeCode code) {
  ++m.version;
  for (int32_t v = 0; v < m.slots(); ++v)
    if (m.alive(v)) {
      const Row& r = m.nbr[size_t(v)];
      m.shape[size_t(v)] =
          encode(m.x_mm[size_t(v)], m.x_mm[size_t(r[0])], m.x_mm[size_t(r[1])], m.x_mm[size_t(r[2])], code);
    }
}

namespace {

void add_topology(Hash64& h, const Mesh& m) {
  for (int32_t v = 0; v < m.slots(); ++v)
    for (size_t k = 0; k < 3; ++k) {
      h.add(m.nbr[size_t(v)][k]);
      if (m.alive(v)) h.add(m.kind(m.left[size_t(v)][k]));
    }
  for (const auto& c : m.contour) {
    h.add(uint32_t(c.size()));
    for (int32_t v : c) h.add(v);
  }
}

}  // namespace

uint64_t topology_hash(const Mesh& m) {
  Hash64 h;
  add_topology(h, m);
  return h.value();
}

uint64_t hash(const Mesh& m) {
  Hash64 h;
  add_topology(h, m);
  for (int32_t v = 0; v < m.slots(); ++v) {
    if (!m.alive(v)) continue;
    const size_t i = size_t(v);
    for (int k = 0; k < 3; ++k) h.add(m.x_mm[i][k]), h.add(m.before_mm[i][k]);
    h.add(m.zone[i]), h.add(m.flags[i]), h.add(m.metric[i][0]), h.add(m.metric[i][1]);
    const VertexShape& s = m.shape[i];
    h.add(s.e1), h.add(s.e2), h.add(s.phi), h.add(s.height), h.add(s.branch);
  }
  return h.value();
}

}  // namespace limberg::simplex
