// Figures of a head: measures and their file, a skull beside another.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/head/measures.h"
#include "app/head/report.h"
#include "app/head/skull_comparison.h"
#include "sim/commands/script.h"
#include "sim/measure/table.h"
#include "sim/patient/world.h"
#include "sim/skull/head/head.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/generators.h"
#include "tests/sim/skull/head/shell_head.h"

namespace limberg {
namespace test_head_figures {

TEST(HeadMeasures, LengthsAnglesAndAsymmetryBeforeAndNow) {
  NamedPlaces before{{"S", {0, 0, 0}},      {"N", {0, 70, 10}},      {"Ba", {0, -20, -40}},  {"ANS", {0, 80, -35}},
                     {"PNS", {0, 30, -35}}, {"Go_L", {-45, 0, -60}}, {"Go_R", {45, 0, -60}}, {"M2", {0, 0, 3}},
                     {"M10", {4, 0, 3}},    {"M1", {0, 0, 0}},       {"Mx", {9, 9, 9}}};
  NamedPlaces now = before;
  now[6].second += Vec3(3, 4, 0), now[9].second -= Vec3(0, 0, 1);
  const std::vector<HeadMeasure> all = head_measures(before, now);
  const auto at = [&](const std::string& name) {
    for (const HeadMeasure& m : all)
      if (m.name == name) return m;
    ADD_FAILURE() << name;
    return HeadMeasure{};
  };
  EXPECT_NEAR(at("Go").before, 0, 1e-9);
  EXPECT_NEAR(at("Go").now, 5, 1e-9);
  EXPECT_NEAR(at("M1-M2").change(), 1, 1e-12);
  EXPECT_NEAR(at("M2-M10").now, 4, 1e-12);  // by number, not by letters
  EXPECT_NEAR(at("M1-M2-M10").now, 90, 1e-9);
  for (const HeadMeasure& m : all) EXPECT_EQ(m.name.find("Mx"), std::string::npos);
  // The file: a line each, seven fields, numbers as they are.
  std::istringstream in(to_csv(all));
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "group,name,unit,before,now,change,norm");
  size_t lines = 0;
  bool found = false;
  for (; std::getline(in, line); ++lines) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 6) << line;
    found |= line == "picked,\"M1-M2\",mm,3.0000,4.0000,1.0000,";
  }
  EXPECT_EQ(lines, all.size());
  EXPECT_TRUE(found);
}

// A place has the name that its file gives it; a table of values carries no formula to a spreadsheet.
TEST(HeadMeasures, NamesStayTextInTheTable) {
  for (const auto& [name, cell] : {std::pair{"=cmd|' /C calc'!A0", "\"'=cmd|' /C calc'!A0\""},
                                   {"+1", "\"'+1\""},
                                   {"@x", "\"'@x\""},
                                   {"a \"b\", c", "\"a \"\"b\"\", c\""},
                                   {"N-ANS", "\"N-ANS\""}}) {
    const std::string csv = to_csv({{HeadMeasure::Group::picked, name, "mm", 1, 2, ""}});
    EXPECT_NE(csv.find(std::string("picked,") + cell + ",mm,"), std::string::npos) << csv;
  }
  // A number that no place has is no number: "M" and more digits than an int has.
  EXPECT_EQ(picked_number("M99999999999999999999"), 0);
  EXPECT_EQ(picked_number("M12"), 12);
}

TEST(HeadReport, EveryFigureIsInTheTableOfMeasures) {
  InlineWorkers w;
  World patient(test::shell_head(), w);
  Result r("operate", "");
  fill_head(r, *patient.head());
  const nlohmann::json metrics = nlohmann::json::parse(r.text()).at("metrics");
  EXPECT_TRUE(metrics.contains("fragments"));
  for (const auto& [name, value] : metrics.items()) {
    const Measure* m = find_measure(name);
    ASSERT_NE(m, nullptr) << name;
    EXPECT_TRUE(m->of_bones) << name;
    EXPECT_EQ(m->counts, value.is_number_integer()) << name;
  }
}

TEST(HeadReport, TheLineOfAPairPutsItTogether) {
  InlineWorkers w;
  World patient(test::shell_head(), w);
  const Head& h = *patient.head();
  const auto report = [&] {
    Result r("operate", "");
    fill_head(r, h);
    return nlohmann::json::parse(r.text()).at("head");
  };
  EXPECT_FALSE(report().contains("fits"));
  CutBone vault;
  vault.point_mm = {0, 0, 12}, vault.normal = {0.1, 0.25, 1};
  ASSERT_TRUE(patient.apply(HeadCommand(vault)).done);
  MoveFragment away;
  away.fragment.id = 1, away.by.translation_mm = {120, 40, -30}, away.by.rotation_deg = {10, 70, -20};
  ASSERT_TRUE(patient.apply(HeadCommand(away)).done);
  const nlohmann::json fits = report().at("fits");
  ASSERT_EQ(fits.size(), 1u);
  EXPECT_EQ(fits[0].at("stays"), 0);  // it is fixed
  EXPECT_EQ(fits[0].at("moves"), 1);
  ASSERT_TRUE(patient.apply(parse_command(fits[0].at("line").get<std::string>(), "", 1)).done);
  for (const auto& [name, at] : h.landmarks_at_rest())
    for (const auto& [other, now] : h.landmarks_now())
      if (other == name) {
        EXPECT_LT((now - at).norm(), 0.5) << name;  // the bar of noisy rings (sorting_test.cpp)
      }
}

/// A potato: no rotation takes it to itself.
simplex::Mesh potato() {
  simplex::Mesh m = simplex::make_sphere({0, 0, 0}, 40, 3);
  for (Vec3& x : m.x_mm)
    x = Vec3(1.0 * x.x() + 0.004 * x.y() * x.y(), 1.3 * x.y(), 0.8 * x.z() + 0.003 * x.x() * x.y());
  m.before_mm = m.x_mm;
  simplex::record_shape(m);
  return m;
}

TEST(SkullComparison, AKnownPlaceIsFoundAndAMoveIsReadOff) {
  InlineWorkers w;
  HeadParts parts;
  parts.bones.push_back({"potato", potato(), false});
  World patient(std::move(parts), w);
  const Head& head = *patient.head();
  Surface other = bone_surface(head, true);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translate(Vec3(2, -1, 3)).rotate(Eigen::AngleAxisd(0.08, Vec3(1, 2, 3).normalized()));
  for (Vec3& x : other.x_mm) x = T * x;
  const SkullComparison same = compare_with(head, other, "itself elsewhere", false, w);
  ASSERT_TRUE(same) << same.reason;
  for (const Vec3& x : same.at_rest_mm) EXPECT_LT((same.map(x) - T * x).norm(), 0.1);  // issue 7's bar
  EXPECT_LT(same.before.max_mm, 0.1);
  // A piece is cut off and raised: the fit stays, what was raised lies outside by so much.
  CutBone cut;
  cut.point_mm = {0, 0, 18}, cut.normal = Vec3::UnitZ();
  ASSERT_TRUE(patient.apply(HeadCommand(cut)).done);
  MoveFragment m;
  m.fragment = {-1, {0, 0, 32}}, m.by.translation_mm = {0, 0, 3};
  ASSERT_TRUE(patient.apply(HeadCommand(m)).done);
  patient.step({});
  const SkullComparison raised = compare_with(head, other, "itself elsewhere", false, w);
  ASSERT_TRUE(raised) << raised.reason;
  const int32_t id = head.bones().nearest_fragment({0, 0, 32});
  double top = 0, rest = 0, most = 0;
  for (size_t v = 0; v < raised.fragment.size(); ++v) {
    if (raised.fragment[v] == id)
      top = std::max(top, raised.after.signed_mm[v]);
    else
      rest = std::max(rest, std::abs(raised.after.signed_mm[v]));
    most = std::max(most, std::abs(raised.before.signed_mm[v]));
  }
  EXPECT_NEAR(top, 3, 0.15);
  EXPECT_LT(rest, 0.1);
  EXPECT_LT(most, 0.1);
}

double number_after(const std::string& text, const std::string& key, size_t from) {
  const size_t at = text.find(key, from);
  return at == std::string::npos ? NAN : std::stod(text.substr(text.find(':', at) + 1));
}

// Asked for twice by a script: as long as a piece stands out, and when it is back. Off asks for nothing.
TEST(SkullComparison, MomentsThatWereAskedForAreInTheReport) {
  InlineWorkers w;
  HeadParts parts;
  parts.bones.push_back({"potato", potato(), false});
  World patient(std::move(parts), w);
  const Head& head = *patient.head();
  const auto act = [&](const HeadCommand& c) {
    const Outcome o = patient.apply(c);
    ASSERT_TRUE(o.done) << o.reason;
  };
  CutBone cut;
  cut.point_mm = {0, 0, 18}, cut.normal = Vec3::UnitZ();
  MoveFragment up, down;
  up.fragment = down.fragment = {-1, {0, 0, 32}}, up.by.translation_mm = {0, 0, 3}, down.by.translation_mm = {0, 0, -3};
  act(cut), act(up), act(Superpose{SkullBeside::mirror, "raised"});
  EXPECT_EQ(head.beside(), SkullBeside::mirror);
  act(down), act(Superpose{SkullBeside::mirror, ""}), act(Superpose{SkullBeside::off, ""});
  EXPECT_EQ(head.beside(), SkullBeside::off);
  ASSERT_EQ(head.skull_moments().size(), 2u);
  EXPECT_EQ(head.skull_moments()[1].name, "2");
  EXPECT_EQ(head.skull_moments()[0].rest, head.skull_moments()[1].rest);
  // It is no part of undo: what goes is the move before it.
  const std::string dir = ::testing::TempDir();
  Result r("test", "potato");
  EXPECT_TRUE(report_skull(r, head, {}, dir, Snapshot{}, Camera{}, w).empty());
  EXPECT_EQ(r.entries("/skull_moments"), 2);
  EXPECT_EQ(r.entries("/skull"), 0);  // so small a skull is compared only when asked
  EXPECT_EQ(r.entries("/tables"), 1);
  EXPECT_EQ(r.entries("/tables/0/rows"), 6);  // all and two fragments, twice
  const std::string text = r.text();
  const size_t first = text.find("\"raised\"");
  ASSERT_NE(first, std::string::npos);
  const double out = number_after(text, "\"rms_mm\"", first),
               back = number_after(text, "\"rms_mm\"", text.find("\"rms_mm\"", first) + 8);
  EXPECT_GT(out, back + 0.2);
  EXPECT_TRUE(std::filesystem::exists(dir + "/skull-moment-2.csv"));
  ASSERT_TRUE(patient.apply(Undo{}).done);
  const int32_t id = head.bones().nearest_fragment({0, 0, 32});
  EXPECT_NEAR(head.bones().fragment(id)->pose.translation().z(), 3, 1e-9);
}

// A normal skull of one's own, in two files, that lies elsewhere; and one that cannot be read.
TEST(SkullComparison, TheScenesNormalSkullMayLieAnywhereAndInSeveralFiles) {
  InlineWorkers w;
  const simplex::FanTriangles fan = simplex::fan_triangles(potato());
  const Surface skull{fan.X_mm, fan.tri};
  const Mat3 turn = Eigen::AngleAxisd(2.8, Vec3(0.1, 0.3, 1).normalized()).toRotationMatrix();
  const std::string dir = ::testing::TempDir();
  std::vector<std::string> files;
  for (const bool upper : {false, true}) {
    std::ostringstream out;
    for (const Vec3& x : skull.x_mm) {
      const Vec3 y = turn * x + Vec3(300, -40, 7);
      out << "v " << y.x() << ' ' << y.y() << ' ' << y.z() << '\n';
    }
    for (const Tri& t : skull.tri)
      if ((skull.x_mm[size_t(t[0])].z() > 0) == upper)
        out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    files.push_back(dir + "/half" + (upper ? "1" : "0") + ".obj");
    std::ofstream(files.back()) << out.str();
  }
  const SkullFit fit = lay_upon_normal(skull, files, w);
  ASSERT_TRUE(fit.target) << fit.reason;
  EXPECT_EQ(fit.reason, "");
  EXPECT_EQ(fit.with, "the scene's normal skull");
  EXPECT_LT((fit.map.R - turn).norm(), 1e-3);
  EXPECT_LT(distance_map(skull, fit.map, *fit.target, w).max_mm, 0.05);
  // Half of it is another skull.
  EXPECT_GT(distance_map(skull, fit.map, SurfaceTarget(load_surface(files[0])), w).max_mm, 5);
  const std::string bad = dir + "/bad.obj";
  std::ofstream(bad) << "v 0 0 0\nv 1 0\n";
  EXPECT_NE(lay_upon_normal(skull, {bad}, w).reason.find("bad.obj:2"), std::string::npos);
  EXPECT_NE(lay_upon_normal(skull, {dir + "/gone.obj"}, w).reason.find("gone.obj"), std::string::npos);
}

}  // namespace test_head_figures
}  // namespace limberg
