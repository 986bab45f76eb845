#include "sim/skull/simplex/generators.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/skull/simplex/dual.h"

namespace limberg::simplex {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kMostVertices = 20e6;

void need(bool ok, const char* what) {
  if (!ok) throw InputError("", 0, what);
}
void need_length(double l, const char* what) { need(std::isfinite(l) && l > 0, what); }

struct Surface {
  std::vector<Vec3> X;
  std::vector<Tri> tri;
};

Mesh projected(const Surface& s, const Vec3& centre, double radius) {
  Mesh m = from_triangles(s.X, s.tri, DualPlacement::centroid);
  for (Vec3& x : m.x_mm) x = centre + radius * x.normalized();
  m.before_mm = m.x_mm;
  record_shape(m);
  return m;
}

Surface icosahedron() {
  const double g = std::numbers::phi;
  Surface s;
  for (int axis = 0; axis < 3; ++axis)  // three golden rectangles
    for (int i = 0; i < 4; ++i) {
      Vec3 p = Vec3::Zero();
      p[(axis + 1) % 3] = i & 1 ? -1 : 1, p[(axis + 2) % 3] = i & 2 ? -g : g;
      s.X.push_back(p.normalized());
    }
  // Faces: all triples at the shortest distance, turned outwards.
  const double edge = 2 / std::sqrt(1 + g * g) * 1.001;
  for (int32_t a = 0; a < 12; ++a)
    for (int32_t b = a + 1; b < 12; ++b)
      for (int32_t c = b + 1; c < 12; ++c) {
        const Vec3 &p = s.X[size_t(a)], &q = s.X[size_t(b)], &r = s.X[size_t(c)];
        if ((p - q).norm() > edge || (q - r).norm() > edge || (r - p).norm() > edge) continue;
        s.tri.push_back((q - p).cross(r - p).dot(p) > 0 ? Tri{a, b, c} : Tri{a, c, b});
      }
  return s;
}

Surface divided(const Surface& s) {
  Surface out;
  out.X = s.X;
  std::map<std::pair<int32_t, int32_t>, int32_t> middle;
  auto mid = [&](int32_t a, int32_t b) {
    const auto [it, fresh] = middle.try_emplace({std::min(a, b), std::max(a, b)}, int32_t(out.X.size()));
    if (fresh) out.X.push_back((s.X[size_t(a)] + s.X[size_t(b)]).normalized());
    return it->second;
  };
  for (const Tri& t : s.tri) {
    const int32_t ab = mid(t[0], t[1]), bc = mid(t[1], t[2]), ca = mid(t[2], t[0]);
    out.tri.insert(out.tri.end(), {{ab, bc, ca}, {t[0], ab, ca}, {t[1], bc, ab}, {t[2], ca, bc}});
  }
  return out;
}

/// Convex hull of points on a sphere, one point after the other:
/// the faces that see it give way to a cone over their border.
Surface hull(const std::vector<Vec3>& X) {
  Surface s;
  s.X = X;
  auto sees = [&](const Tri& t, const Vec3& p) {
    const Vec3& a = X[size_t(t[0])];
    return (X[size_t(t[1])] - a).cross(X[size_t(t[2])] - a).dot(p - a) > 0;
  };
  s.tri = {{0, 1, 2}, {0, 2, 1}};
  for (int32_t v = 3; size_t(v) < X.size(); ++v) {
    std::vector<Tri> keep;
    std::vector<std::pair<int32_t, int32_t>> edge;
    for (const Tri& t : s.tri) {
      if (!sees(t, X[size_t(v)])) {
        keep.push_back(t);
        continue;
      }
      for (size_t k = 0; k < 3; ++k) edge.push_back({t[k], t[(k + 1) % 3]});
    }
    std::vector<std::pair<int32_t, int32_t>> sorted = edge;
    std::sort(sorted.begin(), sorted.end());
    for (const auto& [a, b] : edge)
      if (!std::binary_search(sorted.begin(), sorted.end(), std::pair{b, a})) keep.push_back({a, b, v});
    s.tri = std::move(keep);
  }
  return s;
}

/// Rows of points, row j shifted by half a step where j is odd; wrapped or not. Triangles seen counter-clockwise when
/// i goes right and j goes up.
std::vector<Tri> strip_triangles(int ni, int nj, bool wrap_i, bool wrap_j) {
  std::vector<Tri> tri;
  const int cells = wrap_i ? ni : ni - 1;
  auto at = [&](int i, int j) { return int32_t((j % nj) * ni + i % ni); };
  for (int j = 0; j < (wrap_j ? nj : nj - 1); ++j)
    for (int i = 0; i < cells; ++i) {
      if (j % 2 == 0) {  // the row above is shifted right
        tri.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
        tri.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      } else {
        tri.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
        tri.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    }
  return tri;
}

}  // namespace

Mesh make_sphere(const Vec3& centre, double radius, int levels) {
  need(centre.allFinite(), "the centre of a sphere must be finite");
  need_length(radius, "the radius of a sphere must be a finite number above 0 mm");
  need(levels >= 0 && levels <= 9, "a sphere is divided 0 to 9 times");
  Surface s = icosahedron();
  for (int l = 0; l < levels; ++l) s = divided(s);
  return projected(s, centre, radius);
}

Mesh make_sphere_of_faces(const Vec3& centre, double radius, int faces) {
  need(centre.allFinite(), "the centre of a sphere must be finite");
  need_length(radius, "the radius of a sphere must be a finite number above 0 mm");
  need(faces >= 12 && faces <= 20000, "a sphere of spread points has 12 to 20000 faces");
  std::vector<Vec3> X;
  const double turn = kPi * (3 - std::sqrt(5.));  // golden angle
  for (int i = 0; i < faces; ++i) {
    const double z = 1 - (2 * i + 1.) / faces, rho = std::sqrt(1 - z * z);
    X.push_back({rho * elementary::cos(turn * i), rho * elementary::sin(turn * i), z});
  }
  return projected(hull(X), centre, radius);
}

Mesh make_torus(double R, double r, int around, int across) {
  need_length(r, "the small radius of a torus must be a finite number above 0 mm");
  need(std::isfinite(R) && R > r, "the great radius of a torus must be finite and larger than the small one");
  need(around >= 4 && around % 2 == 0, "a torus has an even number of at least 4 steps around");
  need(across >= 4, "a torus has at least 4 steps across");
  need(2. * around * across <= kMostVertices, "a torus has at most 20 million vertices");
  // Rows go around (j, shifted every other row); within a row the points go across (i).
  const auto place = [&](double i, double j) {
    const double a = 2 * kPi * i / across, b = 2 * kPi * j / around;
    const double rho = R + r * elementary::cos(a);
    return Vec3(rho * elementary::cos(b), rho * elementary::sin(b), r * elementary::sin(a));
  };
  std::vector<Vec3> X;
  for (int j = 0; j < around; ++j)
    for (int i = 0; i < across; ++i) X.push_back(place(i + 0.5 * (j % 2), j));
  std::vector<Tri> tri = strip_triangles(across, around, true, true);
  for (Tri& t : tri) std::swap(t[1], t[2]);  // across x around points inwards
  Mesh m = from_triangles(X, tri, DualPlacement::centroid);
  for (Vec3& x : m.x_mm) {
    const double b = elementary::atan2(x.y(), x.x()), rho = elementary::hypot(x.x(), x.y()) - R,
                 h = elementary::hypot(rho, x.z());
    const double q = R + r * rho / h;
    x = {q * elementary::cos(b), q * elementary::sin(b), r * x.z() / h};
  }
  m.before_mm = m.x_mm;
  record_shape(m);
  return m;
}

Mesh make_cylinder(double R, double length, int around) {
  need_length(R, "the radius of a cylinder must be a finite number above 0 mm");
  need_length(length, "the length of a cylinder must be a finite number above 0 mm");
  need(around >= 4, "a cylinder has at least 4 faces around");
  const double step = 2 * kPi * R / around, row = step * std::sqrt(3.) / 2;
  need(length / row * around <= kMostVertices / 2, "a cylinder has at most 20 million vertices");
  const int rows = std::max(2, int(std::lround(length / row)));
  std::vector<Vec3> X;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i < around; ++i) {
      const double a = 2 * kPi * (i + 0.5 * (j % 2)) / around;
      X.push_back({R * elementary::cos(a), R * elementary::sin(a), length * j / rows});
    }
  Mesh m = from_triangles(X, strip_triangles(around, rows + 1, true, false), DualPlacement::centroid);
  for (Vec3& x : m.x_mm) x.head<2>() *= R / x.head<2>().norm();
  m.before_mm = m.x_mm;
  record_shape(m);
  return m;
}

Mesh make_plane(double size_x, double size_y, double edge) {
  need_length(size_x, "the sides of a plane must be finite numbers above 0 mm");
  need_length(size_y, "the sides of a plane must be finite numbers above 0 mm");
  need_length(edge, "the edges of a plane's faces must be finite and longer than 0 mm");
  const double step = edge * std::sqrt(3.), row = step * std::sqrt(3.) / 2;  // dual triangles of side sqrt(3) edge
  need(2 * (size_x / step + 1) * (size_y / row + 1) <= kMostVertices, "a plane has at most 20 million vertices");
  const int ni = std::max(2, int(std::lround(size_x / step))), nj = std::max(2, int(std::lround(size_y / row)));
  std::vector<Vec3> X;
  for (int j = 0; j <= nj; ++j)
    for (int i = 0; i <= ni; ++i) {
      const double shift = i == 0 || i == ni ? 0 : j % 2 == 0 ? -0.25 : 0.25;  // rows differ by half a step inside
      X.push_back({size_x * (i + shift) / ni, size_y * j / nj, 0});
    }
  return from_triangles(X, strip_triangles(ni + 1, nj + 1, false, false), DualPlacement::centroid);
}

}  // namespace limberg::simplex
