// Writes the surfaces of the face that shipped scenes operate on, their materials and their picture:
//
//   limberg_face_surface app/scenes        -> anatomical_face.obj, .mtl and .png; anatomical_lips.obj, its lips parted;
//                                             anatomical_cleft.obj, with a cleft of the upper lip;
//                                             anatomical_teeth.obj and anatomical_gums.obj, which these lie against;
//                                             anatomical_lids.obj, lids of the right eye parted; anatomical_eye.obj,
//                                             _iris.obj and _pupil.obj, which these lie against;
//                                             anatomical_scalp.obj, the face with the scalp over the vertex;
//                                             anatomical_tension.txt, lines of tension of the face
#include <fmt/format.h>
#include <fmt/os.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>

#include "app/session/workers_pool.h"
#include "render/image.h"
#include "sim/imaging/anatomical/face_lines.h"
#include "sim/imaging/anatomical/face_tissue.h"
#include "sim/imaging/anatomical/lid_bed.h"
#include "sim/imaging/anatomical/mouth_bed.h"
#include "sim/imaging/anatomical/skin_colour.h"

using namespace limberg;

namespace {

constexpr int kPicture = 768;  // pixels a side: .35 mm of skin each

void write_surface(const FaceTissue& f, const std::string& file) {
  auto out = fmt::output_file(file);
  out.print("# The soft tissue of a face, made by limberg_face_surface: mm, x right, y forwards, z up.\n");
  out.print("mtllib anatomical_face.mtl\n");
  for (const Vec3& X : f.X_mm) out.print("v {:.2f} {:.2f} {:.2f}\n", X.x(), X.y(), X.z());
  for (const Vec2& q : f.uv) out.print("vt {:.4f} {:.4f}\n", q.x(), q.y());
  if (f.uv_of_mucosa) out.print("vt {:.4f} {:.4f}\n", f.uv_of_mucosa->x(), f.uv_of_mucosa->y());
  for (size_t part = 0; part < std::size(kFaceParts); ++part) {
    if (std::find(f.part.begin(), f.part.end(), FacePart(part)) == f.part.end()) continue;
    out.print("usemtl {}\n", kFaceParts[part]);
    const bool one_colour = f.uv_of_mucosa && FacePart(part) == FacePart::mucosa;
    for (size_t t = 0; t < f.tri.size(); ++t) {
      if (size_t(f.part[t]) != part) continue;
      out.print("f");
      for (const int32_t v : f.tri[t]) out.print(" {}/{}", v + 1, one_colour ? f.uv.size() + 1 : size_t(v) + 1);
      out.print("\n");
    }
  }
}

void write_materials(const std::string& file) {
  auto out = fmt::output_file(file);
  for (const char* part : kFaceParts) out.print("newmtl {}\nmap_Kd anatomical_face.png\n", part);
}

void write_mesh(const TriMesh& m, const std::string& file) {
  auto out = fmt::output_file(file);
  out.print("# Made by limberg_face_surface: mm, x right, y forwards, z up.\n");
  for (const Vec3& X : m.X_mm) out.print("v {:.3f} {:.3f} {:.3f}\n", X.x(), X.y(), X.z());
  for (const Tri& t : m.tri) out.print("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  std::printf("%s: %zu corners, %zu triangles\n", file.c_str(), m.X_mm.size(), m.tri.size());
}

void write_lines(const FaceTissue& f, const std::string& file) {
  const std::vector<FaceLine> places = face_tension_lines(f.X_mm, f.tri);
  auto out = fmt::output_file(file);
  out.print(
      "# Relaxed skin tension lines of the face, made by limberg_face_surface (sim/imaging/anatomical/face_lines.h "
      "names\n"
      "# sources): a place, mm, x right, y forwards, z up; and the way of the lines there.\n");
  for (const FaceLine& p : places)
    out.print("{:.1f} {:.1f} {:.1f}  {:.3f} {:.3f} {:.3f}\n", p.at_mm.x(), p.at_mm.y(), p.at_mm.z(), p.along.x(),
              p.along.y(), p.along.z());
  std::printf("%s: %zu places\n", file.c_str(), places.size());
}

Image picture(Workers& workers) {
  Image image(kPicture, kPicture);
  const auto byte = [](double v) { return uint8_t(std::lround(255 * std::clamp(v, 0., 1.))); };
  workers.parallel_for(kPicture, 8, [&](size_t begin, size_t end) {
    for (size_t row = begin; row < end; ++row)
      for (int column = 0; column < kPicture; ++column) {
        const Vec2 uv((column + 0.5) / kPicture, 1 - (double(row) + 0.5) / kPicture);
        const Vec3 colour = anatomical::skin_colour(face_place_of_picture(uv));
        image.set(column, int(row), {byte(colour[0]), byte(colour[1]), byte(colour[2])});
      }
  });
  return image;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fprintf(stderr, "limberg_face_surface: expected one folder\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  WorkersPool workers(2);
  const std::pair<const char*, FaceOpenings> faces[] = {{"face", {}},
                                                        {"lips", {.lips = Lips::parted}},
                                                        {"cleft", {.lips = Lips::cleft}},
                                                        {"lids", {.lids = Lids::parted}},
                                                        {"scalp", {.reach = FaceReach::scalp}}};
  for (const auto& [name, open] : faces) {
    const FaceTissue face = make_face_tissue(workers, open);
    write_surface(face, (folder / fmt::format("anatomical_{}.obj", name)).string());
    std::printf("%s: %zu corners, %zu triangles\n", name, face.X_mm.size(), face.tri.size());
    if (std::string(name) == "face") write_lines(face, (folder / "anatomical_tension.txt").string());
  }
  const anatomical::SkinShape skin;
  const MouthBedMeshes bed = make_mouth_bed(MouthBed(skin), workers);
  write_mesh(bed.teeth, (folder / "anatomical_teeth.obj").string());
  write_mesh(bed.gums, (folder / "anatomical_gums.obj").string());
  const LidBedMeshes eye = make_lid_bed();
  write_mesh(eye.globe, (folder / "anatomical_eye.obj").string());
  write_mesh(eye.iris, (folder / "anatomical_iris.obj").string());
  write_mesh(eye.pupil, (folder / "anatomical_pupil.obj").string());
  write_materials((folder / "anatomical_face.mtl").string());
  write_png((folder / "anatomical_face.png").string(), picture(workers));
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "limberg_face_surface: %s\n", e.what());
  return 1;
}
