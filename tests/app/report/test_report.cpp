#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "app/program/places.h"
#include "app/report/compare.h"
#include "app/report/html.h"
#include "app/report/report.h"
#include "app/report/report_data.h"
#include "app/report/report_names.h"
#include "app/result/settled_forces.h"
#include "render/image.h"
#include "sim/base/error.h"
#include "tests/app/report/xml_check.h"
#include "tests/small_files.h"

namespace limberg {
namespace test_report {

namespace fs = std::filesystem;
using test::xml_fault;

const char* const kFull = R"({
"limberg": {"version": "0.1.0", "commit": "abc1234"}, "command": "replay", "scene": "rhomboid", "ok": true,
"machine": {"cpu": "Some CPU", "cores": 2}, "mode": "lockstep", "duration_s": 60.5, "state_hash": "00ff00ff00ff00ff",
"parts": ["cutter", "elasticity"], "memory_mb": 300, "reproduce": "limberg replay recordings/rhomboid.lcm --lockstep",
"device": {"ticks": 60500, "late_ticks": 3, "events_lost": 0, "wake_us": {"p50": 20, "p99": 80, "p999": 300, "max": 5000},
           "work_us": {"p50": 10, "p99": 40, "p999": 60, "max": 90}},
"solver": {"steps": 3630, "step_ms": {"p50": 8, "p95": 10, "p99": 12, "max": 40}, "residual": 3.2e-5, "distance_mm": 0.0123},
"render": {"frames": 900, "frame_ms": {"p50": 20, "p95": 28, "p99": 35, "max": 70}},
"latency_ms": {"sample_to_snapshot": {"p50": 12, "p99": 24}, "sample_to_frame": {"p50": 40, "p99": 90}},
"metrics": {"pieces": 1, "volume_mm3": 900, "removed_volume_mm3": 100, "initial_volume_mm3": 1000, "closure_force_N": 7.25,
            "suture_force_max_N": 2.75, "suture_gap_max_mm": 0.12, "dog_ear_mm": 1.9, "something_new_kPa": 12.5,
            "sutures": [{"id": 1, "force_N": 2.75, "gap_mm": 0.12}, {"id": 2, "force_N": 0.4, "gap_mm": 0.01}, {"id": 3}]},
"stages": [{"name": "excised", "picture": "stages/00-excised.png", "t_s": 10, "caption": "The plug is out."},
           {"name": "closed", "picture": "stages/01-closed.png", "t_s": 50, "sutures": 2, "residual": 3.2e-5}],
"series": {"t_s": [0, 1, 2, 3], "residual": [0.1, null, 1e-3, 3.2e-5]},
"balance": {"hooks_N": [0.1, 0, 0], "supports_N": [-0.1, 0.001, 0], "sum_N": [0, 0.001, 0], "relative": 0.005},
"convergence": [{"cell_mm": 5, "closure_force_N": 6.5, "dog_ear_mm": 1.6}, {"cell_mm": 3.5, "closure_force_N": 7.25, "dog_ear_mm": 1.9}],
"discretisation": {"closure_force_N": {"value": 7.25, "error": 0.3, "order": 1.4, "extrapolated": 7.0, "asymptotic": true, "says": "observed order 1.4"},
                   "dog_ear_mm": {"value": 1.9, "error": 0.9, "asymptotic": false, "says": "swings from size to size: not in the asymptotic range"}},
"script": [{"action": "excise", "depth_mm": 4}, "{\"action\":\"stage\",\"name\":\"excised\"}"]
})";

class Report : public ::testing::Test {
 protected:
  void SetUp() override {
    dir =
        fs::path(binary_dir()) / "test_report_files" / ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(dir);
    fs::create_directories(dir / "stages");
  }
  void put(const std::string& text) { std::ofstream(dir / "result.json", std::ios::binary) << text; }
  static std::string get(const fs::path& p) {
    std::ifstream in(p, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::string make(const std::string& json) {
    put(json);
    const std::string html = get(write_report(dir.string()));
    EXPECT_EQ(xml_fault(html), "");
    return html;
  }
  static size_t count(const std::string& s, const std::string& what) {
    size_t n = 0;
    for (size_t i = s.find(what); i != std::string::npos; i = s.find(what, i + 1)) ++n;
    return n;
  }
  fs::path dir;
};

TEST_F(Report, HoldsTheFigures) {
  write_png(dir / "stages/00-excised.png", Image(8, 6, {200, 150, 140}));
  write_png(dir / "stages/01-closed.png", Image(8, 6, {100, 150, 140}));
  write_png(dir / "tension.png", Image(8, 6, {10, 50, 140}));
  const std::string h = make(kFull);
  for (const char* text : {"Rhomboid",
                           "Sewn with 3 sutures",
                           "7.25\u202fN",
                           "2.75\u202fN",
                           "0.12\u202fmm",
                           "3.2\u202f×\u202f10⁻⁵",
                           "The plug is out.",
                           "p99.9",
                           "60500 device ticks",
                           "3 late by more than",
                           "excise",
                           "limberg replay recordings/rhomboid.lcm",
                           "00ff00ff00ff00ff",
                           "Some CPU",
                           "0.1.0",
                           "Larrabee",
                           "something_new_kPa",
                           "0.5\u202f% of the sum",
                           "(+0.75)",
                           "Tension map",
                           "lattice ± 0.3\u202fN, order 1.4",
                           "lattice ± 0.9\u202fmm, not yet settled",
                           "0.012\u202fmm",
                           "from equilibrium",
                           "swings from size to size"})
    EXPECT_NE(h.find(text), std::string::npos) << text;
  EXPECT_EQ(count(h, "data:image/png;base64,") + count(h, "data:image/jpeg;base64,"), 3u);
  EXPECT_EQ(count(h, "<svg"), 2u);
  EXPECT_EQ(h.find("http://", h.find("<body>")), h.find("http://www.w3.org/2000/svg"));  // a name, not an address
  EXPECT_EQ(count(h, "src=\"") + count(h, "href=\""), 3u);                               // nothing is fetched
  for (const auto& left : fs::directory_iterator(dir))
    EXPECT_FALSE(left.path().filename().string().starts_with(".limberg-")) << left.path();
}

TEST_F(Report, SameInputSameBytes) {
  const std::string first = make(kFull);
  EXPECT_EQ(make(kFull), first);
}

TEST_F(Report, ForcesOfUnsettledSamplesAreLeftOutAndCounted) {
  // A spring that has not converged pulls with 275 N; and once with a value that could be true.
  const std::string h = make(
      R"({"series":{"t_s":[0,1,2,3,4,5],"residual":[0.5,1e-3,0.9,2e-3,0.02,1e-5],
          "closure_N":[0,1.5,275,1.75,1.6,1.7],"suture_max_N":[0,0.5,90,0.5,0.5,0.5]}})");
  EXPECT_NE(h.find("2 of 5 samples with stitches are left out"), std::string::npos);
  EXPECT_NE(h.find("1.75\u202fN"), std::string::npos);
  const size_t at = h.find("<svg", h.find("Closure force over the operation"));
  ASSERT_NE(at, std::string::npos);
  const std::string chart = h.substr(at, h.find("</svg>", at) - at);
  EXPECT_EQ(chart.find(">200<"), std::string::npos) << "the axis reaches to what was left out";
  EXPECT_EQ(count(chart, "M"), 2 * 3u) << "each line has two gaps";
  // Where all are settled nothing is said.
  EXPECT_EQ(make(R"({"series":{"t_s":[0,1],"residual":[1e-3,1e-3],"closure_N":[1,2],"suture_max_N":[1,1]}})")
                .find("left out"),
            std::string::npos);
}

TEST(SettledForces, KeepsWhatIsInBalanceAndCountsTheRest) {
  const std::vector<double> residual{1, kForcesSettled, 2 * kForcesSettled, NAN}, sum{0, 3, 4, 5}, most{0, 1, 2, 3};
  const SettledForces f = settled_forces(residual, sum, most);
  EXPECT_EQ(f.pulling, 3u);
  EXPECT_EQ(f.unsettled, 1u);
  EXPECT_EQ(f.sum_N[0], 0) << "no stitch pulls: nothing is wrong with nothing";
  EXPECT_EQ(f.sum_N[1], 3);
  EXPECT_TRUE(std::isnan(f.sum_N[2]) && std::isnan(f.most_N[2]));
  EXPECT_EQ(f.sum_N[3], 5) << "without a residual nothing is known against it";
}

TEST_F(Report, TitlesSayWhatWasDone) {
  const auto title = [&](const std::string& json) {
    const std::string h = make(json);
    const size_t at = h.find("<h1>") + 4;
    return h.substr(at, h.find("</h1>") - at);
  };
  const std::string acts =
      R"("scene_title":"rhomboid","script":[{"action":"excise","outline":[[0,0],[20,0],[20,10],[0,10]],"depth_mm":4},
         {"action":"suture","a":[0,0],"b":[1,0]}])";
  EXPECT_EQ(title("{" + acts + "}"), "Excision and sutures");
  EXPECT_EQ(title("{" + acts + R"(,"lesson":{"title":"a rhomboid flap","all_met":true}})"), "A rhomboid flap");
  EXPECT_EQ(title("{" + acts + R"(,"lesson":{"title":"a rhomboid flap","all_met":false}})"), "Excision and sutures");
  EXPECT_EQ(title(R"({"scene_title":"rhomboid"})"), "Rhomboid");
}

TEST_F(Report, AnInterruptedRunSaysHowFarItCame) {
  const std::string h =
      make(R"({"interrupted":true,"duration_s":12.5,"commands":7,"stages":[{"name":"defect"},{"name":"flap cut"}]})");
  EXPECT_NE(h.find("Interrupted."), std::string::npos);
  EXPECT_NE(h.find("after 12.5\u202fs, after 7 acts, the last stage that was passed is “flap cut”"), std::string::npos);
  EXPECT_EQ(make(R"({"interrupted":false,"commands":7})").find("Interrupted."), std::string::npos);
}

// A stage was passed while the blade was in the skin.
TEST_F(Report, AStrokeIsToldWholeInTheStageWhereItBegan) {
  const std::string h = make(
      R"({"stages":[{"name":"one"},{"name":"two"}],"script":[
    {"action":"incise","stroke":1,"path":[[0,0],[5.2,0]],"depth_mm":4,"more":true},{"action":"stage","name":"one"},
    {"action":"incise","stroke":1,"path":[[12,0]],"depth_mm":4,"more":true},
    {"action":"incise","stroke":1,"path":[[20,0]],"depth_mm":4},
    {"action":"suture","a":[0,0],"b":[1,0]},{"action":"stage","name":"two"}]})");
  EXPECT_NE(h.find("Incision of 20\u202fmm, 4\u202fmm deep."), std::string::npos);
  EXPECT_EQ(count(h, "Incision of"), 1u);
}

TEST_F(Report, StagesSayWhatTheScriptDid) {
  const std::string h = make(
      R"({"stages":[{"name":"cut"},{"name":"own","caption":"My words."},{"name":"closed"},{"name":"other"}],"script":[
    {"limberg_script":1},{"action":"excise","outline":[[0,0],[20,0],[20,10],[0,10]],"depth_mm":4},{"action":"incise","path":[[0,0],[3,4],[3,14]],"depth_mm":5,"angle_deg":60},
    {"action":"stage","name":"cut"},{"action":"suture","a":[0,0],"b":[1,0]},{"action":"stage","name":"own"},{"action":"hook","id":1,"at":[0,0]},{"action":"hook","id":2,"at":[1,0]},{"action":"move","id":1,"to":[0,0,9]},
    {"action":"suture_row","a":[[0,0],[9,0]],"b":[[0,1],[9,1]]},"no JSON",{"action":7},{"action":"excise","outline":[7]},{"action":"stage","name":"closed"},{"action":"stage","name":"not other"}]})");
  EXPECT_NE(h.find("Excision of 200\u202fmm², 4\u202fmm deep. Incision of 15\u202fmm, 5\u202fmm deep, blade at 60°."),
            std::string::npos);
  EXPECT_NE(h.find("My words."), std::string::npos);
  EXPECT_EQ(h.find("One key suture"), std::string::npos);
  EXPECT_NE(h.find("2 hooks set. The flap is moved with the hooks. One row of sutures."), std::string::npos);
}

TEST_F(Report, AHeadHasItsOwnWordsAndItsPictures) {
  write_png(dir / "face.png", Image(8, 8));
  const std::string head =
      R"({"command": "operate", "scene": "craniofacial", "ok": true, "residual": 0, "distance_mm": 0, "stages": [{"name": "cut", "residual": 0}],
    "metrics": {"fragments": 3, "fragment_moved_max_mm": 8, "face_moved_max_mm": 7.5}, "gallery": [{"picture": "face.png", "caption": "The face after"}],
    "tables": [{"title": "Fragments", "columns": ["fragment"], "rows": [["cranium"]]}], "script": [{"action": "wait"}]})";
  const std::string html = make(head);
  EXPECT_NE(html.find("3 pieces of bone, the farthest carried 8\u202fmm; the face follows by up to 7.5\u202fmm."),
            std::string::npos);
  EXPECT_NE(html.find("<h2>Bones and face</h2>"), std::string::npos);
  EXPECT_NE(html.find("The face after"), std::string::npos);
  for (const char* of_skin : {"residual", "equilibrium", "The closure", "on the skin"})
    EXPECT_EQ(html.find(of_skin), std::string::npos) << of_skin;
}

TEST_F(Report, ChartsKeepTheirMarks) {
  const std::string chart =
      R"({"command": "bench", "charts": [{"title": "Error", "x": "size", "y": "mm", "x_marks": 7, "y_marks": [{"value": 1, "label": "aim 1 mm"}, {"label": "nowhere"}],
    "series": [{"name": "", "x": [1, 2], "y": [0.5, 2]}]}],
    "bars": [{"name": "error of the face", "value": 0.5, "bar": 1, "pass": true, "source": "the aim"}]})";
  const std::string html = make(chart);
  EXPECT_NE(html.find("aim 1\u202fmm"), std::string::npos);
  EXPECT_EQ(html.find("nowhere"), std::string::npos);
  EXPECT_NE(html.find("error of the face"), std::string::npos);
  EXPECT_NE(html.find("The one bar is met"), std::string::npos);
}

TEST_F(Report, LightsFollowTheLimits) {
  const auto with_force = [](double n, double gap) {
    return R"({"metrics":{"sutures":[{"id":1,"force_N":)" + std::to_string(n) + R"(,"gap_mm":)" + std::to_string(gap) +
           "}]}}";
  };
  EXPECT_NE(make(with_force(1, 0.1)).find("<div class=\"verdict good\">"), std::string::npos);
  EXPECT_NE(make(with_force(3, 0.1)).find("<div class=\"verdict warn\">"), std::string::npos);
  EXPECT_NE(make(with_force(6, 0.1)).find("<div class=\"verdict bad\">"), std::string::npos);
  EXPECT_NE(make(with_force(1, 0.3)).find("<div class=\"verdict warn\">"), std::string::npos);
  EXPECT_NE(make(R"({"ok":false,"residual":0.01})").find("did not reach its goal"), std::string::npos);
}

TEST_F(Report, BeginsWithWhatIsWrong) {
  const std::string sewn = R"("metrics":{"sutures":[{"id":1,"force_N":1,"gap_mm":0.02}],"suture_gap_max_mm":0.02})";
  const std::string html = make(
      R"({"ok":false,"verdict":[
    {"what":"wound gape, widest","value":11,"unit":"mm","limit":2,"place":"(3.1, -4.0) mm","light":"bad","source":"Hollander"},
    {"what":"stitches that hold nothing: slack","value":1,"unit":"","limit":0,"place":"stitch 1","light":"warn","source":"x"},
    {"what":"dog-ear","value":1,"unit":"mm","limit":4,"place":"","light":"good","source":"y"},
    {"what":"open <b>","value":null,"unit":"mm","limit":null,"place":"","light":"told","source":""},{"what":7,"value":{},"limit":[]},7],)" +
      sewn + "}");
  const size_t wrong = html.find("What is wrong"), look = html.find("Worth a look"), body = html.find("</header>");
  ASSERT_NE(wrong, std::string::npos);
  EXPECT_NE(html.find("Wound gape, widest: 11\u202fmm at (3.1, -4.0) mm; at most 2\u202fmm"), std::string::npos);
  EXPECT_LT(wrong, look);
  EXPECT_EQ(html.find("<div", body), html.rfind("<div class=\"verdict bad\">", wrong)) << "nothing stands before it";
  EXPECT_EQ(html.find("Closed"), std::string::npos);
  EXPECT_NE(html.find("Not closed, with 1 suture"), std::string::npos);
  EXPECT_EQ(html.find("open <b>"), std::string::npos);
  const std::string closed = make(
      R"({"ok":true,"verdict":[{"what":"closed along its whole edge","value":40,"unit":"mm","limit":null,"place":"gapes by at most 1.6 mm","light":"good","source":""}],)" +
      sewn + "}");
  EXPECT_NE(closed.find("Closed along its whole edge (gapes by at most 1.6\u202fmm) with 1 suture"), std::string::npos);
  EXPECT_EQ(closed.find("What is wrong"), std::string::npos);
}

TEST_F(Report, AbsentFieldsAreAbsent) {
  const std::string h = make("{}");
  for (const char* text : {"Sutures", "Tension map", "Three lanes", "NaN", "nan", "null", "<svg", "Finer cells"})
    EXPECT_EQ(h.find(text), std::string::npos) << text;
  EXPECT_NE(h.find("<h1>Operation</h1>"), std::string::npos);
}

TEST_F(Report, WrongKindsAreLeftOut) {
  // Every field of the full example replaced in turn by something of another kind: never a crash, always well formed.
  for (const char* name :
       {"limberg",    "command", "scene",    "machine", "mode",    "device",      "solver",         "render",
        "latency_ms", "metrics", "stages",   "series",  "balance", "convergence", "discretisation", "script",
        "reproduce",  "parts",   "pictures", "damage",  "lattice", "ok",          "duration_s"})
    for (const char* value :
         {"null", "7", "-1e308", "\"x\"", "[]", "[1,[2],{}]", "{}", "{\"sutures\":{}}", "[[[]]]", "true"})
      make("{\"" + std::string(name) + "\": " + value + "}");
  make(
      R"({"metrics":{"sutures":[7,null,{"id":{},"force_N":"x","gap_mm":null}]},"series":{"t_s":[1],"residual":[-1,0,1e308,1e-308,5]},"balance":{"a":[1,2,"x"]}})");
  make(R"({"series":{"residual":[0,0,0]}})");
  make(R"({"series":{"residual":[1e-4,1e-4],"distance_mm":[5,5]}})");
}

TEST_F(Report, HostileWordsAreEscaped) {
  const std::string bad = R"(<script>alert(1)</script>\"'><img src=x onerror=y>&amp;\u0000\u0007\ud83d\ude00)";
  const std::string h =
      make(R"({"scene":")" + bad + R"(","scene_title":")" + bad + R"(","command":")" + bad + R"(","reproduce":")" +
           bad + R"(","mode":")" + bad + R"(","state_hash":")" + bad + R"(","scene_note":")" + bad +
           R"(","limberg":{"version":")" + bad + R"("},"machine":{"cpu":")" + bad + R"("},"parts":[")" + bad +
           R"("],"script":[")" + bad + R"("],"damage":{")" + bad + R"(":")" + bad + R"("},"stages":[{"name":")" + bad +
           R"(","caption":")" + bad + R"(","t_s":1}],"metrics":{")" + bad + R"(":1,"sutures":[{"id":")" + bad +
           R"("}]},"series":{"t_s":[0,2],"residual":[1,2]},"balance":{")" + bad + R"(":[1,2,3]},"lattice":{")" + bad +
           R"(":1}})");
  EXPECT_EQ(h.find("<script"), std::string::npos);
  EXPECT_EQ(h.find("<img"), std::string::npos);
  EXPECT_NE(h.find("&lt;script&gt;"), std::string::npos);
}

TEST_F(Report, PicturesOutsideTheFolderAreNotTaken) {
  write_png(dir / "secret.png", Image(4, 4));
  const fs::path inner = dir / "inner";
  fs::create_directories(inner);
  const std::string outside = (dir / "secret.png").string();
  const std::string json =
      R"({"stages":[{"name":"a","picture":"../secret.png"},{"name":"b","picture":")" + outside +
      R"("},{"name":"c","picture":"x/../../secret.png"}],"pictures":{"tension":"../secret.png","overview":"../secret.png"}})";
  EXPECT_EQ(report_html(json, inner.string()).find("data:image"), std::string::npos);
  std::ofstream(dir / "stages/00-text.png") << "no picture";
  EXPECT_EQ(make("{}").find("data:image"), std::string::npos);
}

TEST_F(Report, LargeStagePicturesAreMadeSmaller) {
  Image noise(1280, 720);
  uint32_t state = 1;
  for (uint8_t& v : noise.rgb) v = uint8_t((state = state * 1664525u + 1013904223u) >> 24);
  write_png(dir / "stages/00-noise.png", noise);
  write_png(dir / "tension.png", noise);
  const std::string page = make("{}");
  const auto held = [&](const Image& picture) {
    return count(page, "data:image/jpeg;base64," + html::base64(encode_jpeg(picture, html::kPagePictureQuality)));
  };
  EXPECT_EQ(held(shrink(noise, 2)), 1u);
  EXPECT_EQ(held(noise), 1u);  // the tension map keeps its size
}

/// A JPEG where that is smaller; its tables alone are larger than a small plain PNG.
TEST_F(Report, PicturesAreHeldInTheFewerBytes) {
  const Image plain(8, 8, {250, 250, 250});
  write_png(dir / "tension.png", plain);
  const std::string page = make("{}");
  EXPECT_EQ(count(page, "data:image/png;base64," + html::base64(encode_png(plain))), 1u);
  EXPECT_EQ(count(page, "data:image/jpeg"), 0u);
}

TEST_F(Report, PicturesAloneTellTheStory) {
  write_png(dir / report_names::stage_picture(1, "Flap cut!"), Image(4, 4));
  write_png(dir / report_names::stage_picture(0, "before"), Image(4, 4));
  const std::string h = make("{}");
  ASSERT_NE(h.find("2. Flap cut"), std::string::npos);
  EXPECT_LT(h.find("1. Before"), h.find("2. Flap cut"));
  EXPECT_EQ(report_names::stage_picture(7, "  D -> F / key (1) "), "stages/07-d-f-key-1.png");
  EXPECT_EQ(report_names::stage_picture(3, "../../x"), "stages/03-x.png");
  EXPECT_EQ(report_names::stage_picture(3, "äöü"), "stages/03.png");
}

TEST_F(Report, BrokenResultsAreInputErrors) {
  const auto fault = [&](const std::string& text) -> std::string {
    put(text);
    try {
      write_report(dir.string());
    } catch (const InputError& e) {
      return e.what();
    }
    return "no error";
  };
  for (const std::string text : {"", "{", "[]", "7", "{\"a\":1}}", "{\"a\":\xff}", "{\"a\":1e999}", "\n\n{\n\"a\" 1}"})
    EXPECT_NE(fault(text).find("result.json"), std::string::npos) << text;
  EXPECT_NE(fault("{\n\"a\": 1,\n\"b\" 2\n}").find("result.json:3: "), std::string::npos);
  EXPECT_NE(fault("{\"script\":[" + std::string(200000, '[') + std::string(200000, ']') + "]}").find("deeper"),
            std::string::npos);
  const std::string whole = kFull;
  for (size_t n = 1; n + 1 < whole.size(); n += 41)
    EXPECT_NE(fault(whole.substr(0, n)).find("result.json"), std::string::npos) << n;
  fs::remove(dir / "result.json");
  EXPECT_THROW(write_report(dir.string()), InputError);
  fs::create_directory(dir / "result.json");
  EXPECT_THROW(write_report(dir.string()), InputError);
  EXPECT_THROW(write_report((dir / "nowhere").string()), InputError);
}

TEST_F(Report, AnOldReportSurvivesAFailure) {
  const std::string first = make(kFull);
  put("{broken");
  EXPECT_THROW(write_report(dir.string()), InputError);
  EXPECT_EQ(get(dir / "report.html"), first);
  put("{}");
  {
    const SmallFiles no_room(64);
    EXPECT_THROW(write_report(dir.string()), InputError);
  }
  EXPECT_EQ(get(dir / "report.html"), first);
}

// The checker itself must find faults, or the tests above prove nothing.
TEST(XmlCheck, FindsPlantedFaults) {
  EXPECT_EQ(xml_fault("<!DOCTYPE html><a b=\"c\">x &lt; y<br/></a>"), "");
  for (const char* bad : {"<a>", "<a></b>", "<a b=c></a>", "<a b=\"<\"></a>", "a & b", "a < b", "<a b=\"1\" b=\"2\"/>",
                          "<a b=\"x", "&nbsp;", "\x01", "</a>"})
    EXPECT_NE(xml_fault(bad), "") << bad;
}

TEST_F(Report, ComparesTwoResults) {
  std::string other = kFull;
  const auto put_in = [&](const std::string& from, const std::string& to) {
    const size_t at = other.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    other.replace(at, from.size(), to);
  };
  put_in("\"closure_force_N\": 7.25", "\"closure_force_N\": 9.25");  // beyond .3 + .3
  put_in("\"dog_ear_mm\": 1.9", "\"dog_ear_mm\": 2.9");              // within .9 + .9
  put_in("{\"action\": \"excise\", \"depth_mm\": 4}", "{\"action\": \"excise\", \"depth_mm\": 5}");
  put_in("00ff00ff00ff00ff", "11ff00ff00ff00ff");
  const std::string html = comparison_html(kFull, dir.string(), other, dir.string());
  EXPECT_EQ(xml_fault(html), "");
  EXPECT_NE(html.find("Different states"), std::string::npos);
  // Sentences and pictures come first, every figure is folded below them.
  EXPECT_NE(html.find("The stitches together pull with 7.25\u202fN in A and 9.25\u202fN in B, 28\u202f% more, beyond "
                      "what the errors of the lattices explain."),
            std::string::npos);
  EXPECT_NE(html.find("The skin stands up by at most 1.9\u202fmm in A and 2.9\u202fmm in B"), std::string::npos);
  const size_t words = html.find("What differs"), pairs = html.find(">Pictures<"), figures = html.find("All figures");
  EXPECT_TRUE(words < pairs && pairs < figures && figures != std::string::npos);
  EXPECT_LE(count(html.substr(words, pairs - words), "<li>"), 6u);
  EXPECT_EQ(count(html, "<details>"), 4u);
  EXPECT_EQ(html.find(">something_new_kPa<"), std::string::npos) << "a name of the file as a name";
  EXPECT_NE(html.find(">something new (kPa)<"), std::string::npos);
  const auto row = [&](const std::string& name) {
    const size_t at = html.find("<span title=\"" + name + ": ");
    return at == std::string::npos ? std::string() : html.substr(at, html.find("</tr>", at) - at);
  };
  EXPECT_NE(row("closure_force_N").find("closure force, N"), std::string::npos) << "named in words, with its unit";
  EXPECT_NE(row("closure_force_N").find("+2"), std::string::npos) << row("closure_force_N");
  EXPECT_NE(row("closure_force_N").find("beyond"), std::string::npos);
  EXPECT_NE(row("dog_ear_mm").find("within"), std::string::npos);
  EXPECT_NE(row("pieces").find("same"), std::string::npos);
  EXPECT_EQ(row("suture_gap_max_mm").find("within"), std::string::npos);  // no error known: nothing claimed
  EXPECT_NE(html.find("<b class=\"bad\">- "), std::string::npos);
  EXPECT_NE(html.find("<b class=\"good\">+ "), std::string::npos);
  const std::string same = comparison_html(kFull, dir.string(), kFull, dir.string());
  EXPECT_NE(same.find("The same state at the end"), std::string::npos);
  EXPECT_EQ(same.find("<b class=\"bad\">- "), std::string::npos);
  EXPECT_THROW(write_comparison(dir.string(), (dir / "none").string(), (dir / "c.html").string()), InputError);
}

TEST(LineChanges, AreAShortestWay) {
  const auto text = [](const std::vector<LineChange>& c) {
    std::string s;
    for (const LineChange& l : c) s += l.kind + l.line;
    return s;
  };
  EXPECT_EQ(text(line_changes({"a", "b", "c"}, {"a", "x", "c"})), " a-b+x c");
  EXPECT_EQ(text(line_changes({}, {"a"})), "+a");
  EXPECT_EQ(text(line_changes({"a", "b"}, {})), "-a-b");
  // Whatever the texts are: without its + lines the change is the first, without its - lines the second.
  uint32_t seed = 1;
  for (int round = 0; round < 200; ++round) {
    std::vector<std::string> in[2];
    for (auto& t : in)
      for (int i = 0; i < round % 9; ++i)
        seed = seed * 1664525 + 1013904223, t.push_back(std::string(1, char('a' + (seed >> 24) % 3)));
    std::vector<std::string> first, second;
    for (const LineChange& l : line_changes(in[0], in[1])) {
      if (l.kind != '+') first.push_back(l.line);
      if (l.kind != '-') second.push_back(l.line);
    }
    EXPECT_EQ(first, in[0]);
    EXPECT_EQ(second, in[1]);
  }
}

}  // namespace test_report
}  // namespace limberg
