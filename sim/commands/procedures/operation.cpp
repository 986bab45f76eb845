#include "sim/commands/procedures/operation.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/commands/flap_exchange.h"
#include "sim/commands/procedures/shapes.h"

namespace limberg {
namespace {

// The hull of discs of `margin` around all corners, counter-clockwise (Andrew 1979).
std::vector<Vec2> pocket(const Figure& f, double margin) {
  std::vector<Vec2> p;
  for (const auto& w : f.wounds)
    for (const Vec2& c : w)
      for (int i = 0; i < 24; ++i) p.push_back(c + margin * figures::along(15 * i));
  std::sort(p.begin(), p.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  std::vector<Vec2> hull;
  const auto add = [&](const Vec2& q, size_t floor) {
    while (hull.size() >= floor + 2) {
      const Vec2 a = hull.back() - hull[hull.size() - 2], b = q - hull.back();
      if (a.x() * b.y() - a.y() * b.x() > 1e-9) break;
      hull.pop_back();
    }
    hull.push_back(q);
  };
  for (const Vec2& q : p) add(q, 0);
  const size_t lower = hull.size() - 1;
  for (size_t i = p.size() - 1; i-- > 0;) add(p[i], lower);
  hull.pop_back();
  std::vector<Vec2> out;  // corners less than 2 mm apart say nothing
  for (const Vec2& q : hull)
    if (out.empty() || ((q - out.back()).norm() > 2 && (q - out.front()).norm() > 2)) out.push_back(q);
  return out;
}

class Writer {
 public:
  Writer(const Figure& f, const OnSkin& on, const OperationPlan& plan) : f_(f), on_(on), plan_(plan) {}
  std::vector<Command> commands;

  void cuts() {
    for (const auto& o : f_.excisions) commands.push_back(Excise{cut(o, true), plan_.depth_mm});
    if (!f_.excisions.empty()) stage("defect", 1);
    for (const auto& p : f_.incisions) commands.push_back(Incise{cut(p, false), f_.deeper * plan_.depth_mm, 90});
    if (!f_.incisions.empty()) stage("incised", 1);
    if (f_.undermined && plan_.undermine_margin_mm > 0) {
      commands.push_back(Undermine{path(pocket(f_, plan_.undermine_margin_mm)), plan_.depth_mm});
      stage("undermined", 1);
    }
  }

  // Held 3 mm inside its tip, lifted half way, set down inside the corner that it goes to.
  void carry() {
    if (f_.exchanged && plan_.lift_mm > 0) return exchange();
    std::vector<Vec2> from, to;
    for (const Carry& c : f_.carries) {
      from.push_back(place(f_, c.tip) + kGrip_mm * tissue_bisector(f_, c.tip));
      to.push_back(place(f_, c.to) - kGrip_mm * tissue_bisector(f_, c.to));
    }
    for (size_t i = 0; i < from.size(); ++i) commands.push_back(SetHook{int(i) + 1, chart(from[i])});
    for (size_t i = 0; i < from.size(); ++i) move(int(i) + 1, 0.5 * (from[i] + to[i]), plan_.lift_mm);
    if (!from.empty()) stage("raised", 0.5);
    keys(true);
    for (size_t i = 0; i < to.size(); ++i) move(int(i) + 1, to[i], 2);
    if (!from.empty()) stage("transposed", 0.5);
    keys(false);
    if (!from.empty()) commands.push_back(Wait{1});
    for (size_t i = 0; i < from.size(); ++i) commands.push_back(ReleaseHook{int(i) + 1});
    if (!f_.keys.empty()) stage("set", 1);
  }

  void exchange() {
    std::vector<ExchangedFlap> flaps;
    for (const Carry& c : f_.carries) {
      const int n = int(f_.wounds[size_t(c.tip.wound)].size());
      const Vec2 base =
          0.5 * (place(f_, {c.tip.wound, (c.tip.at + n - 1) % n}) + place(f_, {c.tip.wound, (c.tip.at + 1) % n}));
      flaps.push_back(exchanged_flap(base, place(f_, c.tip) + kGrip_mm * tissue_bisector(f_, c.tip), place(f_, c.to),
                                     kGrip_mm, kShortOfCorner_mm));
    }
    for (size_t i = 0; i < flaps.size(); ++i) commands.push_back(SetHook{int(i) + 1, chart(flaps[i].grip)});
    for (size_t i = 0; i < flaps.size(); ++i)
      for (const HookPlace& p : folded_back(flaps[i], 1)) move(int(i) + 1, p.at, p.height_mm);
    stage("raised", 0.5);
    for (size_t i = flaps.size(); i-- > 0;) {
      const int id = int(i) + 1;
      move(id, flaps[i].to, kLaidFrom_mm);
      move(id, flaps[i].to, kLaidAt_mm);
      for (const KeyStitch& k : f_.keys)
        if (k.a == f_.carries[i].tip)
          commands.push_back(Suture{chart(in_corner(k.a, k.b)), chart(in_corner(k.b, k.a))});
      commands.push_back(ReleaseHook{id});
      if (i) stage(("laid " + std::to_string(flaps.size() - i)).c_str(), 0.5);
    }
    stage("transposed", 1);
  }

  void close() {
    if (plan_.buried_mm > 0) {
      for (const Seam& s : f_.seams) sew(s, plan_.buried_mm);
      stage("deep layer", 1);
    }
    for (const Seam& s : f_.seams) sew(s, 0);
    stage("closed", 4);
  }

 private:
  static constexpr double kGrip_mm = 3;
  static constexpr double kNearCorner_mm = 1.5;  // nearer a needle meets the bank that was drawn there before

  ChartPoint chart(const Vec2& p) const {
    const ChartPoint c = on_.chart(p);
    return {rounded(c.x()), rounded(c.y())};
  }
  std::vector<ChartPoint> path(const std::vector<Vec2>& points) const {
    std::vector<ChartPoint> out;
    for (const Vec2& p : points) out.push_back(chart(p));
    return out;
  }
  /// The same for what is cut: along the figure's lines on a curved skin too.
  std::vector<ChartPoint> cut(const std::vector<Vec2>& points, bool closed) const {
    std::vector<ChartPoint> out{chart(points[0])};
    for (size_t i = 1; i < points.size() + (closed ? 1 : 0); ++i)
      for (const ChartPoint& c : on_.line(points[i - 1], points[i % points.size()]))
        out.push_back({rounded(c.x()), rounded(c.y())});
    if (closed) out.pop_back();  // back at the first
    return out;
  }
  void stage(const char* name, double settle_s) {
    commands.push_back(Wait{settle_s});
    commands.push_back(Stage{name});
  }
  void move(int id, const Vec2& to, double height_mm) {
    const Vec3 x = on_.above(to, height_mm);
    commands.push_back(MoveHook{id, {rounded(x.x()), rounded(x.y()), rounded(x.z())}, 1.5});
  }

  void keys(bool raised) {
    for (const KeyStitch& k : f_.keys)
      if (k.while_raised == raised) commands.push_back(Suture{chart(in_corner(k.a, k.b)), chart(in_corner(k.b, k.a))});
  }
  // A stitch in a corner goes through its tissue's middle; at the end of a slit, through the bank that is sewn there.
  Vec2 in_corner(const Corner& c, const Corner& other) const {
    if (tissue_deg(f_, c) < 330) return in_tip(c);
    for (const Seam& s : f_.seams) {
      if (s.a_from == c && s.b_from == other) return bite(bank(f_, s.a_from, s.a_to, true), plan_.corner_mm, 1);
      if (s.b_from == c && s.a_from == other) return bite(bank(f_, s.b_from, s.b_to, false), plan_.corner_mm, -1);
      if (s.a_to == c && s.b_to == other) return from_end(bank(f_, s.a_from, s.a_to, true), 1);
      if (s.b_to == c && s.a_to == other) return from_end(bank(f_, s.b_from, s.b_to, false), -1);
    }
    return place(f_, c) + plan_.corner_mm * tissue_bisector(f_, c);
  }
  // In a tip as narrow as that between two lobes a hand would meet the other side of its edge: deeper in, but not so
  // deep that a small tip is folded over.
  Vec2 in_tip(const Corner& c) const {
    constexpr double kBeside_mm = 0.3, kOfSide = 2. / 3, kStep_mm = 0.1;
    const std::vector<Vec2>& w = f_.wounds[size_t(c.wound)];
    const size_t i = size_t(c.at), n = w.size();
    const double side_mm = std::min((w[(i + 1) % n] - w[i]).norm(), (w[(i + n - 1) % n] - w[i]).norm());
    const Vec2 into = tissue_bisector(f_, c), across(-into.y(), into.x());
    double deep_mm = plan_.corner_mm;
    const auto narrow = [&] {
      const Vec2 at = w[i] + deep_mm * into;
      return std::min(tissue_mm(f_, at, across), tissue_mm(f_, at, -across)) < kBeside_mm;
    };
    while (deep_mm + kStep_mm <= kOfSide * side_mm && narrow()) deep_mm += kStep_mm;
    return w[i] + deep_mm * into;
  }
  Vec2 from_end(const std::vector<Vec2>& p, int side) const { return bite(p, path_length(p) - plan_.corner_mm, side); }

  // Where a needle goes in: the inset behind a bank's edge, at a corner along the middle of its tissue; in a tip
  // narrower than twice that still nearer to its own edge than to the other, or the stitch would take that one, or the
  // skin beyond it. `side`: 1 on the bank's
  // left, -1 on its right.
  Vec2 bite(const std::vector<Vec2>& path, double s_mm, int side) const {
    constexpr double kNearer = 0.45, kAtCorner_mm = 0.05;
    const auto inward = [&](double s) { return Vec2(limberg::beside(path, s, side) - limberg::beside(path, s, 0)); };
    const Vec2 edge = limberg::beside(path, s_mm, 0), before = inward(s_mm - kAtCorner_mm),
               after = inward(s_mm + kAtCorner_mm), into = (before + after).normalized();
    const double inset = std::min(plan_.inset_mm, kNearer * tissue_mm(f_, edge, into));
    return before == after ? limberg::beside(path, s_mm, side * inset) : edge + inset * into;
  }

  void sew(const Seam& s, double depth_mm) {
    const auto a = bank(f_, s.a_from, s.a_to, true), b = bank(f_, s.b_from, s.b_to, false);
    const double la = path_length(a), lb = path_length(b), longer = std::max(la, lb);
    // Of equal parts from t0 to the end stitch 0 stands at t0, where no key holds it already.
    const double t0 = s.no_key ? kNearCorner_mm / longer : 0;
    const int parts = int(parts_of_row((1 - t0) * longer, plan_.spacing_mm)), first = s.no_key ? 0 : 1;
    const int n = parts - first;
    const auto at = [&](int i) {
      const double t = t0 + (1 - t0) * double(first + i) / parts;
      return std::pair(bite(a, t * la, 1), bite(b, t * lb, -1));
    };
    const auto stitch = [&](int i) {
      const auto [pa, pb] = at(i);
      commands.push_back(Suture{chart(pa), chart(pb), depth_mm});
    };
    if (n < 1) return;
    if (n == 1) return stitch(0);
    if (s.from_middle) return halve(stitch, n);
    SutureRow row;
    row.spacing_mm = plan_.spacing_mm, row.depth_mm = depth_mm;
    for (int i = 0; i < n; ++i) {
      const auto [pa, pb] = at(i);
      row.a.push_back(chart(pa)), row.b.push_back(chart(pb));
    }
    commands.push_back(std::move(row));
  }

  // Stitches 0..n-1: the middle one, then the middles of both halves, and so on.
  static void halve(const auto& stitch, int n) {
    std::vector<std::pair<int, int>> open{{0, n - 1}};
    for (size_t i = 0; i < open.size(); ++i) {
      const auto [lo, hi] = open[i];
      const int mid = (lo + hi) / 2;
      stitch(mid);
      if (mid > lo) open.push_back({lo, mid - 1});
      if (hi > mid) open.push_back({mid + 1, hi});
    }
  }

  const Figure& f_;
  const OnSkin& on_;
  const OperationPlan& plan_;
};

}  // namespace

std::vector<Command> carry_out(const Figure& figure, const OnSkin& where, const OperationPlan& plan) {
  if (const std::string why = why_open(figure); !why.empty())
    throw InputError("figure", 0, why + "; expected every edge once");
  Writer w(figure, where, plan);
  w.cuts();
  w.carry();
  w.close();
  return std::move(w.commands);
}

}  // namespace limberg
