#include "tests/app/words/texts.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "app/assembly/lesson.h"
#include "app/program/places.h"
#include "app/words/word_table.h"
#include "sim/base/whole_file.h"
#include "sim/commands/actions.h"
#include "sim/commands/script.h"
#include "sim/measure/table.h"

namespace limberg::testing {
namespace {

namespace fs = std::filesystem;

bool in_name(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; }

void put_utf8(std::string& to, unsigned code) {
  if (code < 0x80)
    to += char(code);
  else if (code < 0x800)
    to += char(0xC0 | code >> 6), to += char(0x80 | (code & 63));
  else
    to += char(0xE0 | code >> 12), to += char(0x80 | (code >> 6 & 63)), to += char(0x80 | (code & 63));
}

/// Reads literals in a source, from a place on.
class Literals {
 public:
  Literals(std::string_view source, size_t at) : s_(source), at_(at) {}
  void skip() {
    while (at_ < s_.size() && (s_[at_] == ' ' || s_[at_] == '\n' || s_[at_] == '\t')) ++at_;
  }
  bool take(char c) {
    skip();
    if (at_ >= s_.size() || s_[at_] != c) return false;
    ++at_;
    return true;
  }
  /// Neighbours are one; nothing that is no literal.
  bool text(std::string& out) {
    skip();
    const char quote = at_ < s_.size() ? s_[at_] : ' ';
    if (quote != '"' && quote != '\'') return false;
    out.clear();
    for (skip(); at_ < s_.size() && s_[at_] == quote; skip()) {
      for (++at_; at_ < s_.size() && s_[at_] != quote; ++at_) {
        if (s_[at_] != '\\') {
          out += s_[at_];
          continue;
        }
        const char c = s_[++at_];
        if (c == 'u')
          put_utf8(out, unsigned(std::stoul(std::string(s_.substr(at_ + 1, 4)), nullptr, 16))), at_ += 4;
        else
          out += c == 'n' ? '\n' : c == 't' ? '\t' : c;
      }
      ++at_;
      if (quote == '\'') break;
    }
    return true;
  }
  /// Past a comma outside of brackets.
  bool next_argument() {
    for (int deep = 0; at_ < s_.size(); ++at_) {
      const char c = s_[at_];
      if (c == '(' || c == '{' || c == '[') ++deep;
      if (c == ')' || c == '}' || c == ']') --deep;
      if (deep < 0 || c == ';') return false;
      if (c == ',' && deep == 0) return ++at_, true;
    }
    return false;
  }

 private:
  std::string_view s_;
  size_t at_;
};

std::vector<fs::path> sources() {
  const fs::path root = source_dir();
  std::vector<fs::path> all;
  for (const auto& e : fs::recursive_directory_iterator(root / "app")) {
    const std::string ending = e.path().extension().string();
    if (e.is_regular_file() && (ending == ".h" || ending == ".cpp" || ending == ".js")) all.push_back(e.path());
  }
  std::sort(all.begin(), all.end());
  return all;
}

void add_lessons(const std::string& folder, std::vector<MarkedText>& all) {
  std::vector<fs::path> files;
  for (const auto& e : fs::directory_iterator(fs::path(source_dir()) / folder))
    if (e.path().extension() == ".toml") files.push_back(e.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    const Lesson l = open_lesson(file.string());
    const std::string name = folder + "/" + file.filename().string();
    const auto add = [&](const std::string& text) { all.push_back({name, "", text, ""}); };
    add(l.title), add(l.goal);
    for (const std::string& s : l.steps) add(s);
    for (const std::string& h : l.hints) add(h);
    for (const SafeLimit& x : l.words.limits) add(x.name);
    for (const LessonStep& s : l.words.steps) {
      add(s.stage), add(s.say), add(s.why), add(s.hint);
      if (!s.question) continue;
      add(s.question->ask), add(s.question->because);
      for (const std::string& a : s.question->answers) add(a);
    }
  }
}

/// Stages of the shipped scripts.
void add_stages(std::vector<MarkedText>& all) {
  std::vector<fs::path> files;
  for (const auto& e : fs::directory_iterator(fs::path(source_dir()) / "recordings"))
    if (e.path().extension() == ".jsonl") files.push_back(e.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files)
    for (const ScriptLine& l : load_script(file.string()).lines)
      if (const auto* stage = std::get_if<Stage>(&l.command))
        all.push_back({"recordings/" + file.filename().string(), "", stage->name, ""});
}

/// What scenes say of themselves.
void add_scenes(std::vector<MarkedText>& all) {
  std::vector<fs::path> files;
  for (const auto& e : fs::directory_iterator(fs::path(source_dir()) / "app/scenes"))
    if (e.path().extension() == ".toml") files.push_back(e.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    std::istringstream lines(read_whole_file(file.string()));
    for (std::string line; std::getline(lines, line);) {
      std::string text;
      if (line.starts_with("note = \"") && Literals(line, 7).text(text))
        all.push_back({"app/scenes/" + file.filename().string(), "", text, ""});
    }
  }
}

void add_tables(std::vector<MarkedText>& all) {
  for (const Measure& m : measure_table()) {
    all.push_back({"sim/measure/table.cpp", "", m.words, ""});
    all.push_back({"sim/measure/table.cpp", "", m.definition, ""});
    if (m.limits) all.push_back({"sim/measure/table.h", "", m.limits->source, ""});
  }
  all.push_back({"sim/measure/table.h", "", kSutureGap_mm.source, ""});
  for (const ActionLine& a : action_lines()) all.push_back({"sim/commands/table.h", "", a.name, ""});
  for (const char* action : {"incise", "undermine", "excise", "suture", "suture_row", "suture_corner"})
    for (const ActionField& f : action_fields(action))
      for (const char* key : {"depth_mm", "angle_deg", "spacing_mm"})
        if (f.field.key == std::string_view(key)) all.push_back({"sim/commands/table.h", "", f.field.help, ""});
  for (const ActionField& f : {action_field("connect_tissue", "mode"), action_field("superpose", "on")})
    for (const char* word : f.field.words) all.push_back({"sim/commands/table_head.h", "", word, ""});
}

}  // namespace

std::vector<MarkedText> marked_texts(std::string_view raw, const std::string& file) {
  // Comments hold examples.
  std::string source;
  bool quoted = false;
  for (size_t i = 0; i < raw.size(); ++i) {
    if (raw[i] == '"' && (i == 0 || raw[i - 1] != '\\')) quoted = !quoted;
    if (raw[i] == '\n') quoted = false;
    if (!quoted && raw[i] == '/' && i + 1 < raw.size() && raw[i + 1] == '/')
      while (i < raw.size() && raw[i] != '\n') ++i;
    if (i < raw.size()) source += raw[i];
  }
  std::vector<MarkedText> all;
  for (size_t i = 0; (i = source.find('(', i)) != source.npos; ++i) {
    size_t begin = i;
    while (begin > 0 && in_name(source[begin - 1])) --begin;
    const std::string name = source.substr(begin, i - begin);
    MarkedText t{file, "", "", ""};
    Literals at(source, i + 1);
    if (name == "english" || name == "w") {
      if (!at.text(t.text)) continue;
    } else if (name == "english_counted") {
      if (!at.text(t.text) || !at.take(',') || !at.text(t.many)) continue;
    } else if (name == "counted") {
      if (!at.next_argument() || !at.text(t.text) || !at.take(',') || !at.text(t.many)) continue;
    } else if (name == "as") {
      if (!at.text(t.context) || !at.take(',') || !at.text(t.text)) continue;
    } else if (name == "button") {
      if (!at.next_argument() || !at.text(t.text)) continue;
    } else {
      continue;
    }
    if (!t.text.empty()) all.push_back(std::move(t));
  }
  return all;
}

std::vector<MarkedText> all_texts() {
  std::vector<MarkedText> all;
  for (const fs::path& file : sources())
    for (MarkedText& t :
         marked_texts(read_whole_file(file.string()), fs::relative(file, source_dir()).generic_string()))
      all.push_back(std::move(t));
  all.push_back({"app/words/word_table.h", "decimal mark", ".", ""});
  add_tables(all);
  add_scenes(all);
  add_lessons("app/lessons", all);
  add_stages(all);
  std::set<std::string> seen;
  std::erase_if(all, [&](const MarkedText& t) {
    const bool letters = std::any_of(t.text.begin(), t.text.end(), [](char c) { return in_name(c); });
    return (t.context.empty() && (!letters || t.text == "{:.1f}" || t.text == "{:.2f}" || t.text == "{:+.1f}")) ||
           !seen.insert(key_of(t.context, t.text)).second;
  });
  return all;
}

std::string pot_of(const std::vector<MarkedText>& texts) {
  const auto quoted = [](const std::string& s) {
    std::string q = "\"";
    for (const char c : s) q += c == '"' || c == '\\' ? std::string("\\") + c : c == '\n' ? "\\n" : std::string(1, c);
    return q + "\"";
  };
  std::string out =
      "# The texts of Limberg, for translations: made by ./do words (docs/words.md).\n"
      "msgid \"\"\n"
      "msgstr \"\"\n"
      "\"Content-Type: text/plain; charset=UTF-8\\n\"\n"
      "\"Content-Transfer-Encoding: 8bit\\n\"\n"
      "\"MIME-Version: 1.0\\n\"\n"
      "\"Language: en\\n\"\n"
      "\"Plural-Forms: nplurals=2; plural=(n != 1);\\n\"\n";
  for (const MarkedText& t : texts) {
    out += "\n#: " + t.file + "\n";
    if (!t.context.empty()) out += "msgctxt " + quoted(t.context) + "\n";
    out += "msgid " + quoted(t.text) + "\n";
    if (t.many.empty())
      out += "msgstr \"\"\n";
    else
      out += "msgid_plural " + quoted(t.many) + "\nmsgstr[0] \"\"\nmsgstr[1] \"\"\n";
  }
  return out;
}

}  // namespace limberg::testing
