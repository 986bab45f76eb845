// The surface cursor: never off the surface, never further than the hand, never stuck where there is a way.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>

#include "devices/surface_cursor.h"
#include "tests/devices/flat_patient.h"
#include "tests/devices/samples.h"

namespace limberg {
namespace test_cursor {

using namespace test;

struct Mesh {
  std::vector<Vec3> X;
  std::vector<Tri> tri;
};

std::shared_ptr<SurfaceTopology> topology_of(const Mesh& m, uint64_t version = 1) {
  auto t = std::make_shared<SurfaceTopology>();
  t->version = version;
  t->body = std::make_shared<Body>();
  for (const Vec3& X : m.X) t->view.X_mm.push_back(X);
  for (const Tri& k : m.tri) t->view.tri.push_back(k), t->view.kind.push_back(FaceKind::skin);
  return t;
}

/// Each triangle in four, on the same surface.
Mesh split(const Mesh& m) {
  Mesh out{m.X, {}};
  std::map<std::pair<int32_t, int32_t>, int32_t> middle;
  const auto mid = [&](int32_t a, int32_t b) {
    auto [it, fresh] = middle.try_emplace(std::minmax(a, b), int32_t(out.X.size()));
    if (fresh) out.X.push_back(0.5 * (m.X[size_t(a)] + m.X[size_t(b)]));
    return it->second;
  };
  for (const Tri& k : m.tri) {
    const int32_t a = mid(k[0], k[1]), b = mid(k[1], k[2]), c = mid(k[2], k[0]);
    for (const Tri& n : {Tri{k[0], a, c}, Tri{a, k[1], b}, Tri{c, b, k[2]}, Tri{a, b, c}}) out.tri.push_back(n);
  }
  return out;
}

/// An octahedron, split, its vertices on a sphere.
Mesh sphere(double radius, int splits) {
  Mesh m{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
         {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int i = 0; i < splits; ++i) m = split(m);
  for (Vec3& X : m.X) X *= radius / X.norm();
  return m;
}

Mesh box(double a) {
  Mesh m;
  for (int i = 0; i < 8; ++i) m.X.push_back(a * Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  for (const auto& q : {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    m.tri.push_back({q[0], q[1], q[2]}), m.tri.push_back({q[0], q[2], q[3]});
  return m;
}

Pose hand_at(const Vec3& p) {
  Pose h;
  h.tip_mm = p;
  h.valid = true;
  return h;
}

/// Barycentric coordinates in order, and a triangle that is there.
void expect_on_surface(const Snapshot& s, const SurfaceCursor& c) {
  ASSERT_GE(c.place().triangle, 0);
  ASSERT_LT(size_t(c.place().triangle), s.topology->view.tri.size());
  double sum = 0;
  for (const double b : c.place().bary) {
    ASSERT_GE(b, 0);
    sum += b;
  }
  ASSERT_NEAR(sum, 1, 1e-12);
}

TEST(SurfaceCursor, OnAPlaneItIsTheHandTimesTheGain) {
  const Snapshot s = snapshot_of(flat_topology(37, 1));
  CursorSettings set;
  set.gain = 0.4;
  SurfaceCursor c(set);
  ASSERT_TRUE(c.put(s, Vec3(3, -7, 2)));
  Vec3 hand(100, 50, 20);
  c.tick(s, hand_at(hand), false, false);
  const Vec3 start = c.x_mm();
  Dice dice{4};
  for (int i = 0; i < 4000; ++i) {
    hand = Vec3(100, 50, 20) + Vec3(70 * std::sin(0.002 * i), 60 * std::sin(0.0031 * i), 30 * std::sin(0.01 * i)) +
           0.05 * Vec3(dice.normal(), dice.normal(), dice.normal());
    c.tick(s, hand_at(hand), false, true);
    expect_on_surface(s, c);
  }
  const Vec3 way = 0.4 * (hand - Vec3(100, 50, 20));
  EXPECT_LT((c.x_mm() - start - Vec3(way.x(), way.y(), 0)).norm(), 1e-6);
  // Its path is made of steps, and is where it went.
  EXPECT_GT(c.path_size(), 100u);
  for (size_t i = 1; i < c.path_size(); ++i) {
    const double step = (c.path(i).chart - c.path(i - 1).chart).norm();
    EXPECT_GE(step, 0.4);
    EXPECT_LT(step, 1.0);
  }
}

TEST(SurfaceCursor, ClutchAndLostTrackingLeaveItBitForBit) {
  const Snapshot s = snapshot_of(topology_of(sphere(40, 3)));
  SurfaceCursor c;
  c.put(s, Vec3(3, 5, 60));
  c.tick(s, hand_at({0, 0, 0}), false, false);
  c.tick(s, hand_at({5, 1, 0}), false, false);
  const SurfacePlace there = c.place();
  for (int i = 0; i < 50; ++i) c.tick(s, hand_at(Vec3(5 + i, 2 * i, i)), true, false);
  EXPECT_EQ(c.place(), there);
  Pose lost;
  c.tick(s, lost, false, false);
  c.tick(s, hand_at({-300, 0, 0}), false, false);
  EXPECT_EQ(c.place(), there);
  c.tick(s, hand_at({-299, 0, 0}), false, false);
  EXPECT_FALSE(c.place() == there);
}

TEST(SurfaceCursor, AGestureRoundTheObjectReachesItsHiddenSide) {
  for (const bool edges : {false, true}) {
    const Snapshot s = snapshot_of(topology_of(edges ? box(30) : sphere(40, 4)));
    CursorSettings set;
    set.gain = 0.5;
    SurfaceCursor c(set);
    c.put(s, Vec3(1, 2, 50));
    double turned = 0, last = std::atan2(c.x_mm().x(), c.x_mm().z()), lowest = 1e9, slowest_quarter = 1e9,
           quarter_start = 0;
    // of the hand's circle; the cursor's part of it goes round the object with room
    const double r = edges ? 150 : 110;
    for (int i = 0; i <= 8000; ++i) {
      const double a = 2 * M_PI * i / 4000;
      c.tick(s, hand_at(r * Vec3(std::sin(a), 0, std::cos(a))), false, false);
      expect_on_surface(s, c);
      const double now = std::atan2(c.x_mm().x(), c.x_mm().z());
      turned += std::remainder(now - last, 2 * M_PI);
      last = now;
      lowest = std::min(lowest, c.x_mm().z());
      if (i % 1000 == 0 && i > 0)
        slowest_quarter = std::min(slowest_quarter, turned - quarter_start), quarter_start = turned;
    }
    EXPECT_NEAR(turned, 4 * M_PI, 0.8) << edges;
    EXPECT_LT(lowest, edges ? -29.9 : -39.0) << edges;
    EXPECT_GT(slowest_quarter, 0.6) << edges;  // of pi / 2: it does not wait at an edge
  }
}

/// The cursor's places at some moments of a hand's path.
std::vector<Vec3> drawn(const Snapshot& s, const Vec3& start, const std::function<Vec3(double)>& hand,
                        double gain = 0.5) {
  CursorSettings set;
  set.gain = gain;
  SurfaceCursor c(set);
  EXPECT_TRUE(c.put(s, start));
  std::vector<Vec3> all;
  Vec3 before = c.x_mm(), last = hand(0);
  for (int i = 0; i <= 6000; ++i) {
    const Vec3 h = hand(i * 1e-3);
    c.tick(s, hand_at(h), false, false);
    // Never further than the hand.
    EXPECT_LE((c.x_mm() - before).norm(), gain * (h - last).norm() + 1e-9) << i;
    before = c.x_mm(), last = h;
    if (i % 50 == 0) all.push_back(c.x_mm());
  }
  return all;
}

double furthest(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double d = 0;
  for (size_t i = 0; i < a.size(); ++i) d = std::max(d, (a[i] - b[i]).norm());
  return d;
}

Mesh wavy(int n) {
  Mesh m;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = -60 + 120.0 * i / n, y = -60 + 120.0 * j / n;
      m.X.push_back({x, y, 6 * std::sin(x / 9) * std::cos(y / 12) + 0.004 * x * x});
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 2, d = a + n + 1;
      m.tri.push_back({a, b, c}), m.tri.push_back({a, c, d});
    }
  return m;
}

Vec3 round_a_flap(double t) {
  return {70 * std::sin(1.1 * t), 60 * std::sin(0.7 * t) + 12 * std::sin(3 * t), 20 * std::sin(0.9 * t)};
}

TEST(SurfaceCursor, TheSameHandOnARefinedMeshDrawsTheSamePath) {
  const Mesh coarse = wavy(60);  // 2 mm
  const std::vector<Vec3> a = drawn(snapshot_of(topology_of(coarse)), {0, 0, 5}, round_a_flap);
  // The same surface in smaller triangles.
  EXPECT_LT(furthest(a, drawn(snapshot_of(topology_of(split(split(coarse)))), {0, 0, 5}, round_a_flap)),
            1e-3);  // float positions
  // The same shape sampled twice and four times as finely: another surface, by the height of its facets.
  const double fine = furthest(a, drawn(snapshot_of(topology_of(wavy(120))), {0, 0, 5}, round_a_flap));
  const double finer = furthest(a, drawn(snapshot_of(topology_of(wavy(240))), {0, 0, 5}, round_a_flap));
  std::printf("2 mm against 1 mm: %.3f mm, against 0.5 mm: %.3f mm\n", fine, finer);
  EXPECT_LT(fine, 0.2);
  EXPECT_LT(finer, 0.2);
}

TEST(SurfaceCursor, AtARimItGoesAlongAndNeverOver) {
  // A hole in the skin, and the skin's own border.
  const Snapshot s = snapshot_of(flat_topology(60, 1, [](double x, double y) { return std::hypot(x - 10, y) < 8; }));
  SurfaceCursor c;
  c.set_gain(1);
  ASSERT_TRUE(c.put(s, Vec3(-10, 1, 0)));
  double moved_up = 0;
  for (int i = 0; i <= 400; ++i) {
    c.tick(s, hand_at({0.1 * i, 0.05 * i, 0}), false, false);
    expect_on_surface(s, c);
    ASSERT_EQ(s.topology->view.kind[size_t(c.place().triangle)], FaceKind::skin);
    moved_up = std::max(moved_up, c.x_mm().y());
  }
  // Pushed against the hole with a part along it, it slides round and comes past.
  EXPECT_GT(c.x_mm().x(), 12);
  EXPECT_GT(moved_up, 8);
  // Away from the border it moves at once.
  for (int i = 0; i < 2000; ++i) c.tick(s, hand_at({40 + 0.1 * i, 20, 0}), false, false);
  EXPECT_NEAR(c.x_mm().x(), 60, 1e-6);
  c.tick(s, hand_at({239.8, 20, 0}), false, false);
  EXPECT_LT(c.x_mm().x(), 60);
}

TEST(SurfaceCursor, FoldsSliversAndRoughSurfaces) {
  Dice dice{8};
  for (int round = 0; round < 12; ++round) {
    Mesh m = sphere(40, 3);
    // Rough, and every tenth vertex pulled onto a neighbour: slivers, some without any area.
    for (Vec3& X : m.X) X *= 1 + 0.06 * (dice.unit() - 0.5);
    for (size_t t = 0; t < m.tri.size(); t += 10) {
      const Tri& k = m.tri[t];
      m.X[size_t(k[0])] = m.X[size_t(k[1])] + (round % 3) * 1e-3 * Vec3(dice.normal(), dice.normal(), dice.normal());
    }
    const Snapshot s = snapshot_of(topology_of(m));
    SurfaceCursor c;
    c.set_gain(1);
    ASSERT_TRUE(c.put(s, Vec3(5, 3, 60)));
    Vec3 hand = Vec3::Zero(), before = c.x_mm();
    double travelled = 0;
    for (int i = 0; i < 3000; ++i) {
      // The direction turns with the surface, so that there is always a way.
      const Vec3 n = c.x_mm().normalized(),
                 along = n.cross(Vec3(std::sin(0.002 * i), 1, std::cos(0.001 * i))).normalized();
      hand += 0.2 * along;
      c.tick(s, hand_at(hand), false, false);
      expect_on_surface(s, c);
      const double step = (c.x_mm() - before).norm();
      ASSERT_LT(step, 0.2 + 0.06) << "it jumped";  // slivers are crossed: a thousandth of their longest edge
      travelled += step;
      before = c.x_mm();
    }
    EXPECT_GT(travelled, 3000 * 0.2 * 0.6) << round;
  }
}

TEST(SurfaceCursor, MovesWithTheSkin) {
  auto t = flat_topology(40, 1);
  Snapshot s = snapshot_of(t);
  SurfaceCursor c;
  c.set_gain(0.5);
  c.put(s, Vec3(5, 5, 0));
  c.tick(s, hand_at({0, 0, 0}), false, false);
  for (int i = 1; i <= 500; ++i) {
    const double a = 0.004 * i;  // the skin is pulled and bulges
    s = snapshot_of(t, [&](const Vec3& X) { return Vec3(X.x() * (1 + 0.1 * a), X.y(), 2 * a * std::sin(X.x() / 10)); });
    const SurfacePlace before = c.place();
    c.tick(s, hand_at({0, 0, 0}), false, false);
    EXPECT_EQ(c.place(), before);
  }
  EXPECT_NEAR(c.x_mm().x(), 5 * 1.2, 1e-4);
  for (int i = 1; i <= 500; ++i) c.tick(s, hand_at({0.1 * i, 0, 0}), false, true);
  EXPECT_GT(c.path_size(), 20u);
  EXPECT_GT(c.x_mm().x(), 20);
}

TEST(SurfaceCursor, ACutFindsItAtTheSamePlace) {
  const Snapshot coarse = snapshot_of(flat_topology(40, 1));
  SurfaceCursor c;
  c.put(coarse, Vec3(7.3, -4.1, 0));
  const Vec3 X = c.X_mm();
  // A new topology with other triangles; a wound opens beside the place and carries the bank away.
  const auto moved = [](const Vec3& p) { return Vec3(p.x() + (p.x() > 6 ? 3 : 0), p.y(), 0.5 * std::sin(p.y())); };
  const Snapshot after = snapshot_of(flat_topology(97, 2), moved);
  c.tick(after, hand_at({0, 0, 0}), false, false);
  EXPECT_LT((c.X_mm() - X).norm(), 1e-9);
  EXPECT_GT(c.x_mm().x(), 9);
  EXPECT_EQ(c.moved_by_cuts(), 0);
  // What it stood on is cut away: the nearest that is left, and it says so.
  const Snapshot gone =
      snapshot_of(flat_topology(97, 3, [](double x, double y) { return std::hypot(x - 7.3, y + 4.1) < 5; }));
  c.tick(gone, hand_at({0, 0, 0}), false, false);
  EXPECT_EQ(c.moved_by_cuts(), 1);
  EXPECT_NEAR((c.X_mm() - X).norm(), 5, 1.5);
}

}  // namespace test_cursor
}  // namespace limberg
