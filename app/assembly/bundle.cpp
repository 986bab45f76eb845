#include "app/assembly/bundle.h"

#include <cstdlib>
#include <filesystem>
#include <set>

#include "app/program/temporary_folder.h"
#include "sim/base/error.h"
#include "sim/base/quoted.h"
#include "sim/base/whole_file.h"

namespace limberg {

namespace fs = std::filesystem;

namespace {

constexpr int kFoldersUp = 8;                     // a mesh may lie so many folders above its scene
constexpr const char* kTissues = "tissues.toml";  // beside the scene, where it is looked for first
constexpr size_t kMaxMesh = size_t(512) << 20;

bool inside(const fs::path& root, const fs::path& p) {
  const fs::path r = p.lexically_relative(root);
  return !r.empty() && *r.begin() != "..";
}

}  // namespace

std::vector<Blob> bundle(const Scene& scene, const Calibration& calibration) {
  std::vector<Blob> out;
  out.push_back({BlobKind::scene, scene.name.substr(0, 63), scene.text});
  out.push_back({BlobKind::calibration, calibration.name.substr(0, 63), to_toml(calibration)});
  if (!scene.tissues.empty()) out.push_back({BlobKind::tissues, kTissues, scene.tissues});
  std::set<std::string> there;
  const auto add_file = [&](const std::string& path, bool given) {
    if (!there.insert(path).second) return;  // a face may wear the surface that its scene names elsewhere
    const fs::path folder = fs::path(scene.path).parent_path();
    const std::string name = fs::path(path).lexically_relative(folder.empty() ? "." : folder).string();
    if (name.empty() || fs::path(name).is_absolute() || name.size() > 63) {
      if (!given) return;
      throw InputError(scene.path, 0,
                       "the path \"" + path +
                           "\" cannot go into a recording; expected a path of at most 63 bytes relative to the scene");
    }
    out.push_back({BlobKind::mesh, name, read_whole_file(path, kMaxMesh)});
  };
  for (const NamedFile& f : files_of(scene)) add_file(f.path, f.given);
  for (const NamedFile& f : looks_of(scene)) add_file(f.path, f.given);
  return out;
}

Unbundled unbundle_scene(const Recording& rec, const std::string& file) {
  const Blob* scene = rec.blob(BlobKind::scene);
  if (!scene) throw InputError(file, 0, "no valid record of a scene; expected a recording that holds its scene whole");
  bool has_files = false;
  for (const Blob& b : rec.blobs) has_files |= b.kind == BlobKind::mesh || b.kind == BlobKind::tissues;
  Unbundled out;
  if (!has_files) {
    out.scene = parse_scene(scene->data, file);
  } else {
    // The scene reads its mesh and tissues from paths relative to itself: lay all out below a folder of our own. A path
    // that would lead out of it is refused.
    const auto tmp = std::make_shared<TemporaryFolder>();
    fs::path folder = tmp->path();
    for (int i = 0; i < kFoldersUp; ++i) folder /= "s";
    fs::create_directories(folder);
    for (const Blob& b : rec.blobs) {
      if (b.kind == BlobKind::tissues) write_whole_file((folder / kTissues).string(), b.data);
      if (b.kind != BlobKind::mesh) continue;
      const fs::path at = (folder / b.name).lexically_normal();
      if (fs::path(b.name).is_absolute() || !inside(tmp->path(), at))
        throw InputError(file, 0,
                         "holds a mesh with the path " + limberg::quoted(b.name) + "; expected a path near its scene");
      std::error_code ec;
      fs::create_directories(at.parent_path(), ec);
      if (ec || fs::is_directory(at, ec))  // a file where another one's folder is, or the other way round
        throw InputError(file, 0,
                         "holds a mesh with the path " + limberg::quoted(b.name) +
                             ", which is in another one's way; expected paths of files beside each other");
      write_whole_file(at.string(), b.data);
    }
    const std::string at = (folder / "scene.toml").string();
    try {
      out.scene = parse_scene(scene->data, at);
    } catch (const InputError& e) {  // of a file that nobody has named
      std::string what = e.what();
      for (size_t k = what.find(at); k != std::string::npos; k = what.find(at)) what.replace(k, at.size(), "scene");
      throw InputError(file, 0, "holds a scene that cannot be read (" + what + "); expected a whole one");
    }
    out.files = tmp;
  }
  if (!scene->name.empty()) out.scene.name = scene->name;
  return out;
}

Calibration unbundle_calibration(const Recording& rec, const std::string& file) {
  const Blob* b = rec.blob(BlobKind::calibration);
  return b ? parse_calibration(b->data, file) : Calibration{};
}

}  // namespace limberg
