// The benchmark suites: one entry each.
#include "app/assembly/streams.h"
#include "app/commands/session_command.h"
#include "app/operating_point/accuracy.h"
#include "app/operating_point/operating_point.h"
#include "app/program/interrupt.h"
#include "app/program/shipped.h"
#include "app/result/output.h"
#include "sim/commands/script.h"
#include "tests/bench/contact.h"
#include "tests/bench/cutting.h"
#include "tests/bench/devices/fuzz.h"
#include "tests/bench/devices/suite.h"
#include "tests/bench/devices/z_width_suite.h"
#include "tests/bench/faults.h"
#include "tests/bench/features.h"
#include "tests/bench/felt_patient.h"
#include "tests/bench/force_latency.h"
#include "tests/bench/frames.h"
#include "tests/bench/fuzz.h"
#include "tests/bench/fuzz/readers.h"
#include "tests/bench/fuzz/world_runner.h"
#include "tests/bench/graded.h"
#include "tests/bench/head_face.h"
#include "tests/bench/laws.h"
#include "tests/bench/live/live.h"
#include "tests/bench/metric.h"
#include "tests/bench/session_latency.h"
#include "tests/bench/simplex.h"
#include "tests/bench/soak/soak.h"
#include "tests/bench/speed.h"
#include "tests/bench/stability.h"
#include "tests/bench/start/start.h"
#include "tests/bench/suite.h"
#include "tests/bench/verification.h"

namespace limberg::bench {
namespace {

using Options = SuiteOptions;

Scene scene_of(const Options& o) { return open_scene(o.scene.empty() ? "rhomboid" : o.scene); }
SuiteOutcome only(Result result) {
  SuiteOutcome out;
  out.result = std::move(result);
  return out;
}
bool wanted(const Options& o, const std::string& part) { return part.find(o.only) != std::string::npos; }

SuiteOutcome run_accuracy(const Options& o) {
  catch_interrupts();  // its trials are kept
  AccuracySettings s;
  s.quick = o.quick, s.budget_ms = o.budget_ms, s.limit_s = o.limit_s;
  if (!o.out_dir.empty()) s.keep_file = o.out_dir + "/accuracy-trials.txt";
  s.progress = o.progress, s.interrupted = interrupted;
  const AccuracyReport report = accuracy(scene_of(o), s);
  if (!o.out_dir.empty()) {
    write_whole_file(o.out_dir + "/accuracy.csv", report.csv());
    write_whole_file(o.out_dir + "/accuracy.svg", in_plain_colours(report.svg()));
  }
  SuiteOutcome out = only(report.result());
  out.scene = report.scene;
  out.also = [point = report.point](limberg::Result& r) { fill_operating_point(r, point); };
  if (interrupted()) out.interrupted = "before its last trial; what was measured is reported";
  return out;
}

SuiteOutcome run_frames(const Options& o) {
  const Scene scene = scene_of(o);
  const std::string file = shipped_file("recordings/" + scene.name + ".jsonl");
  const Script script = file.empty() ? Script{} : load_script(file);
  return only(frames(scene, file.empty() ? nullptr : &script, {o.quick, o.progress}));
}

SuiteOutcome run_devices(const Options& o) {
  Result b = devices_suite({o.quick, o.only, o.progress});
  if (wanted(o, "felt")) add_felt_patient(b, open_scene("rhomboid"), o.quick, o.progress);
  if (wanted(o, "latency"))
    add_session_latency(b, open_scene("rhomboid"), known_stream("tremor", 5).samples, o.quick, o.progress);
  SuiteOutcome out = only(std::move(b));
  if (wanted(o, "hand to force")) add_force_latency(out, open_scene("rhomboid"), o.quick, o.progress);
  if (wanted(o, "z-width")) add_z_width(out, o.quick, o.progress);
  for (size_t i = 0; i < out.charts.size() && !o.out_dir.empty(); ++i)
    write_whole_file(o.out_dir + "/devices-" + std::to_string(i + 1) + ".svg",
                     in_plain_colours(svg(out.charts[i].second)));
  return out;
}

SuiteOutcome run_speed(const Options& o) {
  SpeedSettings s;
  s.quick = o.quick, s.only = o.only, s.progress = o.progress;
  return only(speed(s));
}

SuiteOutcome run_stability(const Options& o) {
  StabilitySettings s;
  s.quick = o.quick, s.only = o.only, s.peers = !o.no_peers, s.progress = o.progress;
  return only(stability(s));
}

SuiteOutcome run_head(const Options& o) {
  const HeadReport heads = head_suite({o.quick, o.only, o.progress});
  SuiteOutcome out = only(heads.result);
  if (!o.out_dir.empty()) write_whole_file(o.out_dir + "/head-modes.csv", heads.csv());
  for (const std::string& situation : heads.situations()) {
    out.charts.emplace_back(situation + ": error against run time", heads.chart(situation));
    if (!o.out_dir.empty())
      write_whole_file(o.out_dir + "/head-modes-" + std::to_string(out.charts.size()) + ".svg",
                       in_plain_colours(svg(out.charts.back().second)));
  }
  return out;
}

SuiteOutcome run_simplex(const Options& o) {
  SimplexSettings s;
  s.quick = o.quick, s.progress = o.progress;
  return only(simplex_suite(s));
}

SuiteOutcome run_cutting(const Options& o) {
  CuttingSettings s;
  s.quick = o.quick, s.only = o.only, s.progress = o.progress;
  Result b = cutting(s);
  if (wanted(o, "metric")) {
    const Result metric = cut_metric({o.quick, o.progress});
    b.rows.insert(b.rows.end(), metric.rows.begin(), metric.rows.end());
    b.bars.insert(b.bars.end(), metric.bars.begin(), metric.bars.end());
  }
  return only(std::move(b));
}

SuiteOutcome run_world_fuzz(const Options& o) {
  fuzz::WorldFuzzSettings s;
  s.acts = o.operations > 0 ? o.operations : o.quick ? 300 : 3000;
  s.seed = o.seed, s.out_dir = o.out_dir, s.progress = o.progress;
  return only(fuzz::world_fuzz(s).result());
}

SuiteOutcome run_devices_fuzz(const Options& o) {
  DevicesFuzzSettings s;
  s.cases = o.operations > 0 ? o.operations : o.quick ? 120'000 : s.cases;
  s.seed = o.seed, s.progress = o.progress;
  return only(devices_fuzz(s).result());
}

SuiteOutcome run_readers_fuzz(const Options& o) {
  ReadersFuzzSettings s;
  s.cases = o.operations > 0 ? o.operations : o.quick ? 10'000 : s.cases;
  s.seed = o.seed, s.out_dir = o.out_dir, s.progress = o.progress;
  return only(readers_fuzz(s, readers()).result());
}

SuiteOutcome run_faults(const Options& o) {
  catch_interrupts();  // what was done by then is reported
  FaultsSettings s;
  s.cases = o.operations > 0 ? o.operations : o.quick ? 200 : 2000;
  s.seed = o.seed, s.progress = o.progress, s.stop = interrupted;
  SuiteOutcome out = only(faults_suite(s));
  if (interrupted()) out.interrupted = "before its last case; what was done is reported";
  return out;
}

SuiteOutcome run_fuzz(const Options& o) {
  if (o.world) return run_world_fuzz(o);
  if (o.devices) return run_devices_fuzz(o);
  if (o.readers) return run_readers_fuzz(o);
  FuzzSettings s;
  s.operations = o.operations > 0 ? o.operations : o.quick ? 2000 : 20000;
  s.seed = o.seed, s.front_levels = o.front_levels, s.divide_every = o.divide_every, s.check_every = o.check_every;
  catch_interrupts();  // what was done by then is reported
  s.stop = interrupted, s.out_dir = o.out_dir, s.progress = o.progress;
  const FuzzReport report = fuzz_run(s);
  SuiteOutcome out = only(report.result());
  if (interrupted())
    out.interrupted = "after " + std::to_string(report.operations()) + " operations; they are reported";
  out.also = [report, seed = o.seed](limberg::Result& r) {
    r.set("/operations", report.operations());
    r.set("/violations", int64_t(report.violations.size()));
    r.set("/refused", report.generic.refused + report.adversarial.refused);
    r.set("/seed", int64_t(seed));
  };
  return out;
}

SuiteOutcome run_soak(const Options& o) {
  catch_interrupts();  // what was done by then is reported
  SoakSettings s;
  s.minutes = o.minutes > 0 ? o.minutes : o.quick ? 2 : s.minutes;
  s.acts = o.operations > 0 ? o.operations : o.quick ? 1000 : s.acts;
  s.only = o.only, s.out_dir = o.out_dir, s.progress = o.progress, s.stop = interrupted;
  return soak(s);
}

SuiteOutcome run_live(const Options& o) {
  catch_interrupts();  // the runs that have ended are reported
  LiveSettings s;
  s.recording = o.scene, s.only = o.only, s.quick = o.quick, s.progress = o.progress, s.stop = interrupted;
  if (o.operations > 0) s.runs = o.operations;
  SuiteOutcome out = only(live(s));
  if (interrupted()) out.interrupted = "before its last run; what was done is reported";
  return out;
}

constexpr Suite kSuites[] = {
    {"accuracy", "error against run time on a scene, and the setting that fits a frame", "", true, run_accuracy},
    {"contact", "overlap and cost of operations with wound surfaces that keep each other out",
     "rhomboid, zplasty, live, or a procedure", false,
     [](const Options& o) {
       return only(contact({o.quick, o.only, o.progress}));
     }},
    {"cutting", "what a cut costs, beside CGAL", "arrangement, history, crossing, whole cut, drawn, fronts, metric",
     false, run_cutting},
    {"devices", "the 1 kHz loop, buffers, tracking, calibration, grabs and force",
     "wake, buffers, tracking, calibration, grabs, force, felt, latency, hand to force, z-width", false, run_devices},
    {"faults", "what full disks, lost memory, kills and stopped clocks do to a session and its recording", "", false,
     run_faults},
    {"features", "memory and time of each part of a scene, off and on", "a part of a scene", true,
     [](const Options& o) {
       return only(features(scene_of(o), {o.quick, o.only, o.progress}));
     }},
    {"frames", "what a picture costs at each quality and size, and what the solver loses beside it", "", true,
     run_frames},
    {"fuzz", "random cuts (or acts, device streams, files), every invariant", "", false, run_fuzz},
    {"graded", "lattices that are fine where it matters, against uniform ones", "patch, rhomboid", false,
     [](const Options& o) {
       return only(graded({o.quick, o.only, o.progress}));
     }},
    {"head", "the face that follows, each mode against the finite elements", "modes, session", false, run_head},
    {"laws", "iterations as tissue becomes incompressible, and layers thinner than a cell", "", false,
     [](const Options& o) {
       return only(laws({o.quick, o.progress}));
     }},
    {"live", "recordings played in real time, alone and beside busy threads, against lockstep (SCENE: a recording)",
     "rhomboid, zplasty, craniofacial, bilobed, cheek", true, run_live},
    {"simplex", "what simplex meshes cost, and random operators on them", "", false, run_simplex},
    {"soak", "hours of emulated operations in one process: memory, times, hashes; and 10,000 acts with undo",
     "lockstep, live, acts", false, run_soak},
    {"speed", "the elasticity solver against full Newton, and the 60 Hz drag",
     "pull 2k, pull 8k, pull 30k, kernels, profile, scalar, workers, locking, slab, flap, region, bullet, drag 8k, "
     "drag "
     "30k, drag 100k",
     false, run_speed},
    {"stability", "what tissue comes back from, beside full Newton", "a family of cases", false, run_stability},
    {"start", "peak memory and start time of the program, by scene, with and without pictures",
     "program, tiny, or a scene", false,
     [](const Options& o) {
       return start({o.quick, o.only, o.progress});
     }},
    {"verification", "closed forms, published values, CalculiX", "", false,
     [](const Options& o) {
       return only(verification({o.quick, o.progress, o.only}));
     }},
};

}  // namespace

std::span<const Suite> suites() { return kSuites; }

}  // namespace limberg::bench
