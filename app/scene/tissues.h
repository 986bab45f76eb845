#pragma once
// A library of tissues: app/scene/tissues.toml is the shipped one. A scene's layer names one with
// tissue = "skin/cheek" and may change any of its values.
//
//   [[tissue]]        name, note, thickness_mm (optional), and the material as in a layer of a scene: law and its
//                     constants (or young_kPa), poisson, density_kg_m3, prestretch_along, prestretch_across, prony
//   [tissue.source]   per key of the above: where its value comes from. Every value needs one; one that was chosen says
//                     "engineering choice"
//
// A scene takes the first of: tissues.toml beside it, in the folder above it, in the folder scene/ beside its own, the
// shipped one (app/program/shipped.h).
#include <string>
#include <utility>
#include <vector>

#include "sim/body/body.h"
#include "sim/fem/materials/catalogue.h"

namespace limberg {

struct NamedTissue {
  std::string name, note;
  double thickness_mm = 0;  // 0: not given
  Material material;
  std::vector<std::pair<std::string, std::string>> source;  // key, where from
};

struct TissueLibrary {
  std::string path, text;
  std::vector<NamedTissue> tissues;
  const NamedTissue* find(const std::string& name) const;
  std::string names() const;
};

/// InputError with file, line, what is wrong and what was expected.
TissueLibrary parse_tissues(const std::string& text, const std::string& path, const LawCatalogue& laws);
/// Where the scene at that path finds its library; empty when there is none.
std::string find_tissues(const std::string& scene_path);

}  // namespace limberg
