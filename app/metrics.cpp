#include "app/metrics.h"

#include "sim/tools/strokes.h"

namespace limberg {

Metrics measure_world(const World& world, std::span<const Command> script) {
  Snapshot s;
  world.fill(s);
  const Skin skin(world.spec().body);
  return measure(world, s, skin, join_strokes(script));
}

namespace {

void set_vector(Result& r, const std::string& path, const Vec3& v) {
  for (int i = 0; i < 3; ++i) r.set(path + "/" + std::to_string(i), v[i]);
}

}  // namespace

void fill_metrics(Result& r, const Metrics& m) {
  r.set("/metrics/pieces", m.pieces);
  r.set("/metrics/volume_mm3", m.volume_mm3);
  r.set("/metrics/removed_volume_mm3", m.removed_volume_mm3);
  r.set("/metrics/initial_volume_mm3", m.initial_volume_mm3);
  r.set("/metrics/volume_change", m.volume_change);
  r.set("/metrics/compression", m.compression);
  r.set_empty_list("/metrics/sutures");
  for (size_t i = 0; i < m.sutures.size(); ++i) {
    const std::string p = "/metrics/sutures/" + std::to_string(i);
    r.set(p + "/id", m.sutures[i].id);
    r.set(p + "/force_N", m.sutures[i].force_N);
    r.set(p + "/gap_mm", m.sutures[i].gap_mm);
    r.set(p + "/at_mm", std::span<const float>(m.sutures[i].at_mm));
  }
  r.set("/metrics/closure_force_N", m.closure_force_N);
  r.set("/metrics/suture_force_max_N", m.suture_force_max_N);
  r.set("/metrics/suture_force_max_id", m.suture_force_max_id);
  r.set("/metrics/suture_gap_max_mm", m.suture_gap_max_mm);
  r.set("/metrics/stretch_max", m.stretch_max);
  r.set("/metrics/stretch_p99", m.stretch_p99);
  r.set("/metrics/stress_p95_kPa", m.stress_p95_kPa);
  r.set("/metrics/stress_max_kPa", m.stress_max_kPa);
  r.set("/metrics/dog_ear_mm", m.dog_ear_mm);
  r.set("/metrics/dog_ear_volume_mm3", m.dog_ear_volume_mm3);
  r.set("/metrics/wound_gape_mm", m.wound_gape_mm);
  r.set("/metrics/wound_gape_mean_mm", m.wound_gape_mean_mm);
  if (m.elongation) r.set("/metrics/elongation", *m.elongation);
  if (m.flap_area_mm2) r.set("/metrics/flap_area_mm2", *m.flap_area_mm2);
  r.set("/metrics/penetration_max_mm", m.penetration.max_mm);
  r.set("/metrics/penetration_p99_mm", m.penetration.p99_mm);
  r.set("/metrics/penetration_area_mm2", m.penetration.overlapping_mm2);
  set_vector(r, "/metrics/penetration_at_mm", m.penetration.at_mm);
  r.set("/metrics/contact_force_N", m.contact_force_N);
  r.set("/metrics/min_J", m.min_J);
  r.set("/metrics/inverted_cells", m.inverted_cells);
  set_vector(r, "/balance/hooks_N", m.balance.hooks_N);
  set_vector(r, "/balance/supports_N", m.balance.supports_N);
  set_vector(r, "/balance/sum_N", m.balance.sum_N);
  r.set("/balance/relative", m.balance.relative);
}

}  // namespace limberg
