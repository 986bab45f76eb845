// Slices of a volume with contours: which way they look, what a plane cuts, how it is drawn.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>

#include "app/patient/slices.h"
#include "app/program/temporary_folder.h"
#include "render/text.h"
#include "sim/base/elementary.h"
#include "sim/base/error.h"

namespace limberg {
namespace test_slices {

template <class F>
Volume sampled(double half_mm, double step_mm, F&& f) {
  Volume v;
  const int32_t n = int32_t(2 * half_mm / step_mm) + 1;
  v.size = {n, n, n};
  v.step_mm = step_mm * Mat3::Identity();
  v.origin_mm = Vec3::Constant(-0.5 * step_mm * (n - 1));
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) v.value.push_back(float(f(v.place(Vec3(i, j, k)))));
  return v;
}

struct Triangles {
  std::vector<Vec3> x;
  std::vector<Tri> tri;
};

/// By latitude and longitude, z the axis; with an even number of rings the equator is one.
Triangles ball(double radius, int rings, int around) {
  Triangles s;
  s.x.emplace_back(0, 0, radius);
  for (int r = 1; r < rings; ++r)
    for (int a = 0; a < around; ++a) {
      const double polar = std::numbers::pi * r / rings, turn = 2 * std::numbers::pi * a / around,
                   q = radius * elementary::sin(polar);
      const double z = 2 * r == rings ? 0 : radius * elementary::cos(polar);
      s.x.emplace_back(q * elementary::cos(turn), q * elementary::sin(turn), z);
    }
  s.x.emplace_back(0, 0, -radius);
  const auto at = [&](int r, int a) {
    return int32_t(r == 0 ? 0 : r == rings ? int(s.x.size()) - 1 : 1 + (r - 1) * around + a % around);
  };
  for (int r = 0; r < rings; ++r)
    for (int a = 0; a < around; ++a) {
      if (r > 0) s.tri.push_back({at(r, a), at(r + 1, a), at(r, a + 1)});
      if (r + 1 < rings) s.tri.push_back({at(r, a + 1), at(r + 1, a), at(r + 1, a + 1)});
    }
  return s;
}

/// A cube from -10 to 10 mm.
Triangles cube() {
  Triangles s;
  for (int c = 0; c < 8; ++c) s.x.emplace_back(c & 1 ? 10 : -10, c & 2 ? 10 : -10, c & 4 ? 10 : -10);
  for (const auto& [a, b, c, d] : {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4},
                                   std::array{2, 6, 7, 3}, std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}})
    s.tri.push_back({a, b, c}), s.tri.push_back({a, c, d});
  return s;
}

/// Nothing but grey values and contours.
SliceLook bare() {
  SliceLook look;
  look.words = false;
  return look;
}

using Segments = std::vector<std::array<Vec3, 2>>;
double length(const Segments& all) {
  double sum = 0;
  for (const auto& [a, b] : all) sum += (b - a).norm();
  return sum;
}

/// Whether every end is met by exactly one other one, to the last bit, and no segment is there twice.
bool closed(const Segments& all) {
  using Key = std::array<double, 3>;
  std::map<Key, int> ends;
  std::map<std::array<Key, 2>, int> twice;
  for (const auto& [a, b] : all) {
    Key p{a.x(), a.y(), a.z()}, q{b.x(), b.y(), b.z()};
    ++ends[p], ++ends[q];
    if (++twice[{std::min(p, q), std::max(p, q)}] > 1) return false;
  }
  return std::all_of(ends.begin(), ends.end(), [](const auto& e) { return e.second == 2; });
}

TEST(PlaneCut, ContoursOfAClosedSurfaceAreClosed) {
  const Triangles b = ball(20, 40, 81);
  for (const double at : {-17.9, -7.3, 0., 4., 15.5})
    for (const int axis : {0, 1, 2}) {
      const Segments s = cut_by_plane(b.x, b.tri, axis, at);
      EXPECT_TRUE(closed(s)) << axis << " " << at;
      EXPECT_NEAR(length(s), 2 * std::numbers::pi * std::sqrt(400 - at * at), 0.4) << axis << " " << at;
      for (const auto& [p, q] : s) {
        EXPECT_EQ(p[axis], at);
        EXPECT_EQ(q[axis], at);
      }
    }
  EXPECT_TRUE(cut_by_plane(b.x, b.tri, 2, 20.1).empty());
  EXPECT_TRUE(cut_by_plane(b.x, b.tri, 2, -20.1).empty());
}

// The equator of the ball is a ring of edges in the plane, each of two triangles: each is there once.
TEST(PlaneCut, EdgesInThePlaneComeOnce) {
  const Triangles b = ball(20, 40, 81);
  const Segments s = cut_by_plane(b.x, b.tri, 2, 0);
  EXPECT_EQ(s.size(), 81u);
  EXPECT_TRUE(closed(s));
}

// The plane goes through two corners and otherwise through faces; where it touches one only nothing is cut.
TEST(PlaneCut, CornersInThePlane) {
  const Triangles o = ball(10, 2, 4);  // an octahedron
  const Segments s = cut_by_plane(o.x, o.tri, 2, 0);
  EXPECT_EQ(s.size(), 4u);
  EXPECT_TRUE(closed(s));
  std::vector<Vec3> turned = o.x;  // two corners at x = 0, four edges through which the plane goes
  for (Vec3& x : turned) x = Vec3(0.8 * x.x() - 0.6 * x.y(), 0.6 * x.x() + 0.8 * x.y(), x.z());
  const Segments t = cut_by_plane(turned, o.tri, 0, 0);
  EXPECT_TRUE(closed(t));
  EXPECT_EQ(t.size(), 4u);
  EXPECT_TRUE(cut_by_plane(o.x, o.tri, 2, 10).empty());
  EXPECT_TRUE(cut_by_plane(o.x, o.tri, 2, -10).empty());
}

// A face in the plane counts as above it: the top of a cube has its border, once; the bottom has none.
TEST(PlaneCut, AFaceInThePlaneHasItsBorderOrNothing) {
  const Triangles c = cube();
  const Segments top = cut_by_plane(c.x, c.tri, 2, 10);
  EXPECT_TRUE(closed(top));
  EXPECT_NEAR(length(top), 80, 1e-12);
  EXPECT_TRUE(cut_by_plane(c.x, c.tri, 2, -10).empty());
  const Segments middle = cut_by_plane(c.x, c.tri, 1, 3);
  EXPECT_TRUE(closed(middle));
  EXPECT_NEAR(length(middle), 80, 1e-12);
}

/// Grey in the middle between the picture's centre and a border.
int half_way(const Image& im, int right, int down) {
  return im.at(im.width / 2 + right * im.width / 4, im.height / 2 + down * im.height / 4).g;
}

// Marks on the patient's left, behind and above lie where a radiologist looks for them.
TEST(Slices, LieAsARadiologistSeesThem) {
  const Volume v = sampled(40, 1, [](const Vec3& x) {
    for (int k = 0; k < 3; ++k)
      if ((x - 20 * Vec3::Unit(k)).norm() < 5) return 100 + 300 * k;  // greys of 85, 128, 170
    return -1000;
  });
  const Vec3 high = Vec3::Constant(40);
  const auto draw = [&](SlicePlane plane) {
    const Slice s{plane, 0};
    return draw_slice(v, {}, s, slice_frame(s, -high, high, {}), bare());
  };
  for (const SlicePlane plane : {SlicePlane::axial, SlicePlane::coronal, SlicePlane::sagittal}) {
    const Image im = draw(plane);
    ASSERT_EQ(im.width, 160);
    ASSERT_EQ(im.height, 160);
    const bool axial = plane == SlicePlane::axial, sagittal = plane == SlicePlane::sagittal;
    // Across: left of the patient (sagittal: behind) is on the right. Down: behind, or below.
    EXPECT_EQ(half_way(im, 1, 0), sagittal ? 128 : 85);
    EXPECT_EQ(half_way(im, -1, 0), 0);
    EXPECT_EQ(half_way(im, 0, axial ? 1 : -1), axial ? 128 : 170);
    EXPECT_EQ(half_way(im, 0, axial ? -1 : 1), 0);
  }
}

// The frame's two ways are each other's inverse, and what is off the plane moves no pixel.
TEST(Slices, PlacesAndPixels) {
  const SliceFrame f = slice_frame({SlicePlane::coronal, 7}, {-50, -60, -70}, {50, 60, 90}, {});
  EXPECT_EQ(f.width, 200);
  EXPECT_EQ(f.height, 320);
  EXPECT_EQ(f.place(0, 0), Vec3(-50, 7, 90));
  EXPECT_EQ(f.place(200, 320), Vec3(50, 7, -70));
  EXPECT_EQ(f.pixel(Vec3(-50, 99, 90)), Vec2(0, 0));
  EXPECT_LT((f.pixel(f.place(31.5, 7.25)) - Vec2(31.5, 7.25)).norm(), 1e-12);
  SliceLook coarse;
  coarse.most_pixels = 100;  // the longer side has them, and pixels stay square
  const SliceFrame g = slice_frame({SlicePlane::coronal, 7}, {-50, -60, -70}, {50, 60, 90}, coarse);
  EXPECT_EQ(g.height, 100);
  EXPECT_EQ(g.width, 63);
  EXPECT_DOUBLE_EQ(g.pixel_mm, 1.6);
  EXPECT_THROW(slice_frame({}, Vec3(0, 0, std::nan("")), {1, 1, 1}, {}), InputError);
  coarse.pixel_mm = 0;
  EXPECT_THROW(slice_frame({}, {0, 0, 0}, {1, 1, 1}, coarse), InputError);
}

TEST(Slices, TheWindowAndWhatLiesOutside) {
  const Vec3 low(-20, -20, -20), high(20, 20, 20);
  const auto grey = [&](double value, double offset, double column, double row) {
    const Volume v = sampled(15, 1, [&](const Vec3&) { return value; });
    SliceLook look = bare();
    look.offset = offset;
    const SliceFrame f = slice_frame({}, low, high, look);
    const Image im = draw_slice(v, {}, {}, f, look);
    return int(im.at(int(column), int(row)).g);
  };
  EXPECT_EQ(grey(400, 0, 40, 50), 128);
  EXPECT_EQ(grey(-500, 0, 40, 50), 0);
  EXPECT_EQ(grey(1300, 0, 40, 50), 255);
  EXPECT_EQ(grey(3000, 0, 40, 50), 255);
  EXPECT_EQ(grey(45, 0, 40, 50), std::lround(255 * 545. / 1800));
  EXPECT_EQ(grey(45 + 1024, 1024, 40, 50), std::lround(255 * 545. / 1800));
  EXPECT_EQ(grey(1300, 0, 8, 24), 0);  // (-16, -8) mm is outside
}

// A pixel of many voxels shows their mean, not one of them.
TEST(Slices, SmallVoxelsAreAveraged) {
  const Volume v = sampled(30, 0.5, [](const Vec3& x) { return std::lround(2 * x.x()) % 2 == 0 ? 1300 : -500; });
  SliceLook look = bare();
  look.pixel_mm = 1;
  const SliceFrame f = slice_frame({}, Vec3::Constant(-30), Vec3::Constant(30), look);
  const Image im = draw_slice(v, {}, {}, f, look);
  EXPECT_NEAR(im.at(24, 30).g, 128, 2);  // a voxel's centre is its middle: 0 or 255
}

// The contour covers as much as a line one pixel wide, nowhere less or more: no gap, no bead at a joint.
TEST(Slices, AContourIsOnePixelWide) {
  const Volume air = sampled(30, 2, [](const Vec3&) { return -1000; });
  const double radius = 15;
  const Triangles b = ball(radius, 60, 121);
  const SliceContour c{"", b.x, b.tri, {255, 0, 0}};
  const SliceFrame f = slice_frame({}, Vec3::Constant(-30), Vec3::Constant(30), {});
  const Image im = draw_slice(air, {&c, 1}, {}, f, bare());
  std::vector<double> sector(60, 0.);
  for (int j = 0; j < im.height; ++j)
    for (int i = 0; i < im.width; ++i) {
      const Rgb8 p = im.at(i, j);
      const Vec3 x = f.place(i + 0.5, j + 0.5);
      const double off = std::abs(x.norm() - radius) / f.pixel_mm;
      if (off > 1.05) {
        EXPECT_EQ(p, Rgb8{}) << i << " " << j;
        continue;
      }
      const double turn = elementary::atan2(x.y(), x.x()) / (2 * std::numbers::pi) + 0.5;
      sector[std::min<size_t>(59, size_t(60 * turn))] += p.r / 255.;
    }
  const double each = 2 * std::numbers::pi * radius / f.pixel_mm / 60;
  double sum = 0;
  for (const double s : sector) {
    EXPECT_NEAR(s, each, 0.35 * each);  // a sector has three pixels of length; its ends cut pixels
    sum += s / 60;
  }
  EXPECT_NEAR(sum, each, 0.02 * each);
}

// Names and contours have their colours; a contour that comes later lies above.
TEST(Slices, LaterContoursLieAbove) {
  const Volume air = sampled(30, 2, [](const Vec3&) { return -1000; });
  const Triangles c = cube();
  const SliceContour both[] = {{"", c.x, c.tri, slice_colours::bone}, {"", c.x, c.tri, slice_colours::mandible}};
  const SliceFrame f = slice_frame({}, Vec3(-30.25, -30.25, -30), Vec3(30.25, 30.25, 30), {});
  const Image im = draw_slice(air, both, {}, f, bare());
  EXPECT_EQ(im.at(80, 60), slice_colours::mandible);  // (10, 0) mm is the middle of that pixel
  EXPECT_EQ(im.at(40, 60), slice_colours::mandible);
}

// The bar is 10 mm long, and a name has its contour's colour; both only where words are asked for.
TEST(Slices, WordsAndTheBar) {
  const Volume air = sampled(60, 4, [](const Vec3&) { return -1000; });
  const Triangles b = cube();
  const SliceContour c{"cube", b.x, b.tri, {255, 0, 0}};
  const SliceFrame f = slice_frame({}, Vec3::Constant(-60), Vec3::Constant(60), {});
  const Image im = draw_slice(air, {&c, 1}, {}, f, {}), plain = draw_slice(air, {&c, 1}, {}, f, bare());
  int longest = 0, red = 0;
  for (int j = 200; j < im.height; ++j)
    for (int i = 0, run = 0; i < im.width; ++i) {
      run = im.at(i, j) == Rgb8{255, 255, 255} ? run + 1 : 0;
      longest = std::max(longest, run);
      red += i < 60 && im.at(i, j).r > 200 && im.at(i, j).g == 0;
      EXPECT_EQ(plain.at(i, j), Rgb8{});
    }
  EXPECT_EQ(longest, 20);  // of half a mm
  if (TextPainter().ready()) {
    EXPECT_GT(red, 20);
  }
}

TEST(Slices, TwelveOfAHeadInItsBox) {
  const TemporaryFolder folder;
  const Volume air = sampled(30, 2, [](const Vec3&) { return -1000; });
  const Triangles c = cube();
  std::vector<Vec3> x = c.x;
  x.emplace_back(500, 0, 0);  // no triangle uses it
  const SliceContour one{"cube", x, c.tri, slice_colours::bone};
  const std::vector<ResultPicture> p = draw_head_slices(folder.path(), air, {&one, 1});
  ASSERT_EQ(p.size(), 12u);
  for (const ResultPicture& each : p) {
    const Image im = read_png(folder.path() / each.picture);
    EXPECT_EQ(im.width, 88);  // 20 mm, and 12 at each side
    EXPECT_EQ(im.height, 88);
  }
  EXPECT_EQ(p[0].picture, "slices/axial-1.png");
  EXPECT_EQ(p[0].caption, "Axial, z = 8.3 mm. Seen from the feet: the patient's right is on the left, anterior is up.");
  EXPECT_EQ(p[7].picture, "slices/coronal-2.png");
  EXPECT_EQ(p[7].caption,
            "Coronal, y = 0.0 mm. Seen from the front: the patient's right is on the left, superior is up.");
  EXPECT_EQ(p[9].caption,
            "Sagittal, x = -6.7 mm. Seen from the patient's left: anterior is on the left, superior is up.");
  // Without a contour the volume is shown.
  const std::vector<ResultPicture> all = draw_head_slices(folder.path(), air, {}, {}, {1, 0, 0});
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(read_png(folder.path() / all[0].picture).width, 168);
}

}  // namespace test_slices
}  // namespace limberg
