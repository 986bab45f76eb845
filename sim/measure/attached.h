#pragma once
// Which of the surface the body holds: a piece that has been cut free on all sides lies anywhere, and says nothing of
// the body's form.
#include <cstdint>
#include <vector>

#include "sim/base/union_find.h"
#include "sim/cutting/arrangement/surface_view.h"

namespace limberg {

/// Vertices that triangles join, as sets.
UnionFind pieces_of(const SurfaceView& view);

/// Per vertex, 1: its piece has a held face. A surface of which nothing is held counts whole.
std::vector<uint8_t> attached(const SurfaceView& view);

}  // namespace limberg
