#include "sim/lattice/cut_cells.h"

#include <algorithm>
#include <cmath>

namespace limberg {
namespace {

constexpr double kFar_mm = 1e30;  // a depth that no layer but the last has

// Index of the sample at corner (i, j, k) of the boxes.
constexpr int sample_at(int i, int j, int k) { return (k * (kSplit + 1) + j) * (kSplit + 1) + i; }

// Corners on the way along three axes from the low corner of a box to its high one, in every order: six tetrahedra that
// fill it, and whose sides are those of the boxes next to it.
constexpr int kPath[6][2] = {{1, 3}, {1, 5}, {2, 3}, {2, 6}, {4, 5}, {4, 6}};

}  // namespace

// The depth is the least of the distances to two skins: linear for each of them, not for both. Corners whose skins face
// different ways get both depths, the other one along the plane of the corners that it belongs to.
constexpr double kOneSkin = 0.5;  // cosine of the angle between ways down that are still taken as one skin's

struct CellCutter::Tet {
  struct Corner {
    Vec3 x = Vec3::Zero();
    double inside = 0, depth = 0, other = kFar_mm;  // `other`: depth below another skin
    Vec3 down = Vec3::Zero();
  };
  std::array<Corner, 4> v;
  void see_two_skins(const Vec3& cell_mm);
};

void CellCutter::Tet::see_two_skins(const Vec3& cell_mm) {
  std::array<bool, 4> second{};
  bool two = false;
  for (size_t i = 1; i < 4; ++i) two = (second[i] = v[0].down.dot(v[i].down) < kOneSkin) || two;
  if (!two) return;
  // Depth at corner i below the skin of the corners on one side: the least of their planes.
  const auto depth = [&](size_t i, bool side) {
    if (second[i] == side) return v[i].depth;
    double least = kFar_mm;
    for (size_t k = 0; k < 4; ++k)
      if (second[k] == side)
        least = std::min(least, v[k].depth + v[k].down.dot((v[i].x - v[k].x).cwiseProduct(cell_mm)));
    return least;
  };
  std::array<double, 4> first{};
  for (size_t i = 0; i < 4; ++i) first[i] = depth(i, false), v[i].other = depth(i, true);
  for (size_t i = 0; i < 4; ++i) v[i].depth = first[i];
}

namespace {

template <class Tet>
double volume6(const Tet& t) {
  const Vec3 a = t.v[1].x - t.v[0].x, b = t.v[2].x - t.v[0].x, c = t.v[3].x - t.v[0].x;
  return std::abs(a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                  a[2] * (b[0] * c[1] - b[1] * c[0]));
}

template <class Corner>
Corner between(const Corner& p, const Corner& q, double fp, double fq) {
  const double t = fp / (fp - fq);
  Corner c;
  c.x = p.x + t * (q.x - p.x);
  c.inside = p.inside + t * (q.inside - p.inside), c.depth = p.depth + t * (q.depth - p.depth);
  c.other = p.other + t * (q.other - p.other);
  return c;
}

// The prism between triangles a and b, corner to corner.
template <class Tet, class Corner, class Visit>
void prism(const std::array<Corner, 3>& a, const std::array<Corner, 3>& b, Visit&& visit) {
  visit(Tet{{a[0], a[1], a[2], b[0]}});
  visit(Tet{{a[1], a[2], b[0], b[1]}});
  visit(Tet{{a[2], b[0], b[1], b[2]}});
}

// The parts of t where the linear function f of its corners is negative, and where it is not.
template <class Tet, class Low, class High>
void split(const Tet& t, const std::array<double, 4>& f, Low&& low, High&& high) {
  std::array<size_t, 4> order{};
  size_t n = 0;
  for (size_t i = 0; i < 4; ++i)
    if (f[i] < 0) order[n++] = i;
  const size_t below = n;
  for (size_t i = 0; i < 4; ++i)
    if (!(f[i] < 0)) order[n++] = i;
  if (below == 0) return high(t);
  if (below == 4) return low(t);
  const auto corner = [&](size_t i) { return t.v[order[i]]; };
  const auto cut = [&](size_t i, size_t j) { return between(t.v[order[i]], t.v[order[j]], f[order[i]], f[order[j]]); };
  using Corner = std::decay_t<decltype(t.v[0])>;
  using Triangle = std::array<Corner, 3>;
  if (below == 1) {
    const Triangle at{cut(0, 1), cut(0, 2), cut(0, 3)};
    low(Tet{{corner(0), at[0], at[1], at[2]}});
    prism<Tet>(at, Triangle{corner(1), corner(2), corner(3)}, high);
  } else if (below == 3) {
    const Triangle at{cut(0, 3), cut(1, 3), cut(2, 3)};
    high(Tet{{corner(3), at[0], at[1], at[2]}});
    prism<Tet>(at, Triangle{corner(0), corner(1), corner(2)}, low);
  } else {
    const Corner ac = cut(0, 2), ad = cut(0, 3), bc = cut(1, 2), bd = cut(1, 3);
    prism<Tet>(Triangle{corner(0), ac, ad}, Triangle{corner(1), bc, bd}, low);
    prism<Tet>(Triangle{corner(2), ac, bc}, Triangle{corner(3), ad, bd}, high);
  }
}

// The four points of the rule of degree two (Hammer and Stroud 1956).
template <class Tet, class Add>
void points_of(const Tet& t, double volume, Add&& add) {
  constexpr double b = 0.13819660112501052, a = 1 - 4 * b;
  const Vec3 sum = b * (t.v[0].x + t.v[1].x + t.v[2].x + t.v[3].x);
  for (size_t i = 0; i < 4; ++i) add(Vec3(sum + a * t.v[i].x), 0.25 * volume);
}

}  // namespace

Mat3 CellMoments::second() const {
  const Vec3 c = centre();
  Mat3 m;
  const auto at = [&](int i, int j, int k) { return of[size_t(9 * k + 3 * j + i)] / of[0]; };
  m(0, 0) = at(2, 0, 0) - c[0] * c[0], m(1, 1) = at(0, 2, 0) - c[1] * c[1], m(2, 2) = at(0, 0, 2) - c[2] * c[2];
  m(0, 1) = m(1, 0) = at(1, 1, 0) - c[0] * c[1];
  m(1, 2) = m(2, 1) = at(0, 1, 1) - c[1] * c[2];
  m(2, 0) = m(0, 2) = at(1, 0, 1) - c[2] * c[0];
  for (double& x : m.reshaped())
    if (std::fabs(x) < 1e-12) x = 0;
  return m;
}

void CellMoments::add(const CellMoments& o, double factor) {
  for (size_t n = 0; n < 27; ++n) of[n] += factor * o.of[n];
}

void CellMoments::add_point(const Vec3& at, double volume, double edge) {
  const double own = edge * edge / 12;
  const double x[3] = {1, at[0], at[0] * at[0] + own}, y[3] = {1, at[1], at[1] * at[1] + own},
               z[3] = {1, at[2], at[2] * at[2] + own};
  for (size_t k = 0; k < 3; ++k)
    for (size_t j = 0; j < 3; ++j) {
      const double w = volume * z[k] * y[j];
      for (size_t i = 0; i < 3; ++i) of[9 * k + 3 * j + i] += w * x[i];
    }
}

CellMoments box_cell_moments(const Vec3& cell_mm, const Vec3& lo, const Vec3& hi) {
  double power[3][3];
  for (int a = 0; a < 3; ++a) {
    const double p = lo[a], q = hi[a];
    power[a][0] = q - p, power[a][1] = 0.5 * (q * q - p * p), power[a][2] = (q * q * q - p * p * p) / 3;
  }
  CellMoments m;
  const double whole = cell_mm[0] * cell_mm[1] * cell_mm[2];
  for (size_t k = 0; k < 3; ++k)
    for (size_t j = 0; j < 3; ++j)
      for (size_t i = 0; i < 3; ++i) m.of[9 * k + 3 * j + i] = whole * power[0][i] * power[1][j] * power[2][k];
  return m;
}

CellCutter::CellCutter(const Vec3& cell_mm, std::vector<double> end_mm)
    : cell_mm_(cell_mm), end_mm_(std::move(end_mm)) {
  for (int b = 0; b < kSplit * kSplit * kSplit; ++b) {
    const Vec3 at(b % kSplit, b / kSplit % kSplit, b / (kSplit * kSplit));
    box_.push_back(box_cell_moments(cell_mm, at / kSplit, (at + Vec3::Ones()) / kSplit));
  }
}

template <class Piece>
void CellCutter::layers_of(const Tet& t, size_t layer, Piece&& piece) const {
  if (layer == end_mm_.size()) return piece(int(layer), t);
  std::array<double, 4> f{};
  for (size_t i = 0; i < 4; ++i) f[i] = t.v[i].depth - end_mm_[layer];
  split(
      t, f, [&](const Tet& above) { piece(int(layer), above); },
      [&](const Tet& below) {
        for (size_t i = 0; i < 4; ++i) f[i] = below.v[i].other - end_mm_[layer];
        split(
            below, f, [&](const Tet& above) { piece(int(layer), above); },
            [&](const Tet& under) { layers_of(under, layer + 1, piece); });
      });
}

template <class Box, class Piece>
void CellCutter::visit(const CellSamples& samples, Box&& box, Piece&& piece) const {
  const auto layer_of = [&](double depth) {
    return size_t(std::upper_bound(end_mm_.begin(), end_mm_.end(), depth) - end_mm_.begin());
  };
  for (int b = 0; b < kSplit * kSplit * kSplit; ++b) {
    const int at[3] = {b % kSplit, b / kSplit % kSplit, b / (kSplit * kSplit)};
    std::array<Tet::Corner, 8> corner;
    double least = kFar_mm, most = -kFar_mm, low = kFar_mm, high = -kFar_mm;
    for (int k = 0; k < 8; ++k) {
      const int i = at[0] + (k & 1), j = at[1] + (k >> 1 & 1), l = at[2] + (k >> 2 & 1);
      const Skin::Place& p = samples[size_t(sample_at(i, j, l))];
      Tet::Corner& c = corner[size_t(k)];
      c.x = Vec3(i, j, l) / kSplit, c.inside = p.inside_mm, c.depth = std::min(p.in_layers_mm(), kFar_mm),
      c.down = p.down;
      least = std::min(least, c.inside), most = std::max(most, c.inside);
      low = std::min(low, c.depth), high = std::max(high, c.depth);
    }
    if (!(most > 0)) continue;
    bool one = true;
    for (size_t k = 1; k < 8; ++k) one = one && !(corner[0].down.dot(corner[k].down) < kOneSkin);
    if (least >= 0 && layer_of(low) == layer_of(high) && (one || layer_of(low) == 0)) {
      box(int(layer_of(low)), size_t(b));
      continue;
    }
    for (const auto& path : kPath) {
      Tet tet{{corner[0], corner[size_t(path[0])], corner[size_t(path[1])], corner[7]}};
      tet.see_two_skins(cell_mm_);
      split(
          tet, {tet.v[0].inside, tet.v[1].inside, tet.v[2].inside, tet.v[3].inside}, [](const Tet&) {},
          [&](const Tet& inside) {
            layers_of(inside, 0, [&](int layer, const Tet& t) {
              const double volume = volume6(t) / 6 * (cell_mm_[0] * cell_mm_[1] * cell_mm_[2]);
              if (volume > 0) piece(layer, t, volume);
            });
          });
    }
  }
}

std::vector<CellMoments> CellCutter::moments(const CellSamples& samples) const {
  std::vector<CellMoments> out(end_mm_.size() + 1);
  visit(
      samples, [&](int layer, size_t b) { out[size_t(layer)].add(box_[b]); },
      [&](int layer, const Tet& t, double volume) {
        points_of(t, volume, [&](const Vec3& x, double v) { out[size_t(layer)].add_point(x, v); });
      });
  return out;
}

std::vector<LayerPoint> CellCutter::points(const CellSamples& samples) const {
  std::vector<LayerPoint> out;
  visit(
      samples,
      [&](int layer, size_t b) {
        out.push_back({layer, box_[b].volume_mm3(), box_[b].centre(), size_t(layer)});
      },
      [&](int layer, const Tet& t, double volume) {
        out.push_back({layer, volume, 0.25 * (t.v[0].x + t.v[1].x + t.v[2].x + t.v[3].x), size_t(layer)});
      });
  return out;
}

std::vector<LayerPoint> CellCutter::fine_points(const CellSamples& samples) const {
  constexpr double edge = 0.5 / kSplit;
  std::vector<LayerPoint> out;
  visit(
      samples,
      [&](int layer, size_t b) {
        for (int q = 0; q < 8; ++q)
          out.push_back({layer, box_[b].volume_mm3() / 8,
                         box_[b].centre() + 0.5 * edge * Vec3(q & 1 ? 1 : -1, q & 2 ? 1 : -1, q & 4 ? 1 : -1),
                         size_t(layer), edge});
      },
      [&](int layer, const Tet& t, double volume) {
        points_of(t, volume, [&](const Vec3& x, double v) { out.push_back({layer, v, x, size_t(layer)}); });
      });
  return out;
}

LayerMoments layer_moments(const Vec3& cell_mm, const CellMoments& c) {
  LayerMoments m;
  const double V = c.volume_mm3();
  m.volume_mm3 = V;
  const Vec3 sum(c.of[1], c.of[3], c.of[9]);
  m.x = (sum - Vec3::Constant(0.5 * V)).cwiseProduct(cell_mm);
  const auto at = [&](const std::array<int, 3>& e) { return c.of[size_t(9 * e[2] + 3 * e[1] + e[0])]; };
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) {
      std::array<int, 3> e{};
      ++e[i], ++e[j];
      m.xx(int(i), int(j)) = (at(e) - 0.5 * (sum[int(i)] + sum[int(j)]) + 0.25 * V) * cell_mm[int(i)] * cell_mm[int(j)];
    }
  // dN_n / dx_a: +-1/h times a linear function along each of the other two axes.
  for (int n = 0; n < 8; ++n)
    for (size_t a = 0; a < 3; ++a) {
      const size_t p = (a + 1) % 3, q = (a + 2) % 3;
      const double factor = ((n >> a & 1) ? 1 : -1) / cell_mm[int(a)];
      const double u[2] = {(n >> p & 1) ? 0.0 : 1.0, (n >> p & 1) ? 1.0 : -1.0};
      const double v[2] = {(n >> q & 1) ? 0.0 : 1.0, (n >> q & 1) ? 1.0 : -1.0};
      const auto integral = [&](std::array<int, 3> e) {
        double s = 0;
        for (int i = 0; i < 2; ++i)
          for (int j = 0; j < 2; ++j) {
            std::array<int, 3> f = e;
            f[p] += i, f[q] += j;
            s += u[i] * v[j] * at(f);
          }
        return factor * s;
      };
      const double plain = integral({0, 0, 0});
      m.B(n, int(a)) = plain;
      for (size_t j = 0; j < 3; ++j) {
        std::array<int, 3> e{};
        ++e[j];
        m.Bx[j](n, int(a)) = (integral(e) - 0.5 * plain) * cell_mm[int(j)];
      }
    }
  return m;
}

}  // namespace limberg
