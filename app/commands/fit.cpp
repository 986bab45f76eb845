#include "sim/imaging/fit/fit.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <tuple>

#include "app/commands/commands.h"
#include "app/commands/fit_sweep.h"
#include "app/commands/length_unit.h"
#include "app/commands/numbers.h"
#include "app/commands/session_command.h"
#include "app/commands/this_call.h"
#include "app/head/skull_comparison.h"
#include "app/operating_point/cpu_clock.h"
#include "app/program/interrupt.h"
#include "app/report/report_names.h"
#include "app/result/metrics.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/schema.h"
#include "app/result/tables.h"
#include "app/session/workers_pool.h"
#include "render/gl_context.h"
#include "render/picture.h"
#include "sim/base/error.h"
#include "sim/imaging/io/surface_file.h"
#include "sim/imaging/register/superposition.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/file.h"

namespace limberg {

namespace {

constexpr double kFound = 0.95;     // of the vertices must have the surface within two voxels
constexpr double kRmsVoxels = 0.5;  // and lie so near it, rms (both: issue list of the craniofacial part)
// This share of a scan's points must lie within two spacings of the mesh; of a plane's scan, of the points facing it.
constexpr double kReached = 0.9;
constexpr double kThin = 100;  // HU: above muscle and brain (45), what .3 mm of cortical bone adds in a voxel of 3.2 mm
constexpr double
    kSmallest = 60,
    kLargest = 1000;  // mm: a scan of a face or head is between them; one that is not was likely written in other units
// edges along a scan's diagonal where --edge-mm is not given (4 mm for a face of 300 mm, as for volumes)
constexpr double kScanEdges = 75;

struct FitOptions {
  std::string volume, tissue, mesh_file, start = "sphere", sweep_dir, report_dir, series, unit = "mm";
  std::vector<double> from;
  double iso = 0, offset = 0, edge_mm = 4, chord_mm = 0, seal_mm = -1, mouth_mm = -1, thin = -1, smooth = 0.6,
         parts = 1, metric_gain = 0;
  bool has_iso = false, has_edge = false, bridge_missing = false;
  CommonOptions common;
};

void print(const FitReport& r, double voxel, const char* unit) {
  std::printf(
      "surface     %.1f %% of the vertices have it within two %ss; %.1f %% of it is within two %ss of the mesh\n",
      100 * r.found, unit, 100 * r.reached, unit);
  std::printf("distance    rms %.3f mm, 95 %% within %.3f mm, at most %.3f mm (%s %.3f mm)\n", r.rms_mm, r.p95_mm,
              r.max_mm, unit, voxel);
  std::printf("            surface to mesh: rms %.3f mm, 95 %% within %.3f mm\n", r.surface_rms_mm, r.surface_p95_mm);
  if (r.on_walls > 0)
    std::printf(
        "thin walls  %d vertices lie where bone is thinner than the voxels show: they are closed, and not counted "
        "above\n",
        r.on_walls);
  if (r.joined + r.cut > 0) std::printf("topology    %d sheets joined (t3), %d tubes cut (t4)\n", r.joined, r.cut);
  for (const FitHole& h : r.hole)
    std::printf("opening     %-52s at (%.0f, %.0f, %.0f) mm, %.0f mm around, %d vertices\n", h.place.c_str(),
                h.centre_mm.x(), h.centre_mm.y(), h.centre_mm.z(), h.around_mm, h.vertices);
  for (const std::string& n : r.notes) std::printf("note        %s\n", n.c_str());
}

/// openings: end contours of the mesh.
struct ResultOpening {
  MaybeText place;
  double around_mm;
  int64_t vertices;
  ResultVector centre_mm;
};
void fields(ResultOpening& x, auto&& f) {
  f("place", x.place), f("around_mm", x.around_mm), f("vertices", x.vertices), f("centre_mm", x.centre_mm);
}

/// A fit to a range scan (scan ... hidden) or to a volume (volume ... smooth_voxels); then what both have. missed: what
/// was wanted and is not so.
struct ResultMeshFit {
  MaybeText scan;
  MaybeCount points;
  MaybeText volume, tissue;
  Maybe iso;
  MaybeText mesh, start;
  Maybe seal_mm, mouth_mm, smooth_voxels, edge_mm, metric_gain, voxel_mm, cpu_s;
  MaybeText unit, warning;
  Maybe hidden;
  int64_t vertices = 0, iterations = 0, vertex_iterations = 0;
  double found = 0, rms_mm = 0, p95_mm = 0, max_mm = 0, reached = 0, surface_rms_mm = 0, surface_p95_mm = 0;
  int64_t on_walls = 0, joined = 0, cut = 0;
  std::vector<ResultOpening> openings;
  std::vector<std::string> notes;
  MaybeCount end_contours, genus;
  MaybeList<std::string> missed;
  MaybeText state_hash, scene_note, reproduce, interrupted;
};
void fields(ResultMeshFit& x, auto&& f) {
  f("scan", x.scan), f("points", x.points), f("volume", x.volume), f("tissue", x.tissue), f("iso", x.iso);
  f("mesh", x.mesh), f("start", x.start), f("seal_mm", x.seal_mm), f("mouth_mm", x.mouth_mm);
  f("smooth_voxels", x.smooth_voxels), f("edge_mm", x.edge_mm), f("metric_gain", x.metric_gain),
      f("voxel_mm", x.voxel_mm), f("cpu_s", x.cpu_s);
  f("unit", x.unit), f("warning", x.warning), f("hidden", x.hidden), f("vertices", x.vertices);
  f("iterations", x.iterations), f("vertex_iterations", x.vertex_iterations), f("found", x.found);
  f("rms_mm", x.rms_mm), f("p95_mm", x.p95_mm), f("max_mm", x.max_mm), f("reached", x.reached);
  f("surface_rms_mm", x.surface_rms_mm), f("surface_p95_mm", x.surface_p95_mm), f("on_walls", x.on_walls);
  f("joined", x.joined), f("cut", x.cut), f("openings", x.openings), f("notes", x.notes);
  f("end_contours", x.end_contours), f("genus", x.genus), f("missed", x.missed), f("state_hash", x.state_hash);
  f("scene_note", x.scene_note), f("reproduce", x.reproduce), f("interrupted", x.interrupted);
}

ResultMeshFit result_of(const FitReport& r) {
  ResultMeshFit out;
  out.vertices = r.vertices, out.iterations = r.iterations, out.vertex_iterations = r.vertex_iterations;
  out.found = r.found, out.rms_mm = r.rms_mm, out.p95_mm = r.p95_mm, out.max_mm = r.max_mm;
  out.reached = r.reached, out.surface_rms_mm = r.surface_rms_mm, out.surface_p95_mm = r.surface_p95_mm;
  out.on_walls = r.on_walls, out.joined = r.joined, out.cut = r.cut;
  for (const FitHole& h : r.hole) out.openings.push_back({h.place, h.around_mm, h.vertices, vector_of(h.centre_mm)});
  out.notes = r.notes;
  return out;
}

/// What the report says: what was fitted to what, how far they lie apart both ways, what stayed open.
void tell(Result& result, ResultMeshFit out, const FitOptions& o, const FitReport& r,
          const std::vector<std::string>& notes, const std::string& unit) {
  const auto mm = [](double v) { return short_number(v, 3); };
  std::string note = "A simplex mesh that began as a " + o.start + " was drawn to " +
                     (o.tissue.empty() ? o.volume : "the " + o.tissue + " of " + o.volume) + ": " +
                     std::to_string(r.vertices) + " vertices.";
  for (const std::string& f : notes) note += " " + f + ".";
  out.scene_note = note, out.reproduce = this_call();
  write_fields(result, "", out);
  add_table(result, {"Distance",
                     "A vertex counts where it has the surface within two " + unit +
                         "s, a place of the surface where the mesh is as near.",
                     {"from, to", "share", "rms, mm", "95 % within, mm", "at most, mm"},
                     {{"vertices to surface", mm(100 * r.found) + " %", mm(r.rms_mm), mm(r.p95_mm), mm(r.max_mm)},
                      {"surface to mesh", mm(100 * r.reached) + " %", mm(r.surface_rms_mm), mm(r.surface_p95_mm), ""},
                      {"half a " + unit + ", the bar", "", mm(kRmsVoxels * r.voxel_mm), "", ""},
                      {"vertices on thin walls, not counted", std::to_string(r.on_walls), "", "", ""}}});
  ResultTable open{"Openings", "End contours of the mesh.", {"where", "around, mm", "vertices"}, {}};
  for (const FitHole& h : r.hole)
    open.rows.push_back({h.place, short_number(h.around_mm, 3), std::to_string(h.vertices)});
  if (!open.rows.empty()) add_table(result, open);
}

/// DIR/overview.png, and the mesh from four sides in the gallery, seen from `front`, z upwards: turned into the frame
/// of a head (y forwards), where the lamp lights the front.
void draw_fit_pictures(Result& result, const std::string& dir, const simplex::Mesh& m, const Vec3& front, Organ organ) {
  const simplex::FanTriangles fan = simplex::fan_triangles(m);
  const Vec3 up = std::abs(front.normalized().z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitY();
  Mat3 to_head;
  to_head.row(0) = front.cross(up).normalized().transpose();
  to_head.row(2) = up.transpose();
  to_head.row(1) = up.cross(to_head.row(0).transpose()).transpose();
  Surface s;
  Vec3f low = Vec3f::Constant(1e9f), high = -low;
  for (const Vec3& x : fan.X_mm) s.x_mm.push_back(to_head * x);
  for (const Vec3& x : m.x_mm)
    low = low.cwiseMin((to_head * x).cast<float>()), high = high.cwiseMax((to_head * x).cast<float>());
  for (size_t t = 0; t < fan.tri.size(); ++t)
    if (m.kind(fan.face[t]) == simplex::FaceKind::surface) s.tri.push_back(fan.tri[t]);
  const Snapshot shown = snapshot_of(s, organ, 1);
  try {
    PictureMaker pictures(1080, 1080);
    const auto draw = [&](const std::string& file, const Vec3f& from, const Vec3f& above) {
      pictures.set_camera(look_at_ball(0.5f * (low + high), 0.4f * (high - low).norm(), from, above, 24, 1));
      write_png(dir + "/" + file, pictures.skin(shown));
    };
    const Vec3f x = Vec3f::UnitX(), y = Vec3f::UnitY(), z = Vec3f::UnitZ();
    draw(report_names::overview, y - 0.6f * x + 0.2f * z, z);  // from the lamp's side
    for (const auto& [file, from, above, words] : {std::tuple("front.png", y, z, "From the front"),
                                                   {"left.png", Vec3f(-x), z, "From one side"},
                                                   {"right.png", x, z, "From the other"},
                                                   {"below.png", Vec3f(0.05f * y - z), y, "From below"}}) {
      draw(file, from, above);
      append(result, "/gallery", ResultPicture{file, words});
    }
  } catch (const RenderUnavailable& e) {
    say(std::string("no pictures: ") + e.what());
  }
}

/// result.json and report.html in `dir`, and the JSON file, as asked.
void leave(const Result& result, const FitOptions& o, const std::string& dir) {
  CommonOptions to = o.common;
  to.out_dir = dir;
  leave_result(result, to);
}

/// What kept the fit from its goal, in sentences; nothing: it was reached.
std::vector<std::string> missed(const FitReport& r, double voxel, const char* unit) {
  std::vector<std::string> out;
  std::string b;
  if (r.found < kFound) {
    b = fmt::format("{:.1f} % of the vertices have the surface within two {}s; {:.0f} % were wanted", 100 * r.found,
                    unit, 100 * kFound);
    out.push_back(b);
  }
  if (!(r.rms_mm <= kRmsVoxels * voxel) || r.vertices == 0) {
    b = fmt::format("the rms distance is {:.3f} mm; {:.3f} mm (half a {}) was wanted", r.rms_mm, kRmsVoxels * voxel,
                    unit);
    out.push_back(b);
  }
  return out;
}

Start start_of(const std::string& s) {
  return s == "plane" ? Start::plane : s == "cylinder" ? Start::cylinder : Start::sphere;
}

std::function<void(int, int32_t, double)> shown(Progress& progress, int stages) {
  return [&progress, stages](int stage, int32_t vertices, double move_mm) {
    const std::string line =
        fmt::format("stage {} of {}, {} vertices, last move {:.3f} mm", stage + 1, stages, vertices, move_mm);
    progress.note(line);
  };
}

void write_mesh(const FitOptions& o, const simplex::Mesh& m) {
  write_whole_file(o.mesh_file, o.mesh_file.ends_with(".obj") ? simplex::to_obj(m) : simplex::to_text(m));
}

/// What the size of a scan says about its units; empty: nothing against them.
std::string unlikely(double across_mm) {
  if (across_mm >= kSmallest && across_mm <= kLargest) return "";
  const std::string as = likely_units(across_mm, kSmallest, kLargest);
  return fmt::format("the scan is {:.3g} mm across; a face is 100 to 300 mm: perhaps its lengths are not in mm",
                     across_mm) +
         (as.empty() ? "" : "; try " + as);
}

/// A range scan: its points, and which way its triangles look.
int run_scan(const FitOptions& o) {
  if (!o.sweep_dir.empty()) throw InputError("", 0, "--sweep is for volumes");
  if (!o.report_dir.empty()) prepare_folder(o.report_dir);
  if (!o.from.empty() && start_of(o.start) != Start::plane) throw InputError("", 0, "--from is for --start plane");
  Surface scan = load_surface(o.volume);
  if (const std::string lacks = lacks_shape(scan); !lacks.empty()) throw InputError(o.volume, 0, lacks);
  for (Vec3& x : scan.x_mm) x *= mm_of(o.unit);
  Vec3 low = scan.x_mm.front(), high = low;
  for (const Vec3& x : scan.x_mm) low = low.cwiseMin(x), high = high.cwiseMax(x);
  const std::string doubt = unlikely((high - low).maxCoeff());
  if (!doubt.empty()) say(o.volume + ": " + doubt);
  WorkersPool workers(o.common.worker_count());
  Progress progress("fit");
  FitSettings s;
  s.edge_mm = o.has_edge ? o.edge_mm : std::max(1e-3, std::min(o.edge_mm, (high - low).norm() / kScanEdges));
  s.chord_mm = o.chord_mm, s.metric_gain = o.metric_gain, s.range_mm = std::max(1e-3, 0.25 * (high - low).maxCoeff()),
  s.progress = shown(progress, s.stages);
  const double start_ms = bench::cpu_ms();
  simplex::Mesh m;
  FitReport r;
  const bool plane = start_of(o.start) == Start::plane;
  ScanView view;
  SeenScan seen;
  try {
    view = view_of(scan.x_mm, scan.tri, o.from.empty() ? Vec3(Vec3::Zero()) : Vec3(o.from[0], o.from[1], o.from[2]));
    if (plane)
      seen.x_mm = seen_from_front(scan.x_mm, scan.tri, view);
    else
      seen = seen_from_around(scan.x_mm, scan.tri);
    int longest = 0;
    (high - low).maxCoeff(&longest);
    m = plane ? start_plane(view) : start_mesh(start_of(o.start), low, high, longest);
    r = fit(m, seen.x_mm, s, workers, plane ? &view : nullptr, seen.looks);
  } catch (const InputError& e) {
    throw InputError(o.volume, 0, e.what());
  }
  const double cpu_s = (bench::cpu_ms() - start_ms) * 1e-3;
  progress.clear();
  catch_interrupts();  // the mesh is written, and the rest takes seconds
  write_mesh(o, m);
  std::printf("scan        %zu points, %.4g x %.4g x %.4g mm\nmesh        %d vertices, edges of %.3g mm, from a %s\n",
              scan.x_mm.size(), (high - low).x(), (high - low).y(), (high - low).z(), r.vertices, s.edge_mm,
              o.start.c_str());
  const double hidden = 1 - double(seen.x_mm.size()) / double(scan.x_mm.size());
  if (plane)
    std::printf(
        "seen from   (%.2f, %.2f, %.2f); %.1f %% of the points are hidden from there and do not count: a plane reaches "
        "one side only\n",
        view.front.x(), view.front.y(), view.front.z(), 100 * hidden);
  else if (hidden > 0)
    std::printf(
        "seen        from around; %.1f %% of the points look at other parts of the scan, as the deep side of a shell "
        "does, and do not count\n",
        100 * hidden);
  print(r, r.voxel_mm, "spacing");
  std::printf("work        %d iterations, %.2f s of CPU time\n", r.iterations, cpu_s);
  if (scan.coloured && !scan.tri.empty())
    std::printf(
        "colours     the mesh has none; in a scene the face wears those of the scan: [head] face_texture = \"%s\"%s\n",
        o.volume.c_str(),
        o.unit == "mm" ? "" : fmt::format(", face_texture_scale_to_mm = {:g}", mm_of(o.unit)).c_str());
  std::vector<std::string> faults = missed(r, r.voxel_mm, "spacing");
  if (r.reached < kReached) {
    const std::string b =
        fmt::format("{:.1f} % of {} is within two spacings of the mesh; {:.0f} % was wanted", 100 * r.reached,
                    hidden > 0 ? "what is seen of the scan" : "the scan", 100 * kReached);
    faults.push_back(b);
  }
  for (const std::string& f : faults)
    say(o.volume + ": " + f + "; try " +
        (s.edge_mm > 2 * r.voxel_mm ? "a smaller --edge-mm (it is " + std::to_string(s.edge_mm).substr(0, 5) + "), or "
                                    : "") +
        (o.start == "sphere" ? "--start plane for a scan that is seen from one side"
                             : "--start sphere for a scan that goes round") +
        ", or a scan without noise and layers behind one another");
  Result result("fit", "");
  ResultMeshFit out = result_of(r);
  out.scan = o.volume, out.points = scan.x_mm.size(), out.mesh = o.mesh_file, out.start = o.start, out.cpu_s = cpu_s;
  out.edge_mm = s.edge_mm, out.metric_gain = s.metric_gain, out.voxel_mm = r.voxel_mm, out.unit = o.unit,
  out.warning = doubt, out.hidden = hidden;
  out.missed = unless_empty(faults);
  out.state_hash = hex(simplex::hash(m));
  result.set_ok(faults.empty());
  tell(result, out, o, r, faults, "spacing");
  if (!o.report_dir.empty()) draw_fit_pictures(result, o.report_dir, m, view.front, Organ::face);
  leave(result, o, o.report_dir);
  return faults.empty() ? kDone : kGoalMissed;
}

int run_fit(const FitOptions& o) {
  o.common.prepare();
  check_writable(o.mesh_file);
  std::error_code none;
  if (std::filesystem::equivalent(o.mesh_file, o.volume, none))
    throw InputError(o.mesh_file, 0, "is what is to be fitted; expected the name of another file for the mesh");
  if (is_surface_name(o.volume)) return run_scan(o);
  if (!o.from.empty() || o.unit != "mm")
    throw InputError("", 0, "--from and --unit are for range scans; " + o.volume + " is taken for a volume");
  for (const std::string& dir : {o.sweep_dir, o.report_dir})
    if (!dir.empty()) prepare_folder(dir);
  if (o.tissue.empty() && !o.has_iso)
    throw InputError(
        "", 0,
        "fit " + o.volume + ": what is to be fitted is not said; expected --tissue skin, --tissue bone or --iso");
  const LoadedVolume loaded = load_volume(o.volume, LoadSettings{o.series, o.bridge_missing});
  const Volume& v = loaded.volume;
  WorkersPool workers(o.common.worker_count());
  PrepareSettings q;
  q.iso = o.has_iso ? o.iso : (o.tissue == "bone" ? 250 : -300) + o.offset;  // Hounsfield units
  q.sigma_voxels = o.smooth, q.least_part = o.parts;
  q.seal_mm = o.seal_mm >= 0 ? o.seal_mm : o.tissue == "bone" ? 10 : 6;
  q.mouth_mm = o.mouth_mm >= 0 ? o.mouth_mm : o.tissue == "bone" ? 20 : 0;
  if (o.thin > 0 || (o.thin < 0 && o.tissue == "bone" && !o.has_iso && q.mouth_mm > 0))
    q.thin = o.thin > 0 ? o.thin + o.offset : kThin + o.offset;
  Progress progress("fit");
  progress.note("preparing the volume");
  const double start_ms = bench::cpu_ms();
  Prepared p;
  try {
    p = prepare(v, q, workers);
  } catch (const InputError& e) {
    throw InputError(o.volume, 0, e.what());
  }
  FitSettings s;
  s.iso = q.iso, s.edge_mm = o.edge_mm, s.chord_mm = o.chord_mm, s.metric_gain = o.metric_gain,
  s.skull = o.tissue == "bone";
  s.range_mm = 0.25 * (p.high_mm - p.low_mm).maxCoeff();
  s.progress = shown(progress, s.stages);
  simplex::Mesh m = start_mesh(start_of(o.start), p.low_mm, p.high_mm);
  const FitReport r = fit(m, p, s, workers);
  const double cpu_s = (bench::cpu_ms() - start_ms) * 1e-3;
  progress.clear();
  catch_interrupts();  // the mesh is written, and every trial of a sweep that is finished is kept
  write_mesh(o, m);
  const simplex::Census c = simplex::census(m);
  for (const std::string& n : loaded.notes) std::printf("volume      %s\n", n.c_str());
  for (const CavityMouth& a : p.mouth)
    std::printf("cavity      closed at its mouth at (%.0f, %.0f, %.0f) mm, %.0f mm wide; %.0f mm deep\n",
                a.centre_mm.x(), a.centre_mm.y(), a.centre_mm.z(), a.width_mm, a.depth_mm);
  if (p.parts > 1)
    std::printf("object      the largest %d of %d parts; the others have %.2f %% of what is above %g\n", p.kept_parts,
                p.parts, 100. * double(p.dropped_nodes) / double(p.dropped_nodes + p.object_nodes), q.iso);
  std::printf("mesh        %d vertices, %lld faces, %lld end contours, genus %lld, from a %s\n", r.vertices,
              static_cast<long long>(c.faces - c.end_contours), static_cast<long long>(c.end_contours),
              static_cast<long long>(c.genus), o.start.c_str());
  print(r, p.voxel_mm, "voxel");
  std::printf("work        %d iterations, %.2f s of CPU time\n", r.iterations, cpu_s);
  const std::vector<std::string> faults = missed(r, p.voxel_mm, "voxel");
  for (const std::string& f : faults) say(o.volume + ": " + f + "; see --iso, --offset, --seal-mm, --edge-mm");
  Result result("fit", "");
  ResultMeshFit out = result_of(r);
  out.notes.insert(out.notes.begin(), loaded.notes.begin(), loaded.notes.end());
  out.volume = o.volume, out.tissue = o.tissue, out.iso = s.iso, out.mesh = o.mesh_file, out.start = o.start;
  out.seal_mm = q.seal_mm, out.mouth_mm = p.mouth_mm, out.smooth_voxels = q.sigma_voxels, out.voxel_mm = p.voxel_mm;
  out.cpu_s = cpu_s, out.metric_gain = s.metric_gain;
  out.end_contours = c.end_contours, out.genus = c.genus;
  out.missed = unless_empty(faults);
  out.state_hash = hex(simplex::hash(m));
  result.set_ok(faults.empty());
  const std::string& dir = o.report_dir.empty() ? o.sweep_dir : o.report_dir;
  std::vector<std::string> notes = faults;
  bool whole = true;
  if (!o.sweep_dir.empty()) {
    const FitSweep sweep = fit_sweep(
        p, s, workers, [&](const std::string& line) { progress.note(line); }, interrupted);
    progress.clear();
    whole = sweep.trial.size() == FitSweep::kTrials;
    std::printf("\n%-9s %8s %8s %9s %9s %12s %12s %9s\n", "faces", "edge mm", "chord mm", "vertices", "CPU s", "rms mm",
                "95 % mm", "reached");
    for (const FitTrial& t : sweep.trial)
      std::printf("%-9s %8.2f %8.2f %9d %9.2f %12.3f %12.3f %8.1f%%\n", t.adapted ? "adapted" : "uniform", t.edge_mm,
                  t.chord_mm, t.report.vertices, t.cpu_s, t.report.surface_rms_mm, t.report.surface_p95_mm,
                  100 * t.report.reached);
    write_whole_file(o.sweep_dir + "/fit-sweep.csv", sweep.csv());
    for (const bool time : {false, true}) {
      const LineChart chart = sweep.chart(time);
      write_whole_file(o.sweep_dir + (time ? "/fit-error-time.svg" : "/fit-error-vertices.svg"),
                       in_plain_colours(svg(chart)));
      add_chart(result, time ? "Error against run time" : "Error against vertices", chart);
    }
    if (!whole) {
      const std::string after = "after " + std::to_string(sweep.trial.size()) + " of " +
                                std::to_string(FitSweep::kTrials) + " trials of the sweep, which are kept";
      say("interrupted " + after + " in " + o.sweep_dir + "; the mesh is whole, in " + o.mesh_file);
      notes.push_back("Interrupted " + after + "; the mesh is whole");
      out.interrupted = notes.back();
      result.set_ok(false);
    }
  }
  tell(result, out, o, r, notes, "voxel");
  if (!dir.empty()) draw_fit_pictures(result, dir, m, Vec3(0, -1, 0), s.skull ? Organ::bone : Organ::face);
  leave(result, o, dir);
  return faults.empty() && whole ? kDone : kGoalMissed;
}

}  // namespace

void add_fit(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<FitOptions>();
  CLI::App* c = app.add_subcommand("fit", "Fit a simplex mesh to skin or bone in a CT volume");
  c->add_option("VOLUME", o->volume,
                "NRRD, MetaImage, NIfTI-1, a folder of DICOM slices; or a range scan (.ply, .xyz, .obj)")
      ->required();
  c->add_option("--tissue", o->tissue, "skin (-300 HU) or bone (250 HU)")->check(CLI::IsMember({"skin", "bone"}));
  c->add_option("--out", o->mesh_file, "The mesh: a simplex mesh, or triangles when the name ends in .obj")
      ->required()
      ->type_name("MESH");
  c->add_option("--series", o->series,
                "Of a DICOM folder with several: number, UID or part of its description (left out: they are listed)")
      ->type_name("NAME");
  c->add_flag("--bridge-missing", o->bridge_missing,
              "Slices that an even DICOM series lacks are interpolated, gaps of 10 mm at most [they are refused]");
  CLI::Option* iso = c->add_option("--iso", o->iso, "Isovalue in the volume's own numbers, instead of the tissue's")
                         ->check(any_number());
  c->add_option("--offset", o->offset, "What the volume's numbers are above Hounsfield units (1024 for many) [0]")
      ->check(any_number());
  add_unit(*c, o->unit, "Of the numbers in a range scan");
  CLI::Option* edge =
      c->add_option("--edge-mm", o->edge_mm, "Wanted edges of the mesh [4; of a scan: 1/75 of its diagonal, at most 4]")
          ->check(number_from(0.1, 100.));
  c->add_option("--chord-mm", o->chord_mm,
                "Shorter edges where it is curved: allowed distance of an edge from the surface [0: even]")
      ->check(number_from(0., 10.));
  c->add_option("--metric-gain", o->metric_gain,
                "Vertices gather where it is curved: 0 none, 0.05 useful, more no better than shorter edges [0]")
      ->check(number_from(0., 0.5));
  c->add_option("--start", o->start,
                "What the mesh is at first: sphere around the object, plane before it (a volume: the -y side; a scan: "
                "the side it is seen from), or cylinder through the borders, about z (a scan: about the longest side "
                "of its box) [sphere]")
      ->check(CLI::IsMember({"sphere", "plane", "cylinder"}));
  c->add_option("--from", o->from,
                "Plane and scan: direction of the side that the scan is seen from, X,Y,Z [across its least extent, "
                "where it bulges or its triangles look to]")
      ->expected(3)
      ->delimiter(',')
      ->type_name("X,Y,Z");
  c->add_option(
       "--seal-mm", o->seal_mm,
       "Radius of the ball that seals openings: airway, sinuses and inner tables are behind them [skin 6, bone 10]")
      ->check(number_from(0., 100.));
  c->add_option("--mouth-mm", o->mouth_mm,
                "Radius of a ball that does not enter orbits, nose and foramen: cavities behind such mouths are closed "
                "there, and the mesh is opened; 0: none [skin 0, bone 20]")
      ->check(number_from(0., 100.));
  c->add_option("--thin-walls", o->thin,
                "Bone that is thinner than the voxels shows as a crest below the isovalue: a sheet above this value "
                "(Hounsfield units, with --iso the volume's own numbers) closes "
                "temples and sinuses, so that only orbits, nose and foramen are taken for mouths; 0: no [bone 100, "
                "unless --iso is given]")
      ->check(number_from(0., 10000.));
  c->add_option("--smooth", o->smooth, "Gaussian smoothing, standard deviation in voxels [0.6]")
      ->check(number_from(0., 10.));
  c->add_option(
       "--parts", o->parts,
       "Keep other parts too that have this share of the largest one's size (a mandible beside a skull: 0.05) [1]")
      ->check(number_from(1e-4, 1.));
  c->add_option("--sweep", o->sweep_dir,
                "Also fit again and again with other edges, uniform and adapted to curvature: table and charts of "
                "error against vertices and run time in this folder, with the report")
      ->type_name("DIR");
  c->add_option("--report", o->report_dir,
                "A page on the fit in this folder: pictures, distances, openings, and the sweep's charts")
      ->type_name("DIR");
  o->common.add_json(*c), o->common.add_workers(*c);
  c->footer(
      "Exit status 3: fewer than 95 % of the vertices have the surface within two voxels, or they are farther from it "
      "than half a voxel, rms;\n"
      "of a scan also: less than 90 % of its points (from a plane: of those that are seen from its side) are within "
      "two spacings of the mesh.\n"
      "Example: limberg fit head.nhdr --tissue skin --offset 1024 --out out/skin.simplex");
  c->callback([o, iso, edge, &chosen] {
    o->has_iso = iso->count() > 0, o->has_edge = edge->count() > 0;
    chosen = [o] { return run_fit(*o); };
  });
}

}  // namespace limberg
