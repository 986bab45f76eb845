#include "app/study/sampling.h"

#include <algorithm>
#include <boost/random/sobol.hpp>
#include <numeric>
#include <random>

namespace limberg::study {

namespace {

double in_open_unit(uint64_t bits) { return (double(bits >> 12) + 0.5) / double(uint64_t(1) << 52); }

std::vector<UnitPoint> sobol_points(size_t n, size_t d, uint64_t seed) {
  boost::random::sobol sequence(d);
  std::mt19937_64 bits(seed);
  std::vector<uint64_t> shift(d);
  for (uint64_t& s : shift) s = bits();
  std::vector<UnitPoint> points(n, UnitPoint(d));
  // Boost's begins with the second point; the first, zero, belongs to the net of the first 2^k points.
  for (size_t j = 0; j < n; ++j)
    for (size_t i = 0; i < d; ++i) points[j][i] = in_open_unit((j == 0 ? 0 : uint64_t(sequence())) ^ shift[i]);
  return points;
}

std::vector<UnitPoint> latin_points(size_t n, size_t d, uint64_t seed) {
  std::mt19937_64 bits(seed);
  std::vector<UnitPoint> points(n, UnitPoint(d));
  std::vector<size_t> part(n);
  for (size_t i = 0; i < d; ++i) {
    std::iota(part.begin(), part.end(), size_t(0));
    for (size_t j = n; j > 1; --j) std::swap(part[j - 1], part[bits() % j]);  // the same on every machine
    for (size_t j = 0; j < n; ++j) points[j][i] = (double(part[j]) + in_open_unit(bits())) / double(n);
  }
  return points;
}

}  // namespace

std::vector<UnitPoint> unit_points(SampleKind kind, size_t n, size_t d, uint64_t seed) {
  return kind == SampleKind::sobol ? sobol_points(n, d, seed) : latin_points(n, d, seed);
}

Design design_of(SampleKind kind, size_t n, size_t d, uint64_t seed, bool blocks) {
  Design design{n, d, blocks, {}};
  if (!blocks) {
    design.points = unit_points(kind, n, d, seed);
    return design;
  }
  const std::vector<UnitPoint> both = unit_points(kind, n, 2 * d, seed);
  for (const bool second : {false, true})
    for (const UnitPoint& p : both) {
      const auto from = p.begin() + std::ptrdiff_t(second ? d : 0);
      design.points.emplace_back(from, from + std::ptrdiff_t(d));
    }
  for (size_t i = 0; i < d; ++i)
    for (size_t j = 0; j < n; ++j) {
      UnitPoint p = design.points[j];
      p[i] = design.points[design.of_b(j)][i];
      design.points.push_back(std::move(p));
    }
  return design;
}

}  // namespace limberg::study
