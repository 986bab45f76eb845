#include "sim/commands/texture_script.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/base/error.h"

namespace limberg {

bool has_texture_places(const Script& script) {
  return std::any_of(script.lines.begin(), script.lines.end(), [](const ScriptLine& l) {
    const auto* c = std::get_if<InSpace>(&l.command);
    return c && has_texture_places(*c);
  });
}

std::optional<InSpace> on_texture(InSpace act, const Body& body, std::string& reason) {
  std::vector<ChartPoint> points;
  for (const Vec3& given : places_of(act)) {
    const auto X = std::isnan(given.z()) ? place_on_texture(body, given.head<2>(), reason) : given;
    if (!X) return std::nullopt;
    act.z_mm[points.size()] = X->z();
    points.emplace_back(X->x(), X->y());
  }
  act.act = with_points(act, points);
  return act;
}

Script on_texture(Script script, const Body& body) {
  for (ScriptLine& l : script.lines) {
    auto* c = std::get_if<InSpace>(&l.command);
    if (!c || !has_texture_places(*c)) continue;
    std::string reason;
    auto laid = on_texture(std::move(*c), body, reason);
    if (!laid) throw InputError(script.name, l.line, reason);
    *c = *std::move(laid);
  }
  return script;
}

}  // namespace limberg
