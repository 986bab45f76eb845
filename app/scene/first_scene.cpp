#include "app/scene/first_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/scene/quoted_toml.h"
#include "sim/geometry/bvh.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

constexpr double kFaces = 0.7;  // cosine, of what counts for a side of the box
constexpr double kLast = 10;    // comes after every place of the box

std::array<double, 6> area_of_sides(const TriMesh& m) {
  std::array<double, 6> area{};
  for (const Tri& t : m.tri) {
    const Vec3 n = area_vector2(m.X_mm[size_t(t[0])], m.X_mm[size_t(t[1])], m.X_mm[size_t(t[2])]);
    for (size_t a = 0; a < 3; ++a)
      if (const double along = n[Eigen::Index(a)]; std::abs(along) > kFaces * n.norm())
        area[2 * a + (along > 0)] += std::abs(along);
  }
  return area;
}

std::string list(const Vec3& v) { return fmt::format("[{:.4g}, {:.4g}, {:.4g}]", v.x(), v.y(), v.z()); }

}  // namespace

std::string layers_of_the_shipped_face(double skin_mm) {
  return fmt::format(
      "[[layer]]\nname = \"skin\"\nthickness_mm = {:g}\nyoung_kPa = 60\npoisson = 0.45\ndensity_kg_m3 = "
      "1100\nprestretch_along = 1.08\nprestretch_across = 1.05\n\n[[layer]]\nname = \"fat and muscle\"\nthickness_mm = "
      "100\nyoung_kPa = 15\npoisson = 0.45\ndensity_kg_m3 = 950\n",
      skin_mm);
}

std::string first_scene(const Body& body, const std::string& mesh, double scale_to_mm) {
  const std::array<double, 6> area = area_of_sides(body.surface);
  // A slab has two sides alike: then upwards or forwards.
  constexpr size_t kOrder[] = {5, 3, 1, 4, 2, 0};
  size_t best = kOrder[0];
  for (const size_t side : kOrder)
    if (area[side] > 1.001 * area[best]) best = side;
  const auto axis = Eigen::Index(best / 2);
  Vec3 out = Vec3::Zero();
  out[axis] = best % 2 ? 1 : -1;
  const Vec3 up = axis == 2 ? Vec3::UnitY() : Vec3::UnitZ(), e1 = up.cross(out);
  const Vec3 size = body.box_max_mm - body.box_min_mm, middle = 0.5 * (body.box_min_mm + body.box_max_mm);
  // The nearest to the middle of the places where a line along `out` leaves the surface and the surface faces that way;
  // a wall (of a ring's hole, say) only where there is nothing else.
  const Bvh surface(body.surface.X_mm, body.surface.tri);
  Vec3 origin = middle;
  const double diagonal_mm = size.norm();
  double nearest = INFINITY;
  constexpr int kLines = 21;
  for (int i = 0; i < kLines * kLines; ++i) {
    const double u = double(i % kLines) / (kLines - 1) - 0.5, v = double(i / kLines) / (kLines - 1) - 0.5;
    const Vec3 from = middle + 0.97 * (u * e1.cwiseProduct(size) + v * up.cwiseProduct(size)) + 2 * diagonal_mm * out;
    const double from_middle = std::sqrt(u * u + v * v);
    if (from_middle >= nearest) continue;
    const auto hits = surface.line(from, -out, 0, 4 * diagonal_mm);
    if (hits.empty() || !hits[0].from_outside) continue;
    const Tri& t = body.surface.tri[size_t(hits[0].triangle)];
    const auto corner = [&](size_t k) -> const Vec3& { return body.surface.X_mm[size_t(t[k])]; };
    const Vec3 n = area_vector2(corner(0), corner(1), corner(2));
    const double off = from_middle + (n.dot(out) > kFaces * n.norm() ? 0 : kLast);
    if (off < nearest) nearest = off, origin = from - hits[0].t * out;
  }
  const double longest = size.maxCoeff(), shortest = size.minCoeff();
  const double cell = std::clamp(std::round(2 * longest / 30) / 2, 0.5, 5.0);
  std::string t = fmt::format(
      "# A scene to begin with: every line is meant to be changed.\nname = \"own\"\n\n[body]\nsource = \"obj\"\nmesh = "
      "{}\nscale_to_mm = {:g}\nchart_origin_mm = {} # script points [x, y] are mm from here\nchart_e1 = {}\nchart_e2 = "
      "{}\ntension_direction = {}\ndeep_direction = {} # what faces this way is held\n",
      quoted_toml(mesh), scale_to_mm, list(origin), list(e1), list(up), list(e1), list(-out));
  t += "\n" + layers_of_the_shipped_face(std::min(1.5, 0.2 * shortest));
  t += fmt::format("\n[lattice]\ncell_mm = {:g}\nwound_cell_mm = {:g} # where a blade goes\n{}refine_pockets = false\n",
                   std::min(cell, shortest), std::min(cell, shortest) / 2,
                   longest > 150 ? "region_mm = 60 # what lies farther from the origin holds still\n" : "");
  t += fmt::format(
      "\n[tools]\nmax_depth_mm = 12\ndefault_depth_mm = 4\n\n[camera]\ntarget_mm = {}\nfrom = {}\nup = "
      "{}\ndistance_mm = {:.0f}\nfov_deg = 28\n",
      list(origin), list(out - 0.3 * up + 0.2 * e1), list(up), std::clamp(2.5 * longest, 60.0, 2000.0));
  return t;
}

}  // namespace limberg
