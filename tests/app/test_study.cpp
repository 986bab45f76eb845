// Studies: their settings, and what must come out of small members.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/study/study.h"
#include "sim/base/error.h"

namespace limberg::study {
namespace test_study {

TEST(Study, MembersAreAllCombinationsInOrder) {
  const Family& f = find_family("gape");
  EXPECT_EQ(members(f, {}).size(), 9u);
  const auto m = members(f, {"prestretch_percent=5,10", "angle_deg=90,45,70"});
  ASSERT_EQ(m.size(), 6u);
  EXPECT_EQ(m[0][0], 90);
  EXPECT_EQ(m[0][1], 5);
  EXPECT_EQ(m[1][1], 10);
  EXPECT_EQ(m[5][0], 70);
  EXPECT_EQ(members(f, {"prestretch=5,10", "angle=90,45,70"}), m);  // units may be left off
}

TEST(Study, BadSettingsAreRefused) {
  EXPECT_THROW(find_family("nothing"), InputError);
  const Family& f = find_family("disc");
  for (const char* bad : {"", "=", "along", "along=", "along=1.1,", "along=x", "along=1.1 ,1.2", "along=nan",
                          "along=inf", "along=0.5", "along=9", "foo=1", "along=1e999", "\n=1"})
    EXPECT_THROW(members(f, {bad}), InputError) << bad;
  EXPECT_THROW(members(f, {"along=1.1", "along=1.2"}), InputError);
  std::string many = "along=1.1", more = "across=1.1";
  for (int i = 0; i < 200; ++i) many += ",1.1", more += ",1.1";
  EXPECT_THROW(members(f, {many, more}), InputError);
}

Row run(const std::string& family, const std::vector<std::string>& settings) {
  InlineWorkers workers;
  const Family& f = find_family(family);
  const auto all = members(f, settings);
  EXPECT_EQ(all.size(), 1u);
  return f.run(all.at(0), {workers, {}});
}

TEST(Study, AFreedDiscTakesTheAreaThatItHadBeforeItWasStretched) {
  // The law of the material, at a ratio where it differs from constant volume by much more than the tolerance.
  const Row r = run("disc", {"along=1.15", "across=1.05", "cell_mm=4", "radius_mm=8", "poisson=0.4"});
  EXPECT_EQ(r.at("pieces"), 2);
  EXPECT_LT(r.at("error_of_law"), 2e-3);
  EXPECT_GT(r.at("error"), 0.03);
  EXPECT_GT(r.at("hole_growth"), 0.02);
  EXPECT_GT(r.at("hole_along_over_across"), 1);
}

TEST(Study, AnUprightCutOpensEvenlyAndALeaningOneDoesNot) {
  const std::vector<std::string> small{"length_mm=20", "cell_mm=3.5", "prestretch_percent=10"};
  auto with = [&](const char* angle) {
    auto s = small;
    s.push_back(angle);
    return run("gape", s);
  };
  const Row upright = with("angle_deg=90"), left = with("angle_deg=50"), right = with("angle_deg=130");
  EXPECT_GT(upright.at("gape_mid_mm"), 0.5);
  EXPECT_LT(upright.at("asymmetry"), 0.01);  // the bar of the study
  EXPECT_GT(left.at("asymmetry"), 0.05);
  // The mirror image of a leaning cut leans the other way: what one bank did the other does.
  EXPECT_NEAR(left.at("left_mm"), right.at("right_mm"), 0.02 * left.at("gape_mid_mm"));
  EXPECT_NEAR(left.at("right_mm"), right.at("left_mm"), 0.02 * left.at("gape_mid_mm"));
  EXPECT_NEAR(left.at("step_mm"), -right.at("step_mm"), 0.02 * left.at("gape_mid_mm"));
}

// Kinds of stitches: 0 single, 2 buried, 3 both.
TEST(Study, EdgesGapeBetweenStitchesByTheirSpacingAndKind) {
  auto gape = [](const char* kind, const char* spacing) {
    return run("stitches", {kind, spacing, "prestretch_percent=10", "cell_mm=5", "halvings=3"}).at("gape_mean_mm");
  };
  const double at4 = gape("kind=0", "spacing_mm=4"), at6 = gape("kind=0", "spacing_mm=6");
  EXPECT_GT(at4, 0.01);
  EXPECT_GT(at6, 2 * at4);  // 3.2 times on 2026-11-27; bites of 2 mm hold all of 4
  const double buried = gape("kind=2", "spacing_mm=4"), both = gape("kind=3", "spacing_mm=4");
  EXPECT_GT(buried, at4);  // the skin above a buried stitch is not held
  EXPECT_LT(both, at4);    // two rows, each with half of the tension
}

// The study's own bar: what two cells say of an endless row of cracks in a membrane, against the closed form.
TEST(Study, AMembraneClosedByStitchesIsARowOfCracks) {
  const Family& f = find_family("stitches");
  std::vector<Row> rows;
  for (const char* halvings : {"halvings=1", "halvings=2"})
    rows.push_back(run("stitches", {"kind=0", "spacing_mm=20", "prestretch_percent=0.2", "cell_mm=5", "bite_mm=5",
                                    "membrane=1", halvings}));
  int judged = 0;
  for (const Bar& b : f.bars(rows)) {
    EXPECT_TRUE(b.pass) << b.name << ": " << b.value;
    judged += b.name.find("row of cracks") != std::string::npos;
  }
  EXPECT_EQ(judged, 1);
  EXPECT_LT(rows[0].at("gape_at_stitch_mm"), 0.1 * rows[0].at("gape_between_mm"));
}

// A wider Z-plasty gains more, stands up more and at the ends of its central limb; bars and charts take any rows.
TEST(Study, AWiderZPlastyGainsMoreAndStandsUpMore) {
  const Family& f = find_family("zplasty");
  const std::vector<std::string> small{"cell_mm=6", "prestretch=0", "push_mm=0", "contact=0", "spacing_mm=4"};
  const auto with = [&](const char* angle) {
    auto s = small;
    s.push_back(angle);
    return run("zplasty", s);
  };
  const std::vector<Row> rows{with("angle=30"), with("angle=90")};
  EXPECT_GT(rows[1].at("elongation"), rows[0].at("elongation") + 0.05);
  EXPECT_LT(rows[1].at("elongation"), rows[1].at("theory"));
  EXPECT_GT(rows[1].at("ear_mm"), rows[0].at("ear_mm"));
  EXPECT_GT(rows[1].at("ear_mm"), rows[1].at("at_C_D_mm"));
  EXPECT_FALSE(f.bars(rows).empty());
  for (const NamedChart& c : f.charts(rows)) {
    ASSERT_GE(c.chart.series.size(), 1u);
    EXPECT_EQ(c.chart.series[0].x, (std::vector<double>{30, 90}));
  }
}

// The protocol asks for one efficiency index that peaks inside 50 to 75 degrees, whichever; where one is greatest is
// found between the angles that were tried.
TEST(Study, OneEfficiencyIndexMustPeakInsideTheRange) {
  const auto settings_without = [](double work,
                                   double ear) {  // where these two peak; that for the strain rises to the end
    std::vector<Row> rows;
    for (const double t : {30., 45., 60., 75., 90.}) {
      Row r;
      r.figures = {{"angle", t},
                   {"prestretch", 10},
                   {"cell_mm", 5},
                   {"gain_per_root_work", 9 - 1e-3 * (t - work) * (t - work)},
                   {"efficiency", t},
                   {"elongation", 2},
                   {"ear_mm", 1 / (9 - 1e-3 * (t - ear) * (t - ear))}};
      rows.push_back(r);
    }
    for (const Bar& b : find_family("zplasty").bars(rows)) {
      if (b.name.find("members of the protocol") != std::string::npos) {
        EXPECT_EQ(b.value, 25);
      }  // of 5 x 3 x 2
      if (b.name.find("no member tells") != std::string::npos) {
        EXPECT_EQ(b.value, 5 * 13);
      }  // all but elongation and height
      if (b.name.find("none of the three efficiency indices") != std::string::npos) return b.value;
    }
    return -1.0;
  };
  EXPECT_EQ(settings_without(56, 62), 0);
  EXPECT_EQ(settings_without(80, 62), 0);
  EXPECT_EQ(settings_without(56, 40), 0);
  EXPECT_EQ(settings_without(48, 80), 1);
  EXPECT_EQ(settings_without(76, 49), 1);  // of those tried 75 and 45 would be greatest
  EXPECT_EQ(settings_without(74, 49), 0);
}

// A Z-plasty as the protocol wants it passes each of its bars; what breaks one clause misses that clause's bars alone.
TEST(Study, TheProtocolsBarsAskWhatItAsks) {
  std::vector<Row> good;
  for (const double cell : {2.5, 3.5})
    for (const double p : {0., 5., 10.})
      for (const double t : {30., 45., 60., 75., 90.}) {
        Row r;
        // Of the plate of the protocol's own table; 30 degrees at 10 % is not in it.
        const double i = (t - 30) / 15, slack[] = {1.101, 1.174, 1.256, 1.324, 1.356},
                     slight[] = {1.134, 1.259, 1.396, 1.513, 1.594}, taut[] = {1.135, 1.272, 1.412, 1.563, 1.681};
        const double up[] = {3.8, 6.8, 9.2, 11, 12}, up_slight[] = {.3, .4, 2.6, 5.3, 7.5},
                     up_taut[] = {.2, .3, .4, 2.1, 4.4};
        const double gain = (p == 0   ? slack
                             : p == 5 ? slight
                                      : taut)[int(i)],
                     ear = (p == 0   ? up
                            : p == 5 ? up_slight
                                     : up_taut)[int(i)];
        r.figures = {{"angle", t},
                     {"prestretch", p},
                     {"cell_mm", cell},
                     {"elongation", gain},
                     {"ear_mm", ear},
                     {"at_C_D_mm", 0.04},
                     {"theory", std::sqrt(5 - 4 * std::cos(t * std::numbers::pi / 180))},
                     {"gain_per_root_work", 9 - 1e-3 * (t - 60) * (t - 60)},
                     {"efficiency", t},
                     {"residual", 1e-5},
                     {"gap_max_mm", 0.01},
                     {"side_limbs", 10},
                     {"undermined_least_limbs", 1.5},
                     {"undermined_most_limbs", 1.9},
                     {"charge_off_deg", 0.1}};
        for (const char* other : {"ear_limbs", "elongation_flat", "elongation_4L", "strain_p95", "strain_p99",
                                  "closure_force_N", "suture_force_max_N", "closing_uJ", "ear_volume_mm3", "rms_mm",
                                  "curvature_A_deg", "curvature_B_deg", "slack_share"})
          r.figures.push_back({other, 1});
        good.push_back(std::move(r));
      }
  const auto missed = [](const std::vector<Row>& rows) {
    std::string clauses;
    for (const Bar& b : find_family("zplasty").bars(rows))
      if (!b.pass && b.name[0] != ' ') clauses += b.name.substr(0, b.name.find(' ')) + " ";
    return clauses;
  };
  EXPECT_EQ(missed(good), "");
  const auto with = [&](double angle, double prestretch, const char* figure, double value) {
    std::vector<Row> rows = good;
    for (Row& r : rows)
      if (r.at("angle") == angle && r.at("prestretch") == prestretch && r.at("cell_mm") == 3.5)
        for (auto& [name, v] : r.figures)
          if (name == figure) v = value;
    return missed(rows);
  };
  EXPECT_EQ(with(60, 5, "gap_max_mm", 0.21), "2 ");
  EXPECT_EQ(with(60, 5, "residual", 1.1e-4), "2 ");
  EXPECT_EQ(with(60, 5, "charge_off_deg", 1), "2 ");
  EXPECT_EQ(with(60, 5, "curvature_A_deg", std::nan("")), "3 ");
  EXPECT_EQ(with(75, 5, "elongation", 1.395), "4a 4f ");  // less than at 60, and 8 % below the plate
  EXPECT_EQ(with(90, 0, "elongation", 1.39), "4e ");      // .066 of .082
  EXPECT_EQ(with(60, 0, "ear_mm", 6.7), "4c 4f 4f ");     // below 45, and 27 % below the plate
  EXPECT_EQ(with(75, 5, "at_C_D_mm", 5.4), "4c ");
  EXPECT_EQ(with(45, 10, "ear_mm", 0.51), "4c 4f 4f ");  // not flat, above 60
  EXPECT_EQ(with(90, 10, "ear_mm", 3.2), "4f ");         // above 2 mm, 27 % below the plate
  EXPECT_EQ(with(30, 10, "ear_mm", 0.35), "4c ");        // by .05 mm: rises is rises
}

// The control without height: a clamped surrounding lets a Z-plasty gain about half
// of what its figure promises. The table of a membrane of triangles has 1.254 at 45
// degrees; cells of 4 mm are too coarse for 3 %, and come nearer as they shrink.
TEST(Study, APlanarZPlastyGainsHalfOfTheTheory) {
  const Row coarse = run("planar", {"angle=45", "prestretch=0", "cell_mm=6"}),
            fine = run("planar", {"angle=45", "prestretch=0", "cell_mm=4"});
  EXPECT_NEAR(fine.at("elongation"), 1.254, 0.05);
  EXPECT_LT(std::abs(fine.at("elongation") - 1.254), std::abs(coarse.at("elongation") - 1.254));
  EXPECT_LT(fine.at("rms_mm"), 1e-3);
  EXPECT_LT(fine.at("gap_max_mm"), 0.3);
}

TEST(Study, FusiformFiguresAgreeWithTheClosedForms) {
  const Row r = run("fusiform", {"ratio=3", "cell_mm=6", "width_mm=14", "push_mm=0", "contact=0", "spacing_mm=6"});
  EXPECT_NEAR(r.at("vertex_form_deg"), 73.7, 0.05);  // tabulated
  EXPECT_NEAR(r.at("scar_mm"), 1.073 * 42, 0.05);    // tabulated
  EXPECT_LT(r.at("gap_max_mm"), 0.2);
  // What it takes to close a wound does not depend on how many stitches
  // share it, as long as none pulls against its neighbours: 3 % apart at
  // 4 and 5 mm in cells of 4 mm, 15 % in these coarse ones (2026-11-22).
  const Row wider = run("fusiform", {"ratio=3", "cell_mm=6", "width_mm=14", "push_mm=0", "contact=0", "spacing_mm=9"});
  EXPECT_NEAR(wider.at("closure_force_N"), r.at("closure_force_N"), 0.2 * r.at("closure_force_N"));
  // The bar sees stitches nearer than cells are large.
  const Row nearer = run("fusiform", {"ratio=3", "cell_mm=6", "width_mm=14", "push_mm=0", "contact=0", "spacing_mm=3"});
  EXPECT_GT(nearer.at("closure_force_N"), 1.25 * r.at("closure_force_N"));
  for (const Row* row : {&r, &nearer}) {
    const std::vector<Bar> bars = find_family("fusiform").bars({*row});
    const auto bar =
        std::find_if(bars.begin(), bars.end(), [](const Bar& b) { return b.name.starts_with("stitches' spacing"); });
    ASSERT_NE(bar, bars.end());
    EXPECT_EQ(bar->pass, row == &r);
  }
}

// What rhomboid flaps are known for: the cut has the angles of the plan, and the donor's closure is pulled tight,
// across it. (That it is the tightest place of all takes finer cells than these.)
TEST(Study, ARhomboidFlapHasTheChargesOfItsPlan) {
  const Row r = run("rhomboid", {"flap_angle=60", "cell_mm=5", "contact=0", "push_mm=0"});
  EXPECT_NEAR(r.at("charge_C_deg"), 60, 0.5);
  EXPECT_NEAR(r.at("charge_E_deg"), 60, 0.5);
  EXPECT_NEAR(r.at("charge_DF_deg"), -120, 0.5);
  EXPECT_GT(r.at("stretch_D_F"), 1.3);
  EXPECT_LT(r.at("direction_off_deg"), 45);
}

// Every procedure, laid on one mesh and carried out on others: within the repertoire's 0.5 mm, with room.
TEST(Study, ScriptsSurviveOtherMeshesLatticesAndSkins) {
  const std::vector<std::string> forms{"form=0", "form=1", "form=2"}, cells{"cell_mm=8", "cell_mm=5.5", "cell_mm=7"},
      skins{"skin_mm=2", "skin_mm=1.7", "skin_mm=2.5"};
  for (size_t i = 0; i < 3; ++i) {
    const Row r = run("place", {forms[i], cells[i], skins[i]});
    EXPECT_EQ(r.at("refused"), 0);
    EXPECT_EQ(r.at("procedures"), 15);
    EXPECT_LT(r.at("corner_mm"), 0.25) << forms[i];
    EXPECT_LT(r.at("line_mm"), 0.25) << forms[i];
    EXPECT_LT(r.at("stitch_mm"), 0.5) << forms[i];
    EXPECT_GT(r.at("stitch_mm"), 0) << forms[i];
  }
}

TEST(Study, RowsAsCommaSeparatedValues) {
  Row a, b;
  a.figures = {{"x", 1}, {"y", 0.1}};
  b.figures = {{"x", 2}, {"y", std::nan("")}};
  EXPECT_EQ(csv({a, b}), "x,y\n1,0.1\n2,\n");
  EXPECT_EQ(csv({}), "");
}

}  // namespace test_study
}  // namespace limberg::study
