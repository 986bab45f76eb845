#pragma once
// Reads tables of words as GNU gettext has them, so that its tools and editors (msgfmt, msgmerge, Poedit) serve them:
//
//   # for people
//   #, fuzzy                     guessed by msgmerge: counts as missing until a person has looked at it
//   msgctxt "tool"               may be left out
//   msgid "{} stitch"
//   msgid_plural "{} stitches"   may be left out, and then it is msgstr alone
//   msgstr[0] "{} Stich"
//   msgstr[1] "{} Stiche"
//
// The entry of the empty text is the head: "Language: de\n", "Plural-Forms: ...\n". It is UTF-8.
//
// Not gettext's own reader: libintl wants a compiled table, a locale that the machine has installed, and is global to
// the program; libgettextpo ends the program where a file is broken.
#include <string>
#include <string_view>
#include <vector>

namespace limberg {

struct PoEntry {
  std::string context, english, many;  // many: empty where there is one form
  std::vector<std::string> forms;      // empty texts: not translated
  int line = 0;                        // of msgid
  std::vector<int> form_line;
  bool fuzzy = false;

  bool translated() const {
    for (const std::string& f : forms)
      if (f.empty()) return false;
    return !forms.empty() && !fuzzy;
  }
};

struct PoFile {
  std::string file;
  std::string language = {}, plural_forms = {};  // of the head; may be empty
  int head_line = 0;
  std::vector<PoEntry> entries = {};  // without the head
};

/// InputError (file, line): not UTF-8, or no such table.
PoFile parse_po(std::string_view text, const std::string& file);
/// The same, or no such file.
PoFile read_po(const std::string& file);

}  // namespace limberg
