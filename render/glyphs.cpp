#include "render/glyphs.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "sim/body/tension_lines.h"

namespace limberg {

namespace {

using Mat2 = Eigen::Matrix2d;
using Mat32 = Eigen::Matrix<double, 3, 2>;

/// The triangle's gradient in the skin's plane, prestretch included; false for one without area.
bool gradient(const Snapshot& s, size_t triangle, Mat32& F) {
  const auto& X = s.topology->view.X_mm;
  const Tri& t = s.topology->view.tri[triangle];
  const Body& body = *s.topology->body;
  const Vec3 lines = tension_along(body, s.topology->view.origin[triangle],
                                   Vec3((X[size_t(t[0])] + X[size_t(t[1])] + X[size_t(t[2])]) / 3));
  const Vec3 normal = (X[size_t(t[1])] - X[size_t(t[0])]).cross(X[size_t(t[2])] - X[size_t(t[0])]).normalized();
  const Vec3 along = (lines - lines.dot(normal) * normal).normalized(), across = normal.cross(along);
  Mat2 E;
  Mat32 e;
  for (int k = 0; k < 2; ++k) {
    const Vec3 rest = X[size_t(t[k + 1])] - X[size_t(t[0])];
    E(0, k) = rest.dot(along), E(1, k) = rest.dot(across);
    e.col(k) = (s.x_mm[size_t(t[k + 1])] - s.x_mm[size_t(t[0])]).cast<double>();
  }
  if (!(std::abs(E.determinant()) > 1e-9)) return false;  // also where the skin stands across the tension lines
  F = e * E.inverse();
  const Material& skin = body.layers[0].material;
  F.col(0) *= skin.prestretch_along, F.col(1) *= skin.prestretch_across;
  return F.allFinite();
}

}  // namespace

std::vector<StretchGlyph> stretch_glyphs(const Snapshot& s, double spacing) {
  std::vector<StretchGlyph> out;
  if (!s.topology || !s.topology->body || s.x_mm.size() != s.topology->view.X_mm.size() ||
      s.topology->body->layers.empty())
    return out;
  const SurfaceView& view = s.topology->view;
  struct Best {
    size_t triangle;
    double off;
  };
  std::map<std::array<int, 2>, Best> square;
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    const Vec3 middle =
        (view.X_mm[size_t(view.tri[t][0])] + view.X_mm[size_t(view.tri[t][1])] + view.X_mm[size_t(view.tri[t][2])]) / 3;
    const Eigen::Vector2d at = s.topology->body->to_chart(middle) / spacing;
    if (!at.allFinite()) continue;
    const std::array<int, 2> key{int(std::floor(at.y())), int(std::floor(at.x()))};
    const double off = (at - Eigen::Vector2d(key[1] + 0.5, key[0] + 0.5)).squaredNorm();
    const auto [it, fresh] = square.try_emplace(key, Best{t, off});
    if (!fresh && off < it->second.off) it->second = {t, off};
  }
  for (const auto& [key, best] : square) {
    const Tri& t = view.tri[best.triangle];
    Mat32 F;
    if (!gradient(s, best.triangle, F)) continue;
    Eigen::SelfAdjointEigenSolver<Mat2> eigen;
    eigen.computeDirect(F.transpose() * F);
    StretchGlyph g;
    const Vec3f &a = s.x_mm[size_t(t[0])], &b = s.x_mm[size_t(t[1])], &c = s.x_mm[size_t(t[2])];
    g.at_mm = (a + b + c) / 3;
    g.normal = (b - a).cross(c - a).normalized();
    g.largest = float(std::sqrt(std::max(0.0, eigen.eigenvalues()[1]))),
    g.least = float(std::sqrt(std::max(0.0, eigen.eigenvalues()[0])));
    g.first = (F * eigen.eigenvectors().col(1)).cast<float>().normalized();
    g.second = g.normal.cross(g.first);
    if (g.normal.allFinite() && g.first.allFinite()) out.push_back(g);
  }
  return out;
}

void add_glyphs(PropMesh& mesh, const std::vector<StretchGlyph>& glyphs, double spacing) {
  constexpr float kLift = 0.15f, kRadius = 0.16f;  // mm: above the skin, half the width of an arm
  const auto arm = [&](const StretchGlyph& g, const Vec3f& direction, float stretch) {
    const float half = 0.5f * float(spacing) * std::min(1.0f, std::abs(stretch - 1) / kFullStretch);
    if (half < 2 * kRadius) return;
    const Vec3f at = g.at_mm + kLift * g.normal;
    const Vec3f path[2] = {at - half * direction, at + half * direction};
    const float radius[2] = {kRadius, kRadius};
    PropLook look;
    look.colour = stretch >= 1 ? Vec3f(0.45f, 0.04f, 0.03f) : Vec3f(0.03f, 0.12f, 0.55f);
    add_tube(mesh, path, radius, look, 5);
  };
  for (const StretchGlyph& g : glyphs) arm(g, g.first, g.largest), arm(g, g.second, g.least);
}

}  // namespace limberg
