#include "app/world_patient.h"

#include <cstdio>

namespace limberg {

namespace {

double depth_of(const Command& c) {
  if (const auto* i = std::get_if<Incise>(&c)) return i->depth_mm;
  if (const auto* m = std::get_if<InciseMore>(&c)) return m->depth_mm;
  if (const auto* u = std::get_if<Undermine>(&c)) return u->depth_mm;
  if (const auto* e = std::get_if<Excise>(&c)) return e->depth_mm;
  return 0;
}

}  // namespace

Outcome WorldPatient::apply(const Command& c) {
  const double depth = depth_of(c);
  if (depth > max_depth_mm_) {
    char text[96];
    std::snprintf(text, sizeof text, "depth %.6g mm is deeper than the scene allows; expected at most %.6g mm", depth,
                  max_depth_mm_);
    return {false, text};
  }
  return world_.apply(c);
}

}  // namespace limberg
