#pragma once
// Points that fill the unit cube, and the design from which sensitivities are read.
//
// Sobol's sequence (Boost's, with the direction numbers of Joe and Kuo) with each coordinate's bits turned over at
// random (a digital shift: another seed is another sample, as evenly spread), or a Latin hypercube: each coordinate has
// one point in each of n equal parts.
//
// A design of Saltelli's has two samples A and B of n points in d coordinates, made as one sample in 2d, and d others:
// AB_i is A with coordinate i from B. n (d + 2) points.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace limberg::study {

enum class SampleKind { sobol, latin };

using UnitPoint = std::vector<double>;
/// n points in d coordinates, each above 0 and below 1.
std::vector<UnitPoint> unit_points(SampleKind kind, size_t n, size_t d, uint64_t seed);

struct Design {
  size_t n = 0, d = 0;
  bool blocks = false;            // with B and all AB_i
  std::vector<UnitPoint> points;  // A; then B; then AB_0, AB_1, ...
  size_t of_b(size_t row) const { return n + row; }
  size_t of_ab(size_t i, size_t row) const { return (2 + i) * n + row; }
  size_t independent() const { return blocks ? 2 * n : n; }  // so many first points are a plain sample
};
Design design_of(SampleKind kind, size_t n, size_t d, uint64_t seed, bool blocks);

}  // namespace limberg::study
