#include "sim/body/collider.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <span>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "sim/geometry/enclosed_volume.h"
#include "sim/geometry/io/mesh_file.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

constexpr size_t kMostBytes = size_t(512) << 20;
constexpr ObjTextLimits kMostText{500'000, 1'000'000, 256};
constexpr double kLongest_mm = 1000, kLeast_mm3 = 1e-3;

/// Every edge has a face on either side, which run along it in opposite directions.
void check_closed(const TriMesh& m, std::span<const int32_t> line, const ColliderSpec& spec) {
  std::map<std::pair<int32_t, int32_t>, size_t> face_of;
  for (size_t t = 0; t < m.tri.size(); ++t)
    for (size_t k = 0; k < 3; ++k)
      if (!face_of.emplace(std::pair(m.tri[t][k], m.tri[t][(k + 1) % 3]), t).second)
        throw InputError(spec.path, line[t],
                         "an edge of the " + spec.what +
                             " has two faces that run the same way along it; expected a closed surface whose faces "
                             "all look outwards");
  for (const auto& [e, t] : face_of)
    if (!face_of.contains({e.second, e.first}))
      throw InputError(spec.path, line[t],
                       "the " + spec.what + " is open at an edge of this face; expected a closed surface");
}

}  // namespace

std::shared_ptr<const Collider> load_collider(const ColliderSpec& spec) {
  return parse_collider(read_whole_file(spec.path, kMostBytes, "a " + spec.what), spec);
}

std::shared_ptr<const Collider> parse_collider(std::string_view text, const ColliderSpec& spec) {
  const ObjText read = parse_mesh_file(text, spec.path, kMostText);
  if (read.face.empty()) throw InputError(spec.path, 0, "no faces; expected a surface in an OBJ, PLY or STL file");
  auto c = std::make_shared<Collider>();
  c->name = std::filesystem::path(spec.path).stem().string(), c->colour = spec.colour, c->rgb = read.rgb;
  TriMesh& m = c->mesh;
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const Vec3& v : read.v) m.X_mm.push_back(spec.scale_to_mm * v);
  std::vector<int32_t> line;
  for (const ObjText::Face& f : read.face)
    for (size_t k = 1; k + 1 < f.corners; ++k) {
      const auto corner = [&](size_t i) { return read.corner[f.first + i].v; };
      m.tri.push_back({corner(0), corner(k), corner(k + 1)});
      line.push_back(f.line);
      for (const int32_t v : m.tri.back())
        low = low.cwiseMin(m.X_mm[size_t(v)]), high = high.cwiseMax(m.X_mm[size_t(v)]);
    }
  if (const double longest = (high - low).maxCoeff(); !(longest <= kLongest_mm))
    throw InputError(spec.path, 0,
                     fmt::format("the {} is {:g} mm long; expected at most {:g} (is the scale right?)", spec.what,
                                 longest, kLongest_mm));
  if (spec.closed) {
    check_closed(m, line, spec);
    turn_outwards(m);
    if (const double volume_mm3 = enclosed_volume(m.X_mm, m.tri); !(volume_mm3 > kLeast_mm3))
      throw InputError(spec.path, 0,
                       fmt::format("the {} holds {:g} mm3; expected a surface around some volume, its faces all "
                                   "counter-clockwise seen from outside",
                                   spec.what, volume_mm3));
  }
  std::erase_if(m.tri, [&](const Tri& t) {  // they have no side
    return !(area_vector2(m.X_mm[size_t(t[0])], m.X_mm[size_t(t[1])], m.X_mm[size_t(t[2])]).norm() > 0);
  });
  return c;
}

}  // namespace limberg
