#include "app/words/words.h"

#include <algorithm>
#include <optional>

#include "app/words/typeset.h"
#include "app/words/word_table.h"

namespace limberg {
namespace {

/// What a number is written with.
class DecimalMark : public std::numpunct<char> {
 public:
  explicit DecimalMark(char mark) : mark_(mark) {}

 protected:
  char do_decimal_point() const override { return mark_; }

 private:
  char mark_;
};

bool is_number(std::string_view s) {
  size_t i = !s.empty() && (s[0] == '-' || s[0] == '+') ? 1 : 0;
  if (s.substr(i).starts_with("\u2212")) i += 3;
  size_t digits = 0, points = 0;
  for (; i < s.size() && (digits += s[i] >= '0' && s[i] <= '9', s[i] == '.' || (s[i] >= '0' && s[i] <= '9')); ++i)
    points += s[i] == '.';
  if (i < s.size() && s[i] == 'e' && digits > 0) {  // 3.2e-05
    ++i;
    if (i < s.size() && (s[i] == '-' || s[i] == '+')) ++i;
    while (i < s.size() && s[i] >= '0' && s[i] <= '9') ++i;
  }
  return i == s.size() && digits > 0 && points <= 1;
}

bool wants_number(const Placeholder& p) {
  return !p.spec.empty() && std::string_view("fgedFGE").find(p.spec.back()) != std::string_view::npos;
}

/// What stands in the places of a pattern, from its piece `k` on; false: the text does not fit.
bool fits(const Placeholders& p, size_t k, std::string_view text, std::vector<std::string_view>& found) {
  const std::string& piece = p.piece[k];
  if (!text.starts_with(piece)) return false;
  text.remove_prefix(piece.size());
  if (k == p.place.size()) return text.empty();
  const std::string& next = p.piece[k + 1];
  const bool last = k + 1 == p.place.size();
  for (size_t n = last && next.empty() ? text.size() : 0; n <= text.size(); ++n) {
    if (n > 0 && !next.empty()) {
      n = text.find(next, n);
      if (n == text.npos) return false;
    }
    const std::string_view here = text.substr(0, n);
    const bool sound = wants_number(p.place[k]) ? is_number(here) : true;
    found.push_back(here);
    if (sound && fits(p, k + 1, text.substr(n), found)) return true;
    found.pop_back();
  }
  return false;
}

std::string in_places(const Placeholders& translated, const std::vector<std::string>& value) {
  std::string out = translated.piece[0];
  for (size_t i = 0; i < translated.place.size(); ++i) {
    const auto index = size_t(translated.place[i].index);
    out += (index < value.size() ? value[index] : std::string()) + translated.piece[i + 1];
  }
  return out;
}

constexpr int kDeepest = 3;  // texts within texts

std::string told(const WordTable& table, std::string_view text, int deep);

std::optional<std::string> by_pattern(const WordTable& table, std::string_view text, int deep) {
  if (deep > kDeepest) return std::nullopt;
  for (const WordPattern& p : table.patterns) {
    std::vector<std::string_view> found;
    if (!fits(p.english, 0, text, found)) continue;
    // A form with hardly a word of its own ("{} of {}") is one of figures alone.
    constexpr size_t kFewLetters = 6;
    const auto figures = [](std::string_view s) { return s.find_first_not_of("0123456789., +-") == s.npos; };
    if (p.letters < kFewLetters && !std::all_of(found.begin(), found.end(), figures)) continue;
    const WordTable::Entry& e = *table.find(p.key);
    std::vector<std::string> value(found.size());
    int64_t n = 2;
    for (size_t i = 0; i < found.size(); ++i) {
      const auto index = size_t(p.english.place[i].index);
      if (index >= value.size()) return std::nullopt;
      value[index] = is_number(found[i]) ? with_decimals(found[i], table.decimal) : told(table, found[i], deep + 1);
      if (index == 0 && is_number(found[i]) && found[i].size() < 9) n = std::atoll(std::string(found[i]).c_str());
    }
    const size_t form = e.many.empty() ? 0 : size_t(table.plural.form(n));
    return in_places(placeholders_of(e.forms[std::min(form, e.forms.size() - 1)]), value);
  }
  return std::nullopt;
}

std::optional<std::string> whole(const WordTable& table, std::string_view text, int deep) {
  if (const WordTable::Entry* e = table.find(text)) {
    const Placeholders p = placeholders_of(e->forms[0]);
    if (p.place.empty()) return in_places(p, {});
  }
  return by_pattern(table, text, deep);
}

/// Sentence by sentence: "A. B." is what A and B are, each with its point or without. So is "A: B", an act and what is
/// said of it.
std::string told(const WordTable& table, std::string_view text, int deep) {
  if (text.empty()) return "";
  if (const auto all = whole(table, text, deep)) return *all;
  if (const size_t end = text.find(": "); end != text.npos && deep <= kDeepest)
    if (const auto act = whole(table, text.substr(0, end), deep))
      return *act + ": " + told(table, text.substr(end + 2), deep);
  if (const size_t end = text.find(". "); end != text.npos && deep <= kDeepest) {
    const std::string_view first = text.substr(0, end + 1);
    return told(table, first, deep) + " " + told(table, text.substr(end + 2), deep);
  }
  if (text.size() > 1 && text.back() == '.')
    if (const auto all = whole(table, text.substr(0, text.size() - 1), deep)) return *all + ".";
  return with_decimals(text, table.decimal);
}

const WordTable& plain_english() {
  static const WordTable table;
  return table;
}

}  // namespace

const std::string& Words::language() const { return (table_ ? *table_ : plain_english()).language; }
char Words::decimal() const { return table_ ? table_->decimal : '.'; }

const char* Words::as(const char* context, const char* text) const {
  if (!table_ || !*text) return text;
  const WordTable::Entry* e = *context ? table_->find(key_of(context, text)) : table_->find(std::string_view(text));
  return e ? e->forms[0].c_str() : text;
}

std::string Words::operator()(const std::string& text) const {
  const WordTable::Entry* e = table_ && !text.empty() ? table_->find(text) : nullptr;
  const std::string& s = e ? e->forms[0] : text;
  return typeset_ ? thin_spaces(s) : s;
}

std::string Words::filled(fmt::string_view text, fmt::format_args args) const {
  if (!table_) return typeset_ ? thin_spaces(fmt::vformat(text, args)) : fmt::vformat(text, args);
  const WordTable::Entry* e = table_->find(std::string_view(text.data(), text.size()));
  const std::string s = fmt::vformat(table_->locale, e ? e->forms[0] : by_locale({text.data(), text.size()}), args);
  return typeset_ ? thin_spaces(s) : s;
}

std::string Words::filled(int64_t n, fmt::string_view one, fmt::string_view many, fmt::format_args args) const {
  const WordTable::Entry* e = table_ ? table_->find(std::string_view(one.data(), one.size())) : nullptr;
  if (!e || e->many.empty()) {
    const fmt::string_view text = n == 1 ? one : many;
    const std::string s =
        table_ ? fmt::vformat(table_->locale, by_locale({text.data(), text.size()}), args) : fmt::vformat(text, args);
    return typeset_ ? thin_spaces(s) : s;
  }
  const std::string s = fmt::vformat(table_->locale, e->forms[size_t(table_->plural.form(n))], args);
  return typeset_ ? thin_spaces(s) : s;
}

std::string Words::said(std::string_view text) const {
  std::string s = table_ ? told(*table_, text, 0) : std::string(text);
  return typeset_ ? thin_spaces(s) : s;
}

WordTable table_of(const PoFile& po, const PoFile* known, std::vector<WordsFault>& faults) {
  WordTable t;
  t.file = po.file;
  const auto fault = [&](int line, const std::string& what) { faults.push_back({line, what}); };
  const int head = std::max(1, po.head_line);
  t.language = po.language;
  const auto is_name = [](const std::string& s) {
    return s.size() >= 2 && s.size() <= 16 && std::all_of(s.begin(), s.end(), [](char c) {
             return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-' || c == '@';
           });
  };
  if (!is_name(t.language)) {
    fault(head, "names no language; expected a head with \"Language: de\\n\"");
    t.language = "en";
  }
  if (!po.plural_forms.empty()) {
    std::string wrong;
    t.plural = PluralRule(po.plural_forms, wrong);
    if (!wrong.empty()) fault(head, wrong);
  }
  std::map<std::string, const PoEntry*> of_program;
  if (known)
    for (const PoEntry& e : known->entries) of_program[key_of(e.context, e.english)] = &e;
  std::map<std::string, int> seen;
  for (const PoEntry& e : po.entries) {
    const std::string key = key_of(e.context, e.english);
    const std::string name = "\"" + (e.english.size() > 60 ? e.english.substr(0, 57) + "..." : e.english) + "\"";
    if (const auto [at, first] = seen.try_emplace(key, e.line); !first) {
      fault(e.line, name + " stands on line " + std::to_string(at->second) + " already; expected each text once");
      continue;
    }
    if (known) {
      const auto at = of_program.find(key);
      if (at == of_program.end()) {
        fault(e.line, name + " is no text of this program; expected one of limberg words --template");
        continue;
      }
      if (at->second->many != e.many) {
        fault(e.line, name + (e.many.empty() ? " has no msgid_plural" : " has another msgid_plural") + "; expected " +
                          (at->second->many.empty() ? "none" : "\"" + at->second->many + "\""));
        continue;
      }
    }
    if (!e.translated()) continue;
    if (e.context == "decimal mark") {
      if (e.forms[0].size() != 1 || std::string_view(".,").find(e.forms[0]) == std::string_view::npos)
        fault(e.form_line[0], "the decimal mark is \"" + e.forms[0] + "\"; expected . or ,");
      else
        t.decimal = e.forms[0][0];
      continue;
    }
    if (!e.many.empty() && int(e.forms.size()) != t.plural.forms()) {
      fault(e.line, name + " has " + std::to_string(e.forms.size()) + " forms; expected " +
                        std::to_string(t.plural.forms()) + ", as Plural-Forms says");
      continue;
    }
    const Placeholders one = placeholders_of(e.english), many = placeholders_of(e.many.empty() ? e.english : e.many);
    bool sound = one.wrong.empty() && many.wrong.empty();
    if (!sound) fault(e.line, name + ": " + one.wrong + many.wrong + "; expected places as {}");
    WordTable::Entry entry;
    entry.many = e.many, entry.line = e.line;
    for (size_t i = 0; sound && i < e.forms.size(); ++i) {
      const Placeholders p = placeholders_of(e.forms[i]);
      const std::string differs = !p.wrong.empty() ? p.wrong : places_differ(many, p, !e.many.empty());
      if (!differs.empty()) {
        fault(e.form_line[i], name + ": the translation " + differs + "; expected the places of the English");
        sound = false;
      }
      entry.forms.push_back(e.forms[i]);
    }
    if (!sound) continue;
    if (!many.place.empty()) {
      WordPattern pattern{many, key, 0};
      for (const std::string& piece : many.piece)
        for (const char c : piece) pattern.letters += (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
      // A text of figures and signs alone fits too much to be told by its form.
      if (e.context.empty() && pattern.letters >= 2) t.patterns.push_back(std::move(pattern));
    }
    t.entries.emplace(key, std::move(entry));
  }
  t.locale = std::locale(std::locale::classic(), new DecimalMark(t.decimal));
  for (auto& [key, entry] : t.entries)
    for (std::string& form : entry.forms) form = by_locale(form);
  std::stable_sort(t.patterns.begin(), t.patterns.end(),
                   [](const WordPattern& a, const WordPattern& b) { return a.letters > b.letters; });
  return t;
}

}  // namespace limberg
