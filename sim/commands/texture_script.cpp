#include "sim/commands/texture_script.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"

namespace limberg {

bool has_texture_places(const Script& script) {
  return std::any_of(script.lines.begin(), script.lines.end(), [](const ScriptLine& l) {
    const auto* c = std::get_if<InSpace>(&l.command);
    return c && has_texture_places(*c);
  });
}

Script on_texture(Script script, const Body& body) {
  for (ScriptLine& l : script.lines) {
    auto* c = std::get_if<InSpace>(&l.command);
    if (!c || !has_texture_places(*c)) continue;
    std::vector<ChartPoint> points;
    const std::vector<Vec3> places = places_of(*c);
    for (size_t i = 0; i < places.size(); ++i) {
      Vec3 X = places[i];
      if (std::isnan(X.z())) {
        std::string reason;
        const auto at = place_on_texture(body, X.head<2>(), reason);
        if (!at) throw InputError(script.name, l.line, reason);
        X = *at;
      }
      points.emplace_back(X.x(), X.y());
      c->z_mm[i] = X.z();
    }
    c->act = with_points(*c, points);
  }
  return script;
}

}  // namespace limberg
