#include "sim/lattice/copy_layers.h"

#include <algorithm>
#include <cmath>

#include "sim/cutting/arrangement/point_store.h"

namespace limberg {
namespace {

// Lines stand a little off the middle of their square: a blade's corners like round numbers.
constexpr double kOff = 0.0137;

struct Crossing {
  double at = 0;  // along the line, in cell units
  int before = -1, after = -1;
};

double place(int i) { return (i + 0.5 + kOff) / kColumns; }

// First and last of the lines between these places; none: the first is beyond the last.
std::pair<int, int> lines_within(std::initializer_list<double> at) {
  const auto [low, high] = std::minmax(at);
  const auto line = [](double x) { return x * kColumns - 0.5 - kOff; };
  return {int(std::ceil(std::clamp(line(low), 0.0, double(kColumns)))),
          int(std::floor(std::clamp(line(high), -1.0, kColumns - 1.0)))};
}

struct Corner2 {
  double x = 0, y = 0;
};
double side_of(const Corner2& a, const Corner2& b, const Corner2& p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

// Adds the part of [from, to] that each layer has; the depth grows from `depth` at 0 by `slope`.
void add_layers(double from, double to, double depth, double slope, std::span<const double> end_mm, double area,
                double* sum) {
  for (size_t l = 0; l <= end_mm.size(); ++l) {
    const double above = l == 0 ? -INFINITY : end_mm[l - 1], below = l == end_mm.size() ? INFINITY : end_mm[l];
    double lo = from, hi = to;
    if (std::abs(slope) > 1e-9) {
      const double a = (above - depth) / slope, b = (below - depth) / slope;
      lo = std::max(lo, std::min(a, b)), hi = std::min(hi, std::max(a, b));
    } else if (!(depth >= above && depth < below)) {
      continue;
    }
    if (hi > lo) sum[l] += area * (hi - lo);
  }
}

}  // namespace

std::vector<double> layers_of_classes(const CellComponents& cell, const MaterialSurface& surface, const Vec3& low_half,
                                      const Vec3& size_half, const CellDepth& depth, std::span<const double> end_mm) {
  const size_t layers = end_mm.size() + 1;
  std::vector<double> out(cell.classes.size() * layers, 0.0);
  const Vec3 size_mm = surface.grid.half_unit_mm() * size_half;
  Eigen::Index up = 0;
  depth.down.cwiseAbs().maxCoeff(&up);
  const size_t a = size_t(up), b = (a + 1) % 3, c = (a + 2) % 3;
  std::array<std::vector<Crossing>, size_t(kColumns) * kColumns> crossing;
  for (size_t f = 0; f < cell.face.size(); ++f) {
    const auto [plus, minus] = cell.of_side[f];
    if (plus == minus) continue;
    const int32_t face = cell.face[f];
    const int64_t n = surface.plane(face).n[a];
    if (n == 0) continue;
    std::array<Corner2, 3> p;
    std::array<double, 3> z{};
    for (size_t k = 0; k < 3; ++k) {
      const Vec3& x = surface.points->approx(surface.faces[size_t(face)].v[k]);
      const auto unit = [&](size_t axis) { return (x[int(axis)] - low_half[int(axis)]) / size_half[int(axis)]; };
      p[k] = {unit(b), unit(c)}, z[k] = unit(a);
    }
    const double area = side_of(p[0], p[1], p[2]);
    if (area == 0) continue;
    const auto [x0, x1] = lines_within({p[0].x, p[1].x, p[2].x});
    const auto [y0, y1] = lines_within({p[0].y, p[1].y, p[2].y});
    for (int j = y0; j <= y1; ++j)
      for (int i = x0; i <= x1; ++i) {
        const Corner2 at{place(i), place(j)};
        const double u = side_of(p[1], p[2], at) / area, v = side_of(p[2], p[0], at) / area, w = 1 - u - v;
        if (u < 0 || v < 0 || w < 0) continue;
        const double t = u * z[0] + v * z[1] + w * z[2];
        if (t <= 0 || t >= 1) continue;
        const Crossing x = n > 0 ? Crossing{t, minus, plus} : Crossing{t, plus, minus};
        crossing[size_t(kColumns * j + i)].push_back(x);
      }
  }
  const double slope = depth.down[up] * size_mm[up], area = size_mm.prod() / (kColumns * kColumns);
  for (int j = 0; j < kColumns; ++j)
    for (int i = 0; i < kColumns; ++i) {
      std::vector<Crossing>& on = crossing[size_t(kColumns * j + i)];
      std::sort(on.begin(), on.end(), [](const Crossing& l, const Crossing& r) { return l.at < r.at; });
      const double at_foot = depth.at_centre_mm - 0.5 * slope +
                             depth.down[int(b)] * (place(i) - 0.5) * size_mm[int(b)] +
                             depth.down[int(c)] * (place(j) - 0.5) * size_mm[int(c)];
      const size_t edge = size_t(i >= kColumns / 2) << b | size_t(j >= kColumns / 2) << c;
      const int foot = cell.of_corner[edge] >= 0 ? cell.of_corner[edge] : cell.of_corner[edge | size_t(1) << a];
      double from = 0;
      int in = on.empty() ? foot : on[0].before;
      for (size_t k = 0; k <= on.size(); ++k) {
        const double to = k < on.size() ? on[k].at : 1;
        if (in >= 0) add_layers(from, to, at_foot, slope, end_mm, area, &out[size_t(in) * layers]);
        if (k < on.size()) from = to, in = on[k].after;
      }
    }
  return out;
}

int32_t stencil_of_copy(const StencilTable& table, const MaterialSurface& surface, const LatticeTopology& t,
                        int32_t cell, int cls, int32_t whole) {
  const CellPlace place = t.tree.place(t.grid, cell);
  const std::shared_ptr<const CellComponents>& in = t.components[size_t(cell)];
  const LayeredCell* layered = whole < 0 ? nullptr : table.layered(whole);
  if (!layered || !in || in->classes[size_t(cls)].fraction < kLeastFraction) return whole;
  const bool walls = std::any_of(in->face.begin(), in->face.end(),
                                 [&](int32_t f) { return surface.orig[size_t(surface.faces[size_t(f)].orig)].op > 0; });
  if (!walls) return whole;

  const LatticeGrid grid = t.grid.at_level(place.level);
  const Vec3 low(grid.origin.x + double(place.at.x) * grid.pitch.x, grid.origin.y + double(place.at.y) * grid.pitch.y,
                 grid.origin.z + double(place.at.z) * grid.pitch.z);
  const Vec3 size(grid.pitch.x, grid.pitch.y, grid.pitch.z);
  const std::vector<double> found = layers_of_classes(*in, surface, low, size, layered->depth, table.layer_ends());
  const size_t layers = table.layer_ends().size() + 1;
  std::vector<double> share(layers, 0.0), all(layers, 0.0);
  double volume = 0, fractions = 0;
  for (size_t k = 0; k < in->classes.size(); ++k) {
    fractions += in->classes[k].fraction;
    for (size_t l = 0; l < layers; ++l) {
      all[l] += found[k * layers + l];
      if (int(k) == cls) share[l] = found[k * layers + l], volume += share[l];
    }
  }
  if (!(volume > 0)) return whole;  // between the lines
  // Nothing was taken out: together the classes hold what the cell does.
  const double cell_mm3 = grid.cell_mm().prod();
  const bool complete = std::abs(fractions * cell_mm3 - table.body_mm3(whole)) < 0.01 * table.body_mm3(whole);
  double sum = 0;
  for (size_t l = 0; l < layers; ++l) {
    if (complete && all[l] > 0) share[l] *= layered->volume_mm3(l) / all[l];
    if (!(layered->volume_mm3(l) > 0)) share[l] = 0;
    sum += share[l];
  }
  if (!(sum > 0)) return whole;
  double base = 0;
  for (size_t l = 0; l < layers; ++l) base += layered->volume_mm3(l);
  bool same = true;
  std::vector<int32_t> steps(layers);
  for (size_t l = 0; l < layers; ++l) {
    steps[l] = int32_t(std::lround(kShareSteps * share[l] / sum));
    same = same && std::abs(share[l] / sum - layered->volume_mm3(l) / base) < kSameShare;
  }
  return same ? whole : table.mixed(whole, steps);
}

}  // namespace limberg
