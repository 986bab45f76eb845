#include <Eigen/Eigenvalues>
#include <cmath>

#include "sim/base/error.h"
#include "sim/lattice/stencil_integrals.h"

namespace limberg {
namespace {

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

ViscousPoint viscous_point(double volume, const Vec3& centre, const LayerMatter& l, const StretchFrame& frame) {
  ViscousPoint v;
  v.at = centre, v.volume_mm3 = volume, v.law = l.whole_law;
  Mat3 axes;
  axes << frame.along, frame.across, frame.normal;
  const double a = l.material.prestretch_along, c = l.material.prestretch_across;
  v.M = axes * Vec3(a, c, 1 / (a * c)).asDiagonal();
  double relaxed = 1;
  for (const PronyTerm& t : l.material.prony) relaxed -= t.share;
  for (const PronyTerm& t : l.material.prony) v.terms.push_back({t.share / relaxed, t.time_s});
  return v;
}

// Everything of a stencil but K, for a part of the cell around `centre` (cell units). `second`: its second moments
// about the centre, per volume. p0 is the pressure at rest.
void add_part(Stencil& s, double volume, const Vec3& centre, const Mat3& second, const LayerMatter& l,
              const StretchFrame& frame) {
  const LayerResponse& r = l.response;
  double p0, stiffness = r.matrix_mu_kPa;
  if (!r.points) {
    p0 = r.matrix_mu_kPa * frame.normal.dot(prestretch_tensor(l.material, frame) * frame.normal);
  } else {
    Mat3 axes;
    axes << frame.along, frame.across, frame.normal;
    const double a = l.material.prestretch_along, c = l.material.prestretch_across;
    const Mat3 M =
        axes * Vec3(a, c, 1 / (a * c)).asDiagonal();  // F0 and the law's axes: it sees F F0 along, across, normal
    p0 = rest_pressure_kPa(r, M, frame.normal);
    stiffness += r.points->typical_stiffness_kPa(M);
    MaterialPoint p;
    p.law = l.points_law, p.M = M;
    if (r.points_per_part == 1) {
      p.at = centre, p.volume_mm3 = volume;
      s.points.push_back(p);
    } else {
      const bool upright = second(0, 1) == 0 && second(1, 2) == 0 && second(2, 0) == 0;
      Mat3 span = second.diagonal().cwiseSqrt().asDiagonal();
      if (!upright) {
        const Eigen::SelfAdjointEigenSolver<Mat3> eig(second);
        span = eig.eigenvectors() * eig.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
      }
      p.volume_mm3 = volume / 8;
      for (int q = 0; q < 8; ++q) {
        p.at = centre + span * Vec3(q & 1 ? 1 : -1, q & 2 ? 1 : -1, q & 4 ? 1 : -1);
        s.points.push_back(p);
      }
    }
  }
  if (!l.material.prony.empty()) s.viscous.push_back(viscous_point(volume, centre, l, frame));
  if (s.volume_mm3 == 0) s.sample.setZero();
  s.volume_mm3 += volume;
  s.mu_kPa += volume * stiffness;
  s.lambda_kPa += volume * r.lambda_kPa;
  s.p0_kPa += volume * p0;
  s.sample += volume * p0 * centre;
  s.density_kg_mm3 += volume * l.material.density_kg_mm3;
}

}  // namespace

std::vector<LayerMatter> layer_matter(const Body& body, std::vector<LawPtr>& laws) {
  std::vector<LayerMatter> out;
  const auto add = [&](const Material& material, const std::string& of) {
    LayerMatter& m = out.emplace_back();
    m.material = material;
    try {
      m.response = layer_response(material, body.laws.get());
    } catch (const InputError& e) {
      throw InputError(body.name, 0, of + ": " + e.what());
    }
    if (m.response.points) m.points_law = int32_t(laws.size()), laws.push_back(m.response.points);
    if (!material.prony.empty()) m.whole_law = int32_t(laws.size()), laws.push_back(m.response.whole);
  };
  for (const Layer& l : body.layers) add(l.material, "layer '" + l.name + "'");
  for (const auto& r : body.regions) add(r->material(), "region '" + r->name() + "'");
  return out;
}

void add_box(Stencil& s, const Vec3& cell_mm, const Vec3& lo, const Vec3& hi, const LayerMatter& l,
             const StretchFrame& frame) {
  const Mat3 A = prestretch_tensor(l.material, frame);
  const double volume = cell_mm.prod() * (hi - lo).prod(), mu = l.response.matrix_mu_kPa;
  for (int q = 0; q < 8 && mu > 0; ++q) {
    const auto grad = gradients(cell_mm, gauss_point(lo, hi, q));
    s.K += grad.transpose() * (mu * volume / 8 * A) * grad;
  }
  const Mat3 second = (hi - lo).cwiseAbs2().asDiagonal();
  add_part(s, volume, 0.5 * (lo + hi), second / 12, l, frame);
}

namespace {

// Integrals of products of two gradients from moments: per axis the coefficients of 1, x and x^2.
class GradientProducts {
 public:
  explicit GradientProducts(const Vec3& cell_mm) {
    for (size_t a = 0; a < 3; ++a)
      for (size_t high = 0; high < 2; ++high) {
        shape_[a][high] = {high ? 0.0 : 1.0, high ? 1.0 : -1.0};
        slope_[a][high] = {(high ? 1 : -1) / cell_mm[int(a)], 0.0};
      }
  }
  /// Integral of dN_m/dx_p dN_n/dx_q.
  double operator()(const CellMoments& of, size_t m, size_t n, size_t p, size_t q) const {
    std::array<std::array<double, 3>, 3> c;
    for (size_t a = 0; a < 3; ++a) {
      const auto& u = a == p ? slope_[a][m >> a & 1] : shape_[a][m >> a & 1];
      const auto& v = a == q ? slope_[a][n >> a & 1] : shape_[a][n >> a & 1];
      c[a] = {u[0] * v[0], u[0] * v[1] + u[1] * v[0], u[1] * v[1]};
    }
    double sum = 0;
    for (size_t k = 0; k < 3; ++k)
      for (size_t j = 0; j < 3; ++j) {
        const double* row = &of.of[9 * k + 3 * j];
        sum += c[2][k] * c[1][j] * (c[0][0] * row[0] + c[0][1] * row[1] + c[0][2] * row[2]);
      }
    return sum;
  }

 private:
  std::array<std::array<std::array<double, 2>, 2>, 3> shape_, slope_;
};

}  // namespace

void add_moments(Stencil& s, const Vec3& cell_mm, const CellMoments& of, const LayerMatter& l,
                 const StretchFrame& frame) {
  const Mat3 A = prestretch_tensor(l.material, frame);
  const GradientProducts product(cell_mm);
  const double mu = l.response.matrix_mu_kPa;
  for (size_t m = 0; m < 8 && mu > 0; ++m)
    for (size_t n = m; n < 8; ++n) {
      double sum = 0;
      for (size_t p = 0; p < 3; ++p)
        for (size_t q = 0; q < 3; ++q)
          if (const double a = A(int(p), int(q)); a != 0) sum += mu * a * product(of, m, n, p, q);
      s.K(int(m), int(n)) += sum;
      if (n != m) s.K(int(n), int(m)) += sum;
    }
  add_part(s, of.volume_mm3(), of.centre(), of.second(), l, frame);
}

void finish_stencil(Stencil& s) {
  s.mu_kPa /= s.volume_mm3;
  s.lambda_kPa /= s.volume_mm3;
  s.sample /= s.p0_kPa;
  // Layers of which some push and some pull at rest have no such point in the cell; without any stress any point does.
  if (!(s.sample.minCoeff() >= 0 && s.sample.maxCoeff() <= 1)) s.sample.setConstant(0.5);
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
  LayerMatter l;
  l.material = material, l.response = layer_response(material);
  if (l.response.points) l.points_law = 0;
  add_box(s, cell_mm, Vec3::Zero(), Vec3::Ones(), l, frame);
  finish_stencil(s);
  return s;
}

}  // namespace limberg
