#include "tests/bench/fuzz.h"

#include <algorithm>
#include <filesystem>

#include "app/operating_point/cpu_clock.h"
#include "tests/bench/fuzz/generator.h"

namespace limberg::bench {

namespace {

constexpr int kHistory = 24;
const fuzz::Op undo = [] {
  fuzz::Op op;
  op.kind = fuzz::Op::undo;
  return op;
}();

std::string kind_of(const std::string& violation) { return violation.substr(0, violation.find(':')); }

}  // namespace

fuzz::Case make_small(fuzz::Case c, const fuzz::Settings& settings, int runs) {
  const std::string kind = kind_of(c.violation);
  const auto still = [&](fuzz::Case& x) {
    if (runs-- <= 0) return false;
    const fuzz::Outcome o = fuzz::run_case(x, settings);
    if (o.violation.empty() || kind_of(o.violation) != kind) return false;
    x.violation = o.violation;
    if (o.op >= 0 && size_t(o.op) + 1 < x.ops.size()) x.ops.resize(size_t(o.op) + 1);
    return true;
  };
  // Operations keep their numbers, which others refer to: what is left out becomes a cut without triangles, which is
  // refused by rule.
  const auto blank = [](const fuzz::Op& op) { return op.kind == fuzz::Op::cut && op.tri.empty(); };
  bool progress = true;
  while (progress && runs > 0) {
    progress = false;
    for (size_t chunk = std::max<size_t>(1, c.ops.size() / 2); chunk >= 1; chunk /= 2) {
      for (size_t from = 0; from < c.ops.size() && runs > 0; from += chunk) {
        fuzz::Case x = c;
        bool any = false;
        for (size_t i = from; i < std::min(from + chunk, c.ops.size()); ++i)
          if (!blank(x.ops[i])) x.ops[i] = fuzz::Op{}, any = true;
        if (any && still(x)) c = x, progress = true;
      }
      if (chunk == 1) break;
    }
    for (size_t i = 0; i < c.ops.size() && runs > 0; ++i)
      for (size_t t = c.ops[i].tri.size(); t-- > 0 && c.ops[i].tri.size() > 1 && runs > 0;) {
        fuzz::Case x = c;
        x.ops[i].tri.erase(x.ops[i].tri.begin() + ptrdiff_t(t));
        x.ops[i].seed_of_tri.erase(x.ops[i].seed_of_tri.begin() + ptrdiff_t(t));
        if (still(x)) c = x, progress = true;
      }
  }
  return c;
}

FuzzReport fuzz_run(const FuzzSettings& s) {
  FuzzReport report;
  report.seed = s.seed;
  const double start_ms = cpu_ms();
  fuzz::Settings runner_settings = s.runner;
  runner_settings.check_every = s.check_every;
  if (!s.out_dir.empty()) std::filesystem::create_directories(s.out_dir);
  int64_t reported = 0;
  for (uint64_t history = s.first_history; report.operations() < s.operations && !(s.stop && s.stop()); ++history) {
    const bool adversarial = s.adversarial && (!s.generic || history % 2 == 1);
    fuzz::Counts& total = adversarial ? report.adversarial : report.generic;
    fuzz::Random mix{s.seed * 0x100000001b3ull + history};
    fuzz::Generator generator(mix.next(), adversarial);
    const bool divided = s.front_levels > 0 && history / 2 % uint64_t(std::max(1, s.divide_every)) == 0;
    fuzz::Case c = generator.start(divided ? s.front_levels : 0);
    std::string why;
    fuzz::Counts counts;
    {
      fuzz::Runner runner(c, runner_settings);
      const int64_t left = s.operations - report.operations();
      for (int32_t i = 0; i < int32_t(std::min<int64_t>(kHistory, left)) && why.empty(); ++i) {
        c.ops.push_back(generator.next(runner, i));
        const int64_t refused = runner.counts().refused;
        why = runner.apply(c.ops.back());
        if (adversarial || runner.counts().refused == refused) continue;
        FuzzReport::Refusal r{history, i, c.ops.back().name, runner.last_cut.reason, {}};
        if (!s.out_dir.empty()) {
          r.file = s.out_dir + "/refused_" + std::to_string(s.seed) + "_" + std::to_string(history) + "_" +
                   std::to_string(i) + ".json";
          fuzz::write_case(c, r.file);
        }
        report.refusals.push_back(std::move(r));
      }
      counts = runner.counts();
      while (why.empty() && !runner.made().empty()) why = runner.apply(undo);
    }
    total.add(counts);
    if (divided) report.divided += counts.operations;
    if (!why.empty()) {
      c.violation = why;
      if (s.progress) s.progress("violation: " + why + " (history " + std::to_string(history) + ")");
      fuzz::Settings strict = runner_settings;
      strict.check_every = 1;
      FuzzReport::Violation v{why, {}, make_small(c, strict, s.shrink_runs)};
      if (!s.out_dir.empty()) {
        v.file = s.out_dir + "/fuzz_" + std::to_string(s.seed) + "_" + std::to_string(history) + ".json";
        fuzz::write_case(v.small, v.file);
      }
      report.violations.push_back(std::move(v));
      if (int(report.violations.size()) >= s.max_violations) break;
    }
    if (s.progress && report.operations() - reported >= 1000) {
      reported = report.operations();
      const fuzz::Counts& g = report.generic;
      const fuzz::Counts& a = report.adversarial;
      s.progress(std::to_string(reported) + " operations, " + std::to_string(report.violations.size()) +
                 " violations, refused " + std::to_string(g.refused) + " of " + std::to_string(g.cuts) +
                 " generic and " + std::to_string(a.refused) + " of " + std::to_string(a.cuts) + " adversarial cuts; " +
                 std::to_string(report.divided) + " with divided fronts; " +
                 std::to_string(int64_t((cpu_ms() - start_ms) * 1e-3)) + " s of CPU");
    }
  }
  report.cpu_s = (cpu_ms() - start_ms) * 1e-3;
  return report;
}

Result FuzzReport::result() const {
  Result r;
  for (const auto& [name, c] : {std::pair{"general position", &generic}, std::pair{"adversarial", &adversarial}}) {
    const auto row = [&](const char* what, double value, const char* unit) {
      Row x;
      x.name = name;
      x.method = what;
      x.settings = "seed " + std::to_string(seed);
      x.error = value;
      x.error_unit = unit;
      r.rows.push_back(x);
    };
    row("operations", double(c->operations), "");
    row("cuts asked", double(c->cuts), "");
    row("cuts made", double(c->done), "");
    row("nothing to cut", double(c->nothing), "");
    row("refused by rule", double(c->by_rule), "");
    row("refused, blade through itself", double(c->folded), "");
    row("refused, 8 tries", double(c->refused), "");
    row("mean tries", c->done + c->refused ? double(c->tries) / double(c->done + c->refused) : 0, "");
    row("faults put in", double(c->faults), "");
    row("faults rolled back", double(c->faults_rolled_back), "");
    row("full checks", double(c->full_checks), "");
  }
  Row all;
  all.name = "both";
  all.method = "operations with divided fronts";
  all.settings = "seed " + std::to_string(seed);
  all.error = double(divided);
  r.rows.push_back(all);
  all.method = "CPU time of all operations";
  all.time_ms = cpu_s * 1e3;
  all.error = 0;
  r.rows.push_back(all);
  Bar b;
  b.name = "invariants broken";
  b.value = double(violations.size());
  b.bar = 0;
  b.larger_is_better = false;
  b.pass = violations.empty();
  b.source = "no operation may break an invariant";
  r.bars.push_back(b);
  b.name = "refused cuts in general position, share";
  b.value = generic.cuts ? double(generic.refused) / double(generic.cuts) : 0;
  b.bar = 1e-4;
  b.pass = b.value <= b.bar;
  b.source = "one in ten thousand";
  r.bars.push_back(b);
  for (const Refusal& x : refusals)
    r.notes.push_back("refused: " + x.name + ", history " + std::to_string(x.history) + ", operation " +
                      std::to_string(x.op) + ": " + x.reason + (x.file.empty() ? "" : "; written to " + x.file));
  for (const Violation& v : violations)
    r.notes.push_back("violation: " + v.what + (v.file.empty() ? "" : "; written to " + v.file));
  return r;
}

}  // namespace limberg::bench
