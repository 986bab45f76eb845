#include "app/commands/closure_force.h"

namespace limberg {

LineChart closure_chart(const std::vector<std::pair<std::string, const std::vector<ClosureForce>*>>& runs) {
  LineChart c;
  c.description = "Sum of the stitches' forces at rest after each action, and the largest of them";
  c.x.title = "line of the script", c.y.title = "N";
  for (const auto& [name, closure] : runs) {
    ChartSeries sum, most;
    sum.name = name.empty() ? "sum of all stitches" : name + ": sum",
    most.name = name.empty() ? "largest stitch" : name + ": largest";
    sum.markers = most.markers = true;
    for (const ClosureForce& f : *closure) {
      sum.x.push_back(f.line), sum.y.push_back(f.sum_N);
      most.x.push_back(f.line), most.y.push_back(f.max_N);
    }
    c.series.push_back(std::move(sum)), c.series.push_back(std::move(most));
  }
  return c;
}

namespace {

/// closure: the stitches after an act.
struct ResultClosure {
  int64_t line;
  MaybeText action;
  int64_t stitches;
  double sum_N, max_N;
  int64_t max_id;
};
void fields(ResultClosure& x, auto&& f) {
  f("line", x.line), f("action", x.action), f("stitches", x.stitches), f("sum_N", x.sum_N), f("max_N", x.max_N);
  f("max_id", x.max_id);
}

}  // namespace

void fill_closure(Result& r, const std::vector<ClosureForce>& closure) {
  for (const ClosureForce& c : closure)
    append(r, "/closure", ResultClosure{c.line, c.action, c.stitches, c.sum_N, c.max_N, c.max_id});
  if (!closure.empty()) add_chart(r, "Closure force over the operation", closure_chart({{"", &closure}}));
}

}  // namespace limberg
