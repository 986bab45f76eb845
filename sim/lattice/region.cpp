#include "sim/lattice/region.h"

#include <utility>

#include "sim/fem/model/hold_part.h"

namespace limberg {

std::shared_ptr<const FemModel> hold_outside(std::shared_ptr<const FemModel> model, const Body& body,
                                             double radius_mm) {
  if (!(radius_mm > 0)) return model;
  const Vec3 axis = body.chart_normal().normalized();
  std::vector<uint8_t> out(model->X_mm.size(), 0);
  for (size_t i = 0; i < out.size(); ++i) {
    const Vec3 d = model->X_mm[i] - body.chart_origin_mm;
    out[i] = (d - d.dot(axis) * axis).squaredNorm() > radius_mm * radius_mm;
  }
  return hold_part(*model, std::move(out));
}

}  // namespace limberg
