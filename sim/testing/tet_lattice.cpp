#include "sim/testing/tet_lattice.h"

#include <cmath>

#include "sim/fem/materials/stable_neo_hookean.h"

namespace limberg {

FemModel bcc_box_model(const BoxSpec& b) {
  ShapedModel s;
  const auto law = [&](double young) {
    const Elastic e = elastic_from_young(young, b.poisson);
    return s.add_law(stable_neo_hookean_full(e.mu_kPa, e.lambda_kPa, e.mu_kPa));
  };
  const std::array<int32_t, 2> laws = {law(b.young_bottom_kPa), law(b.young_top_kPa)};
  const Int3 n = b.cells;
  const Vec3 h = b.size_mm.cwiseQuotient(Vec3(n.x, n.y, n.z)), origin(-b.size_mm[0] / 2, -b.size_mm[1] / 2, 0);
  for (int k = 0; k <= n.z; ++k)
    for (int j = 0; j <= n.y; ++j)
      for (int i = 0; i <= n.x; ++i)
        s.add_node(origin + h.cwiseProduct(Vec3(i, j, k)),
                   (b.fix_sides && (i == 0 || j == 0 || i == n.x || j == n.y)) || (b.fix_bottom && k == 0));
  const auto corner = [&](const std::array<int, 3>& c) {
    return int32_t((c[2] * (n.y + 1) + c[1]) * (n.x + 1) + c[0]);
  };
  const int32_t centres = (n.x + 1) * (n.y + 1) * (n.z + 1);
  for (int k = 0; k < n.z; ++k)
    for (int j = 0; j < n.y; ++j)
      for (int i = 0; i < n.x; ++i) s.add_node(origin + h.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5)));
  const auto centre = [&](const std::array<int, 3>& c) { return int32_t(centres + (c[2] * n.y + c[1]) * n.x + c[0]); };
  const std::array<int, 3> count = {n.x, n.y, n.z};
  const auto law_at = [&](int layer) { return laws[2 * layer >= n.z ? 1 : 0]; };
  std::array<int, 3> c;
  for (c[2] = 0; c[2] < n.z; ++c[2])
    for (c[1] = 0; c[1] < n.y; ++c[1])
      for (c[0] = 0; c[0] < n.x; ++c[0])
        for (size_t axis = 0; axis < 3; ++axis)
          for (int high = 0; high < 2; ++high) {
            const bool outer = high ? c[axis] + 1 == count[axis] : c[axis] == 0;
            if (!outer && !high) continue;  // the other cell has it
            const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
            std::array<int32_t, 4> q;  // around the square
            for (size_t e = 0; e < 4; ++e) {
              std::array<int, 3> p = c;
              p[axis] += high, p[u] += e == 1 || e == 2, p[v] += e >= 2;
              q[e] = corner(p);
            }
            if (outer) {
              const size_t turn = size_t(c[0] + c[1] + c[2]) % 2;  // diagonals alternate
              s.add_tet({centre(c), q[turn], q[turn + 1], q[(turn + 2) % 4]}, law_at(c[2]));
              s.add_tet({centre(c), q[turn], q[(turn + 2) % 4], q[(turn + 3) % 4]}, law_at(c[2]));
              continue;
            }
            std::array<int, 3> next = c;
            ++next[axis];
            // Between two layers of different tissue each half of a
            // tetrahedron belongs to one: the mean stands for both.
            const int32_t la = law_at(c[2]), lb = law_at(next[2]);
            for (size_t e = 0; e < 4; ++e) s.add_tet({centre(c), centre(next), q[e], q[(e + 1) % 4]}, e % 2 ? la : lb);
          }
  return s.finish(b.density_kg_mm3);
}

FemModel tet_mesh_model(std::span<const Vec3> vertices, std::span<const std::array<int32_t, 4>> tets, double young,
                        double poisson, double density) {
  ShapedModel s;
  const Elastic e = elastic_from_young(young, poisson);
  const int32_t law = s.add_law(stable_neo_hookean_full(e.mu_kPa, e.lambda_kPa, e.mu_kPa));
  for (const Vec3& v : vertices) s.add_node(v);
  for (const auto& t : tets) s.add_tet(t, law);
  return s.finish(density);
}

EmbeddedPoint embed_in_tets(const FemModel& m, const Vec3& X) {
  double best = 1e300;
  EmbeddedPoint p;
  for (const HexCell& c : m.cells) {
    Mat3 D;
    for (int i = 0; i < 3; ++i) D.col(i) = m.X_mm[size_t(c.node[size_t(i + 1)])] - m.X_mm[size_t(c.node[0])];
    Eigen::Vector4d w;
    w.tail<3>() = D.inverse() * (X - m.X_mm[size_t(c.node[0])]);
    w[0] = 1 - w.tail<3>().sum();
    const double outside = (-w).cwiseMax(0.0).sum();
    if (outside >= best) continue;
    best = outside;
    w = w.cwiseMax(0.0);
    w /= w.sum();
    p.node = c.node;
    p.w = {};
    for (size_t a = 0; a < 4; ++a) p.w[a] = float(w[Eigen::Index(a)]);
  }
  return p;
}

}  // namespace limberg
