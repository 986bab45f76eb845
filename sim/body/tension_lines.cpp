#include "sim/body/tension_lines.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "sim/body/between_places.h"
#include "sim/body/place_rows.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

constexpr const char* kTensionRow = "expected six numbers: x y z in mm, and dx dy dz along the lines there";
constexpr double kTellsAWay = 1e-3;  // of a unit vector, or of a mean's larger axis: less tells no way

Vec3 laid_flat(const Vec3& d, const Vec3& normal) { return d - d.dot(normal) * normal; }

}  // namespace

std::vector<TensionPlace> parse_tension_lines(std::string_view text, const std::string& file) {
  std::vector<TensionPlace> out;
  read_place_rows<6>(text, file, "six", kTensionRow, [&](const Vec3& X, const auto& value, const auto& fail) {
    const Vec3 d(value[3], value[4], value[5]);
    if (!(d.norm() > 1e-6 && d.norm() < 1e6)) fail("has lines that run nowhere");
    if (out.size() == TensionLimits::places) fail("is one place more than " + std::to_string(out.size()));
    out.push_back({X, d.normalized()});
  });
  return out;
}

std::vector<Vec3f> tension_lines_of(const TensionSpec& spec, const Body& body) {
  std::vector<TensionPlace> places = spec.places;
  if (!spec.file.empty())
    places = parse_tension_lines(read_whole_file(spec.file, TensionLimits::file_bytes, "lines of tension"), spec.file);
  std::vector<Vec3> at;
  for (const TensionPlace& p : places) at.push_back(p.at_mm);
  const BetweenPlaces between(at);
  const TriMesh& m = body.surface;
  std::vector<Vec3> normal(m.X_mm.size(), Vec3::Zero());
  for (size_t t = 0; t < m.tri.size(); ++t) {
    if (!m.tag.empty() && m.tag[t] != SurfaceTag::skin) continue;
    const Vec3 a2 = area_vector2(m.X_mm[size_t(m.tri[t][0])], m.X_mm[size_t(m.tri[t][1])], m.X_mm[size_t(m.tri[t][2])]);
    for (int32_t v : m.tri[t]) normal[size_t(v)] += a2;
  }
  std::vector<Vec3f> out;
  for (size_t v = 0; v < m.X_mm.size(); ++v) {
    const Vec3 n = normal[v].norm() > 0 ? normal[v].normalized() : Vec3(0, 0, 0);
    Mat3 mean = Mat3::Zero();
    for (const auto& [i, weight] : between.weights(m.X_mm[v])) {
      const Vec3 d = laid_flat(places[i].along, n);
      mean += weight * d * d.transpose();
    }
    mean /= std::max(mean.trace(), 1e-300);
    const Eigen::SelfAdjointEigenSolver<Mat3> axes(mean);  // ascending
    Vec3 along = axes.eigenvectors().col(2);
    if (!(axes.eigenvalues()[2] - axes.eigenvalues()[1] > kTellsAWay) || !along.allFinite())
      along = laid_flat(body.tension_direction, n);
    out.push_back((along.norm() > kTellsAWay ? Vec3(along.normalized()) : body.tension_direction).cast<float>());
  }
  return out;
}

Vec3 tension_along(const Body& body, int32_t triangle, const std::array<double, 3>& bary) {
  if (body.tension.empty() || triangle < 0) return body.tension_direction;
  const Tri& t = body.surface.tri[size_t(triangle)];
  Vec3 sum = Vec3::Zero();
  for (size_t k = 0; k < 3; ++k) {
    const Vec3 d = body.tension[size_t(t[k])].cast<double>();
    sum += (d.dot(body.tension[size_t(t[0])].cast<double>()) < 0 ? -bary[k] : bary[k]) * d;
  }
  return sum.norm() > kTellsAWay ? Vec3(sum.normalized()) : body.tension_direction;
}

Vec3 tension_along(const Body& body, int32_t triangle, const Vec3& X) {
  if (body.tension.empty() || triangle < 0) return body.tension_direction;
  const Tri& t = body.surface.tri[size_t(triangle)];
  const auto c = closest_on_triangle(X, body.surface.X_mm[size_t(t[0])], body.surface.X_mm[size_t(t[1])],
                                     body.surface.X_mm[size_t(t[2])]);
  return tension_along(body, triangle, c.bary);
}

}  // namespace limberg
