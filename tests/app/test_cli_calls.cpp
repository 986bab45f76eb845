// Calls that a hand can slip in: numbers that are none, options without what they need, outputs upon inputs, Ctrl-C.
#include <array>
#include <nlohmann/json.hpp>

#include "tests/app/cli.h"

namespace test_cli_calls {

TEST_F(Cli, NumbersThatAreNone) {
  const std::string scene = file("small.toml", small_scene()),
                    s = file("s.jsonl", script("{\"action\":\"stage\",\"name\":\"a\"}\n"));
  expect_refused("operate " + scene + " " + s + " --cell-mm nan",
                 {"--cell-mm", "nan", "expected a number from 0.05 to 100"});
  expect_refused("operate " + scene + " " + s + " --cells 5,nan", {"--cells", "expected a number"});
  for (const std::string share : {"5", "0%", "101%", "nan", "5%%", "much"})
    expect_refused("operate " + scene + " " + s + " --error " + share, {"--error", "expected a share of each figure"});
  expect_refused("operate " + scene + " " + s + " --workers 2.5",
                 {"--workers", "expected a whole number from 1 to 256"});
  expect_refused("emulate --fastrak --seconds nan", {"--seconds", "expected a number"});
  expect_refused("procedure bilobed --at nan,0", {"--at", "expected a number"});
  expect_refused("procedure bilobed --turn 1e99", {"--turn", "expected a number"});
  expect_refused("bench fuzz --operations 0", {"--operations", "expected a whole number"});
  expect_refused("bench fuzz --operations 5 --seed -1", {"--seed", "expected a whole number"});
  expect_refused("design rhomboid --defect circle:0,0,14 --lines inf", {"--lines", "expected a number"});
}

TEST_F(Cli, OptionsThatNeedAnother) {
  expect_refused("replay x.lcm --frames 10", {"--film"});
  expect_refused("run rhomboid --headless --budget-ms 3", {"--auto"});
  expect_refused("run rhomboid --headless --seconds 1 --lesson " + path("absent"), {"absent"});
  expect_refused("operate rhomboid x.jsonl --limit-s 5", {"--error"});
  expect_refused("operate rhomboid x.jsonl --error 5% --cells 5,4", {"--error", "--cells"});
  expect_refused("operate rhomboid", {"SCRIPT", "limberg operate --help"});
}

TEST_F(Cli, DevicesAreRefusedBeforeThePatientIsBuilt) {
  for (const std::string url : {"xyz", "udpm://8.8.8.8:7667?ttl=5"})
    expect_refused("run rhomboid --headless --seconds 1 --device lcm:" + url, {"lcm:" + url, "expected lcm:udpm://"});
  expect_refused("run rhomboid --headless --seconds 1 --device force-simulated:x", {"force-simulated:x"});
  expect_refused(
      "run rhomboid --headless --seconds 1 --slow-motion --device emulated:" + kSource + "/recordings/rhomboid.jsonl",
      {"--slow-motion", "waits for the patient anyhow", "expected a live --device"});
  expect_refused("run rhomboid --headless --seconds 1 --slow-motion --device lcm --device force-simulated",
                 {"--slow-motion with --device force-simulated", "expected a device without forces"});
  expect_refused("superpose " + path("absent.obj") + " --mirror", {"absent.obj", "expected"});
}

TEST_F(Cli, SurfacesThatAreNoneAreRefused) {
  std::string tetrahedron = "v 0 0 0\nv 90 0 0\nv 0 90 0\nv 0 0 90\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", line, place,
              flat, sheet;
  for (int i = 0; i < 30; ++i) {
    const std::string n = std::to_string(i);
    line += "v " + n + "0 " + n + " 5\n", place += "v 1 2 3\n";
    flat +=
        "v " + std::to_string(i % 6 * 20) + " " + std::to_string(i / 6 * 20) + " " + std::to_string(i * i % 7) + "\n";
  }
  sheet = flat + "f 1 2 7\nf 2 8 7\nf 8 9 14\n";
  for (int i = 1; i < 20; ++i) flat += "f 1 1 " + std::to_string(i) + "\n";
  const std::string good = file("sheet.obj", sheet);
  for (const auto& [name, text, word] : {std::tuple{"few.obj", tetrahedron, "has 4 points; at least 10 were expected"},
                                         {"line.obj", line, "on a line"},
                                         {"place.obj", place, "at one place"},
                                         {"flat.obj", flat, "no triangle with an area"}}) {
    const std::string bad = file(name, text);
    expect_refused("superpose " + bad + " --mirror", {name, word});
    expect_refused("superpose " + bad + " " + good, {name, word});
    expect_refused("superpose " + good + " " + bad, {name, word});
    for (const std::string start : {"sphere", "plane"})
      expect_refused("fit " + bad + " --start " + start + " --out " + path("o.simplex"), {name, word});
  }
  EXPECT_FALSE(fs::exists(path("o.simplex")));
}

TEST_F(Cli, AMeanOfSurfacesIsWrittenOrRefusedInWords) {
  // Uneven bricks, the second higher than the first by 6 mm and moved.
  const auto brick = [](double high, double right) {
    std::string out;
    const double x[] = {0, 60}, y[] = {0, 90}, z[] = {0, high};
    std::string faces;
    int n = 0;
    const auto face = [&](auto at, bool turned) {  // 12 x 12 squares
      constexpr int kSquares = 12;
      for (int i = 0; i <= kSquares; ++i)
        for (int j = 0; j <= kSquares; ++j) {
          const std::array<double, 3> p = at(i / double(kSquares), j / double(kSquares));
          out += "v " + std::to_string(p[0] + right) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
        }
      for (int i = 0; i < kSquares; ++i)
        for (int j = 0; j < kSquares; ++j) {
          const int a = n + i * (kSquares + 1) + j + 1, b = a + kSquares + 1;
          const int q[] = {a, b, b + 1, a + 1};
          faces += "f";
          for (int k = 0; k < 4; ++k) faces += " " + std::to_string(q[turned ? 3 - k : k]);
          faces += "\n";
        }
      n += (kSquares + 1) * (kSquares + 1);
    };
    for (const int side : {0, 1}) {
      face([&](double s, double t) { return std::array{x[side], 90 * s, high * t}; }, side == 0);
      face([&](double s, double t) { return std::array{60 * t, y[side], high * s}; }, side == 0);
      face([&](double s, double t) { return std::array{60 * s, 90 * t, z[side]}; }, side == 0);
    }
    return out + faces;
  };
  const std::string a = file("a.obj", brick(40, 0)), b = file("b.obj", brick(46, 200)), to = path("mean.ply");
  const Outcome o = run("superpose " + a + " " + b + " --average " + to + " --out " + path("avg"));
  EXPECT_EQ(o.status, 0) << o.err;
  const auto j = nlohmann::json::parse(slurp(path("avg/result.json")));
  EXPECT_NEAR(j["average"]["spread_max_mm"].get<double>(), 1.5, 0.1);  // 6 mm, half above and half below
  EXPECT_EQ(j["average"]["surfaces"].size(), 2u);
  EXPECT_EQ(run("check " + to).status, 0);
  EXPECT_TRUE(fs::exists(path("avg/spread.csv")));
  expect_refused("superpose " + a + " " + b + " " + a, {"expected --average FILE"});
  expect_refused("superpose " + a + " --average " + to, {"two surfaces or more"});
  expect_refused("superpose " + a + " " + b + " --mirror --average " + to, {"no --mirror"});
  expect_refused("superpose " + a + " " + b + " --average " + path("mean.txt"), {"mean.txt", ".obj, .ply or .stl"});
  expect_refused("superpose " + a + " " + b + " " + path("gone.stl") + " --average " + to,
                 {"gone.stl", "no such file"});
  const std::string head = "[head]\nsource = \"synthetic\"\nnormal_skull = ";
  expect_refused("check " + file("gone.toml", head + "[\"a.obj\", \"gone.stl\"]\n"), {"gone.toml:3", "gone.stl"});
  expect_refused("check " + file("list.toml", head + "[1]\n"), {"list.toml:3", "expected normal_skull"});
  EXPECT_EQ(run("check " + file("good.toml", head + "[\"a.obj\"]\n")).status, 0);
}

TEST_F(Cli, ADeviceThatNeverCameIsNamed) {
  const std::string scene = file("small.toml", small_scene());
  const Outcome o = run("run " + scene + " --headless --seconds 0.1 --device fastrak:" + path("no-port") + " --json " +
                        path("r.json"));
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_NE(o.err.find("no-port sent nothing: "), std::string::npos) << o.err;
  const auto device = nlohmann::json::parse(slurp(path("r.json")))["device"]["sources"][0];
  EXPECT_EQ(device["device"], "fastrak:" + path("no-port"));
  EXPECT_EQ(device["samples"], 0);
}

TEST_F(Cli, WhatIsNoResultIsNotReplacedByOne) {
  const std::string scene = file("small.toml", small_scene());
  const std::string text = script("{\"action\":\"stage\",\"name\":\"a\"}\n"), s = file("s.jsonl", text);
  expect_refused("operate " + scene + " " + s + " --json " + s, {"s.jsonl", "not a result"});
  expect_refused("operate " + scene + " " + s + " --fields " + s, {"s.jsonl", "not a table of fields"});
  expect_refused("procedure bilobed --plan " + s, {"s.jsonl", "not an SVG drawing"});
  expect_refused("emulate " + scene + " " + s + " --replace --out " + s, {"s.jsonl", "not a recording"});
  EXPECT_EQ(slurp(s), text);
  EXPECT_EQ(run("procedure bilobed --plan " + path("p.svg")).status, 0);
  EXPECT_EQ(run("procedure bilobed --plan " + path("p.svg")).status, 0) << "a drawing replaces a drawing";
  EXPECT_EQ(run("bench fuzz --operations 5 --json " + path("r.json")).status, 0);
  EXPECT_EQ(run("bench fuzz --operations 5 --json " + path("r.json")).status, 0) << "a result replaces a result";
}

TEST_F(Cli, AFullDiskBehindStandardOutputIsTold) {
  const int s = std::system((kProgram + " measures >/dev/full 2>" + path("err")).c_str());
  EXPECT_EQ(WEXITSTATUS(s), 2);
  EXPECT_NE(slurp(path("err")).find("standard output"), std::string::npos);
}

TEST_F(Cli, ClosedStandardFilesDoNotEndUpInARecording) {
  const std::string scene = file("small.toml", small_scene()),
                    s = file("s.jsonl", script("{\"action\":\"wait\",\"seconds\":0.2}\n"));
  const std::string call = kProgram + " emulate " + scene + " " + s + " --seed 5 --out ";
  ASSERT_EQ(std::system((call + path("open.lcm") + " >" + path("said")).c_str()), 0);
  EXPECT_EQ(std::system((call + path("closed.lcm") + " <&- >&- 2>&-").c_str()), 0);
  EXPECT_GT(slurp(path("open.lcm")).size(), 1000u);
  EXPECT_EQ(slurp(path("closed.lcm")), slurp(path("open.lcm")));
}

TEST_F(Cli, SeveralCallsMayWriteIntoOneFolder) {
  ASSERT_EQ(run("bench fuzz --operations 5 --out " + path("out")).status, 0);
  const std::string call = "for i in 1 2 3 4 5 6 7 8; do { " + kProgram + " report " + path("out") + " >" +
                           path("said") + " 2>>" + path("err") + " || echo failed >>" + path("err") +
                           "; } & done; wait";
  ASSERT_EQ(std::system(call.c_str()), 0);
  EXPECT_EQ(slurp(path("err")), "");
  int left = 0;
  for (const auto& entry : fs::directory_iterator(path("out")))
    left += entry.path().extension() == ".part" || entry.path().filename().string().starts_with(".limberg-");
  EXPECT_EQ(left, 0);
}

TEST_F(Cli, CtrlCEndsWorkThatKeepsNothing) {
  // A bench of hours: ended by the first signal, with what it has done and the status of a goal not reached.
  const std::string call = "{ " + kProgram + " bench fuzz --operations 100000000 >" + path("out") + " 2>" +
                           path("err") + " & p=$!; sleep 0.3; kill -TERM $p; wait $p; echo $? >" + path("status") +
                           "; }";
  ASSERT_EQ(std::system(call.c_str()), 0);
  EXPECT_EQ(slurp(path("status")), "3\n");
  EXPECT_NE(slurp(path("err")).find("interrupted"), std::string::npos);
}

TEST_F(Cli, CtrlCKeepsARecordingWhole) {
  const std::string scene = file("small.toml", small_scene()), log = path("kept.lcm");
  // Ended once the recording has begun, however busy the machine is.
  const std::string call = "{ " + kProgram + " run " + scene + " --headless --device force-simulated --record " + log +
                           " >" + path("out") + " 2>" + path("err") + " & p=$!; for i in $(seq 200); do [ -s " + log +
                           " ] && break; sleep 0.05; done; kill -TERM $p; wait $p; echo $? >" + path("status") + "; }";
  ASSERT_EQ(std::system(call.c_str()), 0);
  EXPECT_EQ(slurp(path("status")), "0\n") << slurp(path("err"));
  const Outcome o = run("check " + log);
  EXPECT_EQ(o.err, "") << "not damaged: it has its end mark";
}

TEST_F(Cli, ASessionThatWasCutOffIsOfferedAndGoneOnWith) {
  const std::string scene = file("small.toml", small_scene()), log = path("my.lcm"), next = path("my-2.lcm"),
                    device =
                        " --headless --device emulated:" +
                        file("s.jsonl", script("{\"action\":\"incise\",\"path\":[[-8,0],[8,0]],\"depth_mm\":3}\n"));
  ASSERT_EQ(run("run " + scene + device + " --record " + log).status, 0);
  const std::string whole = slurp(log), cut = whole.substr(0, whole.size() * 3 / 4);
  std::ofstream(log, std::ios::binary) << cut;
  // The next start says so, and does not take its name.
  const std::string advice = "limberg run --continue " + log;
  Outcome o = run("run " + scene + device + " --record " + log);
  EXPECT_EQ(o.status, 2);
  EXPECT_NE(o.err.find(advice), std::string::npos) << o.err;
  o = run("emulate " + scene + " " + path("s.jsonl") + " --out " + path("other.lcm"));
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_NE(o.err.find("cut off after"), std::string::npos) << o.err;
  EXPECT_NE(o.err.find(advice), std::string::npos) << o.err;
  EXPECT_EQ(
      run("operate " + scene + " " + path("s.jsonl") + " --out " + dir_.string()).err.find(advice) == std::string::npos,
      false);
  // It goes on, in a recording of its own that replays as one.
  o = run("run --continue " + log + device + " --seconds 0.6 --json " + path("c.json"));
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_NE(o.out.find(next), std::string::npos) << o.out;
  EXPECT_EQ(slurp(log), cut) << "what it went on with is as it was";
  const auto c = nlohmann::json::parse(slurp(path("c.json")));
  EXPECT_EQ(c["continued"]["file"], log);
  EXPECT_EQ(c["checkpoints"]["equal"], c["checkpoints"]["compared"]);
  EXPECT_GT(double(c["duration_s"]), double(c["continued"]["from_s"]) + 0.5);
  o = run("replay " + next + " --json " + path("r.json"));
  EXPECT_EQ(o.status, 0) << o.err;
  const auto r = nlohmann::json::parse(slurp(path("r.json")));
  EXPECT_EQ(r["state_hash"], c["state_hash"]);
  EXPECT_EQ(r["checkpoints"]["equal"], r["checkpoints"]["compared"]);
  EXPECT_GT(int(r["checkpoints"]["compared"]), 0);
  // Nobody is told of it any more.
  o = run("emulate " + scene + " " + path("s.jsonl") + " --replace --out " + path("other.lcm"));
  EXPECT_EQ(o.err.find("--continue"), std::string::npos) << o.err;
  expect_refused("run --continue " + log + " --auto --headless", {"--auto", "expected"});
  expect_refused("run --continue " + path("s.jsonl") + " --headless", {"expected"});
}

}  // namespace test_cli_calls
