#include "app/result/metrics.h"

#include <cmath>

#include "app/result/schema.h"
#include "sim/commands/strokes.h"
#include "sim/measure/table.h"
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
  for (const SutureFigure& s : m.sutures)
    append(r, "/metrics/sutures",
           ResultSuture{s.id,
                        s.force_N,
                        s.gap_mm,
                        s.tied_N,
                        s.peak_N,
                        {s.at_mm.begin(), s.at_mm.end()},
                        s.thread > 0 ? MaybeCount(s.thread) : MaybeCount()});
  for (const PredictedPoint& q : m.predicted)
    append(r, "/metrics/predicted",
           ResultPoint{q.q_deg, q.at.x(), q.at.y(), q.reach_mm, q.height_mm, q.volume_mm3, q.deficit_deg});
  for (const NamedLandmark& l : m.landmarks) {
    ResultLandmark out{l.name, l.at.x(), l.at.y(), std::nan(""), {}, {}, {}};
    if (l.figure) {
      out.displacement_mm = l.figure->displacement_mm, out.along_mm = l.figure->along_mm;
      out.across_mm = l.figure->across_mm, out.up_mm = l.figure->up_mm;
    }
    append(r, "/metrics/landmarks", out);
  }
  set_vector(r, "/metrics/penetration_at_mm", m.penetration.at_mm);
  set_vector(r, "/balance/hooks_N", m.balance.hooks_N);
  set_vector(r, "/balance/supports_N", m.balance.supports_N);
  set_vector(r, "/balance/sum_N", m.balance.sum_N);
  r.set("/balance/relative", m.balance.relative);
}

}  // namespace limberg
