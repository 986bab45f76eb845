// Files and names that were made to hurt: pipes, devices without an end, links that go round, names that no file system
// takes, text with commands for a terminal.
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "tests/app/cli.h"

namespace test_cli_hostile {

class CliHostile : public Cli {
 protected:
  const std::string scene = file("small.toml", small_scene()),
                    script_file = file("s.jsonl", script("{\"action\":\"stage\",\"name\":\"a\"}\n"));
};

TEST_F(CliHostile, NothingWaitsForAPipeNorReadsADeviceWithoutEnd) {
  const std::string pipe = path("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::string head =
      "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 4 4\nspace: left-posterior-superior\n"
      "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: ";
  for (const std::string& from : {pipe, std::string("/dev/zero")}) {
    for (const std::string& call :
         {"check " + from, "replay " + from, "operate " + from + " " + script_file, "operate " + scene + " " + from,
          "run " + scene + " --headless --seconds 1 --calibration " + from, "run " + from + " --headless --seconds 1",
          "calibrate stylus " + from + " --out " + path("c.toml"),
          "fit " + from + " --tissue skin --out " + path("m.simplex"), "superpose " + from + " " + from,
          "emulate " + scene + " " + from + " --out " + path("e.lcm")})
      expect_refused(call, {from, "is not a regular file; expected"});
    fs::create_directories(path("left"));
    fs::remove(path("left/result.json"));
    fs::create_symlink(from, path("left/result.json"));
    expect_refused("report " + path("left"), {"result.json", "is not a regular file"});
    fs::remove(path("v.raw"));
    fs::create_symlink(from, path("v.raw"));
    for (const std::string encoding : {"raw", "gzip"}) {
      expect_refused("check " + file("v.nhdr", head + encoding + "\ndata file: v.raw\n"),
                     {"v.raw", "is not a regular file"});
      expect_refused("check " + file("v.nhdr", head + encoding + "\ndata file: " + from + "\n"),
                     {"v.nhdr:9", "lies outside of the header's folder"});
    }
    expect_refused(
        "check " + file("mesh.toml", small_scene("source = \"block\"\nsize_mm = [40, 40, 10]\nskin_cell_mm = 2",
                                                 "source = \"obj\"\nmesh = \"" + from + "\"")),
        {from, "is not a regular file"});
  }
}

TEST_F(CliHostile, NamesThatCannotBeReachedAreRefused) {
  fs::create_symlink("loop2", path("loop1"));
  fs::create_symlink("loop1", path("loop2"));
  for (const std::string& name : {path(std::string(300, 'a')), path("loop1"), path("small.toml/below"),
                                  path("absent/below"), path(std::string(5000, 'b'))}) {
    const std::string tail = fs::path(name).filename().string().substr(0, 20);
    for (const std::string& call :
         {"check " + name, "replay " + name, "report " + name, "operate " + name + " " + script_file,
          "operate " + scene + " " + name, "operate " + scene + " " + script_file + " --json " + name,
          "operate " + scene + " " + script_file + " --fields " + name, "superpose " + name + " " + name,
          "run " + scene + " --headless --seconds 1 --record " + name,
          "run " + scene + " --headless --seconds 1 --calibration " + name,
          "calibrate stylus x.lcm --from " + name + " --out " + path("c.toml"), "procedure bilobed --out " + name,
          "procedure bilobed --plan " + name, "emulate " + scene + " " + script_file + " --out " + name})
      expect_refused(call, {tail});
    if (name.find("absent") == std::string::npos)
      expect_refused("operate " + scene + " " + script_file + " --out " + name, {tail});
  }
}

TEST_F(CliHostile, TerminalsAreGivenNoCommands) {
  const std::string escapes = "\\u001b]0;owned\\u0007\\u001b[2J\\u009b31mred";
  for (const std::string& call :
       {"check " + file("e.toml", "note = \"" + escapes + "\"\n" + small_scene()),
        "check " + file("e.jsonl", "{\"limberg_script\":1,\"scene\":\"" + scene + "\",\"note\":\"" + escapes +
                                       "\"}\n{\"action\":\"stage\",\"name\":\"" + escapes + "\"}\n"),
        "operate " + scene + " " +
            file("f.jsonl", "{\"limberg_script\":1,\"scene\":\"small\"}\n{\"action\":\"" + escapes + "\"}\n"),
        std::string("check '") +
            path("\x1b]0;owned\x07\xC2\x9B"
                 "2J.toml") +
            "'"}) {
    const Outcome o = run(call);
    EXPECT_NE((o.out + o.err).find("owned"), std::string::npos) << call << o.out << o.err;
    for (const std::string& text : {o.out, o.err}) {
      for (const char c : text) EXPECT_TRUE(c == '\n' || c == '\t' || uint8_t(c) >= ' ') << call << int(c);
      EXPECT_EQ(text.find("\xC2\x9B"), std::string::npos) << call;
    }
  }
}

TEST_F(CliHostile, AScriptThatCannotBeWrittenIsNotLeftInParts) {
  const std::string out = path("p.jsonl");
  const auto with_a_full_disk = [&](const std::string& also) {  // no file may grow
    const int s = std::system(("(trap '' XFSZ; ulimit -f 0; " + kProgram + " procedure bilobed --out " + out + also +
                               ") >/dev/null 2>" + path(".err"))
                                  .c_str());
    return WIFEXITED(s) ? WEXITSTATUS(s) : -1;
  };
  EXPECT_EQ(with_a_full_disk(""), 2);
  EXPECT_FALSE(fs::exists(out));
  EXPECT_EQ(run("procedure bilobed --out " + out).status, 0);
  const std::string text = slurp(out);
  expect_refused("procedure bilobed --out " + out, {"exists already", "--replace"});
  EXPECT_EQ(run("procedure bilobed --out " + out + " --replace").status, 0);
  EXPECT_EQ(slurp(out), text);
  EXPECT_EQ(with_a_full_disk(" --replace"), 2);
  EXPECT_EQ(slurp(out), text) << "the older file is lost";
}

/// Cuts done and undone again on skin that a stitch draws: what is left is as if they had never been.
TEST_F(CliHostile, AScriptDoesNotDependOnCutsThatWereUndone) {
  const std::string mid = file("mid.toml", R"(name = "mid"
note = "tiny block"
[body]
source = "block"
size_mm = [60,60,8]
skin_cell_mm = 2.5
tension_direction = [1, 0, 0]
[[layer]]
name = "skin"
thickness_mm = 1.5
young_kPa = 60
poisson = 0.45
density_kg_m3 = 1100
prestretch_along = 1.10
prestretch_across = 1.06
[[layer]]
name = "fat"
thickness_mm = 6.5
young_kPa = 15
poisson = 0.45
density_kg_m3 = 920
[lattice]
cell_mm = 6
[springs]
suture_N_per_mm = 20
hook_N_per_mm = 0.5
[solver]
iterations_per_step = 8
steps_per_s = 60
seed = 1
[tools]
max_depth_mm = 7
default_depth_mm = 3
default_spacing_mm = 4
)");
  const std::string before = R"({"action":"suture","a":[-3.46,-12.28],"b":[-16.27,-0.71]}
{"action":"incise","path":[[19.33,4.81],[-15.19,-3.66],[19.99,-18.25]],"depth_mm":3,"angle_deg":90}
)";
  const std::string undone = R"({"action":"incise","path":[[-10,15],[0,15]],"depth_mm":3}
{"action":"undo"}
)";
  const std::string after =
      R"({"action":"incise","path":[[20,20.46],[15.02,20.52],[8.97,-8.68],[11.28,10.42]],"depth_mm":3,"angle_deg":60}
)";
  const auto hashes = [&](const std::string& text) {
    const Outcome o = run("operate " + mid + " " + file("n.jsonl", script(text)) + " --json " + path("n.json"));
    EXPECT_TRUE(o.status == 0 || o.status == 3) << o.err;  // 3: what is left open is told
    const auto j = nlohmann::json::parse(slurp(path("n.json")));
    return j["topology_hash"].get<std::string>() + " " + j["state_hash"].get<std::string>();
  };
  const std::string plain = hashes(before + after);
  std::string pairs;
  for (int n = 1; n <= 4; ++n) {
    pairs += undone;
    EXPECT_EQ(hashes(before + pairs + after), plain) << n;
  }
}

}  // namespace test_cli_hostile
