#include "sim/imaging/fit/shape_interpolation.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "sim/base/error.h"

namespace limberg {
namespace {

using Mat2 = Eigen::Matrix2d;

constexpr double kTall = 1.5;  // times the longer step within a slice
constexpr double kBand = 2;    // gaps: beyond, grey values go straight up

/// The pixels of every slice: where they lie, in mm in the plane.
struct PixelGrid {
  int32_t nu = 0, nv = 0;
  Mat2 to_mm, to_pixel;
  double gap_mm = 0;
  Vec2 place(int32_t u, int32_t v) const { return to_mm * Vec2(u, v); }
};

struct ContourPiece {
  Vec2 a, b, inward;  // inward: of unit length, up the grey values
};

/// A slice with its contour, and how far each pixel is from that.
struct SliceShape {
  std::vector<float> grey;
  std::vector<ContourPiece> contour;
  std::vector<int32_t> piece;  // the nearest; empty where there is no contour
  std::vector<float> away_mm;  // above 0 inside
};

Vec2 nearest_on(const ContourPiece& c, const Vec2& x) {
  const Vec2 way = c.b - c.a;
  const double length2 = way.squaredNorm();
  return length2 > 0 ? Vec2(c.a + std::clamp((x - c.a).dot(way) / length2, 0., 1.) * way) : c.a;
}

/// Marching squares: one or two pieces in a square of four pixels, between places on its sides.
void find_contour(const PixelGrid& g, float iso, SliceShape& s, std::vector<double>& nearest2) {
  const auto grey = [&](int32_t u, int32_t v) { return s.grey[size_t(v) * size_t(g.nu) + size_t(u)]; };
  for (int32_t v = 0; v + 1 < g.nv; ++v)
    for (int32_t u = 0; u + 1 < g.nu; ++u) {
      // Corners in the order around the square.
      const std::array<std::array<int32_t, 2>, 4> at{{{u, v}, {u + 1, v}, {u + 1, v + 1}, {u, v + 1}}};
      double f[4];
      bool in[4];
      for (size_t c = 0; c < 4; ++c) f[c] = double(grey(at[c][0], at[c][1])), in[c] = f[c] >= double(iso);
      if (in[0] == in[1] && in[1] == in[2] && in[2] == in[3]) continue;
      Vec2 cross[4];
      size_t side[4], n = 0;
      for (size_t c = 0; c < 4; ++c) {
        const size_t e = (c + 1) % 4;
        if (in[c] == in[e]) continue;
        const double t = (double(iso) - f[c]) / (f[e] - f[c]);
        cross[c] = (1 - t) * g.place(at[c][0], at[c][1]) + t * g.place(at[e][0], at[e][1]);
        side[n++] = c;
      }
      const Vec2 slope = g.to_pixel.transpose() * Vec2(f[1] + f[2] - f[0] - f[3], f[3] + f[2] - f[0] - f[1]);
      const Vec2 inward = slope.norm() > 0 ? Vec2(slope.normalized()) : Vec2(Vec2::UnitX());
      // A saddle: the corners that the middle does not side with are cut off.
      std::array<size_t, 4> pair{side[0], side[1], 0, 0};
      if (n == 4) {
        const bool with_first = (0.25 * (f[0] + f[1] + f[2] + f[3]) >= double(iso)) == in[0];
        pair = with_first ? std::array<size_t, 4>{0, 1, 2, 3} : std::array<size_t, 4>{3, 0, 1, 2};
      }
      for (size_t k = 0; k < n; k += 2) {
        const auto number = int32_t(s.contour.size());
        s.contour.push_back({cross[pair[k]], cross[pair[k + 1]], inward});
        for (const auto& [pu, pv] : at) {
          const Vec2 x = g.place(pu, pv);
          const double d2 = (nearest_on(s.contour.back(), x) - x).squaredNorm();
          const size_t i = size_t(pv) * size_t(g.nu) + size_t(pu);
          if (d2 < nearest2[i]) nearest2[i] = d2, s.piece[i] = number;
        }
      }
    }
}

/// The nearest pieces are handed on from pixel to pixel, in two sweeps over the slice (Danielsson 1980, Euclidean
/// distance mapping, with places on the contour instead of pixels).
void spread(const PixelGrid& g, SliceShape& s, std::vector<double>& nearest2) {
  const auto ask = [&](int32_t u, int32_t v, int32_t du, int32_t dv) {
    if (u + du < 0 || u + du >= g.nu || v + dv < 0 || v + dv >= g.nv) return;
    const size_t i = size_t(v) * size_t(g.nu) + size_t(u), j = size_t(v + dv) * size_t(g.nu) + size_t(u + du);
    if (s.piece[j] < 0 || s.piece[j] == s.piece[i]) return;
    const Vec2 x = g.place(u, v);
    const double d2 = (nearest_on(s.contour[size_t(s.piece[j])], x) - x).squaredNorm();
    if (d2 < nearest2[i]) nearest2[i] = d2, s.piece[i] = s.piece[j];
  };
  for (int pass = 0; pass < 2; ++pass) {
    const int32_t back = pass == 0 ? -1 : 1;
    for (int32_t row = 0; row < g.nv; ++row) {
      const int32_t v = pass == 0 ? row : g.nv - 1 - row;
      for (int32_t u = 0; u < g.nu; ++u) {
        for (int32_t du = -1; du <= 1; ++du) ask(u, v, du, back);
        ask(u, v, -1, 0);
      }
      for (int32_t u = g.nu - 1; u >= 0; --u) ask(u, v, 1, 0);
    }
  }
}

SliceShape shape_of(const PixelGrid& g, std::vector<float> grey, float iso) {
  SliceShape s;
  s.grey = std::move(grey);
  s.piece.assign(s.grey.size(), -1);
  std::vector<double> nearest2(s.grey.size(), std::numeric_limits<double>::infinity());
  find_contour(g, iso, s, nearest2);
  if (s.contour.empty()) {
    s.piece.clear();
    // No contour here: the surface ends within a gap, above or below.
    for (const float x : s.grey) s.away_mm.push_back(float(x >= iso ? g.gap_mm : -g.gap_mm));
    return s;
  }
  spread(g, s, nearest2);
  for (size_t i = 0; i < s.grey.size(); ++i)
    s.away_mm.push_back(float(s.grey[i] >= iso ? std::sqrt(nearest2[i]) : -std::sqrt(nearest2[i])));
  return s;
}

double sampled(const PixelGrid& g, const SliceShape& s, const Vec2& x_mm) {
  const Vec2 p = g.to_pixel * x_mm;
  const double pu = std::clamp(p.x(), 0., double(g.nu - 1)), pv = std::clamp(p.y(), 0., double(g.nv - 1));
  const int32_t u = std::min(int32_t(pu), g.nu - 2), v = std::min(int32_t(pv), g.nv - 2);
  const double a = pu - u, b = pv - v;
  const float* f = s.grey.data() + size_t(v) * size_t(g.nu) + size_t(u);
  return (1 - b) * ((1 - a) * double(f[0]) + a * double(f[1])) +
         b * ((1 - a) * double(f[g.nu]) + a * double(f[g.nu + 1]));
}

/// The grey value of a slice where the distance to its contour is `wanted_mm`, on the line through pixel i at x_mm.
double grey_at(const PixelGrid& g, const SliceShape& s, size_t i, const Vec2& x_mm, double wanted_mm) {
  const ContourPiece& c = s.contour[size_t(s.piece[i])];
  const Vec2 foot = nearest_on(c, x_mm);
  const double away = double(s.away_mm[i]);
  const Vec2 inward = std::abs(away) > 1e-6 ? Vec2((x_mm - foot) / away) : c.inward;
  return sampled(g, s, foot + wanted_mm * inward);
}

/// Pixel i at x_mm of the slice that lies the share t of the way from `low` to `high`.
float between(const PixelGrid& g, const SliceShape& low, const SliceShape& high, size_t i, const Vec2& x_mm, double t,
              float iso) {
  const double straight = (1 - t) * double(low.grey[i]) + t * double(high.grey[i]);
  if (low.contour.empty() && high.contour.empty()) return float(straight);
  const double a = double(low.away_mm[i]), b = double(high.away_mm[i]), d = (1 - t) * a + t * b;
  const double near = low.contour.empty()    ? std::abs(b)
                      : high.contour.empty() ? std::abs(a)
                                             : std::min(std::abs(a), std::abs(b));
  const bool crosses = (a >= 0) != (b >= 0);
  const double follows = crosses ? 1 : 1 - near / (kBand * g.gap_mm);
  if (follows <= 0) return float(straight);
  const double inside = double(iso), outside = double(std::nextafter(iso, -std::numeric_limits<float>::infinity()));
  const auto held = [&](double grey) { return d >= 0 ? std::max(grey, inside) : std::min(grey, outside); };
  const auto moved = [&](const SliceShape& s, double away) {
    return held(grey_at(g, s, i, x_mm, away + follows * (d - away)));
  };
  if (!low.contour.empty() && !high.contour.empty()) return float((1 - t) * moved(low, a) + t * moved(high, b));
  const bool low_empty = low.contour.empty();
  const double empty_away = low_empty ? a : b, share = low_empty ? 1 - t : t;
  const double weight = (d >= 0) == (empty_away >= 0) ? share * std::min(1., std::abs(d) / g.gap_mm) : 0;
  const double own = low_empty ? moved(high, b) : moved(low, a), other = double((low_empty ? low : high).grey[i]);
  return float((1 - weight) * own + weight * other);
}

}  // namespace

Volume interpolated_by_shape(const Volume& v, double iso, double step_mm, Workers& workers) {
  if (!std::isfinite(iso)) throw InputError("", 0, "the isovalue is not finite; expected a number of the volume");
  if (!(step_mm > 0) || !std::isfinite(step_mm))
    throw InputError("", 0, "the wanted step is not above 0; expected a length in mm");
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (v.step_mm.col(k).norm() > v.step_mm.col(axis).norm()) axis = k;
  const int au = axis == 0 ? 1 : 0, av = axis == 2 ? 1 : 2;
  const double gap = v.step_mm.col(axis).norm();
  const Vec3 eu = v.step_mm.col(au), ev = v.step_mm.col(av);
  const int32_t slices = v.size[size_t(axis)];
  PixelGrid g;
  g.nu = v.size[size_t(au)], g.nv = v.size[size_t(av)], g.gap_mm = gap;
  const double wanted = std::round(gap / step_mm);
  if (gap <= kTall * std::max(eu.norm(), ev.norm()) || wanted < 2 || slices < 2 || g.nu < 2 || g.nv < 2) return v;
  const int64_t plane = int64_t(g.nu) * g.nv;
  if (wanted * double(slices) * double(plane) > double(VolumeLimits::voxels))
    throw InputError("", 0,
                     "slices " + std::to_string(step_mm) + " mm apart would be more than " +
                         std::to_string(VolumeLimits::voxels) + " voxels; expected a longer step");
  const auto parts = int32_t(wanted);
  // The plane of a slice, laid flat: u along the first axis.
  const Vec3 along = eu.normalized();
  g.to_mm << eu.norm(), ev.dot(along), 0, (ev - along * along.dot(ev)).norm();
  g.to_pixel = g.to_mm.inverse();

  Volume out;
  out.size = v.size, out.step_mm = v.step_mm, out.origin_mm = v.origin_mm;
  out.size[size_t(axis)] = (slices - 1) * parts + 1;
  out.step_mm.col(axis) /= parts;
  out.value.resize(size_t(plane) * size_t(out.size[size_t(axis)]));
  const auto index = [&](const Volume& of, int32_t u, int32_t w, int32_t k) {
    std::array<int32_t, 3> i{};
    i[size_t(au)] = u, i[size_t(av)] = w, i[size_t(axis)] = k;
    return of.index(i[0], i[1], i[2]);
  };
  const auto slice = [&](int32_t k) {
    std::vector<float> grey;
    grey.reserve(size_t(plane));
    for (int32_t w = 0; w < g.nv; ++w)
      for (int32_t u = 0; u < g.nu; ++u) grey.push_back(v.value[index(v, u, w, k)]);
    return shape_of(g, std::move(grey), float(iso));
  };
  const auto fill = [&](int32_t k, const std::function<float(size_t, const Vec2&)>& value) {
    for (int32_t w = 0; w < g.nv; ++w)
      for (int32_t u = 0; u < g.nu; ++u)
        out.value[index(out, u, w, k)] = value(size_t(w) * size_t(g.nu) + size_t(u), g.place(u, w));
  };
  // Gap by gap; a chunk of gaps finds the shape of its first slice anew.
  constexpr size_t kGaps = 4;
  workers.parallel_for(size_t(slices - 1), kGaps, [&](size_t begin, size_t end) {
    SliceShape low = slice(int32_t(begin));
    for (size_t k = begin; k < end; ++k) {
      SliceShape high = slice(int32_t(k) + 1);
      const int32_t base = int32_t(k) * parts;
      fill(base, [&](size_t i, const Vec2&) { return low.grey[i]; });
      for (int32_t j = 1; j < parts; ++j)
        fill(base + j, [&](size_t i, const Vec2& x) {
          return between(g, low, high, i, x, double(j) / double(parts), float(iso));
        });
      if (int32_t(k) + 2 == slices) fill(base + parts, [&](size_t i, const Vec2&) { return high.grey[i]; });
      low = std::move(high);
    }
  });
  return out;
}

}  // namespace limberg
