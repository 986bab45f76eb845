#include "sim/body/block.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/base/error.h"

namespace limberg {
namespace {

// A rectangle of the surface as rows of vertex indices; two triangles a cell, diagonals alternating.
struct Sheet {
  int nx, ny;
  std::vector<int32_t> v;
  Sheet(int nx_, int ny_) : nx(nx_), ny(ny_), v(size_t(nx_ + 1) * size_t(ny_ + 1), -1) {}
  int32_t& at(int i, int j) { return v[size_t(j) * size_t(nx + 1) + size_t(i)]; }
};

class Builder {
 public:
  explicit Builder(const BlockSpec& s) : uv_scale_(1 / std::max(s.size_mm.x(), s.size_mm.y())), size_(s.size_mm) {}

  TriMesh mesh;

  int32_t vertex(const Vec3& X) {
    mesh.X_mm.push_back(X);
    return int32_t(mesh.X_mm.size()) - 1;
  }

  void triangle(int32_t a, int32_t b, int32_t c, SurfaceTag tag, const Vec3& normal) {
    mesh.tri.push_back({a, b, c});
    mesh.tag.push_back(tag);
    mesh.uv.push_back({uv(a, normal), uv(b, normal), uv(c, normal)});
  }

  // Counter-clockwise when `normal` = (direction of i) x (direction of j).
  void fill(Sheet& s, SurfaceTag tag, const Vec3& normal) {
    for (int j = 0; j < s.ny; ++j)
      for (int i = 0; i < s.nx; ++i) {
        const int32_t a = s.at(i, j), b = s.at(i + 1, j), c = s.at(i + 1, j + 1), d = s.at(i, j + 1);
        if ((i + j) % 2 == 0) {
          triangle(a, b, c, tag, normal);
          triangle(a, c, d, tag, normal);
        } else {
          triangle(a, b, d, tag, normal);
          triangle(b, c, d, tag, normal);
        }
      }
  }

 private:
  // The sides and the bottom unfold away from the skin, so that a grid texture keeps its scale.
  Eigen::Vector2f uv(int32_t v, const Vec3& normal) const {
    const Vec3& X = mesh.X_mm[size_t(v)];
    Vec2 p(X.x() + 0.5 * size_.x(), X.y() + 0.5 * size_.y());
    if (normal.z() == 0) p += -X.z() * normal.head<2>();
    return (p * uv_scale_).cast<float>();
  }
  double uv_scale_;
  Vec3 size_;
};

void check(const BlockSpec& s) {
  auto fail = [&](const std::string& what) { throw InputError(s.name, 0, what); };
  if (!s.size_mm.allFinite() || s.size_mm.minCoeff() <= 0) fail("block size must be three finite lengths above 0 mm");
  if (s.size_mm.maxCoeff() > 1000) fail("block size is above 1000 mm; expected at most 1000");
  if (!std::isfinite(s.skin_cell_mm) || s.skin_cell_mm <= 0) fail("skin cell size must be above 0 mm");
  if (s.size_mm.x() * s.size_mm.y() / (s.skin_cell_mm * s.skin_cell_mm) > 2e6)
    fail("skin cells are too fine: more than 4 million triangles; expected larger skin cells");
  if (s.size_mm.minCoeff() < 0.01) fail("block is thinner than 0.01 mm");
  if (!s.tension_direction.allFinite() || s.tension_direction.head<2>().norm() < 1e-9)
    fail("tension direction must have a part in the plane of the skin");
}

}  // namespace

double rest_unit_mm(double half_extent_mm) {
  double unit = 1.0 / 8192;
  const double need = half_extent_mm * (1 + 1.0 / 32);
  while (need > 0.5 * unit * (RestGrid::kMaxCoordinate - 2)) unit *= 2;
  return unit;
}

Body make_block(const BlockSpec& spec) {
  check(spec);
  Body body;
  body.name = spec.name;
  const double half = std::max({0.5 * spec.size_mm.x(), 0.5 * spec.size_mm.y(), spec.size_mm.z()});
  body.grid.unit_mm = rest_unit_mm(half);
  const RestGrid& g = body.grid;
  auto snap = [&](const Vec3& X) { return g.to_mm(g.to_grid(X)); };

  // Even counts, so that the bottom can have half as many.
  auto cells = [&](double length) { return 2 * std::max(1, int(std::lround(0.5 * length / spec.skin_cell_mm))); };
  const int nx = cells(spec.size_mm.x()), ny = cells(spec.size_mm.y());
  const double h = spec.size_mm.x() / nx;
  // Rows of the sides: fine squares would be many on a thick block and say nothing; rows of up to three cells do.
  const int nz = std::clamp(int(std::lround(spec.size_mm.z() / (2.5 * h))), 1, 64);
  auto x = [&](int i) { return spec.size_mm.x() * (double(i) / nx - 0.5); };
  auto y = [&](int j) { return spec.size_mm.y() * (double(j) / ny - 0.5); };
  auto z = [&](int k) { return -spec.size_mm.z() * double(k) / nz; };

  Builder b(spec);
  Sheet top(nx, ny), bottom(nx / 2, ny / 2);
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) top.at(i, j) = b.vertex(snap({x(i), y(j), 0}));
  for (int j = 0; j <= ny / 2; ++j)
    for (int i = 0; i <= nx / 2; ++i) bottom.at(i, j) = b.vertex(snap({x(2 * i), y(2 * j), -spec.size_mm.z()}));
  b.fill(top, SurfaceTag::skin, Vec3::UnitZ());

  // The ring of the border, counter-clockwise seen from above: grid position of its n-th vertex.
  const int ring = 2 * (nx + ny);
  auto border = [&](int n) -> std::pair<int, int> {
    n %= ring;
    if (n < nx) return {n, 0};
    if (n < nx + ny) return {nx, n - nx};
    if (n < 2 * nx + ny) return {nx - (n - nx - ny), ny};
    return {0, ny - (n - 2 * nx - ny)};
  };
  std::vector<std::vector<int32_t>> row{size_t(nz)};  // rows 0 .. nz-1 are fine
  for (int k = 0; k < nz; ++k)
    for (int n = 0; n < ring; ++n) {
      const auto [i, j] = border(n);
      row[size_t(k)].push_back(k == 0 ? top.at(i, j) : b.vertex(snap({x(i), y(j), z(k)})));
    }
  auto low = [&](int n) {  // bottom vertex under even border position n
    const auto [i, j] = border(n);
    return bottom.at(i / 2, j / 2);
  };
  const auto tag_of = [&](const Vec3& normal) {
    const size_t side = normal.x() != 0 ? size_t(normal.x() > 0) : normal.y() != 0 ? 2 + size_t(normal.y() > 0) : 4;
    return spec.sides[side] == SideHold::free ? SurfaceTag::free : SurfaceTag::fixed;
  };
  auto outward = [&](int n) -> Vec3 {
    if (n < nx) return -Vec3::UnitY();
    if (n < nx + ny) return Vec3::UnitX();
    if (n < 2 * nx + ny) return Vec3::UnitY();
    return -Vec3::UnitX();
  };
  for (int k = 0; k + 1 < nz; ++k)
    for (int n = 0; n < ring; ++n) {
      const size_t m = size_t((n + 1) % ring);
      const int32_t p = row[size_t(k + 1)][size_t(n)], q = row[size_t(k + 1)][m], r = row[size_t(k)][m],
                    s = row[size_t(k)][size_t(n)];
      const Vec3 normal = outward(n);
      if ((n + k) % 2 == 0) {
        b.triangle(p, q, r, tag_of(normal), normal);
        b.triangle(p, r, s, tag_of(normal), normal);
      } else {
        b.triangle(p, q, s, tag_of(normal), normal);
        b.triangle(q, r, s, tag_of(normal), normal);
      }
    }
  for (int n = 0; n < ring; n += 2) {  // two fine edges above, one coarse edge below
    const auto& up = row[size_t(nz - 1)];
    const int32_t l = low(n), r = low(n + 2), a = up[size_t(n)], c = up[size_t(n + 1)], e = up[size_t((n + 2) % ring)];
    const Vec3 normal = outward(n);
    b.triangle(l, c, a, tag_of(normal), normal);
    b.triangle(l, r, c, tag_of(normal), normal);
    b.triangle(r, e, c, tag_of(normal), normal);
  }
  // Seen from below: swap the corners of every triangle of the bottom.
  const size_t first = b.mesh.tri.size();
  b.fill(bottom, tag_of(-Vec3::UnitZ()), -Vec3::UnitZ());
  for (size_t t = first; t < b.mesh.tri.size(); ++t) {
    std::swap(b.mesh.tri[t][1], b.mesh.tri[t][2]);
    std::swap(b.mesh.uv[t][1], b.mesh.uv[t][2]);
  }

  body.surface = std::move(b.mesh);
  body.layers = spec.layers;
  if (body.layers.empty()) body.layers.push_back({"tissue", spec.size_mm.z(), Material{}});
  body.tension_direction = Vec3(spec.tension_direction.x(), spec.tension_direction.y(), 0).normalized();
  body.box_min_mm = snap({x(0), y(0), -spec.size_mm.z()});
  body.box_max_mm = snap({x(nx), y(ny), 0});
  body.is_box = true;
  for (size_t side = 0; side < spec.sides.size(); ++side)
    if (spec.sides[side] == SideHold::sliding) body.sliding_sides |= uint8_t(1u << side);
  return body;
}

}  // namespace limberg
