// Where a place lies in moving cells, and what of the rest body is there: against the map itself, winding numbers and
// all triangles one by one.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim/contact/contact_surface.h"
#include "sim/contact/moving_cells.h"
#include "sim/contact/rest_tissue.h"
#include "sim/geometry/triangle.h"
#include "sim/measure/penetration.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"
#include "tests/sim/contact/plain_block.h"

namespace limberg {
namespace test_rest_tissue {

/// A block with a Z that was cut and undermined: sharp tips, floors, walls that end in cells.
class RestTissueOfAWound : public ::testing::Test {
 protected:
  void SetUp() override {
    WorldSpec spec = test::plain_block(50);
    spec.contact = ContactChoice::automatic;
    world = std::make_unique<World>(spec, workers);
    ASSERT_TRUE(world->apply(Incise{{{-10, 0}, {0, 6}, {0, -6}, {10, 0}}, 4, 80}).done);
    std::vector<ChartPoint> outline;
    for (int k = 0; k < 16; ++k) outline.push_back({14 * std::cos(k * M_PI / 8), 12 * std::sin(k * M_PI / 8)});
    ASSERT_TRUE(world->apply(Undermine{outline, 3.3}).done);
    world->fill(shown);
    surface = contact_surface({shown.topology, &shown.topology->view}, shown.topology->embedding,
                              world->skin()->lattice(), model());
    ASSERT_TRUE(surface);
    tissue = std::make_unique<RestTissue>(*surface, model());
  }
  const FemModel& model() const { return world->skin()->solver().model(); }

  InlineWorkers workers;
  std::unique_ptr<World> world;
  Snapshot shown;
  std::shared_ptr<const ContactSurface> surface;
  std::unique_ptr<RestTissue> tissue;
  std::mt19937 random{7};
  double uniform(double lo, double hi) { return lo + (hi - lo) * double(random()) / 4294967296.0; }
};

TEST_F(RestTissueOfAWound, InverseOfEveryCellsMap) {
  std::vector<Vec3f> u(model().X_mm.size());
  for (size_t i = 0; i < u.size(); ++i) {  // bent and sheared: up to 4 mm and half a radian
    const Vec3& X = model().X_mm[i];
    u[i] = Vec3(0.3 * X.y() + 2 * std::sin(0.15 * X.z()), 2 * std::sin(0.12 * X.x()), 0.02 * X.x() * X.x() - 3)
               .cast<float>();
  }
  MovingCells cells(*tissue, model());
  cells.move(u);
  cells.refit(workers);
  int outside = 0;
  for (size_t c = 0; c < tissue->size(); ++c) {
    const auto& node = surface->lattice->cells[size_t(tissue->copy(c))].node;
    const auto map = [&](const Vec3& at) {
      Vec3 p = Vec3::Zero();
      for (size_t k = 0; k < 8; ++k) {
        const double w = (k & 1 ? at[0] : 1 - at[0]) * (k & 2 ? at[1] : 1 - at[1]) * (k & 4 ? at[2] : 1 - at[2]);
        p += w * (model().X_mm[size_t(node[k])] + u[size_t(node[k])].cast<double>());
      }
      return p;
    };
    for (int i = 0; i < 5; ++i) {
      const Vec3 at(uniform(0, 1), uniform(0, 1), uniform(0, 1));
      Vec3 found;
      ASSERT_TRUE(cells.may_hold(c, map(at).cast<float>(), 0));
      ASSERT_TRUE(cells.invert(c, map(at).cast<float>(), 0.01f, found));
      EXPECT_LT((found - at).norm(), 1e-4);  // single precision: 1e-7 of 50 mm, in cells of 3.5 mm, ten times over
      Vec3 beside = at;
      beside[i % 3] = i % 2 ? 1.2 : -0.2;
      outside += !cells.invert(c, map(beside).cast<float>(), 0.01f, found);
    }
  }
  EXPECT_EQ(outside, int(5 * tissue->size()));
}

// Whose boxes are near is what comparing all of them finds, each once: with cells that are much wider than others, and
// where cells have gone far since they were sorted.
TEST_F(RestTissueOfAWound, CopiesThatAreNearHoweverWideTheyAre) {
  MovingCells cells(*tissue, model());
  const auto& node = tissue->nodes();
  struct Motion {
    double shake_mm, pull_mm;
    size_t pulled;  // nodes
  };
  for (const Motion& m : {Motion{0, 0, 0}, {1, 0, 0}, {1, 20, 1}, {1, 35, 6}, {1, 600, 1}}) {
    const bool sorted = m.pulled < 6;
    std::vector<Vec3f> u(model().X_mm.size());
    for (Vec3f& d : u) d = Vec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).cast<float>() * float(m.shake_mm);
    std::vector<size_t> asked;
    for (size_t i = 0; i < m.pulled; ++i) {
      const size_t slot = size_t(random()) % node.size();
      u[size_t(node[slot])] +=
          Vec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized().cast<float>() * float(m.pull_mm);
      for (size_t c = 0; c < tissue->size(); ++c)
        if (std::ranges::find(tissue->slots(c), int32_t(slot)) != tissue->slots(c).end()) asked.push_back(c);
    }
    for (int i = 0; i < 60; ++i) asked.push_back(size_t(random()) % tissue->size());
    cells.move(u);
    cells.refit(workers);
    if (sorted) cells.sort();
    std::vector<std::pair<Vec3, Vec3>> box;
    size_t wide = 0;
    for (size_t c = 0; c < tissue->size(); ++c) {
      Vec3 lo = Vec3::Constant(1e30), hi = -lo;
      for (int32_t s : tissue->slots(c)) {
        const Vec3 x = model().X_mm[size_t(node[size_t(s)])] + u[size_t(node[size_t(s)])].cast<double>();
        lo = lo.cwiseMin(x), hi = hi.cwiseMax(x);
      }
      box.push_back({lo, hi});
      wide += (hi - lo).maxCoeff() > 10;  // of cells of 3.5 mm
    }
    EXPECT_GE(wide, m.pulled);
    for (size_t c : asked)
      for (float within : {0.f, 0.7f, 4.f}) {
        std::vector<int> visits(tissue->size());
        cells.near(c, within, [&](size_t o) { ++visits[o]; });
        for (size_t o = 0; o < tissue->size(); ++o) {
          const double gap = (box[o].first - box[c].second).cwiseMax(box[c].first - box[o].second).maxCoeff();
          if (std::abs(gap - double(within)) < 0.01) continue;  // boxes are larger by .001 on each side
          ASSERT_EQ(visits[o], !tissue->is_empty(o) && gap < double(within))
              << "copies " << c << ", " << o << ": " << gap << " mm apart";
        }
      }
  }
}

// Nobody is missed who holds a place or has it beside: neither alone nor among others that are asked about at once.
TEST_F(RestTissueOfAWound, WhoeverHoldsAPlaceIsAroundIt) {
  MovingCells cells(*tissue, model());
  std::vector<Vec3f> u(model().X_mm.size());
  for (size_t i = 0; i < u.size(); ++i) {  // bent, sheared and shaken: cells are neither boxes nor of one size
    const Vec3& X = model().X_mm[i];
    u[i] = Vec3(0.3 * X.y() + uniform(-0.4, 0.4), 2 * std::sin(0.12 * X.x()) + uniform(-0.4, 0.4),
                0.02 * X.x() * X.x() + uniform(-0.4, 0.4))
               .cast<float>();
  }
  cells.move(u);
  cells.refit(workers);
  cells.sort();
  int beside = 0;
  for (size_t c = 0; c < tissue->size(); ++c) {
    if (tissue->is_empty(c)) continue;
    const auto& node = surface->lattice->cells[size_t(tissue->copy(c))].node;
    for (int i = 0; i < 8; ++i) {
      Vec3 at(uniform(-0.15, 1.15), uniform(-0.15, 1.15), uniform(-0.15, 1.15)), p = Vec3::Zero(),
                                                                                 lo = Vec3::Constant(1e30), hi = -lo;
      for (size_t k = 0; k < 8; ++k) {
        const Vec3 x = model().X_mm[size_t(node[k])] + u[size_t(node[k])].cast<double>();
        const double w = (k & 1 ? at[0] : 1 - at[0]) * (k & 2 ? at[1] : 1 - at[1]) * (k & 4 ? at[2] : 1 - at[2]);
        p += w * x, lo = lo.cwiseMin(x), hi = hi.cwiseMax(x);
      }
      if ((p.array() < lo.array() - 0.59).any() || (p.array() > hi.array() + 0.59).any()) continue;  // kAhead_mm
      beside += (p.array() < lo.array() - 0.01).any() || (p.array() > hi.array() + 0.01).any();
      EXPECT_TRUE(cells.may_hold(c, p.cast<float>(), true));
      const Vec3f other = p.cast<float>() + Vec3f(float(uniform(-2, 2)), float(uniform(-2, 2)), float(uniform(-2, 2)));
      for (const Vec3f& q : {p.cast<float>().eval(), other}) {
        int visits = 0;
        cells.around(q.cwiseMin(p.cast<float>()), q.cwiseMax(p.cast<float>()), [&](size_t o) { visits += o == c; });
        EXPECT_EQ(visits, 1) << "copy " << c;
      }
    }
  }
  EXPECT_GT(beside, 100);
}

// At rest nothing overlaps: whatever place of the body is asked about, exactly one of the copies there has material.
TEST_F(RestTissueOfAWound, OneCopyHasTheMaterialOfEachPlace) {
  std::vector<Vec3f> rest;
  for (const Vec3& X : shown.topology->view.X_mm) rest.push_back(X.cast<float>());
  std::vector<size_t> carrying;  // copies with triangles: those of one cell are all kept
  for (size_t c = 0; c < tissue->size(); ++c)
    if (std::find(surface->carrier.begin(), surface->carrier.end(), tissue->copy(c)) != surface->carrier.end())
      carrying.push_back(c);
  int asked = 0, parted = 0;
  for (int i = 0; i < 1500; ++i) {
    const size_t c = carrying[size_t(random()) % carrying.size()];
    const Vec3 Q = tissue->rest_mm(c, Vec3(uniform(0.02, 0.98), uniform(0.02, 0.98), uniform(0.02, 0.98)));
    int material = 0, copies = 0;
    bool near = false, empty = false;
    for (size_t o = 0; o < tissue->size(); ++o) {
      if (surface->lattice->cells[size_t(tissue->copy(o))].cell !=
          surface->lattice->cells[size_t(tissue->copy(c))].cell)
        continue;
      empty |= tissue->is_empty(o);
      ++copies;
      const Vec3 at = (Q - tissue->low_mm(o)).cwiseQuotient(tissue->size_mm(o));
      const int32_t part = tissue->part(o, at);
      tissue->learn({&part, 1}, workers);
      RestTissue::Answer a;
      tissue->ask(o, at, part, a);
      material += a.inside;
      for (size_t k = 0; k < a.count; ++k) near |= a.foot[k].distance_mm < 0.02;
    }
    if (near || empty) continue;  // on a wall or the skin; where its material lies is not known
    ++asked, parted += copies > 1;
    EXPECT_EQ(material, int(std::lround(winding_number(shown.topology->view, rest, Q))))
        << Q.transpose() << " copies " << copies;
  }
  EXPECT_GT(asked, 1000);
  EXPECT_GT(parted, 300);
}

// The way out is the shortest of all: against every triangle of the surface, one by one.
TEST_F(RestTissueOfAWound, WaysOutAreTheShortest) {
  int asked = 0;
  for (int i = 0; i < 2000; ++i) {
    const size_t c = size_t(random()) % tissue->size();
    const Vec3 at(uniform(0, 1), uniform(0, 1), uniform(0, 1)), Q = tissue->rest_mm(c, at);
    const int32_t part = tissue->part(c, at);
    tissue->learn({&part, 1}, workers);
    RestTissue::Answer a;
    tissue->ask(c, at, part, a);
    if (!a.inside) continue;
    double found = 1e30, least = 1e30;
    for (size_t k = 0; k < a.count; ++k) found = std::min(found, a.foot[k].distance_mm);
    for (const Tri& t : surface->tri)
      least = std::min(least, (Q - closest_on_triangle(Q, surface->X_mm[size_t(t[0])], surface->X_mm[size_t(t[1])],
                                                       surface->X_mm[size_t(t[2])])
                                       .point)
                                  .norm());
    if (least > RestTissue::kDeep_mm) continue;
    EXPECT_NEAR(found, least, 1e-6);  // feet that are as near to 1e-7 are one
    ++asked;
  }
  EXPECT_GT(asked, 400);
}

// What a copy does not carry it does not have: a point across the wall is outside, at its distance.
TEST_F(RestTissueOfAWound, APlaceIsOutsideOfTheOtherBank) {
  int asked = 0;
  for (const ContactPlace& p : surface->place) {
    const Vec3 n = tissue->smooth_normal(p.triangle, p.bary);
    const Vec3 Q = p.X_mm - 0.3 * n;  // in its own tissue
    for (size_t o = 0; o < tissue->size(); ++o) {
      if (tissue->copy(o) == p.copy ||
          surface->lattice->cells[size_t(tissue->copy(o))].cell != surface->lattice->cells[size_t(p.copy)].cell ||
          tissue->is_empty(o))
        continue;
      const Vec3 at = (Q - tissue->low_mm(o)).cwiseQuotient(tissue->size_mm(o));
      if ((at.array() < 0).any() || (at.array() > 1).any()) continue;
      const int32_t part = tissue->part(o, at), own = tissue->part(size_t(tissue->find(p.copy)), at);
      tissue->learn({&part, 1}, workers);
      tissue->learn({&own, 1}, workers);
      RestTissue::Answer mine, theirs;
      tissue->ask(size_t(tissue->find(p.copy)), at, own, mine);
      if (!mine.inside) continue;  // through a thin piece of it
      tissue->ask(o, at, part, theirs);
      EXPECT_FALSE(theirs.inside) << Q.transpose();
      ++asked;
    }
  }
  EXPECT_GT(asked, 200);
}

}  // namespace test_rest_tissue
}  // namespace limberg
