#pragma once
// A model of which a part holds still: what lies outside is absent (scale 0), what lies on the rim is held.
#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "sim/fem/model/fem_model.h"

namespace limberg {

/// `out`, per node: 1 where it holds still. Cells of nothing but such nodes get scale 0. A hanging node holds still
/// where all its masters do, whatever it says of it; it is never held itself.
inline std::shared_ptr<FemModel> hold_part(const FemModel& model, std::vector<uint8_t> out) {
  auto m = std::make_shared<FemModel>(model);
  for (const HangingNode& h : m->hanging)  // held where its masters are
    out[size_t(h.node)] =
        std::all_of(h.master.begin(), h.master.begin() + h.count, [&](int32_t n) { return out[size_t(n)] != 0; });
  for (size_t i = 0; i < out.size(); ++i)
    if (out[i]) m->fixed.set(i, true);
  for (const HangingNode& h : m->hanging) m->fixed.set(size_t(h.node), false);
  for (size_t c = 0; c < m->cells.size(); ++c) {
    HexCell cell = std::as_const(m->cells)[c];
    if (!std::all_of(cell.node.begin(), cell.node.end(), [&](int32_t n) { return out[size_t(n)] != 0; })) continue;
    cell.scale = 0;
    m->cells.set(c, cell);
  }
  return m;
}

}  // namespace limberg
