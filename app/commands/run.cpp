#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "app/assembly/cases.h"
#include "app/commands/auto_option.h"
#include "app/commands/left_recordings.h"
#include "app/commands/numbers.h"
#include "app/commands/recorded_call.h"
#include "app/headset/headset_source.h"
#include "app/program/shipped.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/room/room_file.h"
#include "devices/emulator.h"
#include "devices/head_surgeon.h"
#include "devices/log_source.h"
#include "sim/base/error.h"
#include "sim/commands/strokes.h"

namespace limberg {

namespace {

struct RunOptions {
  std::string scene = "rhomboid", record, calibration, lesson, judge, continued, of_case, room, mode = "guided";
  std::vector<std::string> devices;
  double seconds = 0, cursor = 0;
  bool headless = false, replace = false, cut_at_end = false, slow_motion = false;
  AutoOption automatic;
  CommonOptions common;
};

constexpr int32_t kOwnControls = 900;  // device number of what the command line chose

/// Adds what a --device names (device_specs.h).
void add_device(SessionCall& call, const std::string& text) {
  const DeviceSpec spec(text);
  if (spec.kind == "emulated" && !spec.rest.empty()) {
    const std::vector<Command> commands = acts_on(call.scene, load_script(spec.rest));
    call.surgeon_seed = SurgeonSettings{}.seed;
    if (call.scene.head && !call.scene.flesh)
      call.sources.push_back(std::make_unique<EmulatedHeadSurgeon>(commands));
    else
      call.sources.push_back(std::make_unique<EmulatedSurgeon>(join_strokes(commands)));
  } else if (spec.kind == "log" && !spec.rest.empty()) {
    Recording rec = read_recording(spec.rest);
    expect_scene_of(rec, spec.rest, call.scene);
    if (rec.samples.empty())
      throw InputError(spec.rest, 0, "no valid record of a sample in it; expected a stream of stylus samples");
    if (rec.damage.total() > 0)
      say(spec.rest + ": damaged: " + std::to_string(rec.damage.total()) + " events lost; what is whole is used");
    call.damage = rec.damage;
    call.sources.push_back(std::make_unique<LogSource>(std::move(rec.samples), rec.damage.total()));
  } else if (LiveSource live = live_source(spec, int(call.live_sources.size()))) {
    call.live_sources.push_back(std::move(live));
    call.live_names.push_back(text);
  } else {
    throw InputError("", 0, "--device " + text + ": unknown device; expected " + device_forms());
  }
}

/// A desktop to open a window on.
bool has_display() {
  const auto set = [](const char* name) {
    const char* value = std::getenv(name);
    return value && *value;
  };
  return set("DISPLAY") || set("WAYLAND_DISPLAY");
}

/// What "next" shows: the script asked for, or the one shipped for the scene.
std::string lesson_file(const RunOptions& o) {
  if (!o.lesson.empty()) return o.lesson;
  return o.scene.find('/') == std::string::npos ? shipped_file("recordings/" + o.scene + ".jsonl") : "";
}
/// The lesson that the window teaches: that which judges, else the one shipped for the scene with its script.
std::optional<Lesson> words_of(const RunOptions& o, const Scene& scene) {
  if (!o.judge.empty()) return open_lesson(o.judge);
  if (!o.lesson.empty()) return std::nullopt;
  const std::string file = shipped_file("app/lessons/" + scene.name + ".toml");
  return file.empty() ? std::nullopt : std::optional(open_lesson(file));
}

LessonMode mode_of(const std::string& name) {
  return name == "free" ? LessonMode::free_hand : name == "examination" ? LessonMode::examination : LessonMode::guided;
}

/// Whether there is a hand that can be slowed down for.
void check_slow_motion(const RunOptions& o, bool hand_waits) {
  if (hand_waits)
    throw InputError("", 0,
                     "--slow-motion with a hand that is emulated or recorded, which waits for the patient anyhow; "
                     "expected a live --device, or the mouse");
  for (const std::string& d : o.devices)
    if (const DeviceKind* kind = device_kind(DeviceSpec(d)); kind && kind->feels)
      throw InputError("", 0,
                       "--slow-motion with --device " + d +
                           ", whose forces need the wall's clock; expected a device without forces");
}

/// What a headset shows, where one is among the devices. Where none is asked for and a runtime is installed, the window
/// offers it: it waits until a key asks for it.
void add_headset(SessionCall& call, const RunOptions& o) {
  for (const std::string& d : o.devices) {
    const DeviceSpec spec(d);
    if (!device_kind(spec)->shows) continue;
    if (call.headset) throw InputError("", 0, "--device " + d + " a second time; expected one headset");
    call.headset = std::make_shared<HeadsetShared>();
    check_calibration(call.calibration);
  }
  if (call.headset || !o.devices.empty() || o.headless || !has_display() || !o.calibration.empty()) return;
  if (headset_runtime_file().empty()) return;
  call.headset = std::make_shared<HeadsetShared>();
  call.headset->wanted = false, call.headset->takes_over = true;
  call.live_sources.push_back(live_source(DeviceSpec("headset"), 0));
  call.live_names.emplace_back("headset");
}

int run_session(const RunOptions& o) {
  o.common.prepare();
  if (!o.continued.empty() && o.automatic.on)
    throw InputError("", 0, "--auto with --continue; expected a session that goes on with the cells that it had");
  SessionCall call = o.continued.empty() ? SessionCall{} : continued_session(given_or_shipped(o.continued));
  call.command = "run";
  call.real_time = true;
  if (!call.goes_on) {
    call.scene = open_scene(o.scene);
    if (!o.calibration.empty()) call.calibration = load_calibration(o.calibration);
    call.progressive_cut = call.scene.tools.progressive_cut.value_or(true) && !o.cut_at_end;
  }
  for (const std::string& d : o.devices) add_device(call, d);  // a log is of the scene as it was named
  if (!call.goes_on) call.point = o.automatic.apply(call.scene);
  add_headset(call, o);
  std::vector<Command> lesson;
  if (const std::string file =
          call.goes_on && o.lesson.empty() ? shipped_file("recordings/" + call.scene.name + ".jsonl") : lesson_file(o);
      !file.empty())
    lesson = acts_on(call.scene, load_script(file));
  const bool window = !o.headless && has_display();
  if (!o.headless && !window) say("no display: no window is opened; --headless says that none is wanted");
  if (o.devices.empty() && !window) add_device(call, "lcm");
  if (window) {
    WindowCall w;
    w.calibrated = !o.calibration.empty() || call.goes_on;
    bool tracked = false;
    for (const std::string& d : o.devices) {
      const DeviceSpec spec(d);
      const DeviceKind& kind = *device_kind(spec);  // add_device() has refused what is none
      tracked |= kind.tracked;
      w.own_device |= kind.own_hand;
      w.device += (w.device.empty() ? "" : ", ") +
                  (kind.from_file ? spec.kind + ": " + std::filesystem::path(spec.rest).filename().string() : d);
    }
    w.calibrated |= !tracked;  // what else there is says where it is in the patient's own measure
    w.mouse = o.devices.empty();
    w.headset = call.headset;
    w.recording = call.goes_on && o.record.empty() ? name_of_continuation(call.goes_on->file) : o.record;
    if (!o.common.out_dir.empty()) w.picture_dir = o.common.out_dir;
    call.keep_dir = w.picture_dir;
    w.script = lesson, w.w = o.common.words();
    w.mode = mode_of(o.mode);
    w.lesson = words_of(o, call.scene);
    call.window = [w](const Scene& scene, const std::string& word) mutable {
      w.word = word;
      return open_window(scene, w);
    };
  }
  if (o.cursor > 0) {
    ControlSample on;
    on.device_id = kOwnControls;
    on.kind = ControlSample::cursor;
    on.value[0] = o.cursor;
    call.sources.push_back(std::make_unique<LogSource>(std::vector<Sample>{on}));
  }
  if (window)
    say("opening a window; ? in it lists keys and mouse, closing it ends the session");
  else if (!call.live_sources.empty() && o.seconds <= 0)
    say("listening until Ctrl-C");
  call.hand_waits = call.live_sources.empty() && !o.devices.empty();
  call.slow_motion = o.slow_motion;
  if (o.slow_motion) check_slow_motion(o, call.hand_waits);
  if (o.seconds > 0) call.end_tick = int64_t(o.seconds * 1000);
  if (!call.goes_on) call.known_length_s = o.seconds;
  call.record_file = call.goes_on && o.record.empty() ? name_of_continuation(call.goes_on->file) : o.record;
  call.replace_record = o.replace;
  if (!o.judge.empty()) call.lesson = open_lesson(o.judge);
  call.common = o.common;
  return run_session(std::move(call));
}

/// What a case names, as far as the call does not.
RunOptions with_case(RunOptions o) {
  if (o.of_case.empty()) return o;
  const Case c = open_case(o.of_case);
  o.scene = c.lesson.scene;
  if (o.lesson.empty()) o.lesson = c.script;
  if (o.judge.empty()) o.judge = c.lesson.file;
  return o;
}

/// What a room has: its devices, before those of the call, and their calibration.
RunOptions with_room(RunOptions o) {
  if (o.room.empty()) return o;
  const Room room = open_room(o.room);
  for (const std::string& d : room.devices)
    if (DeviceSpec(d).kind == "emulated")
      throw InputError("", 0,
                       "the room " + room.name + " was set up with an emulated hand (" + d +
                           "), which operates on nobody; expected a room with a device");
  o.devices.insert(o.devices.begin(), room.devices.begin(), room.devices.end());
  o.calibration = room.calibration;
  return o;
}

}  // namespace

void add_run(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<RunOptions>();
  CLI::App* c = app.add_subcommand("run", "Operate in real time");
  CLI::Option* scene =
      c->add_option("SCENE", o->scene, "Scene file, or the name of a shipped scene (default: rhomboid)");
  CLI::Option* on =
      c->add_option("--continue", o->continued,
                    "Go on with this recording, of a session that was cut off: it is done again as far as "
                    "it is whole, the devices then take over, and all of it is recorded anew")
          ->type_name("FILE")
          ->excludes(scene);
  c->add_option("--case", o->of_case, "Scene, steps and judge of this case of the library (limberg cases)")
      ->type_name("NAME")
      ->excludes(scene)
      ->excludes(on);
  c->add_option("--device", o->devices, device_forms() + "; may be repeated (default: the mouse; without a window lcm)")
      ->type_name("SPEC");
  c->add_option("--calibration", o->calibration, "Calibration file of the device (default: identity)")
      ->type_name("FILE")
      ->excludes(on);
  c->add_option("--room", o->room, "Devices and calibration of this room (limberg rooms): its name, or its folder")
      ->type_name("NAME")
      ->excludes("--calibration")
      ->excludes(on);
  c->add_option("--record", o->record, "Record the session to this LCM log (--continue FILE.lcm: FILE-2.lcm, ...)")
      ->type_name("FILE");
  c->add_flag("--replace", o->replace, "Replace the recording if it exists");
  c->add_option("--seconds", o->seconds, "End after so long (default: when the devices end)")
      ->type_name("S")
      ->check(number_from(0.001, 86400.0));
  c->add_option("--cursor", o->cursor, "The stylus pushes a surface cursor, by this share of its own way")
      ->type_name("GAIN")
      ->check(number_from(0.05, 2.0));
  c->add_flag("--cut-at-end", o->cut_at_end, "Cut a stroke when it ends, not while it is drawn")->excludes(on);
  c->add_flag(
      "--slow-motion", o->slow_motion,
      "A live hand: where the patient falls more than 50 ms behind it, the session's clock runs slower than the "
      "wall's, to a fifth, instead of steps being skipped");
  c->add_flag("--headless", o->headless, "No window");
  c->add_option("--lesson", o->lesson,
                "Script that the window teaches and shows (default: the shipped one of the scene)")
      ->type_name("SCRIPT");
  c->add_option("--judge", o->judge, "Judge the session by this lesson: its file, or the name of a shipped one")
      ->type_name("LESSON");
  c->add_option("--mode", o->mode,
                "Of the window: guided (plan on the skin, next step, words on what is off), free, or examination (no "
                "hints, no plan, nothing is shown)")
      ->type_name("MODE")
      ->check(CLI::IsMember({"guided", "free", "examination"}));
  o->automatic.add(*c);
  o->common.add_out(*c), o->common.add_words(*c), o->common.add_json(*c), o->common.add_workers(*c),
      o->common.add_repro(*c);
  c->footer(
      "Example: limberg run rhomboid --device emulated:recordings/rhomboid.jsonl --record my.lcm --headless --out "
      "out/my");
  c->callback([o, &chosen] { chosen = [o] { return run_session(with_room(with_case(*o))); }; });
}

}  // namespace limberg
