#include "tests/bench/start/start.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/program/shipped.h"
#include "app/program/temporary_folder.h"
#include "app/result/output.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "tests/bench/start/child.h"
#include "tests/small_block.h"

namespace limberg::bench {

namespace {

// What belongs to parts that a session of skin without pictures does not have.
constexpr const char* kParts[] = {"Bullet", "LinearMath", "OSMesa",   "LLVM", "EGL",        "GLX",     "libGL",
                                  "glfw",   "X11",        "xcb",      "lcm",  "glib",       "gallium", "openblas",
                                  "lapack", "blas",       "gfortran", "gomp", "cholmod.so", "gdcm"};

int of_parts(const std::vector<std::string>& libraries) {
  return int(std::count_if(libraries.begin(), libraries.end(), [](const std::string& l) {
    return std::any_of(std::begin(kParts), std::end(kParts),
                       [&](const char* p) { return l.find(p) != std::string::npos; });
  }));
}

int64_t frames_drawn(const std::string& json_file) {
  const auto json = nlohmann::json::parse(read_whole_file(json_file), nullptr, false);
  const nlohmann::json::json_pointer frames("/render/frames");
  return json.contains(frames) ? json.at(frames).get<int64_t>() : -1;
}

}  // namespace

SuiteOutcome start(const StartSettings& set) {
  std::error_code ec;
  const std::string program = (std::filesystem::read_symlink("/proc/self/exe", ec).parent_path() / "limberg").string();
  const TemporaryFolder folder;
  const std::string loader = (folder.path() / "loader").string(), out = (folder.path() / "out").string(),
                    json = (folder.path() / "run.json").string(), tiny = (folder.path() / "tiny.toml").string();
  write_whole_file(tiny, test::small_block({}));
  SuiteOutcome o;
  Result& r = o.result;
  const auto add = [&](const std::string& name, const std::string& method, const ChildFigures& f, bool clock) {
    if (f.status != 0 && f.status != 3)
      throw InputError(program, 0, method + " of " + name + " failed; expected it not to");
    Row row;
    row.name = name, row.method = method;
    row.time_ms = 1000 * (clock ? f.until_line_s : f.took_s);
    row.error = f.peak_mb, row.error_unit = "MB";
    row.settings = fmt::format("{} libraries, {} of them of parts; {} {:.2f} s", f.libraries.size(),
                               of_parts(f.libraries), clock ? "in all" : "its whole run", f.took_s);
    row.reference = clock ? "time: until the session's clock runs; error: peak memory" : "time: all of it";
    r.rows.push_back(row);
    return f;
  };
  const auto wanted = [&](const std::string& name) {
    const bool yes = name.find(set.only) != std::string::npos;
    if (yes && set.progress) set.progress(name);
    return yes;
  };
  const auto session = [&](const std::string& scene) {
    return std::vector<std::string>{program,      "run",      scene,
                                    "--headless", "--device", "log:" + shipped_file("recordings/hand-tremor.lcm"),
                                    "--seconds",  "0.3"};
  };
  int64_t frames = 0, parts = 0;
  if (wanted("program")) add("program", "--version", run_child({program, "--version"}, loader), false);
  std::vector<std::string> scenes{tiny, "rhomboid"};
  if (!set.quick) scenes.insert(scenes.end(), {"zplasty", "cheek", "scalp", "craniofacial"});
  for (const std::string& scene : scenes) {
    const std::string name = scene == tiny ? "tiny" : scene;
    if (!wanted(name)) continue;
    const bool bones = scene == "scalp" || scene == "craniofacial";
    std::vector<std::string> words = session(scene);
    words.insert(words.end(), {"--json", json});
    const ChildFigures plain = add(name, "a session, nothing drawn", run_child(words, loader), true);
    frames += frames_drawn(json);
    if (!bones) parts += of_parts(plain.libraries);
    if (scene == tiny || scene == "rhomboid") {
      words = session(scene);
      words.insert(words.end(), {"--out", out});
      add(name, "a session with pictures", run_child(words, loader), true);
    }
    const std::string recording = shipped_file("recordings/" + name + ".lcm");
    if (scene != tiny && !recording.empty() && !set.quick)
      add(name, "replay --lockstep, all of it", run_child({program, "replay", recording, "--lockstep"}, loader), false);
  }
  const auto none = [&](const std::string& name, double value) {
    Bar b;
    b.name = name, b.value = value, b.bar = 0, b.larger_is_better = false, b.pass = value == 0, b.source = "issue 24";
    r.bars.push_back(b);
  };
  none("frames drawn that nobody sees", double(frames));
  none("libraries of other parts in sessions of skin", double(parts));
  for (const auto& [name, most] : {std::pair{"tiny", 484.0}, std::pair{"rhomboid", 677.0}})
    for (const Row& row : r.rows)
      if (row.name == name && row.method == "a session, nothing drawn") {
        Bar b;
        b.name = fmt::format("{}: peak memory, MB, against a quarter of what it was", name);
        b.value = row.error, b.bar = most / 4, b.larger_is_better = false, b.pass = b.value <= b.bar,
        b.source = "issue 24";
        r.bars.push_back(b);
      }
  return o;
}

}  // namespace limberg::bench
