#include "app/result/error_goal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "sim/measure/table.h"

namespace limberg {

namespace {

// What a surgeon asks of a closure (sim/measure/table.h).
constexpr std::string_view kFigures[] = {"closure_force_N",    "suture_force_max_N", "dog_ear_mm",
                                         "wound_gape_mean_mm", "stress_p95_kPa",     "elongation"};

}  // namespace

bool ErrorGoal::met() const {
  return !rows_.empty() && std::all_of(rows_.begin(), rows_.end(), [](const GoalRow& r) { return r.met(); });
}

bool ErrorGoal::go_on(std::span<const SizedFigures> runs, double solve_s) {
  took_s_.push_back(solve_s);
  const size_t n = took_s_.size();
  if (n >= 3) {
    rows_.clear();
    for (const FigureError& e : discretisation_errors(runs)) {
      if (std::find(std::begin(kFigures), std::end(kFigures), e.name) == std::end(kFigures)) continue;
      const double value = e.estimate.value;
      double allowed = share_ * std::abs(value);
      if (find_measure(e.name)->across == Across::length) allowed = std::max(allowed, kGoodLength_mm);
      rows_.push_back({e.name, value, e.estimate.error.value_or(INFINITY), allowed});
    }
    if (met()) {
      why_ = "every figure is as near as was asked for";
      return false;
    }
    if (rows_.empty()) {
      why_ = "the operation has no figure that depends on the lattice";
      return false;
    }
  }
  if (n >= size_t(kMostSizes)) {
    why_ = fmt::format("{} sizes were tried", kMostSizes);
    return false;
  }
  const double next_s =
      n >= 2 && took_s_[n - 2] > 0 ? took_s_[n - 1] * std::max(1.0, took_s_[n - 1] / took_s_[n - 2]) : took_s_[n - 1];
  if (next_s > limit_s_) {
    why_ = fmt::format("cells of {:.2f} mm would take about {:.0f} s, and {:g} s are allowed (--limit-s)",
                       next_mm_ / 1.4142135623730951, next_s, limit_s_);
    return false;
  }
  next_mm_ /= 1.4142135623730951;
  return true;
}

std::optional<double> parse_share(const std::string& text) {
  char* end = nullptr;
  double x = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || !std::isfinite(x)) return {};
  std::string_view rest(end);
  while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
  if (rest == "%")
    x /= 100;
  else if (!rest.empty())
    return {};
  if (!(x >= 0.001 && x <= 1)) return {};
  return x;
}

}  // namespace limberg
