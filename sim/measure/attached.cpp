#include "sim/measure/attached.h"

namespace limberg {

UnionFind pieces_of(const SurfaceView& view) {
  UnionFind pieces(view.X_mm.size());
  for (const Tri& t : view.tri) pieces.unite(t[0], t[1]), pieces.unite(t[0], t[2]);
  return pieces;
}

std::vector<uint8_t> attached(const SurfaceView& view) {
  UnionFind pieces = pieces_of(view);
  std::vector<uint8_t> piece(view.X_mm.size(), 0);
  bool any = false;
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (view.kind[t] == FaceKind::fixed) piece[size_t(pieces.find(view.tri[t][0]))] = 1, any = true;
  if (!any) return std::vector<uint8_t>(view.X_mm.size(), 1);
  std::vector<uint8_t> out(view.X_mm.size());
  for (size_t v = 0; v < out.size(); ++v) out[v] = piece[size_t(pieces.find(int32_t(v)))];
  return out;
}

}  // namespace limberg
