// What the fuzzer of readers reads, and what it asks of what was taken.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/program/places.h"
#include "app/scene/scene.h"
#include "sim/imaging/io/surface_file.h"
#include "sim/imaging/io/volume.h"
#include "sim/skull/simplex/file.h"
#include "sim/skull/simplex/generators.h"
#include "tests/bench/fuzz/readers.h"
#include "tests/bench/fuzz/sound_files.h"

namespace limberg::bench {

namespace {

std::string sound_volume(const std::string& path) {
  const Volume v = load_volume(path);
  for (const int32_t n : v.size)
    if (n < 1) return "a volume without voxels was taken";
  if (v.value.size() != size_t(v.size[0]) * size_t(v.size[1]) * size_t(v.size[2]))
    return "the volume has another number of voxels than it says";
  if (!v.step_mm.allFinite() || !v.origin_mm.allFinite() || !(std::abs(v.step_mm.determinant()) > 0))
    return "the volume has no place";
  for (const float x : v.value)
    if (!std::isfinite(x)) return "a voxel is not finite";
  return "";
}

std::string sound_surface(const std::string& path) {
  const Surface s = load_surface(path);
  if (s.x_mm.empty()) return "a surface without points was taken";
  for (const Vec3& x : s.x_mm)
    if (!(x.cwiseAbs().maxCoeff() <= SurfaceFileLimits::extent_mm)) return "a point is not at a sensible place";
  for (const Tri& t : s.tri)
    for (const int32_t c : t)
      if (c < 0 || size_t(c) >= s.x_mm.size()) return "a triangle names a point that is not there";
  return "";
}

std::string sound_mesh(const std::string& path) { return simplex::find_fault(simplex::load_mesh(path)).value_or(""); }

std::string sound_scene(const std::string& path) {
  load_scene(path);
  return "";
}

SoundFiles one(const std::string& name, std::string content) { return {{{name, std::move(content)}}, name}; }

std::string scene_text(const char* name) {
  std::ifstream in(std::filesystem::path(source_dir()) / "app/scenes" / (std::string(name) + ".toml"));
  std::ostringstream s;
  s << in.rdbuf();
  return s.str();
}

}  // namespace

std::vector<Reader> readers() {
  using namespace fuzz;
  std::vector<Reader> out;
  const std::string raw = nrrd(false), header = raw.substr(0, raw.find("\n\n") + 1),
                    data = raw.substr(raw.find("\n\n") + 2);
  out.push_back({"NRRD",
                 {one("a.nrrd", raw),
                  one("a.nrrd", nrrd(true)),
                  {{{"a.nhdr", header + "data file: a.raw\n"}, {"a.raw", data}}, "a.nhdr"}},
                 sound_volume});
  std::string meta = meta_image(false);
  const size_t local = meta.find("LOCAL\n");
  const std::string meta_data = meta.substr(local + 6);
  meta.replace(local, std::string::npos, "a.raw\n");
  out.push_back({"MetaImage",
                 {one("a.mha", meta_image(false)),
                  one("a.mha", meta_image(true)),
                  {{{"a.mhd", meta}, {"a.raw", meta_data}}, "a.mhd"}},
                 sound_volume});
  out.push_back({"NIfTI",
                 {one("a.nii", nifti(false, 1)), one("a.nii", nifti(true, 2, 2, 5)), one("a.nii", nifti(false, 0))},
                 sound_volume});
  Reader series{"DICOM", {}, sound_volume};
  for (int form = 0; form < 4; ++form) {  // explicit, implicit, run length encoded, tilted
    SoundFiles f;
    for (int k = 0; k < 4; ++k) {
      Slice s;
      s.explicit_vr = form != 1, s.run_length = form == 2, s.at = {1, form == 3 ? 0.5 * k : 0, 3. * k}, s.slope = 2,
      s.intercept = -24;
      s.value = [k](int i, int j) { return int16_t(i + 10 * j + 100 * k); };
      f.file.emplace_back("s" + std::to_string(k) + ".dcm", dicom(s));
    }
    series.sound.push_back(std::move(f));
  }
  for (int form = 0; form < 3; ++form) {  // all in one file: with lengths, without and implicit, run length encoded
    std::vector<Slice> frames(4);
    for (int k = 0; k < 4; ++k) {
      Slice& s = frames[size_t(k)];
      s.explicit_vr = form != 1, s.run_length = form == 2, s.at = {1, 0, 3. * k}, s.slope = 2, s.intercept = -24;
      s.value = [k](int i, int j) { return int16_t(i + 10 * j + 100 * k); };
    }
    series.sound.push_back(one("s0.dcm", enhanced_dicom(frames, form != 1)));
  }
  out.push_back(std::move(series));
  out.push_back(
      {"PLY",
       {one("a.ply", ply_file(Ply::text)), one("a.ply", ply_file(Ply::little)), one("a.ply", ply_file(Ply::big))},
       sound_surface});
  out.push_back({"STL", {one("a.stl", stl_file(false)), one("a.stl", stl_file(true))}, sound_surface});
  out.push_back({"OBJ", {one("a.obj", obj_file())}, sound_surface});
  out.push_back({"xyz", {one("a.xyz", "# scan\n0 0 1\n1,2,3,255\n\n4 5 6 0.1 0.2\n-7 8e1 9\n")}, sound_surface});
  simplex::Mesh m = simplex::make_sphere({1, 2, 3}, 10, 0);
  m.before_mm[3] += Vec3(0.1, 0, 0);
  out.push_back({"simplex", {one("a.simplex", simplex::to_text(m))}, sound_mesh});
  out.push_back({"scene",
                 {one("a.toml", scene_text("rhomboid")), one("a.toml", scene_text("craniofacial")),
                  one("a.toml", scene_text("cheek"))},
                 sound_scene});
  return out;
}

}  // namespace limberg::bench
