#pragma once
// In which order the kernels take the cells, and in which tiles: square tiles of the
// xy plane, full height, neither too small nor too large. A tile numbers its nodes
// by itself, so most tiles of a model are those of the model before a cut, moved.
#include <compare>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/fem/model/fem_model.h"

namespace limberg::fem {

struct TileKey {
  uint64_t place = 0;  // tile x, tile y, z, x, y: 12, 12, 12, 14 and 14 bits
  int32_t index = 0;   // of the model's cell
  auto operator<=>(const TileKey&) const = default;
  uint64_t tile() const { return place >> 40; }
};

struct TileOrder {
  Vec3 low_mm = Vec3::Constant(1e300);  // of the model's box: places are counted from here
  std::vector<TileKey> key;             // ascending; cells that are absent (scale 0) after all others
  size_t present = 0;
};

TileOrder order_cells(const FemModel& model);

/// The same, from the order of an earlier model whose nodes and cells the model begins with; nothing when it has moved
/// any, or made one absent. `changed`: per earlier cell, 1 when it is not what it was.
std::optional<TileOrder> order_cells(const FemModel& model, const FemModel& before, const TileOrder& order_before,
                                     std::vector<uint8_t>& changed);

/// A tile is complete when it has so many cells and the next one is in another square, or when it is full.
inline bool tile_ends(int cells, bool next_square) {
  constexpr int kMin = 256, kMax = 960;
  return (next_square && cells >= kMin) || cells >= kMax;
}

}  // namespace limberg::fem
