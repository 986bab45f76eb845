#include "app/words/chosen_words.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "app/program/shipped.h"
#include "sim/base/error.h"

namespace limberg {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "app/words";
constexpr const char* kTexts = "app/words/limberg.pot";

/// "de" of "de_DE.UTF-8"; empty: English, or none.
std::string language_of(const std::string& locale) {
  const std::string name = locale.substr(0, locale.find_first_of("_.@-"));
  const bool letters = name.size() >= 2 && name.size() <= 3 &&
                       std::all_of(name.begin(), name.end(), [](char c) { return c >= 'a' && c <= 'z'; });
  return letters && name != "en" ? name : "";
}

std::string table_of_language(const std::string& language) {
  return shipped_file(std::string(kFolder) + "/" + language + ".po");
}

[[noreturn]] void no_table(const std::string& by, const std::string& language) {
  std::string all = "en";
  for (const std::string& l : shipped_languages()) all += ", " + l;
  throw InputError(by + " " + language, 0,
                   "there is no table of words for it; expected one of " + all + ", or --words FILE");
}

Words of_language(const std::string& by, const std::string& asked) {
  const std::string language = language_of(asked);
  if (language.empty()) {
    if (asked.starts_with("en") || asked == "C" || asked == "POSIX") return Words();
    no_table(by, asked);
  }
  const std::string file = table_of_language(language);
  if (file.empty()) no_table(by, asked);
  return words_of_file(file);
}

}  // namespace

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

std::vector<std::string> shipped_languages() {
  std::set<std::string> all;
  for (const std::string& root : shipped_roots()) {
    std::error_code none;
    for (const auto& e : fs::directory_iterator(fs::path(root) / kFolder, none))
      if (e.path().extension() == ".po" && !language_of(e.path().stem().string()).empty())
        all.insert(e.path().stem().string());
  }
  return {all.begin(), all.end()};
}

PoFile known_texts() {
  const std::string file = shipped_file(kTexts);
  return read_po(file.empty() ? kTexts : file);
}

Words words_of_file(const std::string& file) {
  const PoFile po = read_po(file), known = known_texts();
  std::vector<WordsFault> faults;
  auto table = std::make_shared<WordTable>(table_of(po, &known, faults));
  if (!faults.empty()) throw InputError(file, faults.front().line, faults.front().what);
  return Words(std::move(table));
}

Words chosen_words(const WordsWish& wish, const Environment& environment) {
  if (!wish.file.empty()) return words_of_file(wish.file).typeset();
  if (!wish.language.empty()) return of_language("--language", wish.language).typeset();
  if (const std::string asked = environment("LIMBERG_LANGUAGE"); !asked.empty())
    return of_language("LIMBERG_LANGUAGE", asked).typeset();
  for (const char* name : {"LC_ALL", "LC_MESSAGES", "LANG"})
    if (const std::string locale = environment(name); !locale.empty()) {
      const std::string language = language_of(locale);
      const std::string file = language.empty() ? "" : table_of_language(language);
      return file.empty() ? Words().typeset() : words_of_file(file).typeset();
    }
  return Words().typeset();
}

WordsLookedAt look_at_words(const std::string& file) {
  const PoFile po = read_po(file), known = known_texts();
  WordsLookedAt seen;
  const WordTable table = table_of(po, &known, seen.faults);
  seen.language = table.language, seen.texts = known.entries.size();
  std::set<std::string> translated;
  for (const PoEntry& e : po.entries)
    if (e.translated()) translated.insert(key_of(e.context, e.english));
  for (const PoEntry& e : known.entries)
    if (!translated.contains(key_of(e.context, e.english))) seen.missing.push_back(e.english);
  return seen;
}

}  // namespace limberg
