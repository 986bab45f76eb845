#include "app/teaching/why_missed.h"

#include <fmt/format.h>

#include "devices/sample.h"
#include "devices/surface_index.h"

namespace limberg {
namespace {

/// What lies under the tip: skin, the bed or wall of a wound, or nothing of the patient within reach.
enum class Under { skin, wound, nothing };
Under under(const MissedPress& m, const Snapshot& s) {
  constexpr double kNearFlesh_mm = 6;
  if (!has_surface(s) || s.topology->organ_of(0) != Organ::flesh) return Under::nothing;
  const Vec3 tip(m.tip_mm[0], m.tip_mm[1], m.tip_mm[2]);
  const SkinTouch flesh = SurfaceIndex(Ground::flesh).closest(s, tip, -1);
  if (flesh.triangle < 0 || !(flesh.distance_mm < kNearFlesh_mm)) return Under::nothing;
  return s.topology->view.kind[size_t(flesh.triangle)] == FaceKind::skin ? Under::skin : Under::wound;
}

std::string press_on_skin(const MissedPress& m, const Snapshot& s) {
  const Under what = under(m, s);
  const auto tool = Tool(m.tool);
  if (what == Under::skin)
    return fmt::format("The tool is {:.0f} mm above the skin: lower it until it touches.", m.distance_mm);
  if (tool == Tool::hook)
    return what == Under::wound ? "The hook holds nothing in the wound: press on skin, 2 mm beside its edge."
                                : "The hook holds nothing here: press on skin, near the flap's tip.";
  if (sews_bites(tool) || sews_along(tool))
    return what == Under::wound ? "The needle goes in beside the edge, not in the wound: press on skin."
                                : "There is no skin under the needle: press beside an edge of the wound.";
  if (tool == Tool::scissors) return "There is nothing to cut under the scissors: press beside a stitch.";
  if (what == Under::wound)
    return "The stroke began over the defect, where there is no skin: begin on skin, at the edge or beside it.";
  return "The stroke began beside the patient: begin on skin, and hold the button to the end.";
}

}  // namespace

std::string why_missed(const MissedPress& m, const Snapshot& s) {
  switch (m.kind) {
    case MissedPress::hook_stands:
      return "This hook stands elsewhere: take it at its handle, and carry it from there.";
    case MissedPress::second_bite:
      return "The stitch was let go where there is no skin, and is given up: press at one edge, let go on the other.";
    case MissedPress::same_edge:
      return "Both bites lie in one edge, and such a stitch holds nothing: let go across the wound, on the other edge. "
             "Ctrl+Z takes it back.";
    case MissedPress::place:
      return "No bone is touched here: touch bone with saw or grab to name a place on it.";
    case MissedPress::no_hook:
      return "No hook stands here: press where one holds the skin, or at its handle.";
    case MissedPress::no_edge:
      return "There is neither a stitch nor an edge of the wound here. Scissors cut threads, and tissue from an edge: "
             "make the first cut with the scalpel.";
    case MissedPress::no_thread:
      return s.sewn.thread == 0
                 ? "No running stitch is begun: set its first bite, and tie it behind its last one."
                 : "The knot is tied at the last bite of the thread, where it leaves the skin: press beside that.";
    case MissedPress::control:
      return "This patient does not understand what was asked for.";
    default:
      break;
  }
  if (acts_on_bone(Tool(m.tool)))
    return Tool(m.tool) == Tool::saw
               ? "There is no bone under the saw: begin on bone, and draw once round. F makes the face clear."
               : "There is no bone to grab here: press on the piece. F makes the face clear.";
  return press_on_skin(m, s);
}

}  // namespace limberg
