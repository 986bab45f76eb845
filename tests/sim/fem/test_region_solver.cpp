// Absent tissue is no unknown, no element and no row, and the answer is that of the whole model with that tissue held.
#include <gtest/gtest.h>

#include <cmath>

#include "divided_box.h"
#include "models.h"
#include "sim/base/error.h"
#include "sim/fem/solver/region_solver.h"

namespace limberg {
namespace test_region_solver {

constexpr double kRadius_mm = 17;

/// As lattice/region.cpp does it.
void hold(FemModel& m) {
  std::vector<uint8_t> out(m.X_mm.size());
  for (size_t i = 0; i < out.size(); ++i) out[i] = m.X_mm[i].head<2>().norm() > kRadius_mm;
  for (const HangingNode& h : m.hanging)
    out[size_t(h.node)] =
        std::all_of(h.master.begin(), h.master.begin() + h.count, [&](int32_t n) { return out[size_t(n)] != 0; });
  for (size_t i = 0; i < out.size(); ++i)
    if (out[i]) m.fixed[i] = 1;
  for (const HangingNode& h : m.hanging) m.fixed[size_t(h.node)] = 0;
  for (HexCell& c : m.cells)
    if (std::all_of(c.node.begin(), c.node.end(), [&](int32_t n) { return out[size_t(n)] != 0; })) c.scale = 0;
}

FemModel block(int side, double size_mm) {
  BoxSpec b;
  b.cells = {side, side, 3}, b.size_mm = {size_mm, size_mm, 9};
  b.young_bottom_kPa = 18, b.young_top_kPa = 60, b.poisson = 0.49;
  b.fix_bottom = true;
  return box_model(b);
}

EmbeddedPoint place(const FemModel& m, const Vec3& at) { return embed(m, at); }

std::vector<Spring> springs(const FemModel& m) {
  Spring hook, far_hook, stitch;
  hook.id = 1, hook.to_world = true, hook.k_N_per_mm = 0.5, hook.a = place(m, {2, 5, 8.5}),
  hook.target_mm = Vec3(2, 9, 14);
  // Absent tissue holds a hook, and an end of a stitch.
  far_hook = hook, far_hook.id = 2, far_hook.a = place(m, {25, 3, 8}), far_hook.target_mm = Vec3(26, 3, 9);
  stitch.id = 3, stitch.k_N_per_mm = 1, stitch.a = place(m, {12, -4, 8.5}), stitch.b = place(m, {24, -5, 8}),
  stitch.target_mm = Vec3(-9, 1, 0.2);
  return {hook, far_hook, stitch};
}

std::vector<Contact> contacts(const FemModel& m) {
  Contact c;
  c.a = place(m, {-14, 1, 8.9}), c.b = place(m, {-24, 1, 8.9}), c.normal = Vec3f::UnitX(), c.gap_mm = 10.5f,
  c.soft_mm = 0.1f, c.k_N_per_mm = 0.2f;
  return {c};
}

double largest_difference(const ElasticSolver& a, const ElasticSolver& b) {
  double d = 0;
  for (size_t i = 0; i < a.displacement_mm().size(); ++i)
    d = std::max(d, double((a.displacement_mm()[i] - b.displacement_mm()[i]).norm()));
  return d;
}

StepReport settle(ElasticSolver& s) {
  StepSettings set;
  set.max_iterations = 1500, set.tolerance = 2e-6;
  s.step({});
  return s.step(set);
}

// Single precision leaves some 1e-6 of a pull of 7 mm; the bound is a hundred times the sum of a path's roundings.
constexpr double kSame_mm = 1e-3;

void same_answer(ElasticSolver& whole, fem::RegionSolver& part, bool touching) {
  EXPECT_LT(settle(whole).residual, 1e-5);
  EXPECT_LT(settle(part).residual, 1e-5);
  EXPECT_LT(largest_difference(whole, part), kSame_mm);
  double moved = 0;
  for (const Vec3f& u : part.displacement_mm()) moved = std::max(moved, double(u.norm()));
  EXPECT_GT(moved, 1);
  for (int id : {1, 2, 3}) {
    const Vec3 f = whole.spring_force_mN(id);
    EXPECT_LT((f - part.spring_force_mN(id)).norm(), 1 + 1e-3 * f.norm()) << id;
    EXPECT_GT(f.norm(), 10) << id;
  }
  if (touching) {
    EXPECT_GT(whole.contact_force_mN(0), 1);
    EXPECT_NEAR(whole.contact_force_mN(0), part.contact_force_mN(0), 1e-3 * whole.contact_force_mN(0) + 0.2);
  }
  EXPECT_LT((whole.support_force_mN() - part.support_force_mN()).norm(), 1 + 2e-3 * whole.support_force_mN().norm());
  std::vector<float> J, K;
  whole.cell_J(J), part.cell_J(K);
  ASSERT_EQ(J.size(), K.size());
  for (size_t c = 0; c < J.size(); ++c) ASSERT_NEAR(J[c], K[c], 2e-3) << c;
  for (int32_t c = 0; c < int32_t(J.size()); c += 37) EXPECT_LT((whole.cell_F(c) - part.cell_F(c)).norm(), 5e-3);
}

TEST(RegionSolver, IsTheWholeWithItsOutsideHeldThroughCutAndUndo) {
  InlineWorkers workers;
  FemModel held = block(20, 60);
  hold(held);
  const auto model = std::make_shared<const FemModel>(held);
  auto whole = make_solver(workers);
  fem::RegionSolver part(make_solver(workers));
  for (ElasticSolver* s : {whole.get(), static_cast<ElasticSolver*>(&part)})
    s->set_model(model, {}), s->set_springs(springs(*model)), s->set_contacts(contacts(*model));
  same_answer(*whole, part, true);
  const SolverState before = part.save();
  const std::vector<Vec3f> shown(part.displacement_mm().begin(), part.displacement_mm().end());

  const auto cut = std::make_shared<const FemModel>(test::cut_at_x0(held, 21));  // through the rim
  const std::vector<int32_t> cells = test::identity_parents(*cut);
  for (ElasticSolver* s : {whole.get(), static_cast<ElasticSolver*>(&part)}) s->set_model(cut, cells);
  EXPECT_LT(largest_difference(*whole, part), kSame_mm) << "carried over";
  for (ElasticSolver* s : {whole.get(), static_cast<ElasticSolver*>(&part)}) s->set_springs(springs(*cut));
  same_answer(*whole, part, false);

  auto back = std::make_shared<FemModel>(held);
  back->parent = ParentList::identity(held.X_mm.size());
  part.set_model(back, test::identity_parents(held));
  part.restore(before);
  EXPECT_TRUE(part.save() == before);
  for (size_t i = 0; i < shown.size(); ++i) ASSERT_EQ(shown[i], part.displacement_mm()[i]);
}

TEST(RegionSolver, TissueBeyondIsNeitherUnknownNorElement) {
  InlineWorkers workers;
  std::vector<Vec3f> shown[2];
  for (int k = 0; k < 2; ++k) {  // the same region in a block and in one of four times its size
    FemModel held = block(k ? 40 : 20, k ? 120 : 60);
    hold(held);
    fem::RegionSolver part(make_solver(workers));
    part.set_model(std::make_shared<FemModel>(held), {});
    std::vector<Spring> pull = springs(held);
    pull.resize(1);
    part.set_springs(pull);
    settle(part);
    size_t cells = 0;
    std::vector<uint8_t> touched(held.X_mm.size(), 0);
    for (const HexCell& c : held.cells)
      if (c.scale > 0) {
        ++cells;
        for (int32_t v : c.node) touched[size_t(v)] = 1;
      }
    EXPECT_EQ(part.present().cells.size(), cells);
    EXPECT_EQ(part.present().X_mm.size(), size_t(std::count(touched.begin(), touched.end(), 1)) + 8);
    EXPECT_EQ(part.save().displacement_mm.size(), 3 * part.present().X_mm.size());
    for (size_t i = 0; i < touched.size(); ++i)
      if (touched[i])
        shown[k].push_back(part.displacement_mm()[i]);
      else
        EXPECT_EQ(part.displacement_mm()[i].norm(), 0);
  }
  ASSERT_EQ(shown[0].size(), shown[1].size());
  double d = 0;
  for (size_t i = 0; i < shown[0].size(); ++i) d = std::max(d, double((shown[0][i] - shown[1][i]).norm()));
  EXPECT_LT(d, kSame_mm);
}

TEST(RegionSolver, HangingNodesKeepTheirMasters) {
  InlineWorkers workers;
  const FemModel box = block(16, 48);
  std::vector<int> level(box.cells.size(), 0);
  for (size_t c = 0; c < level.size(); ++c) {  // divided cells inside, across the rim and beyond it
    const Vec3 at = box.X_mm[size_t(box.cells[c].node[0])];
    level[c] = at[0] > 2 && at[1] > -4 && at[1] < 4 ? 1 : 0;
  }
  FemModel held = test::divide(box, level).model;
  ASSERT_FALSE(held.hanging.empty());
  hold(held);
  const auto model = std::make_shared<const FemModel>(held);
  auto whole = make_solver(workers);
  fem::RegionSolver part(make_solver(workers));
  std::vector<Spring> pull = springs(box);
  pull.resize(1);
  pull[0].a = box.cells.empty() ? EmbeddedPoint() : place(box, {-4, 5, 8.5});  // in a whole cell: the same nodes
  for (ElasticSolver* s : {whole.get(), static_cast<ElasticSolver*>(&part)})
    s->set_model(model, {}), s->set_springs(pull), settle(*s);
  EXPECT_LT(largest_difference(*whole, part), kSame_mm);
  EXPECT_GT(part.present().hanging.size(), 0u);
  EXPECT_LT(part.present().hanging.size(), held.hanging.size());
}

TEST(RegionSolver, RefusesWhatTheWholeDoesNotHave) {
  InlineWorkers workers;
  FemModel held = block(10, 60);
  hold(held);
  const auto solver = make_region_solver(workers);
  EXPECT_THROW(solver->set_springs({}), InputError);
  solver->set_model(std::make_shared<FemModel>(held), {});
  std::vector<Spring> bad(1);
  bad[0].to_world = true, bad[0].a.w[0] = 1, bad[0].a.node[0] = int32_t(held.X_mm.size());
  EXPECT_THROW(solver->set_springs(bad), InputError);
  EXPECT_THROW(solver->set_displacement_mm({}), InputError);
}

}  // namespace test_region_solver
}  // namespace limberg
