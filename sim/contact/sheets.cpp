#include "sim/contact/sheets.h"

#include <algorithm>

#include "sim/base/union_find.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

constexpr double kSmooth = 0.766;  // cosine of the largest turn within a sheet, 40 degrees

}  // namespace

bool Sheets::adjacent(int32_t a, int32_t b) const {
  return std::binary_search(meet.begin(), meet.end(), std::minmax({a, b}));
}

Sheets find_sheets(std::span<const Vec3> X, std::span<const Tri> tri, std::span<const uint8_t> kind,
                   std::span<const int32_t> around_begin, std::span<const int32_t> around) {
  Sheets s;
  std::vector<Vec3> n(tri.size());
  for (size_t t = 0; t < tri.size(); ++t) {
    const Vec3 a2 = area_vector2(X[size_t(tri[t][0])], X[size_t(tri[t][1])], X[size_t(tri[t][2])]);
    n[t] = a2.norm() > 0 ? a2.normalized() : Vec3(0, 0, 0);
  }
  UnionFind sheet(tri.size());
  const auto beside = [&](size_t t, int32_t a, int32_t b,
                          auto&& visit) {  // the triangles with lower numbers over edge ab
    for (int32_t i = around_begin[size_t(a)]; i < around_begin[size_t(a) + 1]; ++i) {
      const int32_t u = around[size_t(i)];
      if (u >= int32_t(t)) break;
      const Tri& c = tri[size_t(u)];
      if (c[0] == b || c[1] == b || c[2] == b) visit(u);
    }
  };
  for (size_t t = 0; t < tri.size(); ++t)
    for (size_t k = 0; k < 3; ++k)
      beside(t, tri[t][k], tri[t][(k + 1) % 3], [&](int32_t u) {
        // A triangle without area has no direction of its own: it goes with its neighbours.
        const bool flat = n[t].isZero(0) || n[size_t(u)].isZero(0);
        if (kind[t] != kind[size_t(u)] || (!flat && !(n[t].dot(n[size_t(u)]) > kSmooth))) return;
        sheet.unite(int32_t(t), u);
      });
  s.of.assign(tri.size(), -1);
  for (size_t t = 0; t < tri.size(); ++t) {
    const int32_t r = sheet.find(int32_t(t));
    s.of[t] = r == int32_t(t) ? s.count++ : s.of[size_t(r)];
  }
  for (size_t t = 0; t < tri.size(); ++t)
    for (size_t k = 0; k < 3; ++k)
      beside(t, tri[t][k], tri[t][(k + 1) % 3], [&](int32_t u) {
        if (s.of[t] != s.of[size_t(u)]) s.meet.push_back(std::minmax({s.of[t], s.of[size_t(u)]}));
      });
  std::sort(s.meet.begin(), s.meet.end());
  s.meet.erase(std::unique(s.meet.begin(), s.meet.end()), s.meet.end());
  s.fan.resize(tri.size());
  s.fan_begin.push_back(0);
  std::vector<std::pair<int32_t, int32_t>> here;  // sheet, triangle
  for (size_t v = 0; v + 1 < around_begin.size(); ++v) {
    here.clear();
    for (int32_t i = around_begin[v]; i < around_begin[v + 1]; ++i)
      here.push_back({s.of[size_t(around[size_t(i)])], around[size_t(i)]});
    std::sort(here.begin(), here.end());
    for (size_t i = 0; i < here.size(); ++i) {
      if (i > 0 && here[i].first != here[i - 1].first) s.fan_begin.push_back(int32_t(s.fan_triangle.size()));
      const Tri& c = tri[size_t(here[i].second)];
      for (size_t k = 0; k < 3; ++k)
        if (c[k] == int32_t(v)) s.fan[size_t(here[i].second)][k] = int32_t(s.fan_begin.size()) - 1;
      s.fan_triangle.push_back(here[i].second);
    }
    if (!here.empty()) s.fan_begin.push_back(int32_t(s.fan_triangle.size()));
  }
  return s;
}

}  // namespace limberg
