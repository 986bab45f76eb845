#include "app/study/uncertainty.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>

#include "app/report/parts.h"
#include "app/study/sensitivity.h"
#include "app/words/words.h"
#include "sim/base/error.h"

namespace limberg::study {

namespace {

constexpr size_t kMostSampled = 100'000;

double of_five_digits(double v) { return std::strtod(fmt::format("{:.5g}", v).c_str(), nullptr); }

size_t parameter_at(const Family& family, const std::string& name) {
  size_t i = 0;
  while (family.parameters[i].name != name) ++i;
  return i;
}

/// "flap_angle 60, cell_mm 5": those of its values that differ between cases.
std::string setting_of(const Family& family, const std::vector<Values>& cases, const Values& one) {
  std::string text;
  for (size_t i = 0; i < one.size(); ++i)
    if (std::any_of(cases.begin(), cases.end(), [&](const Values& v) { return v[i] != one[i]; }))
      text += fmt::format("{}{} {:g}", text.empty() ? "" : ", ", family.parameters[i].name, one[i]);
  return text;
}

/// The figures that the study is about.
std::vector<std::string> outcomes_of(const Family& family, const std::vector<Row>& rows) {
  if (!family.outcomes.empty()) return family.outcomes;
  std::vector<std::string> out;
  if (!rows.empty())
    for (const auto& [name, v] : rows[0].figures)
      if (std::none_of(family.parameters.begin(), family.parameters.end(),
                       [&, n = name](const Parameter& p) { return p.name == n; }))
        out.push_back(name);
  return out;
}

/// A figure at the points of the design; not a number where the member failed.
std::vector<double> figure_at(const SampledStudy& study, const SampledCase& one, const std::vector<Row>& rows,
                              const std::vector<size_t>& row_of, const std::string& figure) {
  std::vector<double> of_member(study.members.size(), std::numeric_limits<double>::quiet_NaN());
  for (size_t r = 0; r < rows.size(); ++r) of_member[row_of[r]] = rows[r].at(figure);
  std::vector<double> out;
  for (const size_t m : one.member_of) out.push_back(of_member[m]);
  return out;
}

ResultBand band_of(const SampledStudy& study, const std::string& figure, const std::vector<double>& y) {
  const Design& d = study.design;
  std::vector<double> plain(y.begin(), y.begin() + std::ptrdiff_t(d.independent()));
  std::erase_if(plain, [](double v) { return !std::isfinite(v); });
  ResultBand band;
  band.figure = figure;
  band.members = int64_t(plain.size());
  if (plain.empty()) return band;
  band.low = quantile(plain, 0.05), band.median = quantile(plain, 0.5), band.high = quantile(plain, 0.95);
  if (!d.blocks) return band;
  const auto part = [&](size_t k) {
    const auto from = y.begin() + std::ptrdiff_t(k * d.n);
    return std::vector<double>(from, from + std::ptrdiff_t(d.n));
  };
  std::vector<std::vector<double>> ab;
  for (size_t i = 0; i < d.d; ++i) ab.push_back(part(2 + i));
  const Shares shares = sensitivity(part(0), part(1), ab);
  band.rows = int64_t(shares.rows);
  for (size_t i = 0; i < shares.of.size(); ++i) {
    const Share& s = shares.of[i];
    band.shares.push_back(
        {study.ranges.parameters[i].parameter, s.first, s.first_low, s.first_high, s.total, s.total_low, s.total_high});
  }
  return band;
}

}  // namespace

SampledStudy sampled_study(const Family& family, const std::vector<std::string>& settings, const Ranges& ranges,
                           SampleKind kind, size_t n, uint64_t seed, bool sensitivity) {
  SampledStudy out{ranges, kind, seed, {}, {}, {}};
  for (const std::string& s : settings)
    std::erase_if(out.ranges.parameters, [&](const Distribution& d) {
      return d.parameter == parameter_named(family, s.substr(0, s.find('=')));
    });
  // One value of what is sampled, so that the combinations are those of the rest.
  std::vector<std::string> rest = settings;
  for (const Distribution& d : out.ranges.parameters)
    rest.push_back(d.parameter + "=" + fmt::format("{:.17g}", of_five_digits(d.quantile(0.5))));
  const std::vector<Values> cases = members(family, rest);
  if (out.ranges.parameters.empty())
    throw InputError("", 0, "--set names all that ranges " + ranges.name + " sample; expected one left at least");
  out.design = design_of(kind, n, out.ranges.parameters.size(), seed, sensitivity);
  if (cases.size() * out.design.points.size() > kMostSampled)
    throw InputError("", 0,
                     fmt::format("--sample makes {} members; expected {} at most",
                                 cases.size() * out.design.points.size(), kMostSampled));
  std::map<Values, size_t> met;
  for (const Values& fixed : cases) {
    SampledCase one{setting_of(family, cases, fixed), {}};
    for (const UnitPoint& u : out.design.points) {
      Values v = fixed;
      for (size_t i = 0; i < u.size(); ++i) {
        const Distribution& d = out.ranges.parameters[i];
        const size_t at = parameter_at(family, d.parameter);
        const Parameter& p = family.parameters[at];
        const double drawn = d.quantile(u[i]);
        v[at] = std::clamp(d.spread == Spread::whole ? drawn : of_five_digits(drawn), p.lo, p.hi);
      }
      const auto [it, first] = met.emplace(v, out.members.size());
      if (first) out.members.push_back(v);
      one.member_of.push_back(it->second);
    }
    out.cases.push_back(std::move(one));
  }
  return out;
}

ResultUncertainty uncertainty_of(const SampledStudy& study, const Family& family, const std::vector<Row>& rows,
                                 const std::vector<size_t>& row_of) {
  ResultUncertainty out;
  out.ranges = study.ranges.name, out.note = study.ranges.note;
  out.sample = study.kind == SampleKind::sobol ? "sobol" : "latin";
  out.base = int64_t(study.design.n), out.seed = int64_t(study.seed), out.points = int64_t(study.design.points.size());
  for (const Distribution& d : study.ranges.parameters) out.sampled.push_back({d.parameter, d.words(), d.source});
  for (const SampledCase& one : study.cases) {
    ResultCase c{one.setting, {}};
    for (const std::string& figure : outcomes_of(family, rows))
      c.figures.push_back(band_of(study, figure, figure_at(study, one, rows, row_of, figure)));
    out.cases.push_back(std::move(c));
  }
  return out;
}

std::vector<NamedChart> spread_charts(const SampledStudy& study, const Family& family, const std::vector<Row>& rows,
                                      const std::vector<size_t>& row_of) {
  std::vector<NamedChart> out;
  for (const std::string& figure : outcomes_of(family, rows)) {
    NamedChart c;
    c.name = "spread-" + figure, c.title = capital(spoken(figure));
    c.chart.description = "Share of the members below each value: " + spoken(figure);
    c.chart.x.title = spoken(figure), c.chart.y.title = english("members below, %");
    c.chart.y.min = 0, c.chart.y.max = 100;
    c.chart.y_marks = {{5, "5 %"}, {50, "median"}, {95, "95 %"}};
    for (const SampledCase& one : study.cases) {
      std::vector<double> y = figure_at(study, one, rows, row_of, figure);
      y.resize(study.design.independent());
      std::erase_if(y, [](double v) { return !std::isfinite(v); });
      std::sort(y.begin(), y.end());
      ChartSeries s;
      s.name = one.setting;
      for (size_t i = 0; i < y.size(); ++i)
        s.x.push_back(y[i]), s.y.push_back(100 * (double(i) + 0.5) / double(y.size()));
      c.chart.series.push_back(std::move(s));
    }
    out.push_back(std::move(c));
  }
  return out;
}

}  // namespace limberg::study
