// What is shipped replays to what was recorded, bit for bit, with every instruction set that this machine has.
#include <nlohmann/json.hpp>

#include "app/program/places.h"
#include "sim/fem/solver/engine.h"
#include "tests/app/cli.h"
#include "tests/sim/skull/needs_bullet.h"

namespace test_shipped {

class Shipped : public Cli, public testing::WithParamInterface<std::tuple<const char*, const char*>> {};

TEST_P(Shipped, RecordingReplaysToTheRecordedBits) {
  const auto [name, set] = GetParam();
  if (!limberg::fem::find_kernels(set)) GTEST_SKIP() << "this machine does not have " << set;
  if (std::string(name) == "craniofacial") {
    LIMBERG_NEEDS_BULLET();
  }
  const Outcome o = run("replay " + (limberg::source_dir() + "/recordings/") + name + ".lcm --simd " + set +
                        " --workers 1 --json " + path("r.json"));
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(o.err.find("differs"), std::string::npos) << o.err;
  const auto j = nlohmann::json::parse(slurp(path("r.json")));
  EXPECT_GE(j["checkpoints"]["compared"].get<int>(), 20);
  EXPECT_EQ(j["checkpoints"]["equal"], j["checkpoints"]["compared"]);
}
INSTANTIATE_TEST_SUITE_P(Recordings, Shipped,
                         testing::Combine(testing::Values("rhomboid", "zplasty", "craniofacial"),
                                          testing::Values("plain", "avx2", "avx512")),
                         [](const auto& of) {
                           return std::string(std::get<0>(of.param)) + "_" + std::get<1>(of.param);
                         });

/// Operations on bones: each recorded hand replays to its bits, and has done what its lesson asks.
class ShippedBones : public Cli, public testing::WithParamInterface<const char*> {};

TEST_P(ShippedBones, RecordedHandMeetsItsLesson) {
  LIMBERG_NEEDS_BULLET();
  const std::string name = GetParam();
  const Outcome o = run("replay " + limberg::source_dir() + "/recordings/" + name + ".lcm --workers 1 --judge " + name +
                        " --json " + path("r.json"));
  EXPECT_EQ(o.status, 0) << o.out << o.err;
  const auto j = nlohmann::json::parse(slurp(path("r.json")));
  EXPECT_GE(j["checkpoints"]["compared"].get<int>(), 5);
  EXPECT_EQ(j["checkpoints"]["equal"], j["checkpoints"]["compared"]);
  EXPECT_EQ(j["lesson"]["all_met"], true) << j["lesson"].dump(1);
  EXPECT_GE(j["lesson"]["tolerances"].size(), 8u);
  EXPECT_FALSE(j["lesson"]["steps"].empty());
}
INSTANTIATE_TEST_SUITE_P(Recordings, ShippedBones,
                         testing::Values("le_fort_1", "sagittal_split", "genioplasty", "autorotation", "craniofacial"),
                         [](const auto& of) { return std::string(of.param); });

}  // namespace test_shipped
