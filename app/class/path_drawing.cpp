#include "app/class/path_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/class/walk.h"
#include "app/report/markup.h"
#include "app/report/svg_chart.h"
#include "app/teaching/against_plan.h"
#include "app/words/words.h"
#include "devices/sample.h"
#include "sim/commands/strokes.h"

namespace limberg {
namespace {

constexpr double kWide_px = 480;
constexpr const char *kGrey = "#b5bdc0", *kDarkGrey = "#7d878b", *kHand = "#9cc3dd", *kPlan = "#8e6aa8";

struct ToolColour {
  const char *colour, *words;
};
ToolColour colour_of(Tool t) {
  switch (t) {
    case Tool::scalpel:
    case Tool::scalpel_through:
    case Tool::excise:
    case Tool::saw:
      return {"#c2410c", "cut"};
    case Tool::undermine:
      return {"#15803d", "undermined"};
    case Tool::hook:
    case Tool::grab:
      return {"#7c3aed", "held and carried"};
    case Tool::suture:
    case Tool::suture_row:
      return {"#b98200", "sewn"};
    default:
      return {"#0b6b74", "another tool pressed"};
  }
}

/// Cuts of a script, where no hand was recorded.
std::vector<DrawnLine> cuts_of(const ClassMember& m) {
  std::vector<DrawnLine> all;
  if (!m.also.path.empty()) return all;
  for (const Command& c : join_strokes(acts_of(m).command))
    if (auto line = drawn_line(c)) all.push_back(std::move(*line));
  return all;
}

struct Canvas {
  DrawnFrame f;
  double scale;
  std::string text;

  explicit Canvas(const DrawnFrame& frame) : f(frame), scale(kWide_px / (frame.x1_mm - frame.x0_mm)) {}
  double height() const { return (f.y1_mm - f.y0_mm) * scale; }
  std::string at(double x, double y) const {
    return fmt::format("{:.1f},{:.1f}", (x - f.x0_mm) * scale, (f.y1_mm - y) * scale);
  }
  void line(const std::string& points, const char* colour, double width, const char* dash = "") {
    text += fmt::format(
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{:.1f}\" stroke-linejoin=\"round\" "
        "stroke-linecap=\"round\"{}/>\n",
        points, colour, width, *dash ? fmt::format(" stroke-dasharray=\"{}\"", dash) : "");
  }
  void drawn(const DrawnLine& l, const char* colour, double width, const char* dash = "") {
    std::string points;
    for (const ChartPoint& p : l.path) points += at(p.x(), p.y()) + " ";
    if (l.closed && !l.path.empty()) points += at(l.path.front().x(), l.path.front().y());
    line(points, colour, width, dash);
  }
  /// `between`: of a tool that is not pressed; `pressed`: null for that of each tool.
  void path(const ClassPath& p, const char* between, const char* pressed) {
    std::string points;
    double tool = 0;
    const auto end = [&] {
      if (points.find(' ') != std::string::npos)
        line(points,
             tool == 0 ? between
             : pressed ? pressed
                       : colour_of(Tool(int(tool))).colour,
             tool == 0 ? 0.8
             : pressed ? 3.2
                       : 2.2);
      points.clear();
    };
    for (size_t i = 0; i < p.x_mm.size(); ++i) {
      if (!std::isfinite(p.x_mm[i]) || !std::isfinite(p.y_mm[i]) || !(p.tool[i] >= 0 && p.tool[i] < 100)) {
        end();
        continue;
      }
      const std::string here = at(p.x_mm[i], p.y_mm[i]);
      if (p.tool[i] != tool) {
        if (!points.empty()) points += " " + here;
        end();
        tool = p.tool[i];
      }
      points += (points.empty() ? "" : " ") + here;
    }
    end();
  }
  void words(double x_px, double y_px, const std::string& what, const char* colour, double size, bool bold = false) {
    text += fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" font-family=\"sans-serif\" font-size=\"{:.0f}\"{} fill=\"{}\">{}</text>\n",
        x_px, y_px, size, bold ? " font-weight=\"bold\"" : "", colour, html::escape(what));
  }
};

void scale_bar(Canvas& c) {
  const double mm = (c.f.x1_mm - c.f.x0_mm) > 150 ? 50 : 10, y = c.height() - 10, x = kWide_px - 14;
  c.text += fmt::format("<path d=\"M{:.1f} {:.1f}h{:.1f}\" stroke=\"#333\" stroke-width=\"2\"/>\n", x - mm * c.scale, y,
                        mm * c.scale);
  c.words(x - mm * c.scale, y - 5, fmt::format("{:.0f} mm", mm), "#333", 13);
}

}  // namespace

DrawnFrame frame_of(const LessonPlan& plan, const std::vector<const ClassMember*>& all) {
  std::vector<double> x, y;
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
  const auto hold = [&](double px, double py) {
    x0 = std::min(x0, px), x1 = std::max(x1, px), y0 = std::min(y0, py), y1 = std::max(y1, py);
  };
  for (const PlannedAct& a : plan.acts)
    if (const auto line = drawn_line(a.command))
      for (const ChartPoint& p : line->path) hold(p.x(), p.y());
  for (const ClassMember* m : all) {
    for (const DrawnLine& l : cuts_of(*m))
      for (const ChartPoint& p : l.path) x.push_back(p.x()), y.push_back(p.y());
    for (size_t i = 0; i < m->also.path.x_mm.size(); ++i)
      if (std::isfinite(m->also.path.x_mm[i]) && std::isfinite(m->also.path.y_mm[i]))
        x.push_back(m->also.path.x_mm[i]), y.push_back(m->also.path.y_mm[i]);
  }
  if (!x.empty()) {
    std::sort(x.begin(), x.end()), std::sort(y.begin(), y.end());
    const size_t out = x.size() / 100;
    hold(x[out], y[out]), hold(x[x.size() - 1 - out], y[y.size() - 1 - out]);
  }
  if (x1 < x0) return {};
  constexpr double kLeast_mm = 40, kMost_mm = 400, kMargin_mm = 6;
  const auto fit = [&](double& lo, double& hi, double least) {
    const double middle = (lo + hi) / 2, half = std::clamp((hi - lo) / 2 + kMargin_mm, least / 2, kMost_mm / 2);
    lo = middle - half, hi = middle + half;
  };
  fit(x0, x1, kLeast_mm), fit(y0, y1, std::max(kLeast_mm, 0.6 * (x1 - x0)));
  fit(x0, x1, (y1 - y0) / 1.1 + 2 * kMargin_mm);
  return {x0, y0, x1, y1};
}

std::string path_svg(const DrawnFrame& frame, const LessonPlan& plan, const ClassMember& student,
                     const ClassMember* expert, const std::string& title) {
  Canvas c(frame);
  if (expert) {
    for (const DrawnLine& l : cuts_of(*expert)) c.drawn(l, kGrey, 3.2);
    c.path(expert->also.path, "#d5dadc", kGrey);
  }
  for (const PlannedAct& a : plan.acts)
    if (const auto line = drawn_line(a.command)) c.drawn(*line, kPlan, 1.2, "5 4");
  for (const DrawnLine& l : cuts_of(student)) c.drawn(l, colour_of(Tool::scalpel).colour, 2.2);
  c.path(student.also.path, kHand, nullptr);
  for (const LetteredPoint& p : plan.letters)
    c.words((p.at.x() - frame.x0_mm) * c.scale + 5, (frame.y1_mm - p.at.y()) * c.scale - 5, std::string(1, p.letter),
            kPlan, 16, true);
  const ClassMissed& missed = student.also.missed;
  for (size_t i = 0; i < missed.why.size(); ++i)
    if (std::isfinite(missed.x_mm[i]) && std::isfinite(missed.y_mm[i])) {
      const double x = (missed.x_mm[i] - frame.x0_mm) * c.scale, y = (frame.y1_mm - missed.y_mm[i]) * c.scale;
      c.text += fmt::format("<path d=\"M{:.1f} {:.1f}l10 10m0 -10l-10 10\" stroke=\"#b3261e\" stroke-width=\"2.2\"/>\n",
                            x - 5, y - 5);
    }
  scale_bar(c);
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "role=\"img\"><title>{2}</title><rect width=\"{0:.0f}\" height=\"{1:.0f}\" fill=\"#fff\"/>\n{3}</svg>\n",
      kWide_px, c.height(), html::escape(title), c.text);
}

std::string path_legend() {
  return english(
      "Blue: the tool on its way. Red: it cuts; green: undermines; violet: holds and carries; ochre: sews. Grey: "
      "the "
      "expert. Violet, dashed, with letters: the plan. Red crosses: presses that came to nothing. Skin is drawn as "
      "it lay before the operation, bone as the picture of the scene sees it.");
}

std::string step_times_svg(const std::vector<StepTimes>& rows, const std::string& description) {
  constexpr double kName_px = 130, kBar_px = 540, kRow_px = 24, kTop_px = 6;
  double most = 1;
  std::vector<std::string> names;
  for (const StepTimes& r : rows) {
    double sum = 0;
    for (const auto& [name, s] : r.parts) {
      sum += s;
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
    most = std::max(most, sum);
  }
  const auto fill = [&](const std::string& name) {
    const size_t k = size_t(std::find(names.begin(), names.end(), name) - names.begin());
    constexpr const char* colour[] = {"#0072b2", "#d55e00", "#009e73", "#b1568b", "#b98200", "#3a93c9"};
    return fmt::format("var(--s{},{})\" fill-opacity=\"{}", k % 6 + 1, colour[k % 6], k < 6 ? "1" : "0.5");
  };
  std::string s;
  double y = kTop_px;
  for (const StepTimes& r : rows) {
    s += fmt::format("<text x=\"0\" y=\"{:.0f}\" font-size=\"13\" fill=\"var(--ink,#000)\">{}</text>\n", y + 15,
                     html::escape(r.name));
    double x = kName_px, sum = 0;
    for (const auto& [name, t] : r.parts) {
      const double wide = kBar_px * t / most;
      sum += t;
      if (wide >= 0.3)
        s += fmt::format(
            "<rect x=\"{:.1f}\" y=\"{:.0f}\" width=\"{:.1f}\" height=\"17\" fill=\"{}\"><title>{}: {:.1f} s</title>"
            "</rect>\n",
            x, y + 2, wide, fill(name), html::escape(name), t);
      x += wide;
    }
    s += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" font-size=\"13\" fill=\"var(--soft,#555)\">{:.0f} s</text>\n",
                     x + 6, y + 15, sum);
    y += kRow_px;
  }
  y += 10;
  double x = 0;
  for (const std::string& n : names) {  // a legend, in lines of what fits
    const double wide = 22 + 7.2 * double(n.size());
    if (x + wide > kName_px + kBar_px + 60) x = 0, y += 20;
    s += fmt::format("<rect x=\"{:.0f}\" y=\"{:.0f}\" width=\"11\" height=\"11\" fill=\"{}\"/>\n", x, y, fill(n));
    s += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" font-size=\"12.5\" fill=\"var(--soft,#555)\">{}</text>\n", x + 15,
                     y + 10, html::escape(n));
    x += wide + 8;
  }
  return fmt::format(
      "<svg class=\"chart\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 760 {:.0f}\" role=\"img\" "
      "font-family=\"system-ui,sans-serif\"><title>{}</title>\n{}</svg>\n",
      y + 20, html::escape(description), s);
}

}  // namespace limberg
