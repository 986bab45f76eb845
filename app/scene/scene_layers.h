#pragma once
// Reading of materials: a layer of a scene, a tissue of a library. Heavy (toml++): include it from .cpp files only.
//
//   [[layer]]   name           what it is called; a tissue's name serves when it is missing
//               tissue         of the library (tissues.h): gives every value that the layer does not
//               thickness_mm, poisson, density_kg_m3, prestretch_along, prestretch_across
//               thickness_points   where it is not as thick everywhere: [[x, y, z, thickness], ...] in mm, or
//               thickness_file     a file of such rows, or
//               down_to            an OBJ, PLY or STL of the surface it ends on, with scale_to_mm (body/thickness.h)
//               law            of the catalogue; without it stable-neo-hookean, which takes young_kPa
//               constants of the law by their keys: k1_kPa = 50; lists where the law takes several: alpha = [9, -4]
//               prony          [[share, time_s], ...]: what fades of the stiffness after a
//                              strain, in dynamic scenes; all other constants are those of
//                              the relaxed tissue, which is what a quasi-static scene has
#include <functional>

#include "app/scene/scene.h"
#include "app/scene/tissues.h"
#include "app/scene/toml_table.h"

namespace limberg {

/// Nothing known: what read_material asks for all of.
Material unknown_material();
/// The keys of a material. `m` holds what is known already. Its young_kPa becomes that of the law at small strain.
void read_material(Table& t, Material& m, const LawCatalogue& laws);
/// The tissue of the library that a table names; null: it names none.
const NamedTissue* named_tissue(Table& t, const std::function<const TissueLibrary&(Table&)>& library);
struct SceneLayers {
  std::vector<Layer> layers;
  std::vector<ThicknessSpec> thickness;  // of each
  std::vector<int> line;
};
/// `library` is asked for when a layer names a tissue; it throws when there is none.
SceneLayers read_layers(const toml::table& root, const std::string& file, const LawCatalogue& laws,
                        const std::function<const TissueLibrary&(Table&)>& library);
/// The thicknesses by place of a body that is whole otherwise.
void add_thickness(const Scene& scene, Body& body);

}  // namespace limberg
