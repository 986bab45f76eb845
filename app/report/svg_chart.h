#pragma once
// Charts as SVG text: axes (linear or logarithmic), polylines, bars of ranges and shares, marked values, a legend.
// Nothing is needed to show them but a browser. Colours are CSS variables (--ink, --grid, --s1 .. --s6) with
// fall-backs, so that a page can give them its light and dark scheme.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace limberg {

struct ChartAxis {
  std::string title;
  bool log = false;                // values <= 0 are left out
  std::optional<double> min, max;  // otherwise from the data, rounded outwards
};

struct ChartSeries {
  std::string name;
  std::vector<double> x, y;  // same length; not finite: a gap
  bool markers = false;
};

/// A horizontal or vertical line at a value worth comparing with.
struct ChartMark {
  double value = 0;
  std::string label;
};

struct LineChart {
  std::string description;  // for those who cannot see it
  ChartAxis x, y;
  std::vector<ChartSeries> series;
  std::vector<ChartMark> y_marks, x_marks;
  int width = 760, height = 300;
};

/// A row: a bar from low to high with ticks at the given values.
struct RangeRow {
  std::string name;
  std::optional<double> low, high;        // the bar
  std::optional<double> median, extreme;  // a dot and a ring
  std::optional<double> budget;           // a line of its own
  int colour = 1;
};

struct RangeChart {
  std::string description;
  ChartAxis x;
  std::vector<RangeRow> rows;
  int width = 760;
};

/// A row of shares of a whole: two bars from 0, each with the interval that it is known to.
struct ShareBar {
  double value = 0, low = 0, high = 0;
};
struct ShareRow {
  std::string name;
  ShareBar first, second;
};

struct ShareChart {
  std::string description, first, second;  // what the bars are
  ChartAxis x;
  std::vector<ShareRow> rows;
  int width = 760;
};

std::string svg(const LineChart& chart);
std::string svg(const ShareChart& chart);
std::string svg(const RangeChart& chart);

/// For a file of its own: on white, the fall-backs in place of the variables, which drawing programs do not know.
std::string in_plain_colours(std::string_view svg);

/// Tick values of an axis from lo to hi: round steps, or the powers of ten (with 2 and 5 between when there are few).
std::vector<double> axis_ticks(double lo, double hi, bool log);

/// At most about `most` points that keep every peak and every gap: the lowest, the highest and the first gap of each
/// stretch.
ChartSeries thinned(const ChartSeries& series, size_t most);

}  // namespace limberg
