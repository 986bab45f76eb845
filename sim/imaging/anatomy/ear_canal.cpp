#include "sim/imaging/anatomy/ear_canal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include "sim/base/elementary.h"

namespace limberg {

namespace {

constexpr double kStepCanal_mm = 1;
constexpr int kOut = 34, kIn = 16, kAround = 20;  // steps from where the porion is sought: outwards, inwards, beside
constexpr double kCostScale_HU = 250;  // in which a millimetre costs e times as much: air 1, muscle 65, bone 3000
constexpr double kOutside_HU = -800;
// The canal is 6 to 10 mm wide, and its walls are blurred: from its middle they are no farther, the roof at its rim
// neither.
constexpr double kWall_mm = 10, kRoof_mm = 7;
constexpr int kOpenSteps = 4;
constexpr size_t kThinning = 3;
constexpr double kRay_mm = 0.25;
constexpr int kLeastWalled = 4;        // steps in bone that make a canal
constexpr double kCanalAir_HU = -100;  // the mean along it is below: a fold of skin or a suture is not

struct CanalSeeker {
  const VolumeSampler& volume;
  double offset, bone;
  Vec3 near;
  Vec3 out, forwards, up;  // unit

  static constexpr int nx = kOut + kIn + 1, ny = 2 * kAround + 1;
  Vec3 place(int i, int j, int k) const {
    return near + kStepCanal_mm * ((i - kIn) * out + (j - kAround) * forwards + (k - kAround) * up);
  }
  Vec3 place(size_t n) const { return place(int(n) % nx, int(n) / nx % ny, int(n) / (nx * ny)); }
  double HU(const Vec3& x) const { return volume.value(x) - offset; }

  std::optional<EarCanal> run() const {
    const std::vector<size_t> way = way_in();
    if (way.empty()) return std::nullopt;
    // From within outwards: `way` begins at its inner end. It ends where no bone has been close above for some steps.
    int walled = 0, open = 0;
    double air = 0;
    std::vector<Vec3> roof;
    for (const size_t n : way) {
      const Vec3 x = place(n);
      const std::optional<Vec3> above = wall(x, up, kRoof_mm);
      const int others = int(wall(x, -up, kWall_mm).has_value()) + int(wall(x, forwards, kWall_mm).has_value()) +
                         int(wall(x, -forwards, kWall_mm).has_value());
      if (above && others >= 2) ++walled, air += HU(x);
      if (walled == 0) continue;
      if (above) roof.push_back(*above), open = 0;
      if (!above && ++open >= kOpenSteps) break;
    }
    if (walled < kLeastWalled || roof.empty() || !(air / walled < kCanalAir_HU)) return std::nullopt;
    // The last of the roof thins out to nothing, and seems higher than it is.
    return EarCanal{roof[roof.size() - std::min(roof.size(), kThinning)], walled * kStepCanal_mm, air / walled};
  }

  /// Where bone begins along a ray from within the canal.
  std::optional<Vec3> wall(const Vec3& x, const Vec3& along, double length) const {
    double least = HU(x), most = least, at = 0;
    for (double t = kRay_mm; t <= length; t += kRay_mm) {
      const double v = HU(x + t * along);
      if (most < bone) least = std::min(least, v);
      if (v > most) most = v, at = t;
      if (most >= bone && v < most - 100) break;  // through the wall
    }
    if (most < bone || least > 0) return std::nullopt;
    // Skin lines the canal: half-way between air and bone may lie in it.
    const double half = 0.5 * (std::max(bone, 0.5 * (least + most)) + 0.5 * (least + most));
    while (at > 0 && HU(x + at * along) >= half) at -= kRay_mm;
    const double a = HU(x + at * along), b = HU(x + (at + kRay_mm) * along);
    return Vec3(x + (at + (b > a ? kRay_mm * (half - a) / (b - a) : 0)) * along);
  }

  /// From the inner end outwards.
  std::vector<size_t> way_in() const {
    const size_t count = size_t(nx) * ny * ny;
    std::vector<double> cost(count), far(count, std::numeric_limits<double>::infinity());
    std::vector<size_t> from(count, SIZE_MAX);
    using Item = std::pair<double, size_t>;
    std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
    for (size_t n = 0; n < count; ++n) {
      const double v = HU(place(n));
      cost[n] = elementary::exp((std::clamp(v, -1000., 1500.) + 1000) / kCostScale_HU);
      if (int(n) % nx == nx - 1 && v < kOutside_HU) far[n] = 0, open.push({0, n});
    }
    while (!open.empty()) {
      const auto [d, n] = open.top();
      open.pop();
      if (d > far[n]) continue;
      const int i = int(n) % nx, j = int(n) / nx % ny, k = int(n) / (nx * ny);
      // The inner end: as deep as the grid, no nearer to its sides than a third.
      if (i == 0 && std::abs(j - kAround) < kAround * 2 / 3 && std::abs(k - kAround) < kAround * 2 / 3) {
        std::vector<size_t> way{n};
        while (from[way.back()] != SIZE_MAX) way.push_back(from[way.back()]);
        return way;
      }
      const auto go = [&](int a, int b, int c) {
        if (a < 0 || b < 0 || c < 0 || a >= nx || b >= ny || c >= ny) return;
        const size_t m = size_t(a) + size_t(nx) * (size_t(b) + size_t(ny) * size_t(c));
        if (const double w = d + 0.5 * (cost[n] + cost[m]); w < far[m]) far[m] = w, from[m] = n, open.push({w, m});
      };
      go(i - 1, j, k), go(i + 1, j, k), go(i, j - 1, k), go(i, j + 1, k), go(i, j, k - 1), go(i, j, k + 1);
    }
    return {};
  }
};

}  // namespace

std::optional<EarCanal> find_ear_canal(const Volume& volume, double offset, double bone_HU, const Vec3& near,
                                       const Mat3& head, double side) {
  const VolumeSampler sampler(volume);
  return CanalSeeker{sampler, offset, bone_HU, near, side * head.col(0), head.col(1), head.col(2)}.run();
}

}  // namespace limberg
