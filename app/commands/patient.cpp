#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "app/commands/commands.h"
#include "app/commands/numbers.h"
#include "app/commands/session_command.h"
#include "app/commands/this_call.h"
#include "app/head/cache.h"
#include "app/operating_point/cpu_clock.h"
#include "app/patient/operations.h"
#include "app/patient/scene_text.h"
#include "app/patient/slices.h"
#include "app/patient/soft_tissue.h"
#include "app/program/interrupt.h"
#include "app/result/metrics.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/schema.h"
#include "app/result/tables.h"
#include "app/session/workers_pool.h"
#include "sim/base/error.h"
#include "sim/imaging/fit/surface_distances.h"
#include "sim/imaging/io/dicom.h"
#include "sim/measure/cephalometry.h"
#include "sim/skull/simplex/file.h"

namespace limberg {

namespace {

namespace fs = std::filesystem;

constexpr double kReachedSkin = 0.95;   // of the skin's isosurface must lie within two voxels of the mesh
constexpr double kFoundCortex = 0.9;    // of the vertices of bone must see a cortex
constexpr double kSoft_HU = 45;         // muscle and brain
constexpr double kUnsureCut_mm2 = 300;  // of bone between skull and mandible: more than both joints' touching

struct PatientOptions {
  std::string input, series;
  double offset = 0, bone = 250, skin = -300, edge_mm = 3.5, face_edge_mm = 5;
  bool has_offset = false;
  CommonOptions common;
};

struct ResultBone {
  std::string name;
  double volume_cm3, cortex_mm, shift_mm;
  int64_t vertices, genus;
};
void fields(ResultBone& x, auto&& f) {
  f("name", x.name), f("volume_cm3", x.volume_cm3), f("vertices", x.vertices), f("genus", x.genus);
  f("cortex_mm", x.cortex_mm), f("shift_mm", x.shift_mm);
}
struct ResultFoundLandmark {
  std::string name;
  ResultVector at_mm;
  double sd_mm;
  bool on_skin;
};
void fields(ResultFoundLandmark& x, auto&& f) {
  f("name", x.name), f("at_mm", x.at_mm), f("sd_mm", x.sd_mm), f("on_skin", x.on_skin);
}
struct ResultPatientCut {
  bool made;
  double area_mm2, density_HU, apart_at_HU;
};
void fields(ResultPatientCut& x, auto&& f) {
  f("made", x.made), f("area_mm2", x.area_mm2), f("density_HU", x.density_HU), f("apart_at_HU", x.apart_at_HU);
}

/// distances: of a surface to the picture's isosurface, and back.
struct ResultApart {
  std::string surface, way;
  double iso_HU, reached, reached_rms_mm, mean_mm, p95_mm, max_mm;
};
void fields(ResultApart& x, auto&& f) {
  f("surface", x.surface), f("way", x.way), f("iso_HU", x.iso_HU), f("reached", x.reached);
  f("reached_rms_mm", x.reached_rms_mm), f("mean_mm", x.mean_mm), f("p95_mm", x.p95_mm), f("max_mm", x.max_mm);
}

/// operations: scripts beside the scene. why: of one that could not be made.
struct ResultOperation {
  std::string name, title;
  bool made;
  MaybeText why;
};
void fields(ResultOperation& x, auto&& f) {
  f("name", x.name), f("title", x.title), f("made", x.made), f("why", x.why);
}

struct ResultThickness {
  std::string landmark;
  double mm;
};
void fields(ResultThickness& x, auto&& f) { f("landmark", x.landmark), f("mm", x.mm); }
/// The tissue between skin and bone: what was laid, and how thick it is in the picture.
struct ResultSoftTissue {
  double reach_mm = 0;
  int64_t over_bone = 0, covered = 0, columns = 0, hovering = 0, steps_to_rest = 0;
  double least_ratio = 0, low_ratio = 0, thinnest_mm = 0, median_mm = 0, p95_mm = 0, thickest_mm = 0;
  double true_p5_mm = 0, true_median_mm = 0, true_p95_mm = 0;
  std::vector<ResultThickness> at;
};
void fields(ResultSoftTissue& x, auto&& f) {
  f("reach_mm", x.reach_mm), f("over_bone", x.over_bone), f("covered", x.covered), f("columns", x.columns);
  f("hovering", x.hovering), f("steps_to_rest", x.steps_to_rest), f("least_ratio", x.least_ratio);
  f("low_ratio", x.low_ratio), f("thinnest_mm", x.thinnest_mm), f("median_mm", x.median_mm), f("p95_mm", x.p95_mm);
  f("thickest_mm", x.thickest_mm), f("true_p5_mm", x.true_p5_mm), f("true_median_mm", x.true_median_mm);
  f("true_p95_mm", x.true_p95_mm), f("at", x.at);
}
ResultSoftTissue result_of(const LaidTissue& t) {
  ResultSoftTissue r;
  r.reach_mm = t.reach_mm, r.over_bone = t.over_bone, r.covered = t.covered, r.columns = t.quality.columns;
  r.hovering = t.quality.hovering, r.steps_to_rest = t.steps, r.least_ratio = t.quality.least_ratio;
  r.low_ratio = t.quality.low_ratio, r.thinnest_mm = t.quality.thinnest_mm, r.median_mm = t.quality.median_mm;
  r.p95_mm = t.quality.p95_mm, r.thickest_mm = t.quality.thickest_mm;
  r.true_p5_mm = t.true_p5_mm, r.true_median_mm = t.true_median_mm, r.true_p95_mm = t.true_p95_mm;
  for (const ThicknessAt& a : t.at) r.at.push_back({a.landmark, a.mm});
  return r;
}
std::string words_of(const LaidTissue& t) {
  if (t.reach_mm == 0)
    return "no soft tissue could be laid between skin and bone (" + t.why + "): the face does not follow";
  return fmt::format(
      "soft tissue is laid {} under {} of {} vertices of the skin that have bone beneath; {} of {} columns end above "
      "the bone; the flattest tetrahedron has a mean ratio of {:.2f}",
      t.reach_mm >= kWholeFace_mm ? "over the whole face" : fmt::format("within {:.0f} mm of the nose", t.reach_mm),
      t.covered, t.over_bone, t.quality.hovering, t.quality.columns, t.quality.least_ratio);
}

/// What `patient` says beside its tables.
struct ResultPatient {
  std::string volume, series;
  std::string scene_file;
  MaybeText skin_scene_file;
  double offset_HU = 0;
  std::vector<ResultBone> bones;
  ResultPatientCut mandible_cut, spine_cut;
  std::vector<ResultFoundLandmark> landmarks;
  std::vector<std::string> landmarks_missing;
  double pitch_deg = 0, roll_deg = 0, yaw_deg = 0, symmetry_rms_mm = 0, laid_skull_rms_mm = 0;
  double compact_HU = 0, blur_mm = 0;
  double skin_reached = 0, skin_rms_mm = 0, bone_found = 0, cpu_s = 0;
  ResultSoftTissue soft_tissue;
  std::vector<ResultApart> distances;
  std::vector<ResultOperation> operations;
  std::vector<std::string> notes;
  MaybeList<std::string> missed;
  std::string reproduce;
};
void fields(ResultPatient& x, auto&& f) {
  f("volume", x.volume), f("series", x.series), f("scene_file", x.scene_file), f("skin_scene_file", x.skin_scene_file),
      f("offset_HU", x.offset_HU);
  f("bones", x.bones), f("mandible_cut", x.mandible_cut), f("spine_cut", x.spine_cut);
  f("landmarks", x.landmarks), f("landmarks_missing", x.landmarks_missing), f("pitch_deg", x.pitch_deg);
  f("roll_deg", x.roll_deg), f("yaw_deg", x.yaw_deg), f("symmetry_rms_mm", x.symmetry_rms_mm);
  f("laid_skull_rms_mm", x.laid_skull_rms_mm), f("compact_HU", x.compact_HU), f("blur_mm", x.blur_mm);
  f("skin_reached", x.skin_reached), f("skin_rms_mm", x.skin_rms_mm), f("bone_found", x.bone_found);
  f("cpu_s", x.cpu_s), f("soft_tissue", x.soft_tissue), f("distances", x.distances);
  f("operations", x.operations), f("notes", x.notes), f("missed", x.missed), f("reproduce", x.reproduce);
}

/// An MRI is refused with a reason: its numbers have no unit, and bone is as dark in it as air.
void expect_ct(const imaging::SeriesAbout& s, const std::string& input) {
  if (s.modality != "MR") return;
  throw InputError(
      input, 0,
      fmt::format("series {} is an MRI: its numbers have no unit and bone is as dark in it as air; expected "
                  "a CT (limberg fit {} --series {} --iso N fits the skin of it, N halfway between air "
                  "and skin)",
                  s.number, input, s.number));
}

/// The volume, with what was chosen and done said in `notes`.
LoadedVolume load(const PatientOptions& o, std::string& series) {
  std::error_code ec;
  LoadSettings settings;
  settings.series = o.series, settings.bridge_missing = true;
  std::vector<std::string> notes;
  if (fs::is_directory(o.input, ec) || fs::path(o.input).filename() == "DICOMDIR") {
    const std::vector<imaging::SeriesAbout> all = imaging::list_series(o.input, settings);
    for (const imaging::SeriesAbout& s : all) std::printf("series      %s\n", imaging::line_of(s).c_str());
    if (o.series.empty()) {
      const imaging::SeriesChoice c = imaging::choose_series(all);
      if (c.index < 0) throw InputError(o.input, 0, "no series will do: " + c.why);
      expect_ct(all[size_t(c.index)], o.input);
      settings.series = all[size_t(c.index)].uid, series = imaging::line_of(all[size_t(c.index)]);
      notes.push_back(c.why);
      for (const std::string& r : c.rejected) notes.push_back(r);
    } else {
      for (const imaging::SeriesAbout& s : all)
        if (o.series == std::to_string(s.number) || o.series == s.uid) expect_ct(s, o.input);
    }
  }
  LoadedVolume v = load_volume(o.input, settings);
  v.notes.insert(v.notes.begin(), notes.begin(), notes.end());
  return v;
}

std::vector<PlannedOperation> operations(const PatientModel& p, Workers& workers) {
  OperationGround ground;
  for (const PatientBone& b : p.bone) ground.bones.emplace_back(b.name, b.mesh);
  ground.landmarks = p.anatomy.landmark;
  return plan_operations(ground, workers);
}

/// A file that this patient has not, and that an earlier one in this folder may have left.
void remove_old(const std::string& file) {
  std::error_code ec;
  fs::remove(file, ec);
}

void write_files(const PatientOptions& o, const PatientModel& p, const PatientFlesh& flesh, double reach_mm,
                 const std::vector<PlannedOperation>& planned) {
  const std::string &dir = o.common.out_dir, from = "From " + fs::path(o.input).lexically_normal().filename().string();
  for (const PatientBone& b : p.bone) simplex::save_mesh(b.mesh, dir + "/" + b.name + ".simplex");
  if (p.face.slots() > 0) simplex::save_mesh(p.face, dir + "/face.simplex");
  write_whole_file(dir + "/patient.toml", patient_scene(p, reach_mm, from));
  if (!flesh.tri.empty()) {
    write_whole_file(dir + "/flesh.obj", flesh_obj(flesh));
    write_whole_file(dir + "/patient_skin.toml", patient_flesh_scene(p, from));
  } else {
    remove_old(dir + "/flesh.obj"), remove_old(dir + "/patient_skin.toml");
  }
  for (const PlannedOperation& x : planned) {
    const std::string file = dir + "/" + x.name + ".jsonl";
    if (x.made())
      write_whole_file(file, to_text(x.script));
    else
      remove_old(file);
  }
}

std::vector<std::string> missed(const PatientModel& p, double found) {
  std::vector<std::string> out;
  if (p.face.slots() > 0 && p.skin.reached < kReachedSkin)
    out.push_back(fmt::format("{:.1f} % of the skin lies within two voxels of the mesh; {:.0f} % was wanted",
                              100 * p.skin.reached, 100 * kReachedSkin));
  if (found < kFoundCortex)
    out.push_back(fmt::format("{:.1f} % of the vertices of bone see a cortex; {:.0f} % was wanted", 100 * found,
                              100 * kFoundCortex));
  return out;
}

/// A part's triangles where the picture has them.
struct PartInPicture {
  std::string name;
  Surface surface;
};
std::vector<PartInPicture> in_picture(const PatientModel& p) {
  std::vector<PartInPicture> out;
  const Eigen::Isometry3d back = p.anatomy.to_head.inverse();
  const auto add = [&](const std::string& name, const simplex::Mesh& m) {
    PartInPicture part{name, triangles_of(m)};
    for (Vec3& x : part.surface.x_mm) {
      const Vec3 y = back * x;
      x = Vec3(-y.x(), -y.y(), y.z());
    }
    out.push_back(std::move(part));
  };
  for (const PatientBone& b : p.bone) add(b.name, b.mesh);
  if (p.face.slots() > 0) add("skin", p.face);
  return out;
}

void draw_slices(Result& r, const std::string& dir, const Volume& v, const PatientModel& p,
                 const std::vector<PartInPicture>& parts) {
  std::vector<SliceContour> contours;
  for (const PartInPicture& part : parts)
    contours.push_back({part.name, part.surface.x_mm, part.surface.tri,
                        part.name == "cranium"    ? slice_colours::bone
                        : part.name == "mandible" ? slice_colours::mandible
                        : part.name == "skin"     ? slice_colours::skin
                                                  : slice_colours::other});
  SliceLook look;
  look.offset = p.offset;
  for (const ResultPicture& picture : draw_head_slices(dir, v, contours, look)) append(r, "/gallery", picture);
}

/// How far the meshes lie from the picture's own isosurfaces, both ways, over faces: bone half-way between soft tissue
/// and compact bone, skin at its own value.
std::vector<ResultApart> distances(const Volume& v, const PatientModel& p, const PatientOptions& o,
                                   const std::vector<PartInPicture>& parts, Workers& workers) {
  std::vector<ResultApart> out;
  Surface bone, skin;
  for (const PartInPicture& part : parts) append(part.name == "skin" ? skin : bone, part.surface);
  const double voxel = longest_step_mm(v);
  const double compact = p.bone.empty() ? 1150 + p.offset : p.bone.front().cortex.cortical;
  for (const bool of_skin : {false, true}) {
    const Surface& s = of_skin ? skin : bone;
    if (s.tri.empty()) continue;
    const double iso = of_skin ? o.skin + p.offset : 0.5 * (kSoft_HU + p.offset + compact);
    // What lies elsewhere (a table, a head rest) is not meant.
    Vec3 low = s.x_mm.front(), high = low;
    for (const Vec3& x : s.x_mm) low = low.cwiseMin(x), high = high.cwiseMax(x);
    low.array() -= voxel, high.array() += voxel;
    const Surface raw = isosurface(v, iso, workers, [&](const Vec3& x) {
      return (x.array() >= low.array()).all() && (x.array() <= high.array()).all();
    });
    if (raw.tri.empty()) continue;
    const DistancesBothWays d = surface_distances(s, raw, {.within_mm = 2 * voxel}, workers);
    const auto row = [&](const char* way, const SurfaceDistances& x) {
      out.push_back(
          {of_skin ? "skin" : "bone", way, iso - p.offset, x.reached, x.reached_rms_mm, x.mean_mm, x.p95_mm, x.max_mm});
    };
    row("mesh to picture", d.to_isosurface), row("picture to mesh", d.from_isosurface);
  }
  return out;
}

void tell(Result& r, const std::vector<ResultApart>& apart) {
  ResultTable t{
      "How far they lie from the picture",
      "Over faces, both ways, to the raw isosurface; reached: within two voxels. Bone's isosurface lies half-way "
      "between soft tissue and compact bone and loses what is thinner than a voxel; the way from the picture "
      "counts cells, airways and inner surfaces too.",
      {"surface", "from, to", "at, HU", "reached", "rms of that, mm", "mean, mm", "95 % within, mm", "at most, mm"},
      {}};
  for (const ResultApart& a : apart)
    t.rows.push_back({a.surface, a.way, short_number(a.iso_HU, 4), fmt::format("{:.1f} %", 100 * a.reached),
                      fmt::format("{:.2f}", a.reached_rms_mm), fmt::format("{:.2f}", a.mean_mm),
                      fmt::format("{:.2f}", a.p95_mm), fmt::format("{:.2f}", a.max_mm)});
  if (!t.rows.empty()) add_table(r, t);
}

void tell(Result& r, const LaidTissue& t) {
  ResultTable table{"Soft tissue",
                    "From skin to bone along the normal of the skin, in the meshes. Of the columns that the scene's "
                    "tissue is made of see the notes.",
                    {"place", "thickness, mm"},
                    {}};
  const auto row = [&](const std::string& name, double mm) { table.rows.push_back({name, fmt::format("{:.1f}", mm)}); };
  if (t.over_bone == 0) return;
  row("all skin over bone, median", t.true_median_mm), row("5 % are below", t.true_p5_mm);
  row("5 % are above", t.true_p95_mm);
  for (const ThicknessAt& a : t.at) row(a.landmark, a.mm);
  add_table(r, table);
}

std::string cut_words(const BoneCut& c, const char* name, double offset) {
  if (!c.made) return "";
  if (c.area_mm2 == 0) return fmt::format("{} lies apart in the picture", name);
  return fmt::format("{} parted through {:.0f} mm2 of bone of {:.0f} HU, apart above {:.0f} HU{}", name, c.area_mm2,
                     c.density - offset, c.apart_at - offset,
                     c.area_mm2 > kUnsureCut_mm2 ? ": look at it, the cut is not sure" : "");
}

void tell(Result& r, const PatientModel& p) {
  ResultTable bones{"Bone",
                    "Closed solids with outer and inner table; the cortex as the picture's blur tells it.",
                    {"part", "volume, cm³", "vertices", "tunnels", "cortex, mm (median)"},
                    {}};
  for (const PatientBone& b : p.bone)
    bones.rows.push_back({b.name, short_number(b.volume_cm3, 4), std::to_string(b.mesh.vertices()),
                          std::to_string(b.genus), short_number(b.cortex.thickness_mm, 3)});
  add_table(r, bones);
  ResultTable marks{"Landmarks",
                    "In the frame of the head: x right, y forwards, z up, origin between the porions.",
                    {"landmark", "right, mm", "forwards, mm", "up, mm", "may be off by, mm"},
                    {}};
  std::vector<NamedPoint> points;
  for (const FoundLandmark& l : p.anatomy.landmark) {
    marks.rows.push_back({l.name, fmt::format("{:.1f}", unsigned_zero(l.at_mm.x())),
                          fmt::format("{:.1f}", unsigned_zero(l.at_mm.y())),
                          fmt::format("{:.1f}", unsigned_zero(l.at_mm.z())), fmt::format("{:.1f}", l.sd_mm)});
    points.push_back({l.name, l.at_mm, l.sd_mm});
  }
  add_table(r, marks);
  ResultTable ceph{"Cephalometry",
                   "From these landmarks, with what their uncertainty makes of each figure.",
                   {"figure", "value", "±", "norm", "unit"},
                   {}};
  for (const CephalometricRow& c : cephalometry(points))
    if (c.value)
      ceph.rows.push_back({c.measure->name, fmt::format("{:.1f}", unsigned_zero(*c.value)), fmt::format("{:.1f}", c.sd),
                           c.measure->norm ? fmt::format("{:.1f}", *c.measure->norm) : "", c.measure->unit});
  if (!ceph.rows.empty()) add_table(r, ceph);
}

int run_patient(const PatientOptions& o) {
  o.common.prepare();
  if (o.common.out_dir.empty())
    throw InputError("", 0, "patient: expected --out DIR, a folder for the scene and its page");
  prepare_folder(o.common.out_dir);
  Progress progress("patient");
  progress.note("reading");
  std::string series;
  const LoadedVolume loaded = load(o, series);
  const Volume& v = loaded.volume;
  WorkersPool workers(o.common.worker_count());
  const double start_ms = bench::cpu_ms();
  const HeadModel atlas = cached_head({}, workers);
  PatientSettings s;
  if (o.has_offset) s.offset = o.offset;
  s.bone_HU = o.bone, s.skin_HU = o.skin, s.edge_mm = o.edge_mm, s.face_edge_mm = o.face_edge_mm;
  s.progress = [&](const std::string& what) { progress.note(what); };
  PatientModel p;
  try {
    p = make_patient(v, s, atlas, workers);
  } catch (const InputError& e) {
    throw InputError(o.input, 0, e.what());
  }
  progress.note("soft tissue");
  const LaidTissue soft = lay_soft_tissue(p, kPatientTissue_kPa, kPatientTissueLayers, workers);
  PatientFlesh flesh;
  std::string no_flesh;
  progress.note("soft tissue to be cut");
  try {
    flesh = make_patient_flesh(p, workers);
  } catch (const InputError& e) {
    no_flesh = e.what();
  }
  progress.note("operations");
  const std::vector<PlannedOperation> planned = operations(p, workers);
  const double cpu_s = (bench::cpu_ms() - start_ms) * 1e-3;
  progress.clear();
  catch_interrupts();
  write_files(o, p, flesh, soft.reach_mm, planned);
  int64_t seen = 0, all = 0;
  for (const PatientBone& b : p.bone) seen += b.cortex.found, all += b.cortex.vertices;
  const double found = all > 0 ? double(seen) / double(all) : 0;
  const std::vector<std::string> faults = missed(p, found);
  std::vector<std::string> notes = loaded.notes;
  notes.push_back(p.offset_why);
  notes.insert(notes.end(), p.notes.begin(), p.notes.end());
  notes.push_back(words_of(soft));
  notes.push_back(no_flesh.empty() ? fmt::format("patient_skin.toml has soft tissue that can be cut: {} triangles, "
                                                 "{:.0f} % of its skin over bone",
                                                 flesh.tri.size(), 100 * flesh.over_bone)
                                   : "there is no soft tissue to be cut (patient_skin.toml): " + no_flesh);
  for (const auto& [cut, name] : {std::pair(&p.parts.mandible, "the mandible"), std::pair(&p.parts.spine, "the spine")})
    if (const std::string w = cut_words(*cut, name, p.offset); !w.empty()) notes.push_back(w);
  for (const PlannedOperation& x : planned)
    if (!x.made()) notes.push_back(x.name + ".jsonl is left out: " + x.why);
  if (p.solid.thin_mm2 > 0)
    notes.push_back(
        fmt::format("{:.0f} cm2 of walls thinner than the voxels show (median {:.2f} mm), drawn at least "
                    "{:.2f} mm thick",
                    1e-2 * p.solid.thin_mm2, p.solid.thin_median_mm, p.solid.as_mm));
  for (const BoneCavity& c : p.solid.cavity)
    notes.push_back(fmt::format("a cavity of {:.1f} cm3 is kept and opened by a passage", 1e-3 * c.volume_mm3));
  if (p.solid.dropped > 0)
    notes.push_back(fmt::format("{} pieces of {:.1f} cm3 that are small or outside the body were left out",
                                p.solid.dropped, 1e-3 * p.solid.dropped_mm3));
  std::printf("volume      %d x %d x %d voxels of %.3g x %.3g x %.3g mm\n", v.size[0], v.size[1], v.size[2],
              v.step_mm.col(0).norm(), v.step_mm.col(1).norm(), v.step_mm.col(2).norm());
  for (const std::string& n : notes) std::printf("note        %s\n", n.c_str());
  for (const PatientBone& b : p.bone)
    std::printf("%-11s %d vertices, %.1f cm3, %lld tunnels, cortex %.2f mm (median)\n", b.name.c_str(),
                b.mesh.vertices(), b.volume_cm3, static_cast<long long>(b.genus), b.cortex.thickness_mm);
  std::printf("skin        %d vertices, %.1f %% reached, rms %.3f mm\n", p.skin.vertices, 100 * p.skin.reached,
              p.skin.rms_mm);
  std::printf(
      "head        turned by %.1f (pitch), %.1f (roll), %.1f (yaw) degrees in the picture; %zu landmarks, %zu not "
      "found\n",
      unsigned_zero(p.anatomy.pitch_deg), unsigned_zero(p.anatomy.roll_deg), unsigned_zero(p.anatomy.yaw_deg),
      p.anatomy.landmark.size(), p.anatomy.missing.size());
  for (const PlannedOperation& x : planned)
    if (x.made()) std::printf("script      %s/%s.jsonl\n", o.common.out_dir.c_str(), x.name.c_str());
  std::printf("scene       %s/patient.toml\n", o.common.out_dir.c_str());
  if (no_flesh.empty()) std::printf("scene       %s/patient_skin.toml\n", o.common.out_dir.c_str());
  std::printf("work        %.1f s of CPU time\n", cpu_s);
  for (const std::string& f : faults) say(o.input + ": " + f);
  Result result("patient", "");
  ResultPatient out;
  out.volume = o.input, out.series = series, out.scene_file = "patient.toml";
  if (no_flesh.empty()) out.skin_scene_file = MaybeText("patient_skin.toml");
  out.offset_HU = p.offset;
  for (const PatientBone& b : p.bone)
    out.bones.push_back({b.name, b.volume_cm3, b.cortex.thickness_mm, b.cortex.shift_mm, b.mesh.vertices(), b.genus});
  const auto cut = [&](const BoneCut& c) {
    return ResultPatientCut{c.made, c.area_mm2, c.made && c.area_mm2 > 0 ? c.density - p.offset : 0,
                            c.made ? c.apart_at - p.offset : 0};
  };
  out.mandible_cut = cut(p.parts.mandible), out.spine_cut = cut(p.parts.spine);
  for (const FoundLandmark& l : p.anatomy.landmark)
    out.landmarks.push_back({l.name, vector_of(l.at_mm), l.sd_mm, l.on_skin});
  out.landmarks_missing = p.anatomy.missing;
  out.pitch_deg = p.anatomy.pitch_deg, out.roll_deg = p.anatomy.roll_deg, out.yaw_deg = p.anatomy.yaw_deg;
  out.symmetry_rms_mm = p.anatomy.symmetry_rms_mm, out.laid_skull_rms_mm = p.anatomy.skull_rms_mm;
  if (!p.bone.empty())
    out.compact_HU = p.bone.front().cortex.cortical - p.offset, out.blur_mm = p.bone.front().cortex.point_mm;
  out.skin_reached = p.skin.reached, out.skin_rms_mm = p.skin.rms_mm, out.bone_found = found, out.cpu_s = cpu_s;
  for (const PlannedOperation& x : planned)
    out.operations.push_back({x.name, x.title, x.made(), x.made() ? MaybeText() : MaybeText(x.why)});
  out.soft_tissue = result_of(soft);
  out.notes = notes, out.missed = unless_empty(faults), out.reproduce = this_call();
  const std::vector<PartInPicture> parts = in_picture(p);
  out.distances = distances(v, p, o, parts, workers);
  write_fields(result, "", out);
  result.set_ok(faults.empty());
  tell(result, p), tell(result, soft), tell(result, out.distances);
  draw_slices(result, o.common.out_dir, v, p, parts);
  leave_result(result, o.common);
  return faults.empty() ? kDone : kGoalMissed;
}

}  // namespace

void add_patient(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<PatientOptions>();
  CLI::App* c = app.add_subcommand("patient", "A scene with skull, mandible, skin and landmarks from a CT of a head");
  c->add_option("CT", o->input, "A folder of DICOM slices (with subfolders; a DICOMDIR), NRRD, MetaImage or NIfTI-1")
      ->required();
  o->common.add_out(*c), o->common.add_words(*c);
  c->add_option("--series", o->series,
                "Of a folder with several: number, UID or part of its description [the one that shows a head best]")
      ->type_name("NAME");
  CLI::Option* offset =
      c->add_option("--offset", o->offset, "What the volume's numbers are above Hounsfield units [by where air lies]")
          ->check(any_number());
  c->add_option("--bone", o->bone, "Above it is bone, Hounsfield units [250]")->check(number_from(100., 1500.));
  c->add_option("--skin", o->skin, "Above it is the body, Hounsfield units [-300]")->check(number_from(-900., 50.));
  c->add_option("--edge-mm", o->edge_mm, "Wanted edges of the bones' meshes [3.5]")->check(number_from(1., 10.));
  c->add_option("--face-edge-mm", o->face_edge_mm, "Wanted edges of the skin's mesh [5]")->check(number_from(1.5, 15.));
  o->common.add_json(*c), o->common.add_workers(*c);
  c->footer(
      "Leaves patient.toml (a scene), its meshes, operations on it (genioplasty, le_fort_1, sagittal_split,\n"
      "autorotation, fronto_orbital: .jsonl; a note says which could not be made), patient_skin.toml (the same bones\n"
      "under soft tissue that can be cut and sewn, flesh.obj), result.json and report.html.\n"
      "Exit status 3: less than 95 % of the skin is within two voxels of its mesh, or less than 90 % of the bone's\n"
      "vertices see a cortex.\n"
      "Example: limberg patient ct_folder --out out/patient\n"
      "         limberg operate out/patient/patient.toml out/patient/le_fort_1.jsonl --out out/maxilla");
  c->callback([o, offset, &chosen] {
    o->has_offset = offset->count() > 0;
    chosen = [o] { return run_patient(*o); };
  });
}

}  // namespace limberg
