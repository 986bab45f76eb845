#include <fmt/format.h>

#include <CLI/CLI.hpp>
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

struct ExportOptions {
  std::string input, at = "end", frame = "head", scene;
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
  std::vector<ResultExportedFile> files;
  MaybeList<std::string> left_out;
};
void fields(ResultMoment& x, auto&& f) {
  f("name", x.name), f("folder", x.folder), f("files", x.files), f("left_out", x.left_out);
}
struct ResultExport {
  std::string source, at, frame;
  std::vector<ResultMoment> moments;
  std::string reproduce;
};
void fields(ResultExport& x, auto&& f) {
  f("source", x.source), f("at", x.at), f("frame", x.frame), f("moments", x.moments), f("reproduce", x.reproduce);
}

/// The moments that --at asks for, and the files of those that the operation has come to.
class Moments {
 public:
  Moments(const ExportOptions& o, const Scene& scene, Workers& workers) : o_(o), scene_(scene), workers_(workers) {
    set_.guides = !o.without_guides, set_.splint = !o.without_splint, set_.mirror = !o.without_mirror;
    set_.in_picture = o.frame == "picture";
    char* end = nullptr;
    const double s = std::strtod(o.at.c_str(), &end);
    if (end && *end == 0 && end != o.at.c_str() && std::isfinite(s) && s >= 0) seconds_ = s;
  }
  void stage(const World& world, const std::string& name) {
    names_ += (names_.empty() ? "" : ", ") + ("\"" + name + "\"");
    if (o_.at == "all" || o_.at == name) take(world, name);
  }
  void step(const World& world, double t_s) {
    if (seconds_ && t_s >= *seconds_ && out.empty()) take(world, fmt::format("{:g} s", *seconds_));
  }
  void end(const World& world) {
    if (o_.at == "all" || o_.at == "end") take(world, "end");
  }
  /// InputError: nothing has come of what was asked for.
  void check() const {
    if (failure_) std::rethrow_exception(failure_);
    if (out.empty())
      throw InputError(o_.input, 0,
                       fmt::format("has no moment \"{}\"; expected {}, end, all, or seconds of a recording", o_.at,
                                   names_.empty() ? "a stage" : names_));
  }
  std::vector<ExportedMoment> out;

 private:
  /// A session that is replayed goes on; what went wrong is thrown when it has ended.
  void take(const World& world, const std::string& name) {
    if (failure_) return;
    try {
      const std::string folder =
          o_.at == "all" ? fmt::format("{}/{:02d}-{}", o_.common.out_dir, out.size() + 1, file_name_of(name))
                         : o_.common.out_dir;
      out.push_back(export_moment(world, scene_, name, folder, set_, workers_));
    } catch (...) {
      failure_ = std::current_exception();
    }
  }
  const ExportOptions& o_;
  const Scene& scene_;
  Workers& workers_;
  ExportSettings set_;
  std::optional<double> seconds_;
  std::string names_;
  std::exception_ptr failure_;
};

/// The operation whose result lies in a folder, carried out once more.
int of_folder(const ExportOptions& o, std::string& scene_name, std::vector<ExportedMoment>& out) {
  const std::string file = o.input + "/" + report_names::result;
  const OperatedCall call = operated_call(read_whole_file(file, kMostResultBytes, "a result"), file);
  const std::string path = o.scene.empty() ? call.scene_path : o.scene;
  if (path.empty()) throw InputError(file, 0, "does not say where its scene lies; expected --scene FILE beside it");
  Scene scene = open_scene(path);
  if (call.cell_mm > 0) scene.cell_mm = call.cell_mm;
  if (call.seed) scene.seed = *call.seed;  // of a repro-N.json, another than the scene's
  WorkersPool workers(o.common.worker_count());
  const std::unique_ptr<World> world = make_world(scene, workers);
  WorldPatient patient(*world, scene.tools.max_depth_mm);
  Moments moments(o, scene, workers);
  Progress progress("export");
  OperationSettings set;
  set.interrupted = interrupted;
  set.progress = [&](size_t done, size_t total) { progress.show(double(done), double(total), "actions"); };
  set.on_done = [&](const ScriptLine& l, const std::string&) {
    if (const auto* s = std::get_if<Stage>(&l.command)) moments.stage(*world, s->name);
  };
  const OperationOutcome done = operate(patient, call.script, set);
  progress.clear();
  if (done.interrupted) return kGoalMissed;
  moments.end(*world);
  moments.check();
  scene_name = scene.name, out = std::move(moments.out);
  return kDone;
}

/// A session, replayed.
int of_recording(const ExportOptions& o, std::string& scene_name, std::vector<ExportedMoment>& out) {
  Recording rec = open_session(given_or_shipped(o.input));
  SessionCall call;
  call.command = "replay";
  take_session(call, rec, o.input);
  take_samples(call, std::move(rec), o.input, true);
  call.common.workers = o.common.workers, call.common.simd = o.common.simd;
  const Scene scene = call.scene;
  scene_name = scene.name;
  WorkersPool workers(o.common.worker_count());
  auto moments = std::make_shared<Moments>(o, scene, workers);
  call.watch = [moments](const World& world, const Command* act, double t_s) {
    if (!act)
      moments->step(world, t_s);
    else if (const auto* s = std::get_if<Stage>(act))
      moments->stage(world, s->name);
  };
  const int status = run_session(std::move(call), [&](Result&, Assembly& a) {
    if (!interrupted()) moments->end(*a.world);
  });
  if (interrupted()) return kGoalMissed;
  moments->check();
  out = std::move(moments->out);
  return status;
}

int run_export(const ExportOptions& o) {
  o.common.prepare();
  if (o.common.out_dir.empty()) throw InputError("", 0, "export: expected --out DIR, a folder for the files");
  std::error_code same;
  if (std::filesystem::equivalent(o.input, o.common.out_dir, same))
    throw InputError(o.input, 0, "is the folder of --out too, where its result would be lost; expected another");
  prepare_folder(o.common.out_dir);
  catch_interrupts();
  std::string scene;
  std::vector<ExportedMoment> moments;
  std::error_code ec;
  int status = kDone;
  if (std::filesystem::is_directory(o.input, ec))
    status = of_folder(o, scene, moments);
  else
    status = of_recording(o, scene, moments);
  if (interrupted()) {
    say("export: interrupted; what has been written to " + o.common.out_dir + " until then is kept, and no more");
    return kGoalMissed;
  }
  Result r("export", scene);
  ResultExport out{o.input, o.at, o.frame, {}, this_call()};
  for (const ExportedMoment& m : moments) {
    ResultTable t{"At: " + m.name,
                  "In mm. STL and PLY of each; closed: every edge is passed once each way.",
                  {"file", "triangles", "closed", "volume, cm³"},
                  {}};
    ResultMoment x{m.name, m.folder, {}, unless_empty(m.left_out)};
    for (const ExportedFile& f : m.files) {
      x.files.push_back({f.file, f.triangles, f.closed, f.closed ? Maybe(f.volume_mm3) : Maybe()});
      t.rows.push_back({f.file, std::to_string(f.triangles), f.closed ? "yes" : "no",
                        f.closed ? fmt::format("{:.3f}", 1e-3 * f.volume_mm3) : "-"});
    }
    for (const std::string& why : m.left_out) t.rows.push_back({why, "-", "-", "-"});
    out.moments.push_back(std::move(x));
    add_table(r, t);
    std::printf("moment      %s: %zu surfaces in %s\n", m.name.c_str(), m.files.size(), m.folder.c_str());
    for (const std::string& why : m.left_out) std::printf("  left out  %s\n", why.c_str());
  }
  write_fields(r, "", out);
  r.set_ok(status == kDone);
  leave_result(r, o.common);
  return status;
}

}  // namespace

void add_export(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<ExportOptions>();
  CLI::App* c = app.add_subcommand(
      "export", "Fragments, plates, face and skin as STL and PLY, with the plan's moves, guides and splint of a head");
  c->add_option("RECORDING|DIR", o->input, "A recording of a session, or the folder of an operate")->required();
  c->add_option("--at", o->at, "A stage's name, seconds of a recording, end, or all stages and the end [end]")
      ->type_name("STAGE|SECONDS|all");
  o->common.add_out(*c);
  c->add_option("--frame", o->frame,
                "Of the surfaces' places: head (right, forwards, up), or picture (the CT's: left, posterior, superior) "
                "[head]")
      ->check(CLI::IsMember({"head", "picture"}));
  c->add_option("--scene", o->scene, "The scene of a DIR, where its file is no longer where it was")
      ->type_name("SCENE");
  c->add_flag("--without-guides", o->without_guides, "No guides for the saw");
  c->add_flag("--without-splint", o->without_splint, "No splint between the teeth");
  c->add_flag("--without-mirror", o->without_mirror, "No mirrored parts");
  o->common.add_json(*c), o->common.add_workers(*c);
  c->footer(
      "Leaves NAME.stl and NAME.ply of each surface, of a head plan.json too, result.json and report.html.\n"
      "Example: limberg operate out/patient/patient.toml out/patient/le_fort_1.jsonl --out out/maxilla\n"
      "         limberg export out/maxilla --at \"maxilla forwards\" --out out/print");
  c->callback([o, &chosen] { chosen = [o] { return run_export(*o); }; });
}

}  // namespace limberg
