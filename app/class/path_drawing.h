#pragma once
// The way of a tool over the patient, drawn as on paper: the plan's cuts with their letters, the expert's way in grey,
// the student's in colours of what the tool did, crosses where a press came to nothing. All drawings of a class have
// one frame, so that they can be laid beside each other.
#include <string>
#include <vector>

#include "app/class/member.h"
#include "app/teaching/lesson_plan.h"

namespace limberg {

struct DrawnFrame {
  double x0_mm = -50, y0_mm = -50, x1_mm = 50, y1_mm = 50;
};

/// What holds the plan, and of every path all but the outermost hundredth; at most 400 mm wide.
DrawnFrame frame_of(const LessonPlan& plan, const std::vector<const ClassMember*>& all);

/// SVG on white. `expert` null: none.
std::string path_svg(const DrawnFrame& frame, const LessonPlan& plan, const ClassMember& student,
                     const ClassMember* expert, const std::string& title);

/// What the colours mean, in words.
std::string path_legend();

/// The time of each step as one bar a student, all on one scale.
struct StepTimes {
  std::string name;
  std::vector<std::pair<std::string, double>> parts;  // in s, in their order
};
std::string step_times_svg(const std::vector<StepTimes>& rows, const std::string& description);

}  // namespace limberg
