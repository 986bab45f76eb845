#include <CLI/CLI.hpp>
#include <filesystem>

#include "app/commands/session_command.h"
#include "app/progress.h"
#include "devices/emulator.h"
#include "sim/error.h"
#include "sim/tools/strokes.h"

namespace limberg {

namespace {

struct Options {
  std::string scene, script, out_log;
  uint64_t seed = 1;
  bool replace = false, progressive = false;
  CommonOptions common;
};

int emulate(const Options& o) {
  if (!o.common.json_file.empty()) o.common.prepare();
  SessionCall call;
  call.command = "emulate";
  call.scene = open_scene(o.scene);
  call.progressive_cut = call.scene.tools.progressive_cut.value_or(o.progressive);
  const Script script = load_script(o.script);
  std::vector<Command> commands;
  for (const ScriptLine& l : script.lines) commands.push_back(l.command);
  if (commands.empty()) throw InputError(o.script, 0, "holds no action; expected at least one line with an action");
  SurgeonSettings settings;
  settings.seed = o.seed;
  auto surgeon = std::make_unique<EmulatedSurgeon>(join_strokes(commands), settings);
  const EmulatedSurgeon* watch = surgeon.get();
  call.sources.push_back(std::move(surgeon));
  call.surgeon_seed = o.seed;
  call.record_file = o.out_log;
  call.replace_record = o.replace;
  call.common = o.common;
  bool complete = true;
  const int status = run_session(std::move(call), [&](Result& r, Assembly& a) {
    r.set_empty_list("/problems");
    int n = 0;
    for (const std::string& p : watch->problems()) {
      r.set("/problems/" + std::to_string(n++), p);
      say(o.script + ": " + p);
    }
    complete = watch->problems().empty() && a.solver.refused().empty();
  });
  if (status == kDone && !complete) {
    say(o.script + ": not every action was carried out; expected a script that fits the scene");
    return kGoalMissed;
  }
  return status;
}

}  // namespace

void add_emulate(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<Options>();
  CLI::App* c = app.add_subcommand("emulate", "A scripted surgeon carries out an operation with a stylus: a recording");
  c->add_option("SCENE", o->scene, "Scene file, or the name of a shipped scene")->required();
  c->add_option("SCRIPT", o->script, "Operation script (JSON lines)")->required();
  c->add_option("--out", o->out_log, "The LCM log to write")->type_name("LOG")->required();
  c->add_option("--seed", o->seed, "Of tremor, noise and dropouts (default 1)")->type_name("N");
  c->add_flag("--replace", o->replace, "Replace LOG if it exists");
  c->add_flag("--progressive-cut", o->progressive, "Incisions open while they are drawn, as run does it");
  o->common.add_json(*c), o->common.add_workers(*c);
  c->footer("Example: limberg emulate rhomboid recordings/rhomboid.jsonl --out rhomboid.lcm --seed 7");
  c->callback([o, &chosen] { chosen = [o] { return emulate(*o); }; });
}

}  // namespace limberg
