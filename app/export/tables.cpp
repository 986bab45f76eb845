#include "app/export/tables.h"

#include <fmt/format.h>

#include "devices/sample.h"
#include "sim/measure/table.h"

namespace limberg {

namespace {

/// Quoted where it must be (RFC 4180).
std::string csv_word(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
}

const char* tool_word(int32_t tool) {
  static const char* const kWords[] = {"none",   "scalpel",    "undermine", "excise", "hook",
                                       "suture", "suture row", "scissors",  "saw",    "grab"};
  return tool >= 0 && tool < int32_t(std::size(kWords)) ? kWords[tool] : "none";
}

}  // namespace

void ExportTables::moment(double t_s, const std::string& name, const std::string& state_hash, const Metrics& m) {
  if (measures_.empty()) {
    measures_ = "moment,t_s,state_hash";
    for (const Measure& x : measure_table())
      if (x.value) measures_ += std::string(",") + x.name;
    measures_ += "\n";
  }
  measures_ += fmt::format("{},{},{}", csv_word(name), t_s, state_hash);
  for (const Measure& x : measure_table())
    if (x.value) {
      const std::optional<double> v = x.value(m);
      measures_ += v ? fmt::format(",{}", *v) : ",";
    }
  measures_ += "\n";
}

void ExportTables::forces(double t_s, const std::string& name, const Snapshot& s) {
  if (forces_.empty()) forces_ = "t_s,moment,kind,id,thread,force_N,gap_mm,x_mm,y_mm,z_mm\n";
  for (const SutureState& k : s.sutures) {
    const Vec3f at = (k.a_mm + k.b_mm) / 2;
    forces_ += fmt::format("{},{},stitch,{},{},{},{},{},{},{}\n", t_s, csv_word(name), k.id, k.thread, k.force_N,
                           k.gap_mm, at.x(), at.y(), at.z());
  }
  for (const HookState& h : s.hooks)
    forces_ += fmt::format("{},{},hook,{},0,{},{},{},{},{}\n", t_s, csv_word(name), h.id, h.force_N.norm(),
                           (h.handle_mm - h.at_mm).norm(), h.at_mm.x(), h.at_mm.y(), h.at_mm.z());
}

void ExportTables::hands(double t_s, const HandState& h) {
  if (hands_.empty()) hands_ = "t_s,hand,tool,pressed,x_mm,y_mm,z_mm,shaft_x,shaft_y,shaft_z\n";
  if (const ToolState& t = h.tool; t.valid)
    hands_ += fmt::format("{},stylus,{},{},{},{},{},{},{},{}\n", t_s, tool_word(t.tool), t.pressed, t.tip_mm[0],
                          t.tip_mm[1], t.tip_mm[2], t.shaft[0], t.shaft[1], t.shaft[2]);
  for (const auto& [name, g] : {std::pair("glove", &h.glove), std::pair("other glove", &h.other_glove)})
    if (g->valid)
      hands_ += fmt::format("{},{},none,{},{},{},{},{},{},{}\n", t_s, name, g->closed, g->centre_mm[0], g->centre_mm[1],
                            g->centre_mm[2], g->pointing[0], g->pointing[1], g->pointing[2]);
}

}  // namespace limberg
