// The law of motion: forces against their definitions, stability
// on both sides of the bound, settling, workers, rims, cursor.
#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <thread>

#include "sim/base/error.h"
#include "sim/skull/simplex/contour.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/generators.h"
#include "sim/skull/simplex/motion.h"
#include "tests/sim/skull/simplex/random.h"

namespace limberg::simplex {
namespace test_motion {

using test::Random;

Law law_of(Constraint c, double alpha = 0.5, int rigidity = 1, double gamma = 0.35) {
  Law l;
  l.gamma = gamma;
  l.zone = {{c, alpha, 0.5, rigidity, false}};
  return l;
}

Mesh noisy(Mesh m, double part, uint64_t seed) {
  Random rnd(seed);
  for (Vec3& x : m.x_mm) x += part * rnd.vec();
  m.before_mm = m.x_mm;
  return m;
}

/// Root mean square distance after the best similarity, and its scale.
std::pair<double, double> misfit(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  Vec3 ca = Vec3::Zero(), cb = Vec3::Zero();
  const double n = double(a.size());
  for (size_t i = 0; i < a.size(); ++i) ca += a[i] / n, cb += b[i] / n;
  Mat3 S = Mat3::Zero();
  double va = 0;
  for (size_t i = 0; i < a.size(); ++i) S += (b[i] - cb) * (a[i] - ca).transpose(), va += (a[i] - ca).squaredNorm();
  const Eigen::JacobiSVD<Mat3> svd(S, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Mat3 R = svd.matrixU() * svd.matrixV().transpose();
  const double s = (R.transpose() * S).trace() / va;
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += (b[i] - cb - s * (R * (a[i] - ca))).squaredNorm();
  return {std::sqrt(sum / n), s};
}

TEST(Force, IsWhatTheDefinitionSays) {
  InlineWorkers w;
  const Mesh m = noisy(make_torus(30, 10, 24, 12), 0.8, 3);
  for (Constraint c :
       {Constraint::position, Constraint::tangent, Constraint::angle, Constraint::curvature, Constraint::shape})
    for (int rigidity : {1, 3}) {
      Motion motion(w);
      ASSERT_TRUE(motion.set_law(law_of(c, 0.5, rigidity)));
      std::vector<Vec3> F;
      motion.internal_force(m, F);
      for (int32_t v = 0; v < m.slots(); ++v) {
        const Row& r = m.nbr[size_t(v)];
        const Vec3 &P = m.x_mm[size_t(v)], &A = m.x_mm[size_t(r[0])], &B = m.x_mm[size_t(r[1])],
                   &C = m.x_mm[size_t(r[2])];
        const LocalFrame f = m.frame(v);
        // The neighbourhood by its definition: within so many edges.
        std::vector<int32_t> near{v};
        for (int s = 0; s < rigidity; ++s)
          for (int32_t u : std::vector<int32_t>(near))
            for (int32_t t : m.nbr[size_t(u)])
              if (std::find(near.begin(), near.end(), t) == near.end()) near.push_back(t);
        double phi = 0, H = 0;
        for (int32_t u : near)
          phi += m.frame(u).bend() / double(near.size()), H += m.frame(u).mean_curvature_per_mm() / double(near.size());
        VertexShape s;
        Vec3 wanted = P;
        switch (c) {
          case Constraint::position:
            wanted = (A + B + C) / 3 + f.L_mm * f.N;
            break;
          case Constraint::tangent:
            wanted = (A + B + C) / 3;
            break;
          case Constraint::angle:
            s.phi = phi, wanted = decode(s, A, B, C);
            break;
          case Constraint::curvature:
            s.phi = std::asin(std::clamp(f.r_mm * H, -1., 1.)), wanted = decode(s, A, B, C);
            break;
          case Constraint::shape:
            wanted = decode(m.shape[size_t(v)], A, B, C);
            break;
        }
        ASSERT_LT((F[size_t(v)] - (wanted - P)).norm(), 1e-11) << int(c) << " " << v;
      }
    }
}

TEST(Shape, OfAnUndisturbedMeshIsAtRest) {
  InlineWorkers w;
  for (const Mesh& given : {make_sphere({5, 0, 0}, 10, 2), make_torus(30, 10, 24, 12), make_cylinder(8, 20, 12)}) {
    Mesh m = noisy(given, 0.5, 5);  // any shape will do
    record_shape(m);
    for (int r = 0; r < 2; ++r) {
      Motion motion(w);
      motion.set_law(law_of(Constraint::shape));
      EXPECT_LT(motion.rms_force_mm(m), 1e-12);
      record_shape(m, ShapeCode::height);
    }
  }
}

TEST(Shape, IsRecoveredUpToASimilarity) {
  InlineWorkers w;
  const Mesh reference = make_sphere({0, 0, 0}, 10, 2);
  Mesh m = noisy(reference, 0.5, 7);
  Motion motion(w);
  motion.set_law(law_of(Constraint::shape));
  double before = 1e9;
  for (int i = 0; i < 4000; ++i) {
    const StepReport r = motion.step(m);
    if (i % 500 == 499) {
      EXPECT_LT(r.max_move_mm, 0.7 * before + 1e-14);  // settles
      before = r.max_move_mm;
    }
  }
  const auto [rms, scale] = misfit(reference.x_mm, m.x_mm);
  EXPECT_LT(rms, 1e-9);
  EXPECT_NEAR(scale, 1, 0.01);
}

/// Largest move after `n` iterations of x + (1 - gamma)(x - before) + alpha F, whatever the bound says.
double run_free(const Mesh& start, Constraint c, int rigidity, double alpha, int n) {
  InlineWorkers w;
  Mesh m = start;
  Motion motion(w);
  motion.set_law(law_of(c, 0.01, rigidity));
  std::vector<Vec3> F, next;
  double move = 0;
  for (int i = 0; i < n; ++i) {
    motion.internal_force(m, F);
    move = 0;
    next = m.x_mm;
    for (size_t v = 0; v < F.size(); ++v) {
      next[v] += 0.65 * (m.x_mm[v] - m.before_mm[v]) + alpha * F[v];
      move = std::max(move, (next[v] - m.x_mm[v]).norm());
    }
    m.before_mm = m.x_mm, m.x_mm = next;
    if (!(move < 1e3)) return 1e3;
  }
  return move;
}

TEST(Stability, BothSidesOfTheBound) {
  const Mesh m = noisy(make_sphere({0, 0, 0}, 10, 2), 1e-3, 9);
  struct Case {
    Constraint c;
    int rigidity;
    double stable, diverges;  // reference values of alpha at gamma = 0.35
  };
  for (const Case& k : {Case{Constraint::shape, 1, 1.6, 1.75},
                        {Constraint::tangent, 1, 1.6, 1.75},
                        {Constraint::angle, 1, 1.05, 1.2}}) {
    const double small = run_free(m, k.c, k.rigidity, k.stable, 300),
                 large = run_free(m, k.c, k.rigidity, k.diverges, 300);
    EXPECT_LT(small, 0.3) << int(k.c);  // tangent shrinks: it moves, evenly
    EXPECT_GT(large, 1) << int(k.c);
    const Admission a = admit(law_of(k.c, k.stable, k.rigidity)), b = admit(law_of(k.c, k.diverges, k.rigidity));
    ASSERT_TRUE(a && b);
    EXPECT_TRUE(a.reduced.empty());
    EXPECT_EQ(b.reduced.size(), 1u);
    EXPECT_GT(b.law.zone[0].alpha, 0.9 * k.stable);
    EXPECT_LT(b.law.zone[0].alpha, k.diverges);
    EXPECT_FALSE(admit(law_of(k.c, k.diverges, k.rigidity), Excess::refuse));
  }
}

TEST(Stability, TheTableHoldsOnEvenMeshes) {
  InlineWorkers w;
  for (const Mesh& m : {make_sphere({0, 0, 0}, 10, 2), make_sphere_of_faces({0, 0, 0}, 10, 162)}) {
    const auto lambda = [&](Constraint c, int rigidity) {
      Motion motion(w);
      motion.set_law(law_of(c, 0.1, rigidity));
      return motion.measure_lambda(m, 150);
    };
    EXPECT_NEAR(lambda(Constraint::tangent, 1), 2, 0.05);
    EXPECT_LE(lambda(Constraint::shape, 1), 2);
    EXPECT_GT(lambda(Constraint::angle, 1), 2.7);
    EXPECT_LE(lambda(Constraint::angle, 1), 3);
    for (int s : {2, 3, 5}) EXPECT_LE(lambda(Constraint::angle, s), 2.5);
  }
}

TEST(Stability, AbsurdLawsAreRefusedWithReasons) {
  const auto refused = [](auto&& f) {
    Law l;
    f(l);
    const Admission a = admit(l);
    return !a && !a.refused.empty();
  };
  EXPECT_FALSE(refused([](Law&) {}));
  EXPECT_TRUE(refused([](Law& l) { l.gamma = 0; }));
  EXPECT_TRUE(refused([](Law& l) { l.gamma = 2; }));
  EXPECT_TRUE(refused([](Law& l) { l.gamma = NAN; }));
  EXPECT_TRUE(refused([](Law& l) { l.zone[0].alpha = -1; }));
  EXPECT_TRUE(refused([](Law& l) { l.zone[0].beta = INFINITY; }));
  EXPECT_TRUE(refused([](Law& l) { l.zone[0].rigidity = 0; }));
  EXPECT_TRUE(refused([](Law& l) { l.zone[0].beta = 2, l.external_stiffness = 2; }));
  EXPECT_TRUE(refused([](Law& l) { l.zone.clear(); }));
  EXPECT_TRUE(refused([](Law& l) { l.max_step_mm = 0; }));
  InlineWorkers w;
  Mesh m = make_sphere({0, 0, 0}, 1, 1);
  Motion motion(w);
  std::vector<Vec3> few(3);
  EXPECT_THROW(motion.step(m, {few, {}}), InputError);
  std::vector<Repulsor> bad{{{0, 0, NAN}, {0, 0, 0}, 1, 1}};
  EXPECT_THROW(motion.step(m, {{}, bad}), InputError);
}

/// Chunks from the last to the first, on two threads.
class Backwards final : public Workers {
 public:
  int count() const override { return 2; }
  void parallel_for(size_t n, size_t grain, const std::function<void(size_t, size_t)>& body) override {
    const size_t chunks = (n + grain - 1) / grain;
    auto run = [&](size_t odd) {
      for (size_t c = chunks; c-- > 0;)
        if (c % 2 == odd) body(c * grain, std::min(n, (c + 1) * grain));
    };
    std::thread t(run, 1);
    run(0);
    t.join();
  }
  std::shared_ptr<Job> submit(std::function<void()> f) override { return InlineWorkers().submit(std::move(f)); }
};

TEST(Motion, DoesNotDependOnWorkers) {
  InlineWorkers one;
  Backwards two;
  for (Constraint c : {Constraint::angle, Constraint::curvature, Constraint::shape}) {
    Mesh a = noisy(make_sphere({0, 0, 0}, 30, 4), 0.3, 11), b = a;
    Law l = law_of(c, 0.5, 2);
    l.metric_gain = 0.05, l.external_stiffness = 1;
    const std::vector<Vec3> pull(a.x_mm.size(), Vec3(0.01, 0, 0));
    const std::vector<Repulsor> hand{{{30, 0, 0}, {29, 0, 0}, 5, 0.5}};
    Motion x(one), y(two);
    x.set_law(l), y.set_law(l);
    for (int i = 0; i < 25; ++i) {
      const StepReport r = x.step(a, {pull, hand}), s = y.step(b, {pull, hand});
      EXPECT_EQ(r.rms_move_mm, s.rms_move_mm);
    }
    EXPECT_EQ(hash(a), hash(b));
  }
}

TEST(Angle, SettlesToASphereAndHardlyShrinks) {
  InlineWorkers w;
  Mesh m = make_sphere({0, 0, 0}, 10, 3), membrane = m;
  for (Mesh* q : {&m, &membrane}) {
    *q = noisy(*q, 0.15, 13);
    Motion motion(w);
    motion.set_law(law_of(q == &m ? Constraint::angle : Constraint::tangent, 0.5));
    const double before = motion.rms_force_mm(*q);
    for (int i = 0; i < 400; ++i) motion.step(*q);
    if (q == &m) {
      EXPECT_LT(motion.rms_force_mm(*q), 0.05 * before);
    }
  }
  const double V = 4. / 3 * 3.14159265 * 1000;
  EXPECT_NEAR(extent(m).volume_mm3, V, 0.05 * V);
  EXPECT_LT(extent(membrane).volume_mm3, 0.7 * V);
  double lo = 1e9, hi = 0;
  for (const Vec3& x : m.x_mm) lo = std::min(lo, x.norm()), hi = std::max(hi, x.norm());
  EXPECT_LT(hi - lo, 0.3);
}

TEST(External, DataPullTheMeshToThem) {
  InlineWorkers w;
  Mesh m = make_sphere({0, 0, 0}, 8, 3);
  Motion motion(w);
  Law l = law_of(Constraint::angle, 0.4, 2);
  l.zone[0].beta = 0.5, l.external_stiffness = 1;
  ASSERT_TRUE(motion.set_law(l));
  std::vector<Vec3> pull(m.x_mm.size());
  StepReport r;
  for (int i = 0; i < 300; ++i) {
    for (size_t v = 0; v < pull.size(); ++v) {  // an ellipsoid, along the ray
      const Vec3 u = m.x_mm[v].normalized();
      pull[v] = u * (1 / std::sqrt(u.x() * u.x() / 144 + (u.y() * u.y() + u.z() * u.z()) / 100)) - m.x_mm[v];
    }
    r = motion.step(m, {pull, {}});
  }
  EXPECT_LT(r.max_move_mm, 1e-3);
  double far = 0;
  for (const Vec3& x : m.x_mm)
    far = std::max(far, std::abs(x.x() * x.x() / 144 + (x.y() * x.y() + x.z() * x.z()) / 100 - 1));
  EXPECT_LT(far, 0.05);
}

TEST(Cursor, PushesAndAFastOneDoesNotJumpThrough) {
  InlineWorkers w;
  Mesh m = make_plane(40, 40, 1);
  for (const EndContour& e : end_contours(m))
    for (int32_t v : e.rim) m.flags[size_t(v)] |= kLocked;
  Motion motion(w);
  ASSERT_TRUE(motion.set_law(law_of(Constraint::shape, 0.5)));
  std::vector<Repulsor> hand{{{20, 20, 8}, {20, 20, -8}, 4, 0.5}};  // through the sheet in one iteration
  EXPECT_GT(motion.step(m, {{}, hand}).max_move_mm, 0.5);
  hand[0] = {{20, 20, -2}, {20, 20, -2}, 4, 0.5};
  StepReport r;
  for (int i = 0; i < 200; ++i) r = motion.step(m, {{}, hand});
  EXPECT_LT(r.max_move_mm, 1e-3);
  double top = 0;
  for (const Vec3& x : m.x_mm) top = std::max(top, x.z());
  EXPECT_GT(top, 0.3);  // pushed up
  EXPECT_LT(top, 2.1);
  hand.assign(50, hand[0]);
  EXPECT_LT(motion.step(m, {{}, hand}).repulsion, 0.2);  // fifty of them: weakened to stay stable
  for (int i = 0; i < 200; ++i) r = motion.step(m, {{}, hand});
  for (const Vec3& x : m.x_mm) ASSERT_TRUE(x.allFinite() && x.norm() < 100);
  for (int i = 0; i < 2000; ++i) r = motion.step(m);
  for (const Vec3& x : m.x_mm) ASSERT_NEAR(x.z(), 0, 0.02);  // and back
}

TEST(Motion, LockedFixedAndFreeSlots) {
  InlineWorkers w;
  Mesh m = noisy(make_sphere({0, 0, 0}, 10, 3), 0.3, 17);
  Delta d;
  int gone = 0;
  for (int32_t v = 0; v < m.slots() && gone < 60; v += 11)
    if (m.alive(v) && t1(m, v, m.nbr[size_t(v)][0], d)) ++gone;
  ASSERT_GT(gone, 30);
  Law l = law_of(Constraint::angle);
  l.zone.push_back({Constraint::shape, 0.5, 0.5, 1, true});
  for (int32_t v = 0; v < m.slots(); ++v)
    if (m.alive(v)) {
      if (m.x_mm[size_t(v)].z() > 5) m.zone[size_t(v)] = 1;
      if (m.x_mm[size_t(v)].z() < -5) m.flags[size_t(v)] |= kLocked;
    }
  Mesh start = m;
  Motion motion(w);
  motion.set_law(l);
  for (int i = 0; i < 50; ++i) motion.step(m);
  int moved = 0;
  for (int32_t v = 0; v < m.slots(); ++v) {
    if (!m.alive(v)) continue;
    const bool held = std::abs(start.x_mm[size_t(v)].z()) > 5;
    EXPECT_EQ(held && m.x_mm[size_t(v)] != start.x_mm[size_t(v)], false);
    moved += m.x_mm[size_t(v)] != start.x_mm[size_t(v)];
  }
  EXPECT_GT(moved, 100);
  EXPECT_EQ(find_fault(m).value_or(""), "");
  // Operators between steps are noticed.
  for (int32_t f = 0; f < 40; ++f)
    if (m.alive_face(f)) t2_across(m, f, d);
  for (int i = 0; i < 50; ++i) EXPECT_LT(motion.step(m).max_move_mm, 2);
  EXPECT_EQ(find_fault(m).value_or(""), "");
}

TEST(Motion, CurvatureAdaptationGathersVerticesWhereItIsCurved) {
  InlineWorkers w;
  Mesh m = make_sphere({0, 0, 0}, 10, 3), even = m;
  std::vector<Vec3> pull(m.x_mm.size());
  for (Mesh* q : {&m, &even}) {
    Motion motion(w);
    Law l = law_of(Constraint::position, 0.5);
    l.external_stiffness = 1, l.zone[0].beta = 0.6;
    l.metric_gain = q == &m ? 0.1 : 0;
    motion.set_law(l);
    for (int i = 0; i < 600; ++i) {
      for (size_t v = 0; v < pull.size(); ++v) {
        const Vec3 u = q->x_mm[v].normalized();
        pull[v] = u * (1 / std::sqrt(u.x() * u.x() / 900 + (u.y() * u.y() + u.z() * u.z()) / 100)) - q->x_mm[v];
      }
      motion.step(*q, {pull, {}});
    }
  }
  const auto at_tips = [](const Mesh& q) {
    return std::count_if(q.x_mm.begin(), q.x_mm.end(), [](const Vec3& x) { return std::abs(x.x()) > 25; });
  };
  EXPECT_GT(at_tips(m), at_tips(even) * 5 / 4);
  for (const auto& e : m.metric) EXPECT_TRUE(e[0] >= 0.04 && e[1] >= 0.04 && e[0] + e[1] <= 0.96);
}

TEST(Rims, BehaveAsCurves) {
  InlineWorkers w;
  // A noisy cylinder settles; its rims stay rings of about the radius.
  Mesh m = noisy(make_cylinder(10, 30, 16), 0.2, 19);
  Motion motion(w);
  ASSERT_TRUE(motion.set_law(law_of(Constraint::angle, 0.5, 2)));
  const double before = motion.rms_force_mm(m);
  for (int i = 0; i < 60; ++i) motion.step(m);
  EXPECT_LT(motion.rms_force_mm(m), 0.3 * before);
  for (const EndContour& e : end_contours(m))
    for (int32_t v : e.rim) EXPECT_NEAR(m.x_mm[size_t(v)].head<2>().norm(), 10, 2);
  // The end contour of a flat sheet stays flat and does not shrink away under `angle`.
  Mesh sheet = make_plane(30, 30, 2);
  const double area = extent(sheet).area_mm2;
  motion.set_law(law_of(Constraint::angle, 0.5));
  for (int i = 0; i < 100; ++i) motion.step(sheet);
  EXPECT_GT(extent(sheet).area_mm2, 0.8 * area);
  for (const Vec3& x : sheet.x_mm) EXPECT_NEAR(x.z(), 0, 1e-9);
}

TEST(Settling, EnergyGoesDownGeometrically) {
  InlineWorkers w;
  const Mesh reference = make_sphere({0, 0, 0}, 10, 2);
  Mesh m = reference;
  m.flags[0] |= kLocked, m.flags[10] |= kLocked, m.flags[100] |= kLocked,
      m.flags[200] |= kLocked;  // anchors hold scale and pose
  Random rnd(23);
  for (size_t v = 0; v < m.x_mm.size(); ++v)
    if (!(m.flags[v] & kLocked)) m.x_mm[v] += 0.1 * rnd.vec(), m.before_mm[v] = m.x_mm[v];
  Motion motion(w);
  motion.set_law(law_of(Constraint::shape, 1));
  const double start = motion.rms_force_mm(m);
  for (int i = 0; i < 20000; ++i) motion.step(m);
  EXPECT_LT(motion.rms_force_mm(m), 1e-8 * start);
  double far = 0;
  for (size_t v = 0; v < m.x_mm.size(); ++v) far = std::max(far, (m.x_mm[v] - reference.x_mm[v]).norm());
  EXPECT_LT(far, 1e-6);  // not only the shape: the anchors bring back place and size
}

}  // namespace test_motion
}  // namespace limberg::simplex
