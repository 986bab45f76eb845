#include <time.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "app/assembly/streams.h"
#include "app/commands/numbers.h"
#include "app/commands/session_command.h"
#include "app/program/interrupt.h"
#include "app/program/shipped.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/schema.h"
#include "devices/emulator.h"
#include "devices/fastrak/port.h"
#include "devices/head_surgeon.h"
#include "sim/base/error.h"
#include "sim/commands/strokes.h"

namespace limberg {

namespace {

struct EmulateOptions {
  std::string scene, script, out_log;
  uint64_t seed = 1;
  std::string stream;
  bool replace = false, progressive = false, fastrak = false, glove = false;
  double seconds = 0, damage = 0;
  CommonOptions common;
};

/// A FASTRAK on a pseudo-terminal until Ctrl-C.
int serve_fastrak(const EmulateOptions& o) {
  catch_interrupts();
  fastrak::EmulatorSettings settings;
  settings.seed = o.seed;
  settings.damage_per_byte = o.damage;
  const fastrak::EmulatedPort port(fastrak::hand_at_work(o.seed), settings);
  std::printf("%s\n", port.path().c_str());
  std::fflush(stdout);
  say("an emulated FASTRAK: glove on stations 1 and 2, stylus on 3; until Ctrl-C. Elsewhere: limberg devices --watch "
      "--device fastrak:" +
      port.path() + ",fts");
  while (!interrupted() && (o.seconds <= 0 || double(port.now_ns()) * 1e-9 < o.seconds)) {
    const timespec pause{0, 20'000'000};
    nanosleep(&pause, nullptr);
  }
  return kDone;
}

/// A stream whose truth is known (streams.h), with the truth beside it.
int write_known(const EmulateOptions& o) {
  if (o.out_log.empty()) throw InputError("", 0, "emulate --stream without --out; expected the LCM log to write");
  const KnownStream k = known_stream(o.stream, o.seed);
  write_stream(o.out_log, k.samples, o.replace);
  write_whole_file(o.out_log + ".truth.csv", k.truth_csv);
  if (!k.points_mm.empty()) {
    std::string list;
    for (const Vec3& p : k.points_mm)
      list += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
    write_whole_file(o.out_log + ".points.txt", list);
    std::printf("points      %s.points.txt\n", o.out_log.c_str());
  }
  std::printf("recording   %s, %zu samples, seed %llu\ntruth       %s\n            %s.truth.csv\n", o.out_log.c_str(),
              k.samples.size(), static_cast<unsigned long long>(o.seed), k.truth.c_str(), o.out_log.c_str());
  return kDone;
}

int emulate(const EmulateOptions& o) {
  if (!o.stream.empty()) return write_known(o);
  if (o.fastrak) return serve_fastrak(o);
  if (o.scene.empty() || o.script.empty() || o.out_log.empty())
    throw InputError("", 0,
                     "emulate without scene, script or --out; expected limberg emulate SCENE SCRIPT --out LOG, limberg "
                     "emulate --fastrak, or limberg emulate --stream pivot --out LOG");
  if (!o.common.json_file.empty()) o.common.prepare();
  SessionCall call;
  call.command = "emulate";
  call.scene = open_scene(o.scene);
  call.progressive_cut = call.scene.tools.progressive_cut.value_or(o.progressive);
  const Script script = load_script(given_or_shipped(o.script));
  const std::vector<Command> commands = acts_on(call.scene, script);
  if (commands.empty()) throw InputError(o.script, 0, "holds no action; expected at least one line with an action");
  SurgeonSettings settings;
  settings.seed = o.seed;
  const std::vector<std::string>* problems = nullptr;
  if (call.scene.head && !call.scene.flesh) {
    auto surgeon = std::make_unique<EmulatedHeadSurgeon>(commands, settings,
                                                         o.glove ? HeadHands::glove : HeadHands::stylus_and_glove);
    problems = &surgeon->problems();
    call.sources.push_back(std::move(surgeon));
  } else {
    if (o.glove)
      throw InputError(o.scene, 0, "emulate --glove: the scene has skin; expected a scene of a [head] without [body]");
    auto surgeon = std::make_unique<EmulatedSurgeon>(join_strokes(commands), settings);
    problems = &surgeon->problems();
    call.sources.push_back(std::move(surgeon));
  }
  call.surgeon_seed = o.seed;
  call.record_file = o.out_log;
  call.replace_record = o.replace;
  call.common = o.common;
  bool complete = true;
  const int status = run_session(std::move(call), [&](Result& r, Assembly& a) {
    schema::write(r, "/problems", *problems);
    for (const std::string& p : *problems) say(o.script + ": " + p);
    complete = problems->empty() && a.solver.refused().empty();
  });
  if (status == kDone && !complete) {
    say(o.script + ": not every action was carried out; expected a script that fits the scene");
    return kGoalMissed;
  }
  return status;
}

}  // namespace

void add_emulate(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<EmulateOptions>();
  CLI::App* c = app.add_subcommand("emulate", "A scripted surgeon carries out an operation with a stylus: a recording");
  c->add_option("SCENE", o->scene, "Scene file, or the name of a shipped scene");
  c->add_option("SCRIPT", o->script, "Operation script (JSON lines)");
  c->add_option("--out", o->out_log, "The LCM log to write")->type_name("LOG");
  c->add_option("--seed", o->seed, "Of tremor, noise and dropouts (default 1)")
      ->type_name("N")
      ->check(whole_from(0, 9'007'199'254'740'992));
  c->add_flag("--replace", o->replace, "Replace LOG if it exists");
  c->add_option(
       "--stream", o->stream,
       "Instead: a stream of a hand whose truth is known: glove, cursor, tremor, force; or pivot, touch, open, "
       "forefinger, thumb, pointing for limberg calibrate")
      ->type_name("NAME");
  c->add_flag("--fastrak", o->fastrak,
              "Instead: be a FASTRAK on a pseudo-terminal, whose path is printed, moved by a hand at work");
  c->add_option("--seconds", o->seconds, "--fastrak: end after so long (default: Ctrl-C)")
      ->type_name("S")
      ->check(number_from(0.01, 86400));
  c->add_option("--damage", o->damage, "--fastrak: share of bytes lost, changed or put in")
      ->type_name("P")
      ->check(number_from(0.0, 1.0));
  c->add_flag("--glove", o->glove, "Of a head: the glove alone saws, by the surface cursor, and carries");
  c->add_flag("--progressive-cut", o->progressive, "Incisions open while they are drawn, as run does it");
  o->common.add_json(*c), o->common.add_workers(*c);
  c->footer("Example: limberg emulate rhomboid recordings/rhomboid.jsonl --out rhomboid.lcm --seed 7");
  c->callback([o, &chosen] { chosen = [o] { return emulate(*o); }; });
}

}  // namespace limberg
