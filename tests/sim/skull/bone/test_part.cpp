// The part that holds bones is there where it was built, and a build without it says so.
#include <gtest/gtest.h>

#include "sim/skull/bone/bones.h"
#include "sim/skull/bone/rigid_world.h"
#include "tests/sim/skull/bone/heads.h"

namespace limberg::bone {
namespace test_part {

TEST(BulletPart, IsThereWhereItWasBuiltAndElseItsLackIsSaid) {
  const std::string why = why_no_physics();
  test::KeptBones b = test::simple_head();
  ASSERT_TRUE(b.cut(test::window()).done);
  const uint64_t before = b.hash();
  const Outcome o = b.grab(2);
#if LIMBERG_WITH_BULLET
  EXPECT_EQ(why, "");
  EXPECT_TRUE(o.done) << o.reason;
#else
  EXPECT_NE(why.find("bone cannot be held without Bullet: limberg-bullet.so is not beside the program"),
            std::string::npos)
      << why;
  EXPECT_NE(why.find("expected"), std::string::npos) << why;
  EXPECT_FALSE(o.done);
  EXPECT_EQ(o.reason, why);
  EXPECT_FALSE(b.physics());
#endif
  EXPECT_EQ(b.hash(), before);
}

}  // namespace test_part
}  // namespace limberg::bone
