#pragma once
// What a table of words holds once it was read and found sound: for words.cpp, and for who looks at tables.
#include <functional>
#include <locale>
#include <map>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "app/words/placeholders.h"
#include "app/words/plural_rule.h"
#include "app/words/po_file.h"

namespace limberg {

/// A text without its own figures: pieces that stand, and places between them.
struct WordPattern {
  Placeholders english;
  std::string key;
  size_t letters = 0;
};

struct WordTable {
  struct Entry {
    std::string many;                // the English for several; empty: there is one form
    std::vector<std::string> forms;  // as formats, decimals by the locale
    int line = 0;
  };
  struct Hash {
    using is_transparent = void;
    size_t operator()(std::string_view s) const { return std::hash<std::string_view>()(s); }
  };

  std::string file, language = "en";
  char decimal = '.';
  std::locale locale = std::locale::classic();
  PluralRule plural;
  std::unordered_map<std::string, Entry, Hash, std::equal_to<>> entries;  // by key_of()
  std::vector<WordPattern> patterns;                                      // most letters first

  const Entry* find(std::string_view key) const {
    const auto at = entries.find(key);
    return at == entries.end() ? nullptr : &at->second;
  }
};

/// Of an entry in a table: gettext's, the context and a byte that no text has before the English.
inline std::string key_of(std::string_view context, std::string_view english) {
  return context.empty() ? std::string(english) : std::string(context) + '\4' + std::string(english);
}

/// Something wrong in a table.
struct WordsFault {
  int line = 0;
  std::string what;  // with what was expected
};

/// The sound entries of a table, and what is wrong with the others. `known`: the texts of the program; null: any.
WordTable table_of(const PoFile& po, const PoFile* known, std::vector<WordsFault>& faults);

}  // namespace limberg
