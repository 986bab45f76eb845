// What is put into a page to be turned: packed models come out again as they were, a page with one is well formed, runs
// its own scripts only and fetches nothing, and what is no model leaves the page without.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "app/program/places.h"
#include "app/report/report.h"
#include "app/report/viewer.h"
#include "app/words/chosen_words.h"
#include "sim/base/error.h"
#include "tests/app/report/xml_check.h"

namespace limberg {
namespace test_viewer {

namespace fs = std::filesystem;

/// Views with rows of 8, 1 and 6 bytes, the last with a rest that is no row.
std::string glb() {
  std::string json =
      R"({"asset":{"version":"2.0","extras":{"limberg_page_model":1}},"bufferViews":[)"
      R"({"buffer":0,"byteOffset":0,"byteLength":32,"byteStride":8},{"buffer":0,"byteOffset":32,"byteLength":5},)"
      R"({"buffer":0,"byteOffset":40,"byteLength":20,"extras":{"row":6}}],"buffers":[{"byteLength":60}]})";
  while (json.size() % 4) json += ' ';
  std::string bin;
  for (int i = 0; i < 60; ++i) bin += char(i * i * 7 + 3);
  std::string out = "glTF";
  const auto word = [&](size_t n) {
    const auto v = uint32_t(n);
    out.append(reinterpret_cast<const char*>(&v), 4);
  };
  word(2), word(28 + json.size() + bin.size()), word(json.size()), word(0x4E4F534A), out += json;
  word(bin.size()), word(0x004E4942);
  return out + bin;
}

std::string gunzip(const std::string& packed) {
  z_stream z{};
  EXPECT_EQ(inflateInit2(&z, 15 + 16), Z_OK);
  std::string out(1 << 20, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data())), z.avail_in = uInt(packed.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data()), z.avail_out = uInt(out.size());
  EXPECT_EQ(inflate(&z, Z_FINISH), Z_STREAM_END);
  out.resize(z.total_out);
  inflateEnd(&z);
  return out;
}

/// As viewer.js does it: sums over the first bytes of all rows, then over the second ones.
void put_back(std::string& bytes, size_t at, size_t length, size_t row) {
  const size_t rows = length / row;
  const std::string part = bytes.substr(at, rows * row);
  for (size_t k = 0, from = 0; k < row; ++k) {
    unsigned char sum = 0;
    for (size_t i = 0; i < rows; ++i)
      bytes[at + i * row + k] = char(sum = static_cast<unsigned char>(sum + part[from++]));
  }
}

TEST(Viewer, PacksAModelThatComesOutAsItWas) {
  const std::string model = glb();
  std::string out = gunzip(packed_model(model, "model.glb"));
  ASSERT_EQ(out.size(), model.size());
  EXPECT_NE(out, model);
  const size_t bin = model.size() - 60;
  put_back(out, bin, 32, 8), put_back(out, bin + 32, 5, 1), put_back(out, bin + 40, 20, 6);
  EXPECT_EQ(out, model);
}

TEST(Viewer, RefusesWhatIsNoModel) {
  const std::string model = glb();
  for (size_t n : {size_t(0), size_t(11), size_t(27), size_t(60), model.size() - 1})
    EXPECT_THROW(packed_model(model.substr(0, n), "f"), InputError) << n;
  const auto with = [&](const std::string& what, const std::string& other) {
    std::string m = model;
    m.replace(m.find(what), what.size(), other);
    return m;
  };
  for (const auto& [what, other] :
       {std::pair("limberg_page_model", "limberg_page_modem"), std::pair("\"byteOffset\":40", "\"byteOffset\":60"),
        std::pair("\"byteOffset\":32", "\"byteOffset\":12"), std::pair("\"byteStride\":8", "\"byteStride\":0"),
        std::pair("{\"asset\"", "[\"asset\"")})
    EXPECT_THROW(packed_model(with(what, other), "f"), InputError) << other;
}

class ViewerPage : public ::testing::Test {
 protected:
  // Of each test its own: they may run side by side.
  const fs::path dir =
      fs::path(binary_dir()) / "test_viewer_files" / ::testing::UnitTest::GetInstance()->current_test_info()->name();
  void SetUp() override { fs::remove_all(dir), fs::create_directories(dir); }
  std::string page() const { return report_html(R"({"command": "operate", "scene": "small"})", dir.string()); }
};

TEST_F(ViewerPage, HoldsTheModelAndFetchesNothing) {
  if (!viewer_is_built()) GTEST_SKIP() << "built without three.js (libjs-three)";
  const std::string without = page();
  EXPECT_EQ(without.find("<script"), std::string::npos);
  EXPECT_EQ(without.find("script-src"), std::string::npos);
  std::ofstream(dir / "model.glb", std::ios::binary) << glb();
  const std::string html = page();
  EXPECT_EQ(test::xml_fault(html), "");
  const size_t policy = html.find("script-src 'nonce-");
  ASSERT_NE(policy, std::string::npos);
  const std::string nonce = html.substr(policy + 18, 16);
  EXPECT_NE(html.find("default-src 'none'"), std::string::npos);
  EXPECT_EQ(html.find("connect-src"), std::string::npos);
  // Two scripts run, three.js and the viewer, both by name; the others are data.
  size_t run = 0, all = 0;
  for (size_t i = html.find("<script"); i != std::string::npos; i = html.find("<script", i + 1)) {
    ++all;
    if (html.compare(i, 8 + 7 + 16 + 1, "<script nonce=\"" + nonce + "\"") == 0) ++run;
  }
  EXPECT_EQ(run, 2u);
  EXPECT_EQ(all, 4u);
  EXPECT_NE(html.find("<noscript>"), std::string::npos);
  EXPECT_EQ(html.find(" src=\"http"), std::string::npos);
  EXPECT_LT(html.size(), without.size() + 1'000'000);  // what every page pays
}

TEST_F(ViewerPage, SaysAllItSaysInItsLanguage) {
  if (!viewer_is_built()) GTEST_SKIP() << "built without three.js (libjs-three)";
  std::ofstream(dir / "model.glb", std::ios::binary) << glb();
  const Viewer v = viewer({{"one", dir.string()}}, chosen_words({"de", ""}));
  EXPECT_NE(v.section.tags().find("\"act {} of {}\":\"Handlung {} von {}\""), std::string::npos);
  EXPECT_NE(v.section.tags().find("\"Play\":\"Abspielen\""), std::string::npos);
}

TEST_F(ViewerPage, StaysWithoutWhatIsDamaged) {
  std::ofstream(dir / "model.glb", std::ios::binary) << glb().substr(0, 100);
  EXPECT_EQ(page().find("<script"), std::string::npos);
}

}  // namespace test_viewer
}  // namespace limberg
