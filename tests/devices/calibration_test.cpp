#include "calibration/calibration.h"

#include <gtest/gtest.h>

#include "sim/error.h"
#include "tests/devices/samples.h"
#include "tests/devices/temporary.h"

namespace limberg {
namespace {

TEST(Calibration, TheShippedIdentityIsTheDefault) {
  const Calibration c = load_calibration(LIMBERG_SOURCE_DIR "/calibration/identity.toml");
  EXPECT_EQ(calibration_hash(c), calibration_hash(Calibration{}));
  EXPECT_EQ(c.name, "identity");
}

TEST(Calibration, RoundTripToTheBit) {
  test::Dice dice{9};
  test::TemporaryFolder dir;
  for (int k = 0; k < 50; ++k) {
    Calibration c;
    c.name = "a \"quoted\" \\ name";
    c.tip_offset_mm = Vec3(dice.normal(), 100 * dice.normal(), 1e-7 * dice.normal());
    c.world_from_tracker_mm = Vec3(dice.normal(), 0, 1e3 * dice.unit());
    const Eigen::Quaterniond q = Eigen::Quaterniond(dice.normal(), dice.normal(), dice.normal(), dice.normal()).normalized();
    c.world_from_tracker_quat = {q.w(), q.x(), q.y(), q.z()};
    c.filter.stale_ms = 1 + 100 * dice.unit();
    save_calibration(c, dir / "c.toml");
    const Calibration d = load_calibration(dir / "c.toml");
    EXPECT_EQ(calibration_hash(c), calibration_hash(d)) << to_toml(c);
    EXPECT_EQ(c.name, d.name);
  }
}

TEST(Calibration, BadFilesSayWhatAndWhere) {
  const std::string head = "limberg_calibration = 1\n";
  auto message = [&](const std::string& text) -> std::string {
    try {
      parse_calibration(text, "c.toml");
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(message(head), "");
  EXPECT_NE(message("limberg_calibration = 2\n").find("version"), std::string::npos);
  EXPECT_NE(message("").find("version"), std::string::npos);
  EXPECT_NE(message(head + "x = [").find("c.toml:2"), std::string::npos);
  EXPECT_NE(message(head + "\n\ncolour = 1\n").find("c.toml:4: unknown key \"colour\""), std::string::npos);
  EXPECT_NE(message(head + "[filter]\nstale = 1\n").find("unknown key \"stale\""), std::string::npos);
  EXPECT_NE(message(head + "[filter]\nstale_ms = -1\n").find("stale_ms"), std::string::npos);
  EXPECT_NE(message(head + "[filter]\nstale_ms = nan\n").find("stale_ms"), std::string::npos);
  EXPECT_NE(message(head + "[filter]\nstale_ms = \"x\"\n").find("stale_ms"), std::string::npos);
  EXPECT_NE(message(head + "[stylus]\ntip_offset_mm = [1, 2]\n").find("list of 3"), std::string::npos);
  EXPECT_NE(message(head + "[stylus]\ntip_offset_mm = [1, 2, inf]\n").find("tip_offset_mm"), std::string::npos);
  EXPECT_NE(message(head + "[world]\nfrom_tracker_quat = [1, 1, 0, 0]\n").find("unit length"), std::string::npos);
  EXPECT_NE(message(head + "stylus = 3\n").find("table"), std::string::npos);
  EXPECT_THROW(load_calibration("/no/such/file.toml"), InputError);
  EXPECT_THROW(load_calibration("/"), InputError);
  EXPECT_THROW(save_calibration({}, "/no/such/folder/c.toml"), InputError);
}

}  // namespace
}  // namespace limberg
