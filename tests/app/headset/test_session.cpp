// A session with a headset under the runtime of the tests: both eyes' pictures are those of the off-screen renderer,
// the poses handed in are those given out, and every way of failing ends in words.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "app/headset/eyes.h"
#include "app/headset/session.h"
#include "app/pictures/pictures.h"
#include "render/gl_context.h"
#include "render/image_compare.h"
#include "tests/app/headset/headset_world.h"
#include "tests/render/sample_snapshot.h"

namespace limberg {
namespace test_headset_session {

using testing::HeadsetWorld;

#ifndef LIMBERG_OPENXR_RUNTIME

TEST(HeadsetSession, WithoutItsPartItSaysSo) {
  try {
    open_headset([](NativeContext::Kind) { return NativeContext{}; });
    FAIL() << "a headset where there can be none";
  } catch (const RenderUnavailable& e) {
    EXPECT_NE(std::string(e.what()).find("libopenxr"), std::string::npos) << e.what();
  }
}

#else

struct Open {
  std::unique_ptr<GlContext> context;
  std::unique_ptr<HeadsetSession> session;
  std::vector<NativeContext::Kind> asked;
  Open() {
    session = open_headset([this](NativeContext::Kind kind) {
      asked.push_back(kind);
      context = kind == NativeContext::egl ? make_egl_context() : make_glx_context();
      context->make_current();
      return context->native();
    });
  }
};

std::string refusal() {
  try {
    Open open;
    return "";
  } catch (const RenderUnavailable& e) {
    return e.what();
  }
}

/// The test's patient, as the session's threads would have it.
struct Patient {
  Channels channels;
  HeadsetShared shared;
  Patient() {
    testing::SampleOptions o;
    Snapshot s = testing::sample_snapshot(o);
    channels.patient_to_headset.writing().snapshot = s;
    channels.patient_to_headset.publish();
    HandState& hand = channels.hand_to_headset.writing();
    hand.tool.valid = 1, hand.tool.tool = int32_t(Tool::scalpel);
    hand.tool.tip_mm[0] = 8, hand.tool.tip_mm[1] = 12, hand.tool.tip_mm[2] = 1;
    hand.tool.shaft[0] = 0.3, hand.tool.shaft[1] = -0.4, hand.tool.shaft[2] = 0.87;
    channels.hand_to_headset.publish();
    channels.patient_to_headset.update(), channels.hand_to_headset.update();
    shared.channels = &channels;
    shared.camera.eye_mm = {0, -120, 130}, shared.camera.target_mm = {0, 0, 0};
  }
};

const std::string kStill =
    "views 320 288\nperiod_ms 11\nfast\nkeep 2\nhead 0  0.1 1.55 0.2  0.8995 -0.2908 0.3129 0.0972\n";

constexpr int kLevel = 3;

/// What those eyes see, drawn without a headset.
std::array<Image, 2> off_screen(const Patient& p, const HeadsetFrame& frame, bool floor,
                                std::unique_ptr<GlContext> context) {
  const PatientPlace place = PatientPlace::before(frame.head, floor, p.shared.camera, {});
  SceneBuilder builder;
  const RenderScene& scene = builder.build(p.channels.patient_to_headset.reading().snapshot,
                                           tool_pose(p.channels.hand_to_headset.reading().tool));
  builder.add_props(room_props(place, scene.bounds_min, scene.bounds_max, floor_below_m(place, floor)));
  const std::array<View, 2> views = views_of(frame, place);
  Renderer renderer(std::move(context));
  std::array<Image, 2> out;
  for (size_t e = 0; e < 2; ++e) out[e] = renderer.draw(scene, views[e], eye_options(kQualityLevels[kLevel], 320, 288));
  return out;
}

/// Keeps the frame that it passes on.
struct Watched final : HeadsetPainter {
  HeadsetPainter& eyes;
  std::optional<HeadsetFrame> frame;
  explicit Watched(HeadsetPainter& e) : eyes(e) {}
  bool begin(const HeadsetFrame& f) override {
    frame = f;
    return eyes.begin(f);
  }
  void eye(int which, unsigned texture, int width, int height) override { eyes.eye(which, texture, width, height); }
};

/// So many frames, drawn; the session is over afterwards.
HeadsetFrame draw_frames(Open open, Patient& p, int frames, bool& floor) {
  floor = open.session->facts().floor;
  SharedPlace place;
  EyesSettings set;
  set.level = kLevel;
  Eyes eyes(std::move(open.context), p.shared, place, set, floor);
  Watched watched(eyes);
  const std::unique_ptr<HeadsetSession> session = std::move(open.session);
  for (int n = 0, idle = 0; n < frames && idle < 100;)
    session->step(watched) == HeadsetSession::Step::frame ? ++n : ++idle;
  return watched.frame.value_or(HeadsetFrame{});
}

TEST(HeadsetSession, BothEyesAreAsTheOffScreenRendererDrawsThem) {
  for (const std::string more : {"", "no stage\n"}) {
    HeadsetWorld world(kStill + more);
    Patient p;
    bool floor = false;
    const HeadsetFrame frame = draw_frames({}, p, 3, floor);
    EXPECT_EQ(floor, more.empty());
    EXPECT_EQ(world.count("session EGL"), 1) << world.log();
    EXPECT_EQ(world.count("format 35907"), 2);  // SRGB8_ALPHA8: the bytes are sRGB
    EXPECT_NEAR((frame.eye[1].pose.at_m - frame.eye[0].pose.at_m).norm(), 0.063, 1e-4);
    const std::array<Image, 2> wanted = off_screen(p, frame, floor, make_egl_context());
    for (size_t e = 0; e < 2; ++e) {
      const Image given = world.picture(std::string("frame-2-") + (e == 0 ? "left" : "right") + ".ppm");
      ASSERT_EQ(given.width, 320) << world.log();
      EXPECT_EQ(given, wanted[e]) << "eye " << e << " differs by " << block_mean_difference(given, wanted[e]);
    }
    EXPECT_GT(block_mean_difference(wanted[0], wanted[1]), 10);  // each eye has its own
    EXPECT_EQ(world.count("session destroyed after 3 frames"), 1);
    EXPECT_EQ(world.count("with a session left"), 0);
  }
}

TEST(HeadsetSession, WhatIsMissingIsSaid) {
  const auto says = [](const std::string& script, const char* words) {
    HeadsetWorld world("fast\n" + script + "\n");
    const std::string why = refusal();
    EXPECT_NE(why.find(words), std::string::npos) << script << ": " << why;
    EXPECT_EQ(world.count("with a session left"), 0);
  };
  says("no headset", "no head-mounted display");
  says("no XR_KHR_opengl_enable", "XR_KHR_opengl_enable");
  says("fail xrCreateInstance", "runtime does not start");
  says("fail xrCreateSession", "refuses a session");
  says("fail xrCreateSwapchain", "no pictures can be handed over");
  HeadsetWorld world("");
  setenv("XR_RUNTIME_JSON", "/nonexistent/runtime.json", 1);
  EXPECT_NE(refusal().find("XR_RUNTIME_JSON"), std::string::npos);
  EXPECT_EQ(headset_runtime_file(), "");
}

TEST(HeadsetSession, ALostSessionIsSaidAndNothingIsLeft) {
  for (const char* how :
       {"at 2 lose", "at 2 lose_instance", "fail xrEndFrame", "fail xrWaitFrame", "fail xrBeginSession"}) {
    HeadsetWorld world(std::string(kStill) + how + "\n");
    Patient p;
    bool floor = false;
    try {
      draw_frames({}, p, 10, floor);
      FAIL() << how;
    } catch (const RenderUnavailable& e) {
      EXPECT_NE(std::string(e.what()).find("headset"), std::string::npos) << how << ": " << e.what();
    }
    EXPECT_EQ(world.count("session destroyed"), 1) << how;
    EXPECT_EQ(world.count("with a session left"), 0) << how;
  }
}

TEST(HeadsetSession, TheRuntimeMayEndIt) {
  HeadsetWorld world(std::string(kStill) + "at 1 exit\n");
  Patient p;
  bool floor = false;
  draw_frames({}, p, 10, floor);
  EXPECT_EQ(world.count("session destroyed after 2 frames"), 1) << world.log();
}

TEST(HeadsetSession, WithoutAPatientNothingIsHandedIn) {
  HeadsetWorld world(kStill);
  Patient p;
  p.shared.channels = nullptr;
  bool floor = false;
  draw_frames({}, p, 3, floor);
  EXPECT_EQ(world.count("layers 0"), 3) << world.log();
}

#endif

}  // namespace test_headset_session
}  // namespace limberg
