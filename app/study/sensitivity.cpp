#include "app/study/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace limberg::study {

namespace {

struct Figures {
  std::vector<double> a, b;
  std::vector<std::vector<double>> ab;
};

/// S_i, T_i of some rows; the variance first.
struct Estimate {
  double variance = 0;
  std::vector<double> first, total;
};

Estimate estimate(const Figures& y, const std::vector<size_t>& rows) {
  const double n = double(rows.size());
  double mean = 0, square = 0;
  for (const size_t j : rows) mean += (y.a[j] + y.b[j]) / (2 * n);
  for (const size_t j : rows) {
    const double da = y.a[j] - mean, db = y.b[j] - mean;
    square += da * da + db * db;
  }
  Estimate e;
  e.variance = square / (2 * n);
  for (const std::vector<double>& ab : y.ab) {
    double first = 0, total = 0;
    for (const size_t j : rows) {
      const double step = ab[j] - y.a[j];
      first += (y.b[j] - mean) * step, total += step * step;
    }
    e.first.push_back(first / n / e.variance), e.total.push_back(total / (2 * n) / e.variance);
  }
  return e;
}

}  // namespace

double quantile(std::vector<double> v, double p) {
  std::erase_if(v, [](double x) { return !std::isfinite(x); });
  if (v.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(v.begin(), v.end());
  const double at = std::clamp(p, 0.0, 1.0) * double(v.size() - 1);
  const size_t i = std::min(size_t(at), v.size() - 1), k = std::min(i + 1, v.size() - 1);
  return v[i] + (at - double(i)) * (v[k] - v[i]);
}

Shares sensitivity(const std::vector<double>& a, const std::vector<double>& b,
                   const std::vector<std::vector<double>>& ab, size_t draws, uint64_t seed) {
  const Figures y{a, b, ab};
  std::vector<size_t> rows;
  for (size_t j = 0; j < a.size(); ++j) {
    bool whole = std::isfinite(a[j]) && std::isfinite(b[j]);
    for (const auto& column : ab) whole &= std::isfinite(column[j]);
    if (whole) rows.push_back(j);
  }
  Shares out;
  out.rows = rows.size();
  constexpr size_t kLeast = 8;
  if (rows.size() < kLeast) return out;
  const Estimate e = estimate(y, rows);
  double largest = 0;
  for (const size_t j : rows) largest = std::max(largest, std::abs(a[j]));
  out.variance = e.variance;
  if (!(std::sqrt(e.variance) > 1e-12 * largest)) return out;
  for (size_t i = 0; i < ab.size(); ++i) out.of.push_back({e.first[i], 0, 0, e.total[i], 0, 0});

  std::vector<std::vector<double>> first(ab.size()), total(ab.size());
  std::mt19937_64 bits(seed);
  for (size_t k = 0; k < draws; ++k) {
    std::vector<size_t> drawn(rows.size());
    for (size_t& j : drawn) j = rows[bits() % rows.size()];
    const Estimate d = estimate(y, drawn);
    if (!(d.variance > 0)) continue;
    for (size_t i = 0; i < ab.size(); ++i) first[i].push_back(d.first[i]), total[i].push_back(d.total[i]);
  }
  for (size_t i = 0; i < ab.size(); ++i) {
    Share& s = out.of[i];
    s.first_low = quantile(first[i], 0.025), s.first_high = quantile(first[i], 0.975);
    s.total_low = quantile(total[i], 0.025), s.total_high = quantile(total[i], 0.975);
  }
  return out;
}

}  // namespace limberg::study
