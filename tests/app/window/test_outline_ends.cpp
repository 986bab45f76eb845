// An outline whose end runs on beyond its beginning gives one cut, stated by a script, drawn with stylus or mouse.
#include <gtest/gtest.h>

#include <cmath>

#include "app/assembly/assembly.h"
#include "app/program/places.h"
#include "app/session/lockstep.h"
#include "app/window/pointer_source.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"

namespace limberg {
namespace test_outline_ends {

Scene coarse() {
  Scene scene = load_scene(source_dir() + "/app/scenes/rhomboid.toml");
  scene.cell_mm = 8;
  return scene;
}

/// A rectangle of 16 x 10 mm, drawn from its lower left corner round; the end runs on by so much.
std::vector<ChartPoint> rectangle(double beyond_mm) {
  std::vector<ChartPoint> p{{-8, -5}, {8, -5}, {8, 5}, {-8, 5}};
  if (beyond_mm > 0) p.push_back({-8, -5 - beyond_mm});
  return p;
}

/// A hand that presses at the first corner, goes round at 30 mm/s, and lets go at the last.
struct Drawn {
  std::vector<Vec2> place;  // each a hundredth of a second
  explicit Drawn(const std::vector<ChartPoint>& corners) {
    const auto rest = [&](const Vec2& p) { place.insert(place.end(), 20, p); };
    rest(corners[0]);
    for (size_t i = 1; i < corners.size(); ++i) {
      const int n = std::max(1, int((corners[i] - corners[i - 1]).norm() / 0.3));
      for (int k = 1; k <= n; ++k) place.push_back(corners[i - 1] + (corners[i] - corners[i - 1]) * (double(k) / n));
      rest(corners[i]);
    }
  }
  bool pressed(size_t i) const { return i >= 10 && i + 10 < place.size(); }
};

ControlSample excise() {
  ControlSample c;
  c.kind = ControlSample::select_tool, c.tool = Tool::excise, c.value[kDepth] = 4;
  return c;
}

struct Stylus final : Source {
  Drawn way;
  size_t next = 0;
  int64_t seq = 0;
  explicit Stylus(const std::vector<ChartPoint>& corners) : way(corners) {}
  void look(const Snapshot&) override {}
  void poll(int64_t now_ns, SampleSink& sink) override {
    if (seq == 0) {
      ControlSample c = excise();
      c.device_id = 9, c.seq = seq++, c.t_ns = now_ns;
      sink.on_sample(c);
    }
    for (; next < way.place.size() && int64_t(next) * 10'000'000 <= now_ns; ++next) {
      StylusSample s;
      s.device_id = 9, s.seq = seq++, s.t_ns = now_ns, s.buttons = way.pressed(next);
      s.tip_mm = {way.place[next].x(), way.place[next].y(), 0};
      sink.on_sample(s);
    }
  }
  bool done() const override { return next == way.place.size(); }
  SourceCounts counts() const override { return {seq, 0, 0}; }
};

/// The mouse: rays from an eye above, as the window sends them.
struct Mouse final : Source {
  Drawn way;
  HandFeed feed;
  PointerSource pointer{feed, false};
  size_t next = 0;
  explicit Mouse(const std::vector<ChartPoint>& corners) : way(corners) { feed.input.push(excise()); }
  void look(const Snapshot& s) override { pointer.look(s); }
  void poll(int64_t now_ns, SampleSink& sink) override {
    for (; next < way.place.size() && int64_t(next) * 10'000'000 <= now_ns; ++next) {
      PointerReading r;
      r.eye_mm = {3, -20, 200};
      r.towards = (Vec3f(float(way.place[next].x()), float(way.place[next].y()), 0) - r.eye_mm).normalized();
      r.pressed = way.pressed(next);
      feed.input.push(r);
    }
    pointer.poll(now_ns, sink);
  }
  bool done() const override { return next == way.place.size(); }
  SourceCounts counts() const override { return pointer.counts(); }
};

struct Cut {
  double removed_mm3 = 0;
  uint64_t topology = 0;
};
Cut scripted(const std::vector<ChartPoint>& outline) {
  Assembly a(coarse(), Calibration{}, {});
  const Outcome o = a.patient->apply(Excise{outline, 4});
  EXPECT_TRUE(o.done) << o.reason;
  const World& world = *a.world;
  return {world.skin()->removed_volume_mm3(), world.skin()->topology_hash()};
}
template <class Hand>
Cut drawn(const std::vector<ChartPoint>& outline) {
  const Scene scene = coarse();
  Assembly a(scene, Calibration{}, {});
  a.front.add(std::make_unique<Hand>(outline));
  SessionSettings settings = a.session_settings();
  settings.settle_steps = 0;
  run_lockstep(a.lanes(nullptr), settings);
  for (const Refusal& r : a.solver.refused()) ADD_FAILURE() << r.command << ": " << r.reason;
  EXPECT_EQ(a.done.size(), 1u);
  const auto* e = a.done.empty() ? nullptr : std::get_if<Excise>(&a.done[0]);
  std::string corners;
  for (size_t i = 0; e && i < e->outline.size(); ++i)
    corners += "(" + std::to_string(e->outline[i].x()) + ", " + std::to_string(e->outline[i].y()) + ") ";
  if (e) {
    EXPECT_EQ(e->outline.size(), 4u) << (std::is_same_v<Hand, Mouse> ? "mouse: " : "stylus: ") << corners;
  }
  const World& world = *a.world;
  return {world.skin()->removed_volume_mm3(), world.skin()->topology_hash()};
}

TEST(OutlineEnds, ScriptStylusAndMouseGiveTheSameCut) {
  const Cut exact = scripted(rectangle(0));
  EXPECT_NEAR(exact.removed_mm3, 16 * 10 * 4, 0.05 * 16 * 10 * 4);
  for (const double beyond_mm : {0.6, 4.0}) {
    const Cut script = scripted(rectangle(beyond_mm));
    EXPECT_EQ(script.topology, exact.topology) << beyond_mm;
    EXPECT_EQ(script.removed_mm3, exact.removed_mm3);
    for (const Cut& hand : {drawn<Stylus>(rectangle(beyond_mm)), drawn<Mouse>(rectangle(beyond_mm))})
      EXPECT_NEAR(hand.removed_mm3, exact.removed_mm3, 0.02 * exact.removed_mm3) << beyond_mm;
  }
}

TEST(OutlineEnds, PocketsAndWallsFollowTheSameRule) {
  for (const bool floor : {true, false}) {
    std::vector<uint64_t> topology;
    for (const double beyond_mm : {0.0, 0.6}) {
      Assembly a(coarse(), Calibration{}, {});
      if (floor) {
        ASSERT_TRUE(a.patient->apply(Incise{{{-12, -5}, {12, -5}}, 4, 90}).done);
        const Outcome o = a.patient->apply(Undermine{rectangle(beyond_mm), 4});
        ASSERT_TRUE(o.done) << o.reason;
      } else {
        ASSERT_TRUE(a.patient->apply(Incise{{{-12, -7}, {12, -7}}, 4, 90}).done);
        ASSERT_TRUE(a.patient->apply(Undermine{{{-12, -7}, {12, -7}, {12, 8}, {-12, 8}}, 4}).done);
        const Outcome o = a.patient->apply(Excise{rectangle(beyond_mm), 5, false});
        ASSERT_TRUE(o.done) << o.reason;
      }
      topology.push_back(a.world->skin()->topology_hash());
    }
    EXPECT_EQ(topology[0], topology[1]) << (floor ? "a pocket" : "walls");
  }
}

}  // namespace test_outline_ends
}  // namespace limberg
