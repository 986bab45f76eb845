#pragma once
// What was planned against what was achieved: the fragments of a plan (moment.h) laid upon the bone of a later scan.
//
//   skull       the fixed fragments are laid upon the later bone, from anywhere (trimmed ICP): so both are in one frame
//   fragment    each that was to be moved is laid upon it alone, from where the plan has it then
//   difference  how far it lies from there, in the head's frame: its middle's shift and its turn
#include <string>
#include <vector>

#include "sim/base/workers.h"
#include "sim/imaging/register/superposition.h"

namespace limberg {

struct PlannedFragment {
  std::string name;
  Surface surface;  // as it was planned to lie, in the head's frame
  bool fixed = false;
  Vec3 planned_mm = Vec3::Zero();  // of its middle: how far the plan moves it
  double planned_deg = 0;          // and turns it
};

struct AchievedFragment {
  std::string name;
  Vec3 off_mm = Vec3::Zero();  // of its middle: right, forwards, up of where it was planned
  double off_deg = 0;
  double rms_mm = 0;   // of the pairs that ICP kept
  std::string reason;  // why it could not be found; empty: it was
};

struct Achieved {
  std::string reason;  // why the skull could not be laid upon the later bone; the rest is empty then
  double skull_rms_mm = 0;
  std::vector<AchievedFragment> fragments;  // those that were to be moved
};

/// `moved_mm`: fragments no place of which the plan moves as far are taken for such that stay.
Achieved planned_against_achieved(const std::vector<PlannedFragment>& plan, const Surface& later, double moved_mm,
                                  Workers& workers);

/// The plan that `export` has left in a folder, its surfaces read from there in the head's frame. InputError: there is
/// none, or it names files that are not there.
std::vector<PlannedFragment> read_plan(const std::string& folder);

}  // namespace limberg
