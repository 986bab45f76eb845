// What an operate has left of itself: scene, cells, seed and script come back as they were.
#include <gtest/gtest.h>

#include "app/export/operated.h"
#include "sim/base/error.h"

namespace limberg {
namespace test_operated {

TEST(Operated, SeedAndCellsOfAReproComeBack) {
  const std::string head = R"({"command":"operate","scene_path":"/s.toml",)",
                    tail = R"("script":["{\"action\":\"stage\",\"name\":\"before\"}"]})";
  const OperatedCall own = operated_call(head + R"("lattice":{"cell_mm":2.5,"seed":77},)" + tail, "r.json");
  ASSERT_TRUE(own.seed.has_value());
  EXPECT_EQ(*own.seed, 77u);
  EXPECT_EQ(own.cell_mm, 2.5);
  EXPECT_EQ(own.script.lines.size(), 1u);
  EXPECT_FALSE(operated_call(head + R"("lattice":{"cell_mm":2.5},)" + tail, "r.json").seed.has_value());
  EXPECT_FALSE(operated_call(head + tail, "r.json").seed.has_value());  // of a head, or an older program
  EXPECT_FALSE(operated_call(head + R"("lattice":{"seed":-3},)" + tail, "r.json").seed.has_value());
  EXPECT_THROW(operated_call(R"({"command":"run"})", "r.json"), InputError);
}

}  // namespace test_operated
}  // namespace limberg
