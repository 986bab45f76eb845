#pragma once
// One act against the plan's: what is off, by how much, and a gentle word that says what to do.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/teaching/lesson_plan.h"

namespace limberg {

/// One thing that is looked at: its value, what was planned, how much may be off.
struct Off {
  enum Kind : uint8_t { length, line, corner, angle, depth, blade, area, place, way, spacing, pieces };
  Kind kind = length;
  double value = 0;   // how far off
  double limit = 1;   // how far it may be off
  std::string words;  // "8 mm too short, towards F"
  double share() const { return value / limit; }
};

/// All that was looked at, worst first; empty: nothing can be compared.
using Offs = std::vector<Off>;
inline bool within(const Offs& offs) { return offs.empty() || offs.front().share() <= 1; }
/// What is off, at most two things, as one sentence; empty where all is within its limit.
std::string gentle_word(const Offs& offs);

/// Nothing: the act is no attempt at this planned one.
std::optional<Offs> against(const LessonPlan& plan, const PlannedAct& planned, const Command& done);

/// A stroke while it is drawn. Depth and blade are those of the tool; nothing: not known.
struct LiveStroke {
  std::vector<ChartPoint> path;
  std::optional<double> depth_mm, angle_deg;
};
struct LiveRow {
  std::string name, words;  // "length", "12 of 40 mm"
  double share = 0;         // of what may be off; more than 1: off
};
/// Length, line, direction, depth and blade of a stroke against the planned act. Empty: it is not drawn.
std::vector<LiveRow> live_rows(const LessonPlan& plan, const PlannedAct& planned, const LiveStroke& stroke);
/// The cut of this kind that the stroke is meant to be: of those that are open, the nearest; null: none.
const PlannedAct* meant(const LessonPlan& plan, std::span<const size_t> open, const Command& like,
                        const LiveStroke& stroke);

/// The stroke of a planned act, if it is drawn: an incision's path, or an outline.
struct DrawnLine {
  std::vector<ChartPoint> path;
  bool closed = false;
  double depth_mm = 0, angle_deg = 90;
};
std::optional<DrawnLine> drawn_line(const Command& command);
/// From a place to a line, and the place on it.
double distance_to_line(const std::vector<ChartPoint>& path, bool closed, const ChartPoint& p,
                        ChartPoint* on = nullptr);

}  // namespace limberg
