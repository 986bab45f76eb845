#include <gtest/gtest.h>

#include "app/program/places.h"
#include "calibration/calibration.h"
#include "sim/base/error.h"
#include "tests/devices/samples.h"
#include "tests/devices/temporary.h"

namespace limberg {
namespace test_calibration {

TEST(Calibration, TheShippedIdentityIsTheDefault) {
  const Calibration c = load_calibration(source_dir() + "/calibration/identity.toml");
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
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(dice.normal(), dice.normal(), dice.normal(), dice.normal()).normalized();
    c.world_from_tracker_quat = {q.w(), q.x(), q.y(), q.z()};
    c.filter.stale_ms = 1 + 100 * dice.unit();
    c.device = "FASTRAK \"ft\"", c.date = "2026-11-21";
    c.glove.closed_mm = 20 * dice.unit(), c.glove.forefinger_tip_mm = Vec3(dice.normal(), 0, 3);
    if (k % 2) {
      c.distortion.nodes = {2, 3, 2};
      c.distortion.high_mm = Vec3(10, 20, 30 + dice.unit());
      for (int i = 0; i < 12; ++i)
        c.distortion.add_mm.push_back(Vec3(dice.normal(), dice.normal(), 1e-9 * dice.normal()));
    }
    save_calibration(c, dir / "c.toml");
    const Calibration d = load_calibration(dir / "c.toml");
    EXPECT_EQ(calibration_hash(c), calibration_hash(d)) << to_toml(c);
    EXPECT_EQ(c.name, d.name);
    EXPECT_EQ(c.device, d.device);
    EXPECT_EQ(c.date, d.date);
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
  EXPECT_NE(message(head + "[glove]\nopen_mm = 12\n").find("at least 5 above"), std::string::npos);
  EXPECT_NE(message(head + "[glove]\nfist = 1\n").find("unknown key \"fist\""), std::string::npos);
  EXPECT_NE(message(head + "[glove]\npointing = [1, 1, 0]\n").find("direction"), std::string::npos);
  EXPECT_NE(message(head + "[distortion]\nnodes = [2, 2, 2]\n").find("not whole"), std::string::npos);
  EXPECT_NE(message(head + "[distortion]\nnodes = [2, 2, 2]\nlow_mm = [0, 0, 0]\nhigh_mm = [1, 1, 1]\nadd_mm = [1]\n")
                .find("list of 24"),
            std::string::npos);
  EXPECT_NE(message(head + "[distortion]\nnodes = [2, 2.5, 2]\nlow_mm = [0, 0, 0]\nhigh_mm = [1, 1, 1]\nadd_mm = [1]\n")
                .find("nodes each way"),
            std::string::npos);
  EXPECT_NE(message(head + "stylus = 3\n").find("table"), std::string::npos);
  EXPECT_THROW(load_calibration("/no/such/file.toml"), InputError);
  EXPECT_THROW(load_calibration("/"), InputError);
  EXPECT_THROW(save_calibration({}, "/no/such/folder/c.toml"), InputError);
}

}  // namespace test_calibration
}  // namespace limberg
