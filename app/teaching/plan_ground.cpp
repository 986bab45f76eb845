#include "app/teaching/plan_ground.h"

#include "devices/hand_ground.h"
#include "devices/skin_chart.h"

namespace limberg {

void say_on_chart(LessonPlan& plan, const Snapshot& uncut) {
  if (!has_surface(uncut) || !uncut.topology->body) return;
  SkinChart chart;
  for (PlannedAct& planned : plan.acts) {
    const auto* act = std::get_if<InSpace>(&planned.command);
    if (!act || has_texture_places(*act)) continue;
    if (!chart.built_for(uncut)) chart.build(*uncut.topology);
    std::vector<ChartPoint> points;
    bool seen = true;
    for (const Vec3& X : places_of(*act)) {
      const SkinTouch meant = SkinChart::at_rest(uncut, X, kOffSkin_mm);
      const SkinTouch front = chart.at(uncut, meant.chart, 1e-3);
      seen &= meant.triangle >= 0 && front.triangle >= 0 &&
              chart_means(front.X_mm, front.N, meant.X_mm, uncut.topology->body->chart_normal());
      points.push_back(meant.chart);
    }
    if (!seen) continue;
    Command on_chart = std::visit([](const auto& a) { return Command(a); }, with_points(*act, points));
    if (const auto* s = std::get_if<Suture>(&on_chart);
        s && (s->side_a != HeldSide::skin || s->side_b != HeldSide::skin))
      continue;  // a hand says where cut faces are in space
    planned.command = std::move(on_chart);
  }
}

}  // namespace limberg
