#include "sim/commands/procedures/figure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "sim/base/elementary.h"
#include "sim/base/union_find.h"

namespace limberg {
namespace {

const std::vector<Vec2>& wound(const Figure& f, const Corner& c) { return f.wounds.at(size_t(c.wound)); }
int corners(const Figure& f, const Corner& c) { return int(wound(f, c).size()); }

Vec2 edge_from(const Figure& f, const Corner& c) {
  const auto& w = wound(f, c);
  return (w[size_t((c.at + 1) % int(w.size()))] - w.at(size_t(c.at))).normalized();
}
Vec2 edge_back(const Figure& f, const Corner& c) {
  const auto& w = wound(f, c);
  return (w[size_t((c.at + int(w.size()) - 1) % int(w.size()))] - w.at(size_t(c.at))).normalized();
}

// The corners of a stretch in the order walked.
std::vector<Corner> stretch(const Figure& f, Corner from, const Corner& to, bool forward) {
  const int n = corners(f, from);
  std::vector<Corner> out{from};
  while (from.at != to.at) {
    from.at = (from.at + (forward ? 1 : n - 1)) % n;
    out.push_back(from);
  }
  return out;
}

// Corners that are sewn together, and straight bank that meets them.
class Meetings {
 public:
  explicit Meetings(const Figure& f) : f_(f) {
    for (int w = 0; w < int(f.wounds.size()); ++w)
      for (int i = 0; i < int(f.wounds[size_t(w)].size()); ++i) number_[{w, i}] = int(number_.size());
    met_.reset(number_.size());
    straight_.resize(number_.size());
    for (const Seam& s : f.seams) sew(s);
  }

  std::vector<Charge> charges() {
    std::map<int, Charge> found;
    for (const auto& [corner, i] : number_) {
      Charge& c = found.try_emplace(met_.find(i), Charge{360, {}, {}}).first->second;
      const Vec2 ahead = edge_from(f_, corner);
      c.q_deg -= tissue_deg(f_, corner);
      c.meeting.push_back(place(f_, corner));
      c.sector.push_back({elementary::atan2(ahead.y(), ahead.x()) * kDeg, tissue_deg(f_, corner)});
      for (const Straight& s : straight_[size_t(i)])
        c.q_deg -= 180, c.meeting.push_back(s.at), c.sector.push_back({s.from_deg, 180});
    }
    std::vector<Charge> out;
    for (auto& [root, c] : found)
      if (std::abs(c.q_deg) > 1e-6) out.push_back(std::move(c));
    return out;
  }

 private:
  void join(const Corner& a, const Corner& b) { met_.unite(number_.at(a), number_.at(b)); }
  struct Straight {
    Vec2 at;
    double from_deg;  // along the bank, the tissue on its left
  };
  struct Side {
    bool forward;
    std::vector<Corner> corner;
    std::vector<double> t;  // 0..1 of the arc length
  };
  Side side(const Corner& from, const Corner& to, bool forward) const {
    Side s{forward, stretch(f_, from, to, forward), {0}};
    for (size_t i = 1; i < s.corner.size(); ++i)
      s.t.push_back(s.t.back() + (place(f_, s.corner[i]) - place(f_, s.corner[i - 1])).norm());
    for (double& t : s.t) t /= s.t.back();
    return s;
  }
  void sew(const Seam& seam) {
    const Side a = side(seam.a_from, seam.a_to, true), b = side(seam.b_from, seam.b_to, false);
    meet(a, b);
    meet(b, a);
  }
  // Every inner corner of `a` meets a corner of `b` at the same arc length, or straight bank.
  void meet(const Side& a, const Side& b) {
    join(a.corner.front(), b.corner.front());
    join(a.corner.back(), b.corner.back());
    for (size_t i = 1; i + 1 < a.corner.size(); ++i) {
      size_t k = 1;
      while (k + 1 < b.t.size() && b.t[k] < a.t[i] - 1e-9) ++k;
      if (std::abs(b.t[k] - a.t[i]) <= 1e-9) {
        join(a.corner[i], b.corner[k]);
      } else {
        const double u = (a.t[i] - b.t[k - 1]) / (b.t[k] - b.t[k - 1]);
        const Vec2 p = place(f_, b.corner[k - 1]), q = place(f_, b.corner[k]),
                   ahead = b.forward ? Vec2(q - p) : Vec2(p - q);
        straight_[size_t(number_.at(a.corner[i]))].push_back(
            {(1 - u) * p + u * q, elementary::atan2(ahead.y(), ahead.x()) * kDeg});
      }
    }
  }

  const Figure& f_;
  std::map<Corner, int> number_;
  UnionFind met_;
  std::vector<std::vector<Straight>> straight_;
};

}  // namespace

const Vec2& place(const Figure& f, const Corner& c) { return wound(f, c).at(size_t(c.at)); }

double tissue_deg(const Figure& f, const Corner& c) {
  const Vec2 out = edge_from(f, c), back = edge_back(f, c);
  // from the edge ahead to that behind
  double a = elementary::atan2(out.x() * back.y() - out.y() * back.x(), out.dot(back)) * kDeg;
  if (std::abs(a) < 1e-9) return 360;  // the end of a slit
  return a < 0 ? a + 360 : a;
}

Vec2 tissue_bisector(const Figure& f, const Corner& c) {
  const Vec2 out = edge_from(f, c);
  const double half = tissue_deg(f, c) / 2 / kDeg;
  return {elementary::cos(half) * out.x() - elementary::sin(half) * out.y(),
          elementary::sin(half) * out.x() + elementary::cos(half) * out.y()};
}

std::vector<Vec2> bank(const Figure& f, const Corner& from, const Corner& to, bool forward) {
  std::vector<Vec2> out;
  for (const Corner& c : stretch(f, from, to, forward)) out.push_back(place(f, c));
  return out;
}

Vec2 beside(const std::vector<Vec2>& path, double s_mm, double inset_mm) {
  for (size_t i = 1;; ++i) {
    const Vec2 d = path[i] - path[i - 1];
    const double l = d.norm();
    if (s_mm > l && i + 1 < path.size()) {
      s_mm -= l;
      continue;
    }
    return path[i - 1] + d / l * s_mm + inset_mm * Vec2(-d.y(), d.x()) / l;
  }
}

double tissue_mm(const Figure& f, const Vec2& at, const Vec2& direction) {
  constexpr double kHere_mm = 1e-6;  // its own edge, and the other bank of a slit
  const auto cross = [](const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); };
  double least = std::numeric_limits<double>::infinity();
  for (const auto& w : f.wounds)
    for (size_t i = 0; i < w.size(); ++i) {
      const Vec2 from = w[i] - at, e = w[(i + 1) % w.size()] - w[i];  // at + s direction = w[i] + t e
      const double det = cross(direction, e);
      if (det == 0) continue;
      const double s = cross(from, e) / det, t = cross(from, direction) / det;
      if (s > kHere_mm && t >= 0 && t <= 1) least = std::min(least, s);
    }
  return least;
}

std::vector<Charge> charges(const Figure& f) { return Meetings(f).charges(); }

std::string why_open(const Figure& f) {
  std::vector<std::vector<int>> sewn;
  for (const auto& w : f.wounds) sewn.emplace_back(w.size(), 0);
  const auto exists = [&](const Corner& c) {
    return c.wound >= 0 && c.wound < int(f.wounds.size()) && c.at >= 0 && c.at < int(f.wounds[size_t(c.wound)].size());
  };
  for (const Seam& s : f.seams) {
    for (const Corner& c : {s.a_from, s.a_to, s.b_from, s.b_to})
      if (!exists(c))
        return "a seam names corner " + std::to_string(c.at) + " of wound " + std::to_string(c.wound) +
               ", which is not there";
    if (s.a_from.wound != s.a_to.wound || s.b_from.wound != s.b_to.wound)
      return "a bank runs from one wound to another";
    for (const Corner& c : stretch(f, s.a_from, s.a_to, true))
      if (c != s.a_to) ++sewn[size_t(c.wound)][size_t(c.at)];
    for (const Corner& c : stretch(f, s.b_from, s.b_to, false))
      if (c != s.b_from) ++sewn[size_t(c.wound)][size_t(c.at)];
  }
  for (size_t w = 0; w < sewn.size(); ++w)
    for (size_t i = 0; i < sewn[w].size(); ++i)
      if (sewn[w][i] != 1)
        return "the edge after corner " + std::to_string(i) + " of wound " + std::to_string(w) + " is sewn " +
               std::to_string(sewn[w][i]) + " times";
  return {};
}

}  // namespace limberg
