#include "app/result/metrics.h"

#include <cmath>

#include "sim/commands/strokes.h"
#include "sim/measure/table.h"

namespace limberg {

Metrics measure_world(const World& world, std::span<const Command> script, const MeasureAlso& also) {
  Snapshot s;
  world.fill(s);
  const Skin skin(world.spec().body);
  return measure(world, s, skin, join_strokes(script), also);
}

namespace {

void set_vector(Result& r, const std::string& path, const Vec3& v) {
  for (int i = 0; i < 3; ++i) r.set(path + "/" + std::to_string(i), v[i]);
}

}  // namespace

void fill_metrics(Result& r, const Metrics& m) {
  for (const Measure& measure : measure_table())
    if (measure.value)
      if (const std::optional<double> v = measure.value(m)) {
        const std::string path = std::string("/metrics/") + measure.name;
        if (measure.counts)
          r.set(path, int64_t(*v));
        else
          r.set(path, *v);
      }
  r.set_empty_list("/metrics/sutures");
  for (size_t i = 0; i < m.sutures.size(); ++i) {
    const std::string p = "/metrics/sutures/" + std::to_string(i);
    r.set(p + "/id", m.sutures[i].id);
    r.set(p + "/force_N", m.sutures[i].force_N);
    r.set(p + "/gap_mm", m.sutures[i].gap_mm);
    r.set(p + "/at_mm", std::span<const float>(m.sutures[i].at_mm));
    if (m.sutures[i].tied_N) r.set(p + "/tied_N", *m.sutures[i].tied_N);
    r.set(p + "/peak_N", m.sutures[i].peak_N);
    if (m.sutures[i].thread > 0) r.set(p + "/thread", m.sutures[i].thread);
  }
  for (size_t i = 0; i < m.predicted.size(); ++i) {
    const std::string p = "/metrics/predicted/" + std::to_string(i);
    const PredictedPoint& q = m.predicted[i];
    r.set(p + "/charge_deg", q.q_deg);
    r.set(p + "/x_mm", q.at.x());
    r.set(p + "/y_mm", q.at.y());
    r.set(p + "/reach_mm", q.reach_mm);
    r.set(p + "/height_mm", q.height_mm);
    r.set(p + "/volume_mm3", q.volume_mm3);
    if (q.deficit_deg) r.set(p + "/deficit_deg", *q.deficit_deg);
  }
  for (size_t i = 0; i < m.landmarks.size(); ++i) {
    const std::string p = "/metrics/landmarks/" + std::to_string(i);
    r.set(p + "/name", m.landmarks[i].name);
    r.set(p + "/x_mm", m.landmarks[i].at.x());
    r.set(p + "/y_mm", m.landmarks[i].at.y());
    const auto& f = m.landmarks[i].figure;
    r.set(p + "/displacement_mm", f ? f->displacement_mm : std::nan(""));
    if (!f) continue;
    r.set(p + "/along_mm", f->along_mm);
    r.set(p + "/across_mm", f->across_mm);
    r.set(p + "/up_mm", f->up_mm);
  }
  set_vector(r, "/metrics/penetration_at_mm", m.penetration.at_mm);
  set_vector(r, "/balance/hooks_N", m.balance.hooks_N);
  set_vector(r, "/balance/supports_N", m.balance.supports_N);
  set_vector(r, "/balance/sum_N", m.balance.sum_N);
  r.set("/balance/relative", m.balance.relative);
}

}  // namespace limberg
