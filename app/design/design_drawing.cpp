#include "app/design/design_drawing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/text.h"
#include "sim/base/xml_text.h"

namespace limberg {
namespace {

constexpr double kCard = 236, kPlan = 200, kText = 102, kDrawingGap = 12, kHead = 58;
constexpr size_t kNameLetters = 16;  // of a landmark, half a card wide
constexpr const char *kForce = "#a3262e", *kEar = "#c98a1b", *kLandmark = "#1b6ca8";

/// As long as half a card takes, without half a letter at its end.
std::string short_name(std::string name) {
  if (name.size() <= kNameLetters) return name;
  size_t end = kNameLetters;
  while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xC0) == 0x80) --end;
  return name.substr(0, end);
}

/// What a design draws on the skin, as its commands say.
struct Lines {
  std::vector<std::vector<ChartPoint>> excised, cut;
};
Lines lines_of(const Design& d) {
  Lines l;
  for (const Command& c : d.commands) {
    if (const auto* e = std::get_if<Excise>(&c)) l.excised.push_back(e->outline);
    if (const auto* i = std::get_if<Incise>(&c)) l.cut.push_back(i->path);
  }
  return l;
}

class Card {
 public:
  Card(const Vec2& corner, const Vec2& centre, double half_mm)
      : corner_(corner), centre_(centre), px_(kPlan / (2 * half_mm)) {}
  Vec2 at(const ChartPoint& p) const {
    return corner_ + Vec2(kCard / 2 + px_ * (p.x() - centre_.x()), kPlan / 2 - px_ * (p.y() - centre_.y()));
  }
  std::string path(const std::vector<ChartPoint>& points, bool closed, const char* style) const {
    std::string s = "<path d=\"";
    for (size_t i = 0; i < points.size(); ++i) {
      const Vec2 q = at(points[i]);
      s += text("%c%.1f,%.1f", i ? 'L' : 'M', q.x(), q.y());
    }
    return s + (closed ? "Z\" " : "\" ") + style + "/>\n";
  }

 private:
  Vec2 corner_, centre_;
  double px_;
};

}  // namespace

std::string ranking_svg(const std::vector<Design>& found, const DesignTask& task, double lines_deg, size_t most) {
  std::vector<const Design*> shown;
  for (const Design& d : found)
    if (d.dropped.empty() && shown.size() < most) shown.push_back(&d);
  if (shown.empty()) return {};
  Vec2 lo = Vec2::Constant(1e300), hi = -lo;
  double dearest = 1e-9;
  const auto stretch = [&](const std::vector<ChartPoint>& l) {
    for (const ChartPoint& p : l) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
  };
  stretch(task.defect);
  for (const Landmark& l : task.spare) stretch({l.at});
  for (const Design* d : shown) {
    const Lines l = lines_of(*d);
    for (const auto* lists : {&l.excised, &l.cut}) std::for_each(lists->begin(), lists->end(), stretch);
    dearest = std::max(dearest, d->cost);
  }
  const Vec2 centre = 0.5 * (lo + hi);
  const double half = 0.5 * (hi - lo).maxCoeff() + 3;

  const size_t columns = std::min<size_t>(4, shown.size()), rows = (shown.size() + columns - 1) / columns;
  const double width = double(columns) * (kCard + kDrawingGap) + kDrawingGap,
               height = kHead + double(rows) * (kPlan + kText + kDrawingGap);
  std::string s = text(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" width=\"%.0f\" height=\"%.0f\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n",
      width, height, width, height);
  s += "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n<text x=\"12\" y=\"22\" font-size=\"16\">Designs, best "
       "first</text>\n";
  double x = 12;
  for (const auto& [ink, words] : {std::pair(kForce, "largest stitch / 2.45 N"), std::pair(kEar, "dog-ear / 4 mm"),
                                   std::pair(kLandmark, "landmark / 2 mm")}) {
    s += text(
        "<rect x=\"%.0f\" y=\"34\" width=\"12\" height=\"12\" fill=\"%s\"/><text x=\"%.0f\" y=\"44\" "
        "fill=\"#333\">%s</text>\n",
        x, ink, x + 17, words);
    x += 42 + 6.6 * double(std::string(words).size());
  }
  s += "<defs><clipPath id=\"plan\"><rect width=\"" + text("%.0f\" height=\"%.0f", kCard, kPlan) +
       "\"/></clipPath></defs>\n";
  for (size_t i = 0; i < shown.size(); ++i) {
    const Design& d = *shown[i];
    const Vec2 corner(kDrawingGap + double(i % columns) * (kCard + kDrawingGap),
                      kHead + double(i / columns) * (kPlan + kText + kDrawingGap));
    const Card card(corner, centre, half);
    s += text("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.0f\" height=\"%.0f\" fill=\"#fbeee6\"/>\n", corner.x(), corner.y(),
              kCard, kPlan);
    s += text("<g clip-path=\"url(#plan)\" transform=\"translate(%.1f,%.1f)\" stroke=\"#e6cfc2\">", corner.x(),
              corner.y());
    for (int k = -20; k <= 20; ++k)
      s += text("<line x1=\"-300\" x2=\"300\" y1=\"%d\" y2=\"%d\" transform=\"translate(%.0f,%.0f) rotate(%.2f)\"/>",
                14 * k, 14 * k, kCard / 2, kPlan / 2, -lines_deg);
    s += "</g>\n";
    const Lines l = lines_of(d);
    for (const auto& e : l.excised) s += card.path(e, true, "fill=\"#e8a08c\" stroke=\"#333\"");
    for (const auto& c : l.cut) s += card.path(c, false, "fill=\"none\" stroke=\"#333\" stroke-width=\"1.6\"");
    s += card.path(task.defect, true, "fill=\"none\" stroke=\"#7a1020\" stroke-width=\"1.4\" stroke-dasharray=\"4 3\"");
    for (const Landmark& m : task.spare) {
      const Vec2 q = card.at(m.at);
      const bool right = q.x() - corner.x() > kCard / 2;  // its name stands towards the middle of the card
      s += text("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.5\" fill=\"%s\"/><text x=\"%.1f\" y=\"%.1f\" fill=\"%s\"%s>",
                q.x(), q.y(), kLandmark, q.x() + (right ? -6 : 6), q.y() + 4, kLandmark,
                right ? " text-anchor=\"end\"" : "") +
           xml_text(short_name(m.name)) + "</text>\n";
    }
    // A line for each: none is wider than its card.
    const std::string size = d.plan.values.empty() ? "" : text("%.3g mm, ", d.plan.values[0].second);
    s += text("<text x=\"%.1f\" y=\"%.1f\" font-size=\"14\">%zu. %s</text>\n", corner.x() + 2, corner.y() + kPlan + 17,
              i + 1, d.plan.procedure.c_str());
    s += text("<text x=\"%.1f\" y=\"%.1f\" fill=\"#555\">%sturned %.3g&#176;%s</text>\n", corner.x() + 2,
              corner.y() + kPlan + 33, size.c_str(), d.plan.turn_deg, d.plan.mirrored ? ", mirrored" : "");
    s += text("<text x=\"%.1f\" y=\"%.1f\" fill=\"#555\">%.3g mm cells%s</text>\n", corner.x() + 2,
              corner.y() + kPlan + 49, d.cell_mm, d.fine ? "" : ", first pass");
    const std::array<std::pair<double, const char*>, 3> parts{
        {{d.force_cost, kForce}, {d.ear_cost, kEar}, {d.landmark_cost, kLandmark}}};
    double from = corner.x() + 2;
    for (const auto& [cost, ink] : parts) {
      const double w = (kCard - 56) * cost / dearest;
      s += text("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"12\" fill=\"%s\"/>", from, corner.y() + kPlan + 57,
                w, ink);
      from += w;
    }
    s += text("<text x=\"%.1f\" y=\"%.1f\">%.2f</text>\n", from + 5, corner.y() + kPlan + 67, d.cost);
    s += text("<text x=\"%.1f\" y=\"%.1f\" fill=\"#555\">%.2f N, ear %.1f, landmark %.1f mm</text>\n", corner.x() + 2,
              corner.y() + kPlan + 86, d.force_N, d.dog_ear_mm, d.landmark_mm);
  }
  return s + "</svg>\n";
}

}  // namespace limberg
