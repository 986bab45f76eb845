// What no lattice edge sees: tunnels, bumps, cavities, islands in cavities, cracks that end inside a cell.
#include "tests/sim/lattice/lattice_scene.h"
#include "tests/sim/lattice/voxel_oracle.h"

namespace limberg::test {
namespace test_cells_closed {

// A sphere of triangles, an octahedron divided `level` times; turned inside out when `inward`.
void add_sphere(TriMesh& m, const Vec3& centre, double radius, int level, bool inward) {
  std::vector<Vec3> x{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<Tri> t;
  for (int s = 0; s < 8; ++s) {
    Tri f{s & 1, 2 + (s >> 1 & 1), 4 + (s >> 2 & 1)};
    if (x[size_t(f[0])].cross(x[size_t(f[1])]).dot(x[size_t(f[2])]) < 0) std::swap(f[1], f[2]);
    t.push_back(f);
  }
  for (int l = 0; l < level; ++l) {
    std::map<std::pair<int32_t, int32_t>, int32_t> middle;
    const auto mid = [&](int32_t a, int32_t b) {
      const auto [it, made] = middle.try_emplace({std::min(a, b), std::max(a, b)}, int32_t(x.size()));
      if (made) x.push_back((x[size_t(a)] + x[size_t(b)]).normalized());
      return it->second;
    };
    std::vector<Tri> finer;
    for (const Tri& f : t) {
      const int32_t a = mid(f[0], f[1]), b = mid(f[1], f[2]), c = mid(f[2], f[0]);
      finer.insert(finer.end(), {{f[0], a, c}, {a, f[1], b}, {c, b, f[2]}, {a, b, c}});
    }
    t = finer;
  }
  const int32_t first = int32_t(m.X_mm.size());
  const RestGrid g = grid();
  for (const Vec3& p : x) m.X_mm.push_back(g.to_mm(g.to_grid(centre + radius * p)));
  for (const Tri& f : t) {
    m.tri.push_back(inward ? Tri{first + f[0], first + f[2], first + f[1]}
                           : Tri{first + f[0], first + f[1], first + f[2]});
    m.tag.push_back(SurfaceTag::skin);
    m.uv.push_back({});
  }
}

LatticeGrid cubes(double half_mm, double cell_mm, const Vec3& shift_mm = Vec3::Zero()) {
  LatticeGrid g;
  g.rest = grid();
  const double u = g.rest.half_unit_mm();
  const int32_t pitch = 2 * int32_t(std::lround(cell_mm / u / 2));
  const int n = int(2 * half_mm / cell_mm) + 2;
  const auto odd = [&](double mm) { return 2 * int32_t(std::floor(mm / u / 2)) + 1; };
  const double low = -0.5 * n * cell_mm;
  g.origin = {odd(low + shift_mm.x()), odd(low + shift_mm.y()), odd(low + shift_mm.z())};
  g.pitch = {pitch, pitch, pitch};
  g.count = {n, n, n};
  return g;
}

// Onions: concentric shells. Each layer of material is one piece, however the lattice lies; the ball at the heart and
// the walls between are tori, rings, islands and lakes on the squares.
TEST(CellsClosed, OnionHasAsManyPiecesAsLayers) {
  TriMesh m;
  int k = 0;
  for (double r : {10.0, 9.3, 7.2, 6.0, 4.4, 3.9, 1.1})
    add_sphere(m, {0.03 * k, -0.02 * k, 0.01 * k}, r, 3, k % 2 == 1), ++k;
  int walks = 0;
  for (double cell : {25.0, 13.0, 9.0, 6.1, 4.0, 2.3})
    for (const Vec3& shift : {Vec3(0, 0, 0), Vec3(0.31 * cell, -0.17 * cell, 0.41 * cell)}) {
      const LatticeScene s(m, cubes(11 + 0.5 * cell, cell, shift));
      EXPECT_EQ(s.t->pieces, 4) << cell;
      std::vector<double> piece = s.t->piece_volume_mm3, layer;
      double before = 0;
      for (const auto& c : s.a.components()) {  // outermost first: the order of the mesh
        if (c.volume_mm3 > 0)
          layer.push_back(before = c.volume_mm3);
        else
          layer.back() += c.volume_mm3;
      }
      std::sort(piece.begin(), piece.end());
      std::sort(layer.begin(), layer.end());
      ASSERT_EQ(piece.size(), layer.size());
      for (size_t i = 0; i < piece.size(); ++i) EXPECT_NEAR(piece[i], layer[i], 1e-9 * 4200);
      walks += s.t->walks;
    }
  EXPECT_GT(walks, 30);
}

// Random bubbles and islands in a ball, off the lattice's symmetry; the same surface in random lattices.
TEST(CellsClosed, BubblesAndIslands) {
  uint64_t state = 3;
  const auto random = [&](double lo, double hi) {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return lo + (hi - lo) * double(state >> 33) * 0x1p-31;
  };
  for (int round = 0; round < 12; ++round) {
    TriMesh m;
    add_sphere(m, Vec3::Zero(), 10, 3, false);
    std::vector<std::pair<Vec3, double>> bubbles;
    int islands = 0;
    for (int tries = 0; tries < 60; ++tries) {
      const Vec3 c(random(-8, 8), random(-8, 8), random(-8, 8));
      const double r = random(0.2, 2.5);
      bool free = c.norm() + r < 9.2;
      for (const auto& [d, s] : bubbles) free = free && (c - d).norm() > r + s + 0.05;
      if (!free) continue;
      bubbles.push_back({c, r});
      add_sphere(m, c, r, 1, true);
      if (random(0, 1) < 0.5) add_sphere(m, c, 0.45 * r, 1, false), ++islands;
    }
    const double cell = random(1.5, 12);
    const LatticeScene s(
        m, cubes(11 + 0.5 * cell, cell, {random(0, 0.4) * cell, random(0, 0.4) * cell, random(0, 0.4) * cell}));
    EXPECT_EQ(s.t->pieces, 1 + islands);
    EXPECT_GT(s.t->walks, 5);
    const VoxelOracle oracle(s.a);
    for (size_t c = 0; c < s.t->components.size(); c += 1 + s.t->components.size() / 20) {
      const auto& comp = s.t->components[c];
      if (!comp) continue;
      std::vector<double> exact;
      for (const CellClass& k : comp->classes) exact.push_back(k.fraction);
      std::sort(exact.rbegin(), exact.rend());
      const auto seen = oracle.pieces(s.g, int32_t(c), 40);
      for (size_t i = 0; i < std::min(exact.size(), seen.size()); ++i)
        EXPECT_NEAR(exact[i], seen[i], 0.02) << round << " " << c;
    }
  }
}

// A narrow drill down the middle of a column of cells touches no lattice edge.
TEST(CellsClosed, NarrowDrill) {
  const LatticeGrid g = grid_over(60, 12, 5.0);
  LatticeScene s(wavy_slab(60, 12, 12, 0.4), g);
  const Vec3 c = g.node_mm({6, 6, 1}) + 0.5 * g.cell_mm();
  ASSERT_TRUE(s.cut(strip(
      {{c.x() + 0.7, c.y() + 0.1}, {c.x(), c.y() + 0.6}, {c.x() - 0.6, c.y()}, {c.x(), c.y() - 0.8}}, 3, -20, true)));
  EXPECT_EQ(s.t->pieces, 2);
  const int32_t inner = g.cell_index({6, 6, 1});
  EXPECT_EQ(s.t->copies_of(inner), 2);
  EXPECT_GT(s.t->walks, 0);
  ASSERT_TRUE(s.excise_smallest());
  EXPECT_EQ(s.t->pieces, 1);
  ASSERT_EQ(s.t->copies_of(inner), 1);
  EXPECT_EQ(s.t->components[size_t(inner)]->classes[0].corners, 255);
}

// A level sheet whose border pokes into cells through one
// square: its curve there is a crack that no level line crosses.
TEST(CellsClosed, BorderOfALevelSheet) {
  int walks = 0;
  for (int turn = 0; turn < 3; ++turn) {
    const LatticeGrid g = grid_over(60, 12, 5.0);
    LatticeScene s(wavy_slab(60, 12, 12, 0.4), g);
    ASSERT_TRUE(s.cut(strip({{0.3, -14}, {0.5, 14}}, 3, -7)));
    // A zigzag border: each tip ends inside a cell.
    const double x = g.node_mm({8, 0, 0}).x() + (turn == 1 ? 0.9 : 0.4);
    Blade b;
    for (int i = 0; i <= 12; ++i) {
      const double y = -12 + 2 * i + 0.1 * turn;
      b.vertex.push_back(at(-0.5, y, -6));
      b.vertex.push_back(at(i % 2 ? x : x - 2.2, y, -6));
    }
    for (int32_t i = 0; i < 12; ++i) {
      b.tri.push_back({2 * i, 2 * i + 3, 2 * i + 2});
      b.tri.push_back({2 * i, 2 * i + 1, 2 * i + 3});
    }
    b.seed.assign(b.tri.size(), 2);
    s.cut(b);
    walks += s.t->walks;
    EXPECT_EQ(s.t->pieces, 1);
  }
  EXPECT_GT(walks, 10);
}

// A small stab that ends inside a cell opens nothing there.
TEST(CellsClosed, StabIntoTheMiddleOfACell) {
  const LatticeGrid g = grid_over(60, 12, 7.0);
  LatticeScene s(wavy_slab(60, 12, 12, 0.4), g);
  const Vec3 c = g.node_mm({4, 4, 1}) + 0.5 * g.cell_mm();
  const size_t copies = s.t->cells.size();
  ASSERT_TRUE(s.cut(strip({{c.x() - 0.7, c.y()}, {c.x() + 0.6, c.y() + 0.3}}, 3, c.z())));
  EXPECT_EQ(s.t->cells.size(), copies);
  EXPECT_GT(s.t->touched_cells, 0);
}

}  // namespace test_cells_closed
}  // namespace limberg::test
