#include "sim/fem/model/tiles.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace limberg::fem {
namespace {

constexpr int kTileEdgeCells = 12;

TileKey key_of(const FemModel& m, const Vec3& low, size_t c) {
  const Vec3 at = (m.X_mm[size_t(m.cells[c].node[0])] - low).cwiseQuotient(m.cell_mm);
  const int x = int(std::lround(at[0])), y = int(std::lround(at[1])), z = int(std::lround(at[2]));
  const uint64_t tile = uint64_t(x / kTileEdgeCells) << 12 | uint64_t(y / kTileEdgeCells);
  // A layer of cells after the other: neighbours in this order mostly have one stencil.
  return {tile << 40 | uint64_t(z) << 28 | uint64_t(x) << 14 | uint64_t(y), int32_t(c)};
}

/// Cells of scale 0 are absent from the tiles, and so are those all of whose energy is in material points (no boxes:
/// shaped_cells.h): a hexahedron's kernel has nothing to add there.
class Present {
 public:
  explicit Present(const FemModel& m) : m_(m) {
    for (const Stencil& s : m.stencils) box_.push_back(s.points.empty() || !s.points[0].gradients);
  }
  bool operator()(size_t c) const { return m_.cells[c].scale > 0 && box_[size_t(m_.cells[c].stencil)]; }

 private:
  const FemModel& m_;
  std::vector<uint8_t> box_;  // per stencil
};

}  // namespace

TileOrder order_cells(const FemModel& m) {
  TileOrder o;
  for (const Vec3& x : m.X_mm) o.low_mm = o.low_mm.cwiseMin(x);
  o.key.resize(m.cells.size());
  for (size_t c = 0; c < o.key.size(); ++c) o.key[c] = key_of(m, o.low_mm, c);
  std::sort(o.key.begin(), o.key.end());
  const auto absent = std::stable_partition(o.key.begin(), o.key.end(),
                                            [here = Present(m)](const TileKey& k) { return here(size_t(k.index)); });
  o.present = size_t(absent - o.key.begin());
  return o;
}

std::optional<TileOrder> order_cells(const FemModel& m, const FemModel& before, const TileOrder& order_before,
                                     std::vector<uint8_t>& changed) {
  const size_t cells_before = before.cells.size(), nodes_before = before.X_mm.size();
  if (before.cell_mm != m.cell_mm || m.cells.size() < cells_before || m.X_mm.size() < nodes_before) return std::nullopt;
  TileOrder o;
  o.low_mm = order_before.low_mm;
  bool same = true;
  for_each_change(before.X_mm, m.X_mm, [&](size_t n) {
    same = same && n >= nodes_before;
    o.low_mm = o.low_mm.cwiseMin(m.X_mm[n]);
  });
  if (!same || o.low_mm != order_before.low_mm) return std::nullopt;
  changed.assign(cells_before, 0);
  const Present here(m), here_before(before);
  std::vector<TileKey> fresh[2];  // present, absent
  for_each_change(before.cells, m.cells, [&](size_t c) {
    const TileKey key = key_of(m, o.low_mm, c);
    const bool present = here(c);
    if (c >= cells_before)
      fresh[present ? 0 : 1].push_back(key);
    else
      changed[c] = 1, same = same && key == key_of(before, o.low_mm, c) && present == here_before(c);
  });
  if (!same) return std::nullopt;
  o.key.reserve(m.cells.size());
  const auto middle = order_before.key.begin() + ptrdiff_t(order_before.present);
  for (std::vector<TileKey>& f : fresh) std::sort(f.begin(), f.end());
  std::merge(order_before.key.begin(), middle, fresh[0].begin(), fresh[0].end(), std::back_inserter(o.key));
  o.present = o.key.size();
  std::merge(middle, order_before.key.end(), fresh[1].begin(), fresh[1].end(), std::back_inserter(o.key));
  return o;
}

}  // namespace limberg::fem
