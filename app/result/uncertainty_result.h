#pragma once
// uncertainty of a sampled study in result.json: what was sampled, and per case (a combination of the settings that
// were not) each figure's band and what makes its variance.
#include <string>
#include <vector>

#include "app/result/schema.h"

namespace limberg {

/// uncertainty/sampled: a parameter and how it was spread.
struct ResultSampled {
  std::string parameter, distribution, source;
};
template <class F>
void fields(ResultSampled& x, F&& f) {
  f("parameter", x.parameter), f("distribution", x.distribution), f("source", x.source);
}

/// uncertainty/cases/N/figures/M/shares: sensitivity.h says of what; low and high hold 95 % of bootstrap draws.
struct ResultShare {
  std::string parameter;
  Maybe first, first_low, first_high, total, total_low, total_high;
};
template <class F>
void fields(ResultShare& x, F&& f) {
  f("parameter", x.parameter), f("first", x.first), f("first_low", x.first_low), f("first_high", x.first_high);
  f("total", x.total), f("total_low", x.total_low), f("total_high", x.total_high);
}

/// uncertainty/cases/N/figures: 5 % of the members lie below low, half below median, 95 % below high.
struct ResultBand {
  std::string figure;
  Maybe low, median, high;
  MaybeCount members, rows;  // rows of the design that the shares are of
  std::vector<ResultShare> shares;
};
template <class F>
void fields(ResultBand& x, F&& f) {
  f("figure", x.figure), f("low", x.low), f("median", x.median), f("high", x.high), f("members", x.members);
  f("rows", x.rows), f("shares", x.shares);
}

/// uncertainty/cases
struct ResultCase {
  std::string setting;
  std::vector<ResultBand> figures;
};
template <class F>
void fields(ResultCase& x, F&& f) {
  f("setting", x.setting), f("figures", x.figures);
}

/// uncertainty
struct ResultUncertainty {
  std::string ranges, note, sample;
  MaybeCount base, seed, points;  // points: of the design, in each case
  std::vector<ResultSampled> sampled;
  std::vector<ResultCase> cases;
};
template <class F>
void fields(ResultUncertainty& x, F&& f) {
  f("ranges", x.ranges), f("note", x.note), f("sample", x.sample), f("base", x.base), f("seed", x.seed);
  f("points", x.points), f("sampled", x.sampled), f("cases", x.cases);
}

}  // namespace limberg
