#include "app/session/command_words.h"

#include <cmath>

#include "sim/base/text.h"
#include "sim/commands/script.h"

namespace limberg {

namespace {

double length_mm(const std::vector<ChartPoint>& p, bool closed) {
  double l = 0;
  for (size_t i = 1; i < p.size(); ++i) l += (p[i] - p[i - 1]).norm();
  return closed && p.size() > 2 ? l + (p.front() - p.back()).norm() : l;
}

}  // namespace

std::string in_words(const Command& command) {
  if (const auto* c = std::get_if<Incise>(&command))
    return text("incise %.0f mm, %.3g mm deep", length_mm(c->path, false), c->depth_mm);
  if (const auto* c = std::get_if<InciseMore>(&command))
    return text("incision %d, %.3g mm deep", c->stroke, c->depth_mm);
  if (const auto* c = std::get_if<Undermine>(&command))
    return text("undermine %.0f mm around, at %.3g mm", length_mm(c->outline, true), c->depth_mm);
  if (const auto* c = std::get_if<Excise>(&command))
    return text("excise %.0f mm around, %.3g mm deep", length_mm(c->outline, true), c->depth_mm);
  if (const auto* c = std::get_if<SetHook>(&command)) return text("hook %d set", c->id);
  if (const auto* c = std::get_if<MoveHook>(&command)) return text("hook %d moved", c->id);
  if (const auto* c = std::get_if<ReleaseHook>(&command)) return text("hook %d released", c->id);
  if (const auto* c = std::get_if<SutureRow>(&command)) return text("row of sutures every %.3g mm", c->spacing_mm);
  if (const auto* h = std::get_if<HeadCommand>(&command)) {
    if (const auto* c = std::get_if<CutBone>(h))
      return c->contour_mm.empty() ? "osteotomy by a plane"
                                   : text("osteotomy by a contour of %zu places", c->contour_mm.size());
    if (const auto* c = std::get_if<MoveFragment>(h)) {
      const double deg = c->by.rotation_deg.norm();
      return deg > 0 ? text("fragment moved by %.1f mm, turned by %.1f degrees", c->by.translation_mm.norm(), deg)
                     : text("fragment moved by %.1f mm", c->by.translation_mm.norm());
    }
    if (std::holds_alternative<GrabFragment>(*h)) return "fragment grabbed";
    if (const auto* c = std::get_if<LetGo>(h)) return c->snap ? "fragment let go, into its cut" : "fragment let go";
    if (std::holds_alternative<PlateFragments>(*h)) return "plate across two fragments";
    if (std::holds_alternative<Unplate>(*h)) return "plates taken off";
    if (std::holds_alternative<JoinFragments>(*h)) return "two fragments joined";
    if (std::holds_alternative<SortFragments>(*h)) return "fragments sorted by their cut rings";
    if (const auto* c = std::get_if<DragFragment>(h))
      return text("fragment taken by %.1f mm in %.1f s", c->to.translation_mm.norm(), c->seconds);
    if (const auto* c = std::get_if<ConnectTissue>(h)) return "tissue: " + c->name;
    if (const auto* c = std::get_if<PlaceLandmark>(h)) return "landmark " + c->name;
    if (const auto* c = std::get_if<Superpose>(h)) return kSkullBesideWords[size_t(c->on)];
  }
  if (const auto* c = std::get_if<Stage>(&command)) return "stage: " + c->name;
  return action_name(command);
}

}  // namespace limberg
