#pragma once
// Reading of [lattice]: the size of its cells, and where they are divided. Heavy (toml++): include it from .cpp files
// only.
//
//   cell_mm         edge of a cell
//   refine_fronts, refine_pockets, region_mm: scene.h
//   wound_cell_mm   edge of the cells that a blade goes through, and of all that touch them; 0: as they are
//   fine            places and stretches with cells of their own: [{at_mm = [x, y], to_mm = [x, y], radius_mm, cell_mm,
//                   depth_mm}, ...]; to_mm and depth_mm may be left out
//
// Cells are halved, so a size is taken as the nearest of cell_mm, a half, a quarter and an eighth of it.
#include "app/scene/scene.h"
#include "app/scene/toml_table.h"

namespace limberg {

/// A size of cells as so many halvings of cell_mm, the nearest by ratio; fails on one that is larger than cell_mm or
/// smaller than an eighth of it.
int read_level(Table& table, const char* key, double cell_mm, double size_mm);

/// Into `scene`, whose body has been read.
void read_lattice(const toml::table& root, const std::string& file, Scene& scene);

/// Throws InputError when a place of `fine` is off the skin.
void check_fine_places(const Scene& scene, const std::shared_ptr<const Body>& body);

}  // namespace limberg
