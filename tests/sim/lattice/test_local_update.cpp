// The update at the cost of the cut gives what the update from the whole lattice gives, to the last bit.
#include <random>

#include "sim/lattice/embedding.h"
#include "sim/lattice/topology_parts.h"
#include "tests/sim/lattice/lattice_scene.h"

namespace limberg::test {
namespace {

void expect_same(const LatticeTopology& a, const LatticeTopology& b) {
  ASSERT_EQ(a.hash(), b.hash());
  ASSERT_EQ(a.cells.size(), b.cells.size());
  for (size_t i = 0; i < a.cells.size(); ++i) {
    EXPECT_EQ(a.cells[i].cell, b.cells[i].cell) << i;
    EXPECT_EQ(a.cells[i].piece, b.cells[i].piece) << i;
    EXPECT_EQ(a.cells[i].fraction, b.cells[i].fraction) << i;
    EXPECT_EQ(a.cells[i].node, b.cells[i].node) << i;
    EXPECT_EQ(a.cell_parent[i], b.cell_parent[i]) << i;
  }
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_EQ(a.nodes[i].lattice_node, b.nodes[i].lattice_node) << i;
    EXPECT_EQ(a.node_parent[i], b.node_parent[i]) << i;
    EXPECT_EQ(a.nodes[i].at, b.nodes[i].at) << i;
  }
  EXPECT_TRUE(a.copies == b.copies);
  EXPECT_TRUE(a.face_bits == b.face_bits);
  EXPECT_TRUE(a.node_in_material == b.node_in_material);
  EXPECT_TRUE(a.piece_sum == b.piece_sum);
  EXPECT_TRUE(a.links == b.links);
  EXPECT_EQ(a.pieces, b.pieces);
  EXPECT_EQ(a.piece_volume_mm3, b.piece_volume_mm3);
  EXPECT_EQ(a.piece_fixed, b.piece_fixed);
  EXPECT_EQ(a.volume_mm3, b.volume_mm3);
  EXPECT_EQ(a.walks, b.walks);
  EXPECT_EQ(a.walks_unresolved, b.walks_unresolved);
}

TEST(LocalUpdate, IsTheWholeUpdateToTheLastBit) {
  std::mt19937 random(7);
  const auto uniform = [&](double from, double to) { return from + (to - from) * (random() * (1.0 / 4294967296.0)); };
  const LatticeGrid g = grid_over(60, 12, 4.3);
  int through = 0, local = 0;
  for (int scene = 0; scene < 3; ++scene) {
    Arrangement a(wavy_slab(60, 12, 24, 0.8), grid());
    std::vector<std::shared_ptr<const LatticeTopology>> history{build_topology(g, material_surface(a))};
    for (int i = 0; i < 14; ++i) {
      const Vec2 p(uniform(-25, 25), uniform(-25, 25)), q(uniform(-25, 25), uniform(-25, 25));
      const bool deep = i % 5 == 4;  // from end to end and through: a piece comes off
      const Vec2 d = (q - p).normalized() * 90;
      const Blade blade = deep ? strip({p - d, p + d}, 3, -14) : strip({p, q}, 3, -uniform(1, 11));
      if (!a.cut(blade, uint64_t(100 * scene + i)).ok()) continue;
      const MaterialSurface surface = material_surface(a);
      const auto whole = update_topology(*history.back(), surface, false);
      const auto fast = update_topology(*history.back(), surface, true);
      expect_same(*fast, *whole);
      ASSERT_EQ(check_topology(*fast), "");
      through += fast->pieces > history.back()->pieces;
      ++local;
      if (i % 6 == 5)
        a.undo();
      else
        history.push_back(fast);
    }
  }
  EXPECT_GT(through, 3);
  EXPECT_GT(local, 30);
}

void expect_same(const SurfaceView& a, const SurfaceView& b) {
  ASSERT_EQ(a.X_mm.size(), b.X_mm.size());
  EXPECT_TRUE(a.X_mm == b.X_mm);
  EXPECT_TRUE(a.point == b.point);
  EXPECT_TRUE(a.cell_copy == b.cell_copy);
  EXPECT_TRUE(a.tri == b.tri);
  EXPECT_TRUE(a.uv == b.uv);
  EXPECT_TRUE(a.kind == b.kind);
  EXPECT_TRUE(a.sided_face == b.sided_face);
  EXPECT_TRUE(a.component == b.component);
  EXPECT_TRUE(a.origin == b.origin);
}

// The surface that is drawn is a function of the state alone: put together from the version before it is, byte for byte, what
// it is from nothing; after cuts, deepenings along the old front, excisions and undo.
TEST(LocalUpdate, ViewAndEmbeddingAreThoseFromNothing) {
  std::mt19937 random(11);
  const auto uniform = [&](double from, double to) { return from + (to - from) * (random() * (1.0 / 4294967296.0)); };
  struct Version {
    std::shared_ptr<const LatticeTopology> lattice;
    SurfaceView view;
    std::vector<EmbeddedPoint> embedding;
  };
  int cuts = 0, excised = 0, kept = 0, found = 0;
  for (int levels : {0, 0, 2}) {
    Arrangement a(wavy_slab(60, 12, 24, 0.8), grid());
    std::vector<Version> history(1);
    history[0].lattice = build_topology(grid_over(60, 12, 4.3), material_surface(a), levels);
    history[0].view = a.surface_view();
    history[0].embedding = embed_surface(*history[0].lattice, material_surface(a), history[0].view);
    for (int i = 0; i < 16; ++i) {
      const Vec2 p(uniform(-25, 25), uniform(-25, 25)), q(uniform(-25, 25), uniform(-25, 25));
      if (i % 5 == 4) {  // a corner comes off and is taken away
        const Vec2 d = (q - p).normalized() * 90;
        if (!a.cut(strip({p - d, p + d}, 3, -14), uint64_t(i)).ok()) continue;
        const auto& all = a.components();
        int32_t least = 0;
        for (size_t c = 0; c < all.size(); ++c)
          if (all[c].volume_mm3 > 0 && all[c].volume_mm3 < all[size_t(least)].volume_mm3) least = int32_t(c);
        excised += a.excise(least).done;
      } else {
        Blade blade = strip({p, q}, 3, -uniform(1, 6));
        const CutResult r = a.cut(blade, uint64_t(i));
        if (!r.ok()) continue;
        if (i % 3 == 0) {  // deeper, from the points of its front
          Blade deeper;
          std::vector<int32_t> name(blade.vertex.size(), -1);
          for (size_t v = 1; v < blade.vertex.size(); v += 2) {
            const Int3 front = a.explicit_point(r.blade_point[v]);
            deeper.vertex.push_back(front), deeper.shared_point.push_back(r.blade_point[v]);
            deeper.vertex.push_back({front.x, front.y, front.z - 2 * 8192}), deeper.shared_point.push_back(-1);
          }
          for (int32_t v = 0; v + 3 < int32_t(deeper.vertex.size()); v += 2)
            deeper.tri.push_back({v, v + 1, v + 3}), deeper.tri.push_back({v, v + 3, v + 2});
          deeper.seed.assign(deeper.tri.size(), 2);
          a.cut(deeper, 1);
        }
      }
      a.sweep_debris(1);
      ++cuts;
      const Version& before = history.back();
      const MaterialSurface surface = material_surface(a);
      Version now;
      try {
        now.lattice = update_topology(*before.lattice, surface);
      } catch (const std::exception&) {
        break;  // the lattice's own tests are elsewhere
      }
      std::vector<int32_t> earlier;
      now.view = a.surface_view(before.view, int32_t(before.lattice->face_bits.size()), &earlier);
      now.embedding = embed_surface(*now.lattice, surface, now.view, {*before.lattice, before.view, before.embedding, earlier});
      SurfaceView view = a.surface_view();
      const auto embedding = embed_surface(*now.lattice, surface, view);
      expect_same(now.view, view);
      ASSERT_EQ(now.embedding.size(), embedding.size());
      for (size_t v = 0; v < embedding.size(); ++v) {
        ASSERT_EQ(now.embedding[v].node, embedding[v].node) << v;
        ASSERT_EQ(now.embedding[v].w, embedding[v].w) << v;
      }
      for (int32_t u : earlier) ++(u < 0 ? found : kept);
      if (i % 4 == 3) {  // back, and on from there
        const int32_t then = int32_t(before.lattice->face_bits.size());
        while (int32_t(a.faces().size()) > then) a.undo();
      } else {
        history.push_back(std::move(now));
      }
    }
  }
  EXPECT_GT(cuts, 30);
  EXPECT_GT(excised, 3);
  EXPECT_GT(kept, 5 * found);
}

}  // namespace
}  // namespace limberg::test
