#include "sim/skull/bone/seam.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "sim/skull/bone/surface.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/motion.h"

namespace limberg::bone {
namespace {

using simplex::FaceKind;
using simplex::Mesh;

// On a ball whose cap was turned by 7 degrees before it was joined, 30, 100 and 300 leave 0.26, 0.25 and 0.25 degrees
// of 11.7 between the seam's faces and the ball (2026-11-27).
constexpr int kIterations = 100;
constexpr double kFar = std::numeric_limits<double>::infinity();

/// Along edges from the seam, up to band_mm; what holds still is infinitely far.
std::vector<double> distance_from(const Mesh& m, std::span<const int32_t> seam, double band_mm) {
  std::vector<double> d(size_t(m.slots()), kFar);
  using At = std::pair<double, int32_t>;
  std::priority_queue<At, std::vector<At>, std::greater<>> next;
  for (const int32_t v : seam)
    if (m.alive(v)) d[size_t(v)] = 0, next.push({0, v});
  while (!next.empty()) {
    const auto [far, v] = next.top();
    next.pop();
    if (far > d[size_t(v)]) continue;
    for (const int32_t w : m.nbr[size_t(v)]) {
      const double there = far + (m.x_mm[size_t(w)] - m.x_mm[size_t(v)]).norm();
      if (there < std::min(d[size_t(w)], band_mm)) d[size_t(w)] = there, next.push({there, w});
    }
  }
  for (int32_t v = 0; v < m.slots(); ++v) {
    if (!m.alive(v) || d[size_t(v)] == kFar) continue;
    bool still = m.flags[size_t(v)] & simplex::kLocked;
    for (const int32_t f : m.left[size_t(v)]) still |= m.kind(f) != FaceKind::surface;
    if (still) d[size_t(v)] = kFar;
  }
  return d;
}

double volume_mm3(const Mesh& m, const std::vector<int32_t>& part_of, int32_t parts, int32_t part) {
  return bulks(m, part_of, parts)[size_t(part)].volume_mm3;
}

}  // namespace

SeamReport smooth_seam(Mesh& m, std::span<const int32_t> seam, double band_mm, Workers& workers,
                       simplex::Delta& delta) {
  SeamReport report;
  if (!(band_mm > 0)) return report;
  const std::vector<double> far = distance_from(m, seam, band_mm);
  std::vector<int32_t> band;
  for (int32_t v = 0; v < m.slots(); ++v)
    if (far[size_t(v)] < kFar) band.push_back(v);
  if (band.empty()) return report;
  std::vector<int32_t> part_of;
  const int32_t parts = simplex::components(m, part_of), part = part_of[size_t(band.front())];
  const double volume = volume_mm3(m, part_of, parts, part);

  simplex::Edit e(m, delta);
  for (const int32_t v : band) e.save_vertex(v);
  std::vector<Vec3> was;
  for (const int32_t v : band) was.push_back(m.x_mm[size_t(v)]);

  simplex::Law law;
  law.gamma = 0.5;
  law.zone.resize(2);
  law.zone[0].fixed = true;
  law.zone[1].constraint = simplex::Constraint::curvature;
  law.zone[1].alpha = 0.5, law.zone[1].rigidity = 2;
  const std::vector<uint16_t> zones = m.zone;
  std::fill(m.zone.begin(), m.zone.end(), uint16_t(0));
  for (const int32_t v : band) m.zone[size_t(v)] = 1;
  ++m.version;
  simplex::Motion motion(workers);
  motion.set_law(law);
  for (int i = 0; i < kIterations; ++i) motion.step(m);
  m.zone = zones;
  ++m.version;

  // What is missing (or too much) is given back along the normals: volume is a cubic of the way, and Newton's method
  // with the band's areas for a slope needs few steps.
  const auto weight = [&](int32_t v) {
    const double s = 1 - far[size_t(v)] / band_mm;
    return s * s * (3 - 2 * s);
  };
  for (int round = 0; round < 8; ++round) {
    const double missing = volume - volume_mm3(m, part_of, parts, part);
    report.volume_change = -missing / volume;
    if (std::abs(missing) < 1e-9 * volume) break;
    std::vector<Vec3> area(band.size());  // of the three triangles about a vertex, a third each of the dual's cells
    double slope = 0;
    for (size_t i = 0; i < band.size(); ++i) {
      const int32_t v = band[i];
      Vec3 a = Vec3::Zero();
      for (int k = 0; k < 3; ++k) {
        const Vec3 p = m.x_mm[size_t(m.nbr[size_t(v)][size_t(k)])] - m.x_mm[size_t(v)],
                   q = m.x_mm[size_t(m.nbr[size_t(v)][size_t((k + 1) % 3)])] - m.x_mm[size_t(v)];
        a += p.cross(q) / 2;
      }
      area[i] = a;
      if (a.norm() > 0) slope += weight(v) * a.norm();
    }
    if (!(slope > 0)) break;
    const double by = missing / slope;
    for (size_t i = 0; i < band.size(); ++i)
      if (area[i].norm() > 0) m.x_mm[size_t(band[i])] += by * weight(band[i]) * area[i].normalized();
  }
  for (size_t i = 0; i < band.size(); ++i) {
    m.before_mm[size_t(band[i])] = m.x_mm[size_t(band[i])];
    report.farthest_mm = std::max(report.farthest_mm, (m.x_mm[size_t(band[i])] - was[i]).norm());
  }
  report.vertices = int32_t(band.size());
  for (const int32_t v : band) {
    e.reshape(v);
    for (const int32_t w : m.nbr[size_t(v)]) e.reshape(w);
  }
  return report;
}

}  // namespace limberg::bone
