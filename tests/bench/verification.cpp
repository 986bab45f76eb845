#include "tests/bench/verification.h"

#include <cmath>

#include "tests/bench/verification_parts.h"

namespace limberg::bench {

Spring dead_load(const FemModel& m, int32_t id, int32_t node, const Vec3& F, double k, const Vec3& expected) {
  Spring s;
  s.id = id, s.to_world = true, s.k_N_per_mm = k / 1000;
  s.a.node.fill(node), s.a.w[0] = 1;
  s.target_mm = m.X_mm[size_t(node)] + expected + F / k;
  return s;
}

double observed_order(double coarse, double fine, double ratio) {
  return std::log(std::fabs(coarse / fine)) / std::log(ratio);
}

void at_most(Result& out, const std::string& name, double value, double bar, const std::string& source) {
  out.bars.push_back({name, value, false, bar, false, value <= bar, source});
}
void at_least(Result& out, const std::string& name, double value, double bar, const std::string& source) {
  out.bars.push_back({name, value, false, bar, true, value >= bar, source});
}

Result verification(const VerificationSettings& s) {
  Result out;
  const auto part = [&](const char* name, void (*f)(Result&, const VerificationSettings&)) {
    if (std::string(name).find(s.only) == std::string::npos) return;
    if (s.progress) s.progress(name);
    f(out, s);
  };
  part("even states", even_states);
  part("Cook's panel", cook);
  part("thick sphere", thick_sphere);
  part("elastica", elastica);
  part("manufactured solution", manufactured);
  part("bent strip", bent_strip);
  part("CalculiX", calculix_block);
  part("thickness of skin", thickness);
  part("live error", live_error);
  part("live error of operations", live_operations);
  out.notes.push_back(
      "Errors in % of the reference unless the unit says otherwise. Times are CPU time of the Newton reference, not of "
      "the program's minimiser.");
  return out;
}

}  // namespace limberg::bench
