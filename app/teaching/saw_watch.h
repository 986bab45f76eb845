#pragma once
// The saw against the plan, while a hand holds it: how far the tip is from the planned cut and how far the blade leans
// from it; a plane through picked places before it is sawn; what a saw must not come near to. Places in mm in the frame
// of the head, on the bones where they were at first.
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/assembly/cut_distance.h"
#include "app/teaching/against_plan.h"
#include "sim/commands/head_command.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// How far off a saw may be while it is led, and a plane that was sawn.
inline constexpr double kSawBeside_mm = 4, kSawLeans_deg = 10;

/// The plane of the planned cut nearest to a place, as its normal; nothing for a contour.
std::optional<Vec3> plane_near(const HeadCommand& planned, const Vec3& place_mm);

/// Of the surface, the fragment that a cut is meant for; -1: there is no bone.
int32_t bone_meant(const SurfaceTopology& surface, const HeadCommand& cut);
/// Where a cut runs on that bone: places one mm apart, of all its lines.
std::vector<Vec3> line_on_bone(const SurfaceTopology& surface, const HeadCommand& cut);
/// Of all planned cuts of bone, once the patient that they are for is seen.
void find_lines_on_bone(LessonPlan& plan, const SurfaceTopology& surface);
/// From the planned cut, where it runs on bone if that is known, to a place.
std::optional<Vec3> beside_line(const PlannedAct& planned, const Vec3& place_mm);

/// What the hand does with the saw.
struct SawSeen {
  Vec3 tip_mm = Vec3::Zero(), shaft = Vec3::UnitZ();
  std::vector<Vec3> sawn_mm;  // of the stroke, while it is pressed
};
/// The next planned cut that the saw is meant for: of those that are open the nearest, no farther than 40 mm.
const PlannedAct* sawn_for(const LessonPlan& plan, std::span<const size_t> open, const Vec3& tip_mm);
std::vector<LiveRow> saw_rows(const LessonPlan& plan, const PlannedAct& planned, const SawSeen& saw);
/// "The saw is 6 mm above the line that is drawn: bring it down." Empty: it is near enough.
std::string saw_word(const PlannedAct& planned, const Vec3& tip_mm, const Words& words = {});

/// A plane through three picked places against the planned cut, before it is sawn. Empty: no plane is planned.
std::vector<LiveRow> plane_rows(const HeadCommand& planned, const std::array<Vec3, 3>& picked_mm,
                                const Words& words = {});

/// A cut of bone by a plane or planes against the planned one. Nothing: it is no attempt at it.
std::optional<Offs> plane_against(const HeadCommand& want, const HeadCommand& got, const Words& words = {});

}  // namespace limberg
