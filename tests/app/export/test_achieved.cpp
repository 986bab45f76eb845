// A maxilla that was planned and lies a little elsewhere in a later scan, in which the head is turned: what is off is
// found again.
#include <gtest/gtest.h>

#include "app/export/achieved.h"
#include "app/export/bone_field.h"
#include "app/export/solids.h"
#include "sim/imaging/synthetic/synthetic_head.h"

namespace limberg {
namespace test_achieved {

struct Case {
  std::vector<PlannedFragment> plan;
  Surface later;
  Eigen::Isometry3d off;  // of the maxilla from its plan, in the head's frame
};

void add(Surface& to, Surface s, const Eigen::Isometry3d& by) {
  move(s, by);
  const auto first = int32_t(to.x_mm.size());
  to.x_mm.insert(to.x_mm.end(), s.x_mm.begin(), s.x_mm.end());
  for (const Tri& t : s.tri) to.tri.push_back({t[0] + first, t[1] + first, t[2] + first});
}

const Case& made() {
  static const Case once = [] {
    InlineWorkers w;
    const HeadModel model = make_head({}, w);
    bone::Bones bones({{"cranium", model.cranium, true}}, w);
    bone::Osteotomy o;
    o.kind = bone::Osteotomy::Kind::fan, o.point_mm = {-90, 40, -30}, o.radius_mm = 180;
    o.ray = {Vec3::UnitY(), Vec3::UnitX(), -Vec3::UnitZ()};
    const bone::ActedOnBone done = bones.cut(o);
    EXPECT_TRUE(done.done) << done.reason;
    Case c;
    c.off = Eigen::Translation3d(0.8, -1.2, 0.5) * Eigen::AngleAxisd(0.03, Vec3(1, 2, 3).normalized());
    Eigen::Isometry3d planned = Eigen::Isometry3d::Identity();
    planned.translation() = Vec3(0, 6, 0);
    const Eigen::Isometry3d scanner =
        Eigen::Translation3d(30, -20, 200) * Eigen::AngleAxisd(0.2, Vec3(-1, 1, 0.5).normalized());
    for (const bone::Fragment& f : bones.fragments()) {
      Surface s = fragment_surface(bones, f);
      PlannedFragment p{f.name, s, f.fixed, {}};
      if (!f.fixed) move(p.surface, planned), p.planned_mm = {0, 6, 0};
      add(c.later, p.surface, f.fixed ? scanner : Eigen::Isometry3d(scanner * c.off));
      c.plan.push_back(std::move(p));
    }
    return c;
  }();
  return once;
}

TEST(Achieved, TellsHowFarAFragmentLiesFromItsPlan) {
  InlineWorkers w;
  const Case& c = made();
  const Achieved a = planned_against_achieved(c.plan, c.later, 0.5, w);
  ASSERT_EQ(a.reason, "");
  ASSERT_EQ(a.fragments.size(), 1u);
  ASSERT_EQ(a.fragments[0].reason, "");
  Vec3 middle = Vec3::Zero();
  const Surface& s = c.plan[1].surface;
  for (const Vec3& x : s.x_mm) middle += x / double(s.x_mm.size());
  // The same surfaces: ICP comes to rest within a hundredth (superposition.h: still_mm).
  EXPECT_LT((a.fragments[0].off_mm - (c.off * middle - middle)).norm(), 0.05) << a.fragments[0].off_mm.transpose();
  EXPECT_NEAR(a.fragments[0].off_deg, 0.03 * 180 / M_PI, 0.05);
  EXPECT_LT(a.skull_rms_mm, 0.05);
}

TEST(Achieved, APlanWithoutABoneThatStaysIsRefused) {
  InlineWorkers w;
  Case c = made();
  for (PlannedFragment& f : c.plan) f.fixed = false, f.planned_mm = {0, 6, 0};
  EXPECT_NE(planned_against_achieved(c.plan, c.later, 0.5, w).reason.find("nothing says where the head lies"),
            std::string::npos);
}

}  // namespace test_achieved
}  // namespace limberg
