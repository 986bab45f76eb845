#include "app/result/settled_forces.h"

#include <limits>

namespace limberg {

SettledForces settled_forces(std::span<const double> residual, std::span<const double> sum_N,
                             std::span<const double> most_N) {
  SettledForces out{{sum_N.begin(), sum_N.end()}, {most_N.begin(), most_N.end()}};
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (size_t i = 0; i < sum_N.size(); ++i) {
    const bool pulls = sum_N[i] > 0, out_of_balance = i < residual.size() && residual[i] > kForcesSettled;
    out.pulling += pulls, out.unsettled += pulls && out_of_balance;
    if (!pulls || !out_of_balance) continue;
    out.sum_N[i] = kNone;
    if (i < out.most_N.size()) out.most_N[i] = kNone;
  }
  return out;
}

}  // namespace limberg
