// Slices of the verification suite: what is quick and exact in every build.
#include <gtest/gtest.h>

#include "tests/bench/verification_parts.h"

namespace limberg::bench {
namespace test_verification {

void expect_all(const Result& r) {
  EXPECT_FALSE(r.rows.empty());
  for (const Row& row : r.rows)
    EXPECT_TRUE(row.pass) << row.name << ", " << row.method << ", " << row.settings << ": " << row.error << " "
                          << row.error_unit;
  for (const Bar& b : r.bars) EXPECT_TRUE(b.pass) << b.name << ": " << b.value << ", bar " << b.bar;
}

VerificationSettings quick() { return {true, {}, {}}; }

TEST(Verification, EvenStatesOfEveryLaw) {
  Result r;
  even_states(r, quick());
  EXPECT_GT(r.bars.size(), 12u);
  expect_all(r);
}

// Coarse meshes: the error falls as the theory says, and by how much is known.
TEST(Verification, CooksPanelComesNearer) {
  Result r;
  cook(r, quick());
  expect_all(r);
  for (size_t i = 0; i + 1 < r.rows.size(); i += 2) {
    EXPECT_LT(std::abs(r.rows[i + 1].error), std::abs(r.rows[i].error)) << r.rows[i].name;
    EXPECT_LT(std::abs(r.rows[i + 1].error), 6)
        << r.rows[i].name;  // %; published bilinear elements: 5.8 at 8 x 8, 1.7 at 16 x 16
  }
}

TEST(Verification, ThickSphereAndElasticaAreOfSecondOrder) {
  for (auto part : {thick_sphere, elastica}) {
    Result r;
    part(r, quick());
    expect_all(r);
    ASSERT_EQ(r.rows.size(), 2u);  // the sphere; the bar with cells twice as long as high
    EXPECT_GT(observed_order(r.rows[0].error, r.rows[1].error, 2), 1.5) << r.rows[0].name;
  }
}

TEST(Verification, ManufacturedSolution) {
  Result r;
  manufactured(r, quick());
  expect_all(r);
  for (size_t i = 0; i + 2 < r.rows.size(); i += 4) {  // two sizes, L2 and H1
    EXPECT_GT(observed_order(r.rows[i].error, r.rows[i + 2].error, 2), 1.6) << r.rows[i].method;
    EXPECT_GT(observed_order(r.rows[i + 1].error, r.rows[i + 3].error, 2), 0.75) << r.rows[i].method;
  }
}

TEST(Verification, SkinIsAsThickAsItSays) {
  Result r;
  thickness(r, quick());
  expect_all(r);
  EXPECT_EQ(r.rows.size(), 2u);
}

}  // namespace test_verification
}  // namespace limberg::bench
