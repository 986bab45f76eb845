// The flaps are the figures of the textbooks, the scripts make sense on the figure, and the shipped files are current.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "app/program/places.h"
#include "sim/base/error.h"
#include "sim/commands/flaps.h"

namespace limberg {
namespace test_flaps {

double angle_deg(const Vec2& a, const Vec2& tip, const Vec2& b) {
  return std::acos((a - tip).normalized().dot((b - tip).normalized())) * 180 / std::numbers::pi;
}

TEST(Rhomboid, IsLimbergsFigure) {
  const Rhomboid r;
  for (const auto& [p, q] :
       {std::pair(r.A, r.B), {r.B, r.C}, {r.C, r.D}, {r.D, r.A}, {r.D, r.E}, {r.E, r.F}, {r.F, r.C}, {r.D, r.F}})
    EXPECT_NEAR((p - q).norm(), 1, 1e-15);
  EXPECT_NEAR(angle_deg(r.B, r.A, r.D), 60, 1e-12);
  EXPECT_NEAR(angle_deg(r.A, r.B, r.C), 120, 1e-12);
  EXPECT_NEAR(angle_deg(r.D, r.E, r.F), 60, 1e-12);
  EXPECT_NEAR(((r.F - r.E) - (r.C - r.D)).norm(), 0, 1e-15);  // EF parallel to DC
}

TEST(Rhomboid, ShippedPlanClosesTheDonorAcrossTheTensionLines) {
  const Rhomboid r = shipped_rhomboid();
  const Vec2 df = r.frame.chart(r.F) - r.frame.chart(r.D);
  EXPECT_NEAR(df.x(), 0, 1e-12);  // tension lines along x
  EXPECT_NEAR(df.norm(), 20, 1e-12);
}

TEST(ZPlasty, TransposedLimbHasTheTheoreticalLength) {
  for (double t : {20., 30., 45., 60., 75., 90.}) {
    ZPlasty z;
    z.angle_deg = t;
    EXPECT_NEAR((z.C() - z.A()).norm(), 1, 1e-15);
    EXPECT_NEAR(angle_deg(z.B(), z.A(), z.C()), t, 1e-10);
    EXPECT_NEAR(angle_deg(z.A(), z.B(), z.D()), t, 1e-10);
    EXPECT_NEAR((z.C() - z.D()).norm(), std::sqrt(5 - 4 * std::cos(t * std::numbers::pi / 180)), 1e-12);
    EXPECT_LT(z.C().x(), 0);
    EXPECT_GT(z.D().x(), 0);
  }
}

// Does the segment pq cross the polyline?
bool crosses(const Vec2& p, const Vec2& q, const std::vector<Vec2>& line) {
  const auto side = [](const Vec2& a, const Vec2& b, const Vec2& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  };
  for (size_t i = 1; i < line.size(); ++i)
    if (side(p, q, line[i - 1]) * side(p, q, line[i]) < 0 &&
        side(line[i - 1], line[i], p) * side(line[i - 1], line[i], q) < 0)
      return true;
  return false;
}

// Collects the pairs of all stitches of a script.
std::vector<std::pair<ChartPoint, ChartPoint>> stitches(const std::vector<Command>& commands) {
  std::vector<std::pair<ChartPoint, ChartPoint>> all;
  for (const Command& c : commands) {
    if (const auto* s = std::get_if<Suture>(&c)) all.push_back({s->a, s->b});
    if (const auto* r = std::get_if<SutureRow>(&c)) {
      const int n = int(std::lround((r->a[1] - r->a[0]).norm() / r->spacing_mm));
      for (int i = 0; i <= n; ++i) {
        const double t = double(i) / n;
        all.push_back({(1 - t) * r->a[0] + t * r->a[1], (1 - t) * r->b[0] + t * r->b[1]});
      }
    }
  }
  return all;
}

double distance_to(const Vec2& p, const std::vector<Vec2>& line) {
  double d = 1e30;
  for (size_t i = 1; i < line.size(); ++i) {
    const Vec2 e = line[i] - line[i - 1];
    const double t = std::clamp((p - line[i - 1]).dot(e) / e.squaredNorm(), 0., 1.);
    d = std::min(d, (line[i - 1] + t * e - p).norm());
  }
  return d;
}

bool inside(const Vec2& p, const std::vector<Vec2>& polygon) {
  bool in = false;
  for (size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++)
    if ((polygon[i].y() > p.y()) != (polygon[j].y() > p.y()) &&
        p.x() < (polygon[j].x() - polygon[i].x()) * (p.y() - polygon[i].y()) / (polygon[j].y() - polygon[i].y()) +
                    polygon[i].x())
      in = !in;
  return in;
}

TEST(Rhomboid, StitchesLieInTissueBesideTheirEdges) {
  for (bool mirrored : {false, true})
    for (double turn : {0., -30., 77.}) {
      Rhomboid r;
      r.frame = {{3, -4}, 24, turn, mirrored};
      const auto& f = r.frame;
      const std::vector<Vec2> hole{f.chart(r.A), f.chart(r.B), f.chart(r.C), f.chart(r.D), f.chart(r.A)},
          cut{f.chart(r.D), f.chart(r.E), f.chart(r.F)};
      const std::vector<Vec2> flap{f.chart(r.C), f.chart(r.D), f.chart(r.E), f.chart(r.F)};
      const auto all = stitches(operation(r));
      EXPECT_EQ(all.size(),
                3u + 3 * 5 + 6);  // spacing 4 on sides of 24: three rows of 16 mm in 4 steps, one of 18.4 mm in 5
      int from_flap = 0;
      for (const auto& [a, b] : all) {
        for (const Vec2& p : {a, b}) {
          EXPECT_FALSE(inside(p, hole));
          EXPECT_LE(std::min(distance_to(p, hole), distance_to(p, cut)), 0.91);
          EXPECT_GE(std::min(distance_to(p, hole), distance_to(p, cut)), 0.4);
        }
        EXPECT_FALSE(inside(b, flap));  // the flap is held to its surroundings, never to itself
        from_flap += inside(a, flap);
        EXPECT_TRUE(crosses(a, b, hole) || crosses(a, b, cut));
      }
      EXPECT_EQ(from_flap, 2 + 2 * 5 + 6);  // all but the donor's row
      // The first stitch closes the donor, D to F.
      EXPECT_LT((all[0].first - f.chart(r.D)).norm(), 1.2);
      EXPECT_LT((all[0].second - f.chart(r.F)).norm(), 1.2);
    }
}

TEST(ZPlasty, StitchesPairTheEdgesOfTheTransposedFlaps) {
  for (double t : {30., 45., 60., 90.}) {
    ZPlasty z;
    z.angle_deg = t;
    const auto& f = z.frame;
    const Vec2 A = f.chart(z.A()), B = f.chart(z.B()), C = f.chart(z.C()), D = f.chart(z.D());
    const std::vector<Vec2> flap1{A, B, C}, flap2{A, B, D};
    int one = 0, two = 0, both = 0;
    const auto all = stitches(operation(z));
    for (const auto& [a, b] : all) {
      const bool a1 = inside(a, flap1), a2 = inside(a, flap2), b2 = inside(b, flap2);
      EXPECT_TRUE(a1 || a2);
      EXPECT_FALSE(inside(b, flap1));
      (a1 && b2 ? both : a1 ? one : two) += 1;
    }
    EXPECT_EQ(one, 5);
    EXPECT_EQ(two, 5);
    EXPECT_EQ(both, 4);
    // Corner B to C, then corner A to D.
    EXPECT_LT((all[0].first - B).norm(), 1);
    EXPECT_LT((all[0].second - C).norm(), 1.2);
    EXPECT_LT((all[1].first - A).norm(), 1);
    EXPECT_LT((all[1].second - D).norm(), 1.2);
  }
}

TEST(Flaps, EverythingStaysOnTheShippedSkin) {
  for (const char* name : {"rhomboid", "zplasty"})
    for (const ScriptLine& l : shipped_script(name).lines)
      if (const auto* u = std::get_if<Undermine>(&l.command)) {
        for (const auto& p : u->outline) EXPECT_LT(p.cwiseAbs().maxCoeff(), 55);
      }
}

TEST(Flaps, ShippedScriptsAreCurrent) {
  for (const char* name : {"rhomboid", "zplasty"}) {
    const std::string path = source_dir() + "/recordings/" + name + ".jsonl";
    std::ifstream in(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    EXPECT_EQ(text, to_text(shipped_script(name))) << "renew with: ninja -C build write_scripts";
    EXPECT_EQ(load_script(path).header.scene, name);
  }
  EXPECT_THROW(shipped_script("bilobed"), InputError);
  EXPECT_EQ(load_script(source_dir() + "/recordings/face.jsonl").header.scene, "face");
}

}  // namespace test_flaps
}  // namespace limberg
