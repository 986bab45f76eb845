#pragma once
// One student's acts along the plan of the lesson: how long each step took, what of it was done and how far off, what
// came out of its order, what the plan does not have.
//
// The time before an act counts for the step of the planned act that it is an attempt at, in whatever order they come;
// so the times of all steps, of acts elsewhere, of acts taken back and of what came after the last act add up to the
// session. Of a result without the times of acts, a step has the time between the stages of its name and before it.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/class/member.h"
#include "app/teaching/progress.h"

namespace limberg {

struct StepWalk {
  std::string name;
  Maybe time_s;
  int planned = 0, done = 0;  // acts; passed over counts as done (hooks)
  int shown = 0;              // of those done: by the program
  double share = 0;           // the worst of what is off but hooks, of what may be; more than 1: off
  std::string off;            // in words; empty: as planned
  Maybe sawn;                 // of a cut of bone by several lines that are not all of it: their share
};

struct ClassWalk {
  std::vector<StepWalk> steps;
  Maybe elsewhere_s, taken_back_s, afterwards_s;
  int out_of_order = 0;  // own cuts, stitches and acts on bone that came while such a one of an earlier step was open
  int elsewhere = 0;     // acts that stand and are of no plan
  int shown = 0;         // acts that the program has shown
};

/// The acts of a result; lines that are no command are passed over, with their times.
struct TimedActs {
  std::vector<Command> command;
  std::vector<double> at_s;  // empty: not known
};
TimedActs acts_of(const ClassMember& member);

/// Of a plan with bone: find_lines_on_bone (saw_watch.h) first, else lines by hand are judged by the planes alone.
ClassWalk walk_of(const LessonPlan& plan, const ClassMember& member);

}  // namespace limberg
