// Histories of acts on patients, and what to do about those that break something.
#include <filesystem>
#include <fstream>

#include "tests/bench/fuzz/world_generator.h"

namespace limberg::fuzz {

WorldFuzzReport world_fuzz(const WorldFuzzSettings& s) {
  constexpr int kHistory = 16;
  WorldFuzzReport report;
  if (!s.out_dir.empty()) std::filesystem::create_directories(s.out_dir);
  for (uint64_t history = 0; report.counts.acts < s.acts && int(report.violations.size()) < s.max_violations;
       ++history) {
    Random mix{s.seed * 0x100000001b3ull + history};
    WorldGenerator generator(mix.next());
    WorldCase c = generator.start();
    std::string why;
    {
      WorldRunner runner(c, s.check_every);
      for (int i = 0; i < kHistory && why.empty(); ++i) {
        c.acts.push_back(generator.next());
        why = runner.apply(c.acts.back());
      }
      if (why.empty()) why = runner.finish();
      report.counts.add(runner.counts());
      report.defects.insert(report.defects.end(), runner.defects().begin(), runner.defects().end());
      if (why.empty() && runner.defects().empty()) continue;
      if (why.empty() && s.out_dir.empty()) continue;
      c.violation = why.empty() ? "refused inside: " + runner.defects()[0] : why;
    }
    // Acts are left out while it still shows the same.
    const auto shows = [&](const WorldCase& x) {
      const WorldOutcome o = run_world_case(x, s.check_every == 0 ? 0 : 1);
      return why.empty() ? !o.defects.empty()
                         : o.violation.substr(0, o.violation.find(':')) == why.substr(0, why.find(':'));
    };
    int runs = s.shrink_runs;
    for (size_t i = c.acts.size(); i-- > 0 && runs > 0; --runs) {
      WorldCase x = c;
      x.acts.erase(x.acts.begin() + long(i));
      if (shows(x)) c = x;
    }
    std::string file;
    if (!s.out_dir.empty()) {
      file = s.out_dir + "/world_" + std::to_string(s.seed) + "_" + std::to_string(history) + ".jsonl";
      std::ofstream(file) << to_text(c);
    }
    if (!why.empty()) report.violations.push_back({why, file});
    if (s.progress) s.progress(c.violation + " (history " + std::to_string(history) + ")");
  }
  return report;
}

bench::Result WorldFuzzReport::result() const {
  bench::Result r;
  for (const auto& [what, value] : {std::pair{"acts", counts.acts},
                                    {"acts done", counts.done},
                                    {"cuts", counts.cuts},
                                    {"acts refused", counts.refused},
                                    {"refused inside", counts.defects},
                                    {"undone", counts.undone},
                                    {"redone", counts.redone},
                                    {"full checks", counts.full_checks}}) {
    bench::Row x;
    x.name = "patients";
    x.method = what;
    x.error = double(value);
    r.rows.push_back(x);
  }
  Bar b;
  b.name = "invariants broken";
  b.value = double(violations.size());
  b.bar = 0;
  b.larger_is_better = false;
  b.pass = violations.empty();
  b.source = "no act may break an invariant";
  r.bars.push_back(b);
  for (const Violation& v : violations)
    r.notes.push_back("violation: " + v.what + (v.file.empty() ? "" : "; written to " + v.file));
  for (const std::string& d : defects) r.notes.push_back("refused inside: " + d);
  return r;
}

}  // namespace limberg::fuzz
