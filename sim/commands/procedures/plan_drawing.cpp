#include "sim/commands/procedures/plan_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/base/xml_text.h"

namespace limberg {
namespace {

constexpr double kCorner_deg = 25;
constexpr const char* kInk[] = {"#1b6ca8", "#c2571a", "#2e7d32", "#8e3a9d", "#a3262e",
                                "#00838f", "#6d5c00", "#3949ab", "#b23b7e", "#455a64"};

class Paper {
 public:
  explicit Paper(const Figure& f) {
    lo_ = hi_ = f.wounds[0][0];
    for (const auto& w : f.wounds)
      for (const Vec2& p : w) lo_ = lo_.cwiseMin(p), hi_ = hi_.cwiseMax(p);
    const double edge = 0.14 * (hi_ - lo_).maxCoeff();
    lo_.array() -= edge, hi_.array() += edge;
    px_ = 640 / (hi_.x() - lo_.x());
  }
  double width() const { return 640; }
  double height() const { return 30 + px_ * (hi_.y() - lo_.y()) + kLegend_px; }
  static constexpr double kLegend_px = 62;
  double px() const { return px_; }
  Vec2 at(const Vec2& p) const { return {px_ * (p.x() - lo_.x()), 30 + px_ * (hi_.y() - p.y())}; }

 private:
  Vec2 lo_, hi_;
  double px_;
};

std::string points(const Paper& paper, const std::vector<Vec2>& path) {
  std::string s;
  for (const Vec2& p : path) {
    const Vec2 q = paper.at(p);
    s += fmt::format("{:.1f},{:.1f} ", q.x(), q.y());
  }
  return s;
}

// The bank a little inside its tissue, so that both banks of a slit are seen.
std::vector<Vec2> inside(const std::vector<Vec2>& bank, double by) {
  std::vector<Vec2> out;
  const double l = path_length(bank), step = std::max(l / 24, 1e-9);
  for (double s = std::min(1.2 * std::abs(by), 0.2 * l); s <= l - std::min(1.2 * std::abs(by), 0.2 * l) + 1e-9;
       s += step)
    out.push_back(beside(bank, s, by));
  return out;
}

// Letters on their own ground, so that a line beneath does not cross them out.
std::string text(const Vec2& px, const char* ink, const std::string& words, int size) {
  const std::string t = fmt::format(
      "<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"{}\" font-size=\"{}\" text-anchor=\"middle\" stroke=\"#fbeee6\" "
      "stroke-width=\"4\" paint-order=\"stroke\">",
      px.x(), px.y() + size / 3.0, ink, size);
  return t + words + "</text>\n";
}

constexpr const char *kStands = "#b00", *kTight = "#00b";

std::string mark(const Vec2& q, bool stands) {
  if (stands)
    return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"7\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n",
                       q.x(), q.y(), kStands);
  return fmt::format(
      "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"12\" height=\"12\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n",
      q.x() - 6, q.y() - 6, kTight);
}

/// Where a label goes: from its mark outwards, past the labels that are there, within the paper.
class Labels {
 public:
  Labels(const Paper& paper, const Vec2& centre) : width_(paper.width()), centre_(paper.at(centre)) {}
  Vec2 place(const Vec2& q) {
    constexpr double kFirst = 24, kStep = 8, kWide = 50, kHigh = 18, kEdge = 30;
    const Vec2 out = (q - centre_).norm() > 1e-9 ? Vec2((q - centre_).normalized()) : Vec2(0, -1);
    Vec2 at = q;
    const auto taken = [&] {
      return std::any_of(taken_.begin(), taken_.end(), [&](const Vec2& t) {
        return std::abs(t.x() - at.x()) < kWide && std::abs(t.y() - at.y()) < kHigh;
      });
    };
    for (int k = 0; k < 12; ++k) {
      at = q + (kFirst + kStep * k) * out;
      at.x() = std::clamp(at.x(), kEdge, width_ - kEdge);
      if (!taken()) break;
    }
    // At the paper's side there is no farther out: above or below what is there.
    const Vec2 side = at;
    for (int k = 1; k < 12 && taken(); ++k) at = side + Vec2(0, (k % 2 ? kHigh : -kHigh) * ((k + 1) / 2));
    taken_.push_back(at);
    return at;
  }

 private:
  double width_;
  Vec2 centre_;
  std::vector<Vec2> taken_;
};

}  // namespace

std::string plan_svg(const Figure& f, const std::string& title) {
  const Paper paper(f);
  std::string s = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0f} {:.0f}\" font-family=\"sans-serif\">\n<rect "
      "width=\"100%\" height=\"100%\" fill=\"#fbeee6\"/>\n",
      paper.width(), paper.height());
  s += "<text x=\"12\" y=\"22\" font-size=\"16\">" + xml_text(title) + "</text>\n";
  for (const auto& o : f.excisions) s += "<polygon points=\"" + points(paper, o) + "\" fill=\"#e8a08c\"/>\n";
  for (const auto& w : f.wounds) {
    auto closed = w;
    closed.push_back(w[0]);
    s += "<polyline points=\"" + points(paper, closed) + "\" fill=\"none\" stroke=\"#333\" stroke-width=\"1.2\"/>\n";
  }
  const double by = 7 / paper.px();
  for (size_t i = 0; i < f.seams.size(); ++i) {
    const char* ink = kInk[i % std::size(kInk)];
    const std::string letter(1, char('a' + i % 26));
    const auto draw = [&](const std::vector<Vec2>& edge, int side) {
      const auto path = inside(edge, side * by);
      if (path.empty()) return;
      s += "<polyline points=\"" + points(paper, path) + "\" fill=\"none\" stroke=\"" + ink +
           "\" stroke-width=\"3\"/>\n";
      s += text(paper.at(beside(edge, path_length(edge) / 2, side * (by + 11 / paper.px()))), ink, letter,
                14);  // in the tissue that it names
    };
    draw(bank(f, f.seams[i].a_from, f.seams[i].a_to, true), 1);
    draw(bank(f, f.seams[i].b_from, f.seams[i].b_to, false), -1);
  }
  Vec2 centre = Vec2::Zero();
  for (const Vec2& p : f.wounds[0]) centre += p / double(f.wounds[0].size());
  Labels labels(paper, centre);
  for (const Charge& c : charges(f)) {
    if (std::abs(c.q_deg) < kCorner_deg) continue;  // spread along a curve: no place of its own
    const bool stands = c.q_deg > 0;
    for (const Vec2& p : c.meeting) s += mark(paper.at(p), stands);
    s += text(labels.place(paper.at(c.meeting.front())), stands ? kStands : kTight,
              fmt::format("{:+.0f}&#176;", c.q_deg), 15);
  }
  const double y = paper.height() - Paper::kLegend_px + 14;
  const auto line = [&](double at, const char* words) {
    s += fmt::format("<text x=\"34\" y=\"{:.1f}\" font-size=\"13\" fill=\"#333\">{}</text>\n", at + 4.5, words);
  };
  s += mark({20, y}, true), line(y, "+ too much skin meets here: it stands up as a dog-ear");
  s += mark({20, y + 18}, false),
      line(y + 18, "&#8722; too little: it is drawn tight. Marks without a number come to lie at one that has it");
  line(y + 36, "Edges of one letter and colour are sewn to each other");
  return s + "</svg>\n";
}

}  // namespace limberg
