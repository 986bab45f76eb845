#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/imaging/fit/fit_parts.h"

namespace limberg::imaging {

namespace {
constexpr double kGuided = 0.55;  // of the way: the guide leads, after it the volume itself
constexpr double kPush = 0.3, kFolded = 0.2;
// cosine: a normal that differs more than this says that the nearest point is of another sheet
constexpr double kFacing = 0.5;
constexpr size_t kTried = 32;   // points, until one looks to the side of the mesh
constexpr size_t kAround = 20;  // neighbours that say whether a point of a scan is at its edge
}  // namespace

/// Signed way along the normal to the nearest place where the volume falls through iso
/// outwards; false: none within range. Outside the volume nothing is known: no edge there,
/// nor across its border. Edges deep below the sealed surface (the inner table, the wall of
/// a sinus) belong to another surface, those far outside it to a part that was left out.
bool VolumeSight::edge(const Vec3& x, const Vec3& n, double range, double& at) const {
  const double h = 0.5 * p_.voxel_mm, deep = -(2 * p_.voxel_mm + p_.guide_mm);
  const auto known = [&](const Vec3& p, double& f) {
    if (!volume_.inside(p)) return false;
    f = volume_.value(p) - p_.iso;
    return true;
  };
  const auto outer = [&](double t) {
    const double g = guide_.value(x + t * n);
    return g >= deep && g <= -deep;
  };
  double out = 0, in = 0, f = 0;
  bool out_known = known(x, out), in_known = out_known;
  in = out;
  for (double t = 0; t < range; t += h) {
    bool k = known(x + (t + h) * n, f);
    if (k && out_known && out >= 0 && f < 0 && outer(t + h * out / (out - f))) {
      at = t + h * out / (out - f);
      return at <= range;
    }
    out = f, out_known = k;
    k = known(x - (t + h) * n, f);
    if (k && in_known && f >= 0 && in < 0 && outer(-(t + h * in / (in - f)))) {
      at = -(t + h * in / (in - f));
      return -at <= range;
    }
    in = f, in_known = k;
  }
  return false;
}

/// By the guide: phi is the distance to the sealed surface and g its direction. What lies along the normal is (g . N)
/// phi, which never leads away from the surface, not even where the mesh is folded over. In the mouth of a cavity g
/// lies across the normal, or nowhere: there the mesh is pushed in (kPush) as long as it looks outwards.
Vec3 VolumeSight::pull(const Vec3& x, const Vec3& N, double t, double range, bool& seen) const {
  const double near = 2 * p_.voxel_mm, phi = guide_.value(x);
  const Vec3 slope = guide_.gradient(x);
  const double across = slope.norm() > 0.1 ? slope.normalized().dot(N) : 0;
  double at = 0;
  seen = false;
  if (t >= kGuided && across > -kFolded && edge(x, N, near * (t < 1 ? 2 - t : 1), at)) {
    seen = true;
    return at * N;
  }
  if (t >= kGuided && volume_.inside(x) && !at_gate(x)) {
    // Beside the surface, but not across from it (at a rim, in a fold): to its nearest place, sideways too.
    // On a thin wall there is none: its own places are the nearest, and the guide leads.
    const PointTree::Nearest place = tree_.nearest(x, 2 * near);
    if (place.index >= 0 && !on_wall(x)) {
      seen = place.distance <= p_.voxel_mm;
      return tree_.point(place.index) - x;
    }
  }
  const double most = t < kGuided ? range : near;
  return -std::clamp(phi, -most, most) * (across > -kFolded ? std::max(across, kPush) : across) * N;
}

bool VolumeSight::on_wall(const Vec3& x) const {
  const double way = walls_.nearest(x, 2 * p_.voxel_mm).distance;
  return std::isfinite(way) && way < tree_.nearest(x, way).distance;
}

Vec3 VolumeSight::home(const Vec3& x, double most) const {
  const Vec3 slope = guide_.gradient(x);
  const double g = slope.norm();
  return g > 0.1 ? Vec3(-std::clamp(guide_.value(x), -most, most) / g * slope) : Vec3(Vec3::Zero());
}

double VolumeSight::distance(const Vec3& x, const Vec3& way) const {
  // (`way` may lead sideways: it is the distance to a place of the surface in any case.)
  const double g = volume_.gradient(x).norm(), f = std::abs(volume_.value(x) - p_.iso);
  // Where the volume is flat the first order says nothing: then the way along the normal.
  return std::min(g > 0 ? f / g : 1e300, way.norm());
}

int VolumeSight::border(const Vec3& x, double within, Vec3& outward, double& way) const {
  const Vec3 q = to_voxel_ * (x - p_.volume.origin_mm);
  int best = -1;
  double least = within;
  for (int k = 0; k < 3; ++k)
    for (int s = 0; s < 2; ++s) {
      const double step = p_.volume.step_mm.col(k).norm(),
                   inner = (s ? p_.volume.size[size_t(k)] - 1 - q[k] : q[k]) * step;
      if (inner > least) continue;
      // Outward normal of that border: along the reciprocal axis.
      least = inner, best = 2 * k + s, way = inner - 0.02 * step;
      outward = (s ? 1. : -1.) * to_voxel_.row(k).transpose().normalized();
    }
  return best;
}

PointSight::PointSight(const std::vector<Vec3>& points, const ScanView* plane, const std::vector<Vec3>& looks)
    : points_(points), looks_(looks), tree_(points) {
  Vec3 lo = points.front(), hi = lo;
  for (const Vec3& p : points) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
  size_ = (hi - lo).norm();
  spacing_ = std::max(spacing_of(points), 1e-6 * size_);
  around_ = spacings_of(tree_);
  if (!plane) return;
  heights_.emplace(points, *plane, 1.5 * spacing_);
  std::vector<Vec3> edge, around;
  std::vector<PointTree::Nearest> near;
  for (const Vec3& p : points) {
    tree_.nearest(p, kAround, near);
    around.clear();
    for (const PointTree::Nearest& n : near) around.push_back(tree_.point(n.index));
    Vec3 gap;
    if (at_edge(p, around, gap)) edge.push_back(p);
  }
  edge_ = PointTree(edge);
}

Vec3 PointSight::pull(const Vec3& x, const Vec3& N, double t, double range, bool& seen) const {
  seen = false;
  if (heights_ && t < kGuided) {
    // As by the guide of a volume: the way along the normal, and down while it is folded over. Before a steep wall the
    // heights say too much: it is never farther than to the nearest point.
    const Vec3 q = heights_->view().local(x);
    const double most = std::min(range, tree_.nearest(x).distance);
    return std::clamp((heights_->at(q) - q.z()) * std::max(heights_->view().front.dot(N), kPush), -most, most) * N;
  }
  PointTree::Nearest n = tree_.nearest(x);
  if (!looks_.empty() && looks_[size_t(n.index)].dot(N) < 0) {
    // The other side of a thin wall is nearer: it belongs to another sheet.
    std::vector<PointTree::Nearest> near;
    tree_.nearest(x, kTried, near);
    for (const PointTree::Nearest& o : near)
      if (looks_[size_t(o.index)].dot(N) > 0) {
        n = o;
        break;
      }
  }
  const Vec3 to = tree_.point(n.index) - x;
  const double D = size_ * (0.2 + t * (0.08 - 0.2)), G = n.distance < D ? 1 : (D / n.distance) * (D / n.distance);
  const double along = to.dot(N), beside = (to - along * N).norm();
  seen = n.distance <= 2 * spacing_ || (beside <= around_[size_t(n.index)] && std::abs(along) <= 2 * spacing_);
  return std::clamp(G * along, -range, range) * N;
}

Vec3 PointSight::to_edge(const Vec3& x) const {
  const PointTree::Nearest n = edge_.nearest(x, 6 * spacing_);
  return n.index < 0 ? Vec3(Vec3::Zero()) : Vec3(edge_.point(n.index) - x);
}

Vec3 PointSight::onwards(const Vec3& x, const Vec3& N, const Vec3& out, const std::vector<int32_t>& left) const {
  if (heights_) return Vec3::Zero();
  const auto here = size_t(tree_.nearest(x).index);
  const double step = std::max(spacing_, around_[here]);
  // A rim that has folded in does not look ahead: where the points say
  // which way they look, it goes to the nearest that look as those here do.
  const bool known = !looks_.empty() && looks_[here].dot(N) > -kFacing;
  double least = known ? 3 * step : 1.5 * step;
  Vec3 way = Vec3::Zero();
  for (const int32_t i : left) {
    const Vec3 to = points_[size_t(i)] - x;
    if (!looks_.empty() && looks_[size_t(i)].dot(known ? looks_[here] : N) <= 0) continue;
    const double away = (known ? to : Vec3(to - 2 * step * out)).norm();
    if (away < least) least = away, way = to;
  }
  return way;
}

bool PointSight::lost(const Vec3& x, bool seen) const {
  if (!seen) return true;
  const PointTree::Nearest n = tree_.nearest(x);
  return n.distance > elementary::hypot(2 * spacing_, around_[size_t(n.index)]);
}

double PointSight::distance(const Vec3&, const Vec3& way) const { return way.norm(); }

}  // namespace limberg::imaging
