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

constexpr double lowest_order = 0.5, highest_order = 2;  // of the method
constexpr double least_tried = 0.05, most_tried = 12;
constexpr double safety_sure = 1.25, safety_unsure = 3;

/// f = limit + c h^order by least squares; sigma: the spread about it.
struct Fit {
  double order = 0, limit = 0, sigma = 0;
  double at_finest = 0;  // of the fit
};

struct Sizes {
  std::vector<double> h, f;    // the finest first
  std::vector<double> weight;  // sum 1
};

/// `unknowns`: 2, or 3 where the order was found too.
Fit fit_with(const Sizes& s, double order, int unknowns) {
  const size_t n = s.h.size();
  std::vector<double> x(n);
  for (size_t i = 0; i < n; ++i) x[i] = elementary::pow(s.h[i] / s.h.back(), order);
  double mean_x = 0, mean_f = 0, xx = 0, xf = 0, rest = 0;
  for (size_t i = 0; i < n; ++i) mean_x += s.weight[i] * x[i], mean_f += s.weight[i] * s.f[i];
  for (size_t i = 0; i < n; ++i) {
    xx += s.weight[i] * (x[i] - mean_x) * (x[i] - mean_x);
    xf += s.weight[i] * (x[i] - mean_x) * (s.f[i] - mean_f);
  }
  const double slope = xf / xx;
  Fit fit{order, mean_f - slope * mean_x, 0, mean_f + slope * (x[0] - mean_x)};
  for (size_t i = 0; i < n; ++i) {
    const double r = s.f[i] - mean_f - slope * (x[i] - mean_x);
    rest += s.weight[i] * r * r;
  }
  fit.sigma = std::sqrt(double(n) * rest / std::max(1.0, double(n) - unknowns));
  return fit;
}

/// The order of the least spread: a scan, then golden sections.
Fit fit_order(const Sizes& s) {
  constexpr int scan = 240, sections = 60;
  constexpr double golden = 0.6180339887498949, step = (most_tried - least_tried) / scan;
  const auto at = [&](double order) { return fit_with(s, order, 3); };
  Fit best = at(least_tried);
  for (int k = 1; k <= scan; ++k)
    if (const Fit fit = at(least_tried + k * step); fit.sigma < best.sigma) best = fit;
  double lo = std::max(least_tried, best.order - step), hi = std::min(most_tried, best.order + step);
  for (int k = 0; k < sections; ++k) {
    const double a = hi - golden * (hi - lo), b = lo + golden * (hi - lo);
    if (at(a).sigma < at(b).sigma)
      hi = b;
    else
      lo = a;
  }
  const Fit fine = at(0.5 * (lo + hi));
  return fine.sigma < best.sigma ? fine : best;
}

/// The one of less spread of `fit` with all sizes alike and with the finer the heavier.
template <class F>
Fit of_either_weight(Sizes& s, const F& fit) {
  s.weight.assign(s.h.size(), 1 / double(s.h.size()));
  const Fit alike = fit();
  double sum = 0;
  for (double h : s.h) sum += 1 / h;
  for (size_t i = 0; i < s.h.size(); ++i) s.weight[i] = 1 / (s.h[i] * sum);
  const Fit by_size = fit();
  return by_size.sigma < alike.sigma ? by_size : alike;
}

bool swings(const std::vector<double>& f) {
  for (size_t i = 2; i < f.size(); ++i)
    if ((f[i] - f[i - 1]) * (f[i - 1] - f[i - 2]) < 0) return true;
  return false;
}

/// Why nothing is extrapolated.
std::string not_asymptotic(const Fit& fit, const std::vector<double>& f) {
  std::string why = fmt::format("observed order {:.2g}, which the method does not have", fit.order);
  if (swings(f))
    why = "swings from size to size";
  else if (fit.order < lowest_order)
    why = "does not settle as cells shrink";
  return why + ": not in the asymptotic range";
}

/// With an order that is given.
Fit of_order(Sizes& s, double order) {
  return of_either_weight(s, [&] { return fit_with(s, order, 2); });
}

/// Up to twice the finest, three at least: near enough together for orders 1 and 2 to look alike.
Sizes finest_of(const Sizes& s) {
  size_t n = 3;
  while (n < s.h.size() && s.h[n] <= 2 * s.h[0] * (1 + 1e-6)) ++n;
  return {{s.h.begin(), s.h.begin() + int(n)}, {s.f.begin(), s.f.begin() + int(n)}, {}};
}

double to_limit(const Sizes& s, const Fit& fit) { return std::fabs(s.f[0] - fit.limit); }
double spread(const Sizes& s, const Fit& fit) { return fit.sigma + std::fabs(s.f[0] - fit.at_finest); }

/// From three sizes on.
void fit_law(Sizes& s, Extrapolation& e) {
  Fit fit = of_either_weight(s, [&] { return fit_order(s); });
  const auto [least, most] = std::minmax_element(s.f.begin(), s.f.end());
  const double change = (*most - *least) / double(s.f.size() - 1);
  const bool of_the_method = fit.order >= lowest_order && fit.order <= highest_order * (1 + 1e-6);
  if (fit.order > least_tried * 1.01 && fit.order < most_tried * 0.99) e.order = fit.order;
  e.asymptotic = of_the_method && fit.sigma < change;
  e.says = e.asymptotic ? fmt::format("observed order {:.2g}", fit.order) : not_asymptotic(fit, s.f);
  const bool above_first = fit.order > 1;
  if (!of_the_method) {
    const Fit first = of_order(s, 1), second = of_order(s, 2);
    fit = first.sigma <= second.sigma ? first : second;
  }
  if (fit.sigma < change)
    e.error = (of_the_method ? safety_sure : safety_unsure) * to_limit(s, fit) + spread(s, fit);
  else
    e.error = safety_unsure * fit.sigma / change * (to_limit(s, fit) + spread(s, fit));
  if (above_first) {
    Sizes finest = finest_of(s);
    const Fit first = of_order(finest, 1);
    e.error = std::max(*e.error, to_limit(finest, first) + spread(finest, first));
  }
  if (e.asymptotic) e.extrapolated = fit.limit;
}

}  // namespace

Extrapolation extrapolate(std::span<const double> cell_mm, std::span<const double> value, double noise) {
  if (cell_mm.empty() || cell_mm.size() != value.size())
    throw InputError("", 0, "cell sizes and values of the same number, at least one, were expected");
  std::vector<size_t> order(cell_mm.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return cell_mm[a] < cell_mm[b]; });
  Sizes s;
  for (size_t i : order) {
    if (!(cell_mm[i] > 0) || !std::isfinite(cell_mm[i]) || !std::isfinite(value[i]) ||
        (!s.h.empty() && cell_mm[i] == s.h.back()))
      throw InputError("", 0, "positive, different cell sizes and finite values were expected");
    s.h.push_back(cell_mm[i]), s.f.push_back(value[i]);
  }
  const size_t n = s.h.size();
  Extrapolation e;
  e.value = s.f[0];
  if (n == 1) {
    e.says = "one cell size: no estimate";
    return e;
  }
  if (n == 2) {
    e.error = std::max(noise, safety_unsure * std::fabs(s.f[1] - s.f[0]) / (s.h[1] / s.h[0] - 1));
    e.says = "two cell sizes: order 1 taken for granted";
    return e;
  }
  const auto [least, most] = std::minmax_element(s.f.begin(), s.f.end());
  if (*most - *least <= noise) {
    e.error = noise;
    e.says = "changes no more than the solver's own error";
    return e;
  }
  fit_law(s, e);
  e.error = std::max(noise, *e.error);
  return e;
}

}  // namespace limberg
