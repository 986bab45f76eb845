#pragma once
// What a body is made of: its layers and their materials, as a scene gives them (fem/materials makes laws of it).
//
// depth is the distance in mm from the nearest skin-tagged triangle, measured inward. Layers are listed from the skin
// down; the last one reaches to the bottom whatever its thickness.
#include <string>
#include <vector>

namespace limberg {

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

}  // namespace limberg
