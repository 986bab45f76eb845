#pragma once
// How much of a figure's variance each parameter makes.
//
//   first order  S_i = V(E(y | x_i)) / V(y): what would go if x_i alone were known
//   total        T_i = 1 - V(E(y | all but x_i)) / V(y): what would stay if x_i alone were not; T_i - S_i is what it
//                makes together with others
//
// From the figures of a design (sampling.h), centred, as sums over its n rows:
//   S_i V = mean(y_B (y_ABi - y_A))        Saltelli, Annoni, Azzini, Campolongo, Ratto, Tarantola 2010, table 2 (b)
//   T_i V = mean((y_A - y_ABi)^2) / 2      Jansen 1999
// with V the variance over A and B. Their errors: rows drawn again with replacement (bootstrap), the interval that 95 %
// of the draws lie in. An estimate may lie a little below 0 or above 1.
#include <cstddef>
#include <cstdint>
#include <vector>

namespace limberg::study {

struct Share {
  double first = 0, first_low = 0, first_high = 0;
  double total = 0, total_low = 0, total_high = 0;
};

struct Shares {
  std::vector<Share> of;  // per parameter; empty: fewer than 8 rows, or the figure does not vary
  size_t rows = 0;        // that are whole; one with a member that failed is left out
  double variance = 0;
};

/// a, b: the figure at the n points of A and B; ab[i]: at those of AB_i. Not a number: no such member.
Shares sensitivity(const std::vector<double>& a, const std::vector<double>& b,
                   const std::vector<std::vector<double>>& ab, size_t draws = 400, uint64_t seed = 1);

/// The value that a share p of 0 to 1 of the values lies below: between two neighbours in a straight line (Hyndman and
/// Fan's seventh). NaN of none.
double quantile(std::vector<double> values, double p);

}  // namespace limberg::study
