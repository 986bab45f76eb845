#include "sim/cutting/arrangement/tri_tests.h"
#include "sim/cutting/strokes/blade_parts.h"
#include "sim/cutting/strokes/sheet_mesh.h"

namespace limberg {

BladeResult build_plug(const BladeContext& c, std::span<const ChartPoint> outline, double depth_mm) {
  std::string why = check_stroke(outline, depth_mm);
  if (!why.empty()) return refuse(why);
  std::vector<Vec2> path = clean_outline(outline, why);
  if (path.empty()) return refuse(why);
  path = resample(path, kSpacing, true);
  const auto floor = mesh_polygon(path, kSheetSpacing);
  if (!floor) return refuse("the outline cannot be filled; expected a simple outline");
  std::vector<Column> columns;  // of the outline, then of the floor's inside
  if (why = columns_at(c, floor->vertex, columns); !why.empty()) return refuse(why);
  Blade blade;
  std::vector<int32_t> id;
  bool embedded = false;
  for (const double stiffness : kStiffness) {
    if (embedded) break;
    const std::vector<Column> held = stiffened(columns, stiffness);
    std::vector<Vec3> direction;
    for (size_t i = 0; i < path.size(); ++i) direction.push_back(-held[i].normal);
    blade = Blade{};
    id.clear();
    const int rows = add_ring(blade, c, std::span(held).first(path.size()), direction, depth_mm);
    for (size_t i = 0; i < held.size(); ++i) {
      if (i < path.size()) {
        id.push_back(int32_t(i) * (rows + 1) + rows);  // the foot of a column
        continue;
      }
      id.push_back(int32_t(blade.vertex.size()));
      blade.vertex.push_back(c.body->grid.to_grid(held[i].X - held[i].normal * depth_mm));
    }
    std::vector<Tri> all = blade.tri;
    for (const Tri& t : floor->tri) all.push_back({id[size_t(t[0])], id[size_t(t[1])], id[size_t(t[2])]});
    embedded = check_embedded(blade.vertex, all).empty();
  }
  if (!embedded)
    return refuse("the plug's walls would run through one another; expected less depth or a wider outline");
  for (const Tri& t : floor->tri) {
    blade.tri.push_back({id[size_t(t[0])], id[size_t(t[1])], id[size_t(t[2])]});
    std::array<Eigen::Vector2f, 3> uv;
    for (size_t k = 0; k < 3; ++k) uv[k] = floor->vertex[size_t(t[k])].cast<float>();
    blade.uv_mm.push_back(uv);
  }
  blade.seed.assign(blade.tri.size(), 2);
  if (why = fits_grid(c, blade); !why.empty()) return refuse(why);
  return {std::move(blade), {}};
}

}  // namespace limberg
