#include "sim/lattice/grid_fit.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "sim/base/error.h"

namespace limberg {
namespace {

constexpr double kMaxCells = 2e7;

std::string mm(double v) {
  std::string s = std::to_string(v);
  while (s.back() == '0') s.pop_back();
  if (s.back() == '.') s.pop_back();
  return s + " mm";
}

}  // namespace

LatticeGrid fit_lattice(const Body& body, double cell_mm, int levels) {
  auto fail = [&](const std::string& what) { throw InputError(body.name, 0, what); };
  if (!std::isfinite(cell_mm) || cell_mm <= 0)
    fail("the cell size is " + mm(cell_mm) + "; a length above 0 was expected");
  if (body.surface.X_mm.empty()) fail("the body has no surface; a closed surface was expected");
  Int3 low = body.grid.to_grid(body.surface.X_mm[0]), high = low;
  for (const Vec3& X : body.surface.X_mm) {
    const Int3 g = body.grid.to_grid(X);
    low = {std::min(low.x, g.x), std::min(low.y, g.y), std::min(low.z, g.z)};
    high = {std::max(high.x, g.x), std::max(high.y, g.y), std::max(high.z, g.z)};
  }
  const double half_unit = body.grid.half_unit_mm();
  double smallest = INFINITY, cells = 1;
  for (int a = 0; a < 3; ++a) {
    smallest = std::min(smallest, (high[a] - low[a]) * half_unit);
    cells *= (high[a] - low[a]) * half_unit / cell_mm + 1;
  }
  if (cell_mm > smallest)
    fail("the cell size is " + mm(cell_mm) + ", larger than the body's smallest extent; at most " + mm(smallest) +
         " was expected");
  if (cells > kMaxCells)
    fail("the cell size " + mm(cell_mm) + " makes more than 20 million cells; a larger one was expected");

  const int32_t unit = 2 << levels;
  LatticeGrid grid;
  grid.rest = body.grid;
  int32_t origin[3], pitch[3], count[3];
  for (int a = 0; a < 3; ++a) {
    const int64_t span = int64_t(high[a]) - low[a] + 2;  // between the odd planes just outside
    if (body.is_box) {
      count[a] = std::max(1, int(std::lround((high[a] - low[a]) * half_unit / cell_mm)));
      pitch[a] = int32_t((span + count[a] - 1) / count[a]);
      pitch[a] = (pitch[a] + unit - 1) / unit * unit;
    } else {
      pitch[a] = unit * std::max(1, int32_t(std::lround(cell_mm / half_unit / unit)));
      count[a] = int32_t((span + pitch[a] - 1) / pitch[a]);
    }
    const int64_t spare = int64_t(count[a]) * pitch[a] - span;  // even: both are
    origin[a] = int32_t(low[a] - 1 - (spare / 4) * 2);
  }
  grid.origin = {origin[0], origin[1], origin[2]};
  grid.pitch = {pitch[0], pitch[1], pitch[2]};
  grid.count = {count[0], count[1], count[2]};
  return grid;
}

}  // namespace limberg
