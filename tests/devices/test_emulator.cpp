// The surgeon, the front end and the command builder, round the whole way: the script that goes in comes out.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "app/program/places.h"
#include "devices/command_builder.h"
#include "devices/emulator.h"
#include "devices/log_source.h"
#include "devices/motion.h"
#include "sim/base/hash.h"
#include "sim/commands/script.h"
#include "sim/geometry/polyline.h"
#include "tests/devices/flat_patient.h"

namespace limberg {
namespace test_emulator {

using namespace test;

TEST(Motion, MinimumJerkStartsAndEndsAtRest) {
  EXPECT_EQ(minimum_jerk(-1), 0);
  EXPECT_EQ(minimum_jerk(2), 1);
  const double h = 1e-4;
  auto d1 = [&](double s) { return (minimum_jerk(s + h) - minimum_jerk(s - h)) / (2 * h); };
  auto d2 = [&](double s) { return (minimum_jerk(s + h) - 2 * minimum_jerk(s) + minimum_jerk(s - h)) / (h * h); };
  // Speed and acceleration vanish at both ends: s^3 leaves 30 s^2 and 60 s near 0.
  EXPECT_LT(std::abs(d1(2 * h)), 30 * 9 * h * h);
  EXPECT_LT(std::abs(d1(1 - 2 * h)), 30 * 9 * h * h);
  EXPECT_LT(std::abs(d2(2 * h)), 60 * 3 * h);
  EXPECT_LT(std::abs(d2(1 - 2 * h)), 60 * 3 * h);
  EXPECT_NEAR(d1(0.5), 15.0 / 8, 1e-6);
  for (double s = 0; s <= 1; s += 0.01) EXPECT_NEAR(minimum_jerk(s) + minimum_jerk(1 - s), 1, 1e-12);
}

TEST(Motion, TremorStaysInItsBandAndBelowItsAmplitude) {
  const Tremor tremor(3, 0.2, 8, 12);
  double sum2 = 0;
  const int n = 20'000;
  std::vector<double> x(n);
  for (int i = 0; i < n; ++i) {
    const Vec3 p = tremor.at(i * 1e-3);
    EXPECT_LE(p.cwiseAbs().maxCoeff(), 0.2 + 1e-12);
    x[size_t(i)] = p.x();
    sum2 += p.x() * p.x();
  }
  EXPECT_GT(std::sqrt(sum2 / n), 0.04);
  // Power between 8 and 12 Hz against the whole, by projection on sines a twentieth of a hertz apart.
  double inside = 0, all = 0;
  for (double hz = 0.05; hz < 40; hz += 0.05) {
    double c = 0, s = 0;
    for (int i = 0; i < n; i += 4) {
      c += x[size_t(i)] * std::cos(2 * M_PI * hz * i * 1e-3);
      s += x[size_t(i)] * std::sin(2 * M_PI * hz * i * 1e-3);
    }
    all += c * c + s * s;
    if (hz > 7.9 && hz < 12.1) inside += c * c + s * s;
  }
  EXPECT_GT(inside / all, 0.99);
}

TEST(Motion, DropoutsComeAtTheirRate) {
  Dropouts d(7, 0.5, 0.06);
  int lost = 0, gaps = 0, run = 0, longest = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    const bool now = d.lost(i * 1e-3);
    if (now && run == 0) ++gaps;
    run = now ? run + 1 : 0;
    longest = std::max(longest, run);
    lost += now;
  }
  EXPECT_NEAR(gaps, 500, 4 * std::sqrt(500.0));  // Poisson, four standard deviations
  EXPECT_LE(longest, 60);
  EXPECT_NEAR(double(lost) / gaps, 40, 5);  // mean length between a third of the longest and the longest: 40 ms
  Dropouts none(7, 0, 0.06);
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(none.lost(i));
}

std::vector<Command> operation() {
  const double h = 20 * std::sqrt(3.0) / 2;
  std::vector<Command> c;
  c.push_back(Stage{"start"});
  c.push_back(Excise{{{h, 0}, {0, 10}, {-h, 0}, {0, -10}}, 3});
  c.push_back(Incise{{{0.5, 10.5}, {0, 30}, {h, 40}}, 5, 80});
  c.push_back(Undermine{{{-30, -30}, {40, -30}, {40, 45}, {-30, 45}}, 5});
  c.push_back(SetHook{1, {10, 20}});
  c.push_back(MoveHook{1, Vec3(20, 5, 12), 0.8});
  c.push_back(Stage{"flap moved"});
  c.push_back(Suture{{-20, 20}, {-24, 20}});
  c.push_back(MoveHook{1, Vec3(10, 0, 5), 0.5});
  c.push_back(MoveHook{1, Vec3(12, 0, 2), 0.5});
  c.push_back(SutureRow{{{-40, -40}, {-40, 0}}, {{-44, 0}, {-44, -40}}, 4});
  c.push_back(ReleaseHook{1});
  c.push_back(Undo{});
  c.push_back(Redo{});
  c.push_back(Wait{0.2});
  return c;
}

struct Performance {
  std::vector<Command> commands;
  std::vector<Sample> samples;
  std::vector<ToolEvent> events;
  std::vector<ToolState> states;
  std::vector<std::string> problems;
  FrontEndCounts counts;
  int dropped = 0;
  uint64_t hash = 0;
};

/// What has been excised is not skin any more.
void make_hole(Snapshot& s, const Command& c) {
  const auto* e = std::get_if<Excise>(&c);
  if (!e) return;
  Snapshot holed = snapshot_of(flat_topology(160, s.topology_version + 1, [&](double x, double y) {
    return inside_polygon(e->outline, {x, y});
  }));
  holed.hooks = s.hooks;
  s = std::move(holed);
}

Performance perform(std::unique_ptr<Source> source, Snapshot s, bool holes = false) {
  Performance r;
  DeviceFrontEnd front{Calibration{}};
  const auto* surgeon = dynamic_cast<EmulatedSurgeon*>(source.get());
  front.add(std::move(source));
  CommandBuilder builder;
  Events events;
  Samples samples;
  ToolState hand;
  Hash64 hash;
  size_t next = 0, hooks = 0;
  for (int64_t tick = 0; !front.done() && tick < 300'000; ++tick) {
    front.tick(tick, s, events, samples, hand);
    r.states.push_back(hand);
    for (; next < events.all.size(); ++next) {
      if (auto c = builder.feed(events.all[next])) {
        r.commands.push_back(*c);
        if (holes) make_hole(s, *c);
      }
      hash.add(events.all[next].chart_x);
      hash.add(events.all[next].chart_y);
    }
    for (double v : hand.tip_mm) hash.add(v);
    move_hooks(s, events.all, hooks, hand);
  }
  EXPECT_TRUE(front.done());
  r.samples = samples.all;
  r.events = events.all;
  r.counts = front.counts();
  r.dropped = builder.dropped();
  r.hash = hash.value();
  if (surgeon) r.problems = surgeon->problems();
  return r;
}

double furthest(const std::vector<ChartPoint>& a, const std::vector<ChartPoint>& b) {
  double worst = 0;
  for (const ChartPoint& p : a) {
    double nearest = 1e9;
    for (const ChartPoint& q : b) nearest = std::min(nearest, (p - q).norm());
    worst = std::max(worst, nearest);
  }
  return worst;
}

/// The script's commands against those that came out, in order; waits leave no
/// trace. Where the hand rests, the mean over one period of its tremor is taken, so
/// stitches and hooks are placed better (stitch_mm) than strokes are drawn (mm).
void expect_same(const std::vector<Command>& want, const std::vector<Command>& got, double mm,
                 double stitch_mm = 0.12) {
  size_t k = 0, moves = 0;
  for (const Command& w : want) {
    if (std::holds_alternative<Wait>(w)) continue;
    ASSERT_LT(k, got.size());
    // A hook that is set and let go leaves a move to where it was left, which the script's own move stands for.
    while (k < got.size() && std::holds_alternative<MoveHook>(got[k]) && !std::holds_alternative<MoveHook>(w)) ++k;
    ASSERT_LT(k, got.size());
    if (const auto* m = std::get_if<MoveHook>(&w)) {
      // A hook that was set and let go has told of that place first; and of moves in a row only the end is told.
      size_t j = k;
      auto is_it = [&](const Command& c) {
        const auto* n = std::get_if<MoveHook>(&c);
        return n && n->id == m->id && (n->to_mm - m->to_mm).norm() < mm;
      };
      while (j < got.size() && std::holds_alternative<MoveHook>(got[j]) && !is_it(got[j])) ++j;
      if (j < got.size() && is_it(got[j])) k = j + 1, ++moves;
      continue;
    }
    const Command& g = got[k];
    ASSERT_EQ(w.index(), g.index()) << k;
    ++k;
    if (const auto* e = std::get_if<Excise>(&w)) {
      const auto& f = std::get<Excise>(g);
      EXPECT_EQ(e->outline.size(), f.outline.size());
      EXPECT_LT(furthest(e->outline, f.outline), mm);
      EXPECT_EQ(e->depth_mm, f.depth_mm);
    } else if (const auto* u = std::get_if<Undermine>(&w)) {
      EXPECT_EQ(u->outline.size(), std::get<Undermine>(g).outline.size());
      EXPECT_LT(furthest(u->outline, std::get<Undermine>(g).outline), mm);
    } else if (const auto* i = std::get_if<Incise>(&w)) {
      const auto& f = std::get<Incise>(g);
      ASSERT_EQ(i->path.size(), f.path.size());
      for (size_t j = 0; j < i->path.size(); ++j) EXPECT_LT((i->path[j] - f.path[j]).norm(), mm);
      EXPECT_EQ(i->depth_mm, f.depth_mm);
      EXPECT_EQ(i->angle_deg, f.angle_deg);
    } else if (const auto* h = std::get_if<SetHook>(&w)) {
      EXPECT_EQ(h->id, std::get<SetHook>(g).id);
      EXPECT_LT((h->at - std::get<SetHook>(g).at).norm(), stitch_mm);
    } else if (const auto* s = std::get_if<Suture>(&w)) {
      EXPECT_LT((s->a - std::get<Suture>(g).a).norm(), stitch_mm);
      EXPECT_LT((s->b - std::get<Suture>(g).b).norm(), stitch_mm);
    } else if (const auto* row = std::get_if<SutureRow>(&w)) {
      const auto& f = std::get<SutureRow>(g);
      EXPECT_LT(furthest(row->a, f.a), mm);
      EXPECT_LT(furthest(row->b, f.b), mm);
      EXPECT_EQ(f.spacing_mm, row->spacing_mm);
      // Drawn the same way, or plainly the other way and then turned.
      const bool turned = (row->a.front() - row->b.front()).norm() > 4 * (row->a.front() - row->b.back()).norm();
      EXPECT_LT((f.b.front() - (turned ? row->b.back() : row->b.front())).norm(), mm);
    } else if (const auto* t = std::get_if<Stage>(&w)) {
      EXPECT_EQ(t->name, std::get<Stage>(g).name);
    } else if (const auto* q = std::get_if<ReleaseHook>(&w)) {
      EXPECT_EQ(q->id, std::get<ReleaseHook>(g).id);
    }
  }
  // The end of each row of moves of one hook; one of them may have been told before.
  size_t rows = 0;
  const MoveHook* last = nullptr;
  for (size_t i = want.size(); i-- > 0;) {
    const auto* m = std::get_if<MoveHook>(&want[i]);
    rows += m && !(last && last->id == m->id);
    last = m;
  }
  EXPECT_GE(moves + 1, rows);
  for (; k < got.size(); ++k) ADD_FAILURE() << "one too many, of kind " << got[k].index();
}

TEST(EmulatedSurgeon, TheScriptThatGoesInComesOut) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    SurgeonSettings set;
    set.seed = seed;
    const Performance r =
        perform(std::make_unique<EmulatedSurgeon>(operation(), set), snapshot_of(flat_topology(160, 1)));
    EXPECT_TRUE(r.problems.empty());
    EXPECT_EQ(r.dropped, 0);
    EXPECT_EQ(r.counts.missed_presses, 0);
    EXPECT_EQ(r.counts.tracking.jumps, 0);
    // Tremor 0.12 mm and noise 0.05 mm per axis; a corner and an end are one place of the hand, not a mean.
    expect_same(operation(), r.commands, 0.4);
  }
}

TEST(EmulatedSurgeon, TheShippedScriptsComeOut) {
  for (const char* name : {"rhomboid", "zplasty"}) {
    const Script script = load_script(source_dir() + "/recordings/" + name + ".jsonl");
    std::vector<Command> commands;
    for (const ScriptLine& line : script.lines) commands.push_back(line.command);
    const Performance r =
        perform(std::make_unique<EmulatedSurgeon>(commands), snapshot_of(flat_topology(160, 1)), true);
    EXPECT_TRUE(r.problems.empty()) << name << ": " << r.problems.front();
    EXPECT_EQ(r.dropped, 0) << name;
    EXPECT_EQ(r.counts.missed_presses, 0) << name;
    std::printf("  %s: %.1f s\n", name, double(r.states.size()) * 1e-3);
    // Outlines drawn as many-sided circles come back with other corners; everything else as it was.
    std::vector<Command> want = commands, got = r.commands;
    auto round = [](const Command& c) {
      const auto* u = std::get_if<Undermine>(&c);
      return u && u->outline.size() > 8;
    };
    std::erase_if(want, round);
    std::erase_if(got, round);
    EXPECT_EQ(commands.size() - want.size(), r.commands.size() - got.size());
    expect_same(want, got, 0.4);
  }
}

TEST(EmulatedSurgeon, AimsAtMaterialPointsWhereTheyAreNow) {
  // The skin is pulled, turned and bulged; the chart points must not notice.
  const Eigen::AngleAxisd turn(0.3, Vec3::UnitZ());
  auto map = [&](const Vec3& X) {
    return Vec3(turn * Vec3(1.1 * X.x(), 0.95 * X.y(), 4 * std::cos(X.x() / 25) * std::cos(X.y() / 30)) +
                Vec3(5, 0, -3));
  };
  std::vector<Command> script = operation();
  std::erase_if(script, [](const Command& c) { return std::holds_alternative<MoveHook>(c); });
  const Performance r = perform(std::make_unique<EmulatedSurgeon>(script), snapshot_of(flat_topology(160, 1), map));
  expect_same(script, r.commands, 0.45);
}

TEST(EmulatedSurgeon, CarriesHooksToTheirTargets) {
  const Performance r = perform(std::make_unique<EmulatedSurgeon>(operation()), snapshot_of(flat_topology(100, 1)));
  std::vector<MoveHook> moves;
  for (const Command& c : r.commands)
    if (const auto* m = std::get_if<MoveHook>(&c)) moves.push_back(*m);
  ASSERT_EQ(moves.size(), 2u);
  EXPECT_LT((moves[0].to_mm - Vec3(20, 5, 12)).norm(), 0.4);
  EXPECT_LT((moves[1].to_mm - Vec3(12, 0, 2)).norm(), 0.4);
  int held = 0, events_take = 0;
  for (const ToolState& s : r.states) held += s.held_hook == 1;
  for (const ToolEvent& e : r.events) events_take += e.kind == ToolEvent::hook_take;
  EXPECT_GT(held, 1000);
  EXPECT_EQ(events_take, 1);
}

TEST(EmulatedSurgeon, SameSeedSameStreamOtherSeedOther) {
  auto run = [](uint64_t seed) {
    SurgeonSettings set;
    set.seed = seed;
    return perform(std::make_unique<EmulatedSurgeon>(operation(), set), snapshot_of(flat_topology(60, 1)));
  };
  const Performance a = run(5), b = run(5), c = run(6);
  EXPECT_EQ(a.hash, b.hash);
  EXPECT_NE(a.hash, c.hash);
  ASSERT_EQ(a.samples.size(), b.samples.size());
}

TEST(EmulatedSurgeon, TheRecordedStreamGivesTheSameEvents) {
  const Performance live = perform(std::make_unique<EmulatedSurgeon>(operation()), snapshot_of(flat_topology(60, 1)));
  const Performance replay = perform(std::make_unique<LogSource>(live.samples), snapshot_of(flat_topology(60, 1)));
  ASSERT_EQ(live.events.size(), replay.events.size());
  for (size_t i = 0; i < live.events.size(); ++i) {
    EXPECT_EQ(live.events[i].tick, replay.events[i].tick);
    EXPECT_EQ(live.events[i].chart_x, replay.events[i].chart_x);
  }
}

TEST(EmulatedSurgeon, SamplesComeAtTheirRateWithGaps) {
  SurgeonSettings set;
  set.dropouts_per_s = 1;
  set.dropout_max_s = 0.09;
  const Performance r = perform(std::make_unique<EmulatedSurgeon>(operation(), set), snapshot_of(flat_topology(60, 1)));
  int64_t last = -1, gaps = 0, seq = -1;
  double fastest = 0;
  const StylusSample* before = nullptr;
  for (const Sample& s : r.samples) {
    const auto* p = std::get_if<StylusSample>(&s);
    if (!p) continue;
    EXPECT_EQ(p->seq, ++seq);
    if (last >= 0) {
      const double dt = double(p->t_ns - last) * 1e-9;
      EXPECT_GT(dt, 1 / 121.0);
      EXPECT_LT(dt, 0.09 + 2 / 120.0);
      if (dt > 1.5 / 120) ++gaps;
      fastest = std::max(fastest, (p->tip_mm - before->tip_mm).norm() / dt);
    }
    last = p->t_ns;
    before = p;
  }
  EXPECT_GT(gaps, 5);
  EXPECT_LT(fastest, 1000);                        // mm/s: carrying at a mean of 150, and noise
  expect_same(operation(), r.commands, 0.6, 0.3);  // gaps of up to 90 ms in what is averaged
}

TEST(EmulatedSurgeon, DrawsOnAcrossAHole) {
  auto hole = [](double x, double y) { return std::abs(x) < 5 && std::abs(y) < 5; };
  const std::vector<Command> script{Incise{{{-20, 0}, {20, 0}}, 4, 90}};
  const Performance r = perform(std::make_unique<EmulatedSurgeon>(script), snapshot_of(flat_topology(120, 1, hole)));
  ASSERT_EQ(r.commands.size(), 1u);
  const auto& path = std::get<Incise>(r.commands[0]).path;
  EXPECT_LT((path.front() - ChartPoint(-20, 0)).norm(), 0.4);
  EXPECT_LT((path.back() - ChartPoint(20, 0)).norm(), 0.4);
}

// A flap was cut along a bent edge and carried away. The chord between two bites in the other bank runs over where the
// flap's tip lay: the hand stays with its own bank.
TEST(EmulatedSurgeon, SewsAlongABentEdgeAndNotWhatLayBeyond) {
  const auto flap = [](double x, double y) { return y > 0.3 * std::abs(x) && y < 20; };
  auto t = flat_topology(120, 1);
  std::map<int32_t, int32_t> own;  // the flap's corners
  for (Tri& k : t->view.tri) {
    const Vec3 middle = (t->view.X_mm[size_t(k[0])] + t->view.X_mm[size_t(k[1])] + t->view.X_mm[size_t(k[2])]) / 3;
    if (!flap(middle.x(), middle.y())) continue;
    for (int32_t& v : k) {
      const auto [at, is_new] = own.try_emplace(v, int32_t(t->view.X_mm.size()));
      if (is_new) {
        const Vec3 X = t->view.X_mm[size_t(v)];
        t->view.X_mm.push_back(X);
      }
      v = at->second;
    }
  }
  Snapshot s = snapshot_of(t);
  for (const auto& [before, v] : own) s.x_mm[size_t(v)] += Vec3f(25, 30, 2);
  const std::vector<ChartPoint> edge{{-4, 0.7}, {4, 0.7}}, other{{-4, -6}, {4, -6}};
  const Performance r =
      perform(std::make_unique<EmulatedSurgeon>(std::vector<Command>{SutureRow{edge, other, 4}}), std::move(s));
  EXPECT_TRUE(r.problems.empty());
  ASSERT_EQ(r.commands.size(), 1u);
  const std::vector<ChartPoint>& sewn = std::get<SutureRow>(r.commands[0]).a;
  EXPECT_NEAR(sewn.front().x(), -4, 0.5);
  EXPECT_NEAR(sewn.back().x(), 4, 0.5);
  for (const ChartPoint& p : sewn) {
    EXPECT_LT(std::abs(p.x()), 4.5);
    EXPECT_NEAR(p.y(), 0.35, 0.9);  // from the edge's lowest place, 0, to the bites, and the tremor
  }
}

TEST(EmulatedSurgeon, SaysWhatItCannotReach) {
  const std::vector<Command> script{SetHook{1, {200, 0}}, MoveHook{3, Vec3(0, 0, 0), 1}, Suture{{0, 0}, {0, 99}},
                                    Stage{"end"}};
  EmulatedSurgeon surgeon(script);
  const Snapshot s = snapshot_of(flat_topology(20, 1));
  Samples samples;
  for (int64_t t = 0; t < 20'000 && !surgeon.done(); ++t) {
    surgeon.look(s);
    surgeon.poll(t * 1'000'000, samples);
  }
  EXPECT_TRUE(surgeon.done());
  EXPECT_EQ(surgeon.command(), surgeon.commands());
  EXPECT_EQ(surgeon.problems().size(), 3u);
}

TEST(EmulatedSurgeon, WaitsForAPatient) {
  EmulatedSurgeon surgeon(operation());
  Samples samples;
  Snapshot empty;
  for (int64_t t = 0; t < 1000; ++t) {
    surgeon.look(empty);
    surgeon.poll(t * 1'000'000, samples);
  }
  EXPECT_EQ(surgeon.command(), 0u);
  EXPECT_FALSE(surgeon.done());
}

}  // namespace test_emulator
}  // namespace limberg
