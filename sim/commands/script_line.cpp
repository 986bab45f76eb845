// Commands from and to lines of a script, by the rows of the table.
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/commands/script_reader.h"
#include "sim/commands/table.h"

namespace limberg {

namespace {

using Json = nlohmann::ordered_json;

/// The keys that a line may have.
struct KeysOfLine {
  const ScriptReader& line;
  std::vector<const char*> keys{"action"};
  std::string form_words{};

  template <class T>
  void operator()(const Field& f, const T&) {
    keys.push_back(f.key);
  }
  bool form(const char* key, bool, const char* with, const char* without) {
    form_words = line.has(key) ? with : without;
    return line.has(key);
  }
  template <class T>
  void same_unless_given(const T&, const T&) {}
};

/// Whether the places of an act are given in space.
struct SpaceProbe {
  const ScriptReader& line;
  const char* place = nullptr;  // the first key that has one, and the first that has a point of the chart
  const char* point = nullptr;

  void see(const char* key) {
    if (!line.is_list(key) && !line.has_places(key)) return;
    const char*& first = line.has_places(key) ? place : point;
    if (!first) first = key;
  }
  void operator()(const Field& f, const ChartPoint&) { see(f.key); }
  void operator()(const Field& f, const std::vector<ChartPoint>&) { see(f.key); }
  void operator()(const Field& f, const StitchPick&) { see(f.key); }
  template <class T>
  void operator()(const Field&, const T&) {}
  bool form(const char* key, bool, const char*, const char*) { return line.has(key); }
  template <class T>
  void same_unless_given(const T&, const T&) {}
};

/// Fills a command from a line.
struct LineReader {
  static constexpr auto kTextures = ScriptReader::Textures::allowed;
  const ScriptReader& line;
  std::vector<double>* z = nullptr;  // places are in space; what is beside x and y goes here

  ChartPoint flat(const Vec3& X) {
    z->push_back(X.z());
    return {X.x(), X.y()};
  }

  bool left_out(const Field& f) const { return f.stands != Stands::always && !line.has(f.key); }

  void operator()(const Field& f, double& v) {
    if (f.stands == Stands::always || line.has(f.key)) v = line.real(f.key, v, f.from, f.to, f.above);
  }
  void operator()(const Field& f, int& v) {
    if (!left_out(f)) v = int(line.integer(f.key, int64_t(f.from), int64_t(f.to)));
  }
  void operator()(const Field& f, bool& v) { v = line.boolean(f.key, f.on); }
  void operator()(const Field& f, std::string& v) {
    if (!left_out(f)) v = line.text(f.key, true, f.bytes);
  }
  template <class E>
  requires std::is_enum_v<E>
  void operator()(const Field& f, E& v) {
    if (!left_out(f)) v = E(line.choice(f.key, f.names));
  }
  void operator()(const Field& f, ChartPoint& v) {
    if (!left_out(f)) v = z ? flat(line.place(f.key, kTextures)) : line.point(f.key);
  }
  void operator()(const Field& f, Vec3& v) {
    if (!left_out(f)) v = line.place(f.key);
  }
  void operator()(const Field& f, std::vector<ChartPoint>& v) {
    if (!z) return void(v = line.path(f.key, size_t(f.from)));
    v.clear();
    for (const Vec3& X : line.places(f.key, size_t(f.from), kTextures)) v.push_back(flat(X));
  }
  void operator()(const Field& f, std::vector<Vec3>& v) {
    if (!left_out(f)) v = line.places(f.key, size_t(f.from));
  }
  void operator()(const Field& f, StitchPick& v) {
    v = z && line.has_places(f.key) ? StitchPick{0, flat(line.place(f.key, kTextures))} : line.stitch(f.key);
  }
  void operator()(const Field& f, FragmentPick& v) { v = line.fragment(f.key); }
  void operator()(const Field& f, std::optional<Vec3>& v) {
    if (!left_out(f)) v = line.place(f.key);
  }
  void operator()(const Field& f, std::optional<FragmentPick>& v) {
    if (!left_out(f)) v = line.fragment(f.key);
  }
  bool form(const char* key, bool, const char*, const char*) { return line.has(key); }
  template <class T>
  void same_unless_given(T& v, const T& other) {
    v = other;
  }
};

Json json_of(const ChartPoint& p) { return Json::array({p.x(), p.y()}); }
Json json_of(const Vec3& v) { return Json::array({v.x(), v.y(), v.z()}); }
Json json_of(const FragmentPick& p) { return p.id >= 0 ? Json(p.id) : json_of(p.at_mm); }
template <class P>
Json json_of(const std::vector<P>& path) {
  Json a = Json::array();
  for (const P& p : path) a.push_back(json_of(p));
  return a;
}

/// Writes a command's fields into a line.
struct LineWriter {
  Json line = Json::object();
  std::span<const double> z{};  // of an act in space: what is beside x and y, from here on
  bool in_space = false;

  Json place(const ChartPoint& p) {
    if (!in_space) return json_of(p);
    const double height = z.front();
    z = z.subspan(1);
    if (std::isnan(height)) return Json{{"uv", json_of(p)}};
    return json_of(Vec3(p.x(), p.y(), height));
  }

  template <class T>
  void operator()(const Field& f, const T& v) {
    const bool quiet = f.stands == Stands::if_other;
    if constexpr (std::is_same_v<T, bool>) {
      if (v != f.on) line[f.key] = v;
    } else if constexpr (std::is_enum_v<T>) {
      if (!quiet || v != T{}) line[f.key] = f.names[size_t(v)];
    } else if constexpr (std::is_arithmetic_v<T>) {
      if (!quiet || v != T{}) line[f.key] = v;
    } else if constexpr (std::is_same_v<T, std::string>) {
      if (!quiet || !v.empty()) line[f.key] = v;
    } else if constexpr (requires { v.has_value(); }) {
      if (v) line[f.key] = json_of(*v);
    } else if constexpr (std::is_same_v<T, Vec3>) {
      if (!quiet || v != Vec3::Zero()) line[f.key] = json_of(v);
    } else if constexpr (std::is_same_v<T, ChartPoint>) {
      line[f.key] = place(v);
    } else if constexpr (std::is_same_v<T, std::vector<ChartPoint>>) {
      line[f.key] = Json::array();
      for (const ChartPoint& p : v) line[f.key].push_back(place(p));
    } else if constexpr (std::is_same_v<T, StitchPick>) {
      line[f.key] = v.id > 0 ? Json(v.id) : place(v.at);
    } else if constexpr (std::is_same_v<T, std::vector<Vec3>>) {
      if (!quiet || !v.empty()) line[f.key] = json_of(v);
    } else {
      line[f.key] = json_of(v);
    }
  }
  bool form(const char*, bool chosen, const char*, const char*) { return chosen; }
  template <class T>
  void same_unless_given(const T&, const T&) {}
};

template <class C, class V>
struct HoldsAct : std::false_type {};
template <class C, class... A>
struct HoldsAct<C, std::variant<A...>> : std::bool_constant<(std::is_same_v<C, A> || ...)> {};

template <class C>
Command read(const ScriptReader& line, const std::string& where) {
  C c{};
  KeysOfLine known{line};
  Act<C>::fields(known, c);
  line.only(known.keys, where + known.form_words);
  c = C{};
  SpaceProbe probe{line};
  if constexpr (HoldsAct<C, SkinAct>::value) Act<C>::fields(probe, c);
  if (probe.place && probe.point)
    line.fail(ScriptReader::quoted(probe.place) + " holds a place [x, y, z], and " + ScriptReader::quoted(probe.point) +
              " does not; expected places of one kind in one act");
  std::vector<double> z;
  LineReader reader{line, probe.place ? &z : nullptr};
  Act<C>::fields(reader, c);
  if constexpr (requires { Act<C>::check(c); })
    if (const std::string wrong = Act<C>::check(c); !wrong.empty()) line.fail(wrong);
  if constexpr (HoldsAct<C, SkinAct>::value)
    if (probe.place) return InSpace{c, std::move(z)};
  if constexpr (Act<C>::needs == Needs::head)
    return HeadCommand(c);
  else
    return c;
}

template <class C>
constexpr const char* mark_of() {
  if constexpr (requires { Act<C>::mark; })
    return Act<C>::mark;
  else
    return nullptr;
}

std::string names_of_acts(Needs needs, bool or_nothing) {
  std::vector<std::string> names;
  for_each_act([&]<class C>(std::type_identity<C>) {
    const bool wanted = Act<C>::needs == needs || (or_nothing && Act<C>::needs == Needs::nothing);
    if (wanted && std::find(names.begin(), names.end(), Act<C>::name) == names.end()) names.emplace_back(Act<C>::name);
  });
  return ScriptReader::listed(names);
}

}  // namespace

Command parse_command(std::string_view json_line, const std::string& name, int line) {
  const ScriptReader r(json_line, name, line);
  if (r.has("limberg_script")) r.fail("a second header; expected an action");
  const std::string action = r.text("action", true, 100), where = "the action " + ScriptReader::shown(action);
  std::optional<Command> c;
  for (const bool marked : {true, false})
    for_each_act([&]<class C>(std::type_identity<C>) {
      const char* mark = mark_of<C>();
      if (!c && action == Act<C>::name && marked == (mark != nullptr) && (!mark || r.has(mark))) c = read<C>(r, where);
    });
  if (!c)
    r.fail("unknown action \"" + ScriptReader::shown(action) + "\"; expected " + names_of_acts(Needs::skin, true) +
           ", or of a head: " + names_of_acts(Needs::head, false));
  return *std::move(c);
}

const char* action_name(const Command& command) {
  return visit_act(command, []<class C>(const C&) { return Act<C>::name; });
}

std::string to_json_line(const Command& command) {
  LineWriter writer;
  writer.line["action"] = action_name(command);
  const auto write = [&]<class C>(const C& c) { Act<C>::fields(writer, c); };
  if (const auto* placed = std::get_if<InSpace>(&command)) {
    writer.in_space = true, writer.z = placed->z_mm;
    std::visit(write, placed->act);
  } else {
    visit_act(command, write);
  }
  return writer.line.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace limberg
