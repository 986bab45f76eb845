#include "app/result/metrics.h"

#include <cmath>

#include "sim/commands/strokes.h"
#include "sim/patient/soft_tissue.h"

namespace limberg {

Metrics measure_world(const World& world, std::span<const Command> script, const MeasureAlso& also) {
  Snapshot s;
  world.skin()->fill(s);
  const Skin skin(world.spec().body);
  return measure(world, s, skin, join_strokes(script), also);
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
    if (m.sutures[i].tied_N) r.set(p + "/tied_N", *m.sutures[i].tied_N);
    r.set(p + "/peak_N", m.sutures[i].peak_N);
    if (m.sutures[i].thread > 0) r.set(p + "/thread", m.sutures[i].thread);
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
  r.set("/metrics/suture_force_peak_N", m.suture_force_peak_N);
  r.set("/metrics/sutures_over_2_5_N", m.sutures_over_2_5_N);
  r.set("/metrics/sutures_over_5_N", m.sutures_over_5_N);
  if (m.closure_energy_mJ) r.set("/metrics/closure_energy_mJ", *m.closure_energy_mJ);
  r.set("/metrics/scar_length_mm", m.scar_length_mm);
  r.set("/metrics/closure_line_N_per_m", m.closure_line_N_per_m);
  r.set("/metrics/step_off_mm", m.step_off_mm);
  r.set("/metrics/step_off_mean_mm", m.step_off_mean_mm);
  if (m.stress_fibre_angle_deg) r.set("/metrics/stress_fibre_angle_deg", *m.stress_fibre_angle_deg);
  r.set("/metrics/compressed_mm2", m.compressed_mm2);
  r.set("/metrics/excised_mm2", m.excised_mm2);
  if (m.waste_mm2) r.set("/metrics/waste_mm2", *m.waste_mm2);
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
  if (!m.landmarks.empty()) r.set("/metrics/landmark_max_mm", m.landmark_max_mm);
  r.set("/metrics/undermined_mm2", m.perfused.undermined_mm2);
  r.set("/metrics/perfusion_least", m.perfused.least);
  r.set("/metrics/perfusion_farthest_mm", m.perfused.farthest_mm);
  r.set("/metrics/perfusion_below_40_mm2", m.perfused.below_40_mm2);
  r.set("/metrics/perfusion_severed_mm2", m.perfused.severed_mm2);
  if (m.elongation) r.set("/metrics/elongation", *m.elongation);
  if (m.elongations) {
    r.set("/metrics/elongation_planimetric", m.elongations->planimetric);
    r.set("/metrics/elongation_stereometric", m.elongations->stereometric);
  }
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
