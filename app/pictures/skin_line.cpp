#include "app/pictures/skin_line.h"

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "sim/body/skin_view.h"
#include "sim/body/texture_places.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

constexpr double kEvery_mm = 0.6, kBeside_mm = 0.3;

/// Calls f(i, t, point): of the way from corner i to corner i + 1 the share t, and of a dot its only place.
template <class Point, class F>
void finely(const std::vector<Point>& path, F f) {
  f(size_t(0), 0.0, path.front());
  for (size_t i = 0; i + 1 < path.size(); ++i) {
    const int n = std::max(1, int(std::ceil((path[i + 1] - path[i]).norm() / kEvery_mm)));
    for (int k = 1; k <= n; ++k) f(i, double(k) / n, Point(path[i] + double(k) / n * (path[i + 1] - path[i])));
  }
}

/// The skin beside a line, searched at rest.
class Beside {
 public:
  Beside(const Snapshot& s, const std::vector<Vec3>& places) : s_(s) {
    Eigen::AlignedBox3d box;
    for (const Vec3& X : places) box.extend(X);
    box.min().array() -= kOffSkin_mm, box.max().array() += kOffSkin_mm;
    for (const int32_t t : s.topology->index(Ground::skin).triangle) {
      Eigen::AlignedBox3d of;
      for (const int32_t v : s.topology->view.tri[size_t(t)]) of.extend(X_mm(v));
      if (of.intersects(box)) tri_.push_back(t);
    }
  }
  /// The nearest skin within kOffSkin_mm, of that which looks along `out` where one is given.
  SkinTouch nearest(const Vec3& X, const Vec3* out) const {
    int32_t triangle = -1;
    std::array<double, 3> bary{1, 0, 0};
    double best = kOffSkin_mm * kOffSkin_mm;
    for (const int32_t t : tri_) {
      const Tri& k = s_.topology->view.tri[size_t(t)];
      const Vec3 &a = X_mm(k[0]), &b = X_mm(k[1]), &c = X_mm(k[2]);
      const TrianglePoint p = closest_on_triangle(X, a, b, c);
      const double d2 = (p.point - X).squaredNorm();
      if (d2 < best && (!out || (b - a).cross(c - a).dot(*out) > 0)) best = d2, triangle = t, bary = p.bary;
    }
    return touch_at(s_, triangle, bary, std::sqrt(best));
  }

 private:
  const Vec3& X_mm(int32_t v) const { return s_.topology->view.X_mm[size_t(v)]; }
  const Snapshot& s_;
  std::vector<int32_t> tri_;
};

}  // namespace

std::optional<SkinLine> skin_line(const Command& command) {
  const auto* placed = std::get_if<InSpace>(&command);
  const auto* m = placed ? std::get_if<Mark>(&placed->act) : std::get_if<Mark>(&command);
  if (!m || m->path.empty()) return std::nullopt;
  SkinLine line{m->path, {}, m->wipes};
  if (placed) line.X_mm = places_of(*placed);
  return line;
}

std::vector<SkinTouch> laid_on_skin(const Snapshot& s, const SkinChart& chart, const SkinLine& line) {
  std::vector<SkinTouch> out;
  if (line.X_mm.empty()) {
    finely(line.chart, [&](size_t, double, const ChartPoint& p) { out.push_back(chart.at(s, p, kBeside_mm)); });
    return out;
  }
  std::vector<Vec3> places = line.X_mm;
  std::string reason;
  for (Vec3& X : places) {
    if (!std::isnan(X.z())) continue;
    const auto on = s.topology->body ? place_on_texture(*s.topology->body, X.head<2>(), reason) : std::nullopt;
    if (!on) return {};
    X = *on;
  }
  const Beside beside(s, places);
  std::vector<Vec3> looks;
  for (const Vec3& X : places) looks.push_back(beside.nearest(X, nullptr).N);
  finely(places, [&](size_t i, double t, const Vec3& X) {
    const Vec3 look = (1 - t) * looks[i] + t * looks[std::min(i + 1, looks.size() - 1)];
    out.push_back(beside.nearest(X, &look));
  });
  return out;
}

}  // namespace limberg
