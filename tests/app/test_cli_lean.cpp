// What a call does not need is not there: no picture is drawn that nobody sees, no library is loaded of a part that the
// scene has not, and a part that is missing is said in words.
#include <nlohmann/json.hpp>

#include "tests/app/cli.h"

namespace test_cli_lean {

/// What the loader tells of a call: every library that it opened, at its start or later.
class CliLean : public Cli {
 protected:
  std::string libraries(const std::string& arguments) const {
    fs::remove_all(path("loader")), fs::create_directory(path("loader"));
    const std::string call = "env -u DISPLAY -u WAYLAND_DISPLAY LD_DEBUG=libs LD_DEBUG_OUTPUT=" + path("loader/ld") +
                             " " + kProgram + " " + arguments + " >" + path("out.txt") + " 2>" + path("err.txt");
    const int s = std::system(call.c_str());
    EXPECT_EQ(WEXITSTATUS(s) % 3, 0) << arguments << "\n" << slurp(path("err.txt"));
    std::string all;
    for (const auto& e : fs::directory_iterator(path("loader"))) {
      std::ifstream in(e.path());
      for (std::string line; std::getline(in, line);)
        if (line.find("calling init: ") != std::string::npos) all += line.substr(line.rfind('/')) + "\n";
    }
    EXPECT_NE(all.find("libc.so"), std::string::npos) << "the loader says nothing";
    return all;
  }
  static std::string of_parts(const std::string& libraries) {
    std::string found;
    for (const char* part : {"Bullet", "LinearMath", "OSMesa", "LLVM", "EGL", "libGL", "gallium", "glfw", "X11", "xcb",
                             "lcm", "glib", "gdcm", "blas", "lapack", "gfortran", "libgomp"})
      if (libraries.find(part) != std::string::npos) found += std::string(part) + " ";
    return found;
  }
  static int64_t frames(const std::string& json_file) {
    return nlohmann::json::parse(slurp(json_file)).at("render").at("frames").get<int64_t>();
  }
};

TEST_F(CliLean, ASessionOfSkinThatNobodyLooksAtHasNoPartsAndDrawsNothing) {
  const std::string scene = file("small.toml", small_scene()),
                    s = file("s.jsonl", script("{\"action\":\"incise\",\"path\":[[-8,0],[8,0]],\"depth_mm\":4}\n"
                                               "{\"action\":\"stage\",\"name\":\"cut\"}\n")),
                    log = path("a.lcm"), json = path("a.json");
  EXPECT_EQ(of_parts(libraries("--version")), "");
  EXPECT_EQ(of_parts(libraries("emulate " + scene + " " + s + " --out " + log + " --json " + json)), "");
  EXPECT_EQ(frames(json), 0);
  EXPECT_EQ(of_parts(libraries("replay " + log + " --json " + json)), "");
  EXPECT_EQ(frames(json), 0);
  EXPECT_EQ(of_parts(libraries("replay " + log + " --realtime --json " + json)), "");
  EXPECT_EQ(frames(json), 0);
  EXPECT_EQ(of_parts(libraries("run " + scene + " --headless --device emulated:" + s + " --json " + json)), "");
  EXPECT_EQ(frames(json), 0);
  // With a folder for them there are pictures, by a driver; on a virtual clock still no frame that nobody sees.
  const std::string with_pictures = libraries("replay " + log + " --out " + path("out") + " --json " + json);
  EXPECT_EQ(frames(json), 0);
  EXPECT_EQ(of_parts(with_pictures).find("Bullet"), std::string::npos);
  if (!fs::exists(path("out/overview.png"))) GTEST_SKIP() << "no driver for pictures here";
  EXPECT_NE(of_parts(with_pictures), "");
}

TEST_F(CliLean, APartThatIsMissingIsSaid) {
  // The program alone, without what lies beside it.
  const std::string alone = path("limberg");
  fs::copy_file(kProgram, alone);
  const auto refused = [&](const std::string& arguments, const std::vector<std::string>& words) {
    const int s = std::system(("env -u DISPLAY -u WAYLAND_DISPLAY " + alone + " " + arguments + " >" + path("out.txt") +
                               " 2>" + path("err.txt") + " </dev/null")
                                  .c_str());
    EXPECT_EQ(WEXITSTATUS(s), 2) << arguments;
    const std::string err = slurp(path("err.txt"));
    EXPECT_EQ(err.rfind("limberg: ", 0), 0u) << err;
    for (const std::string& w : words) EXPECT_NE(err.find(w), std::string::npos) << "no \"" << w << "\" in: " << err;
  };
  const std::string s =
      file("s.jsonl", "{\"limberg_script\":1,\"scene\":\"scalp\"}\n{\"action\":\"stage\",\"name\":\"a\"}\n");
  refused("operate " + kSource + "/app/scenes/scalp.toml " + s, {"scalp.toml", "Bullet", "libbullet-dev"});
  refused("run " + file("small.toml", small_scene()) +
              " --headless --seconds 0.1 --device lcm-from-anywhere:udpm://239.255.76.67:7667?ttl=0",
          {"lcm", "liblcm1"});
  // A scene without bone needs none of them.
  const int whole = std::system((alone + " check " + path("small.toml") + " --plan >" + path("out.txt")).c_str());
  EXPECT_EQ(WEXITSTATUS(whole), 0);
}

}  // namespace test_cli_lean
