#pragma once
// What is wrong with one of a class, and what a class gets wrong most: counts and values, no grade and no rank. Each
// thing that is looked at has a key, so that the same thing of all students is one line of the summary.
//
//   tolerances of the lesson; steps that were not done, or done elsewhere or otherwise than planned; acts out of order,
//   elsewhere, refused, taken back; presses that came to nothing; tissue inside out; a patient not at rest; stitches
//   that pull too hard
//
// What the program has shown is nobody's fault and nobody's merit: it is not judged.
#include <span>
#include <string>
#include <vector>

#include "app/class/walk.h"

namespace limberg {

struct Finding {
  std::string key;    // "tolerance/corner_mm"
  std::string what;   // "Corners of the cuts"
  std::string words;  // of this student: "4.1 mm, at most 2"
  std::string unit;
  Maybe value, limit;
  bool wrong = false;
  bool judged = true;  // false: there was nothing to judge, and it is neither right nor wrong
};

/// Of one that was looked at; in the order above, wrong or not.
std::vector<Finding> findings_of(const ClassMember& member, const ClassWalk& walk);

struct ClassFinding {
  std::string key, what, unit, advice;
  int wrong = 0, judged = 0;
  Maybe median, limit;  // of those who have it wrong
  Maybe expert;
  bool expert_wrong = false;
  double share() const { return judged > 0 ? double(wrong) / judged : 0; }
};

/// Of all students together, what most have wrong first; nothing that nobody has. `expert`: its findings, or none.
std::vector<ClassFinding> class_findings(std::span<const std::vector<Finding>> students,
                                         std::span<const Finding> expert);

/// Not a number where there is none.
double median_of(std::vector<double> values);

}  // namespace limberg
