#include "tests/bench/faults.h"

#include <fmt/format.h>

#include <map>

#include "tests/bench/faults/harness.h"

namespace limberg::bench {

namespace {

struct Tally {
  int64_t cases = 0, reached = 0, went_on = 0, told = 0, ended = 0, bad = 0;
  void add(const faults::Judgement& j) {
    ++cases, reached += j.reached;
    (j.status == 0 ? went_on : j.status > 1000 ? ended : told) += 1;
    bad += !j.sound();
  }
};

}  // namespace

Result faults_suite(const FaultsSettings& set) {
  faults::Settings s;
  s.cases = set.cases, s.seed = set.seed, s.progress = set.progress, s.stop = set.stop;
  const std::vector<faults::Judgement> all = faults::run_cases(s);
  std::map<std::pair<size_t, size_t>, Tally> table;  // by kind and call
  int64_t hangs = 0, crashes = 0, speechless = 0, lost = 0, wrong = 0;
  Result out;
  for (const faults::Judgement& j : all) {
    size_t kind = 0;
    while (faults::kinds()[kind].kind != j.of.kind) ++kind;
    table[{kind, j.of.call}].add(j);
    hangs += j.hang, crashes += j.crash, speechless += j.speechless, lost += j.lost, wrong += j.wrong;
    if (!j.sound())
      out.notes.push_back(fmt::format("case {} ({} in {}, LIMBERG_FAULT=\"{}\"{}): {} [{}]", j.of.number,
                                      faults::name_of(j.of.kind), faults::calls()[j.of.call].name, j.of.fault(),
                                      j.of.early ? ", early" : "", j.why, j.said));
  }
  for (const auto& [key, t] : table) {
    Row r;
    r.name = faults::kinds()[key.first].name, r.method = faults::calls()[key.second].name;
    r.settings = fmt::format("{} cases, {} met the fault: {} went on to the end, {} ended in words, {} were ended",
                             t.cases, t.reached, t.went_on, t.told, t.ended);
    r.error = double(t.bad), r.error_unit = "bad", r.reference = "the same call without a fault", r.pass = t.bad == 0;
    out.rows.push_back(r);
  }
  const auto bar = [&](const char* name, int64_t value, double most, bool larger = false) {
    Bar b;
    b.name = name, b.value = double(value), b.bar = most, b.larger_is_better = larger;
    b.pass = larger ? b.value >= most : b.value <= most;
    b.source = "issue 24, item 4: no hang, no crash, no recording without its last second, no wrong success";
    out.bars.push_back(b);
  };
  bar("hangs", hangs, 0), bar("crashes of its own", crashes, 0), bar("ends without a word", speechless, 0);
  bar("recordings that lack more than the last second", lost, 0), bar("wrong successes", wrong, 0);
  bar("seeded cases", int64_t(all.size()), double(set.cases), true);
  return out;
}

}  // namespace limberg::bench
