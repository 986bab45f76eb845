#include <cmath>

#include "sim/lattice/stencil_integrals.h"

namespace limberg {
namespace {

constexpr int kPairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};

// Gradients of the eight corner functions at x (in cell units, 0..1 per axis).
Eigen::Matrix<double, 3, 8> gradients(const Vec3& cell_mm, const Vec3& x) {
  Eigen::Matrix<double, 3, 8> grad;
  for (int n = 0; n < 8; ++n)
    for (int a = 0; a < 3; ++a) {
      double v = (n >> a & 1 ? 1 : -1) / cell_mm[a];
      for (int b = 0; b < 3; ++b)
        if (b != a) v *= n >> b & 1 ? x[b] : 1 - x[b];
      grad(a, n) = v;
    }
  return grad;
}

// The q-th of 2 x 2 x 2 Gauss points of a box.
Vec3 gauss_point(const Vec3& lo, const Vec3& hi, int q) {
  constexpr double kGauss = 0.28867513459481288;  // half of 1/sqrt(3)
  Vec3 x;
  for (int a = 0; a < 3; ++a) x[a] = 0.5 * (lo[a] + hi[a]) + (hi[a] - lo[a]) * (q >> a & 1 ? kGauss : -kGauss);
  return x;
}

// Everything of a stencil but K, for a part of the cell around `centre` (cell units) with pressure p0 at rest.
void add_means(Stencil& s, double volume, const Vec3& centre, const Material& m, double p0) {
  if (s.volume_mm3 == 0) s.sample.setZero();
  s.volume_mm3 += volume;
  s.mu_kPa += volume * m.mu_kPa();
  s.lambda_kPa += volume * (m.lambda_kPa() + m.mu_kPa());
  s.p0_kPa += volume * p0;
  s.sample += volume * p0 * centre;
  s.density_kg_mm3 += volume * m.density_kg_mm3;
}

}  // namespace

void add_box(Stencil& s, const Vec3& cell_mm, const Vec3& lo, const Vec3& hi, const Material& m,
             const StretchFrame& frame) {
  const Mat3 A = prestretch_tensor(m, frame);
  const double volume = cell_mm.prod() * (hi - lo).prod(), mu = m.mu_kPa();
  for (int q = 0; q < 8; ++q) {
    const auto grad = gradients(cell_mm, gauss_point(lo, hi, q));
    s.K += grad.transpose() * (mu * volume / 8 * A) * grad;
  }
  add_means(s, volume, 0.5 * (lo + hi), m, mu * frame.normal.dot(A * frame.normal));
}

std::vector<GradientTable> gradient_tables(const Vec3& cell_mm) {
  std::vector<GradientTable> tables;
  for (int k = 0; k < kSplit; ++k)
    for (int j = 0; j < kSplit; ++j)
      for (int i = 0; i < kSplit; ++i) {
        GradientTable& t = tables.emplace_back();
        for (Mat8& m : t) m.setZero();
        for (int q = 0; q < 8; ++q) {
          const auto g = gradients(cell_mm, gauss_point(Vec3(i, j, k) / kSplit, Vec3(i + 1, j + 1, k + 1) / kSplit, q));
          for (size_t p = 0; p < 6; ++p) {
            const auto u = g.row(kPairs[p][0]), v = g.row(kPairs[p][1]);
            t[p] += u.transpose() * v;
            if (p > 2) t[p] += v.transpose() * u;
          }
        }
        for (Mat8& m : t) m *= cell_mm.prod() / (8 * kSplit * kSplit * kSplit);
      }
  return tables;
}

Stencil layered_stencil(const Vec3& cell_mm, const std::vector<GradientTable>& tables, const std::vector<Layer>& layers,
                        const std::array<int, kSplit * kSplit * kSplit>& layer_of_box, const StretchFrame& frame) {
  Stencil s;
  for (size_t l = 0; l < layers.size(); ++l) {
    GradientTable sum;
    int boxes = 0;
    Vec3 centre = Vec3::Zero();
    for (size_t b = 0; b < tables.size(); ++b) {
      if (layer_of_box[b] != int(l)) continue;
      const int i = int(b);
      centre += (Vec3(i % kSplit, i / kSplit % kSplit, i / (kSplit * kSplit)) + Vec3::Constant(0.5)) / kSplit;
      for (size_t p = 0; p < 6; ++p) sum[p] = boxes ? Mat8(sum[p] + tables[b][p]) : tables[b][p];
      ++boxes;
    }
    if (!boxes) continue;
    const Material& m = layers[l].material;
    const Mat3 A = prestretch_tensor(m, frame);
    const double volume = cell_mm.prod() * boxes / double(tables.size()), mu = m.mu_kPa();
    for (size_t p = 0; p < 6; ++p) s.K += mu * A(kPairs[p][0], kPairs[p][1]) * sum[p];
    add_means(s, volume, centre / boxes, m, mu * frame.normal.dot(A * frame.normal));
  }
  return s;
}

void finish_stencil(Stencil& s) {
  s.mu_kPa /= s.volume_mm3;
  s.lambda_kPa /= s.volume_mm3;
  s.sample /= s.p0_kPa;
  for (double& x : s.sample)
    if (std::abs(x - 0.5) < 1e-12) x = 0.5;  // homogeneous up to rounding: the kernel's shorter way
  s.p0_kPa /= s.volume_mm3;
  s.density_kg_mm3 /= s.volume_mm3;
  s.K = (0.5 * (s.K + s.K.transpose())).eval();
  for (int i = 0; i < 8; ++i) s.K(i, i) -= s.K.row(i).sum();
}

Mat3 prestretch_tensor(const Material& m, const StretchFrame& f) {
  const double a = m.prestretch_along, c = m.prestretch_across, n = 1 / (a * c);
  return a * a * f.along * f.along.transpose() + c * c * f.across * f.across.transpose() +
         n * n * f.normal * f.normal.transpose();
}

Stencil homogeneous_stencil(const Vec3& cell_mm, const Material& material, const StretchFrame& frame) {
  Stencil s;
  add_box(s, cell_mm, Vec3::Zero(), Vec3::Ones(), material, frame);
  finish_stencil(s);
  return s;
}

}  // namespace limberg
