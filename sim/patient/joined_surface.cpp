#include "sim/patient/joined_surface.h"

#include <algorithm>

#include "sim/base/hash.h"

namespace limberg {
namespace {

/// Lists that only the skin has are as long as the skin.
std::shared_ptr<const SurfaceTopology> joined(const SurfaceTopology& skin, const SurfaceTopology& head,
                                              uint64_t version) {
  auto both = std::make_shared<SurfaceTopology>(skin);
  both->version = version;
  Hash64 h;
  h.add(skin.hash), h.add(head.hash);
  both->hash = h.value();
  const auto base = int32_t(skin.view.X_mm.size());
  both->organ.assign(skin.view.tri.size(), Organ::flesh);
  both->object.assign(skin.view.tri.size(), -1);
  for (size_t v = 0; v < head.view.X_mm.size(); ++v) {
    both->view.X_mm.push_back(head.view.X_mm[v]);
    both->embedding.push_back({});
  }
  const auto with_others = [others = head.view.X_mm.size()](const Lazy<SharedArray<float>>& of_skin) {
    return Lazy<SharedArray<float>>([of_skin, others] {
      SharedArray<float> depth = of_skin.get();
      for (size_t v = 0; v < others; ++v) depth.push_back(0);
      return depth;
    });
  };
  both->depth_mm = with_others(skin.depth_mm), both->layers_mm = with_others(skin.layers_mm);
  for (size_t t = 0; t < head.view.tri.size(); ++t) {
    const Tri& k = head.view.tri[t];
    both->view.tri.push_back({k[0] + base, k[1] + base, k[2] + base});
    both->view.kind.push_back(head.view.kind[t]);
    both->organ.push_back(head.organ[t]);
    both->object.push_back(head.object[t]);
  }
  if (!both->image) both->image = head.image, both->image_on = head.image_on;  // a scene has one (app/scene)
  if (both->image) {
    both->view.uv.resize(skin.view.tri.size());
    for (size_t t = 0; t < head.view.tri.size(); ++t)
      both->view.uv.push_back(head.view.uv.size() == head.view.tri.size() ? head.view.uv[t]
                                                                          : std::array<Eigen::Vector2f, 3>{});
  }
  if (!skin.rgba.empty() || !head.rgba.empty()) {
    both->rgba.resize(skin.view.X_mm.size());
    both->rgba.insert(both->rgba.end(), head.rgba.begin(), head.rgba.end());
    both->rgba.resize(both->view.X_mm.size());
  }
  for (const auto& [a, b] : head.strand) both->strand.push_back({a + base, b + base});
  both->landmark = head.landmark;
  return both;
}

}  // namespace

std::shared_ptr<const SurfaceTopology> JoinedSurface::of(const std::shared_ptr<const SurfaceTopology>& skin,
                                                         const std::shared_ptr<const SurfaceTopology>& head) {
  if (skin != skin_ || head != head_) skin_ = skin, head_ = head, both_ = joined(*skin, *head, ++version_);
  return both_;
}

void JoinedSurface::append(Snapshot& s, const Snapshot& head, const std::shared_ptr<const SurfaceTopology>& both) {
  const size_t n = s.x_mm.size();
  s.x_mm.insert(s.x_mm.end(), head.x_mm.begin(), head.x_mm.end());
  if (!s.field.empty()) s.field.resize(s.x_mm.size(), 0.0f);
  s.moved_mm.clear();
  if (!head.moved_mm.empty())
    s.moved_mm.assign(n, 0.0f), s.moved_mm.insert(s.moved_mm.end(), head.moved_mm.begin(), head.moved_mm.end());
  s.plate_mm = head.plate_mm;
  s.landmark_mm = head.landmark_mm;
  s.figures = head.figures;
  s.residual = std::max(s.residual, head.residual);
  s.topology = both;
  s.topology_version = both->version;
}

}  // namespace limberg
