// A session with a headset as a user calls it, under the runtime of the tests: controller and hand operate, are
// recorded, and the replay without a headset ends in the same bits; the core validation layer has nothing to say; a
// headset that goes away takes nothing with it.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <nlohmann/json.hpp>
#include <set>

#include "app/assembly/streams.h"
#include "app/headset/headset_source.h"
#include "devices/recording.h"
#include "tests/app/cli.h"
#include "tests/app/headset/headset_world.h"
#include "tests/app/headset/x_server.h"

namespace test_headset_run {

using limberg::ControlSample, limberg::read_recording, limberg::Sample, limberg::StationRole, limberg::TrackerSample,
    limberg::Vec3;
using limberg::testing::HeadsetWorld, limberg::testing::XServer;

class HeadsetRun : public Cli {
 protected:
  nlohmann::json json(const std::string& name) const { return nlohmann::json::parse(slurp(path(name))); }
  std::string scene() const { return file("small.toml", small_scene()); }

  /// With a display, or none.
  Outcome call(const std::string& arguments, const std::string& display = "", const std::string& more = "") const {
    const std::string out = path(".out"), err = path(".err");
    const int s =
        std::system(("env -u WAYLAND_DISPLAY " + (display.empty() ? "-u DISPLAY " : "DISPLAY=" + display + " ") + more +
                     " " + kProgram + " " + arguments + " >" + out + " 2>" + err + " </dev/null")
                        .c_str());
    Outcome o;
    o.status = WIFEXITED(s) ? WEXITSTATUS(s) : 1000 + WTERMSIG(s);
    o.out = slurp(out), o.err = slurp(err);
    return o;
  }

  /// A stream that chooses the scalpel.
  std::string scalpel() const {
    const std::string log = path("scalpel.lcm");
    ControlSample c;
    c.device_id = 900, c.t_ns = 1'000'000, c.kind = ControlSample::select_tool, c.tool = limberg::Tool::scalpel;
    c.value[limberg::kDepth] = 4, c.value[limberg::kAngle] = 90;
    limberg::write_stream(log, {c}, true);
    return log;
  }
};

TEST_F(HeadsetRun, AnOptionThatMeansNothingIsRefused) {
  expect_refused("run rhomboid --headless --device headset:scale=99", {"scale=0.2 to 20"});
  expect_refused("run rhomboid --headless --device headset --device headset:left", {"one headset"});
}

#ifndef LIMBERG_OPENXR_RUNTIME

TEST_F(HeadsetRun, WithoutOpenXrTheSessionGoesOn) {
  const Outcome o = call("run " + scene() + " --headless --device headset --seconds 1");
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_NE(o.err.find("no headset: "), std::string::npos) << o.err;
}

#else

/// Of a session that ended by Ctrl-C, as the runtime's script has it; 3: the verdict on so rough an operation.
bool ended_well(const Outcome& o) { return o.status == 0 || o.status == 3; }

/// Keys of hands in the patient's mm, as the runtime's script has them in the room.
class Hands {
 public:
  std::string text = "views 160 144\nperiod_ms 20\nkeep last\nhead 0  0 1.6 0  0.9538 -0.3007 0 0\n";
  Hands() {
    head_.at_m = {0, 1.6, 0};
    head_.turned = Eigen::Quaterniond(0.9538, -0.3007, 0, 0);
    limberg::Camera c;  // the block's scene has the usual one
    c.eye_mm = {0, -180, 240}, c.target_mm = Vec3::Zero().cast<float>();
    place_ = limberg::PatientPlace::before(head_, true, c, {});
  }
  void controller(double t, const Vec3& tip_mm, bool press, const char* hand = "right") {
    key(hand, t, place_.to_room(tip_mm) + Vec3(0, 0.05, 0), press ? "1 0 0" : "0 0 0");
  }
  /// From the controller's usual place; shares of the tablet's width and height.
  void points_at_tablet(double t, double u, double v, bool press) {
    const limberg::BoardPlace b = limberg::tablet_place(place_, head_, 1280. / 720);
    const Vec3 on =
        place_.to_room((b.centre_mm + float(2 * u - 1) * b.right_mm + float(1 - 2 * v) * b.up_mm).cast<double>());
    const Vec3 at = place_.at_m() + Vec3(0.1, 0.15, 0.15);
    const Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(-Vec3::UnitZ(), on - at);
    std::ostringstream s;
    s << "right " << t << "  " << at.x() << " " << at.y() << " " << at.z() << "  " << q.w() << " " << q.x() << " "
      << q.y() << " " << q.z() << "  " << (press ? "1 0 0" : "0 0 0") << "\n";
    text += s.str();
  }
  void glove(double t, const Vec3& finger_mm, double aperture_m) {
    key("left_hand", t, place_.to_room(finger_mm), std::to_string(aperture_m));
  }

 private:
  void key(const char* what, double t, const Vec3& at, const std::string& rest) {
    std::ostringstream s;
    s << what << " " << t << "  " << at.x() << " " << at.y() << " " << at.z() << "  0.7071068 -0.7071068 0 0  " << rest
      << "\n";  // looks straight down
    text += s.str();
  }
  limberg::RoomPose head_;
  limberg::PatientPlace place_;
};

/// The scalpel draws 16 mm of skin from left to right; the glove takes skin beside it and lifts it 6 mm.
std::string operation(double from_s) {
  Hands h;
  h.controller(0, {-8, -8, 20}, false), h.controller(from_s, {-8, -8, 20}, false);
  h.controller(from_s + 0.5, {-8, -8, 0}, false), h.controller(from_s + 0.6, {-8, -8, -1}, true);
  h.controller(from_s + 1.6, {8, -8, -1}, true), h.controller(from_s + 1.7, {8, -8, 0}, false);
  h.controller(from_s + 2.2, {8, -8, 30}, false);
  h.glove(0, {4, 8, 25}, 0.07), h.glove(from_s, {4, 8, 25}, 0.07), h.glove(from_s + 0.5, {4, 8, 25}, 0.005);
  h.glove(from_s + 1, {4, 8, 25}, 0.005), h.glove(from_s + 1.5, {4, 8, 31}, 0.005);
  return h.text;
}

int count(const std::vector<Sample>& samples, StationRole role, bool pressed = false) {
  return int(std::count_if(samples.begin(), samples.end(), [&](const Sample& s) {
    const auto* t = std::get_if<TrackerSample>(&s);
    return t && t->role == role && (!pressed || t->buttons & 1);
  }));
}

TEST_F(HeadsetRun, ControllerAndHandOperateAndReplayWithoutAHeadset) {
  HeadsetWorld world(operation(1) + "end_s 4\n");
  const std::string log = path("a.lcm");
  Outcome o = call("run " + scene() + " --headless --device headset --device log:" + scalpel() +
                   " --seconds 90 --record " + log + " --json " + path("a.json"));
  ASSERT_TRUE(ended_well(o)) << o.status << o.err;
  const auto made = json("a.json");
  const std::vector<Sample> samples = read_recording(log).samples;
  EXPECT_GT(count(samples, StationRole::stylus), 500);  // 250 a second, where a machine keeps up
  EXPECT_GT(count(samples, StationRole::stylus, true), 100);
  EXPECT_GT(count(samples, StationRole::forefinger), 500);
  EXPECT_EQ(count(samples, StationRole::forefinger), count(samples, StationRole::thumb));
  EXPECT_NEAR(double(made["metrics"]["scar_length_mm"]), 16, 1) << o.out;  // what the hand drew, twice as large
  EXPECT_EQ(int(made["exercise"]["hooks"]), 1) << o.out;                   // and what the glove holds
  EXPECT_GT(double(made["metrics"]["dog_ear_mm"]), 1) << o.out;
  EXPECT_GT(world.count("layers 1"), 10);
  // Without a headset, a runtime, or their names.
  for (const char* name : {"XR_RUNTIME_JSON", "LIMBERG_TEST_XR"}) unsetenv(name);
  o = call("replay " + log + " --json " + path("r.json"));
  ASSERT_TRUE(ended_well(o)) << o.status << o.err;
  const auto again = json("r.json");
  EXPECT_EQ(again["state_hash"], made["state_hash"]);
  EXPECT_EQ(again["checkpoints"]["compared"], again["checkpoints"]["equal"]);
  EXPECT_GT(int(again["checkpoints"]["compared"]), 5);
}

// GLX: version 1.0.20 of the layer (Debian 12) does not know the structure of a context without an X server.
TEST_F(HeadsetRun, TheValidationLayerHasNothingToSay) {
  const std::string layer = "XR_APILAYER_LUNARG_core_validation";
  if (!fs::exists("/usr/share/openxr/1/api_layers/explicit.d/XrApiLayer_core_validation.x86_64-linux-gnu.json"))
    GTEST_SKIP() << "no core validation layer (Debian: openxr-layer-corevalidation)";
  XServer x;
  if (x.display.empty()) GTEST_SKIP() << "no Xvfb (Debian: xvfb)";
  HeadsetWorld world(operation(0.5) + "no XR_MNDX_egl_enable\nend_s 3\n");
  const std::string report = path("validation.txt");
  const Outcome o = call("run " + scene() + " --headless --device headset --seconds 90", x.display,
                         "XR_ENABLE_API_LAYERS=" + layer + " XR_CORE_VALIDATION_EXPORT_TYPE=text" +
                             " XR_CORE_VALIDATION_FILE_NAME=" + report);
  ASSERT_TRUE(ended_well(o)) << o.status << o.err;
  EXPECT_NE((o.out + o.err).find("Core Validation output type: text"), std::string::npos) << o.out << o.err;
  EXPECT_EQ(world.count("session GLX"), 1) << world.log() << o.err;
  EXPECT_GT(world.count("layers 1"), 10);
  EXPECT_EQ(world.count("instance destroyed"), 1);
  EXPECT_EQ(slurp(report), "");  // written when there is something to complain of
  EXPECT_EQ(o.err.find("VALID_"), std::string::npos) << o.err;
}

TEST_F(HeadsetRun, AHeadsetThatGoesAwayTakesNothingWithIt) {
  for (const std::string how : {"at 20 lose", "at 20 lose_instance", "at 20 exit"}) {
    HeadsetWorld world(operation(0) + how + "\nend_s 0.2 2\n");
    const Outcome o = call("run " + scene() + " --headless --device headset --seconds 90 --json " + path("l.json"));
    EXPECT_TRUE(ended_well(o)) << how << o.status << o.err;
    EXPECT_NE(o.err.find(how == "at 20 exit" ? "ended the session" : "the headset is gone"), std::string::npos)
        << how << ": " << o.err;
    EXPECT_NE(o.err.find("it is looked for again"), std::string::npos) << o.err;
    EXPECT_GT(double(json("l.json")["duration_s"]), 3);
    EXPECT_EQ(world.count("session EGL"), 2) << how << world.log();  // and found again
    EXPECT_EQ(world.count("with a session left"), 0) << how;
  }
}

// The window is the tablet: a controller that points down the column of tools and presses here and there chooses some,
// and none of these presses reaches the patient.
TEST_F(HeadsetRun, ToolsAreChosenOnTheTablet) {
  XServer x;
  if (x.display.empty()) GTEST_SKIP() << "no Xvfb (Debian: xvfb)";
  Hands h;
  for (int k = 0; k < 10; ++k) {
    const double t = k == 0 ? 0 : 2 + 0.5 * k;
    h.points_at_tablet(t, 0.04, 0.06 + 0.03 * k, false);
    h.points_at_tablet(2.2 + 0.5 * k, 0.04, 0.06 + 0.03 * k, true);
    h.points_at_tablet(2.3 + 0.5 * k, 0.04, 0.06 + 0.03 * k, false);
  }
  HeadsetWorld world(h.text + "no XR_MNDX_egl_enable\nend_s 8\n");
  const std::string log = path("t.lcm");
  const Outcome o = call("run " + scene() + " --device headset --seconds 90 --workers 1 --record " + log, x.display);
  ASSERT_TRUE(ended_well(o)) << o.status << o.err;
  EXPECT_EQ(world.count("session GLX"), 1) << o.err;
  std::set<limberg::Tool> chosen;
  const std::vector<Sample> samples = read_recording(log).samples;
  for (const Sample& s : samples)
    if (const auto* c = std::get_if<ControlSample>(&s); c && c->kind == ControlSample::select_tool)
      chosen.insert(c->tool);
  EXPECT_GE(chosen.size(), 3u) << o.err;
  EXPECT_GT(count(samples, StationRole::stylus), 500);
  EXPECT_EQ(count(samples, StationRole::stylus, true), 0);
}

TEST_F(HeadsetRun, ItsControllersAreListed) {
  HeadsetWorld world(operation(0) + "end_s 2\n");
  const Outcome o = call("devices --device headset --seconds 90");
  EXPECT_TRUE(ended_well(o)) << o.status << o.err;
  EXPECT_NE(o.out.find("stylus"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("forefinger"), std::string::npos) << o.out;
  EXPECT_GT(world.count("layers 0"), 10);  // nothing is drawn
}

#endif

}  // namespace test_headset_run
