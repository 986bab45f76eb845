#include "sim/imaging/register/registration.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/geometry/rotation.h"
#include "sim/imaging/fit/prepare.h"

namespace limberg {
namespace {

struct Range {
  float low = 0, high = 0;
};

/// Without the outermost half percent on either side.
Range range_of(const Volume& v) {
  std::vector<float> x;
  const size_t every = std::max<size_t>(1, v.value.size() / 100000);
  for (size_t i = 0; i < v.value.size(); i += every) x.push_back(v.value[i]);
  std::sort(x.begin(), x.end());
  return {x[x.size() / 200], x[x.size() - 1 - x.size() / 200]};
}

uint64_t mixed(uint64_t x) {  // splitmix64
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9ull, x = (x ^ x >> 27) * 0x94d049bb133111ebull;
  return x ^ x >> 31;
}

class Level {
 public:
  Level(const Volume& fixed, const Volume& moved, const Range& a, const Range& b, int samples, int bins,
        Workers& workers)
      : moved_(moved), sampler_(moved_), b_(b), bins_(bins), workers_(workers) {
    const VolumeSampler from(fixed);
    const double n = double(fixed.value.size()), cell = std::max(1., elementary::cbrt(n / samples));
    uint64_t seed = 1;
    for (double k = 0; k < fixed.size[2]; k += cell)
      for (double j = 0; j < fixed.size[1]; j += cell)
        for (double i = 0; i < fixed.size[0]; i += cell) {
          Vec3 p;
          const double at[3] = {i, j, k};
          for (int q = 0; q < 3; ++q)
            p[q] = std::min(at[q] + cell * double(mixed(++seed) >> 11) * 0x1p-53, double(fixed.size[size_t(q)] - 1));
          const Vec3 x = fixed.place(p);
          const double t = (from.value(x) - double(a.low)) / double(a.high - a.low);
          x_.push_back(x), bin_.push_back(std::clamp(int(t * bins), 0, bins - 1));
        }
  }

  /// `back`: places of the fixed image in the moved one.
  double information(const Similarity& back, double* overlap) const {
    constexpr size_t kGrain = 2048;
    const size_t cells = size_t(bins_) * size_t(bins_), chunks = (x_.size() + kGrain - 1) / kGrain;
    std::vector<double> joint(chunks * cells, 0);
    workers_.parallel_for(x_.size(), kGrain, [&](size_t begin, size_t end) {
      double* h = joint.data() + begin / kGrain * cells;
      for (size_t i = begin; i < end; ++i) {
        const Vec3 y = back(x_[i]);
        if (!sampler_.inside(y)) continue;
        const double t =
            std::clamp((sampler_.value(y) - double(b_.low)) / double(b_.high - b_.low), 0., 1.) * (bins_ - 1);
        const int lower = std::min(int(t), bins_ - 2);
        double* row = h + size_t(bin_[i]) * size_t(bins_);
        row[lower] += 1 - (t - lower), row[lower + 1] += t - lower;
      }
    });
    for (size_t c = 1; c < chunks; ++c)
      for (size_t i = 0; i < cells; ++i) joint[i] += joint[c * cells + i];
    double all = 0;
    std::vector<double> row(size_t(bins_), 0), column(size_t(bins_), 0);
    for (size_t i = 0; i < cells; ++i)
      all += joint[i], row[i / size_t(bins_)] += joint[i], column[i % size_t(bins_)] += joint[i];
    if (overlap) *overlap = all / double(x_.size());
    if (all < 0.2 * double(x_.size())) return 0;  // sliding apart is no way
    const auto entropy = [&](const double* h, size_t n) {
      double e = 0;
      for (size_t i = 0; i < n; ++i)
        if (h[i] > 0) e -= h[i] / all * elementary::log(h[i] / all);
      return e;
    };
    const double both = entropy(joint.data(), cells);
    return both > 0 ? (entropy(row.data(), row.size()) + entropy(column.data(), column.size())) / both : 0;
  }

 private:
  const Volume& moved_;
  VolumeSampler sampler_;
  Range b_;
  int bins_;
  Workers& workers_;
  std::vector<Vec3> x_;
  std::vector<int> bin_;
};

/// Turn by angles (rad) about the axes one after the other around c, then shift.
Similarity motion(const double* u, const Vec3& c) {
  Similarity s;
  s.R = rotation(u[5], Vec3::UnitZ()) * rotation(u[4], Vec3::UnitY()) * rotation(u[3], Vec3::UnitX());
  s.t_mm = c - s.R * c + Vec3(u[0], u[1], u[2]);
  return s;
}

}  // namespace

RegistrationResult register_volumes(const Volume& fixed, const Volume& moved, const RegistrationSettings& s,
                                    Workers& workers) {
  if (s.levels < 1 || s.levels > 8 || s.bins < 4 || s.bins > 256 || s.samples < 100 || s.samples > 10'000'000 ||
      !(s.shift_mm > 0) || !(s.turn_deg > 0))
    throw InputError("", 0,
                     "a registration has 1 to 8 levels, 4 to 256 bins, 100 samples or more, and first steps above 0");
  if (fixed.value.empty() || moved.value.empty()) throw InputError("", 0, "a registration needs two volumes");
  RegistrationResult r;
  const Range a = range_of(fixed), b = range_of(moved);
  if (!(a.high > a.low) || !(b.high > b.low)) {
    r.reason = "an image has the same number nearly everywhere; expected one with contrast";
    return r;
  }
  const Vec3 c = fixed.place(0.5 * Vec3(fixed.size[0] - 1, fixed.size[1] - 1, fixed.size[2] - 1));
  double voxel = 1e300;
  for (const Volume* v : {&fixed, &moved})
    for (int k = 0; k < 3; ++k) voxel = std::min(voxel, v->step_mm.col(k).norm());
  const double reach =
      0.5 * (fixed.place(Vec3(fixed.size[0] - 1, fixed.size[1] - 1, fixed.size[2] - 1)) - fixed.origin_mm).norm();
  const Similarity from_start = s.start.inverse();
  double u[6] = {}, shift = s.shift_mm, turn = s.turn_deg * 3.14159265358979 / 180;
  for (int level = s.levels - 1; level >= 0; --level) {
    const double sigma = level == 0 ? 0 : 0.5 * (1 << level);
    const Volume f = smoothed(fixed, sigma, workers), m = smoothed(moved, sigma, workers);
    const Level l(f, m, a, b, std::max(100, s.samples >> level), s.bins, workers);
    const auto measure = [&](const double* at) {
      ++r.evaluations;
      return l.information(from_start * motion(at, c), &r.overlap);
    };
    double best = measure(u);
    if (level == s.levels - 1) r.at_start = best;
    if (best == 0) {
      r.reason = "the images hardly overlap where they lie; expected a start that brings them together (landmarks)";
      return r;
    }
    const double finest = level == 0 ? 0.03 * voxel : 0.25 * voxel * (1 << level);
    // The turns' steps follow the shifts': both move the outermost places alike in the end.
    while (shift > finest || turn * reach > finest) {
      bool better = false;
      double before[6];
      std::copy(u, u + 6, before);
      for (int k = 0; k < 6; ++k)
        for (const double sign : {1., -1.}) {
          double v[6];
          std::copy(u, u + 6, v);
          v[k] += sign * (k < 3 ? shift : turn);
          if (const double i = measure(v); i > best) {
            best = i, better = true;
            std::copy(v, v + 6, u);
            break;
          }
        }
      // The same way once more (Hooke and Jeeves 1961): valleys run across the axes.
      while (better) {
        double v[6];
        for (int k = 0; k < 6; ++k) v[k] = 2 * u[k] - before[k];
        const double i = measure(v);
        if (!(i > best)) break;
        best = i;
        std::copy(u, u + 6, before);
        std::copy(v, v + 6, u);
      }
      if (!better) shift *= 0.5, turn *= 0.5;
    }
    r.information = measure(u);
    // A little room at the next level.
    if (level > 0) shift = voxel * (1 << level), turn = 2 * shift / reach;
  }
  r.map = (from_start * motion(u, c)).inverse();
  if (!(r.information > r.at_start) && r.information < 1.005)
    r.reason = "neither image says anything about the other; expected two images of the same head";
  return r;
}

Volume resampled(const Volume& fixed, const Volume& moved, const Similarity& map, float outside, Workers& workers) {
  Volume out = fixed;
  const Similarity back = map.inverse();
  const VolumeSampler s(moved);
  workers.parallel_for(size_t(fixed.size[2]), 1, [&](size_t k0, size_t k1) {
    for (size_t k = k0; k < k1; ++k)
      for (int32_t j = 0; j < fixed.size[1]; ++j)
        for (int32_t i = 0; i < fixed.size[0]; ++i) {
          const Vec3 x = back(fixed.place(Vec3(i, j, double(k))));
          out.value[fixed.index(i, j, int32_t(k))] = s.inside(x) ? float(s.value(x)) : outside;
        }
  });
  return out;
}

std::string to_nrrd(const Volume& v) {
  const Mat3& m = v.step_mm;
  std::string head = fmt::format(
      "NRRD0004\ntype: float\ndimension: 3\nspace: left-posterior-superior\nsizes: {} {} {}\nspace directions: "
      "({:.17g},{:.17g},{:.17g}) ({:.17g},{:.17g},{:.17g}) ({:.17g},{:.17g},{:.17g})\n"
      "space origin: ({:.17g},{:.17g},{:.17g})\nendian: {}\nencoding: raw\n\n",
      v.size[0], v.size[1], v.size[2], m(0, 0), m(1, 0), m(2, 0), m(0, 1), m(1, 1), m(2, 1), m(0, 2), m(1, 2), m(2, 2),
      v.origin_mm.x(), v.origin_mm.y(), v.origin_mm.z(), std::endian::native == std::endian::little ? "little" : "big");
  std::string out = head;
  const size_t at = out.size();
  out.resize(at + v.value.size() * sizeof(float));
  std::memcpy(out.data() + at, v.value.data(), v.value.size() * sizeof(float));
  return out;
}

}  // namespace limberg
