// A peer's files are read as they come: with a comma missing, with acts that are none, and never with numbers that
// cannot be used.
#include <gtest/gtest.h>

#include "app/import/lenient_json.h"
#include "app/import/peer_files.h"
#include "sim/base/error.h"
#include "tests/app/import/peer_fixture.h"

namespace limberg {
namespace test_peer_files {

using test::PeerFixture;

/// The message of an InputError of f; empty: there was none.
template <class F>
std::string refusal(F&& f) {
  try {
    f();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(LenientJson, KnowsTheLineOfEveryValue) {
  const LenientJson v =
      parse_lenient_json("{\n \"a\": [1,\n  -2.5e1],\n \"b\": {\"c\": true, \"d\": \"x\\\"\\u0041\"}\n}", "f", nullptr);
  ASSERT_EQ(v.kind, LenientJson::Kind::object);
  EXPECT_EQ(v.find("a")->item[1].line, 3);
  EXPECT_EQ(v.find("a")->item[1].number, -25);
  EXPECT_EQ(v.find("b")->find("d")->text, "x\"A");
  EXPECT_EQ(v.find("b")->find("d")->line, 4);
  EXPECT_EQ(v.find("c"), nullptr);
}

TEST(LenientJson, LetsAMissingCommaPassAndSaysSo) {
  std::vector<std::string> mended;
  const LenientJson v = parse_lenient_json("[{\"a\":1}\n{\"a\":2},]", "f.hst", &mended);
  EXPECT_EQ(v.item.size(), 2u);
  ASSERT_EQ(mended.size(), 1u);
  EXPECT_NE(mended[0].find("f.hst:2:"), std::string::npos) << mended[0];
}

TEST(LenientJson, RefusesTheRestWithItsLine) {
  for (const char* broken : {"", "[", "[1,", "[1 2]", "[,1]", "[1,,2]", "{\"a\"1}", "{1:2}", "[NaN]", "[1e999]", "[-]",
                             "[\"a", "[\"a\nb\"]", "[\"\\q\"]", "[1]x", "[tru]", "{\"a\":1"})
    EXPECT_NE(refusal([&] { parse_lenient_json(broken, "f", nullptr); }).find("f:"), std::string::npos) << broken;
  EXPECT_NE(refusal([] { parse_lenient_json(std::string(100, '['), "f", nullptr); }).find("deep"), std::string::npos);
  EXPECT_NE(refusal([] { parse_lenient_json("[\n1,\n\nx]", "f", nullptr); }).find("f:4:"), std::string::npos);
}

TEST(PeerScene, SaysWhatIsWrong) {
  EXPECT_EQ(parse_peer_scene(PeerFixture::scene(), "s").object, "slab.obj");
  EXPECT_EQ(parse_peer_scene(PeerFixture::scene(), "s").levels, 4);
  const auto wrong = [](std::string from, const std::string& to) {
    std::string s = PeerFixture::scene();
    s.replace(s.find(from), from.size(), to);
    return refusal([&] { parse_peer_scene(s, "s.smd"); });
  };
  EXPECT_NE(wrong("\"slab.obj\"", "\"../slab.obj\"").find("name of a model"), std::string::npos);
  EXPECT_NE(wrong(":34}", ":1e9}").find("maxDimMegatetSubdivs"), std::string::npos);
  EXPECT_NE(wrong("0.8", "\"much\"").find("minStrain is a text; expected a number"), std::string::npos);
  EXPECT_NE(wrong("dynamicObjects", "dynamicobjects").find("dynamicObjects"), std::string::npos);
}

TEST(PeerHistory, KeepsAnActThatIsNoneWithWhatIsWrongAboutIt) {
  const std::string good = PeerFixture::excise(20, 20);
  const PeerHistory h = parse_peer_history(
      PeerFixture::history({good, "{\"excise\":{\"material\":2,\"historyTexture\":[0.1]}}",
                            "{\"moveHook\":[0,1e300,0,0]}", "{\"addHook\":{" + PeerFixture::place(1, 1) + "}}",
                            "{\"fly\":1}", "7", "{\"makeIncision\":{}}", good}),
      "h.hst");
  ASSERT_EQ(h.act.size(), 9u);
  const char* expected[] = {
      "", "", "historyTexture", "moveHook", "hookNum", "no known kind", "no act", "expected a list", ""};
  for (size_t i = 0; i < h.act.size(); ++i) {
    EXPECT_EQ(h.act[i].wrong.empty(), expected[i][0] == '\0') << i << h.act[i].wrong;
    EXPECT_NE(h.act[i].wrong.find(expected[i]), std::string::npos) << i << ": " << h.act[i].wrong;
    EXPECT_EQ(h.act[i].line, int(i) + 2) << i;
  }
}

TEST(PeerHistory, HasItsActsWhereACommaIsMissing) {
  const std::vector<std::string> acts{PeerFixture::excise(20, 20), PeerFixture::excise(30, 20)};
  const PeerHistory h = parse_peer_history(PeerFixture::history(acts, "\n"), "h.hst");
  EXPECT_EQ(h.act.size(), 3u);
  EXPECT_EQ(h.mended.size(), 2u);
}

TEST(PeerBed, RefusesWhatIsNoDeepPoint) {
  EXPECT_EQ(parse_peer_bed("3 1 2 3\r\n\n4 1 2 3.5\n", "b").vertex.size(), 2u);
  for (const char* broken : {"3 1 2", "3 1 2 3 4", "-1 1 2 3", "3 1 2 nan", "3 1 2 1e9", "x 1 2 3", "9999999 1 2 3"})
    EXPECT_NE(refusal([&] { parse_peer_bed("1 1 1 1\n" + std::string(broken), "b"); }).find("b:2:"), std::string::npos)
        << broken;
}

TEST(PeerModel, RefusesWhatIsNone) {
  const PeerFixture f;
  const PeerScene scene = parse_peer_scene(PeerFixture::scene(), "s");
  const auto wrong = [&](const std::string& obj, double unit_mm = 10) {
    return refusal([&] { parse_peer_model(obj, "m.obj", scene, nullptr, "", unit_mm); });
  };
  EXPECT_EQ(wrong(f.obj), "");
  EXPECT_NE(wrong(f.obj, 1000).find("6000 mm long"), std::string::npos);
  EXPECT_NE(wrong("").find("m.obj"), std::string::npos);
  std::string unnamed = f.obj;
  unnamed.replace(unnamed.find("usemtl 2"), 8, "usemtl x");
  EXPECT_NE(wrong(unnamed).find("no number"), std::string::npos) << wrong(unnamed);
  std::string bare = f.obj;
  for (const char* m : {"usemtl 1\n", "usemtl 2\n", "usemtl 7\n"}) bare.erase(bare.find(m), 9);
  EXPECT_NE(wrong(bare).find("without a material"), std::string::npos);
  PeerBed bed;
  bed.vertex = {99'999}, bed.deep = {Vec3::Zero()};
  EXPECT_NE(refusal([&] { parse_peer_model(f.obj, "m.obj", scene, &bed, "b.bed", 10); }).find("b.bed:1:"),
            std::string::npos);
}

}  // namespace test_peer_files
}  // namespace limberg
