// Scripts survive a round trip, refuse what they cannot mean, and stand any bytes.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "sim/base/error.h"
#include "sim/commands/script.h"

namespace limberg {
namespace test_script {

const std::string kHeader = "{\"limberg_script\":1,\"scene\":\"rhomboid\"}\n";

// Seeded random commands with awkward numbers.
class Maker {
 public:
  explicit Maker(uint64_t seed) : rng_(seed) {}
  double real(double lo, double hi) {
    const double r = std::uniform_real_distribution<double>(lo, hi)(rng_);
    return pick(4) == 0 ? std::round(r) : r;
  }
  int pick(int n) { return int(rng_() % uint64_t(n)); }
  ChartPoint point() { return {real(-9999, 9999), pick(5) == 0 ? -0.0 : real(-1, 1) * std::pow(10., -pick(300))}; }
  std::vector<ChartPoint> path(int least) {
    std::vector<ChartPoint> p;
    for (int n = least + pick(6); n > 0; --n) p.push_back({real(-100, 100), real(-100, 100)});
    return p;
  }
  Command command() {
    const int id = 1 + pick(1000);
    switch (pick(18)) {
      case 0:
        return Incise{path(2), real(0.5, 200), real(20, 160)};
      case 1:
        return Undermine{path(3), real(0.5, 200)};
      case 2:
        return Excise{path(3), real(0.5, 200)};
      case 3:
        return SetHook{id, point()};
      case 4:
        return MoveHook{id, {real(-1, 1), real(-9999, 9999), real(-1e-9, 1e-9)}, real(0, 3600)};
      case 5:
        return ReleaseHook{id};
      case 6:
        return Suture{point(), point(), pick(2) == 0 ? 0 : real(0.6, 9)};
      case 7:
        return SutureRow{path(2), path(2), real(2, 9), pick(2) == 0 ? 0 : real(0.6, 9), true, real(0, 9)};
      case 8:
        return Undo{};
      case 9:
        return Redo{};
      case 10:
        return InciseMore{id, path(1), real(0.5, 200), real(20, 160), pick(2) == 0};
      case 12:
        return SutureCorner{point(), point(), point(), real(0.6, 9)};
      case 13:
        return SutureBetween{{id, {0, 0}}, {0, point()}, {real(2, 9), real(0, 5), true, real(0, 5)}};
      case 14:
        return pick(2) == 0 ? CutSuture{{id, {0, 0}}} : CutSuture{{0, point()}};
      case 15:
        return SutureBite{point(), point(), pick(2) == 0 ? 0 : real(0.6, 9)};
      case 16:
        return pick(3) == 0 ? Command(LetThreadGo{}) : TieSuture{pick(2) == 0 ? 0 : real(0, 9)};
      case 11:
        return Stage{pick(2) == 0 ? "flap \"cut\" \\ \n\t" : "lambeau incis\xc3\xa9"};
      default:
        return Wait{real(0, 3600)};
    }
  }

 private:
  std::mt19937_64 rng_;
};

TEST(Script, RoundTripIsExact) {
  Maker make(7);
  Script s;
  s.header = {"app/scenes/face.toml",
              "with a \"note\"",
              {{"ala", {1, 2.5}}, {"at", {-3, 0}}},
              PlannedProcedure{"bilobed", {{"diameter_mm", 12.5}}, {0.1, -4}, 30, true}};
  for (int i = 0; i < 3000; ++i) s.lines.push_back({i + 2, make.command()});
  const std::string text = to_text(s);
  const Script back = parse_script(text, "mem");
  ASSERT_EQ(back.lines.size(), s.lines.size());
  EXPECT_EQ(back.header.scene, s.header.scene);
  EXPECT_EQ(back.header.note, s.header.note);
  ASSERT_EQ(back.header.landmarks.size(), 2u);
  EXPECT_EQ(back.header.landmarks[0].at, s.header.landmarks[0].at);
  ASSERT_TRUE(back.header.plan);
  EXPECT_EQ(back.header.plan->values, s.header.plan->values);
  EXPECT_EQ(back.header.plan->at, s.header.plan->at);
  EXPECT_TRUE(back.header.plan->mirrored);
  for (size_t i = 0; i < s.lines.size(); ++i) {
    EXPECT_EQ(back.lines[i].line, s.lines[i].line);
    ASSERT_EQ(back.lines[i].command.index(), s.lines[i].command.index());
    if (const auto* m = std::get_if<MoveHook>(&s.lines[i].command)) {
      const auto& b = std::get<MoveHook>(back.lines[i].command);
      EXPECT_EQ(b.id, m->id);
      EXPECT_EQ(b.to_mm, m->to_mm);
      EXPECT_EQ(b.seconds, m->seconds);
    }
    if (const auto* m = std::get_if<SutureRow>(&s.lines[i].command)) {
      const auto& b = std::get<SutureRow>(back.lines[i].command);
      EXPECT_EQ(b.a, m->a);
      EXPECT_EQ(b.b, m->b);
      EXPECT_EQ(b.spacing_mm, m->spacing_mm);
      EXPECT_EQ(b.depth_mm, m->depth_mm);
      EXPECT_EQ(b.running, m->running);
      EXPECT_EQ(b.slack_mm, m->slack_mm);
    }
    if (const auto* m = std::get_if<Suture>(&s.lines[i].command)) {
      const auto& b = std::get<Suture>(back.lines[i].command);
      EXPECT_EQ(b.a, m->a);
      EXPECT_EQ(b.b, m->b);
    }
  }
  EXPECT_EQ(to_text(back), text);
}

TEST(Script, DefaultsBlankLinesAndCarriageReturns) {
  const Script s = parse_script(
      "\n" + kHeader.substr(0, kHeader.size() - 1) + "\r\n\r\n{\"action\":\"incise\",\"path\":[[0,0],[1,2]]}\r\n", "m");
  ASSERT_EQ(s.lines.size(), 1u);
  EXPECT_EQ(s.lines[0].line, 4);
  const auto& c = std::get<Incise>(s.lines[0].command);
  EXPECT_EQ(c.depth_mm, Incise{}.depth_mm);
  EXPECT_EQ(c.angle_deg, 90);
  EXPECT_EQ(c.path[1], ChartPoint(1, 2));
  EXPECT_FALSE(c.spline);
  const Command curve = parse_command("{\"action\":\"incise\",\"path\":[[0,0],[1,2],[3,2]],\"spline\":true}", "m", 1);
  EXPECT_TRUE(std::get<Incise>(curve).spline);
  EXPECT_TRUE(std::get<Incise>(parse_command(to_json_line(curve), "m", 1)).spline);
  const Command ring = parse_command("{\"action\":\"excise\",\"outline\":[[0,0],[1,2],[3,2]],\"floor\":false}", "m", 1);
  EXPECT_FALSE(std::get<Excise>(ring).floor);
  EXPECT_FALSE(std::get<Excise>(parse_command(to_json_line(ring), "m", 1)).floor);
}

// Each broken line must be refused with file:line and a word that names the trouble.
TEST(Script, RefusesWithPlaceAndReason) {
  const std::pair<const char*, const char*> cases[] = {
      {R"({"action":"cut"})", "unknown action"},
      {R"({"path":[[0,0],[1,1]]})", "action"},
      {R"({"action":3})", "not a text"},
      {R"({"action":"incise"})", "path"},
      {R"({"action":"incise","path":[]})", "0 points"},
      {R"({"action":"incise","path":[[0,0],[1,2]],"spline":1})", "true nor false"},
      {R"({"action":"incise","path":[[0,0]]})", "1 points"},
      {R"({"action":"incise","path":[[0,0],[1]]})", "2 numbers"},
      {R"({"action":"incise","path":[[0,0],[1,2,3]]})", "2 numbers"},
      {R"({"action":"incise","path":[[0,0],[1,"a"]]})", "not a number"},
      {R"({"action":"incise","path":[[0,0],[1,null]]})", "not a number"},
      {R"({"action":"incise","path":[[0,0],[1,1e99]]})", "coordinate"},
      {R"({"action":"incise","path":[[0,0],[1,1e999]]})", "out of range"},
      {R"({"action":"incise","path":[[0,0],[1,NaN]]})", "broken JSON"},
      {R"({"action":"incise","path":"ab"})", "list of points"},
      {R"({"action":"incise","path":[[0,0],[1,1]],"depth_mm":-4})", "depth_mm"},
      {R"({"action":"incise","path":[[0,0],[1,1]],"depth_mm":0})", "above 0"},
      {R"({"action":"incise","path":[[0,0],[1,1]],"depth_mm":"4"})", "not a number"},
      {R"({"action":"incise","path":[[0,0],[1,1]],"angle_deg":0})", "angle_deg"},
      {R"({"action":"incise","path":[[0,0],[1,1]],"angle_deg":15})", "20 to 160"},
      {R"({"action":"incise","path":[[0,0],[1,1]],"colour":1})", "unknown key \"colour\""},
      {R"({"action":"incise","path":[[0,0],[1,1]],"path":[[0,0],[1,1]]})", "twice"},
      {R"({"action":"undermine","outline":[[0,0],[1,1]]})", "2 points"},
      {R"({"action":"hook","id":0,"at":[0,0]})", "from 1"},
      {R"({"action":"hook","id":1.5,"at":[0,0]})", "not an integer"},
      {R"({"action":"hook","id":99999999999999999999,"at":[0,0]})", "not an integer"},
      {R"({"action":"hook","id":18446744073709551615,"at":[0,0]})", "out of range"},
      {R"({"action":"move","id":1,"to":[0,0]})", "3 numbers"},
      {R"({"action":"move","id":1,"to":[0,0,1],"seconds":-1})", "seconds"},
      {R"({"action":"suture","a":[0,0]})", "\"b\""},
      {R"({"action":"suture_row","a":[[0,0],[9000,0]],"b":[[0,0],[9000,0]],"spacing_mm":0.01})", "too many sutures"},
      {R"({"action":"stage","name":""})", "empty"},
      {R"({"action":"wait","seconds":1e9})", "seconds"},
      {R"({"action":"wait")", "broken JSON"},
      {R"([1,2])", "one JSON object"},
      {R"({"limberg_script":1,"scene":"x"})", "second header"},
      {"{\"action\":\"stage\",\"name\":\"\xff\xfe\"}", "broken JSON"},
  };
  for (const auto& [line, word] : cases) {
    try {
      parse_script(kHeader + "{\"action\":\"undo\"}\n" + line + "\n", "s.jsonl");
      ADD_FAILURE() << "accepted: " << line;
    } catch (const InputError& e) {
      EXPECT_EQ(e.line(), 3) << line;
      EXPECT_TRUE(std::string(e.what()).starts_with("s.jsonl:3: ")) << e.what();
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << line << "\n  said: " << e.what();
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    }
  }
}

TEST(Script, RefusesBrokenHeadersAndHugeInput) {
  for (const std::string& text :
       {std::string(), std::string("\n\n"), std::string("{\"action\":\"undo\"}\n"),
        std::string("{\"limberg_script\":2,\"scene\":\"x\"}\n"), std::string("{\"limberg_script\":1}\n"),
        std::string("{\"limberg_script\":1,\"scene\":\"x\",\"scenes\":1}\n"), kHeader + std::string(2 << 20, '['),
        kHeader + std::string(900'000, '['),
        kHeader + "{\"action\":\"stage\",\"name\":\"" + std::string(5000, 'a') + "\"}\n"})
    EXPECT_THROW(parse_script(text, "s"), InputError) << text.substr(0, 60);
  try {
    parse_script(kHeader + "{\"action\":" + std::string(100'000, '['), "s");
    ADD_FAILURE();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("nested too deeply"), std::string::npos);  // before any parser meets it
  }
  std::string many = kHeader + "{\"action\":\"incise\",\"path\":[[0,0]";
  for (int i = 0; i < 3000; ++i) many += ",[1,1]";
  EXPECT_THROW(parse_script(many + "]}\n", "s"), InputError);
}

TEST(Script, AnyBytesAreEitherAScriptOrAnInputError) {
  Maker make(11);
  Script s;
  s.header = {"rhomboid", "n"};
  for (int i = 0; i < 12; ++i) s.lines.push_back({i + 2, make.command()});
  const std::string good = to_text(s);
  const std::string spice = "{}[]\":,0123456789.eE+-\n\\untf \x01\x7f\x80\xff";
  std::mt19937_64 rng(12);
  int refused = 0, accepted = 0;
  for (int n = 0; n < 20000; ++n) {
    std::string t = good;
    for (int k = 1 + int(rng() % 4); k > 0 && !t.empty(); --k) {
      const size_t at = rng() % t.size();
      switch (rng() % 4) {
        case 0:
          t[at] = spice[rng() % spice.size()];
          break;
        case 1:
          t.erase(at, 1 + rng() % 9);
          break;
        case 2:
          t.insert(at, 1, spice[rng() % spice.size()]);
          break;
        default:
          t.resize(at);
          break;
      }
    }
    try {
      const Script back = parse_script(t, "f");
      EXPECT_EQ(to_text(parse_script(to_text(back), "f")), to_text(back));
      ++accepted;
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(accepted, 100);  // digits changed for digits
}

TEST(Script, FilesAreReadAndWrittenLineByLine) {
  namespace fs = std::filesystem;
  const fs::path dir = fs::path(::testing::TempDir()) / "limberg_script_test";
  fs::remove_all(dir);
  fs::create_directories(dir);
  const std::string path = dir / "s.jsonl";
  EXPECT_THROW(load_script(path), InputError);
  EXPECT_THROW(load_script(dir), InputError);
  {
    ScriptWriter w(path, {"rhomboid", ""});
    w.append(Stage{"one"});
    EXPECT_EQ(load_script(path).lines.size(), 1u);  // there before the writer closes
    w.append(Wait{2});
    EXPECT_EQ(load_script(path).lines.size(), 2u);
  }
  EXPECT_THROW(ScriptWriter(path, {"other", ""}), InputError);
  EXPECT_EQ(load_script(path).header.scene, "rhomboid");
  EXPECT_THROW(ScriptWriter(dir / "no" / "such.jsonl", {"x", ""}), InputError);
  { ScriptWriter w(path, {"other", ""}, ScriptWriter::Existing::replace); }
  EXPECT_EQ(load_script(path).header.scene, "other");
  if (fs::exists("/dev/full")) {
    EXPECT_THROW(ScriptWriter("/dev/full", {"x", ""}, ScriptWriter::Existing::replace), InputError);
  }
  fs::remove_all(dir);
}

}  // namespace test_script
}  // namespace limberg
