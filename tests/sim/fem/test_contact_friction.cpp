// Friction in the solver: exact derivatives, the reference, and a slab that is drawn over another: it holds as long as
// it can, and slides under exactly that.
#include <gtest/gtest.h>

#include "contact_checks.h"
#include "models.h"
#include "sim/base/error.h"
#include "sim/fem/forces/contact_forces.h"
#include "sim/testing/reference_newton.h"

namespace limberg {
namespace test_contact_friction {

constexpr double kSide_mm = 12, kHeight_mm = 4;
constexpr int kPerSide = 3;

/// Two boxes, the second one's nodes after the first one's, one on the other.
struct Pile {
  FemModel model;
  int32_t upper = 0;  // its first node
  Pile() {
    BoxSpec b;
    b.cells = {kPerSide, kPerSide, 1}, b.size_mm = {kSide_mm, kSide_mm, kHeight_mm};
    b.young_bottom_kPa = b.young_top_kPa = 30, b.poisson = 0.3;
    const FemModel one = box_model(b);
    model = one, upper = int32_t(one.X_mm.size());
    for (size_t i = 0; i < one.X_mm.size(); ++i) {
      model.X_mm.push_back(one.X_mm[i] + Vec3(0, 0, kHeight_mm)), model.fixed.push_back(false);
      model.mass_kg.push_back(one.mass_kg[i]), model.parent.push_back(-1);
      model.fixed[i] = one.X_mm[i].z() < 0.01;
    }
    for (HexCell c : one.cells) {
      for (int32_t& n : c.node) n += upper;
      model.cells.push_back(c);
    }
  }
  /// A node between the two, as one of them carries it.
  EmbeddedPoint at(int32_t node) const {
    EmbeddedPoint e;
    e.node.fill(node), e.w[0] = 1;
    return e;
  }
  /// Every node of the lower one's top with that of the upper one's bottom which lies on it.
  std::vector<Contact> contacts() const {
    std::vector<Contact> out;
    for (int32_t i = 0; i < upper; ++i)
      for (int32_t j = upper; j < int32_t(model.X_mm.size()); ++j)
        if (std::abs(model.X_mm[size_t(i)].z() - kHeight_mm) < 1e-9 &&
            (model.X_mm[size_t(i)] - model.X_mm[size_t(j)]).norm() < 1e-9) {
          Contact c;
          c.a = at(j), c.b = at(i);
          out.push_back(c);
        }
    return out;
  }
};

std::vector<Contact> random_friction(const Pile& s, uint64_t seed) {
  test::Random r(seed);
  std::vector<Contact> out = s.contacts();
  for (Contact& c : out) {
    c.normal = (Vec3::UnitZ() + r.vector(0.4)).normalized().cast<float>();
    c.gap_mm = float(0.3 * r.uniform()), c.soft_mm = 0.2f;
    c.stick_mm = r.vector(0.4).cast<float>();
    c.grip_N_per_mm = float(0.1 + 0.05 * r.uniform()), c.hold_mN = float(40 + 30 * r.uniform());
  }
  return out;
}

TEST(ContactFriction, GradientIsTheDerivativeOfTheEnergyAndThatOfTheReference) {
  const Pile s;
  const std::vector<Contact> contacts = random_friction(s, 3);
  fem::ContactForces f(s.model, contacts);
  NodeArray at = test::nodes_of(test::random_displacement(s.model, 0.3, 11)), g(at.size());
  const double energy = f.add(at, g, false);
  int slide = 0, hold = 0;
  for (size_t i = 0; i < f.size(); ++i) {
    const Vec3 force = f.friction_mN(i, at);
    EXPECT_LT(std::abs(force.dot(contacts[i].normal.cast<double>())), 1e-4);
    (force.norm() > 0.999 * double(contacts[i].hold_mN) ? slide : hold) += 1;
    EXPECT_LT(force.norm(), 1.0001 * double(contacts[i].hold_mN));
  }
  EXPECT_GT(slide, 2);
  EXPECT_GT(hold, 2);
  const auto [worst, largest] = test::against_differences(f, at, g);
  const double h = test::kDifference_mm;
  EXPECT_GT(largest, 50);
  // Exact but where a spring of friction comes to its end within the step (its stiffness times h / 4), and for the
  // third derivative of the turning force, hold / slid^2 h^2.
  EXPECT_LT(worst, 150 * h / 4 + 70 / (0.3 * 0.3) * h * h + 1e-4 * largest);
  const ReferenceElasticity none(s.model, {}), with(s.model, {}, contacts);
  const std::vector<Vec3> u = test::vectors_of(at), own = test::vectors_of(g);
  std::vector<Vec3> g0, g1;
  EXPECT_NEAR(with.energy(u) - none.energy(u), energy, 1e-9 * none.energy(u) + 1e-6 * energy);
  none.gradient(u, g0), with.gradient(u, g1);
  for (size_t i = 0; i < u.size(); ++i) EXPECT_LT((g1[i] - g0[i] - own[i]).norm(), 1e-5 * largest);
}

TEST(ContactFriction, TheReferenceHessianIsTheDerivativeOfItsGradient) {
  const Pile s;
  std::vector<Contact> contacts = random_friction(s, 5);
  for (size_t i = 0; i < contacts.size(); ++i) {  // none comes to its end within a step
    contacts[i].gap_mm = i % 3 ? 2.0f : -2.0f, contacts[i].soft_mm = 0;
    contacts[i].hold_mN = i % 2 ? 4.0f : 4000.0f;
  }
  const ReferenceElasticity none(s.model, {}), with(s.model, {}, contacts);
  const std::vector<Vec3> u = test::random_displacement(s.model, 0.2, 17);
  const Eigen::MatrixXd H = with.dense_hessian(u, false) - none.dense_hessian(u, false);
  EXPECT_LT(test::hessian_off(none, with, u, H, 1), 2e-3);
  EXPECT_GT(H.norm(), 100);
}

TEST(ContactFriction, ActionIsReaction) {
  const Pile s;
  for (const Contact& c : random_friction(s, 7)) {
    fem::ContactForces f(s.model, std::span(&c, 1));
    const NodeArray u = test::nodes_of(test::random_displacement(s.model, 0.5, 13));
    NodeArray g(u.size());
    f.add(u, g, false);
    Vec3 sum = Vec3::Zero(), on_a = Vec3::Zero();
    for (size_t i = 0; i < u.size(); ++i)
      sum += test::vectors_of(g)[i], on_a -= int32_t(i) >= s.upper ? test::vectors_of(g)[i] : Vec3(0, 0, 0);
    const Vec3 force = f.force_mN(0, u) * c.normal.cast<double>() + f.friction_mN(0, u);
    EXPECT_LT(sum.norm(), 1e-5 * (1 + force.norm()));
    EXPECT_LT((on_a - force).norm(), 1e-5 * (1 + force.norm()));
  }
}

// The upper slab is drawn aside by springs to the world, all its nodes alike. As long as they draw less than friction
// bears in all it gives by no more than its springs; harder, and it slides until they draw just that.
TEST(ContactFriction, ASlabSlidesUnderWhatItsFrictionBears) {
  const Pile s;
  std::vector<Contact> contacts = s.contacts();
  const double hold_mN = 5, all_mN = hold_mN * double(contacts.size());  // 80
  for (Contact& c : contacts) c.k_N_per_mm = 1, c.hold_mN = float(hold_mN), c.grip_N_per_mm = 0.25f;
  const auto drawn = [&](double target_mm) {
    std::vector<Spring> springs;
    const size_t nodes = s.model.X_mm.size() - size_t(s.upper);
    const double k_mN_per_mm = 100.0 / double(nodes);  // in all
    for (size_t i = size_t(s.upper); i < s.model.X_mm.size(); ++i) {
      Spring p;
      p.id = int32_t(springs.size()) + 1, p.to_world = true, p.k_N_per_mm = 1e-3 * k_mN_per_mm;
      p.a = s.at(int32_t(i)), p.target_mm = s.model.X_mm[i] + Vec3(target_mm, 0, -0.2);
      springs.push_back(p);
    }
    InlineWorkers w;
    auto solver = make_solver(w);
    solver->set_model(std::make_shared<FemModel>(s.model), {});
    solver->set_springs(springs), solver->set_contacts(contacts);
    StepSettings settings;
    settings.max_iterations = 2000, settings.tolerance = 2e-6;
    solver->step(settings);
    Vec3 friction = Vec3::Zero(), moved = Vec3::Zero(), pull = Vec3::Zero();
    for (size_t i = 0; i < contacts.size(); ++i) friction += solver->contact_friction_mN(i);
    for (const Spring& p : springs) pull += solver->spring_force_mN(p.id);
    for (const Contact& c : contacts)
      moved += (solver->displacement_mm()[size_t(c.a.node[0])] - solver->displacement_mm()[size_t(c.b.node[0])])
                   .cast<double>() /
               double(contacts.size());
    return std::tuple(friction.x(), pull.x(), moved.x());
  };
  const auto [holds, held_by, gave_mm] = drawn(0.5);  // 50 mN of 80
  EXPECT_NEAR(holds, -held_by, 0.01 * held_by);
  EXPECT_LT(-holds, 51);
  EXPECT_NEAR(gave_mm, -holds / 16 / 250, 1e-4) << "the mean of 16 springs of 250 mN/mm";
  const auto [slides, drawn_by, slid_mm] = drawn(3);
  EXPECT_NEAR(-slides, all_mN, 0.01 * all_mN);
  EXPECT_NEAR(drawn_by, all_mN, 0.01 * all_mN);
  EXPECT_GT(slid_mm, 1);
}

TEST(ContactFriction, BadFrictionIsRefused) {
  const Pile s;
  const Contact good = random_friction(s, 1).front();
  const auto refused = [&](auto&& spoil) {
    Contact c = good;
    spoil(c);
    EXPECT_THROW(fem::ContactForces(s.model, std::span(&c, 1)), InputError);
  };
  EXPECT_NO_THROW(fem::ContactForces(s.model, std::span(&good, 1)));
  refused([](Contact& c) { c.hold_mN = -1; });
  refused([](Contact& c) { c.hold_mN = NAN; });
  refused([](Contact& c) { c.grip_N_per_mm = 0; });
  refused([](Contact& c) { c.stick_mm[1] = INFINITY; });
}

}  // namespace test_contact_friction
}  // namespace limberg
