// A session as `limberg run` drives it, with a window that is none: what it leaves when it ends, and when it fails.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/commands/session_command.h"
#include "app/program/places.h"
#include "app/session/clock.h"
#include "sim/base/error.h"

namespace limberg {
namespace test_session_command {

namespace fs = std::filesystem;

/// A stylus above the skin that fails after a while; -1: never.
struct Stylus final : Source {
  int64_t fails_at_ns, seq = 0;
  explicit Stylus(int64_t fails_at) : fails_at_ns(fails_at) {}
  void poll(int64_t now_ns, SampleSink& sink) override {
    if (fails_at_ns >= 0 && now_ns > fails_at_ns) throw std::runtime_error("broken device");
    StylusSample s;
    s.device_id = 7, s.seq = seq++, s.t_ns = now_ns, s.tip_mm = Vec3(0, 0, 40);
    sink.on_sample(s);
  }
  bool done() const override { return false; }
  SourceCounts counts() const override { return {seq, 0, 0}; }
};

struct NoWindow : SessionWindow, PictureSink {
  int64_t fails_at_ns = -1, closes_at_ns = -1;
  bool keeps = false;
  LaneGauges lanes;
  PictureSink& sink() override { return *this; }
  std::unique_ptr<Source> pointer(Channels&) override { return std::make_unique<Stylus>(fails_at_ns); }
  LaneGauges& gauges() override { return lanes; }
  void pump() override {}
  bool keep_recording() const override { return keeps; }
  void frame(const Snapshot&, const ToolState&) override {}
  void stage(const std::string&, const Snapshot&) override {}
  bool open() const override { return closes_at_ns < 0 || RealClock::monotonic_ns() < closes_at_ns; }
};

class SessionCommand : public ::testing::Test {
 protected:
  const fs::path dir = fs::path(::testing::TempDir()) / ("limberg-session-command-" + std::to_string(getpid()));
  void SetUp() override { fs::create_directories(dir); }
  void TearDown() override { fs::remove_all(dir); }

  SessionCall call(int64_t fails_at_ns, int64_t closes_after_ns, bool keeps = false) const {
    SessionCall c;
    c.command = "run";
    c.scene = load_scene(source_dir() + "/app/scenes/rhomboid.toml");
    c.scene.cell_mm = 8;
    c.real_time = true;
    c.keep_dir = dir.string();
    c.common.json_file = (dir / "result.json").string();
    c.window = [=](const Scene&, const std::string&) {
      auto w = std::make_unique<NoWindow>();
      w->fails_at_ns = fails_at_ns, w->keeps = keeps;
      if (closes_after_ns >= 0) w->closes_at_ns = RealClock::monotonic_ns() + closes_after_ns;
      return w;
    };
    return c;
  }
  nlohmann::json result() const {
    std::ifstream in(dir / "result.json");
    return nlohmann::json::parse(in, nullptr, false);
  }
  static bool aside_is_left() {
    return fs::exists(fs::temp_directory_path() / ("limberg-session-" + std::to_string(getpid()) + ".lcm"));
  }
};

TEST_F(SessionCommand, OneThatFailsKeepsItsRecordingAndSaysWhereItIs) {
  std::string what;
  try {
    run_session(call(500'000'000, -1));
  } catch (const std::runtime_error& e) {
    what = e.what();
  }
  EXPECT_EQ(what, "broken device") << "the program ends as with any defect";
  const fs::path kept = dir / "limberg-1.lcm";
  ASSERT_TRUE(fs::exists(kept));
  const Recording rec = read_recording(kept.string());
  EXPECT_EQ(rec.damage.total(), 0) << rec.damage.first_message;
  EXPECT_GT(rec.samples.size(), 100u);
  EXPECT_TRUE(rec.schedule.usable()) << "it can be replayed";
  EXPECT_TRUE(rec.blob(BlobKind::scene));
  const nlohmann::json r = result();
  ASSERT_TRUE(r.is_object());
  EXPECT_EQ(r["ok"], false);
  EXPECT_EQ(r["failure"]["where"], "device thread");
  EXPECT_EQ(r["failure"]["what"], "broken device");
  EXPECT_EQ(r["failure"]["recording"], kept.string());
  EXPECT_GT(r["duration_s"].get<double>(), 0.3);
  EXPECT_FALSE(aside_is_left());
}

TEST_F(SessionCommand, WhereARecordingCannotBeKeptItStaysWhereItWasMade) {
  SessionCall c = call(500'000'000, -1);
  c.keep_dir = (dir / "no such folder").string();
  EXPECT_THROW(run_session(std::move(c)), std::runtime_error);
  const fs::path aside = fs::temp_directory_path() / ("limberg-session-" + std::to_string(getpid()) + ".lcm");
  ASSERT_TRUE(fs::exists(aside));
  EXPECT_EQ(result()["failure"]["recording"], aside.string());
  fs::remove(aside);
}

TEST_F(SessionCommand, ClosingTheWindowEndsItAndIsNoFailure) {
  for (const bool keeps : {false, true}) {
    EXPECT_EQ(run_session(call(-1, 1'000'000'000, keeps)), kDone);
    EXPECT_EQ(fs::exists(dir / "limberg-1.lcm"), keeps);
    EXPECT_FALSE(aside_is_left());
    const nlohmann::json r = result();
    EXPECT_EQ(r["ok"], true);
    EXPECT_LE(r["solver"]["settle_steps"].get<int>(), 2);
  }
}

TEST_F(SessionCommand, TheWindowSaysThatASessionWasCutOff) {
  std::vector<std::string> words;
  const auto session = [&] {
    SessionCall c = call(-1, 600'000'000, true);
    c.window = [&words, opens = c.window](const Scene& scene, const std::string& word) {
      words.push_back(word);
      return opens(scene, word);
    };
    return run_session(std::move(c));
  };
  EXPECT_EQ(session(), kDone);
  const fs::path kept = dir / "limberg-1.lcm";
  ASSERT_TRUE(fs::exists(kept));
  fs::resize_file(kept, fs::file_size(kept) * 3 / 4);
  EXPECT_EQ(session(), kDone);
  ASSERT_EQ(words.size(), 2u);
  EXPECT_EQ(words[0].find(dir.string()), std::string::npos) << words[0];
  EXPECT_NE(words[1].find("cut off after"), std::string::npos) << words[1];
  EXPECT_NE(words[1].find("limberg run --continue " + kept.string()), std::string::npos) << words[1];
}

// Between the opening of a recording and its tick 0 the window opens, which may take seconds.
TEST_F(SessionCommand, ARecordingSaysWhenItsTickZeroWasNotWhenItWasOpened) {
  const auto utc_ns = [] {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
        .count();
  };
  struct SlowWindow final : NoWindow {
    std::function<void()> slow;
    std::unique_ptr<Source> pointer(Channels& channels) override {
      slow();
      return NoWindow::pointer(channels);
    }
  };
  int64_t shown_ns = 0;
  SessionCall c = call(-1, -1);
  c.window = [&](const Scene&, const std::string&) {
    auto w = std::make_unique<SlowWindow>();
    w->keeps = true, w->closes_at_ns = RealClock::monotonic_ns() + 1'000'000'000;
    w->slow = [&] { std::this_thread::sleep_for(std::chrono::milliseconds(200)), shown_ns = utc_ns(); };
    return w;
  };
  EXPECT_EQ(run_session(std::move(c)), kDone);
  ASSERT_GT(shown_ns, 0);
  const Recording rec = read_recording((dir / "limberg-1.lcm").string());
  ASSERT_TRUE(rec.session);
  EXPECT_GE(rec.session->utc_start_ns, shown_ns) << "tick 0 was before the window was there";
  EXPECT_LE(rec.session->utc_start_ns, utc_ns());
}

}  // namespace test_session_command
}  // namespace limberg
