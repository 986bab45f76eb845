// Refinement and files.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "sim/base/error.h"
#include "sim/skull/simplex/adapt.h"
#include "sim/skull/simplex/contour.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/file.h"
#include "sim/skull/simplex/generators.h"
#include "sim/skull/simplex/motion.h"

namespace limberg::simplex {
namespace test_adapt {

/// Vertices back onto an ellipsoid about the origin, after smoothing in the surface.
void settle(Mesh& m, const Vec3& half, int iterations) {
  InlineWorkers w;
  Motion motion(w);
  Law l;
  l.zone[0].constraint = Constraint::tangent;
  l.zone[0].alpha = 0.3, l.external_stiffness = 1, l.zone[0].beta = 0.5;
  motion.set_law(l);
  std::vector<Vec3> pull(m.x_mm.size(), Vec3::Zero());
  for (int i = 0; i < iterations; ++i) {
    for (int32_t v = 0; v < m.slots(); ++v)
      if (m.alive(v)) {
        const Vec3& x = m.x_mm[size_t(v)];
        pull[size_t(v)] = x / x.cwiseQuotient(half).norm() - x;
      }
    motion.step(m, {pull, {}});
  }
  for (int32_t v = 0; v < m.slots(); ++v)
    if (m.alive(v)) m.x_mm[size_t(v)] /= m.x_mm[size_t(v)].cwiseQuotient(half).norm();
  m.before_mm = m.x_mm;
}

TEST(Adapt, RefinesAndCoarsensToTheWantedSize) {
  const Mesh start = make_sphere({0, 0, 0}, 20, 3);
  for (double edge : {0.9, 4.}) {
    Mesh m = start;
    for (int i = 0; i < 12; ++i) {
      Delta d;
      const uint64_t before = hash(m);
      AdaptSettings s;
      s.edge_mm = edge, s.passes = 1, s.seed = uint64_t(i);
      adapt(m, s, d);
      ASSERT_EQ(find_fault(m).value_or(""), "");
      if (i == 0) {
        Mesh back = m;
        undo(back, d);
        EXPECT_EQ(hash(back), before);
      }
      settle(m, {20, 20, 20}, 10);
    }
    compact(m);
    const double wanted = 1.5 * std::sqrt(3.) * edge * edge, faces = 4 * 3.14159 * 400 / wanted;
    EXPECT_GT(m.faces(), 0.7 * faces);
    EXPECT_LT(m.faces(), 1.8 * faces);
    const FaceQuality q = face_quality(m);
    EXPECT_GE(q.smallest, 4);
    EXPECT_LE(q.largest, 9);
    EXPECT_LT(q.mean_deviation, 0.9);
    EXPECT_LT(q.area_cv, 0.4);
    EXPECT_EQ(census(m).genus, 0);
  }
}

TEST(Adapt, FollowsCurvature) {
  const Vec3 half(30, 8, 8);
  Mesh m = make_sphere({0, 0, 0}, 10, 3);
  for (Vec3& x : m.x_mm) x = x.cwiseProduct(half) / 10;
  m.before_mm = m.x_mm;
  Mesh even = m;
  for (int i = 0; i < 14; ++i) {
    Delta d;
    AdaptSettings s;
    s.edge_mm = 5, s.chord_mm = 0.06, s.min_edge_mm = 0.7, s.passes = 1, s.seed = uint64_t(i);
    adapt(m, s, d);
    settle(m, half, 6);
    s.chord_mm = 0, s.edge_mm = 2.6;
    adapt(even, s, d);
    settle(even, half, 6);
    ASSERT_EQ(find_fault(m).value_or(""), "");
  }
  // Mean face area near the tips against the waist.
  const auto ratio = [](const Mesh& q) {
    double tip = 0, waist = 0;
    int a = 0, b = 0;
    for (int32_t f = 0; f < q.face_slots(); ++f) {
      if (!q.alive_face(f)) continue;
      const double x = std::abs(face_centre(q, f).x());
      if (x > 28) tip += face_area(q, f).area_mm2, ++a;
      if (x < 12) waist += face_area(q, f).area_mm2, ++b;
    }
    return tip / std::max(1, a) / (waist / std::max(1, b));
  };
  EXPECT_LT(ratio(m), 0.6 * ratio(even));
}

TEST(Adapt, RefusesNonsenseAndRespectsWhatIsKept) {
  Mesh m = make_sphere({0, 0, 0}, 20, 3);
  Delta d;
  AdaptSettings s;
  for (double edge : {0., -1., double(NAN), double(INFINITY)}) {
    s.edge_mm = edge;
    EXPECT_THROW(adapt(m, s, d), InputError);
  }
  s.edge_mm = 0.01, s.max_vertices = 3000;
  adapt(m, s, d);
  EXPECT_LE(m.vertices(), 3000);
  EXPECT_EQ(find_fault(m).value_or(""), "");
  Mesh held = make_sphere({0, 0, 0}, 20, 3);
  const std::vector<int32_t> ring = held.ring(5);
  ASSERT_EQ(keep_contour(held, ring), "");
  for (size_t v = 0; v < held.flags.size(); ++v)
    if (held.x_mm[v].z() > 0) held.flags[v] |= kLocked;
  const Mesh start = held;
  s.edge_mm = 6, s.passes = 8;
  adapt(held, s, d);
  EXPECT_EQ(find_fault(held).value_or(""), "");
  for (int32_t v : ring) EXPECT_TRUE(held.alive(v));
  for (size_t v = 0; v < start.flags.size(); ++v)
    EXPECT_TRUE(!(start.flags[v] & kLocked) || held.x_mm[v] == start.x_mm[v]);
}

Mesh rich() {  // a bit of everything
  Mesh m = make_cylinder(10, 30, 12);
  append(m, make_sphere({30, 0, 0}, 7, 2));
  Delta d;
  const PlaneCurves c = curves_of_plane(m, {30, 0, 1}, Vec3::UnitZ());
  for (const auto& curve : c.curve) t4_edges(m, curve, CutPolicy::any, d);
  for (int32_t v = 0; v < 40; v += 9) t1(m, v, m.nbr[size_t(v)][1], d);
  for (int32_t f = 0; f < m.face_slots(); ++f)
    if (m.alive_face(f) && !is_end(m.kind(f))) {
      keep_contour(m, m.ring(f));
      break;
    }
  for (int32_t v = 0; v < m.slots(); v += 3) {
    m.zone[size_t(v)] = uint16_t(v), m.before_mm[size_t(v)] += Vec3(0.1, 1. / 3, 0), m.metric[size_t(v)] = {0.2, 0.3};
    m.shape[size_t(v)].phi = 0.1 * v;
    if (v % 2) m.flags[size_t(v)] |= kLocked, m.shape[size_t(v)].branch = ShapeBranch::far;
  }
  return m;
}

TEST(File, RoundTripToTheBit) {
  for (Mesh m : {rich(), make_sphere({0, 0, 0}, 1. / 3, 3), make_torus(30, 10, 12, 9), make_plane(10, 10, 1)}) {
    const std::string text = to_text(m);
    const Mesh back = parse_mesh(text, "test");
    compact(m);
    EXPECT_EQ(hash(back), hash(m));
    EXPECT_EQ(to_text(back), text);
    EXPECT_EQ(find_fault(back).value_or(""), "");
  }
  const std::string path = std::filesystem::temp_directory_path() / "limberg_simplex_test.simplex";
  const Mesh m = make_sphere({0, 0, 0}, 5, 1);
  save_mesh(m, path);
  save_mesh(m, path);
  EXPECT_EQ(hash(load_mesh(path)), hash(m));
  std::filesystem::remove(path);
  EXPECT_THROW(load_mesh(path), InputError);
  EXPECT_THROW(load_mesh(std::filesystem::temp_directory_path()), InputError);
  EXPECT_THROW(save_mesh(m, "/nowhere/at/all"), InputError);
  EXPECT_NE(to_obj(m).find("f "), std::string::npos);
}

TEST(File, SaysWhichWayItsAxesPoint) {
  Mesh m = make_sphere({3, 5, 7}, 2, 1);
  EXPECT_EQ(parse_mesh(to_text(m), "test").axes, Axes::unsaid);
  m.axes = Axes::left_posterior_superior;
  Mesh back = parse_mesh(to_text(m), "test");
  compact(back);
  EXPECT_EQ(back.axes, Axes::left_posterior_superior);
  turn_to_head(back);  // left 3, posterior 5, superior 7
  EXPECT_EQ(back.axes, Axes::right_forwards_up);
  for (int32_t v = 0; v < m.slots(); ++v) {
    const Vec3 &x = m.x_mm[size_t(v)], &y = back.x_mm[size_t(v)];
    EXPECT_EQ(y, Vec3(-x.x(), -x.y(), x.z()));
    EXPECT_EQ(back.before_mm[size_t(v)], y);
  }
  EXPECT_EQ(parse_mesh(to_text(back), "test").axes, Axes::right_forwards_up);
  const Mesh once = back;
  turn_to_head(back);
  EXPECT_EQ(hash(back), hash(once));
}

TEST(File, BrokenInputHasAMessage) {
  const std::string good = to_text(make_sphere({0, 0, 0}, 5, 0));
  const auto message = [](const std::string& text) {
    try {
      parse_mesh(text, "F");
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message(good), "accepted");
  EXPECT_EQ(message("# a comment\n\n" + good + "\r\n# end"), "accepted");
  EXPECT_NE(message("").find("empty"), std::string::npos);
  EXPECT_NE(message("OFF\n").find("F:1"), std::string::npos);
  EXPECT_NE(message("limberg-simplex 2\n").find("version"), std::string::npos);
  EXPECT_NE(message("limberg-simplex 1\n").find("no vertices"), std::string::npos);
  EXPECT_NE(message("limberg-simplex 1\nz 3\n").find("F:2"), std::string::npos);
  EXPECT_NE(message("limberg-simplex 1\naxes ras\n").find("are no known axes; expected lps or head"),
            std::string::npos);
  EXPECT_NE(message("limberg-simplex 1\naxes lps\naxes lps\n").find("F:3"), std::string::npos);
  EXPECT_NE(message(good + "axes lps\n").find("before the first vertex"), std::string::npos);
  EXPECT_NE(message(good + "q\n").find("no statement"), std::string::npos);
  EXPECT_NE(message(good + "v 1 2 3 4 5\n").find("F:22"), std::string::npos);
  EXPECT_NE(message(good + "v 1 2 nan 0 1 2\n").find("finite"), std::string::npos);
  EXPECT_NE(message(good + "v 1 2 1e300 0 1 2\n").find("kilometre"), std::string::npos);
  EXPECT_NE(message(good + "v 1 2 3 0 1 2\n").find("in turn"), std::string::npos);
  EXPECT_NE(message(good + "z 70000\n").find("65535"), std::string::npos);
  EXPECT_NE(message(good + "z -1\n").find("whole number"), std::string::npos);
  EXPECT_NE(message(good + "e 0 19 window\n").find("a hole, a cut or a wall"), std::string::npos);
  EXPECT_NE(message(good + "e 0 0 hole\n").find("not neighbours"), std::string::npos);
  EXPECT_NE(message(good + "e 0 4000 hole\n").find("not neighbours"), std::string::npos);
  EXPECT_NE(message(good + "c 0 1\n").find("F:22"), std::string::npos);
  EXPECT_NE(message(good + "c 0 99 1\n").find("not neighbours"), std::string::npos);
  EXPECT_NE(message(good + "s 1 2 3 4 up\n").find("near, far or height"), std::string::npos);
  EXPECT_NE(message(good + "l 3\n").find("more on the line"), std::string::npos);
  // Every truncation, and a byte changed everywhere: an answer or a message, never anything else.
  const std::string whole = to_text(rich());
  for (size_t n = 0; n < whole.size(); n += 97) message(whole.substr(0, n));
  for (size_t n = 0; n < good.size(); ++n)
    for (char c : {'9', 'v', '-', '\n', '\0'}) {
      std::string bad = good;
      bad[n] = c;
      message(bad);
    }
}

}  // namespace test_adapt
}  // namespace limberg::simplex
