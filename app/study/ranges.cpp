#include "app/study/ranges.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "app/program/shipped.h"
#include "app/scene/toml_table.h"
#include "sim/base/whole_file.h"

namespace limberg::study {

namespace {

constexpr double kOf95 = 1.6448536269514722;  // the standard normal's 95 % quantile

struct SpreadName {
  Spread spread;
  const char* name;
};
constexpr SpreadName kSpreads[] = {{Spread::uniform, "uniform"},
                                   {Spread::log_uniform, "log-uniform"},
                                   {Spread::normal, "normal"},
                                   {Spread::log_normal, "log-normal"},
                                   {Spread::whole, "whole"}};

bool of_logarithm(Spread s) { return s == Spread::log_uniform || s == Spread::log_normal; }
bool of_normal(Spread s) { return s == Spread::normal || s == Spread::log_normal; }

Distribution read_distribution(const toml::table& table, const std::string& path, const Family& family) {
  Table t(&table, "parameter", path);
  Distribution d;
  for (const char* key : {"name", "distribution", "low", "high", "source"})
    if (!t.has(key)) t.fail(key, "is missing; expected name, distribution, low, high and source");
  t.text("name", d.parameter, 60);
  const auto p = std::find_if(family.parameters.begin(), family.parameters.end(),
                              [&](const Parameter& q) { return q.name == d.parameter; });
  if (p == family.parameters.end()) {
    std::string names;
    for (const Parameter& q : family.parameters) names += (names.empty() ? "" : ", ") + q.name;
    t.fail("name", "is no parameter of study " + family.name + "; expected one of: " + names);
  }
  std::string spread;
  t.text("distribution", spread, 60);
  const auto s =
      std::find_if(std::begin(kSpreads), std::end(kSpreads), [&](const SpreadName& k) { return spread == k.name; });
  if (s == std::end(kSpreads))
    t.fail("distribution", "is unknown; expected uniform, log-uniform, normal, log-normal or whole");
  d.spread = s->spread;
  t.real("low", d.low, p->lo, p->hi);
  t.real("high", d.high, p->lo, p->hi);
  if (!(d.low < d.high)) t.fail("high", "does not lie above low; expected low < high");
  if (of_logarithm(d.spread) && d.low <= 0) t.fail("low", "is not above 0; expected so for a logarithm");
  t.text("source", d.source, 2000);
  t.finish();
  return d;
}

}  // namespace

double Distribution::quantile(double u) const {
  constexpr double kEnd = 1e-6;
  u = std::clamp(u, kEnd, 1 - kEnd);
  if (spread == Spread::whole) return std::floor(low) + std::floor(u * (std::floor(high) - std::floor(low) + 1));
  const double a = of_logarithm(spread) ? std::log(low) : low, b = of_logarithm(spread) ? std::log(high) : high;
  double v = a + u * (b - a);
  if (of_normal(spread)) {
    const double normal = std::numbers::sqrt2 * boost::math::erf_inv(2 * u - 1);
    v = 0.5 * (a + b) + 0.5 * (b - a) / kOf95 * normal;
  }
  return of_logarithm(spread) ? std::exp(v) : v;
}

std::string Distribution::words() const {
  for (const SpreadName& k : kSpreads)
    if (k.spread == spread)
      return fmt::format("{}, {:g} to {:g}{}", k.name, low, high, of_normal(spread) ? " for nine in ten" : "");
  return {};
}

Ranges parse_ranges(const std::string& text, const std::string& path, const Family& family) {
  const toml::table root = parse_toml(text, path, "ranges of a tissue");
  Table t(&root, "", path);
  Ranges out;
  std::string study;
  t.text("name", out.name, 60), t.text("note", out.note, 2000), t.text("study", study, 60);
  if (out.name.empty()) t.fail("name", "is missing; expected a name like \"facial skin\"");
  if (study != family.name) t.fail("study", "does not name study " + family.name + "; expected ranges for that");
  const toml::node* list = t.node("parameter");
  t.finish();
  const toml::array* all = list ? list->as_array() : nullptr;
  if (!all || all->empty()) t.fail("parameter", "is missing; expected at least one [[parameter]]");
  for (const toml::node& e : *all) {
    if (!e.is_table()) t.fail("parameter", "is no table; expected [[parameter]]");
    Distribution d = read_distribution(*e.as_table(), path, family);
    for (const Distribution& other : out.parameters)
      if (other.parameter == d.parameter)
        throw InputError(path, int(e.source().begin.line),
                         "parameter " + d.parameter + " stands here for the second time; expected each once");
    out.parameters.push_back(std::move(d));
  }
  return out;
}

Ranges load_ranges(const std::string& name_or_path, const Family& family) {
  std::error_code ec;
  std::string file = name_or_path;
  if (!std::filesystem::exists(file, ec)) file = shipped_file("app/study/ranges/" + name_or_path + ".toml");
  if (file.empty())
    throw InputError(name_or_path, 0, "no such file, nor shipped ranges of that name; expected facial-skin or a file");
  return parse_ranges(read_whole_file(file, size_t(1) << 20), file, family);
}

}  // namespace limberg::study
