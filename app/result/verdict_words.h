#pragma once
// A line of a verdict in words, the same on a terminal and on paper.
#include <fmt/format.h>

#include <cmath>
#include <string>

#include "app/result/schema.h"
#include "app/words/words.h"

namespace limberg {

/// How a line of a verdict stands, as result.json says it. told: neither right nor wrong.
namespace light_names {
inline constexpr const char *bad = "bad", *warn = "warn", *told = "told", *good = "good";
}
/// The line that says that a wound is closed; it has a length.
inline constexpr const char* kClosedWhole = english("closed along its whole edge");

/// "wound gape, widest: 11 mm at (3.1, -4.0) mm; at most 2 mm"
inline std::string in_words(const ResultVerdict& v, const Words& w = {}) {
  const std::string unit = v.unit.empty() ? "" : " " + (v.unit == "degrees" ? "°" : v.unit);
  const auto number = [&](double x) { return w("{:.3g}", x + 0.0) + unit; };
  std::string s = w.said(v.what) + ": " + (std::isfinite(v.value) ? number(v.value) : w("not measured"));
  if (!v.place.empty())
    s += v.place.front() == '(' && std::isfinite(v.value) ? " " + w("at {}", w.said(v.place)) : ", " + w.said(v.place);
  if (std::isfinite(v.limit)) s += "; " + w("at most {}", number(v.limit));
  return s;
}

}  // namespace limberg
