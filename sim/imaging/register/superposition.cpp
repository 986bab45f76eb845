#include "sim/imaging/register/superposition.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/geometry/rotation.h"

namespace limberg {

Vec3 middle_of(const std::vector<Vec3>& x) {
  Vec3 m = Vec3::Zero();
  for (const Vec3& p : x) m += p / double(x.size());
  return m;
}

namespace {

constexpr double kLooksAlong = -0.08;  // cosine, to an axis, of what counts as looking along it
constexpr size_t kNeighbours = 12;     // of a point, for its plane
constexpr size_t kFewest = 10;         // points that say something of a shape: six unknowns, and some to spare
constexpr double kLine = 0.02;         // of the longest spread: less across it is a line
constexpr double kPolish_mm = 0.02;    // a motion below it: the trimmed pairs have brought the surfaces together
constexpr double kGain = 1e-4;         // of the root mean square: less is none

Mat3 spread_of(const std::vector<Vec3>& x, const Vec3& m) {
  Mat3 S = Mat3::Zero();
  for (const Vec3& p : x) S += (p - m) * (p - m).transpose() / double(x.size());
  return S;
}

/// How far points spread about their middle, root of the mean
/// square, along the two directions in which they do so most.
struct Spreads {
  double largest = 0, second = 0;
};

Spreads spreads_of(const std::vector<Vec3>& x, const Vec3& middle) {
  const Eigen::SelfAdjointEigenSolver<Mat3> e(spread_of(x, middle));
  return {std::sqrt(std::max(0., e.eigenvalues()[2])), std::sqrt(std::max(0., e.eigenvalues()[1]))};
}

Mat3 rotation_of(const Vec3& w) {
  const double a = w.norm();
  return a > 1e-12 ? rotation(a, w / a) : Mat3::Identity();
}

}  // namespace

double Similarity::angle_deg() const {
  return elementary::acos(std::clamp(0.5 * ((R.determinant() < 0 ? -R : R).trace() - 1), -1., 1.)) * 180 /
         3.14159265358979323846;
}

LandmarkFit fit_landmarks(const std::vector<Vec3>& from, const std::vector<Vec3>& to, bool with_scale) {
  LandmarkFit out;
  if (from.size() != to.size())
    out.reason = "the two sides have " + std::to_string(from.size()) + " and " + std::to_string(to.size()) +
                 " landmarks; pairs were expected";
  else if (from.size() < 3)
    out.reason =
        "there are " + std::to_string(from.size()) + " pairs of landmarks; at least 3, not on a line, were expected";
  for (size_t i = 0; out && i < from.size(); ++i)
    if (!from[i].allFinite() || !to[i].allFinite())
      out.reason = "landmark " + std::to_string(i + 1) + " is not at a finite place";
  if (!out) return out;
  const Vec3 a = middle_of(from), b = middle_of(to);
  const double n = double(from.size());
  for (const auto* side : {&from, &to}) {
    const Spreads e = spreads_of(*side, side == &from ? a : b);
    if (!(e.largest > 1e-9))
      out.reason = "the landmarks lie at one place";
    else if (e.second < kLine * e.largest)
      out.reason = "the landmarks lie on a line: the turn about it is not known; expected one well beside it";
    if (!out) return out;
  }
  const auto columns = [](const std::vector<Vec3>& x) {
    return Eigen::Map<const Eigen::Matrix3Xd>(x[0].data(), 3, Eigen::Index(x.size()));
  };
  const Mat3 scaled = Eigen::umeyama(columns(from), columns(to), with_scale).topLeftCorner<3, 3>();
  if (with_scale) out.map.scale = elementary::cbrt(scaled.determinant());
  out.map.R = scaled / out.map.scale;
  out.map.t_mm = b - out.map.scale * (out.map.R * a);
  for (size_t i = 0; i < from.size(); ++i) {
    const double d = (out.map(from[i]) - to[i]).norm();
    out.rms_mm += d * d / n, out.max_mm = std::max(out.max_mm, d);
  }
  out.rms_mm = std::sqrt(out.rms_mm);
  return out;
}

std::string lacks_shape(const Surface& s) {
  if (s.x_mm.size() < kFewest)
    return "has " + std::to_string(s.x_mm.size()) + " points; at least " + std::to_string(kFewest) + " were expected";
  const Spreads e = spreads_of(s.x_mm, middle_of(s.x_mm));
  if (!(e.largest > 1e-9)) return "has all its points at one place; a surface was expected";
  if (e.second < kLine * e.largest) return "has all its points on a line, or nearly; a surface was expected";
  const auto has_area = [&](const Tri& t) {
    const Vec3 &a = s.x_mm[size_t(t[0])], &b = s.x_mm[size_t(t[1])], &c = s.x_mm[size_t(t[2])];
    return (b - a).cross(c - a).norm() > 1e-12 * e.largest * e.largest;
  };
  if (!s.tri.empty() && std::none_of(s.tri.begin(), s.tri.end(), has_area))
    return "has no triangle with an area; at least one, or points alone, were expected";
  return {};
}

SurfaceTarget::SurfaceTarget(const Surface& s, bool by_side)
    : tri_(s.tri), normal_(s.x_mm.size(), Vec3::Zero()), rim_(s.x_mm.size(), 0) {
  if (s.x_mm.empty()) throw InputError("", 0, "a surface without points cannot be laid upon");
  if (tri_.empty()) {
    tree_ = PointTree(s.x_mm);
    std::vector<PointTree::Nearest> near;
    for (size_t i = 0; i < s.x_mm.size(); ++i) {
      tree_.nearest(s.x_mm[i], kNeighbours, near);
      std::vector<Vec3> x;
      for (const auto& p : near) x.push_back(s.x_mm[size_t(p.index)]);
      const Eigen::SelfAdjointEigenSolver<Mat3> e(spread_of(x, middle_of(x)));
      normal_[i] = e.eigenvectors().col(0);
    }
    return;
  }
  bvh_ = Bvh(s.x_mm, tri_);
  std::vector<std::pair<int32_t, int32_t>> edge;
  for (const Tri& t : tri_) {
    const Vec3 n = (s.x_mm[size_t(t[1])] - s.x_mm[size_t(t[0])]).cross(s.x_mm[size_t(t[2])] - s.x_mm[size_t(t[0])]);
    const double l = n.norm();
    const Vec3 u = l > 0 ? Vec3(n / l) : Vec3(Vec3::Zero());
    face_normal_.push_back(u);
    for (size_t k = 0; k < 3; ++k) {
      const Vec3 p = (s.x_mm[size_t(t[(k + 1) % 3])] - s.x_mm[size_t(t[k])]).normalized(),
                 q = (s.x_mm[size_t(t[(k + 2) % 3])] - s.x_mm[size_t(t[k])]).normalized();
      if (l > 0) normal_[size_t(t[k])] += elementary::acos(std::clamp(p.dot(q), -1., 1.)) * u;
      edge.emplace_back(std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3]));
    }
  }
  for (size_t side = 0; by_side && side < side_.size(); ++side) {
    std::vector<int32_t> those;
    for (size_t i = 0; i < tri_.size(); ++i)
      if ((side % 2 == 0 ? 1 : -1) * face_normal_[i][Eigen::Index(side / 2)] > kLooksAlong) those.push_back(int32_t(i));
    if (!those.empty()) side_[side] = Bvh(s.x_mm, tri_, those);  // an empty list would mean all
  }
  for (Vec3& n : normal_)
    if (const double l = n.norm(); l > 0) n /= l;
  std::sort(edge.begin(), edge.end());
  for (size_t i = 0; i < edge.size();) {
    size_t j = i;
    while (j < edge.size() && edge[j] == edge[i]) ++j;
    if (j - i == 1) rim_[size_t(edge[i].first)] = rim_[size_t(edge[i].second)] = 1;
    i = j;
  }
}

SurfaceTarget::Place SurfaceTarget::closest(const Vec3& x) const {
  if (!cloud()) return place_of(bvh_.closest(x));
  const PointTree::Nearest n = tree_.nearest(x);
  Place p;
  p.point_mm = tree_.point(n.index), p.normal = normal_[size_t(n.index)], p.distance_mm = n.distance;
  return p;
}

bool SurfaceTarget::closest_facing(const Vec3& x, const Vec3& normal, double far_mm, Place& place) const {
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const Bvh& side = side_[2 * size_t(axis) + (normal[axis] < 0)];
  if (side.empty()) return false;
  const Bvh::Closest c = side.closest(x, far_mm);
  if (c.triangle < 0) return false;
  place = place_of(c);
  return true;
}

SurfaceTarget::Place SurfaceTarget::place_of(const Bvh::Closest& c) const {
  Place p;
  const Tri& t = tri_[size_t(c.triangle)];
  p.point_mm = c.point_mm, p.distance_mm = c.distance_mm;
  int zeros = 0;
  Vec3 blend = Vec3::Zero();
  bool rim = true;
  for (size_t k = 0; k < 3; ++k) {
    zeros += c.bary[k] == 0;
    blend += c.bary[k] * normal_[size_t(t[k])];
    rim &= c.bary[k] == 0 || rim_[size_t(t[k])];
  }
  p.border = zeros > 0 && rim;
  p.normal = zeros == 0 || !(blend.norm() > 0) ? face_normal_[size_t(c.triangle)] : Vec3(blend.normalized());
  return p;
}

IcpResult icp(const Surface& moved, const SurfaceTarget& target, const Similarity& start, const IcpSettings& s,
              Workers& workers) {
  IcpResult r;
  r.map = start;
  if (!(s.keep > 0 && s.keep <= 1) || s.iterations < 1 || s.samples < 1)
    throw InputError("", 0, "a superposition keeps a share above 0 and at most 1 of the pairs");
  const size_t every = std::max<size_t>(1, (moved.x_mm.size() + size_t(s.samples) - 1) / size_t(s.samples));
  std::vector<Vec3> x;
  for (size_t i = 0; i < moved.x_mm.size(); i += every) x.push_back(moved.x_mm[i]);
  if (x.size() < kFewest) {
    r.reason = "the surface has " + std::to_string(x.size()) + " points; at least " + std::to_string(kFewest) +
               " were expected";
    return r;
  }
  struct Pair {
    SurfaceTarget::Place to;
    Vec3 at;
  };
  std::vector<Pair> pair(x.size());
  std::vector<size_t> order;
  bool polish = false;
  double least = std::numeric_limits<double>::infinity();
  int gained = 0;  // the iteration in which it was found
  for (r.iterations = 0; r.iterations < s.iterations && !r.still; ++r.iterations) {
    workers.parallel_for(x.size(), 256, [&](size_t b, size_t e) {
      for (size_t i = b; i < e; ++i) pair[i].at = r.map(x[i]), pair[i].to = target.closest(pair[i].at);
    });
    order.clear();
    for (size_t i = 0; i < x.size(); ++i)
      if (!pair[i].to.border) order.push_back(i);
    const size_t keep = std::min(order.size(), std::max<size_t>(6, size_t(s.keep * double(x.size()))));
    if (keep < kFewest) {
      r.reason =
          "hardly any place of the surface faces the other one; expected them to overlap (landmarks bring them near)";
      return r;
    }
    std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
      return pair[a].to.distance_mm != pair[b].to.distance_mm ? pair[a].to.distance_mm < pair[b].to.distance_mm : a < b;
    });
    size_t count = keep;
    if (polish && s.keep < 1) {
      // Robust standard deviation: 1.4826 medians of the sizes, along the normals.
      std::vector<double> away;
      for (const size_t i : order) away.push_back(std::abs(pair[i].to.normal.dot(pair[i].to.point_mm - pair[i].at)));
      std::nth_element(away.begin(), away.begin() + ptrdiff_t(away.size() / 2), away.end());
      const double most = 3 * 1.4826 * away[away.size() / 2];
      while (count < order.size() && pair[order[count]].to.distance_mm <= most) ++count;
    }
    order.resize(count);
    Vec3 c = Vec3::Zero();
    for (const size_t i : order) c += pair[i].at / double(order.size());
    double size2 = 0;
    for (const size_t i : order) size2 += (pair[i].at - c).squaredNorm() / double(order.size());
    const double size = std::sqrt(std::max(size2, 1e-12));
    // Unknowns: turn about c (times size, so that all are lengths), shift, growth (times size).
    Eigen::Matrix<double, 7, 7> A = Eigen::Matrix<double, 7, 7>::Zero();
    Eigen::Matrix<double, 7, 1> g = Eigen::Matrix<double, 7, 1>::Zero();
    double sum = 0;
    for (const size_t i : order) {
      const Vec3 p = pair[i].at - c, n = pair[i].to.normal;
      const double d = n.dot(pair[i].to.point_mm - pair[i].at);
      Eigen::Matrix<double, 7, 1> row;
      row << p.cross(n) / size, n, n.dot(p) / size;
      A += row * row.transpose(), g += d * row, sum += d * d;
    }
    r.rms_mm = std::sqrt(sum / double(order.size()));
    if (r.rms_mm < (1 - kGain) * least)
      least = r.rms_mm, gained = r.iterations;
    else if (polish && s.patience > 0 && r.iterations - gained >= s.patience)
      break;
    const int unknowns = s.with_scale ? 7 : 6;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eig(A.topLeftCorner(unknowns, unknowns));
    const Eigen::VectorXd& l = eig.eigenvalues();
    if (!(l[0] > 1e-7 * l[unknowns - 1])) {
      r.reason =
          "the surfaces let each other slip (a plane, a ball or a cylinder); expected shapes that hold, or landmarks "
          "alone";
      return r;
    }
    const Eigen::VectorXd u = eig.eigenvectors() * (eig.eigenvectors().transpose() * g.head(unknowns)).cwiseQuotient(l);
    Similarity step;
    step.scale = s.with_scale ? std::clamp(1 + u[6] / size, 0.8, 1.25) : 1;
    step.R = rotation_of(u.head<3>() / size);
    step.t_mm = c + u.segment<3>(3) - step.scale * (step.R * c);
    r.map = step * r.map;
    double move = 0;
    for (size_t i = 0; i < x.size(); i += 16) move = std::max(move, (r.map(x[i]) - pair[i].at).norm());
    r.still = polish && move < s.still_mm;
    polish |= move < kPolish_mm || r.iterations > s.iterations / 3;
  }
  // Rounding of many products.
  const Eigen::JacobiSVD<Mat3> svd(r.map.R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  r.map.R = svd.matrixU() * svd.matrixV().transpose();
  return r;
}

IcpResult icp_from_anywhere(const Surface& moved, const SurfaceTarget& target, const Surface& onto,
                            const IcpSettings& s, Workers& workers) {
  if (moved.x_mm.empty() || onto.x_mm.empty()) return {{}, 0, 0, false, "a surface has no points"};
  const Vec3 a = middle_of(moved.x_mm), b = middle_of(onto.x_mm);
  std::vector<Similarity> start(2);
  start[1].t_mm = b - a;
  Mat3 A = Eigen::SelfAdjointEigenSolver<Mat3>(spread_of(moved.x_mm, a)).eigenvectors(),
       B = Eigen::SelfAdjointEigenSolver<Mat3>(spread_of(onto.x_mm, b)).eigenvectors();
  if (A.determinant() < 0) A.col(2) = -A.col(2);
  if (B.determinant() < 0) B.col(2) = -B.col(2);
  for (const Vec3& flip : {Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)}) {
    Similarity q;
    q.R = B * flip.asDiagonal() * A.transpose(), q.t_mm = b - q.R * a;
    start.push_back(q);
  }
  IcpSettings quick = s;
  quick.iterations = 30, quick.samples = std::min(s.samples, 1000);
  IcpResult best;
  best.reason = "nothing was tried";
  for (const Similarity& q : start) {
    const IcpResult r = icp(moved, target, q, quick, workers);
    if (r && (!best || r.rms_mm < best.rms_mm))
      best = r;
    else if (!best)
      best.reason = r.reason;
  }
  return best ? icp(moved, target, best.map, s, workers) : best;
}

MirrorPlane mirror_plane(const Surface& surface, const Vec3& guess, const IcpSettings& s, Workers& workers) {
  MirrorPlane out;
  if (!guess.allFinite() || !(guess.norm() > 0))
    throw InputError("", 0, "the first guess of a mirror plane needs a normal");
  const Vec3 m = middle_of(surface.x_mm), n = guess.normalized();
  Similarity flip;
  flip.R = Mat3::Identity() - 2 * n * n.transpose(), flip.t_mm = m - flip.R * m;
  Surface other = surface;
  for (Vec3& x : other.x_mm) x = flip(x);
  for (Tri& t : other.tri) std::swap(t[1], t[2]);
  const SurfaceTarget target(surface);
  const IcpResult r = icp(other, target, {}, s, workers);
  if (!r) {
    out.reason = r.reason;
    return out;
  }
  out.map = r.map * flip, out.rms_mm = r.rms_mm;
  // A reflection with a glide and a small turn about the normal:
  // the plane's normal is what is most nearly turned round.
  const Eigen::SelfAdjointEigenSolver<Mat3> e(0.5 * (out.map.R + out.map.R.transpose()));
  out.normal = e.eigenvectors().col(0);
  if (out.normal.dot(n) < 0) out.normal = -out.normal;
  out.point_mm = 0.5 * (m + out.map(m));
  return out;
}

DistanceMap distance_map(const Surface& surface, const Similarity& map, const SurfaceTarget& target, Workers& workers) {
  DistanceMap out;
  out.signed_mm.resize(surface.x_mm.size());
  workers.parallel_for(surface.x_mm.size(), 256, [&](size_t b, size_t e) {
    for (size_t i = b; i < e; ++i) {
      const Vec3 x = map(surface.x_mm[i]);
      const SurfaceTarget::Place p = target.closest(x);
      out.signed_mm[i] = !target.cloud() && (x - p.point_mm).dot(p.normal) < 0 ? -p.distance_mm : p.distance_mm;
    }
  });
  std::vector<double> size;
  const double n = double(std::max<size_t>(1, out.signed_mm.size()));
  for (const double d : out.signed_mm)
    out.mean_mm += d / n, out.mean_abs_mm += std::abs(d) / n, out.rms_mm += d * d / n, size.push_back(std::abs(d));
  out.rms_mm = std::sqrt(out.rms_mm);
  std::sort(size.begin(), size.end());
  if (!size.empty()) out.p95_mm = size[std::min(size.size() - 1, size.size() * 95 / 100)], out.max_mm = size.back();
  return out;
}

}  // namespace limberg
