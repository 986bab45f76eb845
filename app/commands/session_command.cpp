#include "app/commands/session_command.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>

#include "app/commands/left_recordings.h"
#include "app/export/page_model.h"
#include "app/head/report.h"
#include "app/pictures/pictures.h"
#include "app/program/interrupt.h"
#include "app/program/shipped.h"
#include "app/program/version.h"
#include "app/report/report.h"
#include "app/report/report_names.h"
#include "app/report/viewer.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/run_result.h"
#include "app/session/as_recorded.h"
#include "app/session/clock.h"
#include "app/session/lockstep.h"
#include "app/session/realtime.h"
#include "devices/continued_source.h"
#include "devices/log_source.h"
#include "devices/unfinished.h"
#include "render/gl_context.h"
#include "sim/base/error.h"
#include "sim/commands/kinds.h"
#include "sim/fem/solver/engine.h"
#include "sim/patient/soft_tissue.h"

namespace limberg {

namespace {

/// A time as one says it.
std::string about_s(double s) {
  return s < 100    ? fmt::format("{:.0f} s", s)
         : s < 6000 ? fmt::format("{:.0f} min", s / 60)
                    : fmt::format("{:.1f} h", s / 3600);
}

bool is_special(const std::string& file) {
  struct stat st {};
  return stat(file.c_str(), &st) == 0 && !S_ISREG(st.st_mode) && !S_ISDIR(st.st_mode);
}

/// Version, commit, compiler and instructions: all that could make two programs differ.
std::string build_name() {
  return program_name() + ", " + compiler() + ", " + processor() + " " + fem::default_kernels().name;
}

int64_t utc_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::unique_ptr<Recorder> open_recorder(const SessionCall& call, Assembly& a) {
  if (call.record_file.empty()) return nullptr;
  SessionInfo info;
  info.program = build_name().substr(0, 95);
  info.scene_name = a.scene.name.substr(0, 63);
  info.scene_hash = a.scene.hash;
  info.calibration_hash = calibration_hash(a.calibration);
  info.seeds = {a.scene.seed, call.surgeon_seed,
                (call.progressive_cut ? SessionInfo::kProgressiveCut : 0) |
                    (call.threads_slip ? SessionInfo::kThreadsSlip : 0) | (call.in_space ? SessionInfo::kInSpace : 0) |
                    (call.as_meant ? SessionInfo::kAsMeant : 0),
                0};
  info.ticks_per_solver_step = a.session_settings().ticks_per_solver_step;
  info.ticks_per_frame = a.session_settings().ticks_per_frame;
  info.solver_delay_ticks = 0;
  info.utc_start_ns = call.real_time ? utc_ns() : 0;  // a virtual clock began at no time: the same call, the same bytes
  if (call.goes_on) {
    info.utc_start_ns = call.goes_on->session.utc_start_ns, info.seeds = call.goes_on->session.seeds;
    info.seeds[SessionInfo::kGoesOnWith] = recording_mark(call.goes_on->file);
  }
  return std::make_unique<Recorder>(a.channels, call.record_file, info,
                                    call.goes_on ? call.goes_on->files : bundle(a.scene, a.calibration),
                                    call.replace_record || is_special(call.record_file));
}

/// checkpoints: hashes of the recorded run that were met again. difference_mm, difference_N: where not all were, the
/// largest distance of a sampled place and the largest difference of a sum of forces (devices/state_sample.h).
struct ResultCheckpoints {
  int64_t compared, equal;
  Maybe first_difference_s;
  Maybe difference_mm, difference_N;
};
void fields(ResultCheckpoints& x, auto&& f) {
  f("compared", x.compared), f("equal", x.equal), f("first_difference_s", x.first_difference_s);
  f("difference_mm", x.difference_mm), f("difference_N", x.difference_N);
}

/// recorded_by: the program that made a recording, as its header says; simd and compiler absent in headers of old.
struct ResultRecordedBy {
  std::string version, simd, compiler;
};
void fields(ResultRecordedBy& x, auto&& f) { f("version", x.version), f("simd", x.simd), f("compiler", x.compiler); }

/// Of what build_name() wrote.
ResultRecordedBy recorded_by(const std::string& program) {
  const size_t compiler = program.find(", "), machine = program.find(", ", compiler == program.npos ? 0 : compiler + 2);
  ResultRecordedBy by{program.substr(0, compiler), "", ""};
  if (compiler != program.npos) by.compiler = program.substr(compiler + 2, machine - compiler - 2);
  if (machine != program.npos && machine != compiler) by.simd = program.substr(machine + 2);
  return by;
}

/// failure: of a lane, and with it of the session. recording: what is kept of it.
struct ResultFailure {
  MaybeText where, what;
  double at_s;
  std::string recording;
};
void fields(ResultFailure& x, auto&& f) {
  f("where", x.where), f("what", x.what), f("at_s", x.at_s), f("recording", x.recording);
}

/// ": by at most 0.02 mm and 0.1 N where it was sampled".
std::string amount_of(const StateDifference& d) {
  if (d.compared == 0) return "";  // recorded before places were
  std::string s;
  if (d.compared > d.other_topology)
    s = fmt::format(": by at most {:.2g} mm, and {:.2g} N of stitches or hooks, where it was sampled", d.mm, d.N);
  if (d.other_topology > 0)
    s += fmt::format("{} in {} of {} samples the cuts are others", s.empty() ? ":" : ";", d.other_topology, d.compared);
  return s;
}

std::string reason_for(const SessionCall& call) {
  if (call.damage.total() > 0) return "the recording is damaged (below)";
  if (call.recorded_by == build_name()) return "it was made by this very program: please report it as a defect";
  return "it was made by " + call.recorded_by + ", this is " + build_name();
}

/// Says where a replay differs; nothing where there was nothing to compare.
std::optional<ResultCheckpoints> compare_checkpoints(const SessionCall& call, const SolverLane& solver,
                                                     const SessionFigures& f) {
  int64_t compared = f.hashes_compared, equal = f.hashes_equal, first_difference = f.first_difference_tick;
  for (const Checkpoint& want : call.expected)
    for (const Checkpoint& got : f.checkpoints)
      if (want.tick == got.tick && want.hash != 0) {
        ++compared;
        if (want.hash == got.hash)
          ++equal;
        else if (first_difference < 0)
          first_difference = want.tick;
        break;
      }
  if (compared == 0) return std::nullopt;
  ResultCheckpoints c;
  c.compared = compared, c.equal = equal;
  if (first_difference >= 0) c.first_difference_s = double(first_difference) * 1e-3;
  const StateDifference& d = solver.difference();
  if (first_difference >= 0 && d.compared > d.other_topology) c.difference_mm = d.mm, c.difference_N = d.N;
  if (first_difference >= 0)
    say("this run differs from the recorded one from second " + std::to_string(first_difference / 1000) + " on" +
        amount_of(d) + "; " + reason_for(call));
  return c;
}

/// Of a recording that was done again.
void tell_recorded(Result& r, const SessionCall& call, std::optional<ResultCheckpoints> checkpoints) {
  if (call.recorded_by.empty()) return;
  ResultRecordedBy by = recorded_by(call.recorded_by);
  write_fields(r, "/recorded_by", by);
  if (checkpoints) write_fields(r, "/checkpoints", *checkpoints);
}

/// continued: the recording that the session went on with, and from which second on.
struct ResultContinued {
  std::string file;
  double from_s;
};
void fields(ResultContinued& x, auto&& f) { f("file", x.file), f("from_s", x.from_s); }

/// What each live device sent; of one that sent nothing also why, where it says so.
void tell_devices(Result& r, const std::vector<std::string>& names, const std::vector<const Source*>& devices) {
  for (size_t i = 0; i < devices.size(); ++i) {
    const SourceCounts c = devices[i]->counts();
    const std::string health = devices[i]->health();
    append(r, "/device/sources", ResultSource{names[i], c.samples, c.malformed, c.lost, health});
    if (c.samples == 0) say("--device " + names[i] + " sent nothing" + (health.empty() ? "" : ": " + health));
  }
}

void print_summary(const SessionCall& call, const Assembly& a, const SessionFigures& f) {
  std::printf("scene       %s\n", a.scene.name.c_str());
  std::printf("mode        %s, %.2f s\n", call.real_time ? "real time" : "lockstep", f.duration_s);
  std::printf("commands    %llu done, %zu refused\n", static_cast<unsigned long long>(a.solver.commands()),
              a.solver.refused().size());
  std::printf("solver      %llu steps, %.2f ms median, residual %.2e, about %.2g mm from equilibrium\n",
              static_cast<unsigned long long>(a.solver.steps()), double(f.solver.work.percentile_ns(0.5)) * 1e-6,
              a.solver.last().residual, a.solver.last().distance_mm);
  if (a.world->skin()) std::printf("pieces      %d\n", a.world->skin()->pieces());
  if (a.head) print_head(*a.head);
  std::printf("state_hash  %s\n", hex(f.state_hash).c_str());
  const HandFigures& h = a.solver.hand();
  if (h.path_mm > 0)
    std::printf("hand        %.0f mm in %d movements, %d gaps in tracking\n", h.path_mm, h.movements, h.gaps);
}

}  // namespace

void leave_figures(const Result& result, const CommonOptions& common) {
  if (!common.json_file.empty()) result.write(common.json_file);
  if (common.out_dir.empty()) return;
  const std::string own = common.out_dir + "/" + report_names::result;
  std::error_code ec;
  if (common.json_file.empty() || !std::filesystem::equivalent(own, common.json_file, ec)) result.write(own);
}

void leave_result(const Result& result, const CommonOptions& common) {
  leave_figures(result, common);
  if (common.out_dir.empty()) return;
  std::printf("report      %s\n", write_report(common.out_dir, common.words()).c_str());
}

void mark_stopped(Result& result) {
  result.set("/interrupted", true);
  result.set_ok(false);
}

/// A recording that is made in case it is wanted: beside the machine's temporary files, kept or removed at the end. A
/// session that fails or is killed leaves it there, and it can be replayed.
class AsideRecording {
 public:
  explicit AsideRecording(const std::string& keep_dir)
      : dir_(keep_dir),
        file_((std::filesystem::temp_directory_path() / ("limberg-session-" + std::to_string(getpid()) + ".lcm"))
                  .string()) {}
  const std::string& file() const { return file_; }
  /// Nobody wants it.
  void remove() const {
    std::error_code ec;
    std::filesystem::remove(file_, ec);
  }
  /// The name under which it was kept: limberg-N.lcm, never replacing a file. InputError when it cannot be: then it
  /// stays where it was made.
  std::string keep() const {
    std::string name;
    int n = 0;
    std::error_code ec;
    do name = dir_ + "/limberg-" + std::to_string(++n) + ".lcm";
    while (std::filesystem::exists(name, ec));
    std::filesystem::copy_file(file_, name, ec);
    if (std::error_code gone; ec) {
      std::filesystem::remove(name, gone);  // a part of it is of no use to anybody
      throw InputError(name, 0,
                       "the recording cannot be kept there (" + ec.message() + "), it is in " + file_ +
                           "; expected a folder with room and the right to write");
    }
    remove();
    return name;
  }

 private:
  std::string dir_, file_;
};

/// Where a session that cannot go on leaves its recording; empty: it has none, or nothing was recorded.
std::string keep_after_failure(const std::optional<AsideRecording>& aside, Recorder* recorder) {
  if (!recorder) return "";
  recorder->cut_short();
  if (recorder->samples() == 0 && !is_special(recorder->path())) {  // nobody misses an empty session
    std::error_code ec;
    std::filesystem::remove(recorder->path(), ec);
    return "";
  }
  if (!aside) return recorder->path();
  try {
    return aside->keep();
  } catch (const InputError&) {
    return aside->file();
  }
}

/// A session that cannot go on: says where and after how long, leaves its recording and what figures there are, and
/// throws the cause on.
[[noreturn]] void leave_failure(const SessionFailure& failure, const SessionCall& call, Assembly& a,
                                const std::string& recording) {
  const SessionFigures& f = failure.figures;
  if (f.ticks > 0) {
    say(fmt::format("the session ended after {:.1f} s, in its {}", f.duration_s, failure.what()));
    Result result(call.command, a.scene.name);
    write_fields(result, "/failure", ResultFailure{failure.where, words_of(failure.cause), f.duration_s, recording});
    try {
      fill_session(result, a, f, call.real_time, call.lesson ? &*call.lesson : nullptr);
    } catch (const std::exception& e) {
      say(std::string("some of its figures cannot be told: ") + e.what());
    }
    result.set_ok(false);
    try {
      leave_result(result, call.common);
    } catch (const std::exception& e) {
      say(e.what());
    }
    if (!recording.empty())
      say(fmt::format("what was recorded until then is kept: limberg replay {} repeats it{}", recording,
                      call.real_time ? ", limberg run --continue " + recording + " goes on with it" : ""));
  }
  std::rethrow_exception(failure.cause);
}

namespace {

/// Where the recording goes is settled before anything is built.
std::optional<AsideRecording> settle_recording(SessionCall& call) {
  std::optional<AsideRecording> aside;
  if (call.window && call.record_file.empty() && !call.keep_dir.empty()) {
    aside.emplace(call.keep_dir);
    call.record_file = aside->file(), call.replace_record = true;
  }
  if (!call.record_file.empty() && !is_special(call.record_file)) {
    check_writable(call.record_file);
    if (const auto left = unfinished_recording(call.record_file); left && !call.replace_record)
      throw InputError(
          call.record_file, 0,
          fmt::format("holds a session that was cut off after {:.1f} s; expected limberg run --continue {}, "
                      "the name of a new file, or --replace",
                      left->length_s, call.record_file));
    if (std::error_code ec; !call.replace_record && std::filesystem::exists(call.record_file, ec))
      throw InputError(call.record_file, 0, "exists already; expected the name of a new file, or --replace");
    check_replaces_recording(call.record_file);
  }
  return aside;
}

AssemblyOptions assembly_options(const SessionCall& call) {
  AssemblyOptions o;
  o.workers = call.common.worker_count();
  o.record = !call.record_file.empty();
  o.real_time = call.real_time;
  o.progressive_cut = call.progressive_cut, o.threads_slip = call.threads_slip, o.in_space = call.in_space;
  o.as_meant = call.as_meant;
  // Nobody sees frames: a window or a film says so itself. In real time a session with pictures draws them all the
  // same, so that its times are those of a session that is looked at.
  o.draw_frames = call.real_time && !call.common.out_dir.empty();
  o.repro_dir = call.common.repro();
  o.watch = call.watch;
  if (!call.common.out_dir.empty()) o.script_file = call.common.out_dir + "/session.jsonl";
  return o;
}

/// Null: there is none, and a device is enough.
std::unique_ptr<SessionWindow> open_window(const SessionCall& call, const std::string& word) {
  if (!call.window) return nullptr;
  try {
    return call.window(call.scene, word);
  } catch (const RenderUnavailable& e) {
    say(e.what());
    if (call.sources.empty() && call.live_sources.empty())
      throw InputError("", 0,
                       "no window and no device: nothing can be done to the patient; expected a display, or --device");
    say("going on without a window");
    return nullptr;
  }
}

/// A film and a replay take as long as they need: what is left goes by what was needed until now.
std::function<void(int64_t)> progress_line(const SessionCall& call, Progress& progress) {
  return [&call, &progress, began_ns = RealClock::monotonic_ns()](int64_t tick) {
    const double done_s = double(tick) * 1e-3, took_s = double(RealClock::monotonic_ns() - began_ns) * 1e-9;
    if (call.real_time || call.known_length_s <= 0 || done_s < 0.02 * call.known_length_s)
      progress.show(done_s, call.known_length_s, "s");
    else
      progress.show(done_s, call.known_length_s,
                    ("s, " + about_s(took_s * std::max(0.0, call.known_length_s / done_s - 1)) + " left").c_str());
  };
}

/// How the session came to be, and what went wrong on the way, into the result and to the person.
void tell_story(Result& result, const SessionCall& call, const Assembly& a, const Recorder* recorder) {
  ResultStory story = made_by(call.reproduce);
  story.repro = unless_empty(a.repro.files());
  if (recorder && recorder->failed()) story.recording_error = recorder->error();
  write_fields(result, "", story);
  for (const Refusal& r : a.solver.refused()) say(fmt::format("{:.2f} s: {} refused: {}", r.t_s, r.command, r.reason));
  for (const std::string& file : a.repro.files())
    say("a refused cut can be tried again: limberg operate " + a.scene.name + " " + file);
  if (!a.repro.error().empty()) say(a.repro.error());
  if (!a.script_error.empty()) say("the session's script is cut short: " + a.script_error);
}

/// The model of the page. On a virtual clock it is looked at while it goes on; in real time only at its stages, and the
/// solver's thread has nothing more to do.
class SessionModel {
 public:
  static constexpr int kFrames = 30;

  explicit SessionModel(double length_s) : every_s_(std::max(length_s, 1.0) / kFrames) {}
  void watch(const World& world, const Command* act, double t_s) {
    if (!act) {
      t_s_ = t_s;
      if (t_s < next_s_) return;
      world.fill(now_), model_.frame(t_s, now_), next_s_ = t_s + every_s_;
      if (++frames_ == 2 * kFrames) model_.thin(), frames_ = kFrames, every_s_ *= 2;  // it lasts longer than was known
      return;
    }
    world.fill(now_);
    if (const auto* s = std::get_if<Stage>(act))
      model_.stage(t_s_, s->name, now_);
    else if (!leaves_patient(*act))
      model_.done(t_s_, *act);
  }
  void stages(const std::vector<StageRow>& rows) {
    if (!model_.empty()) return;
    for (const StageRow& s : rows) model_.stage(s.t_s, s.name, s.shown), t_s_ = s.t_s;
  }
  void leave(const std::string& dir, const std::string& title, const Snapshot& last, const Camera& camera,
             double aspect) {
    model_.frame(t_s_ + 1e-3, last);
    model_.leave(dir, title, camera, aspect);
  }

 private:
  PageModel model_{"s"};
  double every_s_, next_s_ = 0, t_s_ = 0;
  int frames_ = 0;
  Snapshot now_;
};

/// What could not be written, if so: the figures of the session are left even then. `stopped`: a person had enough of
/// the drawing.
std::optional<InputError> leave_pictures(Result& result, const SessionCall& call, Assembly& a, const Snapshot& first,
                                         SessionModel* model, bool& stopped) {
  stopped = false;
  if (call.common.out_dir.empty()) return std::nullopt;
  try {
    Snapshot last;
    a.patient->fill_with_field(last);  // with the tension
    if (a.world->skin())
      stopped = !draw_report_pictures(call.common.out_dir, a.solver.stages(), last, call.common.words());
    else if (a.head)
      stopped = !draw_head_pictures(call.common.out_dir, a.solver.stages(), first, last, scene_camera(a.scene), *a.head,
                                    call.common.words());
    if (model) {
      model->stages(a.solver.stages());
      const bool skin = a.world->skin();
      model->leave(call.common.out_dir, a.scene.name, last, skin ? report_camera(last) : scene_camera(a.scene),
                   skin ? kReportAspect : kHeadAspect);
    }
    if (a.head)
      leave_head_figures(result, *a.head, a.scene.head->normal_files, call.common.out_dir, last, scene_camera(a.scene),
                         a.workers);
  } catch (const InputError& e) {
    return e;
  }
  return std::nullopt;
}

/// The recording's last name, told; one that nobody wants is removed.
void leave_recording(const std::optional<AsideRecording>& aside, bool keep, const Recorder* recorder) {
  if (recorder && !recorder->failed()) {
    const std::string file = !aside ? recorder->path() : keep ? aside->keep() : "";
    if (!file.empty()) fmt::print("recording   {}, {} samples\n", file, recorder->samples());
  }
  if (aside && !keep) aside->remove();
}

/// Where the recordings of a session lie, and those that an earlier one may have left.
std::vector<std::string> folders_of(const SessionCall& call, bool aside) {
  std::vector<std::string> folders{call.common.out_dir, call.keep_dir};
  std::error_code ec;
  if (aside)
    folders.push_back(std::filesystem::temp_directory_path(ec).string());
  else if (!call.record_file.empty() && !is_special(call.record_file))
    folders.push_back((std::filesystem::path(call.record_file).parent_path() / ".").string());
  return folders;
}

/// The earlier part of a session once more, unseen, with everything of it in the new recording.
SessionFigures do_again(const SessionCall& call, Assembly& a, Recorder* recorder, TakenSource* taken,
                        SessionSettings set) {
  RenderLane unseen(a.channels, nullptr, false);
  const SessionLanes lanes{a.device, a.solver, unseen, recorder};
  set.goes_on = true, set.end_tick = call.goes_on->end_tick, set.settle_steps = 0;
  return taken ? run_as_recorded(lanes, set, call.schedule, *taken) : run_lockstep(lanes, set);
}

/// On a whole solver step.
int64_t first_tick_after(int64_t last, int step) { return (last / step + 1) * step; }

int leave_as_it_was(const SessionCall& call, Recorder& recorder) {
  recorder.cut_short();
  std::error_code ec;
  std::filesystem::remove(recorder.path(), ec);
  say("interrupted before it went on; " + call.goes_on->file + " is as it was");
  return kGoalMissed;
}

}  // namespace

std::string whole_path(const std::string& file) {
  std::error_code ec;
  const std::filesystem::path whole = std::filesystem::weakly_canonical(file, ec);
  return ec ? file : whole.string();
}

void check_lesson(const Lesson& lesson, const Scene& scene) {
  if (lesson.bone ? !scene.head : !scene.flesh)
    throw InputError(lesson.file, 0,
                     "is a lesson on " + std::string(lesson.bone ? "bones" : "skin") + ", and the scene " + scene.name +
                         " is judged by its " + (scene.head ? "bones" : "skin") + "; expected a lesson on those");
  if (const std::string other = made_for_another(lesson, scene.name, scene.path); !other.empty()) say(other);
}

void check_lesson(const Lesson& lesson, const Head* head) {
  if (!lesson.bone || !head) return;
  if (const std::string missing = plan_lacks(*lesson.bone, head->landmarks()); !missing.empty())
    throw InputError(lesson.file, 0, "asks for what this head lacks: " + missing + "; expected its landmarks");
}

int run_session(SessionCall call, const std::function<void(Result&, Assembly&)>& after) {
  if (call.lesson) check_lesson(*call.lesson, call.scene);
  catch_interrupts();
  call.common.prepare();
  const std::optional<AsideRecording> aside = settle_recording(call);
  std::string left;
  if (!call.goes_on && call.command != "replay") left = offer_to_continue(folders_of(call, aside.has_value()));

  // The patient, and all that looks at it or acts on it.
  std::shared_ptr<SessionModel> model;
  if (!call.common.out_dir.empty() && viewer_is_built()) {
    model = std::make_shared<SessionModel>(call.known_length_s);
    if (!call.real_time)
      call.watch = [model, also = call.watch](const World& w, const Command* act, double t_s, const HandState* hands) {
        model->watch(w, act, t_s);
        if (also) also(w, act, t_s, hands);
      };
  }
  AssemblyOptions o = assembly_options(call);
  OffscreenFrames frames(call.scene, 640, 480);
  if (o.draw_frames) o.sink = &frames;
  std::unique_ptr<SessionWindow> window = open_window(call, left);
  if (window) o.sink = &window->sink(), o.draw_frames = true;
  std::unique_ptr<Film> film;
  if (call.film) {
    film = std::make_unique<Film>(call.scene, *call.film);
    o.sink = film.get(), o.draw_frames = true;
  }
  Assembly a(std::move(call.scene), call.calibration, o);
  a.solver.expect(std::move(call.expected_states));
  if (call.lesson) check_lesson(*call.lesson, a.head);
  call.scene_files.reset();
  if (call.goes_on)
    for (auto& s : call.goes_on->earlier) a.front.add(std::move(s));
  TakenSource* taken = nullptr;
  if (call.schedule.usable()) {
    auto source = std::make_unique<TakenSource>(std::move(call.taken));
    taken = source.get();
    a.front.add(std::move(source));
  }
  const std::unique_ptr<Recorder> recorder = open_recorder(call, a);

  Progress progress(call.command);
  SessionSettings set = a.session_settings();
  if (call.ticks_per_solver_step > 0) set.ticks_per_solver_step = call.ticks_per_solver_step;
  set.end_tick = call.end_tick;
  set.stop_when_recording_fails = call.command == "emulate";
  set.hand_waits = call.hand_waits;
  if (call.slow_motion) set.slow_motion = std::make_shared<SlowedTime>();
  set.settle_when_closed = call.lesson.has_value();  // a judge looks at the patient at rest
  set.interrupted = interrupted;
  set.progress = progress_line(call, progress);
  set.say = [&](const std::string& line) { progress.clear(), say(line); };
  if (window) set.gauges = &window->gauges();
  if (window || call.headset)
    set.pump = [&] {
      if (window) window->pump();
      if (call.headset)
        for (std::string line; call.headset->words.take(line);) set.say(line);
    };
  if (call.headset) call.headset->channels = &a.channels, call.headset->camera = scene_camera(a.scene);
  // On a virtual clock frames are samples of the picture, one a second.
  if (!call.real_time) set.ticks_per_frame = film ? 1000 / call.film->frames_per_s : 1000;
  // A recording that is whole says itself how it came to rest.
  if (!call.real_time && taken && call.end_tick >= 0) set.settle_steps = 0;

  // What it goes on with, and the hands of both parts as one.
  std::optional<SessionFailure> failure;
  std::optional<ResultCheckpoints> checkpoints;
  SessionFigures before;
  std::shared_ptr<EarlierPart> earlier;
  if (call.goes_on) {
    try {
      before = do_again(call, a, recorder.get(), taken, set);
    } catch (const SessionFailure& e) {
      failure = e;
    }
    progress.clear();
    if (before.interrupted) return leave_as_it_was(call, *recorder);
    checkpoints = compare_checkpoints(call, a.solver, before);
    set.first_tick = first_tick_after(before.last_tick, set.ticks_per_solver_step);
    earlier = std::make_shared<EarlierPart>(call.goes_on->samples, set.first_tick * kDeviceTickNs);
    if (set.end_tick >= 0) set.end_tick += set.first_tick;
    a.front.add(std::make_unique<LogSource>(earlier->let_go()));
    say(fmt::format("{}: {:.1f} s are done again; the session goes on, and is recorded in {}", call.goes_on->file,
                    before.duration_s, recorder->path()));
  }
  const auto add = [&](std::unique_ptr<Source> s) {
    a.front.add(earlier ? std::make_unique<ContinuedSource>(std::move(s), earlier) : std::move(s));
  };
  for (auto& s : call.sources) add(std::move(s));
  if (window) add(window->pointer(a.channels));

  // The session.
  SessionFigures f;
  std::vector<const Source*> devices;  // as in call.live_names
  Snapshot first;
  if (a.head && !call.common.out_dir.empty()) a.patient->fill_with_field(first);  // for the pictures
  const auto connect = [&](int64_t start_ns) {
    // Between the opening of the recording and tick 0 lie seconds.
    if (recorder && !earlier) recorder->began(utc_ns() + start_ns - RealClock::monotonic_ns());
    for (const LiveSource& live : call.live_sources) {
      auto source =
          live({SourceTime(start_ns, set.slow_motion, set.first_tick * kDeviceTickNs), a.channels.press, call.headset});
      devices.push_back(source.get());
      add(std::move(source));
    }
  };
  if (call.real_time && !call.live_sources.empty()) a.channels.press = std::make_shared<PressLine>();
  try {
    if (!failure)
      f = call.real_time ? run_realtime(a.lanes(recorder.get()), set, {}, connect)
          : taken        ? run_as_recorded(a.lanes(nullptr), set, call.schedule, *taken)
                         : run_lockstep(a.lanes(recorder.get()), set);
  } catch (const SessionFailure& e) {
    failure = e;
  }
  progress.clear();
  if (call.headset) call.headset->over = true;
  const bool keep = window && window->keep_recording();
  window.reset();
  if (failure) leave_failure(*failure, call, a, keep_after_failure(aside, recorder.get()));
  if (film) {
    film->close();
    const FilmTimes& t = film->times();
    fmt::print("film        {}, {} frames, {} of them drawn, in {:.0f} s; {:.0f} s with ffmpeg\n", call.film->file,
               t.frames, t.drawn, t.drawing_s, t.encoding_s);
  }

  // What it leaves.
  Result result(call.command, a.scene.name);
  const std::vector<ResultVerdict> verdict =
      fill_session(result, a, f, call.real_time, call.lesson ? &*call.lesson : nullptr);
  if (call.point) fill_operating_point(result, *call.point);
  fill_damage(result, call.damage);
  f.solver.skipped += before.solver.skipped;
  if (!call.real_time) checkpoints = compare_checkpoints(call, a.solver, f);
  tell_recorded(result, call, checkpoints);
  if (earlier) {
    ResultContinued from{call.goes_on->file, before.duration_s};
    write_fields(result, "/continued", from);
  }
  tell_story(result, call, a, recorder.get());
  tell_devices(result, call.live_names, devices);
  if (after) after(result, a);
  const bool recording_failed = recorder && recorder->failed();
  const bool at_rest = f.interrupted || f.closed || a.solver.at_rest(1e-4);
  bool reached = at_rest && !is_bad(verdict), stopped = false;
  // A live session may be ended at any time; a recording that was not replayed to its end has not been compared whole.
  if (f.interrupted && std::string_view(call.command) == "replay") reached = false;
  result.set_ok(reached && !recording_failed);
  if (f.interrupted) leave_figures(result, call.common);
  const std::optional<InputError> unwritten = leave_pictures(result, call, a, first, model.get(), stopped);
  if (stopped) mark_stopped(result), reached = false;
  print_summary(call, a, f);
  leave_recording(aside, keep, recorder.get());
  leave_result(result, call.common);
  print_verdict(verdict);
  if (unwritten) throw InputError(*unwritten);
  if (recording_failed) {
    say("the recording is cut short: " + recorder->error());
    return kBadInput;
  }
  if (f.interrupted) say("interrupted; what was done and recorded until then is kept");
  if (!at_rest) say("the patient did not come to rest: relative residual above 1e-4");
  // Not all of what was recorded could be replayed. That a session which goes on was cut off within an event is why it
  // goes on.
  const int64_t cut_off = call.goes_on ? call.damage.truncated : 0;
  if (call.damage.total() > cut_off) return kGoalMissed;
  return reached ? kDone : kGoalMissed;
}

}  // namespace limberg
