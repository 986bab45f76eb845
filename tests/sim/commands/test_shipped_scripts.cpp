// The shipped scripts: their flaps are the figures of the textbooks, their stitches hold what is to be sewn.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>

#include "sim/commands/flap_exchange.h"
#include "sim/geometry/overrun.h"
#include "tests/sim/commands/shipped_scripts.h"

namespace limberg {
namespace test_shipped_scripts {

using namespace test;

double angle_deg(const Vec2& a, const Vec2& tip, const Vec2& b) {
  return std::acos((a - tip).normalized().dot((b - tip).normalized())) * 180 / std::numbers::pi;
}

// The rule for outlines that run on beyond their beginning cuts nothing off what is shipped.
TEST(ShippedScripts, NoOutlineRunsOn) {
  int outlines = 0;
  for (const auto& e : std::filesystem::directory_iterator(source_dir() + "/recordings")) {
    if (e.path().extension() != ".jsonl") continue;
    for (const Command& c : shipped_commands(e.path().stem().string())) {
      const std::vector<ChartPoint>* outline = nullptr;
      if (const auto* x = std::get_if<Excise>(&c)) outline = &x->outline;
      if (const auto* u = std::get_if<Undermine>(&c)) outline = &u->outline;
      if (!outline) continue;
      ++outlines;
      EXPECT_EQ(points_to_closing(*outline), outline->size()) << e.path();
    }
  }
  EXPECT_GT(outlines, 20);
}

constexpr double kRounded_mm = 2e-3;  // scripts state thousandths

/// Rhombus ABCD with 60 degrees at A and C; its short diagonal BD, prolonged, gives E; EF is parallel to DC. The flap
/// CDEF keeps its base CF; its corner D comes to B, E to A.
struct Rhomboid {
  ChartPoint A, B, C, D, E, F;
};
Rhomboid shipped_rhomboid() {
  const auto hole = first_of<Excise>(shipped_commands("rhomboid")).outline;
  const auto cut = first_of<Incise>(shipped_commands("rhomboid")).path;
  return {hole.at(0), hole.at(1), hole.at(2), hole.at(3), cut.at(1), cut.at(2)};
}

TEST(ShippedRhomboid, IsLimbergsFigure) {
  const Rhomboid r = shipped_rhomboid();
  for (const auto& [p, q] :
       {std::pair(r.A, r.B), {r.B, r.C}, {r.C, r.D}, {r.D, r.A}, {r.D, r.E}, {r.E, r.F}, {r.F, r.C}, {r.D, r.F}})
    EXPECT_NEAR((p - q).norm(), 20, kRounded_mm);
  EXPECT_NEAR(angle_deg(r.B, r.A, r.D), 60, 0.01);
  EXPECT_NEAR(angle_deg(r.A, r.B, r.C), 120, 0.01);
  EXPECT_NEAR(angle_deg(r.D, r.E, r.F), 60, 0.01);
  EXPECT_NEAR(((r.F - r.E) - (r.C - r.D)).norm(), 0, kRounded_mm);  // EF parallel to DC
  EXPECT_EQ(first_of<Incise>(shipped_commands("rhomboid")).path.at(0), r.D);
}

// There the tension is greatest: the line runs along the most extensible direction (Limberg; Lister and Gibson 1972).
TEST(ShippedRhomboid, ClosesTheDonorAcrossTheTensionLines) {
  const Rhomboid r = shipped_rhomboid();
  EXPECT_NEAR((r.F - r.D).x(), 0, kRounded_mm);  // tension lines along x
}

/// AB is the central limb (the contracted scar), AC and BD the lateral limbs; corner A comes to D, B to C.
struct ZPlasty {
  ChartPoint C, A, B, D;
};
ZPlasty shipped_zplasty() {
  const auto cut = first_of<Incise>(shipped_commands("zplasty")).path;
  return {cut.at(0), cut.at(1), cut.at(2), cut.at(3)};
}

TEST(ShippedZPlasty, TransposedLimbHasTheTheoreticalLength) {
  const ZPlasty z = shipped_zplasty();
  for (const auto& [p, q] : {std::pair(z.A, z.B), {z.A, z.C}, {z.B, z.D}}) EXPECT_NEAR((p - q).norm(), 20, kRounded_mm);
  EXPECT_NEAR(angle_deg(z.B, z.A, z.C), 60, 0.01);
  EXPECT_NEAR(angle_deg(z.A, z.B, z.D), 60, 0.01);
  EXPECT_NEAR((z.C - z.D).norm(), 20 * std::sqrt(5 - 4 * std::cos(std::numbers::pi / 3)), kRounded_mm);
}

// A tip that is pressed into its corner jams there, and where a needle meets it is chance.
TEST(ShippedZPlasty, FlapsAreSetDownShortOfTheirCorners) {
  const ZPlasty z = shipped_zplasty();
  std::map<int, ChartPoint> held;
  std::map<int, Vec3> down;
  for (const Command& c : shipped_commands("zplasty")) {
    if (const auto* h = std::get_if<SetHook>(&c)) held[h->id] = h->at;
    if (const auto* m = std::get_if<MoveHook>(&c)) down[m->id] = m->to_mm;
  }
  ASSERT_EQ(held.size(), 2u);
  for (const auto& [id, to] : down) {
    const bool first = (held.at(id) - z.A).norm() < (held.at(id) - z.B).norm();
    const ChartPoint tip = first ? z.A : z.B, corner = first ? z.D : z.C;
    const double left_mm = (corner - to.head<2>()).norm() - (tip - held.at(id)).norm();
    EXPECT_NEAR(left_mm, kShortOfCorner_mm, 0.01) << id;
    EXPECT_DOUBLE_EQ(to.z(), kLaidAt_mm) << id;
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

TEST(ShippedRhomboid, StitchesLieInTissueBesideTheirEdges) {
  const Rhomboid r = shipped_rhomboid();
  const std::vector<Vec2> hole{r.A, r.B, r.C, r.D, r.A}, cut{r.D, r.E, r.F}, flap{r.C, r.D, r.E, r.F};
  const auto all = stitches(shipped_commands("rhomboid"));
  EXPECT_EQ(all.size(), 3u + 3 * 4 + 5);  // spacing 4: three rows of 12 mm in 3 steps, one of 14.4 mm in 4
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
  EXPECT_EQ(from_flap, 2 + 2 * 4 + 5);  // all but the donor's row
  // The first stitch closes the donor, D to F.
  EXPECT_LT((all[0].first - r.D).norm(), 1.2);
  EXPECT_LT((all[0].second - r.F).norm(), 1.2);
}

TEST(ShippedZPlasty, StitchesPairTheEdgesOfTheTransposedFlaps) {
  const ZPlasty z = shipped_zplasty();
  const std::vector<Vec2> flap1{z.A, z.B, z.C}, flap2{z.A, z.B, z.D};
  int one = 0, two = 0, both = 0;
  const auto all = stitches(shipped_commands("zplasty"));
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
  EXPECT_LT((all[0].first - z.B).norm(), 1);
  EXPECT_LT((all[0].second - z.C).norm(), 1.2);
  EXPECT_LT((all[1].first - z.A).norm(), 1);
  EXPECT_LT((all[1].second - z.D).norm(), 1.2);
}

TEST(ShippedScripts, StayOnTheShippedSkin) {
  for (const char* name : {"rhomboid", "zplasty"})
    for (const ChartPoint& p : first_of<Undermine>(shipped_commands(name)).outline)
      EXPECT_LT(p.cwiseAbs().maxCoeff(), 55);
}

TEST(ShippedScripts, AreReadAndWrittenByteForByte) {
  for (const std::string name : {"rhomboid", "zplasty"}) {
    std::ifstream in(source_dir() + "/recordings/" + name + ".jsonl", std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    EXPECT_EQ(text, to_text(shipped_script(name)));
    EXPECT_EQ(shipped_script(name).header.scene, name);
  }
  for (const std::string name : {"face", "scalp", "craniofacial"})  // written by hand
    EXPECT_EQ(shipped_script(name).header.scene, name);
  for (const std::string name : {"le_fort_1", "le_fort_3", "sagittal_split", "genioplasty", "autorotation"}) {
    std::ifstream in(source_dir() + "/recordings/" + name + ".jsonl", std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    EXPECT_EQ(text, to_text(shipped_script(name))) << name;  // as `limberg procedure` writes it
  }
  for (const std::string name : {"head-le-fort-1", "head-genioplasty"})
    EXPECT_EQ(shipped_script(name).header.scene, "head");
}

}  // namespace test_shipped_scripts
}  // namespace limberg
