// From a key and a click in the window to a thread that is cut: the whole way, in one thread.
#include <gtest/gtest.h>

#include "app/assembly/assembly.h"
#include "app/program/places.h"
#include "app/window/input_router.h"
#include "app/window/pointer_source.h"

namespace limberg {
namespace test_scissors {

struct NoScreen final : Screen {
  std::unique_ptr<GlContext> context() override { return nullptr; }
};

TEST(Scissors, PointedAtAStitchCutItsThread) {
  Scene scene = load_scene(source_dir() + "/app/scenes/rhomboid.toml");
  scene.cell_mm = 8;
  Assembly a(scene, Calibration{}, {});
  ASSERT_TRUE(a.patient->apply(Incise{{{-14, 0}, {14, 0}}, 4, 90}).done);
  for (const double x : {-6.0, 6.0}) ASSERT_TRUE(a.patient->apply(Suture{{x, 1.5}, {x, -1.5}}).done);
  for (int i = 0; i < 60; ++i) a.patient->step({});
  Snapshot s;
  a.patient->fill(s);
  ASSERT_EQ(s.sutures.size(), 2u);

  NoScreen screen;
  HandFeed feed;
  InputRouter router(screen, feed);
  Camera camera;
  camera.eye_mm = {0, -60, 150}, camera.target_mm = {0, 0, 0};
  FrameSeen& frame = feed.seen.writing();
  frame.view = camera.view(16.0 / 9), frame.width = 1600, frame.height = 900;
  feed.seen.publish();
  a.front.add(std::make_unique<PointerSource>(feed));
  a.solver.start();
  const SutureState second = s.sutures[1];
  const Vec3f px = camera.view(16.0 / 9).to_pixel(0.5f * (second.a_mm + second.b_mm), 1600, 900);
  for (int64_t tick = 0; tick < 400; ++tick) {
    WindowEvent e;
    if (tick == 50) e.x = px.x(), e.y = px.y(), router.take(e);
    if (tick == 100) {
      e.kind = WindowEvent::key, e.code = '0', e.down = 1, router.take(e);
      e.kind = WindowEvent::button, e.code = 0, router.take(e);
      e.down = 0, router.take(e);
    }
    router.pump(tick * 1'000'000);
    a.device.tick(tick);
    if (tick % 16 == 0) a.solver.step(tick);
  }
  for (const Refusal& r : a.solver.refused()) ADD_FAILURE() << r.command << ": " << r.reason;
  ASSERT_FALSE(a.done.empty());
  EXPECT_TRUE(std::holds_alternative<CutSuture>(a.done.back()));
  a.patient->fill(s);
  ASSERT_EQ(s.sutures.size(), 1u);
  EXPECT_NE(s.sutures[0].id, second.id) << "the one that was pointed at is gone";
}

}  // namespace test_scissors
}  // namespace limberg
