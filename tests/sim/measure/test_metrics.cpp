// Sums over stitches, hooks and supports, and the collection of all figures from a snapshot.
#include <gtest/gtest.h>

#include "sim/measure/metrics.h"
#include "tests/sim/commands/shipped_scripts.h"
#include "tests/sim/measure/views.h"

namespace limberg {
namespace test_metrics {

// A solution that is given, not computed.
class GivenSolver final : public ElasticSolver {
 public:
  // Four cells of 8 mm³ in a row along x; the third is a quarter of one.
  GivenSolver() {
    Stencil s;
    s.volume_mm3 = 8;
    model_.stencils.push_back(s);
    for (int c = 0; c < 4; ++c) {
      HexCell cell;
      for (int k = 0; k < 8; ++k) {
        cell.node[size_t(k)] = int32_t(model_.X_mm.size());
        model_.X_mm.push_back(2 * Vec3(c + (k & 1), k >> 1 & 1, k >> 2));
      }
      cell.stencil = 0, cell.scale = c == 2 ? 0.25f : 1.0f;
      model_.cells.push_back(cell);
    }
  }
  std::vector<float> J{1.0f, 0.5f, -0.25f, 1.1f};
  Vec3 support{0, 0, 0}, loaded{0, 0, 0};
  void set_model(std::shared_ptr<const FemModel>, const ParentList&) override {}
  void set_springs(std::span<const Spring>) override {}
  void set_contacts(std::span<const Contact>) override {}
  StepReport step(const StepSettings&) override { return {}; }
  std::span<const Vec3f> displacement_mm() const override { return {}; }
  void set_displacement_mm(std::span<const Vec3f>) override {}
  SolverState save() const override { return {}; }
  void restore(const SolverState&) override {}
  Vec3 spring_force_mN(int32_t) const override { return Vec3::Zero(); }
  double contact_force_mN(size_t) const override { return 0; }
  Vec3 contact_friction_mN(size_t) const override { return Vec3::Zero(); }
  size_t contacts() const override { return 0; }
  void set_gravity(const Vec3&) override {}
  Vec3 gravity_m_s2() const override { return Vec3::Zero(); }
  void set_loads(std::span<const DeadLoad>) override {}
  std::span<const DeadLoad> loads() const override { return {}; }
  std::vector<SupportForce> support_forces_mN() const override { return {{0, support}}; }
  Vec3 load_force_mN() const override { return loaded; }
  void cell_J(std::vector<float>& out) const override { out = J; }
  Mat3 cell_F(int32_t) const override { return Mat3::Identity(); }
  std::string describe() const override { return "given"; }
  const FemModel& model() const override { return model_; }

 private:
  FemModel model_;
};

TEST(ForceBalance, SupportsAnswerTheHooks) {
  const std::vector<HookState> hooks{{1, Vec3f::Zero(), Vec3f::Zero(), Vec3f(1, 0, 2)},
                                     {2, Vec3f::Zero(), Vec3f::Zero(), Vec3f(0, 3, 0)}};
  const ForceBalance even = force_balance(hooks, {}, Vec3(1000, 3000, 2000));  // mN that the supports receive
  EXPECT_NEAR(even.relative, 0, 1e-7);
  EXPECT_NEAR((even.supports_N + even.hooks_N).norm(), 0, 1e-6);
  const ForceBalance odd = force_balance(hooks, {}, Vec3(1000, 3000, 1900));
  const double all = std::sqrt(5.0) + 3 + Vec3(1, 3, 1.9).norm();
  EXPECT_NEAR(odd.relative, 0.1 / all, 1e-7);
  const std::vector<SutureState> stitches{{1, Vec3f::Zero(), Vec3f::Zero(), 2.f, 0.1f}};
  EXPECT_NEAR(force_balance(hooks, stitches, Vec3(1000, 3000, 1900)).relative, 0.1 / (all + 4), 1e-7);
  // The supports receive what hooks and loads give, 1 N of load here.
  const ForceBalance loaded = force_balance(hooks, {}, Vec3(1000, 3000, 3000), Vec3(0, 0, 1000));
  EXPECT_NEAR(loaded.sum_N.norm(), 0, 1e-6);
  EXPECT_EQ(loaded.loads_N, Vec3(0, 0, 1));
  EXPECT_EQ(force_balance({}, {}, Vec3::Zero()).relative, 0);
  EXPECT_NEAR(force_balance({}, {}, Vec3(1e-3, 0, 0)).relative, 1e-4, 1e-12);  // a micronewton of rounding
}

TEST(Metrics, OfAStretchedBlock) {
  const auto body = measured_block({80, 80, 10}, 1);
  const Skin skin(body);
  auto topology = std::make_shared<SurfaceTopology>();
  topology->view = view_of(*body);
  topology->body = body;
  Snapshot s;
  s.topology = topology;
  s.x_mm = deformed(topology->view, [](const Vec3& X) { return Vec3(X.x(), 1.1 * X.y(), X.z()); });
  s.sutures = {{1, Vec3f::Zero(), Vec3f::Zero(), 1.5f, 0.05f},
               {2, Vec3f::Zero(), Vec3f::Zero(), 2.5f, 0.02f},
               {7, Vec3f::Zero(), Vec3f::Zero(), 0.5f, 0.15f}};
  const GivenSolver solver;
  const Metrics m = measure(s, skin, solver, {1, 60000, 4000, 64000}, test::shipped_commands("zplasty"));
  EXPECT_EQ(m.pieces, 1);
  EXPECT_EQ(m.volume_change, 0);
  EXPECT_NEAR(m.compression, 0.1, 1e-5);
  ASSERT_EQ(m.sutures.size(), 3u);
  EXPECT_EQ(m.sutures[2].id, 7);
  EXPECT_NEAR(m.closure_force_N, 4.5, 1e-6);
  EXPECT_EQ(m.suture_force_max_id, 2);
  EXPECT_NEAR(m.suture_force_max_N, 2.5, 1e-6);
  EXPECT_NEAR(m.suture_gap_max_mm, 0.15, 1e-6);
  EXPECT_EQ(m.min_J, -0.25);
  EXPECT_EQ(m.inverted_cells, 1);
  EXPECT_EQ(m.inverted_mm3, 2);
  EXPECT_EQ(m.inverted_at_mm, Vec3(5, 1, 1));
  EXPECT_NEAR(m.stretch_max, 1.1, 1e-5);
  EXPECT_EQ(m.dog_ear_mm, 0);
  EXPECT_EQ(m.wound_gape_mm, 0);
  ASSERT_TRUE(m.elongation);
  EXPECT_NEAR(*m.elongation, 1.1, 1e-5);
  EXPECT_FALSE(m.flap_area_mm2);
  const Metrics r = measure(s, skin, solver, {1, 64000, 0, 64000}, test::shipped_commands("rhomboid"));
  ASSERT_TRUE(r.flap_area_mm2);
  EXPECT_NEAR(*r.flap_area_mm2, 1.1 * 400 * std::sqrt(0.75), 15);  // cells of 1 mm along a border of 80 mm
}

}  // namespace test_metrics
}  // namespace limberg
