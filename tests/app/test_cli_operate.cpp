// Operations that are not carried out whole: refused actions are left out when asked, an interrupt keeps what was done.
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>

#include <nlohmann/json.hpp>

#include "tests/app/cli.h"

using nlohmann::json;

TEST_F(Cli, KeepGoingLeavesOutWhatIsRefusedAndNothingElse) {
  const std::string scene = file("small.toml", small_scene("1.08", "1.15"));
  const std::string cut = "{\"action\":\"incise\",\"path\":[[-12,1],[12,1]],\"depth_mm\":5}\n";
  const std::string stitch = "{\"action\":\"suture\",\"a\":[0,0.3],\"b\":[0,1.7]}\n";
  const std::string lost = "{\"action\":\"suture\",\"a\":[500,500],\"b\":[500,501]}\n";
  const std::string whole = file("whole.jsonl", script(cut + stitch)),
                    holed = file("holed.jsonl", script(cut + lost + stitch));
  expect_refused("operate " + scene + " " + holed, {"holed.jsonl:3:", "suture refused", "off the skin"});
  const Outcome good = run("operate " + scene + " " + whole + " --json " + path("whole.json"));
  const Outcome o = run("operate " + scene + " " + holed + " --keep-going --json " + path("holed.json"));
  EXPECT_EQ(o.status, 3) << o.err;
  EXPECT_NE(o.err.find("holed.jsonl:3: suture refused"), std::string::npos) << o.err;
  EXPECT_NE(o.err.find("1 of 3 actions were refused"), std::string::npos) << o.err;
  const json j = json::parse(slurp(dir_ / "holed.json")), k = json::parse(slurp(dir_ / "whole.json"));
  EXPECT_EQ(j["commands"], 2);
  ASSERT_EQ(j["refused"].size(), 1u);
  EXPECT_EQ(j["refused"][0]["line"], 3);
  EXPECT_EQ(j["refused"][0]["action"], "suture");
  EXPECT_FALSE(j["ok"].get<bool>());
  EXPECT_EQ(j["state_hash"], k["state_hash"]);  // what was refused has left no trace
  EXPECT_EQ(j["metrics"]["sutures"].size(), 1u);
  EXPECT_EQ(k["commands"], 2);
  EXPECT_TRUE(k["refused"].empty());
}

TEST_F(Cli, AnInterruptKeepsWhatWasDone) {
  const std::string scene = file("small.toml", small_scene());
  constexpr int kActs = 90'000;
  std::string lines = "{\"action\":\"incise\",\"path\":[[-12,1],[12,1]],\"depth_mm\":5}\n";
  for (int k = 0; k < kActs; ++k)  // minutes of work: the test tells it to stop when it has begun
    lines += k % 2 ? "{\"action\":\"undo\"}\n" : "{\"action\":\"suture\",\"a\":[0,0.3],\"b\":[0,1.7]}\n";
  const std::string f = file("long.jsonl", script(lines)), result = path("long.json");
  std::vector<std::string> words{kProgram, "operate", scene, f, "--json", result};
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  const std::string err = path("err");
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), O_WRONLY | O_CREAT, 0600);
  pid_t child = 0;
  ASSERT_EQ(posix_spawn(&child, kProgram.c_str(), &actions, nullptr, argv.data(), environ), 0);
  posix_spawn_file_actions_destroy(&actions);
  usleep(1'500'000);
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 3);
  if (!fs::exists(result)) {  // so slow a machine that it was told before it had begun: then there is nothing to keep
    EXPECT_NE(slurp(err).find("interrupted"), std::string::npos);
    return;
  }
  const json j = json::parse(slurp(result));
  EXPECT_TRUE(j.value("interrupted", false)) << j.dump(1);
  EXPECT_FALSE(j.value("ok", true));
  EXPECT_LT(j.value("commands", -1), kActs + 1);
  // A slow machine may not have done one of them: then there is no script.
  EXPECT_EQ(j.value("commands", -1), j.contains("script") ? int(j["script"].size()) : 0) << j.dump(1);
  EXPECT_NE(slurp(err).find("of 90001 actions"), std::string::npos) << slurp(err);
}

TEST_F(Cli, StagesShowWhatThePenHasDrawn) {
  const std::string script = file("pen.jsonl", R"({"limberg_script":1,"scene":"rhomboid"}
{"action":"stage","name":"skin"}
{"action":"mark","path":[[-15,10],[15,10]]}
{"action":"stage","name":"skin"}
{"action":"mark","path":[[0,5],[0,15]],"wipes":true}
{"action":"stage","name":"skin"}
)");
  const ::Outcome o = run("operate rhomboid " + script + " --out " + path("out"));
  ASSERT_EQ(o.status, 0) << o.err;
  if (!fs::exists(path("out/overview.png"))) GTEST_SKIP() << "no driver for pictures here";
  const auto picture = [&](int number) { return slurp(path("out/stages/0" + std::to_string(number) + "-skin.png")); };
  EXPECT_EQ(picture(1), picture(3));
  EXPECT_NE(picture(1), picture(2));
}
