// A CT of the analytic head: what is where, partly filled voxels, the scanner's blur, noise.
#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/imaging/synthetic/synthetic_head.h"

namespace limberg {
namespace {

constexpr double kAir = -1000, kFat = -90, kMuscle = 45, kBrain = 35, kOrbitFat = -60, kEyeHU = 20, kCortical = 1100,
                 kDiploe = 450;
constexpr double kCortex_mm = 2.2, kSkin_mm = 2.5, kFat_mm = 5;

/// Part of a voxel that lies inside, from the distance of its centre.
double share(double distance, double voxel) { return std::clamp(0.5 - distance / voxel, 0., 1.); }

constexpr double kCanal_mm = 4;  // radius
const shape::Capsule kCanal({90, 0, -kCanal_mm}, {44, 0, -kCanal_mm}, kCanal_mm, kCanal_mm);

double density(const HeadShape& h, const Vec3& p, double voxel, const HeadCt& c) {
  const double skin = h.skin(p);
  if (skin > voxel) return kAir;
  double v = kMuscle;
  if (skin > -kSkin_mm - kFat_mm) v += (kFat - v) * share(skin + kSkin_mm, 1) * share(-skin - kSkin_mm - kFat_mm, 1);
  v += (kBrain - v) * share(h.brain(p), voxel);
  v += (kOrbitFat - v) * share(h.orbit(p), voxel);
  v += (kEyeHU - v) * share(h.eye(p), voxel);
  v += (kAir - v) * share(h.airway(p), voxel) * share(skin + 6, voxel);
  const double bone = h.bone(p);
  if (bone < voxel) v += (kCortical + (kDiploe - kCortical) * share(bone + kCortex_mm, 1) - v) * share(bone, voxel);
  if (c.ear_canals) v += (kAir - v) * share(kCanal({std::abs(p.x()), p.y(), p.z()}), voxel);
  if (c.sinuses) v += (kAir - v) * share(h.sinus(p), voxel);
  return kAir + (v - kAir) * share(skin, voxel);
}

double normal(uint64_t i, uint64_t seed) {
  const auto mix = [](uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  };
  const uint64_t a = mix(2 * i + seed * 0x9e3779b97f4a7c15ull), b = mix(a + 0x9e3779b97f4a7c15ull);
  const double u = (double(a >> 11) + 0.5) / 9007199254740992., w = double(b >> 11) / 9007199254740992.;
  return std::sqrt(-2 * elementary::log(u)) * elementary::cos(2 * M_PI * w);
}

void blur(Volume& v, double sigma_voxels, Workers& workers) {
  const int r = int(std::ceil(3 * sigma_voxels));
  std::vector<double> w(size_t(2 * r + 1));
  double sum = 0;
  for (int i = -r; i <= r; ++i) sum += w[size_t(i + r)] = elementary::exp(-0.5 * i * i / (sigma_voxels * sigma_voxels));
  for (double& x : w) x /= sum;
  const size_t stride[3] = {1, size_t(v.size[0]), size_t(v.size[0]) * size_t(v.size[1])};
  for (size_t axis = 0; axis < 3; ++axis) {
    const size_t n = size_t(v.size[axis]), a = (axis + 1) % 3, b = (axis + 2) % 3;
    workers.parallel_for(size_t(v.size[a]) * size_t(v.size[b]), 256, [&](size_t first, size_t last) {
      std::vector<float> line(n);
      for (size_t l = first; l < last; ++l) {
        float* p = v.value.data() + l % size_t(v.size[a]) * stride[a] + l / size_t(v.size[a]) * stride[b];
        for (size_t i = 0; i < n; ++i) line[i] = p[i * stride[axis]];
        for (size_t i = 0; i < n; ++i) {
          double s = 0;
          for (int k = -r; k <= r; ++k)
            s += w[size_t(k + r)] * double(line[size_t(std::clamp<int64_t>(int64_t(i) + k, 0, int64_t(n) - 1))]);
          p[i * stride[axis]] = float(s);
        }
      }
    });
  }
}

Volume averaged(const Volume& v, int n) {
  Volume out = v;
  out.size[2] = v.size[2] / n;
  out.step_mm.col(2) *= n, out.origin_mm += 0.5 * (n - 1) * v.step_mm.col(2);
  out.value.clear();
  for (int32_t k = 0; k < out.size[2]; ++k)
    for (int32_t j = 0; j < v.size[1]; ++j)
      for (int32_t i = 0; i < v.size[0]; ++i) {
        double sum = 0;
        for (int32_t s = 0; s < n; ++s) sum += double(v.value[v.index(i, j, k * n + s)]) / n;
        out.value.push_back(float(sum));
      }
  return out;
}

}  // namespace

Volume head_ct(const HeadSpec& spec, double voxel, Workers& workers, const HeadCt& c) {
  if (!(voxel >= 0.3 && voxel <= 10)) throw InputError("", 0, "a voxel of a synthetic CT has 0.3 to 10 mm");
  if (!(c.blur_mm >= 0 && c.blur_mm <= 10) || !(c.noise_HU >= 0 && c.noise_HU <= 1000))
    throw InputError("", 0, "a blur of 0 to 10 mm and a noise of 0 to 1000 HU were expected");
  if (c.slices_in_one < 1 || c.slices_in_one > 10) throw InputError("", 0, "1 to 10 slices in one were expected");
  const HeadShape h(spec);
  const Vec3 lo = HeadShape::low_mm(), hi = HeadShape::high_mm();
  Volume v;
  for (size_t a = 0; a < 3; ++a) v.size[a] = int32_t(std::floor((hi - lo)[Eigen::Index(a)] / voxel)) + 1;
  v.step_mm = voxel * Mat3::Identity();
  v.origin_mm = Vec3(-hi.x(), -hi.y(), lo.z());
  v.value.assign(size_t(v.size[0]) * size_t(v.size[1]) * size_t(v.size[2]), float(kAir));
  // Blocks whose centre says that all of them is air, or is far inside the brain, are filled at once.
  constexpr int32_t kSide = 6;
  const std::array<int32_t, 3> blocks = {(v.size[0] + kSide - 1) / kSide, (v.size[1] + kSide - 1) / kSide,
                                         (v.size[2] + kSide - 1) / kSide};
  const double radius = 0.5 * std::sqrt(3.) * kSide * voxel * HeadShape::kLipschitz;
  workers.parallel_for(size_t(blocks[0]) * size_t(blocks[1]) * size_t(blocks[2]), 16, [&](size_t first, size_t last) {
    for (size_t b = first; b < last; ++b) {
      const int32_t i0 = int32_t(b % size_t(blocks[0])) * kSide,
                    j0 = int32_t(b / size_t(blocks[0]) % size_t(blocks[1])) * kSide,
                    k0 = int32_t(b / (size_t(blocks[0]) * size_t(blocks[1]))) * kSide;
      const auto place = [&](double i, double j, double k) {
        const Vec3 q = v.place({i, j, k});
        return Vec3(-q.x(), -q.y(), q.z());
      };
      const double m = 0.5 * (kSide - 1);
      const Vec3 middle = place(i0 + m, j0 + m, k0 + m);
      if (h.skin(middle) > radius + voxel) continue;
      const bool brain = h.brain(middle) < -radius - voxel;
      for (int32_t k = k0; k < std::min(k0 + kSide, v.size[2]); ++k)
        for (int32_t j = j0; j < std::min(j0 + kSide, v.size[1]); ++j)
          for (int32_t i = i0; i < std::min(i0 + kSide, v.size[0]); ++i)
            v.value[v.index(i, j, k)] = float(brain ? kBrain : density(h, place(i, j, k), voxel, c));
    }
  });
  if (c.blur_mm / voxel > 0.15) blur(v, c.blur_mm / voxel, workers);
  if (c.slices_in_one > 1) v = averaged(v, c.slices_in_one);
  if (c.noise_HU > 0)
    workers.parallel_for(v.value.size(), 65536, [&](size_t b, size_t e) {
      for (size_t i = b; i < e; ++i) v.value[i] += float(c.noise_HU * normal(i, c.seed));
    });
  return v;
}

}  // namespace limberg
