#include "sim/skull/head/head_view.h"

#include "sim/base/hash.h"
#include "sim/skull/simplex/dual.h"

namespace limberg {

namespace {

/// Appends the fans of a mesh: its slots are vertices from `base`, the middles of its faces follow them.
template <class OfFace>
void add_fans(SurfaceTopology& top, const simplex::Mesh& mesh, std::vector<int32_t>& middle, OfFace&& of_face) {
  const auto base = int32_t(top.view.X_mm.size());
  for (int32_t v = 0; v < mesh.slots(); ++v)
    top.view.X_mm.push_back(mesh.alive(v) ? mesh.x_mm[size_t(v)] : Vec3(Vec3::Zero()));
  middle.clear();
  for (int32_t f = 0; f < mesh.face_slots(); ++f) {
    if (!mesh.alive_face(f) || simplex::is_end(mesh.kind(f))) continue;
    const auto centre = int32_t(top.view.X_mm.size());
    top.view.X_mm.push_back(simplex::face_centre(mesh, f));
    middle.push_back(f);
    const auto [organ, object] = of_face(f);
    mesh.around(f, [&, organ = organ, object = object](int32_t h) {  // clang 14 cannot capture parts of a pair
      top.view.tri.push_back({centre, base + mesh.from(h), base + mesh.to(h)});
      top.view.kind.push_back(FaceKind::free);
      top.organ.push_back(organ);
      top.object.push_back(object);
    });
  }
}

}  // namespace

void HeadView::build(const simplex::Mesh& face, const bone::Bones& bones,
                     const std::vector<const simplex::Tissue*>& tissue, const std::vector<std::string>& landmarks,
                     const SurfaceColour& colour, const FaceTexture* texture) {
  auto top = std::make_shared<SurfaceTopology>();
  top->version = ++version_;
  add_fans(*top, face, face_middle_, [](int32_t) { return std::pair(Organ::face, int32_t(-1)); });
  face_slots_ = size_t(face.slots()), face_vertices_ = top->view.X_mm.size();
  const simplex::Mesh& mesh = bones.mesh();
  add_fans(*top, mesh, bone_middle_, [&](int32_t f) {
    return std::pair(mesh.kind(f) == simplex::FaceKind::wall ? Organ::bone_cut : Organ::bone,
                     bones.fragment_of(mesh.face_edge[size_t(f)] / 3));
  });
  bone_slots_ = size_t(mesh.slots());
  const SurfaceTopology& made = *top;
  bone_middle_mm_.clear();
  for (size_t i = 0; i < bone_middle_.size(); ++i)
    bone_middle_mm_.push_back(made.view.X_mm[face_vertices_ + bone_slots_ + i]);
  // Fragments by place in the list: its order changes only with the topology.
  const auto place = [&](int32_t id) {
    for (size_t i = 0; i < bones.fragments().size(); ++i)
      if (bones.fragments()[i].id == id) return int32_t(i);
    return int32_t(-1);
  };
  fragment_.assign(bone_slots_ + bone_middle_.size(), -1);
  for (int32_t v = 0; v < mesh.slots(); ++v)
    if (mesh.alive(v)) fragment_[size_t(v)] = place(bones.fragment_of(v));
  for (size_t i = 0; i < bone_middle_.size(); ++i)
    fragment_[bone_slots_ + i] = fragment_[size_t(mesh.face_edge[size_t(bone_middle_[i])] / 3)];
  if (colour) {
    top->rgba.resize(made.view.X_mm.size());
    for (size_t v = 0; v < top->rgba.size(); ++v) {
      const bool cut = v >= face_vertices_ + bone_slots_ &&
                       mesh.kind(bone_middle_[v - face_vertices_ - bone_slots_]) == simplex::FaceKind::wall;
      top->rgba[v] = colour(made.view.X_mm[v], v < face_vertices_ ? Organ::face : cut ? Organ::bone_cut : Organ::bone);
    }
  }
  if (texture) put_on(*top, face, *texture);
  tissue_vertices_ = 0;
  for (const simplex::Tissue* t : tissue) {
    const auto base = int32_t(top->view.X_mm.size());
    for (int32_t v = 0; v < t->vertices(); ++v) {
      top->view.X_mm.push_back(t->x_mm[size_t(v)]);
      for (const int32_t n : t->nbr[size_t(v)])
        if (n > v) top->strand.push_back({base + v, base + n});
    }
    tissue_vertices_ += size_t(t->vertices());
  }
  if (!top->rgba.empty()) top->rgba.resize(top->view.X_mm.size());  // tissue is strands, and shows none
  top->landmark = landmarks;
  Hash64 h;
  h.add(simplex::topology_hash(face)), h.add(simplex::topology_hash(mesh));
  for (const simplex::Tissue* t : tissue) h.add(uint64_t(t->vertices()));
  for (const std::string& l : landmarks) h.add(l);
  top->hash = h.value();
  topology_ = std::move(top);
}

void HeadView::put_on(SurfaceTopology& top, const simplex::Mesh& face, const FaceTexture& texture) {
  const SharedArray<Vec3>& X = std::as_const(top.view.X_mm);
  const uint64_t mesh = simplex::topology_hash(face);
  if (worn_.face != mesh || worn_.rgba.size() != face_vertices_) {
    worn_ = {mesh, {}, {}};
    worn_.rgba.resize(face_vertices_);
    std::vector<bool> used(face_vertices_);
    for (size_t t = 0; t < top.view.tri.size() && std::as_const(top.organ)[t] == Organ::face; ++t) {
      const Tri& c = std::as_const(top.view.tri)[t];
      for (const int32_t v : c) used[size_t(v)] = true;
      if (texture.image()) worn_.uv.push_back(texture.uv({X[size_t(c[0])], X[size_t(c[1])], X[size_t(c[2])]}));
    }
    for (size_t v = 0; v < face_vertices_; ++v)
      if (used[v]) worn_.rgba[v] = texture.colour(X[v]);
  }
  top.rgba.resize(X.size());
  std::copy(worn_.rgba.begin(), worn_.rgba.end(), top.rgba.begin());
  if (!texture.image()) return;
  top.image = texture.image(), top.image_on = Organ::face;
  for (const auto& corners : worn_.uv) top.view.uv.push_back(corners);
  while (top.view.uv.size() < top.view.tri.size()) top.view.uv.push_back({});  // bone wears none
}

void HeadView::places(const simplex::Mesh& face, const bone::Bones& bones,
                      const std::vector<const simplex::Tissue*>& tissue, std::vector<Vec3f>& x) const {
  x.resize(face_vertices_ + fragment_.size() + tissue_vertices_);
  size_t at = 0;
  for (size_t v = 0; v < face_slots_; ++v) x[at++] = face.x_mm[v].cast<float>();
  for (const int32_t f : face_middle_) x[at++] = simplex::face_centre(face, f).cast<float>();
  const auto& fragments = bones.fragments();
  for (size_t i = 0; i < fragment_.size(); ++i) {
    if (fragment_[i] < 0) {
      x[at++] = Vec3f::Zero();
      continue;
    }
    const Eigen::Isometry3d& pose = fragments[size_t(fragment_[i])].pose;
    x[at++] = (pose * (i < bone_slots_ ? bones.mesh().x_mm[i] : bone_middle_mm_[i - bone_slots_])).cast<float>();
  }
  for (const simplex::Tissue* t : tissue)
    for (const Vec3& p : t->x_mm) x[at++] = p.cast<float>();
}

void HeadView::moved(const simplex::Mesh& face, const std::vector<Vec3f>& x, std::vector<float>& moved_mm) const {
  const SharedArray<Vec3>& X = std::as_const(topology_->view.X_mm);
  moved_mm.assign(x.size(), 0.0f);
  for (size_t v = 0; v < face_slots_; ++v)
    if (face.alive(int32_t(v))) moved_mm[v] = (x[v] - X[v].cast<float>()).norm();
  for (size_t i = 0; i < face_middle_.size(); ++i) {
    Vec3f sum = Vec3f::Zero();
    face.around(face_middle_[i],
                [&](int32_t h) { sum += x[size_t(face.from(h))] - X[size_t(face.from(h))].cast<float>(); });
    moved_mm[face_slots_ + i] = (sum / float(face.face_size[size_t(face_middle_[i])])).norm();
  }
}

}  // namespace limberg
