#pragma once
// The patient at rest: a closed surface, its layers (layers.h), what holds it. Generated (block.h) or loaded (obj.h).
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/body/chart.h"
#include "sim/body/collider.h"
#include "sim/body/layers.h"
#include "sim/body/region.h"
#include "sim/geometry/rest_grid.h"
#include "sim/geometry/tri_mesh.h"

namespace limberg {

class LawCatalogue;  // fem/materials/catalogue.h

/// The result of asking "where on the skin?" in rest space.
struct SkinHit {
  Vec3 X_mm = Vec3::Zero();     // on the rest surface
  Vec3 normal = Vec3::UnitZ();  // outward, unit
  int32_t triangle = -1;        // of Body::surface
};

struct Body {
  std::string name;
  RestGrid grid;
  TriMesh
      surface;  // vertices already on the even grid: X_mm == grid.to_mm(grid.to_grid(X_mm)); validated closed, embedded
  std::vector<Layer> layers;
  // Per layer and vertex of the surface how thick it is there (thickness.h); empty or missing: as `layers` says.
  std::vector<std::vector<float>> thickness_mm;
  std::shared_ptr<const LawCatalogue> laws;                // what layers may name; null: the shipped laws
  std::vector<std::shared_ptr<const Collider>> colliders;  // what it lies against
  std::vector<std::shared_ptr<const Region>> regions;      // tissue of its own, later ones over earlier ones
  std::vector<std::string> paints;                         // materials that an OBJ names
  std::vector<int32_t> paint_of;  // per triangle of the surface its material in `paints`; -1: none
  // Per triangle of the surface: springs that hold it, 0 where none do; empty: no springs.
  std::vector<float> soft_kPa_mm;
  std::vector<Vec3f> rgb;  // per vertex of the surface its own colour, sRGB, 0 to 1; empty: it looks like skin
  Vec3 tension_direction = Vec3::UnitX();
  // Per vertex of the surface how its lines of tension run there, unit, in its plane; their sense means nothing. Empty:
  // as tension_direction says, everywhere (tension_lines.h).
  std::vector<Vec3f> tension;
  Vec3 box_min_mm = Vec3::Zero(), box_max_mm = Vec3::Zero();
  bool is_box = false;  // an axis-aligned block: the lattice is fitted to it exactly
  // Of a box, bit 2 axis + (0 low, 1 high): a side tagged `fixed` that holds along its axis and slides in its plane
  uint8_t sliding_sides = 0;

  // Chart: a point p of the chart is the skin point met by the line through chart_origin + p.x e1 + p.y e2 along the
  // chart normal e1 x e2, outermost first.
  Vec3 chart_origin_mm = Vec3::Zero(), chart_e1 = Vec3::UnitX(), chart_e2 = Vec3::UnitY();
  double layer_thickness_mm(size_t layer, int32_t vertex) const {
    return layer < thickness_mm.size() && !thickness_mm[layer].empty() ? double(thickness_mm[layer][size_t(vertex)])
                                                                       : layers[layer].thickness_mm;
  }
  Chart chart() const { return {chart_origin_mm, chart_e1, chart_e2}; }
  Vec3 chart_normal() const { return chart().normal(); }
  ChartPoint to_chart(const Vec3& X_mm) const { return chart().to_chart(X_mm); }
};

}  // namespace limberg
