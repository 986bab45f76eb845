#include "sim/fem/model/hold_part.h"

#include <algorithm>
#include <utility>

namespace limberg {

std::shared_ptr<const FemModel> hold_part(const FemModel& model, std::vector<uint8_t> out) {
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
