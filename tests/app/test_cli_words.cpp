// Languages as a user chooses them: a page again in German, tables that are looked at, and those that are refused.
#include "tests/app/cli.h"

namespace test_cli_words {

class CliWords : public Cli {
 protected:
  /// A folder with a result.
  std::string result() const {
    fs::create_directories(path("run"));
    file("run/result.json", R"({"command": "operate", "scene": "small", "metrics": {"closure_force_N": 7.25}})");
    return path("run");
  }
};

TEST_F(CliWords, AReportIsMadeAgainInGermanAndTheResultStaysAsItIs) {
  const std::string dir = result(), before = slurp(dir + "/result.json");
  ASSERT_EQ(run("report " + dir + " --language de").status, 0);
  const std::string german = slurp(dir + "/report.html");
  EXPECT_NE(german.find("lang=\"de\""), std::string::npos);
  EXPECT_NE(german.find("Verschlusskraft"), std::string::npos);
  EXPECT_NE(german.find("7,25\u202fN"), std::string::npos);
  EXPECT_EQ(slurp(dir + "/result.json"), before);
  ASSERT_EQ(run("report " + dir + " --language en").status, 0);
  EXPECT_NE(slurp(dir + "/report.html").find("closure force"), std::string::npos);
  ASSERT_EQ(run("report " + dir + " --words " + kSource + "/app/words/de.po").status, 0);
  EXPECT_EQ(slurp(dir + "/report.html"), german);
}

TEST_F(CliWords, AWrongTableIsRefusedWithFileAndLine) {
  const std::string dir = result();
  const std::string head = "msgid \"\"\nmsgstr \"Language: xy\\n\"\n\n";
  for (const auto& [text, said] :
       {std::pair<std::string, std::string>{head + "msgid \"Scalpel\"\nmsgstr \"S\n", ":5: a text that does not end"},
        {head + "msgid \"try {}\"\nmsgstr \"essai\"\n", ":5: \"try {}\": the translation lacks {0}; expected"},
        {head + "msgid \"No such text\"\nmsgstr \"x\"\n", ":4: \"No such text\" is no text of this program; expected"},
        {head + "msgid \"Scalpel\"\nmsgstr \"\xe4\"\n", ":5: is not UTF-8; expected"},
        {"msgid \"Scalpel\"\nmsgstr \"S\"\n", ":1: names no language; expected"}}) {
    const std::string table = file("xy.po", text);
    for (const std::string& call : {"report " + dir + " --words " + table, "words --check " + table}) {
      const Outcome o = run(call);
      EXPECT_EQ(o.status, 2) << call;
      EXPECT_NE(o.err.find("limberg: " + table + said), std::string::npos) << o.err;
    }
  }
  const Outcome none = run("report " + dir + " --language klingon");
  EXPECT_EQ(none.status, 2);
  EXPECT_NE(none.err.find("expected one of en, de, or --words FILE"), std::string::npos) << none.err;
}

TEST_F(CliWords, ATableIsLookedAtAndBegun) {
  const Outcome all = run("words");
  EXPECT_EQ(all.status, 0);
  EXPECT_NE(all.out.find("\nde "), std::string::npos) << all.out;
  const Outcome begun = run("words --template");
  EXPECT_EQ(begun.status, 0);
  std::string table = begun.out;
  const std::string untranslated = "msgid \"Scalpel\"\nmsgstr \"\"";
  const size_t at = table.find(untranslated);
  ASSERT_NE(at, std::string::npos);
  table.replace(at, untranslated.size(), "msgid \"Scalpel\"\nmsgstr \"Bistouri\"");
  table.replace(table.find("Language: en"), 12, "Language: fr");
  const Outcome looked = run("words --check " + file("fr.po", table));
  EXPECT_EQ(looked.status, 0) << looked.err;
  EXPECT_NE(looked.out.find("language    fr\n"), std::string::npos) << looked.out;
  EXPECT_NE(looked.out.find("translated  1\n"), std::string::npos);
  EXPECT_NE(looked.out.find("missing     Hook out\n"), std::string::npos);
}

}  // namespace test_cli_words
