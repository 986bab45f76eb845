#pragma once
// Lays the lattice over a body.
#include "sim/lattice/lattice.h"

namespace limberg {

/// Cells of about cell_mm over the body's box.
///  * A block (Body::is_box) gets counts rounded to the nearest and a pitch per axis such that the outermost planes lie
///    just outside its faces: at least one half-unit, at most `count` half-units (some micrometres).
///  * Any other body gets cubic cells that cover its surface, centred on it.
/// Planes lie on odd coordinates. Throws InputError when cell_mm is not finite and positive, larger than the smallest
/// extent of the body, or so small that there would be more than 20 million cells.
LatticeGrid fit_lattice(const Body& body, double cell_mm);

}  // namespace limberg
