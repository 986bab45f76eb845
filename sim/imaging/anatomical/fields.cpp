#include "sim/imaging/anatomical/fields.h"

#include <Eigen/Dense>

#include "sim/base/error.h"

namespace limberg::anatomical {

namespace {

constexpr int kOfSegment = 6;  // straight parts of a bend

}  // namespace

Tube::Tube(std::initializer_list<std::array<double, 4>> given) {
  // Catmull and Rom's curve through the places, and their radii by the same.
  const std::vector<std::array<double, 4>> at(given);
  const auto n = int(at.size());
  Vec3 low = Vec3::Constant(1e300), high = -low;
  std::array<double, 4> last = at.front();
  const auto place = [](const std::array<double, 4>& p) { return Vec3(p[0], p[1], p[2]); };
  for (int i = 0; i + 1 < n; ++i)
    for (int j = 1; j <= kOfSegment; ++j) {
      const double t = double(j) / kOfSegment;
      std::array<double, 4> p{};
      for (size_t k = 0; k < 4; ++k) {
        const double b = at[size_t(i)][k], c = at[size_t(i + 1)][k];
        const double before = i > 0 ? at[size_t(i - 1)][k] : 2 * b - c,
                     after = i + 2 < n ? at[size_t(i + 2)][k] : 2 * c - b;
        p[k] =
            b + 0.5 * t * (c - before + t * (2 * before - 5 * b + 4 * c - after + t * (3 * (b - c) + after - before)));
      }
      part_.emplace_back(place(last), place(p), last[3], p[3]);
      for (const auto& e : {last, p})
        low = low.cwiseMin(place(e) - Vec3::Constant(e[3])), high = high.cwiseMax(place(e) + Vec3::Constant(e[3]));
      last = p;
    }
  middle_ = 0.5 * (low + high), far_ = 0.5 * (high - low).norm();
}

namespace {

constexpr double kPullCell_mm = 12;

double wendland(double r) { return r >= 1 ? 0 : (1 - r) * (1 - r) * (1 - r) * (1 - r) * (4 * r + 1); }

}  // namespace

Pull::Pull(std::vector<Vec3> places, const std::vector<double>& values, double reach, bool mirrored, double slack)
    : reach_(reach) {
  const auto n = Eigen::Index(places.size());
  Eigen::MatrixXd A(n, n);
  Eigen::VectorXd b(n);
  const auto other = [](const Vec3& p) { return Vec3(-p.x(), p.y(), p.z()); };
  const auto twice = [&](const Vec3& p) { return mirrored && p.x() != 0; };
  for (Eigen::Index i = 0; i < n; ++i) {
    b[i] = values[size_t(i)];
    for (Eigen::Index j = 0; j < n; ++j) {
      const Vec3 &p = places[size_t(i)], &c = places[size_t(j)];
      A(i, j) = wendland((p - c).norm() / reach);
      if (twice(c)) A(i, j) += wendland((p - other(c)).norm() / reach);
      if (i == j) A(i, j) += slack;
    }
  }
  const Eigen::VectorXd w = A.partialPivLu().solve(b);
  if (!w.allFinite() || (A * w - b).lpNorm<Eigen::Infinity>() > 1e-6)
    throw InputError("", 0, "two of the places that a surface is pulled onto coincide");
  for (Eigen::Index i = 0; i < n; ++i) {
    at_.push_back({places[size_t(i)], w[i]});
    if (twice(places[size_t(i)])) at_.push_back({other(places[size_t(i)]), w[i]});
  }
  if (at_.empty()) return;
  Vec3 high = at_.front().c;
  low_ = high;
  for (const At& a : at_) low_ = low_.cwiseMin(a.c), high = high.cwiseMax(a.c);
  low_.array() -= reach, high.array() += reach;
  size_t all = 1;
  for (size_t k = 0; k < 3; ++k)
    cells_[k] = int((high - low_)[Eigen::Index(k)] / kPullCell_mm) + 1, all *= size_t(cells_[k]);
  near_.resize(all);
  const double far = reach + 0.5 * std::sqrt(3.) * kPullCell_mm;
  for (int k = 0; k < cells_[2]; ++k)
    for (int j = 0; j < cells_[1]; ++j)
      for (int i = 0; i < cells_[0]; ++i) {
        const Vec3 m = low_ + kPullCell_mm * Vec3(i + 0.5, j + 0.5, k + 0.5);
        for (size_t a = 0; a < at_.size(); ++a)
          if ((at_[a].c - m).squaredNorm() < far * far)
            near_[size_t(i + cells_[0] * (j + cells_[1] * k))].push_back(int(a));
      }
}

double Pull::operator()(const Vec3& p) const {
  const Vec3 q = (p - low_) / kPullCell_mm;
  const int i = int(std::floor(q.x())), j = int(std::floor(q.y())), k = int(std::floor(q.z()));
  if (i < 0 || j < 0 || k < 0 || i >= cells_[0] || j >= cells_[1] || k >= cells_[2] || near_.empty()) return 0;
  double sum = 0;
  for (const int a : near_[size_t(i + cells_[0] * (j + cells_[1] * k))]) {
    const At& at = at_[size_t(a)];
    const double d2 = (p - at.c).squaredNorm();
    if (d2 < reach_ * reach_) sum += at.w * wendland(std::sqrt(d2) / reach_);
  }
  return sum;
}

}  // namespace limberg::anatomical
