#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "app/assembly/streams.h"
#include "app/commands/command_line.h"
#include "app/commands/numbers.h"
#include "app/commands/session_command.h"
#include "app/commands/this_call.h"
#include "app/operating_point/accuracy.h"
#include "app/operating_point/operating_point.h"
#include "app/program/interrupt.h"
#include "app/program/shipped.h"
#include "app/program/version.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/result.h"
#include "app/result/tables.h"
#include "sim/base/error.h"
#include "sim/lattice/lattice.h"
#include "tests/bench/contact.h"
#include "tests/bench/cutting.h"
#include "tests/bench/devices/fuzz.h"
#include "tests/bench/devices/suite.h"
#include "tests/bench/features.h"
#include "tests/bench/felt_patient.h"
#include "tests/bench/frames.h"
#include "tests/bench/fuzz.h"
#include "tests/bench/fuzz/readers.h"
#include "tests/bench/fuzz/world_runner.h"
#include "tests/bench/head_face.h"
#include "tests/bench/laws.h"
#include "tests/bench/metric.h"
#include "tests/bench/session_latency.h"
#include "tests/bench/simplex.h"
#include "tests/bench/speed.h"
#include "tests/bench/stability.h"
#include "tests/bench/verification.h"

namespace limberg {

namespace {

struct Options {
  std::string suite, scene, only;
  bool quick = false, no_peers = false;
  int front_levels = 0;
  int check_every = 1, divide_every = 1;
  bool world = false;      // fuzz: acts on patients
  bool devices = false;    // fuzz: what devices send
  bool readers = false;    // fuzz: damaged files
  int64_t operations = 0;  // fuzz; 0: 20000, with --quick 2000
  uint64_t seed = 1;
  double budget_ms = 0, limit_s = 150;  // accuracy
  CommonOptions common;
};

void print(const bench::Result& b) {
  std::printf("%-26s %-38s %12s %14s  %s\n", "case", "method", "time ms", "error", "settings");
  for (const bench::Row& r : b.rows)
    std::printf("%-26s %-38s %1s%11.2f %9.3g %-4s  %s%s\n", r.name.c_str(), r.method.c_str(), r.at_least ? ">" : "",
                r.time_ms, r.error, r.error_unit.c_str(), r.settings.c_str(), r.pass ? "" : " FAIL");
  std::printf("\n%-62s %10s %10s\n", "bar", "value", "bar");
  for (const bench::Bar& x : b.bars)
    std::printf("%-62s %1s%9.3g %1s%9.3g  %s\n", x.name.c_str(), x.at_least ? ">" : "", x.value,
                x.larger_is_better ? ">" : "<", x.bar, x.pass ? "pass" : "FAIL");
  for (const std::string& n : b.notes) std::printf("%s\n", n.c_str());
}

void fill(Result& out, const bench::Result& b) {
  out.set_empty_list("/rows");
  for (size_t i = 0; i < b.rows.size(); ++i) {
    const bench::Row& r = b.rows[i];
    const std::string p = "/rows/" + std::to_string(i);
    out.set(p + "/case", r.name);
    out.set(p + "/method", r.method);
    out.set(p + "/settings", r.settings);
    out.set(p + "/time_ms", r.time_ms);
    out.set(p + "/at_least", r.at_least);
    out.set(p + "/error", r.error);
    out.set(p + "/error_unit", r.error_unit);
    out.set(p + "/reference", r.reference);
    out.set(p + "/pass", r.pass);
  }
  out.set_empty_list("/bars");
  for (size_t i = 0; i < b.bars.size(); ++i) {
    const bench::Bar& x = b.bars[i];
    const std::string p = "/bars/" + std::to_string(i);
    out.set(p + "/name", x.name);
    out.set(p + "/value", x.value);
    out.set(p + "/at_least", x.at_least);
    out.set(p + "/bar", x.bar);
    out.set(p + "/larger_is_better", x.larger_is_better);
    out.set(p + "/pass", x.pass);
    out.set(p + "/source", x.source);
  }
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

int run(const Options& o) {
  o.common.prepare();
  const std::vector<std::string> suites = {"accuracy", "contact",   "cutting",     "devices", "features",
                                           "frames",   "fuzz",      "head",        "laws",    "simplex",
                                           "speed",    "stability", "verification"};
  if (std::find(suites.begin(), suites.end(), o.suite) == suites.end())
    throw InputError("", 0, "bench " + o.suite + ": unknown suite; expected " + any_of(suites));
  if (o.operations < 0) throw InputError("", 0, "--operations is negative; a number of operations was expected");
  if (!o.scene.empty() && o.suite != "accuracy" && o.suite != "features" && o.suite != "frames")
    throw InputError("", 0, "bench " + o.suite + " takes no scene; it makes its own at several sizes");
  Progress progress("bench " + o.suite);
  const auto note = [&](const std::string& line) { progress.note(line); };
  bench::Result b;
  bench::FuzzReport fuzzed;
  bench::AccuracyReport accuracy;
  std::vector<std::pair<std::string, LineChart>> charts;
  if (o.suite == "accuracy") {
    catch_interrupts();  // its trials are kept
    bench::AccuracySettings s;
    s.quick = o.quick, s.budget_ms = o.budget_ms, s.limit_s = o.limit_s;
    if (!o.common.out_dir.empty()) {
      prepare_folder(o.common.out_dir);
      s.keep_file = o.common.out_dir + "/accuracy-trials.txt";
    }
    s.progress = note, s.interrupted = interrupted;
    accuracy = bench::accuracy(open_scene(o.scene.empty() ? "rhomboid" : o.scene), s);
    b = accuracy.result();
  } else if (o.suite == "features") {
    b = bench::features(open_scene(o.scene.empty() ? "rhomboid" : o.scene), {o.quick, o.only, note});
  } else if (o.suite == "frames") {
    const Scene scene = open_scene(o.scene.empty() ? "rhomboid" : o.scene);
    const std::string file = shipped_file("recordings/" + scene.name + ".jsonl");
    const Script script = file.empty() ? Script{} : load_script(file);
    b = bench::frames(scene, file.empty() ? nullptr : &script, {o.quick, note});
  } else if (o.suite == "contact") {
    b = bench::contact({o.quick, o.only, note});
  } else if (o.suite == "devices") {
    b = bench::devices_suite({o.quick, o.only, note});
    if (std::string("felt").find(o.only) != std::string::npos)
      bench::add_felt_patient(b, open_scene("rhomboid"), o.quick, note);
    if (std::string("latency").find(o.only) != std::string::npos)
      bench::add_session_latency(b, open_scene("rhomboid"), known_stream("tremor", 5).samples, o.quick, note);
  } else if (o.suite == "verification") {
    b = bench::verification({o.quick, note});
  } else if (o.suite == "speed") {
    bench::SpeedSettings s;
    s.quick = o.quick;
    s.only = o.only;
    s.progress = note;
    b = bench::speed(s);
  } else if (o.suite == "stability") {
    bench::StabilitySettings s;
    s.quick = o.quick;
    s.only = o.only;
    s.peers = !o.no_peers;
    s.progress = note;
    b = bench::stability(s);
  } else if (o.suite == "head") {
    const bench::HeadReport heads = bench::head_suite({o.quick, o.only, note});
    b = heads.result;
    if (!o.common.out_dir.empty()) {
      prepare_folder(o.common.out_dir);
      write_whole_file(o.common.out_dir + "/head-modes.csv", heads.csv());
    }
    for (const std::string& situation : heads.situations()) {
      charts.emplace_back(situation + ": error against run time", heads.chart(situation));
      if (!o.common.out_dir.empty())
        write_whole_file(o.common.out_dir + "/head-modes-" + std::to_string(charts.size()) + ".svg",
                         svg(charts.back().second));
    }
  } else if (o.suite == "simplex") {
    bench::SimplexSettings s;
    s.quick = o.quick;
    s.progress = note;
    b = bench::simplex_suite(s);
  } else if (o.suite == "fuzz" && o.world) {
    fuzz::WorldFuzzSettings s;
    s.acts = o.operations > 0 ? o.operations : o.quick ? 300 : 3000;
    s.seed = o.seed;
    s.out_dir = o.common.out_dir;
    s.progress = note;
    b = fuzz::world_fuzz(s).result();
  } else if (o.suite == "fuzz" && o.devices) {
    bench::DevicesFuzzSettings s;
    s.cases = o.operations > 0 ? o.operations : o.quick ? 120'000 : s.cases;
    s.seed = o.seed;
    s.progress = note;
    b = bench::devices_fuzz(s).result();
  } else if (o.suite == "fuzz" && o.readers) {
    bench::ReadersFuzzSettings s;
    s.cases = o.operations > 0 ? o.operations : o.quick ? 10'000 : s.cases;
    s.seed = o.seed;
    s.out_dir = o.common.out_dir;
    s.progress = note;
    b = bench::readers_fuzz(s, bench::readers()).result();
  } else if (o.suite == "laws") {
    b = bench::laws({o.quick, note});
  } else if (o.suite == "fuzz") {
    bench::FuzzSettings s;
    s.operations = o.operations > 0 ? o.operations : o.quick ? 2000 : 20000;
    s.seed = o.seed;
    s.front_levels = o.front_levels;
    s.divide_every = o.divide_every;
    catch_interrupts();  // what was done by then is reported
    s.stop = interrupted;
    s.check_every = o.check_every;
    s.out_dir = o.common.out_dir;
    s.progress = note;
    fuzzed = bench::fuzz_run(s);
    b = fuzzed.result();
  } else {
    bench::CuttingSettings s;
    s.quick = o.quick;
    s.only = o.only;
    s.progress = note;
    b = bench::cutting(s);
    if (std::string("metric").find(o.only) != std::string::npos) {
      const bench::Result metric = bench::cut_metric({o.quick, note});
      b.rows.insert(b.rows.end(), metric.rows.begin(), metric.rows.end());
      b.bars.insert(b.bars.end(), metric.bars.begin(), metric.bars.end());
    }
  }
  progress.clear();
  if (!o.only.empty() && b.rows.empty())
    throw InputError(
        "", 0, "bench " + o.suite + ": --only " + o.only + " names no part; expected one of those that --help lists");
  print(b);
  Result result("bench", accuracy.scene);
  result.set("/suite", o.suite);
  result.set("/quick", o.quick);
  const std::string call = this_call();  // "limberg speed --quick"
  result.set("/reproduce", "limberg bench" + call.substr(std::min(call.size(), std::string("limberg").size())));
  if (o.suite == "fuzz" && !o.world && !o.devices && !o.readers) {
    result.set("/operations", fuzzed.operations());
    result.set("/violations", int64_t(fuzzed.violations.size()));
    result.set("/refused", fuzzed.generic.refused + fuzzed.adversarial.refused);
    result.set("/seed", int64_t(o.seed));
  }
  if (o.suite == "accuracy") {
    fill_operating_point(result, accuracy.point);
    if (!o.common.out_dir.empty())
      write_whole_file(o.common.out_dir + "/accuracy.csv", accuracy.csv()),
          write_whole_file(o.common.out_dir + "/accuracy.svg", accuracy.svg());
  }
  fill(result, b);
  for (const auto& [title, chart] : charts) add_chart(result, result.entries("/charts"), title, chart);
  bool ok = true;
  for (const bench::Bar& x : b.bars) ok &= x.pass;
  if (interrupted()) {
    std::fprintf(stderr, "limberg: interrupted after %lld operations; they are reported\n",
                 static_cast<long long>(fuzzed.operations()));
    ok = false;
  }
  result.set_ok(ok);
  add_table(result, result.entries("/tables"), measured(b));
  leave_result(result, o.common);
  return ok ? kDone : kGoalMissed;
}

void add_suites(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<Options>();
  CLI::App* c = app.add_subcommand("bench", "Measure against bars, in CPU time, in one process");
  c->add_option("SUITE", o->suite,
                "accuracy: error against run time on a scene, and the setting that fits a frame; contact: overlap and "
                "cost of operations with wound surfaces that keep each other out; features: memory and time of each "
                "part of a scene, off and on; frames: what a picture costs at each quality and size, and what the "
                "solver loses beside it; verification: closed forms, published values, CalculiX; speed: the elasticity "
                "solver against full Newton, and the 60 Hz drag; cutting: what a cut costs, beside CGAL; devices: the "
                "1 kHz loop, buffers, tracking, calibration, grabs and force; stability: what tissue comes back from, "
                "beside full Newton; laws: iterations as tissue becomes incompressible, and layers thinner than a "
                "cell; head: the face that follows, each mode against the finite elements; simplex: what simplex "
                "meshes cost, and random operators on them; fuzz: random cuts, every invariant")
      ->required();
  c->add_option("SCENE", o->scene, "Scene, for suites that take one");
  c->add_flag("--quick", o->quick, "The smallest size only");
  c->add_flag("--no-peers", o->no_peers, "stability: only what is under test");
  c->add_option("--only", o->only,
                "speed, stability, contact, cutting, devices, features, head: the parts or families whose name "
                "contains this (head: modes, session; contact: rhomboid, zplasty, live, or a procedure; cutting: "
                "arrangement, history, crossing, whole cut, fronts, metric; devices: wake, buffers, tracking, "
                "calibration, grabs, force, latency; speed: pull 2k, pull 8k, pull 30k, kernels, profile, scalar, "
                "workers, locking, slab, flap, region, bullet, drag 8k, drag 30k, drag 100k)")
      ->type_name("TEXT");
  c->add_option("--budget-ms", o->budget_ms, "accuracy: time of a frame (default: half the scene's step)")
      ->type_name("MS")
      ->check(number_from(0.001, 1e5));
  c->add_option("--limit-s", o->limit_s, "accuracy: CPU time after which no new trial begins (default 150)")
      ->type_name("S")
      ->check(number_from(0.1, 1e6));
  c->add_option("--operations", o->operations, "fuzz: how many (default 20000; --quick 2000)")
      ->type_name("N")
      ->check(whole_from(1, 1'000'000'000'000));
  c->add_flag(
      "--world", o->world,
      "fuzz: whole acts on patients (strokes at once and drawn, sheets, plugs, stitches, undo) instead of cuts");
  c->add_flag("--devices", o->devices, "fuzz: damaged serial bytes, packets and logs instead of cuts");
  c->add_flag("--readers", o->readers,
              "fuzz: damaged images, surfaces, meshes and scenes instead of cuts (default 100000 cases)");
  c->add_option("--seed", o->seed, "fuzz: of the operations (default 1)")
      ->type_name("N")
      ->check(whole_from(0, 9'007'199'254'740'992));
  c->add_option("--front-levels", o->front_levels,
                "fuzz: how often lattice cells at the end of a cut are divided (default 0)")
      ->check(whole_from(0, kLevels));
  c->add_option("--divide-every", o->divide_every,
                "fuzz: with --front-levels, divide cells in one of so many histories only (default 1: in all)")
      ->check(whole_from(1, 1000));
  c->add_option("--check-every", o->check_every, "fuzz: operations between checks of everything (default 1)")
      ->check(whole_from(1, 1000));
  o->common.add_out(*c), o->common.add_json(*c), o->common.add_workers(*c);
  c->footer("Example: limberg bench speed --quick --json out/bench.json");
  c->callback([o, &chosen] { chosen = [o] { return run(*o); }; });
}

/// The words that follow `limberg bench`.
int run_main(int argc, char** argv) {
  CLI::App app("Limberg: benchmark suites", "limberg");
  Chosen chosen;
  add_suites(app, chosen);
  std::vector<std::string> words(argv + 1, argv + argc);
  if (words.empty() || words.front() != "--version") words.insert(words.begin(), "bench");
  app.set_version_flag("--version", program_name());
  return run_command_line(app, std::move(words), chosen,
                          "limberg bench SUITE; limberg bench --help lists the suites\n");
}

}  // namespace

}  // namespace limberg

int main(int argc, char** argv) {
  return limberg::run_framed([&] { return limberg::run_main(argc, argv); });
}
