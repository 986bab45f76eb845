#include "sim/fem/elements/shaped_cells.h"

#include <cmath>

#include "sim/base/elementary.h"
#include "sim/base/error.h"

namespace limberg {
namespace {

using CornerGradients = Eigen::Matrix<double, 8, 3>;

const double gauss[2] = {0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)};

/// dN_a / dxi on the unit cube.
CornerGradients local_gradients(const Vec3& at) {
  CornerGradients D;
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i) {
      double v = (a >> i & 1) ? 1 : -1;
      for (int j = 0; j < 3; ++j)
        if (j != i) v *= (a >> j & 1) ? at[j] : 1 - at[j];
      D(a, i) = v;
    }
  return D;
}

std::string number_of(size_t cell) { return "cell " + std::to_string(cell); }

}  // namespace

int32_t ShapedModel::add_node(const Vec3& X, bool fixed) {
  m_.X_mm.push_back(X), m_.fixed.push_back(fixed), m_.parent.push_back(-1);
  return int32_t(m_.X_mm.size()) - 1;
}

int32_t ShapedModel::add_law(LawPtr law) {
  if (!law) throw InputError("", 0, "a law was expected");
  m_.laws.push_back(std::move(law));
  return int32_t(m_.laws.size()) - 1;
}

void ShapedModel::check(std::span<const int32_t> nodes, int32_t law) const {
  for (int32_t n : nodes)
    if (n < 0 || size_t(n) >= m_.X_mm.size())
      throw InputError("", 0,
                       number_of(m_.cells.size()) + " names node " + std::to_string(n) + "; there are " +
                           std::to_string(m_.X_mm.size()));
  if (law < 0 || size_t(law) >= m_.laws.size())
    throw InputError("", 0,
                     number_of(m_.cells.size()) + " names law " + std::to_string(law) + "; there are " +
                         std::to_string(m_.laws.size()));
}

void ShapedModel::add_cell(const std::array<int32_t, 8>& nodes, const std::vector<Point>& points, double volume) {
  Stencil s;
  s.volume_mm3 = volume;
  for (const Point& p : points) {
    MaterialPoint q;
    q.volume_mm3 = p.volume_mm3, q.law = p.law;
    q.gradients = std::make_shared<const CornerGradients>(p.gradients);
    s.points.push_back(q);
    s.mu_kPa += p.volume_mm3 / volume * m_.laws[size_t(p.law)]->typical_stiffness_kPa();
  }
  HexCell c;
  c.node = nodes;
  c.stencil = int32_t(m_.stencils.size());
  m_.stencils.push_back(std::move(s));
  m_.cells.push_back(c);
}

void ShapedModel::add_hex(const std::array<int32_t, 8>& nodes, int32_t shape, int32_t volume) {
  check(nodes, shape);
  if (volume >= 0) check(nodes, volume);
  CornerGradients X;
  for (int a = 0; a < 8; ++a) X.row(a) = m_.X_mm[size_t(nodes[size_t(a)])].transpose();
  std::vector<Point> points;
  CornerGradients mean = CornerGradients::Zero();
  double V = 0;
  for (int q = 0; q < 8; ++q) {
    const CornerGradients D = local_gradients(Vec3(gauss[q & 1], gauss[q >> 1 & 1], gauss[q >> 2]));
    const Mat3 J = X.transpose() * D;
    const double det = J.determinant();
    if (!(det > 0))
      throw InputError(
          "", 0, number_of(m_.cells.size()) + " is folded over at a Gauss point; a positive Jacobian was expected");
    points.push_back({D * J.inverse(), det / 8, shape});
    mean += points.back().gradients * det / 8;
    V += det / 8;
  }
  if (volume >= 0) points.insert(points.begin(), {mean / V, V, volume});
  add_cell(nodes, points, V);
}

void ShapedModel::add_quad(const std::array<int32_t, 4>& n, double thickness, int32_t shape, int32_t volume) {
  check(n, shape);
  if (volume >= 0) check(n, volume);
  Eigen::Matrix<double, 4, 2> X;
  for (int a = 0; a < 4; ++a) X.row(a) = m_.X_mm[size_t(n[size_t(a)])].head<2>().transpose();
  std::vector<Point> points;
  CornerGradients mean = CornerGradients::Zero();
  double V = 0;
  for (int q = 0; q < 4; ++q) {
    const double x = gauss[q & 1], y = gauss[q >> 1];
    Eigen::Matrix<double, 4, 2> D;
    D << y - 1, x - 1, 1 - y, -x, -y, 1 - x, y, x;
    const Eigen::Matrix2d J = X.transpose() * D;
    const double det = J.determinant();
    if (!(det > 0))
      throw InputError(
          "", 0, number_of(m_.cells.size()) + " is folded over at a Gauss point; a positive Jacobian was expected");
    CornerGradients G = CornerGradients::Zero();
    G.topLeftCorner<4, 2>() = D * J.inverse();
    const double v = det * thickness / 4;
    points.push_back({G, v, shape});
    mean += G * v;
    V += v;
  }
  if (volume >= 0) points.insert(points.begin(), {mean / V, V, volume});
  add_cell({n[0], n[1], n[2], n[3], n[0], n[0], n[0], n[0]}, points, V);
}

void ShapedModel::add_tet(std::array<int32_t, 4> n, int32_t law) {
  check(n, law);
  const auto edges = [&] {
    Mat3 D;
    for (int i = 0; i < 3; ++i) D.col(i) = m_.X_mm[size_t(n[size_t(i + 1)])] - m_.X_mm[size_t(n[0])];
    return D;
  };
  Mat3 D = edges();
  if (D.determinant() < 0) std::swap(n[2], n[3]), D = edges();
  const double V = D.determinant() / 6, longest = D.colwise().norm().maxCoeff();
  if (!(V > 1e-12 * longest * longest * longest))
    throw InputError("", 0, number_of(m_.cells.size()) + " is a flat tetrahedron; one with a volume was expected");
  const Mat3 inverse = D.inverse();  // row i: the gradient of corner i + 1
  CornerGradients G = CornerGradients::Zero();
  G.middleRows<3>(1) = inverse;
  G.row(0) = -inverse.colwise().sum();
  add_cell({n[0], n[1], n[2], n[3], n[0], n[0], n[0], n[0]}, {{G, V, law}}, V);
}

FemModel ShapedModel::finish(double density) const {
  FemModel m = m_;
  double mean = 0;
  m.mass_kg.assign(m.X_mm.size(), 0);
  for (const HexCell& c : m.cells) {
    Stencil& s = m.stencils[size_t(c.stencil)];
    s.density_kg_mm3 = density;
    mean += s.volume_mm3 / double(m.cells.size());
    std::array<double, 8> used{};
    double sum = 0;
    for (size_t a = 0; a < 8; ++a)
      used[a] = s.points[0].gradients->row(Eigen::Index(a)).squaredNorm() > 0, sum += used[a];
    for (size_t a = 0; a < 8; ++a) m.mass_kg[size_t(c.node[a])] += density * s.volume_mm3 * used[a] / sum;
  }
  m.cell_mm = Vec3::Constant(elementary::cbrt(std::max(mean, 1e-300)));
  return m;
}

}  // namespace limberg
