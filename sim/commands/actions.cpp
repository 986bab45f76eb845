#include "sim/commands/actions.h"

#include <stdexcept>

#include "sim/commands/script_reader.h"
#include "sim/commands/table.h"

namespace limberg {

namespace {

std::string unit_of(std::string_view key) {
  if (key.ends_with("_mm")) return "mm";
  if (key.ends_with("_deg")) return "degrees";
  if (key.ends_with("_kPa")) return "kPa";
  return key == "seconds" ? "s" : "";
}

// Describes the fields of one kind of line; the values are those of a command that was just made.
struct Describer {
  std::vector<ActionField> fields;
  bool other_form = false;  // the line without the key of its form
  bool in_space = false;    // its places may be in space (in_space.h)
  bool has_forms = false;
  std::string form_words;

  void add(const Field& f, const char* kind, const std::string& unit, const std::string& limits,
           const std::string& otherwise) {
    fields.push_back({f, kind, unit, limits, f.stands == Stands::always ? "" : otherwise});
  }
  void operator()(const Field& f, double v) {
    add(f, "number", unit_of(f.key), fmt::format("{}{:g} to {:g}", f.above ? "above " : "", f.from, f.to),
        fmt::format("{:g}", v));
  }
  void operator()(const Field& f, int v) {
    add(f, "whole number", "", fmt::format("{:g} to {:d}", f.from, int64_t(f.to)), fmt::format("{}", v));
  }
  void operator()(const Field& f, bool) { add(f, "true or false", "", "", f.on ? "true" : "false"); }
  void operator()(const Field& f, const std::string&) {
    add(f, "text", "", fmt::format("at most {} bytes", f.bytes), "none");
  }
  template <class E>
  requires std::is_enum_v<E>
  void operator()(const Field& f, E v) {
    add(f, "choice", "", ScriptReader::listed({f.names.begin(), f.names.end()}), f.names[size_t(v)]);
  }
  void operator()(const Field& f, const ChartPoint&) {
    add(f, in_space ? "point [x, y] or place [x, y, z]" : "point [x, y]", "mm", "", "");
  }
  void operator()(const Field& f, const Vec3&) {
    add(f, "[x, y, z]",
        f.key == std::string_view("normal") ? ""
        : unit_of(f.key).empty()            ? "mm"
                                            : unit_of(f.key),
        "", f.key == std::string_view("bone") ? "that of the face" : "[0, 0, 0]");
  }
  void operator()(const Field& f, const std::vector<ChartPoint>&) {
    add(f, in_space ? "points [[x, y], ...] or places [[x, y, z], ...] in mm" : "points [[x, y], ...] in mm", "",
        least(f), "");
  }
  void operator()(const Field& f, const std::vector<Vec3>&) {
    const bool directions = f.key == std::string_view("normals");
    add(f, directions ? "directions [[x, y, z], ...]" : "places [[x, y, z], ...] in mm", "", least(f), "none");
  }
  void operator()(const Field& f, const StitchPick&) { add(f, "number or point [x, y]", "", "", ""); }
  void operator()(const Field& f, const FragmentPick&) { add(f, "number or place [x, y, z]", "", "", ""); }
  void operator()(const Field& f, const std::optional<Vec3>&) { add(f, "place [x, y, z]", "mm", "", "none"); }
  void operator()(const Field& f, const std::optional<FragmentPick>&) {
    add(f, "number or place [x, y, z]", "", "", "none");
  }
  bool form(const char*, bool, const char* with, const char* without) {
    has_forms = true, form_words = other_form ? without : with;
    return !other_form;
  }
  template <class T>
  void same_unless_given(const T&, const T&) {}

 private:
  static std::string least(const Field& f) { return fmt::format("{:g} to {:g} of them", f.from, f.to); }
};

std::vector<ActionLine> described() {
  std::vector<ActionLine> all;
  for_each_act([&]<class C>(std::type_identity<C>) {
    for (const bool other_form : {false, true}) {
      Describer d;
      d.other_form = other_form;
      d.in_space = []<class... A>(std::type_identity<std::variant<A...>>) {
        return (std::is_same_v<C, A> || ...);
      }(std::type_identity<SkinAct>{});
      C c{};
      Act<C>::fields(d, c);
      if (other_form && !d.has_forms) continue;
      std::string form = d.form_words;
      if constexpr (requires { Act<C>::mark; }) form = " with " + ScriptReader::quoted(Act<C>::mark);
      all.push_back({Act<C>::name, form, Act<C>::needs == Needs::head, Act<C>::help, Act<C>::example, d.fields});
    }
  });
  return all;
}

std::string field_text(const ActionField& f) {
  std::string s = f.kind;
  for (const std::string& part : {f.limits, f.unit})
    if (!part.empty()) s += (part == f.unit && !f.limits.empty() ? " " : ", ") + part;
  return s + (f.field.stands == Stands::always ? "" : "; left out: " + f.otherwise);
}

constexpr const char* kOfHead =
    "Of a head: places in mm, x right, y forward, z up, on the bones where they were at first";
constexpr const char* kOfSkin =
    "Of skin, and of any patient: points on the chart of the skin, mm; where a field says so, places in space, mm at "
    "rest, anywhere on it, or {\"uv\": [u, v]} by its texture";

}  // namespace

const std::vector<ActionLine>& action_lines() {
  static const std::vector<ActionLine> all = described();
  return all;
}

const std::vector<ActionField>& action_fields(const std::string& action) {
  for (const ActionLine& a : action_lines())
    if (a.name == action) return a.fields;
  throw std::logic_error("the table of acts has no " + action);
}

const ActionField& action_field(const std::string& action, const std::string& key) {
  for (const ActionLine& a : action_lines())
    if (a.name == action)
      for (const ActionField& f : a.fields)
        if (f.field.key == key) return f;
  throw std::logic_error("the table of acts has no " + action + "." + key);
}

std::string actions_text(const std::string& action) {
  std::string s;
  bool head = false;
  if (action.empty()) s += std::string(kOfSkin) + "\n\n";
  for (const ActionLine& a : action_lines()) {
    if (!action.empty() && a.name != action) continue;
    if (action.empty() && a.of_head && !head) head = true, s += std::string(kOfHead) + "\n\n";
    s += a.name + a.form + "\n    " + a.help + "\n";
    for (const ActionField& f : a.fields)
      s += fmt::format("    {:<15} {}\n    {:<15} ({})\n", f.field.key, f.field.help, "", field_text(f));
    s += "    " + a.example + "\n\n";
  }
  return s;
}

std::string actions_markdown() {
  std::string s =
      "# Actions\n\nWhat a line of a script may say ([scripts.md](scripts.md)). This page is made by\n"
      "`limberg actions --markdown > docs/actions.md`.\n\n";
  s += std::string("## ") + kOfSkin + "\n\n";
  bool head = false;
  for (const ActionLine& a : action_lines()) {
    if (a.of_head && !head) head = true, s += std::string("## ") + kOfHead + "\n\n";
    s += "### `" + a.name + "`" + a.form + "\n\n" + a.help + "\n\n";
    if (!a.fields.empty()) s += "| field | value | left out | meaning |\n|---|---|---|---|\n";
    for (const ActionField& f : a.fields) {
      std::string value = f.kind;
      if (!f.limits.empty()) value += ", " + f.limits;
      if (!f.unit.empty()) value += (f.limits.empty() ? ", " : " ") + f.unit;
      s += fmt::format("| `{}` | {} | {} | {} |\n", f.field.key, value,
                       f.field.stands == Stands::always ? "must be given" : f.otherwise, f.field.help);
    }
    s += (a.fields.empty() ? "" : "\n") + std::string("    ") + a.example + "\n\n";
  }
  return s;
}

}  // namespace limberg
