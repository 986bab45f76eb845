#pragma once
// What a benchmark suite returns; the command turns it into the rows and bars of result.json.
#include <string>
#include <vector>

#include "app/result/schema.h"

namespace limberg::bench {

struct Row {
  std::string name;  // the case: what was solved
  std::string method;
  std::string settings;
  double time_ms = 0;     // process CPU time
  bool at_least = false;  // stopped at its limit: the true time is longer (print as ">")
  double error = 0;
  std::string error_unit;
  std::string reference;  // what the error is measured against
  bool pass = true;       // what is under test reached what was asked; a baseline never fails, see at_least
};

template <class F>
void fields(Row& x, F&& f) {
  f("case", x.name), f("method", x.method), f("settings", x.settings), f("time_ms", x.time_ms);
  f("at_least", x.at_least), f("error", x.error), f("error_unit", x.error_unit), f("reference", x.reference);
  f("pass", x.pass);
}

struct Result {
  std::vector<Row> rows;
  std::vector<Bar> bars;
  std::vector<std::string> notes;  // what a reader has to know to judge the figures
};

}  // namespace limberg::bench
