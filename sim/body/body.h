#pragma once
// The patient at rest: a closed surface, its layers and what holds it. Generated (block.h) or loaded (obj.h).
//
// depth is the distance in mm from the nearest skin-tagged triangle, measured inward. Layers are listed from the skin
// down; the last one reaches to the bottom whatever its thickness.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/geometry/rest_grid.h"
#include "sim/geometry/tri_mesh.h"

namespace limberg {

class LawCatalogue;  // fem/materials/catalogue.h

/// The law of a layer: its name and its constants as a scene gives them. Plain data; the catalogue makes the law of it.
struct LawSpec {
  struct Constant {
    std::string key;            // as in the scene, with its unit: "k1_kPa"
    std::vector<double> value;  // one number, or a list where the law takes one
  };
  std::string name;  // empty: stable neo-Hookean of young_kPa and poisson
  std::vector<Constant> constants;
};

/// Resistance to change of shape that fades: `share` of what a sudden strain meets at first, gone with exp(-t /
/// time_s).
struct PronyTerm {
  double share = 0, time_s = 1;
};

/// Elastic constants of a layer. nu is the Lame Poisson ratio (lambda = 2 mu nu / (1 - 2 nu)). With a law of its own
/// young_kPa is what that law has at small strain (of its matrix, where fibres lie in one), for figures that need one
/// number.
struct Material {
  double young_kPa = 60;
  double poisson = 0.45;
  double density_kg_mm3 = 1e-6;
  // Stretch that the tissue already carries at rest, along and across `Body::tension_direction`, within the skin plane;
  // the thickness direction takes 1/(along*across), so the prestretch keeps volume.
  double prestretch_along = 1, prestretch_across = 1;
  LawSpec law = {};
  std::vector<PronyTerm> prony = {};  // shares sum to less than 1; all constants above are those of the relaxed tissue
  std::string tissue = {};            // its name in the library of tissues, where it comes from there

  double mu_kPa() const { return young_kPa / (2 * (1 + poisson)); }
  double lambda_kPa() const { return 2 * mu_kPa() * poisson / (1 - 2 * poisson); }
};

struct Layer {
  std::string name;
  double thickness_mm = 1;
  Material material;
};

/// A point of the skin as scripts name it: chart coordinates in mm, independent of any mesh.
/// Block: (x, y) of the flat skin, origin at its centre. Loaded surface: the tangent plane that the scene names.
using ChartPoint = Vec2;

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
  std::shared_ptr<const LawCatalogue> laws;  // what layers may name; null: the shipped laws
  Vec3 tension_direction = Vec3::UnitX();
  Vec3 box_min_mm = Vec3::Zero(), box_max_mm = Vec3::Zero();
  bool is_box = false;  // an axis-aligned block: the lattice is fitted to it exactly

  // Chart: a point p of the chart is the skin point met by the line through chart_origin + p.x e1 + p.y e2 along the
  // chart normal e1 x e2, outermost first.
  Vec3 chart_origin_mm = Vec3::Zero(), chart_e1 = Vec3::UnitX(), chart_e2 = Vec3::UnitY();
  Vec3 chart_normal() const { return chart_e1.cross(chart_e2); }
  ChartPoint to_chart(const Vec3& X_mm) const {
    return {(X_mm - chart_origin_mm).dot(chart_e1), (X_mm - chart_origin_mm).dot(chart_e2)};
  }
};

}  // namespace limberg
