#include "app/head/build.h"

#include <algorithm>
#include <filesystem>

#include "app/head/cache.h"
#include "app/head/face_look.h"
#include "sim/base/error.h"
#include "sim/imaging/anatomical/skin_colour.h"
#include "sim/imaging/synthetic/synthetic_head.h"
#include "sim/skull/simplex/file.h"

namespace limberg {

namespace {

/// Names of the synthetic head: soft tissue begins with a small letter.
bool on_face(const std::string& name) { return !name.empty() && name[0] >= 'a' && name[0] <= 'z'; }

void add_synthetic(const HeadScene& h, HeadParts& parts, Workers& workers) {
  HeadSpec spec;
  spec.anatomical = h.source == HeadScene::Source::anatomical;
  spec.mandible_scale = h.mandible_scale, spec.ramus_left = h.ramus_left;
  spec.vault_wide = h.vault_wide, spec.vault_long = h.vault_long, spec.forehead_flat = h.forehead_flat;
  spec.edge_mm = h.edge_mm, spec.face_edge_mm = h.face_edge_mm;
  HeadModel m = cached_head(spec, workers);
  parts.bones.push_back({"cranium", std::move(m.cranium), false});
  parts.bones.push_back({"mandible", std::move(m.mandible), false});
  if (h.face) parts.face = std::move(m.face);
  for (const auto& [name, at] : m.landmarks)
    if (h.face || !on_face(name)) parts.landmarks.push_back({name, at, on_face(name)});
}

/// A mesh from a file with its axes right, forwards and up. `axes`: those of the file.
simplex::Mesh mesh_of(const Scene& scene, const std::string& file, simplex::Axes* axes = nullptr) {
  using simplex::Axes;
  simplex::Mesh m = simplex::load_mesh(file);
  const Axes said = scene.head->axes;
  if (said != Axes::unsaid && m.axes != Axes::unsaid && said != m.axes)
    throw InputError(scene.path, 0,
                     "head.axes says otherwise than " + file + " which way its axes point; expected no head.axes");
  if (m.axes == Axes::unsaid) m.axes = said;
  if (axes) *axes = m.axes;
  simplex::turn_to_head(m);
  return m;
}

}  // namespace

HeadParts head_parts(const Scene& scene, Workers& workers) {
  const HeadScene& h = *scene.head;
  HeadParts parts;
  parts.face_iterations = h.iterations_per_step;
  simplex::Axes of_face = simplex::Axes::unsaid;
  if (h.source != HeadScene::Source::files) {
    add_synthetic(h, parts, workers);
  } else {
    for (const std::string& f : h.bone_files)
      parts.bones.push_back({std::filesystem::path(f).stem().string(), mesh_of(scene, f), false});
    if (h.face) parts.face = mesh_of(scene, h.face_file, &of_face);
  }
  parts.texture = face_look(scene, of_face);
  if (h.source == HeadScene::Source::anatomical)
    parts.colour = [off = h.offset_mm](const Vec3& X, Organ organ) {
      return organ == Organ::face ? anatomical::colour_on_face(X - off) : anatomical::colour_on_bone(X - off);
    };
  if (h.offset_mm != Vec3::Zero()) {
    std::vector<simplex::Mesh*> meshes{&parts.face};
    for (auto& b : parts.bones) meshes.push_back(&b.mesh);
    for (simplex::Mesh* m : meshes) {
      for (Vec3& x : m->x_mm) x += h.offset_mm;
      for (Vec3& x : m->before_mm) x += h.offset_mm;
    }
    for (HeadLandmark& l : parts.landmarks) l.X_mm += h.offset_mm;
  }
  for (const std::string& name : h.fixed) {
    const auto b = std::find_if(parts.bones.begin(), parts.bones.end(), [&](const auto& x) { return x.name == name; });
    if (b == parts.bones.end())
      throw InputError(scene.path, 0,
                       "head.fixed names the bone \"" + name + "\", which is not there; expected one of the bones");
    b->fixed = true;
  }
  const auto put = [&](const auto& places, bool face) {
    for (const auto& [name, at] : places) {
      const auto same = std::find_if(parts.landmarks.begin(), parts.landmarks.end(),
                                     [&, n = name](const HeadLandmark& l) { return l.name == n; });
      if (same != parts.landmarks.end())
        same->X_mm = at, same->on_face = face;
      else
        parts.landmarks.push_back({name, at, face});
    }
  };
  put(h.landmarks, false);
  put(h.face_landmarks, true);
  const auto place_of = [&](const std::string& name, const char* key = "tissue") {
    for (const HeadLandmark& l : parts.landmarks)
      if (l.name == name) return l.X_mm;
    throw InputError(scene.path, 0,
                     std::string("head.") + key + " names the landmark \"" + name +
                         "\", which is not there; expected a place [x, y, z] or one of the landmarks");
  };
  const auto fill = [&](std::vector<Vec3>& at, const std::vector<std::string>& names, const char* key) {
    for (size_t k = 0; k < names.size(); ++k)
      if (!names[k].empty()) at[k] = place_of(names[k], key);
  };
  for (const HeadScene::TissueAt& t : h.tissues) {
    ConnectTissue c = t.tissue;
    if (!t.face_name.empty()) c.face_mm = place_of(t.face_name);
    fill(c.face_outline_mm, t.outline_names, "tissue");
    if (!c.face_outline_mm.empty()) c.face_mm = middle_of(c.face_outline_mm);
    if (!t.bone_name.empty()) c.bone_mm = place_of(t.bone_name);
    parts.tissues.push_back(std::move(c));
  }
  for (const HeadScene::MuscleAt& m : h.muscles) {
    simplex::FaceBundle& b = parts.muscles.emplace_back(m.bundle);
    fill(b.path_mm, m.names, "muscle");
  }
  for (const HeadScene::SlideAt& s : h.slides) {
    simplex::FaceSlide& into = parts.slides.emplace_back(s.slide);
    if (!s.landmark.empty()) into.at_mm = place_of(s.landmark, "slide");
  }
  return parts;
}

}  // namespace limberg
