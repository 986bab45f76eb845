// Fragments sorted by their cut rings; STL.
#include <gtest/gtest.h>

#include <cstring>

#include "sim/base/error.h"
#include "sim/skull/bone/bones.h"
#include "sim/skull/bone/gaps.h"
#include "sim/skull/bone/shape.h"
#include "sim/skull/bone/sorting.h"
#include "sim/testing/stl.h"
#include "tests/sim/skull/bone/heads.h"
#include "tests/sim/skull/needs_bullet.h"
#include "tests/sim/skull/simplex/random.h"

namespace limberg::bone {
namespace test_sorting {

/// A vault in six fragments: cut off, then apart by planes that meet each other.
test::KeptBones six_fragments(const Mat3& turn = Mat3::Identity()) {
  std::vector<NamedMesh> all;
  all.push_back({"cranium", test::skull_shell(4, {70, 85, 65}, 6, 3, turn), true});
  test::KeptBones b(std::move(all), test::inline_workers());
  const auto plane = [&](const Vec3& p, const Vec3& n, int32_t id) {
    Osteotomy o;
    o.kind = Osteotomy::Kind::plane, o.point_mm = p, o.normal = n, o.fragment = id;
    const Outcome done = b.cut(o);
    EXPECT_TRUE(done.done) << done.reason;
  };
  plane({0, 0, 12}, {0.1, 0.25, 1}, 0);  // 0 below, 1 the vault
  plane({5, 10, 0}, {0.15, 1, 0.1}, 1);  // front and back
  const int32_t back = b.fragments()[2].id;
  plane({6, 0, 0}, {1, 0.2, 0}, 1);
  plane({-9, 0, 0}, {1, -0.1, 0.1}, back);
  plane({0, -45, 0}, {0.3, 1, -0.3}, b.nearest_fragment({30, -50, 40}));
  EXPECT_EQ(b.fragments().size(), 6u);
  return b;
}

Eigen::Isometry3d anywhere(test::Random& random) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(random.uniform(0, 3), random.vec().normalized()).toRotationMatrix();
  T.translation() = random.vec(200);
  return T;
}

void move_mesh(simplex::Mesh& m, const Eigen::Isometry3d& T, test::Random& random, double noise_mm) {
  for (Vec3& x : m.x_mm) x = T * x + random.vec(noise_mm);
}

struct Errors {
  double place_mm = 0, angle_deg = 0;
  int pairs = 0;  // with a seam of 20 mm at least, all found
};

/// Sorts the pieces after random motions and noise; every pair and every place against what was done.
Errors sorted(std::vector<simplex::Mesh> pieces, double noise_mm, uint64_t seed) {
  test::Random random(seed);
  std::vector<Eigen::Isometry3d> moved;
  std::vector<FragmentShape> shapes;
  for (simplex::Mesh& m : pieces) {
    shapes.push_back(fragment_shape(m, 0));
    moved.push_back(anywhere(random));
    move_mesh(m, moved.back(), random, noise_mm);
  }
  const Sorting s = sort_fragments(pieces);
  Errors e;
  const auto against = [&](const Eigen::Isometry3d& found, size_t i, size_t j) {
    const Eigen::Isometry3d truth = moved[i] * moved[j].inverse();
    const Vec3 middle = moved[j] * (0.5 * (shapes[j].lo_mm + shapes[j].hi_mm));
    e.place_mm = std::max(e.place_mm, (found * middle - truth * middle).norm());
    e.angle_deg =
        std::max(e.angle_deg, Eigen::AngleAxisd(Mat3((truth.inverse() * found).linear())).angle() * 180 / M_PI);
  };
  for (size_t i = 0; i < pieces.size(); ++i) {
    EXPECT_EQ(s.group[i], 0) << i;
    for (size_t j = i + 1; j < pieces.size(); ++j) {
      const double seam = seam_mm2(shapes[i], shapes[j]);
      const auto m = std::find_if(s.matches.begin(), s.matches.end(),
                                  [&](const Match& k) { return size_t(k.a) == i && size_t(k.b) == j; });
      // Rings of pieces that meet at a corner only may run together
      // for a little; then they have to lie right all the same.
      if (seam == 0 && m != s.matches.end()) {
        EXPECT_LT(m->length_mm, 60) << i << " " << j;
      }
      // A seam of 6 mm thickness runs along twice its length: two tables.
      if (seam > 6 * 20) {
        ++e.pairs;
        std::string why;
        for (const Unmatched& u : s.refused)
          if (size_t(u.a) == i && size_t(u.b) == j) why = u.reason;
        EXPECT_TRUE(m != s.matches.end()) << i << " " << j << " seam " << seam << ": " << why;
      }
      if (m != s.matches.end()) against(m->b_in_a, i, j);
    }
    against(s.pose[i], 0, i);
  }
  return e;
}

TEST(Sorting, SixFragmentsMovedAtRandomAreFoundToFit) {
  const std::vector<simplex::Mesh> pieces = pieces_of(six_fragments());
  for (const double noise_mm : {0., 0.2, 0.3}) {
    const Errors e = sorted(pieces, noise_mm, 5);
    std::printf("noise up to %.2f mm each way: %d pairs, %.3f mm, %.3f degrees\n", noise_mm, e.pairs, e.place_mm,
                e.angle_deg);
    EXPECT_GE(e.pairs, 7);
    EXPECT_LE(e.place_mm, noise_mm == 0 ? 0.05 : 0.5);
    EXPECT_LE(e.angle_deg, noise_mm == 0 ? 0.1 : 1);
  }
}

TEST(Sorting, RingsThatAreDividedDifferentlyAreTheSame) {
  // The same cuts in the same shape under another mesh; every second piece is taken from there.
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  std::vector<simplex::Mesh> pieces = pieces_of(six_fragments()), other = pieces_of(six_fragments(turn));
  ASSERT_EQ(other.size(), pieces.size());
  for (size_t i = 1; i < pieces.size(); i += 2) pieces[i] = other[i];
  for (const double noise_mm : {0., 0.2}) {
    const Errors e = sorted(pieces, noise_mm, 17);
    std::printf("other mesh, noise up to %.2f mm each way: %d pairs, %.3f mm, %.3f degrees\n", noise_mm, e.pairs,
                e.place_mm, e.angle_deg);
    EXPECT_GE(e.pairs, 7);
    EXPECT_LE(e.place_mm, 0.5);
    EXPECT_LE(e.angle_deg, 1);
  }
}

TEST(Sorting, WhatDoesNotBelongTogetherIsRefused) {
  // The pieces of one skull's forehead against the window of another.
  Bones one = test::simple_head(4), other = test::simple_head(4);
  Osteotomy o = test::window();
  o.path_mm = test::on_ellipsoid(test::circle({0, 68, 30}, {0, 1, 0.5}, 24, 80, 0.2));
  ASSERT_TRUE(one.cut(o).done);
  o.path_mm = test::on_ellipsoid(test::circle({5, 60, 40}, {0, 1, 0.9}, 20, 80, -0.25));
  ASSERT_TRUE(other.cut(o).done);
  const std::vector<simplex::Mesh> a = pieces_of(one), b = pieces_of(other);
  const Sorting right = sort_fragments({a[0], a[2]}), wrong = sort_fragments({a[0], b[2]});
  ASSERT_EQ(right.matches.size(), 1u);
  EXPECT_TRUE(wrong.matches.empty());
  ASSERT_EQ(wrong.refused.size(), 1u);
  std::printf("%s\n", wrong.refused[0].reason.c_str());
  // A round hole in a sphere: it fits at every angle.
  std::vector<NamedMesh> ball;
  ball.push_back({"ball", test::skull_shell(4, {70, 70, 70}), true});
  test::KeptBones round(std::move(ball), test::inline_workers());
  o.path_mm = test::on_ellipsoid(test::circle({0, 60, 0}, {0, 1, 0}, 25, 80), {70, 70, 70});
  ASSERT_TRUE(round.cut(o).done);
  const Sorting turned = sort_fragments(pieces_of(round));
  EXPECT_TRUE(turned.matches.empty());
  ASSERT_EQ(turned.refused.size(), 1u);
  EXPECT_NE(turned.refused[0].reason.find("several"), std::string::npos) << turned.refused[0].reason;
}

/// How far the fragments lie from where they were cut, which is where the fixed one still is.
void expect_back(const Bones& b) {
  for (const Fragment& f : b.fragments()) {
    EXPECT_LE((f.pose * f.centre_mm - f.centre_mm).norm(), 0.5) << f.name;  // the bars of the noisy rings above
    EXPECT_LE(Eigen::AngleAxisd(Mat3(f.pose.linear())).angle() * 180 / M_PI, 1) << f.name;
  }
}

TEST(SortingAct, BringsEachFragmentBackInOneStep) {
  test::KeptBones b = six_fragments();
  test::Random random(11);
  for (const Fragment& f : std::vector<Fragment>(b.fragments()))
    if (!f.fixed) {
      ASSERT_TRUE(b.move(f.id, anywhere(random)).done);
    }
  const uint64_t apart = b.hash();
  const Outcome o = b.sort();
  ASSERT_TRUE(o.done) << o.reason;
  std::printf("%s\n", o.reason.c_str());
  EXPECT_EQ(b.fragment(0)->pose.matrix(), Eigen::Matrix4d::Identity());  // it is fixed
  expect_back(b);
  const uint64_t together = b.hash();
  // Again there is nothing to do: no act, so that an undo is not one of nothing.
  const Outcome again = b.sort();
  EXPECT_FALSE(again.done);
  EXPECT_NE(again.reason.find("lie so already"), std::string::npos) << again.reason;
  EXPECT_EQ(b.hash(), together);
  ASSERT_TRUE(b.undo().done);
  EXPECT_EQ(b.hash(), apart);
  ASSERT_TRUE(b.redo().done);
  EXPECT_EQ(b.hash(), together);
}

TEST(SortingAct, TheFixedOneStaysWhateverItsNumber) {
  const std::vector<simplex::Mesh> piece = pieces_of(six_fragments());
  std::vector<NamedMesh> two;
  two.push_back({"vault", piece[1], false}), two.push_back({"skull base", piece[0], true});
  test::KeptBones b(std::move(two), test::inline_workers());
  test::Random random(13);
  ASSERT_TRUE(b.move(0, anywhere(random)).done);
  const Outcome o = b.sort();
  ASSERT_TRUE(o.done) << o.reason;
  EXPECT_EQ(b.fragment(1)->pose.matrix(), Eigen::Matrix4d::Identity());
  expect_back(b);
}

TEST(SortingAct, APlateThatHoldsFragmentsApartHasToGoFirst) {
  test::KeptBones b = six_fragments();
  test::Random random(12);
  ASSERT_TRUE(b.move(1, anywhere(random)).done);
  Vec3 on1, on2;
  ASSERT_EQ(b.nearest_fragment(b.fragment(1)->centre_mm, &on1), 1);
  ASSERT_EQ(b.nearest_fragment(b.fragment(2)->centre_mm, &on2), 2);
  ASSERT_TRUE(b.plate(on1, on2).done);
  const uint64_t plated = b.hash();
  const Outcome held = b.sort();
  EXPECT_FALSE(held.done);
  EXPECT_NE(held.reason.find("a plate holds them"), std::string::npos) << held.reason;
  EXPECT_EQ(b.hash(), plated);
  ASSERT_TRUE(b.unplate(1).done);
  const Outcome o = b.sort();
  ASSERT_TRUE(o.done) << o.reason;
  expect_back(b);
  // A plate between fragments that fit goes along.
  ASSERT_TRUE(b.plate(on1, on2).done);
  const Eigen::Isometry3d one = b.fragment(1)->pose, away = anywhere(random);
  ASSERT_TRUE(b.move(1, away * one).done);
  const Outcome both = b.sort();
  ASSERT_TRUE(both.done) << both.reason;
  expect_back(b);
}

TEST(SortingAct, ARefusalSaysWhyAndChangesNothing) {
  LIMBERG_NEEDS_BULLET();
  const auto refused = [](test::KeptBones& b, const char* says) {
    const uint64_t before = b.hash();
    const bool undo = b.can_undo();
    const Outcome o = b.sort();
    EXPECT_FALSE(o.done);
    EXPECT_NE(o.reason.find(says), std::string::npos) << o.reason;
    EXPECT_EQ(b.hash(), before);
    EXPECT_EQ(b.can_undo(), undo);
  };
  test::KeptBones whole = test::simple_head();
  refused(whole, "no fragment fits another by its cut rings");
  std::vector<NamedMesh> ball;
  ball.push_back({"ball", test::skull_shell(4, {70, 70, 70}), true});
  test::KeptBones round(std::move(ball), test::inline_workers());
  Osteotomy o;
  o.path_mm = test::on_ellipsoid(test::circle({0, 60, 0}, {0, 1, 0}, 25, 80), {70, 70, 70});
  ASSERT_TRUE(round.cut(o).done);
  ASSERT_TRUE(round.move(1, test::moved({0, 40, 0}, 1)).done);
  refused(round, "several");
  ASSERT_TRUE(round.grab(1).done);
  EXPECT_NE(round.sort().reason.find("held"), std::string::npos);
  // Two that are fixed cannot be brought together.
  const std::vector<simplex::Mesh> piece = pieces_of(six_fragments());
  std::vector<NamedMesh> two;
  two.push_back({"skull base", piece[0], true}), two.push_back({"vault", piece[1], true});
  test::KeptBones both(std::move(two), test::inline_workers());
  refused(both, "skull base and vault fit each other and are fixed, both");
}

TEST(Stl, IsClosedAndHasTheVolume) {
  test::KeptBones b = test::simple_head();
  ASSERT_TRUE(b.cut(test::window()).done);
  const Fragment& f = b.fragments()[2];
  const std::string s = to_stl(b.mesh(), f.vertex, test::moved({1, 2, 3}, 0.3));
  uint32_t n;
  std::memcpy(&n, s.data() + 80, 4);
  ASSERT_EQ(s.size(), 84 + 50 * size_t(n));
  double volume = 0;
  for (uint32_t t = 0; t < n; ++t) {
    float x[12];
    std::memcpy(x, s.data() + 84 + 50 * t, sizeof x);
    const Vec3 p(x[3], x[4], x[5]), q(x[6], x[7], x[8]), r(x[9], x[10], x[11]);
    volume += p.dot(q.cross(r)) / 6;
    EXPECT_GT((q - p).cross(r - p).dot(Vec3(x[0], x[1], x[2])), -1e-6);
  }
  EXPECT_NEAR(volume, f.volume_mm3, 1e-3 * f.volume_mm3);
  EXPECT_THROW(to_stl(b.mesh(), -4, Eigen::Isometry3d::Identity()), InputError);
  EXPECT_THROW(save_stl(s, "/nonexistent-folder/x.stl"), InputError);
}

}  // namespace test_sorting
}  // namespace limberg::bone
