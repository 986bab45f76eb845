#pragma once
// The program as a user calls it: files in a folder of its own, a call, what it said and how it ended.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "app/program/places.h"
#include "tests/small_block.h"

namespace fs = std::filesystem;

inline const std::string kProgram = limberg::binary_dir() + "/limberg";
inline const std::string kSource = limberg::source_dir();

struct Outcome {
  int status = -1;  // exit status; 1000 + signal when killed by one
  std::string out, err;
  int lines() const { return int(std::count(err.begin(), err.end(), '\n')); }
};

inline std::string slurp(const fs::path& p) {
  std::ifstream in(p, std::ios::binary);
  std::ostringstream s;
  s << in.rdbuf();
  return s.str();
}

class Cli : public ::testing::Test {
 protected:
  Cli() {
    std::string name = (fs::temp_directory_path() / "limberg-cli-XXXXXX").string();
    dir_ = mkdtemp(name.data());
  }
  ~Cli() override { fs::remove_all(dir_); }

  std::string file(const std::string& name, const std::string& text) const {
    std::ofstream(dir_ / name, std::ios::binary) << text;
    return (dir_ / name).string();
  }
  std::string path(const std::string& name) const { return (dir_ / name).string(); }

  Outcome run(const std::string& arguments) const {
    const std::string out = path(".out"), err = path(".err");
    const int s = std::system(
        ("env -u DISPLAY -u WAYLAND_DISPLAY " + kProgram + " " + arguments + " >" + out + " 2>" + err + " </dev/null")
            .c_str());
    Outcome o;
    o.status = WIFEXITED(s) ? WEXITSTATUS(s) : 1000 + WTERMSIG(s);
    o.out = slurp(out), o.err = slurp(err);
    return o;
  }

  /// Exit 2, one line, in the house's form, that holds every given word.
  void expect_refused(const std::string& arguments, const std::vector<std::string>& words) const {
    Outcome o = run(arguments);
    // How far a call is stands in a log every ten seconds ("limberg: patient: bone"), here and there before a refusal.
    const std::string progress = "limberg: " + arguments.substr(0, arguments.find(' ')) + ": ";
    while (o.lines() > 1 && o.err.starts_with(progress)) o.err.erase(0, o.err.find('\n') + 1);
    EXPECT_EQ(o.status, 2) << arguments << "\n" << o.err;
    EXPECT_EQ(o.lines(), 1) << arguments << "\n" << o.err;
    EXPECT_EQ(o.err.rfind("limberg: ", 0), 0u) << o.err;
    for (const std::string& w : words)
      EXPECT_NE(o.err.find(w), std::string::npos) << arguments << "\nno \"" << w << "\" in: " << o.err;
  }

  static std::string small_scene(const std::string& change = "", const std::string& to = "") {
    std::string s = limberg::test::small_block({.name = "small", .prestretch_along = "1.08"});
    if (!change.empty()) s.replace(s.find(change), change.size(), to);
    return s;
  }
  static std::string script(const std::string& lines) { return "{\"limberg_script\":1,\"scene\":\"small\"}\n" + lines; }

  fs::path dir_;
};
