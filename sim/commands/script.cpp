#include "sim/commands/script.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <type_traits>

#include "sim/base/error.h"
#include "sim/commands/script_reader.h"
#include "sim/geometry/blade_angle.h"

namespace limberg {
namespace {

using Json = nlohmann::ordered_json;
using L = ScriptLimits;
// Of what a script may hold, what a blade can do.
constexpr double kLeast_deg = std::max(L::min_angle_deg, kLeastBlade_deg),
                 kMost_deg = std::min(L::max_angle_deg, kMostBlade_deg);

double length_mm(const std::vector<ChartPoint>& p) {
  double l = 0;
  for (size_t i = 1; i < p.size(); ++i) l += (p[i] - p[i - 1]).norm();
  return l;
}

double depth(const ScriptReader& r, double otherwise) { return r.real("depth_mm", otherwise, 0, L::depth_mm, true); }

ScriptHeader read_header(std::string_view text, const std::string& name, int line) {
  const ScriptReader r(text, name, line);
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
  const ScriptReader r(json_line, name, line);
  if (r.has("limberg_script")) r.fail("a second header; expected an action");
  const std::string a = r.text("action", true, 100);
  const std::string where = "the action " + ScriptReader::shown(a);
  if (a == "incise" && r.has("stroke")) {
    r.only({"action", "stroke", "path", "depth_mm", "angle_deg", "more"}, where);
    const InciseMore d;
    return InciseMore{int(r.integer("stroke", 1, L::max_id)), r.path("path", 1), depth(r, d.depth_mm),
                      r.real("angle_deg", d.angle_deg, kLeast_deg, kMost_deg, false), !r.boolean("more", false)};
  }
  if (a == "incise") {
    r.only({"action", "path", "depth_mm", "angle_deg", "spline"}, where);
    const Incise d;
    return Incise{r.path("path", 2), depth(r, d.depth_mm),
                  r.real("angle_deg", d.angle_deg, kLeast_deg, kMost_deg, false), r.boolean("spline", false)};
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
    return MoveHook{int(r.integer("id", 1, L::max_id)), r.place("to"),
                    r.real("seconds", MoveHook{}.seconds, 0, L::seconds, false)};
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
      r.fail("\"spacing_mm\" " + ScriptReader::number(row.spacing_mm) + " on a path of " +
             ScriptReader::number(longer) + " mm makes too many sutures; expected at most " +
             std::to_string(L::row_sutures));
    if (row.slack_mm > 0 && !row.running) r.fail("\"slack_mm\" without \"running\":true; expected a running suture");
    return row;
  }
  if (a == "suture_corner") {
    r.only({"action", "tip", "a", "b", "depth_mm"}, where);
    return SutureCorner{r.point("tip"), r.point("a"), r.point("b"),
                        r.real("depth_mm", SutureCorner{}.depth_mm, 0, L::depth_mm, true)};
  }
  if (a == "suture_between") {
    r.only({"action", "from", "to", "spacing_mm", "depth_mm", "running", "slack_mm"}, where);
    const SutureBetween between{r.stitch("from"), r.stitch("to"), kind()};
    if (between.row.slack_mm > 0 && !between.row.running)
      r.fail("\"slack_mm\" without \"running\":true; expected a running suture");
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
  if (is_head_action(a)) return read_head_action(r, a, where);
  r.fail("unknown action \"" + ScriptReader::shown(a) +
         "\"; expected excise, incise, undermine, hook, move, release, suture, suture_row, suture_corner, "
         "suture_between, cut_suture, undo, redo, stage or wait, or of a head: osteotomy, move_fragment, grab, drag, "
         "let_go, plate, unplate, join, sort, connect_tissue, landmark or superpose");
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
  if (!in)
    throw InputError(path, 0,
                     std::string("cannot be opened (") + std::strerror(errno) + "); expected an operation script");
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
  static constexpr const char* names[] = {"incise",  "incise",        "undermine",      "excise",     "hook", "move",
                                          "release", "suture",        "suture_row",     "undo",       "redo", "stage",
                                          "wait",    "suture_corner", "suture_between", "cut_suture", ""};
  static_assert(std::variant_size_v<Command> == std::size(names));
  if (const auto* head = std::get_if<HeadCommand>(&command)) return head_action_name(*head);
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
  if (const auto* head = std::get_if<HeadCommand>(&command)) return head_json_line(*head);
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
    throw InputError(path, 0,
                     std::string("cannot be written (") + std::strerror(errno) + "); expected a writable place");
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
    throw InputError(path_, 0,
                     std::string("cannot be written to (") + std::strerror(errno) + "); expected room on the disk");
}

}  // namespace limberg
