#include "devices/drawn_curve.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "sim/geometry/polyline.h"

namespace limberg {

namespace {

constexpr double kMean_mm = 0.5;          // of the stroke that one mean stands for
constexpr double kReach_mm = 8;           // of an edge that says what its corner is
constexpr double kLeastSpan_mm = 4;       // of the spline: two waves of tremor at 20 mm/s
constexpr double kSharpest_cos = -0.342;  // 110 degrees
constexpr double kShallow_cos = 0.259;    // 75 degrees
constexpr size_t kLeastPoints = 6;

/// The best of c0 + c1 t + c2 f(t), whose columns are `basis`, and the points' sum of squares beside it.
struct LeastSquares {
  Eigen::Vector3d c;
  double left;
};
LeastSquares fit(const Eigen::MatrixX3d& basis, const Eigen::VectorXd& d) {
  const Eigen::Matrix3d A = basis.transpose() * basis + 1e-12 * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d c = A.ldlt().solve(basis.transpose() * d);
  return {c, (d - basis * c).squaredNorm()};
}

struct Window {
  Eigen::VectorXd t, d;  // along and across the way from the window's first point to its last
};

std::pair<size_t, size_t> between(const Course& c, double from, double to) {
  const auto b = std::lower_bound(c.s_mm.begin(), c.s_mm.end(), from), e = std::upper_bound(b, c.s_mm.end(), to);
  return {size_t(b - c.s_mm.begin()), size_t(e - c.s_mm.begin())};
}

/// Empty when there is too little to tell from.
Window window_of(const Course& c, double from, double to, const Vec2& origin) {
  const auto [b, e] = between(c, from, to);
  Window w;
  if (e < b + kLeastPoints) return w;
  const Vec2 way = c.at[e - 1] - c.at[b];
  if (!(way.norm() > 1e-9)) return w;
  const Vec2 along = way.normalized();
  w.t.resize(Eigen::Index(e - b)), w.d.resize(Eigen::Index(e - b));
  for (size_t i = b; i < e; ++i) {
    const Vec2 p = c.at[i] - origin;
    w.t[Eigen::Index(i - b)] = along.dot(p), w.d[Eigen::Index(i - b)] = cross2(along, p);
  }
  return w;
}

Eigen::MatrixX3d basis_of(const Eigen::VectorXd& t, const Eigen::VectorXd& third) {
  Eigen::MatrixX3d m(t.size(), 3);
  m.col(0).setOnes(), m.col(1) = t, m.col(2) = third;
  return m;
}

/// The four cubic B-splines that are not zero at u in [0, 1] of a span, and their slopes by u.
void cubic(double u, double (&value)[4], double (&slope)[4]) {
  const double v = 1 - u;
  value[0] = v * v * v / 6, value[3] = u * u * u / 6;
  value[1] = (3 * u * u * u - 6 * u * u + 4) / 6, value[2] = (3 * v * v * v - 6 * v * v + 4) / 6;
  slope[0] = -v * v / 2, slope[3] = u * u / 2;
  slope[1] = (9 * u * u - 12 * u) / 6, slope[2] = (12 * v - 9 * v * v) / 6;
}

struct Spline {
  double from, to;
  Eigen::MatrixX2d control;  // spans + 3

  int spans() const { return int(control.rows()) - 3; }
  std::pair<int, double> span_at(double s) const {
    const double x = std::clamp((s - from) / (to - from), 0.0, 1.0) * spans();
    const int i = std::min(int(x), spans() - 1);
    return {i, x - i};
  }
  Vec2 operator()(double s, Vec2* slope = nullptr) const {
    const auto [i, u] = span_at(s);
    double value[4], by_u[4];
    cubic(u, value, by_u);
    Vec2 at = Vec2::Zero(), way = Vec2::Zero();
    for (int k = 0; k < 4; ++k) {
      at += value[k] * control.row(i + k).transpose();
      way += by_u[k] * control.row(i + k).transpose();
    }
    if (slope) *slope = way;
    return at;
  }
};

/// A symmetric matrix whose rows reach three places beyond their diagonal: of row i, those from i to i + 3.
using Banded = std::vector<std::array<double, 4>>;

/// Solves A x = b in place by the Cholesky decomposition, b's columns side by side; A positive definite. O(rows)
void solve(Banded& A, Eigen::MatrixX2d& b) {
  const auto n = Eigen::Index(A.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const double root = std::sqrt(A[size_t(i)][0]);
    for (double& a : A[size_t(i)]) a /= root;
    for (Eigen::Index j = 1; j < 4 && i + j < n; ++j)
      for (Eigen::Index k = j; k < 4 && i + k < n; ++k)
        A[size_t(i + j)][size_t(k - j)] -= A[size_t(i)][size_t(j)] * A[size_t(i)][size_t(k)];
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    b.row(i) /= A[size_t(i)][0];
    for (Eigen::Index j = 1; j < 4 && i + j < n; ++j) b.row(i + j) -= A[size_t(i)][size_t(j)] * b.row(i);
  }
  for (Eigen::Index i = n - 1; i >= 0; --i) {
    for (Eigen::Index j = 1; j < 4 && i + j < n; ++j) b.row(i) -= A[size_t(i)][size_t(j)] * b.row(i + j);
    b.row(i) /= A[size_t(i)][0];
  }
}

/// By least squares, with so little of their second differences that it only counts where no points are.
Spline fit(const Course& c, size_t b, size_t e, double from, double to, int spans) {
  Spline spline{from, to, Eigen::MatrixX2d::Zero(spans + 3, 2)};
  Banded A(size_t(spans + 3), {0, 0, 0, 0});
  for (size_t i = b; i < e; ++i) {
    const auto [at, u] = spline.span_at(c.s_mm[i]);
    double value[4], slope[4];
    cubic(u, value, slope);
    for (int j = 0; j < 4; ++j) {
      spline.control.row(at + j) += value[j] * c.at[i].transpose();
      for (int k = j; k < 4; ++k) A[size_t(at + j)][size_t(k - j)] += value[j] * value[k];
    }
  }
  const double stiffness = 1e-6 * double(e - b), difference[3] = {1, -2, 1};
  for (int i = 0; i <= spans; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = j; k < 3; ++k) A[size_t(i + j)][size_t(k - j)] += stiffness * difference[j] * difference[k];
  solve(A, spline.control);
  return spline;
}

double mean_square(const Course& c, size_t b, size_t e, const Spline& spline) {
  double sum = 0;
  for (size_t i = b; i < e; ++i) sum += (spline(c.s_mm[i]) - c.at[i]).squaredNorm();
  return sum / double(e - b);
}

}  // namespace

Course course_of(std::span<const Vec2> points, std::span<const size_t> knots) {
  Course c;
  double begin = 0;
  for (size_t k = 0; k + 1 < knots.size(); ++k) {
    c.knot.push_back(begin);
    const Vec2 &a = points[knots[k]], way = points[knots[k + 1]] - a;
    const double length = way.norm();
    const size_t means = std::max<size_t>(1, size_t(length / kMean_mm));
    std::vector<Vec2> sum(means, Vec2::Zero());
    std::vector<double> along(means, 0), count(means, 0);
    for (size_t i = knots[k]; i <= knots[k + 1] && length > 0; ++i) {
      const double t = std::clamp((points[i] - a).dot(way) / (length * length), 0.0, 1.0);
      const size_t m = std::min(means - 1, size_t(t * double(means)));
      sum[m] += points[i], along[m] += begin + t * length, ++count[m];
    }
    for (size_t m = 0; m < means; ++m)
      if (count[m] > 0) c.at.emplace_back(sum[m] / count[m]), c.s_mm.push_back(along[m] / count[m]);
    begin += length;
  }
  c.knot.push_back(begin);
  return c;
}

bool bends_at(const Course& c, size_t k, double tolerance_mm) {
  const double from = std::max(c.knot[k - 1], c.knot[k] - kReach_mm),
               to = std::min(c.knot[k + 1], c.knot[k] + kReach_mm);
  const auto [b, e] = between(c, from, to);
  const auto middle = size_t(std::lower_bound(c.s_mm.begin(), c.s_mm.end(), c.knot[k]) - c.s_mm.begin());
  if (middle <= b || middle >= e) return false;
  const Window w = window_of(c, from, to, c.at[middle]);
  if (w.t.size() == 0) return false;
  const Vec2 in = (c.at[middle] - c.at[b]).normalized(), out = (c.at[e - 1] - c.at[middle]).normalized();
  if (in.dot(out) < kSharpest_cos) return false;
  const double curved = fit(basis_of(w.t, w.t.cwiseAbs2()), w.d).left;
  double straight = 1e300;
  for (double hinge = -1; hinge <= 1; hinge += 0.25)
    straight = std::min(straight, fit(basis_of(w.t, (w.t.array() - hinge).abs()), w.d).left);
  const double enough = tolerance_mm * tolerance_mm / 8 * double(w.t.size());
  return curved < straight || (in.dot(out) > kShallow_cos && (curved < enough || curved < 2 * straight));
}

bool is_arc(const Course& c, size_t k, double tolerance_mm) {
  const auto [b, e] = between(c, c.knot[k], c.knot[k + 1]);
  if (e < b + kLeastPoints) return false;
  const Window w = window_of(c, c.knot[k], c.knot[k + 1], 0.5 * (c.at[b] + c.at[e - 1]));
  if (w.t.size() == 0) return false;
  const LeastSquares parabola = fit(basis_of(w.t, w.t.cwiseAbs2()), w.d);
  const double half = 0.5 * (c.at[e - 1] - c.at[b]).norm();
  if (!(std::abs(parabola.c[2]) * half * half > tolerance_mm)) return false;
  return 2 * parabola.left < fit(basis_of(w.t, Eigen::VectorXd::Zero(w.t.size())), w.d).left;
}

DrawnCurve drawn_curve(const Course& c, size_t a, size_t b, double tolerance_mm) {
  const double from = c.knot[a], to = c.knot[b];
  const auto [first, last] = between(c, from, to);
  if (last < first + kLeastPoints) return {};
  const int most = std::max(1, std::min(int((to - from) / kLeastSpan_mm), int(last - first) - 3));
  Spline spline = fit(c, first, last, from, to, 1);
  const double enough = 2 * tolerance_mm * tolerance_mm / 16;  // across and along
  for (int spans = 1; spans < most && mean_square(c, first, last, spline) > enough;)
    spline = fit(c, first, last, from, to, spans = std::min(2 * spans, most));

  std::vector<Vec2> fine;
  const int steps = std::max(2, int(std::ceil((to - from) / (kMean_mm / 2))));
  for (int i = 0; i <= steps; ++i) fine.push_back(spline(from + (to - from) * i / steps));
  DrawnCurve curve;
  curve.at = simplify(std::span<const Vec2>(fine), tolerance_mm / 8);
  spline(from, &curve.tangent_at_begin), spline(to, &curve.tangent_at_end);
  for (Vec2* t : {&curve.tangent_at_begin, &curve.tangent_at_end})
    if (!(t->norm() > 1e-9)) return {};
  curve.tangent_at_begin.normalize(), curve.tangent_at_end.normalize();
  return curve;
}

}  // namespace limberg
