#include "app/assembly/repro.h"

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>

#include "app/result/json_nesting.h"
#include "app/result/result.h"
#include "sim/base/error.h"
#include "sim/commands/kinds.h"

namespace limberg {

namespace {

using Json = nlohmann::json;

[[noreturn]] void fail(const std::string& file, const std::string& what) { throw InputError(file, 0, what); }

std::string words(const Json& j, const char* key, const std::string& file) {
  const auto it = j.find(key);
  if (it == j.end() || !it->is_string()) fail(file, std::string("\"") + key + "\" is missing or no text");
  return it->get<std::string>();
}

uint64_t hash(const Json& j, const char* key, const std::string& file) {
  const std::string s = words(j, key, file);
  if (s.size() != 16 || s.find_first_not_of("0123456789abcdef") != std::string::npos)
    fail(file, std::string("\"") + key + "\" is no hash; expected 16 hexadecimal digits");
  return std::strtoull(s.c_str(), nullptr, 16);
}

Command command(const Json& j, const std::string& file, int number) {
  if (!j.is_object())
    fail(file, "command " + std::to_string(number) + " is no object; expected an action as in a script");
  return parse_command(j.dump(-1, ' ', false, Json::error_handler_t::replace), file, number);
}

}  // namespace

std::string to_text(const Repro& r) {
  nlohmann::ordered_json j = nlohmann::ordered_json::object();  // what it is stands first
  j["limberg_repro"] = 1;
  j["program"] = r.program;
  j["scene"] = r.scene;
  j["scene_hash"] = hex(r.scene_hash);
  j["cell_mm"] = r.cell_mm;
  j["seed"] = r.seed;
  j["topology_hash"] = hex(r.topology_hash);
  j["reason"] = r.reason;
  j["commands"] = nlohmann::ordered_json::array();
  for (const Command& c : r.commands) j["commands"].push_back(nlohmann::ordered_json::parse(to_json_line(c)));
  j["refused"] = nlohmann::ordered_json::parse(to_json_line(r.refused));
  // One command a line, so that it can be read.
  std::string text = "{\n";
  for (const auto& [key, value] : j.items()) {
    if (text.size() > 2) text += ",\n";
    text += " \"" + key + "\": ";
    if (key != "commands") {
      text += value.dump(-1, ' ', false, Json::error_handler_t::replace);
      continue;
    }
    text += "[";
    for (size_t i = 0; i < value.size(); ++i)
      text += (i ? ",\n  " : "\n  ") + value[i].dump(-1, ' ', false, Json::error_handler_t::replace);
    text += "]";
  }
  return text + "\n}\n";
}

bool looks_like_repro(std::string_view text) {
  const size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && text[first] == '{' &&
         text.substr(first, 64).find("\"limberg_repro\"") != std::string_view::npos;
}

Repro parse_repro(const std::string& text, const std::string& file) {
  if (text.size() > ScriptLimits::file_bytes)
    fail(file, "is larger than " + std::to_string(ScriptLimits::file_bytes >> 20) + " MB");
  if (json_nesting(text) > 16) fail(file, "brackets are nested too deeply; expected a repro file");
  const Json j = Json::parse(text, nullptr, false);
  if (!j.is_object()) fail(file, "is broken JSON; expected a repro file");
  for (const auto& [key, value] : j.items()) {
    bool known = false;
    for (const char* k : {"limberg_repro", "program", "scene", "scene_hash", "cell_mm", "seed", "topology_hash",
                          "reason", "commands", "refused"})
      known = known || key == k;
    if (!known) fail(file, "unknown key \"" + key.substr(0, 40) + "\"; expected a repro file as limberg writes it");
  }
  if (!j.contains("limberg_repro") || !j["limberg_repro"].is_number_integer() || j["limberg_repro"] != 1)
    fail(file, "\"limberg_repro\" is not 1; expected a file of version 1");
  Repro r;
  r.program = words(j, "program", file);
  r.scene = words(j, "scene", file);
  r.reason = words(j, "reason", file);
  r.scene_hash = hash(j, "scene_hash", file);
  r.topology_hash = hash(j, "topology_hash", file);
  if (!j.contains("cell_mm") || !j["cell_mm"].is_number()) fail(file, "\"cell_mm\" is missing or no number");
  r.cell_mm = j["cell_mm"].get<double>();
  if (!(r.cell_mm >= 0.2 && r.cell_mm <= 100)) fail(file, "\"cell_mm\" is out of range; expected 0.2 to 100");
  if (!j.contains("seed") || !j["seed"].is_number_unsigned()) fail(file, "\"seed\" is missing or no whole number");
  r.seed = j["seed"].get<uint64_t>();
  if (!j.contains("commands") || !j["commands"].is_array()) fail(file, "\"commands\" is missing or no list");
  if (j["commands"].size() > ScriptLimits::commands) fail(file, "holds too many commands");
  int n = 0;
  for (const Json& c : j["commands"]) r.commands.push_back(command(c, file, ++n));
  if (!j.contains("refused")) fail(file, "\"refused\" is missing; expected the command that was refused");
  r.refused = command(j["refused"], file, ++n);
  return r;
}

Script script_of(const Repro& r, const std::string& file) {
  Script s;
  s.name = file;
  s.header.scene = r.scene;
  s.header.note = "a cut that was refused: " + r.reason;
  int n = 0;
  for (const Command& c : r.commands) s.lines.push_back({++n, c});
  s.lines.push_back({++n, r.refused});
  return s;
}

ReproWriter::ReproWriter(std::string dir, Repro blank) : dir_(std::move(dir)), repro_(std::move(blank)) {}

void ReproWriter::done(const Command& c) {
  if (dir_.empty() || leaves_patient(c)) return;
  repro_.commands.push_back(c);
}

std::string ReproWriter::refused(const Command& c, const std::string& reason, uint64_t topology_hash) {
  if (dir_.empty() || !cuts_skin(c) || !error_.empty() || int(files_.size()) >= kMost) return {};
  if (const auto* piece = std::get_if<InciseMore>(&c)) {
    if (piece->stroke == last_stroke_) return {};  // the rest of a stroke that has stopped
    last_stroke_ = piece->stroke;
  }
  std::string text;
  try {
    repro_.refused = c;
    repro_.reason = reason;
    repro_.topology_hash = topology_hash;
    text = to_text(repro_);
  } catch (const std::exception&) {
    return {};  // a command with numbers that no script can hold
  }
  for (int n = 1; n < 100'000; ++n) {
    const std::string name = dir_ + "/repro-" + std::to_string(n) + ".json";
    std::FILE* f = std::fopen(name.c_str(), "wbx");  // never an existing file
    if (!f && errno == EEXIST) continue;
    const bool written = f && std::fwrite(text.data(), 1, text.size(), f) == text.size();
    const int why = errno;
    if (!f || std::fclose(f) != 0 || !written) {
      error_ = name + ": cannot be written (" + std::strerror(why) + ")";
      if (f) std::remove(name.c_str());  // none is better than a part
      return {};
    }
    files_.push_back(name);
    return name;
  }
  return {};
}

}  // namespace limberg
