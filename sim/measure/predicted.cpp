#include "sim/measure/predicted.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "sim/base/elementary.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/commands/procedures/placement.h"
#include "sim/geometry/polyline.h"
#include "sim/measure/plan.h"
#include "sim/measure/skin_shape.h"

namespace limberg {
namespace {

constexpr double kLeast_deg = 20, kStep_deg = 3, kRad = std::numbers::pi / 180;

// The seams of a procedure between corners that were drawn otherwise; wound and corners as its own figure lists them.
std::optional<PlanOnSkin> drawn(const char* procedure, std::vector<Vec2> wound) {
  const Procedure& p = find_procedure(procedure);
  PlanOnSkin plan{p.figure(p.defaults()), [](const Vec2& c) { return ChartPoint(c); }};
  plan.figure.wounds = {std::move(wound)};
  return plan;
}

}  // namespace

PlanOnSkin plan_on(const Skin& skin, const PlannedProcedure& named) {
  const Procedure& p = find_procedure(named.procedure);
  std::vector<std::string> settings;
  for (const auto& [name, value] : named.values) {
    const std::string text = fmt::format("={:.17g}", value);
    settings.push_back(name + text);
  }
  const auto where = std::make_shared<OnSkin>(skin, Placement{named.at, named.turn_deg, named.mirrored});
  return {p.figure(procedure_values(p, settings)), [where](const Vec2& c) { return where->chart(c); }, true};
}

std::optional<PlanOnSkin> plan_of(const Skin& skin, const std::optional<PlannedProcedure>& named,
                                  std::span<const Command> script) {
  if (named) return plan_on(skin, *named);
  if (const auto z = find_central_limb(script)) {
    const auto& [C, A, B, D] = *z;
    // The figure has the tissue on its left when it walks C A B D B A: C on the right of AB. A mirrored Z is walked
    // from its other end.
    if (cross2(B - A, C - A) < 0) return drawn("z_plasty", {C, A, B, D, B, A});
    return std::nullopt;
  }
  if (const auto f = find_transposition_flap(script)) {
    // The rhombus' other corners, found again from the excision.
    for (const Command& c : script) {
      const auto* e = std::get_if<Excise>(&c);
      if (!e) continue;
      const auto r = corners_of_outline(e->outline);
      if (r.size() != 4) continue;
      for (size_t i = 0; i < 4; ++i) {
        if ((r[i] - f->D).norm() > 2) continue;
        const bool next_is_C = (r[(i + 1) % 4] - f->C).norm() < 1e-9;
        const ChartPoint A = r[(i + (next_is_C ? 3 : 1)) % 4], B = r[(i + 2) % 4];
        // Walked A D E F E D C B with the tissue on the left; a mirrored flap has it on the right.
        std::vector<Vec2> w{A, r[i], f->E, f->F, f->E, r[i], f->C, B};
        const Vec2 rhombus[4] = {A, r[i], f->C, B};
        if (signed_area(rhombus) < 0) return drawn("rhomboid", std::move(w));
        return std::nullopt;
      }
    }
  }
  return std::nullopt;
}

std::vector<PredictedPoint> predicted_points(const SurfaceView& view, std::span<const Vec3f> x_mm, const Skin& skin,
                                             const SkinPoints& points, const PlanOnSkin& plan) {
  std::vector<Charge> all = charges(plan.figure);
  std::erase_if(all, [](const Charge& c) { return std::abs(c.q_deg) < kLeast_deg; });
  std::vector<PredictedPoint> out;
  for (const Charge& c : all) {
    PredictedPoint p;
    p.q_deg = c.q_deg;
    p.at = plan.chart(c.meeting.front());
    double next = 20;
    for (const Charge& o : all)
      if (&o != &c)
        for (const Vec2& a : c.meeting)
          for (const Vec2& b : o.meeting) next = std::min(next, (a - b).norm());
    p.reach_mm = std::clamp(0.5 * next, 2.0, 10.0);
    std::vector<Vec3> places;
    for (const Vec2& m : c.meeting)
      if (const auto hit = skin.at(plan.chart(m))) places.push_back(hit->X_mm);
    const DogEar ear = dog_ear(view, x_mm, skin, places, p.reach_mm);
    p.height_mm = ear.height_mm, p.volume_mm3 = ear.volume_mm3;
    double closed_deg = 0;
    bool whole = true;
    for (size_t i = 0; i < c.meeting.size() && whole; ++i) {
      const TissueSector& s = c.sector[i];
      const double r = 0.8 * p.reach_mm, inside = 0.5 * kStep_deg;
      const auto at = [&](double deg, double radius) -> std::optional<Vec3> {
        const Vec2 d(elementary::cos((s.from_deg + deg) * kRad), elementary::sin((s.from_deg + deg) * kRad));
        const auto place = points.find(plan.chart(c.meeting[i] + radius * d));
        return place ? std::optional(points.now_mm(*place, x_mm)) : std::nullopt;
      };
      const auto centre = at(0.5 * s.sweep_deg, 0.002 * r);
      const int n = std::max(2, int(s.sweep_deg / kStep_deg));
      double length = 0, distance = 0;
      std::optional<Vec3> before;
      for (int k = 0; k <= n && whole; ++k) {
        const auto here = centre ? at(inside + (s.sweep_deg - 2 * inside) * k / n, r) : std::nullopt;
        whole = here.has_value();
        if (!whole) break;
        distance += (*here - *centre).norm() / (n + 1);
        if (before) length += (*here - *before).norm();
        before = here;
      }
      // Chords are shorter than arcs by step^2 / 24.
      if (whole) closed_deg += length / std::max(distance, 1e-9) / kRad * s.sweep_deg / (s.sweep_deg - 2 * inside);
    }
    if (whole) p.deficit_deg = 360 - closed_deg;
    out.push_back(p);
  }
  return out;
}

}  // namespace limberg
