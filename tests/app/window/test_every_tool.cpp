// Every tool by an emulated hand, from the script through gestures to the patient; and the bed that a swab shows.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "app/assembly/assembly.h"
#include "app/program/places.h"
#include "app/session/lockstep.h"
#include "app/session/workers_pool.h"
#include "devices/emulator.h"
#include "render/render_scene.h"
#include "sim/commands/kinds.h"
#include "sim/commands/script.h"

namespace limberg {
namespace test_every_tool {

Scene coarse() {
  Scene scene = load_scene(source_dir() + "/app/scenes/rhomboid.toml");
  scene.cell_mm = 8;
  return scene;
}

const std::vector<Command>& script() {
  static const std::vector<Command> all{Mark{{{-30, 15}, {-10, 15}}, false},
                                        Incise{{{-26, 0}, {26, 0}}, 4, 90},
                                        SetHook{1, {4, -4}},
                                        MoveHook{1, {4, -10, 4}, 0.6},
                                        ReleaseHook{1},
                                        Suture{{-12, 1.2}, {-12, -1.2}, 1},
                                        SutureCorner{{0, -1.2}, {-4, 1.2}, {4, 1.2}, 1},
                                        SutureRow{{{8, 1.2}, {14, 1.2}}, {{8, -1.2}, {14, -1.2}}, 3, 0, true},
                                        SutureBite{{-23, 2}, {-23, -2}},
                                        SutureBite{{-20, 2}, {-20, -2}},
                                        Undo{},
                                        SutureBite{{-19, 2}, {-19, -2}},
                                        SutureBite{{-16, 2}, {-16, -2}},
                                        LetThreadGo{},
                                        TieSuture{},
                                        SutureRow{{{18, 1.2}, {23, 1.2}}, {{18, -1.2}, {23, -1.2}}, 2.5, 1},
                                        CutSuture{{1, {}}},
                                        Mark{{{-20, 15}}, true}};
  return all;
}

/// A flap is raised, and its underside is stitched to its bed.
const std::vector<Command>& deep_script() {
  static const std::vector<Command> all{Incise{{{-16, -10}, {16, -10}}, 4, 90},
                                        Undermine{{{-14, -10}, {14, -10}, {14, 6}, {-14, 6}}, 4}, SetHook{1, {0, -7}},
                                        MoveHook{1, {0, -2, 12}, 0.6},
                                        InSpace{Suture{{0, -4}, {0, -4}, 0, HeldSide::under, HeldSide::bed}, {-4, -4}}};
  return all;
}

struct Session {
  Scene scene = coarse();
  Assembly a;
  uint64_t hash = 0;
  explicit Session(const std::vector<Command>& acts = script()) : a(scene, Calibration{}, {}) {
    SurgeonSettings hand;
    hand.dropouts_per_s = 0;
    auto surgeon = std::make_unique<EmulatedSurgeon>(acts, hand);
    const EmulatedSurgeon& s = *surgeon;
    a.front.add(std::move(surgeon));
    SessionSettings settings = a.session_settings();
    settings.settle_steps = 0;
    run_lockstep(a.lanes(nullptr), settings);
    for (const std::string& p : s.problems()) ADD_FAILURE() << p;
    for (const Refusal& r : a.solver.refused()) ADD_FAILURE() << r.command << ": " << r.reason;
    hash = a.solver.state_hash();
  }
};

TEST(EveryTool, IsCarriedOutByAHandAndComesToTheSameState) {
  Session one;
  std::vector<std::string> done, wanted;
  for (const Command& c : one.a.done) done.push_back(action_name(c));
  for (const Command& c : script()) wanted.push_back(action_name(c));
  EXPECT_EQ(done, wanted);
  bool buried = false, running = false, buried_row = false;
  std::vector<double> bites;
  for (const Command& c : one.a.done) {
    if (const auto* b = std::get_if<SutureBite>(&c)) bites.push_back(b->a.x());
    if (const auto* r = std::get_if<SutureRow>(&c)) buried_row |= r->depth_mm == 1 && !r->running;
    if (const auto* s = std::get_if<Suture>(&c)) buried |= s->depth_mm == 1;
    if (const auto* r = std::get_if<SutureRow>(&c)) running |= r->running;
  }
  EXPECT_TRUE(buried);
  EXPECT_TRUE(running);
  EXPECT_TRUE(buried_row);
  // Each bite lies where the hand set it: nothing is spread evenly.
  ASSERT_EQ(bites.size(), 4u);
  const double meant[] = {-23, -20, -19, -16};
  for (size_t i = 0; i < 4; ++i) EXPECT_NEAR(bites[i], meant[i], 0.5) << i;
  Snapshot s;
  one.a.patient->fill(s);
  EXPECT_TRUE(s.hooks.empty()) << "it was taken out by hand";
  EXPECT_EQ(s.sewn.thread, 0) << "the knot ends the thread";
  std::map<int32_t, int> of_thread;
  for (const SutureState& k : s.sutures) ++of_thread[k.thread];
  EXPECT_TRUE(std::any_of(of_thread.begin(), of_thread.end(), [](const auto& t) {
    return t.first > 0 && t.second == 3;
  })) << "three bites are left of the thread, the second was taken back";
  Session two;
  EXPECT_EQ(one.hash, two.hash);
}

TEST(EveryTool, ADeepStitchJoinsAFlapsUndersideToItsBed) {
  Session one(deep_script());
  ASSERT_EQ(one.a.done.size(), deep_script().size());
  const auto* deep = std::get_if<InSpace>(&one.a.done.back());
  ASSERT_NE(deep, nullptr);
  const auto& s = std::get<Suture>(deep->act);
  EXPECT_EQ(s.side_a, HeldSide::under);
  EXPECT_EQ(s.side_b, HeldSide::bed);
  for (const Vec3& p : places_of(*deep)) EXPECT_LT((p - Vec3(0, -4, -4)).norm(), 2) << p.transpose();
  // As a script it comes to the same act.
  const Command again = parse_command(to_json_line(one.a.done.back()), "a script", 1);
  EXPECT_EQ(to_json_line(again), to_json_line(one.a.done.back()));
  Session two(deep_script());
  EXPECT_EQ(one.hash, two.hash);
}

TEST(Swab, ShowsTheBedOfAFlapAndNothingElseGoes) {
  const Scene scene = coarse();
  Assembly a(scene, Calibration{}, {});
  ASSERT_TRUE(a.patient->apply(Incise{{{-16, -10}, {16, -10}}, 4, 90}).done);
  Snapshot s;
  a.patient->fill(s);
  const TissueMesh cut = make_tissue_mesh(*s.topology);
  EXPECT_EQ(without_flaps(cut, *s.topology).tri.size(), cut.tri.size()) << "nothing was raised";
  ASSERT_TRUE(a.patient->apply(Undermine{{{-14, -10}, {14, -10}, {14, 6}, {-14, 6}}, 4}).done);
  a.patient->fill(s);
  const TissueMesh whole = make_tissue_mesh(*s.topology), bared = without_flaps(whole, *s.topology);
  const SurfaceView& view = s.topology->view;
  double gone_mm2 = 0, bed_mm2 = 0;
  const std::set<int32_t> left(bared.tri_source.begin(), bared.tri_source.end());
  for (size_t t = 0; t < view.tri.size(); ++t) {
    const Tri& k = view.tri[t];
    const Vec3 &p = view.X_mm[size_t(k[0])], &q = view.X_mm[size_t(k[1])], &r = view.X_mm[size_t(k[2])];
    const Vec3 n = 0.5 * (q - p).cross(r - p), middle = (p + q + r) / 3;
    const bool stays = left.count(int32_t(t)) > 0;
    if (view.kind[t] == FaceKind::skin && !stays) {
      gone_mm2 += n.norm();
      const ChartPoint c = s.topology->to_chart(middle);
      EXPECT_TRUE(std::abs(c.x()) < 15 && c.y() > -11 && c.y() < 7) << c.transpose();
    }
    if (view.kind[t] == FaceKind::wall && stays && n.z() > 0.7 * n.norm()) bed_mm2 += n.norm();
    if (view.kind[t] != FaceKind::skin && view.kind[t] != FaceKind::wall) EXPECT_TRUE(stays);
  }
  EXPECT_NEAR(gone_mm2, 28 * 16, 0.2 * 28 * 16);
  EXPECT_NEAR(bed_mm2, 28 * 16, 0.08 * 28 * 16);
}

}  // namespace test_every_tool
}  // namespace limberg
