#include "app/study/sewn_metric.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "sim/geometry/vec.h"
#include "sim/patient/anchors.h"

namespace limberg::study {

namespace {

// A stitch's end is a place of an edge, told by where both lie now: in single precision, and between its vertices an
// edge may bend within a strained cell.
constexpr double kOnEdge_mm = 0.6;
constexpr double kApart_mm = 0.5;    // the two ends of a stitch, along one edge
constexpr double kStraight_deg = 2;  // the body's grid turns an edge by less
constexpr double kSamePlace_mm = 0.5;

/// One edge between skin and cut wall, tissue on its left.
struct Edge {
  int32_t from = -1, to = -1, next = -1, loop = -1;
  double length_mm = 0, start_mm = 0;  // start: along its loop
  double tissue = 0;                   // the angle of tissue at its end, radians
};

struct Place {
  int32_t loop = -1;
  double at_mm = 0, off_mm = 0;  // along its loop; from where the stitch's end is now
  ChartPoint at{0, 0};
  Vec2 along = Vec2::UnitX();  // unit, the tissue on its left
};

/// Both ends of a stitch as it was asked for: beside the edges that it goes through, in their tissue.
using Given = std::pair<ChartPoint, ChartPoint>;

std::vector<Given> given(std::span<const Command> commands) {
  std::vector<Given> out;
  for (const Command& c : commands) {
    if (const auto* one = std::get_if<Suture>(&c)) out.push_back({one->a, one->b});
    if (const auto* row = std::get_if<SutureRow>(&c)) {
      const int n = int(row_stitches(row->a, row->b, row->spacing_mm));
      const std::vector<Vec2> a = resample(row->a, n), b = resample(row->b, n);
      for (size_t i = 0; i < a.size(); ++i) out.push_back({a[i], b[i]});
    }
  }
  return out;
}

/// How little a place of an edge can be the one that a stitch was given to, mm.
double unlike(const Place& p, const ChartPoint& given) {
  constexpr double kOtherBank_mm = 2;  // no stitch is given so far from its edge
  const Vec2 d = given - p.at;
  return p.off_mm + d.norm() + (p.along.x() * d.y() - p.along.y() * d.x() < 0 ? kOtherBank_mm : 0);
}

class Rim {
 public:
  explicit Rim(const Snapshot& s) : body_(*s.topology->body), v_(s.topology->view) {
    std::map<std::pair<int32_t, int32_t>, std::pair<int32_t, int>>
        skin;  // an edge's two ends: its triangle and corner there
    std::map<std::pair<int32_t, int>, int32_t> number;
    for (size_t t = 0; t < v_.tri.size(); ++t) {
      if (v_.kind[t] != FaceKind::skin) continue;
      for (int k = 0; k < 3; ++k) {
        const int32_t a = corner(int32_t(t), k), b = corner(int32_t(t), k + 1);
        skin[{a, b}] = {int32_t(t), k};
        if (!(v_.rim[t] >> k & 1)) continue;
        number[{int32_t(t), k}] = int32_t(edges.size());
        edges.push_back({a, b});
        edges.back().length_mm = (v_.X_mm[size_t(b)] - v_.X_mm[size_t(a)]).norm();
      }
    }
    // Round each edge's end, through the triangles of the skin, to the edge that leaves it.
    for (const auto& [where, i] : number) {
      auto [t, k] = where;
      for (size_t guard = 0; guard < v_.tri.size(); ++guard) {
        const Vec3 &at = X(t, k + 1), u = X(t, k) - at, w = X(t, k + 2) - at;
        edges[size_t(i)].tissue += std::atan2(u.cross(w).norm(), u.dot(w));
        if (const auto leaves = number.find({t, (k + 1) % 3}); leaves != number.end()) {
          edges[size_t(i)].next = leaves->second;
          break;
        }
        const auto beyond = skin.find({corner(t, k + 2), corner(t, k + 1)});
        if (beyond == skin.end()) break;  // where the body ends
        std::tie(t, k) = beyond->second;
      }
    }
    for (size_t i = 0; i < edges.size(); ++i) {
      if (edges[i].loop >= 0) continue;
      double at = 0;
      const auto loop = int32_t(length_mm.size());
      for (int32_t e = int32_t(i); e >= 0 && edges[size_t(e)].loop < 0; e = edges[size_t(e)].next) {
        edges[size_t(e)].loop = loop, edges[size_t(e)].start_mm = at;
        at += edges[size_t(e)].length_mm;
      }
      length_mm.push_back(at);
    }
  }

  /// Places of edges within reach of a place now, each the nearest of its surroundings.
  std::vector<Place> near(const Snapshot& s, const Vec3& now) const {
    std::vector<Place> all;
    for (const Edge& e : edges) {
      const Vec3 a = s.x_mm[size_t(e.from)].cast<double>(), d = s.x_mm[size_t(e.to)].cast<double>() - a;
      if ((now - a).norm() > d.norm() + kOnEdge_mm) continue;
      const double t = d.squaredNorm() > 0 ? std::clamp((now - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0,
                   off = (now - a - t * d).norm();
      // At its end it is at the next one's start.
      const ChartPoint from = chart(e.from), to = chart(e.to);
      if (off <= kOnEdge_mm)
        all.push_back({e.loop, t == 1 && e.next >= 0 ? edges[size_t(e.next)].start_mm : e.start_mm + t * e.length_mm,
                       off, (1 - t) * from + t * to, (to - from).normalized()});
    }
    std::sort(all.begin(), all.end(), [](const Place& p, const Place& q) { return p.off_mm < q.off_mm; });
    std::vector<Place> out;
    for (const Place& p : all)
      if (std::all_of(out.begin(), out.end(), [&](const Place& q) { return apart(p, q); })) out.push_back(p);
    return out;
  }
  bool apart(const Place& p, const Place& q) const {
    if (p.loop != q.loop) return true;
    const double d = std::abs(p.at_mm - q.at_mm);
    return std::min(d, length_mm[size_t(p.loop)] - d) > kApart_mm;
  }

  SewnGap::Turn turn_after(const Edge& e) const {
    const ChartPoint at = chart(e.to);
    const Vec2 out = (chart(edges[size_t(e.next)].to) - at).normalized();
    const double half = e.tissue / 2;
    return {
        at, e.tissue * kDeg,
        Vec2(std::cos(half) * out.x() - std::sin(half) * out.y(), std::sin(half) * out.x() + std::cos(half) * out.y())};
  }

  std::vector<Edge> edges;
  std::vector<double> length_mm;  // of each loop

 private:
  int32_t corner(int32_t t, int k) const { return v_.tri[size_t(t)][size_t(k % 3)]; }
  const Vec3& X(int32_t t, int k) const { return v_.X_mm[size_t(corner(t, k))]; }
  ChartPoint chart(int32_t vertex) const { return body_.to_chart(v_.X_mm[size_t(vertex)]); }
  const Body& body_;
  const SurfaceView& v_;
};

}  // namespace

SewnSkin sewn_skin(const Snapshot& s, std::span<const Command> commands) {
  SewnSkin out;
  const std::vector<Given> asked = given(commands);
  const Rim rim(s);
  struct End {
    Place at;
    size_t other = 0;
  };
  std::vector<End> ends;
  if (asked.size() != s.sutures.size()) {
    out.unpaired = int(s.sutures.size());
    return out;
  }
  for (size_t i = 0; i < s.sutures.size(); ++i) {
    const SutureState& t = s.sutures[i];
    const std::vector<Place> as = rim.near(s, t.a_mm.cast<double>()), bs = rim.near(s, t.b_mm.cast<double>());
    std::optional<std::pair<Place, Place>> best;
    double least = std::numeric_limits<double>::infinity();
    for (const Place& a : as)
      for (const Place& b : bs) {
        if (!rim.apart(a, b)) continue;
        if (const double u = unlike(a, asked[i].first) + unlike(b, asked[i].second); u < least)
          least = u, best = {a, b};
      }
    if (!best) {
      ++out.unpaired;
      continue;
    }
    ends.push_back({best->first, ends.size() + 1});
    ends.push_back({best->second, ends.size() - 1});
  }
  // The next end along the same edge, and what lies between.
  std::vector<std::vector<size_t>> of_loop(rim.length_mm.size());
  for (size_t i = 0; i < ends.size(); ++i) of_loop[size_t(ends[i].at.loop)].push_back(i);
  std::vector<size_t> next(ends.size());
  for (auto& of : of_loop) {
    if (of.empty()) continue;
    // Of two stitches in one place the one that reaches farther ahead along this edge comes first: else they would
    // cross. One to another edge lies where the next stitch to that edge leaves.
    const auto reach = [&](size_t i) {
      const Place &at = ends[i].at, &to = ends[ends[i].other].at;
      const double whole = rim.length_mm[size_t(at.loop)];
      const auto ahead = [&](double s_mm) { return s_mm > at.at_mm ? s_mm : s_mm + whole; };
      if (to.loop == at.loop) return std::pair(ahead(to.at_mm), 0.0);
      double next_there = at.at_mm + whole;
      for (const size_t j : of)
        if (ends[ends[j].other].at.loop == to.loop) next_there = std::min(next_there, ahead(ends[j].at.at_mm));
      return std::pair(next_there, to.at_mm);
    };
    std::sort(of.begin(), of.end(), [&](size_t a, size_t b) {
      return ends[a].at.at_mm != ends[b].at.at_mm ? ends[a].at.at_mm < ends[b].at.at_mm : reach(a) > reach(b);
    });
    for (size_t k = 0; k < of.size(); ++k) next[of[k]] = of[(k + 1) % of.size()];
  }
  std::vector<uint8_t> walked(ends.size(), 0);
  for (size_t first = 0; first < ends.size(); ++first) {
    if (walked[first]) continue;
    SewnGap g;
    g.charge_deg = 360;
    std::vector<double> bank;
    for (size_t i = first; !walked[i]; i = ends[next[i]].other) {
      walked[i] = 1;
      const Place &from = ends[i].at, &to = ends[next[i]].at;
      const double whole = rim.length_mm[size_t(from.loop)];
      const bool around = next[i] == i || to.at_mm < from.at_mm;  // past the loop's start
      bank.push_back(to.at_mm - from.at_mm + (around ? whole : 0));
      ++g.stitches;
      g.charge_deg -= 180;
      for (const Edge& e : rim.edges) {
        if (e.loop != from.loop || e.next < 0) continue;
        // A vertex under a stitch belongs to the way that ends there.
        const double at = rim.edges[size_t(e.next)].start_mm;
        const bool after = at > from.at_mm, before = at <= to.at_mm;
        if (around ? !(after || before) : !(after && before)) continue;
        g.charge_deg += 180 - e.tissue * kDeg;
        if (std::abs(180 - e.tissue * kDeg) > kStraight_deg) g.turns.push_back(rim.turn_after(e));
      }
    }
    if (bank.size() == 2) g.unequal_mm = std::abs(bank[0] - bank[1]);
    out.gaps.push_back(std::move(g));
  }
  return out;
}

double SewnSkin::sum_deg() const {
  double sum = 0;
  for (const SewnGap& g : gaps) sum += g.charge_deg;
  return sum;
}

double SewnSkin::stray_deg() const {
  double most = 0;
  for (const SewnGap& g : gaps)
    if (g.turns.empty()) most = std::max(most, std::abs(g.charge_deg));
  return most;
}

std::optional<double> SewnSkin::charge_deg(const Figure& f, const std::vector<Corner>& corners) const {
  std::set<size_t> holding;
  for (const Corner& c : corners) {
    std::optional<size_t> best;
    double most = 0;
    for (size_t g = 0; g < gaps.size(); ++g)
      for (const SewnGap::Turn& t : gaps[g].turns)
        if ((t.at - place(f, c)).norm() < kSamePlace_mm && t.inward.dot(tissue_bisector(f, c)) > 0.7 &&
            std::abs(180 - t.tissue_deg) > most)
          best = g, most = std::abs(180 - t.tissue_deg);
    if (!best) return std::nullopt;
    holding.insert(*best);
  }
  double sum = 0;
  for (const size_t g : holding) sum += gaps[g].charge_deg;
  return sum;
}

}  // namespace limberg::study
