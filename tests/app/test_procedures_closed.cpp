// Every procedure of the repertoire, carried out with its own settings on a patch of skin: it closes and comes to rest.
#include <gtest/gtest.h>

#include <ostream>

#include "app/metrics.h"
#include "app/operation.h"
#include "sim/tools/procedures/catalogue.h"
#include "sim/tools/procedures/operation.h"

namespace limberg {

void PrintTo(const Procedure& p, std::ostream* to) { *to << p.name; }  // the test's name for it

namespace {

class Repertoire : public testing::TestWithParam<Procedure> {};

TEST_P(Repertoire, ClosesAndRests) {
  BlockSpec b;
  b.size_mm = {130, 130, 10};
  b.skin_cell_mm = 1.6;
  Material skin, fat;
  skin.young_kPa = 60, fat.young_kPa = 15;
  skin.prestretch_along = skin.prestretch_across = 1.05, fat.prestretch_along = fat.prestretch_across = 1.04;
  b.layers = {{"skin", 1.5, skin}, {"fat", 8.5, fat}};
  WorldSpec spec;
  spec.body = std::make_shared<Body>(make_block(b));
  spec.cell_mm = 5;
  // Two take 10 s each to come to rest with contact (they do, 2026-11-21): too long for a test.
  const bool slow = GetParam().name == "multiple_z" || GetParam().name == "bilobed";
  spec.contact = slow ? ContactChoice::off : ContactChoice::automatic;
  InlineWorkers workers;
  World world(spec, workers);
  const Figure f = GetParam().figure(GetParam().defaults());
  const std::vector<Command> commands = carry_out(f, OnSkin(Skin(spec.body), {}));
  Script script;
  for (const Command& c : commands) script.lines.push_back({int(script.lines.size()) + 1, c});
  const OperationOutcome o = operate(world, 10, script, {});  // throws when anything is refused
  const Metrics m = measure_world(world, commands);
  EXPECT_LE(o.last.residual, 1e-5);
  EXPECT_EQ(m.pieces, 1);
  EXPECT_LT(m.suture_gap_max_mm, 0.2);
  EXPECT_LT(std::abs(m.volume_change), 1e-12);
  EXPECT_LT(m.closure_force_N, 60);  // nobody ties more than 2 N a stitch, 30 stitches at most here
}

INSTANTIATE_TEST_SUITE_P(All, Repertoire, testing::ValuesIn(procedures()), [](const auto& i) { return i.param.name; });

}  // namespace
}  // namespace limberg
