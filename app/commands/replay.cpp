#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <string_view>
#include <utility>

#include "app/commands/auto_option.h"
#include "app/commands/recorded_call.h"
#include "app/program/shipped.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

struct ReplayOptions {
  std::string recording, scene, convergence, film, lesson;
  int frames_per_s = 20;
  std::string film_size = "1280x720";
  bool film_fine = false;
  bool lockstep = false, real_time = false, even_clock = false;
  AutoOption automatic;
  CommonOptions common;
};

/// "1280x720". A codec wants even sides.
std::pair<int, int> size_of_film(const std::string& text) {
  const size_t x = text.find('x');
  const auto side = [](std::string_view digits) {
    int n = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), n);
    return error == std::errc() && end == digits.data() + digits.size() && n >= 64 && n <= 4096 && n % 2 == 0 ? n : 0;
  };
  const int width = x == text.npos ? 0 : side(std::string_view(text).substr(0, x)),
            height = x == text.npos ? 0 : side(std::string_view(text).substr(x + 1));
  if (!width || !height)
    throw InputError("", 0,
                     "--film-size " + text +
                         ": no size of a film; expected width x height as 1280x720, even numbers "
                         "from 64 to 4096");
  return {width, height};
}

int replay(const ReplayOptions& o) {
  o.common.prepare();
  Recording rec = open_session(given_or_shipped(o.recording));
  SessionCall call;
  call.command = "replay";
  take_session(call, rec, o.recording);
  if (!o.scene.empty()) expect_scene_of(rec, o.recording, open_scene(o.scene));
  call.real_time = o.real_time, call.hand_waits = true;
  if ((call.point = o.automatic.apply(call.scene)))
    call.expected.clear(), call.expected_states.clear();  // another lattice: nothing to compare with
  take_samples(call, std::move(rec), o.recording, !o.real_time && !o.even_clock && !call.point);
  if (!o.lesson.empty()) call.lesson = open_lesson(o.lesson);
  call.reproduce = "limberg replay " + o.recording + (o.real_time ? " --realtime" : "") +
                   (o.common.out_dir.empty() ? "" : " --out " + o.common.out_dir);
  if (!o.film.empty()) {
    const auto [width, height] = size_of_film(o.film_size);
    call.film = FilmSettings{o.film, o.frames_per_s, width, height, o.common.words(), o.film_fine};
  }
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
  c->add_option("--frames", o->frames_per_s, "Frames a second of the film (default 20)")
      ->type_name("N")
      ->check(CLI::IsMember({10, 20, 25, 40, 50}))
      ->needs(film);
  c->add_option("--film-size", o->film_size, "Width and height of the film in pixels (default 1280x720)")
      ->type_name("WxH")
      ->needs(film);
  c->add_flag("--film-fine", o->film_fine, "Edges as smooth as those of the report's pictures: about four times longer")
      ->needs(film);
  o->automatic.add(*c);
  o->common.add_out(*c), o->common.add_words(*c), o->common.add_json(*c), o->common.add_workers(*c),
      o->common.add_repro(*c);
  c->footer(
      "Exit status 3: the recording is damaged; what is whole was replayed.\n"
      "Example: limberg replay recordings/rhomboid.lcm --out out/demo --json out/demo/result.json");
  c->callback([o, &chosen] { chosen = [o] { return replay(*o); }; });
}

}  // namespace limberg
