#include <CLI/CLI.hpp>
#include <cstdio>

#include "app/commands/auto_option.h"
#include "app/commands/session_command.h"
#include "app/program/shipped.h"
#include "app/result/progress.h"
#include "devices/log_source.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

struct ReplayOptions {
  std::string recording, scene, convergence, film, lesson;
  int frames_per_s = 25;
  bool lockstep = false, real_time = false, even_clock = false;
  AutoOption automatic;
  CommonOptions common;
};

std::string describe(const LogDamage& d, const std::string& file) {
  std::string s = file + ": damaged: " + std::to_string(d.total()) + " events lost";
  if (d.skipped_bytes > 0) s += ", " + std::to_string(d.skipped_bytes) + " bytes skipped";
  if (!d.first_message.empty()) s += "; first: " + d.first_message;
  return s + "; what is whole is replayed";
}

int replay(const ReplayOptions& o) {
  o.common.prepare();
  Recording rec = read_recording(given_or_shipped(o.recording));
  if (!rec.session)
    throw InputError(
        o.recording, 0,
        "no valid record of a session in it; expected a recording made by limberg run --record or limberg emulate");
  Unbundled u = unbundle_scene(rec, o.recording);
  if (u.scene.hash != rec.session->scene_hash)
    throw InputError(o.recording, 0,
                     "its scene is not the one that it was recorded with (hash " + hex(u.scene.hash) + ", recorded " +
                         hex(rec.session->scene_hash) + "); expected an unchanged recording");
  if (!o.scene.empty()) {
    const Scene asked = open_scene(o.scene);
    if (asked.hash != rec.session->scene_hash)
      throw InputError(o.recording, 0,
                       "log of another scene (" + rec.session->scene_name + ", hash " + hex(rec.session->scene_hash) +
                           "); expected " + asked.name + ", hash " + hex(asked.hash));
  }
  if (rec.samples.empty())
    throw InputError(o.recording, 0, "no valid record of a sample in it; expected a stream of stylus samples");
  if (rec.damage.total() > 0) say(describe(rec.damage, o.recording));
  if (!rec.end && rec.damage.total() == 0)
    say(o.recording + ": has no end record: the session was cut short; what is there is replayed");

  SessionCall call;
  call.command = "replay";
  call.scene = std::move(u.scene);
  call.scene_files = u.files;
  call.calibration = unbundle_calibration(rec, o.recording);
  call.real_time = o.real_time, call.hand_waits = true;
  call.progressive_cut = (rec.session->seeds[2] & SessionInfo::kProgressiveCut) != 0;
  call.ticks_per_solver_step = std::max(1, rec.session->ticks_per_solver_step);
  call.expected = rec.checkpoints;
  call.expected_states = rec.states;
  call.recorded_by = rec.session->program;
  if (rec.end) {
    call.end_tick = rec.end->tick;
    call.expected.push_back({rec.end->tick, rec.end->hash});
  }
  if ((call.point = o.automatic.apply(call.scene)))
    call.expected.clear(), call.expected_states.clear();  // another lattice: nothing to compare with
  const bool as_it_was = !o.real_time && !o.even_clock && !call.point &&
                         rec.damage.total() == rec.damage.truncated;  // a killed session ends within an event
  if (as_it_was && rec.schedule.usable()) {
    call.schedule = std::move(rec.schedule);
    call.taken = std::move(rec.samples);
    call.known_length_s = double(call.schedule.solver.back().tick) * 1e-3;
  } else {
    if (rec.schedule.usable())
      call.expected.clear(),
          call.expected_states.clear();  // hashes of a live session are those of its own interleaving
    else if (rec.schedule.broken)
      say(o.recording + ": what its threads found is not whole: replayed on an even clock, not exactly as it was");
    auto source = std::make_unique<LogSource>(std::move(rec.samples), rec.damage.total());
    call.known_length_s = double(source->last_ns()) * 1e-9;
    call.sources.push_back(std::move(source));
  }
  call.damage = rec.damage;
  if (!o.lesson.empty()) call.lesson = open_lesson(o.lesson);
  call.reproduce = "limberg replay " + o.recording + (o.real_time ? " --realtime" : "") +
                   (o.common.out_dir.empty() ? "" : " --out " + o.common.out_dir);
  if (!o.film.empty()) call.film = FilmSettings{.file = o.film, .frames_per_s = o.frames_per_s};
  call.common = o.common;
  Result other("", "");
  if (!o.convergence.empty()) other.take("/convergence", o.convergence);  // refuses a bad file before the work
  return run_session(std::move(call), [&o](Result& r, Assembly&) {
    if (o.convergence.empty()) return;
    r.take("/convergence", o.convergence);
    r.take("/discretisation", o.convergence);
  });
}

}  // namespace

void add_replay(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<ReplayOptions>();
  CLI::App* c = app.add_subcommand("replay", "Replay a recorded session: the file alone reproduces it");
  c->add_option("RECORDING", o->recording, "LCM log made by run --record or emulate")->required();
  CLI::Option* lockstep = c->add_flag("--lockstep", o->lockstep, "On a virtual clock, bit for bit (default)");
  CLI::Option* realtime =
      c->add_flag("--realtime", o->real_time, "On three threads at their own rates, with timing figures")
          ->excludes(lockstep);
  c->add_flag("--even-clock", o->even_clock,
              "A recording of run: not as its threads were interleaved then, but on an even clock")
      ->excludes(realtime);
  c->add_option("--scene", o->scene, "Refuse the recording if it was not made with this scene")->type_name("SCENE");
  c->add_option("--convergence", o->convergence,
                "Put the convergence table and the lattice errors of this result (of operate --cells) into the report")
      ->type_name("FILE");
  c->add_option("--judge", o->lesson, "Judge the session by this lesson: its file, or the name of a shipped one")
      ->type_name("LESSON");
  CLI::Option* film =
      c->add_option("--film", o->film,
                    "Make a film, FILE.mp4 or FILE.webm, of the replay on its virtual clock (needs ffmpeg)")
          ->type_name("FILE")
          ->excludes(realtime);
  c->add_option("--frames", o->frames_per_s, "Frames a second of the film (default 25)")
      ->type_name("N")
      ->check(CLI::IsMember({10, 20, 25, 40, 50}))
      ->needs(film);
  o->automatic.add(*c);
  o->common.add_out(*c), o->common.add_json(*c), o->common.add_workers(*c), o->common.add_repro(*c);
  c->footer(
      "Exit status 3: the recording is damaged; what is whole was replayed.\n"
      "Example: limberg replay recordings/rhomboid.lcm --out out/demo --json out/demo/result.json");
  c->callback([o, &chosen] { chosen = [o] { return replay(*o); }; });
}

}  // namespace limberg
