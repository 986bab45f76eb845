#include "app/operating_point/accuracy_probe.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "sim/fem/elements/material_points.h"
#include "sim/fem/materials/isotropic.h"
#include "sim/fem/materials/stable_neo_hookean.h"
#include "sim/patient/soft_tissue.h"
#include "sim/patient/world.h"

namespace limberg::bench {
namespace {

constexpr double near_mm = 40, hook_mm = 5, lift_mm = 6, aside_mm = 6;

/// mu A of fem_model.h, the mean over the cell, as mu and M with A = M M^T, det M = 1.
struct MeanShape {
  double mu_kPa = 0;
  Mat3 M = Mat3::Identity();
  MeanShape(const Stencil& s, const Vec3& cell_mm) {
    const Vec3 h = cell_size_mm(cell_mm, s.level);
    Eigen::Matrix<double, 8, 3> X;
    for (int a = 0; a < 8; ++a)
      for (int i = 0; i < 3; ++i) X(a, i) = (a >> i & 1) ? h[i] : 0;
    const Mat3 mean = X.transpose() * s.K * X / s.volume_mm3;
    mu_kPa = std::cbrt(mean.determinant());
    M = Mat3((mean / mu_kPa).llt().matrixL());
  }
};

bool plain(const FemModel& m) {
  return m.hanging.empty() && std::all_of(m.stencils.begin(), m.stencils.end(),
                                          [](const Stencil& s) { return s.points.empty() && s.level == 0; });
}

}  // namespace

Probe make_probe(const Scene& scene, std::shared_ptr<const Body> body, double cell_mm, Workers& workers) {
  WorldSpec spec = world_spec(scene, body);
  spec.cell_mm = cell_mm;
  World world(spec, workers);
  const double reach = 0.5 * (body->box_max_mm - body->box_min_mm).norm() / std::sqrt(3.0),
               half = std::min(20.0, 0.4 * reach);
  if (scene.can_cut)
    world.apply(
        Incise{{{-half, 0}, {half, 0}}, std::min(scene.tools.default_depth_mm, scene.tools.max_depth_mm), 90, false});
  Probe p;
  p.gravity_m_s2 = scene.gravity_m_s2;
  p.model = std::make_shared<const FemModel>(world.skin()->solver().model());
  const SurfaceTopology& t = *world.topology();
  const Outcome hooked = world.apply(SetHook{1, {0, 4}});
  Snapshot shown;
  world.fill(shown);
  const Vec3 at =
      hooked.done && !shown.hooks.empty() ? Vec3(shown.hooks[0].at_mm.cast<double>()) : body->chart_origin_mm;

  std::vector<uint8_t> skin(t.view.X_mm.size(), 0);
  for (size_t f = 0; f < t.view.tri.size(); ++f)
    for (int32_t v : t.view.tri[f])
      if (t.view.kind[f] == FaceKind::skin) skin[size_t(v)] = 1;
  // Both banks of a cut lie at one place: such places are left out, so that places of two lattices can be matched.
  std::vector<int32_t> count;
  for (int32_t i : t.view.point) {
    if (size_t(i) >= count.size()) count.resize(size_t(i) + 1, 0);
    ++count[size_t(i)];
  }
  // Right at the hook there is no limit to compare with: a point that is pulled gives the more, the finer the cells.
  double best = 1e300;
  for (size_t v = 0; v < skin.size(); ++v) {
    if (!skin[v]) continue;
    const double d = (t.view.X_mm[v] - at).norm();
    if (count[size_t(t.view.point[v])] == 1 && d < near_mm && d > hook_mm)
      p.X_mm.push_back(t.view.X_mm[v]), p.place.push_back(t.embedding[v]);
    if (d < best) best = d, p.hook.a = t.embedding[v], p.hook.target_mm = t.view.X_mm[v];
  }
  p.hook.id = 1, p.hook.to_world = true, p.hook.k_N_per_mm = scene.hook_N_per_mm;
  p.pull_mm = lift_mm * body->chart_normal().normalized() + aside_mm * body->chart_e2.normalized();
  return p;
}

std::vector<Vec3> places_mm(const Probe& p, const ElasticSolver& solver) {
  const auto u = solver.displacement_mm();
  std::vector<Vec3> x;
  for (size_t i = 0; i < p.place.size(); ++i) {
    Vec3 d = Vec3::Zero();
    for (size_t a = 0; a < 8; ++a) d += double(p.place[i].w[a]) * u[size_t(p.place[i].node[a])].cast<double>();
    x.push_back(p.X_mm[i] + d);
  }
  return x;
}

std::shared_ptr<const FemModel> with_full_integration(const FemModel& from) {
  if (!plain(from)) return nullptr;
  auto m = std::make_shared<FemModel>(from);
  m->laws.clear();
  const double g = 0.5 / std::sqrt(3.0);
  for (Stencil& s : m->stencils) {
    const int32_t law = int32_t(m->laws.size());
    m->laws.push_back(stable_neo_hookean_full(0, s.lambda_kPa, s.p0_kPa));
    for (int q = 0; q < 8; ++q) {
      MaterialPoint p;
      p.at = Vec3(q & 1 ? 0.5 + g : 0.5 - g, q & 2 ? 0.5 + g : 0.5 - g, q & 4 ? 0.5 + g : 0.5 - g);
      p.volume_mm3 = s.volume_mm3 / 8, p.law = law;
      s.points.push_back(p);
    }
    s.lambda_kPa = s.p0_kPa = 0;
    s.slide_kPa = 0;  // this element does not let layers that share a cell slide
  }
  return m;
}

std::shared_ptr<const FemModel> with_poisson(const FemModel& from, double nu) {
  if (!plain(from)) return nullptr;
  auto m = std::make_shared<FemModel>(from);
  for (Stencil& s : m->stencils) s.lambda_kPa = s.mu_kPa * (2 * nu / (1 - 2 * nu) + 1);
  return m;
}

std::shared_ptr<const FemModel> with_mooney_rivlin(const FemModel& from) {
  if (!plain(from)) return nullptr;
  auto m = std::make_shared<FemModel>(from);
  m->laws.clear();
  for (Stencil& s : m->stencils) {
    const MeanShape shape(s, m->cell_mm);
    const LawPtr law = mooney_rivlin(0.35 * shape.mu_kPa, 0.15 * shape.mu_kPa);
    m->laws.push_back(law);
    const uint8_t level = s.level;
    s = fem::law_stencil(cell_size_mm(m->cell_mm, level), int32_t(m->laws.size()) - 1, *law, s.lambda_kPa,
                         s.density_kg_mm3, shape.M);
    s.level = level;
  }
  return m;
}

std::shared_ptr<const FemModel> with_tetrahedra(const FemModel& from) {
  if (!plain(from)) return nullptr;
  auto m = std::make_shared<FemModel>(from);
  m->cells.clear(), m->stencils.clear(), m->laws.clear();
  std::array<std::array<size_t, 4>, 6> faces;  // corners around each square
  for (size_t axis = 0, f = 0; axis < 3; ++axis)
    for (size_t high = 0; high < 2; ++high, ++f) {
      const size_t u = (axis + 1) % 3, v = (axis + 2) % 3, base = high << axis;
      faces[f] = {base, base | size_t(1) << u, base | size_t(1) << u | size_t(1) << v, base | size_t(1) << v};
    }
  // Twelve tetrahedra of the cell's centre and half a square. A square's diagonal runs through its corners of even
  // lattice coordinates, so both cells at it agree.
  const auto halves = [&](int parity) {
    std::vector<std::array<size_t, 3>> out;
    for (const auto& q : faces) {
      const size_t t = (size_t(parity) + q[0] % 2 + q[0] / 2 % 2 + q[0] / 4) % 2;
      out.push_back({q[t], q[t + 1], q[(t + 2) % 4]});
      out.push_back({q[t], q[(t + 2) % 4], q[(t + 3) % 4]});
    }
    return out;
  };
  for (const Stencil& s : from.stencils) {
    const MeanShape shape(s, m->cell_mm);
    const int32_t law = int32_t(m->laws.size());
    m->laws.push_back(stable_neo_hookean_full(shape.mu_kPa, s.lambda_kPa, s.p0_kPa));
    for (int parity = 0; parity < 2; ++parity)
      for (const auto& h : halves(parity)) {
        Mat3 D;  // columns: the three corners from the centre
        for (int i = 0; i < 3; ++i)
          for (int k = 0; k < 3; ++k)
            D(k, i) = ((h[size_t(i)] >> k & 1) ? 0.5 : -0.5) * cell_size_mm(m->cell_mm, s.level)[k];
        Stencil t;
        t.volume_mm3 = std::fabs(D.determinant()) / 6;
        t.mu_kPa = s.mu_kPa, t.density_kg_mm3 = s.density_kg_mm3, t.level = s.level;
        Eigen::Matrix<double, 8, 3> G = Eigen::Matrix<double, 8, 3>::Zero();
        G.middleRows<3>(1) = D.inverse();
        G.row(0) = -G.middleRows<3>(1).colwise().sum();
        MaterialPoint p;
        p.volume_mm3 = t.volume_mm3, p.law = law, p.M = shape.M;
        p.gradients = std::make_shared<const Eigen::Matrix<double, 8, 3>>(G);
        t.points.push_back(p);
        m->stencils.push_back(t);
      }
  }
  const std::array<std::vector<std::array<size_t, 3>>, 2> corners = {halves(0), halves(1)};
  for (const HexCell& c : from.cells) {
    const int32_t centre = int32_t(m->X_mm.size());
    Vec3 X = Vec3::Zero();
    double mass = 0;
    unsigned held = Held(true).axes();
    for (int32_t v : c.node)
      X += from.X_mm[size_t(v)] / 8, held &= from.fixed[size_t(v)].axes(), mass += 0.25 * from.mass_kg[size_t(v)] / 8;
    m->X_mm.push_back(X), m->fixed.push_back(Held::axes(held)), m->parent.push_back(-1), m->mass_kg.push_back(mass);
    const size_t parity = size_t((c.at[0] / 2 + c.at[1] / 2 + c.at[2] / 2) & 1);
    for (size_t k = 0; k < 12; ++k) {
      HexCell t = c;
      t.node.fill(centre);
      for (size_t i = 0; i < 3; ++i) t.node[i + 1] = c.node[corners[parity][k][i]];
      t.stencil = int32_t((2 * size_t(c.stencil) + parity) * 12 + k);
      m->cells.push_back(t);
    }
  }
  return m;
}

}  // namespace limberg::bench
