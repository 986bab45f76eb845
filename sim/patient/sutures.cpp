#include "sim/patient/sutures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/commands/plan_numbers.h"
#include "sim/lattice/embedding.h"

namespace limberg {
namespace {

constexpr double kSamePlace_mm = 0.5;  // two stitches nearer than this at both ends are one
constexpr double kPick_mm = 5;         // a stitch is meant that is this near to the place pointed at
constexpr int kMostStitches = 500;     // of one row
constexpr double kMet_mm = 0.2;        // edges nearer than this have met
constexpr double kTear_N = 5.9;        // knot-pull strength of USP 4-0: no thread is drawn harder

constexpr double kLeastBite_mm = 0.5;  // a needle that goes in nearer to the edge than this tears out
constexpr double kUneven_mm = 1;       // bites of one stitch that differ by more lie unevenly

std::string mm(double v) { return fmt::format("{:.4g} mm", v); }

// Where its triangle has no edge of the wound any more, from a little inside it: on the edge itself both banks are
// equally near.
std::optional<RimWalk::Spot> spot_on(const RimWalk& rim, const RestIndex& index, const Anchor& anchor) {
  if (anchor.in_wall()) return std::nullopt;
  if (const auto spot = rim.spot(anchor.at)) return spot;
  const auto p =
      index.snap_to_rim({anchor.at.triangle, 0.95 * anchor.at.bary + Vec3::Constant(0.05 / 3)}, kStitchReach_mm);
  return p ? rim.spot(*p) : std::nullopt;
}

}  // namespace

// Of the same piece of tissue, too: the two edges of a wound that has not opened yet lie in one place, but the way from
// one to the other goes round the wound's end.
bool Sutures::same_place(const Anchor& a, const Anchor& b) const {
  if ((a.X_mm - b.X_mm).norm() >= kSamePlace_mm) return false;
  // Walls that face each other are two, though a shallow wound's lie in one cell.
  if (a.in_wall() && b.in_wall()) return a.wall_normal.dot(b.wall_normal) > 0;
  if (a.at.triangle == b.at.triangle) return true;
  const auto from = spot_on(tissue_.rim(), *tissue_.version().index, a),
             to = spot_on(tissue_.rim(), *tissue_.version().index, b);
  if (!from || !to) return !from && !to && a.embedded.node == b.embedded.node;
  for (const bool forward : {true, false})
    if (const auto way = tissue_.rim().way(*from, *to, forward); way && way->length_mm < 2 * kSamePlace_mm) return true;
  return false;
}

bool Sutures::joins(const Stitch& s, const Anchor& a, const Anchor& b) const {
  return (same_place(s.a, a) && same_place(s.b, b)) || (same_place(s.a, b) && same_place(s.b, a));
}

std::optional<Anchor> Sutures::bite_at(const SurfacePoint& rim, double depth_mm, std::string& reason) const {
  std::optional<Anchor> anchor;
  if (depth_mm > 0) {
    anchor = make_buried_anchor(*tissue_.version().surface, *tissue_.version().index, rim, depth_mm);
    if (!anchor) {
      reason = "the wound has no wall " + mm(depth_mm) + " below its edge at " +
               at_text(tissue_.body().to_chart(tissue_.version().index->rest_mm(rim))) +
               "; a shallower bite was expected";
      return std::nullopt;
    }
  } else {
    anchor = make_anchor(tissue_.version().surface->view, *tissue_.version().index, rim);
  }
  anchor->embedded = tissue_.embed(anchor->at);
  return anchor;
}

std::optional<Anchor> Sutures::find_bite(const ChartPoint& p, double depth_mm, std::string& reason,
                                         HeldSide side) const {
  if (side != HeldSide::skin) return tissue_.find_in_wall(p, side, reason);
  if (!(depth_mm > 0)) return tissue_.find_anchor(p, true, reason);
  const auto skin = tissue_.find_skin(p, reason);
  if (!skin) return std::nullopt;
  const auto rim = tissue_.version().index->snap_to_rim(*skin, kStitchReach_mm);
  if (!rim)
    return reason = "there is no wound's edge near " + tissue_.place_text(p) + "; a place beside one was expected",
           std::nullopt;
  return bite_at(*rim, depth_mm, reason);
}

std::optional<size_t> Sutures::find_stitch(const StitchPick& pick, std::string& reason) const {
  if (pick.id > 0) {
    for (size_t i = 0; i < holding_.stitches.size(); ++i)
      if (holding_.stitches[i].id == pick.id) return i;
    return reason =
               "there is no stitch " + std::to_string(pick.id) + "; the number of a stitch that is there was expected",
           std::nullopt;
  }
  const auto at = tissue_.find_skin(pick.at, reason);
  if (!at) return std::nullopt;
  const Vec3 X = tissue_.version().index->rest_mm(*at);
  std::optional<size_t> best;
  double nearest = kPick_mm;
  for (size_t i = 0; i < holding_.stitches.size(); ++i) {
    if (!holding_.stitches[i].across()) continue;
    const double d = std::min((holding_.stitches[i].a.X_mm - X).norm(), (holding_.stitches[i].b.X_mm - X).norm());
    if (d < nearest) nearest = d, best = i;
  }
  if (!best)
    reason = "there is no stitch within " + mm(kPick_mm) + " of " + tissue_.place_text(pick.at) +
             "; a place beside one was expected";
  return best;
}

// A needle takes a bite, not a point (bite_patch()). In a wall there is half as much room around it.
void Sutures::widen(Anchor& anchor) const {
  anchor.wide.clear();
  if (!(anchor.bite_mm > 0)) return;
  SurfacePoint at = anchor.at;
  if (const auto spot = spot_on(tissue_.rim(), *tissue_.version().index, anchor)) at = tissue_.rim().point(*spot);
  anchor.wide = tissue_.embed_bite(at, anchor.in_wall() ? 0.5 * anchor.bite_mm : anchor.bite_mm);
}

namespace {

double turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// Whether the straight way from a to b on the chart meets an edge of a wound.
bool meets_rim(const SurfaceView& view, const Body& body, const Vec3& a_mm, const Vec3& b_mm) {
  const Vec2 a = body.to_chart(a_mm), b = body.to_chart(b_mm);
  for (size_t t = 0; t < view.tri.size(); ++t)
    for (size_t k = 0; view.rim[t] != 0 && k < 3; ++k) {
      if (!(view.rim[t] >> k & 1)) continue;
      const Vec2 p = body.to_chart(view.X_mm[size_t(view.tri[t][k])]),
                 q = body.to_chart(view.X_mm[size_t(view.tri[t][(k + 1) % 3])]);
      if (turn(a, b, p) * turn(a, b, q) <= 0 && turn(p, q, a) * turn(p, q, b) <= 0) return true;
    }
  return false;
}

}  // namespace

// A way along the rim that is hardly longer than the straight one runs along one bank: between two banks it goes round
// the end of the wound. Across a round hole, or the blunt end of one, it may be as short, but there is no skin under it
// then: none at all, or that of a flap which lies elsewhere now.
std::vector<int> Sutures::in_one_bank() const {
  constexpr double kStraight = 1.1, kSlack_mm = 0.1;
  std::vector<int> found;
  const TissueVersion& version = tissue_.version();
  for (const Stitch& s : holding_.stitches) {
    if (!s.across() || s.a.in_wall() || s.b.in_wall()) continue;
    const auto from = spot_on(tissue_.rim(), *version.index, s.a), to = spot_on(tissue_.rim(), *version.index, s.b);
    // Both bites in skin, away from any edge, and none between.
    bool one = !from && !to && !meets_rim(version.surface->view, tissue_.body(), s.a.X_mm, s.b.X_mm);
    if (from && to)
      for (const bool forward : {true, false})
        if (const auto way = tissue_.rim().way(*from, *to, forward))
          one |= way->length_mm <= kStraight * (s.a.X_mm - s.b.X_mm).norm() + kSlack_mm;
    std::string reason;
    if (!one) continue;
    const auto under = tissue_.find_skin(tissue_.body().to_chart(0.5 * (s.a.X_mm + s.b.X_mm)), reason);
    if (!under) continue;
    const Vec3 middle_mm = 0.5 * (tissue_.held_mm(s.a) + tissue_.held_mm(s.b));
    if ((tissue_.position_mm(tissue_.embed(*under)) - middle_mm).norm() <= (s.a.X_mm - s.b.X_mm).norm())
      found.push_back(s.id);
  }
  return found;
}

Stitch Sutures::between(const Anchor& a, const Anchor& b, double bite_mm) const {
  Stitch s;
  s.a = a, s.b = b;
  s.a.bite_mm = s.b.bite_mm = bite_mm;
  widen(s.a), widen(s.b);
  s.slack_mm = tissue_.held_mm(s.a) - tissue_.held_mm(s.b);
  return s;
}

bool Sutures::draw_tight() {
  bool drawn = false;
  const double pull_mm = tissue_.spec().suture_pull_mm_per_step;
  for (Stitch& s : holding_.stitches) {
    if (s.drawn()) continue;
    const double slack = s.slack_mm.norm();
    s.slack_mm *= slack > pull_mm ? 1 - pull_mm / slack : 0;
    drawn = true;
  }
  for (Thread& t : holding_.threads) {
    if (t.let_go) {
      slip(t);
      drawn |= t.closing;
      continue;
    }
    if (!t.closing) continue;
    draw(t);
    drawn = true;
  }
  return drawn;
}

bool Sutures::settled() const {
  return std::all_of(holding_.stitches.begin(), holding_.stitches.end(), [](const Stitch& s) { return s.drawn(); }) &&
         std::all_of(holding_.threads.begin(), holding_.threads.end(), [](const Thread& t) { return !t.closing; });
}

double Sutures::to_draw_mm() const {
  double most = 0;
  for (const Stitch& s : holding_.stitches) {
    if (!s.drawn()) most = std::max(most, s.slack_mm.norm());
    if (s.thread == 0 || !s.across()) continue;
    const auto t = std::find_if(holding_.threads.begin(), holding_.threads.end(),
                                [&](const Thread& thread) { return thread.id == s.thread; });
    if (t != holding_.threads.end() && t->closing && !t->let_go)
      most = std::max(most, (tissue_.held_mm(s.a) - tissue_.held_mm(s.b)).norm());
  }
  return most;
}

void Sutures::note_forces() {
  for (Stitch& s : holding_.stitches) {
    const double f = 1e-3 * tissue_.solver().spring_force_mN(s.spring).norm();
    if (s.tied_N < 0) s.tied_N = f;
    s.peak_N = std::max(s.peak_N, f);
  }
}

void Sutures::carry() {
  std::vector<int32_t> torn;  // a thread that has lost one bite holds nothing
  std::erase_if(holding_.stitches, [&](Stitch& s) {
    if (tissue_.carry(s.a) && tissue_.carry(s.b)) {
      widen(s.a), widen(s.b);
      return false;
    }
    if (s.thread > 0) torn.push_back(s.thread);
    return true;
  });
  for (int32_t t : torn) drop_thread(t);
}

// A hand draws until the edges meet, or until the thread would tear; then it ties.
void Sutures::draw(Thread& t) const {
  double open = 0, widest = 0, tension_N = 0, kept = 0;
  int stitches = 0;
  std::optional<Vec3> first;
  Vec3 last = Vec3::Zero();
  for (const Stitch& s : holding_.stitches) {
    if (s.thread != t.id) continue;
    const Vec3 a = tissue_.held_mm(s.a), b = tissue_.held_mm(s.b);
    tension_N = std::max(tension_N, 1e-3 * tissue_.solver().spring_force_mN(s.spring).norm());
    if (!first) first = a;
    last = b;
    kept += s.slack_mm.norm();
    if (!s.across()) continue;
    ++stitches;
    open += (a - b).norm(), widest = std::max(widest, (a - b).norm());
  }
  if (t.corner && first) open -= (*first - last).norm(), widest = open;
  if (widest <= kMet_mm || tension_N >= kTear_N || t.length_mm <= kept) {
    t.closing = false;
    t.length_mm += t.slack_mm;
    return;
  }
  // As much for each stitch of it as a single one is drawn; less where little is left.
  t.length_mm = std::max(
      kept, t.length_mm - std::clamp(0.5 * open, kMet_mm / 4, tissue_.spec().suture_pull_mm_per_step * stitches));
}

void Sutures::thread_through(std::vector<Stitch> spans, bool corner, double slack_mm) {
  Thread t;
  t.id = holding_.next_thread++;
  for (Stitch& s : spans) {
    t.length_mm += (tissue_.held_mm(s.a) - tissue_.held_mm(s.b)).norm();
    if (s.across()) s.slack_mm.setZero();
    s.thread = t.id;
    s.spring = holding_.next_spring++;
    holding_.stitches.push_back(s);
  }
  t.corner = corner, t.slack_mm = slack_mm;
  holding_.threads.push_back(t);
}

Vec3 Sutures::along_the_wound(const Stitch& before, const Stitch& next) const {
  const Vec3 a = tissue_.position_mm(next.a.embedded) - tissue_.position_mm(before.a.embedded);
  const Vec3 b = tissue_.position_mm(next.b.embedded) - tissue_.position_mm(before.b.embedded);
  return a.squaredNorm() < b.squaredNorm() ? a : b;  // a wound's banks close side by side
}

void Sutures::go_on(Thread& t, std::vector<Stitch>::iterator where, std::vector<Stitch> spans) {
  for (Stitch& s : spans) {
    t.length_mm += (tissue_.held_mm(s.a) - tissue_.held_mm(s.b)).norm();
    if (s.across()) s.slack_mm.setZero();
    s.thread = t.id, s.spring = holding_.next_spring++;
  }
  t.closing = true;
  holding_.stitches.insert(where, spans.begin(), spans.end());
}

void Sutures::drop_thread(int32_t thread) {
  std::erase_if(holding_.stitches, [&](const Stitch& s) { return s.thread == thread; });
  std::erase_if(holding_.threads, [&](const Thread& t) { return t.id == thread; });
}

Outcome Sutures::act(const Suture& c) {
  std::string reason;
  const auto a = find_bite(c.a, c.depth_mm, reason, c.side_a);
  if (!a) return {false, reason};
  const auto b = find_bite(c.b, c.depth_mm, reason, c.side_b);
  if (!b) return {false, reason};
  for (const Stitch& s : holding_.stitches)  // first: a stitch that is tight has its two ends in one place
    if (s.across() && joins(s, *a, *b))
      return {false, "stitch " + std::to_string(s.id) + " is there already; another place was expected"};
  if (same_place(*a, *b))
    return {false, "both ends of the stitch are at " + tissue_.place_text(c.a) + "; two different edges were expected"};
  Stitch stitch = between(*a, *b, tissue_.spec().suture_bite_mm);
  stitch.id = holding_.next_stitch++, stitch.spring = holding_.next_spring++;
  holding_.stitches.push_back(stitch);
  return {true, through_whole_skin(*a, *b)};
}

// A surgeon may tie one, to gather skin or to hold a flap down; mostly it is a slip, and puckers the skin.
std::string Sutures::through_whole_skin(const Anchor& a, const Anchor& b) const {
  const auto whole = [&](const Anchor& x) {
    return !x.in_wall() && !spot_on(tissue_.rim(), *tissue_.version().index, x);
  };
  const int ends = whole(a) + whole(b);
  if (ends == 0) return {};
  const Vec3& X = whole(a) ? a.X_mm : b.X_mm;
  return fmt::format("{} through whole skin: no wound's edge lies within {:g} mm of ({:.1f}, {:.1f}, {:.1f}) mm",
                     ends == 2 ? "both ends go" : "one end goes", kStitchReach_mm, X.x(), X.y(), X.z());
}

Outcome Sutures::act(const SutureCorner& c) {
  if (!(c.depth_mm > 0))
    return {false, "a half-buried stitch at a depth of " + mm(c.depth_mm) + "; a depth above 0 was expected"};
  std::string reason;
  const auto a = find_bite(c.a, c.depth_mm, reason);
  const auto tip = a ? find_bite(c.tip, c.depth_mm, reason) : std::nullopt;
  const auto b = tip ? find_bite(c.b, c.depth_mm, reason) : std::nullopt;
  if (!b) return {false, reason};
  if (same_place(*a, *b) || same_place(*a, *tip) || same_place(*tip, *b))
    return {false,
            "two bites of the corner stitch are at one place; the tip and a bank on either side of its corner were "
            "expected"};
  for (const Stitch& s : holding_.stitches)
    if (s.across() && (joins(s, *a, *tip) || joins(s, *tip, *b)))
      return {false, "stitch " + std::to_string(s.id) + " is there already; another place was expected"};
  std::vector<Stitch> spans{between(*a, *tip, tissue_.spec().suture_bite_mm),
                            between(*tip, *b, tissue_.spec().suture_bite_mm)};
  for (Stitch& s : spans) s.id = holding_.next_stitch++;
  thread_through(std::move(spans), true, 0);
  return {true, {}};
}

Outcome Sutures::sew_row(const std::vector<std::pair<Anchor, Anchor>>& bites, const RowKind& kind, bool whole) {
  std::vector<std::pair<Anchor, Anchor>> row;
  const auto taken = [&](const Anchor& a, const Anchor& b) {
    return std::any_of(holding_.stitches.begin(), holding_.stitches.end(),
                       [&](const Stitch& s) { return s.across() && joins(s, a, b); }) ||
           std::any_of(row.begin(), row.end(), [&](const auto& r) {
             return (same_place(r.first, a) && same_place(r.second, b)) ||
                    (same_place(r.first, b) && same_place(r.second, a));
           });
  };
  // Where the edges of a cut lie closed within half a mm single stitches of a drawn row are left out; a thread, and a
  // row between two stitches, go all along.
  const auto closed = [&](const Anchor& a, const Anchor& b) {
    return same_place(a, b) &&
           (!whole || (tissue_.position_mm(a.embedded) - tissue_.position_mm(b.embedded)).norm() < 1e-3);
  };
  for (const auto& [a, b] : bites)
    if (!closed(a, b) && !taken(a, b)) row.emplace_back(a, b);
  if (row.empty()) return {false, "every stitch of the row is there already; free edges were expected"};
  if (kind.running && row.size() < 2)
    return {false, "a running suture of one stitch; a longer edge or a smaller spacing was expected"};
  const double bite = std::min(tissue_.spec().suture_bite_mm, 0.5 * kind.spacing_mm);  // neighbours share no tissue
  if (!kind.running) {
    for (const auto& [a, b] : row) {
      Stitch s = between(a, b, bite);
      s.id = holding_.next_stitch++, s.spring = holding_.next_spring++;
      holding_.stitches.push_back(s);
    }
  } else {
    std::vector<Stitch> spans;
    for (size_t i = 0; i < row.size(); ++i) {
      if (i > 0) {
        spans.push_back(between(row[i - 1].second, row[i].first, bite));
        Stitch before, next;
        before.a = row[i - 1].first, before.b = row[i - 1].second, next.a = row[i].first, next.b = row[i].second;
        spans.back().slack_mm = along_the_wound(before, next);
      }
      spans.push_back(between(row[i].first, row[i].second, bite));
      spans.back().id = holding_.next_stitch++;
    }
    thread_through(std::move(spans), false, kind.slack_mm);
  }
  return {true, {}};
}

Outcome Sutures::act(const SutureRow& c) {
  if (c.a.size() < 2 || c.b.size() < 2) return {false, "a row of stitches needs two paths of at least two points"};
  if (!(c.spacing_mm > 0)) return {false, "the spacing of a row must be more than 0 mm"};
  const double stitches = row_stitches(c.a, c.b, c.spacing_mm);
  if (!(stitches <= kMostStitches))
    return {false, "a row of more than " + std::to_string(kMostStitches) +
                       " stitches; a wider spacing or a shorter path was expected"};
  const int n = int(stitches);
  const std::vector<Vec2> pa = resample(c.a, n), pb = resample(c.b, n);
  std::vector<std::pair<Anchor, Anchor>> bites;
  for (int i = 0; i < n; ++i) {
    std::string reason;
    const auto a = find_bite(pa[size_t(i)], c.depth_mm, reason);
    const auto b = a ? find_bite(pb[size_t(i)], c.depth_mm, reason) : std::nullopt;
    if (!a || !b) return {false, "stitch " + std::to_string(i + 1) + " of the row: " + reason};
    bites.emplace_back(*a, *b);
  }
  return sew_row(bites, {c.spacing_mm, c.depth_mm, c.running, c.slack_mm}, c.running);
}

std::optional<Anchor> Sutures::find_own_bite(const ChartPoint& p, double depth_mm, HeldSide side,
                                             std::string& reason) const {
  std::optional<Anchor> anchor;
  double from_edge_mm = tissue_.spec().suture_bite_mm;
  if (side != HeldSide::skin) {
    anchor = tissue_.find_in_wall(p, side, reason);
  } else if (const auto skin = tissue_.find_skin(p, reason)) {
    const RestIndex& index = *tissue_.version().index;
    const auto rim = index.snap_to_rim(*skin, SutureBite::kFarthest_mm);
    if (!rim)
      return reason = "there is no wound's edge within " + mm(SutureBite::kFarthest_mm) + " of " +
                      tissue_.place_text(p) + "; a bite nearer to one was expected",
             std::nullopt;
    from_edge_mm = (index.rest_mm(*skin) - index.rest_mm(*rim)).norm();
    anchor = bite_at(*rim, depth_mm, reason);
  }
  if (anchor) anchor->bite_mm = std::clamp(from_edge_mm, kLeastBite_mm, SutureBite::kFarthest_mm);
  return anchor;
}

Thread* Sutures::sewn_thread() {
  for (Thread& t : holding_.threads)
    if (t.open) return &t;
  return nullptr;
}

std::optional<SewnThread> Sutures::sewn() const {
  for (const Thread& t : holding_.threads) {
    if (!t.open) continue;
    SewnThread sewn;
    sewn.thread = t.id, sewn.let_go = t.let_go;
    for (const Stitch& s : holding_.stitches)
      if (s.thread == t.id && s.across()) ++sewn.bites, sewn.end_mm = tissue_.position_mm(s.b.embedded).cast<float>();
    return sewn;
  }
  return std::nullopt;
}

Outcome Sutures::act(const SutureBite& c) {
  std::string reason;
  const auto a = find_own_bite(c.a, c.depth_mm, c.side_a, reason);
  const auto b = a ? find_own_bite(c.b, c.depth_mm, c.side_b, reason) : std::nullopt;
  if (!b) return {false, reason};
  for (const Stitch& s : holding_.stitches)
    if (s.across() && joins(s, *a, *b))
      return {false, "stitch " + std::to_string(s.id) + " is there already; another place was expected"};
  if (same_place(*a, *b))
    return {false, "both ends of the bite are at " + tissue_.place_text(c.a) + "; two different edges were expected"};
  const double uneven = std::abs(a->bite_mm - b->bite_mm);
  Stitch across = between(*a, *b, 0);
  across.a.bite_mm = a->bite_mm, across.b.bite_mm = b->bite_mm;
  widen(across.a), widen(across.b);
  across.id = holding_.next_stitch++;
  if (Thread* t = sewn_thread()) {
    take_up(*t);
    const auto last = std::find_if(holding_.stitches.rbegin(), holding_.stitches.rend(),
                                   [&](const Stitch& s) { return s.thread == t->id; });
    Stitch along = between(last->b, across.a, 0);
    along.a = last->b, along.b = across.a;
    along.slack_mm = along_the_wound(*last, across);
    go_on(*t, last.base(), {along, across});
  } else {
    thread_through({across}, false, 0);
    holding_.threads.back().open = true;
  }
  const std::string note = through_whole_skin(*a, *b);
  if (!note.empty() || uneven <= kUneven_mm || c.side_a != c.side_b) return {true, note};
  return {true, fmt::format("it lies {:.1f} mm from one edge and {:.1f} mm from the other; where bites are not alike "
                            "one edge comes to lie higher",
                            a->bite_mm, b->bite_mm)};
}

Outcome Sutures::act(const TieSuture& c) {
  Thread* t = sewn_thread();
  if (!t) return {false, "no thread is being sewn; a bite of a running suture was expected before its knot"};
  take_up(*t);
  t->open = false;
  if (t->closing)
    t->slack_mm = c.slack_mm;
  else
    t->length_mm += c.slack_mm;
  return {true, {}};
}

Outcome Sutures::act(const SutureBetween& c) {
  if (!(c.row.spacing_mm > 0)) return {false, "the spacing of a row must be more than 0 mm"};
  std::string reason;
  const auto i = find_stitch(c.from, reason), k = i ? find_stitch(c.to, reason) : std::nullopt;
  if (!k) return {false, reason};
  if (i == k)
    return {false, "the row begins and ends at stitch " + std::to_string(holding_.stitches[*i].id) +
                       "; two different stitches were expected"};
  const RimWalk& rim = tissue_.rim();
  const auto spot = [&](const Anchor& a) { return spot_on(rim, *tissue_.version().index, a); };
  // Forward along one bank and backward along the other; which bank of one stitch goes on into which of the other is
  // not said by the order of their bites. The shortest way is meant.
  struct Ways {
    RimWalk::Way a, b;
  };
  std::optional<Ways> best;
  const Stitch &from = holding_.stitches[*i], &to = holding_.stitches[*k];
  const auto fa = spot(from.a), fb = spot(from.b);
  for (const bool swapped : {false, true}) {
    const auto ta = spot(swapped ? to.b : to.a), tb = spot(swapped ? to.a : to.b);
    if (!fa || !fb || !ta || !tb)
      return {false, "a bite of the two stitches lies on no wound's edge; stitches through the edges were expected"};
    for (const bool forward : {true, false}) {
      const auto a = rim.way(*fa, *ta, forward), b = rim.way(*fb, *tb, !forward);
      if (a && b && (!best || a->length_mm + b->length_mm < best->a.length_mm + best->b.length_mm)) best = Ways{*a, *b};
    }
  }
  if (!best) return {false, "the two stitches lie on different wounds; two stitches of one wound were expected"};
  const double length = std::max(best->a.length_mm, best->b.length_mm);
  const int n = int(std::min(1e6, parts_of_row(length, c.row.spacing_mm))) - 1;
  if (n < 1)
    return {false,
            "the two stitches are " + mm(length) + " apart; more than one and a half times the spacing was expected"};
  if (n > kMostStitches)
    return {false, "a row of more than " + std::to_string(kMostStitches) + " stitches; a wider spacing was expected"};
  std::vector<std::pair<Anchor, Anchor>> bites;
  for (int j = 1; j <= n; ++j) {
    const double share = double(j) / (n + 1);
    const auto a = bite_at(rim.point(best->a, share), c.row.depth_mm, reason);
    const auto b = a ? bite_at(rim.point(best->b, share), c.row.depth_mm, reason) : std::nullopt;
    if (!b) return {false, "stitch " + std::to_string(j) + " of the row: " + reason};
    bites.emplace_back(*a, *b);
  }
  return sew_row(bites, c.row, true);
}

Outcome Sutures::act(const CutSuture& c) {
  std::string reason;
  const auto i = find_stitch(c.which, reason);
  if (!i) return {false, reason};
  if (const int32_t thread = holding_.stitches[*i].thread; thread > 0)
    drop_thread(thread);
  else
    holding_.stitches.erase(holding_.stitches.begin() + std::ptrdiff_t(*i));
  return {true, {}};
}

namespace {

constexpr int32_t kOfOneSpan = 1 << 30;  // above the numbers of all threads

}  // namespace

std::vector<Spring> springs(const Holding& holding, const WorldSpec& spec) {
  std::vector<Spring> springs;
  for (const Hook& h : holding.hooks) {
    Spring s;
    s.id = h.spring, s.a = h.anchor.embedded, s.a_wide = h.anchor.wide, s.to_world = true, s.target_mm = h.handle_mm,
    s.k_N_per_mm = spec.hook_k_N_per_mm;
    springs.push_back(s);
  }
  for (const Stitch& t : holding.stitches) {
    Spring s;
    s.id = t.spring, s.a = t.a.embedded, s.b = t.b.embedded, s.a_wide = t.a.wide, s.b_wide = t.b.wide,
    s.target_mm = t.slack_mm, s.k_N_per_mm = spec.suture_k_N_per_mm;
    if (t.thread > 0)
      for (const Thread& thread : holding.threads)
        if (thread.id == t.thread) s.thread = t.thread, s.thread_mm = thread.length_mm;
    if (t.own_mm >= 0) s.thread = kOfOneSpan + t.spring, s.thread_mm = t.own_mm;
    springs.push_back(s);
  }
  return springs;
}

}  // namespace limberg
