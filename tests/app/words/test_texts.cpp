// Every text of the program stands in app/words/limberg.pot, and every one of these in every shipped table. With
// LIMBERG_WRITE_TEXTS in the environment the list is written anew (./do words).
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <regex>

#include "app/program/places.h"
#include "app/words/chosen_words.h"
#include "sim/base/whole_file.h"
#include "tests/app/words/texts.h"

namespace limberg {
namespace test_texts {

using testing::MarkedText;

std::string shipped(const std::string& name) { return source_dir() + "/app/words/" + name; }

TEST(Texts, TheListIsThatOfCodeAndData) {
  const std::string pot = testing::pot_of(testing::all_texts());
  if (std::getenv("LIMBERG_WRITE_TEXTS")) write_whole_file(shipped("limberg.pot"), pot);
  const PoFile is = parse_po(pot, "the code"), listed = read_po(shipped("limberg.pot"));
  const auto keys = [](const PoFile& po) {
    std::map<std::string, std::string> all;
    for (const PoEntry& e : po.entries) all[key_of(e.context, e.english)] = e.many;
    return all;
  };
  const auto in_code = keys(is), in_list = keys(listed);
  EXPECT_GT(in_code.size(), 1000u);
  for (const auto& [key, many] : in_code) {
    const auto at = in_list.find(key);
    EXPECT_TRUE(at != in_list.end() && at->second == many) << "not in limberg.pot (./do words): " << key;
  }
  for (const auto& [key, many] : in_list) EXPECT_TRUE(in_code.contains(key)) << "in limberg.pot alone: " << key;
}

TEST(Texts, EveryShippedTableHasAllOfThem) {
  const std::vector<std::string> languages = shipped_languages();
  ASSERT_NE(std::find(languages.begin(), languages.end(), "de"), languages.end());
  for (const std::string& language : languages) {
    const WordsLookedAt seen = look_at_words(shipped(language + ".po"));
    EXPECT_EQ(seen.language, language);
    for (const WordsFault& f : seen.faults) ADD_FAILURE() << language << ".po:" << f.line << ": " << f.what;
    for (const std::string& text : seen.missing) ADD_FAILURE() << language << ".po has no \"" << text << "\"";
  }
}

TEST(Texts, MarksAreFound) {
  const auto found = [](const std::string& source) { return testing::marked_texts(source, "x.cpp"); };
  EXPECT_TRUE(found("// w(\"a comment\")\nint x = f(\"no mark\");").empty());
  const auto all = found(
      "w(\"one \"\n  \"text\"); d.w.counted(int64_t(n), \"{} act\", \"{} acts\", n); w.as(\"tool\", \"Hook\");\n"
      "button(w, \"Press\"); {english(\"a \\\"quote\\\" and \\u00b0\")}; w(x ? english(\"yes\") : english(\"no\"))");
  ASSERT_EQ(all.size(), 7u);
  EXPECT_EQ(all[0].text, "one text");
  EXPECT_EQ(all[1].text + "|" + all[1].many, "{} act|{} acts");
  EXPECT_EQ(all[2].context + "|" + all[2].text, "tool|Hook");
  EXPECT_EQ(all[3].text, "Press");
  EXPECT_EQ(all[4].text, "a \"quote\" and \u00b0");
  EXPECT_EQ(all[5].text + all[6].text, "yesno");
}

/// The reasons in a source of sim/ that stand there as one text, without figures.
std::vector<std::string> whole_reasons(const std::string& source) {
  static const std::regex reason(
      R"re((?:refused?\(|fail\(refused, |return \{false,\s*)((?:"(?:[^"\\]|\\.)*"\s*)+)[)}])re");
  static const std::regex piece(R"re("((?:[^"\\]|\\.)*)")re");
  std::vector<std::string> all;
  for (std::sregex_iterator m(source.begin(), source.end(), reason), end; m != end; ++m) {
    const std::string texts = (*m)[1];
    std::string whole;
    for (std::sregex_iterator t(texts.begin(), texts.end(), piece); t != end; ++t) whole += (*t)[1];
    if (whole.find('\\') == std::string::npos) all.push_back(whole);
  }
  return all;
}

// Why a cut, a hook, a stitch or an act on bone was refused is said in the reader's language (patient_texts.h).
TEST(Texts, NoWholeReasonOfARefusalStaysEnglish) {
  EXPECT_EQ(whole_reasons("x = refuse(\"one \"\n \"text\"); fail(refused, \"two\"); return {false, \"three\"};").size(),
            3u);
  const Words de = chosen_words({"de", ""});
  size_t found = 0;
  for (const char* part : {"cutting", "patient", "skull/bone"})
    for (const auto& f : std::filesystem::recursive_directory_iterator(source_dir() + "/sim/" + part)) {
      if (f.path().extension() != ".cpp") continue;
      for (const std::string& reason : whole_reasons(read_whole_file(f.path().string()))) {
        ++found;
        EXPECT_NE(de.said(reason), reason) << f.path() << ": not in patient_texts.h";
      }
    }
  EXPECT_GT(found, 40u);
  EXPECT_EQ(
      de.said("suture: one end goes through whole skin: no wound's edge lies within 2 mm of (-45.0, 7.5, -2.0) mm"),
      "Naht: ein Ende geht durch ganze Haut: kein Wundrand liegt innerhalb von 2\u202fmm um (-45,0, 7,5, -2,0) mm");
}

TEST(Texts, TheViewerOfThePageSaysNoOtherThanThoseThatItIsGiven) {
  std::map<std::string, bool> given;
  for (const MarkedText& t : testing::marked_texts(read_whole_file(source_dir() + "/app/report/viewer.cpp"), "viewer"))
    given[t.text] = true;
  int said = 0;
  for (const MarkedText& t :
       testing::marked_texts(read_whole_file(source_dir() + "/app/report/viewer/viewer.js"), "viewer.js")) {
    EXPECT_TRUE(given[t.text]) << t.text;
    ++said;
  }
  EXPECT_GT(said, 10);
}

}  // namespace test_texts
}  // namespace limberg
