// Contacts in the solver: exact derivatives, action and reaction,
// closed forms, the reference, and nothing when there are none.
#include <gtest/gtest.h>

#include "contact_checks.h"
#include "models.h"
#include "sim/base/error.h"
#include "sim/fem/forces/contact_forces.h"
#include "sim/fem/solver/loose_pieces.h"
#include "sim/testing/reference_newton.h"

namespace limberg {
namespace test_contact_forces {

/// Two boxes of n x n x layers cells, side x side x height each, one on the other: the upper one's nodes come after,
/// and their squares at z = height meet the lower one's. `apart_mm` lifts the upper one at rest.
struct Slabs {
  FemModel model;
  int32_t nodes_of_one = 0;
  int cells_per_side = 0;
  double side_mm = 0, height_mm = 0;
};

Slabs two_slabs(int n, int layers, double side, double height, double young_kPa, double poisson, double apart_mm = 0) {
  BoxSpec b;
  b.cells = {n, n, layers}, b.size_mm = {side, side, height};
  b.young_bottom_kPa = b.young_top_kPa = young_kPa, b.poisson = poisson;
  const FemModel one = box_model(b);
  Slabs s{one, int32_t(one.X_mm.size()), n, side, height};
  FemModel& m = s.model;
  for (size_t i = 0; i < one.X_mm.size(); ++i) {
    m.X_mm.push_back(one.X_mm[i] + Vec3(0, 0, height + apart_mm));
    m.fixed.push_back(one.fixed[i]), m.mass_kg.push_back(one.mass_kg[i]), m.parent.push_back(-1);
  }
  for (HexCell c : one.cells) {
    for (int32_t& v : c.node) v += s.nodes_of_one;
    m.cells.push_back(c);
  }
  return s;
}

/// A point of the square between the slabs, as the lower (0) or the upper (1) slab carries it.
EmbeddedPoint on_interface(const Slabs& s, int slab, double x, double y) {
  BoxSpec b;
  b.cells = {s.cells_per_side, s.cells_per_side, 1}, b.size_mm = {s.side_mm, s.side_mm, s.height_mm};
  const double z = slab == 0 ? s.height_mm : 0;
  for (const HexCell& c : s.model.cells) {
    if ((c.node[0] >= s.nodes_of_one) != (slab == 1)) continue;
    const Vec3 lo = s.model.X_mm[size_t(c.node[0])], at(x, y, lo.z());
    const double base = slab == 0 ? lo.z() + s.model.cell_mm.z() : lo.z();
    const double want = slab == 0 ? z : s.model.X_mm[size_t(s.nodes_of_one)].z();
    if (std::abs(base - want) > 1e-9) continue;
    const double u = (x - lo.x()) / s.model.cell_mm.x(), v = (y - lo.y()) / s.model.cell_mm.y(), w = slab == 0 ? 1 : 0;
    if (u < -1e-9 || u > 1 + 1e-9 || v < -1e-9 || v > 1 + 1e-9) continue;
    EmbeddedPoint e;
    e.node = c.node;
    for (int k = 0; k < 8; ++k) e.w[size_t(k)] = float((k & 1 ? u : 1 - u) * (k & 2 ? v : 1 - v) * (k & 4 ? w : 1 - w));
    return e;
  }
  ADD_FAILURE() << "no cell at " << x << ", " << y;
  return {};
}

/// Contacts at 2 x 2 Gauss points of every square between the slabs (exact for bilinear shares), k = stiffness x area.
std::vector<Contact> gauss_contacts(const Slabs& s, double stiffness_kPa_per_mm) {
  std::vector<Contact> out;
  const double h = s.side_mm / s.cells_per_side, gauss = 0.5 / std::sqrt(3.0);
  for (int i = 0; i < s.cells_per_side; ++i)
    for (int j = 0; j < s.cells_per_side; ++j)
      for (double du : {-gauss, gauss})
        for (double dv : {-gauss, gauss}) {
          const double x = -s.side_mm / 2 + h * (i + 0.5 + du), y = -s.side_mm / 2 + h * (j + 0.5 + dv);
          Contact c;
          c.a = on_interface(s, 1, x, y), c.b = on_interface(s, 0, x, y);
          c.normal = Vec3f::UnitZ();
          c.k_N_per_mm = float(1e-3 * stiffness_kPa_per_mm * h * h / 4);
          out.push_back(c);
        }
  return out;
}

std::vector<Contact> random_contacts(const Slabs& s, int count, uint64_t seed) {
  test::Random r(seed);
  std::vector<Contact> out;
  for (int i = 0; i < count; ++i) {
    Contact c;
    const double x = 0.45 * s.side_mm * r.uniform(), y = 0.45 * s.side_mm * r.uniform();
    c.a = on_interface(s, 1, x, y);
    c.b = on_interface(s, 0, x + 0.3 * r.uniform(), y + 0.3 * r.uniform());
    c.normal = (Vec3::UnitZ() + r.vector(0.4)).normalized().cast<float>();
    c.gap_mm = float(0.3 * r.uniform());
    c.k_N_per_mm = float(0.5 + 0.4 * r.uniform());
    c.soft_mm = i % 2 ? float(0.2 + 0.1 * r.uniform()) : 0.0f;
    out.push_back(c);
  }
  return out;
}

TEST(ContactForces, GradientIsTheDerivativeOfTheEnergy) {
  const Slabs s = two_slabs(3, 1, 12, 4, 30, 0.3);
  const std::vector<Contact> contacts = random_contacts(s, 40, 3);
  fem::ContactForces f(s.model, contacts);
  const std::vector<Vec3> u = test::random_displacement(s.model, 0.5, 11);
  NodeArray at = test::nodes_of(u), g(u.size());
  const double energy = f.add(at, g, false);
  int pressed = 0;
  for (size_t i = 0; i < f.size(); ++i) pressed += f.clearance_mm(i, at) < 0;
  EXPECT_GT(pressed, 5);
  EXPECT_LT(pressed, 36);  // some are apart: both branches are met
  EXPECT_GT(energy, 0);
  const auto [worst, largest] = test::against_differences(f, at, g);
  // Central differences of a piecewise quadratic: exact but where
  // a contact opens within the step, there k h / 4 at most.
  EXPECT_LT(worst, 900.0 / 1024 / 4 + 1e-5 * largest);
  EXPECT_GT(largest, 50);
  // The reference has the same energy and the same gradient.
  const ReferenceElasticity none(s.model, {}), with(s.model, {}, contacts);
  std::vector<Vec3> uf, g0, g1;
  for (size_t i = 0; i < u.size(); ++i) uf.push_back(Vec3(double(at[i].x), double(at[i].y), double(at[i].z)));
  EXPECT_NEAR(with.energy(uf) - none.energy(uf), energy, 1e-9 * none.energy(uf) + 3e-7 * energy);
  none.gradient(uf, g0), with.gradient(uf, g1);
  for (size_t i = 0; i < u.size(); ++i)
    EXPECT_LT((g1[i] - g0[i] - Vec3(double(g[i].x), double(g[i].y), double(g[i].z))).norm(), 1e-5 * largest);
}

TEST(ContactForces, TheReferenceHessianIsTheDerivativeOfItsGradient) {
  const Slabs s = two_slabs(2, 1, 8, 4, 30, 0.3);
  std::vector<Contact> contacts = random_contacts(s, 20, 5);
  for (Contact& c : contacts) {  // none changes sides within a step; the soft ones stay in their soft part
    c.gap_mm += c.gap_mm > 0 ? 2 : -2;
    if (c.soft_mm > 0) c.soft_mm = 8;
  }
  const ReferenceElasticity none(s.model, {}), with(s.model, {}, contacts);
  const std::vector<Vec3> u = test::random_displacement(s.model, 0.2, 17);
  const Eigen::MatrixXd H = with.dense_hessian(u, false) - none.dense_hessian(u, false);
  EXPECT_LT(test::hessian_off(none, with, u, H, 3), 1e-3);
  EXPECT_GT(H.norm(), 100);
}

// Where the parts of the law meet, energy, force and slope agree; each is the derivative of the one before.
TEST(ContactForces, TheLawHasNoJump) {
  const double k = 700, soft = 0.05;
  for (const double p : {0.0, soft}) {
    const fem::Push a = fem::contact_push(-p + 1e-9, k, soft), b = fem::contact_push(-p - 1e-9, k, soft);
    EXPECT_NEAR(a.energy, b.energy, 1e-6);
    EXPECT_NEAR(a.force, b.force, 1e-5);
    EXPECT_NEAR(a.slope, b.slope, 1e-3 * k);
  }
  for (double p = 0.0021; p < 0.2; p *= 1.3) {
    const double h = 1e-6;
    const fem::Push a = fem::contact_push(-p + h, k, soft), b = fem::contact_push(-p - h, k, soft),
                    at = fem::contact_push(-p, k, soft);
    EXPECT_NEAR((b.energy - a.energy) / (2 * h), at.force, 1e-4 + 1e-6 * at.force);
    EXPECT_NEAR((b.force - a.force) / (2 * h), at.slope, 1e-3 * k);
  }
}

TEST(ContactForces, ActionIsReaction) {
  const Slabs s = two_slabs(3, 1, 12, 4, 30, 0.3);
  for (const Contact& c : random_contacts(s, 30, 7)) {
    fem::ContactForces f(s.model, std::span(&c, 1));
    const NodeArray u = test::nodes_of(test::random_displacement(s.model, 0.5, 13));
    NodeArray g(u.size());
    f.add(u, g, false);
    Vec3 sum = Vec3::Zero(), torque = Vec3::Zero(), xa = Vec3::Zero(), xb = Vec3::Zero();
    for (size_t i = 0; i < u.size(); ++i) {
      const Vec3 x = s.model.X_mm[i] + Vec3(double(u[i].x), double(u[i].y), double(u[i].z));
      const Vec3 fi = -Vec3(double(g[i].x), double(g[i].y), double(g[i].z));
      sum += fi, torque += x.cross(fi);
    }
    for (size_t k = 0; k < 8; ++k) {
      const auto at = [&](int32_t n) {
        return Vec3(s.model.X_mm[size_t(n)] +
                    Vec3(double(u[size_t(n)].x), double(u[size_t(n)].y), double(u[size_t(n)].z)));
      };
      xa += double(c.a.w[k]) * at(c.a.node[k]), xb += double(c.b.w[k]) * at(c.b.node[k]);
    }
    const double force = f.force_mN(0, u);
    EXPECT_LT(sum.norm(), 1e-5 * (1 + force));
    // Two opposite forces along n, at a and at b: their moment is
    // (a - b) x n, nothing when the places lie along the normal.
    EXPECT_LT((torque - (xa - xb).cross(force * c.normal.cast<double>())).norm(), 1e-4 * (1 + force));
  }
}

// Two equal slabs, all their outside held on a homogeneous compression; free inside, and between them only contact.
// Then the homogeneous state is the equilibrium, with the pressure P_zz on both sides of the gap:
//   stiffness * overlap = -P_zz(b),  P_zz = mu b + (lambda (J - 1) - mu) for F = diag(1, 1, b), J = b.
TEST(ContactForces, TwoSlabsPressedTogether) {
  const Slabs s = two_slabs(4, 2, 16, 6, 40, 0.4);
  const Elastic el = elastic_from_young(40, 0.4);
  const double stiffness = 60, b = 0.9;  // kPa per mm
  const double P = el.mu_kPa * b + el.lambda_kPa * (b - 1) - el.mu_kPa, overlap = -P / stiffness;
  ASSERT_GT(overlap, 0.05);
  FemModel m = s.model;
  std::vector<Vec3> want(m.X_mm.size());
  for (size_t i = 0; i < m.X_mm.size(); ++i) {
    const Vec3 X = m.X_mm[i];
    want[i] = Vec3(0, 0, (b - 1) * (X.z() - s.height_mm) - (int32_t(i) >= s.nodes_of_one ? overlap : 0));
    m.fixed[i] = std::abs(X.x()) > 7.99 || std::abs(X.y()) > 7.99 || X.z() < 0.01 || X.z() > 11.99;
  }
  std::vector<Vec3f> start = test::to_float(want);
  test::Random r(1);
  for (size_t i = 0; i < start.size(); ++i)
    if (!m.fixed[i]) start[i] += r.vector(0.3).cast<float>();
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(std::make_shared<FemModel>(m), {});
  solver->set_displacement_mm(start);
  const std::vector<Contact> contacts = gauss_contacts(s, stiffness);
  solver->set_contacts(contacts);
  StepSettings settings;
  settings.max_iterations = 300, settings.tolerance = 1e-6;
  EXPECT_TRUE(solver->step(settings).converged);
  double worst = 0, force = 0;
  for (size_t i = 0; i < want.size(); ++i)
    worst = std::max(worst, (solver->displacement_mm()[i].cast<double>() - want[i]).norm());
  for (size_t i = 0; i < contacts.size(); ++i) force += solver->contact_force_mN(i);
  EXPECT_LT(worst, 1e-4);
  EXPECT_NEAR(force, -P * s.side_mm * s.side_mm, 1e-3 * force);
}

TEST(ContactForces, SameEquilibriumAsFullNewton) {
  Slabs s = two_slabs(4, 2, 16, 6, 40, 0.45, 0.5);
  for (size_t i = 0; i < s.model.X_mm.size(); ++i) s.model.fixed[i] = s.model.X_mm[i].z() < 0.01;
  std::vector<Contact> contacts = gauss_contacts(s, 40);
  test::Random r(5);
  for (Contact& c : contacts) c.normal = (Vec3::UnitZ() + r.vector(0.2)).normalized().cast<float>();
  std::vector<Spring>
      springs;  // four corners of the top pulled down and a little aside: the upper slab is pressed and slides
  for (int k = 0; k < 4; ++k) {
    Spring p;
    p.id = k + 1, p.to_world = true, p.k_N_per_mm = 0.3;
    const Vec3 at((k & 1) ? 7.9 : -7.9, (k & 2) ? 7.9 : -7.9, 12.5);
    p.a = embed(s.model, at), p.target_mm = at + Vec3(1, 0.5, -1.5 - 0.3 * k);
    springs.push_back(p);
  }
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(std::make_shared<FemModel>(s.model), {});
  solver->set_springs(springs);
  solver->set_contacts(contacts);
  StepSettings settings;
  // A slab that floats on soft springs: single precision ends between 1e-5 and 4e-5 here (2026-11-21).
  settings.max_iterations = 400, settings.tolerance = 5e-5;
  const StepReport report = solver->step(settings);
  EXPECT_TRUE(report.converged) << report.residual << " after " << report.iterations;
  const ReferenceElasticity reference(s.model, springs, contacts);
  const auto q = reference.solve(std::vector<Vec3>(s.model.X_mm.size(), Vec3::Zero()), {});
  EXPECT_TRUE(q.converged);
  double worst = 0, force = 0;
  for (size_t i = 0; i < q.u.size(); ++i)
    worst = std::max(worst, (solver->displacement_mm()[i].cast<double>() - q.u[i]).norm());
  for (size_t i = 0; i < contacts.size(); ++i) force += solver->contact_force_mN(i);
  EXPECT_LT(worst, 1e-3);
  EXPECT_GT(force, 100);
}

// A slab that nothing holds lies .2 mm deep in one that is held. It is pushed out of it, and no farther than a few
// iterates may carry it: elasticity has nothing to say about its place, and it went metres.
TEST(ContactForces, APieceThatNothingHoldsIsPushedOutAndNotAway) {
  Slabs s = two_slabs(4, 2, 16, 6, 40, 0.45, 0.5);
  for (size_t i = 0; i < s.model.X_mm.size(); ++i) s.model.fixed[i] = s.model.X_mm[i].z() < 0.01;
  std::vector<Contact> contacts = gauss_contacts(s, 40);
  test::Random r(5);
  for (Contact& c : contacts) {
    c.normal = (Vec3::UnitZ() + r.vector(0.2)).normalized().cast<float>();
    c.gap_mm = 0.5f + 0.2f + 0.1f * float(r.uniform());
  }
  InlineWorkers w;
  auto solver = make_solver(w);
  solver->set_model(std::make_shared<FemModel>(s.model), {});
  solver->set_contacts(contacts);
  StepSettings settings;
  settings.tolerance = 5e-5;
  for (int i = 0; i < 5; ++i) solver->step(settings);
  double farthest = 0, force = 0;
  for (const Vec3f& u : solver->displacement_mm()) farthest = std::max(farthest, double(u.norm()));
  for (size_t i = 0; i < contacts.size(); ++i) force += solver->contact_force_mN(i);
  EXPECT_LT(farthest, 4 * fem::kLooseStep_mm);
  EXPECT_GT(farthest, 0.1);
  EXPECT_LT(force, 1);
}

TEST(ContactForces, WhereNothingPressesNothingChanges) {
  Slabs s = two_slabs(4, 2, 16, 6, 40, 0.45, 0.5);
  for (size_t i = 0; i < s.model.X_mm.size(); ++i)
    s.model.fixed[i] = s.model.X_mm[i].z() < 0.01 || s.model.X_mm[i].z() > 12.49;
  Spring pull;
  pull.id = 1, pull.to_world = true, pull.a = embed(s.model, {0, 0, 6}), pull.target_mm = {3, 2, 5};
  const auto run = [&](int contacts) {
    InlineWorkers w;
    auto solver = make_solver(w);
    solver->set_model(std::make_shared<FemModel>(s.model), {});
    solver->set_springs(std::span(&pull, 1));
    if (contacts == 1) solver->set_contacts({});
    if (contacts == 2) {
      std::vector<Contact> far = gauss_contacts(s, 40);
      for (Contact& c : far) c.gap_mm = -20;
      solver->set_contacts(far);
    }
    for (int i = 0; i < 3; ++i) solver->step({});
    return std::vector<Vec3f>(solver->displacement_mm().begin(), solver->displacement_mm().end());
  };
  const std::vector<Vec3f> never = run(0), none = run(1), apart = run(2);
  EXPECT_GT(none[0].size(), 0);
  for (size_t i = 0; i < never.size(); ++i) {
    EXPECT_EQ((never[i] - none[i]).norm(), 0);
    EXPECT_EQ((never[i] - apart[i]).norm(), 0);
  }
}

TEST(ContactForces, BadContactsAreRefused) {
  const Slabs s = two_slabs(2, 1, 8, 4, 30, 0.3);
  const Contact good = gauss_contacts(s, 10).front();
  const auto refused = [&](auto&& spoil) {
    Contact c = good;
    spoil(c);
    EXPECT_THROW(fem::ContactForces(s.model, std::span(&c, 1)), InputError);
  };
  EXPECT_NO_THROW(fem::ContactForces(s.model, std::span(&good, 1)));
  refused([](Contact& c) { c.k_N_per_mm = 0; });
  refused([](Contact& c) { c.normal *= 2; });
  refused([](Contact& c) { c.gap_mm = NAN; });
  refused([](Contact& c) { c.a.node[0] = 10000; });
  refused([](Contact& c) { c.b.node[7] = -1; });
}

/// A machine that has no memory for a loop.
class WithoutMemory final : public Workers {
 public:
  int count() const override { return 1; }
  void parallel_for(size_t, size_t, const std::function<void(size_t, size_t)>&) override { throw std::bad_alloc(); }
  std::shared_ptr<Job> submit(std::function<void()>) override { throw std::bad_alloc(); }
};

// Half of another model's contacts would be read past the end of this one's nodes.
TEST(ContactForces, WhatFailsHalfWayLeavesNone) {
  const Slabs large = two_slabs(4, 1, 8, 4, 30, 0.3), small = two_slabs(2, 1, 8, 4, 30, 0.3);
  const std::vector<Contact> many = gauss_contacts(large, 10), few = gauss_contacts(small, 10);
  InlineWorkers here;
  WithoutMemory poor;
  fem::ContactForces c;
  c.set(large.model, many, here);
  ASSERT_EQ(c.size(), many.size());
  EXPECT_THROW(c.set(small.model, few, poor), std::bad_alloc);
  EXPECT_EQ(c.size(), 0u);
  c.set(large.model, many, here);
  Contact bad = few.front();
  bad.k_N_per_mm = 0;
  EXPECT_THROW(c.set(small.model, std::span(&bad, 1), here), InputError);
  EXPECT_EQ(c.size(), 0u);
}

}  // namespace test_contact_forces
}  // namespace limberg
