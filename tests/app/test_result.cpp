// result.json and the files around it: names, numbers, whole files or none.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/report/report_data.h"
#include "app/result/output.h"
#include "app/result/run_result.h"
#include "app/result/times.h"
#include "sim/base/error.h"

namespace limberg {
namespace test_result {

namespace fs = std::filesystem;

struct Folder {
  fs::path path = fs::temp_directory_path() / ("limberg-test-" + std::to_string(getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  std::string operator/(const std::string& name) const { return (path / name).string(); }
};

TEST(Result, NamesListsAndNumbers) {
  Result r("replay", "rhomboid");
  Histogram h;
  for (int i = 1; i <= 1000; ++i) h.add(i * 1000);
  write_fields(r, "/device/wake_us", times_of(h, 1e-3, {.p999 = true}));
  r.set("/stages/0/name", "one");
  r.set("/stages/1/name", "two \xff");  // not UTF-8: replaced, never thrown
  r.set("/metrics/bad", std::nan(""));
  r.set("/state_hash", hex(0x1234));
  const std::vector<float> values{0.1f, 1e-7f, INFINITY};
  r.set("/series/residual", std::span<const float>(values));
  const auto j = nlohmann::json::parse(r.text());
  EXPECT_TRUE(j["limberg"]["version"].is_string());
  EXPECT_TRUE(j["limberg"]["commit"].is_string());
  EXPECT_EQ(j["command"], "replay");
  EXPECT_GE(j["machine"]["cores"].get<int>(), 1);
  EXPECT_TRUE(j["ok"].get<bool>());
  EXPECT_NEAR(j["device"]["wake_us"]["p50"].get<double>(), 500, 17);  // a bucket is 1/32 wide
  EXPECT_EQ(j["device"]["wake_us"]["max"].get<double>(), 1000);
  EXPECT_FALSE(j["device"]["wake_us"].contains("p95"));
  ASSERT_TRUE(j["stages"].is_array());
  EXPECT_EQ(j["stages"][0]["name"], "one");
  EXPECT_EQ(j["state_hash"], "0000000000001234");
  EXPECT_TRUE(j["metrics"]["bad"].is_null());
  EXPECT_EQ(j["series"]["residual"][0].get<double>(), 0.1);
  EXPECT_TRUE(j["series"]["residual"][2].is_null());
}

TEST(Result, AStructIsWrittenAsItsFieldsSay) {
  Result r("operate", "");
  EXPECT_EQ(nlohmann::json::parse(r.text())["scene"], "") << "a Maybe that is empty text is there";
  write_fields(r, "/table", ResultTable{"t", "", {"a", "b", "c"}, {{"", "1", ""}, {"x", "", "y"}}});
  ResultRun run;
  run.scene_note = "", run.workers = 3, run.memory_mb = 2, run.lattice.nodes = 5;
  write_fields(r, "", run);
  write_fields(
      r, "/story",
      ResultStory{
          {}, {{}, std::vector<double>{}, {}, {}, {}}, {}, {}, unless_empty(std::vector<ResultRefusal>()), "", {}, ""});
  write_fields(r, "/balance", ResultBalance{{1.0 / 3, 0, 0}, {}, {}, 0});
  const auto j = nlohmann::json::parse(r.text());
  // Places in a list count: an empty cell of a table stays one.
  EXPECT_EQ(j["table"]["rows"], nlohmann::json::parse(R"([["", "1", ""], ["x", "", "y"]])"));
  EXPECT_FALSE(j["table"].contains("about"));
  EXPECT_EQ(j["scene_note"], "");
  EXPECT_EQ(j["workers"].dump(), "3");
  EXPECT_EQ(j["memory_mb"].dump(), "2.0");
  EXPECT_EQ(j["lattice"], nlohmann::json::parse(R"({"nodes": 5})"));
  for (const char* absent : {"device", "solver", "parts", "mode", "residual"})
    EXPECT_FALSE(j.contains(absent)) << absent;
  EXPECT_EQ(j["story"], nlohmann::json::parse(R"({"series": {"residual": []}})"));
  EXPECT_EQ(j["balance"]["hooks_N"][0].get<double>(), 1.0 / 3);
}

TEST(Result, TheReportReadsWhatWasWritten) {
  Result r("replay", "rhomboid");
  ResultRun run;
  run.scene_title = "Rhomboid", run.interrupted = true, run.parts = {"cutter"}, run.lattice.cell_mm = 3.5;
  run.device.late_ticks = 7, run.solver.residual = 1e-5, run.solver.step_ms.p95 = 9, run.render.frames = 11;
  run.latency_ms.sample_to_frame.p50 = 13;
  write_fields(r, "", run);
  ResultStory story = made_by("limberg replay x");
  story.stages = {{"cut", "stages/01-cut.png", "", 1.5, {}, 3, {}}};
  story.series.closure_N = {0, 1};
  write_fields(r, "", story);
  ResultPatient patient;
  patient.sutures.emplace().push_back({1, 0.5, 0.1, {}, {}, {1, 2, 3}, {}});
  write_fields(r, "/metrics", patient);
  ResultLesson lesson;
  lesson.title = "Close", lesson.tolerances = {{"dog_ear_mm", "mm", 2, 1, true, ""}}, lesson.all_met = true;
  write_fields(r, "/lesson", lesson);
  const ReportData d = read_report_data(r.text(), "result.json");
  EXPECT_EQ(d.command, "replay");
  EXPECT_EQ(d.scene_title, "Rhomboid");
  EXPECT_EQ(d.interrupted, true);
  EXPECT_EQ(d.lattice.cell_mm, 3.5);
  EXPECT_EQ(d.device.late_ticks, 7);
  EXPECT_EQ(d.residual, 1e-5) << "of a session its solver's";
  EXPECT_EQ(d.solver.step_ms.p95, 9);
  EXPECT_EQ(d.render.frames, 11);
  EXPECT_EQ(d.latency_ms.sample_to_frame.p50, 13);
  EXPECT_EQ(entries(d.parts), std::vector<std::string>{"cutter"});
  EXPECT_EQ(d.reproduce, "limberg replay x");
  ASSERT_EQ(d.stages.size(), 1u);
  EXPECT_EQ(d.stages[0].sutures, 3);
  EXPECT_EQ(d.series_closure_N, (std::vector<double>{0, 1}));
  ASSERT_EQ(d.sutures().size(), 1u);
  EXPECT_EQ(d.sutures()[0].at_mm, (std::vector<double>{1, 2, 3}));
  EXPECT_TRUE(entries(d.lesson.tolerances).at(0).met);
}

TEST(Output, RefusesWhatCannotBeWritten) {
  const Folder dir;
  EXPECT_NO_THROW(check_writable(dir / "new.json"));
  EXPECT_FALSE(fs::exists(dir / "new.json"));
  EXPECT_THROW(check_writable(dir / "no/such/folder/x.json"), InputError);
  EXPECT_THROW(check_writable(dir.path.string()), InputError);
  EXPECT_THROW(prepare_folder("/dev/null/out"), InputError);
  EXPECT_THROW(prepare_folder("/proc/limberg"), InputError);
  write_whole_file(dir / "file", "text");
  EXPECT_THROW(prepare_folder(dir / "file"), InputError);
  EXPECT_EQ(read_whole_file(dir / "file"), "text");
  EXPECT_THROW(read_whole_file(dir / "absent"), InputError);
  EXPECT_THROW(read_whole_file(dir.path.string()), InputError);
  EXPECT_THROW(read_whole_file(dir / "file", 3), InputError);
  EXPECT_THROW(write_whole_file("/dev/full", "text"), InputError);
}

TEST(Output, AnOldFileIsReplacedWholeAndNothingIsLeftBeside) {
  const Folder dir;
  write_whole_file(dir / "a", std::string(10'000, 'x'));
  write_whole_file(dir / "a", "new");
  EXPECT_EQ(read_whole_file(dir / "a"), "new");
  int files = 0;
  for ([[maybe_unused]] const auto& e : fs::directory_iterator(dir.path)) ++files;
  EXPECT_EQ(files, 1);
}

}  // namespace test_result
}  // namespace limberg
