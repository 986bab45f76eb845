#pragma once
// Tables and charts on their way into result.json and from there into the report, whatever the command.
#include <string>
#include <vector>

#include "app/report/svg_chart.h"
#include "app/result.h"

namespace limberg {

struct ResultTable {
  std::string title, about;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  // as the columns
};

/// Appended to `tables` and `charts`; `number`: how many stand there already.
void add_table(Result& result, int number, const ResultTable& table);
void add_chart(Result& result, int number, const std::string& title, const LineChart& chart);

/// At most `digits` significant digits.
std::string short_number(double v, int digits = 4);

}  // namespace limberg
