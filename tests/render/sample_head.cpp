#include "tests/render/sample_head.h"

#include <cmath>

namespace limberg::testing {

namespace {

constexpr int kRings = 48, kSides = 96;

/// From the front pole of an egg (towards -y) to its equator; plate:
/// how far a part within 35 degrees above the middle comes forwards.
struct Egg {
  Vec3 half_mm;
  Vec3 at(int ring, int side) const {
    const double a = 0.5 * 3.14159265358979 * ring / kRings, b = 2 * 3.14159265358979 * side / kSides;
    return {half_mm.x() * std::sin(a) * std::cos(b), -half_mm.y() * std::cos(a),
            half_mm.z() * std::sin(a) * std::sin(b)};
  }
};

}  // namespace

Snapshot sample_head(double moved_mm) {
  auto topology = std::make_shared<SurfaceTopology>();
  SurfaceView& view = topology->view;
  Snapshot s;
  SharedArray<float> depths;
  const auto triangle = [&](const Tri& t, Organ organ) {
    view.tri.push_back(t),
        view.uv.push_back({Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero()}),
        view.kind.push_back(FaceKind::free), view.sided_face.push_back(int32_t(view.tri.size())),
        view.origin.push_back(0);
    topology->organ.push_back(organ), topology->object.push_back(organ == Organ::face ? -1 : 0);
  };
  const auto vertex = [&](const Vec3& X, double forwards) {
    view.X_mm.push_back(X), depths.push_back(0);
    s.x_mm.push_back((X - Vec3(0, forwards, 0)).cast<float>()), s.moved_mm.push_back(float(forwards));
    return int32_t(view.X_mm.size()) - 1;
  };
  const auto shell = [&](const Egg& egg, Organ organ, auto forwards, auto holds) {
    std::vector<int32_t> index(size_t(kRings + 1) * kSides);
    for (int r = 0; r <= kRings; ++r)
      for (int k = 0; k < kSides; ++k)
        index[size_t(r * kSides + k)] = r == 0 && k > 0 ? index[0] : vertex(egg.at(r, k), forwards(egg.at(r, k)));
    for (int r = 0; r < kRings; ++r)
      for (int k = 0; k < kSides; ++k) {
        if (!holds(egg.at(r, k))) continue;
        const int32_t a = index[size_t(r * kSides + k)], b = index[size_t(r * kSides + (k + 1) % kSides)],
                      c = index[size_t((r + 1) * kSides + k)], d = index[size_t((r + 1) * kSides + (k + 1) % kSides)];
        triangle({a, c, d}, organ);
        if (a != b) triangle({a, d, b}, organ);
      }
  };
  const Egg face{{70, 90, 90}}, bone{{58, 76, 78}};
  const auto plate = [](const Vec3& X) { return std::abs(X.x()) < 26 && X.z() > 12 && X.z() < 44; };
  shell(
      bone, Organ::bone, [](const Vec3&) { return 0.0; }, [&](const Vec3& X) { return !plate(X); });
  shell(
      bone, Organ::bone_cut, [&](const Vec3&) { return moved_mm; }, plate);
  shell(
      face, Organ::face,
      [&](const Vec3& X) {
        return moved_mm * std::exp(-(X.x() * X.x() + (X.z() - 28) * (X.z() - 28)) / (2 * 26.0 * 26)) *
               (X.y() < 0 ? 1 : 0);
      },
      [](const Vec3&) { return true; });
  topology->depth_mm = topology->layers_mm = depths;
  topology->version = 1, topology->hash = 0x4ead;
  s.topology = topology, s.topology_version = 1;
  return s;
}

}  // namespace limberg::testing
