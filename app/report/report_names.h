#pragma once
// What a run leaves in its folder, and the names in result.json that the report reads (as structs: run_result.h and
// schema.h in app/result) beside those of the contract
// (`limberg`, `command`, `scene`, `machine`, `ok`, `metrics`, `device`, `solver`, `render`, ...). Every one is
// optional.
//
//   DIR/result.json
//   DIR/stages/NN-name.png     one picture per stage, NN = 00, 01, ... in order
//   DIR/tension.png            tension map at the end
//   DIR/height.png, DIR/moved.png, DIR/risk.png   what stands up, how far skin was moved, perfusion risk: on the skin
//   at the end
//   DIR/perfusion.svg, DIR/stress.svg   maps on the chart at rest
//   DIR/ranking.svg            designs that were compared
//   DIR/overview.png           picture at the end, shown first
//   DIR/model.glb              the operation to be turned and played in the page (app/export/page_model.h)
//   DIR/report.html            written by the report
//
//   "stages":      [{"name", "picture" (relative to DIR), "t_s", "caption", "residual", "sutures", "pieces"}]
//                  no caption: what the script did since the stage before
//                  absent: the pictures found in DIR/stages are shown in order of their names
//   "pictures":    {"overview": "overview.png", "tension": "tension.png"}   absent: those names, where they exist
//   "gallery":     [{"picture", "caption"}]  more pictures, side by side; those that are not there are left out
//   "series":      {"t_s": [...], "residual": [...], "distance_mm": [...]}  of the solver, one entry a step or thinner;
//                  null where a value is missing
//   "balance":     {"hooks_N": [x,y,z], "loads_N": [x,y,z], "supports_N": [x,y,z], "sum_N": [x,y,z], "relative": r}
//                  forces on the tissue at the end; loads_N: weight and loads, of scenes with such;
//                  relative = |sum| / sum of magnitudes
//   "metrics":     also "removed_volume_mm3", "initial_volume_mm3"
//   "convergence": [{"cell_mm", "nodes", "closure_force_N", "suture_gap_max_mm", "dog_ear_mm", "residual", "solve_ms"}]
//   "discretisation": {NAME: {"value", "error", "order", "extrapolated", "asymptotic", "says"}}   NAME: one of
//   "metrics"; of the
//                  finest lattice of "convergence"
//   "distance_mm" (or "solver": {"distance_mm"}): estimated distance to equilibrium at the end
//   "study", "about", "columns": [name], "rows": [{name: value}], "bars": [{"name", "value", "bar", "larger_is_better",
//   "pass",
//                  "source"}], "charts": [{"title", "description", "x", "y", "x_log", "y_log" (absent: even), "series":
//                  [{"name", "markers", "x": [...], "y": [...]}]}]
//                  of a study; rows are shown in the order of the columns
//   "charts" and "tables": [{"title", "about", "columns": [name], "rows": [[text]]}] of other commands too
//   "series": also "closure_N", "suture_max_N" of a session, over t_s; "unsettled": how many are not drawn
//   "exercise":    {name: number, "design": {name: number}}; "lesson": {"title", "goal", "tolerances": [{"name",
//   "unit", "limit",
//                  "value" (absent: not measured, "why"), "met"}], "hints": [...]}
//   "verdict":     [{"what", "value", "unit", "limit", "place", "light" (bad, warn, told, good), "source"}]  bad first
//   "solver":      also "hand" ("waits", "slowed" or "live") and "waited_ms": for so long the patient held the clock;
//                  "slowed_ms" and "slowest_pace": of slow motion, time added and the pace over the slowest second
//   "script":      ["{...}", ...] the operation, one JSON line each (strings or objects)
//   "reproduce":   "limberg replay ..."  the command that makes this result again
//   "damage":      {...}  what was lost of a damaged recording: shown as a notice, as it stands
//   "scene_title", "scene_note": words about the scene
#include <fmt/format.h>

#include <string>

namespace limberg::report_names {

inline constexpr const char* result = "result.json";
inline constexpr const char* html = "report.html";
inline constexpr const char* stages_dir = "stages";
inline constexpr const char* overview = "overview.png";
inline constexpr const char* tension = "tension.png";
inline constexpr const char* perfusion = "perfusion.svg";
inline constexpr const char* stress = "stress.svg";
inline constexpr const char* height = "height.png";
inline constexpr const char* moved = "moved.png";
inline constexpr const char* risk = "risk.png";
inline constexpr const char* model = "model.glb";
inline constexpr const char* ranking = "ranking.svg";

/// "stages/03-flap-cut.png": letters and digits kept (lower case), everything else becomes one dash.
inline std::string stage_picture(int number, const std::string& name) {
  std::string slug;
  for (const char c : name) {
    const bool upper = c >= 'A' && c <= 'Z', plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    if (upper || plain)
      slug += upper ? char(c - 'A' + 'a') : c;
    else if (!slug.empty() && slug.back() != '-')
      slug += '-';
    if (slug.size() >= 48) break;
  }
  while (!slug.empty() && slug.back() == '-') slug.pop_back();
  const std::string head = fmt::format("{:02}", number);
  return std::string(stages_dir) + "/" + head + (slug.empty() ? "" : "-") + slug + ".png";
}

}  // namespace limberg::report_names
