#include "app/pictures/skin_line.h"

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "sim/body/skin_view.h"
#include "sim/commands/texture_script.h"

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

/// Triangles of skin that may lie within kOffSkin_mm of the line, at rest.
std::vector<int32_t> skin_beside(const SurfaceTopology& topology, const std::vector<Vec3>& places) {
  Eigen::AlignedBox3d box;
  for (const Vec3& X : places) box.extend(X);
  box.min().array() -= kOffSkin_mm, box.max().array() += kOffSkin_mm;
  std::vector<int32_t> beside;
  for (const int32_t t : topology.index(Ground::skin).triangle) {
    Eigen::AlignedBox3d of;
    for (const int32_t v : topology.view.tri[size_t(t)]) of.extend(topology.view.X_mm[size_t(v)]);
    if (of.intersects(box)) beside.push_back(t);
  }
  return beside;
}

}  // namespace

std::optional<SkinLine> skin_line(const Command& command) {
  const auto* placed = std::get_if<InSpace>(&command);
  const auto* m = placed ? std::get_if<Mark>(&placed->act) : std::get_if<Mark>(&command);
  if (!m || m->path.empty()) return std::nullopt;
  SkinLine line{m->path, std::nullopt, m->wipes};
  if (placed) line.placed = *placed;
  return line;
}

std::vector<SkinTouch> laid_on_skin(const Snapshot& s, const SkinChart& chart, const SkinLine& line) {
  std::vector<SkinTouch> out;
  if (!line.placed) {
    finely(line.chart, [&](size_t, double, const ChartPoint& p) { out.push_back(chart.at(s, p, kBeside_mm)); });
    return out;
  }
  std::string reason;
  const auto on_body = on_texture(*line.placed, *s.topology->body, reason);
  if (!on_body) return out;
  const std::vector<Vec3> places = places_of(*on_body);
  const std::vector<int32_t> beside = skin_beside(*s.topology, places);
  std::vector<Vec3> looks;
  for (const Vec3& X : places) looks.push_back(SkinChart::at_rest(s, X, kOffSkin_mm, beside).N);
  finely(places, [&](size_t i, double t, const Vec3& X) {
    const Vec3 look = (1 - t) * looks[i] + t * looks[std::min(i + 1, looks.size() - 1)];
    out.push_back(SkinChart::at_rest(s, X, kOffSkin_mm, beside, &look));
  });
  return out;
}

}  // namespace limberg
