// A plan in space beside what a hand says of the same acts.
#include <gtest/gtest.h>

#include "app/teaching/against_plan.h"
#include "app/teaching/plan_ground.h"
#include "sim/base/workers.h"
#include "sim/commands/script.h"
#include "sim/patient/world.h"
#include "tests/sim/patient/lip.h"

namespace limberg {
namespace test_plan_ground {

Command line(const std::string& text) { return parse_command(text, "test", 1); }

LessonPlan plan() {
  const std::vector<Command> script{
      line(
          R"({"action":"cut_through","path":[[-6.3,20.5,8],[0.2,8,8],[6.4,20.5,8]],"normals":[[0,0,1],[0,0,1],[0,0,1]],"open_start":true,"open_end":true})"),
      line(R"({"action":"excise","at":[0,19,8]})"),
      line(R"({"action":"suture_row","a":[[-4.4,16,0],[-1.4,10,0]],"b":[[4.9,16,0],[1.8,10,0]],"spacing_mm":3})"),
      line(R"({"action":"suture_row","a":[[-6.9,20.5,8],[-0.6,8.8,8]],"b":[[7,20.5,8],[1,8.8,8]],"spacing_mm":3})")};
  return make_lesson_plan(nullptr, script);
}

double worst_share(const std::optional<Offs>& offs) {
  double worst = 0;
  if (offs)
    for (const Off& o : *offs) worst = std::max(worst, o.share());
  return worst;
}

TEST(PlanGround, WhatTheChartSeesIsSaidOnItAndTheBackIsNot) {
  InlineWorkers workers;
  World world(test::lip(), workers);
  Snapshot uncut;
  world.fill(uncut);
  LessonPlan p = plan();
  ASSERT_EQ(p.acts.size(), 4u);
  say_on_chart(p, uncut);
  EXPECT_TRUE(std::holds_alternative<CutThrough>(p.acts[0].command));
  const auto* piece = std::get_if<ExcisePiece>(&p.acts[1].command);
  ASSERT_NE(piece, nullptr) << to_json_line(p.acts[1].command);
  const ChartPoint at = uncut.topology->to_chart(Vec3(0, 19, 8));
  EXPECT_LT((piece->at - at).norm(), 1e-6);
  EXPECT_TRUE(std::holds_alternative<InSpace>(p.acts[2].command)) << "mucosa";
  EXPECT_TRUE(std::holds_alternative<SutureRow>(p.acts[3].command)) << "skin";
}

TEST(PlanGround, AHandsOwnPostsCountAsTheLineThatWasPlanned) {
  LessonPlan p = plan();
  // More posts, drawn the other way.
  const Command cut = line(
      R"({"action":"cut_through","path":[[6.4,20.5,8],[3.3,14.25,8],[0.2,8,8],[-6.3,20.5,8]],"normals":[[0,0,1],[0,0,1],[0,0,1],[0,0,1]]})");
  ASSERT_TRUE(against(p, p.acts[0], cut));
  EXPECT_LT(worst_share(against(p, p.acts[0], cut)), 0.01);
  const Command beside = line(R"({"action":"cut_through","path":[[6.4,20.5,8],[4,8,8],[-6.3,20.5,8]]})");
  ASSERT_TRUE(against(p, p.acts[0], beside));
  EXPECT_GT(worst_share(against(p, p.acts[0], beside)), 1) << "its point lies 3.8 mm away, 2 are allowed";
  // The two edges of a row in either order.
  const Command row = line(
      R"({"action":"suture_row","a":[[4.9,16,0],[3.3,13,0],[1.8,10,0]],"b":[[-4.4,16,0],[-1.4,10,0]],"spacing_mm":3})");
  ASSERT_TRUE(against(p, p.acts[2], row));
  EXPECT_LT(worst_share(against(p, p.acts[2], row)), 0.1);
  EXPECT_FALSE(against(p, p.acts[2], line(R"({"action":"hook","id":1,"at":[0,16,0]})")));
}

}  // namespace test_plan_ground
}  // namespace limberg
