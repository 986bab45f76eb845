// The force loop in a closed circuit with a simulated device and hand.
#include <gtest/gtest.h>

#include "devices/force/force_device.h"
#include "tests/bench/devices/force.h"

namespace limberg::bench {
namespace test_devices_force {

ForceModel plane(double k) {
  ForceModel m;
  m.seq = 1, m.t_ns = 0;
  m.facets = 2;
  m.facet[0] = {Vec3(-100, -100, 0), Vec3(100, -100, 0), Vec3(100, 100, 0)};
  m.facet[1] = {Vec3(-100, -100, 0), Vec3(100, 100, 0), Vec3(-100, 100, 0)};
  m.stiffness_N_mm = k;
  return m;
}

/// Ticks with a fresh model each 16 ms, the tip where `at` says.
template <class At>
std::vector<Vec3> forces(ForceLoop& loop, ForceModel m, int ticks, At&& at, int models_until = 1 << 30) {
  std::vector<Vec3> f;
  for (int i = 0; i < ticks; ++i) {
    if (i % 16 == 0 && i < models_until) ++m.seq, m.t_ns = int64_t(i) * 1'000'000, loop.take(m);
    f.push_back(loop.tick(int64_t(i) * 1'000'000, at(i), true).force_N);
  }
  return f;
}

TEST(Force, FreeSpaceIsFreeAndContactPushesOut) {
  ForceLoop loop;
  const auto f = forces(loop, plane(0.5), 3000, [](int i) { return Vec3(0, 0, i < 1000 ? 5 : -2); });
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(f[size_t(i)].norm(), 0);
  // In series with the coupling of 2 N/mm: 0.4 N/mm.
  EXPECT_NEAR(f.back().z(), 0.8, 1e-6);
  EXPECT_LE(loop.counts().largest_step_N, 0.2 + 1e-12);
  EXPECT_NEAR(f.back().x(), 0, 1e-9);
}

TEST(Force, BeginsWithARampAndEndsWithTheModel) {
  ForceLoop loop;
  const auto f = forces(
      loop, plane(0.5), 2500, [](int) { return Vec3(0, 0, -2); }, 1500);
  EXPECT_LT(f[50].norm(), 0.12);  // a ramp of half a second
  EXPECT_NEAR(f[1400].z(), 0.8, 1e-6);
  EXPECT_GT(f[1520].z(), 0.7);   // two periods without a new model are nothing unusual
  EXPECT_EQ(f[1650].norm(), 0);  // then it fades within 50 ms
  EXPECT_GT(loop.counts().stale, 800);
}

TEST(Force, StaysWithinItsLimits) {
  ForceLoop loop;
  const auto f = forces(loop, plane(3), 3000, [](int i) { return Vec3(0, 0, -8 + 6 * std::sin(0.02 * i)); });
  for (const Vec3& v : f) ASSERT_LE(v.norm(), 3.3 + 1e-9);
  EXPECT_GT(loop.counts().saturated, 100);
  // An unread device gets nothing.
  EXPECT_EQ(loop.tick(3'000'000'000, Vec3(0, 0, -3), false).force_N.norm(), 0);
}

TEST(Force, FrictionHoldsWithinItsCone) {
  ForceLoop loop;
  const auto f = forces(loop, plane(0.5), 4000, [](int i) {
    return Vec3(i < 2000 ? 0 : std::min(0.3, 0.001 * (i - 2000)) + (i > 3000 ? 3 : 0), 0, -2);
  });
  EXPECT_NEAR(f[2900].x(), -0.3 * 0.4, 0.01);   // sticks: an elastic pull back
  EXPECT_NEAR(f.back().x(), -0.2 * 0.8, 0.01);  // slides: friction times the normal force
}

TEST(Force, CuttingRisesBreaksAndDrops) {
  ForceModel m = plane(0.5);
  m.puncture_N = 0.8, m.cutting_N = 0.35;
  ForceLoop loop;
  const auto f = forces(loop, m, 5000, [](int i) { return Vec3(0, 0, 1 - 0.001 * i); });
  double most = 0;
  size_t when = 0;
  for (size_t i = 0; i < f.size(); ++i)
    if (f[i].z() > most) most = f[i].z(), when = i;
  EXPECT_NEAR(most, 0.8, 0.02);
  EXPECT_NEAR(double(when), 1000 + 2000, 30);  // 0.4 N/mm: at a depth of 2 mm
  EXPECT_NEAR(f[when + 50].z(), 0.35, 0.02);
  EXPECT_NEAR(f.back().z(), 0.35, 0.02);
  // Out and in again: whole skin.
  const auto again = forces(loop, m, 100, [](int) { return Vec3(0, 0, 5); });
  EXPECT_FALSE(loop.state().cut);
  (void)again;
}

TEST(Force, AHeldHookPullsTowardsItsHome) {
  ForceModel m{};
  m.t_ns = 0;
  m.hooked = true;
  m.hook_home_mm = Vec3(0, 0, 0);
  m.hook_stiffness_N_mm = 0.05;
  ForceLoop loop;
  const auto f = forces(loop, m, 2000, [](int) { return Vec3(10, 0, 5); });
  const double k = 0.05 * 2 / 2.05;
  EXPECT_LT((f.back() - Vec3(-10 * k, 0, -5 * k)).norm(), 1e-6);
}

// What the local model is for: the naive methods make energy, this one does not.
TEST(Force, PassiveWhereTheNaiveMethodsAreNot) {
  for (const double hz : {30.0, 60.0, 120.0})
    for (const double k : {0.1, 0.5, 1.0, 3.0, 5000.0}) {  // the last one is bone, through the coupling
      ForceTrial t;
      t.stiffness_N_mm = k, t.solver_hz = hz, t.stiffening = 0.1, t.seconds = 6;
      const ForceFigures ours = force_trial(t);
      t.method = ForceMethod::hold;
      const ForceFigures held = force_trial(t);
      t.method = ForceMethod::tangent;
      const ForceFigures tangent = force_trial(t);
      std::printf(
          "k %.1f, %3.0f Hz: least energy %.2f mJ (held %.1f, tangent %.1f), step %.3f N (%.2f, %.2f), damped %lld\n",
          k, hz, ours.least_energy_mJ, held.least_energy_mJ, tangent.least_energy_mJ, ours.largest_step_N,
          held.largest_step_N, tangent.largest_step_N, (long long)ours.damped);
      EXPECT_GT(ours.least_energy_mJ, -0.15) << k << " " << hz;  // the spare of 0.1 mJ and a tick of the damper
      EXPECT_LE(ours.largest_step_N, 0.2 + 1e-9);
      if (k >= 0.5 && hz <= 60) {
        EXPECT_LT(held.least_energy_mJ, -10);
        EXPECT_GT(held.largest_step_N, 1.0);
      }
    }
}

TEST(Force, AStallOfThirtyMillisecondsDoesNotKick) {
  for (const double k : {0.1, 0.5, 3.0})
    for (const double s : {0.01, 0.03}) {
      const StallFigures f = stall_trials(k, s, 6);
      std::printf("k %.1f, %2.0f ms: %.1f mm/s (%.1f without a stall, %.1f in free air), least energy %.2f mJ\n", k,
                  1000 * s, f.stalled_mm_s, f.calm_mm_s, f.free_mm_s, f.energy_mJ);
      EXPECT_LE(f.stalled_mm_s, f.free_mm_s) << k << " " << s;
      EXPECT_LE(f.largest_step_N, 0.2 + 1e-9);
    }
}

// In free space nothing is left of a force that was held over a stall, and after a long one it begins anew.
TEST(Force, AHandThatLeftDuringAStallIsLetGo) {
  for (const int stall : {30, 400}) {
    ForceLoop loop;
    ForceModel m = plane(0.5);
    int64_t t = 0;
    const auto tick = [&](double z) {
      if (t % 16'000'000 == 0) ++m.seq, m.t_ns = t, loop.take(m);
      const Vec3 f = loop.tick(t, Vec3(0, 0, z), true).force_N;
      t += 1'000'000;
      return f;
    };
    for (int i = 0; i < 1000; ++i) tick(-2);
    EXPECT_NEAR(loop.state().force_N.z(), 0.8, 1e-3);
    t += int64_t(stall) * 1'000'000;
    for (int i = 0; i < 5; ++i) tick(stall == 30 ? 1.0 : -2.0);
    EXPECT_LT(loop.state().force_N.z(), stall == 30 ? 1e-9 : 0.02);
    EXPECT_EQ(loop.counts().stalls, 1);
  }
}

}  // namespace test_devices_force
}  // namespace limberg::bench
