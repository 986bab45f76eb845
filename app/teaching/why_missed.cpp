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

std::string press_on_skin(const MissedPress& m, const Snapshot& s, const Words& w) {
  const Under what = under(m, s);
  const auto tool = Tool(m.tool);
  if (what == Under::skin) return w("The tool is {:.0f} mm above the skin: lower it until it touches.", m.distance_mm);
  if (tool == Tool::hook)
    return w(what == Under::wound ? english("The hook holds nothing in the wound: press on skin, 2 mm beside its edge.")
                                  : english("The hook holds nothing here: press on skin, near the flap's tip."));
  if (sews_bites(tool) || sews_along(tool))
    return w(what == Under::wound ? english("The needle goes in beside the edge, not in the wound: press on skin.")
                                  : english("There is no skin under the needle: press beside an edge of the wound."));
  if (tool == Tool::scissors) return w("There is nothing to cut under the scissors: press beside a stitch.");
  if (what == Under::wound)
    return w("The stroke began over the defect, where there is no skin: begin on skin, at the edge or beside it.");
  return w("The stroke began beside the patient: begin on skin, and hold the button to the end.");
}

}  // namespace

std::string why_missed(const MissedPress& m, const Snapshot& s, const Words& w) {
  switch (m.kind) {
    case MissedPress::hook_stands:
      return w("This hook stands elsewhere: take it at its handle, and carry it from there.");
    case MissedPress::second_bite:
      return w(
          "The stitch was let go where there is no skin, and is given up: press at one edge, let go on the other.");
    case MissedPress::same_edge:
      return w(
          "Both bites lie in one edge, and such a stitch holds nothing: let go across the wound, on the other edge. "
          "Ctrl+Z takes it back.");
    case MissedPress::place:
      return w("No bone is touched here: touch bone with saw or grab to name a place on it.");
    case MissedPress::no_hook:
      return w("No hook stands here: press where one holds the skin, or at its handle.");
    case MissedPress::no_edge:
      return w(
          "There is neither a stitch nor an edge of the wound here. Scissors cut threads, and tissue from an edge: "
          "make the first cut with the scalpel.");
    case MissedPress::no_thread:
      return s.sewn.thread == 0
                 ? w("No running stitch is begun: set its first bite, and tie it behind its last one.")
                 : w("The knot is tied at the last bite of the thread, where it leaves the skin: press beside that.");
    case MissedPress::control:
      return w("This patient does not understand what was asked for.");
    default:
      break;
  }
  if (acts_on_bone(Tool(m.tool)))
    return w(
        Tool(m.tool) == Tool::saw
            ? english("There is no bone under the saw: begin on bone, and draw once round. F makes the face clear.")
            : english("There is no bone to grab here: press on the piece. F makes the face clear."));
  return press_on_skin(m, s, w);
}

}  // namespace limberg
