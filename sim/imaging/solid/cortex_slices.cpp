// The cortex in slices that are taller than their pixels are wide (cortex_fit.h).
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/base/elementary.h"
#include "sim/imaging/solid/cortex_move.h"

namespace limberg {

namespace {

constexpr double kAlong_mm = 3.5, kAlongBlurs = 2.5;  // how far a profile reaches: the larger of both
constexpr double kBeside =
    0.35;  // of a slice's height: standard deviation of the weight of what lies beside the normal
constexpr double kBesideMost = 0.8;
constexpr double kUpright = 0.35;  // of the normal along the slices: below it the pixels tell
constexpr int kSliceRounds = 2;
constexpr double kSoft = 45,
                 kSoftSd = 60;     // Hounsfield units of muscle and brain; fat and cerebrospinal fluid are within
constexpr size_t kLeastSure = 50;  // vertices that what is known beforehand is taken from

struct SliceStack {
  explicit SliceStack(const Volume& volume) : v(volume) {
    for (size_t k = 1; k < 3; ++k)
      if (v.step_mm.col(Eigen::Index(k)).norm() > v.step_mm.col(Eigen::Index(axis)).norm()) axis = k;
    const Eigen::Index a = Eigen::Index((axis + 1) % 3), b = Eigen::Index((axis + 2) % 3);
    up = v.step_mm.col(a).cross(v.step_mm.col(b)).normalized();
    gap_mm = v.step_mm.col(Eigen::Index(axis)).dot(up);
    if (gap_mm < 0) up = -up, gap_mm = -gap_mm;
    pixel_mm = 0.5 * (v.step_mm.col(a).norm() + v.step_mm.col(b).norm());
    to_voxel = v.step_mm.inverse();
  }
  const Volume& v;
  size_t axis = 0;
  Vec3 up;
  double gap_mm = 1, pixel_mm = 1;
  Mat3 to_voxel;

  /// At a place in the plane of slice k; false: outside.
  bool value(const Vec3& x, int32_t k, double& out) const {
    const Vec3 at = to_voxel * (x - v.origin_mm);
    const size_t a = (axis + 1) % 3, b = (axis + 2) % 3;
    const double fa = at[Eigen::Index(a)], fb = at[Eigen::Index(b)];
    const auto ia = int32_t(std::floor(fa)), ib = int32_t(std::floor(fb));
    if (ia < 0 || ib < 0 || ia + 1 >= v.size[a] || ib + 1 >= v.size[b]) return false;
    const double ta = fa - ia, tb = fb - ib;
    const auto pixel = [&](int32_t p, int32_t q) {
      std::array<int32_t, 3> i{};
      i[axis] = k, i[a] = p, i[b] = q;
      return double(v.value[v.index(i[0], i[1], i[2])]);
    };
    out = (1 - tb) * ((1 - ta) * pixel(ia, ib) + ta * pixel(ia + 1, ib)) +
          tb * ((1 - ta) * pixel(ia, ib + 1) + ta * pixel(ia + 1, ib + 1));
    return true;
  }

  Spread spread(double along_up, double point) const {
    const double flat2 = std::max(0., 1 - along_up * along_up);
    // A box of a pixel, and interpolation between two of them: the mean of t (1 - t) is 1/6.
    return {std::sqrt(point * point + flat2 * pixel_mm * pixel_mm * (1. / 12 + 1. / 6)), std::abs(along_up) * gap_mm};
  }

  /// Of the slices near x, at places in their planes on the way that the normal takes in them.
  void samples(const Vec3& x, const Vec3& n, double reach, std::vector<ProfileSample>& out) const {
    out.clear();
    const double n_up = n.dot(up), n_in = std::sqrt(std::max(0., 1 - n_up * n_up));
    Vec3 in = n - n_up * up;
    if (in.norm() < 1e-6) in = v.step_mm.col(Eigen::Index((axis + 1) % 3));
    in = (in - in.dot(up) * up).normalized();
    const double at_k = (x - v.origin_mm).dot(up) / gap_mm, beside = kBesideMost * gap_mm,
                 high = reach * std::abs(n_up) + beside * n_in;
    const auto low_k = int32_t(std::ceil(at_k - high / gap_mm)), high_k = int32_t(std::floor(at_k + high / gap_mm));
    const double step = std::max(0.5 * pixel_mm, 0.3), wide = reach * n_in + beside * std::abs(n_up),
                 sd = kBeside * gap_mm;
    const int steps = int(wide / step);
    for (int32_t k = std::max(0, low_k); k <= std::min(v.size[axis] - 1, high_k); ++k) {
      const double dz = (k - at_k) * gap_mm;
      for (int j = -steps; j <= steps; ++j) {
        const double u = j * step, along = n_in * u + n_up * dz, off = n_in * dz - n_up * u;
        if (std::abs(along) > reach || std::abs(off) > beside) continue;
        ProfileSample s;
        s.at_mm = along, s.weight = elementary::exp(-0.5 * off * off / (sd * sd));
        if (value(x + u * in + dz * up, k, s.value)) out.push_back(s);
      }
    }
  }
};

/// The density of compact bone and the blur that leave least, by the mean logarithm of what is left of each profile.
/// Densities that leave nearly as little have a part by how little: 1100 and 1300 HU differ by 1 % there, and by a
/// quarter of a millimetre all around (synthetic head of 1100 HU in slices of 3 mm, 2026-11-27).
template <class Look>
void likely_scanner(const std::vector<size_t>& some, const std::vector<double>& densities, Look&& look,
                    Workers& workers, CortexReport& out) {
  constexpr double kUntold = 0.02;
  struct Trial {
    double density, point, left;
  };
  std::vector<Trial> best;
  std::vector<double> left(some.size());
  for (const double density : densities) {
    best.push_back({density, 0.6, std::numeric_limits<double>::infinity()});
    for (const double point : {0.3, 0.45, 0.6, 0.75, 0.9, 1.1, 1.3}) {
      workers.parallel_for(some.size(), 16, [&](size_t b, size_t e) {
        for (size_t k = b; k < e; ++k)
          left[k] = elementary::log(std::clamp(look(some[k], point, density).rms, 1., 1e3));
      });
      double sum = 0;
      for (const double x : left) sum += x / double(left.size());
      if (sum < best.back().left) best.back().point = point, best.back().left = sum;
    }
  }
  double least = std::numeric_limits<double>::infinity(), all = 0, square = 0;
  for (const Trial& t : best) least = std::min(least, t.left);
  out.cortical = out.point_mm = 0;
  for (const Trial& t : best) {
    const double weight = elementary::exp((least - t.left) / kUntold);
    all += weight, out.cortical += weight * t.density, out.point_mm += weight * t.point;
    square += weight * t.density * t.density;
  }
  out.cortical /= all, out.point_mm /= all;
  out.cortical_sd = std::sqrt(std::max(0., square / all - out.cortical * out.cortical));
}

double median(std::vector<double> x) {
  const auto at = x.begin() + std::ptrdiff_t(x.size() / 2);
  std::nth_element(x.begin(), at, x.end());
  return *at;
}
/// Of a normal distribution it is the standard deviation.
double spread_of(std::vector<double> x, double middle) {
  for (double& a : x) a = std::abs(a - middle);
  return 1.4826 * median(std::move(x));
}

}  // namespace

CortexReport put_on_cortex_in_slices(simplex::Mesh& m, const Volume& slices, const std::vector<double>& densities,
                                     double offset, Workers& workers, const CortexReport* same_scan) {
  CortexReport out;
  const SliceStack stack(slices);
  const size_t slots = size_t(m.slots());
  CortexPrior prior;
  prior.soft = kSoft + offset, prior.soft_sd = kSoftSd, prior.deep = 450 + offset;
  for (int round = 0; round < kSliceRounds; ++round) {
    const std::vector<Vec3> normal = cortex::normals_of(m);
    const auto reach = [&](size_t i, double point) {
      const Spread s = stack.spread(normal[i].dot(stack.up), point);
      return std::max(kAlong_mm, kAlongBlurs * std::sqrt(s.sd_mm * s.sd_mm + s.box_mm * s.box_mm / 12));
    };
    const auto look = [&](size_t i, double point, double density, const CortexPrior* known) {
      std::vector<ProfileSample> samples;
      stack.samples(m.x_mm[i], normal[i], reach(i, point), samples);
      return fit_cortex(samples, stack.spread(normal[i].dot(stack.up), point), density, known);
    };
    std::vector<size_t> all, upright;
    for (size_t i = 0; i < slots; ++i)
      if (m.alive(int32_t(i)) && normal[i] != Vec3::Zero()) {
        all.push_back(i);
        if (std::abs(normal[i].dot(stack.up)) < kUpright) upright.push_back(i);
      }
    if (round == 0) {
      if (same_scan)
        out.cortical = same_scan->cortical, out.point_mm = same_scan->point_mm;
      else
        likely_scanner(
            cortex::some_of(upright.empty() ? all : upright), densities,
            [&](size_t i, double point, double density) { return look(i, point, density, nullptr); }, workers, out);
      // What the upright surfaces say of cortex and what is beneath.
      std::vector<Cortex> said(upright.size());
      workers.parallel_for(upright.size(), 64, [&](size_t b, size_t e) {
        for (size_t k = b; k < e; ++k) said[k] = look(upright[k], out.point_mm, out.cortical, nullptr);
      });
      std::vector<double> thick, deep;
      for (const Cortex& c : said)
        if (c.found) thick.push_back(c.outer_mm - c.inner_mm), deep.push_back(c.deep);
      if (thick.size() >= kLeastSure) {
        prior.thickness_mm = median(thick), prior.deep = median(deep);
        prior.thickness_sd_mm = std::max(0.3, spread_of(thick, prior.thickness_mm));
        prior.deep_sd = std::max(50., spread_of(deep, prior.deep));
      }
    }
    std::vector<double> shift(slots, 0);
    std::vector<uint8_t> found(slots, 0), sure(slots, 0);
    out.cortex_mm.assign(slots, std::numeric_limits<float>::quiet_NaN());
    workers.parallel_for(all.size(), 64, [&](size_t b, size_t e) {
      for (size_t k = b; k < e; ++k) {
        const size_t i = all[k];
        const Cortex c = look(i, out.point_mm, out.cortical, &prior);
        if (!c.found) continue;
        found[i] = 1, shift[i] = c.outer_mm, out.cortex_mm[i] = float(c.outer_mm - c.inner_mm);
        sure[i] = std::abs(normal[i].dot(stack.up)) < kUpright;
      }
    });
    out.sure = int32_t(std::count(sure.begin(), sure.end(), 1));
    cortex::move_to(m, normal, std::move(shift), std::move(found), 2 * kAlong_mm, out);
  }
  return out;
}

}  // namespace limberg
