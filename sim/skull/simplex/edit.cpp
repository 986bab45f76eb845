#include "sim/skull/simplex/edit.h"

#include <cassert>
#include <iterator>

namespace limberg::simplex {

size_t Delta::bytes() const {
  size_t n = step_.size() * sizeof(Step) + vertex_.size() * sizeof(Vertex) + face_.size() * sizeof(Face);
  for (const auto& all : contours_)
    for (const auto& c : all) n += c.size() * sizeof(int32_t);
  return n;
}

void Delta::append(Delta&& later) {
  const auto add = [](auto& to, auto& from) {
    to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
    from.clear();
  };
  add(step_, later.step_), add(vertex_, later.vertex_), add(face_, later.face_), add(contours_, later.contours_);
}

void undo(Mesh& m, Delta& d) {
  using What = Delta::What;
  while (!d.step_.empty()) {
    const auto [what, i] = d.step_.back();
    d.step_.pop_back();
    const size_t n = size_t(i);
    switch (what) {
      case What::vertex: {
        const Delta::Vertex& v = d.vertex_.back();
        m.nbr[n] = v.nbr, m.left[n] = v.left, m.x_mm[n] = v.x_mm, m.before_mm[n] = v.before_mm;
        m.shape[n] = v.shape, m.metric[n] = v.metric, m.zone[n] = v.zone, m.flags[n] = v.flags;
        d.vertex_.pop_back();
        break;
      }
      case What::face: {
        const Delta::Face& f = d.face_.back();
        m.face_edge[n] = f.edge, m.face_size[n] = f.size, m.face_kind[n] = f.kind;
        d.face_.pop_back();
        break;
      }
      case What::new_vertex:
        m.nbr.pop_back(), m.left.pop_back(), m.x_mm.pop_back(), m.before_mm.pop_back();
        m.shape.pop_back(), m.metric.pop_back(), m.zone.pop_back(), m.flags.pop_back();
        break;
      case What::new_face:
        m.face_edge.pop_back(), m.face_size.pop_back(), m.face_kind.pop_back();
        break;
      case What::reused_vertex:
        m.free_vertex.push_back(i);
        break;
      case What::reused_face:
        m.free_face.push_back(i);
        break;
      case What::freed_vertex:
        m.free_vertex.pop_back();
        break;
      case What::freed_face:
        m.free_face.pop_back();
        break;
      case What::contours:
        m.contour = std::move(d.contours_.back());
        d.contours_.pop_back();
        break;
    }
  }
  ++m.version;
}

void Edit::save_vertex(int32_t v) {
  const size_t i = size_t(v);
  d_.vertex_.push_back(
      {m.nbr[i], m.left[i], m.x_mm[i], m.before_mm[i], m.shape[i], m.metric[i], m.zone[i], m.flags[i]});
  d_.step_.push_back({Delta::What::vertex, v});
}

void Edit::save_face(int32_t f) {
  const size_t i = size_t(f);
  d_.face_.push_back({m.face_edge[i], m.face_size[i], m.face_kind[i]});
  d_.step_.push_back({Delta::What::face, f});
}

void Edit::save_contours() {
  d_.contours_.push_back(m.contour);
  d_.step_.push_back({Delta::What::contours, 0});
}

int32_t Edit::add_vertex(int32_t like) {
  const size_t l = size_t(like);
  int32_t v;
  if (!m.free_vertex.empty()) {
    v = m.free_vertex.back();
    m.free_vertex.pop_back();
    d_.step_.push_back({Delta::What::reused_vertex, v});
    save_vertex(v);
  } else {
    v = m.slots();
    m.nbr.push_back({-1, -1, -1}), m.left.push_back({-1, -1, -1});
    m.x_mm.emplace_back(), m.before_mm.emplace_back(), m.shape.emplace_back(), m.metric.emplace_back();
    m.zone.push_back(0), m.flags.push_back(0);
    d_.step_.push_back({Delta::What::new_vertex, v});
  }
  const size_t i = size_t(v);
  m.x_mm[i] = m.x_mm[l], m.before_mm[i] = m.before_mm[l], m.shape[i] = VertexShape{};
  m.metric[i] = {1. / 3, 1. / 3}, m.zone[i] = m.zone[l], m.flags[i] = 0;
  return v;
}

int32_t Edit::add_face(FaceKind kind) {
  int32_t f;
  if (!m.free_face.empty()) {
    f = m.free_face.back();
    m.free_face.pop_back();
    d_.step_.push_back({Delta::What::reused_face, f});
    save_face(f);
  } else {
    f = m.face_slots();
    m.face_edge.push_back(-1), m.face_size.push_back(0), m.face_kind.push_back(kind);
    d_.step_.push_back({Delta::What::new_face, f});
  }
  m.face_kind[size_t(f)] = kind;
  return f;
}

void Edit::free_vertex(int32_t v) {
  save_vertex(v);
  m.nbr[size_t(v)] = m.left[size_t(v)] = Row{-1, -1, -1};
  m.flags[size_t(v)] = 0;
  m.free_vertex.push_back(v);
  d_.step_.push_back({Delta::What::freed_vertex, v});
}

void Edit::free_face(int32_t f) {
  save_face(f);
  m.face_edge[size_t(f)] = -1, m.face_size[size_t(f)] = 0;
  m.free_face.push_back(f);
  d_.step_.push_back({Delta::What::freed_face, f});
}

void Edit::replace_neighbour(int32_t v, int32_t was, int32_t is) {
  const int k = m.slot(v, was);
  assert(k >= 0);
  save_vertex(v);
  m.nbr[size_t(v)][size_t(k)] = is;
}

void Edit::mark_face(int32_t f, int32_t h0) {
  save_face(f);
  int32_t size = 0, h = h0;
  do {
    int32_t& mark = m.left[size_t(h / 3)][size_t(h % 3)];
    if (mark != f) save_vertex(h / 3), m.left[size_t(h / 3)][size_t(h % 3)] = f;
    ++size;
    h = m.next(h);
  } while (h != h0);
  m.face_edge[size_t(f)] = h0, m.face_size[size_t(f)] = size;
}

void Edit::reshape(int32_t v) {
  save_vertex(v);
  const Row& r = m.nbr[size_t(v)];
  m.shape[size_t(v)] = encode(m.x_mm[size_t(v)], m.x_mm[size_t(r[0])], m.x_mm[size_t(r[1])], m.x_mm[size_t(r[2])]);
}

}  // namespace limberg::simplex
