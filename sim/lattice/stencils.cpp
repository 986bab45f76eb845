// Integrals over full cells, and which cell takes which.
#include <algorithm>
#include <cmath>
#include <string>

#include "sim/error.h"
#include "sim/lattice/fem_assembly.h"

namespace limberg {
namespace {

// Adds the box [lo, hi] (in cell units, 0..1 per axis) of one material to a stencil whose means are still sums.
void add_box(Stencil& s, const Vec3& cell_mm, const Vec3& lo, const Vec3& hi, const Material& m, const StretchFrame& frame) {
  const Mat3 A = prestretch_tensor(m, frame);
  const double volume = cell_mm.prod() * (hi - lo).prod(), mu = m.mu_kPa();
  constexpr double kGauss = 0.28867513459481288;  // half of 1/sqrt(3)
  for (int q = 0; q < 8; ++q) {
    Vec3 x;
    for (int a = 0; a < 3; ++a) x[a] = 0.5 * (lo[a] + hi[a]) + (hi[a] - lo[a]) * (q >> a & 1 ? kGauss : -kGauss);
    Eigen::Matrix<double, 3, 8> grad;
    for (int n = 0; n < 8; ++n)
      for (int a = 0; a < 3; ++a) {
        double v = (n >> a & 1 ? 1 : -1) / cell_mm[a];
        for (int b = 0; b < 3; ++b)
          if (b != a) v *= n >> b & 1 ? x[b] : 1 - x[b];
        grad(a, n) = v;
      }
    s.K += grad.transpose() * (mu * volume / 8 * A) * grad;
  }
  if (s.volume_mm3 == 0) s.sample.setZero();
  s.volume_mm3 += volume;
  s.mu_kPa += volume * mu;
  s.lambda_kPa += volume * (m.lambda_kPa() + mu);
  const double p0 = mu * frame.normal.dot(A * frame.normal);
  s.p0_kPa += volume * p0;
  s.sample += volume * p0 * 0.5 * (lo + hi);
  s.density_kg_mm3 += volume * m.density_kg_mm3;
}

// Sums to means; rows of K to exact zero sums (rounding goes to the diagonal).
void finish(Stencil& s) {
  s.mu_kPa /= s.volume_mm3;
  s.lambda_kPa /= s.volume_mm3;
  s.sample /= s.p0_kPa;
  for (double& x : s.sample)
    if (std::abs(x - 0.5) < 1e-12) x = 0.5;  // homogeneous up to rounding: the kernel's shorter way
  s.p0_kPa /= s.volume_mm3;
  s.density_kg_mm3 /= s.volume_mm3;
  s.K = (0.5 * (s.K + s.K.transpose())).eval();
  for (int i = 0; i < 8; ++i) s.K(i, i) -= s.K.row(i).sum();
}

void check_layers(const Body& body) {
  auto fail = [&](const std::string& what) { throw InputError(body.name, 0, what); };
  if (body.layers.empty()) fail("the body has no layer; at least one was expected");
  for (const Layer& l : body.layers) {
    const Material& m = l.material;
    const std::string name = "layer '" + l.name + "': ";
    auto positive = [](double v) { return std::isfinite(v) && v > 0; };
    if (!positive(m.young_kPa)) fail(name + "Young's modulus must be above 0 kPa");
    if (!std::isfinite(m.poisson) || m.poisson < 0 || m.poisson >= 0.5) fail(name + "Poisson's ratio must be in [0, 0.5)");
    if (!positive(m.density_kg_mm3)) fail(name + "density must be above 0");
    if (!positive(m.prestretch_along) || !positive(m.prestretch_across)) fail(name + "prestretch must be above 0");
    if (!positive(l.thickness_mm)) fail(name + "thickness must be above 0 mm");
  }
}

// Whether the only skin is the whole top (greatest z) of a box.
bool skin_on_top(const Body& body) {
  if (!body.is_box) return false;
  double top = -INFINITY;
  for (const Vec3& X : body.surface.X_mm) top = std::max(top, X.z());
  for (size_t t = 0; t < body.surface.tri.size(); ++t) {
    if (body.surface.tag[t] != SurfaceTag::skin) continue;
    for (int32_t v : body.surface.tri[t])
      if (body.surface.X_mm[size_t(v)].z() != top) return false;
  }
  return true;
}

}  // namespace

Mat3 prestretch_tensor(const Material& m, const StretchFrame& f) {
  const double a = m.prestretch_along, c = m.prestretch_across, n = 1 / (a * c);
  return a * a * f.along * f.along.transpose() + c * c * f.across * f.across.transpose() +
         n * n * f.normal * f.normal.transpose();
}

Stencil homogeneous_stencil(const Vec3& cell_mm, const Material& material, const StretchFrame& frame) {
  Stencil s;
  add_box(s, cell_mm, Vec3::Zero(), Vec3::Ones(), material, frame);
  finish(s);
  return s;
}

StencilTable::StencilTable(const Skin& skin, const LatticeGrid& grid) {
  const Body& body = skin.body();
  check_layers(body);
  of_cell_.assign(size_t(grid.count.x) * size_t(grid.count.y) * size_t(grid.count.z), 0);
  fixed_.assign(size_t(grid.count.x + 1) * size_t(grid.count.y + 1) * size_t(grid.count.z + 1), 0);
  if (skin_on_top(body))
    fill_block(body, grid);
  else
    fill_general(skin, grid);
}

int32_t StencilTable::intern(const Stencil& s) {
  for (size_t i = 0; i < stencils_.size(); ++i) {
    const Stencil& o = stencils_[i];
    if (o.K == s.K && o.volume_mm3 == s.volume_mm3 && o.mu_kPa == s.mu_kPa && o.lambda_kPa == s.lambda_kPa &&
        o.p0_kPa == s.p0_kPa && o.sample == s.sample && o.density_kg_mm3 == s.density_kg_mm3)
      return int32_t(i);
  }
  stencils_.push_back(s);
  return int32_t(stencils_.size()) - 1;
}

void StencilTable::fill_block(const Body& body, const LatticeGrid& grid) {
  const Vec3 h = grid.cell_mm();
  StretchFrame frame;
  Vec3 along = body.tension_direction;
  along.z() = 0;
  if (along.norm() > 1e-9) frame.along = along.normalized();
  frame.across = frame.normal.cross(frame.along);
  double top = -INFINITY, bottom = INFINITY;
  for (const Vec3& X : body.surface.X_mm) top = std::max(top, X.z()), bottom = std::min(bottom, X.z());

  std::vector<int32_t> of_row;
  for (int32_t k = 0; k < grid.count.z; ++k) {
    const double low = grid.node_mm({0, 0, k}).z(), high = grid.node_mm({0, 0, k + 1}).z();
    Stencil s;
    double from = -INFINITY;  // depth of the layer's upper side; the first reaches up without end, the last down
    for (size_t l = 0; l < body.layers.size(); ++l) {
      const double to = l + 1 == body.layers.size() ? INFINITY : (l ? from : 0) + body.layers[l].thickness_mm;
      const double z1 = std::min(high, top - from), z0 = std::max(low, top - to);
      if (z1 > z0) {
        // Cell units; differences of rounding size are the same as nothing.
        const double a = std::max(0.0, (z0 - low) / h.z()), b = std::min(1.0, (z1 - low) / h.z());
        if (b - a > 1e-9) add_box(s, h, {0, 0, a}, {1, 1, b}, body.layers[l].material, frame);
      }
      from = to;
    }
    finish(s);
    of_row.push_back(intern(s));
  }
  for (size_t c = 0; c < of_cell_.size(); ++c) of_cell_[c] = of_row[size_t(grid.cell_at(int32_t(c)).z)];

  // Sides of the box that are fixed, and the planes that stand for them.
  Vec3 lo = body.surface.X_mm[0], hi = lo;
  for (const Vec3& X : body.surface.X_mm) lo = lo.cwiseMin(X), hi = hi.cwiseMax(X);
  uint8_t sides = 0;
  for (size_t t = 0; t < body.surface.tri.size(); ++t) {
    if (body.surface.tag[t] != SurfaceTag::fixed) continue;
    for (int a = 0; a < 3; ++a)
      for (int high = 0; high < 2; ++high) {
        bool on = true;
        for (int32_t v : body.surface.tri[t]) on = on && body.surface.X_mm[size_t(v)][a] == (high ? hi[a] : lo[a]);
        if (on) sides |= uint8_t(1u << (2 * a + high));
      }
  }
  for (size_t n = 0; n < fixed_.size(); ++n) {
    const Int3 at = grid.node_at(int32_t(n));
    for (int a = 0; a < 3; ++a) {
      if (at[a] == 0) fixed_[n] |= uint8_t(sides & 1u << (2 * a));
      if (at[a] == grid.count[a]) fixed_[n] |= uint8_t(sides & 1u << (2 * a + 1));
    }
  }
}

void StencilTable::fill_general(const Skin& skin, const LatticeGrid& grid) {
  const Body& body = skin.body();
  const Vec3 h = grid.cell_mm();
  const double reach = 0.5 * h.norm();
  for (size_t c = 0; c < of_cell_.size(); ++c) {
    const Int3 at = grid.cell_at(int32_t(c));
    const Vec3 low = grid.node_mm(at), centre = low + 0.5 * h;
    const double depth = skin.depth_mm(centre);
    StretchFrame frame;
    bool stretched = false;
    for (const Layer& l : body.layers)
      stretched = stretched || l.material.prestretch_along != 1 || l.material.prestretch_across != 1;
    if (stretched) {
      const Skin::Frame f = skin.frame(centre);
      frame = {f.along, f.across, f.normal};
    }
    Stencil s;
    if (skin.layer_at(depth - reach) == skin.layer_at(depth + reach)) {  // depth changes by no more than the distance
      add_box(s, h, Vec3::Zero(), Vec3::Ones(), body.layers[size_t(skin.layer_at(depth))].material, frame);
    } else {
      constexpr int n = 4;
      for (int k = 0; k < n; ++k)
        for (int j = 0; j < n; ++j)
          for (int i = 0; i < n; ++i) {
            const Vec3 a = Vec3(i, j, k) / n, b = Vec3(i + 1, j + 1, k + 1) / n;
            const int layer = skin.layer_at(skin.depth_mm(low + h.cwiseProduct(0.5 * (a + b))));
            add_box(s, h, a, b, body.layers[size_t(layer)].material, frame);
          }
    }
    finish(s);
    // Only whole-layer cells without prestretch can be equal; looking among many different ones would be quadratic.
    of_cell_[c] = stencils_.size() < 64 ? intern(s) : (stencils_.push_back(s), int32_t(stencils_.size()) - 1);
  }
  const double near = 0.1 * h.minCoeff(), far = 2 * h.norm();
  for (size_t n = 0; n < fixed_.size(); ++n) {
    const Bvh::Closest hit = skin.surface().closest(grid.node_mm(grid.node_at(int32_t(n))), far);
    if (hit.triangle < 0 || body.surface.tag[size_t(hit.triangle)] != SurfaceTag::fixed) continue;
    fixed_[n] = hit.distance_mm <= near ? kNearFixed : kFarFixed;
  }
}

}  // namespace limberg
