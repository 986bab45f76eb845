#include "app/commands/fit_sweep.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/operating_point/cpu_clock.h"

namespace limberg {

FitSweep fit_sweep(const Prepared& target, const FitSettings& like, Workers& workers,
                   const std::function<void(const std::string&)>& progress, const std::function<bool()>& stopped) {
  FitSweep out;
  const double longest = 6 * target.voxel_mm;
  for (const bool adapted : {false, true})
    for (const double x : adapted ? std::vector<double>{0.2, 0.1, 0.05, 0.025, 0.012}
                                  : std::vector<double>{6, 4.5, 3.5, 2.5, 1.8}) {  // in voxels
      if (stopped()) return out;
      FitTrial t;
      t.adapted = adapted, t.edge_mm = adapted ? longest : x * target.voxel_mm,
      t.chord_mm = adapted ? x * target.voxel_mm : 0;
      FitSettings s = like;
      s.edge_mm = t.edge_mm, s.chord_mm = t.chord_mm, s.progress = {};
      simplex::Mesh m = start_mesh(Start::sphere, target.low_mm, target.high_mm);
      const double t0 = bench::cpu_ms();
      t.report = fit(m, target, s, workers);
      t.cpu_s = (bench::cpu_ms() - t0) * 1e-3;
      out.trial.push_back(std::move(t));
      progress("sweep: " + std::to_string(out.trial.size()) + " of " + std::to_string(FitSweep::kTrials));
    }
  return out;
}

std::string FitSweep::csv() const {
  std::string s =
      "faces,edge_mm,chord_mm,vertices,cpu_s,iterations,found,rms_mm,reached,surface_rms_mm,surface_p95_mm,openings\n";
  std::string b;
  for (const FitTrial& t : trial) {
    b = fmt::format("{},{:.4g},{:.4g},{},{:.3f},{},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{}\n",
                    t.adapted ? "adapted" : "uniform", t.edge_mm, t.chord_mm, t.report.vertices, t.cpu_s,
                    t.report.iterations, t.report.found, t.report.rms_mm, t.report.reached, t.report.surface_rms_mm,
                    t.report.surface_p95_mm, t.report.hole.size());
    s += b;
  }
  return s;
}

LineChart FitSweep::chart(bool time) const {
  LineChart c;
  c.description = std::string("Distance of the isosurface to the fitted mesh against ") +
                  (time ? "run time" : "the number of vertices") + ", uniform faces and faces adapted to curvature";
  c.x = {time ? "CPU time, s" : "vertices", true, {}, {}};
  c.y = {"rms distance of the surface to the mesh, mm", true, {}, {}};
  for (const bool adapted : {false, true}) {
    ChartSeries s;
    s.name = adapted ? "adapted to curvature" : "uniform", s.markers = true;
    std::vector<const FitTrial*> in;
    for (const FitTrial& t : trial)
      if (t.adapted == adapted) in.push_back(&t);
    std::stable_sort(in.begin(), in.end(), [&](const FitTrial* a, const FitTrial* b) {
      return time ? a->cpu_s < b->cpu_s : a->report.vertices < b->report.vertices;
    });
    for (const FitTrial* t : in)
      s.x.push_back(time ? t->cpu_s : t->report.vertices), s.y.push_back(t->report.surface_rms_mm);
    c.series.push_back(std::move(s));
  }
  return c;
}

}  // namespace limberg
