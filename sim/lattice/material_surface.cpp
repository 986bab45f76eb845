#include "sim/lattice/material_surface.h"

#include <algorithm>
#include <numeric>

#include "sim/cutting/arrangement/store.h"

namespace limberg {

MaterialSurface material_surface(const Arrangement& arrangement) {
  const ArrangementStore& store = arrangement.store();
  return {store.grid, store.face, store.mate, store.orig, store.tag, &store.points, &store.history};
}

int32_t MaterialSurface::operations() const { return history ? int32_t(history->size()) : 0; }

std::vector<int32_t> MaterialSurface::suspects(int32_t operations_then, size_t faces_then) const {
  std::vector<int32_t> out;
  if (!history || size_t(operations_then) > history->size()) {
    out.resize(std::min(faces_then, faces.size()));
    std::iota(out.begin(), out.end(), 0);
    return out;
  }
  // The last operation of that time may have gone on since: debris is swept as a part of it.
  for (size_t i = size_t(std::max(0, operations_then - 1)); i < history->size(); ++i) {
    const OperationDelta& d = (*history)[i];
    for (int32_t f : d.retired)
      if (size_t(f) < faces_then) out.push_back(f);
    for (const auto& m : d.mat)
      if (size_t(m.first) < faces_then) out.push_back(m.first);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace limberg
