// docs/figures.md: written from results of benches, up to date, and nothing else of the page touched.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "app/program/places.h"
#include "sim/base/error.h"
#include "tests/bench/figures/figures.h"

namespace limberg {
namespace test_figures {

namespace fs = std::filesystem;

std::string slurp(const fs::path& p) {
  std::ifstream in(p, std::ios::binary);
  std::ostringstream s;
  s << in.rdbuf();
  return s.str();
}

class Figures : public ::testing::Test {
 protected:
  Figures() {
    std::string name = (fs::temp_directory_path() / "limberg-figures-XXXXXX").string();
    dir_ = mkdtemp(name.data());
    fs::create_directory(dir_ / "kept");
  }
  ~Figures() override { fs::remove_all(dir_); }
  std::string file(const std::string& name, const std::string& text) const {
    std::ofstream(dir_ / name, std::ios::binary) << text;
    return (dir_ / name).string();
  }
  std::string kept() const { return (dir_ / "kept").string(); }
  fs::path dir_;
};

std::string result(const std::string& call, double value, bool pass) {
  std::ostringstream s;
  s << R"({"limberg":{"version":"0.1.0","commit":"abc"},"command":"bench","scene":"","machine":{"cpu":"A CPU","cores":2},)"
    << R"("ok":true,"suite":"speed","quick":false,"reproduce":")" << call << R"(","rows":[{"case":"long"}],"bars":[)"
    << R"({"name":"times | faster","value":)" << value << R"(,"at_least":true,"bar":50,"larger_is_better":true,"pass":)"
    << (pass ? "true" : "false") << R"(,"source":"a paper"}]})";
  return s.str();
}

TEST_F(Figures, ATableAndItsPicturesAreKeptWhereTheyAreTheFigures) {
  std::string text = result("limberg bench speed", 1, true);
  text.replace(text.find("\"speed\""), 7, "\"start\"");
  text.replace(text.find(R"({"case":"long"})"), 15,
               R"({"case":"tiny","method":"plain","time_ms":12.34,"error":33,"error_unit":"MB","settings":"a | b"})");
  const std::string r = file("r.json", text);
  file("start-memory.svg", "<svg/>"), file("other-memory.svg", "<svg/>");
  bench::keep_result(r, kept(), {"2026-11-23", ""});
  EXPECT_TRUE(fs::exists(fs::path(kept()) / "start-memory.svg"));
  EXPECT_FALSE(fs::exists(fs::path(kept()) / "other-memory.svg"));
  const std::string page = bench::figures_text(kept());
  EXPECT_NE(page.find("| tiny | plain | 12.3 | 33 MB | a \\| b |"), std::string::npos) << page;
  EXPECT_NE(page.find("(figures/start-memory.svg)"), std::string::npos) << page;
}

TEST_F(Figures, ABarOfAResultStandsInThePage) {
  const std::string page =
      file("page.md", std::string("before\n\n") + bench::kFiguresBegin + "\nold\n" + bench::kFiguresEnd + "\nafter\n");
  const std::string r = file("r.json", result("limberg bench speed --only slab --json /tmp/r.json", 82.04, true));
  const std::string small = bench::keep_result(r, kept(), {"2026-11-23", "Beside other work."});
  EXPECT_EQ(fs::path(small).filename(), "speed-slab.json");
  EXPECT_EQ(slurp(small).find("/tmp/r.json"), std::string::npos);  // no path of a machine
  EXPECT_EQ(slurp(small).find("rows"), std::string::npos);
  bench::write_page(kept(), page);
  const std::string text = slurp(page);
  EXPECT_TRUE(text.starts_with("before\n")) << text;
  EXPECT_TRUE(text.ends_with("\nafter\n")) << text;
  EXPECT_EQ(text.find("old"), std::string::npos) << text;
  for (const char* part : {"| times \\| faster | > 82 | at least 50 | met |", "`limberg bench speed --only slab`",
                           "A CPU, 2 cores", "2026-11-23", "Beside other work."})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  bench::write_page(kept(), page);
  EXPECT_EQ(slurp(page), text);
}

TEST_F(Figures, ANewMeasurementTakesThePlaceOfTheSame) {
  const std::string call = "limberg bench speed --json x";
  bench::keep_result(file("a.json", result(call, 82, true)), kept(), {"2026-11-22", ""});
  bench::keep_result(file("b.json", result(call, 41, false)), kept(), {"2026-11-23", ""});
  const std::string text = bench::figures_text(kept());
  EXPECT_EQ(text.find("82"), std::string::npos) << text;
  EXPECT_NE(text.find("| > 41 | at least 50 | **missed** |"), std::string::npos) << text;
}

TEST_F(Figures, SuitesThatWereNotMeasuredAnewAreNamedWithTheirDate) {
  file("kept/earlier.json", R"({"speed":"2026-11-21","cutting":"2026-11-22"})");
  bench::keep_result(file("a.json", result("limberg bench speed --only slab", 82, true)), kept(), {"2026-11-23", ""});
  EXPECT_NE(bench::figures_text(kept()).find("| speed | 2026-11-21 |"), std::string::npos);  // a part is no whole
  bench::keep_result(file("b.json", result("limberg bench speed", 82, true)), kept(), {"2026-11-23", ""});
  const std::string text = bench::figures_text(kept());
  EXPECT_EQ(text.find("| speed | 2026-11-21 |"), std::string::npos) << text;
  EXPECT_NE(text.find("| cutting | 2026-11-22 |"), std::string::npos) << text;
}

TEST_F(Figures, WhatIsNoResultOfABenchIsRefused) {
  EXPECT_THROW(bench::keep_result(file("a.json", "[]"), kept(), {}), InputError);
  EXPECT_THROW(bench::keep_result(file("b.json", R"({"command":"replay"})"), kept(), {}), InputError);
  EXPECT_THROW(bench::keep_result(file("c.json", R"({"command":"bench","suite":"speed"})"), kept(), {}), InputError);
  EXPECT_THROW(bench::keep_result((dir_ / "none.json").string(), kept(), {}), InputError);
  EXPECT_THROW(bench::write_page(kept(), file("page.md", "no markers\n")), InputError);
  EXPECT_TRUE(fs::is_empty(kept()));
}

TEST(FiguresPage, IsWhatItsFolderGives) {
  const std::string docs = source_dir() + "/docs";
  EXPECT_NE(slurp(docs + "/figures.md").find(bench::figures_text(docs + "/figures")), std::string::npos)
      << "docs/figures.md is not what docs/figures/*.json give; expected the page of ./do figures";
}

}  // namespace test_figures
}  // namespace limberg
