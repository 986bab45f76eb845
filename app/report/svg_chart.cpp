#include "app/report/svg_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "app/report/html.h"
#include "app/report/markup.h"

namespace limberg {

namespace {

constexpr const char* kColours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};

std::string f1(double v) { return fmt::format("{:.1f}", v); }

std::string colour(size_t i) {
  const size_t k = i % 6;
  return "var(--s" + std::to_string(k + 1) + "," + kColours[k] + ")";
}

// Beyond the colours lines are told apart by their dashes.
const char* dashes(size_t i) { return i < 6 ? "" : i < 12 ? " stroke-dasharray=\"7 4\"" : " stroke-dasharray=\"2 3\""; }

double step_for(double range, int most) {
  const double raw = range / most, power = std::pow(10, std::floor(std::log10(raw)));
  for (const double m : {1.0, 2.0, 5.0})
    if (m * power >= raw * (1 - 1e-9)) return m * power;
  return 10 * power;
}

// Value to pixel along one axis.
struct Scale {
  double lo = 0, hi = 1, from = 0, to = 1;
  bool log = false;
  bool can(double v) const { return std::isfinite(v) && (!log || v > 0); }
  double at(double v) const {
    const double t = log ? (std::log10(v) - std::log10(lo)) / (std::log10(hi) - std::log10(lo)) : (v - lo) / (hi - lo);
    return from + std::clamp(t, -0.02, 1.02) * (to - from);
  }
};

struct Range {
  double lo = std::numeric_limits<double>::max(), hi = -std::numeric_limits<double>::max();
  void add(double v, bool log) {
    if (std::isfinite(v) && (!log || v > 0)) lo = std::min(lo, v), hi = std::max(hi, v);
  }
};

Scale make_scale(const ChartAxis& axis, Range r, double from, double to) {
  if (r.lo > r.hi) r.lo = axis.log ? 0.1 : 0, r.hi = 1;
  if (axis.min && (!axis.log || *axis.min > 0)) r.lo = *axis.min;
  if (axis.max && (!axis.log || *axis.max > 0)) r.hi = *axis.max;
  if (axis.log) {
    r.lo = std::max(r.lo, 1e-300);
    r.hi = std::clamp(r.hi, r.lo, 1e300);
    if (!axis.min) r.lo = std::pow(10, std::floor(std::log10(r.lo) + 1e-9));
    if (!axis.max) r.hi = std::pow(10, std::ceil(std::log10(r.hi) - 1e-9));
    if (r.hi <= r.lo) r.hi = 10 * r.lo;
  } else {
    if (!(r.hi - r.lo > 1e-12 * (std::abs(r.hi) + std::abs(r.lo)) && r.hi - r.lo > 1e-300 &&
          std::isfinite(r.hi - r.lo))) {
      const double pad = std::max(1e-3, std::min(0.5 * std::abs(r.lo), 1e300));
      if (!std::isfinite(r.hi - r.lo))
        r.lo = -1, r.hi = 1;
      else
        r.hi = r.lo + pad;
    }
    const double step = step_for(r.hi - r.lo, 6);
    if (!axis.min) r.lo = step * std::floor(r.lo / step + 1e-9);
    if (!axis.max) r.hi = step * std::ceil(r.hi / step - 1e-9);
  }
  return {r.lo, r.hi, from, to, axis.log};
}

std::string text(double x, double y, const std::string& anchor, const std::string& body, const std::string& more = "") {
  return "<text x=\"" + f1(x) + "\" y=\"" + f1(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" +
         html::escape(body) + "</text>";
}

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
  return "<line x1=\"" + f1(x1) + "\" y1=\"" + f1(y1) + "\" x2=\"" + f1(x2) + "\" y2=\"" + f1(y2) + "\" " + style +
         "/>";
}

std::string open(int width, int height, const std::string& description) {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" viewBox=\"0 0 " + std::to_string(width) + " " +
         std::to_string(height) + "\" role=\"img\" aria-label=\"" + html::escape(description) +
         "\" font-family=\"system-ui,sans-serif\" font-size=\"13\" fill=\"var(--ink,#222)\">";
}

const std::string kGrid = "stroke=\"var(--grid,#ddd)\" stroke-width=\"1\"";
const std::string kMark = "stroke=\"var(--ink,#222)\" stroke-width=\"1\" stroke-dasharray=\"5 4\" opacity=\"0.65\"";

constexpr double kLetter = 7.5, kLegendTop = 14, kLegendRow = 20;

struct LegendPlace {
  double x, y;
};
/// Of the names of a legend, in rows that end before `right`.
std::vector<LegendPlace> places(const std::vector<ChartSeries>& series, double left, double right) {
  std::vector<LegendPlace> out;
  LegendPlace at{left, kLegendTop};
  for (const ChartSeries& s : series) {
    const double wide = 28 + kLetter * double(s.name.size());
    if (at.x > left && at.x + wide > right) at = {left, at.y + kLegendRow};
    out.push_back(at);
    at.x += wide + 16;
  }
  return out;
}

std::string x_axis(const Scale& x, const ChartAxis& axis, double top, double bottom) {
  std::string s;
  for (const double v : axis_ticks(x.lo, x.hi, x.log)) {
    s += line(x.at(v), top, x.at(v), bottom, kGrid);
    s += text(x.at(v), bottom + 17, "middle", html::number(v));
  }
  if (!axis.title.empty()) s += text(0.5 * (x.from + x.to), bottom + 37, "middle", axis.title);
  return s;
}

}  // namespace

std::string in_plain_colours(std::string_view svg) {
  constexpr std::string_view kVariable = "var(--";
  std::string out;
  for (size_t at = 0; at < svg.size();) {
    const size_t from = svg.find(kVariable, at), comma = svg.find(',', from), to = svg.find(')', comma);
    const bool one = from != svg.npos && comma != svg.npos && to != svg.npos;
    out.append(svg.substr(at, one ? from - at : svg.npos));
    if (!one) break;
    out.append(svg.substr(comma + 1, to - comma - 1));
    at = to + 1;
  }
  const size_t drawing = out.find('>');  // the end of <svg ...>
  if (drawing != out.npos) out.insert(drawing + 1, "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>");
  return out;
}

std::vector<double> axis_ticks(double lo, double hi, bool log) {
  std::vector<double> t;
  if (!(hi > lo) || !std::isfinite(lo) || !std::isfinite(hi)) return t;
  if (!log) {
    const double step = step_for(hi - lo, 7);
    const double first = std::ceil(lo / step - 1e-9);
    for (int k = 0; k < 20 && (first + k) * step <= hi + 1e-9 * (hi - lo); ++k) t.push_back((first + k) * step);
    return t;
  }
  if (lo <= 0) return t;
  const int a = int(std::floor(std::log10(lo) + 1e-9)), b = int(std::ceil(std::log10(hi) - 1e-9));
  const int every = std::max(1, (b - a + 7) / 8);
  for (int p = a; p <= b; ++p)
    for (const double m : {1.0, 2.0, 5.0}) {
      if (m > 1 && b - a > 2) continue;
      const double v = m * std::pow(10, p);
      if ((p - a) % every == 0 && v >= lo * (1 - 1e-9) && v <= hi * (1 + 1e-9)) t.push_back(v);
    }
  return t;
}

ChartSeries thinned(const ChartSeries& s, size_t most) {
  const size_t n = std::min(s.x.size(), s.y.size());
  if (n <= most || most < 4) return s;
  ChartSeries out{s.name, {}, {}, s.markers};
  const size_t stretches = most / 2;
  for (size_t k = 0; k < stretches; ++k) {
    const size_t b = k * n / stretches, e = (k + 1) * n / stretches;
    std::array<size_t, 3> kept{n, n, n};  // the lowest, the highest, the first gap
    auto& [low, high, gap] = kept;
    for (size_t i = b; i < e; ++i) {
      if (!std::isfinite(s.y[i])) {
        if (gap == n) gap = i;
        continue;
      }
      if (low == n || s.y[i] < s.y[low]) low = i;
      if (high == n || s.y[i] > s.y[high]) high = i;
    }
    std::sort(kept.begin(), kept.end());
    for (size_t j = 0; j < kept.size(); ++j) {
      if (kept[j] == n || (j > 0 && kept[j] == kept[j - 1])) continue;
      out.x.push_back(s.x[kept[j]]);
      out.y.push_back(s.y[kept[j]]);
    }
  }
  return out;
}

std::string svg(const LineChart& c) {
  const double left = 78, right = c.width - 27.0;  // the last number of the axis goes half beyond it
  const std::vector<LegendPlace> legend =
      c.series.size() > 1 ? places(c.series, left, right) : std::vector<LegendPlace>{};
  const double top = legend.empty() ? 14 : 34 + legend.back().y - kLegendTop;
  // Rows of the legend, and a long title along the y axis, make the chart higher.
  const double bottom =
      top + std::max(c.height - (legend.empty() ? 14.0 : 34.0) - 48, kLetter * double(c.y.title.size()));
  const int height = int(bottom) + 48;
  Range rx, ry;
  for (const ChartSeries& s : c.series)
    for (size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i)
      if (std::isfinite(s.x[i]) && std::isfinite(s.y[i]) && (!c.y.log || s.y[i] > 0))
        rx.add(s.x[i], c.x.log), ry.add(s.y[i], c.y.log);
  for (const ChartMark& m : c.y_marks) ry.add(m.value, c.y.log);
  const Scale x = make_scale(c.x, rx, left, right), y = make_scale(c.y, ry, bottom, top);

  std::string s = open(c.width, height, c.description);
  for (const double v : axis_ticks(y.lo, y.hi, y.log)) {
    s += line(left, y.at(v), right, y.at(v), kGrid);
    s += text(left - 8, y.at(v) + 4.5, "end", html::number(v));
  }
  s += x_axis(x, c.x, top, bottom);
  if (!c.y.title.empty())
    s += text(0, 0, "middle", c.y.title, " transform=\"translate(16 " + f1(0.5 * (top + bottom)) + ") rotate(-90)\"");
  for (const ChartMark& m : c.y_marks)
    if (y.can(m.value)) {
      s += line(left, y.at(m.value), right, y.at(m.value), kMark);
      s += text(right - 4, y.at(m.value) - 5, "end", m.label, " opacity=\"0.8\"");
    }
  double last_label = -1e9;
  int row = 0;
  for (const ChartMark& m : c.x_marks)
    if (x.can(m.value) && m.value >= x.lo && m.value <= x.hi) {
      const double at = x.at(m.value);
      s += line(at, top, at, bottom, kMark);
      row = at - last_label < 90 ? (row + 1) % 4 : 0;  // neighbours get labels on different heights
      s += text(at + 4, top + 12 + 15 * row, "start", m.label, " font-size=\"11\" opacity=\"0.8\"");
      last_label = at;
    }
  for (size_t k = 0; k < c.series.size(); ++k) {
    const ChartSeries t = thinned(c.series[k], 1200);
    std::string d, dots;
    bool pen = false;
    for (size_t i = 0; i < std::min(t.x.size(), t.y.size()); ++i) {
      if (!x.can(t.x[i]) || !y.can(t.y[i])) {
        pen = false;
        continue;
      }
      d += (pen ? "L" : "M") + f1(x.at(t.x[i])) + " " + f1(y.at(t.y[i]));
      pen = true;
      if (t.markers)
        dots += "<circle cx=\"" + f1(x.at(t.x[i])) + "\" cy=\"" + f1(y.at(t.y[i])) + "\" r=\"3.5\" fill=\"" +
                colour(k) + "\"/>";
    }
    if (!d.empty())
      s += "<path d=\"" + d + "\" fill=\"none\" stroke=\"" + colour(k) +
           "\" stroke-width=\"1.6\" stroke-linejoin=\"round\"" + dashes(k) + "/>";
    s += dots;
  }
  for (size_t k = 0; k < legend.size(); ++k) {
    const auto [at, from_top] = legend[k];
    s += line(at, from_top, at + 22, from_top, "stroke=\"" + colour(k) + "\" stroke-width=\"3\"" + dashes(k));
    s += text(at + 28, from_top + 4.5, "start", c.series[k].name);
  }
  return s + "</svg>";
}

std::string svg(const RangeChart& c) {
  const double left = 170, right = c.width - 20.0, top = 10, pitch = 34, bottom = top + pitch * double(c.rows.size());
  Range r;
  for (const RangeRow& row : c.rows)
    for (const auto& v : {row.low, row.high, row.median, row.extreme, row.budget})
      if (v) r.add(*v, c.x.log);
  const Scale x = make_scale(c.x, r, left, right);
  std::string s = open(c.width, int(bottom) + 48, c.description);
  s += x_axis(x, c.x, top, bottom);
  for (size_t k = 0; k < c.rows.size(); ++k) {
    const RangeRow& row = c.rows[k];
    const double y = top + pitch * (double(k) + 0.5);
    const std::string paint = colour(size_t(std::max(row.colour - 1, 0)));
    s += text(left - 10, y + 4.5, "end", row.name);
    const auto has = [&](const std::optional<double>& v) { return v && x.can(*v); };
    if (has(row.high) && has(row.extreme))
      s += line(x.at(*row.high), y, x.at(*row.extreme), y,
                "stroke=\"" + paint + "\" stroke-width=\"2\" opacity=\"0.5\"");
    if (has(row.low) && has(row.high))
      s += line(x.at(*row.low), y, std::max(x.at(*row.high), x.at(*row.low) + 1), y,
                "stroke=\"" + paint + "\" stroke-width=\"11\" stroke-linecap=\"round\"");
    if (has(row.extreme))
      s += "<circle cx=\"" + f1(x.at(*row.extreme)) + "\" cy=\"" + f1(y) +
           "\" r=\"4.5\" fill=\"var(--paper,#fff)\" stroke=\"" + paint + "\" stroke-width=\"2\"/>";
    if (has(row.median))
      s += "<circle cx=\"" + f1(x.at(*row.median)) + "\" cy=\"" + f1(y) + "\" r=\"4\" fill=\"var(--paper,#fff)\"/>";
    if (has(row.budget))
      s += line(x.at(*row.budget), y - 14, x.at(*row.budget), y + 14, "stroke=\"var(--ink,#222)\" stroke-width=\"2\"");
  }
  return s + "</svg>";
}

std::string svg(const ShareChart& c) {
  const double left = 170, right = c.width - 27.0, top = 36, pitch = 40, bottom = top + pitch * double(c.rows.size());
  Range r;
  r.add(0, false);
  for (const ShareRow& row : c.rows)
    for (const ShareBar& b : {row.first, row.second})
      for (const double v : {b.value, b.low, b.high}) r.add(v, false);
  const Scale x = make_scale(c.x, r, left, right);
  std::string s = open(c.width, int(bottom) + 48, c.description);
  s += x_axis(x, c.x, top, bottom);
  double at = left;
  for (const bool second : {false, true}) {
    const std::string& words = second ? c.second : c.first;
    s += line(at, kLegendTop, at + 22, kLegendTop, "stroke=\"" + colour(second) + "\" stroke-width=\"9\"");
    s += text(at + 28, kLegendTop + 4.5, "start", words);
    at += 44 + kLetter * double(words.size());
  }
  for (size_t k = 0; k < c.rows.size(); ++k) {
    const ShareRow& row = c.rows[k];
    const double middle = top + pitch * (double(k) + 0.5);
    s += text(left - 10, middle + 4.5, "end", row.name);
    for (const bool second : {false, true}) {
      const ShareBar& b = second ? row.second : row.first;
      if (!x.can(b.value) || !x.can(b.low) || !x.can(b.high)) continue;
      const double y = middle + (second ? 8 : -8);
      s += line(x.at(0), y, x.at(b.value), y, "stroke=\"" + colour(second) + "\" stroke-width=\"11\"");
      const std::string thin = "stroke=\"var(--ink,#222)\" stroke-width=\"1.5\"";
      s += line(x.at(b.low), y, x.at(b.high), y, thin);
      for (const double end : {b.low, b.high}) s += line(x.at(end), y - 4, x.at(end), y + 4, thin);
    }
  }
  s += line(x.at(0), top, x.at(0), bottom, "stroke=\"var(--ink,#222)\" stroke-width=\"1\"");
  return s + "</svg>";
}

}  // namespace limberg
