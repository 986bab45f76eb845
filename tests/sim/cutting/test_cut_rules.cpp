// What decides where a blade cuts: coincidences, seeds, patches,
// shared points, refusals; and what the surface view shows.
#include <gtest/gtest.h>

#include <map>

#include "sim/base/error.h"
#include "sim/cutting/arrangement/store.h"
#include "tests/sim/cutting/scenes.h"

namespace limberg::test {
namespace test_cut_rules {

using Chi = std::vector<int>;

// A flat slab 40 x 40 x 10 whose skin vertices lie on whole multiples of 2 mm.
Arrangement flat_slab() { return Arrangement(wavy_slab(40, 10, 20, 0), grid()); }

CutResult must_cut(Arrangement& a, const Blade& b, uint64_t seed = 5) {
  const CutResult r = a.cut(b, seed);
  EXPECT_TRUE(r.ok()) << r.reason;
  EXPECT_EQ(a.check_all(), "");
  return r;
}

double lowest_wall(const Arrangement& a) {
  double z = 1e9;
  for (int32_t f : a.last_operation().new_walls)
    for (int32_t p : a.faces()[size_t(f)].v) z = std::min(z, a.point_mm(p).z());
  return z;
}

TEST(Coincidence, ThroughVerticesAndAlongEdges) {
  const std::vector<std::vector<Vec2>> lines{
      {{-8, 0}, {8, 0}},    // along a row of edges, through every vertex
      {{-9, -9}, {9, 9}},   // along diagonals
      {{0, -7}, {0.5, 7}},  // through one vertex
      {{0, 0}, {7, 3}},     // beginning in a vertex
      {{1, 1}, {9, 1}},     // through crossings of diagonals
  };
  for (const auto& line : lines) {
    Arrangement a = flat_slab();
    const CutResult r = must_cut(a, strip(line, 2, -5));
    EXPECT_LE(r.tries, 8);
    EXPECT_EQ(euler(a), Chi{2});
    Arrangement b = flat_slab();  // the same blade 10 micrometres beside
    std::vector<Vec2> beside = line;
    for (Vec2& p : beside) p += Vec2(0.01, 0.017);
    must_cut(b, strip(beside, 2, -5));
    EXPECT_EQ(euler(a), euler(b));
  }
}

TEST(Coincidence, BladeInThePlaneOfTheSkin) {
  Arrangement a = flat_slab();
  const uint64_t before = a.full_hash();
  const CutResult r = a.cut(sheet({-8, -8, 0}, {16, 0, 0}, {0, 16, 0}, 8, 8), 3);
  if (r.ok()) {
    EXPECT_EQ(a.check_all(), "");  // the jitter found a way through
    EXPECT_LE(r.tries, 8);
  } else {
    EXPECT_FALSE(r.reason.empty());
    EXPECT_EQ(a.full_hash(), before);
  }
}

TEST(Coincidence, TheSameCutAgainOrAShallowerOneChangesNothing) {
  Arrangement a = flat_slab();
  const Blade b = strip({{-8, 0.3}, {8, 1.1}}, 2, -5);
  must_cut(a, b);
  const uint64_t hash = a.full_hash();
  for (const Blade& again : {b, strip({{-8, 0.3}, {8, 1.1}}, 2, -4), strip({{-6, 0.41}, {7.5, 1.06}}, 1, -3)}) {
    EXPECT_EQ(a.cut(again, 9).status, CutResult::nothing_to_cut);
    EXPECT_EQ(a.full_hash(), hash);
  }
}

TEST(Coincidence, NearlyTheSameCutAgainIsSafe) {
  Arrangement a = flat_slab();
  const uint64_t initial = a.full_hash();
  const Blade b = strip({{-8, 0.3}, {8, 1.1}}, 2, -5);
  must_cut(a, b);
  const uint64_t volume = a.store().volume_residue;
  const CutResult r = a.cut(strip({{-8, 0.3}, {8, 1.1}}, 2, -6), 9);  // a little deeper: most of it coincides
  EXPECT_EQ(a.check_all(), "");
  EXPECT_EQ(a.store().volume_residue, volume);
  int real_pieces = 0;
  for (const SurfaceComponent& c : a.components()) real_pieces += c.volume_mm3 > 1;
  EXPECT_EQ(real_pieces, 1);
  // The slivers between the two cuts are debris; sweeping it belongs to the cut and goes with its undo.
  if (r.ok()) {
    const int pieces = a.pieces();
    const double before = a.volume_mm3();
    const DebrisResult swept = a.sweep_debris(1);
    EXPECT_EQ(a.check_all(), "");
    EXPECT_EQ(a.pieces(), 1);
    EXPECT_EQ(swept.pieces, pieces - 1);
    EXPECT_NEAR(a.volume_mm3() + swept.volume_mm3, before, 1e-9 * before);
    for (int32_t f : a.last_operation().added) EXPECT_TRUE(a.faces()[size_t(f)].live());
    for (int32_t f : a.last_operation().removed) EXPECT_FALSE(a.faces()[size_t(f)].live());
    ASSERT_TRUE(a.undo());
    EXPECT_EQ(a.check_all(), "");
  }
  ASSERT_TRUE(a.undo());
  EXPECT_EQ(a.full_hash(), initial);
  EXPECT_EQ(a.sweep_debris(1).pieces, 0);
}

TEST(Seeds, AFlapIsCutAndItsBedIsNot) {
  Arrangement a = flat_slab();
  must_cut(a, strip({{-10, 0}, {10, 0.1}}, 2, -5));
  must_cut(a, sheet({-9, -0.3, -4}, {18, 0, 0}, {0, 12, 0}, 9, 6));  // a pocket above y = 0
  must_cut(a, strip({{1, -0.1}, {1.3, 9}}, 2, -7));                  // across the flap, past the pocket
  EXPECT_GT(lowest_wall(a), -4.2);
  EXPECT_EQ(euler(a), Chi{2});
}

TEST(Seeds, NothingIsCutInAHole) {
  Arrangement a = flat_slab();
  must_cut(a, open_box({{6, 0}, {0, 6}, {-6, 0}, {0, -6}}, 2, -5));
  ASSERT_TRUE(a.excise(a.loose_component_near({0, 0, 0}, 1)).done);
  must_cut(a, strip({{-12, 0.3}, {12, 0.4}}, 2, -3));  // both banks of the hole
  double nearest = 1e9;
  std::map<bool, int> sides;
  for (int32_t f : a.last_operation().new_walls)
    for (int32_t p : a.faces()[size_t(f)].v) {
      nearest = std::min(nearest, std::abs(a.point_mm(p).x()));
      ++sides[a.point_mm(p).x() > 0];
    }
  EXPECT_GT(nearest, 5.5);
  EXPECT_GT(sides[true], 5);
  EXPECT_GT(sides[false], 5);
  EXPECT_EQ(euler(a), Chi{2});
}

TEST(Seeds, SheetsNeedAWallToBeginFrom) {
  Arrangement a = flat_slab();
  const uint64_t before = a.full_hash();
  EXPECT_EQ(a.cut(sheet({-5, -5, -4}, {10, 0, 0}, {0, 10, 0}, 5, 5), 1).status, CutResult::refused);
  EXPECT_EQ(a.full_hash(), before);
  EXPECT_EQ(a.cut(strip({{50, 0}, {60, 0}}, 2, -5), 1).status, CutResult::nothing_to_cut);
  Blade unseeded = strip({{-5, 0}, {5, 0.5}}, 2, -5);
  unseeded.seed.assign(unseeded.seed.size(), 0);
  EXPECT_EQ(a.cut(unseeded, 1).status, CutResult::nothing_to_cut);
  EXPECT_EQ(a.full_hash(), before);
}

TEST(Topology, ASheetJoiningTwoIncisionsIsATunnel) {
  Arrangement a = flat_slab();
  must_cut(a, strip({{-10, -4}, {10, -4.1}}, 2, -5));
  must_cut(a, strip({{-10, 4}, {10, 4.1}}, 2, -5));
  must_cut(a, sheet({-6, -4.3, -4}, {12, 0, 0}, {0, 8.6, 0}, 6, 5));
  EXPECT_EQ(a.pieces(), 1);
  EXPECT_EQ(euler(a), Chi{0});
}

TEST(Topology, TheLastBridgeMakesThePiece) {
  Arrangement a = flat_slab();
  must_cut(a, strip({{-30, 0.3}, {-3, 0.3}}, 4, -14));
  EXPECT_EQ(a.pieces(), 1);
  must_cut(a, strip({{3, 0.3}, {30, 0.3}}, 4, -14));
  EXPECT_EQ(a.pieces(), 1);
  must_cut(a, strip({{-4, 0}, {0, 2.1}, {4, 0}}, 4, -14));
  EXPECT_EQ(a.pieces(), 2);
  EXPECT_EQ(euler(a), (Chi{2, 2}));
}

// --- Blades that continue older ones
// -----------------------------------------------------------------------------------

Blade deeper(const Arrangement& a, const Blade& old, const CutResult& r, double z) {
  // Below every foot of the old strip (odd vertices) a new one; the feet are shared.
  Blade b;
  const size_t columns = old.vertex.size() / 2;
  for (size_t i = 0; i < columns; ++i) {
    const int32_t foot = r.blade_point[2 * i + 1];
    const Int3 p = a.explicit_point(foot);
    b.vertex.push_back(p);
    b.shared_point.push_back(foot);
    b.vertex.push_back({p.x, p.y, at(0, 0, z).z});
    b.shared_point.push_back(-1);
  }
  for (int32_t i = 0; i + 1 < int32_t(columns); ++i) {
    b.tri.push_back({2 * i, 2 * i + 1, 2 * i + 3});
    b.tri.push_back({2 * i, 2 * i + 3, 2 * i + 2});
  }
  b.seed.assign(b.tri.size(), 2);
  return b;
}

TEST(Continuing, DeepeningSharesTheFront) {
  Arrangement a = flat_slab();
  const Blade b = strip({{-8, 0.3}, {8, 1.1}}, 2, -4);
  const CutResult first = must_cut(a, b);
  const Blade below = deeper(a, b, first, -7);
  must_cut(a, below);
  EXPECT_EQ(euler(a), Chi{2});
  EXPECT_EQ(a.components().size(), 1u);
  // No face of the old wall was touched, and nothing was intersected with it.
  EXPECT_TRUE(a.last_operation().removed.empty());
  EXPECT_EQ(a.last_operation().new_walls.size(), below.tri.size());
  // Across the joint, then undo all.
  must_cut(a, strip({{1, -8}, {2, 8}}, 2, -6));
  EXPECT_EQ(euler(a), Chi{2});
  must_cut(a, strip({{-2, -8}, {-2.5, 8}}, 2, -9));
  EXPECT_EQ(euler(a), Chi{2});
}

TEST(Continuing, DeepeningAWallThatAnotherCrossed) {
  Arrangement a = flat_slab();
  const Blade b = strip({{-8, 0.3}, {8, 1.1}}, 2, -4);
  const CutResult first = must_cut(a, b);
  must_cut(a, strip({{1, -8}, {2, 8}}, 2, -6));  // crosses the front that will be shared
  must_cut(a, deeper(a, b, first, -8));
  EXPECT_EQ(euler(a), Chi{2});
}

TEST(Continuing, ProgressiveDrawingAppendsColumns) {
  Arrangement a = flat_slab();
  const Blade b = strip({{-8, 0.3}, {0.5, 0.7}}, 2, -4);
  CutResult r = must_cut(a, b);
  int32_t top = r.blade_point[r.blade_point.size() - 2], foot = r.blade_point.back();
  for (int i = 1; i <= 4; ++i) {
    Blade next;
    next.vertex = {a.explicit_point(top), a.explicit_point(foot), at(0.5 + 1.3 * i, 0.7 + 0.2 * i, 2),
                   at(0.5 + 1.3 * i, 0.7 + 0.2 * i, -4)};
    next.shared_point = {top, foot, -1, -1};
    next.tri = {{0, 1, 3}, {0, 3, 2}};
    next.seed = {1, 1};
    r = must_cut(a, next);
    EXPECT_EQ(euler(a), Chi{2});
    top = r.blade_point[2], foot = r.blade_point[3];
  }
}

// --- The radial order
// --------------------------------------------------------------------------------------------------

TEST(RadialOrder, FansOfManyPlanesAreSortedByAngle) {
  PointStore points;
  const int32_t a = points.add_explicit({0, 0, -40}), b = points.add_explicit({0, 0, 40});
  uint64_t state = 1;
  const auto draw = [&](int n) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return int(state >> 40) % n;
  };
  for (int round = 0; round < 500; ++round) {
    std::vector<RadialFace> faces;
    std::vector<double> angle;
    const int n = 3 + draw(6);
    std::vector<Plane> plane(static_cast<size_t>(n));
    while (int(faces.size()) < n) {
      const int32_t x = 2 * (draw(21) - 10), y = 2 * (draw(21) - 10);
      const double w = std::atan2(y, x);
      bool known = x == 0 && y == 0;
      for (double v : angle) known = known || std::abs(v - w) < 1e-9;
      if (known) continue;
      RadialFace f;
      f.orig = int32_t(faces.size());
      f.third = points.add_explicit({x, y, 2 * draw(9)});
      f.sense = draw(2) ? 1 : -1;
      plane[faces.size()] = f.sense > 0 ? plane_through(points.integer(a), points.integer(b), points.integer(f.third))
                                        : plane_through(points.integer(b), points.integer(a), points.integer(f.third));
      f.plane = &plane[faces.size()];
      faces.push_back(f);
      angle.push_back(w);
    }
    ASSERT_TRUE(sort_radially(points, a, b, faces));
    int descents = 0;  // counter-clockwise around +z: angles rise, wrapping once
    for (int i = 0; i < n; ++i)
      descents += angle[size_t(faces[size_t(i)].orig)] > angle[size_t(faces[size_t((i + 1) % n)].orig)];
    ASSERT_EQ(descents, 1);
    faces.push_back(faces[1]);
    faces.back().orig = 99;
    ASSERT_FALSE(sort_radially(points, a, b, faces));  // two in one place
  }
}

// --- Refusals
// -----------------------------------------------------------------------------------------------------------

TEST(Refusal, BadBladesChangeNothing) {
  Arrangement a = flat_slab();
  const uint64_t before = a.full_hash();
  const Blade good = strip({{-5, 0.3}, {5, 0.5}}, 2, -5);
  const auto refuse = [&](const Blade& b) {
    const CutResult r = a.cut(b, 1);
    EXPECT_EQ(r.status, CutResult::refused);
    EXPECT_FALSE(r.reason.empty());
    EXPECT_EQ(a.full_hash(), before);
    EXPECT_FALSE(a.undo());
  };
  refuse({});
  Blade b = good;
  b.vertex[0].x += 1;  // odd
  refuse(b);
  b = good;
  b.vertex[0].x = 1 << 22;  // outside the domain
  refuse(b);
  b = good;
  b.tri[0][0] = 1000;
  refuse(b);
  b = good;
  b.tri.push_back({0, 1, 2}), b.tri.push_back({0, 1, 3}), b.seed.assign(b.tri.size(), 1);  // three at an edge
  refuse(b);
  b = good;
  b.seed.pop_back();
  refuse(b);
  b = good;
  b.shared_point.assign(b.vertex.size(), -1);
  b.shared_point[0] = 7;  // somewhere else
  refuse(b);
  refuse(strip({{-5, 0}, {5, 0}, {5, 5}, {0, -5}}, 2, -5));  // through itself
}

TEST(Refusal, MoreLinesInATriangleThanItHasLabelsFor) {
  Arrangement a(wavy_slab(200, 12, 1, 0), grid());
  const uint64_t before = a.full_hash();
  // 44,000 columns, most of them in one triangle
  const CutResult r = a.cut(strip({{-95, 0.3}, {80, 30}}, 2, -5, false, 0.004), 1);
  EXPECT_EQ(r.status, CutResult::refused);
  EXPECT_NE(r.reason.find("32765"), std::string::npos) << r.reason;
  EXPECT_EQ(a.full_hash(), before);
}

TEST(Refusal, OpenOrBadSurfaces) {
  TriMesh m = wavy_slab(40, 10, 4, 0);
  m.tri.pop_back();
  EXPECT_THROW(Arrangement(m, grid()), InputError);
  m = wavy_slab(40, 10, 4, 0);
  std::swap(m.tri[3][0], m.tri[3][1]);
  EXPECT_THROW(Arrangement(m, grid()), InputError);
  m = wavy_slab(40, 10, 4, 0);
  m.tri[3][0] = -4;
  EXPECT_THROW(Arrangement(m, grid()), InputError);
  EXPECT_THROW(Arrangement(TriMesh{}, grid()), InputError);
}

TEST(Refusal, ExcisionOfNothingOrEverything) {
  Arrangement a = flat_slab();
  EXPECT_FALSE(a.excise(-1).done);
  EXPECT_FALSE(a.excise(5).done);
  EXPECT_FALSE(a.excise(0).done);
  EXPECT_EQ(a.loose_component_near({0, 0, 0}, 5), -1);
}

// --- The surface view
// ---------------------------------------------------------------------------------------------------

TEST(View, IsAClosedOrientedMeshWithItsBanksApart) {
  Arrangement a = flat_slab();
  const CutResult r = must_cut(a, strip({{-8, 0.3}, {8, 1.1}}, 2, -5));
  must_cut(a, strip({{0.3, -8}, {0.9, 8}}, 2, -4));
  const SurfaceView v = a.surface_view();
  std::map<std::pair<int32_t, int32_t>, int> half_edges;
  double volume = 0;
  for (const Tri& t : v.tri) {
    for (size_t k = 0; k < 3; ++k) ++half_edges[{t[k], t[(k + 1) % 3]}];
    volume += v.X_mm[size_t(t[0])].dot(v.X_mm[size_t(t[1])].cross(v.X_mm[size_t(t[2])])) / 6;
  }
  // Once each way; both banks of a wall may have an edge between the same two vertices of its front, then twice.
  for (const auto& [e, n] : half_edges) {
    ASSERT_LE(n, 2);
    ASSERT_EQ((half_edges[{e.second, e.first}]), n);
  }
  EXPECT_NEAR(volume, a.volume_mm3(), 1e-9 * volume);
  int walls = 0;
  for (size_t i = 0; i < v.tri.size(); ++i) {
    if (v.kind[i] == FaceKind::wall) {
      ++walls;
      EXPECT_GE(v.origin[i], r.op);
      continue;
    }
    EXPECT_LT(v.origin[i], int32_t(wavy_slab(40, 10, 20, 0).tri.size()));
    if (v.kind[i] != FaceKind::skin) continue;
    for (size_t k = 0; k < 3; ++k)  // the slab's uv is its (x, y)
      EXPECT_LT((v.uv[i][k].cast<double>() - v.X_mm[size_t(v.tri[i][k])].head<2>()).norm(), 1e-5);
  }
  int faces = 0;
  for (const Face& f : a.faces())
    if (f.live() && f.mat == (kMaterialPlus | kMaterialMinus)) ++faces;
  EXPECT_EQ(walls, 2 * faces);  // both banks
  // Points inside an incision's mouth have two vertices, crossings of two mouths four.
  std::map<int32_t, int> copies;
  for (int32_t p : v.point) ++copies[p];
  int twos = 0, fours = 0;
  for (const auto& [p, n] : copies) twos += n == 2, fours += n == 4;
  EXPECT_GT(twos, 20);
  EXPECT_GE(fours, 1);
}

}  // namespace test_cut_rules
}  // namespace limberg::test
