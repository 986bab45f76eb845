#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>

#include "app/assembly/operation.h"
#include "app/commands/commands.h"
#include "app/commands/numbers.h"
#include "app/commands/recorded_call.h"
#include "app/commands/session_command.h"
#include "app/commands/this_call.h"
#include "app/export/moment.h"
#include "app/export/operated.h"
#include "app/export/story.h"
#include "app/program/interrupt.h"
#include "app/program/shipped.h"
#include "app/report/report_names.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/schema.h"
#include "app/result/tables.h"
#include "app/session/workers_pool.h"
#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg {

namespace {

constexpr size_t kMostResultBytes = size_t(1) << 28;

constexpr int kFrames = 24;

struct ExportOptions {
  std::string input, at = "end", frame = "head", scene;
  std::vector<std::string> only;  // empty: all
  int frames = kFrames;
  bool wants(const char* kind) const { return only.empty() || std::find(only.begin(), only.end(), kind) != only.end(); }
  bool without_guides = false, without_splint = false, without_mirror = false;
  CommonOptions common;
};

struct ResultExportedFile {
  std::string file;
  int64_t triangles;
  bool closed;
  Maybe volume_mm3;
};
void fields(ResultExportedFile& x, auto&& f) {
  f("file", x.file), f("triangles", x.triangles), f("closed", x.closed), f("volume_mm3", x.volume_mm3);
}
struct ResultMoment {
  std::string name, folder;
  double t_s;
  std::string state_hash;
  double displacement_max_mm;
  std::vector<ResultExportedFile> files;
  MaybeList<std::string> fields_in, left_out;
};
void fields(ResultMoment& x, auto&& f) {
  f("name", x.name), f("folder", x.folder), f("t_s", x.t_s), f("state_hash", x.state_hash);
  f("displacement_max_mm", x.displacement_max_mm), f("files", x.files), f("fields_in", x.fields_in);
  f("left_out", x.left_out);
}
struct ResultExport {
  std::string source, at, frame;
  std::vector<ResultMoment> moments;
  MaybeList<std::string> of_all;
  std::string reproduce;
};
void fields(ResultExport& x, auto&& f) {
  f("source", x.source), f("at", x.at), f("frame", x.frame), f("moments", x.moments), f("of_all", x.of_all);
  f("reproduce", x.reproduce);
}

/// A moment as it was written: its surfaces, and its fields.
struct WrittenMoment {
  ExportedMoment surfaces;
  StoryMoment story;
};
struct Written {
  std::string scene;
  std::vector<WrittenMoment> moments;
  std::vector<std::string> of_all;  // files of the whole operation
};

/// The moments that --at asks for, and the files of those that the operation has come to.
class Moments {
 public:
  Moments(const ExportOptions& o, const Scene& scene, Workers& workers)
      : o_(o),
        scene_(scene),
        workers_(workers),
        all_(o.at == "all"),
        story_(scene, o.common.out_dir, {o.wants("glb"), o.wants("vtk"), o.wants("csv"), all_}) {
    set_.guides = !o.without_guides, set_.splint = !o.without_splint, set_.mirror = !o.without_mirror;
    set_.in_picture = o.frame == "picture";
    char* end = nullptr;
    const double s = std::strtod(o.at.c_str(), &end);
    if (end && *end == 0 && end != o.at.c_str() && std::isfinite(s) && s >= 0) seconds_ = s;
  }
  /// Of a recording: so long it is. Frames of the animation are spread over it.
  void lasts(double length_s) { length_s_ = length_s; }

  /// Of a script, whose acts have a second each.
  void begin(const World& world) {
    scripted_ = true;
    if (all_) frame(world);
  }
  void act(const World& world, const Command& act) {
    story_.act(act);
    const auto* s = std::get_if<Stage>(&act);
    if (!s) return;
    names_ += (names_.empty() ? "" : ", ") + ("\"" + s->name + "\"");
    if (all_ || o_.at == s->name) take(world, s->name);
  }
  /// Of a script: an act has been carried out, and the patient is at rest.
  void acted(const World& world, const Command& command) {
    if (!std::holds_alternative<Wait>(command)) t_s_ += 1;
    act(world, command);
    if (all_ && t_s_ > framed_s_) frame(world);
  }
  /// Of a recording: a step has been taken.
  void step(const World& world, double t_s, const HandState& hands) {
    t_s_ = t_s;
    if (all_) story_.hands(t_s, hands);
    if (all_ && o_.frames > 0 && t_s >= framed_s_ + length_s_ / o_.frames) frame(world);
    if (seconds_ && t_s >= *seconds_ && out.moments.empty()) take(world, fmt::format("{:g} s", *seconds_));
  }
  void end(const World& world) {
    if (scripted_) t_s_ += 1;
    if (all_ || o_.at == "end") take(world, "end");
    if (!failure_ && !out.moments.empty()) out.of_all = story_.finish();
  }
  /// InputError: nothing has come of what was asked for.
  void check() const {
    if (failure_) std::rethrow_exception(failure_);
    if (out.moments.empty())
      throw InputError(o_.input, 0,
                       fmt::format("has no moment \"{}\"; expected {}, end, all, or seconds of a recording", o_.at,
                                   names_.empty() ? "a stage" : names_));
  }
  Written out;

 private:
  void frame(const World& world) {
    if (failure_ || o_.frames == 0 || !(o_.wants("glb") || o_.wants("csv"))) return;
    framed_s_ = t_s_;
    story_.frame(world, t_s_);
  }
  /// A session that is replayed goes on; what went wrong is thrown when it has ended.
  void take(const World& world, const std::string& name) {
    if (failure_) return;
    // No two moments have one time: programs that play them would show one.
    if (!out.moments.empty() && t_s_ <= out.moments.back().story.t_s) t_s_ = out.moments.back().story.t_s + 1e-3;
    try {
      const std::string folder =
          all_ ? fmt::format("{}/{:02d}-{}", o_.common.out_dir, out.moments.size() + 1, file_name_of(name))
               : o_.common.out_dir;
      WrittenMoment m;
      m.surfaces.name = name, m.surfaces.folder = folder;
      if (o_.wants("surfaces"))
        m.surfaces = export_moment(world, scene_, name, folder, set_, workers_);
      else
        prepare_folder(folder);
      m.story = story_.moment(world, t_s_, name, folder);
      out.moments.push_back(std::move(m));
    } catch (...) {
      failure_ = std::current_exception();
    }
  }
  const ExportOptions& o_;
  const Scene& scene_;
  Workers& workers_;
  const bool all_;
  ExportStory story_;
  ExportSettings set_;
  std::optional<double> seconds_;
  bool scripted_ = false;
  double t_s_ = 0, framed_s_ = -1e9, length_s_ = 0;
  std::string names_;
  std::exception_ptr failure_;
};

/// A script carried out once more, as operate does.
int of_script(const ExportOptions& o, Scene scene, const Script& script, Written& out) {
  WorkersPool workers(o.common.worker_count());
  const std::unique_ptr<World> world = make_world(scene, workers);
  WorldPatient patient(*world, scene.tools.max_depth_mm);
  Moments moments(o, scene, workers);
  moments.begin(*world);
  Progress progress("export");
  OperationSettings set;
  set.interrupted = interrupted;
  set.progress = [&](size_t done, size_t total) { progress.show(double(done), double(total), "actions"); };
  set.on_done = [&](const ScriptLine& l, const std::string&) { moments.acted(*world, l.command); };
  const OperationOutcome done = operate(patient, script, set);
  progress.clear();
  if (done.interrupted) return kGoalMissed;
  moments.end(*world);
  moments.check();
  out = std::move(moments.out), out.scene = scene.name;
  return kDone;
}

/// The operation whose result lies in a folder.
int of_folder(const ExportOptions& o, Written& out) {
  const std::string file = o.input + "/" + report_names::result;
  const OperatedCall call = operated_call(read_whole_file(file, kMostResultBytes, "a result"), file);
  const std::string path = o.scene.empty() ? call.scene_path : o.scene;
  if (path.empty()) throw InputError(file, 0, "does not say where its scene lies; expected --scene FILE beside it");
  Scene scene = open_scene(path);
  if (call.cell_mm > 0) scene.cell_mm = call.cell_mm;
  if (call.seed) scene.seed = *call.seed;  // of a repro-N.json, another than the scene's
  return of_script(o, std::move(scene), call.script, out);
}

/// A session, replayed.
int of_recording(const ExportOptions& o, Written& out) {
  Recording rec = open_session(given_or_shipped(o.input));
  SessionCall call;
  call.command = "replay";
  take_session(call, rec, o.input);
  take_samples(call, std::move(rec), o.input, true);
  call.common.workers = o.common.workers, call.common.simd = o.common.simd;
  const Scene scene = call.scene;
  WorkersPool workers(o.common.worker_count());
  auto moments = std::make_shared<Moments>(o, scene, workers);
  moments->lasts(call.known_length_s);
  call.watch = [moments](const World& world, const Command* act, double t_s, const HandState* hands) {
    if (act)
      moments->act(world, *act);
    else
      moments->step(world, t_s, *hands);
  };
  bool ended = false;  // an interrupt that comes later than that changes nothing
  const int status = run_session(std::move(call), [&](Result&, Assembly& a) {
    if (!interrupted()) ended = true, moments->end(*a.world);
  });
  if (!ended) return kGoalMissed;
  moments->check();
  out = std::move(moments->out), out.scene = scene.name;
  return status;
}

bool is_script(const std::string& file) { return file.ends_with(".jsonl"); }

int run_export(const ExportOptions& o) {
  o.common.prepare();
  if (o.common.out_dir.empty()) throw InputError("", 0, "export: expected --out DIR, a folder for the files");
  std::error_code same;
  if (std::filesystem::equivalent(o.input, o.common.out_dir, same))
    throw InputError(o.input, 0, "is the folder of --out too, where its result would be lost; expected another");
  prepare_folder(o.common.out_dir);
  catch_interrupts();
  Written written;
  std::error_code ec;
  int status = kDone;
  if (std::filesystem::is_directory(o.input, ec)) {
    status = of_folder(o, written);
  } else if (is_script(o.input)) {
    const Script script = load_script(given_or_shipped(o.input));
    if (o.scene.empty() && script.header.scene.empty())
      throw InputError(o.input, 1, "does not name its scene; expected --scene FILE beside it");
    status = of_script(o, open_scene(o.scene.empty() ? script.header.scene : o.scene), script, written);
  } else {
    status = of_recording(o, written);
  }
  if (written.moments.empty()) {
    say("export: interrupted; what has been written to " + o.common.out_dir + " until then is kept, and no more");
    return kGoalMissed;
  }
  Result r("export", written.scene);
  ResultExport out{o.input, o.at, o.frame, {}, unless_empty(written.of_all), this_call()};
  for (const WrittenMoment& w : written.moments) {
    const ExportedMoment& m = w.surfaces;
    ResultTable t{"At: " + m.name,
                  "In mm. STL and PLY of each; closed: every edge is passed once each way.",
                  {"file", "triangles", "closed", "volume, cm³"},
                  {}};
    ResultMoment x{m.name,
                   m.folder,
                   w.story.t_s,
                   w.story.state_hash,
                   w.story.displacement_max_mm,
                   {},
                   unless_empty(w.story.files),
                   unless_empty(m.left_out)};
    for (const ExportedFile& f : m.files) {
      x.files.push_back({f.file, f.triangles, f.closed, f.closed ? Maybe(f.volume_mm3) : Maybe()});
      t.rows.push_back({f.file, std::to_string(f.triangles), f.closed ? "yes" : "no",
                        f.closed ? fmt::format("{:.3f}", 1e-3 * f.volume_mm3) : "-"});
    }
    for (const std::string& why : m.left_out) t.rows.push_back({why, "-", "-", "-"});
    out.moments.push_back(std::move(x));
    if (!t.rows.empty()) add_table(r, t);
    std::string fields_in;
    for (const std::string& f : w.story.files) fields_in += ", " + f;
    std::printf("moment      %s: %zu surfaces%s in %s\n", m.name.c_str(), m.files.size(), fields_in.c_str(),
                m.folder.c_str());
    for (const std::string& why : m.left_out) std::printf("  left out  %s\n", why.c_str());
  }
  for (const std::string& f : written.of_all) std::printf("of all      %s/%s\n", o.common.out_dir.c_str(), f.c_str());
  write_fields(r, "", out);
  r.set_ok(status == kDone);
  leave_result(r, o.common);
  return status;
}

}  // namespace

void add_export(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<ExportOptions>();
  CLI::App* c = app.add_subcommand(
      "export",
      "An operation for other programs: an animated glTF, skin and bones as STL and PLY with the plan of a head, the "
      "lattice's fields for ParaView, tables of figures, forces and hands");
  c->add_option("RECORDING|DIR|SCRIPT", o->input,
                "A recording of a session, the folder of an operate, or a script (.jsonl)")
      ->required();
  c->add_option("--at", o->at, "A stage's name, seconds of a recording, end, or all stages and the end [end]")
      ->type_name("STAGE|SECONDS|all");
  o->common.add_out(*c);
  c->add_option("--frame", o->frame,
                "Of the surfaces' places: head (right, forwards, up), or picture (the CT's: left, posterior, superior) "
                "[head]")
      ->check(CLI::IsMember({"head", "picture"}));
  c->add_option("--scene", o->scene, "The scene of a DIR or SCRIPT, in place of the one that it names")
      ->type_name("SCENE");
  c->add_option("--only", o->only,
                "Some kinds only: surfaces (STL, PLY, plan.json), glb, vtk (VTU, VTP, PVD), csv [all]")
      ->type_name("KIND,...")
      ->delimiter(',')
      ->check(CLI::IsMember({"surfaces", "glb", "vtk", "csv"}));
  c->add_option(
       "--frames", o->frames,
       "With --at all, of a recording: pictures of the animation between its stages; 0: none, stages only [24]")
      ->type_name("N")
      ->check(whole_from(0, 1000));
  c->add_flag("--without-guides", o->without_guides, "No guides for the saw");
  c->add_flag("--without-splint", o->without_splint, "No splint between the teeth");
  c->add_flag("--without-mirror", o->without_mirror, "No mirrored parts");
  o->common.add_json(*c), o->common.add_workers(*c);
  c->footer(
      "Leaves operation.glb; NAME.stl and NAME.ply of each surface, of a head plan.json too; lattice.vtu and skin.vtp "
      "of "
      "each moment, and .pvd of all; measures.csv, forces.csv, hands.csv; result.json and report.html.\n"
      "Example: limberg export recordings/rhomboid.lcm --at all --out out/rhomboid\n"
      "         limberg operate out/patient/patient.toml out/patient/le_fort_1.jsonl --out out/maxilla\n"
      "         limberg export out/maxilla --at \"maxilla forwards\" --out out/print");
  c->callback([o, &chosen] { chosen = [o] { return run_export(*o); }; });
}

}  // namespace limberg
