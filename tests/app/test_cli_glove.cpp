// The glove does it all, as a user calls it: emulated, recorded, replayed; calibrated from streams.
#include <cmath>
#include <nlohmann/json.hpp>

#include "calibration/calibration.h"
#include "devices/recording.h"
#include "sim/skull/simplex/file.h"
#include "sim/skull/simplex/generators.h"
#include "sim/skull/simplex/mesh.h"
#include "tests/app/cli.h"
#include "tests/sim/skull/needs_bullet.h"

namespace test_cli_glove {

using limberg::Calibration, limberg::CommandSample, limberg::load_calibration, limberg::read_recording, limberg::Sample,
    limberg::StylusSample, limberg::Vec3;
namespace simplex = limberg::simplex;

class GloveAlone : public Cli {
 protected:
  nlohmann::json json(const std::string& name) const { return nlohmann::json::parse(slurp(path(name))); }
  /// A ball of bone of radius 40 (and another bone, which holds it) as files beside a scene.
  std::string ball_scene() const {
    simplex::Mesh ball = simplex::make_sphere({0, 0, 0}, 40, 3), anvil = simplex::make_sphere({0, 0, -200}, 20, 2);
    for (simplex::Mesh* m : {&ball, &anvil}) simplex::record_shape(*m);
    simplex::save_mesh(ball, path("ball.txt")), simplex::save_mesh(anvil, path("anvil.txt"));
    return file("ball.toml", "name = \"ball\"\n[head]\nsource = \"files\"\nbones = [\"anvil.txt\", \"ball.txt\"]\n");
  }
};

// An emulated hand points at the bone, pushes the surface cursor round a ring with its forefinger, grabs what it has
// sawn out and carries it 8 mm. The recording has no stylus; its replay ends in the same bits.
TEST_F(GloveAlone, SawsAndCarriesAndReplaysToTheSameBits) {
  LIMBERG_NEEDS_BULLET();
  const std::string scene = ball_scene();
  std::string contour;
  for (int i = 0; i < 48; ++i) {
    const double w = i * M_PI / 24;
    contour += (i ? ",[" : "[") + std::to_string(25 * std::cos(w)) + "," +
               std::to_string(std::sqrt(40. * 40 - 25 * 25)) + "," + std::to_string(25 * std::sin(w)) + "]";
  }
  const std::string script = file(
      "s.jsonl", "{\"limberg_script\":1,\"scene\":\"ball\"}\n{\"action\":\"osteotomy\",\"contour\":[" + contour +
                     "]}\n{\"action\":\"move_fragment\",\"fragment\":[0,40,0],\"translation_mm\":[0,8,0],\"seconds\":"
                     "1.5}\n{\"action\":\"stage\",\"name\":\"moved\"}\n");
  const std::string log = path("glove.lcm");
  Outcome o = run("emulate " + scene + " " + script + " --glove --seed 5 --out " + log + " --json " + path("e.json"));
  ASSERT_EQ(o.status, 0) << o.err;
  for (const Sample& s : read_recording(log).samples) {
    EXPECT_FALSE(std::holds_alternative<StylusSample>(s));
    EXPECT_FALSE(std::holds_alternative<CommandSample>(s));
  }
  const auto made = json("e.json");
  const auto& fragments = made["head"]["fragments"];
  ASSERT_EQ(fragments.size(), 3u);
  const auto& piece = fragments[2];
  EXPECT_NEAR(double(piece["translation_mm"][1]), 8, 1);  // the hand's tremor and noise, and what it met
  // A cap of 25 mm radius off a ball of 40: h = 40 - sqrt(40^2 - 25^2), V = pi h^2 (40 - h / 3). The line is drawn to
  // some tenths of a mm, of 157 mm around: 3 % are 0.4 mm everywhere.
  const double h = 40 - std::sqrt(40. * 40 - 25 * 25), cap = M_PI * h * h * (40 - h / 3);
  EXPECT_NEAR(double(piece["volume_mm3"]), cap, 0.03 * cap);
  std::printf("%.0f of %.0f mm^3\n", double(piece["volume_mm3"]), cap);
  for (const int workers : {1, 2}) {
    o = run("replay " + log + " --json " + path("r.json") + " --workers " + std::to_string(workers));
    ASSERT_EQ(o.status, 0) << o.err;
    const auto r = json("r.json");
    EXPECT_EQ(r["state_hash"], made["state_hash"]);
    EXPECT_EQ(r["checkpoints"]["compared"], r["checkpoints"]["equal"]);
    EXPECT_GT(int(r["checkpoints"]["compared"]), 5);
    EXPECT_EQ(r["head"]["fragments"], fragments);
  }
  expect_refused("emulate rhomboid " + kSource + "/recordings/rhomboid.jsonl --glove --out " + path("no.lcm"),
                 {"--glove", "[head]"});
}

// Tip and direction of a forefinger, and the tip of a thumb, from streams whose truth is known (devices/rehearsal.h).
TEST_F(GloveAlone, IsCalibratedFromStreams) {
  std::string from;
  for (const std::string what : {"forefinger", "thumb", "pointing"}) {
    const std::string log = path(what + ".lcm"), out = path(what + ".toml");
    ASSERT_EQ(run("emulate --stream " + what + " --seed 4 --out " + log).status, 0);
    const Outcome o = run("calibrate " + what + " " + log + from + " --out " + out);
    ASSERT_EQ(o.status, 0) << o.out << o.err;
    EXPECT_NE(o.out.find("rms"), std::string::npos) << o.out;
    from = " --from " + out;
  }
  const Calibration c = load_calibration(path("pointing.toml"));
  EXPECT_LT((c.glove.forefinger_tip_mm - Vec3(17, 2, -8)).norm(), 0.15);
  EXPECT_LT((c.glove.thumb_tip_mm - Vec3(15, -2, -9)).norm(), 0.15);
  const Vec3 truth = Vec3(0.94, 0.1, -0.32).normalized();
  EXPECT_LT(std::atan2(c.glove.pointing.cross(truth).norm(), c.glove.pointing.dot(truth)) * 180 / M_PI, 0.5);
  EXPECT_FALSE(c.other_glove.has_value());
  // A hand that only points does not turn about its tip.
  const Outcome o = run("calibrate thumb " + path("pointing.lcm") + " --out " + path("bad.toml"));
  EXPECT_EQ(o.status, 3) << o.out << o.err;
  EXPECT_FALSE(fs::exists(path("bad.toml")));
  expect_refused("calibrate forefinger " + path("thumb.lcm") + " --other-glove --out " + path("bad.toml"),
                 {"forefinger", "expected"});
}

}  // namespace test_cli_glove
