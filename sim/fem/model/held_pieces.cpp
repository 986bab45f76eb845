#include "sim/fem/model/held_pieces.h"

#include "sim/base/union_find.h"
#include "sim/fem/forces/spring_end.h"

namespace limberg::fem {

HeldPieces held_pieces(const FemModel& m, std::span<const Spring> springs) {
  UnionFind piece(m.X_mm.size());
  for (const HexCell& c : m.cells)
    for (int32_t v : c.node) piece.unite(v, c.node[0]);
  for (const HangingNode& h : m.hanging)
    for (size_t k = 0; k < size_t(h.count); ++k) piece.unite(h.node, h.master[k]);
  std::vector<int32_t> hooked;
  for (const Spring& s : springs) {
    int32_t first = -1;
    const auto tie = [&](int32_t v, double) {
      if (first < 0) first = v;
      piece.unite(v, first);
    };
    for_each_weight(s.held_a(), tie);
    if (s.to_world)
      hooked.push_back(first);
    else
      for_each_weight(s.held_b(), tie);
  }
  HeldPieces out{std::vector<int32_t>(m.X_mm.size()), std::vector<Held>(m.X_mm.size())};
  for (size_t v = 0; v < out.piece.size(); ++v) {
    out.piece[v] = piece.find(int32_t(v));
    out.held[size_t(out.piece[v])] |= m.fixed[v];
  }
  for (int32_t v : hooked)
    if (v >= 0) out.held[size_t(out.piece[size_t(v)])] = true;
  for (size_t v = 0; v < out.piece.size(); ++v) out.held[v] = out.held[size_t(out.piece[v])];
  return out;
}

}  // namespace limberg::fem
