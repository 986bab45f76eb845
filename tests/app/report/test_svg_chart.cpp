#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>

#include "app/report/html.h"
#include "app/report/markup.h"
#include "app/report/svg_chart.h"
#include "tests/app/report/xml_check.h"

namespace limberg {
namespace test_svg_chart {

using test::xml_fault;

TEST(Html, NumbersAsPeopleReadThem) {
  EXPECT_EQ(html::number(0), "0");
  EXPECT_EQ(html::number(1.5), "1.5");
  EXPECT_EQ(html::number(0.12345), "0.123");
  EXPECT_EQ(html::number(142620.125, 9), "142620.125");
  EXPECT_EQ(html::number(0.9996), "1");
  EXPECT_EQ(html::number(99.96), "100");
  EXPECT_EQ(html::number(-2.5), "\u22122.5");
  EXPECT_EQ(html::number(3.21e-5), "3.21\u202f×\u202f10⁻⁵");
  EXPECT_EQ(html::number(1e-4), "10⁻⁴");
  EXPECT_EQ(html::number(NAN), "–");
  EXPECT_EQ(html::quantity({}, "mm"), "–");
  for (const double v : {1e308, -1e308, 5e-324, 1e-300, 123456789.0}) EXPECT_FALSE(html::number(v).empty());
}

TEST(Html, EscapesAndRepairsText) {
  EXPECT_EQ(html::escape("a<b>&\"'"), "a&lt;b&gt;&amp;&quot;&#39;");
  EXPECT_EQ(html::escape("ä €\n"), "ä €\n");
  EXPECT_EQ(html::escape("\xff"), "\ufffd");
  EXPECT_EQ(html::escape("\xc3"), "\ufffd");                      // cut off
  EXPECT_EQ(html::escape("\xc0\xbc"), "\ufffd\ufffd");            // an overlong '<'
  EXPECT_EQ(html::escape("\xed\xa0\x80"), "\ufffd\ufffd\ufffd");  // half of a surrogate pair
  EXPECT_EQ(html::escape(std::string("\0\x1b", 2)), "\ufffd\ufffd");
}

// A letter of 13 px is about 7.5 px wide (Helvetica's digits 7.2, its m 10.8).
TEST(Chart, LongLegendsAndTitlesFitInto) {
  LineChart c;
  c.y.title = "rms distance of the surface from the mesh, in mm";
  for (int i = 0; i < 14; ++i)
    c.series.push_back({"prestretch " + std::to_string(i) + " %, cells", {0, 1e5}, {double(i), 1}, false});
  const std::string s = svg(c);
  EXPECT_EQ(xml_fault(s), "");
  double width = 0, height = 0, lowest = 0;
  ASSERT_EQ(std::sscanf(s.c_str() + s.find("viewBox=\"0 0 ") + 13, "%lf %lf", &width, &height), 2);
  std::set<std::string> looks;
  for (const ChartSeries& series : c.series) {
    const size_t end = s.find(">" + series.name + "<");
    ASSERT_NE(end, std::string::npos);
    const size_t begin = s.rfind("<text", end), sample = s.rfind("<line", begin);
    double x = 0, y = 0;
    ASSERT_EQ(std::sscanf(s.c_str() + begin, "<text x=\"%lf\" y=\"%lf\"", &x, &y), 2);
    EXPECT_LE(x + 7.5 * double(series.name.size()), width) << series.name;
    lowest = std::max(lowest, y);
    const size_t look = s.find("stroke=", sample);
    EXPECT_TRUE(looks.insert(s.substr(look, begin - look)).second) << series.name << " looks like another";
  }
  double last = 0;
  const size_t number = s.find(">" + html::number(1e5) + "<"), begin = s.rfind("<text", number);
  ASSERT_EQ(std::sscanf(s.c_str() + begin, "<text x=\"%lf\"", &last), 1);
  EXPECT_LE(last + 0.5 * 7.5 * double(html::number(1e5).size()), width);
  double top = 1e9;  // of the lines of the grid
  for (size_t at = s.find("y1=\""); at != std::string::npos; at = s.find("y1=\"", at + 1))
    if (const double y = std::atof(s.c_str() + at + 4); y > lowest) top = std::min(top, y);
  EXPECT_GT(top, lowest);
  EXPECT_GE(height - 48 - top, 7.5 * double(c.y.title.size()) - 1);
}

TEST(Html, Base64) {
  EXPECT_EQ(html::base64(""), "");
  EXPECT_EQ(html::base64("f"), "Zg==");
  EXPECT_EQ(html::base64("fo"), "Zm8=");
  EXPECT_EQ(html::base64("foobar"), "Zm9vYmFy");
}

TEST(Chart, TicksAreRoundAndInside) {
  for (const auto& [lo, hi] : {std::pair{0.0, 1.0}, {-3.0, 17.0}, {0.0, 3600.0}, {1e-9, 2e-9}, {-1e300, 1e300}}) {
    const auto t = axis_ticks(lo, hi, false);
    EXPECT_GE(t.size(), 3u) << lo << " " << hi;
    EXPECT_LE(t.size(), 12u);
    for (const double v : t) EXPECT_TRUE(v >= lo - 1e-9 * (hi - lo) && v <= hi + 1e-9 * (hi - lo));
  }
  const auto decades = axis_ticks(1e-6, 1, true);
  EXPECT_EQ(decades.size(), 7u);
  EXPECT_DOUBLE_EQ(decades.front(), 1e-6);
  EXPECT_LE(axis_ticks(1e-300, 1e300, true).size(), 12u);
  EXPECT_TRUE(axis_ticks(1, 1, false).empty());
  EXPECT_TRUE(axis_ticks(0, INFINITY, false).empty());
  EXPECT_TRUE(axis_ticks(-1, 1, true).empty());
}

TEST(Chart, ThinningKeepsPeaks) {
  ChartSeries s{"r", {}, {}, false};
  for (int i = 0; i < 10000; ++i) s.x.push_back(i), s.y.push_back(i == 7777 ? 5.0 : i == 1234 ? -5.0 : 1.0);
  const ChartSeries t = thinned(s, 200);
  EXPECT_LE(t.x.size(), 200u);
  EXPECT_EQ(*std::max_element(t.y.begin(), t.y.end()), 5);
  EXPECT_EQ(*std::min_element(t.y.begin(), t.y.end()), -5);
  EXPECT_TRUE(std::is_sorted(t.x.begin(), t.x.end()));
}

TEST(Chart, ThinningKeepsPeaksBesideGapsAndTheGaps) {
  ChartSeries s;
  for (int i = 0; i < 5000; ++i) {
    s.x.push_back(i), s.y.push_back(std::sin(0.01 * i));
    if (i % 500 == 250) s.y.back() = NAN;
  }
  s.y[251] = 5, s.y[749] = -5;
  const ChartSeries t = thinned(s, 200);
  EXPECT_LE(t.x.size(), 300u);
  EXPECT_TRUE(std::is_sorted(t.x.begin(), t.x.end()));
  EXPECT_EQ(std::count(t.y.begin(), t.y.end(), 5), 1);
  EXPECT_EQ(std::count(t.y.begin(), t.y.end(), -5), 1);
  EXPECT_EQ(std::count_if(t.y.begin(), t.y.end(), [](double v) { return std::isnan(v); }), 10);
}

TEST(Chart, LineAndRangeChartsAreWellFormed) {
  LineChart c;
  c.description = "a \"chart\" <of> & things";
  c.x.title = "time, s", c.y = {"residual & more", true, {}, {}};
  c.series = {{"<one>", {0, 1, 2, 3}, {1, 0.1, NAN, 1e-3}, true}, {"two", {0, 1}, {-1, 0}, false}};
  c.y_marks = {{1e-4, "goal"}};
  c.x_marks = {{1, "a"}, {1.01, "b"}, {99, "outside"}};
  const std::string s = svg(c);
  EXPECT_EQ(xml_fault(s), "");
  EXPECT_NE(s.find("goal"), std::string::npos);
  EXPECT_EQ(s.find("outside"), std::string::npos);
  EXPECT_EQ(s.find("nan"), std::string::npos);
  // Four points, one missing: the line is lifted once, so there are two starts.
  const size_t path = s.find("<path");
  ASSERT_NE(path, std::string::npos);
  const std::string d = s.substr(path, s.find("/>", path) - path);
  EXPECT_EQ(std::count(d.begin(), d.end(), 'M'), 2);
  EXPECT_EQ(s.find("<path", path + 1), std::string::npos);  // on a log axis the second series has no point

  RangeChart r;
  r.x = {"ms", true, {}, {}};
  r.rows = {{"lane", 0.1, 2.0, 0.1, 30.0, 16.7, 1},
            {"half", {}, {}, 1.0, {}, {}, 9},
            {"none", {}, {}, {}, {}, {}, -3},
            {"odd", -1.0, 0.0, NAN, INFINITY, {}, 2}};
  EXPECT_EQ(xml_fault(svg(r)), "");
  EXPECT_EQ(xml_fault(svg(LineChart{})), "");
  EXPECT_EQ(xml_fault(svg(RangeChart{})), "");
}

// On a logarithmic axis equal ratios lie equally far apart.
TEST(Chart, LogAxisIsLogarithmic) {
  LineChart c;
  c.y.log = true;
  c.series = {{"r", {0, 1, 2}, {1, 0.1, 0.01}, true}};
  const std::string s = svg(c);
  std::vector<double> y;
  for (size_t i = s.find("<circle"); i != std::string::npos; i = s.find("<circle", i + 1))
    y.push_back(std::stod(s.substr(s.find("cy=\"", i) + 4)));
  ASSERT_EQ(y.size(), 3u);
  EXPECT_NEAR(y[1] - y[0], y[2] - y[1], 0.11);  // pixels are written with one decimal
  EXPECT_GT(y[1], y[0]);
}

// Drawing programs know no CSS variables and draw nothing, or all in black.
TEST(SvgChart, AFileOfItsOwnHasColoursThatEveryProgramKnows) {
  LineChart chart;
  chart.description = "a line";
  chart.series.push_back({"one", {1, 2, 3}, {2, 3, 1}, true});
  chart.series.push_back({"two", {1, 2, 3}, {3, 1, 1}, false});
  const std::string page = svg(chart), file = in_plain_colours(page);
  EXPECT_NE(page.find("var(--s2,#"), std::string::npos);
  EXPECT_EQ(file.find("var("), std::string::npos);
  EXPECT_NE(file.find("fill=\"#222\""), std::string::npos);
  EXPECT_LT(file.find("fill=\"#fff\"/>"), file.find("<line"));
  EXPECT_EQ(xml_fault(file), "");
  EXPECT_EQ(in_plain_colours("<svg>no colours</svg>"),
            "<svg><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>no colours</svg>");
}

}  // namespace test_svg_chart
}  // namespace limberg
