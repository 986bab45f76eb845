// Surfaces for printers: whether they are closed, what is in them, and their bytes.
#include <gtest/gtest.h>

#include <cstring>

#include "app/export/moment.h"
#include "app/export/solids.h"

namespace limberg {
namespace test_solids {

/// A box from a to b, outwards.
Surface box(const Vec3& a, const Vec3& b) {
  Surface s;
  for (int i = 0; i < 8; ++i) s.x_mm.emplace_back(i & 1 ? b.x() : a.x(), i & 2 ? b.y() : a.y(), i & 4 ? b.z() : a.z());
  s.tri = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
           {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return s;
}

TEST(Solids, ABoxIsClosedAndHasItsVolume) {
  Surface s = box({1, 2, 3}, {3, 5, 7});
  EXPECT_TRUE(solid_figures(s).closed());
  EXPECT_NEAR(solid_figures(s).volume_mm3, 24, 1e-9);
  s.tri.pop_back();
  EXPECT_EQ(solid_figures(s).open_edges, 3);
  s.tri.push_back({3, 5, 7});  // the wrong way round
  EXPECT_GT(solid_figures(s).open_edges, 0);
}

TEST(Solids, PartsAreTheLargestFirstWithoutHollows) {
  Surface s = box({0, 0, 0}, {10, 10, 10});
  for (const auto& [a, b] : {std::pair(Vec3(20, 0, 0), Vec3(40, 20, 20)), {Vec3(50, 0, 0), Vec3(51, 1, 1)}}) {
    const Surface more = box(a, b);
    const auto first = int32_t(s.x_mm.size());
    s.x_mm.insert(s.x_mm.end(), more.x_mm.begin(), more.x_mm.end());
    for (const Tri& t : more.tri) s.tri.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  const Surface hollow = box({2, 2, 2}, {8, 8, 8});
  const auto first = int32_t(s.x_mm.size());
  s.x_mm.insert(s.x_mm.end(), hollow.x_mm.begin(), hollow.x_mm.end());
  for (const Tri& t : hollow.tri) s.tri.push_back({t[0] + first, t[2] + first, t[1] + first});
  const std::vector<Surface> parts = parts_of(s, 10);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_NEAR(solid_figures(parts[0]).volume_mm3, 8000, 1e-6);
  EXPECT_NEAR(solid_figures(parts[1]).volume_mm3, 1000, 1e-6);
  EXPECT_EQ(parts[1].x_mm.size(), 8u);
}

TEST(Solids, BytesHoldWhatIsThere) {
  const Surface s = box({0, 0, 0}, {1, 2, 3});
  const std::string stl = stl_bytes(s, "solid as a rock\nin two lines");
  ASSERT_EQ(stl.size(), 84u + 12 * 50);
  EXPECT_FALSE(stl.starts_with("solid"));
  float corner[3];
  std::memcpy(corner, stl.data() + 84 + 50 * 3 + 12 + 12, 12);  // triangle 3, corner 1
  EXPECT_EQ(Vec3(double(corner[0]), double(corner[1]), double(corner[2])), s.x_mm[7]);
  const std::string ply = ply_bytes(s, "box");
  EXPECT_NE(ply.find("element vertex 8\n"), std::string::npos);
  EXPECT_EQ(ply.size(), ply.find("end_header\n") + 11 + 8 * 12 + 12 * 13);
}

TEST(Solids, FilesHavePlainNames) {
  EXPECT_EQ(file_name_of("cranium piece 3"), "cranium-piece-3");
  EXPECT_EQ(file_name_of("../etc/passwd"), "etc-passwd");
  EXPECT_EQ(file_name_of("  "), "part");
}

}  // namespace test_solids
}  // namespace limberg
