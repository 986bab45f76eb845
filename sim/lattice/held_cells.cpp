#include "sim/lattice/held_cells.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

namespace limberg {
namespace {

constexpr double kBent = 0.15;   // of the shortest edge: a held surface that is no plane in the cell
constexpr double kLeast = 0.02;  // of it: a free corner is at least so far above the held surface
constexpr int kPlaces = 5;       // per axis, of which the best is the sample point

using Gradients = Eigen::Matrix<double, 8, 3>;

class HeldFunctions {
 public:
  HeldFunctions(const Vec3& cell_mm, const HeldCorners& c) : cell_mm_(cell_mm), c_(c) {
    for (size_t k = 0; k < 8; ++k) {
      mean_ += c.depth_mm[k] / 8;
      for (int a = 0; a < 3; ++a) slope_[a] += ((k >> a & 1) ? 0.25 : -0.25) * c.depth_mm[k];
    }
    const double edge = cell_mm.minCoeff();
    least_ = kLeast * edge;
    for (size_t k = 0; k < 8; ++k) {
      fits_ = fits_ && std::fabs(c.depth_mm[k] - depth(Vec3(k & 1, k >> 1 & 1, k >> 2 & 1))) <= kBent * edge;
      if (free(k)) fits_ = fits_ && c.depth_mm[k] > least_;
    }
    held_ = 0;
    for (size_t k = 0; k < 8; ++k) held_ += !free(k);
    fits_ = fits_ && held_ > 0 && held_ < 8;
  }
  bool fits() const { return fits_; }
  bool free(size_t k) const { return !(c_.held >> k & 1); }

  /// Nothing where the functions have no value: on an edge between held corners, below the held surface.
  std::optional<Gradients> gradients(const Vec3& at) const {
    const double g = depth(at);
    if (!(g > 0)) return std::nullopt;
    std::array<double, 8> N{};
    Stencil unit;
    const Gradients B = trilinear_gradients(unit, at, cell_mm_);
    double D = 0;
    Vec3 dD = Vec3::Zero();
    for (size_t k = 0; k < 8; ++k) {
      N[k] = 1;
      for (int a = 0; a < 3; ++a) N[k] *= (k >> a & 1) ? at[a] : 1 - at[a];
      if (!free(k)) continue;
      D += N[k] * c_.depth_mm[k];
      dD += c_.depth_mm[k] * B.row(int(k)).transpose();
    }
    if (!(D > 0.05 * least_)) return std::nullopt;
    const double q = g / D;
    const Vec3 dq = slope_.cwiseQuotient(cell_mm_) / D - g / (D * D) * dD;
    Gradients out = Gradients::Zero();
    Vec3 sum = Vec3::Zero();
    for (size_t k = 0; k < 8; ++k) {
      if (!free(k)) continue;
      const Vec3 row = q * B.row(int(k)).transpose() + N[k] * dq;
      out.row(int(k)) = row.transpose();
      sum += row;
    }
    for (size_t k = 0; k < 8; ++k)
      if (!free(k)) out.row(int(k)) = -sum.transpose() / held_;
    return out;
  }

 private:
  double depth(const Vec3& at) const { return mean_ + slope_.dot(at - Vec3::Constant(0.5)); }

  Vec3 cell_mm_;
  HeldCorners c_;
  double mean_ = 0, least_ = 0, held_ = 0;
  Vec3 slope_ = Vec3::Zero();  // per cell unit
  bool fits_ = true;
};

// In a rotation, p0 V |sum u B^T|^2 / 2 comes off u K u / 2 (fem_model.h). They cancel where K has the mean gradient
// that B is; here B is only near to it, and with more V than this the cell at rest would lie on a saddle: 1 / (p0 m),
// m the largest eigenvalue of B^T K^-1 B over the corners that move.
double most_volume_mm3(const Stencil& s, const Vec3& cell_mm, const HeldFunctions& functions) {
  const Gradients B = trilinear_gradients(s, s.sample, cell_mm);
  std::vector<int> free;
  for (int k = 0; k < 8; ++k)
    if (functions.free(size_t(k))) free.push_back(k);
  const Eigen::MatrixXd K = s.K(free, free), of = B(free, Eigen::all);
  const Mat3 M = of.transpose() * K.ldlt().solve(of);
  const double m = Eigen::SelfAdjointEigenSolver<Mat3>(M, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
  return m > 0 ? 1 / (s.p0_kPa * m) : INFINITY;
}

}  // namespace

bool hold_at_surface(Stencil& s, const Vec3& cell_mm, const HeldCorners& corners, const std::vector<LayerPoint>& points,
                     const std::vector<LayerMatter>& matter, const std::vector<StretchFrame>& frames, double unheld) {
  const HeldFunctions functions(cell_mm, corners);
  if (!functions.fits() || s.slide_kPa != 0) return false;
  std::vector<Mat3> A, rest;
  for (size_t i = 0; i < matter.size(); ++i) {
    const StretchFrame& frame = frames[i];
    A.push_back(matter[i].response.matrix_mu_kPa * prestretch_tensor(matter[i].material, frame));
    const double p0_kPa = frame.normal.dot(A.back() * frame.normal);  // each layer's own: without prestretch it rests
    rest.push_back(A.back() - p0_kPa * Mat3::Identity());
  }
  Mat8 K = Mat8::Zero();
  Gradients mean = Gradients::Zero(), force = Gradients::Zero();
  double volume = 0;
  for (const LayerPoint& p : points) {
    if (matter[p.matter].response.points) return false;
    const auto G = functions.gradients(p.at);
    if (!G) continue;
    const Gradients GA = *G * A[p.matter];
    K += p.volume_mm3 * (GA * G->transpose());
    force += p.volume_mm3 * (*G * rest[p.matter]);
    mean += p.volume_mm3 * *G;
    volume += p.volume_mm3;
  }
  if (!(volume > 0)) return false;
  mean /= volume;

  // The trilinear gradient that is nearest to the mean one, over the corners that move.
  Stencil unit;
  double best = -1, factor = 1;
  Vec3 place = s.sample;
  for (int k = 0; k < kPlaces; ++k)
    for (int j = 0; j < kPlaces; ++j)
      for (int i = 0; i < kPlaces; ++i) {
        const Vec3 at = (Vec3(i, j, k) + Vec3::Constant(0.5)) / kPlaces;
        const Gradients B = trilinear_gradients(unit, at, cell_mm);
        double with = 0, own = 0;
        for (size_t n = 0; n < 8; ++n)
          if (functions.free(n))
            for (int a = 0; a < 3; ++a) with += B(int(n), a) * mean(int(n), a), own += B(int(n), a) * B(int(n), a);
        const double fit = with > 0 ? with * with / own : 0;  // what it takes off |mean|^2
        if (fit > best) best = fit, factor = with / own, place = at;
      }
  if (!(best > 0)) return false;
  const double scale = s.volume_mm3 / volume;  // points at which the functions have no value
  s.K = unheld * s.K + (1 - unheld) * scale * K;
  s.rest_mN = std::make_shared<const Gradients>(scale * force);
  s.sample = place;
  s.mean_gradients.reset();
  s.volume_mm3 *= factor * factor;
  s.K = (0.5 * (s.K + s.K.transpose())).eval();
  for (int i = 0; i < 8; ++i) s.K(i, i) -= s.K.row(i).sum();
  if (s.p0_kPa > 0) s.volume_mm3 = std::min(s.volume_mm3, most_volume_mm3(s, cell_mm, functions));
  return true;
}

}  // namespace limberg
