#pragma once
// The part of a lesson that is about bones: which pieces there should be, where each should have gone, what should have
// stayed; and how far a head is from that.
//
//   [bone]
//   fragments = 3                         how many there are at the end; left out: any number
//   stays = ["N", "Or_R", ...]            landmarks on bone that should lie where they lay
//   [[bone.piece]]
//   name = "maxilla"
//   holds = ["A", "ANS", "PNS", "Is"]     landmarks that lie on it, all on one fragment
//   apart_from = ["N", "Or_R"]            landmarks that do not
//   move_mm = [0, 5, 0]                   x right, y forwards, z up
//   turn_deg = [-3, 0, 0]                 its angle is the vector's length
//   about = ["Co_R", "Co_L"]              the middle of these is turned about; left out: that of `holds`
//   [bone.cephalometry]
//   overjet = 2.3                         what a figure of cephalometry.h should come to
//
// Everything is measured on the landmarks of the scene. One that the operation itself placed anew counts for nothing:
// what needs it is not measured.
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/assembly/lesson_steps.h"
#include "sim/commands/command.h"
#include "sim/measure/bone_outside.h"
#include "sim/skull/head/head.h"

namespace limberg {

struct PlannedPiece {
  std::string name;
  std::vector<std::string> holds, apart_from, about;
  RigidMove move;  // about_mm is left out
};
struct BonePlan {
  std::vector<PlannedPiece> pieces;
  std::vector<std::string> stays;
  std::vector<std::pair<std::string, double>> cephalometry;
  std::optional<int> fragments;
};

/// What was measured, and why the rest was not, by the names of tolerances.
struct LessonValues {
  std::map<std::string, double> value;
  std::map<std::string, std::string> why_not, place;  // place: where the value was found, in words
};

/// Names of a plan that a head with these landmarks lacks, in words; empty: none.
std::string plan_lacks(const BonePlan& plan, std::span<const HeadLandmark> landmarks);

/// pieces_wrong           landmarks of `holds` that do not lie on their piece, of `apart_from` that do, and fragments
///                        too many or too few
/// piece_mm               from a landmark of a piece to where it should be, the farthest
/// piece_deg              between the turn of a piece (of its landmarks, by least squares) and the one that was meant
/// sideways_mm, forwards_mm, upwards_mm   of the middle of a piece's landmarks, either way, the farthest of all pieces
/// stays_mm               how far a landmark of `stays` has moved, the farthest
/// midline_mm             of a piece's landmarks in the middle, from the plane of symmetry of what stays in the cranium
/// osteotomy_gap_mm       mean gap between a piece and what it was cut from, the widest of all
/// osteotomy_overlap_mm   how deep a piece lies in other bone
/// too_near_mm            by how much a cut comes nearer to a [[limit]] on bone than the lesson keeps, the worst
/// bone_outside_mm        how far bone stands out of the skin
/// cephalometry_mm, cephalometry_deg      from what [bone.cephalometry] asks, the farthest
/// `done`: what was carried out; cuts that were taken back do not count.
LessonValues bone_values(const BonePlan& plan, const Head& head, const std::optional<BoneOutside>& outside,
                         std::span<const Command> done, std::span<const SafeLimit> limits);

}  // namespace limberg
