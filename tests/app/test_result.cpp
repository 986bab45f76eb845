// result.json and the files around it: names, numbers, whole files or none.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/result/output.h"
#include "app/result/result.h"
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
  r.set_times("/device/wake_us", h, 1e-3, {.p999 = true});
  r.set("/stages/0/name", "one");
  r.set("/stages/1/name", "two \xff");  // not UTF-8: replaced, never thrown
  r.set("/metrics/bad", std::nan(""));
  r.set_hash("/state_hash", 0x1234);
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
