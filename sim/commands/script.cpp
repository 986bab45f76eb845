#include "sim/commands/script.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "sim/commands/script_reader.h"

namespace limberg {
namespace {

using Json = nlohmann::ordered_json;
using L = ScriptLimits;
ScriptHeader read_header(std::string_view text, const std::string& name, int line) {
  const ScriptReader r(text, name, line);
  if (!r.has("limberg_script"))
    r.fail("the first line is not a script's header; expected {\"limberg_script\":1,\"scene\":\"NAME\"}");
  r.only({"limberg_script", "scene", "note", "landmarks", "plan"}, "the header");
  r.integer("limberg_script", ScriptHeader::version, ScriptHeader::version);
  return {r.text("scene", true, 1000), r.text("note", false, 10'000), r.landmarks("landmarks"), r.plan("plan")};
}

Json json(const ChartPoint& p) { return Json::array({p.x(), p.y()}); }

}  // namespace

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
  return parse_script(read_whole_file(path, L::file_bytes, "an operation script"), path);
}

std::string to_json_line(const ScriptHeader& h) {
  Json j = Json::object();  // not made by its first entry: short of memory that would end in a crash
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
