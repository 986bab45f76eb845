// Words in another language: look-up, places for figures, one and several, finished texts, numbers; tables that are
// refused with file, line and reason; whose language is taken.
#include <gtest/gtest.h>

#include <fstream>

#include "app/program/places.h"
#include "app/program/temporary_folder.h"
#include "app/words/chosen_words.h"
#include "app/words/typeset.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg {
namespace test_words {

constexpr const char* kHead =
    "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n\"Language: xy\\n\"\n"
    "\"Plural-Forms: nplurals=2; plural=(n != 1);\\n\"\n";

Words words_of(const std::string& entries, std::vector<WordsFault>* faults = nullptr) {
  std::vector<WordsFault> found;
  auto table = std::make_shared<WordTable>(table_of(parse_po(kHead + entries, "xy.po"), nullptr, found));
  if (faults) *faults = found;
  return Words(std::move(table));
}
std::string entry(const std::string& english, const std::string& translated) {
  return "\nmsgid \"" + english + "\"\nmsgstr \"" + translated + "\"\n";
}
const std::string kComma = "\nmsgctxt \"decimal mark\"\nmsgid \".\"\nmsgstr \",\"\n";

TEST(Words, WithoutATableAreEnglish) {
  const Words w;
  EXPECT_EQ(w.language(), "en");
  EXPECT_STREQ(w("Try again"), "Try again");
  EXPECT_EQ(w("{:.1f} mm beside the line{}", 2.25, " at A"), "2.2 mm beside the line at A");
  EXPECT_EQ(w.counted(1, "{} act", "{} acts", 1), "1 act");
  EXPECT_EQ(w.counted(0, "{} act", "{} acts", 0), "0 acts");
  EXPECT_EQ(w.said("2 hooks set. 3.5 mm"), "2 hooks set. 3.5 mm");
  EXPECT_EQ(w.typeset()("{:.0f} mm, {:.0f} °", 4.0, 60.0), "4\u202fmm, 60°");
}

TEST(Words, OfATableStandInTheirPlacesWithItsNumbers) {
  const Words w = words_of(entry("{:.1f} mm of {}", "von {1} {0:.1f} mm") + entry("Hook", "Haken") +
                           "\nmsgctxt \"verb\"\nmsgid \"Hook\"\nmsgstr \"haken\"\n"
                           "\nmsgid \"{} act, {:.1f} s\"\nmsgid_plural \"{} acts, {:.1f} s\"\n"
                           "msgstr[0] \"eine Tat, {1:.1f} s\"\nmsgstr[1] \"{} Taten, {:.1f} s\"\n" +
                           kComma);
  EXPECT_EQ(w.language(), "xy");
  EXPECT_EQ(w("{:.1f} mm of {}", 2.25, "A"), "von A 2,2 mm");
  EXPECT_STREQ(w("Hook"), "Haken");
  EXPECT_STREQ(w.as("verb", "Hook"), "haken");
  EXPECT_STREQ(w("Saw"), "Saw") << "what the table lacks is English";
  EXPECT_EQ(w("{:.2f} N is not there", 1.5), "1,50 N is not there") << "with the numbers of the language";
  EXPECT_EQ(w.counted(1, "{} act, {:.1f} s", "{} acts, {:.1f} s", 1, 0.5), "eine Tat, 0,5 s");
  EXPECT_EQ(w.counted(12, "{} act, {:.1f} s", "{} acts, {:.1f} s", 12, 0.5), "12 Taten, 0,5 s");
}

TEST(Words, SayFinishedTexts) {
  const Words w = words_of(
      entry("Excision of {} mm², {} mm deep", "Exzision von {} mm², {} mm tief") + entry("{} deep", "{} TIEF") +
      entry("not done: {}.", "nicht getan: {}.") + entry("stitch {} is there", "Naht {} ist da") +
      entry("gapes by {:.2g} mm", "klafft {:.2g} mm") + entry("sutures", "Nähte") +
      "\nmsgid \"One hook set\"\nmsgid_plural \"{} hooks set\"\nmsgstr[0] \"Ein Haken\"\nmsgstr[1] \"{} Haken\"\n" +
      kComma);
  EXPECT_EQ(w.said("sutures"), "Nähte");
  EXPECT_EQ(w.said("Excision of 200 mm², 4.5 mm deep. 2 hooks set."), "Exzision von 200 mm², 4,5 mm tief. 2 Haken.");
  EXPECT_EQ(w.said("One hook set."), "Ein Haken.");
  EXPECT_EQ(w.said("not done: stitch 3 is there."), "nicht getan: Naht 3 ist da.") << "a text within a text";
  EXPECT_EQ(w.said("gapes by wide mm"), "gapes by wide mm") << "a place for a number takes no word";
  EXPECT_EQ(w.said("version 1.2.3 at 5.5 N"), "version 1.2.3 at 5,5 N");
  EXPECT_EQ(w.said("12 deep"), "12 TIEF");
  EXPECT_EQ(w.said("knee deep"), "knee deep") << "a form with hardly a letter of its own takes figures alone";
  EXPECT_EQ(w.said(""), "");
}

TEST(Words, PluralRulesOfOtherLanguages) {
  std::string wrong;
  const PluralRule polish("nplurals=3; plural=(n==1 ? 0 : n%10>=2 && n%10<=4 && (n%100<10 || n%100>=20) ? 1 : 2);",
                          wrong);
  EXPECT_EQ(wrong, "");
  const int of[] = {2, 0, 1, 1, 1, 2};
  for (int n = 0; n < 6; ++n) EXPECT_EQ(polish.form(n), of[n]) << n;
  EXPECT_EQ(polish.form(12), 2);
  EXPECT_EQ(polish.form(22), 1);
  const PluralRule japanese("nplurals=1; plural=0;", wrong);
  EXPECT_EQ(japanese.forms(), 1);
  EXPECT_EQ(japanese.form(7), 0);
  for (const char* bad :
       {"", "nplurals=2;", "nplurals=9; plural=0;", "nplurals=2; plural=n;", "nplurals=2; plural=n/0;",
        "nplurals=2; plural=(n", "nplurals=2; plural=m;", "nplurals=0; plural=0;"}) {
    const PluralRule none(bad, wrong);
    EXPECT_NE(wrong, "") << bad;
    EXPECT_EQ(none.form(1), 0);
  }
  const PluralRule deep("nplurals=2; plural=" + std::string(5000, '(') + "n" + std::string(5000, ')') + ";", wrong);
  EXPECT_NE(wrong, "");
}

TEST(Words, ATableThatIsNoneIsRefusedWithItsLine) {
  const auto refused = [](const std::string& text) -> std::string {
    try {
      parse_po(text, "xy.po");
    } catch (const InputError& e) {
      return e.what();
    }
    return "taken";
  };
  EXPECT_EQ(refused("msgid \"a\"\nmsgstr \"b\"\n"), "taken");
  EXPECT_EQ(refused("\n\nmsgid \"a\"\nmsgstr \"\xff\"\n"), "xy.po:4: is not UTF-8; expected a table of words in UTF-8");
  EXPECT_NE(refused("msgid \"a\"\nmsgstr \"b\n").find("xy.po:2: a text that does not end"), std::string::npos);
  EXPECT_NE(refused("msgid \"a\"\n\nmsgid \"b\"\nmsgstr \"\"\n").find("an entry without msgstr"), std::string::npos);
  EXPECT_NE(refused("msgid \"a\"\nmsgtxt \"b\"\n").find("xy.po:2: \"msgtxt\" is no keyword"), std::string::npos);
  EXPECT_NE(refused("msgstr \"b\"\n").find("xy.po:1: msgstr stands in the wrong place"), std::string::npos);
  EXPECT_NE(refused("\"b\"\n").find("xy.po:1: a text without a keyword"), std::string::npos);
  EXPECT_NE(refused("msgid \"a\"\nmsgstr \"\\q\"\n").find("xy.po:2: \\q is no sign"), std::string::npos);
  EXPECT_NE(refused("msgid \"a\"\nmsgstr[0] \"b\"\n").find("xy.po:2: msgstr[0] stands in the wrong place"),
            std::string::npos);
  EXPECT_NE(
      refused("msgid \"\"\nmsgstr \"Content-Type: text/plain; charset=ISO-8859-1\\n\"\n").find("expected charset"),
      std::string::npos);
  EXPECT_EQ(refused("#~ msgid \"gone\"\n#~ msgstr \"weg\"\n"), "taken");
}

TEST(Words, AnEntryThatDoesNotFitIsNamedWithItsLine) {
  const auto fault = [](const std::string& entries) {
    std::vector<WordsFault> faults;
    words_of(entries, &faults);
    return faults.empty() ? std::string() : std::to_string(faults[0].line) + ": " + faults[0].what;
  };
  // The head has five lines, and an entry begins with an empty one.
  EXPECT_EQ(fault(entry("a {} b", "{} ab")), "");
  EXPECT_EQ(fault(entry("a {} b", "ab")),
            "8: \"a {} b\": the translation lacks {0}; expected the places of the English");
  EXPECT_EQ(fault(entry("a {:.1f}", "{:.2f}")),
            "8: \"a {:.1f}\": the translation has {0:.2f} where the English has {0:.1f}; expected the places of the "
            "English");
  EXPECT_EQ(fault(entry("a", "{}")),
            "8: \"a\": the translation has {0}, which the English has not; expected the places of the English");
  EXPECT_NE(fault(entry("{} a {}", "{1} a {")).find("a { without its }"), std::string::npos);
  EXPECT_NE(fault(entry("{} a {}", "{1} a {}")).find("places with numbers and without"), std::string::npos);
  EXPECT_NE(fault(entry("{:.1f} {}", "{} {:.1f}")), "") << "other places without their numbers";
  EXPECT_NE(fault(entry("a", "b") + entry("a", "c")).find("stands on line 7 already"), std::string::npos);
  EXPECT_NE(fault("\nmsgid \"{} a\"\nmsgid_plural \"{} as\"\nmsgstr[0] \"{}\"\n").find("has 1 forms; expected 2"),
            std::string::npos);
  EXPECT_EQ(fault(entry("a {}", "")), "") << "not translated yet";
  EXPECT_EQ(fault("\n#, fuzzy\nmsgid \"a {}\"\nmsgstr \"b\"\n"), "") << "a guess is not looked at";
}

TEST(Words, ATextThatTheProgramDoesNotHaveIsRefused) {
  const TemporaryFolder folder;
  const std::string file = folder.path().string() + "/xy.po";
  write_whole_file(file, kHead + entry("Scalpel", "S") + entry("Scalpell", "S"));
  try {
    words_of_file(file);
    FAIL() << "it was taken";
  } catch (const InputError& e) {
    EXPECT_EQ(std::string(e.what()), file +
                                         ":10: \"Scalpell\" is no text of this program; expected one of limberg words "
                                         "--template");
  }
  const WordsLookedAt seen = look_at_words(file);
  EXPECT_EQ(seen.faults.size(), 1u);
  EXPECT_EQ(seen.missing.size() + 1, seen.texts);
}

TEST(Words, TheFirstThatSaysSomethingChoosesTheLanguage) {
  std::map<std::string, std::string> set;
  const Environment environment = [&](const char* name) { return set[name]; };
  const auto chosen = [&](const WordsWish& wish) { return chosen_words(wish, environment).language(); };
  EXPECT_EQ(chosen({}), "en");
  set["LANG"] = "de_DE.UTF-8";
  EXPECT_EQ(chosen({}), "de");
  set["LC_MESSAGES"] = "en_GB.UTF-8";
  EXPECT_EQ(chosen({}), "en");
  set["LC_ALL"] = "de_AT@euro";
  EXPECT_EQ(chosen({}), "de");
  set["LC_ALL"] = "xx_YY";
  EXPECT_EQ(chosen({}), "en") << "a machine may be set to a language without a table";
  set["LIMBERG_LANGUAGE"] = "de";
  EXPECT_EQ(chosen({}), "de");
  EXPECT_EQ(chosen({"en", ""}), "en");
  const std::string de = source_dir() + "/app/words/de.po";
  EXPECT_EQ(chosen({"en", de}), "de");
  for (const char* none : {"xx", "../de", "d", "DE"}) EXPECT_THROW(chosen({none, ""}), InputError) << none;
  EXPECT_THROW(chosen({"", "nowhere.po"}), InputError);
  set["LIMBERG_LANGUAGE"] = "klingon";
  EXPECT_THROW(chosen({}), InputError);
}

TEST(Typeset, SpacesBeforeUnitsAreThinAndDegreesHaveNone) {
  EXPECT_EQ(thin_spaces("4 mm deep, 2.5 N and 12 mm²; 60 ° or 3 cm³"),
            "4\u202fmm deep, 2.5\u202fN and 12\u202fmm²; 60° or 3\u202fcm³");
  EXPECT_EQ(thin_spaces("5 stitches, 2 minutes, 3 Nerven, 7 s."), "5 stitches, 2 minutes, 3 Nerven, 7\u202fs.");
  EXPECT_EQ(thin_spaces("a mm, at 95 % of 1 kPa"), "a mm, at 95\u202f% of 1\u202fkPa");
}

TEST(Typeset, NumbersHaveTheMarkAndNamesDoNot) {
  EXPECT_EQ(with_decimals("3.4 mm; 0.1.2; p99.9; 10.1007/s1; 1.5.", ','), "3,4 mm; 0.1.2; p99.9; 10.1007/s1; 1,5.");
  EXPECT_EQ(with_decimals("3.4", '.'), "3.4");
  EXPECT_EQ(typeset_page("<p title=\"1.5\">1.5 mm</p><code>1.5 mm</code><pre>2.5</pre><th>2.5 N</th>", ','),
            "<p title=\"1.5\">1,5\u202fmm</p><code>1.5 mm</code><pre>2.5</pre><th>2,5\u202fN</th>");
}

}  // namespace test_words
}  // namespace limberg
