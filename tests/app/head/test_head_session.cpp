// A whole session on a head: the emulated surgeon saws and
// carries, once with one worker and once with two; scenes
// with and without [head]; skin over bone.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "app/assembly/assembly.h"
#include "app/assembly/operation.h"
#include "app/head/cache.h"
#include "app/session/lockstep.h"
#include "devices/force/force_source.h"
#include "devices/head_surgeon.h"
#include "devices/log_source.h"
#include "devices/motion.h"
#include "devices/surface_index.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "sim/geometry/rotation.h"
#include "sim/patient/soft_tissue.h"
#include "sim/skull/simplex/file.h"
#include "sim/skull/simplex/generators.h"
#include "sim/skull/simplex/mesh.h"
#include "tests/sim/skull/needs_bullet.h"

namespace limberg {
namespace test_head_session {

/// A ball of bone of radius 40 under a face of radius 48, as files beside a scene. `more`: other parts of the scene.
Scene ball_scene(const std::string& name, const std::string& more = "") {
  const std::string dir = ::testing::TempDir();
  simplex::Mesh ball = simplex::make_sphere({0, 0, 0}, 40, 3), anvil = simplex::make_sphere({0, 0, -200}, 20, 2),
                face = simplex::make_sphere({0, 0, 0}, 48, 3);
  for (simplex::Mesh* m : {&ball, &anvil, &face}) simplex::record_shape(*m);
  simplex::save_mesh(ball, dir + "/ball.txt"), simplex::save_mesh(anvil, dir + "/anvil.txt"),
      simplex::save_mesh(face, dir + "/face.txt");
  return parse_scene("[head]\nsource = \"files\"\nbones = [\"anvil.txt\", \"ball.txt\"]\nface = \"face.txt\"\n" + more,
                     dir + "/" + name + ".toml");
}

constexpr const char* kTissue =
    "[[head.tissue]]\nname = \"cap\"\nface = [0, 48, 0]\nface_radius_mm = 35\nlayers = 2\nmode = \"springs\"\n";

/// A ring about the y axis, on the ball.
CutBone ring(double radius_mm = 25) {
  CutBone c;
  for (int i = 0; i < 48; ++i)
    c.contour_mm.push_back({radius_mm * std::cos(i * M_PI / 24), std::sqrt(40.0 * 40 - radius_mm * radius_mm),
                            radius_mm * std::sin(i * M_PI / 24)});
  return c;
}

std::vector<Command> operation() {
  MoveFragment m;
  m.fragment = {-1, {0, 40, 0}};
  m.by.translation_mm = {0, 8, 0};
  m.seconds = 1.5;
  return {HeadCommand(ring()), Stage{"cut"}, HeadCommand(m), Stage{"moved"}};
}

struct Ran {
  uint64_t hash = 0;
  std::vector<std::string> refused, script;
  double forward_mm = 0;
  size_t fragments = 0;
};

Ran run(int workers) {
  AssemblyOptions o;
  o.workers = workers;
  Assembly a(ball_scene("session", kTissue), Calibration{}, o);
  SurgeonSettings hand;
  hand.seed = 5;
  a.front.add(std::make_unique<EmulatedHeadSurgeon>(operation(), hand));
  SessionSettings set = a.session_settings();
  set.ticks_per_frame = 1000;
  const SessionFigures f = run_lockstep(a.lanes(nullptr), set);
  Ran r;
  r.hash = f.state_hash;
  for (const Refusal& x : a.solver.refused()) r.refused.push_back(x.command + ": " + x.reason);
  for (const Command& c : a.done) r.script.push_back(action_name(c));
  for (const bone::Fragment& x : a.head->bones().fragments())
    r.forward_mm = std::max(r.forward_mm, (x.pose * x.centre_mm - x.centre_mm).y());
  r.fragments = a.head->bones().fragments().size();
  return r;
}

TEST(HeadSession, SawAndGloveCutAndCarryTheSameWithAnyNumberOfWorkers) {
  LIMBERG_NEEDS_BULLET();
  const Ran one = run(1), two = run(2);
  EXPECT_EQ(one.refused, std::vector<std::string>{});
  EXPECT_EQ(one.script, (std::vector<std::string>{"osteotomy", "stage", "grab", "drag", "let_go", "stage"}));
  EXPECT_EQ(one.fragments, 3u);
  EXPECT_NEAR(one.forward_mm, 8, 1);  // the hand's tremor and noise, and what it met
  EXPECT_EQ(one.hash, two.hash);
}

/// Two gloves over the halves of the ball, which point down, close, draw the halves apart by 10 mm each, and open.
std::vector<Sample> two_gloves() {
  std::vector<Sample> out;
  CutBone halves;
  halves.point_mm = Vec3::Zero(), halves.normal = Vec3::UnitX(), halves.of = FragmentPick{-1, {0, 0, 40}};
  CommandSample cut = command_sample(HeadCommand(halves));
  cut.device_id = 1, cut.t_ns = 100'000'000;
  const Eigen::Quaterniond down = turn_about(M_PI / 2, Vec3::UnitY());
  bool told = false;
  for (int i = 0; i < 6 * 120; ++i) {
    const double t = i / 120.0;
    if (!told && t > 0.1) out.push_back(cut), told = true;
    const double shut = minimum_jerk((t - 1.5) / 0.4) - minimum_jerk((t - 4) / 0.4), half = 31 - 25 * shut;
    const double apart = 20 + 10 * minimum_jerk((t - 2.2) / 1.2);
    for (const int glove : {0, 1}) {
      TrackerSample s;
      s.device_id = 10 + glove, s.seq = i / 2, s.t_ns = s.true_ns = int64_t(t * 1e9) + glove;
      s.station = 1 + i % 2 + 2 * glove;
      if (glove == 0)
        s.role = i % 2 ? StationRole::thumb : StationRole::forefinger;
      else
        s.role = i % 2 ? StationRole::other_thumb : StationRole::other_forefinger;
      s.pos_mm = Vec3(glove == 0 ? -apart : apart, -31 + (i % 2 ? -half : half), 85);
      s.quat = {down.w(), down.x(), down.y(), down.z()};
      out.push_back(s);
    }
  }
  return out;
}

TEST(HeadSession, TwoGlovesDrawTwoFragmentsApart) {
  LIMBERG_NEEDS_BULLET();
  uint64_t hash[2] = {1, 2};
  for (const int workers : {1, 2}) {
    AssemblyOptions o;
    o.workers = workers;
    Assembly a(ball_scene("two", kTissue), Calibration{}, o);
    a.front.add(std::make_unique<LogSource>(two_gloves()));
    SessionSettings set = a.session_settings();
    set.ticks_per_frame = 1000;
    hash[workers - 1] = run_lockstep(a.lanes(nullptr), set).state_hash;
    EXPECT_EQ(a.solver.refused().size(), 0u);
    const auto& fragments = a.head->bones().fragments();
    ASSERT_EQ(fragments.size(), 3u);
    std::vector<double> went;
    for (const bone::Fragment& f : fragments)
      if (!f.fixed) went.push_back((f.pose * f.centre_mm - f.centre_mm).x());
    std::sort(went.begin(), went.end());
    ASSERT_EQ(went.size(), 2u);
    EXPECT_NEAR(went[0], -10, 0.5);
    EXPECT_NEAR(went[1], 10, 0.5);
    int grabs = 0, let_go = 0;
    for (const Command& c : a.done)
      grabs += action_name(c) == std::string("grab"), let_go += action_name(c) == std::string("let_go");
    EXPECT_EQ(grabs, 2);
    EXPECT_EQ(let_go, 2);
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST(HeadSession, AScriptDoesTheSameWithoutAHand) {
  LIMBERG_NEEDS_BULLET();
  AssemblyOptions o;
  Assembly a(ball_scene("script", kTissue), Calibration{}, o);
  Script s;
  s.name = "s";
  for (const Command& c : operation()) s.lines.push_back({int(s.lines.size()) + 2, c});
  const OperationOutcome out = operate(*a.patient, s, {});
  EXPECT_EQ(out.stages.size(), 2u);
  EXPECT_NEAR(a.head->bones().fragments().back().pose.translation().y(), 8, 1e-9);
  // Skin is not there: refused with the script's line.
  Script bad;
  bad.name = "bad.jsonl";
  bad.lines.push_back({9, Incise{}});
  try {
    operate(*a.patient, bad, {});
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("bad.jsonl:9: incise refused: there is no skin"), std::string::npos)
        << e.what();
  }
}

TEST(HeadSession, ScenesSayWhatIsWrong) {
  const auto why = [](const std::string& more) {
    try {
      ball_scene("bad", more);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(why(""), "");
  EXPECT_NE(why("colour = 3\n").find("unknown key \"colour\" in [head]"), std::string::npos);
  EXPECT_NE(why("[[head.tissue]]\nname = \"a\"\n").find("face is missing"), std::string::npos);
  EXPECT_NE(why("[[head.tissue]]\nname = \"a\"\nface = \"N\"\nmode = \"jelly\"\n").find("expected smoothing"),
            std::string::npos);
  EXPECT_NE(why("[lattice]\ncell_mm = 3\n").find("lattice belongs to a [body]"), std::string::npos);
  EXPECT_NE(why("[head.landmarks]\nN = [1, 2]\n").find("is not [x, y, z]"), std::string::npos);
  EXPECT_NE(why("[[head.tissue]]\nname = \"a\"\nface_outline = [[0, 48, 0], [1, 48, 0]]\n").find("3 to 200"),
            std::string::npos);
  EXPECT_NE(
      why("[[head.tissue]]\nname = \"a\"\nface = [0, 48, 0]\nface_outline = [[0, 48, 0], [9, 48, 0], [0, 48, 9]]\n")
          .find("one of the two"),
      std::string::npos);
  EXPECT_NE(why("[[head.muscle]]\npath = [[0, 0, 0], [1, 0, 0]]\n").find("name is missing"), std::string::npos);
  EXPECT_NE(why("[[head.muscle]]\nname = \"m\"\npath = [\"a\"]\n").find("2 to 200"), std::string::npos);
  EXPECT_NE(why("[[head.muscle]]\nname = \"m\"\npath = [\"a\", [1, 2]]\n").find("is no place"), std::string::npos);
  EXPECT_NE(why("[[head.muscle]]\nname = \"m\"\npath = [\"a\", \"b\"]\nk1_kPa = -1\n").find("k1_kPa"),
            std::string::npos);
  EXPECT_NE(why("muscle = 3\n").find("expected [[head.muscle]]"), std::string::npos);
  // A landmark that is not there is found when the head is built.
  EXPECT_THROW(Assembly(ball_scene("bad", "[[head.tissue]]\nname = \"a\"\nface = \"Nowhere\"\n"), Calibration{}, {}),
               InputError);
}

// The cap over the ring of bone that moves, stretched round it: a muscle across its border changes where the face goes.
TEST(HeadSession, AMuscleTakesPartInWhatTheFaceDoes) {
  const std::string tissue =
      "[[head.tissue]]\nname = \"cap\"\nface = [0, 48, 0]\nface_radius_mm = 42\nlayers = 3\nmode = "
      "\"finite_elements\"\n[head.landmarks]\nmiddle = [0, 40, 0]\n";
  const auto moved_mm = [&](const std::string& muscle) {
    Assembly a(ball_scene("muscle", tissue + muscle), Calibration{}, {});
    for (const Command& c : operation()) EXPECT_TRUE(a.patient->apply(c).done);
    StepSettings s;
    for (int i = 0; i < 400; ++i) a.patient->step(s);
    const simplex::FaceModel& face = a.head->face_model();
    bool told = false;
    for (const std::string& line : face.describe()) told |= line.find("muscle m") != std::string::npos;
    EXPECT_EQ(told, !muscle.empty());
    double most = 0;
    for (size_t v = 0; v < face.rest_mm().size(); ++v)
      if (face.rest_mm()[v].x() > 18 && face.rest_mm()[v].y() > 20)  // over the border, on the muscle's side
        most = std::max(most, (face.face().x_mm[v] - face.rest_mm()[v]).norm());
    return most;
  };
  const double without = moved_mm(""),
               soft = moved_mm("[[head.muscle]]\nname = \"m\"\npath = [\"middle\", [40, 0, 0]]\nradius_mm = 1\n"),
               strong = moved_mm(
                   "[[head.muscle]]\nname = \"m\"\npath = [\"middle\", [31, 31, 0], [44, 0, 0]]\nradius_mm = "
                   "14\nk1_kPa = 10\nk2 = 0.2\n");
  std::printf("moved by %.3f mm, with a thread of a muscle %.3f, with a strong one %.3f\n", without, soft, strong);
  EXPECT_GT(without, 2);
  EXPECT_NEAR(soft, without, 0.02 * without);
  EXPECT_GT(std::abs(strong - without), 0.03 * without);
  EXPECT_THROW(Assembly(ball_scene("bad", tissue + "[[head.muscle]]\nname = \"m\"\npath = [\"middle\", \"nowhere\"]\n"),
                        Calibration{}, {}),
               InputError);
}

// A piece of bone that turns about the middle of the ball, so that it goes along beneath the skin: what slides stays
// behind and is drawn out less. (Over a piece that is lifted skin is drawn out as much: it slides, but is not lifted.)
TEST(HeadSession, SkinThatSlidesSpreadsWhatABoneDoes) {
  const std::string tissue =
      "[[head.tissue]]\nname = \"cap\"\nface = [0, 48, 0]\nface_radius_mm = 42\nlayers = 3\nmode = "
      "\"finite_elements\"\n[head.landmarks]\nmiddle = [0, 40, 0]\n";
  struct Result {
    double stretch = 0, along_mm = 0;
  };
  const auto moved = [&](const std::string& slide) {
    Assembly a(ball_scene("slide", tissue + slide), Calibration{}, {});
    MoveFragment along;
    along.fragment = {-1, {0, 40, 0}}, along.by.rotation_deg = {0, 0, 8}, along.by.about_mm = Vec3::Zero();
    for (const Command& c : {Command(HeadCommand(ring(14))), Command(HeadCommand(along))})
      EXPECT_TRUE(a.patient->apply(c).done);
    StepSettings s;
    for (int i = 0; i < 400; ++i) a.patient->step(s);
    const simplex::FaceModel& model = a.head->face_model();
    EXPECT_TRUE(model.at_rest());
    bool told = false;
    for (const std::string& line : model.describe()) told |= line.find("slides on bone, scalp") != std::string::npos;
    EXPECT_EQ(told, !slide.empty());
    const std::vector<Vec3>&X = model.rest_mm(), &x = model.face().x_mm;
    Result r;
    for (size_t v = 0; v < X.size(); ++v) {
      if (X[v].y() < 38) continue;  // the middle of the tissue, and the border of the piece
      r.along_mm = std::max(r.along_mm, (x[v] - X[v]).norm());
      for (const int32_t w : model.face().nbr[v])
        r.stretch = std::max(r.stretch, (x[size_t(w)] - x[v]).norm() / (X[size_t(w)] - X[v]).norm());
    }
    return r;
  };
  const Result held = moved(""), slides = moved("[[head.slide]]\nname = \"scalp\"\nat = \"middle\"\nradius_mm = 45\n");
  std::printf("held: stretch %.3f, along by %.2f mm; sliding: %.3f, %.2f mm\n", held.stretch, held.along_mm,
              slides.stretch, slides.along_mm);
  EXPECT_LT(slides.stretch - 1, 0.75 * (held.stretch - 1));  // 0.47 on 2026-11-30
  EXPECT_LT(slides.along_mm, 0.75 * held.along_mm);          // 0.62
  const auto why = [&](const std::string& slide) {
    try {
      Assembly(ball_scene("bad", tissue + slide), Calibration{}, {});
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  const std::string name = "[[head.slide]]\nname = \"s\"\n";
  EXPECT_NE(why(name).find("at is missing"), std::string::npos) << why(name);
  EXPECT_NE(why(name + "at = \"nowhere\"\n").find("head.slide names the landmark"), std::string::npos);
  EXPECT_NE(why(name + "at = [0, 0, 0]\nkPa_per_mm = 0\n").find("kPa_per_mm"), std::string::npos);
  EXPECT_NE(why(name + "at = [0, 0, 0]\nfriction = 1\n").find("unknown key"), std::string::npos);
}

/// A slab of skin 60 x 60 x 8 mm, its underside 1 mm above flat
/// bone: the top of a ball so large that it is nearly flat.
Scene skin_over_bone() {
  const std::string dir = ::testing::TempDir();
  simplex::Mesh plate = simplex::make_sphere({0, 0, 0}, 1, 4), anvil = simplex::make_sphere({0, 0, -300}, 20, 2);
  for (Vec3& x : plate.x_mm)
    x = Vec3(60 * x.x(), 60 * x.y(), 10 * (x.z() < 0 ? -1 : 1) * std::pow(std::abs(x.z()), 0.3) - 19);
  for (simplex::Mesh* m : {&plate, &anvil}) m->before_mm = m->x_mm, simplex::record_shape(*m);
  simplex::save_mesh(plate, dir + "/plate.txt"), simplex::save_mesh(anvil, dir + "/anvil2.txt");
  return parse_scene(
      "[head]\nsource = \"files\"\nbones = [\"anvil2.txt\", \"plate.txt\"]\ncarries_skin_mm = 20\n"
      "[body]\nsource = \"block\"\nsize_mm = [60, 60, 8]\nskin_cell_mm = 3\n[[layer]]\nname = \"skin\"\nthickness_mm = "
      "8\nyoung_kPa = 60\npoisson = 0.45\n[lattice]\ncell_mm = 4\n",
      dir + "/skin_over_bone.toml");
}

std::vector<Vec3f> settled(Assembly& a, int steps = 300) {
  StepSettings s;
  s.max_iterations = 20, s.tolerance = 1e-6;
  for (int i = 0; i < steps && a.patient->step(s).residual > 2e-6; ++i) {
  }
  Snapshot shown;
  a.world->skin()->fill(shown);
  return shown.x_mm;
}

TEST(HeadSession, RigidMotionOfAllTheBoneMovesTheSkinRigidly) {
  LIMBERG_NEEDS_BULLET();
  Assembly a(skin_over_bone(), Calibration{}, {});
  const std::vector<Vec3f> before = settled(a);
  MoveFragment m;
  m.fragment = {-1, {0, 0, -9}};
  m.by.translation_mm = {3, -2, 4}, m.by.rotation_deg = {0, 5, 3}, m.by.about_mm = Vec3(0, 0, -10);
  ASSERT_TRUE(a.patient->apply(HeadCommand(m)).done);
  const std::vector<Vec3f> after = settled(a);
  const Eigen::Isometry3d map = isometry(m.by, Vec3::Zero());
  double worst = 0;
  for (size_t v = 0; v < before.size(); ++v)
    worst = std::max(worst, (map * before[v].cast<double>() - after[v].cast<double>()).norm());
  EXPECT_LT(worst, 0.01);
}

TEST(HeadSession, AFragmentRaisedLiftsTheSkinAboveIt) {
  LIMBERG_NEEDS_BULLET();
  Assembly a(skin_over_bone(), Calibration{}, {});
  const std::vector<Vec3f> before = settled(a);
  CutBone c;
  c.point_mm = {0, 0, -19}, c.normal = Vec3::UnitX();
  const Outcome cut = a.patient->apply(HeadCommand(c));
  ASSERT_TRUE(cut.done) << cut.reason;
  MoveFragment m;
  m.fragment = {-1, {40, 0, -9}};
  m.by.translation_mm = {0, 0, 3};
  ASSERT_TRUE(a.patient->apply(HeadCommand(m)).done);
  const std::vector<Vec3f> after = settled(a);
  double above = 0, beside = 0;
  for (size_t v = 0; v < before.size(); ++v) {
    const float dz = after[v].z() - before[v].z();
    if (before[v].z() > -0.1f && before[v].x() > 20) above = std::max(above, std::abs(double(dz) - 3));
    if (before[v].z() > -0.1f && before[v].x() < -20) beside = std::max(beside, std::abs(double(dz)));
  }
  EXPECT_LT(above, 0.3);
  EXPECT_LT(beside, 0.3);
  // Skin and bone in one history: the last act goes first.
  ASSERT_TRUE(a.patient->apply(Incise{{{-10, 0}, {10, 0}}, 3}).done);
  ASSERT_TRUE(a.patient->apply(Undo{}).done);
  EXPECT_EQ(a.head->bones().fragments().size(), 3u);
  ASSERT_TRUE(a.patient->apply(Undo{}).done);  // the move
  ASSERT_TRUE(a.patient->apply(Undo{}).done);  // the cut
  EXPECT_EQ(a.head->bones().fragments().size(), 2u);
  const std::vector<Vec3f> back = settled(a);
  double worst = 0;
  for (size_t v = 0; v < before.size(); ++v) worst = std::max(worst, double((before[v] - back[v]).norm()));
  EXPECT_LT(worst, 0.02);
}

// One patient: flap tools in skin that a raised piece of bone carries, and the bone moves on under the stitches.
TEST(HeadSession, AFlapIsCutUnderminedAndSewnOverRaisedBone) {
  LIMBERG_NEEDS_BULLET();
  Assembly a(skin_over_bone(), Calibration{}, {});
  settled(a);
  const auto act = [&](const Command& c) {
    const Outcome o = a.patient->apply(c);
    ASSERT_TRUE(o.done) << o.reason;
  };
  CutBone c;
  c.point_mm = {0, 0, -19}, c.normal = Vec3::UnitX();
  MoveFragment m;
  m.fragment = {-1, {40, 0, -9}}, m.by.translation_mm = {0, 0, 3};
  act(HeadCommand(c)), act(HeadCommand(m));
  settled(a);
  const uint64_t whole = a.patient->topology_hash();
  act(Incise{{{12, -6}, {26, -6}}, 3});
  act(Undermine{{{12, -12}, {26, -12}, {26, 0}, {12, 0}}, 2.5});
  act(Suture{{19, -7.5}, {19, -4.5}});
  const std::vector<Vec3f> sewn = settled(a);
  Snapshot s;
  a.patient->fill(s);
  ASSERT_EQ(s.sutures.size(), 1u);
  EXPECT_LT(s.sutures[0].gap_mm, 0.3f);
  for (const Vec3f& x : s.x_mm) ASSERT_TRUE(x.allFinite());
  // The bone goes on by another 2 mm: bed, flap and stitch go along.
  m.by.translation_mm = {0, 0, 2};
  act(HeadCommand(m));
  const std::vector<Vec3f> higher = settled(a);
  ASSERT_EQ(higher.size(), sewn.size());
  double rise = 0, n = 0;
  for (size_t v = 0; v < sewn.size(); ++v)
    if (sewn[v].x() > 14 && sewn[v].x() < 24 && std::abs(sewn[v].y() + 6) < 6)
      rise += double(higher[v].z() - sewn[v].z()), ++n;
  ASSERT_GT(n, 20);
  EXPECT_NEAR(rise / n, 2, 0.3);
  a.patient->fill(s);
  EXPECT_LT(s.sutures[0].gap_mm, 0.3f);
  // One history through both.
  for (int i = 0; i < 4; ++i) act(Undo{});
  EXPECT_EQ(a.patient->topology_hash(), whole);
  act(Undo{}), act(Undo{});
  EXPECT_EQ(a.head->bones().fragments().size(), 2u);
}

MoveFragment raise_plate(double by_mm) {
  MoveFragment m;
  m.fragment = {-1, {40, 0, -9}};
  m.by.translation_mm = {0, 0, by_mm};
  return m;
}

// One history: what is no entry for one part is none for the patient.
TEST(HeadSession, APieceOfAStrokeThatCutsNothingIsNoEntry) {
  LIMBERG_NEEDS_BULLET();
  Assembly a(skin_over_bone(), Calibration{}, {});
  const uint64_t at_first = a.patient->state_hash();
  ASSERT_TRUE(a.patient->apply(HeadCommand(raise_plate(3))).done);
  const uint64_t topology = a.patient->topology_hash();
  ASSERT_TRUE(a.patient->apply(InciseMore{1, {{-5, 0}, {-4.5, 0}}, 3, 90, false}).done);
  ASSERT_EQ(a.patient->topology_hash(), topology) << "too short to cut anything yet";
  const Outcome o = a.patient->apply(Undo{});
  EXPECT_TRUE(o.done) << o.reason;
  EXPECT_EQ(a.patient->state_hash(), at_first);
  EXPECT_FALSE(a.patient->apply(Undo{}).done);
}

TEST(HeadSession, AHookEndsWhatCouldBeDoneAgainInEveryPart) {
  LIMBERG_NEEDS_BULLET();
  Assembly a(skin_over_bone(), Calibration{}, {});
  const auto act = [&](const Command& c) {
    const Outcome o = a.patient->apply(c);
    ASSERT_TRUE(o.done) << o.reason;
  };
  act(HeadCommand(raise_plate(3)));
  act(Incise{{{-10, 0}, {10, 0}}, 3});
  act(Undo{}), act(Undo{});
  act(SetHook{1, {0, 10}});
  EXPECT_FALSE(a.patient->apply(Redo{}).done);
  act(HeadCommand(raise_plate(2)));
  const uint64_t raised = a.patient->state_hash();
  act(Undo{}), act(Redo{});
  EXPECT_EQ(a.patient->state_hash(), raised);
  EXPECT_FALSE(a.patient->apply(Redo{}).done);
}

TEST(HeadSession, AnActOnBoneStopsAStrokeInSkin) {
  LIMBERG_NEEDS_BULLET();
  Assembly a(skin_over_bone(), Calibration{}, {});
  const uint64_t whole = a.patient->topology_hash(), at_first = a.patient->state_hash();
  ASSERT_TRUE(a.patient->apply(InciseMore{1, {{-18, 0}, {-6, 0}}, 3, 90, false}).done);
  const uint64_t cut = a.patient->state_hash();
  ASSERT_NE(a.patient->topology_hash(), whole);
  ASSERT_TRUE(a.patient->apply(HeadCommand(raise_plate(3))).done);
  EXPECT_FALSE(a.patient->apply(InciseMore{1, {{-6, 0}, {6, 0}}, 3, 90, false}).done);
  ASSERT_TRUE(a.patient->apply(Undo{}).done);
  EXPECT_EQ(a.patient->state_hash(), cut) << "the bone was the last act";
  ASSERT_TRUE(a.patient->apply(Undo{}).done);
  EXPECT_EQ(a.patient->state_hash(), at_first);
}

// The skin over bone answers a hand as it would alone; bone is as hard as bone, where no skin lies over it.
TEST(HeadSession, SkinAndBoneAreFelt) {
  LIMBERG_NEEDS_BULLET();
  Assembly a(skin_over_bone(), Calibration{}, {});
  settled(a);
  Snapshot s;
  a.patient->fill(s);
  const SurfaceIndex skin, bone(Ground::bone);
  const SkinTouch on = skin.closest(s, Vec3(2, 3, 5), -1), hard = bone.closest(s, Vec3(45, 0, 20), -1);
  ASSERT_GE(on.triangle, 0);
  ASSERT_GE(hard.triangle, 0);
  PressAnswer joined, alone;
  ASSERT_TRUE(a.patient->press({s.topology_version, on.triangle, on.bary, on.normal, 1, 1}, joined));
  EXPECT_EQ(joined.topology_version, s.topology_version);
  alone = a.world->press({a.world->topology()->version, on.triangle, on.bary, on.normal, 1, 1});
  EXPECT_NEAR(joined.stiffness_N_mm / alone.stiffness_N_mm, 1, 0.1);  // the second one goes on from the first
  EXPECT_FALSE(a.patient->press({s.topology_version, hard.triangle, hard.bary, hard.normal, 1, 1}, joined));
  EXPECT_FALSE(a.patient->press({s.topology_version + 1, on.triangle, on.bary, on.normal, 1, 1}, joined));

  for (const Vec3& over : {on.x_mm, hard.x_mm}) {
    SimulatedHand h;
    h.target = [over](double t) { return Vec3(over + Vec3(0, 0, 3 - 5 * std::min(1.0, 4 * t))); };
    ForceSource force(std::make_unique<SimulatedForceDevice>(h));
    struct : SampleSink {
      void on_sample(const Sample&) override {}
    } nowhere;
    for (int64_t tick = 1; tick < 800; ++tick) {
      s.step = uint64_t(tick / 16);
      force.look(s), force.poll(tick * 1'000'000, nowhere);
    }
    const bool is_bone = over == hard.x_mm;
    EXPECT_TRUE(force.loop().state().touching) << is_bone;
    if (is_bone) {
      EXPECT_GT(force.model().stiffness_N_mm, 1000);
      EXPECT_LT(force.loop().state().depth_mm, 0.5);  // a spring of the coupling's stiffness against the hand's
    } else {
      EXPECT_LT(force.model().stiffness_N_mm, 1);
    }
  }
}

TEST(HeadSession, AScenesSkinAloneBuildsNoHead) {
  Assembly a(parse_scene("[body]\nsource = \"block\"\nsize_mm = [40, 40, 8]\nskin_cell_mm = 4\n[[layer]]\nname = "
                         "\"skin\"\nthickness_mm = 8\nyoung_kPa = 60\npoisson = 0.45\n[lattice]\ncell_mm = 5\n",
                         "plain.toml"),
             Calibration{}, {});
  EXPECT_EQ(a.head, nullptr);
  const Outcome o = a.patient->apply(HeadCommand(ring()));
  EXPECT_FALSE(o.done);
  EXPECT_NE(o.reason.find("no bone here"), std::string::npos);
}

class HeadCache : public ::testing::Test {
 protected:
  HeadCache() {
    std::string name = (std::filesystem::temp_directory_path() / "limberg-cache-XXXXXX").string();
    folder_ = mkdtemp(name.data());
    spec_.edge_mm = 8, spec_.face_edge_mm = 9, spec_.vault_wide = 1.02;
  }
  ~HeadCache() override { std::filesystem::remove_all(folder_); }
  HeadModel head() { return cached_head(spec_, workers_, folder_.string()); }
  std::filesystem::path file(const std::string& name) const {
    for (const auto& f : std::filesystem::recursive_directory_iterator(folder_))
      if (f.path().filename() == name) return f.path();
    return {};
  }
  static std::string text(const std::filesystem::path& file) { return read_whole_file(file.string()); }
  static void expect_same(const HeadModel& a, const HeadModel& b) {
    for (const auto& [p, q] :
         {std::pair(&a.cranium, &b.cranium), std::pair(&a.mandible, &b.mandible), std::pair(&a.face, &b.face)}) {
      EXPECT_EQ(simplex::hash(*p), simplex::hash(*q));
      EXPECT_EQ(p->face_edge, q->face_edge);  // numbers of faces too: tissue is built by them
    }
    ASSERT_EQ(a.landmarks.size(), b.landmarks.size());
    for (size_t i = 0; i < a.landmarks.size(); ++i)
      EXPECT_TRUE(a.landmarks[i] == b.landmarks[i]) << a.landmarks[i].first;
  }

  HeadSpec spec_;
  InlineWorkers workers_;
  std::filesystem::path folder_;
};

TEST_F(HeadCache, WhatIsReadIsWhatWasMade) {
  const HeadModel made = head();
  const std::filesystem::path landmarks = file("landmarks.txt");
  ASSERT_FALSE(landmarks.empty());
  const auto written = std::filesystem::last_write_time(landmarks);
  expect_same(made, head());
  EXPECT_EQ(std::filesystem::last_write_time(landmarks), written) << "it was made a second time";
  struct stat st {};
  ASSERT_EQ(stat(landmarks.parent_path().c_str(), &st), 0);
  EXPECT_EQ(st.st_mode & 0777, 0700u);
}

TEST_F(HeadCache, WhatWasDamagedOrChangedIsMadeAnew) {
  const HeadModel made = head();
  const std::string sound = text(file("landmarks.txt"));
  const size_t nasion = sound.find(' ', sound.find('\n') + 20);
  for (const auto& [name, size] : {std::pair{"mandible.simplex", 1000}, {"landmarks.txt", 0}, {"landmarks.txt", 200}}) {
    std::filesystem::resize_file(file(name), uintmax_t(size));
    expect_same(made, head());
    EXPECT_EQ(text(file("landmarks.txt")), sound) << name;
  }
  std::string moved = sound;
  moved.replace(nasion, 2, " 9");  // whole, and elsewhere
  write_whole_file(file("landmarks.txt").string(), moved);
  expect_same(made, head());
  EXPECT_EQ(text(file("landmarks.txt")), sound);
}

TEST_F(HeadCache, WhatOthersCouldHavePutThereIsNotBelieved) {
  const HeadModel made = head();
  const std::filesystem::path place = file("landmarks.txt").parent_path();
  const auto written = [&] { return std::filesystem::last_write_time(file("landmarks.txt")); };
  auto before = written();
  std::filesystem::permissions(place, std::filesystem::perms::others_write, std::filesystem::perm_options::add);
  expect_same(made, head());
  EXPECT_NE(written(), before) << "a head that others can write was believed";
  before = written();
  const std::filesystem::path aside = folder_.string() + "-aside";
  std::filesystem::rename(place, aside);
  std::filesystem::create_directory_symlink(aside, place);
  expect_same(made, head());
  EXPECT_FALSE(std::filesystem::is_symlink(place)) << "a link was followed";
  std::filesystem::remove_all(aside);
  before = written();
  std::filesystem::permissions(folder_, std::filesystem::perms::others_write, std::filesystem::perm_options::add);
  expect_same(made, head());
  EXPECT_EQ(written(), before) << "a head was kept where others can write";
}

TEST_F(HeadCache, WhatIsAnothersIsNotBelieved) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give a folder away";
  const HeadModel made = head();
  const auto written = [&] { return std::filesystem::last_write_time(file("landmarks.txt")); };
  const auto before = written();
  constexpr uid_t kNobody = 65534;
  ASSERT_EQ(chown(file("landmarks.txt").parent_path().c_str(), kNobody, gid_t(kNobody)), 0);
  expect_same(made, head());
  EXPECT_NE(written(), before) << "another's head was believed";
}

TEST_F(HeadCache, AFolderThatCannotBeReachedIsNone) {
  std::filesystem::create_symlink("loop2", folder_ / "loop1");
  std::filesystem::create_symlink("loop1", folder_ / "loop2");
  std::ofstream(folder_ / "file") << "no folder";
  for (const std::string& name : {std::string("loop1"), std::string("file/below"), std::string(300, 'a')}) {
    const HeadModel made = cached_head(spec_, workers_, (folder_ / name).string());
    EXPECT_FALSE(made.landmarks.empty()) << name;
  }
  EXPECT_TRUE(file("landmarks.txt").empty());
}

}  // namespace test_head_session
}  // namespace limberg
