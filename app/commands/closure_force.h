#pragma once
// How hard the stitches pull after each act of an operation: in result.json (`closure`) and as a chart.
#include <string>
#include <utility>
#include <vector>

#include "app/assembly/operation.h"
#include "app/result/output.h"
#include "app/result/tables.h"

namespace limberg {

/// One pair of lines for each run: the sum of its stitches and the largest. A run without a name is the only one.
LineChart closure_chart(const std::vector<std::pair<std::string, const std::vector<ClosureForce>*>>& runs);
/// `closure` and its chart.
void fill_closure(Result& r, const std::vector<ClosureForce>& closure);

}  // namespace limberg
