#pragma once
// Sheets in a lattice that does not fit them: how thick their skin is in it, and how far a patch of it moves.
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "sim/cutting/arrangement/arrangement.h"
#include "sim/lattice/embedding.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/lattice/grid_fit.h"
#include "sim/lattice/material_surface.h"
#include "sim/testing/reference_newton.h"
#include "tests/sim/lattice/sheet_bodies.h"

namespace limberg::test {

inline constexpr double kSkin_mm = 1.5;

/// `shift` (0 to 1, of a cell): how much higher its planes lie than where they were fitted.
inline LatticeGrid shifted(LatticeGrid g, const Vec3& shift) {
  if (shift == Vec3::Zero()) return g;
  const auto by = [&](int a) { return 2 * int32_t(std::lround((shift[a] - 1) * g.pitch[a] / 2)); };
  g.origin = {g.origin.x + by(0), g.origin.y + by(1), g.origin.z + by(2)};
  g.count = {g.count.x + 1, g.count.y + 1, g.count.z + 1};
  return g;
}

struct SheetLattice {
  std::shared_ptr<const Body> body;
  Skin skin;
  LatticeGrid grid;
  StencilTable table;
  Arrangement a;
  std::shared_ptr<const LatticeTopology> t;
  std::shared_ptr<const FemModel> m;
  SheetLattice(Body b, double h, const Vec3& shift = Vec3::Zero(), const Grading& grading = {})
      : body(std::make_shared<Body>(std::move(b))),
        skin(body),
        grid(shifted(fit_lattice(*body, h, grading.empty() ? 0 : kLevels), shift)),
        table(skin, grid),
        a(body->surface, body->grid),
        t(build_topology(grid, material_surface(a), 0, grading)),
        m(assemble_fem(table, *t)) {}
};

/// Volume (mm^3) that acts as skin: the mass, where fat weighs nothing.
inline double skin_mass(const SheetLattice& l) {
  double kg = 0;
  for (double m : l.m->mass_kg) kg += m;
  return kg / 1e-6;
}

/// The same from the stiffness: energy of an even shear in the plane of x and y, of which fat's share is known. uJ.
inline double shear_energy(const SheetLattice& l) {
  double e = 0;
  for (const HexCell& c : l.m->cells) {
    const Stencil& s = l.m->stencils[size_t(c.stencil)];
    Eigen::Matrix<double, 8, 1> u;
    for (int n = 0; n < 8; ++n) u[n] = (n >> 1 & 1) ? l.m->cell_mm.y() : 0;
    e += 0.5 * double(c.scale) * u.dot(s.K * u);
  }
  return e;
}

/// Mean move (mm) of a square of 6 x 6 mm in the middle of the skin under a force of `force_N` spread evenly on it.
inline Vec3 patch_move(const SheetLattice& l, const Vec3& force_N) {
  const double top = l.body->box_max_mm.z();
  std::vector<HeldPlace> held;
  for (int j = 0; j < 12; ++j)
    for (int i = 0; i < 12; ++i) {
      const Vec3 X(-2.75 + 0.5 * i, -2.75 + 0.5 * j, top - 1e-6);
      const int32_t cell = cell_of(*l.t, X);
      held.push_back(embed_in_copy(*l.t, l.t->copy(cell, 0), X));
    }
  // A weak spring whose far end is so far away that its pull hardly changes.
  Spring s;
  s.a = held[0], s.a_wide = held, s.to_world = true;
  s.k_N_per_mm = 1e-5;
  Vec3 at = Vec3::Zero();
  const auto middle = [&](std::span<const Vec3> u) {
    Vec3 m = Vec3::Zero();
    for (const EmbeddedPoint& p : held)
      for (size_t k = 0; k < 8; ++k)
        m += double(p.w[k]) * (l.m->X_mm[size_t(p.node[k])] + (u.empty() ? Vec3(0, 0, 0) : u[size_t(p.node[k])]));
    return Vec3(m / double(held.size()));
  };
  at = middle({});
  s.target_mm = at + force_N / s.k_N_per_mm;
  const std::vector<Spring> springs{s};
  ReferenceElasticity e(*l.m, springs);
  std::vector<Vec3> start(l.m->X_mm.size(), Vec3::Zero());
  ReferenceElasticity::Settings settings;
  settings.tolerance = 1e-9;
  const auto r = e.solve(start, settings);
  if (!r.converged) throw std::runtime_error("patch_move: not converged");
  return middle(r.u) - at;
}

/// The largest force that its cells exert on a free node at rest, beside what one of them would under its rest pressure
/// alone.
inline double force_at_rest(const SheetLattice& l, double cell_mm) {
  double scale = 0, force = 0;
  for (const Stencil& k : l.m->stencils) scale = std::max(scale, k.p0_kPa * k.volume_mm3 / cell_mm);
  const std::vector<Vec3> u(l.m->X_mm.size(), Vec3::Zero());
  std::vector<Vec3> f;
  ReferenceElasticity(*l.m, {}).gradient(u, f);
  for (size_t n = 0; n < f.size(); ++n)
    if (!l.m->fixed[n]) force = std::max(force, f[n].norm());
  return force / scale;
}

inline Body slab(double off, double fat_mm = 10) {
  Sheet s;
  s.cells = 10;
  s.top = [=](double, double) { return off; };
  s.bottom = [=](double, double) { return off - kSkin_mm - fat_mm; };
  return layered(sheet_mesh(s), kSkin_mm);
}

inline Body as_block(Body b) {
  b.is_box = true;
  return b;
}

}  // namespace limberg::test
