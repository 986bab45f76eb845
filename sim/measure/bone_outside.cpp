#include "sim/measure/bone_outside.h"

#include <map>
#include <memory>

#include "sim/body/body.h"
#include "sim/body/skin.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

// The face as a body whose whole surface is skin: what tells its outer side.
class FaceSurface {
 public:
  FaceSurface(const SurfaceTopology& topology, std::vector<Vec3> places) {
    const SurfaceView& view = topology.view;
    auto body = std::make_shared<Body>();
    std::map<int32_t, int32_t> number;
    for (size_t t = 0; t < view.tri.size(); ++t) {
      if (topology.organ_of(t) != Organ::face) continue;
      Tri tri;
      for (size_t k = 0; k < 3; ++k) {
        const auto [at, fresh] = number.try_emplace(view.tri[t][k], int32_t(body->surface.X_mm.size()));
        if (fresh) body->surface.X_mm.push_back(places[size_t(view.tri[t][k])]);
        tri[k] = at->second;
      }
      body->surface.tri.push_back(tri);
      body->surface.tag.push_back(SurfaceTag::skin);
    }
    std::map<std::pair<int32_t, int32_t>, int> edges;
    for (const Tri& t : body->surface.tri)
      for (size_t k = 0; k < 3; ++k) ++edges[std::minmax(t[k], t[(k + 1) % 3])];
    border_.resize(body->surface.X_mm.size(), 0);
    for (const auto& [e, n] : edges)
      if (n == 1) border_[size_t(e.first)] = border_[size_t(e.second)] = 1;
    tri_ = body->surface.tri;
    skin_ = std::make_unique<Skin>(body);
  }

  bool empty() const { return tri_.empty(); }
  /// How far a place stands out; 0 where it does not, or where the face has ended.
  double outside_mm(const Vec3& x) const {
    const Bvh::Closest near = skin_->surface().closest(x);
    if (near.triangle < 0) return 0;
    for (size_t k = 0; k < 3; ++k)
      if (border_[size_t(tri_[size_t(near.triangle)][k])] && near.bary[k] > 0) return 0;
    return std::max(0.0, -skin_->depth_mm(x));
  }

 private:
  std::vector<Tri> tri_;
  std::vector<uint8_t> border_;
  std::unique_ptr<Skin> skin_;
};

}  // namespace

BoneOutside bone_outside(const Snapshot& snapshot) {
  BoneOutside out;
  if (!has_surface(snapshot)) return out;
  const SurfaceTopology& topology = *snapshot.topology;
  const SurfaceView& view = topology.view;
  if (topology.organ.empty()) return out;
  std::vector<Vec3> now;
  for (const Vec3f& x : snapshot.x_mm) now.push_back(x.cast<double>());
  const FaceSurface is(topology, now);
  if (is.empty()) return out;
  const FaceSurface was(topology, std::vector<Vec3>(view.X_mm.begin(), view.X_mm.end()));
  constexpr double kSame_mm = 0.1;  // a scan's own error; what stood out so little farther before stands as it did
  std::vector<float> depth(now.size(), -1);
  for (size_t t = 0; t < view.tri.size(); ++t) {
    const Organ o = topology.organ_of(t);
    if (o != Organ::bone && o != Organ::bone_cut) continue;
    bool all = true;
    for (const int32_t v : view.tri[t]) {
      float& d = depth[size_t(v)];
      if (d < 0) {
        d = float(is.outside_mm(now[size_t(v)]));
        if (d > 0 && double(d) <= was.outside_mm(view.X_mm[size_t(v)]) + kSame_mm) d = 0;
      }
      all &= d > 0;
      if (double(d) > out.depth_mm) {
        out.depth_mm = double(d), out.at_mm = now[size_t(v)];
        out.object = topology.object.empty() ? -1 : topology.object[t];
      }
    }
    if (all)
      out.area_mm2 +=
          0.5 *
          area_vector2(now[size_t(view.tri[t][0])], now[size_t(view.tri[t][1])], now[size_t(view.tri[t][2])]).norm();
  }
  return out;
}

}  // namespace limberg
