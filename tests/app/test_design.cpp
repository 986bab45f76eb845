// The search for a design: what is a candidate, what is dropped, how those that are left are ranked and drawn.
#include <gtest/gtest.h>

#include <algorithm>

#include "app/design/design_drawing.h"
#include "app/design/design_search.h"
#include "app/program/shipped.h"
#include "sim/base/error.h"
#include "sim/geometry/polyline.h"
#include "sim/measure/plan.h"
#include "tests/app/report/xml_check.h"

namespace limberg {
namespace test_design {

Scene small_scene() {
  Scene s = load_scene(shipped_file("app/scenes/rhomboid.toml"));
  s.block.size_mm = {110, 110, 10};
  s.block.skin_cell_mm = 2.5;
  s.cell_mm = 6;
  return s;
}

DesignTask task_of(const char* defect, std::vector<std::string> types) {
  DesignTask t;
  t.defect = parse_defect(defect);
  t.types = std::move(types);
  t.turn_step_deg = 90;
  t.coarse_mm = 8, t.fine_mm = 6, t.refine = 1;
  return t;
}

/// By how much a text of the ranking reaches over the right edge of its card, at 0.55 of its size a letter.
double overhang_px(const std::string& svg) {
  constexpr double kCard = 236, kPitch = 248, kFirst = 12, kBelowHead = 58;
  double over = 0;
  for (size_t at = svg.find("<text x=\""); at != std::string::npos; at = svg.find("<text x=\"", at + 1)) {
    const size_t from = svg.find('>', at) + 1, to = svg.find("</text>", from);
    const std::string tag = svg.substr(at, from - at), words = svg.substr(from, to - from);
    const double x = std::stod(tag.substr(9)), y = std::stod(tag.substr(tag.find("y=\"") + 3));
    if (y < kBelowHead) continue;
    size_t letters = 0;
    for (size_t i = 0; i < words.size(); ++i) letters += words[i] == '&' ? i = words.find(';', i), 1 : 1;
    const double wide = 0.55 * (tag.find("font-size=\"14\"") == std::string::npos ? 12 : 14) * double(letters);
    const bool ends_here = tag.find("text-anchor=\"end\"") != std::string::npos;
    const double card = kFirst + kPitch * std::floor((x - kFirst) / kPitch);
    over = std::max({over, ends_here ? card - (x - wide) : x + wide - (card + kCard)});
  }
  return over;
}

TEST(Design, ADefectIsACircleOrAnOutline) {
  const auto circle = parse_defect("circle:3,-4,10");
  for (const ChartPoint& p : circle) EXPECT_NEAR((p - Vec2(3, -4)).norm(), 5, 1e-12);
  EXPECT_EQ(parse_defect("0,0;10,0;10,5").size(), 3u);
  for (const char* bad : {"", "circle:", "circle:1,2", "circle:0,0,-3", "circle:0,0,1e9", "0,0;1,1", "0,0;5,5;10,10",
                          "0,0;1,0;1", "0,0,1,0;1,1", "circle:a,b,c", "0,0;nan,1;2,2"})
    EXPECT_THROW(parse_defect(bad), InputError) << bad;
}

TEST(Design, EveryCandidateHoldsTheDefectAndIsNoLargerThanItMustBe) {
  const Scene scene = small_scene();
  const auto body = build_body(scene);
  const Skin skin(body);
  const DesignTask task = task_of("circle:2,1,12", {});
  const std::vector<Design> all = candidates(scene, skin, task);
  EXPECT_GT(all.size(), covering_types().size());
  for (const Design& d : all) {
    if (!d.dropped.empty()) continue;
    const auto* e = std::get_if<Excise>(&d.commands.at(0));
    ASSERT_NE(e, nullptr) << d.name();
    double nearest = 1e300;
    for (const ChartPoint& p : task.defect) {
      EXPECT_TRUE(inside_polygon(e->outline, p)) << d.name();
      for (size_t i = 0; i < e->outline.size(); ++i) {
        const Vec2 a = e->outline[i], b = e->outline[(i + 1) % e->outline.size()], c = b - a;
        const double t = std::clamp((p - a).dot(c) / c.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (a + t * c - p).norm());
      }
    }
    EXPECT_LT(nearest, 0.35) << d.name();  // sizes go in steps of 0.05 mm; the outline's corners are rounded
  }
}

TEST(Design, WhatTakesALandmarkAwayIsDroppedAndSaysWhy) {
  const Scene scene = small_scene();
  const Skin skin(build_body(scene));
  DesignTask task = task_of("circle:0,0,12", {"fusiform"});
  task.spare = {{"lid", {0, 11}}};  // in the tips of those that stand upright
  int dropped = 0;
  for (const Design& d : candidates(scene, skin, task)) dropped += d.dropped.find("lid") != std::string::npos;
  EXPECT_EQ(dropped, 1);
  task.types = {"nothing"};
  EXPECT_THROW(candidates(scene, skin, task), InputError);
}

// Why the first is first: of what its cost is made, and what the next one costs more by; what was dropped, by reason.
TEST(Design, SaysWhyTheFirstIsFirstAndWhyOthersWereDropped) {
  Design a, b, c, d;
  a.force_N = 1.225, a.force_cost = 0.5, a.dog_ear_mm = 2, a.ear_cost = 0.5, a.cost = 1, a.cell_mm = b.cell_mm = 5;
  b.force_cost = 0.4, b.ear_cost = 0.75, b.landmark_cost = 0.1, b.cost = 1.25;
  c.dropped = d.dropped = "takes lid away";
  Design e;
  e.dropped = "passes within 2 mm of lid";
  const std::string why = why_first(a, &b);
  EXPECT_NE(why.find("1.23 N (cost 0.50)"), std::string::npos) << why;
  EXPECT_NE(why.find("0.25 more, most of it by its dog-ear (+0.25)"), std::string::npos) << why;
  b.fine = true;  // another pass: not compared, though on the same cells
  EXPECT_EQ(why_first(a, &b), why_first(a, nullptr));
  const std::vector<Design> all{a, e, c, b, d};
  const std::vector<std::pair<std::string, int>> expected{{"takes lid away", 2}, {"passes within 2 mm of lid", 1}};
  EXPECT_EQ(dropped_by_reason(all), expected);
}

// A cost on fine cells and one of the first pass say nothing of each other, whichever is the larger.
TEST(Design, RefinedOnesAreRankedAmongThemselvesAndComeFirst) {
  std::vector<Design> all(6);
  const auto is = [&](size_t i, const char* name, bool fine, double first, double cost, const char* dropped = "") {
    all[i].plan.procedure = name, all[i].fine = fine, all[i].first_cost = first, all[i].cost = cost,
    all[i].dropped = dropped;
  };
  is(0, "coarse cheap", false, 0.6, 0.6), is(1, "fine dear", true, 0.3, 0.9),
      is(2, "refused on fine cells", false, 0.2, 0.2, "refused");
  is(3, "coarse", false, 0.8, 0.8), is(4, "fine cheap", true, 0.5, 0.7), is(5, "never", false, 0, 0, "takes lid away");
  rank(all);
  std::vector<std::string> order;
  for (const Design& d : all) order.push_back(d.plan.procedure);
  EXPECT_EQ(order, (std::vector<std::string>{"fine cheap", "fine dear", "coarse cheap", "coarse", "never",
                                             "refused on fine cells"}));
  EXPECT_EQ(why_first(all[1], &all[2]), why_first(all[1], nullptr));  // "costs -0.30 more" would be nonsense
}

TEST(Design, TheSearchRanksTellsHowFarItIsAndDraws) {
  const Scene scene = small_scene();
  DesignTask task = task_of("circle:0,0,10", {"fusiform"});
  InlineWorkers workers;
  std::vector<SearchProgress> told;
  const auto found = search_designs(scene, task, workers, {}, [&](const SearchProgress& p) { told.push_back(p); });
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].cell_mm, 6);  // the best, carried out again
  EXPECT_EQ(found[1].cell_mm, 8);
  EXPECT_TRUE(found[0].fine);
  EXPECT_FALSE(found[1].fine);
  EXPECT_LE(found[0].first_cost, found[1].first_cost);  // the best of the first pass was taken
  EXPECT_NE(found[0].first_cost, found[0].cost);
  EXPECT_EQ(found[1].first_cost, found[1].cost);
  for (const Design& d : found) {
    EXPECT_TRUE(d.dropped.empty()) << d.dropped;
    EXPECT_GT(d.force_N, 0);
    EXPECT_NEAR(d.cost, d.force_N / 2.45 + d.dog_ear_mm / 4 + d.landmark_mm / 2, 1e-12);
  }
  ASSERT_EQ(told.size(), 3u);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end(), [](const auto& a, const auto& b) { return a.share < b.share; }));
  EXPECT_EQ(told[0].share, 0);
  EXPECT_LT(told.back().share, 1);
  EXPECT_TRUE(told.back().fine);
  const std::string picture = ranking_svg(found, task, 0);
  EXPECT_NE(picture.find("1. fusiform"), std::string::npos);
  EXPECT_NE(picture.find("2. fusiform"), std::string::npos);
  EXPECT_TRUE(ranking_svg({}, task, 0).empty());
  // Of the longest names and figures, too, every text ends within its card.
  std::vector<Design> wide(4, found[0]);
  for (Design& d : wide)
    d.plan.procedure = "dufourmentel", d.plan.turn_deg = 322.5, d.plan.mirrored = true, d.fine = false,
    d.force_N = 12.34, d.dog_ear_mm = 12.3, d.landmark_mm = 12.3;
  DesignTask spared = task;
  spared.spare = {{"corner of the left eye", {30, 5}}};
  EXPECT_EQ(overhang_px(ranking_svg(wide, spared, 0)), 0);
  // A landmark has the name that its file gives it.
  DesignTask named = task;
  named.spare = {{"</text><script>\x1b&\xff", {0, 0}}};
  EXPECT_EQ(test::xml_fault(ranking_svg(found, named, 0)), "");
}

}  // namespace test_design
}  // namespace limberg
