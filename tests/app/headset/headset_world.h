#pragma once
// A folder with a script for the runtime of the tests (openxr_runtime.cpp), and what that leaves there.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "render/image.h"

namespace limberg::testing {

class HeadsetWorld {
 public:
  explicit HeadsetWorld(const std::string& script) {
    std::string name = (std::filesystem::temp_directory_path() / "limberg-headset-XXXXXX").string();
    dir_ = mkdtemp(name.data());
    std::ofstream(dir_ / "script.txt") << script;
#ifdef LIMBERG_OPENXR_RUNTIME
    setenv("XR_RUNTIME_JSON", LIMBERG_OPENXR_RUNTIME, 1);
#endif
    setenv("LIMBERG_TEST_XR", (dir_ / "script.txt").c_str(), 1);
    setenv("LIMBERG_TEST_XR_OUT", dir_.c_str(), 1);
    setenv("XR_LOADER_DEBUG", "none", 1);
  }
  ~HeadsetWorld() {
    std::error_code ec;
    std::filesystem::remove_all(dir_, ec);
  }
  HeadsetWorld(const HeadsetWorld&) = delete;
  HeadsetWorld& operator=(const HeadsetWorld&) = delete;

  std::string file(const std::string& name) const { return (dir_ / name).string(); }
  std::string text(const std::string& name) const {
    std::ifstream in(dir_ / name);
    std::ostringstream s;
    s << in.rdbuf();
    return s.str();
  }
  std::string log() const { return text("log.txt"); }
  int count(const std::string& words) const {
    const std::string all = log();
    int n = 0;
    for (size_t at = all.find(words); at != std::string::npos; at = all.find(words, at + 1)) ++n;
    return n;
  }
  /// A picture that the runtime was given; empty: it was not.
  Image picture(const std::string& name) const {
    std::ifstream in(dir_ / name, std::ios::binary);
    std::string magic;
    int w = 0, h = 0, most = 0;
    if (!(in >> magic >> w >> h >> most) || magic != "P6") return {};
    in.get();
    Image image(w, h);
    in.read(reinterpret_cast<char*>(image.rgb.data()), std::streamsize(image.rgb.size()));
    return image;
  }

 private:
  std::filesystem::path dir_;
};

}  // namespace limberg::testing
