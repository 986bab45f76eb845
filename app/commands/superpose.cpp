#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "app/commands/average.h"
#include "app/commands/commands.h"
#include "app/commands/numbers.h"
#include "app/commands/session_command.h"
#include "app/export/achieved.h"
#include "app/result/metrics.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/schema.h"
#include "app/result/tables.h"
#include "app/session/workers_pool.h"
#include "sim/base/error.h"
#include "sim/imaging/anatomy/patient_model.h"
#include "sim/imaging/fit/surface_distances.h"
#include "sim/imaging/io/surface_file.h"
#include "sim/imaging/io/volume.h"
#include "sim/imaging/register/landmark_pairs.h"
#include "sim/imaging/register/registration.h"
#include "sim/imaging/register/superposition.h"

namespace limberg {

namespace {

struct SuperposeOptions {
  std::string a, b, landmarks, series_a, series_b, plan, average;
  std::vector<std::string> more;
  double bone_HU = 250;
  bool mirror = false, scale = false, landmarks_only = false;
  std::optional<double> keep;
  CommonOptions common;
};

/// mirror: the plane.
struct ResultMirror {
  ResultVector normal, point_mm;
};
void fields(ResultMirror& x, auto&& f) { f("normal", x.normal), f("point_mm", x.point_mm); }

/// plan/fragments: how far each lies from where it was planned. reason: why it could not be found.
struct ResultAchieved {
  std::string name;
  ResultVector off_mm;
  double distance_mm, off_deg, rms_mm;
  std::string reason;
};
void fields(ResultAchieved& x, auto&& f) {
  f("name", x.name), f("off_mm", x.off_mm), f("distance_mm", x.distance_mm), f("off_deg", x.off_deg);
  f("rms_mm", x.rms_mm), f("reason", x.reason);
}
struct ResultAgainstPlan {
  std::string folder;
  double skull_rms_mm;
  std::vector<ResultAchieved> fragments;
};
void fields(ResultAgainstPlan& x, auto&& f) {
  f("folder", x.folder), f("skull_rms_mm", x.skull_rms_mm), f("fragments", x.fragments);
}

/// asymmetry, and distance: mean_mm is of the second alone.
struct ResultDistance {
  Maybe mean_mm;
  double mean_abs_mm, rms_mm, p95_mm, max_mm;
};
void fields(ResultDistance& x, auto&& f) {
  f("mean_mm", x.mean_mm), f("mean_abs_mm", x.mean_abs_mm), f("rms_mm", x.rms_mm), f("p95_mm", x.p95_mm);
  f("max_mm", x.max_mm);
}
ResultDistance distance_of(const DistanceMap& d) { return {d.mean_mm, d.mean_abs_mm, d.rms_mm, d.p95_mm, d.max_mm}; }

struct ResultLandmarks {
  MaybeCount pairs;
  Maybe rms_mm, max_mm;
};
void fields(ResultLandmarks& x, auto&& f) { f("pairs", x.pairs), f("rms_mm", x.rms_mm), f("max_mm", x.max_mm); }

/// icp: iterated closest points. still: came to rest.
struct ResultIcp {
  Maybe rms_mm;
  MaybeCount iterations;
  MaybeFlag still;
};
void fields(ResultIcp& x, auto&& f) { f("rms_mm", x.rms_mm), f("iterations", x.iterations), f("still", x.still); }

/// a_to_b: three rows of a matrix, turned and scaled, then shifted (mm). information: of two images about each other.
/// reason: why they could not be laid upon each other.
struct ResultSuperposition {
  MaybeText a, b;
  std::optional<ResultMirror> mirror;
  std::optional<ResultDistance> asymmetry;
  std::optional<ResultAgainstPlan> plan;
  std::optional<ResultAverage> average;
  ResultLandmarks landmarks;
  ResultIcp icp;
  std::optional<std::array<std::array<double, 4>, 3>> a_to_b;
  std::optional<ResultDistance> distance;
  Maybe information, information_at_start, overlap;
  std::string reason;
};
void fields(ResultSuperposition& x, auto&& f) {
  f("a", x.a), f("b", x.b), f("mirror", x.mirror), f("asymmetry", x.asymmetry), f("plan", x.plan);
  f("average", x.average), f("landmarks", x.landmarks);
  f("icp", x.icp), f("a_to_b", x.a_to_b), f("distance", x.distance), f("information", x.information);
  f("information_at_start", x.information_at_start), f("overlap", x.overlap), f("reason", x.reason);
}

std::array<std::array<double, 4>, 3> matrix_of(const Similarity& s) {
  std::array<std::array<double, 4>, 3> m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 4; ++j) m[size_t(i)][size_t(j)] = j < 3 ? s.scale * s.R(i, j) : s.t_mm[i];
  return m;
}

void print(const Similarity& s) {
  std::printf("moved       turned by %.3f degrees, %s%.4f times as large, shifted by (%.3f, %.3f, %.3f) mm\n",
              s.angle_deg(), s.scale == 1 ? "" : "made ", s.scale, s.t_mm.x(), s.t_mm.y(), s.t_mm.z());
}

/// How A was moved, and how far it lies from what it was compared with, as tables of the report.
void tell_superposition(Result& r, const Similarity& s) {
  add_table(r, {"How the first was moved",
                "",
                {"figure", "value"},
                {{"turned, degrees", fmt::format("{:.3f}", s.angle_deg())},
                 {"times as large", fmt::format("{:.4f}", s.scale)},
                 {"shifted, mm", fmt::format("({:.3f}, {:.3f}, {:.3f})", s.t_mm.x(), s.t_mm.y(), s.t_mm.z())}}});
}
void tell_superposition(Result& r, const char* title, const char* about, const DistanceMap& d) {
  ResultTable t{title, about, {"figure", "mm"}, {}};
  for (const auto& [name, v] : {std::pair("mean size", d.mean_abs_mm), std::pair("rms", d.rms_mm),
                                std::pair("95 % within", d.p95_mm), std::pair("at most", d.max_mm)}) {
    const std::string text = fmt::format("{:.3f}", v);
    t.rows.push_back({name, text});
  }
  add_table(r, t);
}

/// The map as a table and as a PLY with colours: blue inside, red outside, full at the 95th percentile.
void write_map(const std::string& dir, const Surface& s, const Similarity& map, const DistanceMap& d) {
  std::string csv = "x_mm,y_mm,z_mm,distance_mm\n",
              ply = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(s.x_mm.size()) +
                    "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar "
                    "green\nproperty uchar blue\nproperty float distance_mm\nelement face " +
                    std::to_string(s.tri.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  std::string b;
  const double full = d.p95_mm > 0 ? d.p95_mm : 1;
  for (size_t i = 0; i < s.x_mm.size(); ++i) {
    const Vec3 x = map(s.x_mm[i]);
    const double t = std::clamp(d.signed_mm[i] / full, -1., 1.);
    b = fmt::format("{:.4f},{:.4f},{:.4f},{:.5f}\n", x.x(), x.y(), x.z(), d.signed_mm[i]);
    csv += b;
    b = fmt::format("{:.4f} {:.4f} {:.4f} {} {} {} {:.5f}\n", x.x(), x.y(), x.z(), int(230 * (t < 0 ? 1 + t : 1)),
                    int(230 * (1 - std::abs(t))), int(230 * (t > 0 ? 1 - t : 1)), d.signed_mm[i]);
    ply += b;
  }
  for (const Tri& t : s.tri) {
    b = fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
    ply += b;
  }
  write_whole_file(dir + "/distance.csv", csv);
  write_whole_file(dir + "/distance.ply", ply);
}

int finish(const SuperposeOptions& o, Result& result, ResultSuperposition& found, const std::string& reason) {
  if (!reason.empty()) say(o.a + ": " + reason);
  found.reason = reason;
  write_fields(result, "", found);
  result.set_ok(reason.empty());
  leave_result(result, o.common);
  return reason.empty() ? kDone : kGoalMissed;
}

/// A surface that is to be laid upon another by its shape, and that has one.
Surface shape_from(const std::string& file) {
  Surface s = load_surface(file);
  if (const std::string lacks = lacks_shape(s); !lacks.empty()) throw InputError(file, 0, lacks);
  return s;
}

/// A second image upon the first.
int images(const SuperposeOptions& o, Result& result, ResultSuperposition& found, Workers& workers,
           Progress& progress) {
  if (o.mirror) throw InputError("", 0, "--mirror is for surfaces");
  const LoadedVolume loaded_a = load_volume(o.a, LoadSettings{o.series_a, false}),
                     loaded_b = load_volume(o.b, LoadSettings{o.series_b, false});
  const Volume &a = loaded_a.volume, &b = loaded_b.volume;
  for (const auto& [file, loaded] : {std::pair(&o.a, &loaded_a), std::pair(&o.b, &loaded_b)})
    for (const std::string& n : loaded->notes) std::printf("volume      %s: %s\n", file->c_str(), n.c_str());
  RegistrationSettings s;
  if (!o.landmarks.empty()) {
    const LandmarkPairs pairs = parse_landmark_pairs(read_whole_file(o.landmarks, size_t(16) << 20), o.landmarks);
    const LandmarkFit f = fit_landmarks(pairs.a_mm, pairs.b_mm, false);
    if (!f) throw InputError(o.landmarks, 0, f.reason);
    s.start = f.map;
  }
  progress.note("registering");
  const RegistrationResult r = register_volumes(b, a, s, workers);
  progress.clear();
  print(r.map);
  std::printf(
      "information %.4f (1: nothing, 2: everything), %.4f at the start; %.0f %% of the samples in both, %d "
      "evaluations\n",
      r.information, r.at_start, 100 * r.overlap, r.evaluations);
  found.a_to_b = matrix_of(r.map);
  tell_superposition(result, r.map);
  found.information = r.information, found.information_at_start = r.at_start, found.overlap = r.overlap;
  if (!o.common.out_dir.empty()) {
    float least = a.value.front();
    for (const float x : a.value) least = std::min(least, x);
    write_whole_file(o.common.out_dir + "/registered.nrrd", to_nrrd(resampled(b, a, r.map, least, workers)));
  }
  return finish(o, result, found, r.reason);
}

/// The bone of a later scan: a surface, or the isosurface of a CT in right, forwards, up.
Surface later_bone(const SuperposeOptions& o, Workers& workers) {
  if (is_surface_name(o.a)) return shape_from(o.a);
  const LoadedVolume loaded = load_volume(o.a, LoadSettings{o.series_a, true});
  for (const std::string& n : loaded.notes) std::printf("volume      %s: %s\n", o.a.c_str(), n.c_str());
  std::string why;
  double offset = 0;
  try {
    offset = hounsfield_offset(loaded.volume, why);
  } catch (const InputError& e) {
    throw InputError(o.a, 0, e.what());
  }
  Surface s = isosurface(loaded.volume, o.bone_HU + offset, workers);
  for (Vec3& x : s.x_mm) x = Vec3(-x.x(), -x.y(), x.z());
  if (const std::string lacks = lacks_shape(s); !lacks.empty()) throw InputError(o.a, 0, "its bone: " + lacks);
  return s;
}

/// A later scan against a plan.
int against_plan(const SuperposeOptions& o, Result& result, ResultSuperposition& found, Workers& workers,
                 Progress& progress) {
  if (!o.b.empty() || !o.average.empty() || o.mirror || o.scale || o.landmarks_only || !o.landmarks.empty())
    throw InputError("", 0,
                     "superpose: --plan takes one later scan alone; expected no B, --average, --mirror, --scale, "
                     "--landmarks, --landmarks-only");
  constexpr double kMoved_mm = 0.5;
  const std::vector<PlannedFragment> plan = read_plan(o.plan);
  const Surface later = later_bone(o, workers);
  progress.note("laying the skull upon the later one");
  const Achieved a = planned_against_achieved(plan, later, kMoved_mm, workers);
  progress.clear();
  if (!a.reason.empty()) return finish(o, result, found, a.reason);
  found.plan = ResultAgainstPlan{o.plan, a.skull_rms_mm, {}};
  std::printf("skull       laid upon the later one, rms of the kept pairs %.3f mm\n", a.skull_rms_mm);
  ResultTable t{
      "Planned and achieved",
      "How far each fragment that was to be moved lies from where it was planned: its middle and its turn.",
      {"fragment", "right, mm", "forward, mm", "up, mm", "distance, mm", "turned, degrees", "rms of the fit, mm"},
      {}};
  std::string lost;
  for (const AchievedFragment& f : a.fragments) {
    found.plan->fragments.push_back({f.name, vector_of(f.off_mm), f.off_mm.norm(), f.off_deg, f.rms_mm, f.reason});
    if (!f.reason.empty()) {
      lost += (lost.empty() ? "" : "; ") + f.name + ": " + f.reason;
      continue;
    }
    std::printf("%-11s %+.2f mm right, %+.2f forward, %+.2f up of its plan, turned by %.2f degrees\n", f.name.c_str(),
                f.off_mm.x(), f.off_mm.y(), f.off_mm.z(), f.off_deg);
    t.rows.push_back({f.name, fmt::format("{:.2f}", f.off_mm.x()), fmt::format("{:.2f}", f.off_mm.y()),
                      fmt::format("{:.2f}", f.off_mm.z()), fmt::format("{:.2f}", f.off_mm.norm()),
                      fmt::format("{:.2f}", f.off_deg), fmt::format("{:.2f}", f.rms_mm)});
  }
  if (a.fragments.empty()) lost = "the plan moves no fragment";
  if (!t.rows.empty()) add_table(result, t);
  return finish(o, result, found, lost);
}

/// The mean of several.
int averaged(const SuperposeOptions& o, Result& result, ResultSuperposition& found, Workers& workers,
             Progress& progress) {
  if (o.b.empty() || o.mirror || o.landmarks_only || !o.landmarks.empty())
    throw InputError("", 0,
                     "superpose: --average takes two surfaces or more; expected no --mirror, --landmarks, "
                     "--landmarks-only");
  std::vector<std::string> files{o.a, o.b};
  files.insert(files.end(), o.more.begin(), o.more.end());
  std::vector<Surface> surfaces;
  for (const std::string& f : files) {
    surfaces.push_back(shape_from(f));
    if (surfaces.back().tri.empty()) throw InputError(f, 0, "has no triangles; expected a surface");
  }
  AverageSettings s;
  s.keep = o.keep.value_or(s.keep), s.with_scale = o.scale;
  progress.note("averaging");
  std::string reason;
  found.average = average_files(files, surfaces, o.average, s, o.common.out_dir, result, workers, reason);
  progress.clear();
  return finish(o, result, found, reason);
}

int run_superpose(const SuperposeOptions& o) {
  std::vector<std::string> all{o.a, o.b};
  all.insert(all.end(), o.more.begin(), o.more.end());
  for (const std::string& given : all)
    if (std::error_code ec; !given.empty() && !std::filesystem::exists(given, ec))
      throw InputError(given, 0,
                       "cannot be read (" + (ec ? ec.message() : "no such file") + "); expected a surface or an image");
  o.common.prepare();
  WorkersPool workers(o.common.worker_count());
  Progress progress("superpose");
  Result result("superpose", "");
  ResultSuperposition found;
  found.a = o.a, found.b = o.b;
  if (!o.more.empty() && o.average.empty())
    throw InputError("", 0, "superpose: more than two surfaces are averaged; expected --average FILE");
  if (!o.average.empty() && o.plan.empty()) return averaged(o, result, found, workers, progress);
  if (!o.plan.empty()) return against_plan(o, result, found, workers, progress);
  if (!is_surface_name(o.a) && (o.b.empty() || !is_surface_name(o.b))) {
    if (o.b.empty())
      throw InputError("", 0, "superpose: two images, or surfaces (.obj, .ply, .stl, .xyz, .simplex), were expected");
    return images(o, result, found, workers, progress);
  }
  const auto read = o.landmarks_only && !o.mirror ? load_surface : shape_from;
  const Surface a = read(o.a);
  IcpSettings s;
  s.keep = o.keep.value_or(s.keep), s.with_scale = o.scale;
  if (o.mirror) {
    progress.note("looking for the mirror plane");
    const MirrorPlane m = mirror_plane(a, Vec3::UnitX(), s, workers);
    progress.clear();
    if (!m) return finish(o, result, found, m.reason);
    std::printf("mirror      normal (%.4f, %.4f, %.4f) through (%.2f, %.2f, %.2f) mm, rms of the kept pairs %.3f mm\n",
                m.normal.x(), m.normal.y(), m.normal.z(), m.point_mm.x(), m.point_mm.y(), m.point_mm.z(), m.rms_mm);
    found.mirror = ResultMirror{vector_of(m.normal), vector_of(m.point_mm)};
    // Asymmetry: the surface against its own reflection in the plane.
    Similarity flip;
    flip.R = Mat3::Identity() - 2 * m.normal * m.normal.transpose(),
    flip.t_mm = 2 * m.normal.dot(m.point_mm) * m.normal;
    Surface other = a;
    for (Vec3& x : other.x_mm) x = flip(x);
    for (Tri& t : other.tri) std::swap(t[1], t[2]);
    const DistanceMap d = distance_map(a, {}, SurfaceTarget(other), workers);
    std::printf("asymmetry   mean %.3f mm, rms %.3f mm, 95 %% within %.3f mm, at most %.3f mm\n", d.mean_abs_mm,
                d.rms_mm, d.p95_mm, d.max_mm);
    found.asymmetry = distance_of(d);
    found.asymmetry->mean_mm.reset();  // of a surface and its mirror image it is nothing
    tell_superposition(
        result, "Left and right",
        "Distance of the surface from its own mirror image. The plane is the one in which they differ least.", d);
    if (!o.common.out_dir.empty()) write_map(o.common.out_dir, a, {}, d);
    if (o.b.empty()) return finish(o, result, found, {});
  }
  if (o.b.empty()) throw InputError("", 0, "superpose " + o.a + ": a second surface, or --mirror, was expected");
  const Surface b = read(o.b);
  const SurfaceTarget target(b);
  Similarity start;
  if (!o.landmarks.empty()) {
    const LandmarkPairs pairs = parse_landmark_pairs(read_whole_file(o.landmarks, size_t(16) << 20), o.landmarks);
    const LandmarkFit f = fit_landmarks(pairs.a_mm, pairs.b_mm, o.scale);
    if (!f) throw InputError(o.landmarks, 0, f.reason);
    std::printf("landmarks   %zu pairs, rms %.3f mm, at most %.3f mm\n", pairs.a_mm.size(), f.rms_mm, f.max_mm);
    found.landmarks = {pairs.a_mm.size(), f.rms_mm, f.max_mm};
    start = f.map;
  }
  Similarity map = start;
  if (!o.landmarks_only) {
    progress.note("iterating");
    const IcpResult r =
        o.landmarks.empty() ? icp_from_anywhere(a, target, b, s, workers) : icp(a, target, start, s, workers);
    progress.clear();
    if (!r) return finish(o, result, found, r.reason);
    std::printf("pairs       %.0f %% kept, rms %.4f mm along the normals, %d iterations%s\n", 100 * s.keep, r.rms_mm,
                r.iterations, r.still ? "" : ", not at rest");
    found.icp = {r.rms_mm, r.iterations, r.still};
    map = r.map;
  }
  print(map);
  found.a_to_b = matrix_of(map);
  const DistanceMap d = distance_map(a, map, target, workers);
  std::printf("distance    mean %+.3f mm, mean size %.3f mm, rms %.3f mm, 95 %% within %.3f mm, at most %.3f mm\n",
              d.mean_mm, d.mean_abs_mm, d.rms_mm, d.p95_mm, d.max_mm);
  found.distance = distance_of(d);
  tell_superposition(result, map);
  tell_superposition(
      result, "What differs",
      "Distance of the first surface, as it was laid, from the second; distance.ply shows it in colours.", d);
  if (!o.common.out_dir.empty()) write_map(o.common.out_dir, a, map, d);
  return finish(o, result, found, {});
}

}  // namespace

void add_superpose(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<SuperposeOptions>();
  CLI::App* c = app.add_subcommand("superpose", "Lay a surface, or an image, upon another and measure what differs");
  c->add_option("A", o->a, "What is moved: OBJ, PLY, STL, xyz or simplex mesh; or a volume")->required();
  c->add_option("B", o->b, "What it is laid upon, of the same kind; not needed with --mirror");
  c->add_option("MORE", o->more, "With --average: more surfaces");
  c->add_option(
       "--average", o->average,
       "Writes the mean of all surfaces (.obj, .ply, .stl), with the triangles of A: a normal skull of several")
      ->type_name("FILE");
  c->add_option("--landmarks", o->landmarks, "Where to begin: lines of a name, x y z in A, x y z in B (mm)")
      ->type_name("FILE");
  c->add_flag("--landmarks-only", o->landmarks_only, "Landmarks alone, without looking for nearest places");
  c->add_flag("--scale", o->scale, "Let A grow or shrink; with --average all are made as large as their mean");
  c->add_flag("--mirror", o->mirror, "Also the mirror plane of A (first guess: x = middle) and its asymmetry");
  c->add_option(
       "--keep", o->keep,
       "Share of the pairs that count: the others are where the two differ or one is missing [0.7; 1 with --average]")
      ->check(number_from(0.05, 1.));
  c->add_option("--series-a", o->series_a, "Series of a DICOM folder A: number, UID or part of its description")
      ->type_name("NAME");
  c->add_option("--series-b", o->series_b, "The same of B")->type_name("NAME");
  c->add_option("--plan", o->plan,
                "A folder of `export`: how far its fragments lie in the later scan A from where they were planned")
      ->type_name("DIR");
  c->add_option("--bone", o->bone_HU, "With --plan and a CT: above it is bone, Hounsfield units [250]")
      ->check(number_from(100., 1500.));
  o->common.add_out(*c), o->common.add_words(*c), o->common.add_json(*c), o->common.add_workers(*c);
  c->footer(
      "With --out also: distance.csv and distance.ply (coloured), registered.nrrd or spread.csv. Exit status 3: they "
      "could not be "
      "laid upon each other; the reason is said.\n"
      "Example: limberg superpose patient.obj normal.obj --landmarks points.txt --out out/superposed\n"
      "         limberg superpose later_ct --plan out/print\n"
      "         limberg superpose one.stl two.stl three.stl --average normal.obj");
  c->callback([o, &chosen] { chosen = [o] { return run_superpose(*o); }; });
}

}  // namespace limberg
