#include "sim/imaging/io/scan_view.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/geometry/bvh.h"
#include "sim/skull/simplex/generators.h"

namespace limberg {

namespace {
constexpr double kMargin = 0.12;  // of the scan's larger half side: how far the sheet reaches beyond it
// of the whole area: triangles that look less to one side than this do not say where the front is
constexpr double kLooking = 0.05;
// of the edges: with more that both sides run along alike, triangles do not say which side is out
constexpr double kTwisted = 0.01;
constexpr double kGap = 2.0943951;  // 120 degrees
// times the silhouette along the axis of least spread: then it is seen along another axis
constexpr double kLarger = 1.05;
constexpr int kCells = 512;
constexpr int kHidden = 10;    // of 13 directions
constexpr double kOwn = 1e-3;  // of the scan's size: nearer than this a place meets its own triangles
constexpr double kColumn = 0.6,
                 kLayers = 4;  // spacings: radius of a column of points, and the gap in it that parts two layers
constexpr size_t kFourth = 5;  // a point and its four nearest
constexpr size_t kVoters = 9;  // a point and its eight nearest

/// Right-handed, least spread last.
void principal_axes(const Mat3& spread, Vec3& across, Vec3& up, Vec3& front) {
  const Eigen::SelfAdjointEigenSolver<Mat3> e(spread);
  front = e.eigenvectors().col(0), up = e.eigenvectors().col(2), across = up.cross(front);
}
}  // namespace

Vec2 ScanView::sheet_mm() const {
  const double more = kMargin * std::max(half_mm.x(), half_mm.y());
  return {half_mm.x() + more, half_mm.y() + more};
}

namespace {

/// Least spread, most spread and the third, and the middle; by area where there are triangles.
struct Spread {
  std::vector<Vec3> at;      // what counts: centres of triangles by area, or points
  std::vector<double> much;  // sum 1
  Vec3 mean = Vec3::Zero(), looks = Vec3::Zero(), axis[3];
};

Spread spread_of(const std::vector<Vec3>& points, const std::vector<Tri>& tri) {
  Spread s;
  double weight = 0;
  for (const Tri& t : tri) {
    const Vec3 &a = points[size_t(t[0])], &b = points[size_t(t[1])], &c = points[size_t(t[2])];
    const Vec3 area = 0.5 * (b - a).cross(c - a);
    s.at.push_back((a + b + c) / 3), s.much.push_back(area.norm());
    s.looks += area, weight += area.norm();
  }
  if (weight > 0)
    s.looks /= weight;
  else
    s.at = points, s.much.assign(points.size(), 1), weight = double(points.size());
  Mat3 spread = Mat3::Zero();
  for (double& w : s.much) w /= weight;
  for (size_t i = 0; i < s.at.size(); ++i) s.mean += s.much[i] * s.at[i];
  for (size_t i = 0; i < s.at.size(); ++i) spread += s.much[i] * (s.at[i] - s.mean) * (s.at[i] - s.mean).transpose();
  if (!(spread.trace() > 0)) throw InputError("", 0, "all points of the scan are the same");
  const Eigen::SelfAdjointEigenSolver<Mat3> e(spread);
  for (int k = 0; k < 3; ++k) s.axis[k] = e.eigenvectors().col(k);
  return s;
}

/// On which side of an axis the front is: where the triangles look to, else where it bulges: what is in the middle is
/// higher than what is at the edge.
double side_of(const Spread& s, const Vec3& front) {
  if (std::abs(s.looks.dot(front)) > kLooking) return s.looks.dot(front);
  double r_mean = 0, side = 0;
  for (size_t i = 0; i < s.at.size(); ++i)
    r_mean += s.much[i] * ((s.at[i] - s.mean).squaredNorm() - elementary::pow(front.dot(s.at[i] - s.mean), 2));
  for (size_t i = 0; i < s.at.size(); ++i) {
    const double h = front.dot(s.at[i] - s.mean);
    side += s.much[i] * h * (r_mean + h * h - (s.at[i] - s.mean).squaredNorm());
  }
  return side;
}

ScanView view_along(const std::vector<Vec3>& points, const Spread& s, const Vec3& front, const Vec3& up) {
  ScanView v;
  v.front = front.normalized();
  v.up = (up - up.dot(v.front) * v.front).normalized(), v.across = v.up.cross(v.front);
  v.middle_mm = s.mean;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Vec3& x : points) low = low.cwiseMin(v.local(x)), high = high.cwiseMax(v.local(x));
  v.middle_mm = v.place(0.5 * (low + high));
  v.half_mm = 0.5 * (high - low);
  return v;
}

/// How many square cells of that side the scan covers.
double silhouette(const std::vector<Vec3>& points, const ScanView& v, double cell) {
  if (!(cell > 0)) return 1;
  std::vector<std::pair<int64_t, int64_t>> at;
  for (const Vec3& x : points) {
    const Vec3 q = v.local(x);
    at.emplace_back(int64_t(std::floor(q.x() / cell)), int64_t(std::floor(q.y() / cell)));
  }
  std::sort(at.begin(), at.end());
  return double(std::unique(at.begin(), at.end()) - at.begin());
}

}  // namespace

ScanView view_of(const std::vector<Vec3>& points, const std::vector<Tri>& tri, const Vec3& from) {
  if (!from.allFinite()) throw InputError("", 0, "the side that the scan is seen from must be a finite direction");
  if (points.size() < 3) throw InputError("", 0, "a range scan of at least 3 points was expected");
  for (const Vec3& x : points)
    if (!x.allFinite()) throw InputError("", 0, "a point of the scan is not at a finite place");
  const Spread s = spread_of(points, tri);
  const auto up_of = [&](const Vec3& front) {
    return std::abs(s.axis[2].dot(front)) < 0.9 * front.norm() ? s.axis[2] : s.axis[1];
  };
  if (from != Vec3::Zero()) return view_along(points, s, from, up_of(from));
  // Where its silhouette is largest: across the least spread,
  // but for a face from ear to ear, which is deeper than wide.
  const double cell = 1.5 * spacing_of(points);
  ScanView best;
  double most = 0;
  for (const Vec3& axis : s.axis) {
    const ScanView v = view_along(points, s, side_of(s, axis) < 0 ? Vec3(-axis) : axis, up_of(axis));
    const double area = silhouette(points, v, cell);
    if (most == 0 || area > kLarger * most) best = v, most = area;
  }
  return best;
}

double spacing_of(const std::vector<Vec3>& points) {
  if (points.empty()) return 0;
  const PointTree tree(points);
  std::vector<double> d;
  std::vector<PointTree::Nearest> n;
  const size_t every = std::max<size_t>(1, points.size() / 2000);
  for (size_t i = 0; i < points.size(); i += every) {
    tree.nearest(points[i], kFourth, n);
    d.push_back(n.back().distance);
  }
  std::nth_element(d.begin(), d.begin() + ptrdiff_t(d.size() / 2), d.end());
  return d[d.size() / 2];
}

std::vector<double> spacings_of(const PointTree& points) {
  std::vector<double> own(points.size()), out(points.size()), around;
  std::vector<PointTree::Nearest> n;
  for (size_t i = 0; i < own.size(); ++i) {
    points.nearest(points.point(int32_t(i)), kFourth, n);
    own[i] = n.back().distance;
  }
  for (size_t i = 0; i < own.size(); ++i) {
    points.nearest(points.point(int32_t(i)), kVoters, n);
    around.clear();
    for (const PointTree::Nearest& o : n) around.push_back(own[size_t(o.index)]);
    std::nth_element(around.begin(), around.begin() + ptrdiff_t(around.size() / 2), around.end());
    out[i] = around[around.size() / 2];
  }
  return out;
}

std::vector<Vec3> seen_from_front(const std::vector<Vec3>& points, const std::vector<Tri>& tri, const ScanView& view) {
  const double spacing = spacing_of(points);
  if (!(spacing > 0)) return points;
  std::vector<uint8_t> hidden(points.size(), 0);
  if (!tri.empty()) {
    const Bvh bvh(points, tri);
    Bvh::LineHit hit[1];
    for (size_t i = 0; i < points.size(); ++i)
      hidden[i] = bvh.line(points[i], view.front, spacing, 4 * view.half_mm.norm(), hit) > 0;
  } else {
    // By columns: the points of a square cell and of those around it are
    // sorted by height once, and looked through for each of its points.
    const double r = kColumn * spacing;
    struct Placed {
      int64_t i, j;
      double h;
      size_t point;
    };
    std::vector<Placed> at(points.size());
    for (size_t p = 0; p < points.size(); ++p) {
      const Vec3 q = view.local(points[p]);
      at[p] = {int64_t(std::floor(q.x() / r)), int64_t(std::floor(q.y() / r)), q.z(), p};
    }
    const auto before = [](const Placed& a, const Placed& b) {
      return a.i != b.i ? a.i < b.i : a.j != b.j ? a.j < b.j : a.h != b.h ? a.h < b.h : a.point < b.point;
    };
    std::sort(at.begin(), at.end(), before);
    std::vector<double> height;
    for (size_t p = 0; p < at.size(); ++p) {
      height.clear();
      const Vec3& x = points[at[p].point];
      for (int64_t i = at[p].i - 1; i <= at[p].i + 1; ++i) {
        const Placed least{i, at[p].j - 1, -std::numeric_limits<double>::infinity(), 0};
        for (auto o = std::lower_bound(at.begin(), at.end(), least, before);
             o != at.end() && o->i == i && o->j <= at[p].j + 1; ++o) {
          const Vec3 d = points[o->point] - x;
          if (o->h >= at[p].h && (d - d.dot(view.front) * view.front).norm() <= r) height.push_back(o->h);
        }
      }
      std::sort(height.begin(), height.end());
      for (size_t k = 0; k + 1 < height.size(); ++k)
        hidden[at[p].point] |= height[k + 1] - height[k] > kLayers * spacing;
    }
  }
  const PointTree tree(points);
  std::vector<PointTree::Nearest> near;
  std::vector<Vec3> out;
  for (const Vec3& x : points) {
    tree.nearest(x, kVoters, near);
    size_t votes = 0;
    for (const PointTree::Nearest& n : near) votes += hidden[size_t(n.index)];
    if (2 * votes <= near.size()) out.push_back(x);
  }
  return out;
}

namespace {

/// Unit normals at the points, outwards; empty: the triangles do not say.
std::vector<Vec3> looks_of(const std::vector<Vec3>& points, const std::vector<Tri>& tri) {
  std::vector<std::pair<int32_t, int32_t>> edge;
  std::vector<Vec3> out(points.size(), Vec3::Zero());
  Vec3 middle = Vec3::Zero();
  for (const Vec3& x : points) middle += x / double(points.size());
  double volume = 0;
  for (const Tri& t : tri) {
    const Vec3 a = points[size_t(t[0])] - middle, b = points[size_t(t[1])] - middle, c = points[size_t(t[2])] - middle;
    volume += a.dot(b.cross(c));
    for (size_t k = 0; k < 3; ++k) out[size_t(t[k])] += (b - a).cross(c - a), edge.emplace_back(t[k], t[(k + 1) % 3]);
  }
  // Neighbours run along their common edge in opposite directions.
  std::sort(edge.begin(), edge.end());
  size_t twice = 0;
  for (size_t i = 1; i < edge.size(); ++i) twice += edge[i] == edge[i - 1];
  if (tri.empty() || double(twice) > kTwisted * double(edge.size()) || volume == 0) return {};
  for (Vec3& n : out) n = n.norm() > 0 ? Vec3(std::copysign(1 / n.norm(), volume) * n) : Vec3(Vec3::Zero());
  return out;
}

/// A sector that a place looks into: 13 directions within 60 degrees of its normal.
template <class Visit>
void sector(const Vec3& normal, Visit&& visit) {
  const Vec3 u = normal.unitOrthogonal(), w = normal.cross(u);
  visit(normal);
  for (const double off : {M_PI / 6, M_PI / 3})
    for (int k = 0; k < 6; ++k)
      visit(Vec3(elementary::cos(off) * normal +
                 elementary::sin(off) * (elementary::cos(k * M_PI / 3) * u + elementary::sin(k * M_PI / 3) * w)));
}

}  // namespace

SeenScan seen_from_around(const std::vector<Vec3>& points, const std::vector<Tri>& tri) {
  const std::vector<Vec3> looks = looks_of(points, tri);
  if (looks.empty()) return {points, {}};
  Vec3 low = points.front(), high = low;
  for (const Vec3& x : points) low = low.cwiseMin(x), high = high.cwiseMax(x);
  const double size = (high - low).norm();
  const Bvh bvh(points, tri);
  SeenScan out;
  for (size_t i = 0; i < points.size(); ++i) {
    int met = 0;
    Bvh::LineHit hit[1];
    if (looks[i] != Vec3::Zero())
      sector(looks[i], [&](const Vec3& way) { met += bvh.line(points[i], way, kOwn * size, size, hit) > 0; });
    if (met < kHidden) out.x_mm.push_back(points[i]), out.looks.push_back(looks[i]);
  }
  return out;
}

simplex::Mesh start_plane(const ScanView& view) {
  const Vec2 half = view.sheet_mm().cwiseMax(0.02 * view.half_mm.norm());
  simplex::Mesh m = simplex::make_plane(
      2 * half.x(), 2 * half.y(), std::sqrt(4 * half.prod() / 2000 / 1.3));  // 4 / (3 sqrt 3) edge^-2 vertices per area
  for (Vec3& x : m.x_mm)
    x = view.place({x.x() - half.x(), x.y() - half.y(), 1.1 * view.half_mm.z() + 0.01 * half.norm()});
  m.before_mm = m.x_mm;
  return m;
}

ScanHeights::ScanHeights(const std::vector<Vec3>& points, const ScanView& view, double cell)
    : view_(view), low_(-view.sheet_mm()) {
  cell_ = std::max(cell, 2 * view.sheet_mm().maxCoeff() / (kCells - 1));
  nx_ = int(std::ceil(-2 * low_.x() / cell_)) + 1, ny_ = int(std::ceil(-2 * low_.y() / cell_)) + 1;
  const double none = -std::numeric_limits<double>::infinity();
  height_.assign(size_t(nx_) * size_t(ny_), none);
  for (const Vec3& x : points) {
    const Vec3 q = view_.local(x);
    const int i = std::clamp(int(std::lround((q.x() - low_.x()) / cell_)), 0, nx_ - 1),
              j = std::clamp(int(std::lround((q.y() - low_.y()) / cell_)), 0, ny_ - 1);
    double& h = height_[size_t(j) * size_t(nx_) + size_t(i)];
    h = std::max(h, q.z());
  }
  // Outwards from the cells that have a height, ring by ring.
  std::vector<int32_t> front, next;
  for (size_t c = 0; c < height_.size(); ++c)
    if (height_[c] > none) front.push_back(int32_t(c));
  while (!front.empty()) {
    next.clear();
    for (const int32_t c : front)
      for (int k = 0; k < 4; ++k) {
        const int i = c % nx_ + (k == 0) - (k == 1), j = c / nx_ + (k == 2) - (k == 3);
        if (i < 0 || j < 0 || i >= nx_ || j >= ny_) continue;
        double& h = height_[size_t(j) * size_t(nx_) + size_t(i)];
        if (h == none) h = height_[size_t(c)], next.push_back(j * nx_ + i);
      }
    front.swap(next);
  }
}

double ScanHeights::at(const Vec3& q) const {
  const double x = std::clamp((q.x() - low_.x()) / cell_, 0., double(nx_ - 1)),
               y = std::clamp((q.y() - low_.y()) / cell_, 0., double(ny_ - 1));
  const int i = std::min(int(x), nx_ - 1), j = std::min(int(y), ny_ - 1), i1 = std::min(i + 1, nx_ - 1),
            j1 = std::min(j + 1, ny_ - 1);
  const auto h = [&](int a, int b) { return height_[size_t(b) * size_t(nx_) + size_t(a)]; };
  const double s = x - i, t = y - j;
  return (1 - t) * ((1 - s) * h(i, j) + s * h(i1, j)) + t * ((1 - s) * h(i, j1) + s * h(i1, j1));
}

bool at_edge(const Vec3& x, const std::vector<Vec3>& around, Vec3& outward) {
  Vec3 mean = Vec3::Zero(), a, b, n;
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : around) mean += p / double(around.size());
  for (const Vec3& p : around) spread += (p - mean) * (p - mean).transpose();
  principal_axes(spread, a, b, n);
  std::vector<double> angle;
  for (const Vec3& p : around)
    if (const double u = a.dot(p - x), w = b.dot(p - x); elementary::hypot(u, w) > 1e-9 * std::sqrt(spread.trace()))
      angle.push_back(elementary::atan2(w, u));
  if (angle.size() < 3) return false;
  std::sort(angle.begin(), angle.end());
  double widest = 0, middle = 0;
  for (size_t i = 0; i < angle.size(); ++i) {
    const double gap = i + 1 < angle.size() ? angle[i + 1] - angle[i] : angle[0] + 6.283185307 - angle[i];
    if (gap > widest) widest = gap, middle = angle[i] + 0.5 * gap;
  }
  outward = elementary::cos(middle) * a + elementary::sin(middle) * b;
  return widest >= kGap;
}

}  // namespace limberg
