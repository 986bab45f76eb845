#include "sim/imaging/solid/cortex_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "sim/base/elementary.h"
#include "sim/imaging/solid/cortex_move.h"

namespace limberg {

namespace {

constexpr int kProfileHalf = 20;  // places to either side
constexpr int kMostIterations = 30;
constexpr double kLeastCortex_mm = 0.1;
constexpr double kBoxCounts = 0.5;       // of the standard deviation: a narrower box adds 1 % to it
constexpr double kGoodFit = 0.12;        // of the contrast: a profile that leaves more is none of the three materials
constexpr int32_t kTrialVertices = 400;  // that the blur is found with
constexpr int kShiftRounds = 3;          // of smoothing the moves over the mesh

/// The normal distribution and its density, which every sample of a fit asks for up to four times: a table of both
/// with their slopes, a cubic between (of the fourth order: errors below 1e-9).
class NormalTable {
 public:
  NormalTable() {
    double P = 0;
    for (int i = 0; i < kSize; ++i) {
      const double x = double(i) / kPerUnit - kReach;
      Node& n = node_[size_t(i)];
      n.p = 0.3989422804014327 * elementary::exp(-0.5 * x * x), n.slope = -x * n.p;
      if (i > 0) {  // trapezoid with its end correction
        const Node& o = node_[size_t(i) - 1];
        P += (o.p + n.p) / (2 * kPerUnit) + (o.slope - n.slope) / (12 * kPerUnit * kPerUnit);
      }
      n.P = P;
    }
  }
  void at(double x, double& P, double& p) const {
    const double place = (x + kReach) * kPerUnit;
    if (!(place > 0 && place < kSize - 1)) {
      P = x > 0 ? 1 : 0, p = 0;
      return;
    }
    const int i = int(place);
    const double t = place - i, s = 1 - t, h = 1 / kPerUnit;
    const Node &a = node_[size_t(i)], &b = node_[size_t(i) + 1];
    const double from = s * s * (1 + 2 * t), to = t * t * (3 - 2 * t), out = h * t * s * s, in = -h * t * t * s;
    P = from * a.P + to * b.P + out * a.p + in * b.p;
    p = from * a.p + to * b.p + out * a.slope + in * b.slope;
  }

 private:
  static constexpr double kReach = 8, kPerUnit = 64;  // beyond it P is 0 or 1 by 1e-15
  static constexpr int kSize = int(2 * kReach * kPerUnit) + 1;
  struct Node {
    double P, p, slope;
  };
  std::array<Node, size_t(kSize)> node_;
};

struct Normal {
  double P, p;
  explicit Normal(double x) {
    static const NormalTable table;
    table.at(x, P, p);
  }
};

using Vec4 = Eigen::Vector4d;  // outer, thickness, soft, deep
using Mat4 = Eigen::Matrix4d;

/// A step that the scanner has blurred, at t from it: how much of it there is, and its slope per mm.
struct BlurredStep {
  double P, p;
  BlurredStep(double t, const Spread& s) {
    if (s.box_mm < kBoxCounts * s.sd_mm) {
      const Normal g(t / s.sd_mm);
      P = g.P, p = g.p / s.sd_mm;
      return;
    }
    // The mean of the normal distribution over the box: x P(x) + p(x) is its integral.
    const double half = 0.5 * s.box_mm, u = (t + half) / s.sd_mm, v = (t - half) / s.sd_mm;
    const Normal a(u), b(v);
    P = s.sd_mm / s.box_mm * (u * a.P + a.p - v * b.P - b.p);
    p = (a.P - b.P) / s.box_mm;
  }
};

struct Model {
  std::span<const ProfileSample> sample;
  Spread spread;
  double cortical;
  const CortexPrior* prior = nullptr;

  /// Sum of squares, and the normal equations.
  double residual(const Vec4& q, Mat4& A, Vec4& b) const {
    A.setZero(), b.setZero();
    double sum = 0;
    for (const ProfileSample& s : sample) {
      const BlurredStep out(s.at_mm - q[0], spread), in(s.at_mm - q[0] + q[1], spread);
      const double r = q[3] + (cortical - q[3]) * in.P - (cortical - q[2]) * out.P - s.value;
      sum += s.weight * r * r;
      Vec4 J;
      J[0] = -(cortical - q[3]) * in.p + (cortical - q[2]) * out.p;
      J[1] = (cortical - q[3]) * in.p;
      J[2] = out.P;
      J[3] = 1 - in.P;
      A += s.weight * J * J.transpose(), b -= s.weight * r * J;
    }
    if (prior) {
      const double noise2 = prior->noise * prior->noise;
      const Vec4 at(0, prior->thickness_mm, prior->soft, prior->deep),
          sd(prior->outer_sd_mm, prior->thickness_sd_mm, prior->soft_sd, prior->deep_sd);
      for (int k = 0; k < 4; ++k) {
        const double w = noise2 / (sd[k] * sd[k]), r = q[k] - at[k];
        sum += w * r * r;
        A(k, k) += w, b[k] -= w * r;
      }
    }
    return sum;
  }
  double left(const Vec4& q) const {  // mean square of what the picture has beside the model
    double sum = 0, all = 0;
    for (const ProfileSample& s : sample) {
      const BlurredStep out(s.at_mm - q[0], spread), in(s.at_mm - q[0] + q[1], spread);
      const double r = q[3] + (cortical - q[3]) * in.P - (cortical - q[2]) * out.P - s.value;
      sum += s.weight * r * r, all += s.weight;
    }
    return all > 0 ? sum / all : std::numeric_limits<double>::infinity();
  }
};

}  // namespace

Cortex fit_cortex(std::span<const ProfileSample> sample, const Spread& spread, double cortical,
                  const CortexPrior* prior) {
  const Model m{sample, spread, cortical, prior};
  Cortex best;
  if (sample.size() < 5) return best;
  const auto [first, last] =
      std::minmax_element(sample.begin(), sample.end(), [](const auto& a, const auto& b) { return a.at_mm < b.at_mm; });
  double least = std::numeric_limits<double>::infinity();
  // From a thin cortex and from a thick one: where the deep side is dense the two are not the same valley.
  for (const double thick : {1., 4.}) {
    Vec4 q(0, thick, last->value, std::min(first->value, 0.8 * cortical));
    if (prior) q[2] = prior->soft, q[3] = prior->deep;
    Mat4 A, next_A;
    Vec4 b, next_b;
    double sum = m.residual(q, A, b), damping = 1e-2;
    bool still = false;
    for (int k = 0; k < kMostIterations && !still; ++k) {
      Mat4 D = A;
      for (int a = 0; a < 4; ++a) D(a, a) = A(a, a) * (1 + damping) + 1e-12;
      Vec4 next = q + D.ldlt().solve(b);
      next[1] = std::max(next[1], kLeastCortex_mm);
      next[3] = std::min(next[3], 0.95 * cortical);
      const double there = next.allFinite() ? m.residual(next, next_A, next_b) : sum + 1;
      if (there < sum) {
        still = (next - q).head<2>().norm() < 1e-4;
        q = next, sum = there, A = next_A, b = next_b, damping = std::max(1e-6, 0.3 * damping);
      } else {
        damping *= 5;
        still = damping > 1e8;
      }
    }
    if (sum < least) {
      least = sum;
      best.outer_mm = q[0], best.inner_mm = q[0] - q[1], best.soft = q[2], best.deep = q[3];
      best.rms = std::sqrt(m.left(q));
    }
  }
  best.found = best.outer_mm > first->at_mm && best.outer_mm < last->at_mm && best.soft < cortical &&
               best.rms < kGoodFit * (cortical - best.soft);
  return best;
}

Cortex fit_cortex(std::span<const double> values, double step, double blur, double cortical) {
  std::vector<ProfileSample> sample(values.size());
  for (size_t i = 0; i < values.size(); ++i)
    sample[i] = {(double(i) - 0.5 * double(values.size() - 1)) * step, values[i], 1};
  return fit_cortex(sample, {blur, 0}, cortical);
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

namespace cortex {

std::vector<Vec3> normals_of(const simplex::Mesh& m) {
  std::vector<Vec3> normal(size_t(m.slots()), Vec3::Zero());
  for (int32_t i = 0; i < m.slots(); ++i)
    if (m.alive(i))
      if (const simplex::LocalFrame f = m.frame(i); !f.degenerate) normal[size_t(i)] = f.N;
  return normal;
}

void move_to(simplex::Mesh& m, const std::vector<Vec3>& normal, std::vector<double> shift, std::vector<uint8_t> found,
             double reach, CortexReport& out) {
  const size_t slots = size_t(m.slots());
  std::vector<double> next(slots, 0);
  const std::vector<uint8_t> own = found;
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
  out.vertices = out.found = 0;
  double sum = 0;
  for (size_t i = 0; i < slots; ++i) {
    if (!m.alive(int32_t(i))) continue;
    ++out.vertices, out.found += own[i] == 1;
    sum += shift[i];
    m.x_mm[i] += shift[i] * normal[i];
    if (std::isfinite(out.cortex_mm[i])) cortex.push_back(out.cortex_mm[i]);
  }
  if (out.vertices > 0) out.shift_mm += sum / out.vertices;
  if (!cortex.empty()) {
    std::nth_element(cortex.begin(), cortex.begin() + std::ptrdiff_t(cortex.size() / 2), cortex.end());
    out.thickness_mm = double(cortex[cortex.size() / 2]);
  }
  m.before_mm = m.x_mm;
  simplex::record_shape(m);
}

std::vector<size_t> some_of(const std::vector<size_t>& all) {
  std::vector<size_t> some;
  const size_t stride = std::max<size_t>(1, all.size() / size_t(kTrialVertices));
  for (size_t k = 0; k < all.size(); k += stride) some.push_back(all[k]);
  return some;
}

}  // namespace cortex

CortexReport put_on_cortex(simplex::Mesh& m, const Volume& v, const std::vector<double>& densities, double reach,
                           Workers& workers) {
  CortexReport out;
  const VolumeSampler sampler(v);
  const size_t slots = size_t(m.slots());
  const std::vector<Vec3> normal = cortex::normals_of(m);
  const double step = reach / kProfileHalf;
  const auto look = [&](size_t i, double point, double density) {
    std::array<double, 2 * kProfileHalf + 1> f{};
    for (int k = -kProfileHalf; k <= kProfileHalf; ++k)
      f[size_t(k + kProfileHalf)] = sampler.value(m.x_mm[i] + k * step * normal[i]);
    return fit_cortex(f, step, blur_of(v, point).along(normal[i]), density);
  };
  std::vector<size_t> all;
  for (size_t i = 0; i < slots; ++i)
    if (m.alive(int32_t(i)) && normal[i] != Vec3::Zero()) all.push_back(i);
  cortex::find_scanner(cortex::some_of(all), densities, look, workers, out);
  std::vector<double> shift(slots, 0);
  std::vector<uint8_t> found(slots, 0);
  out.cortex_mm.assign(slots, std::numeric_limits<float>::quiet_NaN());
  workers.parallel_for(all.size(), 256, [&](size_t b, size_t e) {
    for (size_t k = b; k < e; ++k) {
      const size_t i = all[k];
      const Cortex c = look(i, out.point_mm, out.cortical);
      if (!c.found) continue;
      found[i] = 1, shift[i] = c.outer_mm, out.cortex_mm[i] = float(c.outer_mm - c.inner_mm);
    }
  });
  cortex::move_to(m, normal, std::move(shift), std::move(found), reach, out);
  return out;
}

}  // namespace limberg
