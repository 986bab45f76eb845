#include <Eigen/Eigenvalues>
#include <cmath>

#include "sim/base/error.h"
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
  for (const Layer& l : body.layers) {
    LayerMatter& m = out.emplace_back();
    m.material = l.material;
    try {
      m.response = layer_response(l.material, body.laws.get());
    } catch (const InputError& e) {
      throw InputError(body.name, 0, "layer '" + l.name + "': " + e.what());
    }
    if (m.response.points) m.points_law = int32_t(laws.size()), laws.push_back(m.response.points);
    if (!l.material.prony.empty()) m.whole_law = int32_t(laws.size()), laws.push_back(m.response.whole);
  }
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

Stencil layered_stencil(const Vec3& cell_mm, const std::vector<GradientTable>& tables,
                        const std::vector<LayerMatter>& layers,
                        const std::array<int, kSplit * kSplit * kSplit>& layer_of_box, const StretchFrame& frame) {
  Stencil s;
  for (size_t l = 0; l < layers.size(); ++l) {
    GradientTable sum;
    int boxes = 0;
    Vec3 centre = Vec3::Zero();
    Mat3 second = Mat3::Zero();
    for (size_t b = 0; b < tables.size(); ++b) {
      if (layer_of_box[b] != int(l)) continue;
      const int i = int(b);
      const Vec3 at = (Vec3(i % kSplit, i / kSplit % kSplit, i / (kSplit * kSplit)) + Vec3::Constant(0.5)) / kSplit;
      centre += at;
      second += at * at.transpose();
      for (size_t p = 0; p < 6; ++p) sum[p] = boxes ? Mat8(sum[p] + tables[b][p]) : tables[b][p];
      ++boxes;
    }
    if (!boxes) continue;
    const LayerMatter& m = layers[l];
    const Mat3 A = prestretch_tensor(m.material, frame);
    const double volume = cell_mm.prod() * boxes / double(tables.size()), mu = m.response.matrix_mu_kPa;
    for (size_t p = 0; p < 6; ++p) s.K += mu * A(kPairs[p][0], kPairs[p][1]) * sum[p];
    centre /= boxes;
    second = second / boxes - centre * centre.transpose() + Mat3::Identity() / (12.0 * kSplit * kSplit);  // a box's own
    for (double& x : second.reshaped())
      if (std::fabs(x) < 1e-12) x = 0;
    add_part(s, volume, centre, second, m, frame);
  }
  return s;
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
