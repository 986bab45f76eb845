#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "app/operating_point/cpu_clock.h"
#include "tests/bench/soak/soak.h"

namespace limberg::bench {

namespace {

constexpr double kGrowth = 0.05;  // the issue's: flat within 5 % after the first ten minutes

Bar soak_bar(const std::string& name, double value, double most, const std::string& source) {
  Bar b;
  b.name = name, b.value = value, b.bar = most, b.larger_is_better = false, b.pass = value <= most, b.source = source;
  return b;
}

/// Rounds of one part and scene, those that ended within the first ten minutes of the part first.
struct Course {
  std::vector<const SoakRound*> early, late;
};

std::map<std::pair<std::string, std::string>, Course> courses(const std::vector<SoakRound>& rounds) {
  std::map<std::string, double> began;
  std::map<std::pair<std::string, std::string>, Course> all;
  for (const SoakRound& r : rounds) {
    const double start = began.try_emplace(r.part, r.at_min).first->second;
    Course& c = all[{r.part, r.scene}];
    (r.at_min - start <= kSettledMin || c.early.empty() ? c.early : c.late).push_back(&r);
  }
  return all;
}

double most_of(const std::vector<const SoakRound*>& rounds, double (*value)(const SoakRound&)) {
  double most = 0;
  for (const SoakRound* r : rounds) most = std::max(most, value(*r));
  return most;
}

Times times_of(const std::vector<const SoakRound*>& rounds) {
  Times t;
  for (const SoakRound* r : rounds) t.add(r->cpu_ms);
  return t;
}

}  // namespace

Result judge_soak(const std::vector<SoakRound>& rounds) {
  Result out;
  double trimmed = 0, allocated = 0, slower = 0, noise = 0.02;
  bool lasted = false;
  const auto resident = [](const SoakRound& r) { return r.after.trimmed_mb; };
  const auto handed_out = [](const SoakRound& r) { return r.after.allocated_mb; };
  std::map<std::string, Course> parts;  // a round leaves nothing of its scene: memory is judged over all of them
  for (const auto& [name, c] : courses(rounds)) {
    const Times early = times_of(c.early), late = times_of(c.late);
    Course& all = parts[name.first];
    all.early.insert(all.early.end(), c.early.begin(), c.early.end());
    all.late.insert(all.late.end(), c.late.begin(), c.late.end());
    Row row;
    row.name = name.first + ", " + name.second;
    row.method = fmt::format("{} rounds, {} of them later", c.early.size() + c.late.size(), c.late.size());
    row.time_ms = (c.late.empty() ? c.early : c.late).back()->median_ms;
    row.error = most_of(c.late.empty() ? c.early : c.late, resident), row.error_unit = "MB";
    row.reference = "time: a solver step, by the clock; error: resident memory after a round";
    row.settings =
        fmt::format("first ten minutes: {:.1f} MB, {:.2f} ms CPU a step", most_of(c.early, resident), early.median());
    if (!c.late.empty()) {
      lasted = true;
      row.settings += fmt::format("; later: {:.1f} MB, {:.2f} ms", most_of(c.late, resident), late.median());
      const double first = early.median();
      if (first > 0) slower = std::max(slower, late.median() / first - 1);
      for (const double t : early.ms) noise = std::max(noise, std::fabs(t / first - 1));
    }
    out.rows.push_back(row);
  }
  for (const auto& [part, c] : parts) {
    if (c.late.empty()) continue;
    trimmed = std::max(trimmed, most_of(c.late, resident) / most_of(c.early, resident) - 1);
    allocated = std::max(allocated, most_of(c.late, handed_out) / most_of(c.early, handed_out) - 1);
  }
  std::map<std::string, std::string> hash;
  int64_t other = 0, again = 0, failed = 0;
  for (const SoakRound& r : rounds) {
    failed += !r.as_expected;
    if (r.part != "lockstep") continue;  // a live session has its own interleaving, which its replay repeats
    const auto [it, first] = hash.try_emplace(fmt::format("{} {}", r.scene, r.seed), r.hash);
    if (!first) ++again, other += it->second != r.hash;
  }
  const ProcessState& first = rounds.front().after;
  ProcessState most = first;
  for (const SoakRound& r : rounds) {
    most.files = std::max(most.files, r.after.files), most.threads = std::max(most.threads, r.after.threads);
    most.left = std::max(most.left, r.after.left);
  }
  const std::string ten = fmt::format("in the first {:g} minutes", kSettledMin);
  if (lasted) {
    out.bars.push_back(soak_bar("resident memory after a round, more than " + ten, trimmed, kGrowth, "issue 24"));
    out.bars.push_back(soak_bar("allocated memory after a round, more than " + ten, allocated, kGrowth, "issue 24"));
    out.bars.push_back(soak_bar("CPU time of a step, by scene, more than " + ten, slower, noise,
                                "the largest deviation among those rounds, at least 2 %"));
  } else {
    out.notes.push_back("shorter than ten minutes: memory and times are told, not judged");
  }
  out.bars.push_back(soak_bar(fmt::format("other hashes in {} repeated rounds", again), double(other), 0, "bit-exact"));
  out.bars.push_back(soak_bar("rounds that failed, or whose replay differs", double(failed), 0, "bit-exact"));
  out.bars.push_back(
      soak_bar("open files more than after the first round", double(most.files - first.files), 0, "none"));
  out.bars.push_back(
      soak_bar("threads more than after the first round", double(most.threads - first.threads), 0, "none"));
  out.bars.push_back(soak_bar("temporary files left", double(most.left), 0, "none"));
  return out;
}

std::string soak_csv(const std::vector<SoakRound>& rounds) {
  std::string text =
      "part,scene,seed,at_min,resident_mb,trimmed_mb,allocated_mb,step_median_ms,step_p95_ms,step_cpu_ms,files,threads,"
      "left,hash\n";
  for (const SoakRound& r : rounds)
    text += fmt::format("{},{},{},{:.2f},{:.1f},{:.1f},{:.2f},{:.3f},{:.3f},{:.3f},{},{},{},{}\n", r.part, r.scene,
                        r.seed, r.at_min, r.after.resident_mb, r.after.trimmed_mb, r.after.allocated_mb, r.median_ms,
                        r.p95_ms, r.cpu_ms, r.after.files, r.after.threads, r.after.left, r.hash);
  return text;
}

}  // namespace limberg::bench
