#include "sim/body/thickness.h"

#include <algorithm>
#include <optional>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "sim/body/between_places.h"
#include "sim/body/body.h"
#include "sim/body/place_rows.h"
#include "sim/geometry/sided_patch.h"

namespace limberg {
namespace {

constexpr const char* kRow = "expected four numbers: x y z thickness, in mm";

std::vector<float> down_to(const ThicknessSpec& spec, const Body& body, size_t layer) {
  ColliderSpec file;
  file.path = spec.down_to, file.scale_to_mm = spec.scale_to_mm, file.closed = false;
  file.what = "surface that a layer ends on";
  const std::shared_ptr<const Collider> end = load_collider(file);
  const Bvh surface(end->mesh.X_mm, end->mesh.tri);
  const TriMesh& m = body.surface;
  std::vector<int32_t> skin;
  for (size_t t = 0; t < m.tri.size(); ++t)
    if (m.tag.empty() || m.tag[t] == SurfaceTag::skin) skin.push_back(int32_t(t));
  std::vector<float> out(m.X_mm.size(), float(body.layers[layer].thickness_mm));
  if (skin.empty()) return out;
  const SidedPatch patch(m, skin);
  size_t all = 0, met = 0;
  for (size_t v = 0; v < m.X_mm.size(); ++v) {
    const Vec3& out_of_skin = patch.corner_normal(int32_t(v));
    if (out_of_skin.isZero(0)) continue;  // no corner of it
    double above = 0;
    for (size_t l = 0; l < layer; ++l) above += body.layer_thickness_mm(l, int32_t(v));
    const std::vector<Bvh::LineHit> hits = surface.line(m.X_mm[v], -out_of_skin, 0, above + ThicknessLimits::most_mm);
    ++all, met += !hits.empty();
    const double deep = hits.empty() ? surface.closest(m.X_mm[v]).distance_mm : hits[0].t;
    if (deep - above > ThicknessLimits::most_mm)
      throw InputError(spec.down_to, 0,
                       "lies " + std::to_string(int(deep)) + " mm from a place of the skin; expected at most " +
                           std::to_string(int(ThicknessLimits::most_mm)) + " mm of a layer");
    out[v] = float(std::max(deep - above, ThicknessLimits::least_mm));
  }
  if (2 * met < all)
    throw InputError(spec.down_to, 0,
                     "lies beneath " + std::to_string(met) + " of " + std::to_string(all) +
                         " corners of the skin; expected a surface below at least half of it, in the same frame");
  return out;
}

}  // namespace

std::vector<PlaceThickness> parse_thickness(std::string_view text, const std::string& file) {
  std::vector<PlaceThickness> out;
  read_place_rows<4>(text, file, "four", kRow, [&](const Vec3& X, const auto& value, const auto& fail) {
    if (!(value[3] >= ThicknessLimits::least_mm && value[3] <= ThicknessLimits::most_mm))
      fail("has a thickness that is not from 0.1 to 100 mm");
    if (out.size() == ThicknessLimits::points) fail("is one place more than " + std::to_string(out.size()));
    out.push_back({X, value[3]});
  });
  return out;
}

std::vector<float> thickness_of(const ThicknessSpec& spec, const Body& body, size_t layer) {
  if (!spec.down_to.empty()) return down_to(spec, body, layer);
  std::vector<PlaceThickness> points = spec.points;
  if (!spec.file.empty())
    points =
        parse_thickness(read_whole_file(spec.file, ThicknessLimits::file_bytes, "thicknesses of a layer"), spec.file);
  std::vector<Vec3> at;
  for (const PlaceThickness& p : points) at.push_back(p.at_mm);
  const BetweenPlaces between(at);
  std::vector<float> out;
  for (const Vec3& X : body.surface.X_mm) {
    double sum = 0, weights = 0;
    for (const auto& [i, weight] : between.weights(X)) sum += weight * points[i].thickness_mm, weights += weight;
    out.push_back(float(sum / weights));
  }
  return out;
}

}  // namespace limberg
