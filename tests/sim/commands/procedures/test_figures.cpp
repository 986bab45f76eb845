// Every figure closes to one flat-topped sheet, and its angles are those of the textbooks.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/base/error.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/commands/procedures/plan_drawing.h"
#include "sim/geometry/vec.h"
#include "tests/app/report/xml_check.h"

namespace limberg {
namespace test_figures {

Figure figure(const std::string& name, std::vector<std::string> settings = {}) {
  const Procedure& p = find_procedure(name);
  return p.figure(procedure_values(p, settings));
}

// Every parameter at its default, lowest and highest, one at a time; figures that say why they cannot be are left out.
template <class Visit>
void for_many(const Visit& visit) {
  for (const Procedure& p : procedures())
    for (size_t i = 0; i <= p.parameters.size(); ++i)
      for (const int end : {0, 1}) {
        std::vector<double> v = p.defaults();
        if (i < v.size()) v[i] = end ? p.parameters[i].hi : p.parameters[i].lo;
        try {
          const Figure f = p.figure(v);
          SCOPED_TRACE(p.name + (i < v.size() ? " " + p.parameters[i].name + (end ? " high" : " low") : ""));
          visit(f);
        } catch (const InputError&) {
          EXPECT_LT(i, v.size()) << p.name << " refuses its own defaults";
        }
      }
}

TEST(Figures, EveryEdgeIsSewnOnce) {
  int n = 0;
  for_many([&](const Figure& f) {
    ++n;
    EXPECT_EQ(why_open(f), "");
  });
  EXPECT_GT(n, 60);
}

// Gauss and Bonnet: the closed plan is a disc with the old border, so cones and saddles cancel.
TEST(Figures, ChargesAddUpToNothing) {
  for_many([&](const Figure& f) {
    double sum = 0;
    for (const Charge& c : charges(f)) sum += c.q_deg;
    EXPECT_NEAR(sum, 0, 1e-6);
  });
}

TEST(Figures, AWrongSeamIsFound) {
  Figure f = figure("z_plasty");
  f.seams.pop_back();
  EXPECT_NE(why_open(f), "");
  f = figure("z_plasty");
  f.seams[0].b_from.at = 99;
  EXPECT_NE(why_open(f), "");
  // The edges are all sewn, but to the wrong partners: a handle instead of a disc.
  f = figure("rhomboid");
  std::swap(f.seams[0].b_from, f.seams[1].b_from), std::swap(f.seams[0].b_to, f.seams[1].b_to);
  EXPECT_EQ(why_open(f), "");
  double sum = 0;
  for (const Charge& c : charges(f)) sum += c.q_deg;
  EXPECT_GT(std::abs(sum), 300);
}

std::vector<double> sizes(const Figure& f) {
  std::vector<double> q;
  for (const Charge& c : charges(f)) q.push_back(c.q_deg);
  std::sort(q.begin(), q.end());
  return q;
}

TEST(Figures, RhomboidHasSixtySixtyAndMinusOneHundredAndTwenty) {
  const auto q = sizes(figure("rhomboid"));
  ASSERT_EQ(q.size(), 3u);
  EXPECT_NEAR(q[0], -120, 1e-9);
  EXPECT_NEAR(q[1], 60, 1e-9);
  EXPECT_NEAR(q[2], 60, 1e-9);
}

TEST(Figures, ZPlastyHasItsAngleAtAllFourEnds) {
  for (const double t : {30., 45., 60., 75., 90.}) {
    const auto q = sizes(figure("z_plasty", {"angle_a_deg=" + std::to_string(t), "angle_b_deg=" + std::to_string(t)}));
    ASSERT_EQ(q.size(), 4u);
    EXPECT_NEAR(q[0], -t, 1e-5);
    EXPECT_NEAR(q[1], -t, 1e-5);
    EXPECT_NEAR(q[2], t, 1e-5);
    EXPECT_NEAR(q[3], t, 1e-5);
  }
}

// Vertex angle 4 atan(W/L), and scar length of the closed form, for the ratios that the study uses.
TEST(Figures, FusiformAnglesAndScar) {
  for (const double ratio : {2., 3., 4., 5., 6.}) {
    const Figure f = figure("fusiform", {"ratio=" + std::to_string(ratio)});
    const double W = 14, L = W * ratio, R = (L * L + W * W) / (4 * W), vertex = 4 * std::atan(1 / ratio) * kDeg;
    const double scar = R * vertex / kDeg;
    const double drawn = path_length(bank(f, f.seams[0].a_from, f.seams[0].a_to, true));
    EXPECT_NEAR(drawn, scar, scar * std::pow(vertex / kDeg / 12, 2) / 24 * 1.01);  // chords of 12 equal pieces
    const auto q = sizes(f);
    EXPECT_NEAR(q.back(), vertex,
                vertex / 12 + 1e-9);  // the first chord stands half a piece inside the tangent, at both sides
  }
}

TEST(Figures, WebstersDonorEarIsItsTip) {
  const auto q = sizes(figure("webster"));
  EXPECT_NEAR(q.back(), 60, 1e-9);  // the pivot
  EXPECT_NEAR(q[q.size() - 2], 30, 1e-9);
}

// Cuts along the tangent would leave tips without an angle, in which no stitch holds. A circle of 20 chords and arcs of
// 8 degrees a piece take half of their turns from it.
TEST(Figures, OToZHasTipsOfTheirAngle) {
  for (const double tip : {15., 25., 40.}) {
    const Figure f = figure("o_to_z", {"tip_deg=" + std::to_string(tip)});
    ASSERT_EQ(f.carries.size(), 2u);
    for (const Carry& c : f.carries) EXPECT_NEAR(tissue_deg(f, c.tip), tip + 9 - 4, 1.5) << tip;
  }
}

// Behan 2003: the island's ends at right angles to the defect's edge, its sides concentric, and each V of equal limbs.
TEST(Figures, KeystoneIsARingSector) {
  const Figure f = figure("keystone");
  const std::vector<Vec2>& island = f.wounds[1];
  const Seam& over = f.seams[0];
  const Vec2 right = place(f, over.a_from), left = place(f, f.seams[1].a_to);
  EXPECT_NEAR((right - left).norm(), 27, 1e-9);      // 9 mm by 3
  EXPECT_NEAR(tissue_deg(f, over.a_from), 90, 3.5);  // half a chord of twelve
  EXPECT_NEAR(tissue_deg(f, f.seams[1].a_to), 90, 3.5);
  EXPECT_NEAR((island.front() - left).norm(), 1.2 * 9, 1e-9);
  int stems = 0;
  for (const Seam& s : f.seams) {
    const double a = path_length(bank(f, s.a_from, s.a_to, true)), b = path_length(bank(f, s.b_from, s.b_to, false));
    if (s.a_from.wound != s.b_from.wound) continue;
    ++stems;
    EXPECT_NEAR(a, 2.5, 0.05);
    EXPECT_NEAR(b, 2.5, 0.05);
  }
  EXPECT_EQ(stems, 2);
}

// The banner's bed closes with equal sides, and its two sides lie at its angle from the defect's.
TEST(Figures, BannerTurnsByItsAngle) {
  const Figure f = figure("banner", {"turn_deg=70"});
  const Seam& donor = f.seams[0];
  EXPECT_NEAR(path_length(bank(f, donor.a_from, donor.a_to, true)),
              path_length(bank(f, donor.b_from, donor.b_to, false)), 1e-9);
  const Vec2 near = place(f, f.carries[0].tip), to = place(f, f.carries[0].to);
  EXPECT_NEAR(std::atan2(near.y(), near.x()) - std::atan2(to.y(), to.x()), 70 / kDeg, 1e-9);
  EXPECT_NEAR(near.norm(), to.norm(), 1e-9);
}

// The flap goes where the rhomboid's does: sides of equal length on equal sides.
TEST(Figures, SeamsOfTranspositionFlapsHaveEqualBanks) {
  for (const char* name : {"rhomboid", "dufourmentel", "webster", "z_plasty", "multiple_z", "four_flap_z"})
    for (const Figure f = figure(name); const Seam& s : f.seams)
      EXPECT_NEAR(path_length(bank(f, s.a_from, s.a_to, true)), path_length(bank(f, s.b_from, s.b_to, false)), 1e-9)
          << name;
}

// The title may be that of a lesson or a script, whoever wrote it.
TEST(Figures, ADrawingsTitleStaysText) {
  const std::string svg = plan_svg(figure("z_plasty"), "</text><script>alert(1)</script>\x1b \"&\" \xff");
  EXPECT_EQ(test::xml_fault(svg), "");
  EXPECT_EQ(svg.find("<script"), std::string::npos);
  EXPECT_NE(svg.find("&lt;script&gt;alert(1)"), std::string::npos);
}

TEST(Figures, DrawingNamesEveryCharge) {
  for_many([](const Figure& f) {
    const std::string svg = plan_svg(f, "plan");
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_NE(svg.find("</svg>"), std::string::npos);
    // Every figure can be read: no two on one another, none over the edge.
    std::vector<Vec2> at;
    for (size_t k = 0; (k = svg.find("<text x=\"", k)) != std::string::npos; ++k) {
      const std::string element = svg.substr(k, svg.find("</text>", k) - k);
      double x = 0, y = 0;
      ASSERT_EQ(std::sscanf(element.c_str(), "<text x=\"%lf\" y=\"%lf\"", &x, &y), 2);
      if (element.find("&#176;") != std::string::npos) at.emplace_back(x, y);
    }
    size_t wanted = 0;
    for (const Charge& c : charges(f)) wanted += std::abs(c.q_deg) >= 25;
    EXPECT_EQ(at.size(), wanted);
    for (size_t i = 0; i < at.size(); ++i) {
      EXPECT_GE(at[i].x(), 25);
      EXPECT_LE(at[i].x(), 615);
      for (size_t k = 0; k < i; ++k)
        EXPECT_TRUE(std::abs(at[i].x() - at[k].x()) > 40 || std::abs(at[i].y() - at[k].y()) > 14)
            << f.seams.size() << " seams";
    }
  });
}

TEST(Catalogue, BadSettingsSayWhatWasExpected) {
  const Procedure& p = find_procedure("bilobed");
  for (const char* s :
       {"diameter_mm", "size=3", "diameter_mm=x", "diameter_mm=1e9", "diameter_mm=nan", "diameter_mm=12mm", ""})
    EXPECT_THROW(procedure_values(p, {s}), InputError) << s;
  EXPECT_THROW(procedure_values(p, {"diameter_mm=12", "diameter_mm=13"}), InputError);
  EXPECT_THROW(find_procedure("trilobed"), InputError);
  EXPECT_EQ(procedure_values(p, {"turn_deg=50"}), (std::vector<double>{15, 50}));
}

}  // namespace test_figures
}  // namespace limberg
