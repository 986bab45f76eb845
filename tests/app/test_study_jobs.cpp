// Members of studies as jobs: their files, processes, and the program that goes on where it was stopped.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "app/program/places.h"
#include "app/study/member_file.h"
#include "app/study/processes.h"
#include "app/study/task_file.h"
#include "sim/base/error.h"

namespace limberg::study {
namespace test_study_jobs {

namespace fs = std::filesystem;

class Jobs : public ::testing::Test {
 protected:
  Jobs() {
    std::string name = (fs::temp_directory_path() / "limberg-jobs-XXXXXX").string();
    dir_ = mkdtemp(name.data());
  }
  ~Jobs() override { fs::remove_all(dir_); }
  std::string path(const std::string& name) const { return dir_ + "/" + name; }
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories(fs::path(path(name)).parent_path());
    std::ofstream(path(name), std::ios::binary) << text;
  }
  std::string slurp(const std::string& name) const {
    std::ifstream in(path(name), std::ios::binary);
    std::ostringstream s;
    s << in.rdbuf();
    return s.str();
  }
  /// Exit status; what it printed lies in .out and .err.
  int limberg(const std::string& arguments) const {
    const int s = std::system(
        (binary_dir() + "/limberg " + arguments + " >" + path(".out") + " 2>" + path(".err") + " </dev/null").c_str());
    return WIFEXITED(s) ? WEXITSTATUS(s) : 1000 + WTERMSIG(s);
  }
  std::string dir_;
  const Family& disc_ = find_family("disc");
  const std::string small_ = "study disc --set along=1.1,1.2 --set across=1.05 --set cell_mm=6 --set radius_mm=6 ";
};

TEST_F(Jobs, AMembersFileHoldsItsRowToTheLastBit) {
  const Values v{1.1, 1.0 / 3 + 1, 3.5, 10, 3, 0.495};
  MemberResult m;
  m.row.figures = {{"a", 0.1}, {"b", 1.0 / 3}, {"none", std::nan("")}};
  m.row.title = "a \"title\"";
  m.row.profile = {"curve", {1, 2}, {0.1, std::nan("")}, true};
  m.seconds = 1.5, m.program = 0x0123456789abcdef, m.inputs = ~uint64_t(0);
  write("members/x.json", member_text(disc_, v, m));
  const auto r = read_member(path("members/x.json"), disc_, v);
  ASSERT_TRUE(r);
  EXPECT_EQ(r->row.at("a"), 0.1);
  EXPECT_EQ(r->row.at("b"), 1.0 / 3);
  EXPECT_TRUE(std::isnan(r->row.at("none")));
  EXPECT_EQ(r->row.figures.size(), 3u);
  EXPECT_EQ(r->row.title, m.row.title);
  EXPECT_EQ(r->row.profile.x, m.row.profile.x);
  EXPECT_TRUE(std::isnan(r->row.profile.y[1]));
  EXPECT_EQ(r->program, m.program);
  EXPECT_EQ(r->inputs, m.inputs);
  EXPECT_TRUE(r->failure.empty());
  Values other = v;
  other[1] = 1.05;
  EXPECT_THROW(read_member(path("members/x.json"), disc_, other), InputError);
  EXPECT_THROW(read_member(path("members/x.json"), find_family("gape"), v), InputError);
  EXPECT_FALSE(read_member(path("members/none.json"), disc_, v));
}

TEST_F(Jobs, BrokenMembersAreRefused) {
  const Values v = members(disc_, {})[0];
  for (const char* text : {"", "{", "[]", "{\"study\":\"disc\"}", "{\"study\":3}", "null",
                           "[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[["}) {
    write("x.json", text);
    EXPECT_THROW(read_member(path("x.json"), disc_, v), InputError) << text;
  }
  EXPECT_THROW(members_in(dir_, disc_), InputError);  // no folder
  write("members/disc,along=1.json", "{}");
  EXPECT_THROW(members_in(dir_, disc_), InputError);
}

TEST_F(Jobs, ProcessesRunSeveralAtATimeAndSayHowTheyEnded) {
  std::vector<Process> all;
  for (const char* c : {"exit 0", "exit 7", "echo why >&2; exit 2", "kill -9 $$"})
    all.push_back({{"/bin/sh", "-c", c}, path("log" + std::to_string(all.size()))});
  all.push_back({{"/no/such/program"}, path("log4")});
  std::vector<int> status(all.size(), -99);
  size_t most = 0;
  run_processes(
      all, 2, {}, [&](size_t n) { most = std::max(most, n); }, [&](size_t i, int s) { status[i] = s; });
  EXPECT_EQ(status, (std::vector<int>{0, 7, 2, 1000 + SIGKILL, -1}));
  EXPECT_LE(most, 2u);
  EXPECT_EQ(slurp("log2"), "why\n");
}

TEST_F(Jobs, AnInterruptEndsThoseThatRunAndStartsNoMore) {
  std::vector<Process> all(4, {{"/bin/sleep", "600"}, path("log")});
  std::vector<int> status(4, -99);
  bool now = false;
  run_processes(
      all, 2, [&] { return now; }, [&](size_t running) { now = running == 2 || now; },
      [&](size_t i, int s) { status[i] = s; });
  EXPECT_EQ(status, (std::vector<int>{1000 + SIGTERM, 1000 + SIGTERM, -1, -1}));
}

TEST_F(Jobs, AStudyGoesOnFromTheMembersThatAreThere) {
  const std::string out = "--out " + path("o");
  ASSERT_EQ(limberg(small_ + out), 0) << slurp(".err");
  const std::string rows = slurp("o/rows.csv");
  const std::string first =
      path("o/members/disc,along=1.1,across=1.05,cell_mm=6,radius_mm=6,depth_mm=3,poisson=0.495.json");
  ASSERT_TRUE(fs::exists(first)) << slurp(".out");
  ASSERT_EQ(limberg(small_ + out), 0);
  EXPECT_NE(slurp(".err").find("2 members are there already"), std::string::npos);
  EXPECT_EQ(slurp("o/rows.csv"), rows);  // the times too: nothing ran
  // One taken away, one of another program: both are made again.
  fs::remove(first);
  ASSERT_EQ(limberg(small_ + out), 0);
  EXPECT_NE(slurp(".err").find("1 members are there already"), std::string::npos);
  std::string text = slurp(fs::relative(first, dir_).string());
  text.replace(text.find("\"program\": \"") + 12, 16, "0123456789abcdef");
  std::ofstream(first) << text;
  ASSERT_EQ(limberg(small_ + out), 0);
  EXPECT_NE(slurp(".err").find("1 members are there already"), std::string::npos);
}

TEST_F(Jobs, AMemberThatFailsDoesNotLoseTheOthers) {
  // Its file cannot be written: something that is no file is in its place.
  write("o/members/disc,along=1.2,across=1.05,cell_mm=6,radius_mm=6,depth_mm=3,poisson=0.495.json/x", "");
  EXPECT_EQ(limberg(small_ + "--out " + path("o")), 3);
  EXPECT_NE(slurp("o/rows.csv").find("\n1.1,"), std::string::npos);
  EXPECT_EQ(slurp("o/rows.csv").find("\n1.2,"), std::string::npos);
  EXPECT_NE(slurp(".err").find("along=1.2"), std::string::npos) << slurp(".err");
  EXPECT_NE(slurp("o/result.json").find("\"complete\": false"), std::string::npos);
}

TEST_F(Jobs, AJobListRunsElsewhereAndIsCollected) {
  ASSERT_EQ(limberg(small_ + "--list-jobs --out '" + path("there it is") + "'"), 0);
  const std::string list = slurp(".out");
  EXPECT_EQ(std::count(list.begin(), list.end(), '\n'), 2);
  write("list.sh", list);
  ASSERT_EQ(std::system(("sh " + path("list.sh")).c_str()), 0);
  ASSERT_EQ(limberg("study disc --collect '" + path("there it is") + "' --out " + path("o")), 0) << slurp(".err");
  const std::string rows = slurp("o/rows.csv");
  EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 3);
  // Members of another program are not mixed with these.
  const std::string one = "/members/disc,along=1.2,across=1.05,cell_mm=6,radius_mm=6,depth_mm=3,poisson=0.495.json";
  std::string text = slurp("there it is" + one);
  text.replace(text.find("\"program\": \"") + 12, 16, "0123456789abcdef");
  write("there it is" + one, text);
  EXPECT_EQ(limberg("study disc --collect '" + path("there it is") + "'"), 2);
  EXPECT_NE(slurp(".err").find("another program"), std::string::npos);
}

TEST_F(Jobs, AProcessThatTakesTooLongIsEnded) {
  ProcessPool pool(2);
  pool.add(7, {{"sleep", "600"}, path("log"), {}, 0.1});
  pool.add(8, {{"sh", "-c", "echo $0 out; echo err >&2"}, path("log8"), path("out8"), 60});
  std::map<size_t, int> status;
  while (!pool.idle()) pool.turn([&](size_t name, int s) { status[name] = s; });
  EXPECT_EQ(status, (std::map<size_t, int>{{7, kOverLimit}, {8, 0}}));
  EXPECT_EQ(slurp("out8"), "sh out\n");
  EXPECT_EQ(ask_program({"/no/such/program"}).status, kNotRun);
  const Answer a = ask_program({"sh", "-c", "echo 1; echo 2 >&2; exit 3"});
  EXPECT_EQ(a.status, 3);
  EXPECT_EQ(a.output + a.words, "1\n2\n");
}

// A member that hangs, or takes more memory than it may, is one that failed, in words; the others are done.
TEST_F(Jobs, LimitsMakeFailedMembersOfSlowAndLargeOnes) {
  // The largest disc of the finest cells: it takes seconds, so whoever looks every .02 s finds it running.
  const std::string slow =
      "study disc --set along=1.1,1.2 --set across=1.05 --set cell_mm=1.5 --set radius_mm=30 --set depth_mm=6 ";
  EXPECT_EQ(limberg(slow + "--limit 0.001 --retries 1 --out " + path("slow")), 3);
  EXPECT_NE(slurp(".err").find("took longer than 0.001 s"), std::string::npos) << slurp(".err");
  EXPECT_NE(slurp("slow/progress.log").find("0 of 2 done, 0 running, 2 failed, 2 tried again"), std::string::npos)
      << slurp("slow/progress.log");
  EXPECT_EQ(
      limberg("study disc --set along=1.1 --set across=1.05 --set cell_mm=2.5 --memory 16 --out " + path("large")), 3);
  EXPECT_NE(slurp(".err").find("memory"), std::string::npos) << slurp(".err");
}

TEST_F(Jobs, ATaskRunsTheMembersThatAreMissing) {
  const std::vector<Values> all = members(disc_, {"along=1.1,1.2", "across=1.05", "cell_mm=6", "radius_mm=6"});
  write("task", task_text({{&disc_, all[0]}, {&disc_, all[1]}}));
  const std::string call = "study disc --task " + path("task") + " --out " + path("o");
  ASSERT_EQ(limberg(call), 0) << slurp(".err");
  EXPECT_NE(slurp(".err").find("2 of 2 members to be run"), std::string::npos);
  const std::string file = member_file(path("o"), disc_, all[1], ".json");
  const auto before = fs::last_write_time(member_file(path("o"), disc_, all[0], ".json"));
  fs::remove(file);
  ASSERT_EQ(limberg(call), 0);
  EXPECT_NE(slurp(".err").find("1 of 2 members to be run"), std::string::npos);
  EXPECT_TRUE(fs::exists(file));
  EXPECT_EQ(fs::last_write_time(member_file(path("o"), disc_, all[0], ".json")), before);
  ASSERT_EQ(limberg(small_ + "--out " + path("o")), 0);  // and the study has them
  EXPECT_NE(slurp(".err").find("2 members are there already"), std::string::npos);
}

TEST_F(Jobs, ASampleGivesBandsAndIsTheSameAgain) {
  write("r.toml",
        "name = \"rubber\"\nstudy = \"disc\"\n[[parameter]]\nname = \"along\"\ndistribution = \"uniform\"\n"
        "low = 1.1\nhigh = 1.3\nsource = \"a test\"\n");
  const std::string call = "study disc --set across=1.05 --set cell_mm=6 --set radius_mm=6 --sample latin 6 --ranges " +
                           path("r.toml") + " --out ";
  ASSERT_EQ(limberg(call + path("o")), 0) << slurp(".err");
  EXPECT_NE(slurp(".out").find("for rubber"), std::string::npos) << slurp(".out");
  EXPECT_NE(slurp("o/result.json").find("\"uncertainty\""), std::string::npos);
  EXPECT_NE(slurp("o/report.html").find("for rubber"), std::string::npos);
  const std::string rows = slurp("o/rows.csv");
  EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 7);
  ASSERT_EQ(limberg(call + path("o") + " --jobs 1"), 0);
  EXPECT_NE(slurp(".err").find("6 members are there already"), std::string::npos);
  EXPECT_EQ(slurp("o/rows.csv"), rows);
}

TEST_F(Jobs, WithoutSlurmTheEngineSaysSo) {
  const std::string path_before = std::getenv("PATH");
  ::setenv("PATH", dir_.c_str(), 1);  // the call to limberg is an absolute one, by /bin/sh
  EXPECT_EQ(limberg(small_ + "--engine slurm --out " + path("o")), 2);
  ::setenv("PATH", path_before.c_str(), 1);
  EXPECT_NE(slurp(".err").find("there is no sbatch"), std::string::npos) << slurp(".err");
}

TEST_F(Jobs, BadCallsAreRefused) {
  EXPECT_EQ(limberg(small_ + "--engine cloud"), 2);
  EXPECT_EQ(limberg(small_ + "--engine slurm"), 2);  // where to?
  EXPECT_EQ(limberg(small_ + "--task " + path("none") + " --out " + path("o")), 2);
  EXPECT_EQ(limberg("study tissue --sample halton 8"), 2);
  EXPECT_EQ(limberg("study tissue --sample sobol 1"), 2);
  EXPECT_EQ(limberg("study tissue --sample sobol x"), 2);
  EXPECT_EQ(limberg("study tissue --sensitivity"), 2);
  EXPECT_EQ(limberg("study disc --sample sobol 8"), 2);  // the shipped ranges are of another study
  EXPECT_EQ(limberg("study tissue --sample sobol 8 --ranges " + path("none")), 2);
  EXPECT_EQ(limberg(small_ + "--member --out " + path("o")), 2);  // two members
  EXPECT_EQ(limberg(small_ + "--set across=1.05 --list-jobs"), 2);
  EXPECT_EQ(limberg("study disc --list-jobs"), 2);  // where to?
  EXPECT_EQ(limberg("study disc --collect " + path("nowhere")), 2);
  EXPECT_EQ(limberg("study disc --jobs 0"), 2);
}

}  // namespace test_study_jobs
}  // namespace limberg::study
