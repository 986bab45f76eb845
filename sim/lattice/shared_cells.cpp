#include "sim/lattice/shared_cells.h"

#include <algorithm>

#include "sim/fem/elements/effective_bulk.h"

namespace limberg {
namespace {

constexpr double kSlide = 0.97;
constexpr double kFilled = 0.25;  // of a cell; 0.14 drew corners out, 0.25 and 0.5 did not (2026-11-28)

using Vec8 = Eigen::Matrix<double, 8, 1>;

// Integrals with a weight per layer.
struct Weighted {
  double M = 0;
  Vec3 x = Vec3::Zero();
  Mat3 xx = Mat3::Zero();
  Vec8 g = Vec8::Zero();  // of the gradient along the direction
  Eigen::Matrix<double, 8, 3> gx = Eigen::Matrix<double, 8, 3>::Zero();
};

Weighted weigh(const std::vector<LayerPart>& parts, const Vec3& direction, const Mat3& axes, int axis) {
  Weighted w;
  for (const LayerPart& p : parts) {
    const Material& m = p.matter->material;
    const double a = m.prestretch_along, c = m.prestretch_across;
    const Vec3 stretch(a, c, 1 / (a * c));
    const double weight = p.matter->response.matrix_mu_kPa * stretch[axis] * stretch[axis];
    const LayerMoments& o = p.moments;
    w.M += weight * o.volume_mm3;
    w.x += weight * axes.transpose() * o.x;
    w.xx += weight * axes.transpose() * o.xx * axes;
    w.g += weight * o.B * direction;
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) w.gx.col(j) += weight * axes(k, j) * (o.Bx[size_t(k)] * direction);
  }
  w.xx -= w.x * w.x.transpose() / w.M;
  w.gx -= w.g * w.x.transpose() / w.M;
  return w;
}

// Symmetric, rows of sum zero: what rounding has changed.
void keep_rows(Stencil& s) {
  s.K = (0.5 * (s.K + s.K.transpose())).eval();
  for (int i = 0; i < 8; ++i) s.K(i, i) -= s.K.row(i).sum();
}

}  // namespace

double bending_over_mu(double nu) { return 1.5 * (1 + nu) + 0.5 / (1 - nu); }

void LayerMoments::add(const LayerMoments& o, double sign) {
  volume_mm3 += sign * o.volume_mm3, x += sign * o.x, xx += sign * o.xx, B += sign * o.B;
  for (size_t j = 0; j < 3; ++j) Bx[j] += sign * o.Bx[j];
}

LayerMoments box_moments(const Vec3& h, const Vec3& lo, const Vec3& hi) {
  constexpr double gauss = 0.28867513459481288;  // half of 1/sqrt(3)
  Stencil unit;
  LayerMoments m;
  const double v = h.prod() * (hi - lo).prod() / 8;
  for (int q = 0; q < 8; ++q) {
    const Vec3 at = 0.5 * (lo + hi) + (hi - lo).cwiseProduct(
                                          Vec3(q & 1 ? gauss : -gauss, q & 2 ? gauss : -gauss, q & 4 ? gauss : -gauss));
    const Vec3 x = (at - Vec3::Constant(0.5)).cwiseProduct(h);
    const auto B = trilinear_gradients(unit, at, h);
    m.volume_mm3 += v, m.x += v * x, m.xx += v * x * x.transpose(), m.B += v * B;
    for (int j = 0; j < 3; ++j) m.Bx[size_t(j)] += v * x[j] * B;
  }
  return m;
}

void share_cell(Stencil& s, const Vec3& cell_mm, const std::vector<LayerPart>& parts, const StretchFrame& frame,
                bool cut, bool slides) {
  Mat3 axes;
  axes << frame.along, frame.across, frame.normal;
  double mean = 0, compliance = 0, plate = 0, shape = 0;
  for (const LayerPart& p : parts) {
    const Material& m = p.matter->material;
    const double n = 1 / (m.prestretch_along * m.prestretch_across), mu = p.matter->response.matrix_mu_kPa,
                 share = p.moments.volume_mm3 / s.volume_mm3;
    if (!(mu > 0)) return;
    mean += share * mu * n * n, compliance += share / (mu * n * n);
    plate += share * mu * bending_over_mu(m.poisson), shape += share * mu;
  }
  double slide = kSlide * (mean - 1 / compliance);
  double body_mm3 = 0;
  for (const LayerPart& p : parts) body_mm3 += p.moments.volume_mm3;
  const bool shared = slides && parts.size() > 1 && slide >= 1e-6 * mean && body_mm3 >= kFilled * cell_mm.prod();
  if (!(shared || cut) || !(s.p0_kPa > 0)) return;
  if (!shared) slide = 0;

  s.slide_kPa = slide;
  if (shared) s.slide_axes = axes;
  const double bulk = shared ? fem::effective_bulk_kPa(s, true) : 0, r = bulk / (s.p0_kPa + bulk);
  const double off = frame.normal.dot((s.sample - Vec3::Constant(0.5)).cwiseProduct(cell_mm));
  for (int a = 0; a < 2; ++a) {
    const Weighted w = weigh(parts, axes.col(a), axes, a);
    const double there = 4 * r * (1 - r) * off * off * s.p0_kPa * s.volume_mm3 / w.xx(2, 2);
    const double modulus = std::max(1.0, plate / shape - 0.75 * there);
    s.K += (modulus - 1) / w.xx(2, 2) * w.gx.col(2) * w.gx.col(2).transpose();
  }
  const Weighted w = weigh(parts, frame.normal, axes, 2);
  const Eigen::Matrix<double, 8, 2> along = w.gx.leftCols<2>();
  s.K -= along * w.xx.topLeftCorner<2, 2>().inverse() * along.transpose();
  if (!shared) return keep_rows(s);
  Stencil flat;  // the centre of a cell of this size, where what slides is measured
  const Vec8 b = trilinear_gradients(flat, Vec3::Constant(0.5), cell_mm) * frame.normal;
  s.K += s.volume_mm3 * (mean - slide) * b * b.transpose() - w.g * w.g.transpose() / w.M;
  keep_rows(s);
}

}  // namespace limberg
