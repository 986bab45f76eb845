#include "app/study/study.h"

#include <charconv>
#include <cmath>
#include <limits>

#include "app/study/flaps.h"
#include "app/study/place.h"
#include "app/study/zplasty.h"
#include "sim/base/error.h"

namespace limberg::study {

namespace {

std::string text(double v) {
  char t[40];
  const auto end = std::to_chars(t, t + sizeof t, v);
  return {t, end.ptr};
}

std::string names(const std::vector<Parameter>& parameters) {
  std::string list;
  for (const Parameter& p : parameters) list += (list.empty() ? "" : ", ") + p.name;
  return list;
}

std::string shown(std::string s) {
  if (s.size() > 60) s = s.substr(0, 60) + "...";
  for (char& c : s)
    if (c < ' ' || c == 127) c = '?';
  return s;
}

/// A parameter may be called without its unit: cell for cell_mm.
bool names_it(const std::string& key, const std::string& parameter) {
  if (key == parameter) return true;
  for (const char* unit : {"_mm", "_deg", "_percent"})
    if (parameter.ends_with(unit) && key + unit == parameter) return true;
  return false;
}

std::vector<double> numbers(const std::string& list, const Parameter& p) {
  const std::string want = "; expected numbers from " + text(p.lo) + " to " + text(p.hi) + " with commas between";
  std::vector<double> out;
  for (size_t at = 0; at <= list.size();) {
    const size_t end = std::min(list.find(',', at), list.size());
    double v = 0;
    const auto r = std::from_chars(list.data() + at, list.data() + end, v);
    if (r.ec != std::errc() || r.ptr != list.data() + end)
      throw InputError("", 0,
                       "--set " + p.name + ": \"" + shown(list.substr(at, end - at)) + "\" is not a number" + want);
    if (!std::isfinite(v) || v < p.lo || v > p.hi)
      throw InputError("", 0, "--set " + p.name + ": " + text(v) + " is out of range" + want);
    out.push_back(v);
    at = end + 1;
  }
  return out;
}

}  // namespace

double Row::at(const std::string& name) const {
  for (const auto& [n, v] : figures)
    if (n == name) return v;
  return std::numeric_limits<double>::quiet_NaN();
}

const std::vector<Family>& families() {
  static const std::vector<Family> all{gape(),   stitches(), disc(),     zplasty(),     plate(),
                                       planar(), rhomboid(), fusiform(), tissue_flap(), place_scripts()};
  return all;
}

const Family& find_family(const std::string& name) {
  std::string list;
  for (const Family& f : families()) {
    if (f.name == name) return f;
    list += (list.empty() ? "" : ", ") + f.name;
  }
  throw InputError("", 0, "study " + shown(name) + ": unknown study; expected one of: " + list);
}

std::string parameter_named(const Family& family, const std::string& key) {
  for (const Parameter& p : family.parameters)
    if (names_it(key, p.name)) return p.name;
  return {};
}

std::vector<Values> members(const Family& family, const std::vector<std::string>& settings) {
  std::vector<std::vector<double>> values;
  for (const Parameter& p : family.parameters) values.push_back(p.values);
  std::vector<uint8_t> given(values.size(), 0);
  for (const std::string& s : settings) {
    const size_t equals = s.find('=');
    const std::string key = s.substr(0, equals);
    size_t i = 0;
    while (i < values.size() && !names_it(key, family.parameters[i].name)) ++i;
    if (equals == std::string::npos || i == values.size())
      throw InputError("", 0,
                       "--set " + shown(s) + ": no such setting of study " + family.name +
                           "; expected KEY=V1,V2,... with one of: " + names(family.parameters));
    if (given[i]) throw InputError("", 0, "--set " + key + " is given twice; expected each key once");
    given[i] = 1;
    values[i] = numbers(s.substr(equals + 1), family.parameters[i]);
  }
  size_t count = 1;
  for (const auto& v : values) {
    count *= v.size();
    if (count > kMostMembers)
      throw InputError(
          "", 0,
          "study " + family.name + ": more than " + std::to_string(kMostMembers) + " members; expected fewer values");
  }
  std::vector<Values> out;
  for (size_t m = 0; m < count; ++m) {
    Values row(values.size());
    size_t rest = m;
    for (size_t i = values.size(); i-- > 0;) row[i] = values[i][rest % values[i].size()], rest /= values[i].size();
    out.push_back(std::move(row));
  }
  return out;
}

Bar at_most(std::string name, double value, double bar, std::string source) {
  return {std::move(name), value, false, bar, false, value <= bar, std::move(source)};
}
Bar at_least(std::string name, double value, double bar, std::string source) {
  return {std::move(name), value, false, bar, true, value >= bar, std::move(source)};
}

std::string csv(const std::vector<Row>& rows) {
  std::string out;
  if (rows.empty()) return out;
  for (const auto& [name, v] : rows[0].figures) out += (out.empty() ? "" : ",") + name;
  out += "\n";
  for (const Row& r : rows) {
    std::string line;
    for (const auto& [name, v] : r.figures) line += (line.empty() ? "" : ",") + (std::isfinite(v) ? text(v) : "");
    out += line + "\n";
  }
  return out;
}

}  // namespace limberg::study
