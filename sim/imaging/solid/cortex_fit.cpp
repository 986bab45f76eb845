#include "sim/imaging/solid/cortex_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sim/base/elementary.h"

namespace limberg {

namespace {

constexpr int kProfileHalf = 20;  // places to either side
constexpr int kMostIterations = 30;
constexpr double kLeastCortex_mm = 0.1;
constexpr double kGoodFit = 0.12;        // of the contrast: a profile that leaves more is none of the three materials
constexpr int32_t kTrialVertices = 400;  // that the blur is found with
constexpr int kShiftRounds = 3;          // of smoothing the moves over the mesh

/// Normal distribution (Abramowitz and Stegun 26.2.17, error below 7.5e-8) and its density.
struct Normal {
  double P, p;
  explicit Normal(double x) {
    p = 0.3989422804014327 * elementary::exp(-0.5 * x * x);
    const double k = 1 / (1 + 0.2316419 * std::abs(x));
    const double tail =
        p * k * (0.319381530 + k * (-0.356563782 + k * (1.781477937 + k * (-1.821255978 + k * 1.330274429))));
    P = x >= 0 ? 1 - tail : tail;
  }
};

using Vec4 = Eigen::Vector4d;  // outer, thickness, soft, deep
using Mat4 = Eigen::Matrix4d;

struct Model {
  std::span<const double> values;
  double step, blur, cortical;
  double at(size_t i) const { return (double(i) - 0.5 * double(values.size() - 1)) * step; }

  /// Sum of squares, and the normal equations.
  double residual(const Vec4& q, Mat4* A, Vec4* b) const {
    if (A) A->setZero(), b->setZero();
    double sum = 0;
    for (size_t i = 0; i < values.size(); ++i) {
      const Normal out((at(i) - q[0]) / blur), in((at(i) - q[0] + q[1]) / blur);
      const double r = q[3] + (cortical - q[3]) * in.P - (cortical - q[2]) * out.P - values[i];
      sum += r * r;
      if (!A) continue;
      Vec4 J;
      J[0] = (-(cortical - q[3]) * in.p + (cortical - q[2]) * out.p) / blur;
      J[1] = (cortical - q[3]) * in.p / blur;
      J[2] = out.P;
      J[3] = 1 - in.P;
      *A += J * J.transpose(), *b -= r * J;
    }
    return sum;
  }
};

}  // namespace

Cortex fit_cortex(std::span<const double> values, double step, double blur, double cortical) {
  const Model m{values, step, blur, cortical};
  const size_t n = values.size();
  Cortex best;
  double least = std::numeric_limits<double>::infinity();
  // From a thin cortex and from a thick one: where the deep side is dense the two are not the same valley.
  for (const double thick : {1., 4.}) {
    Vec4 q(0, thick, values[n - 1], std::min(values[0], 0.8 * cortical));
    Mat4 A;
    Vec4 b;
    double sum = m.residual(q, &A, &b), damping = 1e-2;
    bool still = false;
    for (int k = 0; k < kMostIterations && !still; ++k) {
      Mat4 D = A;
      for (int a = 0; a < 4; ++a) D(a, a) = A(a, a) * (1 + damping) + 1e-12;
      Vec4 next = q + D.ldlt().solve(b);
      next[1] = std::max(next[1], kLeastCortex_mm);
      next[3] = std::min(next[3], 0.95 * cortical);
      const double there = next.allFinite() ? m.residual(next, nullptr, nullptr) : sum + 1;
      if (there < sum) {
        still = (next - q).head<2>().norm() < 1e-4;
        q = next, sum = m.residual(q, &A, &b), damping = std::max(1e-6, 0.3 * damping);
      } else {
        damping *= 5;
        still = damping > 1e8;
      }
    }
    if (sum < least) {
      least = sum;
      best.outer_mm = q[0], best.inner_mm = q[0] - q[1], best.soft = q[2], best.deep = q[3];
    }
  }
  best.rms = std::sqrt(least / double(n));
  best.found = std::abs(best.outer_mm) < 0.5 * double(n - 1) * step && best.soft < cortical &&
               best.rms < kGoodFit * (cortical - best.soft);
  return best;
}

double Blur::along(const Vec3& normal) const {
  const Vec3 n = axes.transpose() * normal;
  return std::sqrt(n.cwiseProduct(n).dot(variance_mm2));
}

Blur blur_of(const Volume& v, double point_mm) {
  Blur b;
  for (int k = 0; k < 3; ++k) {
    const double side = v.step_mm.col(k).norm();
    b.axes.col(k) = v.step_mm.col(k) / side;
    // A box of a voxel, and interpolation between two of them: the mean of t (1 - t) is 1/6.
    b.variance_mm2[k] = side * side * (1. / 12 + 1. / 6) + point_mm * point_mm;
  }
  return b;
}

CortexReport put_on_cortex(simplex::Mesh& m, const Volume& v, const std::vector<double>& densities, double reach,
                           Workers& workers, double slice_mm) {
  CortexReport out;
  const VolumeSampler sampler(v);
  const size_t slots = size_t(m.slots());
  std::vector<Vec3> normal(slots, Vec3::Zero());
  for (int32_t i = 0; i < m.slots(); ++i)
    if (m.alive(i)) {
      const simplex::LocalFrame f = m.frame(i);
      if (!f.degenerate) normal[size_t(i)] = f.N;
    }
  const double step = reach / kProfileHalf;
  const auto look = [&](size_t i, double point, double density) {
    std::array<double, 2 * kProfileHalf + 1> f{};
    for (int k = -kProfileHalf; k <= kProfileHalf; ++k)
      f[size_t(k + kProfileHalf)] = sampler.value(m.x_mm[i] + k * step * normal[i]);
    Blur blur = blur_of(v, point);
    const Cortex first = fit_cortex(f, step, blur.along(normal[i]), density);
    if (!(slice_mm > 0)) return first;
    blur.variance_mm2[2] = slice_mm * slice_mm * (1. / 12 + 1. / 6) + point * point;
    const Cortex tall = fit_cortex(f, step, blur.along(normal[i]), density);
    return tall.rms < first.rms ? tall : first;
  };
  // The density and the blur that leave the least at some of the vertices.
  double least = std::numeric_limits<double>::infinity(), cortical = densities.front();
  std::vector<size_t> some;
  const size_t stride = std::max<size_t>(1, slots / kTrialVertices);
  for (size_t i = 0; i < slots; i += stride)
    if (m.alive(int32_t(i)) && normal[i] != Vec3::Zero()) some.push_back(i);
  std::vector<double> rms(some.size());
  for (const double density : densities)
    for (const double point : {0.3, 0.45, 0.6, 0.75, 0.9, 1.1, 1.3}) {
      workers.parallel_for(some.size(), 16, [&](size_t b, size_t e) {
        for (size_t k = b; k < e; ++k) rms[k] = look(some[k], point, density).rms;
      });
      if (rms.empty()) break;
      std::nth_element(rms.begin(), rms.begin() + std::ptrdiff_t(rms.size() / 2), rms.end());
      if (rms[rms.size() / 2] < least) least = rms[rms.size() / 2], out.point_mm = point, cortical = density;
    }
  out.cortical = cortical;
  std::vector<double> shift(slots, 0);
  std::vector<uint8_t> found(slots, 0);
  out.cortex_mm.assign(slots, std::numeric_limits<float>::quiet_NaN());
  workers.parallel_for(slots, 256, [&](size_t b, size_t e) {
    for (size_t i = b; i < e; ++i) {
      if (!m.alive(int32_t(i)) || normal[i] == Vec3::Zero()) continue;
      const Cortex c = look(i, out.point_mm, cortical);
      if (!c.found) continue;
      found[i] = 1, shift[i] = c.outer_mm, out.cortex_mm[i] = float(c.outer_mm - c.inner_mm);
    }
  });
  // Vertices without an answer, and ones that stand out of their neighbours, follow these.
  std::vector<double> next(slots, 0);
  for (int round = 0; round < kShiftRounds; ++round) {
    for (size_t i = 0; i < slots; ++i) {
      if (!m.alive(int32_t(i))) continue;
      std::array<double, 4> near;
      near.fill(std::numeric_limits<double>::infinity());
      size_t n = 0;
      for (const int32_t u : m.nbr[i])
        if (found[size_t(u)]) near[n++] = shift[size_t(u)];
      if (found[i]) near[n++] = shift[i];
      std::sort(near.begin(), near.end());
      if (n == 0) {
        next[i] = 0;
        continue;
      }
      const double middle = n % 2 ? near[n / 2] : 0.5 * (near[n / 2] + near[n / 2 - 1]);
      next[i] = found[i] && std::abs(shift[i] - middle) < 0.25 * reach ? shift[i] : middle;
    }
    shift.swap(next);
    for (size_t i = 0; i < slots; ++i)
      if (!found[i] && shift[i] != 0) found[i] = 2;
  }
  std::vector<float> cortex;
  for (size_t i = 0; i < slots; ++i) {
    if (!m.alive(int32_t(i))) continue;
    ++out.vertices, out.found += found[i] == 1;
    out.shift_mm += shift[i];
    m.x_mm[i] += shift[i] * normal[i];
    if (std::isfinite(out.cortex_mm[i])) cortex.push_back(out.cortex_mm[i]);
  }
  if (out.vertices > 0) out.shift_mm /= out.vertices;
  if (!cortex.empty()) {
    std::nth_element(cortex.begin(), cortex.begin() + std::ptrdiff_t(cortex.size() / 2), cortex.end());
    out.thickness_mm = double(cortex[cortex.size() / 2]);
  }
  m.before_mm = m.x_mm;
  simplex::record_shape(m);
  return out;
}

}  // namespace limberg
