// The arrows of the house, read from the include lines of the tree:
//
//   library -> what is installed                 app -> render, devices, calibration, sim
//   render, devices -> sim's read-only parts     calibration -> itself and plain words
//   sim -> sim, and in sim only downwards; no thread, no clock, no lock but that of a lazy value
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "app/program/places.h"

namespace fs = std::filesystem;

namespace test_includes {

struct Include {
  std::string from;  // path from the root of the tree
  int line = 0;
  std::string target;  // between the quotes or brackets
};

std::string wing(const std::string& path) { return path.substr(0, path.find('/')); }
std::string part(const std::string& path) {  // "sim/fem" of "sim/fem/x.h"; "sim" of "sim/patient/world.h"
  const size_t last = path.rfind('/');
  return last == std::string::npos ? "" : path.substr(0, last);
}

std::vector<Include> parse(std::istream& in, const std::string& name) {
  std::vector<Include> found;
  std::string l;
  for (int line = 1; std::getline(in, l); ++line) {
    size_t i = l.find_first_not_of(" \t");
    if (i == std::string::npos || l[i] != '#') continue;
    i = l.find_first_not_of(" \t", i + 1);
    if (i == std::string::npos || l.compare(i, 7, "include") != 0) continue;
    const size_t a = l.find_first_of("<\"", i);
    if (a == std::string::npos) continue;
    const size_t b = l.find_first_of(">\"", a + 1);
    if (b != std::string::npos) found.push_back({name, line, l.substr(a + 1, b - a - 1)});
  }
  return found;
}

std::vector<Include> includes_of(const std::string& folder) {
  const fs::path root = limberg::source_dir();
  std::vector<fs::path> files;
  for (const auto& e : fs::recursive_directory_iterator(root / folder))
    if (e.is_regular_file() && (e.path().extension() == ".h" || e.path().extension() == ".cpp"))
      files.push_back(e.path());
  std::sort(files.begin(), files.end());
  std::vector<Include> all;
  for (const auto& f : files) {
    std::ifstream in(f);
    for (auto& i : parse(in, fs::relative(f, root).generic_string())) all.push_back(i);
  }
  return all;
}

bool own(const std::string& target) {
  static const std::set<std::string> wings{"app", "calibration", "devices", "library", "render", "sim", "tests"};
  return target.find('/') != std::string::npos && wings.contains(wing(target));
}

using Rule = std::function<bool(const Include&)>;
std::string offences(const std::vector<Include>& all, const Rule& allowed) {
  std::string text;
  for (const Include& i : all)
    if (!allowed(i)) text += i.from + ":" + std::to_string(i.line) + " includes " + i.target + "\n";
  return text;
}

// What devices and render may know of the patient.
bool read_only_sim(const std::string& t) {
  static const std::set<std::string> files{
      "sim/patient/snapshot.h",    "sim/patient/ground_index.h", "sim/patient/press.h",
      "sim/base/elementary.h",     "sim/base/error.h",           "sim/base/hash.h",
      "sim/base/part.h",           "sim/base/whole_file.h",      "sim/cutting/arrangement/surface_view.h",
      "sim/fem/model/fem_model.h", "sim/commands/command.h",     "sim/commands/head_command.h",
      "sim/commands/script.h"};
  return files.contains(t) || t.starts_with("sim/geometry/") || t.starts_with("sim/body/");
}

// Order of dependence inside sim: each part may include those named beside it, and its own. sim/base, and patient/
// above all others, are not listed: everybody may include the first, and the second everything.
const std::map<std::string, std::set<std::string>> kSim{
    {"sim/base", {}},
    {"sim/geometry", {}},
    {"sim/body", {"sim/geometry"}},
    {"sim/commands", {"sim/geometry", "sim/body"}},
    {"sim/cutting", {"sim/geometry", "sim/body"}},
    {"sim/fem", {"sim/geometry", "sim/body"}},
    {"sim/lattice", {"sim/geometry", "sim/body", "sim/cutting", "sim/fem"}},
    {"sim/contact", {"sim/geometry", "sim/body", "sim/cutting", "sim/fem", "sim/lattice"}},
    {"sim/skull", {"sim/geometry", "sim/fem", "sim/commands", "sim/measure"}},
    {"sim/imaging", {"sim/geometry", "sim/skull"}},
    {"sim/measure",
     {"sim/geometry", "sim/body", "sim/cutting", "sim/fem", "sim/lattice", "sim/skull", "sim/commands", "sim/patient"}},
    {"sim/testing", {"sim/geometry", "sim/body", "sim/fem", "sim/skull"}},
};

bool sim_rule(const Include& i) {
  static const std::set<std::string> forbidden{"thread",    "mutex",   "shared_mutex", "condition_variable", "future",
                                               "semaphore", "barrier", "latch",        "stop_token",         "chrono",
                                               "ctime",     "time.h",  "sys/time.h",   "pthread.h"};
  // A value that is found when it is first asked for is found once, whichever thread asks first; no thread of sim waits
  // for it but the one that needs it.
  static const std::set<std::string> lazy{"sim/base/lazy.h", "sim/patient/point_depths.h"};
  if (i.target == "mutex" && lazy.contains(i.from)) return true;
  if (forbidden.contains(i.target)) return false;
  if (!own(i.target)) return true;
  if (wing(i.target) != "sim") return false;
  std::string p = part(i.from);
  while (p.size() > 3 && !kSim.contains(p)) p = part(p);  // folders inside a part belong to it
  const auto rule = kSim.find(p);
  if (rule == kSim.end()) return !i.target.starts_with("sim/testing/");  // sim/patient sees everything but oracles
  if (p == "sim/skull" && i.target == "sim/patient/snapshot.h") return true;
  std::string q = part(i.target);
  while (q.size() > 3 && !kSim.contains(q) && q != "sim/patient") q = part(q);
  return q == p || q == "sim/base" || rule->second.contains(q);
}

bool devices_rule(const Include& i) {
  if (!own(i.target)) return true;
  const std::string w = wing(i.target);
  return w == "devices" || w == "calibration" || read_only_sim(i.target);
}
bool render_rule(const Include& i) { return !own(i.target) || wing(i.target) == "render" || read_only_sim(i.target); }
// Calibration links nothing of sim; it shares only the words of the house: vectors, errors, hashes, files.
bool calibration_rule(const Include& i) {
  static const std::set<std::string> words{"sim/geometry/vec.h", "sim/base/error.h", "sim/base/hash.h",
                                           "sim/base/whole_file.h"};
  return !own(i.target) || wing(i.target) == "calibration" || words.contains(i.target);
}

// What others link sees of app/ only what is installed with it: nothing of windows, reports or sessions.
bool library_rule(const Include& i) {
  static const std::set<std::string> apps{"app/assembly/bundle.h",           "app/assembly/operation.h",
                                          "app/assembly/patient_of_scene.h", "app/program/shipped.h",
                                          "app/program/version.h",           "app/session/workers_pool.h"};
  if (!own(i.target)) return true;
  const std::string w = wing(i.target);
  return w == "library" || w == "sim" || w == "devices" || w == "calibration" || i.target.starts_with("app/scene/") ||
         apps.contains(i.target);
}
// No other folder includes the library: it is made of them.
bool no_library(const Include& i) { return !own(i.target) || wing(i.target) != "library"; }

TEST(Includes, SimKnowsNoClockNoThreadNoOtherWing) { EXPECT_EQ(offences(includes_of("sim"), sim_rule), ""); }
TEST(Includes, DevicesSeeOnlyReadOnlySim) { EXPECT_EQ(offences(includes_of("devices"), devices_rule), ""); }
TEST(Includes, RenderSeesOnlyReadOnlySim) { EXPECT_EQ(offences(includes_of("render"), render_rule), ""); }
TEST(Includes, CalibrationStandsAlone) { EXPECT_EQ(offences(includes_of("calibration"), calibration_rule), ""); }

TEST(Includes, TheLibrarySeesWhatIsInstalled) {
  EXPECT_EQ(offences(includes_of("library"), library_rule), "");
  for (const char* folder : {"app", "calibration", "devices", "render", "sim"})
    EXPECT_EQ(offences(includes_of(folder), no_library), "");
}

TEST(Includes, HeavyHeadersStayOutOfHeaders) {
  const auto light = [](const Include& i) {
    // Those three exist to be included by .cpp files.
    if (!i.from.ends_with(".h") || i.from == "calibration/toml.h" || i.from == "app/commands/numbers.h" ||
        i.from == "app/result/read_result.h")
      return true;
    for (const char* heavy :
         {"nlohmann/", "toml++/", "CLI/", "Eigen/Dense", "Eigen/Sparse", "Eigen/Eigenvalues", "Eigen/SVD"})
      if (i.target.starts_with(heavy)) return false;
    return true;
  };
  std::string text;
  for (const char* folder : {"app", "calibration", "devices", "render", "sim"})
    text += offences(includes_of(folder), light);
  EXPECT_EQ(text, "");
}

// The rules themselves see an arrow that points the wrong way.
TEST(Includes, WrongArrowsAreSeen) {
  const auto refused = [](const Rule& r, const std::string& from, const std::string& target) {
    return !r({from, 1, target});
  };
  EXPECT_TRUE(refused(sim_rule, "sim/fem/solver.cpp", "thread"));
  EXPECT_TRUE(refused(sim_rule, "sim/patient/world.cpp", "chrono"));
  EXPECT_TRUE(refused(sim_rule, "sim/patient/world.cpp", "devices/sample.h"));
  EXPECT_TRUE(refused(sim_rule, "sim/fem/solver.cpp", "sim/patient/world.h"));
  EXPECT_TRUE(refused(sim_rule, "sim/fem/solver.cpp", "sim/cutting/strokes/blade.h"));
  EXPECT_TRUE(refused(sim_rule, "sim/geometry/bvh.h", "sim/fem/model/fem_model.h"));
  EXPECT_TRUE(refused(devices_rule, "devices/cursor.h", "sim/patient/world.h"));
  EXPECT_TRUE(refused(devices_rule, "devices/cursor.h", "sim/fem/solver/elastic_solver.h"));
  EXPECT_TRUE(refused(devices_rule, "devices/cursor.h", "app/session/session.h"));
  EXPECT_TRUE(refused(render_rule, "render/scene.cpp", "devices/sample.h"));
  EXPECT_TRUE(refused(calibration_rule, "calibration/pivot.h", "sim/geometry/bvh.h"));
  EXPECT_TRUE(refused(library_rule, "library/python/world.cpp", "app/report/report.h"));
  EXPECT_FALSE(refused(library_rule, "library/python/world.cpp", "app/scene/scene.h"));
  EXPECT_TRUE(refused(sim_rule, "sim/lattice/embedding.h", "sim/contact/contact_finder.h"));
  EXPECT_TRUE(refused(sim_rule, "sim/measure/penetration.cpp", "sim/contact/contact_finder.h"));
  EXPECT_FALSE(refused(sim_rule, "sim/patient/world.cpp", "sim/fem/solver/elastic_solver.h"));
  EXPECT_FALSE(refused(devices_rule, "devices/cursor.h", "sim/geometry/bvh.h"));
  std::istringstream text(
      "  #  include <thread>\n// #include <mutex>\n#include \"sim/patient/world.h\" // x\n#define include\n");
  const auto got = parse(text, "f");
  ASSERT_EQ(got.size(), 2u);
  EXPECT_EQ(got[0].target, "thread");
  EXPECT_EQ(got[1].line, 3);
}

}  // namespace test_includes
