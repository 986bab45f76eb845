// Acts on skull and face as script lines: round trip, refusals with line and reason.
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/commands/script.h"

namespace limberg {
namespace test_script_head {

std::string why(const std::string& line) {
  try {
    parse_command(line, "s.jsonl", 7);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(ScriptHead, EveryActSurvivesTheRoundTrip) {
  CutBone contour, plane;
  contour.contour_mm = {{1, 2, 3}, {4.25, 5, 6}, {7, 8, 9.125}}, contour.must_divide = false;
  plane.point_mm = {0, 80, -70}, plane.normal = {0, 0.5, 1}, plane.radius_mm = 25,
  plane.of = FragmentPick{2, Vec3::Zero()};
  CutBoneByBlade step;
  step.corner_mm = {-90, 45.5, -30}, step.rays = {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}}, step.reach_mm = 120,
  step.of = FragmentPick{-1, Vec3(0, 90, 25)}, step.must_divide = false;
  RigidMove by;
  by.translation_mm = {0, 8, 0}, by.rotation_deg = {0, 0, 12.5}, by.about_mm = Vec3(1, 2, 3);
  ConnectTissue tissue;
  tissue.name = "chin", tissue.face_mm = {0, 90, -80}, tissue.bone_mm = {0, 80, -80}, tissue.layers = 3,
  tissue.young_kPa = 7.5, tissue.mode = TissueKind::springs;
  ConnectTissue drawn = tissue;
  drawn.face_outline_mm = {{-20, 90, -60}, {20, 90, -60.5}, {0, 84, -90}};
  drawn.face_mm = middle_of(drawn.face_outline_mm);
  const std::vector<HeadCommand> acts{contour,
                                      plane,
                                      step,
                                      MoveFragment{{-1, {1, 2, 3}}, by, 3},
                                      GrabFragment{{4, Vec3::Zero()}, 1},
                                      DragFragment{by, 0, 1},
                                      LetGo{true, 0},
                                      PlateFragments{{1, 2, 3}, {4, 5, 6}},
                                      JoinFragments{{0, Vec3::Zero()}, {-1, {9, 8, 7}}, 8},
                                      tissue,
                                      drawn,
                                      Unplate{{2, Vec3::Zero()}},
                                      SortFragments{},
                                      SplitFace{{0, 84, 60.5}},
                                      MergeFaces{{0, 84, 60.5}},
                                      SmoothSurface{{0, 84, 60.5}, 12.5},
                                      PushSurface{{0, 96, 60}, {0, 88, 60}, 7.5, FragmentPick{3, Vec3::Zero()}},
                                      PlaceLandmark{"Pog'", {0, 95, -80}, true},
                                      Superpose{SkullBeside::mirror, "advanced"},
                                      Superpose{SkullBeside::off, ""}};
  for (const HeadCommand& act : acts) {
    const std::string line = to_json_line(Command(act));
    const Command read = parse_command(line, "s", 1);
    EXPECT_EQ(to_json_line(read), line);
    ASSERT_TRUE(std::holds_alternative<HeadCommand>(read)) << line;
    EXPECT_EQ(std::get<HeadCommand>(read).index(), act.index());
    EXPECT_STREQ(action_name(read), action_name(Command(act)));
  }
}

TEST(ScriptHead, ADrawnRegionHasItsMiddle) {
  const Command c =
      parse_command(R"({"action":"connect_tissue","name":"a","face_outline":[[0,90,0],[6,90,0],[0,96,3]]})", "s", 1);
  const auto& t = std::get<ConnectTissue>(std::get<HeadCommand>(c));
  EXPECT_EQ(t.face_outline_mm.size(), 3u);
  EXPECT_EQ(t.face_mm, Vec3(2, 92, 1));
  EXPECT_EQ(t.bone_mm, Vec3(2, 92, 1));
  EXPECT_NE(why(R"({"action":"connect_tissue","name":"a","face_outline":[[0,90,0],[6,90,0]]})").find("expected 3"),
            std::string::npos);
  EXPECT_NE(why(R"({"action":"connect_tissue","name":"a","face":[0,1,2],"face_outline":[[0,90,0],[6,90,0],[0,96,3]]})")
                .find("\"face\""),
            std::string::npos);
}

TEST(ScriptHead, BadLinesSayLineAndReason) {
  EXPECT_NE(why(R"({"action":"superpose","on":"moon"})").find("expected off, normal or mirror"), std::string::npos);
  EXPECT_NE(why(R"({"action":"unplate"})").find("\"fragment\" is missing"), std::string::npos);
  EXPECT_NE(why(R"({"action":"sort","fragment":1})").find("unknown key \"fragment\""), std::string::npos);
  EXPECT_NE(why(R"({"action":"superpose"})").find("\"on\""), std::string::npos);
  EXPECT_NE(why(R"({"action":"superpose","on":"normal","at":[0,0,0]})").find("\"at\""), std::string::npos);
  EXPECT_NE(why(R"({"action":"osteotomy","contour":[[1,2,3],[4,5,6]]})")
                .find("s.jsonl:7: \"contour\" has 2 points; expected 3"),
            std::string::npos);
  EXPECT_NE(why(R"({"action":"osteotomy","contour":[[1,2],[4,5],[6,7]]})").find("expected [x, y, z]"),
            std::string::npos);
  EXPECT_NE(why(R"({"action":"osteotomy","point":[0,0,0],"normal":[0,0,0]})").find("no length"), std::string::npos);
  EXPECT_NE(why(R"({"action":"osteotomy","contour":[[1,2,3],[4,5,6],[7,8,9]],"normal":[0,0,1]})")
                .find("unknown key \"normal\""),
            std::string::npos);
  EXPECT_NE(why(R"({"action":"osteotomy","corner":[0,0,0],"rays":[[0,1,0]]})")
                .find("s.jsonl:7: \"rays\" has 1 points; expected 2"),
            std::string::npos);
  std::string nine;
  for (int i = 0; i < 9; ++i) nine += (i > 0 ? ",[" : "[") + std::to_string(i) + ",1,0]";
  EXPECT_NE(why(R"({"action":"osteotomy","corner":[0,0,0],"rays":[)" + nine + "]}")
                .find("s.jsonl:7: \"rays\" holds 9 directions; expected two to 8"),
            std::string::npos);
  EXPECT_NE(why(R"({"action":"push_surface","from":[0,96,60],"to":[0,88,60],"radius_mm":0})").find("radius_mm"),
            std::string::npos);
  EXPECT_NE(why(R"({"action":"split_face"})").find("\"at\" is missing"), std::string::npos);
  EXPECT_NE(why(R"({"action":"osteotomy","rays":[[0,1,0],[1,0,0]]})").find("\"corner\" is missing"), std::string::npos);
  EXPECT_NE(why(R"({"action":"osteotomy","corner":[0,0,0],"rays":[[0,1,0],[1,0,0]],"radius_mm":3})")
                .find("unknown key \"radius_mm\""),
            std::string::npos);
  EXPECT_NE(why(R"({"action":"move_fragment","translation_mm":[0,8,0]})").find("\"fragment\" is missing"),
            std::string::npos);
  EXPECT_NE(why(R"({"action":"move_fragment","fragment":-3})").find("expected an integer from 0"), std::string::npos);
  EXPECT_NE(why(R"({"action":"move_fragment","fragment":1,"rotation_deg":[0,400,0]})").find("more than 360"),
            std::string::npos);
  EXPECT_NE(why(R"({"action":"connect_tissue","name":"a","face":[0,0,0],"mode":"jelly"})").find("expected smoothing"),
            std::string::npos);
  EXPECT_NE(
      why(R"({"action":"connect_tissue","name":"a","face":[0,0,0],"layers":0})").find("expected an integer from 1"),
      std::string::npos);
  EXPECT_NE(why(R"({"action":"landmark","name":"N","at":[0,0,0],"on":"moon"})").find("expected bone or face"),
            std::string::npos);
  EXPECT_NE(why(R"({"action":"grab","fragment":1,"hand":3})").find("from 0 to 2"), std::string::npos);
}

TEST(ScriptHead, AMoveTurnsAboutItsPlaceAndShifts) {
  RigidMove m;
  m.translation_mm = {1, 2, 3}, m.rotation_deg = {0, 0, 90};
  const Eigen::Isometry3d about_centre = isometry(m, {10, 0, 0});
  EXPECT_LT((about_centre * Vec3(10, 0, 0) - Vec3(11, 2, 3)).norm(), 1e-12);
  EXPECT_LT((about_centre * Vec3(11, 0, 0) - Vec3(11, 3, 3)).norm(), 1e-12);
  m.about_mm = Vec3::Zero();
  EXPECT_LT((isometry(m, {10, 0, 0}) * Vec3(1, 0, 0) - Vec3(1, 3, 3)).norm(), 1e-12);
  // There and back.
  const Eigen::Isometry3d map = isometry(m, Vec3::Zero());
  EXPECT_LT((isometry(as_move(map), {5, 5, 5}).matrix() - map.matrix()).norm(), 1e-12);
}

}  // namespace test_script_head
}  // namespace limberg
