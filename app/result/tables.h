#pragma once
// Tables and charts on their way into result.json and from there into the report, whatever the command.
#include <string>
#include <vector>

#include "app/report/svg_chart.h"
#include "app/result/schema.h"

namespace limberg {

/// Appended to `tables` and `charts`.
void add_table(Result& result, const ResultTable& table);
void add_chart(Result& result, const std::string& title, const LineChart& chart);

/// At most `digits` significant digits.
std::string short_number(double v, int digits = 4);

/// For printing with one decimal: 0 for what would be "-0.0".
inline double unsigned_zero(double v) { return v > -0.05 && v < 0.05 ? 0 : v; }

}  // namespace limberg
