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

/// The points of a list; of one point ([x, y] itself) where `least` is 1. `size`: of its numbers.
std::vector<Vec3> points_of(Table& t, const toml::table& table, const char* key, size_t size, size_t least,
                            const char* expected) {
  std::vector<Vec3> out;
  const auto add = [&](const toml::array* p) {
    Vec3 x = Vec3::Zero();
    if (!p || p->size() != size) t.fail(key, expected);
    for (size_t k = 0; k < size; ++k) {
      const auto v = p->get(k)->value<double>();
      if (!v || !std::isfinite(*v)) t.fail(key, expected);
      x[Eigen::Index(k)] = *v;
    }
    out.push_back(x);
  };
  const toml::array* a = table.get(key)->as_array();
  if (least == 1) return add(a), out;
  if (!a || a->size() < least || a->size() > kMostPoints) t.fail(key, expected);
  for (const toml::node& e : *a) add(e.as_array());
  return out;
}

LessonQuestion question_of(const toml::table& table, const std::string& file) {
  LessonQuestion q;
  Table t(&table, "step.question", file);
  need(t, "ask", q.ask);
  need(t, "because", q.because);
  const bool place = t.has("place"), number = t.has("number");
  if (place || number) {
    for (const char* key : {"answers", "right", place ? "number" : "place", place ? "unit" : "place"})
      if (t.has(key)) t.fail(key, "beside another way to answer; expected one of answers, place and number");
    if (!t.has("within")) t.fail("within", "is missing; expected how far off an answer may be");
    t.real("within", q.within, 0, 1000, true);
    if (place) {
      const std::vector<Vec3> at = points_of(t, table, "place", 2, 1, "is no place; expected [x, y] in mm");
      q.place = ChartPoint(at[0].x(), at[0].y());
    } else {
      double value = 0;
      t.real("number", value, -1e6, 1e6);
      q.number = value;
      t.text("unit", q.unit, 20);
    }
    t.finish({"place"});
    return q;
  }
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
  if (t.has("line"))
    for (const Vec3& p : points_of(t, table, "line", 2, 2, "is no line; expected two to 200 points [x, y] in mm"))
      l.line.emplace_back(p.x(), p.y());
  if (t.has("bone_line")) {
    if (t.has("line") || t.has("deepest_mm"))
      t.fail("bone_line", "beside a limit of skin; expected either bone_line and nearest_mm, or line and deepest_mm");
    l.bone_line = points_of(t, table, "bone_line", 3, 2, "is no line; expected two to 200 points [x, y, z] in mm");
    if (!t.has("nearest_mm")) t.fail("nearest_mm", "is missing; expected how near a saw may come to it");
    t.real("nearest_mm", l.nearest_mm, 0, 200, true);
  }
  if (l.line.empty() && !l.deepest_mm && l.bone_line.empty())
    t.fail("name", "has neither line nor deepest_mm; expected one of them");
  t.finish({"line", "bone_line"});
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
