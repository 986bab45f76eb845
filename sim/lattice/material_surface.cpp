#include "sim/lattice/material_surface.h"

#include "sim/cutting/store.h"

namespace limberg {

MaterialSurface material_surface(const Arrangement& arrangement) {
  const ArrangementStore& store = arrangement.store();
  return {store.grid, store.face, store.mate, store.orig, store.tag, &store.points};
}

}  // namespace limberg
