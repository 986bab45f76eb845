#include "app/pictures/field_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace limberg {

std::string field_map_svg(const SurfaceView& view, const Body& body, std::span<const float> value, const FieldMap& map,
                          double nothing) {
  constexpr const char* kInk[10] = {"#fff3e6", "#fde3c8", "#fbd0a4", "#f7b77b", "#f19b54",
                                    "#e67e34", "#d3611c", "#b5470f", "#8f310a", "#641f06"};
  Vec2 lo = Vec2::Constant(1e300), hi = -lo;
  std::vector<std::array<Vec2, 3>> corner(view.tri.size());
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    for (size_t k = 0; k < 3; ++k) {
      corner[t][k] = body.to_chart(view.X_mm[size_t(view.tri[t][k])]);
      lo = lo.cwiseMin(corner[t][k]), hi = hi.cwiseMax(corner[t][k]);
    }
  }
  constexpr double kAround_mm = 25;
  std::vector<std::pair<Vec2, Vec2>> cut;
  Vec2 cut_lo = Vec2::Constant(1e300), cut_hi = -cut_lo;
  for (size_t t = 0; t < view.tri.size() && t < view.rim.size(); ++t)
    for (size_t k = 0; k < 3; ++k)
      if (view.kind[t] == FaceKind::skin && (view.rim[t] >> k & 1)) {
        cut.push_back({corner[t][k], corner[t][(k + 1) % 3]});
        for (const Vec2& p : {cut.back().first, cut.back().second})
          cut_lo = cut_lo.cwiseMin(p), cut_hi = cut_hi.cwiseMax(p);
      }
  if (!cut.empty()) {
    // A square, so that every map of an operation has one scale.
    const Vec2 centre = 0.5 * (cut_lo + cut_hi), half = Vec2::Constant(0.5 * (cut_hi - cut_lo).maxCoeff() + kAround_mm);
    lo = lo.cwiseMax(centre - half), hi = hi.cwiseMin(centre + half);
  }
  if (!(hi.x() > lo.x()) || !(hi.y() > lo.y()))
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 10 10\"></svg>\n";
  const double step = (hi - lo).maxCoeff() / 160;
  const int nx = int(std::ceil((hi.x() - lo.x()) / step)), ny = int(std::ceil((hi.y() - lo.y()) / step));
  std::vector<int> level(size_t(nx) * size_t(ny), -1);
  const auto left = [](const Vec2& a, const Vec2& b, const Vec2& p) {
    return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
  };
  for (size_t t = 0; t < view.tri.size() && t < value.size(); ++t) {
    if (view.kind[t] != FaceKind::skin || !std::isfinite(value[t]) || double(value[t]) < nothing) continue;
    const auto& c = corner[t];
    const double share = std::clamp((double(value[t]) - map.lo) / (map.hi - map.lo), 0.0, 1.0);
    const int ink = std::clamp(int(10 * (map.dark_is_low ? 1 - share : share)), 0, 9);
    const Vec2 a = c[0].cwiseMin(c[1]).cwiseMin(c[2]), b = c[0].cwiseMax(c[1]).cwiseMax(c[2]);
    for (int i = std::max(0, int((a.x() - lo.x()) / step)); i <= std::min(nx - 1, int((b.x() - lo.x()) / step)); ++i)
      for (int k = std::max(0, int((a.y() - lo.y()) / step)); k <= std::min(ny - 1, int((b.y() - lo.y()) / step));
           ++k) {
        const Vec2 p(lo.x() + (i + 0.5) * step, lo.y() + (k + 0.5) * step);
        const double s[3] = {left(c[0], c[1], p), left(c[1], c[2], p), left(c[2], c[0], p)};
        if ((s[0] >= 0 && s[1] >= 0 && s[2] >= 0) || (s[0] <= 0 && s[1] <= 0 && s[2] <= 0))
          level[size_t(k) * size_t(nx) + size_t(i)] = ink;
      }
  }
  const double px = 560.0 / nx, height = px * ny;
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 700 {:.0f}\" font-family=\"sans-serif\" "
      "font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
      height + 40);
  std::string s = text + std::string("<text x=\"8\" y=\"20\" font-size=\"15\">") + map.title + "</text>\n";
  for (int k = 0; k < ny; ++k)
    for (int i = 0; i < nx;) {
      const int ink = level[size_t(k) * size_t(nx) + size_t(i)];
      int j = i;
      while (j < nx && level[size_t(k) * size_t(nx) + size_t(j)] == ink) ++j;
      if (ink >= 0) {
        text = fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"/>\n",
                           8 + i * px, 32 + (ny - 1 - k) * px, (j - i) * px + 0.2, px + 0.2, kInk[ink]);
        s += text;
      }
      i = j;
    }
  s += "<g stroke=\"#222\" stroke-width=\"1\" stroke-linecap=\"round\">\n";
  const double mm = px / step;
  for (const auto& [a, b] : cut) {
    text = fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>\n", 8 + (a.x() - lo.x()) * mm,
                       32 + height - (a.y() - lo.y()) * mm, 8 + (b.x() - lo.x()) * mm,
                       32 + height - (b.y() - lo.y()) * mm);
    s += text;
  }
  text = fmt::format(
      "<line x1=\"585\" y1=\"270\" x2=\"{:.1f}\" y2=\"270\" stroke-width=\"2\"/></g>\n<text x=\"585\" y=\"290\">10 "
      "mm</text>\n",
      585 + 10 * mm);
  s += text;
  for (int n = 0; n < 10; ++n) {
    const double v = map.lo + (map.hi - map.lo) * (map.dark_is_low ? 1 - n / 10.0 : n / 10.0);
    const std::string figure = map.w("{:.3g}", v);
    text = fmt::format(
        "<rect x=\"585\" y=\"{}\" width=\"18\" height=\"18\" fill=\"{}\"/><text x=\"610\" y=\"{}\">{} {}</text>\n",
        40 + 20 * n, kInk[n], 54 + 20 * n, figure, n == 0 ? map.unit.c_str() : "");
    s += text;
  }
  return s + "</svg>\n";
}

}  // namespace limberg
