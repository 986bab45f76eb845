// Images, surfaces, meshes and scenes: what the readers' benches damage at random (tests/bench/fuzz), here guided.
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>

#include "app/program/temporary_folder.h"
#include "render/image.h"
#include "sim/body/collider.h"
#include "sim/body/obj.h"
#include "sim/body/obj_material.h"
#include "tests/bench/fuzz/readers.h"
#include "tests/bench/fuzz/sound_files.h"
#include "tests/fuzz/entry_parts.h"
#include "tests/render/jpeg_bytes.h"

namespace limberg::fuzz {
namespace {

namespace fs = std::filesystem;

const std::map<std::string, std::vector<std::string>> kReads{
    {"NRRD", {"sim/imaging/io/volume.cpp", "sim/imaging/io/header.cpp"}},
    {"MetaImage", {"sim/imaging/io/volume.cpp", "sim/imaging/io/header.cpp"}},
    {"NIfTI", {"sim/imaging/io/nifti.cpp", "sim/imaging/io/volume.cpp"}},
    {"DICOM", {"sim/imaging/io/dicom_folder.cpp", "sim/imaging/io/dicom_file.cpp", "sim/imaging/io/dicom_pixels.cpp"}},
    {"PLY", {"sim/imaging/io/surface_file.cpp", "sim/geometry/io/mesh_file.cpp"}},
    {"STL", {"sim/imaging/io/surface_file.cpp", "sim/geometry/io/mesh_file.cpp"}},
    {"OBJ", {"sim/imaging/io/surface_file.cpp", "sim/geometry/io/obj_text.cpp"}},
    {"xyz", {"sim/imaging/io/surface_file.cpp"}},
    {"simplex", {"sim/skull/simplex/file.cpp"}},
    {"scene",
     {"app/scene/scene.cpp", "app/scene/toml_table.h", "app/scene/scene_layers.cpp", "app/scene/scene_head_read.cpp"}},
};

/// All variants of a reader in one entry. The bytes take the place of the file that is opened, which has the name that
/// it has in the first variant (readers look at what is in a file), or of the first slice of a series; the other files
/// of all variants lie beside it.
Entry reader_entry(const bench::Reader& reader, const Folder& folder) {
  const bench::SoundFiles& first = reader.sound.front();
  const bool series = first.open.empty();
  const std::string name = series ? first.file.front().first : first.open;
  std::vector<std::string> sound;
  const fs::path place = folder->path() / reader.name;
  fs::create_directories(place);
  for (const bench::SoundFiles& s : reader.sound) {
    const std::string hit = series ? name : s.open;
    for (const auto& [file, content] : s.file) {
      if (file == hit)
        sound.push_back(content);
      else if (!series || &s == &first)
        write_file((place / file).string(), content);
    }
  }
  if (series) sound.resize(2);  // slices of the third and fourth series have no place among those of the first
  const auto read = [series, inner = reader.read](const std::string& path) {
    return inner(series ? fs::path(path).parent_path().string() : path);
  };
  return path_entry(reader.name, folder, name, kReads.at(reader.name), sound, read);
}

/// A surface as the body of a patient: snapped, welded and validated exactly.
Entry body_entry() {
  return text_entry("body", {"sim/body/obj.cpp", "sim/geometry/io/obj_text.cpp", "sim/geometry/io/mesh_file.cpp"},
                    {"v 0 0 0\nv 30 0 0\nv 0 20 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
                     "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
                     "z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 4\nproperty list "
                     "uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n30 0 0 0 255 0\n0 20 0 0 0 255\n0 0 10 9 9 "
                     "9\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n"},
                    [](const std::string& text) -> std::string {
                      ObjSpec spec;
                      spec.path = kNamed;
                      Layer skin;
                      skin.name = "skin", skin.thickness_mm = 1;
                      spec.layers = {skin};
                      const Body body = parse_obj(text, spec);
                      for (const Tri& t : body.surface.tri)
                        for (const int32_t c : t)
                          if (c < 0 || size_t(c) >= body.surface.X_mm.size()) return "a triangle without its corner";
                      return body.surface.tri.size() < 4 ? "a body that encloses nothing" : "";
                    });
}

/// What tissue lies against: closed, whatever else.
Entry collider_entry() {
  return text_entry(
      "collider", {"sim/body/collider.cpp", "sim/geometry/io/obj_text.cpp"},
      {"v 0 0 0\nv 30 0 0\nv 0 20 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
       "v 0 0 0 1 0 0\nv 30 0 0 0 1 0\nv 0 20 0 0 0 1\nv 0 0 10 .5 .5 .5\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"},
      [](const std::string& text) -> std::string {
        ColliderSpec spec;
        spec.path = kNamed;
        const auto c = parse_collider(text, spec);
        for (const Tri& t : c->mesh.tri)
          for (const int32_t v : t)
            if (v < 0 || size_t(v) >= c->mesh.X_mm.size()) return "a triangle without its corner";
        if (!c->rgb.empty() && c->rgb.size() != c->mesh.X_mm.size()) return "colours of some vertices";
        return c->mesh.tri.size() < 4 ? "a collider that encloses nothing" : "";
      });
}

Entry material_entry() {
  return text_entry("material", {"sim/body/obj_material.cpp"},
                    {"newmtl a\nKd 1 1 1\nmap_Kd -s 1 1 1 face.png\n", "mtllib a b.mtl\nv 0 0 0\n"},
                    [](const std::string& text) -> std::string {
                      for (const std::string& name : {picture_of_material(text), materials_of_obj(text)})
                        if (name.find('\n') != std::string::npos || name.size() > text.size())
                          return "a name that no line holds";
                      return "";
                    });
}

/// With the checksums that a hostile writer would give its chunks.
std::string with_checksums(std::string_view bytes) {
  std::string png(bytes);
  const auto number = [&](size_t at) {
    uint32_t v = 0;
    for (size_t k = 0; k < 4; ++k) v = v << 8 | uint8_t(png[at + k]);
    return size_t(v);
  };
  for (size_t at = 8; at + 12 <= png.size();) {
    const size_t length = number(at);
    if (length > png.size() - at - 12) break;
    const auto sum = ::crc32(0, reinterpret_cast<const Bytef*>(png.data() + at + 4), uInt(length + 4));
    for (size_t k = 0; k < 4; ++k) png[at + 8 + length + k] = char(sum >> (24 - 8 * k));
    at += 12 + length;
  }
  return png;
}

Entry png_entry() {
  Image image(5, 4, {200, 150, 140});
  image.set(2, 1, {1, 2, 3});
  return text_entry("PNG", {"render/image.cpp", "app/report/html.cpp"}, {encode_png(image)},
                    [](const std::string& text) -> std::string {
                      const Image got = decode_png(with_checksums(text), kNamed);
                      if (got.width < 1 || got.height < 1) return "a picture without pixels was taken";
                      if (got.rgb.size() != 3 * size_t(got.width) * size_t(got.height))
                        return "the picture has another number of pixels than it says";
                      return got.rgb.size() > 3 * kMostPixels ? "a picture beyond the limit was taken" : "";
                    });
}

Entry jpeg_entry() {
  const Image image(19, 11, {200, 150, 140});
  return text_entry("JPEG", {"render/image_jpeg.cpp"},
                    {test::jpeg_bytes(image), test::jpeg_bytes(image, test::JpegKind::progressive)},
                    [](const std::string& text) -> std::string {
                      const Image got = decode_jpeg(text, kNamed);
                      if (got.width < 1 || got.height < 1) return "a picture without pixels was taken";
                      if (got.rgb.size() != 3 * size_t(got.width) * size_t(got.height))
                        return "the picture has another number of pixels than it says";
                      return got.rgb.size() > 3 * kMostPixels ? "a picture beyond the limit was taken" : "";
                    });
}

}  // namespace

std::vector<Entry> file_entries(const Folder& folder) {
  std::vector<Entry> all;
  for (const bench::Reader& r : bench::readers()) all.push_back(reader_entry(r, folder));
  all.push_back(body_entry());
  all.push_back(collider_entry());
  all.push_back(material_entry());
  all.push_back(png_entry());
  all.push_back(jpeg_entry());
  return all;
}

}  // namespace limberg::fuzz
