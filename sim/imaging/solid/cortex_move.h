#pragma once
// What the fits of a cortex share (cortex_fit.h), and nobody else needs.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "sim/imaging/solid/cortex_fit.h"

namespace limberg::cortex {

/// Unit normals of the vertices; zero where there is none.
std::vector<Vec3> normals_of(const simplex::Mesh& mesh);

/// Moves vertices along their normals by `shift`. Ones without an answer (found 0), and ones that stand out of their
/// neighbours by a quarter of `reach_mm`, follow these. Fills vertices, found, thickness and adds to the mean shift.
void move_to(simplex::Mesh& mesh, const std::vector<Vec3>& normal, std::vector<double> shift,
             std::vector<uint8_t> found, double reach_mm, CortexReport& report);

/// Some of the vertices named, evenly.
std::vector<size_t> some_of(const std::vector<size_t>& all);

/// The density and the blur that leave the least at the median of some vertices, with look(vertex, blur, density).
template <class Look>
void find_scanner(const std::vector<size_t>& some, const std::vector<double>& densities, Look&& look, Workers& workers,
                  CortexReport& out) {
  double least = std::numeric_limits<double>::infinity();
  out.cortical = densities.front();
  std::vector<double> rms(some.size());
  for (const double density : densities)
    for (const double point : {0.3, 0.45, 0.6, 0.75, 0.9, 1.1, 1.3}) {
      workers.parallel_for(some.size(), 16, [&](size_t b, size_t e) {
        for (size_t k = b; k < e; ++k) rms[k] = look(some[k], point, density).rms;
      });
      if (rms.empty()) return;
      std::nth_element(rms.begin(), rms.begin() + std::ptrdiff_t(rms.size() / 2), rms.end());
      if (rms[rms.size() / 2] < least) least = rms[rms.size() / 2], out.point_mm = point, out.cortical = density;
    }
}

}  // namespace limberg::cortex
