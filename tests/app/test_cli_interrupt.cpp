// Ctrl-C, by a real SIGINT: what was done so far is written, and the program says so and ends with status 3.
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>

#include <nlohmann/json.hpp>

#include "tests/app/cli.h"

using nlohmann::json;

namespace {

struct Interrupts : Cli {
  /// Starts the program and tells it to stop after so many ms.
  Outcome interrupted(std::vector<std::string> words, int ms) {
    words.insert(words.begin(), kProgram);
    std::vector<char*> argv;
    for (std::string& w : words) argv.push_back(w.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    const std::string err = path(".err"), out = path(".out");
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    pid_t child = 0;
    EXPECT_EQ(posix_spawn(&child, kProgram.c_str(), &actions, nullptr, argv.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    usleep(useconds_t(ms) * 1000);
    kill(child, SIGINT);
    int status = 0;
    waitpid(child, &status, 0);
    Outcome o;
    o.status = WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
    o.out = slurp(out), o.err = slurp(err);
    return o;
  }
  /// Later and later, until something was done by then: machines are not equally fast. What was written.
  json kept(const std::vector<std::string>& words, const std::string& result) {
    for (const int ms : {1500, 4000, 10'000, 30'000}) {
      std::vector<std::string> all = words;
      all.insert(all.end(), {"--json", result});
      const Outcome o = interrupted(all, ms);
      if (o.status == SIGINT + 1000) continue;  // before it had begun
      EXPECT_EQ(o.status, 3) << o.err;
      EXPECT_NE(o.err.find("interrupted"), std::string::npos) << o.err;
      if (fs::exists(result)) return json::parse(slurp(result));
    }
    ADD_FAILURE() << "nothing was done in half a minute";
    return json::object();
  }
};

// A running stitch by an emulated hand, bite by bite with one taken back: its recording replays to the same bits.
TEST_F(Cli, ARunningStitchByHandIsRecordedAndReplayed) {
  const std::string scene = file("small.toml", small_scene());
  std::string lines = "{\"action\":\"incise\",\"path\":[[-18,1],[18,1]],\"depth_mm\":5}\n";
  for (const char* x : {"-8", "-4", "3"})
    lines += std::string("{\"action\":\"suture_bite\",\"a\":[") + x + ",-1],\"b\":[" + x + ",3]}\n";
  lines +=
      "{\"action\":\"undo\"}\n{\"action\":\"suture_bite\",\"a\":[0,-1],\"b\":[0,3]}\n{\"action\":\"suture_tie\"}\n";
  const std::string log = path("bites.lcm"), f = file("bites.jsonl", script(lines));
  Outcome o = run("emulate " + scene + " " + f + " --seed 3 --out " + log + " --json " + path("e.json"));
  ASSERT_EQ(o.status, 0) << o.err;
  o = run("replay " + log + " --json " + path("r.json"));
  ASSERT_EQ(o.status, 0) << o.err;
  const json e = json::parse(slurp(path("e.json"))), r = json::parse(slurp(path("r.json")));
  EXPECT_EQ(e["state_hash"], r["state_hash"]);
  EXPECT_EQ(r["checkpoints"]["compared"], r["checkpoints"]["equal"]);
  EXPECT_GT(r["checkpoints"]["compared"].get<int>(), 3);
  EXPECT_TRUE(r["refused"].empty()) << r["refused"];
  ASSERT_EQ(r["metrics"]["sutures"].size(), 3u) << "the third bite was taken back, another took its place";
}

TEST_F(Interrupts, AReplayWritesHowFarItCame) {
  const json j = kept({"replay", kSource + "/recordings/rhomboid.lcm"}, path("r.json"));
  EXPECT_TRUE(j.value("interrupted", false));
  EXPECT_FALSE(j.value("ok", true));
  EXPECT_LT(j.value("duration_s", 1e9), 50) << "the whole recording";
  ASSERT_TRUE(j.contains("solver"));
  EXPECT_GT(j["solver"].value("steps", 0), 0);
}

TEST_F(Interrupts, OrdersOfClosureThatWereTriedAreTold) {
  const std::string scene = file("small.toml", small_scene());
  std::string lines = "{\"action\":\"incise\",\"path\":[[-18,1],[18,1]],\"depth_mm\":5}\n";
  for (int k = 0; k < 5; ++k) {
    const std::string x = std::to_string(-12 + 6 * k);
    lines += "{\"action\":\"suture\",\"a\":[" + x + ",0.3],\"b\":[" + x + ",1.7]}\n";
  }
  const std::string f = file("five.jsonl", script(lines));
  std::string orders = "as-written";
  for (const char* o : {"reversed", "alternating", "2-1-3-4-5", "1-3-2-4-5", "1-2-4-3-5", "1-2-3-5-4", "5-1-2-3-4"})
    for (int again = 0; again < 40; ++again) orders += std::string(",") + o;
  const json j = kept({"operate", scene, f, "--orders", orders}, path("o.json"));
  EXPECT_TRUE(j.value("interrupted", false));
  EXPECT_FALSE(j.value("ok", true));
  ASSERT_TRUE(j.contains("tables") && !j["tables"].empty());
  const size_t rows = j["tables"][0]["rows"].size();
  EXPECT_GE(rows, 1u);
  EXPECT_LT(rows, 281u);
}

TEST_F(Interrupts, DesignsThatWereTriedAreRanked) {
  // Seventy-two orientations of one flap, a second or more each.
  const std::string scene = file("wide.toml", limberg::test::small_block({.name = "wide", .side_mm = 100}));
  const json j = kept(
      {"design", scene, "--defect", "circle:0,0,10", "--types", "rhomboid", "--turn-step", "5", "--coarse-mm", "8"},
      path("d.json"));
  EXPECT_TRUE(j.value("interrupted", false));
  EXPECT_FALSE(j.value("ok", true));
  ASSERT_TRUE(j.contains("tables") && !j["tables"].empty());
  EXPECT_GE(j["tables"][0]["rows"].size(), 1u);
}

}  // namespace
