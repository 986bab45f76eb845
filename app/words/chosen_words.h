#pragma once
// Whose language the program speaks, and its table: app/words/LANGUAGE.po among what is shipped, or one's own file.
//
// The first of these that says something:
//
//   --words FILE           a table by its path
//   --language de          a table that is shipped, or en
//   LIMBERG_LANGUAGE       the same
//   LC_ALL, LC_MESSAGES, LANG    as the machine is set ("de_DE.UTF-8"): English where there is no such table
#include <functional>
#include <string>
#include <vector>

#include "app/words/word_table.h"
#include "app/words/words.h"

namespace limberg {

struct WordsWish {
  std::string language, file;
};
/// A variable of the environment; empty: not set.
using Environment = std::function<std::string(const char* name)>;
std::string variable(const char* name);

/// The words of a call, as they are printed (Words::typeset). InputError (file, line): a table that is not sound, or a
/// language without a table.
Words chosen_words(const WordsWish& wish, const Environment& environment = variable);

/// Of a table in a file, checked against the texts of the program. InputError: the first that is wrong.
Words words_of_file(const std::string& file);

/// The shipped languages but English, in the order of their names.
std::vector<std::string> shipped_languages();
/// The list of all texts of the program, without translations. InputError: it is not there.
PoFile known_texts();

/// A table beside the texts of the program.
struct WordsLookedAt {
  std::string language;
  std::vector<WordsFault> faults;
  std::vector<std::string> missing;  // texts without a translation, guessed ones included
  size_t texts = 0;                  // of the program
};
/// InputError: it cannot be read at all.
WordsLookedAt look_at_words(const std::string& file);

}  // namespace limberg
