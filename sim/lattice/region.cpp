#include "sim/lattice/region.h"

#include <algorithm>
#include <utility>

namespace limberg {

std::shared_ptr<const FemModel> hold_outside(std::shared_ptr<const FemModel> model, const Body& body,
                                             double radius_mm) {
  if (!(radius_mm > 0)) return model;
  auto m = std::make_shared<FemModel>(*model);
  const Vec3 axis = body.chart_normal().normalized();
  std::vector<uint8_t> out(m->X_mm.size(), 0);
  for (size_t i = 0; i < out.size(); ++i) {
    const Vec3 d = std::as_const(m->X_mm)[i] - body.chart_origin_mm;
    out[i] = (d - d.dot(axis) * axis).squaredNorm() > radius_mm * radius_mm;
  }
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
