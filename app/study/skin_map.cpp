#include "app/study/skin_map.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/geometry/vec.h"
#include "sim/measure/skin_strain.h"

namespace limberg::study {

namespace {

constexpr double kBin_mm = 3, kSliver_mm = 0.02;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

SkinMap::SkinMap(const Snapshot& s, Side side) {
  const SurfaceView& v = s.topology->view;
  up_ = s.topology->body->chart_normal();
  Vec2 high = Vec2::Constant(-1e300);
  low_ = -high;
  for (size_t t = 0; t < v.tri.size(); ++t) {
    Patch p;
    Tri corner = v.tri[t];
    if (side == Side::skin) {
      if (v.kind[t] != FaceKind::skin) continue;
    } else {
      if (v.kind[t] != FaceKind::wall && v.kind[t] != FaceKind::free) continue;
      const Vec3 a = v.X_mm[size_t(corner[0])],
                 n = (v.X_mm[size_t(corner[1])] - a).cross(v.X_mm[size_t(corner[2])] - a);
      if (n.dot(up_) > -0.9 * n.norm()) continue;
      std::swap(corner[1], corner[2]);  // seen from above, as the skin
    }
    for (size_t k = 0; k < 3; ++k) {
      const auto i = size_t(corner[k]);
      p.X[k] = v.X_mm[i], p.x[k] = s.x_mm[i].cast<double>();
      p.at[k] = s.topology->body->to_chart(p.X[k]);
      low_ = low_.cwiseMin(p.at[k]), high = high.cwiseMax(p.at[k]);
    }
    patches_.push_back(p);
    for (size_t k = 0; k < 3 && t < v.rim.size() && side == Side::skin; ++k)
      if (v.rim[t] >> k & 1) rim_.push_back({p.at[k], p.at[(k + 1) % 3]});
  }
  if (patches_.empty()) return;
  nx_ = int((high.x() - low_.x()) / kBin_mm) + 1, ny_ = int((high.y() - low_.y()) / kBin_mm) + 1;
  bin_.resize(size_t(nx_) * size_t(ny_));
  centred_in_.resize(bin_.size());
  for (size_t t = 0; t < patches_.size(); ++t) {
    Vec2 a = patches_[t].at[0], b = a;
    for (const Vec2& p : patches_[t].at) a = a.cwiseMin(p), b = b.cwiseMax(p);
    const Vec2 c = (patches_[t].centre() - low_) / kBin_mm;
    centred_in_[size_t(int(c.y())) * size_t(nx_) + size_t(int(c.x()))].push_back(int32_t(t));
    for (int y = int((a.y() - low_.y()) / kBin_mm); y <= int((b.y() - low_.y()) / kBin_mm); ++y)
      for (int x = int((a.x() - low_.x()) / kBin_mm); x <= int((b.x() - low_.x()) / kBin_mm); ++x)
        bin_[size_t(y) * size_t(nx_) + size_t(x)].push_back(int32_t(t));
  }
}

std::optional<Vec3> SkinMap::now_mm(const ChartPoint& p) const {
  const int x = int(std::floor((p.x() - low_.x()) / kBin_mm)), y = int(std::floor((p.y() - low_.y()) / kBin_mm));
  if (x < 0 || y < 0 || x >= nx_ || y >= ny_) return std::nullopt;
  for (const int32_t i : bin_[size_t(y) * size_t(nx_) + size_t(x)]) {
    const Patch& t = patches_[size_t(i)];
    const double area = cross(t.at[1] - t.at[0], t.at[2] - t.at[0]);
    if (!(area > 0)) continue;
    Vec3 w;
    for (size_t k = 0; k < 3; ++k) w[Eigen::Index(k)] = cross(t.at[(k + 1) % 3] - p, t.at[(k + 2) % 3] - p) / area;
    if (w.minCoeff() < -1e-9) continue;
    return w[0] * t.x[0] + w[1] * t.x[1] + w[2] * t.x[2];
  }
  return std::nullopt;
}

double SkinMap::free_mm(const ChartPoint& from, const Vec2& d) const {
  double least = 1e300;
  for (const auto& [p, q] : rim_) {  // from + s d = p + t (q - p)
    const Vec2 e = q - p;
    const double det = cross(d, e);
    if (det == 0) continue;
    const double s = cross(p - from, e) / det, t = cross(p - from, d) / det;
    if (s > 0 && t >= -1e-9 && t <= 1 + 1e-9) least = std::min(least, s);
  }
  return least;
}

SkinMap::Gradient SkinMap::gradient(const Patch& t) {
  Gradient g;
  Eigen::Matrix2d D;
  D << t.at[1] - t.at[0], t.at[2] - t.at[0];
  const double twice = D.determinant(),
               longest = std::max({(t.at[1] - t.at[0]).norm(), (t.at[2] - t.at[1]).norm(), (t.at[0] - t.at[2]).norm()});
  if (!(twice > kSliver_mm * longest)) return g;
  Eigen::Matrix<double, 3, 2> d;
  d << t.x[1] - t.x[0], t.x[2] - t.x[0];
  g.F = d * D.inverse();
  g.area_mm2 = 0.5 * twice;
  return g;
}

template <class Visit>
void SkinMap::near(const ChartPoint& p, double radius, Visit visit) const {
  if (patches_.empty()) return;
  const auto bin = [](double d, int n) { return std::clamp(int(std::floor(d / kBin_mm)), 0, n - 1); };
  const Vec2 c = p - low_;
  for (int y = bin(c.y() - radius, ny_); y <= bin(c.y() + radius, ny_); ++y)
    for (int x = bin(c.x() - radius, nx_); x <= bin(c.x() + radius, nx_); ++x)
      for (const int32_t i : centred_in_[size_t(y) * size_t(nx_) + size_t(x)]) {
        const Patch& t = patches_[size_t(i)];
        if ((t.centre() - p).norm() <= radius)
          if (const Gradient g = gradient(t); g.area_mm2 > 0) visit(t, g);
      }
}

std::optional<Vec3> SkinMap::mean_now_mm(const ChartPoint& p, double radius) const {
  Vec3 sum = Vec3::Zero();
  double area = 0;
  near(p, radius, [&](const Patch& t, const Gradient& g) {
    sum += g.area_mm2 * (t.x[0] + t.x[1] + t.x[2]) / 3, area += g.area_mm2;
  });
  if (area < 0.5 * std::numbers::pi * radius * radius) return std::nullopt;
  return sum / area;
}

std::optional<double> SkinMap::mean_height_mm(const ChartPoint& p, double radius) const {
  double sum = 0, area = 0;
  near(p, radius, [&](const Patch& t, const Gradient& g) {
    sum += g.area_mm2 * (t.x[0] + t.x[1] + t.x[2] - t.X[0] - t.X[1] - t.X[2]).dot(up_) / 3, area += g.area_mm2;
  });
  if (area < 0.5 * std::numbers::pi * radius * radius) return std::nullopt;
  return sum / area;
}

SkinMap::Stretch SkinMap::stretch(const ChartPoint& p, double radius) const {
  Stretch out;
  Mat3 left = Mat3::Zero();                         // F F^T
  Eigen::Matrix2d right = Eigen::Matrix2d::Zero();  // F^T F
  near(p, radius, [&](const Patch&, const Gradient& g) {
    left += g.area_mm2 * g.F * g.F.transpose(), right += g.area_mm2 * g.F.transpose() * g.F;
    out.area_mm2 += g.area_mm2;
  });
  if (!(out.area_mm2 > 0)) return out;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> stretches(right / out.area_mm2);
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(left / out.area_mm2);
  out.most = std::sqrt(stretches.eigenvalues()[1]), out.least = std::sqrt(std::max(0.0, stretches.eigenvalues()[0]));
  out.direction = axes.eigenvectors().col(2);
  return out;
}

double SkinMap::percentile(double q, double radius, const std::vector<ChartPoint>& tips, double keep_off) const {
  std::vector<std::pair<double, double>> stretches;
  near({0, 0}, radius, [&](const Patch& t, const Gradient& g) {
    for (const ChartPoint& c : tips)
      if ((t.centre() - c).norm() < keep_off) return;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> e(g.F.transpose() * g.F);
    stretches.push_back({std::sqrt(e.eigenvalues()[1]), g.area_mm2});
  });
  return weighted_percentile(stretches, q);
}

double SkinMap::slack_share(double radius, double prestretch) const {
  double all = 0, slack = 0;
  near({0, 0}, radius, [&](const Patch&, const Gradient& g) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> e(g.F.transpose() * g.F);
    const double most = prestretch * std::sqrt(e.eigenvalues()[1]),
                 least = prestretch * std::sqrt(std::max(0.0, e.eigenvalues()[0]));
    all += g.area_mm2;
    if (least * std::sqrt(most) < 1 - 1e-3)
      slack += g.area_mm2;  // a thousandth is the rounding of positions over a triangle
  });
  return all > 0 ? slack / all : 0;
}

double SkinMap::turned_share(double radius) const {
  double all = 0, turned = 0;
  near({0, 0}, radius, [&](const Patch& t, const Gradient& g) {
    const Vec3 n = (t.x[1] - t.x[0]).cross(t.x[2] - t.x[0]);
    all += g.area_mm2;
    if (n.dot(up_) < 0.5 * n.norm()) turned += g.area_mm2;
  });
  return all > 0 ? turned / all : 0;
}

double SkinMap::cut_angle_deg(const Figure& f, const Corner& c, double radius) const {
  const Vec2 apex = place(f, c), middle = tissue_bisector(f, c);
  double ahead = 360, behind = 360;
  for (const auto& [p, q] : rim_) {
    const Vec2 a = p - apex, e = q - p;  // |a + t e| = radius
    const double A = e.squaredNorm(), B = a.dot(e), C = a.squaredNorm() - radius * radius, D = B * B - A * C;
    if (!(A > 0) || D < 0) continue;
    for (const double root : {-std::sqrt(D), std::sqrt(D)}) {
      const double t = (root - B) / A;
      if (t < 0 || t > 1) continue;
      const Vec2 x = a + t * e;
      double turn = std::atan2(cross(middle, x), middle.dot(x)) * kDeg;  // counter-clockwise from the middle
      if (turn < 0) turn += 360;
      ahead = std::min(ahead, turn), behind = std::min(behind, 360 - turn);
    }
  }
  return ahead < 360 && behind < 360 ? ahead + behind : std::nan("");
}

double SkinMap::deficit_deg(const Figure& f, const std::vector<Corner>& corners, double radius) const {
  constexpr double kStep_deg = 4, kEdge_deg = 1, kApex_mm = 0.03;
  double sum = 0;
  for (const Corner& c : corners) {
    const double angle = tissue_deg(f, c);
    const Vec2 middle = tissue_bisector(f, c), apex = place(f, c);
    const auto apex_now = now_mm(apex + kApex_mm * middle);
    if (!apex_now) return std::nan("");
    // From edge to edge; the outermost places lie a degree inside, and what is missing there is taken in proportion.
    const double half = 0.5 * angle - kEdge_deg;
    const int n = std::max(2, int(std::ceil(2 * half / kStep_deg)));
    double seen = 0;
    std::optional<Vec3> before;
    for (int i = 0; i <= n; ++i) {
      const double a = (-half + 2 * half * i / n) / kDeg;
      const Vec2 d(std::cos(a) * middle.x() - std::sin(a) * middle.y(),
                   std::sin(a) * middle.x() + std::cos(a) * middle.y());
      const auto x = now_mm(apex + radius * d);
      if (!x) return std::nan("");
      const Vec3 ray = *x - *apex_now;
      if (before) seen += std::atan2(before->cross(ray).norm(), before->dot(ray));
      before = ray;
    }
    sum += seen * kDeg * angle / (2 * half);
  }
  return 360 - sum;
}

double SkinMap::curvature_deg(const Figure& f, const std::vector<Corner>& corners, double radius, double width) const {
  constexpr double kCell_deg = 12;
  std::vector<Vec3> round;  // unit normals
  for (const Corner& c : corners) {
    const double angle = tissue_deg(f, c);
    const Vec2 middle = tissue_bisector(f, c), apex = place(f, c);
    std::vector<Vec3> cell(size_t(std::max(2.0, std::ceil(angle / kCell_deg))), Vec3::Zero());
    near(apex, radius + 0.5 * width, [&](const Patch& t, const Gradient&) {
      const Vec2 d = t.centre() - apex;
      if (d.norm() < radius - 0.5 * width) return;
      // from the sector's first edge
      const double turn = std::atan2(cross(middle, d), middle.dot(d)) * kDeg + 0.5 * angle;
      if (turn < 0 || turn >= angle) return;
      cell[std::min(cell.size() - 1, size_t(turn / angle * double(cell.size())))] +=
          (t.x[1] - t.x[0]).cross(t.x[2] - t.x[0]);
    });
    const size_t before = round.size();
    for (const Vec3& n : cell)
      if (n.norm() > 0) round.push_back(n.normalized());
    if (round.size() < before + 2) return std::nan("");
  }
  Vec3 pole = Vec3::Zero();
  for (const Vec3& n : round) pole += n;
  pole.normalize();
  double area = 0;  // of the spherical triangles pole, n, next (Van Oosterom and Strackee 1983)
  for (size_t i = 0; i < round.size(); ++i) {
    const Vec3 &a = round[i], &b = round[(i + 1) % round.size()];
    area += 2 * std::atan2(pole.dot(a.cross(b)), 1 + pole.dot(a) + a.dot(b) + b.dot(pole));
  }
  return area * kDeg;
}

}  // namespace limberg::study
