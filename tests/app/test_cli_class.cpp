// `limberg class`: a class of emulated students on a small block, each with a fault of their own.
#include <signal.h>

#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "tests/app/cli.h"
#include "tests/app/report/xml_check.h"

namespace test_cli_class {

using nlohmann::json;

constexpr const char* kLesson = R"(lesson = "A spindle"
goal = "Close it."
scene = "small"
hints = ["Slowly."]
steps = ["Excise.", "Undermine.", "Close."]
[procedure]
name = "fusiform"
[procedure.values]
width_mm = 5
ratio = 3
[tolerance]
corner_mm = 2
suture_peak_N = 5
undos = 3
)";

class ClassCli : public Cli {
 protected:
  ClassCli() {
    file("small.toml", small_scene());
    file("lesson.toml", kLesson);
    fs::create_directories(dir_ / "class");
  }
  /// A script of the lesson's procedure, laid at a place.
  std::string plan(const std::string& name, const std::string& options) {
    const Outcome o =
        run("procedure fusiform --scene " + path("small.toml") + " --set width_mm=5 --set ratio=3 --undermine-mm 5 " +
            options + " --replace --out " + path(name + ".jsonl"));
    EXPECT_EQ(o.status, 0) << o.err;
    return slurp(dir_ / (name + ".jsonl"));
  }
  void student(const std::string& name, const std::string& script, int seed) {
    const std::string s = file(name + ".jsonl", script);
    const Outcome o = run("emulate " + path("small.toml") + " " + s + " --seed " + std::to_string(seed) + " --out " +
                          path(name == "expert" ? "expert.lcm" : "class/" + name + ".lcm"));
    ASSERT_TRUE(o.status == 0 || o.status == 3) << o.err;
  }
  std::string call(const std::string& more = "") const {
    return "class " + path("class") + " --lesson " + path("lesson.toml") + " --expert " + path("expert.lcm") +
           " --out " + path("out") + " " + more;
  }
  /// The table by name of student and column.
  std::map<std::string, std::map<std::string, std::string>> table() const {
    std::istringstream in(slurp(dir_ / "out/class.csv"));
    std::vector<std::string> head;
    std::map<std::string, std::map<std::string, std::string>> out;
    for (std::string line; std::getline(in, line);) {
      std::vector<std::string> cells;
      std::istringstream row(line + ",");
      for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
      if (head.empty()) {
        head = cells;
        continue;
      }
      EXPECT_EQ(cells.size(), head.size()) << line;
      for (size_t i = 0; i < head.size(); ++i) out[cells[0]][head[i]] = cells[i];
    }
    return out;
  }
  std::map<std::string, std::string> key() const {  // of a file's stem its pseudonym
    std::istringstream in(slurp(dir_ / "key.csv"));
    std::map<std::string, std::string> out;
    for (std::string line; std::getline(in, line);)
      if (const size_t comma = line.find(','); comma != std::string::npos && line != "name,file")
        out[fs::path(line.substr(comma + 1)).stem().string()] = line.substr(0, comma);
    return out;
  }
  std::map<std::string, fs::file_time_type> kept() const {
    std::map<std::string, fs::file_time_type> out;
    for (const auto& e : fs::directory_iterator(dir_ / "out/measured"))
      if (e.path().extension() == ".json") out[e.path().filename().string()] = e.last_write_time();
    return out;
  }
};

TEST_F(ClassCli, EachFaultIsOnThePageAndNobodysName) {
  const std::string as_planned = plan("p", "");
  student("expert", as_planned, 1);
  student("anna", as_planned, 2);
  student("bert", plan("q", "--at 3,2"), 3);
  student("carla", as_planned.substr(0, as_planned.find("{\"action\":\"suture\"")), 4);
  std::string slow = as_planned;
  for (size_t at = slow.find("\"seconds\":1.0"); at != std::string::npos; at = slow.find("\"seconds\":1.0", at + 1))
    slow.replace(at, 13, "\"seconds\":6.0");
  student("dora", slow, 5);
  // The folder of a session, judged by nobody; what is broken, and what is something else.
  fs::create_directories(dir_ / "class/emil");
  ASSERT_NE(run("replay " + path("class/anna.lcm") + " --json " + path("class/emil/result.json")).status, 1);
  file("class/broken.lcm", slurp(dir_ / "expert.lcm").substr(0, 3000));
  file("class/notes.txt", "who is who");
  const Outcome o = run(call("--key " + path("key.csv") + " --json " + path("r.json")));
  EXPECT_EQ(o.status, 3) << o.err;  // not all of the folder could be used
  EXPECT_NE(o.err.find("broken.lcm: left out: "), std::string::npos) << o.err;
  EXPECT_NE(o.err.find("notes.txt"), std::string::npos) << o.err;

  const auto rows = table();
  auto who = key();
  ASSERT_EQ(who.size(), 5u);
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_EQ(rows.at("expert").at("expert"), "1");
  const auto of = [&](const std::string& student, const std::string& column) {
    return rows.at(who.at(student)).at(column);
  };
  EXPECT_EQ(rows.at("expert").at("lesson_corner_mm_met"), "1");
  EXPECT_EQ(of("anna", "lesson_corner_mm_met"), "1");
  EXPECT_EQ(of("bert", "lesson_corner_mm_met"), "0");
  EXPECT_NEAR(std::stod(of("bert", "lesson_corner_mm")), std::hypot(3, 2), 0.6);
  EXPECT_EQ(of("anna", "stitches"), "3");
  EXPECT_EQ(of("carla", "stitches"), "0");
  EXPECT_EQ(of("carla", "step_3_closed_done"), "0");
  EXPECT_EQ(of("carla", "step_3_closed_s"), "");
  EXPECT_EQ(of("carla", "force_peak_N"), "");
  EXPECT_GT(std::stod(of("anna", "force_peak_N")), 0);
  EXPECT_LT(std::abs(std::stod(of("anna", "force_peak_x_mm"))), 8);  // on the wound
  // Ten seconds longer, in the two steps that follow the waits.
  const double longer = std::stod(of("dora", "total_s")) - std::stod(of("anna", "total_s"));
  EXPECT_NEAR(longer, 10, 0.5);
  double steps = 0;
  for (const char* c :
       {"step_1_defect_s", "step_2_undermined_s", "step_3_closed_s", "elsewhere_s", "taken_back_s", "afterwards_s"})
    steps += std::stod(of("dora", c));
  EXPECT_NEAR(steps, std::stod(of("dora", "total_s")), 1e-3);
  // The folder has the same patient at its end, and is judged as far as its figures go.
  EXPECT_EQ(of("emil", "kind"), "result");
  EXPECT_EQ(of("emil", "closure_force_N"), of("anna", "closure_force_N"));

  const std::string page = slurp(dir_ / "out/class.html"), result = slurp(dir_ / "out/result.json");
  EXPECT_EQ(limberg::test::xml_fault(page), "");
  for (const std::string name : {"anna", "bert", "carla", "dora", "emil", "broken"})
    for (const std::string& text : {page, result, slurp(dir_ / "out/class.csv")})
      EXPECT_EQ(text.find(name), std::string::npos) << name;
  const json r = json::parse(result);
  EXPECT_EQ(r["students"].size(), 6u);
  EXPECT_EQ(r["left_out"], 1);
  EXPECT_EQ(r["passed_over"], 1);
  EXPECT_FALSE(r["ok"].get<bool>());
  EXPECT_EQ(json::parse(slurp(dir_ / "r.json")), r);
  const auto wrong = [&](const std::string& what) {
    for (const json& w : r["wrong"])
      if (w["what"] == what) return w["wrong"].get<int>();
    return 0;
  };
  EXPECT_EQ(wrong("Corners of the cuts"), 1);
  EXPECT_GE(wrong("Step \"closed\" not done"), 1);  // stitches that lie elsewhere may be another

  // The same call again measures nothing, and says the same; one that is gone is measured again.
  const auto before = kept();
  EXPECT_EQ(before.size(), 5u);
  const Outcome again = run(call("--key " + path("key.csv") + " --json " + path("r.json")));
  EXPECT_EQ(again.status, 3);
  EXPECT_EQ(kept(), before);
  EXPECT_EQ(slurp(dir_ / "out/class.html"), page);
  file("out/measured/" + before.begin()->first, "{damaged");
  EXPECT_EQ(run(call("--key " + path("key.csv") + " --json " + path("r.json"))).status, 3);
  EXPECT_EQ(slurp(dir_ / "out/class.html"), page);

  // With names, by whoever asks for them.
  EXPECT_EQ(run(call("--names")).status, 3);
  EXPECT_NE(slurp(dir_ / "out/class.html").find("anna.lcm"), std::string::npos);
}

TEST_F(ClassCli, AnInterruptedCallGoesOn) {
  std::string script = plan("p", "");
  student("expert", script, 1);
  script.replace(script.find("\"seconds\":1.0"), 13, "\"seconds\":30.0");
  for (const int seed : {2, 3, 4}) student("s" + std::to_string(seed), script, seed);
  const std::string arguments = call();
  const pid_t child = fork();
  if (child == 0) {
    const std::string line = "exec " + kProgram + " " + arguments + " >" + path(".o") + " 2>" + path(".e");
    execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
    _exit(127);
  }
  const auto measured_one = [&] {
    std::error_code ec;
    for (fs::directory_iterator it(dir_ / "out/measured", ec), end; !ec && it != end; it.increment(ec))
      if (it->path().extension() == ".json") return true;
    return false;
  };
  for (int i = 0; i < 6000 && !measured_one(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status)) << slurp(dir_ / ".e");
  EXPECT_EQ(WEXITSTATUS(status), 3) << slurp(dir_ / ".e");
  const json r = json::parse(slurp(dir_ / "out/result.json"));
  EXPECT_GT(r["to_come"].get<int>(), 0);
  EXPECT_NE(slurp(dir_ / "out/class.html").find("Interrupted"), std::string::npos);
  const auto before = kept();
  EXPECT_GE(before.size(), 1u);
  EXPECT_LT(before.size(), 4u);

  EXPECT_EQ(run(arguments).status, 0);
  const auto after = kept();
  EXPECT_EQ(after.size(), 4u);
  for (const auto& [name, when] : before) EXPECT_EQ(after.at(name), when) << name << " was measured again";
  EXPECT_EQ(json::parse(slurp(dir_ / "out/result.json"))["to_come"], 0);
}

TEST_F(ClassCli, ScriptsAreMeasuredAndWrongCallsRefused) {
  const std::string s = plan("p", "");
  file("class/one.jsonl", s);
  file("class/two.jsonl", plan("q", "--at 3,2"));
  file("class/same.jsonl", s);
  std::string other = s;
  file("class/other.jsonl", "{\"limberg_script\":1,\"scene\":\"zplasty\"}\n{\"action\":\"stage\",\"name\":\"a\"}\n");
  const Outcome o =
      run("class " + path("class") + " --lesson " + path("lesson.toml") + " --no-expert --out " + path("out"));
  EXPECT_EQ(o.status, 3) << o.err;
  EXPECT_NE(o.err.find("byte for byte"), std::string::npos) << o.err;
  EXPECT_NE(o.err.find("is of the scene zplasty"), std::string::npos) << o.err;
  EXPECT_EQ(table().size(), 2u);
  for (const auto& [name, row] : table()) {
    EXPECT_EQ(row.at("kind"), "script");
    EXPECT_EQ(row.at("total_s"), "");  // there was no hand
    EXPECT_EQ(row.at("stitches"), "3");
  }
  fs::create_directories(dir_ / "empty");
  expect_refused("class " + path("class"), {"--out DIR"});
  expect_refused("class " + path("none") + " --out " + path("o"), {"is no folder"});
  expect_refused("class " + path("empty") + " --out " + path("o"), {"holds no session"});
  expect_refused("class " + path("class") + " --lesson nowhere --out " + path("o"), {"nowhere"});
  expect_refused("class " + path("class") + " --lesson " + path("lesson.toml") + " --expert " + path("none.lcm") +
                     " --out " + path("o"),
                 {"none.lcm"});
  file("mine.csv", "my,own\n1,2\n");
  expect_refused("class " + path("class") + " --out " + path("o") + " --key " + path("mine.csv"), {"mine.csv"});
}

}  // namespace test_cli_class
