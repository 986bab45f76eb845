// The update at the cost of the cut gives what the update from the whole lattice gives, to the last bit.
#include <random>

#include "sim/body/block.h"
#include "sim/lattice/embedding.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/lattice/grid_fit.h"
#include "sim/lattice/topology_parts.h"
#include "tests/sim/lattice/lattice_scene.h"

namespace limberg::test {
namespace test_local_update {

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
  ASSERT_EQ(a.hanging.size(), b.hanging.size());
  for (size_t i = 0; i < a.hanging.size(); ++i) {
    EXPECT_EQ(a.hanging[i].node, b.hanging[i].node) << i;
    EXPECT_EQ(a.hanging[i].count, b.hanging[i].count) << i;
    EXPECT_EQ(a.hanging[i].master, b.hanging[i].master) << i;
  }
  ASSERT_EQ(a.born.size(), b.born.size());
  for (size_t i = 0; i < a.born.size(); ++i) {
    EXPECT_EQ(a.born[i].node, b.born[i].node) << i;
    EXPECT_EQ(a.born[i].from, b.born[i].from) << i;
  }
  EXPECT_TRUE(a.tree.division == b.tree.division);
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

void expect_same(const FemModel& a, const FemModel& b);

// With divided fronts: histories of cuts, undermining, excisions
// and undo. Model and embedding are those of the whole, too.
TEST(LocalUpdate, OfDividedFrontsIsTheWholeUpdateToTheLastBit) {
  std::mt19937 random(11);
  const auto uniform = [&](double from, double to) { return from + (to - from) * (random() * (1.0 / 4294967296.0)); };
  BlockSpec spec;
  spec.size_mm = {48, 40, 12};
  spec.skin_cell_mm = 2;
  spec.layers = {{"skin", 2, {}}, {"fat", 10, {}}};
  spec.layers[0].material.prestretch_along = 1.1;
  const auto body = std::make_shared<const Body>(make_block(spec));
  const Skin skin(body);
  int updates = 0, apart = 0, born = 0, refilled = 0, excised = 0;
  for (int scene = 0; scene < 6; ++scene) {
    const LatticeGrid g = fit_lattice(*body, 4, kLevels);
    const StencilTable table(skin, g);
    Arrangement a(body->surface, body->grid);
    struct Version {
      std::shared_ptr<const LatticeTopology> lattice;
      std::shared_ptr<const FemModel> model;
      SurfaceView view;
      SharedArray<EmbeddedPoint> embedding;
    };
    Grading grading;
    if (scene > 3) {  // graded, too
      grading.wound_level = scene - 3;
      GradedZone z;
      z.from_mm = {-10, 4, 0}, z.to_mm = {6, 4, 0}, z.radius_mm = 5, z.depth_mm = 4, z.level = 2;
      grading.zones.push_back(z);
    }
    const int levels = scene == 3 ? 2 : scene == 5 ? 0 : kLevels;
    Version v{build_topology(g, material_surface(a), levels, grading), nullptr, a.surface_view(), {}};
    v.model = assemble_fem(table, *v.lattice);
    v.embedding = embed_surface(*v.lattice, material_surface(a), v.view);
    std::vector<Version> history{v};
    for (int i = 0; i < 12; ++i) {
      const Vec2 p(uniform(-18, 18), uniform(-15, 15)), q = p + Vec2(uniform(-14, 14), uniform(-14, 14));
      bool done = false;
      if (i % 5 == 3)
        done = a.cut(sheet({p.x(), p.y(), -uniform(2, 9)}, {uniform(4, 12), 0.3, 0.2},
                           {0.2, uniform(4, 9), uniform(-1, 1)}, 5, 5),
                     uint64_t(100 * scene + i))
                   .ok();
      else if (i % 5 == 4)
        done = a.cut(open_box({p + Vec2(4, 0), p + Vec2(0, 3), p + Vec2(-4, 0), p + Vec2(0, -3)}, 3, -uniform(3, 8)),
                     uint64_t(100 * scene + i))
                   .ok();
      else
        done = a.cut(strip({p, q}, 3, -uniform(1, 11)), uint64_t(100 * scene + i)).ok();
      if (!done) continue;
      const MaterialSurface surface = material_surface(a);
      const LatticeTopology& before = *v.lattice;
      const auto whole = update_topology(before, surface, false);
      const auto fast = update_topology(before, surface, true);
      expect_same(*fast, *whole);
      ASSERT_EQ(check_topology(*fast), "");
      const EarlierModel earlier{before, *v.model};
      Version next{fast, assemble_fem(table, *fast, &earlier), {}, {}};
      expect_same(*next.model, *assemble_fem(table, *whole));
      ViewChange change;
      next.view = a.surface_view(v.view, before.operations, change);
      next.embedding = embed_surface(*fast, surface, next.view, {before, v.view, v.embedding, change});
      SurfaceView alone = next.view;
      const auto embedding = embed_surface(*fast, surface, alone);
      EXPECT_TRUE(next.view.cell_copy == alone.cell_copy);
      EXPECT_TRUE(next.embedding == embedding);
      ++updates;
      apart += fast->cells.size() > before.cells.size(), born += int(fast->born.size());
      for (const auto& b : fast->born) refilled += size_t(b.node) < before.nodes.size();
      if (i % 4 == 3) {
        ASSERT_TRUE(a.undo());
        v = history.back();
        continue;
      }
      v = next;
      if (i % 5 == 4 && a.components().size() > 1) {  // takes the plug out: the whole way, and parts of what is left
        int smallest = 0;
        for (size_t c = 1; c < a.components().size(); ++c)
          if (a.components()[c].volume_mm3 < a.components()[size_t(smallest)].volume_mm3) smallest = int(c);
        if (a.excise(smallest).done) {
          const auto slow = update_topology(*v.lattice, material_surface(a), false),
                     quick = update_topology(*v.lattice, material_surface(a), true);
          expect_same(*quick, *slow);
          ASSERT_EQ(check_topology(*quick), "");
          v = {quick, assemble_fem(table, *quick), a.surface_view(), {}};
          v.embedding = embed_surface(*v.lattice, material_surface(a), v.view);
          ++excised;
        }
      }
      history.push_back(v);
    }
  }
  EXPECT_GT(updates, 25);
  EXPECT_GT(apart, 20);
  EXPECT_GT(born, 1000);
  EXPECT_GT(refilled, 0);  // numbers of nodes that are gone pass to new ones
  EXPECT_GT(excised, 1);
}

void expect_same(const FemModel& a, const FemModel& b) {
  ASSERT_EQ(a.hanging.size(), b.hanging.size());
  for (size_t i = 0; i < a.hanging.size(); ++i)
    EXPECT_TRUE(a.hanging[i].node == b.hanging[i].node && a.hanging[i].master == b.hanging[i].master);

  EXPECT_TRUE(a.X_mm == b.X_mm);
  EXPECT_TRUE(a.fixed == b.fixed);
  EXPECT_TRUE(a.mass_kg == b.mass_kg);
  EXPECT_TRUE(a.cells == b.cells);
  EXPECT_TRUE(a.parent == b.parent);
  EXPECT_EQ(a.stencils.size(), b.stencils.size());
}

// The same mesh, whatever its numbers: triangles are named by sided faces, and each has one vertex for the other's.
void expect_same(const SurfaceView& a, const SharedArray<EmbeddedPoint>& of_a, const SurfaceView& b,
                 const SharedArray<EmbeddedPoint>& of_b) {
  ASSERT_EQ(a.X_mm.size(), b.X_mm.size());
  ASSERT_EQ(a.tri.size(), b.tri.size());
  for (const SurfaceView* v : {&a, &b}) {
    ASSERT_EQ(v->cell_copy.size(), v->X_mm.size());
    ASSERT_EQ(v->point.size(), v->X_mm.size());
    ASSERT_EQ(v->corners.size(), v->X_mm.size());
    for (size_t n : {v->uv.size(), v->kind.size(), v->sided_face.size(), v->origin.size(), v->rim.size()})
      ASSERT_EQ(n, v->tri.size());
    size_t named = 0;
    for (int32_t t : v->triangle_of) named += t >= 0;
    ASSERT_EQ(named, v->tri.size());
  }
  ASSERT_EQ(of_a.size(), a.X_mm.size());
  ASSERT_EQ(of_b.size(), b.X_mm.size());
  ASSERT_EQ(a.triangle_of.size(), b.triangle_of.size());
  std::vector<int32_t> partner(a.X_mm.size(), -1), back(a.X_mm.size(), -1);
  for (size_t t = 0; t < a.tri.size(); ++t) {
    const int32_t sided = a.sided_face[t];
    ASSERT_EQ(a.triangle_of[size_t(sided)], int32_t(t));
    const size_t u = size_t(b.triangle_of[size_t(sided)]);
    ASSERT_LT(u, b.tri.size());
    EXPECT_EQ(a.uv[t], b.uv[u]);
    EXPECT_EQ(a.kind[t], b.kind[u]);
    EXPECT_EQ(a.origin[t], b.origin[u]);
    EXPECT_EQ(a.rim[t], b.rim[u]);
    for (size_t k = 0; k < 3; ++k) {
      const int32_t v = a.tri[t][k], w = b.tri[u][k];
      ASSERT_TRUE(partner[size_t(v)] < 0 || partner[size_t(v)] == w);
      ASSERT_TRUE(back[size_t(w)] < 0 || back[size_t(w)] == v);
      partner[size_t(v)] = w, back[size_t(w)] = v;
    }
  }
  for (size_t v = 0; v < partner.size(); ++v) {
    ASSERT_GE(partner[v], 0) << "a vertex without a triangle";
    const size_t w = size_t(partner[v]);
    EXPECT_EQ(a.X_mm[v], b.X_mm[w]);
    EXPECT_EQ(a.point[v], b.point[w]);
    EXPECT_EQ(a.corners[v], b.corners[w]);
    EXPECT_EQ(a.cell_copy[v], b.cell_copy[w]);
    EXPECT_EQ(of_a[v], of_b[w]);
  }
}

// What was not said to change has not changed.
void expect_kept(const SurfaceView& before, const SurfaceView& now, const ViewChange& change) {
  const auto in = [](const std::vector<int32_t>& list, size_t i) {
    return std::binary_search(list.begin(), list.end(), int32_t(i));
  };
  for (size_t v = 0; v < now.X_mm.size(); ++v)
    if (!in(change.vertices, v)) {
      ASSERT_LT(v, before.X_mm.size());
      EXPECT_EQ(now.point[v], before.point[v]);
    }
  for (size_t t = 0; t < now.tri.size(); ++t)
    if (!in(change.triangles, t)) {
      ASSERT_LT(t, before.tri.size());
      EXPECT_EQ(now.tri[t], before.tri[t]);
      EXPECT_EQ(now.sided_face[t], before.sided_face[t]);
      EXPECT_EQ(now.rim[t], before.rim[t]);
    }
}

// The surface that is drawn is a function of the state alone: made from the version before it is, up to its numbers,
// what it is from nothing; after cuts, deepenings along the old front, excisions and undo. So is the model.
TEST(LocalUpdate, ViewAndEmbeddingAreThoseFromNothing) {
  std::mt19937 random(11);
  const auto uniform = [&](double from, double to) { return from + (to - from) * (random() * (1.0 / 4294967296.0)); };
  struct Version {
    std::shared_ptr<const LatticeTopology> lattice;
    SurfaceView view;
    SharedArray<EmbeddedPoint> embedding;
    std::shared_ptr<const FemModel> model;
  };
  int cuts = 0, excised = 0, kept = 0, followed = 0, deepened = 0;
  for (int levels : {0, 0, 2}) {
    Arrangement a(wavy_slab(60, 12, 24, 0.8), grid());
    std::vector<Version> history(1);
    history[0].lattice = build_topology(grid_over(60, 12, 4.3), material_surface(a), levels);
    Body slab;
    slab.grid = grid();
    slab.surface = wavy_slab(60, 12, 24, 0.8);
    slab.layers.resize(2);
    slab.layers[0].thickness_mm = 2, slab.layers[1].thickness_mm = 5;
    slab.box_min_mm = {-30, -30, -12}, slab.box_max_mm = {30, 30, 0.8};
    const auto body = std::make_shared<const Body>(std::move(slab));
    const Skin skin(body);
    const StencilTable stencils(skin, history[0].lattice->grid);
    history[0].model = assemble_fem(stencils, *history[0].lattice);
    history[0].view = a.surface_view();
    history[0].embedding = embed_surface(*history[0].lattice, material_surface(a), history[0].view);
    Blade deeper;  // from the front of the cut before: there vertices come apart
    for (int i = 0; i < 16; ++i) {
      const Vec2 p(uniform(-25, 25), uniform(-25, 25)), q(uniform(-25, 25), uniform(-25, 25));
      if (!deeper.tri.empty()) {
        deepened += a.cut(deeper, 1).ok();
        deeper = {};
      } else if (i % 5 == 4) {  // a corner comes off and is taken away
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
        if (i % 3 == 0) {
          std::vector<int32_t> name(blade.vertex.size(), -1);
          for (size_t v = 1; v < blade.vertex.size(); v += 2) {
            const Int3 front = a.explicit_point(r.blade_point[v]);
            deeper.vertex.push_back(front), deeper.shared_point.push_back(r.blade_point[v]);
            deeper.vertex.push_back({front.x, front.y, front.z - 2 * 8192}), deeper.shared_point.push_back(-1);
          }
          for (int32_t v = 0; v + 3 < int32_t(deeper.vertex.size()); v += 2)
            deeper.tri.push_back({v, v + 1, v + 3}), deeper.tri.push_back({v, v + 3, v + 2});
          deeper.seed.assign(deeper.tri.size(), 2);
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
      ViewChange change;
      now.view = a.surface_view(before.view, before.lattice->operations, change);
      now.embedding =
          embed_surface(*now.lattice, surface, now.view, {*before.lattice, before.view, before.embedding, change});
      SurfaceView view = a.surface_view();
      const auto embedding = embed_surface(*now.lattice, surface, view);
      expect_same(now.view, now.embedding, view, embedding);
      if (!change.whole) {
        expect_kept(before.view, now.view, change);
        ++followed, kept += change.vertices.size() < now.view.X_mm.size() / 2;
      }
      const EarlierModel earlier{*before.lattice, *before.model};
      now.model = assemble_fem(stencils, *now.lattice, &earlier);
      expect_same(*now.model, *assemble_fem(stencils, *now.lattice));
      if (i % 4 == 3) {  // back, and on from there
        while (a.operations() > before.lattice->operations) a.undo();
        deeper = {};
      } else {
        history.push_back(std::move(now));
      }
    }
  }
  EXPECT_GT(cuts, 30);
  EXPECT_GT(excised, 3);
  EXPECT_GT(deepened, 3);
  EXPECT_GT(followed, 15);
  EXPECT_GT(kept, 10);
}

}  // namespace test_local_update
}  // namespace limberg::test
