#include <Eigen/Eigenvalues>

#include "sim/base/error.h"
#include "sim/body/block.h"
#include "sim/lattice/cut_cells.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/lattice/grid_fit.h"
#include "sim/testing/reference_newton.h"
#include "tests/sim/lattice/lattice_scene.h"

namespace limberg::test {
namespace test_fem_assembly {

Body layered_block(double stretch = 1.15) {
  BlockSpec spec;
  spec.size_mm = {40, 30, 10};
  spec.skin_cell_mm = 2;
  Layer skin{"skin", 1.7, {}}, fat{"fat", 4.1, {}}, deep{"deep", 1, {}};
  skin.material = {120, 0.45, 1.1e-6, stretch, 1 + 0.5 * (stretch - 1)};
  fat.material = {12, 0.47, 0.9e-6, 1 + 0.3 * (stretch - 1), 1};
  deep.material = {60, 0.4, 1e-6, 1, 1};
  spec.layers = {skin, fat, deep};
  spec.tension_direction = {1, 0.4, 0};
  return make_block(spec);
}

struct Scene {
  std::shared_ptr<const Body> body;
  Skin skin;
  LatticeGrid grid;
  StencilTable table;
  Arrangement a;
  std::shared_ptr<const LatticeTopology> t;
  std::shared_ptr<const FemModel> m;
  Scene(Body b, double h)
      : body(std::make_shared<Body>(std::move(b))),
        skin(body),
        grid(fit_lattice(*body, h)),
        table(skin, grid),
        a(body->surface, body->grid),
        t(build_topology(grid, material_surface(a))),
        m(assemble_fem(table, *t)) {}
};

// Energy of fem_model.h.
double energy(const FemModel& m, const std::vector<Vec3>& x) {
  double e = 0;
  for (const HexCell& c : m.cells) {
    const Stencil& s = m.stencils[size_t(c.stencil)];
    const auto g = sample_gradients(s, m.cell_mm);
    Mat3 F = Mat3::Zero();
    double q = 0;
    for (int i = 0; i < 8; ++i) {
      F += x[size_t(c.node[size_t(i)])] * g.row(i);
      for (int j = 0; j < 8; ++j) q += s.K(i, j) * x[size_t(c.node[size_t(i)])].dot(x[size_t(c.node[size_t(j)])]);
    }
    const double J = F.determinant() - 1;
    e += double(c.scale) * (0.5 * q + s.volume_mm3 * (0.5 * s.lambda_kPa * J * J - s.p0_kPa * J));
  }
  return e;
}

TEST(Stencils, RowsSumToZeroAndAreSymmetric) {
  const Scene s(layered_block(), 3.5);
  EXPECT_EQ(s.table.stencils().size(), size_t(s.grid.count.z));
  for (const Stencil& k : s.table.stencils()) {
    const double scale = k.K.cwiseAbs().maxCoeff();
    EXPECT_LT((k.K - k.K.transpose()).cwiseAbs().maxCoeff(), 1e-14 * scale);
    EXPECT_LT(k.K.rowwise().sum().cwiseAbs().maxCoeff(), 1e-14 * scale);
  }
}

// Closed form for an isotropic box: K is a sum over axes of products of 1-D mass and stiffness matrices.
TEST(Stencils, HomogeneousCellHasTheClosedForm) {
  const Vec3 h(2, 3, 1.5);
  const Material m{80, 0.4, 1e-6, 1, 1};
  const Stencil s = homogeneous_stencil(h, m);
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j) {
      double sum = 0;
      for (int a = 0; a < 3; ++a) {
        double term = (((i ^ j) >> a & 1) ? -1 : 1) / h[a];
        for (int b = 0; b < 3; ++b)
          if (b != a) term *= h[b] * (((i ^ j) >> b & 1) ? 1.0 / 6 : 1.0 / 3);
        sum += term;
      }
      EXPECT_NEAR(s.K(i, j), m.mu_kPa() * sum, 1e-12 * m.mu_kPa());
    }
  EXPECT_NEAR(s.p0_kPa, m.mu_kPa(), 1e-12);
  EXPECT_NEAR(s.lambda_kPa, m.lambda_kPa() + m.mu_kPa(), 1e-12);
}

// A cell of two layers as a sum of moments is the sum of two boxes, under any prestretch.
TEST(Stencils, MomentsAddUpToBoxes) {
  const Vec3 h(2, 3, 1.5);
  const Body b = layered_block(1.3);
  const Vec3 along = Vec3(1, 2, 3).normalized(), across = along.cross(Vec3::UnitX()).normalized();
  const StretchFrame frame{along, across, along.cross(across)};
  std::vector<LawPtr> laws;
  const std::vector<LayerMatter> matter = layer_matter(b, laws);
  Stencil t, s;
  add_moments(t, h, box_cell_moments(h, {0, 0, 0.7}, {1, 1, 1}), matter[0], frame);
  add_moments(t, h, box_cell_moments(h, {0, 0, 0}, {1, 1, 0.7}), matter[1], frame);
  add_box(s, h, {0, 0, 0.7}, {1, 1, 1}, matter[0], frame);
  add_box(s, h, {0, 0, 0}, {1, 1, 0.7}, matter[1], frame);
  finish_stencil(t);
  finish_stencil(s);
  EXPECT_LT((t.K - s.K).cwiseAbs().maxCoeff(), 1e-12 * s.K.cwiseAbs().maxCoeff());
  EXPECT_NEAR(t.p0_kPa, s.p0_kPa, 1e-12 * s.p0_kPa);
  EXPECT_NEAR(t.lambda_kPa, s.lambda_kPa, 1e-12 * s.lambda_kPa);
  EXPECT_NEAR(t.volume_mm3, 9, 1e-12);
  EXPECT_LT((t.sample - s.sample).norm(), 1e-12);
}

// What share_cell() takes of a part is the same from its moments as from Gauss points.
TEST(Stencils, LayerMomentsAreThoseOfTheBox) {
  const Vec3 h(2, 3, 1.5), lo(0.1, 0.3, 0.45), hi(0.8, 0.9, 1);
  const LayerMoments m = layer_moments(h, box_cell_moments(h, lo, hi)), o = box_moments(h, lo, hi);
  EXPECT_NEAR(m.volume_mm3, o.volume_mm3, 1e-13);
  EXPECT_LT((m.x - o.x).norm(), 1e-13);
  EXPECT_LT((m.xx - o.xx).norm(), 1e-13);
  EXPECT_LT((m.B - o.B).norm(), 1e-13);
  for (size_t j = 0; j < 3; ++j) EXPECT_LT((m.Bx[j] - o.Bx[j]).norm(), 1e-13);
}

// The general assembly of a flat block comes to the layers of the block's own.
TEST(Stencils, GeneralBodiesSeeTheSameLayers) {
  Body b = layered_block();
  const Scene block(b, 2.5);
  b.is_box = false;
  const Scene general(std::move(b), 2.5);
  const auto mean_mu = [](const Scene& s) {
    double sum = 0, volume = 0;
    for (size_t c = 0; c < s.m->cells.size(); ++c) {
      const double v = s.t->cells[c].fraction;
      sum += v * s.m->stencils[size_t(s.m->cells[c].stencil)].mu_kPa;
      volume += v;
    }
    return sum / volume;
  };
  EXPECT_NEAR(mean_mu(general), mean_mu(block), 0.08 * mean_mu(block));  // quarters of cells, and cells that stick out
}

TEST(Stencils, EnergyOfAHomogeneousDeformation) {
  Body b = layered_block();
  b.layers = {{"one", 1, {70, 0.42, 1e-6, 1.2, 1.05}}};
  const Scene s(std::move(b), 3.1);
  Mat3 F;
  F << 1.2, 0.1, -0.05, 0.02, 0.9, 0.11, 0.07, -0.03, 1.1;
  std::vector<Vec3> x;
  for (const Vec3& X : s.m->X_mm) x.push_back(F * X + Vec3(3, 4, 5));
  const Material& m = s.body->layers[0].material;
  const Vec3 along = Vec3(1, 0.4, 0).normalized();
  const Mat3 A = prestretch_tensor(m, {along, Vec3::UnitZ().cross(along), Vec3::UnitZ()});
  EXPECT_NEAR(A.determinant(), 1, 1e-12);
  const double mu = m.mu_kPa(), J = F.determinant() - 1;
  const double W = 0.5 * mu * (F * A * F.transpose()).trace() + 0.5 * (m.lambda_kPa() + mu) * J * J - mu * A(2, 2) * J;
  const double V = s.m->cell_mm.prod() * double(s.m->cells.size());
  EXPECT_NEAR(energy(*s.m, x), W * V, 1e-9 * std::abs(W * V));
}

// Cells that layers share (shared_cells.h): an even shear along the layers meets the laminate's modulus, one in their
// plane the mean; turning costs nothing, and K stays a stiffness.
TEST(Stencils, SharedCellsShearAsALaminate) {
  Body b = layered_block(1);
  b.layers[0].thickness_mm = 1.5;
  const Scene s(b, 2.5);
  const Material &skin = b.layers[0].material, &fat = b.layers[1].material;
  FemModel one;
  one.cell_mm = s.m->cell_mm;
  one.stencils.push_back(s.table.stencils()[size_t(s.table.of_cell(s.grid.cell_index({0, 0, s.grid.count.z - 1})))]);
  HexCell cell;
  for (int a = 0; a < 8; ++a) {
    cell.node[size_t(a)] = a;
    one.X_mm.push_back(one.cell_mm.cwiseProduct(Vec3(a & 1, a >> 1 & 1, a >> 2 & 1)));
    one.fixed.push_back(0), one.parent.push_back(-1), one.mass_kg.push_back(0);
  }
  one.cells.push_back(cell);
  const Stencil& k = one.stencils[0];
  const double share =
      (k.p0_kPa - fat.mu_kPa()) / (skin.mu_kPa() - fat.mu_kPa());  // no prestretch: p0 is the mean modulus
  EXPECT_NEAR(share, 0.6, 1e-3);                                   // (the lattice is a little larger than the block)
  const double mean = k.p0_kPa, harmonic = 1 / (share / skin.mu_kPa() + (1 - share) / fat.mu_kPa()),
               laminate = 0.97 * harmonic + 0.03 * mean;
  EXPECT_NEAR(k.slide_kPa, mean - laminate, 1e-9 * mean);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Mat8>(k.K).eigenvalues()[0], -1e-12 * k.K.norm());
  ReferenceElasticity e(one, {});
  const auto energy = [&](const Mat3& F) {
    std::vector<Vec3> u;
    for (const Vec3& X : one.X_mm) u.push_back((F - Mat3::Identity()) * X);
    return e.energy(u) / k.volume_mm3;
  };
  const double g = 0.3, sheared = 0.5 * (laminate * g * g + k.slide_kPa * std::pow(g, 4) /
                                                                (g * g + 2.5));  // the slip's end (layer_slide.h)
  Mat3 along = Mat3::Identity(), within = Mat3::Identity();
  along(0, 2) = g, within(0, 1) = g;
  const Mat3 R = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  EXPECT_NEAR(energy(along), sheared, 1e-9 * mean);
  EXPECT_NEAR(energy(R * along), sheared, 1e-9 * mean);
  EXPECT_NEAR(energy(within), 0.5 * mean * g * g, 1e-9 * mean);
  EXPECT_NEAR(energy(R), 0, 1e-9 * mean);
  const Vec3 even(1.2, 0.9, 1 / (1.2 * 0.9));  // keeps volume
  EXPECT_NEAR(energy(R * Mat3(even.asDiagonal())), 0.5 * mean * (even.squaredNorm() - 3), 1e-9 * mean);
}

// A prestretched, layered, uncut block is in equilibrium as it lies.
TEST(Assembly, RestIsEquilibrium) {
  for (double h : {3.5, 2.0, 9.0}) {
    const Scene s(layered_block(), h);
    std::vector<Vec3> f;
    ReferenceElasticity(*s.m, {}).gradient(std::vector<Vec3>(s.m->X_mm.size(), Vec3::Zero()), f);
    double size = 0;
    for (const Stencil& k : s.m->stencils) size = std::max(size, k.volume_mm3 * k.p0_kPa / s.m->cell_mm.minCoeff());
    size_t free_nodes = 0;
    for (size_t n = 0; n < f.size(); ++n)
      if (!s.m->fixed[n]) {
        EXPECT_LT(f[n].norm(), 1e-10 * size) << n;
        ++free_nodes;
      }
    EXPECT_GT(free_nodes, 0u);
  }
}

TEST(Assembly, LayersThinnerThanACellAreIntegratedExactly) {
  // The volume means and the masses of a coarse and a fine lattice are those of the layers.
  for (double h : {1.0, 3.5, 9.0}) {
    const Scene s(layered_block(), h);
    double mass = 0, mu = 0;
    for (double m : s.m->mass_kg) mass += m;
    for (size_t c = 0; c < s.m->cells.size(); ++c) {
      const Stencil& k = s.m->stencils[size_t(s.m->cells[c].stencil)];
      mu += k.mu_kPa * k.volume_mm3;
    }
    const auto& l = s.body->layers;
    const double area = 40 * 30, deep = 10 - 1.7 - 4.1;
    const double expected = area * (1.7 * l[0].material.density_kg_mm3 + 4.1 * l[1].material.density_kg_mm3 +
                                    deep * l[2].material.density_kg_mm3);
    // The lattice's planes lie some micrometres outside the block, and a row's mean density is spread over them.
    EXPECT_NEAR(mass, expected, 2e-5 * expected);
    const double expected_mu =
        area * (1.7 * l[0].material.mu_kPa() + 4.1 * l[1].material.mu_kPa() + deep * l[2].material.mu_kPa());
    EXPECT_NEAR(mu, expected_mu, 1e-3 * expected_mu);
  }
}

TEST(Assembly, BlockIsHeldOnItsSidesAndBottom) {
  const Scene s(layered_block(), 3.5);
  for (size_t n = 0; n < s.m->X_mm.size(); ++n) {
    const Int3 at = s.grid.node_at(s.t->nodes[n].lattice_node);
    const bool held = at.x == 0 || at.x == s.grid.count.x || at.y == 0 || at.y == s.grid.count.y || at.z == 0;
    EXPECT_EQ(bool(s.m->fixed[n]), held);
    EXPECT_GT(s.m->mass_kg[n], 0);
  }
}

// Cutting changes no mass; a plug, though it reaches into the lowest cells, is not held.
TEST(Assembly, PlugIsFreeAndMassStays) {
  Scene s(layered_block(), 3.5);
  double before = 0, after = 0;
  for (double m : s.m->mass_kg) before += m;
  ASSERT_TRUE(s.a.cut(open_box({{9, 0}, {0, 8}, {-9, 0}, {0, -8}}, 3, -9), 1).ok());
  s.t = update_topology(*s.t, material_surface(s.a));
  s.m = assemble_fem(s.table, *s.t);
  for (double m : s.m->mass_kg) after += m;
  EXPECT_NEAR(after, before, 1e-12 * before);
  ASSERT_EQ(s.t->pieces, 2);
  const int plug = s.t->piece_fixed[0] ? 1 : 0;
  EXPECT_FALSE(s.t->piece_fixed[size_t(plug)]);
  size_t lowest = 0;
  for (const CellCopy& c : s.t->cells)
    if (c.piece == plug)
      for (int32_t n : c.node) {
        EXPECT_FALSE(s.m->fixed[size_t(n)]);
        lowest += s.grid.node_at(s.t->nodes[size_t(n)].lattice_node).z == 0;
      }
  EXPECT_GT(lowest, 0u);
}

TEST(Assembly, CurvedBodyIsHeldAndLayered) {
  Body b;
  b.surface = wavy_slab(40, 12, 16, 1.5);
  b.layers = {{"skin", 2, {100, 0.45, 1e-6, 1, 1}}, {"fat", 5, {10, 0.45, 2e-6, 1, 1}}};
  b.box_min_mm = {-20, -20, -12}, b.box_max_mm = {20, 20, 1.5};
  const Scene s(std::move(b), 3);
  size_t held = 0;
  for (size_t n = 0; n < s.m->X_mm.size(); ++n) {
    const double z = s.m->X_mm[n].z();
    held += s.m->fixed[n].any();
    EXPECT_TRUE(!s.m->fixed[n] || z < -8 || s.m->X_mm[n].head<2>().cwiseAbs().maxCoeff() > 17)
        << s.m->X_mm[n].transpose();
  }
  EXPECT_GT(held, 100u);
  double mass = 0;
  for (double m : s.m->mass_kg) mass += m;
  const double skin = 2 * s.skin.area_mm2(), expected = skin * 1e-6 + (s.a.volume_mm3() - skin) * 2e-6;
  EXPECT_NEAR(mass, expected, 0.02 * expected);  // fractions of cut cells are taken at the cell's mean density
}

TEST(Assembly, ImpossibleLayersAreRefused) {
  for (int i = 0; i < 4; ++i) {
    Body b = layered_block();
    if (i == 0) b.layers.clear();
    if (i == 1) b.layers[1].material.poisson = 0.5;
    if (i == 2) b.layers[1].material.young_kPa = NAN;
    if (i == 3) b.layers[1].material.prestretch_along = 0;
    EXPECT_THROW(Scene(std::move(b), 3.5), InputError) << i;
  }
}

}  // namespace test_fem_assembly
}  // namespace limberg::test
