#include "app/assembly/lesson_steps_read.h"

namespace limberg {
namespace {

constexpr size_t kMostSteps = 50, kMostAnswers = 5, kMostPoints = 200;
constexpr size_t kSentence = 400;  // bytes: what a panel can show

/// The tables of a list [[key]].
std::vector<const toml::table*> tables_of(const toml::table& root, const char* key, const std::string& file) {
  std::vector<const toml::table*> out;
  const toml::node* n = root.get(key);
  if (!n) return out;
  const toml::array* a = n->as_array();
  const std::string expected = std::string("; expected [[") + key + "]]";
  if (!a) throw InputError(file, int(n->source().begin.line), std::string(key) + " is no list of tables" + expected);
  if (a->size() > kMostSteps)
    throw InputError(file, int(n->source().begin.line),
                     std::to_string(a->size()) + " of " + key + "; expected at most " + std::to_string(kMostSteps));
  for (const toml::node& e : *a) {
    if (!e.is_table())
      throw InputError(file, int(e.source().begin.line), std::string(key) + " holds what is no table" + expected);
    out.push_back(e.as_table());
  }
  return out;
}

void need(Table& t, const char* key, std::string& value, size_t bytes = kSentence) {
  t.text(key, value, bytes);
  if (value.empty()) t.fail(key, std::string("is missing; expected ") + key + " = \"...\"");
}

LessonQuestion question_of(const toml::table& table, const std::string& file) {
  LessonQuestion q;
  Table t(&table, "step.question", file);
  need(t, "ask", q.ask);
  need(t, "because", q.because);
  const char* const expected = "expected two to five texts";
  const toml::array* a = table.contains("answers") ? table.get("answers")->as_array() : nullptr;
  if (!a || a->size() < 2 || a->size() > kMostAnswers)
    t.fail("answers", std::string("is no list of answers; ") + expected);
  for (const toml::node& e : *a) {
    const auto text = e.value<std::string>();
    if (!text || text->empty() || text->size() > kSentence)
      t.fail("answers", std::string("holds what is no text; ") + expected);
    q.answers.push_back(*text);
  }
  if (!t.has("right")) t.fail("right", "is missing; expected the number of the right answer, from 1");
  t.integer("right", 1, int64_t(q.answers.size()), [&](int64_t n) { q.right = int(n); });
  t.finish({"answers"});
  return q;
}

SafeLimit limit_of(const toml::table& table, const std::string& file) {
  SafeLimit l;
  Table t(&table, "limit", file);
  need(t, "name", l.name, 80);
  if (t.has("deepest_mm")) {
    double deepest_mm = 0;
    t.real("deepest_mm", deepest_mm, 0, 200, true);
    l.deepest_mm = deepest_mm;
  }
  if (t.has("line")) {
    const char* const expected = "is no line; expected two to 200 points [x, y] in mm";
    const toml::array* a = table.get("line")->as_array();
    if (!a || a->size() < 2 || a->size() > kMostPoints) t.fail("line", expected);
    for (const toml::node& e : *a) {
      const toml::array* p = e.as_array();
      const auto x = p && p->size() == 2 ? p->get(0)->value<double>() : std::nullopt,
                 y = x ? p->get(1)->value<double>() : std::nullopt;
      if (!y || !std::isfinite(*x) || !std::isfinite(*y)) t.fail("line", expected);
      l.line.emplace_back(*x, *y);
    }
  }
  if (l.line.empty() && !l.deepest_mm) t.fail("name", "has neither line nor deepest_mm; expected one of them");
  t.finish({"line"});
  return l;
}

}  // namespace

LessonWords read_lesson_words(const toml::table& root, const std::string& file) {
  LessonWords words;
  for (const toml::table* table : tables_of(root, "step", file)) {
    LessonStep s;
    Table t(table, "step", file);
    need(t, "stage", s.stage, 80), need(t, "say", s.say), need(t, "why", s.why);
    t.text("hint", s.hint, kSentence);
    if (const toml::table* q = t.table("question")) s.question = question_of(*q, file);
    t.finish();
    for (const LessonStep& other : words.steps)
      if (other.stage == s.stage)
        t.fail("stage", "\"" + s.stage + "\" has words already; expected one step for a stage");
    words.steps.push_back(std::move(s));
  }
  for (const toml::table* table : tables_of(root, "limit", file)) words.limits.push_back(limit_of(*table, file));
  return words;
}

}  // namespace limberg
