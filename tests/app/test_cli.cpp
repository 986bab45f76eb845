// The program itself, on bad input: exit status 2, one clear line that names the file, nothing overwritten, no crash.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "devices/recording.h"
#include "tests/app/cli.h"
#include "tests/bench/fuzz/sound_files.h"

namespace test_cli {

TEST_F(Cli, HelpAndVersion) {
  Outcome o = run("--version");
  EXPECT_EQ(o.status, 0);
  EXPECT_EQ(o.out.rfind("limberg ", 0), 0u);
  for (const char* c : {"run", "replay", "operate", "emulate", "check", "report", "bench", "fit"}) {
    o = run(std::string(c) + " --help");
    EXPECT_EQ(o.status, 0) << c;
    EXPECT_NE(o.out.find(std::string("Example: limberg ") + c), std::string::npos) << c;
    EXPECT_EQ(run(std::string("help ") + c).out, o.out) << c;
  }
  EXPECT_EQ(run("help").out, run("--help").out);
  EXPECT_EQ(run("help").status, 0);
}

TEST_F(Cli, WrongCalls) {
  expect_refused("dance", {"expected"});
  expect_refused("help dance", {"dance", "expected"});
  expect_refused("replay", {"RECORDING"});
  expect_refused("replay a.lcm --lockstep --realtime", {"expected"});
  expect_refused("bench nothing", {"nothing", "expected accuracy"});
  expect_refused("run rhomboid --device telepathy", {"telepathy", "expected"});
  expect_refused("operate rhomboid x.jsonl --cell-mm -1", {"cell-mm"});
  expect_refused("check x --workers 0", {"workers"});
}

TEST_F(Cli, FirstStepsManualAndCompletionComeFromTheCommandLine) {
  const Outcome first = run("");
  EXPECT_EQ(first.status, 0);
  EXPECT_NE(first.out.find("limberg run "), std::string::npos) << first.out;
  const Outcome man = run("--man"), completion = run("--completion");
  for (const std::string command :
       {"run", "replay", "operate", "study", "bench", "emulate", "calibrate", "devices", "fit", "check", "report"}) {
    EXPECT_NE(man.out.find(".SS limberg " + command + "\n"), std::string::npos) << command;
    EXPECT_NE(completion.out.find("    " + command + ") words="), std::string::npos) << command;
  }
  EXPECT_NE(man.out.find("\\-\\-headless"), std::string::npos);
  const std::string script =
      file("completion",
           completion.out + "\nCOMP_WORDS=(limberg replay --lo) COMP_CWORD=2; _limberg; echo ${COMPREPLY[@]}\n");
  const std::string said = path("said");
  ASSERT_EQ(std::system(("bash " + script + " >" + said).c_str()), 0);
  EXPECT_EQ(slurp(said), "--lockstep\n");
  const std::string scenes = file(
      "completion", completion.out + "\nCOMP_WORDS=(limberg run rhom) COMP_CWORD=2; _limberg; echo ${COMPREPLY[@]}\n");
  ASSERT_EQ(std::system(("bash " + scenes + " >" + said).c_str()), 0);
  EXPECT_EQ(slurp(said), "rhomboid\n");
}

TEST_F(Cli, MissingEmptyFolder) {
  const std::string empty = file("empty", "");
  for (const std::string& c : {std::string("replay "), std::string("check "), std::string("report ")}) {
    expect_refused(c + path("absent"), {"absent"});
    if (c == "replay ") expect_refused(c + dir_.string(), {dir_.string(), "is a "});
    if (c == "check ")
      expect_refused(c + dir_.string(), {dir_.string(), "no DICOM slices"});  // a folder is a series of images
    if (c != "report ") expect_refused(c + empty, {"empty"});
  }
  const std::string scene = file("small.toml", small_scene()),
                    ok = file("ok.jsonl", script("{\"action\":\"wait\",\"seconds\":0}\n"));
  for (const std::string& bad : {path("absent.toml"), dir_.string(), empty}) {
    expect_refused("operate " + bad + " " + ok, {});
    expect_refused("operate " + scene + " " + bad, {});
    expect_refused("emulate " + bad + " " + ok + " --out " + path("x.lcm"), {});
  }
  EXPECT_FALSE(fs::exists(path("x.lcm")));
}

TEST_F(Cli, BrokenScenes) {
  const auto refused = [&](const std::string& change, const std::string& to, const std::vector<std::string>& words) {
    const std::string f = file("bad.toml", small_scene(change, to));
    std::vector<std::string> all = words;
    all.push_back("bad.toml");
    expect_refused("check " + f, all);
  };
  refused("[body]", "[body", {"bad.toml:2"});
  refused("cell_mm = 5", "cell_mm = 5\ncolour = 3", {"colour", "expected"});
  refused("[40, 40, 10]", "[40, -40, 10]", {"size_mm", "expected"});
  refused("[40, 40, 10]", "[40, nan, 10]", {"size_mm", "expected"});
  refused("thickness_mm = 2", "thickness_mm = inf", {"thickness_mm", "expected"});
  refused("cell_mm = 5\n", "cell_mm = 50\n", {"cell_mm", "expected"});
  refused("source = \"block\"", "source = \"cake\"", {"source", "expected"});
}

TEST_F(Cli, BrokenScripts) {
  const std::string scene = file("small.toml", small_scene());
  const auto refused = [&](const std::string& lines, const std::vector<std::string>& words) {
    const std::string f = file("bad.jsonl", script(lines));
    std::vector<std::string> all = words;
    all.push_back("bad.jsonl:2");
    expect_refused("operate " + scene + " " + f + " --json " + path("r.json"), all);
  };
  refused("{\"action\":\"incise\",\"path\":[[0,0],[500,0]],\"depth_mm\":3}\n", {"incise"});  // off the skin
  refused("{\"action\":\"incise\",\"path\":[[0,0],[5,0]],\"depth_mm\":60}\n", {"incise", "expected"});
  refused("{\"action\":\"incise\",\"path\":[[0,0],[5,0]],\"deepness\":3}\n", {"deepness"});
  refused("{\"action\":\"dance\"}\n", {"dance"});
  refused("{\"action\":\"incise\",\n", {});
  EXPECT_FALSE(fs::exists(path("r.json")));
}

TEST_F(Cli, SurfacesThatAreNoBody) {
  const std::string tetra = "v 0 0 0\nv 30 0 0\nv 0 30 0\nv 0 0 30\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  EXPECT_EQ(run("check " + file("tetra.obj", tetra)).status, 0);
  // In metres, and inside out, as a mirror leaves it: what to say of it is said, and then it is a scene.
  const std::string metres =
      file("m.obj", "v 0 0 0\nv .03 0 0\nv 0 .03 0\nv 0 0 .03\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n");
  expect_refused("check " + metres, {"m.obj", "0.03 mm long", "--unit"});
  const Outcome m = run("check " + metres + " --unit m --scene " + path("m.toml"));
  EXPECT_EQ(m.status, 0) << m.err;
  EXPECT_NE(m.out.find("ran clockwise seen from outside: turned"), std::string::npos) << m.out;
  EXPECT_NE(slurp(path("m.toml")).find("scale_to_mm = 1000"), std::string::npos);
  EXPECT_EQ(run("check " + path("m.toml") + " --plan").status, 0);
  const Outcome cm =
      run("check " + file("cm.obj", "v 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"));
  EXPECT_EQ(cm.status, 0) << cm.err;
  EXPECT_NE(cm.out.find("try --unit cm (30 mm) or --unit inch (76 mm)"), std::string::npos) << cm.out;
  expect_refused("check " + file("open.obj", tetra.substr(0, tetra.rfind("f"))), {"open.obj", "expected"});
  // A second tetrahedron that sticks through the first.
  std::string crossing = tetra;
  crossing += "v 5 5 5\nv 35 5 5\nv 5 35 5\nv 5 5 35\nf 5 7 6\nf 5 6 8\nf 6 7 8\nf 5 8 7\n";
  expect_refused("check " + file("crossing.obj", crossing), {"crossing.obj", "expected"});
  expect_refused("check " + file("broken.obj", "v 0 0\nf 1 2 9\n"), {"broken.obj:1"});
}

TEST_F(Cli, WhatWasDoneToAVolumeIsSaid) {
  // A ball in slices of a tilted gantry; one of them is missing.
  fs::create_directories(path("ct"));
  for (int k = 0; k < 24; ++k) {
    limberg::fuzz::Slice s;
    s.columns = 30, s.rows = 30, s.at = {0, 0.5 * k, 2. * k};
    s.value = [k](int i, int j) {
      const double x = 2 * i - 29, y = 2 * j + 0.5 * k - 35, z = 2 * k - 23;
      return int16_t(std::clamp(100 * (18 - std::sqrt(x * x + y * y + z * z)), -1000., 1000.));
    };
    if (k != 4) file("ct/s" + std::to_string(10 + k), dicom(s));
  }
  expect_refused("check " + path("ct"), {"1 slice is missing between", "--bridge-missing"});
  const std::string fit = "fit " + path("ct") + " --iso 0 --edge-mm 6 --out " + path("m.simplex");
  expect_refused(fit, {"1 slice is missing between"});
  Outcome o = run(fit + " --bridge-missing --json " + path("r.json"));
  EXPECT_EQ(o.status % 3, 0) << o.err;
  const std::string notes = nlohmann::json::parse(slurp(path("r.json")))["notes"].dump();
  for (const char* words : {"tilted by 14.0 degrees", "1 slice is missing"}) {
    EXPECT_NE(o.out.find(words), std::string::npos) << o.out;
    EXPECT_NE(notes.find(words), std::string::npos) << notes;
  }
  fs::remove(path("ct/s10")), fs::remove(path("ct/s11")), fs::remove(path("ct/s12")), fs::remove(path("ct/s13"));
  for (const char* given : {"ct", "ct/s20"}) {  // a slice by itself is known by its content
    o = run("check " + path(given));
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_NE(o.out.find("note        the gantry was tilted"), std::string::npos) << o.out;
  }
}

TEST_F(Cli, FitsSayHowMuchTheyReachAndInWhichUnit) {
  // A dome, in cm. Its edge is where the mesh ends.
  std::string dome;
  for (int j = -20; j <= 20; ++j)
    for (int i = -20; i <= 20; ++i)
      if (const double q = 1 - (i * i + j * j) / 450.; q > 0.05)
        dome += std::to_string(0.4 * i) + " " + std::to_string(0.4 * j) + " " + std::to_string(6 * std::sqrt(q)) + "\n";
  const std::string scan = file("dome.xyz", dome), out = " --out " + path("m.simplex") + " --json " + path("r.json");
  Outcome o = run("fit " + scan + " --start plane --unit cm" + out);
  EXPECT_EQ(o.status, 0) << o.err;
  nlohmann::json r = nlohmann::json::parse(slurp(path("r.json")));
  EXPECT_GT(r["reached"].get<double>(), 0.95);
  EXPECT_NEAR(r["voxel_mm"].get<double>(), 4, 2.);
  EXPECT_EQ(r["unit"], "cm");
  EXPECT_EQ(r["warning"], "");
  // In mm it would be a face of 16 mm: said, with what it might be.
  o = run("fit " + scan + " --start plane" + out);
  EXPECT_NE(o.err.find("--unit cm (160 mm)"), std::string::npos) << o.err;
  // Not reached: exit 3, and how much was. A ball within a ball is behind it from everywhere.
  std::string balls;
  for (const double radius : {50., 35.})
    for (int i = 0; i < int(radius * radius); ++i) {
      const double z = 2 * (i + 0.5) / (radius * radius) - 1, turn = 2.399963 * i, ring = std::sqrt(1 - z * z);
      balls += std::to_string(radius * ring * std::cos(turn)) + " " + std::to_string(radius * ring * std::sin(turn)) +
               " " + std::to_string(radius * z) + "\n";
    }
  o = run("fit " + file("balls.xyz", balls) + out);
  EXPECT_EQ(o.status, 3) << o.err << o.out;
  EXPECT_NE(o.err.find("of the scan is within two spacings of the mesh; 90 % was wanted"), std::string::npos) << o.err;
  r = nlohmann::json::parse(slurp(path("r.json")));
  EXPECT_FALSE(r["ok"].get<bool>());
  EXPECT_TRUE(r.contains("missed"));
  EXPECT_NEAR(r["reached"].get<double>(), 2500. / 3725, 0.05);
  expect_refused("fit " + scan + " --from 0,0,1" + out, {"--from", "--start plane"});
  expect_refused("fit " + scan + " --start plane --unit cm --from 0,0,nan" + out, {"dome.xyz", "finite"});
  // What a damaged file holds is quoted without commands to a terminal.
  o = run("check " + file("escape.nrrd", "NRRD0004\ndimension: 3\nsizes: 3 \x1b[31m 5\n\n"));
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(o.err.find('\x1b'), std::string::npos);
}

TEST_F(Cli, RecordingsThatAreNone) {
  expect_refused("replay " + file("text.lcm", std::string(5000, 'x')), {"text.lcm", "expected"});
  expect_refused("replay " + file("sync.lcm", "\xED\xA1\xDA\x01 and then nothing"), {"sync.lcm", "expected"});
  expect_refused("replay " + file("script.lcm", script("")), {"script.lcm", "expected"});
}

TEST_F(Cli, OutputThatCannotBeWritten) {
  const std::string scene = file("small.toml", small_scene()),
                    s = file("s.jsonl", script("{\"action\":\"stage\",\"name\":\"a\"}\n"));
  const std::string kept = file("kept", "precious");
  expect_refused("operate " + scene + " " + s + " --out /proc/limberg", {"/proc/limberg", "expected"});
  expect_refused("operate " + scene + " " + s + " --out " + kept, {"kept", "expected"});
  expect_refused("operate " + scene + " " + s + " --json " + path("no/such/r.json"), {"r.json", "expected"});
  expect_refused("operate " + scene + " " + s + " --json " + dir_.string(), {"folder"});
  expect_refused("emulate " + scene + " " + s + " --out " + kept, {"kept", "exists"});
  expect_refused("emulate " + scene + " " + s + " --out " + path("no/such/x.lcm"), {"x.lcm", "expected"});
  expect_refused("report " + kept, {"kept"});
  EXPECT_EQ(slurp(kept), "precious");
}

/// One recording for the tests below; 2 s of a surgeon on a small block.
class Recorded : public Cli {
 protected:
  void SetUp() override {
    scene_ = file("small.toml", small_scene());
    script_ = file("s.jsonl", script("{\"action\":\"incise\",\"path\":[[-8,0],[8,0]],\"depth_mm\":3}\n"
                                     "{\"action\":\"stage\",\"name\":\"cut\"}\n"));
    log_ = path("s.lcm");
    const Outcome o =
        run("emulate " + scene_ + " " + script_ + " --out " + log_ + " --seed 5 --json " + path("e.json"));
    ASSERT_EQ(o.status, 0) << o.err;
  }
  nlohmann::json json(const std::string& name) const { return nlohmann::json::parse(slurp(path(name))); }
  std::string scene_, script_, log_;
};

TEST_F(Recorded, ReplaysToTheSameHashWithAnyWorkers) {
  const auto first = json("e.json");
  for (const int workers : {1, 2}) {
    const Outcome o = run("replay " + log_ + " --json " + path("r.json") + " --workers " + std::to_string(workers));
    ASSERT_EQ(o.status, 0) << o.err;
    const auto j = json("r.json");
    EXPECT_EQ(j["state_hash"], first["state_hash"]);
    EXPECT_EQ(j["mode"], "lockstep");
    EXPECT_EQ(j["checkpoints"]["compared"], j["checkpoints"]["equal"]);
    EXPECT_GE(j["checkpoints"]["compared"].get<int>(), 2);
    EXPECT_EQ(j["device"]["events_lost"], 0);
    EXPECT_EQ(j["metrics"]["pieces"], 1);
    EXPECT_LE(std::abs(j["metrics"]["volume_change"].get<double>()), 1e-9);
    EXPECT_FALSE(j.contains("damage"));
    for (const char* key :
         {"limberg", "machine", "duration_s", "parts", "memory_mb", "device", "solver", "render", "latency_ms"})
      EXPECT_TRUE(j.contains(key)) << key;
  }
}

// An encoder that ends badly half way costs nobody the film that was there.
TEST_F(Recorded, AFilmReplacesAnotherWholeOrNotAtAll) {
  const std::string film = file("film.mp4", "yesterday's");
  fs::permissions(
      file("ffmpeg", "#!/bin/sh\nfor last; do :; done\ncat > \"$last\"\nexit \"$(cat " + path("status") + ")\"\n"),
      fs::perms::owner_all);
  const std::string before = std::getenv("PATH");
  setenv("PATH", (dir_.string() + ":" + before).c_str(), 1);
  const auto parts = [&] {
    return std::count_if(fs::directory_iterator(dir_), fs::directory_iterator(),
                         [](const auto& f) { return f.path().string().find(".part") != std::string::npos; });
  };
  for (const std::string status : {"1", "0"}) {
    file("status", status);
    const Outcome o =
        run("replay " + log_ + " --film " + film + " --frames 10 --film-size 160x90 --json " + path("film.json"));
    EXPECT_EQ(o.status, status == "1" ? 2 : 0) << o.err;
    if (status == "0") {  // this encoder keeps what it gets: a frame for every tenth of a second, drawn anew or not
      const auto seconds = nlohmann::json::parse(slurp(path("film.json")))["duration_s"].get<double>();
      EXPECT_EQ(slurp(film).size() % (160 * 90 * 3), 0u);
      EXPECT_NEAR(double(slurp(film).size()) / (160 * 90 * 3), 10 * seconds, 2);
    }
    EXPECT_EQ(slurp(film) == "yesterday's", status == "1");
    EXPECT_EQ(parts(), 0);
  }
  setenv("PATH", before.c_str(), 1);
}

// The recording is told to have come from another program, whose patient was half a millimetre beside ours somewhere.
TEST_F(Recorded, AReplayThatDiffersSaysByHowMuchAndWhatIsOther) {
  using namespace limberg;
  const Recording rec = read_recording(log_);
  ASSERT_GE(rec.states.size(), 1u);
  SessionInfo info = *rec.session;
  info.program = "limberg 0.0.1 (abc), g++ 9.4.0, x86_64 avx2";
  const auto other = [&](bool far) {
    RecordingWriter w;
    w.open(path("other.lcm"), info, rec.blobs, true);
    for (const Sample& s : rec.samples) w.on_sample(s);
    for (StateSample s : rec.states) {
      if (far && s.step == rec.states.back().step) s.at_mm[5][2] += 0.5f, s.sutures_N += 0.25f;
      w.state(s);
    }
    for (const Checkpoint& c : rec.checkpoints) w.checkpoint(c.tick, far ? c.hash ^ 1 : c.hash);
    ASSERT_TRUE(w.finish(rec.end->tick, rec.end->hash));
  };
  other(false);
  auto o = run("replay " + path("other.lcm") + " --json " + path("r.json"));
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(o.err.find("differs"), std::string::npos) << o.err;
  other(true);
  o = run("replay " + path("other.lcm") + " --json " + path("r.json"));
  EXPECT_NE(o.err.find("differs from the recorded one from second 1 on: by at most 0.5 mm, and 0.25 N"),
            std::string::npos)
      << o.err;
  EXPECT_NE(o.err.find("made by limberg 0.0.1 (abc), g++ 9.4.0, x86_64 avx2, this is limberg "), std::string::npos)
      << o.err;
  EXPECT_EQ(o.err.find("damaged"), std::string::npos) << o.err;
  EXPECT_EQ(json("r.json")["recorded_by"]["version"], "limberg 0.0.1 (abc)");
  EXPECT_EQ(json("r.json")["recorded_by"]["compiler"], "g++ 9.4.0");
  EXPECT_EQ(json("r.json")["recorded_by"]["simd"], "x86_64 avx2");
  EXPECT_NEAR(json("r.json")["checkpoints"]["difference_mm"].get<double>(), 0.5, 1e-5);
  EXPECT_NEAR(json("r.json")["checkpoints"]["difference_N"].get<double>(), 0.25, 1e-6);
}

TEST_F(Recorded, TheSameCallWritesTheSameBytes) {
  ASSERT_EQ(run("emulate " + scene_ + " " + script_ + " --out " + path("again.lcm") + " --seed 5").status, 0);
  EXPECT_EQ(slurp(log_), slurp(path("again.lcm")));
  const std::string before = slurp(log_);
  expect_refused("emulate " + scene_ + " " + script_ + " --out " + log_, {"exists"});
  EXPECT_EQ(slurp(log_), before);
}

TEST_F(Recorded, OfAnotherScene) {
  const std::string other = file("other.toml", small_scene("cell_mm = 5", "cell_mm = 4"));
  expect_refused("replay " + log_ + " --scene " + other, {"another scene"});
  EXPECT_EQ(run("replay " + log_ + " --scene " + scene_).status, 0);
  expect_refused("run " + other + " --headless --device log:" + log_, {"another scene", "comments only"});
  const std::string said = file("said.toml", "# with a word more\n" + slurp(scene_));
  EXPECT_EQ(run("replay " + log_ + " --scene " + said).status, 0);
}

TEST_F(Recorded, DamageIsSaidAndCountedAndTheRestReplays) {
  const std::string whole = slurp(log_);
  // Cut short.
  Outcome o = run("replay " + file("cut.lcm", whole.substr(0, whole.size() * 2 / 3)) + " --json " + path("cut.json"));
  EXPECT_TRUE(o.status == 0 || o.status == 3) << o.status << o.err;
  EXPECT_NE(o.err.find("cut"), std::string::npos);
  // A hole in the stream of samples.
  std::string holed = whole;
  for (size_t i = whole.size() / 2; i < whole.size() / 2 + 3000; ++i) holed[i] = char(i * 7);
  o = run("replay " + file("holed.lcm", holed) + " --json " + path("holed.json"));
  EXPECT_EQ(o.status, 3) << o.err;
  EXPECT_NE(o.err.find("damaged"), std::string::npos) << o.err;
  EXPECT_GT(json("holed.json")["damage"]["events"].get<int>(), 0);
  EXPECT_EQ(run("check " + path("holed.lcm")).status, 3);
  // The scene itself damaged: nothing to replay.
  std::string sceneless = whole;
  const size_t at = whole.find("skin_cell_mm");
  ASSERT_NE(at, std::string::npos);
  sceneless[at] = 'x';
  expect_refused("replay " + file("sceneless.lcm", sceneless), {"sceneless.lcm", "expected"});
}

TEST_F(Recorded, AFullDiskKeepsWhatThereIs) {
  const Outcome o = run("emulate " + scene_ + " " + script_ + " --out /dev/full");
  EXPECT_EQ(o.status, 2) << o.err;
  EXPECT_NE(o.err.find("No space"), std::string::npos) << o.err;
}

TEST_F(Recorded, ReportIsMadeAgain) {
  ASSERT_EQ(run("replay " + log_ + " --out " + path("out")).status, 0);
  EXPECT_TRUE(fs::exists(path("out/result.json")));
  EXPECT_TRUE(fs::exists(path("out/session.jsonl")));
  ASSERT_TRUE(fs::remove(path("out/report.html")));
  EXPECT_EQ(run("report " + path("out")).status, 0);
  EXPECT_TRUE(fs::exists(path("out/report.html")));
  // The session's own script carries the same operation out again.
  const Outcome o = run("operate " + scene_ + " " + path("out/session.jsonl") + " --json " + path("o.json"));
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(json("o.json")["metrics"]["pieces"], 1);
}

TEST_F(Cli, StudiesSayWhatTheyTake) {
  expect_refused("study nothing", {"nothing", "gape", "disc"});
  expect_refused("study disc --set foo=1", {"foo", "along", "poisson"});
  expect_refused("study disc --set along=2", {"along", "2", "range"});
  expect_refused("study disc --set along=1.1,x", {"along", "x"});
  const Outcome o =
      run("study disc --set along=1.1 --set across=1.05 --set cell_mm=4 --set radius_mm=6 --out " + path("disc"));
  EXPECT_EQ(o.status, 0) << o.err;
  const auto j = nlohmann::json::parse(slurp(dir_ / "disc/result.json"));
  EXPECT_EQ(j["command"], "study");
  EXPECT_EQ(j["rows"].size(), 1u);
  EXPECT_TRUE(j["bars"][0]["pass"].get<bool>());
  for (const char* name : {"disc/rows.csv", "disc/disc.svg", "disc/report.html"})
    EXPECT_TRUE(fs::exists(dir_ / name)) << name;
  EXPECT_NE(slurp(dir_ / "disc/report.html").find("Study: disc"), std::string::npos);
}

TEST_F(Cli, ARefusedCutCanBeTriedAgain) {
  const std::string scene = file("small.toml", small_scene());
  const std::string bad = file(
      "bad.jsonl",
      script("{\"action\":\"incise\",\"path\":[[-8,0],[8,0]]}\n{\"action\":\"incise\",\"path\":[[-8,5],[80,5]]}\n"));
  for (int n = 1; n <= 2; ++n) {  // the second does not overwrite the first
    EXPECT_EQ(run("operate " + scene + " " + bad + " --out " + path("out")).status, 2);
    EXPECT_TRUE(fs::exists(dir_ / ("out/repro-" + std::to_string(n) + ".json")));
  }
  const std::string repro = path("out/repro-1.json");
  EXPECT_EQ(run("check " + repro).status, 0);
  const Outcome again = run("operate " + scene + " " + repro);
  EXPECT_EQ(again.status, 3);
  EXPECT_NE(again.out.find("as recorded"), std::string::npos) << again.out;
  EXPECT_FALSE(fs::exists(dir_ / "out/repro-3.json"));
  const std::string other = file("other.toml", small_scene("1.08", "1.07"));
  expect_refused("operate " + other + " " + repro, {"another scene"});
  expect_refused("check " + file("broken.json", slurp(repro).substr(0, 300)), {"broken"});
}

TEST_F(Cli, BadScriptsNameTheirLine) {
  const std::string scene = file("small.toml", small_scene());
  const std::string hole = "{\"action\":\"excise\",\"outline\":[[-4,-4],[4,-4],[4,4],[-4,4]],\"depth_mm\":4}\n";
  const std::string slit = "{\"action\":\"incise\",\"path\":[[-10,7],[10,7]],\"depth_mm\":4}\n";
  const std::string stitch = "{\"action\":\"suture\",\"a\":[0,6.4],\"b\":[0,7.6]}\n";
  const struct {
    std::string name, lines;
    int line;
    const char* word;
  } bad[] = {
      {"unknown", "{\"action\":\"pray\"}\n", 2, "unknown action"},
      {"outside", slit + "{\"action\":\"incise\",\"path\":[[-8,5],[80,5]]}\n", 3, "skin"},
      {"removed", hole + "{\"action\":\"suture\",\"a\":[0,0],\"b\":[0,6]}\n", 3, "removed"},
      {"nothing", hole + "{\"action\":\"incise\",\"path\":[[-2,0],[2,0]]}\n", 3, "incise refused"},
      {"twice", slit + stitch + stitch, 4, "already"},
      {"loop", "{\"action\":\"excise\",\"outline\":[[-4,-4],[4,-4],[4,4],[-4,4]],\"depth_mm\":3,\"floor\":false}\n", 2,
       "attached"},
      {"bow-tie", "{\"action\":\"excise\",\"outline\":[[-6,-4],[6,4],[6,-4],[-6,4]],\"depth_mm\":3}\n", 2,
       "crosses itself at (0.00, 0.00) mm"},  // encloses nothing, taken with its sign
      {"lopsided-bow-tie", "{\"action\":\"undermine\",\"outline\":[[-6,-4],[6,4],[6,-4],[-6,5]],\"depth_mm\":3}\n", 2,
       "crosses itself at"},
      {"no-area", "{\"action\":\"excise\",\"outline\":[[-6,-4],[6,4],[-6,-4]],\"depth_mm\":3}\n", 2,
       "encloses nothing"},
      {"none", slit + stitch + "{\"action\":\"cut_suture\",\"id\":2}\n", 4, "no stitch 2"},
      {"both", slit + "{\"action\":\"cut_suture\",\"id\":2,\"at\":[0,0]}\n", 3, "unknown key \"at\""},
  };
  for (const auto& b : bad) {
    const std::string f = file(b.name + ".jsonl", script(b.lines));
    expect_refused("operate " + scene + " " + f + " --json " + path(b.name + ".json"),
                   {b.name + ".jsonl:" + std::to_string(b.line) + ":", b.word});
    EXPECT_FALSE(fs::exists(path(b.name + ".json"))) << b.name;
  }
  expect_refused("operate " + scene + " " + file("good.jsonl", script(slit)) + " --cells 0", {"cells", "0.05"});
  expect_refused("operate " + scene + " " + file("good.jsonl", script(slit)) + " --cells 5,5",
                 {"--cells", "5 mm after 5 mm", "coarse to fine"});
  expect_refused("check " + file("lost.jsonl", "{\"limberg_script\":1,\"scene\":\"nowhere\"}\n"),
                 {"lost.jsonl:1:", "nowhere"});
}

TEST_F(Cli, ThreadsOrdersAndTheirFigures) {
  const std::string scene = file("small.toml", small_scene("1.08", "1.15"));
  const std::string text = script(
      "{\"action\":\"incise\",\"path\":[[-12,1],[12,1]],\"depth_mm\":5}\n"
      "{\"action\":\"suture\",\"a\":[-6,0.3],\"b\":[-6,1.7]}\n"
      "{\"action\":\"suture\",\"a\":[0,0.3],\"b\":[0,1.7]}\n"
      "{\"action\":\"suture\",\"a\":[6,0.3],\"b\":[6,1.7]}\n");
  const std::string f = file("three.jsonl", text);
  Outcome o = run("operate " + scene + " " + f + " --orders as-written,reversed,2-1-3 --json " + path("orders.json"));
  EXPECT_EQ(o.status, 0) << o.err;
  const auto j = nlohmann::json::parse(slurp(dir_ / "orders.json"));
  ASSERT_EQ(j["orders"].size(), 3u);
  const double a = j["orders"][0]["closure_force_N"], b = j["orders"][1]["closure_force_N"];
  EXPECT_NEAR(a, b, 0.02 * a);  // elastic: the end does not remember the way
  EXPECT_GE(j["orders"][0]["suture_force_peak_N"].get<double>(),
            j["orders"][0]["suture_force_max_N"].get<double>() - 1e-9);
  EXPECT_EQ(j["charts"].size(), 1u);
  for (const std::string order : {"as-written", "reversed", "2-1-3"})
    EXPECT_TRUE(std::any_of(j["verdict"].begin(), j["verdict"].end(), [&](const auto& v) {
      return v["what"] == order + ": closed along its whole edge" && v["light"] == "good";
    })) << order;
  // Most of the wound is not sewn: each order ends badly.
  const std::string open =
      file("open.jsonl", script("{\"action\":\"excise\",\"outline\":[[-12,0],[0,-5],[12,0],[0,5]],\"depth_mm\":5}\n"
                                "{\"action\":\"suture\",\"a\":[-10,-1.5],\"b\":[-10,1.5]}\n"
                                "{\"action\":\"suture\",\"a\":[10,-1.5],\"b\":[10,1.5]}\n"));
  o = run("operate " + scene + " " + open + " --orders as-written,reversed --json " + path("open.json"));
  EXPECT_EQ(o.status, 3) << o.err;
  const auto left = nlohmann::json::parse(slurp(dir_ / "open.json"));
  EXPECT_FALSE(left["ok"].get<bool>());
  EXPECT_EQ(left["verdict"][0]["light"], "bad");
  expect_refused("operate " + scene + " " + f + " --orders 1-2", {"orders"});
  const std::string running =
      file("running.jsonl", script("{\"action\":\"incise\",\"path\":[[-12,1],[12,1]],\"depth_mm\":5}\n"
                                   "{\"action\":\"suture_row\",\"a\":[[-10,0.3],[10,0.3]],\"b\":[[-10,1.7],[10,1.7]],"
                                   "\"spacing_mm\":5,\"running\":true}\n"));
  o = run("operate " + scene + " " + running + " --json " + path("running.json") + " --fields " + path("fields.csv"));
  EXPECT_EQ(o.status, 0) << o.err;
  const auto k = nlohmann::json::parse(slurp(dir_ / "running.json"));
  for (const auto& s : k["metrics"]["sutures"]) {
    EXPECT_EQ(s["thread"], 1);
    EXPECT_GE(s["peak_N"].get<double>(), s["force_N"].get<double>() - 1e-9);
  }
  EXPECT_GT(k["closure"].size(), 0u);
  EXPECT_NE(slurp(dir_ / "fields.csv").find("perfusion_index"), std::string::npos);
}

TEST_F(Cli, PlansLessonsAndMeasures) {
  Outcome o = run("check " + kSource + "/app/lessons/rhomboid.toml --plan --draw " + path("plan.svg"));
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_NE(o.out.find("saddle  of -120 degrees"), std::string::npos) << o.out;
  EXPECT_NE(slurp(dir_ / "plan.svg").find("<svg"), std::string::npos);
  o = run("check " + kSource + "/recordings/zplasty.jsonl --plan");
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_NE(o.out.find("dog-ear of +60 degrees"), std::string::npos) << o.out;
  expect_refused("check " + file("bad.toml",
                                 "lesson = \"x\"\ngoal = \"y\"\nscene = \"rhomboid\"\n[procedure]\nname = "
                                 "\"magic\"\n[tolerance]\ngap_mm = 1\n"),
                 {"bad.toml:5", "magic"});
  EXPECT_NE(run("measures").out.find("closure_force_N [N]"), std::string::npos);
  expect_refused("design rhomboid --defect circle:0,0", {"circle"});
  expect_refused("design rhomboid --defect circle:200,0,10", {"skin"});
  expect_refused("design rhomboid --defect circle:0,0,10 --types sleight", {"sleight", "fusiform"});
}

// A session is judged as a script is: live, from its recording, and by both the same limits.
TEST_F(Cli, SessionsAreJudgedByALesson) {
  const std::string scene = file("small.toml", small_scene());
  const std::string script = file("slit.jsonl", R"({"limberg_script":1,"scene":"small"}
{"action":"incise","path":[[-6,0],[6,0]],"depth_mm":3}
{"action":"suture","a":[0,1],"b":[0,-1]}
)");
  const std::string lesson = file(
      "slit.toml",
      "lesson = \"A slit\"\ngoal = \"Close it\"\nscene = \"small\"\n[procedure]\nname = "
      "\"fusiform\"\n[procedure.values]\nwidth_mm = 4\n[tolerance]\ncorner_mm = 2\ngap_mm = 0.2\ntime_s = 0.001\n");
  const auto judged = [&](const std::string& command) {
    const Outcome o = run(command + " --judge " + lesson + " --json " + path("result.json"));
    EXPECT_EQ(o.status, 3) << command << ": two of three tolerances are missed\n" << o.err;
    EXPECT_NE(o.out.find("lesson      gap_mm"), std::string::npos) << o.out;
    EXPECT_NE(o.out.find("verdict     bad   lesson: corner_mm: not measured"), std::string::npos) << o.out;
    std::map<std::string, bool> met;
    const auto j = nlohmann::json::parse(slurp(dir_ / "result.json"));
    for (const auto& t : j.at("lesson").at("tolerances")) {
      met[t.at("name").get<std::string>()] = t.at("met").get<bool>();
      if (t.at("name") == "corner_mm") {
        EXPECT_NE(t.value("why", "").find("no excision was drawn"), std::string::npos) << t;  // the plan is one
      }
      EXPECT_EQ(t.contains("why"), !t.contains("value")) << t;
    }
    EXPECT_NE(o.out.find("not measured: "), std::string::npos) << o.out;
    EXPECT_EQ(met.size(), 3u);
    return met;
  };
  ASSERT_EQ(run("emulate " + scene + " " + script + " --out " + path("slit.lcm")).status, 0);
  const auto replayed = judged("replay " + path("slit.lcm"));
  EXPECT_TRUE(replayed.at("gap_mm"));
  EXPECT_FALSE(replayed.at("time_s"));  // nobody sews in a millisecond
  const auto live = judged("run " + scene + " --headless --device emulated:" + script);
  EXPECT_TRUE(live.at("gap_mm"));
  EXPECT_FALSE(live.at("time_s"));
  const Outcome bad = run("replay " + path("slit.lcm") + " --judge " + file("none.toml", "lesson = 3\n"));
  EXPECT_EQ(bad.status, 2) << bad.err;
  EXPECT_NE(bad.err.find("none.toml"), std::string::npos) << bad.err;
}

// Closed is a wound whose whole edge is: stitches that hold say nothing of what gapes between them.
TEST_F(Cli, AWoundIsClosedWhenItsWholeEdgeIs) {
  std::string soft = small_scene("young_kPa = 60", "young_kPa = 12");  // so that no force is at its limit
  soft.replace(soft.find("young_kPa = 15"), 14, "young_kPa = 3");
  const std::string scene = file("small.toml", soft);
  const std::string cut = R"({"limberg_script":1,"scene":"small"}
{"action":"excise","outline":[[-9,0],[-4,1.3],[4,1.3],[9,0],[4,-1.3],[-4,-1.3]],"depth_mm":3}
)";
  const auto verdict = [&](const std::string& stitches, int status) {
    const Outcome o = run("operate " + scene + " " + file("s.jsonl", cut + stitches) + " --out " + path("out"));
    EXPECT_EQ(o.status, status) << o.out << o.err;
    const auto j = nlohmann::json::parse(slurp(dir_ / "out" / "result.json"));
    EXPECT_EQ(j.at("ok").get<bool>(), status == 0);
    std::map<std::string, std::string> lights;
    for (const auto& v : j.at("verdict")) {
      for (const char* name : {"what", "value", "unit", "limit", "place", "light"}) EXPECT_TRUE(v.contains(name)) << v;
      lights[v.at("what").get<std::string>()] = v.at("light").get<std::string>();
    }
    const std::string html = slurp(dir_ / "out" / "report.html");
    EXPECT_EQ(html.find("What is wrong") != std::string::npos, status != 0);
    EXPECT_EQ(html.find("Closed along its whole edge") != std::string::npos,
              lights.contains("closed along its whole edge"));
    EXPECT_EQ(html.find("Closed with"), std::string::npos);
    return lights;
  };
  EXPECT_EQ(verdict("", 0).at("open wound, nothing is sewn"), "told");
  auto v = verdict(R"({"action":"suture","a":[-7,0.6],"b":[-7,-0.6]}
)",
                   3);
  EXPECT_EQ(v.at("wound gape, widest"), "bad");
  EXPECT_EQ(v.at("bites of a stitch apart"), "good") << "the stitch holds";
  v = verdict(
      R"({"action":"suture_row","a":[[-8,0.3],[-4,1.3],[4,1.3],[8,0.3]],"b":[[-8,-0.3],[-4,-1.3],[4,-1.3],[8,-0.3]],"spacing_mm":2}
)",
      0);
  EXPECT_EQ(v.at("closed along its whole edge"), "good");
  // A stitch along one bank joins nothing, however well all the others do.
  v = verdict(
      R"({"action":"suture_row","a":[[-8,0.3],[-4,1.3],[4,1.3],[8,0.3]],"b":[[-8,-0.3],[-4,-1.3],[4,-1.3],[8,-0.3]],"spacing_mm":2}
{"action":"suture","a":[-3,1.3],"b":[0,1.3]}
)",
      3);
  EXPECT_EQ(v.at("stitches that hold nothing: both bites in one bank"), "bad");
}

TEST_F(Cli, DesignsAreRanked) {
  const std::string scene = file("flat.toml", small_scene("size_mm = [40, 40, 10]", "size_mm = [70, 70, 10]"));
  const Outcome o =
      run("design " + scene +
          " --defect circle:0,0,8 --types fusiform --turn-step 60 --refine 1 --spare lid=0,16 --out " + path("out"));
  EXPECT_EQ(o.status, 0) << o.err;
  const auto j = nlohmann::json::parse(slurp(dir_ / "out/result.json"));
  ASSERT_GE(j["rows"].size(), 1u);
  EXPECT_GT(j["rows"][0]["excised_mm2"].get<double>(), 50.3);  // it holds the circle
  EXPECT_EQ(j["rows"][0]["pass"], "fine");
  ASSERT_GE(j["rows"].size(), 2u);
  EXPECT_EQ(j["rows"][1]["pass"], "first");
  EXPECT_EQ(j["rows"][1]["cost"], j["rows"][1]["first_pass_cost"]);
  EXPECT_NE(o.out.find("  (2) fusiform"), std::string::npos) << o.out;  // ranked by the first pass
  EXPECT_NE(slurp(dir_ / "out/report.html").find("(2)"), std::string::npos);
  EXPECT_TRUE(fs::exists(dir_ / "out/design-1.svg"));
  EXPECT_EQ(run("operate " + scene + " " + path("out/design-1.jsonl")).status, 0);
}

}  // namespace test_cli
