#include "sim/tools/procedures/plan_drawing.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace limberg {
namespace {

constexpr double kCorner_deg = 25;
constexpr const char* kInk[] = {"#1b6ca8", "#c2571a", "#2e7d32", "#8e3a9d", "#a3262e", "#00838f", "#6d5c00", "#3949ab", "#b23b7e", "#455a64"};

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
  double height() const { return px_ * (hi_.y() - lo_.y()) + 30; }
  double px() const { return px_; }
  Vec2 at(const Vec2& p) const { return {px_ * (p.x() - lo_.x()), 30 + px_ * (hi_.y() - p.y())}; }

 private:
  Vec2 lo_, hi_;
  double px_;
};

std::string points(const Paper& paper, const std::vector<Vec2>& path) {
  std::string s;
  char t[48];
  for (const Vec2& p : path) {
    const Vec2 q = paper.at(p);
    std::snprintf(t, sizeof t, "%.1f,%.1f ", q.x(), q.y());
    s += t;
  }
  return s;
}

// The bank a little inside its tissue, so that both banks of a slit are seen.
std::vector<Vec2> inside(const std::vector<Vec2>& bank, double by) {
  std::vector<Vec2> out;
  const double l = length_mm(bank), step = std::max(l / 24, 1e-9);
  for (double s = std::min(1.2 * std::abs(by), 0.2 * l); s <= l - std::min(1.2 * std::abs(by), 0.2 * l) + 1e-9; s += step) out.push_back(beside(bank, s, by));
  return out;
}

std::string text(const Paper& paper, const Vec2& at, const char* ink, const std::string& words, int size) {
  const Vec2 q = paper.at(at);
  char t[200];
  std::snprintf(t, sizeof t, "<text x=\"%.1f\" y=\"%.1f\" fill=\"%s\" font-size=\"%d\" text-anchor=\"middle\">", q.x(), q.y() + size / 3.0, ink, size);
  return t + words + "</text>\n";
}

}  // namespace

std::string plan_svg(const Figure& f, const std::string& title) {
  const Paper paper(f);
  char t[400];
  std::snprintf(t, sizeof t,
                "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" font-family=\"sans-serif\">\n<rect width=\"100%%\" height=\"100%%\" fill=\"#fbeee6\"/>\n",
                paper.width(), paper.height());
  std::string s = t;
  s += "<text x=\"12\" y=\"22\" font-size=\"16\">" + title + "</text>\n";
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
      s += "<polyline points=\"" + points(paper, path) + "\" fill=\"none\" stroke=\"" + ink + "\" stroke-width=\"3\"/>\n";
      s += text(paper, beside(edge, length_mm(edge) / 2, side * (by + 11 / paper.px())), ink, letter, 14);  // in the tissue that it names
    };
    draw(bank(f, f.seams[i].a_from, f.seams[i].a_to, true), 1);
    draw(bank(f, f.seams[i].b_from, f.seams[i].b_to, false), -1);
  }
  Vec2 centre = Vec2::Zero();
  for (const Vec2& p : f.wounds[0]) centre += p / double(f.wounds[0].size());
  for (const Charge& c : charges(f)) {
    if (std::abs(c.q_deg) < kCorner_deg) continue;  // spread along a curve: no place of its own
    std::snprintf(t, sizeof t, "%+.0f&#176;", c.q_deg);
    for (const Vec2& p : c.meeting) {
      const Vec2 q = paper.at(p);
      char mark[200];
      if (c.q_deg > 0)
        std::snprintf(mark, sizeof mark, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"7\" fill=\"none\" stroke=\"#b00\" stroke-width=\"2\"/>\n", q.x(), q.y());
      else
        std::snprintf(mark, sizeof mark, "<rect x=\"%.1f\" y=\"%.1f\" width=\"12\" height=\"12\" fill=\"none\" stroke=\"#00b\" stroke-width=\"2\"/>\n", q.x() - 6, q.y() - 6);
      s += mark;
    }
    const Vec2 out = c.meeting.front() - centre;  // outside the plan, where no line is
    s += text(paper, c.meeting.front() + 22 / paper.px() * (out.norm() > 1e-9 ? Vec2(out.normalized()) : Vec2(0, 1)), c.q_deg > 0 ? "#b00" : "#00b", t, 15);
  }
  return s + "</svg>\n";
}

}  // namespace limberg
