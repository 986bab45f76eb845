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

}  // namespace test_shipped
