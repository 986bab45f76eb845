#include "sim/tools/script.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <type_traits>

#include "sim/error.h"

namespace limberg {
namespace {

using Json = nlohmann::ordered_json;
using L = ScriptLimits;

std::string number(double v) {
  std::ostringstream s;
  s << v;
  return s.str();
}

// One line being read: gives each key by its type and complains in the words of the house.
class Reader {
 public:
  Reader(std::string_view text, const std::string& name, int line) : name_(name), line_(line) {
    if (text.size() > L::line_bytes) fail("the line is longer than " + std::to_string(L::line_bytes) + " bytes");
    check_depth(text);
    std::vector<std::pair<int, std::string>> keys;  // of the objects that are open, by depth
    std::string twice;
    const auto watch = [&](int depth, Json::parse_event_t event, Json& value) {
      if (event == Json::parse_event_t::object_end) std::erase_if(keys, [&](const auto& k) { return k.first > depth; });
      if (event == Json::parse_event_t::key) {
        const auto& k = value.get_ref<const std::string&>();
        if (std::find(keys.begin(), keys.end(), std::pair(depth, k)) != keys.end()) twice = k;
        keys.emplace_back(depth, k);
        if (keys.size() > 100) keys.clear(), twice = "(more than 100 keys)";
      }
      return true;
    };
    try {
      json_ = Json::parse(text.begin(), text.end(), watch);
    } catch (const Json::parse_error& e) {
      fail("broken JSON near column " + std::to_string(e.byte) + "; expected one whole JSON object on the line");
    } catch (const Json::exception&) {
      fail("a number is out of range; expected finite numbers");
    }
    if (!json_.is_object()) fail("expected one JSON object on the line");
    if (!twice.empty()) fail("key \"" + shown(twice) + "\" is given twice; expected each key once");
  }

  [[noreturn]] void fail(const std::string& what) const { throw InputError(name_, line_, what); }

  bool has(const char* key) const { return json_.contains(key); }

  void only(std::initializer_list<const char*> keys, const std::string& where) const {
    for (const auto& [k, v] : json_.items()) {
      if (std::any_of(keys.begin(), keys.end(), [&](const char* want) { return k == want; })) continue;
      std::string list;
      for (const char* want : keys) list += (list.empty() ? "" : ", ") + std::string(want);
      fail("unknown key \"" + shown(k) + "\" in " + where + "; expected " + list);
    }
  }

  std::string text(const char* key, bool required, size_t max_bytes) const {
    if (!has(key)) {
      if (required) missing(key, "a text");
      return {};
    }
    const Json& v = json_[key];
    if (!v.is_string()) fail(quoted(key) + " is not a text");
    const auto& s = v.get_ref<const std::string&>();
    if (required && s.empty()) fail(quoted(key) + " is empty");
    if (s.size() > max_bytes) fail(quoted(key) + " is longer than " + std::to_string(max_bytes) + " bytes");
    return s;
  }

  int64_t integer(const char* key, int64_t lo, int64_t hi) const {
    if (!has(key)) missing(key, "an integer");
    const Json& v = json_[key];
    const std::string range = "; expected an integer from " + std::to_string(lo) + " to " + std::to_string(hi);
    if (!v.is_number_integer()) fail(quoted(key) + " is not an integer" + range);
    if (v.is_number_unsigned() && v.get<uint64_t>() > uint64_t(INT64_MAX)) fail(quoted(key) + " is out of range" + range);
    const int64_t i = v.get<int64_t>();
    if (i < lo || i > hi) fail(quoted(key) + " is " + std::to_string(i) + range);
    return i;
  }

  bool boolean(const char* key, bool otherwise) const {
    if (!has(key)) return otherwise;
    if (!json_[key].is_boolean()) fail(quoted(key) + " is neither true nor false; expected one of them");
    return json_[key].get<bool>();
  }

  // lo <= value <= hi; with `open`, lo < value.
  double real(const char* key, double otherwise, double lo, double hi, bool open) const {
    if (!has(key)) return otherwise;
    const Json& v = json_[key];
    const std::string range = std::string("; expected a number ") + (open ? "above " : "from ") + number(lo) + " to " + number(hi);
    if (!v.is_number()) fail(quoted(key) + " is not a number" + range);
    const double d = v.get<double>();
    if (!std::isfinite(d) || d < lo || d > hi || (open && d == lo)) fail(quoted(key) + " is " + number(d) + range);
    return d;
  }

  /// Named points: {"name":[x, y], ...}.
  std::vector<Landmark> landmarks(const char* key) const {
    std::vector<Landmark> out;
    if (!has(key)) return out;
    if (!json_[key].is_object() || json_[key].size() > L::landmarks)
      fail(quoted(key) + " is no list of at most " + std::to_string(L::landmarks) + " named points; expected {\"name\":[x, y], ...}");
    for (const auto& [name, at] : json_[key].items()) {
      if (name.empty() || name.size() > L::name_bytes) fail(quoted(key) + " holds a name that is empty or too long");
      double c[2];
      coordinates(at, c, 2, key);
      out.push_back({name, {c[0], c[1]}});
    }
    return out;
  }

  std::optional<PlannedProcedure> plan(const char* key) const {
    if (!has(key)) return std::nullopt;
    const std::string expected = "; expected {\"procedure\":\"NAME\",\"values\":{...},\"at\":[x, y],\"turn_deg\":0,\"mirror\":false}";
    const Json& p = json_[key];
    if (!p.is_object() || !p.contains("procedure") || !p["procedure"].is_string()) fail(quoted(key) + " names no procedure" + expected);
    PlannedProcedure out;
    out.procedure = p["procedure"].get<std::string>();
    for (const auto& [k, v] : p.items()) {
      if (k == "procedure") continue;
      if (k == "values" && v.is_object() && v.size() <= 32) {
        for (const auto& [name, value] : v.items()) {
          if (!value.is_number() || !std::isfinite(value.get<double>())) fail("\"values\" holds something that is not a number" + expected);
          out.values.emplace_back(name, value.get<double>());
        }
      } else if (k == "at") {
        double c[2];
        coordinates(v, c, 2, "at");
        out.at = {c[0], c[1]};
      } else if (k == "turn_deg" && v.is_number() && std::abs(v.get<double>()) <= 3600) {
        out.turn_deg = v.get<double>();
      } else if (k == "mirror" && v.is_boolean()) {
        out.mirrored = v.get<bool>();
      } else {
        fail(quoted(key) + " holds \"" + shown(k) + "\", which is unknown or of a wrong kind" + expected);
      }
    }
    return out;
  }

  /// A stitch: its number, or a place.
  StitchPick stitch(const char* key) const {
    if (!has(key)) missing(key, "the number of a stitch or a place [x, y]");
    if (json_[key].is_array()) return {0, point(key)};
    return {int(integer(key, 1, L::max_id)), {0, 0}};
  }

  ChartPoint point(const char* key) const {
    if (!has(key)) missing(key, "a point [x, y]");
    double c[2];
    coordinates(json_[key], c, 2, key);
    return {c[0], c[1]};
  }

  Vec3 place(const char* key) const {
    if (!has(key)) missing(key, "a place [x, y, z]");
    double c[3];
    coordinates(json_[key], c, 3, key);
    return {c[0], c[1], c[2]};
  }

  std::vector<ChartPoint> path(const char* key, size_t least) const {
    if (!has(key)) missing(key, "a list of points [[x, y], ...]");
    const Json& v = json_[key];
    if (!v.is_array()) fail(quoted(key) + " is not a list of points [[x, y], ...]");
    if (v.size() < least || v.size() > L::path_points)
      fail(quoted(key) + " has " + std::to_string(v.size()) + " points; expected " + std::to_string(least) + " to " +
           std::to_string(L::path_points));
    std::vector<ChartPoint> p;
    p.reserve(v.size());
    for (const Json& e : v) {
      double c[2];
      coordinates(e, c, 2, key);
      p.emplace_back(c[0], c[1]);
    }
    return p;
  }

  // A text from the file, made fit for a one-line message.
  static std::string shown(const std::string& s) {
    std::string out;
    for (char c : s.substr(0, 40)) out += (c >= ' ' && c != 127) ? c : '?';
    return out + (s.size() > 40 ? "..." : "");
  }

 private:
  static std::string quoted(const char* key) { return "\"" + std::string(key) + "\""; }
  [[noreturn]] void missing(const char* key, const std::string& what) const {
    fail("key " + quoted(key) + " is missing; expected " + what);
  }

  void coordinates(const Json& v, double* out, size_t n, const char* key) const {
    const std::string want = n == 2 ? "; expected points [x, y]" : "; expected [x, y, z]";
    if (!v.is_array() || v.size() != n) fail(quoted(key) + " holds something that is not " + std::to_string(n) + " numbers" + want);
    for (size_t i = 0; i < n; ++i) {
      if (!v[i].is_number()) fail(quoted(key) + " holds a coordinate that is not a number" + want);
      out[i] = v[i].get<double>();
      if (!std::isfinite(out[i]) || std::abs(out[i]) > L::coordinate_mm)
        fail(quoted(key) + " holds the coordinate " + number(out[i]) + "; expected at most " + number(L::coordinate_mm) + " mm");
    }
  }

  void check_depth(std::string_view text) const {
    int depth = 0;
    bool in_text = false;
    for (size_t i = 0; i < text.size(); ++i) {
      const char c = text[i];
      if (in_text) {
        if (c == '\\') ++i;
        else if (c == '"') in_text = false;
      } else if (c == '"') {
        in_text = true;
      } else if (c == '[' || c == '{') {
        if (++depth > 4) fail("brackets are nested too deeply; expected an object of numbers and points");
      } else if (c == ']' || c == '}') {
        --depth;
      }
    }
  }

  std::string name_;
  int line_;
  Json json_;
};

double length_mm(const std::vector<ChartPoint>& p) {
  double l = 0;
  for (size_t i = 1; i < p.size(); ++i) l += (p[i] - p[i - 1]).norm();
  return l;
}

double depth(const Reader& r, double otherwise) { return r.real("depth_mm", otherwise, 0, L::depth_mm, true); }

ScriptHeader read_header(std::string_view text, const std::string& name, int line) {
  const Reader r(text, name, line);
  if (!r.has("limberg_script"))
    r.fail("the first line is not a script's header; expected {\"limberg_script\":1,\"scene\":\"NAME\"}");
  r.only({"limberg_script", "scene", "note", "landmarks", "plan"}, "the header");
  r.integer("limberg_script", ScriptHeader::version, ScriptHeader::version);
  return {r.text("scene", true, 1000), r.text("note", false, 10'000), r.landmarks("landmarks"), r.plan("plan")};
}

Json json(const ChartPoint& p) { return Json::array({p.x(), p.y()}); }
Json json(const std::vector<ChartPoint>& path) {
  Json a = Json::array();
  for (const auto& p : path) a.push_back(json(p));
  return a;
}
Json json(const StitchPick& s) { return s.id > 0 ? Json(s.id) : json(s.at); }
void add_kind(Json& j, const RowKind& k) {
  j["spacing_mm"] = k.spacing_mm;
  if (k.depth_mm > 0) j["depth_mm"] = k.depth_mm;
  if (k.running) j["running"] = true;
  if (k.slack_mm > 0) j["slack_mm"] = k.slack_mm;
}

}  // namespace

Command parse_command(std::string_view json_line, const std::string& name, int line) {
  const Reader r(json_line, name, line);
  if (r.has("limberg_script")) r.fail("a second header; expected an action");
  const std::string a = r.text("action", true, 100);
  const std::string where = "the action " + Reader::shown(a);
  if (a == "incise" && r.has("stroke")) {
    r.only({"action", "stroke", "path", "depth_mm", "angle_deg", "more"}, where);
    const InciseMore d;
    return InciseMore{int(r.integer("stroke", 1, L::max_id)), r.path("path", 1), depth(r, d.depth_mm),
                      r.real("angle_deg", d.angle_deg, L::min_angle_deg, L::max_angle_deg, false), !r.boolean("more", false)};
  }
  if (a == "incise") {
    r.only({"action", "path", "depth_mm", "angle_deg", "spline"}, where);
    const Incise d;
    return Incise{r.path("path", 2), depth(r, d.depth_mm), r.real("angle_deg", d.angle_deg, L::min_angle_deg, L::max_angle_deg, false),
                  r.boolean("spline", false)};
  }
  if (a == "undermine") {
    r.only({"action", "outline", "depth_mm"}, where);
    return Undermine{r.path("outline", 3), depth(r, Undermine{}.depth_mm)};
  }
  if (a == "excise") {
    r.only({"action", "outline", "depth_mm", "floor"}, where);
    return Excise{r.path("outline", 3), depth(r, Excise{}.depth_mm), r.boolean("floor", true)};
  }
  if (a == "hook") {
    r.only({"action", "id", "at"}, where);
    return SetHook{int(r.integer("id", 1, L::max_id)), r.point("at")};
  }
  if (a == "move") {
    r.only({"action", "id", "to", "seconds"}, where);
    return MoveHook{int(r.integer("id", 1, L::max_id)), r.place("to"), r.real("seconds", MoveHook{}.seconds, 0, L::seconds, false)};
  }
  if (a == "release") {
    r.only({"action", "id"}, where);
    return ReleaseHook{int(r.integer("id", 1, L::max_id))};
  }
  const auto bite = [&](double otherwise) { return r.real("depth_mm", otherwise, 0, L::depth_mm, false); };
  const auto kind = [&] {
    return RowKind{r.real("spacing_mm", RowKind{}.spacing_mm, 0, 1000, true), bite(0), r.boolean("running", false),
                   r.real("slack_mm", 0, 0, 1000, false)};
  };
  if (a == "suture") {
    r.only({"action", "a", "b", "depth_mm"}, where);
    return Suture{r.point("a"), r.point("b"), bite(0)};
  }
  if (a == "suture_row") {
    r.only({"action", "a", "b", "spacing_mm", "depth_mm", "running", "slack_mm"}, where);
    const RowKind k = kind();
    SutureRow row{r.path("a", 2), r.path("b", 2), k.spacing_mm, k.depth_mm, k.running, k.slack_mm};
    const double longer = std::max(length_mm(row.a), length_mm(row.b));
    if (longer / row.spacing_mm > double(L::row_sutures))
      r.fail("\"spacing_mm\" " + number(row.spacing_mm) + " on a path of " + number(longer) + " mm makes too many sutures; expected at most " +
             std::to_string(L::row_sutures));
    if (row.slack_mm > 0 && !row.running) r.fail("\"slack_mm\" without \"running\":true; expected a running suture");
    return row;
  }
  if (a == "suture_corner") {
    r.only({"action", "tip", "a", "b", "depth_mm"}, where);
    return SutureCorner{r.point("tip"), r.point("a"), r.point("b"), r.real("depth_mm", SutureCorner{}.depth_mm, 0, L::depth_mm, true)};
  }
  if (a == "suture_between") {
    r.only({"action", "from", "to", "spacing_mm", "depth_mm", "running", "slack_mm"}, where);
    const SutureBetween between{r.stitch("from"), r.stitch("to"), kind()};
    if (between.row.slack_mm > 0 && !between.row.running) r.fail("\"slack_mm\" without \"running\":true; expected a running suture");
    return between;
  }
  if (a == "cut_suture") {
    r.only({"action", "id", "at"}, where);
    if (r.has("id") == r.has("at")) r.fail("expected either \"id\" or \"at\"");
    return r.has("id") ? CutSuture{{int(r.integer("id", 1, L::max_id)), {0, 0}}} : CutSuture{{0, r.point("at")}};
  }
  if (a == "undo") {
    r.only({"action"}, where);
    return Undo{};
  }
  if (a == "redo") {
    r.only({"action"}, where);
    return Redo{};
  }
  if (a == "stage") {
    r.only({"action", "name"}, where);
    return Stage{r.text("name", true, L::name_bytes)};
  }
  if (a == "wait") {
    r.only({"action", "seconds"}, where);
    return Wait{r.real("seconds", Wait{}.seconds, 0, L::seconds, false)};
  }
  r.fail("unknown action \"" + Reader::shown(a) +
         "\"; expected excise, incise, undermine, hook, move, release, suture, suture_row, suture_corner, suture_between, cut_suture, undo, redo, stage or wait");
}

Script parse_script(std::string_view text, const std::string& name) {
  if (text.size() > L::file_bytes)
    throw InputError(name, 0, "the script is larger than " + std::to_string(L::file_bytes >> 20) + " MB");
  Script s;
  s.name = name;
  bool header = false;
  int line = 0;
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size());
    std::string_view l = text.substr(at, end - at);
    at = end + 1;
    ++line;
    while (!l.empty() && (l.back() == '\r' || l.back() == ' ' || l.back() == '\t')) l.remove_suffix(1);
    if (l.empty()) continue;
    if (!header) {
      s.header = read_header(l, name, line);
      header = true;
      continue;
    }
    if (s.lines.size() == L::commands)
      throw InputError(name, line, "more than " + std::to_string(L::commands) + " actions; expected a shorter script");
    s.lines.push_back({line, parse_command(l, name, line)});
  }
  if (!header) throw InputError(name, 0, "the script is empty; expected a header line and one action a line");
  return s;
}

Script load_script(const std::string& path) {
  std::error_code ec;
  if (!std::filesystem::exists(path, ec)) throw InputError(path, 0, "no such file; expected an operation script");
  if (std::filesystem::is_directory(path, ec)) throw InputError(path, 0, "is a folder; expected an operation script");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, 0, std::string("cannot be opened (") + std::strerror(errno) + "); expected an operation script");
  std::string text;
  std::vector<char> part(1 << 16);
  while (in.read(part.data(), std::streamsize(part.size())), in.gcount() > 0) {
    text.append(part.data(), size_t(in.gcount()));
    if (text.size() > L::file_bytes) break;  // parse_script says so
  }
  if (in.bad()) throw InputError(path, 0, "cannot be read to its end");
  return parse_script(text, path);
}

const char* action_name(const Command& command) {
  static constexpr const char* names[] = {"incise", "incise", "undermine",  "excise", "hook",  "move", "release",
                                          "suture", "suture_row", "undo",   "redo",  "stage", "wait", "suture_corner", "suture_between", "cut_suture"};
  static_assert(std::variant_size_v<Command> == std::size(names));
  return names[command.index()];
}

std::string to_json_line(const ScriptHeader& h) {
  Json j;
  j["limberg_script"] = ScriptHeader::version;
  j["scene"] = h.scene;
  if (!h.note.empty()) j["note"] = h.note;
  for (const Landmark& l : h.landmarks) j["landmarks"][l.name] = json(l.at);
  if (h.plan) {
    Json& p = j["plan"];
    p["procedure"] = h.plan->procedure;
    for (const auto& [name, value] : h.plan->values) p["values"][name] = value;
    p["at"] = json(h.plan->at);
    p["turn_deg"] = h.plan->turn_deg;
    if (h.plan->mirrored) p["mirror"] = true;
  }
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string to_json_line(const Command& command) {
  Json j;
  j["action"] = action_name(command);
  std::visit(
      [&](const auto& c) {
        using T = std::decay_t<decltype(c)>;
        if constexpr (std::is_same_v<T, Incise>) {
          j["path"] = json(c.path);
          j["depth_mm"] = c.depth_mm;
          j["angle_deg"] = c.angle_deg;
          if (c.spline) j["spline"] = true;
        } else if constexpr (std::is_same_v<T, InciseMore>) {
          j["stroke"] = c.stroke;
          j["path"] = json(c.path);
          j["depth_mm"] = c.depth_mm;
          j["angle_deg"] = c.angle_deg;
          if (!c.last) j["more"] = true;
        } else if constexpr (std::is_same_v<T, Undermine> || std::is_same_v<T, Excise>) {
          j["outline"] = json(c.outline);
          j["depth_mm"] = c.depth_mm;
          if constexpr (std::is_same_v<T, Excise>)
            if (!c.floor) j["floor"] = false;
        } else if constexpr (std::is_same_v<T, SetHook>) {
          j["id"] = c.id;
          j["at"] = json(c.at);
        } else if constexpr (std::is_same_v<T, MoveHook>) {
          j["id"] = c.id;
          j["to"] = Json::array({c.to_mm.x(), c.to_mm.y(), c.to_mm.z()});
          j["seconds"] = c.seconds;
        } else if constexpr (std::is_same_v<T, ReleaseHook>) {
          j["id"] = c.id;
        } else if constexpr (std::is_same_v<T, Suture>) {
          j["a"] = json(c.a);
          j["b"] = json(c.b);
          if (c.depth_mm > 0) j["depth_mm"] = c.depth_mm;
        } else if constexpr (std::is_same_v<T, SutureRow>) {
          j["a"] = json(c.a);
          j["b"] = json(c.b);
          add_kind(j, RowKind{c.spacing_mm, c.depth_mm, c.running, c.slack_mm});
        } else if constexpr (std::is_same_v<T, SutureCorner>) {
          j["tip"] = json(c.tip);
          j["a"] = json(c.a);
          j["b"] = json(c.b);
          j["depth_mm"] = c.depth_mm;
        } else if constexpr (std::is_same_v<T, SutureBetween>) {
          j["from"] = json(c.from);
          j["to"] = json(c.to);
          add_kind(j, c.row);
        } else if constexpr (std::is_same_v<T, CutSuture>) {
          j[c.which.id > 0 ? "id" : "at"] = json(c.which);
        } else if constexpr (std::is_same_v<T, Stage>) {
          j["name"] = c.name;
        } else if constexpr (std::is_same_v<T, Wait>) {
          j["seconds"] = c.seconds;
        }
      },
      command);
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string to_text(const Script& script) {
  std::string text = to_json_line(script.header) + "\n";
  for (const ScriptLine& l : script.lines) text += to_json_line(l.command) + "\n";
  return text;
}

ScriptWriter::ScriptWriter(const std::string& path, const ScriptHeader& header, Existing existing) : path_(path) {
  file_ = std::fopen(path.c_str(), existing == Existing::replace ? "wb" : "wbx");
  if (!file_) {
    if (errno == EEXIST) throw InputError(path, 0, "exists already; expected the name of a new file");
    throw InputError(path, 0, std::string("cannot be written (") + std::strerror(errno) + "); expected a writable place");
  }
  try {
    write(to_json_line(header));
  } catch (...) {
    std::fclose(file_);
    throw;
  }
}

ScriptWriter::~ScriptWriter() { std::fclose(file_); }

void ScriptWriter::append(const Command& command) { write(to_json_line(command)); }

void ScriptWriter::write(const std::string& line) {
  const std::string l = line + "\n";
  if (std::fwrite(l.data(), 1, l.size(), file_) != l.size() || std::fflush(file_) != 0)
    throw InputError(path_, 0, std::string("cannot be written to (") + std::strerror(errno) + "); expected room on the disk");
}

}  // namespace limberg
