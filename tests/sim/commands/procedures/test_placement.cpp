// Figures on curved skin: straight on, true lengths through the origin, the same places on another mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "sim/base/error.h"
#include "sim/body/block.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/commands/procedures/operation.h"
#include "sim/commands/procedures/placement.h"
#include "sim/commands/script.h"

namespace limberg {
namespace test_placement {

std::shared_ptr<Body> flat(double skin_cell_mm) {
  BlockSpec b;
  b.skin_cell_mm = skin_cell_mm;
  b.layers = {{"skin", 10, Material()}};
  return std::make_shared<Body>(make_block(b));
}

// The skin of a dome: a grid over |x|, |y| <= half, z = height(x, y). Only the skin is needed here.
template <class Height>
std::shared_ptr<Body> dome(double half, int n, const Height& height) {
  auto body = std::make_shared<Body>();
  body->name = "dome";
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = -half + 2 * half * i / n, y = -half + 2 * half * j / n;
      body->surface.X_mm.push_back({x, y, height(x, y)});
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      body->surface.tri.push_back({a, b, d}), body->surface.tri.push_back({a, d, c});
    }
  body->surface.tag.assign(body->surface.tri.size(), SurfaceTag::skin);
  return body;
}

TEST(OnSkin, IsATurnAndAShiftOnFlatSkin) {
  const Skin skin(flat(1.7));
  const OnSkin on(skin, {{3, -4}, 30, true});
  for (const Vec2& p : {Vec2(0, 0), Vec2(10, 0), Vec2(-7, 13), Vec2(21.3, -17.9)}) {
    const double c = std::cos(std::numbers::pi / 6), s = 0.5;
    const Vec2 q(p.x(), -p.y()), want(3 + c * q.x() - s * q.y(), -4 + s * q.x() + c * q.y());
    EXPECT_LT((on.chart(p) - want).norm(), 1e-9);
    EXPECT_LT((on.above(p, 5) - Vec3(want.x(), want.y(), 5)).norm(), 1e-9);
  }
}

// On a sphere the exponential map is known: distance r in direction u arrives at angle r / R from the pole.
TEST(OnSkin, WalksGreatCirclesOnASphere) {
  constexpr double R = 60;
  double last = 0;
  for (const int n : {60, 120, 240}) {
    const Skin skin(dome(40, n, [](double x, double y) { return std::sqrt(R * R - x * x - y * y); }));
    const OnSkin on(skin, {{0.37, 0.21}, 0, false});
    const Vec3 pole = skin.at({0.37, 0.21})->X_mm.normalized();
    double worst = 0;
    for (const double r : {5., 15., 30.})
      for (int k = 0; k < 24; ++k) {
        const double a = 2 * std::numbers::pi * (k + 0.3) / 24;
        const Vec3 X = on.spot(r * Vec2(std::cos(a), std::sin(a))).X_mm;
        worst = std::max(worst, std::abs(std::acos(std::clamp(X.normalized().dot(pole), -1.0, 1.0)) * R - r));
      }
    // Chords are shorter than arcs by h^2 / 24 R^2 of their length (h: mesh width); the direction errs by as much.
    const double h = 80.0 / n * std::numbers::sqrt2;
    EXPECT_LT(worst, 30 * h * h / (24 * R * R) * 3);
    if (last > 0) {
      EXPECT_LT(worst, 0.45 * last);
    }
    last = worst;
  }
}

TEST(OnSkin, UnrollsACylinder) {
  constexpr double R = 40;
  const Skin skin(dome(30, 300, [](double x, double) { return std::sqrt(R * R - x * x); }));
  const OnSkin on(skin, {{0, 0}, 0, false});
  for (const Vec2& p : {Vec2(20, 0), Vec2(0, 20), Vec2(14, -11), Vec2(-9, 17)}) {
    const Vec3 want(R * std::sin(p.x() / R), p.y(), R * std::cos(p.x() / R));
    EXPECT_LT((on.spot(p).X_mm - want).norm(), 0.01);
  }
}

// The same figure on a remeshed skin: within 0.5 mm (the bar of the repertoire), here far better.
// On a strongly curved bump a straight line of the figure that passes beside the origin is bent on the chart.
TEST(OnSkin, LinesAreFollowedOnACurvedSkin) {
  const Skin skin(dome(45, 150, [](double x, double y) { return 14 * std::exp(-(x * x + y * y) / 200); }));
  const OnSkin on(skin, {{9, 0}, 20, false});
  const Vec2 a(-20, -9), b(18, 7);
  const auto off = [&](const std::vector<ChartPoint>& chart) {  // of the places meant from the line cut, on the skin
    double worst = 0;
    for (double t = 0; t <= 1; t += 1.0 / 128) {
      const Vec3 meant = on.spot(a + t * (b - a)).X_mm;
      double best = 1e300;
      for (size_t i = 1; i < chart.size(); ++i)
        for (int k = 0; k <= 400; ++k)
          if (const auto x = skin.at(chart[i - 1] + (chart[i] - chart[i - 1]) * (k / 400.0)))
            best = std::min(best, (x->X_mm - meant).norm());
      worst = std::max(worst, best);
    }
    return worst;
  };
  std::vector<ChartPoint> followed{on.chart(a)};
  for (const ChartPoint& p : on.line(a, b)) followed.push_back(p);
  EXPECT_GT(off({on.chart(a), on.chart(b)}), 0.5);
  EXPECT_LT(off(followed), 0.2);  // 0.1 at the quarters of each piece; what lies between them, and the samples here
  EXPECT_LT(followed.size(), 40u);
  EXPECT_EQ((followed.back() - on.chart(b)).norm(), 0);
  // The script's cut is that line.
  Figure f = find_procedure("z_plasty").figure({14, 60, 60});
  const auto commands = carry_out(f, on);
  const auto& path = std::get<Incise>(commands.at(0)).path;
  EXPECT_GT(path.size(), 4u);
  // On a flat skin nothing is added.
  const Skin level(flat(2));
  EXPECT_EQ(OnSkin(level, {{1, 2}, 33, true}).line(a, b).size(), 1u);
  EXPECT_EQ(std::get<Incise>(carry_out(f, OnSkin(level, {})).at(0)).path.size(), 4u);
}

// A corner's stitch has tissue on both sides, in the cusp between two lobes too: a hand cuts .1 mm beside its line and
// would take the other side of the cut for what is left of the tip.
TEST(CarryOut, ANeedleHasRoomInEveryCorner) {
  const Skin level(flat(2));
  int in_corners = 0;
  for (const Procedure& p : procedures()) {
    const Figure f = p.figure(p.defaults());
    const OperationPlan plan;
    for (const Command& c : carry_out(f, OnSkin(level, {}), plan))
      if (const auto* s = std::get_if<Suture>(&c))
        for (const Vec2& at : {s->a, s->b}) {
          double least = 1e300;
          bool corner = false;
          for (const auto& w : f.wounds)
            for (size_t i = 0; i < w.size(); ++i) {
              const Vec2 e = w[(i + 1) % w.size()] - w[i];
              const double t = std::clamp((at - w[i]).dot(e) / e.squaredNorm(), 0., 1.);
              least = std::min(least, (w[i] + t * e - at).norm());
              corner |= (w[i] - at).norm() < 2.01;
            }
          if (corner) EXPECT_GT(least, 0.22) << p.name << " at " << at.transpose();  // a tip of 30 degrees: .9 sin 15
          in_corners += corner;
        }
  }
  EXPECT_GT(in_corners, 40);
}

// A deep layer is the skin's stitches once more, as deep as asked for, all sewn before the first of the skin; the rest
// of the operation is as without it.
TEST(CarryOut, ADeepLayerLiesUnderEveryStitchOfASeam) {
  const Skin level(flat(2));
  int layers = 0;
  for (const Procedure& p : procedures()) {
    const Figure f = p.figure(p.defaults());
    const std::vector<Command> one = carry_out(f, OnSkin(level, {}));
    OperationPlan plan;
    plan.buried_mm = 1.5;
    std::vector<std::string> deep, skin, rest;
    bool sewn_below = false;
    for (const Command& c : carry_out(f, OnSkin(level, {}), plan)) {
      if (const auto* s = std::get_if<Stage>(&c); s && s->name == "deep layer") {
        sewn_below = true;
        rest.pop_back();  // the wait before the stage
        continue;
      }
      const auto* s = std::get_if<Suture>(&c);
      const auto* r = std::get_if<SutureRow>(&c);
      const double depth = s ? s->depth_mm : r ? r->depth_mm : 0;
      if (depth > 0) {
        EXPECT_FALSE(sewn_below) << p.name;
        EXPECT_EQ(depth, 1.5) << p.name;
        Command flat_one = c;
        if (s) std::get<Suture>(flat_one).depth_mm = 0;
        if (r) std::get<SutureRow>(flat_one).depth_mm = 0;
        deep.push_back(to_json_line(flat_one));
      } else {
        if (sewn_below && (s || r)) skin.push_back(to_json_line(c));
        rest.push_back(to_json_line(c));
      }
    }
    EXPECT_EQ(deep, skin) << p.name;
    std::vector<std::string> as_before;
    for (const Command& c : one) as_before.push_back(to_json_line(c));
    EXPECT_EQ(rest, as_before) << p.name;
    layers += !deep.empty();
  }
  EXPECT_GT(layers, 10);
}

// Where a stitch has drawn a corner to a bank, a second one through that corner meets what lies over it.
TEST(CarryOut, ABilobedFlapsNeedleGoesInNowhereTwice) {
  const Skin level(flat(2));
  std::vector<Vec2> holes;
  for (const Command& c : carry_out(find_procedure("bilobed").figure({15, 45}), OnSkin(level, {}))) {
    std::vector<Vec2> now;
    if (const auto* s = std::get_if<Suture>(&c)) now = {s->a, s->b};
    if (const auto* r = std::get_if<SutureRow>(&c)) {
      now = r->a;
      now.insert(now.end(), r->b.begin(), r->b.end());
    }
    for (const Vec2& at : now) {
      for (const Vec2& before : holes) EXPECT_GT((at - before).norm(), 1) << at.transpose();
      holes.push_back(at);
    }
  }
  EXPECT_GT(holes.size(), 40u);
}

TEST(OnSkin, RemeshedSkinGivesTheSamePlaces) {
  const auto hill = [](double x, double y) { return 12 * std::cos(x / 18) * std::cos(y / 25); };
  const Skin coarse(dome(45, 50, hill)), fine(dome(45, 173, hill));
  for (const Procedure& p : procedures()) {
    const Figure f = p.figure(p.defaults());
    const OnSkin a(coarse, {{2, 1}, 17, false}), b(fine, {{2, 1}, 17, false});
    for (const auto& w : f.wounds)
      for (const Vec2& c : w) {
        if (c.norm() > 30) continue;
        EXPECT_LT((a.spot(c).X_mm - b.spot(c).X_mm).norm(), 0.5) << p.name;
      }
  }
}

TEST(OnSkin, RefusesPlacesBeyondTheSkin) {
  const Skin skin(flat(2));
  EXPECT_THROW(OnSkin(skin, {{70, 0}, 0, false}), InputError);
  EXPECT_THROW(OnSkin(skin, {{50, 0}, 0, false}).chart({20, 0}), InputError);
}

TEST(CarryOut, WritesScriptsThatReadBack) {
  const Skin skin(flat(2));
  for (const Procedure& p : procedures()) {
    const auto commands = carry_out(p.figure(p.defaults()), OnSkin(skin, {}));
    EXPECT_GT(commands.size(), 6u) << p.name;
    for (const Command& c : commands)
      EXPECT_EQ(to_json_line(parse_command(to_json_line(c), "test", 1)), to_json_line(c));
  }
}

// The edge of the figure's wounds that is nearest to a place, as its wound and the corner that it begins at; of two
// banks in one place that on whose left the place lies. `left`: whether it lies in tissue.
struct Beside {
  Corner edge;
  bool left = false;
};
Beside nearest_edge(const Figure& f, const Vec2& p) {
  Beside best;
  double least = 1e300;
  for (int w = 0; w < int(f.wounds.size()); ++w)
    for (int i = 0; i < int(f.wounds[size_t(w)].size()); ++i) {
      const auto& at = f.wounds[size_t(w)];
      const Vec2 a = at[size_t(i)], d = at[(size_t(i) + 1) % at.size()] - a, q = p - a;
      const double t = std::clamp(q.dot(d) / d.squaredNorm(), 0.0, 1.0), off = (q - t * d).norm();
      const bool left = d.x() * q.y() - d.y() * q.x() > 0;
      if (off < least - 1e-9 || (off < least + 1e-9 && left)) least = off, best = {{w, i}, left};
    }
  return best;
}

// A stitch takes the edge that its place is nearest to. Beside a tip of a few degrees the usual distance behind the
// edge leads beyond the other one: o_to_z's tips have 5 degrees.
TEST(CarryOut, EveryStitchGoesThroughTheEdgeOfItsSeam) {
  const Skin skin(flat(2));
  for (const Procedure& p : procedures()) {
    const Figure f = p.figure(p.defaults());
    const OnSkin on(skin, {});
    std::vector<std::pair<Vec2, Vec2>> tied;  // the seams' stitches, in their order
    for (const Command& c : carry_out(f, on)) {
      if (const auto* one = std::get_if<Suture>(&c)) tied.push_back({one->a, one->b});
      if (const auto* row = std::get_if<SutureRow>(&c))
        for (size_t i = 0; i < row->a.size(); ++i) tied.push_back({row->a[i], row->b[i]});
    }
    ASSERT_GT(tied.size(), f.keys.size());
    tied.erase(tied.begin(), tied.begin() + std::ptrdiff_t(f.keys.size()));
    const auto among = [&](const Corner& edge, Corner from, const Corner& to) {  // forward from one corner to the other
      if (edge.wound != from.wound) return false;
      for (; from.at != to.at; from.at = (from.at + 1) % int(f.wounds[size_t(from.wound)].size()))
        if (from.at == edge.at) return true;
      return false;
    };
    size_t s = 0;
    std::vector<bool> sewn(f.seams.size(), false);
    for (size_t i = 0; i < tied.size(); ++i) {
      const Beside a = nearest_edge(f, tied[i].first), b = nearest_edge(f, tied[i].second);
      EXPECT_TRUE(a.left && b.left) << p.name << ": stitch " << i << " lies in no tissue";
      while (s < f.seams.size() &&
             !(among(a.edge, f.seams[s].a_from, f.seams[s].a_to) && among(b.edge, f.seams[s].b_to, f.seams[s].b_from)))
        ++s;
      ASSERT_LT(s, f.seams.size()) << p.name << ": stitch " << i << " of " << tied.size()
                                   << " joins edges that no seam does";
      sewn[s] = true;
    }
    for (size_t i = 0; i < f.seams.size(); ++i) {  // a short seam is held by the stitches at its corners
      const auto& w = f.wounds[size_t(f.seams[i].a_from.wound)];
      double length = 0;
      for (size_t at = size_t(f.seams[i].a_from.at); at != size_t(f.seams[i].a_to.at); at = (at + 1) % w.size())
        length += (w[(at + 1) % w.size()] - w[at]).norm();
      EXPECT_TRUE(sewn[i] || length < 2 * OperationPlan{}.spacing_mm)
          << p.name << ": seam " << i << " of " << length << " mm has no stitch, and would gape";
    }
  }
}

}  // namespace test_placement
}  // namespace limberg
