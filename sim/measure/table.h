#pragma once
// Every figure of `metrics` in result.json, once: name, unit, words, definition, error, value and limits. The result,
// the
// estimates of the lattice's error, lessons, comparisons, the report's limits and `limberg measures` read this table.
//
// A figure is added by a field of Metrics with its computation (metrics.h, metrics.cpp) and an entry in table.cpp.
#include <optional>
#include <span>
#include <string_view>

#include "sim/measure/metrics.h"

namespace limberg {

/// What a figure is judged by. Above `warn` a reader is warned, above `bad` the figure is bad.
struct MeasureLimits {
  double warn = 0, bad = 0;
  const char* source = "";  // publication, or why
};

/// How a figure is compared between lattices (extrapolation.h).
enum class Across : uint8_t { none, figure, length };  // length: nothing below the distance to equilibrium counts

struct Measure {
  const char* name;   // in result.json; entries of a list have "list[].name" and no value here
  const char* unit;   // "": a number
  const char* words;  // as a report says it
  const char* definition;
  const char* error;                                         // where the figure's error comes from
  std::optional<double> (*value)(const Metrics&) = nullptr;  // nothing: the figure does not apply
  Across across = Across::none;
  std::optional<MeasureLimits> limits = {};
  bool counts = false;    // a whole number of things
  bool of_bones = false;  // of a head, which fills it in (app/head/report.cpp); no value here
};

std::span<const Measure> measure_table();
/// Null: there is none of this name.
const Measure* find_measure(std::string_view name);

/// Limits that more than one part needs by themselves.
inline constexpr MeasureLimits kSutureForce_N{
    2.5, 5.0,
    "Larrabee, Holloway, Sutton 1984: necrosis rises above 250 g; knots of USP "
    "5-0 to 4-0 thread pull out from 5 N"};
inline constexpr MeasureLimits kClosureForce_N{15.0, 15.0,
                                               "Lear 2019: largest clinically acceptable closure force (scalp)"};
inline constexpr MeasureLimits kWoundGape_mm{
    kOpen_mm, kOpen_mm, "Hollander et al. 1995: wound margin separation above 2 mm is a fault of a closure"};
inline constexpr MeasureLimits kDogEar_mm{
    4, 4, "a dog-ear of up to 4 mm may be watched instead of excised (PubMed 28930788)"};
inline constexpr MeasureLimits kSutureGap_mm{0.2, 0.2, "bites this near count as met; of no publication"};

}  // namespace limberg
