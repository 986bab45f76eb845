#pragma once
// A lesson: what to do, where, how well, and hints; and what a session came to by it.
//
//   lesson = "Limberg's flap"               its title
//   goal = "..."                            in a sentence or two
//   scene = "rhomboid"                      name of a shipped scene or path of a scene file
//   hints = ["...", "..."]
//   steps = ["...", "..."]                  in their order
//   [procedure]                             of skin
//   name = "rhomboid"                       of the repertoire (limberg procedure)
//   at_mm = [0, 0], turn_deg, mirror        where it is laid
//   [procedure.values]  side_mm = 20        parameters that differ from the procedure's own
//   [bone]                                  of bones: bone_lesson.h; one of the two at least
//   by_script = true                        or neither: the plan is the lesson's script, no figure of the repertoire;
//                                           corners are then compared act by act (app/teaching), and not judged
//   [tolerance]                             at most; only those that are given are judged, and pieces_wrong of bones
//   corner_mm, angle_deg, limb_percent      of the cuts against the plan (design_error)
//   gap_mm, suture_N, suture_peak_N, closure_N, dog_ear_mm, wound_gape_mm, step_off_mm, landmark_mm, waste_mm2
//                                           of result.json's metrics; gap_mm: of the bites of a stitch, wound_gape_mm:
//                                           of the edge between stitches, 95 % of it
//   pieces_wrong, piece_mm, piece_deg, sideways_mm, forwards_mm, upwards_mm, stays_mm, midline_mm, osteotomy_gap_mm,
//   osteotomy_overlap_mm, too_near_mm, bone_outside_mm, cephalometry_mm, cephalometry_deg      of bones (bone_lesson.h)
//   time_s, path_mm, movements, undos       of the hand; judged where there was one
//   [landmarks]  ala = [x, y]               places that must not be drawn away
//   [[step]], [[limit]]                     what is said at each step, what is not to be crossed (lesson_steps.h)
//
// Reading is strict, as of scenes. There is no grade: each tolerance is met or not, with its value beside it.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/assembly/bone_lesson.h"
#include "app/assembly/lesson_steps.h"
#include "sim/measure/metrics.h"

namespace limberg {

struct Lesson {
  std::string file, title, goal, scene;
  std::vector<std::string> steps, hints;
  std::optional<PlannedProcedure> plan;  // of skin
  bool by_script = false;                // or of its script alone
  std::optional<BonePlan> bone;
  std::vector<std::pair<std::string, double>> tolerances;  // by name, in the file's order of the list above
  std::vector<Landmark> landmarks;
  LessonWords words;
};

/// Is this the text of one?
bool looks_like_lesson(std::string_view text);
Lesson parse_lesson(const std::string& text, const std::string& file);
std::string find_lesson(const std::string& name_or_path);
/// A path, or NAME for app/lessons/NAME.toml. InputError that lists the names to be had.
Lesson open_lesson(const std::string& name_or_path);

/// A line that says so when a lesson judges what was done in another
/// scene than its own, by the scene's name and file; empty where it fits.
std::string made_for_another(const Lesson& lesson, const std::string& scene_name, const std::string& scene_path);

/// A planned corner without a drawn one near enough.
struct MissingCorner {
  bool outline = false;  // of an excision; otherwise of an incision
  ChartPoint planned{0, 0};
  std::optional<ChartPoint> nearest;  // drawn, of the same kind of cut; nothing: there is no such cut
};
/// How far the cuts lie from the plan. Corners of what was drawn are those that matter by more than 1.5 mm (plan.h).
struct DesignError {
  double corner_mean_mm = 0, corner_max_mm = 0;  // planned corner to the nearest drawn one of the same kind of cut
  double angle_max_deg = 0;            // at planned inner corners of cuts, against the drawn corner nearest to them
  double limb_max_percent = 0;         // length between neighbouring planned corners, against that between theirs
  int corners = 0;                     // planned
  std::vector<MissingCorner> missing;  // of them, without a drawn one within 10 mm
};
/// Nothing when nothing was cut.
std::optional<DesignError> design_error(const PlanOnSkin& plan, std::span<const Command> script);

/// One tolerance and what it came to.
struct Judgement {
  std::string name, unit;
  double limit = 0;
  std::optional<double> value;  // nothing: it could not be measured
  std::string why;              // not: what was looked for, and what was found; otherwise where, or empty
  bool met = false;
};
std::vector<Judgement> judge(const Lesson& lesson, const LessonValues& values);
/// What hangs on acts that the program has shown is not judged as the learner's: its value goes, and `why` says so.
void withhold_shown(std::vector<Judgement>& judged, std::span<const Command> script);
/// "Corners of the cuts" for corner_mm.
std::string words_of_tolerance(const std::string& name);
/// The most that is to be done better, worst first, at most `most` sentences. Empty: all is met.
std::vector<std::string> to_do_better(std::span<const Judgement> judged, size_t most = 3);
LessonValues lesson_values(const Metrics& metrics, const std::optional<DesignError>& error);
/// Of a result.json's metrics by their names there: only what is figures of the skin.
LessonValues values_of_metrics(const std::map<std::string, double>& metrics);

}  // namespace limberg
