#pragma once
// What holds a block and what loads a body:
//
//   [body]   sliding_sides = ["-x", "-y", ...]   sides of a block that hold along their axis and slide in their
//                                                plane, as rollers and planes of symmetry do
//            free_sides = ["+x"]                 sides that hold nothing; -z is the bottom. All others hold, the
//                                                skin is free; one side at least must hold or slide
//   [loads]  gravity_m_s2 = [0, 0, -9.81]        weight, along the axes of the body; at most 100 m/s^2. Absent: none
//            patches = [{at_mm = [x, y], force_N = [x, y, z], radius_mm}, ...]
//                                                dead forces on patches of skin, at most 32 and 100 N each; radius_mm
//                                                from 0 to 20 (2)
//            cell_mm                             edge of cells within 8 mm of a patch; half of [lattice]'s if absent.
//                                                A force on few cells that skin and fat share moves up to a fifth
//                                                too little in cells of 5 mm, 3 % off in halves (docs/validation.md)
//
// The body as given is its shape without weight and loads: it sags from there.
#include <memory>

#include "app/scene/scene.h"
#include "app/scene/toml_table.h"

namespace limberg {

/// The keys of [body].
void read_sides(Table& body, Scene& scene);
/// [loads], after [lattice].
void read_loads(const toml::table& root, const std::string& file, Scene& scene);
/// Throws InputError with the line of a load that lies off the skin.
void check_load_places(const Scene& scene, const std::shared_ptr<const Body>& body);

}  // namespace limberg
