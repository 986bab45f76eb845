#pragma once
// Lays the lattice over a body.
#include "sim/lattice/lattice.h"

namespace limberg {

/// Cells of about cell_mm over the body's box.
///  * A block (Body::is_box) gets counts rounded to the nearest and a pitch per axis such that the outermost planes lie
///    just outside its faces: at least one half-unit, at most `count` half-units (some micrometres).
///  * Any other body gets cubic cells that cover its surface, centred on it.
/// Planes lie on odd coordinates. With `levels`, cells can be divided that often: the pitch is a multiple of 2 <<
/// levels half-units, so that a block's outermost planes lie up to `count << levels` half-units outside. Throws
/// InputError when cell_mm is not finite and positive, larger than the smallest
/// extent of the body, or so small that there would be more than 20 million cells.
LatticeGrid fit_lattice(const Body& body, double cell_mm, int levels = 0);

}  // namespace limberg
