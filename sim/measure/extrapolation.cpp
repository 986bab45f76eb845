#include "sim/measure/extrapolation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "sim/base/elementary.h"
#include "sim/base/error.h"

namespace limberg {
namespace {

constexpr double lowest_order = 0.5, highest_order = 3.5;  // of the method: 1 to 2; observed orders scatter about that
constexpr double safety_three = 1.25, safety_unsure = 3;

/// p of (h3^p - h2^p) / (h2^p - h1^p) = ratio, or nothing when it is not in [0.01, 12].
std::optional<double> solve_order(double h1, double h2, double h3, double ratio) {
  const double a = elementary::log(h1 / h2), b = elementary::log(h3 / h2);
  const auto f = [&](double p) { return elementary::expm1(b * p) / -elementary::expm1(a * p) - ratio; };
  double lo = 0.01, hi = 12;
  if (f(lo) > 0 || f(hi) < 0) return {};
  for (int k = 0; k < 100; ++k) {
    const double m = 0.5 * (lo + hi);
    (f(m) < 0 ? lo : hi) = m;
  }
  return 0.5 * (lo + hi);
}

}  // namespace

Extrapolation extrapolate(std::span<const double> cell_mm, std::span<const double> value, double noise) {
  if (cell_mm.empty() || cell_mm.size() != value.size())
    throw InputError("", 0, "cell sizes and values of the same number, at least one, were expected");
  std::vector<size_t> order(cell_mm.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return cell_mm[a] < cell_mm[b]; });
  std::vector<double> h, f;
  for (size_t i : order) {
    if (!(cell_mm[i] > 0) || !std::isfinite(cell_mm[i]) || !std::isfinite(value[i]) ||
        (!h.empty() && cell_mm[i] == h.back()))
      throw InputError("", 0, "positive, different cell sizes and finite values were expected");
    h.push_back(cell_mm[i]), f.push_back(value[i]);
  }
  Extrapolation e;
  e.value = f[0];
  if (h.size() == 1) {
    e.says = "one cell size: no estimate";
    return e;
  }
  const double e21 = f[1] - f[0];
  if (h.size() == 2) {
    e.error = std::max(noise, safety_unsure * std::fabs(e21) / (h[1] / h[0] - 1));
    e.says = "two cell sizes: order 1 taken for granted";
    return e;
  }
  const double e32 = f[2] - f[1], largest = std::max({std::fabs(e21), std::fabs(e32), std::fabs(f[2] - f[0])});
  if (largest <= noise) {
    e.error = noise;
    e.says = "changes no more than the solver's own error";
    return e;
  }
  e.error = std::max(noise, safety_unsure * largest);
  if (e21 == 0 || e32 / e21 < 0) {
    e.says = "swings from size to size: not in the asymptotic range";
    return e;
  }
  e.order = solve_order(h[0], h[1], h[2], e32 / e21);
  if (!e.order) {
    e.says = "does not settle as cells shrink: not in the asymptotic range";
    return e;
  }
  if (*e.order < lowest_order || *e.order > highest_order) {
    e.says =
        fmt::format("observed order {:.2g}, which the method does not have: not in the asymptotic range", *e.order);
    return e;
  }
  const double rest =
      e21 * elementary::pow(h[0], *e.order) / (elementary::pow(h[1], *e.order) - elementary::pow(h[0], *e.order));
  e.asymptotic = true;
  e.extrapolated = f[0] - rest;
  e.error = std::max(noise, safety_three * std::fabs(rest));
  e.says = fmt::format("observed order {:.2g}", *e.order);
  return e;
}

}  // namespace limberg
