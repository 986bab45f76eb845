// How the face is told of bones: they have moved, they were cut or joined.
#include <algorithm>

#include "sim/base/error.h"
#include "sim/skull/face/face_parts.h"

namespace limberg::simplex {

void FaceModel::turn_as_one(const Mesh& bones, const Eigen::Isometry3d& by) {
  const Mat3 Q = by.linear();
  for (int32_t v = 0; v < face_.slots(); ++v)
    if (face_.alive(v))
      face_.x_mm[size_t(v)] = by * face_.x_mm[size_t(v)], face_.before_mm[size_t(v)] = by * face_.before_mm[size_t(v)];
  for (Region& r : region_) {
    Tissue& t = r.tissue;
    for (size_t v = 0; v < t.nbr.size(); ++v)
      t.x_mm[v] = by * t.x_mm[v], t.before_mm[v] = by * t.before_mm[v], t.turn[v] = Q * t.turn[v],
      t.bent_mm[v] = Q * t.bent_mm[v];
    for (std::vector<Foot>* feet : {&r.anchor, &r.under})
      for (Foot& f : *feet) carry(f, bones);
  }
  frame_ = by * frame_;
}

void FaceModel::follow(const Mesh& bones) {
  for (const Region& r : region_)
    for (const std::vector<Foot>* feet : {&r.anchor, &r.under})
      for (const Foot& f : *feet)
        for (int32_t v : f.at.skull)
          if (!bones.alive(v))
            throw InputError("", 0,
                             "tissue " + r.plan.name + " stands on vertex " + std::to_string(v) +
                                 " of the bones, which has gone; rebind was expected");
  Eigen::Isometry3d whole;
  const bool as_one = !bones_mm_.empty() && moved_as_one(bones_mm_, bones, whole);
  bones_mm_ = bones.x_mm;
  if (as_one) return turn_as_one(bones, whole);
  bool moved = false;
  size_t body = 0;
  const Eigen::Isometry3d back = frame_.inverse();
  for (Region& r : region_) {
    Tissue& t = r.tissue;
    const bool elastic = r.plan.mode == TissueKind::finite_elements;
    bool here = false;
    std::vector<Carry> by(r.foot.size());
    for (size_t k = 0; k < r.foot.size(); ++k) by[k] = carry(r.anchor[size_t(r.foot[k])], bones), here |= by[k].moved();
    if (elastic) {
      const size_t n = r.under.size();
      for (Foot& f : r.under) {
        const size_t i = size_t(f.at.vertex);
        const Carry c = carry(f, bones);
        if (!c.moved()) continue;
        here = true;
        for (size_t l = 0; l <= size_t(t.layers); ++l) {
          Vec3& u = u_mm_[size_t(elastic_->node(body, l * n + i))];
          const Vec3& X = t.node_mm[l * n + i];
          u = back * (l == 0 ? f.now_mm : c(frame_ * (X + u))) - X;
        }
      }
      ++body;
    }
    if (!here) continue;
    moved = true, simplex_rest_ = false;
    if (elastic) {
      elastic_rest_ = false;
      continue;
    }
    for (size_t v = 0; v < t.nbr.size(); ++v) {
      const Carry& c = by[size_t(r.column[v])];
      t.turn[v] = c.Q * t.turn[v];
      if (t.role[v] == TissueRole::face) continue;
      t.x_mm[v] = c(t.x_mm[v]), t.before_mm[v] = t.x_mm[v];
    }
    if (r.plan.mode == TissueKind::smoothing) continue;
    for (size_t k = 0; k < r.foot.size(); ++k) {
      Vec3& x = face_.x_mm[size_t(r.face_vertex[k])];
      x = by[k](x), face_.before_mm[size_t(r.face_vertex[k])] = x;
    }
    for (const auto& [v, f] : t.link) t.x_mm[size_t(v)] = t.before_mm[size_t(v)] = face_.x_mm[size_t(f)];
  }
  if (moved) at_rest_ = false, still_ = 0;
}

void FaceModel::rest_set_anew(std::span<const uint8_t> vertices, const Eigen::Isometry3d& by) {
  for (Region& r : region_)
    for (std::vector<Foot>* feet : {&r.anchor, &r.under})
      for (Foot& f : *feet) {
        const size_t v = size_t(f.at.skull[0]);
        if (v >= vertices.size() || !vertices[v]) continue;
        f.rest_mm = by * f.rest_mm;
        f.turn = f.turn * by.linear().transpose();
      }
}

void FaceModel::rebind(const Mesh& rest) {
  warnings_.clear();
  bones_mm_.clear();  // their numbers have changed
  if (region_.empty()) return;
  std::vector<int32_t> component;
  components(rest, component);
  const auto holds = [&](const Foot& f) {
    const BoneAnchor& a = f.at;
    return rest.alive(a.skull[0]) && rest.alive(a.skull[1]) && rest.alive(a.skull[2]) &&
           component[size_t(a.skull[0])] == component[size_t(a.skull[1])] &&
           component[size_t(a.skull[1])] == component[size_t(a.skull[2])] &&
           (place_of(a, rest) - f.rest_mm).norm() < 1e-9;
  };
  std::vector<Foot*> lost;
  for (Region& r : region_)
    for (std::vector<Foot>* feet : {&r.anchor, &r.under})
      for (Foot& f : *feet)
        if (!holds(f)) lost.push_back(&f);
  if (!lost.empty()) {
    // They stood along a cut: the bone near them is enough to find ground, unless it turns out to be farther than that.
    constexpr double kNear_mm = 12;
    Vec3 lo = lost[0]->rest_mm, hi = lo;
    for (const Foot* f : lost) lo = lo.cwiseMin(f->rest_mm), hi = hi.cwiseMax(f->rest_mm);
    const Standing near(rest, (lo.array() - kNear_mm).matrix(), (hi.array() + kNear_mm).matrix());
    std::unique_ptr<Standing> all;
    for (Foot* f : lost) {
      double far = near.stand(f->rest_mm, f->at);
      if (far < 0 || far > kNear_mm) {
        if (!all) all = std::make_unique<Standing>(rest, std::span<const int32_t>());
        far = all->stand(f->rest_mm, f->at);
      }
      if (far < 0) throw InputError("", 0, "there is no bone for the tissue to stand on");
      f->at.axes = f->turn * f->at.axes;
    }
  }
  for (Region& r : region_) {
    for (size_t i = 0; i < r.anchor.size(); ++i) r.tissue.anchor[i] = r.anchor[i].at;
    const int now = fragments_under(component, r.anchor);
    if (now > r.fragments)
      warnings_.push_back("tissue " + r.plan.name + " hangs on " + std::to_string(now) + " fragments now (" +
                          std::to_string(r.fragments) + " when it was made): a cut goes through its region");
  }
}

}  // namespace limberg::simplex
