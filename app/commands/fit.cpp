#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>

#include "app/bench/cpu_clock.h"
#include "app/commands/commands.h"
#include "app/output.h"
#include "app/progress.h"
#include "app/result.h"
#include "app/session/workers_pool.h"
#include "sim/error.h"
#include "sim/imaging/fit.h"
#include "sim/simplex/file.h"
#include "sim/simplex/generators.h"

namespace limberg {

namespace {

struct Options {
  std::string volume, tissue, mesh_file;
  double iso = 0, offset = 0, edge_mm = 4, chord_mm = 0;
  bool has_iso = false;
  CommonOptions common;
};

/// An ellipsoid that nearly fills the volume.
simplex::Mesh start(const Volume& v) {
  simplex::Mesh m = simplex::make_sphere_of_faces({0, 0, 0}, 1, 1002);
  const Vec3 last(v.size[0] - 1, v.size[1] - 1, v.size[2] - 1);
  Mat3 half = v.step_mm * (0.45 * last).asDiagonal();
  if (half.determinant() < 0) half.col(0) = -half.col(0);  // the outside stays outside
  for (Vec3& x : m.x_mm) x = v.place(0.5 * last) + half * x;
  m.before_mm = m.x_mm;
  return m;
}

int run(const Options& o) {
  o.common.prepare();
  check_writable(o.mesh_file);
  const Volume v = load_volume(o.volume);
  double longest = 0, voxel = 1e300;
  for (int k = 0; k < 3; ++k) {
    const double step = v.step_mm.col(k).norm();
    longest = std::max(longest, step * v.size[size_t(k)]), voxel = std::min(voxel, step);
  }
  FitSettings s;
  s.iso = o.has_iso ? o.iso : (o.tissue == "bone" ? 250 : -300) + o.offset;  // Hounsfield units
  s.edge_mm = o.edge_mm, s.chord_mm = o.chord_mm, s.range_mm = 0.25 * longest;
  Progress progress("fit");
  s.progress = [&](int stage, int32_t vertices, double move_mm) {
    char line[128];
    std::snprintf(line, sizeof line, "stage %d of %d, %d vertices, last move %.3f mm", stage + 1, s.stages, vertices, move_mm);
    progress.note(line);
  };
  WorkersPool workers(o.common.worker_count());
  simplex::Mesh m = start(v);
  const double start_ms = bench::cpu_ms();
  const FitReport r = fit(m, v, s, workers);
  const double cpu_s = (bench::cpu_ms() - start_ms) * 1e-3;
  progress.clear();
  write_whole_file(o.mesh_file, o.mesh_file.ends_with(".obj") ? simplex::to_obj(m) : simplex::to_text(m));
  const simplex::Census c = simplex::census(m);
  std::printf("mesh        %d vertices, %lld faces, %lld end contours, genus %lld\n", r.vertices, static_cast<long long>(c.faces - c.end_contours),
              static_cast<long long>(c.end_contours), static_cast<long long>(c.genus));
  std::printf("surface     %.1f %% of the vertices have one within two voxels\n", 100 * r.found);
  std::printf("distance    rms %.3f mm, 95 %% within %.3f mm, at most %.3f mm (smallest voxel side %.3f mm)\n", r.rms_mm, r.p95_mm, r.max_mm, voxel);
  std::printf("work        %d iterations, %.2f s of CPU time\n", r.iterations, cpu_s);
  constexpr double kMost = 0.9;  // of the vertices: else much of the mesh hangs free, however near the rest may be
  const bool ok = r.found >= kMost && r.rms_mm <= 0.5 * voxel;
  if (!ok) say(o.volume + ": the surface was not reached to half a voxel by 90 % of the vertices; see --iso, --offset");
  Result result("fit", "");
  result.set("/volume", o.volume), result.set("/tissue", o.tissue), result.set("/iso", s.iso), result.set("/mesh", o.mesh_file);
  result.set("/vertices", r.vertices), result.set("/iterations", r.iterations), result.set("/cpu_s", cpu_s);
  result.set("/found", r.found), result.set("/rms_mm", r.rms_mm), result.set("/p95_mm", r.p95_mm), result.set("/max_mm", r.max_mm);
  result.set("/end_contours", c.end_contours), result.set("/genus", c.genus);
  result.set_hash("/state_hash", simplex::hash(m));
  result.set_ok(ok);
  if (!o.common.json_file.empty()) result.write(o.common.json_file);
  return ok ? kDone : kGoalMissed;
}

}  // namespace

void add_fit(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<Options>();
  CLI::App* c = app.add_subcommand("fit", "Fit a simplex mesh to skin or bone in a CT volume");
  c->add_option("VOLUME", o->volume, "NRRD (.nrrd, .nhdr) or MetaImage (.mha, .mhd)")->required();
  c->add_option("--tissue", o->tissue, "skin (-300 HU) or bone (250 HU)")->required()->check(CLI::IsMember({"skin", "bone"}));
  c->add_option("--out", o->mesh_file, "The mesh: a simplex mesh, or triangles when the name ends in .obj")->required()->type_name("MESH");
  CLI::Option* iso = c->add_option("--iso", o->iso, "Isovalue in the volume's own numbers, instead of the tissue's");
  c->add_option("--offset", o->offset, "What the volume's numbers are above Hounsfield units (1024 for many) [0]");
  c->add_option("--edge-mm", o->edge_mm, "Wanted edges of the mesh [4]")->check(CLI::Range(0.1, 100.));
  c->add_option("--chord-mm", o->chord_mm, "Shorter edges where it is curved: allowed distance of an edge from the surface [0: even]")->check(CLI::Range(0., 10.));
  o->common.add_json(*c), o->common.add_workers(*c);
  c->footer("Exit status 3: the surface was not reached to half a voxel by 90 % of the vertices.\n"
            "Example: limberg fit head.nhdr --tissue skin --offset 1024 --out out/skin.simplex");
  c->callback([o, iso, &chosen] {
    o->has_iso = iso->count() > 0;
    chosen = [o] { return run(*o); };
  });
}

}  // namespace limberg
