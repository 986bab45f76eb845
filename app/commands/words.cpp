#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "app/commands/commands.h"
#include "app/program/shipped.h"
#include "app/words/chosen_words.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg {

namespace {

constexpr const char* kTemplate = "app/words/limberg.pot";

int check(const std::string& file) {
  const WordsLookedAt seen = look_at_words(file);
  for (const WordsFault& f : seen.faults)
    std::fprintf(stderr, "limberg: %s:%d: %s\n", file.c_str(), f.line, f.what.c_str());
  for (const std::string& text : seen.missing) std::printf("missing     %s\n", text.c_str());
  std::printf(
      "language    %s\ntexts       %zu\ntranslated  %zu\nmissing     %zu, which stay English\nwrong       %zu\n",
      seen.language.c_str(), seen.texts, seen.texts - seen.missing.size(), seen.missing.size(), seen.faults.size());
  return seen.faults.empty() ? kDone : kBadInput;
}

int list() {
  std::printf("en          the language of the program, %zu texts\n", known_texts().entries.size());
  for (const std::string& language : shipped_languages()) {
    const std::string file = shipped_file("app/words/" + language + ".po");
    const WordsLookedAt seen = look_at_words(file);
    std::printf("%-11s %zu of them, %s\n", language.c_str(), seen.texts - seen.missing.size(), file.c_str());
  }
  return kDone;
}

}  // namespace

void add_words(CLI::App& app, Chosen& chosen) {
  struct Options {
    std::string file;
    bool pot = false;
  };
  auto o = std::make_shared<Options>();
  CLI::App* c = app.add_subcommand("words", "Languages of window and pages, and what a table of words lacks");
  CLI::Option* file =
      c->add_option("--check", o->file, "A table: what is wrong in it, what is missing")->type_name("FILE");
  c->add_flag("--template", o->pot, "Print the list of all texts, to begin a language with")->excludes(file);
  c->footer(
      "Example: limberg words --template > fr.po\n"
      "         limberg words --check fr.po\n"
      "         limberg run --words fr.po");
  c->callback([o, &chosen] {
    chosen = [o] {
      if (!o->file.empty()) return check(o->file);
      if (!o->pot) return list();
      const std::string pot = shipped_file(kTemplate);
      const std::string text = read_whole_file(pot.empty() ? kTemplate : pot, size_t(8) << 20, "the list of texts");
      return std::fwrite(text.data(), 1, text.size(), stdout) == text.size() ? int(kDone) : int(kBadInput);
    };
  });
}

}  // namespace limberg
