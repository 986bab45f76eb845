#include "sim/fem/elements/lane_blocks.h"

#include <algorithm>
#include <array>

namespace limberg::fem {
namespace {

constexpr int kRun = 6;    // of one stencil: every instruction set takes so many together (kernels/parts.h)
constexpr int kLanes = 6;  // of a block's sixteen: fewer cost more than one by one

LaneBlock::Kind kind_of(const KernelStencil& s) {
  return s.slide != 0 ? LaneBlock::layers : s.centred ? LaneBlock::centred : LaneBlock::off_centre;
}

template <size_t N>
void put_rows(float* to, int lane, const float (&from)[N]) {
  for (size_t i = 0; i < N; ++i) to[16 * i + size_t(lane)] = from[i];
}

void put(LaneBlock& b, int lane, const KernelStencil& s) {
  put_rows(b.K, lane, s.K), put_rows(b.f0, lane, s.f0), put_rows(b.inv4h, lane, s.inv4h);
  b.volume[lane] = s.volume, b.p0[lane] = s.p0, b.ke[lane] = s.ke;
  put_rows(b.bx, lane, s.bx), put_rows(b.by, lane, s.by), put_rows(b.bz, lane, s.bz);
  b.slide[lane] = s.slide, b.rest[lane] = s.rest, b.rest_lambda[lane] = s.rest_lambda;
  for (int i = 0; i < 3; ++i)
    b.along[16 * i + lane] = s.along[i], b.across[16 * i + lane] = s.across[i], b.normal[16 * i + lane] = s.normal[i];
}

}  // namespace

std::shared_ptr<const LaneBlocks> lane_blocks(const KernelStencil* stencils, std::span<const KernelCell> tile) {
  const auto made = std::make_shared<LaneBlocks>();
  made->kind.assign(tile.size(), LaneBlock::none);
  std::array<std::vector<int32_t>, LaneBlock::none> of_kind;
  for (size_t c = 0; c < tile.size();) {
    size_t end = c + 1;
    while (end < tile.size() && tile[end].stencil == tile[c].stencil) ++end;
    if (end - c < size_t(kRun))
      for (size_t i = c; i < end; ++i) of_kind[kind_of(stencils[tile[i].stencil])].push_back(int32_t(i));
    c = end;
  }
  // Blocks in the order of their first cells.
  struct Lot {
    LaneBlock::Kind kind;
    std::span<const int32_t> cells;
  };
  std::vector<Lot> lots;
  for (size_t k = 0; k < of_kind.size(); ++k)
    for (size_t i = 0; i + size_t(kLanes) <= of_kind[k].size(); i += 16)
      lots.push_back(
          {LaneBlock::Kind(k), std::span(of_kind[k]).subspan(i, std::min<size_t>(16, of_kind[k].size() - i))});
  if (lots.empty()) return nullptr;
  std::sort(lots.begin(), lots.end(), [](const Lot& a, const Lot& b) { return a.cells[0] < b.cells[0]; });
  made->block.resize(lots.size());
  for (size_t n = 0; n < lots.size(); ++n) {
    LaneBlock& b = made->block[n];
    const std::span<const int32_t> cells = lots[n].cells;
    b.kind = lots[n].kind, b.count = int32_t(cells.size());
    for (int l = 0; l < 16; ++l) {
      const int32_t c = b.cell[l] = cells[std::min(size_t(l), cells.size() - 1)];
      made->kind[size_t(c)] = b.kind;
      put(b, l, stencils[tile[size_t(c)].stencil]);
    }
  }
  return made;
}

}  // namespace limberg::fem
