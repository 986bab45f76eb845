#include "app/assembly/orders.h"

#include <algorithm>
#include <charconv>

#include "sim/base/error.h"
#include "sim/commands/kinds.h"

namespace limberg {

Script reordered(const Script& script, const std::string& how) {
  std::vector<size_t> at;  // of the lines that sew
  for (size_t i = 0; i < script.lines.size(); ++i) {
    const Command& c = script.lines[i].command;
    const int line = script.lines[i].line;
    if (sews(c)) at.push_back(i);
    if (looks_back(c))
      throw InputError(
          script.name, line,
          std::string(action_name(c)) + " depends on the order of what comes before it; expected a script without it");
  }
  const size_t n = at.size();
  if (n < 2) throw InputError(script.name, 0, "has fewer than two suture lines; expected a script that closes a wound");
  std::vector<size_t> order;
  if (how == "as-written" || how == "reversed") {
    for (size_t i = 0; i < n; ++i) order.push_back(how == "reversed" ? n - 1 - i : i);
  } else if (how == "alternating") {
    for (size_t i = 0; i < n; ++i) order.push_back(i % 2 ? n - 1 - i / 2 : i / 2);
  } else {
    for (const char *p = how.data(), *end = p + how.size(); p <= end;) {
      size_t k = 0;
      const auto r = std::from_chars(p, end, k);
      if (r.ec != std::errc() || (r.ptr != end && *r.ptr != '-') || k < 1 || k > n ||
          std::find(order.begin(), order.end(), k - 1) != order.end())
        throw InputError(script.name, 0,
                         "--orders " + how + "; expected as-written, reversed, alternating or each of 1 to " +
                             std::to_string(n) + " once, as 2-1-3");
      order.push_back(k - 1);
      p = r.ptr + 1;
      if (r.ptr == end) break;
    }
    if (order.size() != n)
      throw InputError(script.name, 0,
                       "--orders " + how + " names " + std::to_string(order.size()) + " of " + std::to_string(n) +
                           " suture lines; expected each once");
  }
  Script out = script;
  for (size_t i = 0; i < n; ++i) out.lines[at[i]].command = script.lines[at[order[i]]].command;
  return out;
}

}  // namespace limberg
