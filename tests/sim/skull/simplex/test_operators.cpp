// t1, t2 and exchange: bookkeeping, inverses, reasons.
#include <gtest/gtest.h>

#include "sim/skull/simplex/contour.h"
#include "sim/skull/simplex/generators.h"
#include "sim/skull/simplex/operators.h"

namespace limberg::simplex {
namespace test_operators {

std::vector<Mesh> closed_meshes() {
  return {make_sphere({0, 0, 0}, 10, 2), make_torus(30, 10, 12, 9), make_plane(20, 20, 2)};
}

void expect_change(const Census& a, const Census& b, int V, int E, int F, int chi) {
  EXPECT_EQ(b.vertices - a.vertices, V);
  EXPECT_EQ(b.edges - a.edges, E);
  EXPECT_EQ(b.faces - a.faces, F);
  EXPECT_EQ(b.chi - a.chi, chi);
}

TEST(T2, SplitsEveryFaceEveryWayAndT1IsItsInverse) {
  for (Mesh& m : closed_meshes()) {
    const uint64_t before = hash(m), rows = topology_hash(m);
    const Census c = census(m);
    int tried = 0;
    for (int32_t f = 0; f < m.face_slots(); f += 7) {
      if (is_end(m.kind(f))) continue;
      const std::vector<int32_t> ring = m.ring(f);
      for (size_t i = 0; i < ring.size(); ++i)
        for (size_t j = 0; j < ring.size(); ++j) {
          if (i == j) continue;
          Delta d, e;
          const OperatorResult o = t2(m, f, ring[i], ring[j], d);
          ASSERT_TRUE(o) << sentence(o.answer);
          ASSERT_EQ(find_fault(m).value_or(""), "");
          expect_change(c, census(m), 2, 3, 1, 0);
          const int32_t n1 = m.face_size[size_t(o.face[0])], n2 = m.face_size[size_t(o.face[1])];
          EXPECT_EQ(n1 + n2, int32_t(ring.size()) + 4);
          const OperatorResult back = t1(m, o.vertex[0], o.vertex[1], e);
          ASSERT_TRUE(back) << sentence(back.answer);
          ASSERT_EQ(find_fault(m).value_or(""), "");
          Mesh packed = m;
          compact(packed);
          ASSERT_EQ(topology_hash(packed), rows);
          undo(m, e);
          undo(m, d);
          ASSERT_EQ(hash(m), before);
          ++tried;
        }
    }
    EXPECT_GT(tried, 100);
    EXPECT_EQ(m.slots(), m.vertices());
  }
}

TEST(T1, DeletesEdgesAndUndoGivesTheBitsBack) {
  for (Mesh& m : closed_meshes()) {
    const uint64_t before = hash(m);
    const Census c = census(m);
    int done = 0;
    for (int32_t v = 0; v < m.slots(); ++v)
      for (int32_t u : Row(m.nbr[size_t(v)])) {
        Delta d;
        const int32_t A = m.face(m.edge(v, u)), B = m.face(m.edge(u, v));
        const int32_t nA = m.face_size[size_t(A)], nB = m.face_size[size_t(B)];
        const OperatorResult o = t1(m, v, u, d);
        ASSERT_EQ(find_fault(m).value_or(""), "");
        if (o) {
          ++done;
          expect_change(c, census(m), -2, -3, -1, 0);
          EXPECT_EQ(m.face_size[size_t(o.face[0])], nA + nB - 4);
          undo(m, d);
        }
        EXPECT_TRUE(d.empty());
        ASSERT_EQ(hash(m), before);
      }
    EXPECT_GT(done, m.slots());
  }
}

TEST(T1, ReducesASphereToATetrahedronAndNoFurther) {
  Mesh m = make_sphere({0, 0, 0}, 10, 1);
  Delta d;
  const uint64_t before = hash(m);
  for (bool any = true; any;) {
    any = false;
    for (int32_t v = 0; v < m.slots() && !any; ++v)
      if (m.alive(v))
        for (int32_t u : Row(m.nbr[size_t(v)]))
          if (t1(m, v, u, d)) {
            any = true;
            break;
          }
    ASSERT_EQ(find_fault(m).value_or(""), "");
  }
  EXPECT_EQ(m.vertices(), 4);
  EXPECT_EQ(m.faces(), 4);
  undo(m, d);
  EXPECT_EQ(hash(m), before);
}

TEST(Exchange, TurnsAndTurnsBack) {
  for (Mesh& m : closed_meshes()) {
    const uint64_t before = topology_hash(m);
    const std::vector<Vec3> x = m.x_mm;
    const Census c = census(m);
    int done = 0;
    for (int32_t v = 0; v < m.slots(); ++v)
      for (int32_t u : Row(m.nbr[size_t(v)]))
        for (Turn turn : {Turn::clockwise, Turn::counter_clockwise}) {
          Delta d;
          const int32_t h = m.edge(v, u), A = m.face(h), B = m.face(m.twin(h));
          const int32_t nA = m.face_size[size_t(A)];
          if (!exchange(m, v, u, turn, d)) continue;
          ++done;
          ASSERT_EQ(find_fault(m).value_or(""), "");
          EXPECT_EQ(census(m), c);
          EXPECT_EQ(m.face_size[size_t(A)], nA - 1);
          EXPECT_NE(m.face(m.edge(v, u)), A);
          EXPECT_NE(m.face(m.edge(v, u)), B);
          const Turn back = turn == Turn::clockwise ? Turn::counter_clockwise : Turn::clockwise;
          ASSERT_TRUE(exchange(m, v, u, back, d));
          ASSERT_EQ(find_fault(m).value_or(""), "");
          // Rows may have turned; as cycles they are the same.
          for (int32_t w : {v, u}) {
            Row& r = m.nbr[size_t(w)];
            EXPECT_EQ(std::count(r.begin(), r.end(), w == v ? u : v), 1);
          }
          for (size_t i = 0; i < x.size(); ++i) ASSERT_LT((m.x_mm[i] - x[i]).norm(), 1e-12);
          undo(m, d);
          ASSERT_EQ(topology_hash(m), before);
        }
    EXPECT_GT(done, 2 * m.slots());
  }
}

TEST(Operators, RefuseWithAReasonAndChangeNothing) {
  Mesh m = make_plane(20, 20, 2);
  const auto ends = end_contours(m);
  ASSERT_EQ(ends.size(), 1u);
  const std::vector<int32_t>& rim = ends[0].rim;
  const uint64_t before = hash(m);
  Delta d;
  const auto same = [&](const OperatorResult& o, Answer a) {
    EXPECT_EQ(o.answer, a) << sentence(o.answer);
    EXPECT_EQ(hash(m), before);
    EXPECT_TRUE(d.empty());
    EXPECT_STRNE(sentence(o.answer), "");
  };
  same(t1(m, -1, 0, d), Answer::no_such_vertex);
  same(t1(m, 0, m.slots(), d), Answer::no_such_vertex);
  same(t1(m, 0, 0, d), Answer::no_such_edge);
  same(t1(m, rim[0], rim[1], d), Answer::end_face);
  same(exchange(m, rim[0], rim[1], Turn::clockwise, d), Answer::end_face);
  same(t2(m, -5, 0, 1, d), Answer::no_such_face);
  same(t2(m, ends[0].face, rim[0], rim[2], d), Answer::end_face);
  const int32_t v = m.slots() / 2, u = m.nbr[size_t(v)][0], f = m.left[size_t(v)][0];
  ASSERT_EQ(m.kind(f), FaceKind::surface);
  same(t2(m, f, v, v, d), Answer::same_edge);
  same(t2(m, f, v, rim[0], d), Answer::no_such_face);
  m.flags[size_t(v)] |= kLocked;
  EXPECT_EQ(t1(m, v, u, d).answer, Answer::locked);
  EXPECT_EQ(exchange(m, v, u, Turn::clockwise, d).answer, Answer::locked);
  m.flags[size_t(v)] = 0;
  const std::vector<int32_t> ring = m.ring(f);
  ASSERT_EQ(keep_contour(m, ring), "");
  EXPECT_NE(keep_contour(m, ring), "");
  EXPECT_EQ(t1(m, ring[0], ring[1], d).answer, Answer::on_contour);
  EXPECT_EQ(t2(m, f, ring[0], ring[2], d).answer, Answer::on_contour);
  EXPECT_EQ(t4(m, ring, CutPolicy::any, d).answer, Answer::on_contour);
  EXPECT_EQ(find_fault(m).value_or(""), "");
  release_contour(m, 0);
  EXPECT_EQ(hash(m), before);
}

TEST(T1, TheLinkConditionHolds) {
  // A prism with triangular ends: deleting an edge between its three sides would make two faces meet twice.
  const Mesh prism = make_mesh({{1, 2, 3}, {2, 0, 4}, {0, 1, 5}, {5, 4, 0}, {3, 5, 1}, {4, 3, 2}},
                               {{1, 0, 1}, {0, 1, 1}, {-1, -1, 1}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}});
  EXPECT_EQ(census(prism).chi, 2);
  Mesh m = prism;
  Delta d;
  EXPECT_NE(t1(m, 0, 3, d).answer, Answer::done);  // an upright
  EXPECT_EQ(t1(m, 0, 1, d).answer, Answer::done);  // an edge of an end: what is left is a tetrahedron
  EXPECT_EQ(m.vertices(), 4);
  EXPECT_EQ(find_fault(m).value_or(""), "");
}

TEST(T2, SplitsAcrossTheLongDirection) {
  Mesh m = make_plane(20, 20, 2);
  for (Vec3& x : m.x_mm) x.x() *= 3;
  int32_t f = m.left[size_t(m.slots() / 2)][0];
  Delta d;
  const OperatorResult o = t2_across(m, f, d);
  ASSERT_TRUE(o);
  const Vec3 e = (m.x_mm[size_t(o.vertex[0])] - m.x_mm[size_t(o.vertex[1])]).normalized();
  EXPECT_LT(std::abs(e.x()), 0.9);
  EXPECT_EQ(find_fault(m).value_or(""), "");
}

TEST(T2, NewVerticesInheritVelocityAndZone) {
  Mesh m = make_sphere({0, 0, 0}, 10, 2);
  for (size_t v = 0; v < m.x_mm.size(); ++v) m.before_mm[v] = m.x_mm[v] - Vec3(1, 2, 3), m.zone[v] = 4;
  Delta d;
  const OperatorResult o = t2_across(m, 3, d);
  ASSERT_TRUE(o);
  for (int32_t v : o.vertex) {
    EXPECT_TRUE((m.x_mm[size_t(v)] - m.before_mm[size_t(v)]).isApprox(Vec3(1, 2, 3)));
    EXPECT_EQ(m.zone[size_t(v)], 4);
  }
}

}  // namespace test_operators
}  // namespace limberg::simplex
