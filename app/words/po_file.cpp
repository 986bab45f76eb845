#include "app/words/po_file.h"

#include <algorithm>
#include <optional>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg {
namespace {

/// The number of bytes of the character there; 0: it is none of UTF-8.
size_t utf8_length(std::string_view s, size_t at) {
  const auto byte = [&](size_t i) { return i < s.size() ? static_cast<unsigned char>(s[i]) : 0u; };
  const unsigned first = byte(at);
  if (first < 0x80) return first == 0 ? 0 : 1;
  const size_t n = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4) return 0;
  for (size_t k = 1; k < n; ++k)
    if ((byte(at + k) & 0xC0) != 0x80) return 0;
  const unsigned second = byte(at + 1);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90),
             beyond = (first == 0xED && second > 0x9F) || (first == 0xF4 && second > 0x8F);
  return overlong || beyond ? 0 : n;
}

class PoReader {
 public:
  PoReader(std::string_view text, const std::string& file) : text_(text) { po_.file = file; }

  PoFile read() {
    check_utf8();
    if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
    for (size_t at = 0; at < text_.size();) {
      const size_t end = std::min(text_.find('\n', at), text_.size());
      std::string_view line = text_.substr(at, end - at);
      at = end + 1, ++line_;
      const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
      while (!line.empty() && blank(line.front())) line.remove_prefix(1);
      while (!line.empty() && blank(line.back())) line.remove_suffix(1);
      take(line);
    }
    ++line_;
    end_entry();
    return std::move(po_);
  }

 private:
  static constexpr size_t kMostEntries = 20'000, kLongest = 4'000;

  [[noreturn]] void fail(const std::string& what) const { throw InputError(po_.file, line_, what); }

  void check_utf8() const {
    int line = 1;
    for (size_t i = 0; i < text_.size();) {
      const size_t n = utf8_length(text_, i);
      if (n == 0) throw InputError(po_.file, line, "is not UTF-8; expected a table of words in UTF-8");
      line += text_[i] == '\n', i += n;
    }
  }

  void take(std::string_view line) {
    if (line.empty()) return;
    if (line[0] == '#') {
      // What msgmerge keeps of old, and what a text was before, is not read.
      if (into_) end_entry();
      if (line.starts_with("#,") && line.find("fuzzy") != line.npos) fuzzy_ = true;
      return;
    }
    if (line[0] == '"') {
      if (!into_) fail("a text without a keyword; expected msgid, msgstr or a line that begins with #");
      *into_ += text_in(line);
      if (into_->size() > kLongest) fail("a text of more than 4000 bytes; expected less");
      return;
    }
    const size_t end = line.find_first_of(" \t\"");
    const std::string_view word = line.substr(0, end);
    std::string_view rest = end == line.npos ? std::string_view() : line.substr(end);
    while (!rest.empty() && (rest[0] == ' ' || rest[0] == '\t')) rest.remove_prefix(1);
    begin(word);
    if (rest.empty()) fail(std::string(word) + " without a text; expected " + std::string(word) + " \"...\"");
    *into_ += text_in(rest);
  }

  /// Where the text of this keyword goes.
  void begin(std::string_view word) {
    const auto must = [&](bool fits, const char* expected) {
      if (!fits) fail(std::string(word) + " stands in the wrong place; expected " + expected);
    };
    if (word == "msgctxt") {
      if (has_id_) end_entry();
      must(!has_context_, "msgid after msgctxt");
      has_context_ = true, into_ = &entry_.context;
    } else if (word == "msgid") {
      if (has_id_) end_entry();
      has_id_ = true, entry_.line = line_, into_ = &entry_.english;
    } else if (word == "msgid_plural") {
      must(has_id_ && entry_.forms.empty() && !plural_, "it once, after msgid");
      plural_ = true, into_ = &entry_.many;
    } else if (word == "msgstr") {
      must(has_id_ && !plural_ && entry_.forms.empty(),
           plural_ ? "msgstr[0] after msgid_plural" : "it once, after msgid");
      add_form();
    } else if (word.starts_with("msgstr[") && word.ends_with("]")) {
      const std::string_view number = word.substr(7, word.size() - 8);
      must(plural_, "msgid_plural before it");
      must(number.size() == 1 && number[0] == char('0' + int(entry_.forms.size())),
           "msgstr[0], msgstr[1] in their order");
      add_form();
    } else {
      fail("\"" + std::string(word.substr(0, 40)) +
           "\" is no keyword; expected msgid, msgstr or a line that begins with #");
    }
  }
  void add_form() {
    entry_.forms.emplace_back(), entry_.form_line.push_back(line_);
    into_ = &entry_.forms.back();
  }

  std::string text_in(std::string_view quoted) const {
    if (quoted.size() < 2 || quoted.front() != '"' || quoted.back() != '"')
      fail("a text that does not end; expected \"...\"");
    std::string out;
    const std::string_view inside = quoted.substr(1, quoted.size() - 2);
    for (size_t i = 0; i < inside.size(); ++i) {
      if (inside[i] == '"') fail("a \" within a text; expected \\\"");
      if (inside[i] != '\\') {
        out += inside[i];
        continue;
      }
      const char c = i + 1 < inside.size() ? inside[++i] : ' ';
      if (c == 'n')
        out += '\n';
      else if (c == 't')
        out += '\t';
      else if (c == '"' || c == '\\')
        out += c;
      else
        fail(std::string("\\") + c + " is no sign; expected \\n, \\t, \\\" or \\\\");
    }
    return out;
  }

  void end_entry() {
    into_ = nullptr;
    if (!has_id_ && !has_context_) return;
    if (!has_id_ || entry_.forms.empty())
      fail(has_id_ ? "an entry without msgstr; expected msgstr \"...\" (an empty one: not translated)"
                   : "msgctxt without msgid; expected msgid \"...\"");
    entry_.fuzzy = fuzzy_;
    if (entry_.english.empty() && entry_.context.empty())
      head();
    else if (entry_.english.empty())
      fail("an empty msgid; expected the English text");
    else
      po_.entries.push_back(std::move(entry_));
    if (po_.entries.size() > kMostEntries) fail("more than 20000 entries; expected fewer");
    entry_ = {}, has_context_ = has_id_ = plural_ = fuzzy_ = false;
  }

  void head() {
    if (po_.head_line > 0) fail("a second head (msgid \"\"); expected one, at the beginning");
    po_.head_line = entry_.line;
    const std::string& text = entry_.forms[0];
    for (size_t at = 0; at < text.size();) {
      const size_t end = std::min(text.find('\n', at), text.size());
      const std::string line = text.substr(at, end - at);
      const size_t colon = line.find(':');
      std::string value = colon == line.npos ? "" : line.substr(colon + 1);
      value.erase(0, std::min(value.find_first_not_of(' '), value.size()));
      const std::string name = line.substr(0, colon);
      if (name == "Language") po_.language = value;
      if (name == "Plural-Forms") po_.plural_forms = value;
      if (name == "Content-Type" && value.find("charset=") != value.npos && value.find("charset=UTF-8") == value.npos &&
          value.find("charset=utf-8") == value.npos)
        throw InputError(po_.file, po_.head_line, value + "; expected charset=UTF-8");
      at = end + 1;
    }
  }

  std::string_view text_;
  PoFile po_;
  PoEntry entry_;
  std::string* into_ = nullptr;
  bool has_context_ = false, has_id_ = false, plural_ = false, fuzzy_ = false;
  int line_ = 0;
};

}  // namespace

PoFile parse_po(std::string_view text, const std::string& file) { return PoReader(text, file).read(); }

PoFile read_po(const std::string& file) {
  return parse_po(read_whole_file(file, size_t(8) << 20, "a table of words"), file);
}

}  // namespace limberg
