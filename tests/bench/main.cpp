// limberg_bench: the benchmark suites, which `limberg bench` starts.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>

#include "app/commands/command_line.h"
#include "app/commands/numbers.h"
#include "app/commands/session_command.h"
#include "app/commands/this_call.h"
#include "app/program/version.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/schema.h"
#include "app/result/tables.h"
#include "sim/base/error.h"
#include "sim/lattice/lattice.h"
#include "tests/bench/suite.h"

namespace limberg {

namespace {

struct Options {
  std::string suite;
  bench::SuiteOptions with;
  CommonOptions common;
};

void print(const bench::Result& b) {
  std::printf("%-26s %-38s %12s %14s  %s\n", "case", "method", "time ms", "error", "settings");
  for (const bench::Row& r : b.rows)
    std::printf("%-26s %-38s %1s%11.2f %9.3g %-4s  %s%s\n", r.name.c_str(), r.method.c_str(), r.at_least ? ">" : "",
                r.time_ms, r.error, r.error_unit.c_str(), r.settings.c_str(), r.pass ? "" : " FAIL");
  std::printf("\n%-62s %10s %10s\n", "bar", "value", "bar");
  for (const Bar& x : b.bars)
    std::printf("%-62s %1s%9.3g %1s%9.3g  %s\n", x.name.c_str(), x.at_least ? ">" : "", x.value,
                x.larger_is_better ? ">" : "<", x.bar, x.pass ? "pass" : "FAIL");
  for (const std::string& n : b.notes) std::printf("%s\n", n.c_str());
}

void fill(Result& out, const bench::Result& b) {
  out.set_empty_list("/rows");
  for (const bench::Row& r : b.rows) append(out, "/rows", r);
  out.set_empty_list("/bars");
  for (const Bar& x : b.bars) append(out, "/bars", x);
  for (size_t i = 0; i < b.notes.size(); ++i) out.set("/notes/" + std::to_string(i), b.notes[i]);
}

/// What was measured, as a table of the report.
ResultTable measured(const bench::Result& b) {
  ResultTable t;
  t.title = "What was measured";
  for (const std::string& note : b.notes)
    t.about += (t.about.empty() ? "" : " ") + note + (note.empty() || note.back() == '.' ? "" : ".");
  t.columns = {"case", "method", "CPU time, ms", "error", "settings"};
  for (const bench::Row& r : b.rows)
    t.rows.push_back({r.name, r.method, (r.at_least ? "> " : "") + short_number(r.time_ms),
                      short_number(r.error, 3) + " " + r.error_unit, r.settings});
  return t;
}

/// "a, b or c"
std::string any_of(const std::vector<std::string>& names) {
  std::string s;
  for (size_t i = 0; i < names.size(); ++i) s += (i == 0 ? "" : i + 1 < names.size() ? ", " : " or ") + names[i];
  return s;
}

int run(Options o) {
  o.common.prepare();
  const std::span<const bench::Suite> all = bench::suites();
  const auto suite = std::find_if(all.begin(), all.end(), [&](const bench::Suite& s) { return o.suite == s.name; });
  if (suite == all.end()) {
    std::vector<std::string> names;
    for (const bench::Suite& s : all) names.push_back(s.name);
    throw InputError("", 0, "bench " + o.suite + ": unknown suite; expected " + any_of(names));
  }
  if (o.with.operations < 0) throw InputError("", 0, "--operations is negative; a number of operations was expected");
  if (!o.with.scene.empty() && !suite->takes_scene)
    throw InputError("", 0, "bench " + o.suite + " takes no scene; it makes its own at several sizes");
  o.with.out_dir = o.common.out_dir;
  if (!o.with.out_dir.empty()) prepare_folder(o.with.out_dir);
  Progress progress("bench " + o.suite);
  o.with.progress = [&](const std::string& line) { progress.note(line); };
  const bench::SuiteOutcome outcome = suite->run(o.with);
  progress.clear();
  if (!o.with.only.empty() && outcome.result.rows.empty())
    throw InputError(
        "", 0,
        "bench " + o.suite + ": --only " + o.with.only + " names no part; expected one of those that --help lists");
  print(outcome.result);
  Result result("bench", outcome.scene);
  result.set("/suite", o.suite);
  result.set("/quick", o.with.quick);
  const std::string call = this_call();  // "limberg speed --quick"
  result.set("/reproduce", "limberg bench" + call.substr(std::min(call.size(), std::string("limberg").size())));
  if (outcome.also) outcome.also(result);
  fill(result, outcome.result);
  for (const auto& [title, chart] : outcome.charts) add_chart(result, title, chart);
  bool ok = outcome.interrupted.empty();
  for (const Bar& x : outcome.result.bars) ok &= x.pass;
  if (!outcome.interrupted.empty()) std::fprintf(stderr, "limberg: interrupted %s\n", outcome.interrupted.c_str());
  result.set_ok(ok);
  add_table(result, measured(outcome.result));
  leave_result(result, o.common);
  return ok ? kDone : kGoalMissed;
}

/// "accuracy: error against run time ...; contact: ..."
std::string listed(const char* bench::Suite::*what) {
  std::string s;
  for (const bench::Suite& x : bench::suites())
    if ((x.*what)[0]) s += (s.empty() ? "" : "; ") + std::string(x.name) + ": " + x.*what;
  return s;
}

int run_main(int argc, char** argv) {
  CLI::App app("Measure against bars, in CPU time, in one process", "limberg bench");
  app.set_version_flag("--version", program_name());
  Chosen chosen;
  auto o = std::make_shared<Options>();
  CLI::App* c = &app;
  c->add_option("SUITE", o->suite, listed(&bench::Suite::measures))->required();
  c->add_option("SCENE", o->with.scene, "Scene, for suites that take one; live: a recording");
  c->add_flag("--quick", o->with.quick, "The smallest size only");
  c->add_flag("--no-peers", o->with.no_peers, "stability: only what is under test");
  c->add_option("--only", o->with.only, "The parts whose name contains this. Parts of " + listed(&bench::Suite::parts))
      ->type_name("TEXT");
  c->add_option("--budget-ms", o->with.budget_ms, "accuracy: time of a frame (default: half the scene's step)")
      ->type_name("MS")
      ->check(number_from(0.001, 1e5));
  c->add_option("--limit-s", o->with.limit_s, "accuracy: CPU time after which no new trial begins (default 150)")
      ->type_name("S")
      ->check(number_from(0.1, 1e6));
  c->add_option("--minutes", o->with.minutes, "soak: for so long (default 120; --quick 2), a third of it live")
      ->type_name("N")
      ->check(number_from(0.01, 1e5));
  c->add_option("--operations", o->with.operations,
                "fuzz, soak, live: how many (default 20000; 10000 acts; 10 runs of each; --quick 2000, 1000, 1)")
      ->type_name("N")
      ->check(whole_from(1, 1'000'000'000'000));
  c->add_flag(
      "--world", o->with.world,
      "fuzz: whole acts on patients (strokes at once and drawn, sheets, plugs, stitches, undo) instead of cuts");
  c->add_flag("--devices", o->with.devices, "fuzz: damaged serial bytes, packets and logs instead of cuts");
  c->add_flag("--readers", o->with.readers,
              "fuzz: damaged images, surfaces, meshes and scenes instead of cuts (default 100000 cases)");
  c->add_option("--seed", o->with.seed, "fuzz: of the operations (default 1)")
      ->type_name("N")
      ->check(whole_from(0, 9'007'199'254'740'992));
  c->add_option("--front-levels", o->with.front_levels,
                "fuzz: how often lattice cells at the end of a cut are divided (default 0)")
      ->check(whole_from(0, kLevels));
  c->add_option("--divide-every", o->with.divide_every,
                "fuzz: with --front-levels, divide cells in one of so many histories only (default 1: in all)")
      ->check(whole_from(1, 1000));
  c->add_option("--check-every", o->with.check_every, "fuzz: operations between checks of everything (default 1)")
      ->check(whole_from(1, 1000));
  o->common.add_out(*c), o->common.add_json(*c), o->common.add_workers(*c);
  c->footer("Example: limberg bench speed --quick --json out/bench.json");
  c->callback([o, &chosen] { chosen = [o] { return run(*o); }; });
  return run_command_line(app, {argv + 1, argv + argc}, chosen, "");
}

}  // namespace
}  // namespace limberg

int main(int argc, char** argv) {
  return limberg::run_framed([&] { return limberg::run_main(argc, argv); });
}
