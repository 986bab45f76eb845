#include <map>

#include "sim/lattice/embedding.h"
#include "tests/sim/lattice/lattice_scene.h"

namespace limberg::test {
namespace test_embedding {

const std::vector<Vec2> kRhombus{{10, 0}, {0, 6}, {-10, 0}, {0, -6}};

struct Skin : ::testing::Test {
  LatticeScene s{wavy_slab(60, 12, 24, 0.8), grid_over(60, 12, 3.0)};

  static Vec3 at(const EmbeddedPoint& e, const std::vector<Vec3>& u) {
    Vec3 x = Vec3::Zero();
    for (size_t k = 0; k < 8; ++k) x += double(e.w[k]) * u[size_t(e.node[k])];
    return x;
  }
  std::vector<Vec3> rest(const LatticeTopology& t) const {
    std::vector<Vec3> X;
    for (const NodeCopy& n : t.nodes) X.push_back(t.grid.node_mm(t.grid.node_at(n.lattice_node)));
    return X;
  }
  void cut_everything() {
    ASSERT_TRUE(s.cut(open_box(kRhombus, 3, -6)));
    ASSERT_TRUE(s.excise_smallest());
    ASSERT_TRUE(s.cut(strip({{0.1, 4}, {4, 16}, {14, 14}}, 3, -6)));
    ASSERT_TRUE(s.cut(sheet({-2, 4, -5}, {18, 0.1, 0}, {0.1, 13, 0.1}, 9, 7)));
  }
};

TEST_F(Skin, WeightsReproduceRestPositions) {
  cut_everything();
  SurfaceView view = s.a.surface_view();
  const auto e = embed_surface(*s.t, material_surface(s.a), view);
  const auto X = rest(*s.t);
  for (size_t v = 0; v < e.size(); ++v) {
    ASSERT_GE(view.cell_copy[v], 0);
    float sum = 0;
    for (float w : e[v].w) {
      sum += w;
      EXPECT_GE(w, -1e-5f);
    }
    EXPECT_NEAR(sum, 1, 8 * 0x1p-23);
    EXPECT_LT((at(e[v], X) - view.X_mm[v]).norm(), 60 * 8 * 0x1p-24);  // float weights times coordinates
  }
}

// The whole chain of cuts under an arbitrary displacement: what was there before stays exactly where it was.
TEST_F(Skin, NothingJumpsAtACut) {
  SurfaceView view = s.a.surface_view();
  auto e = embed_surface(*s.t, material_surface(s.a), view);
  std::vector<Vec3> u;
  for (size_t n = 0; n < s.t->nodes.size(); ++n)
    u.push_back(Vec3(std::sin(1.0 * n), std::cos(1.7 * n), std::sin(0.3 * n)));
  std::vector<std::function<bool()>> steps{[&] { return s.cut(open_box(kRhombus, 3, -6)); },
                                           [&] { return s.excise_smallest(); },
                                           [&] {
                                             return s.cut(strip({{0.1, 4}, {4, 16}, {14, 14}}, 3, -6));
                                           },
                                           [&] {
                                             return s.cut(sheet({-2, 4, -5}, {18, 0.1, 0}, {0.1, 13, 0.1}, 9, 7));
                                           },
                                           [&] {
                                             return s.cut(strip({{8, 20}, {7, 8}}, 3, -3));
                                           }};
  for (auto& step : steps) {
    ASSERT_TRUE(step());
    std::map<std::pair<int32_t, int32_t>, Vec3> before;  // (sided face, point) -> position
    for (size_t f = 0; f < view.tri.size(); ++f)
      for (int32_t v : view.tri[f]) before[{view.sided_face[f], view.point[size_t(v)]}] = at(e[size_t(v)], u);
    std::vector<Vec3> carried;
    for (size_t n = 0; n < s.t->nodes.size(); ++n) carried.push_back(u[size_t(s.t->node_parent[n])]);
    u = carried;
    view = s.a.surface_view();
    e = embed_surface(*s.t, material_surface(s.a), view);
    size_t same = 0;
    for (size_t f = 0; f < view.tri.size(); ++f)
      for (int32_t v : view.tri[f]) {
        const auto it = before.find({view.sided_face[f], view.point[size_t(v)]});
        if (it == before.end()) continue;
        ++same;
        ASSERT_EQ((at(e[size_t(v)], u) - it->second).norm(), 0) << "vertex " << v;
      }
    EXPECT_GT(same, view.tri.size());
  }
}

// The two banks of a cut deeper than a cell follow different copies.
TEST_F(Skin, BanksSeparate) {
  ASSERT_TRUE(s.cut(strip({{-40, 0.3}, {40, 1.1}}, 3, -20)));
  SurfaceView view = s.a.surface_view();
  const auto e = embed_surface(*s.t, material_surface(s.a), view);
  std::vector<Vec3> u;
  for (const NodeCopy& n : s.t->nodes) u.push_back(Vec3::Zero()), (void)n;
  for (const CellCopy& c : s.t->cells)
    for (int32_t n : c.node) u[size_t(n)] = c.piece == 0 ? Vec3(0, 1, 0) : Vec3(0, -1, 0);
  for (size_t f = 0; f < view.tri.size(); ++f)
    for (int32_t v : view.tri[f]) {
      const double y = at(e[size_t(v)], u).y();
      EXPECT_NEAR(std::abs(y), 1, 1e-6);
      const int32_t piece = s.t->cells[size_t(view.cell_copy[size_t(v)])].piece;
      EXPECT_EQ(y > 0, piece == 0);
      EXPECT_EQ(s.a.component_of(view.sided_face[f]), s.a.component_of(view.sided_face[0]) == 0 ? piece : 1 - piece);
    }
}

TEST_F(Skin, PointsInsideTriangles) {
  cut_everything();
  SurfaceView view = s.a.surface_view();
  embed_surface(*s.t, material_surface(s.a), view);
  const auto X = rest(*s.t);
  uint64_t r = 1;
  auto random = [&] { return double((r = r * 6364136223846793005ull + 1442695040888963407ull) >> 40) * 0x1p-24; };
  for (int i = 0; i < 3000; ++i) {
    const int32_t f = int32_t(random() * double(view.tri.size()));
    const double a = random(), b = random() * (1 - a);
    Vec3 where;
    const EmbeddedPoint e = embed_point(*s.t, view, f, {a, b, 1 - a - b}, &where);
    EXPECT_LT((at(e, X) - where).norm(), 60 * 8 * 0x1p-24);
    const int32_t piece = s.t->cells[size_t(view.cell_copy[size_t(view.tri[size_t(f)][0])])].piece;
    bool found = false;  // the node copies of the point belong to the piece of its triangle
    for (const CellCopy& c : s.t->cells) found = found || (c.node == e.node && c.piece == piece);
    EXPECT_TRUE(found);
  }
}

}  // namespace test_embedding
}  // namespace limberg::test
