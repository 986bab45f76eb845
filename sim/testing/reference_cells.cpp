#include "sim/testing/reference_cells.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "sim/fem/elements/effective_bulk.h"
#include "sim/fem/elements/material_points.h"
#include "sim/fem/forces/layer_slide.h"

namespace limberg::fem {
namespace {

using Gradients = ReferenceCells::Gradients;
using Mat24 = ReferenceCells::Mat24;
using Vec9 = Eigen::Matrix<double, 9, 1>;

Mat3 cofactor(const Mat3& F) {
  Mat3 c;
  c.col(0) = F.col(1).cross(F.col(2)), c.col(1) = F.col(2).cross(F.col(0)), c.col(2) = F.col(0).cross(F.col(1));
  return c;
}

Mat3 skew(const Vec3& v) {  // S_ik = epsilon_ikm v_m
  Mat3 s;
  s << 0, v[2], -v[1], -v[2], 0, v[0], v[1], -v[0], 0;
  return s;
}

/// B H B^T with B from gradients to vec F (column-major), corners of nodes 3 a + i.
Mat24 at_nodes(const Mat9& H, const Gradients& grad_N) {
  Eigen::Matrix<double, 24, 9> B = Eigen::Matrix<double, 24, 9>::Zero();
  for (int a = 0; a < 8; ++a)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) B(3 * a + i, 3 * j + i) = grad_N(a, j);
  Mat24 out;
  out.noalias() = B * (H * B.transpose()).eval();
  return out;
}

}  // namespace

ReferenceCells::ReferenceCells(const FemModel& model) : m_(model) {
  for (const Stencil& s : model.stencils) {
    const Vec3 h = cell_size_mm(model.cell_mm, s.level);
    Gradients X;
    for (int a = 0; a < 8; ++a)
      for (int i = 0; i < 3; ++i) {
        X(a, i) = (a >> i & 1) ? h[i] : 0;
      }
    B_.push_back(volume_gradients(s, model.cell_mm));
    B_sample_.push_back(sample_gradients(s, model.cell_mm));
    KX_.push_back(s.rest_mN ? Gradients(*s.rest_mN + s.p0_kPa * s.volume_mm3 * B_.back()) : Gradients(s.K * X));
    const Mat3 mean = X.transpose() * s.K * X / s.volume_mm3;
    const double mu = std::max(0.0, Eigen::SelfAdjointEigenSolver<Mat3>(mean).eigenvalues()[0]);
    mu_sample_.push_back(mu);
    K_rest_.push_back(s.K - mu * s.volume_mm3 * B_.back() * B_.back().transpose());
  }
}

Mat3 ReferenceCells::F_at(const Gradients& grad_N, const HexCell& c, std::span<const Vec3> u) {
  Mat3 f = Mat3::Identity();
  for (int a = 0; a < 8; ++a) f += u[size_t(c.node[size_t(a)])] * grad_N.row(a);
  return f;
}

double ReferenceCells::energy(const HexCell& c, std::span<const Vec3> u, Gradients* force) const {
  const Stencil& s = m_.stencils[size_t(c.stencil)];
  const Gradients& kx = KX_[size_t(c.stencil)];
  Gradients U;
  for (int a = 0; a < 8; ++a) U.row(a) = u[size_t(c.node[size_t(a)])].transpose();
  const Mat3 f = F(c, u);
  const double theta = f.determinant() - 1;
  const Gradients KU = s.K * U;
  const bool shared = s.slide_kPa != 0;
  double energy = double(c.scale) * (U.cwiseProduct(0.5 * KU + kx).sum() +
                                     s.volume_mm3 * (0.5 * s.lambda_kPa * theta * theta - s.p0_kPa * theta));
  LayerEnergy slide, here, there;
  if (shared) {
    const double lambda = effective_bulk_kPa(s, true);
    slide = layer_slide(f, s.slide_axes);
    here = layer_stretch(f, s.slide_axes, s.p0_kPa, lambda);
    there = layer_stretch(F_at(B_sample_[size_t(c.stencil)], c, u), s.slide_axes, s.p0_kPa, lambda);
    energy += double(c.scale) * s.volume_mm3 * (s.slide_kPa * (slide.energy - 0.5) + there.energy - here.energy);
  }
  Gradients extra;
  if (!s.points.empty()) energy += double(c.scale) * points_force(m_, s, m_.cell_mm, U, extra);
  if (!force) return energy;
  Mat3 P = s.volume_mm3 * (s.lambda_kPa * theta - s.p0_kPa) * cofactor(f);
  if (shared) P += s.volume_mm3 * (s.slide_kPa * slide.slope - here.slope);
  *force = double(c.scale) * (KU + kx + B_[size_t(c.stencil)] * P.transpose());
  if (shared) *force += double(c.scale) * s.volume_mm3 * B_sample_[size_t(c.stencil)] * there.slope.transpose();
  if (!s.points.empty()) *force += double(c.scale) * extra;
  return energy;
}

ReferenceCells::Mat24 ReferenceCells::hessian(const HexCell& c, std::span<const Vec3> u, bool project) const {
  const Stencil& s = m_.stencils[size_t(c.stencil)];
  Mat24 H = stencil_hessian(c, u, project);
  if (s.slide_kPa != 0) H += layers_hessian(c, u, project);
  if (s.points.empty()) return H;
  Gradients U;
  for (int a = 0; a < 8; ++a) U.row(a) = u[size_t(c.node[size_t(a)])].transpose();
  return H + double(c.scale) * points_tangent(m_, s, m_.cell_mm, U, project);
}

// What layers that share a cell add to stencil_hessian.
ReferenceCells::Mat24 ReferenceCells::layers_hessian(const HexCell& c, std::span<const Vec3> u, bool project) const {
  const Stencil& s = m_.stencils[size_t(c.stencil)];
  const double lambda = effective_bulk_kPa(s, true);
  const Mat3 f = F(c, u), there = F_at(B_sample_[size_t(c.stencil)], c, u);
  Mat9 centre =
      s.slide_kPa * layer_slide_tangent(f, s.slide_axes) - layer_stretch_tangent(f, s.slide_axes, s.p0_kPa, lambda);
  Mat9 sample = layer_stretch_tangent(there, s.slide_axes, s.p0_kPa, lambda);
  for (Mat9* H : {&centre, &sample}) {
    if (!project) break;
    const Eigen::SelfAdjointEigenSolver<Mat9> eig(*H);
    *H = eig.eigenvectors() * eig.eigenvalues().cwiseMax(0).asDiagonal() * eig.eigenvectors().transpose();
  }
  return double(c.scale) * s.volume_mm3 *
         (at_nodes(centre, B_[size_t(c.stencil)]) + at_nodes(sample, B_sample_[size_t(c.stencil)]));
}

ReferenceCells::Mat24 ReferenceCells::stencil_hessian(const HexCell& c, std::span<const Vec3> u, bool project) const {
  const Stencil& s = m_.stencils[size_t(c.stencil)];
  const Gradients& grad_N = B_[size_t(c.stencil)];
  const Mat3 f = F(c, u);
  const double V = s.volume_mm3, pressure = s.lambda_kPa * (f.determinant() - 1) - s.p0_kPa;
  Mat24 H;
  if (!project) {
    const Gradients cb = grad_N * cofactor(f).transpose();
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b) {
        const Vec3 cross = grad_N.row(a).transpose().cross(Vec3(grad_N.row(b).transpose()));
        H.block<3, 3>(3 * a, 3 * b) =
            s.K(a, b) * Mat3::Identity() +
            V * (s.lambda_kPa * cb.row(a).transpose() * cb.row(b) + pressure * skew(f * cross));
      }
    return double(c.scale) * H;
  }
  const double mu = mu_sample_[size_t(c.stencil)];
  const Eigen::JacobiSVD<Mat3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 U = svd.matrixU();
  const Mat3 W = svd.matrixV();
  Vec3 sig = svd.singularValues();
  if (U.determinant() * W.determinant() < 0) U.col(2) *= -1, sig[2] *= -1;
  Mat9 HF = Mat9::Zero();
  auto add = [&](const Mat3& D, double value) {
    if (value <= 0) return;
    const Mat3 E = U * D * W.transpose();
    const Vec9 e = Eigen::Map<const Vec9>(E.data());
    HF += value * e * e.transpose();
  };
  const Vec3 grad(sig[1] * sig[2], sig[2] * sig[0], sig[0] * sig[1]);
  Mat3 scaling = mu * Mat3::Identity() + s.lambda_kPa * grad * grad.transpose();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    scaling(i, j) += pressure * sig[k], scaling(j, i) += pressure * sig[k];
    Mat3 D = Mat3::Zero();
    D(i, j) = D(j, i) = std::sqrt(0.5);
    add(D, mu - pressure * sig[k]);
    D(j, i) *= -1;
    add(D, mu + pressure * sig[k]);
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> eig(scaling);
  for (int i = 0; i < 3; ++i) add(eig.eigenvectors().col(i).asDiagonal(), eig.eigenvalues()[i]);
  H = V * at_nodes(HF, grad_N);
  const Mat8& K = K_rest_[size_t(c.stencil)];
  for (int a = 0; a < 8; ++a)
    for (int b = 0; b < 8; ++b)
      for (int i = 0; i < 3; ++i) H(3 * a + i, 3 * b + i) += K(a, b);
  return double(c.scale) * H;
}

}  // namespace limberg::fem
