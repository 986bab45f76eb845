// The local operators: t1, t2, exchange.
#include "sim/skull/simplex/operators.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace limberg::simplex {
namespace {

bool kept(const Mesh& m, int32_t v, uint8_t flag) { return (m.flags[size_t(v)] & flag) != 0; }

/// The four neighbours of an edge p - q in the pictures of operators.h: p1 and q2 on its left, p2 and q1 on its right.
struct Around {
  int32_t p1, p2, q1, q2;
  int32_t A, B, C, D;  // faces: left, right, beyond p, beyond q
};
Around around(const Mesh& m, int32_t p, int32_t q) {
  const size_t i = size_t(m.slot(p, q)), j = size_t(m.slot(q, p));
  const Row &rp = m.nbr[size_t(p)], &rq = m.nbr[size_t(q)], &lp = m.left[size_t(p)], &lq = m.left[size_t(q)];
  return {rp[(i + 1) % 3], rp[(i + 2) % 3], rq[(j + 1) % 3], rq[(j + 2) % 3],
          lp[i],           lq[j],           lp[(i + 1) % 3], lq[(j + 1) % 3]};
}

/// Some face other than `not1`, `not2` has an edge in common with both A and B. (Walks the shorter ring.)
bool third_face(const Mesh& m, int32_t A, int32_t B, int32_t not1, int32_t not2) {
  bool found = false;
  m.around(A, [&](int32_t h) {
    const int32_t g = m.face(m.twin(h));
    if (found || g == B || g == not1 || g == not2) return;
    m.around(g, [&](int32_t e) { found |= m.face(m.twin(e)) == B; });
  });
  return found;
}

bool faces_share_edge(const Mesh& m, int32_t A, int32_t B) {
  if (m.face_size[size_t(A)] > m.face_size[size_t(B)]) std::swap(A, B);
  bool found = false;
  m.around(A, [&](int32_t h) { found |= m.face(m.twin(h)) == B; });
  return found;
}

Answer edge_exists(const Mesh& m, int32_t p, int32_t q) {
  if (!m.alive(p) || !m.alive(q)) return Answer::no_such_vertex;
  return m.slot(p, q) < 0 ? Answer::no_such_edge : Answer::done;
}

}  // namespace

const char* sentence(Answer a) {
  switch (a) {
    case Answer::done:
      return "done";
    case Answer::no_such_vertex:
      return "there is no such vertex";
    case Answer::no_such_edge:
      return "the two vertices are not neighbours";
    case Answer::no_such_face:
      return "there is no such face, or the face does not have that edge";
    case Answer::same_edge:
      return "two different edges of the face are needed";
    case Answer::end_face:
      return "it would touch the rim of a hole or of a cut";
    case Answer::locked:
      return "a vertex there is locked";
    case Answer::on_contour:
      return "a vertex there belongs to a contour that is kept";
    case Answer::face_too_small:
      return "a face would be left with fewer than three vertices";
    case Answer::already_neighbours:
      return "two vertices would be neighbours twice";
    case Answer::faces_meet_twice:
      return "two faces would share more than one edge";
    case Answer::same_face:
      return "two different faces are needed";
    case Answer::shared_vertex:
      return "the two faces have a vertex in common";
    case Answer::common_face:
      return "a face between them touches both";
    case Answer::sizes_differ:
      return "the two faces do not have equally many vertices";
    case Answer::not_interleaved:
      return "the contour does not run through the rims of both faces in their order";
    case Answer::too_short:
      return "a contour has at least three vertices";
    case Answer::not_a_cycle:
      return "the contour is not closed: two vertices that follow each other are not neighbours";
    case Answer::repeated_vertex:
      return "the contour crosses or touches itself";
    case Answer::too_few_left:
      return "fewer than three edges leave the contour on its left";
    case Answer::too_few_right:
      return "fewer than three edges leave the contour on its right";
    case Answer::touches_face_twice:
      return "the contour leaves a face and comes back to it";
    case Answer::does_not_divide:
      return "the cut would not divide the part in two";
    case Answer::divides:
      return "the cut would divide the part in two";
  }
  return "";
}

Answer may_t1(const Mesh& m, int32_t p, int32_t q) {
  if (const Answer a = edge_exists(m, p, q); a != Answer::done) return a;
  if (kept(m, p, kLocked) || kept(m, q, kLocked)) return Answer::locked;
  if (kept(m, p, kOnContour) || kept(m, q, kOnContour)) return Answer::on_contour;
  const Around s = around(m, p, q);
  if (is_end(m.kind(s.A)) || is_end(m.kind(s.B)) || m.kind(s.A) != m.kind(s.B)) return Answer::end_face;
  if (m.face_size[size_t(s.C)] < 4 || m.face_size[size_t(s.D)] < 4) return Answer::face_too_small;
  if (m.face_size[size_t(s.A)] + m.face_size[size_t(s.B)] < 7) return Answer::face_too_small;
  if (m.slot(s.p1, s.p2) >= 0 || m.slot(s.q1, s.q2) >= 0) return Answer::already_neighbours;
  const bool swap = m.face_size[size_t(s.A)] > m.face_size[size_t(s.B)];
  if (s.C == s.D || third_face(m, swap ? s.B : s.A, swap ? s.A : s.B, s.C, s.D)) return Answer::faces_meet_twice;
  return Answer::done;
}

OperatorResult t1(Mesh& m, int32_t p, int32_t q, Delta& delta) {
  if (const Answer a = may_t1(m, p, q); a != Answer::done) return no(a, p, q);
  const Around s = around(m, p, q);
  Edit e(m, delta);
  e.replace_neighbour(s.p1, p, s.p2), e.replace_neighbour(s.p2, p, s.p1);
  e.replace_neighbour(s.q1, q, s.q2), e.replace_neighbour(s.q2, q, s.q1);
  e.free_vertex(std::max(p, q)), e.free_vertex(std::min(p, q));
  const int32_t keep = std::min(s.A, s.B);
  e.free_face(std::max(s.A, s.B));
  e.mark_face(keep, m.edge(s.p1, s.p2));
  e.mark_face(s.C, m.edge(s.p2, s.p1));
  e.mark_face(s.D, m.edge(s.q2, s.q1));
  for (int32_t v : {s.p1, s.p2, s.q1, s.q2}) e.reshape(v);
  ++m.version;
  OperatorResult o;
  o.face[0] = keep;
  return o;
}

Answer may_t2(const Mesh& m, int32_t f, int32_t u1, int32_t u2) {
  if (!m.alive_face(f)) return Answer::no_such_face;
  if (is_end(m.kind(f))) return Answer::end_face;
  if (!m.alive(u1) || !m.alive(u2)) return Answer::no_such_vertex;
  if (u1 == u2) return Answer::same_edge;
  for (int32_t u : {u1, u2}) {
    const Row& l = m.left[size_t(u)];
    const size_t k = l[0] == f ? 0 : l[1] == f ? 1 : l[2] == f ? 2 : 3;
    if (k == 3) return Answer::no_such_face;
    const int32_t v = m.nbr[size_t(u)][k];
    if (kept(m, u, kLocked) && kept(m, v, kLocked)) return Answer::locked;
    if (kept(m, u, kOnContour) && kept(m, v, kOnContour)) return Answer::on_contour;
  }
  return Answer::done;
}

OperatorResult t2(Mesh& m, int32_t f, int32_t u1, int32_t u2, Delta& delta) {
  if (const Answer a = may_t2(m, f, u1, u2); a != Answer::done) return no(a, u1, u2);
  auto end_of = [&](int32_t u) {
    const Row& l = m.left[size_t(u)];
    return m.nbr[size_t(u)][l[0] == f ? 0 : l[1] == f ? 1 : 2];
  };
  const int32_t v1 = end_of(u1), v2 = end_of(u2);
  const int32_t g1 = m.face(m.edge(v1, u1)), g2 = m.face(m.edge(v2, u2));
  Edit e(m, delta);
  const int32_t a = e.add_vertex(u1), b = e.add_vertex(u2);
  const int32_t fresh = e.add_face(m.kind(f));
  const auto at = [](int32_t i) { return size_t(i); };
  const auto place = [&](std::vector<Vec3>& x) {
    const Vec3 h1 = 0.5 * (x[at(u1)] + x[at(v1)]), h2 = 0.5 * (x[at(u2)] + x[at(v2)]);
    x[at(a)] = (2 * h1 + h2) / 3, x[at(b)] = (2 * h2 + h1) / 3;
  };
  place(m.x_mm);
  for (int32_t n : {a, b}) {
    const int32_t u = n == a ? u1 : u2, v = n == a ? v1 : v2;
    m.before_mm[at(n)] =
        m.x_mm[at(n)] - 0.5 * (m.x_mm[at(u)] - m.before_mm[at(u)] + m.x_mm[at(v)] - m.before_mm[at(v)]);
  }
  // (Replacing one after the other also serves when the two edges meet: v1 = u2 then gets both.)
  e.replace_neighbour(u1, v1, a), e.replace_neighbour(v1, u1, a);
  e.replace_neighbour(u2, v2, b), e.replace_neighbour(v2, u2, b);
  m.nbr[at(a)] = {u1, v1, b}, m.nbr[at(b)] = {u2, v2, a};
  e.mark_face(f, m.edge(b, a)), e.mark_face(fresh, m.edge(a, b));
  e.mark_face(g1, m.edge(v1, a)), e.mark_face(g2, m.edge(v2, b));
  for (int32_t v : {u1, v1, u2, v2, a, b}) e.reshape(v);
  ++m.version;
  OperatorResult o;
  o.vertex[0] = a, o.vertex[1] = b, o.face[0] = f, o.face[1] = fresh;
  return o;
}

OperatorResult t2_across(Mesh& m, int32_t f, Delta& delta) {
  if (!m.alive_face(f)) return no(Answer::no_such_face);
  const std::vector<int32_t> ring = m.ring(f);
  Vec3 c = Vec3::Zero();
  for (int32_t v : ring) c += m.x_mm[size_t(v)] / double(ring.size());
  Mat3 S = Mat3::Zero();
  for (int32_t v : ring) S += (m.x_mm[size_t(v)] - c) * (m.x_mm[size_t(v)] - c).transpose();
  const Vec3 axis = Eigen::SelfAdjointEigenSolver<Mat3>(S).eigenvectors().col(2);
  std::vector<int32_t> crossed;
  for (size_t i = 0; i < ring.size(); ++i) {
    const double s = axis.dot(m.x_mm[size_t(ring[i])] - c),
                 t = axis.dot(m.x_mm[size_t(ring[(i + 1) % ring.size()])] - c);
    if ((s < 0) != (t < 0)) crossed.push_back(ring[i]);
  }
  if (crossed.size() < 2) crossed = {ring[0], ring[ring.size() / 2]};  // a face without extent
  return t2(m, f, crossed[0], crossed[1], delta);
}

Answer may_exchange(const Mesh& m, int32_t p, int32_t q) {
  if (const Answer a = edge_exists(m, p, q); a != Answer::done) return a;
  if (kept(m, p, kLocked) || kept(m, q, kLocked)) return Answer::locked;
  if (kept(m, p, kOnContour) || kept(m, q, kOnContour)) return Answer::on_contour;
  const Around s = around(m, p, q);
  for (int32_t f : {s.A, s.B, s.C, s.D})
    if (is_end(m.kind(f))) return Answer::end_face;
  if (m.face_size[size_t(s.A)] < 4 || m.face_size[size_t(s.B)] < 4) return Answer::face_too_small;
  if (s.C == s.D || faces_share_edge(m, s.C, s.D)) return Answer::faces_meet_twice;
  return Answer::done;
}

OperatorResult exchange(Mesh& m, int32_t p, int32_t q, Turn turn, Delta& delta) {
  if (const Answer a = may_exchange(m, p, q); a != Answer::done) return no(a, p, q);
  const Around s = around(m, p, q);
  Edit e(m, delta);
  e.save_vertex(p), e.save_vertex(q);
  const size_t i = size_t(p), j = size_t(q);
  const auto place = [&](std::vector<Vec3>& x, const Vec3& n) {
    const Vec3 mid = 0.5 * (x[i] + x[j]), half = x[i] - mid;
    const Vec3 flat = half - half.dot(n) * n;
    const Vec3 turned = n.cross(flat) * (turn == Turn::counter_clockwise ? 1 : -1) + half.dot(n) * n;
    x[i] = mid + turned, x[j] = mid - turned;
  };
  Vec3 n = (m.x_mm[size_t(s.q1)] - m.x_mm[size_t(s.p1)]).cross(m.x_mm[size_t(s.q2)] - m.x_mm[size_t(s.p2)]);
  n = n.norm() > 0 ? Vec3(n.normalized()) : Vec3(Vec3::UnitZ());
  place(m.x_mm, n), place(m.before_mm, n);
  // Afterwards C and D are the sides of p - q, and A and B lie at its ends.
  if (turn == Turn::clockwise) {  // p, at the left end, goes to the left side: between p1 and q2
    e.replace_neighbour(s.q2, q, p), e.replace_neighbour(s.p2, p, q);
    m.nbr[i] = {q, s.q2, s.p1}, m.nbr[j] = {p, s.p2, s.q1};
    e.mark_face(s.D, m.edge(p, q)), e.mark_face(s.C, m.edge(q, p));
    e.mark_face(s.A, m.edge(s.p1, p)), e.mark_face(s.B, m.edge(s.q1, q));
  } else {
    e.replace_neighbour(s.q1, q, p), e.replace_neighbour(s.p1, p, q);
    m.nbr[i] = {q, s.p2, s.q1}, m.nbr[j] = {p, s.q2, s.p1};
    e.mark_face(s.C, m.edge(p, q)), e.mark_face(s.D, m.edge(q, p));
    e.mark_face(s.B, m.edge(s.q1, p)), e.mark_face(s.A, m.edge(s.p1, q));
  }
  for (int32_t v : {p, q, s.p1, s.p2, s.q1, s.q2}) e.reshape(v);
  ++m.version;
  return {};
}

}  // namespace limberg::simplex
