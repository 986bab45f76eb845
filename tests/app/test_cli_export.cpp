// `limberg export` of skin: files for other programs, with the session's own numbers, and none that is half.
#include <signal.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/app/cli.h"

namespace test_cli_export {

using nlohmann::json;

class Export : public Cli {
 protected:
  /// A small block that is cut, stitched, and measured: the folder of its operate.
  std::string operated() {
    const std::string scene = file("small.toml", small_scene());
    const std::string s = file("s.jsonl", script(R"({"action":"incise","path":[[-10,0],[10,0]],"depth_mm":3}
{"action":"stage","name":"cut, \"open\""}
{"action":"suture","a":[0,1],"b":[0,-1]}
{"action":"stage","name":"closed"}
)"));
    const Outcome o = run("operate " + scene + " " + s + " --out " + path("op"));
    EXPECT_TRUE(o.status == 0 || o.status == 3) << o.err;
    return path("op");
  }
  std::vector<std::string> names_in(const std::string& folder) const {
    std::vector<std::string> out;
    for (const auto& e : fs::recursive_directory_iterator(folder))
      if (e.is_regular_file()) out.push_back(fs::relative(e.path(), folder).string());
    std::sort(out.begin(), out.end());
    return out;
  }
};

/// Rows of a table; commas in quotes are part of a word.
std::vector<std::vector<std::string>> table(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    std::vector<std::string> row{""};
    bool quoted = false;
    for (size_t i = 0; i < line.size(); ++i)
      if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
        row.back() += line[i++];
      else if (line[i] == '"')
        quoted = !quoted;
      else if (line[i] == ',' && !quoted)
        row.emplace_back();
      else
        row.back() += line[i];
    rows.push_back(row);
  }
  return rows;
}

TEST_F(Export, HasTheSessionsOwnNumbers) {
  const std::string op = operated();
  const Outcome o = run("export " + op + " --at all --out " + path("x"));
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(names_in(path("x")),
            (std::vector<std::string>{
                "01-cut-open/lattice.vtu", "01-cut-open/skin.ply", "01-cut-open/skin.stl", "01-cut-open/skin.vtp",
                "02-closed/lattice.vtu", "02-closed/skin.ply", "02-closed/skin.stl", "02-closed/skin.vtp",
                "03-end/lattice.vtu", "03-end/skin.ply", "03-end/skin.stl", "03-end/skin.vtp", "forces.csv",
                "lattice.pvd", "measures.csv", "operation.glb", "report.html", "result.json", "skin.pvd"}));
  const json was = json::parse(slurp(op + "/result.json")), x = json::parse(slurp(path("x/result.json")));
  // The end of the export is that of the operation, to the bit and in every figure.
  EXPECT_EQ(x["moments"][2]["state_hash"], was["state_hash"]);
  const auto rows = table(slurp(path("x/measures.csv")));
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[1][0], "cut, \"open\"");
  EXPECT_EQ(rows[3][2], was["state_hash"].get<std::string>());
  int compared = 0;
  for (size_t k = 3; k < rows[0].size(); ++k) {
    ASSERT_EQ(rows[3].size(), rows[0].size());
    if (!was["metrics"].contains(rows[0][k])) {
      EXPECT_EQ(rows[3][k], "") << rows[0][k];
      continue;
    }
    EXPECT_NEAR(std::stod(rows[3][k]), was["metrics"][rows[0][k]].get<double>(),
                1e-5 * std::abs(was["metrics"][rows[0][k]].get<double>()) + 1e-12)
        << rows[0][k];
    ++compared;
  }
  EXPECT_GT(compared, 25);
  // The stitch is in the table of forces, at the end with the force that the result says.
  const auto forces = table(slurp(path("x/forces.csv")));
  EXPECT_EQ(forces.back()[1], "end");
  EXPECT_EQ(forces.back()[2], "stitch");
  EXPECT_NEAR(std::stod(forces.back()[5]), was["metrics"]["closure_force_N"].get<double>(), 1e-5);
  const std::string glb = slurp(path("x/operation.glb"));
  EXPECT_EQ(glb.substr(0, 4), "glTF");
}

TEST_F(Export, OneMomentSomeKinds) {
  const std::string op = operated();
  ASSERT_EQ(run("export " + op + " --at closed --only vtk,csv --out " + path("v")).status, 0);
  EXPECT_EQ(names_in(path("v")), (std::vector<std::string>{"forces.csv", "lattice.vtu", "measures.csv", "report.html",
                                                           "result.json", "skin.vtp"}));
  // A script by itself is carried out as operate does.
  const Outcome o =
      run("export " + path("s.jsonl") + " --scene " + path("small.toml") + " --only csv --out " + path("s"));
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(json::parse(slurp(path("s/result.json")))["moments"][0]["state_hash"],
            json::parse(slurp(op + "/result.json"))["state_hash"]);
  expect_refused("export " + op + " --only pictures --out " + path("p"), {"pictures"});
  expect_refused("export " + path("s.jsonl") + " --out " + path("p"), {"small"});
  expect_refused("export " + op + " --at never --out " + path("p"), {"never", "closed"});
}

TEST_F(Export, OfARecordingHasThePathOfTheHand) {
  const std::string scene = file("small.toml", small_scene());
  const std::string s = file("s.jsonl", script(R"({"action":"incise","path":[[-10,0],[10,0]],"depth_mm":3}
{"action":"stage","name":"cut"}
)"));
  ASSERT_EQ(run("emulate " + scene + " " + s + " --out " + path("e.lcm")).status, 0);
  const Outcome o = run("export " + path("e.lcm") + " --at all --only csv,glb --out " + path("x"));
  ASSERT_EQ(o.status, 0) << o.err;
  const auto hands = table(slurp(path("x/hands.csv")));
  ASSERT_GT(hands.size(), 50u);
  // The tip passes along the cut: 20 mm with the scalpel engaged.
  double path_mm = 0;
  const std::vector<std::string>* last = nullptr;
  for (size_t i = 1; i < hands.size(); ++i) {
    const auto& r = hands[i];
    if (r[2] != "scalpel" || r[3] != "1") {
      last = nullptr;
      continue;
    }
    if (last) path_mm += std::hypot(std::stod(r[4]) - std::stod((*last)[4]), std::stod(r[5]) - std::stod((*last)[5]));
    last = &r;
  }
  EXPECT_NEAR(path_mm, 20, 2);
  const json x = json::parse(slurp(path("x/result.json")));
  EXPECT_GT(x["moments"][0]["t_s"].get<double>(), 0);
  EXPECT_EQ(std::stod(table(slurp(path("x/measures.csv")))[1][1]), x["moments"][0]["t_s"].get<double>());
}

// Whenever an export is interrupted: each file in its folder is whole, and none of the whole operation is there.
TEST_F(Export, InterruptedLeavesNoHalfFile) {
  const std::string op = operated();
  ASSERT_EQ(run("export " + op + " --at all --out " + path("whole")).status, 0);
  for (const char* seconds : {"0.05", "0.2", "0.5", "1"}) {
    const std::string to = path(std::string("cut-") + seconds);
    // (an interrupt that comes when all is written changes nothing: the status is that of the program, not timeout's)
    const int s = std::system(("timeout --preserve-status -s INT " + std::string(seconds) + " " + kProgram +
                               " export " + op + " --at all --out " + to + " >/dev/null 2>&1")
                                  .c_str());
    const bool ended = WIFEXITED(s) && WEXITSTATUS(s) == 0;
    if (!fs::exists(to)) continue;
    for (const std::string& name : names_in(to)) {
      if (name == "result.json" || name == "report.html") {
        EXPECT_TRUE(ended);
        continue;
      }
      EXPECT_EQ(slurp(to + "/" + name) == slurp(path("whole/" + name)), true) << name << " after " << seconds << " s";
    }
    if (!ended) {
      EXPECT_FALSE(fs::exists(to + "/operation.glb"));
    }
  }
}

}  // namespace test_cli_export
