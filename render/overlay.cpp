#include "render/overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/colour_map.h"

namespace limberg {

namespace {

void fill_rect(Image& im, int x0, int y0, int x1, int y1, Rgb8 c, double alpha) {
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) im.blend(x, y, c, alpha);
}

// A panel with round corners: coverage from the distance to the corner's centre.
void fill_panel(Image& im, int x0, int y0, int x1, int y1, int r, Rgb8 c, double alpha) {
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const double dx = std::max({double(x0 + r) - x - 0.5, x + 0.5 - double(x1 - r), 0.0});
      const double dy = std::max({double(y0 + r) - y - 0.5, y + 0.5 - double(y1 - r), 0.0});
      im.blend(x, y, c, alpha * std::clamp(r - std::hypot(dx, dy) + 0.5, 0.0, 1.0));
    }
}

}  // namespace

double round_step(double range, int most) {
  if (!(range > 0) || !std::isfinite(range) || most < 1) return 1;
  const double raw = range / most, power = std::pow(10, std::floor(std::log10(raw)));
  for (const double m : {1.0, 2.0, 5.0})
    if (m * power >= raw * (1 - 1e-9)) return m * power;
  return 10 * power;
}

std::string tick_label(double value, double step) {
  const int digits = std::clamp(int(-std::floor(std::log10(step) + 1e-9)), 0, 9);
  return fmt::format("{:.{}f}", value == 0 ? 0.0 : value, digits);
}

void draw_caption(Image& image, const TextPainter& text, const std::string& title, const std::string& caption) {
  const double em = std::max(12.0, image.height / 27.0), margin = 0.9 * em;
  double y = margin;
  if (!title.empty()) {
    y += em;
    text.draw(image, margin, y, title, {1.15 * em, {255, 255, 255}, true, 0.55});
    y += 0.35 * em;
  }
  if (!caption.empty()) {
    const TextPainter::Style style{0.78 * em, {238, 244, 245}, false, 0.5};
    for (const std::string& line : text.wrap(caption, 0.68 * image.width, style)) {
      y += 1.0 * em;
      text.draw(image, margin, y, line, style);
    }
  }
}

void draw_legend(Image& image, const TextPainter& text, const Legend& legend) {
  const double em = std::max(10.0, image.height / 36.0);
  const TextPainter::Style label{0.9 * em, {245, 248, 248}, false, 0}, heading{0.92 * em, {255, 255, 255}, true, 0};
  const int bar_w = int(1.2 * em), bar_h = int(0.46 * image.height);
  const int panel_w = int(8.6 * em), right = image.width - int(0.8 * em), left = right - panel_w;
  const auto lines = text.wrap(legend.title, panel_w - 1.6 * em, heading);
  const int head = int(em * (0.7 + 1.15 * double(lines.size()) + (legend.unit.empty() ? 0 : 1.15)));
  const int cap = int(0.95 * em);  // room for the clipping marks
  const int panel_h = head + 2 * cap + bar_h + int(0.9 * em), top = (image.height - panel_h) / 2;
  fill_panel(image, left, top, right, top + panel_h, int(0.6 * em), {18, 28, 32}, 0.62);

  double y = top + 0.35 * em;
  for (const std::string& line : lines) text.draw(image, left + 0.8 * em, y += 1.15 * em, line, heading);
  if (!legend.unit.empty()) text.draw(image, left + 0.8 * em, y += 1.15 * em, legend.unit, label);

  const int x0 = left + int(0.9 * em), y0 = top + head + cap, y1 = y0 + bar_h;
  for (int v = y0; v < y1; ++v)
    for (int u = x0; u < x0 + bar_w; ++u) image.blend(u, v, colour_of(legend.scale, 1 - (v + 0.5 - y0) / bar_h), 1);
  const auto mark = [&](int tip, int base, Rgb8 c) {  // a triangle: the scale goes on beyond its end
    const int step = tip < base ? 1 : -1;
    for (int v = tip; v != base; v += step) {
      const double half = 0.5 * bar_w * double(std::abs(v - tip)) / std::abs(base - tip);
      for (int u = 0; u < bar_w; ++u)
        image.blend(x0 + u, v, c, std::clamp(half - std::abs(u + 0.5 - 0.5 * bar_w) + 0.5, 0.0, 1.0));
    }
  };
  if (legend.clipped_above) mark(y0 - cap + 2, y0 - 2, colour_of(legend.scale, 1));
  if (legend.clipped_below) mark(y1 + cap - 3, y1 + 1, colour_of(legend.scale, 0));

  const double range = legend.max - legend.min, step = round_step(range, 6);
  for (int k = int(std::ceil(legend.min / step - 1e-9)); k <= int(std::floor(legend.max / step + 1e-9)); ++k) {
    const double value = k * step;
    const int v = y1 - int(std::lround((value - legend.min) / range * bar_h));
    fill_rect(image, x0 + bar_w, v, x0 + bar_w + int(0.4 * em), v + std::max(1, int(em / 12)), {245, 248, 248}, 1);
    std::string figure = tick_label(value, step);
    std::replace(figure.begin(), figure.end(), '.', legend.decimal);
    text.draw(image, x0 + bar_w + 0.65 * em, v + 0.32 * em, figure, label);
  }
}

}  // namespace limberg
