#include "app/result/metrics.h"

#include <cmath>

#include "app/result/run_result.h"
#include "sim/measure/table.h"

namespace limberg {

namespace {

ResultLandmark landmark_of(const NamedLandmark& l) {
  ResultLandmark out{l.name, l.at.x(), l.at.y(), std::nan(""), {}, {}, {}};
  if (l.figure) {
    out.displacement_mm = l.figure->displacement_mm, out.along_mm = l.figure->along_mm;
    out.across_mm = l.figure->across_mm, out.up_mm = l.figure->up_mm;
  }
  return out;
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
  ResultPatient patient;
  patient.sutures.emplace();
  for (const SutureFigure& s : m.sutures)
    patient.sutures->push_back({s.id,
                                s.force_N,
                                s.gap_mm,
                                s.tied_N,
                                s.peak_N,
                                {s.at_mm.begin(), s.at_mm.end()},
                                s.thread > 0 ? MaybeCount(s.thread) : MaybeCount()});
  std::vector<ResultPoint> predicted;
  for (const PredictedPoint& q : m.predicted)
    predicted.push_back({q.q_deg, q.at.x(), q.at.y(), q.reach_mm, q.height_mm, q.volume_mm3, q.deficit_deg});
  patient.predicted = unless_empty(std::move(predicted));
  std::vector<ResultLandmark> landmarks;
  for (const NamedLandmark& l : m.landmarks) landmarks.push_back(landmark_of(l));
  patient.landmarks = unless_empty(std::move(landmarks));
  patient.penetration_at_mm = vector_of(m.penetration.at_mm);
  write_fields(r, "/metrics", patient);
  std::optional<ResultVector> loads;
  if (!m.balance.loads_N.isZero(0)) loads = vector_of(m.balance.loads_N);
  write_fields(r, "/balance",
               ResultBalance{vector_of(m.balance.hooks_N), vector_of(m.balance.supports_N), vector_of(m.balance.sum_N),
                             m.balance.relative, loads});
}

}  // namespace limberg
