#include "app/scene/discretisation.h"

#include <algorithm>
#include <optional>

namespace limberg {
namespace {

struct Named {
  const char* name;
  std::optional<double> (*of)(const Metrics&);
  bool length;
};

const Named figures[] = {
    {"closure_force_N", [](const Metrics& m) { return std::optional(m.closure_force_N); }, false},
    {"suture_force_max_N", [](const Metrics& m) { return std::optional(m.suture_force_max_N); }, false},
    {"suture_gap_max_mm", [](const Metrics& m) { return std::optional(m.suture_gap_max_mm); }, true},
    {"dog_ear_mm", [](const Metrics& m) { return std::optional(m.dog_ear_mm); }, true},
    {"dog_ear_volume_mm3", [](const Metrics& m) { return std::optional(m.dog_ear_volume_mm3); }, false},
    {"wound_gape_mm", [](const Metrics& m) { return std::optional(m.wound_gape_mm); }, true},
    {"elongation", [](const Metrics& m) { return m.elongation; }, false},
    {"flap_area_mm2", [](const Metrics& m) { return m.flap_area_mm2; }, false},
    {"stretch_p99", [](const Metrics& m) { return std::optional(m.stretch_p99); }, false},
    {"stress_p95_kPa", [](const Metrics& m) { return std::optional(m.stress_p95_kPa); }, false},
    {"compression", [](const Metrics& m) { return std::optional(m.compression); }, false},
};

}  // namespace

std::vector<FigureError> discretisation_errors(std::span<const SizedFigures> runs) {
  std::vector<SizedFigures> sorted(runs.begin(), runs.end());
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.cell_mm < b.cell_mm; });
  // Sizes that were fitted to the same lattice say nothing twice.
  sorted.erase(
      std::unique(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.cell_mm == b.cell_mm; }),
      sorted.end());
  std::vector<FigureError> out;
  if (sorted.size() < 2) return out;
  for (const Named& f : figures) {
    std::vector<double> h, v;
    double noise = 0;
    for (const SizedFigures& r : sorted)
      if (const auto x = f.of(r.figures)) {
        h.push_back(r.cell_mm), v.push_back(*x);
        if (f.length) noise = std::max(noise, 2 * r.distance_mm);
      }
    if (h.size() != sorted.size() || std::all_of(v.begin(), v.end(), [](double x) { return x == 0; })) continue;
    out.push_back({f.name, extrapolate(h, v, noise)});
  }
  return out;
}

void fill_discretisation(Result& r, std::span<const FigureError> errors) {
  for (const FigureError& e : errors) {
    const std::string p = "/discretisation/" + e.name;
    r.set(p + "/value", e.estimate.value);
    if (e.estimate.error) r.set(p + "/error", *e.estimate.error);
    if (e.estimate.order) r.set(p + "/order", *e.estimate.order);
    if (e.estimate.extrapolated) r.set(p + "/extrapolated", *e.estimate.extrapolated);
    r.set(p + "/asymptotic", e.estimate.asymptotic);
    r.set(p + "/says", e.estimate.says);
  }
}

}  // namespace limberg
