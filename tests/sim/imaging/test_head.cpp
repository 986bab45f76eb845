// The synthetic head: distances, meshes, landmarks, CT.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/base/error.h"
#include "sim/imaging/synthetic/synthetic_head.h"
#include "sim/skull/simplex/dual.h"

namespace limberg {
namespace test_head {

struct Random {
  uint64_t s = 1;
  double operator()() {
    s = s * 6364136223846793005ull + 1442695040888963407ull;
    return double(s >> 11) / 9007199254740992.;
  }
  Vec3 in_box() {
    const Vec3 lo = HeadShape::low_mm(), hi = HeadShape::high_mm();
    return lo + Vec3((*this)(), (*this)(), (*this)()).cwiseProduct(hi - lo);
  }
};

const HeadModel& head() {
  static const HeadModel h = [] {
    InlineWorkers w;
    return make_head({}, w);
  }();
  return h;
}

std::map<std::string, Vec3> landmarks(const HeadSpec& spec = {}) {
  std::map<std::string, Vec3> out;
  for (const auto& [name, p] : head_landmarks(HeadShape(spec))) out[name] = p;
  return out;
}

double angle_deg(const Vec3& a, const Vec3& corner, const Vec3& b) {
  return std::acos((a - corner).normalized().dot((b - corner).normalized())) * 180 / M_PI;
}

TEST(HeadShape, DistancesHaveTheirSignsAndTheirBound) {
  for (HeadSpec spec :
       {HeadSpec{},
        HeadSpec{
            .mandible_scale = 0.85, .ramus_left = 0.8, .vault_wide = 1.1, .vault_long = 0.9, .forehead_flat = 1}}) {
    const HeadShape h(spec);
    // Inside: brain's shell at the vertex, cheekbone, chin; outside: brain, orbit, nose, mouth, far away.
    EXPECT_LT(h.skull({0, 2, 115}), 0);
    EXPECT_LT(h.skull({53, 62, -6}), -3);
    EXPECT_GT(h.skull({0, 2, 53}), 20);
    EXPECT_LT(h.brain({0, 2, 53}), -20);
    EXPECT_GT(h.skull({31, 82, 14}), 5);
    EXPECT_GT(h.skull({0, 70, -20}), 5);
    EXPECT_GT(h.skull({0, -22, -15}), 5);  // foramen magnum
    EXPECT_LT(h.mandible(h.mandible_place({0, 82, -90})), -3);
    EXPECT_LT(h.skin({0, 2, 53}), -35);
    EXPECT_GT(h.skin({0, 130, 100}), 20);
    Random r;
    double worst = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 p = r.in_box(), d = Vec3(r() - 0.5, r() - 0.5, r() - 0.5);
      const Vec3 q = p + std::pow(10, -3 + 4 * r()) * d;
      const double l = (q - p).norm();
      for (double slope : {std::abs(h.skull(p) - h.skull(q)) / l, std::abs(h.mandible(p) - h.mandible(q)) / l,
                           std::abs(h.skin(p) - h.skin(q)) / l})
        worst = std::max(worst, slope);
      if (spec.ramus_left == 1) {
        EXPECT_NEAR(h.bone(p), h.bone({-p.x(), p.y(), p.z()}), 1e-9);
        EXPECT_NEAR(h.skin(p), h.skin({-p.x(), p.y(), p.z()}), 1e-9);
      }
    }
    EXPECT_LT(worst, HeadShape::kLipschitz);
    EXPECT_GT(worst, 0.9);
  }
  EXPECT_THROW(HeadShape({.mandible_scale = 2}), InputError);
  EXPECT_THROW(HeadShape({.forehead_flat = NAN}), InputError);
  EXPECT_THROW(HeadShape({.edge_mm = 0}), InputError);
}

TEST(HeadShape, BoneLiesUnderTheSkinAndTheMandibleUnderTheSkull) {
  for (HeadSpec spec : {HeadSpec{}, HeadSpec{.mandible_scale = 0.85}, HeadSpec{.mandible_scale = 1.15},
                        HeadSpec{.ramus_left = 0.8}, HeadSpec{.forehead_flat = 1}}) {
    const HeadShape h(spec);
    Random r;
    double thinnest = 1e9, gap = 1e9;
    for (int i = 0; i < 60000; ++i) {
      const Vec3 p = r.in_box();
      const double m = h.mandible(p), s = h.skull(p);
      if (m < 0 || s < 0) thinnest = std::min(thinnest, -h.skin(p));
      if (m < 0) gap = std::min(gap, s);
    }
    EXPECT_GT(thinnest, 2.0) << spec.mandible_scale;                       // rhinion: 3.1 mm published
    EXPECT_GT(gap, 1.0) << spec.mandible_scale << " " << spec.ramus_left;  // two bones
  }
}

TEST(LevelSet, SkippingBlocksLosesNothingAndTheSurfaceIsAManifold) {
  const HeadShape h({});
  InlineWorkers w;
  LevelSet s{[&](const Vec3& p) { return h.skull(p); }, HeadShape::kLipschitz, {-110, 20, -60}, {110, 140, 40}};
  std::vector<Vec3> X, Y;
  std::vector<Tri> T, U;
  int64_t skipped = 0, all = 0;
  march(s, 3, w, X, T, &skipped);
  s.lipschitz = 1e9;
  march(s, 3, w, Y, U, &all);
  EXPECT_LT(double(skipped), 0.7 * double(all));
  EXPECT_EQ(X, Y);
  EXPECT_EQ(T, U);
  EXPECT_NO_THROW(simplex::from_triangles(X, T));
  // Area and volume of a sphere, from inside out.
  LevelSet ball{[](const Vec3& p) { return (p - Vec3(1, 2, 3)).norm() - 20; }, 1, {-30, -30, -30}, {30, 30, 30}};
  LevelSetReport report;
  const simplex::Mesh m = mesh_level_set(ball, {.grid_mm = 2, .edge_mm = 2}, w, &report);
  const simplex::Extent e = simplex::extent(m);
  EXPECT_NEAR(e.volume_mm3, 4. / 3 * M_PI * 8000, 0.01 * 33510);
  EXPECT_NEAR(e.area_mm2, 4 * M_PI * 400, 0.01 * 5027);
  EXPECT_LT(report.max_mm, 1e-3);
  EXPECT_EQ(report.folded, 0);
  EXPECT_EQ(simplex::census(m).genus, 0);
  EXPECT_THROW(march(ball, 1e-5, w, X, T), InputError);
  EXPECT_THROW(march(ball, NAN, w, X, T), InputError);
  ball.distance_mm = [](const Vec3&) { return 1.; };
  EXPECT_THROW(mesh_level_set(ball, {}, w), InputError);
}

TEST(HeadModel, MeshesAreClosedOfTheStatedTopologyAndOnTheSurface) {
  const HeadModel& h = head();
  struct Part {
    const char* name;
    const simplex::Mesh& mesh;
    const LevelSetReport& report;
    int64_t genus, ends, least, most;
  };
  const HeadShape shape({});
  for (const Part& p : {Part{"cranium", h.cranium, h.cranium_report, 3, 0, 8000, 12000},
                        {"mandible", h.mandible, h.mandible_report, 0, 0, 800, 1500},
                        {"face", h.face, h.face_report, 0, 1, 4500, 6000}}) {
    SCOPED_TRACE(p.name);
    EXPECT_EQ(simplex::find_fault(p.mesh).value_or(""), "");
    const simplex::Census c = simplex::census(p.mesh);
    EXPECT_EQ(c.components, 1);
    EXPECT_EQ(c.genus, p.genus);
    EXPECT_EQ(c.end_contours, p.ends);
    EXPECT_GE(c.vertices, p.least);
    EXPECT_LE(c.vertices, p.most);
    EXPECT_LT(p.report.max_mm, 1e-3);
    EXPECT_LE(p.report.folded, 4);
    EXPECT_LT(p.report.face_rms_mm, 0.4);  // flat faces of 4 to 5 mm edges on radii of 5 mm and more: h^2 / 8 r = 0.5
    std::printf("%s: %lld vertices, distance rms %.2g max %.2g mm, face centres rms %.2f max %.2f mm, %d folded\n",
                p.name, static_cast<long long>(c.vertices), p.report.rms_mm, p.report.max_mm, p.report.face_rms_mm,
                p.report.face_max_mm, p.report.folded);
  }
  // The volume of the mesh is that of the shape (by counting 2.5 mm cells).
  // Flat faces lose about h^2 / r a side on rods of 5 to 7 mm radius.
  for (const auto& [mesh, f] : {std::pair{&h.cranium, +[](const HeadShape&s, const Vec3&x) { return s.skull(x); }},
                                {&h.mandible, +[](const HeadShape&s, const Vec3&x) { return s.mandible(x); }}}) {
    double inside = 0;
    for (double x = -80; x < 80; x += 2.5)
      for (double y = -95; y < 115; y += 2.5)
        for (double z = -110; z < 125; z += 2.5) inside += f(shape, {x, y, z}) < 0 ? 2.5 * 2.5 * 2.5 : 0;
    EXPECT_NEAR(simplex::extent(*mesh).volume_mm3, inside, (mesh == &h.mandible ? 0.07 : 0.03) * inside);
  }
  for (int32_t f = 0; f < h.face.face_slots(); ++f) {
    if (h.face.kind(f) != simplex::FaceKind::hole) continue;
    for (int32_t v : h.face.ring(f)) EXPECT_NEAR(h.face.x_mm[size_t(v)].z(), HeadShape::kNeck_mm, 1e-6);
  }
}

TEST(HeadModel, LandmarksLieOnTheirSurfacesAndAreExtremal) {
  const HeadShape h({});
  const auto L = landmarks();
  size_t expected = 1;
  for (const LandmarkRule& r : landmark_rules()) expected += r.pair ? 2 : 1;
  EXPECT_EQ(L.size(), expected);
  for (const LandmarkRule& r : landmark_rules()) {
    SCOPED_TRACE(r.name);
    const Vec3 p = L.at(r.pair ? std::string(r.name) + "_R" : r.name);
    const auto f = [&](const Vec3& q) {
      return r.surface == LandmarkRule::Surface::skull      ? h.skull(q)
             : r.surface == LandmarkRule::Surface::mandible ? h.mandible(q)
                                                            : h.skin(q);
    };
    EXPECT_LT(std::abs(f(p)), 1e-5);
    EXPECT_LT((p - r.place).norm(), 12);
    if (r.pair) {
      const Vec3 q = L.at(std::string(r.name) + "_L");
      EXPECT_LT((Vec3(-q.x(), q.y(), q.z()) - p).norm(), 1e-3);
    }
    if (r.reach_mm[1] == 0) continue;
    // Extremal within the plane that was searched: the surface's normal has no part along the score there.
    LevelSet s{f, 1, {}, {}};
    const Vec3 n = level_at(s, p).gradient.normalized(), look = r.look.normalized();
    Vec3 t = n.cross(r.reach_mm[0] > 0 ? n.cross(r.score) : Vec3(1, 0, 0));
    if (r.reach_mm[0] == 0) t = Vec3(1, 0, 0).cross(n);
    const double slope = t.normalized().dot(r.score.normalized());
    EXPECT_LT(std::abs(slope), 0.12) << "at " << p.transpose() << " look " << look.transpose();
  }
}

TEST(HeadModel, ProportionsAreThoseOfAnAdult) {
  const auto L = landmarks();
  const auto far = [&](const char* a, const char* b) { return (L.at(a) - L.at(b)).norm(); };
  // Norms and their spread as in measure/cephalometry.cpp; here: within three standard deviations or so.
  EXPECT_NEAR(angle_deg(L.at("S"), L.at("N"), L.at("A")), 82, 4);
  EXPECT_NEAR(angle_deg(L.at("S"), L.at("N"), L.at("B")), 80, 4);
  EXPECT_NEAR(angle_deg(L.at("Ba"), L.at("S"), L.at("N")), 130, 12);
  EXPECT_NEAR(far("Zy_L", "Zy_R"), 132, 3);   // bizygomatic 130-134
  EXPECT_NEAR(far("Go_L", "Go_R"), 102, 12);  // bigonial 97-107
  EXPECT_NEAR(far("S", "N"), 72, 8);
  EXPECT_NEAR(far("N", "Me"), 120, 12);
  EXPECT_NEAR(far("ch_L", "ch_R"), 54, 4);
  EXPECT_NEAR(far("en_L", "en_R"), 32, 2);
  EXPECT_NEAR(L.at("Or_R").z(), 0, 3);  // the Frankfurt plane
}

TEST(HeadModel, SoftTissueIsAsThickAsPublished) {
  const HeadShape h({});
  const auto L = landmarks();
  struct Row {
    const char* name;
    double published_mm, within_mm;
  };
  // Order of magnitude of adult means (glabella 5.5, nasion 6.5, rhinion 3.1, subspinale and philtrum 11 to 12.5,
  // pogonion 11, menton 7, zygion 6, gonion 10, vertex 5.5); individuals differ by a fifth to a third.
  for (const Row& r : {Row{"G", 5.5, 1.5},
                       {"N", 6.5, 1.5},
                       {"Rhi", 3.07, 0.6},
                       {"A", 11, 2.5},
                       {"Pog", 11, 2.5},
                       {"Me", 7, 2},
                       {"Zy_R", 6, 1},
                       {"Go_R", 10, 2.5},
                       {"V", 5.5, 1}}) {
    const double thick = -h.skin(L.at(r.name));
    std::printf("%s %.2f mm (published %.2f)\n", r.name, thick, r.published_mm);
    EXPECT_NEAR(thick, r.published_mm, r.within_mm) << r.name;
  }
}

TEST(HeadModel, VariantsMoveWhatTheySayAndNothingElse) {
  const auto normal = landmarks();
  const auto shorter = landmarks({.mandible_scale = 0.9}), ramus = landmarks({.ramus_left = 0.8}),
             flat = landmarks({.forehead_flat = 1}), wide = landmarks({.vault_wide = 1.1});
  EXPECT_NEAR((normal.at("Pog") - shorter.at("Pog")).y(), 7.15,
              0.4);  // a tenth of 71.5 mm from the ramus to the chin's middle
  EXPECT_LT((normal.at("A") - shorter.at("A")).norm(), 1e-6);
  EXPECT_LT((normal.at("Co_R") - shorter.at("Co_R")).norm(), 0.3);
  EXPECT_GT(shorter.at("sl").y(), 0);
  EXPECT_LT(shorter.at("pog'").y(), normal.at("pog'").y() - 4);
  EXPECT_NEAR((ramus.at("Go_L") - normal.at("Go_L")).z(), 8.2, 1.5);  // a fifth of 41 mm
  EXPECT_LT((ramus.at("Go_R") - normal.at("Go_R")).norm(), 1e-3);
  EXPECT_LT(flat.at("G").y(), normal.at("G").y() - 4);
  EXPECT_GT(HeadShape({.forehead_flat = 1}).skin({0, normal.at("G").y() + 5, 50}), 3);
  EXPECT_NEAR((wide.at("Eu_R") - wide.at("Eu_L")).norm() / (normal.at("Eu_R") - normal.at("Eu_L")).norm(), 1.1, 0.005);
}

TEST(HeadCt, NumbersAndSurfacesAreWhereTheyShouldBe) {
  InlineWorkers w;
  const HeadShape h({});
  const Volume v = head_ct({}, 2, w, {.noise_HU = 0}), noisy = head_ct({}, 2, w);
  const VolumeSampler s(v);
  const auto at = [&](const Vec3& p) { return s.value({-p.x(), -p.y(), p.z()}); };
  EXPECT_NEAR(at({0, 130, 100}), -1000, 1e-3);
  EXPECT_NEAR(at({0, 0, 60}), 35, 1);
  EXPECT_NEAR(at({31, 76, 14}), 20, 2);
  EXPECT_NEAR(at({0, 66, -19}), -1000, 5);    // nose
  EXPECT_NEAR(at({23, 66, -22}), -1000, 30);  // maxillary sinus
  EXPECT_GT(at({0, 2, 114.5}), 400);
  double square = 0;
  for (size_t i = 0; i < v.value.size(); ++i)
    square += std::pow(double(noisy.value[i]) - double(v.value[i]), 2) / double(v.value.size());
  EXPECT_NEAR(std::sqrt(square), 15, 0.1);
  // The isosurfaces of skin and bone against the shape, along lines inwards from the landmarks.
  double worst_skin = 0, worst_bone = 0;
  for (const auto& [name, p] : landmarks()) {
    if (name == "V" || name == "Eu_R" || name == "G") {
      const Vec3 n = Vec3(p.x(), p.y() * 0.4, p.z() - 50).normalized();
      for (double t = 3; t > -3; t -= 0.02)
        if (at(p + t * n) > 0.5 * (45 + 1100)) {
          worst_bone = std::max(worst_bone, std::abs(h.skull(p + t * n)));
          break;
        }
    }
    if (name == "v'" || name == "g'" || name == "pog'") {
      const Vec3 n = (p - Vec3(0, 20, 0)).normalized();
      for (double t = 6; t > -6; t -= 0.02)
        if (at(p + t * n) > -477) {
          worst_skin = std::max(worst_skin, std::abs(h.skin(p + t * n)));
          break;
        }
    }
  }
  EXPECT_LT(worst_skin, 0.4);  // a fifth of a voxel
  EXPECT_LT(worst_bone, 0.6);  // the table is three voxels thick and its middle less dense
  EXPECT_THROW(head_ct({}, 0.1, w), InputError);
  EXPECT_THROW(head_ct({}, 2, w, {.blur_mm = NAN}), InputError);
}

}  // namespace test_head
}  // namespace limberg
