// A hand that errs with the saw, on a ball of bone: what the coach says while it saws, and after it has sawn.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "app/assembly/assembly.h"
#include "app/program/temporary_folder.h"
#include "app/session/lockstep.h"
#include "app/teaching/coach.h"
#include "devices/head_surgeon.h"
#include "sim/skull/simplex/file.h"
#include "sim/skull/simplex/generators.h"
#include "sim/skull/simplex/mesh.h"
#include "tests/sim/skull/needs_bullet.h"

namespace limberg {
namespace test_erring_saw {

constexpr double kBall_mm = 40;

/// A ring on the ball, so many mm before its middle.
CutBone ring(double y_mm) {
  CutBone cut;
  const double r = std::sqrt(kBall_mm * kBall_mm - y_mm * y_mm);
  for (int i = 0; i < 48; ++i)
    cut.contour_mm.emplace_back(r * std::cos(i * M_PI / 24), y_mm, r * std::sin(i * M_PI / 24));
  return cut;
}

/// Hears and looks, and draws nothing.
struct Listener final : PictureSink {
  Coach coach;
  double most_beside = 0;  // of the live row, in shares of what may be off
  explicit Listener(LessonPlan plan) : coach(std::move(plan)) {}
  void prepare(const SurfaceTopology&) override {}
  void notice(const Notice& n) override { coach.hear(n); }
  void missed(const MissedPress& m, const Snapshot& s) override { coach.missed(m, s); }
  bool wants_frame() override { return true; }
  void stage(const std::string&, const Snapshot&) override {}
  void finish() override {}
  void frame(const Snapshot& s, const ToolState& t) override {
    HandSeen seen;
    seen.tool = t;
    coach.look(s, seen);
    for (const LiveRow& r : coach.says().stroke)
      if (t.pressed && r.name == "saw") most_beside = std::max(most_beside, r.share);
  }
};

TEST(ErringSaw, IsToldWhileItSawsAndAfterwards) {
  LIMBERG_NEEDS_BULLET();
  const TemporaryFolder folder;
  simplex::Mesh ball = simplex::make_sphere({0, 0, 0}, kBall_mm, 3), anvil = simplex::make_sphere({0, 0, -200}, 20, 2);
  for (simplex::Mesh* m : {&ball, &anvil}) simplex::record_shape(*m);
  simplex::save_mesh(ball, folder.path() / "ball.txt"), simplex::save_mesh(anvil, folder.path() / "anvil.txt");
  const std::string file = (folder.path() / "ball.toml").string();
  std::ofstream(file) << "name = \"ball\"\n[head]\nsource = \"files\"\nbones = [\"anvil.txt\", \"ball.txt\"]\n";
  const Scene scene = load_scene(file);

  const Command planned = HeadCommand(ring(30));
  Listener listener(make_lesson_plan(nullptr, std::vector<Command>{planned, Stage{"sawn"}}));
  AssemblyOptions o;
  o.workers = 1, o.sink = &listener, o.draw_frames = true;
  Assembly a(scene, Calibration{}, o);
  SurgeonSettings steady;
  steady.noise_mm = steady.noise_rad = steady.tremor_mm = 0, steady.dropouts_per_s = 0;
  a.front.add(std::make_unique<EmulatedHeadSurgeon>(std::vector<Command>{HeadCommand(ring(21)), Undo{}, planned},
                                                    steady, HeadHands::stylus));
  SessionSettings s = a.session_settings();
  s.ticks_per_frame = 33, s.settle_steps = 0;
  run_lockstep(a.lanes(nullptr), s);

  std::string all;
  for (const Coach::Said& w : listener.coach.said()) all += w.word + "\n";
  // 9 mm behind, on a ball whose ring there is wider: the nearest place of the line is 11.7 mm away.
  size_t from = 0;
  for (const char* words : {"The saw is 12 mm behind the line that is drawn: lead it forwards",
                            "mm beside the line on the bone", "Ctrl+Z takes it back", "As planned"}) {
    const size_t at = all.find(words, from);
    EXPECT_NE(at, std::string::npos) << words << "\nsaid:\n" << all;
    if (at != std::string::npos) from = at;
  }
  EXPECT_EQ(all.find("The saw is", all.find("The saw is") + 1), std::string::npos)
      << "once a stroke, and not of the good one";
  EXPECT_GT(listener.most_beside, 2.5);
  EXPECT_TRUE(listener.coach.says().finished);
}

}  // namespace test_erring_saw
}  // namespace limberg
