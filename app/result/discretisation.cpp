#include "app/result/discretisation.h"

#include <algorithm>
#include <optional>

#include "app/result/schema.h"
#include "sim/measure/table.h"

namespace limberg {
std::vector<FigureError> discretisation_errors(std::span<const SizedFigures> runs) {
  std::vector<SizedFigures> sorted(runs.begin(), runs.end());
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.cell_mm < b.cell_mm; });
  // Sizes that were fitted to the same lattice say nothing twice.
  sorted.erase(
      std::unique(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.cell_mm == b.cell_mm; }),
      sorted.end());
  std::vector<FigureError> out;
  if (sorted.size() < 2) return out;
  for (const Measure& f : measure_table()) {
    if (f.across == Across::none) continue;
    std::vector<double> h, v;
    double noise = 0;
    for (const SizedFigures& r : sorted)
      if (const auto x = f.value(r.figures)) {
        h.push_back(r.cell_mm), v.push_back(*x);
        if (f.across == Across::length) noise = std::max(noise, 2 * r.distance_mm);
      }
    if (h.size() != sorted.size() || std::all_of(v.begin(), v.end(), [](double x) { return x == 0; })) continue;
    out.push_back({f.name, extrapolate(h, v, noise)});
  }
  return out;
}

void fill_discretisation(Result& r, std::span<const FigureError> errors) {
  for (const FigureError& e : errors) {
    const Extrapolation& x = e.estimate;
    write_fields(r, "/discretisation/" + e.name,
                 ResultError{x.value, x.error, x.order, x.extrapolated, x.asymptotic, x.says});
  }
}

}  // namespace limberg
