#include "sim/contact/contact_finder.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/contact/contact_constants.h"
#include "sim/contact/contact_stiffness.h"

namespace limberg {

namespace constant = contact_constants;

namespace {

constexpr size_t kPlaceGrain = 32, kChunks = 4;  // places of a chunk, at least; chunks of a worker's share
constexpr double kNear_mm = 0.3;                 // clearance of pairs that may press within a few iterations
constexpr double kSorted_mm = 2;                 // cells may go so far until their tree is sorted again
constexpr double kTurn_mm = 0.08;                // less motion turns no surface by turn_deg
constexpr double kLeast_mm = 0.005;              // pairs are checked again after so much motion at least
constexpr double kNever_mm = 1e30;               // until pairs go stale that are not there
constexpr int kFullProjections = 2;              // projections in one neighbourhood that go all the way
constexpr int kMostProjections = 8;              // the last one
const double kTurnCos = elementary::cos(constant::turn_deg * std::numbers::pi / 180);

}  // namespace

ContactFinder::ContactFinder(std::shared_ptr<const ContactSurface> surface, const FemModel& model, double friction)
    : surface_(std::move(surface)),
      cell_mm_(elementary::cbrt(model.cell_mm.prod())),
      tissue_(*surface_, model),
      cells_(tissue_, model),
      motion_(tissue_, model),
      u_(model.X_mm.size()),
      state_(surface_->place.size()),
      friction_{friction} {
  for (int32_t c : surface_->carrier) carrier_.push_back(tissue_.find(c));
  for (size_t i = 0; i < surface_->place.size(); ++i) {
    const ContactPlace& p = surface_->place[i];
    normal_.push_back(tissue_.smooth_normal(p.triangle, p.bary));
    const int32_t sheet = surface_->sheets.of[size_t(p.triangle)];
    if (i == 0 || p.copy != surface_->place[i - 1].copy) {
      Group g;
      g.first = i, g.own = size_t(tissue_.find(p.copy)), g.sheet = sheet;
      group_.push_back(std::move(g));
    }
    group_.back().last = i + 1;
    if (group_.back().sheet != sheet) group_.back().sheet = -1;
  }
  chunk_of_.resize(surface_->place.size());
  for (size_t g = 0; g < group_.size(); ++g) {
    if (chunk_.empty() || group_[g].first - group_[chunk_.back().first].first >= kPlaceGrain)
      chunk_.emplace_back().first = g;
    chunk_.back().last = g + 1;
    for (size_t i = group_[g].first; i < group_[g].last; ++i) chunk_of_[i] = chunk_.size() - 1;
  }
  counts_.places = surface_->place.size(), counts_.triangles = surface_->tri.size();
}

Vec3 ContactFinder::displacement(const EmbeddedPoint& e) const {
  v4 d = {};
  for (size_t i = 0; i < 8; ++i) d += e.w[i] * u_[size_t(e.node[i])];
  return {double(d[0]), double(d[1]), double(d[2])};
}

Vec3 ContactFinder::shown_mm(int32_t t, const std::array<double, 3>& bary) const {
  Vec3 x = Vec3::Zero();
  for (size_t k = 0; k < 3; ++k) {
    if (bary[k] == 0) continue;
    const size_t v = size_t(surface_->tri[size_t(t)][k]);
    x += bary[k] * (surface_->X_mm[v] + displacement(surface_->embedding[v]));
  }
  return x;
}

// A bound of how far it and the copies of its list have moved against each other.
double ContactFinder::moved_mm(const Group& g) const {
  float most2 = 0;
  for (int32_t c : g.around) most2 = std::max(most2, motion_.apart2(g.own, size_t(c)));
  return double(std::sqrt(most2));
}

// Persistence: which places must be queried, and which pairs are stale.
void ContactFinder::check(size_t chunk) {
  Chunk& here = chunk_[chunk];
  here.changed = here.due = false;
  double moved = 0;
  const double bound = 2 * motion_.most_mm();  // of any two
  const bool still = bound < kLeast_mm;
  bool listed = true;
  std::vector<uint8_t> relation;
  for (size_t k = here.first; k < here.last; ++k) {
    Group& g = group_[k];
    g.far_mm += still ? bound : motion_.apart(g.own);
    g.relist = g.far_mm > constant::margin_mm;
    if (!g.listed && !g.relist) complete_list(g, relation);
    listed &= g.listed;
    const double m = !still ? moved_mm(g) : g.around.empty() ? 0 : bound;
    g.near_mm += m;
    moved = std::max(moved, m);
    const double query = std::clamp(constant::query_slowing * m, constant::query_least_mm, constant::query_mm);
    g.due = g.relist || (g.near_mm > query && !g.around.empty());
    here.due |= g.due;
    for (size_t i = g.first; i < g.last; ++i) state_[i].due = g.due, state_[i].stale = false;
  }
  // Lists that nobody will use again tell one thing still: how near pairs may have come that have not gone stale for
  // sure.
  if (!listed && here.left_mm < kNever_mm)
    for (size_t k = here.first; k < here.last && moved < here.left_mm; ++k)
      if (Group& g = group_[k]; !g.listed) complete_list(g, relation), moved = std::max(moved, moved_mm(g));
  here.left_mm -= moved, here.nearest_mm -= moved;
  if (here.left_mm > 0) return;
  here.left_mm = here.nearest_mm = kNever_mm;
  for (Pair& p : here.pair) {
    const HeldContact& h = p.held;
    const size_t i = size_t(h.place);
    PlaceState& l = state_[i];
    const Vec3 apart = apart_mm(p);
    p.s_mm = h.normal.dot(apart) - h.gap_mm;
    Vec3 slid = apart - h.apart_mm;
    slid -= h.normal.dot(slid) * h.normal;
    double left = h.depth_tested ? (p.s_mm < 0 ? kTurn_mm : p.s_mm + kTurn_mm) : p.s_mm;
    p.stale = left < 0;
    if (!p.stale && p.s_mm < constant::guard_mm) {
      const bool damped = l.projections > kMostProjections && (l.slid_mm + slid).norm() < constant::neighbourhood_mm;
      if (!damped) {
        const double more = constant::slide_mm + std::max(0.0, p.s_mm) - slid.norm();
        p.stale =
            more < 0 ||
            (p.s_mm < 0 &&
             carried_normal(h.triangle, h.bary, tissue_.smooth_normal(h.triangle, h.bary)).dot(h.facet) < kTurnCos);
        left = std::min(left, more);
      }
    }
    here.left_mm = std::min(here.left_mm, std::max(left, kLeast_mm));
    if (h.weight > kNothing) here.nearest_mm = std::min(here.nearest_mm, p.s_mm);
    if (!p.stale) continue;
    slide(l, slid);
    l.due = l.stale = here.due = true;
  }
}

void ContactFinder::make_contact(Pair& p) const {
  const HeldContact& f = p.held;
  const ContactPlace& place = surface_->place[size_t(f.place)];
  Contact& c = p.contact;
  p.rest_apart_mm = place.X_mm - surface_->rest_mm(f.triangle, f.bary);
  c.a = place.embedded;
  c.b = surface_->embedded(f.triangle, f.bary);
  c.normal = f.normal.cast<float>();
  c.gap_mm = float(f.gap_mm - constant::slack_mm);
  c.soft_mm = float(constant::soft_mm);
  c.k_N_per_mm = float(contact_stiffness_N_per_mm(f.weight, place.stiffness_kPa, place.area_mm2, cell_mm_));
  if (friction_.coefficient > 0) take_grip(f.grip, friction_, c);
}

// Of place and foot, as the cells carry them.
Vec3 ContactFinder::apart_mm(const Pair& p) const {
  return p.rest_apart_mm + displacement(p.contact.a) - displacement(p.contact.b);
}

void ContactFinder::grip(size_t chunk) {
  for (Pair& p : chunk_[chunk].pair)
    if (p.held.weight > kNothing && (p.held.grip.push_mN > 0 || chunk_[chunk].nearest_mm < kNear_mm))
      chunk_[chunk].changed |= follow_grip(p.held.grip, apart_mm(p), friction_, p.contact);
}

// True when the place has slid on so far that it is fresh again.
bool ContactFinder::slide(PlaceState& l, const Vec3& slid_mm) const {
  l.slid_mm += slid_mm;
  if (!(l.slid_mm.norm() > constant::neighbourhood_mm)) return false;
  l.slid_mm = Vec3::Zero(), l.projections = 0;
  return true;
}

// Pairs of one place: what was held goes to what is found, or stays.
void ContactFinder::merge(size_t i, std::span<Pair> before, std::vector<HeldContact>& found, Chunk& chunk,
                          std::vector<Pair>& out) {
  PlaceState& l = state_[i];
  double part = l.projections < kFullProjections ? 1 : 1.0 / (l.projections - kFullProjections + 2);
  bool reprojected = false;
  const auto leave_foot = [&](const Pair& p) {  // before it is forgotten; what is stale has been counted
    if (p.stale) return;
    const Vec3 slid = apart_mm(p) - p.held.apart_mm;
    if (slide(l, slid - p.held.normal.dot(slid) * p.held.normal)) part = 1;
  };
  // Its place and its foot are where they are now; s_mm is given. `was`: how the pair was held before, if it was.
  const auto place = [&](Pair p, const HeldContact* was = nullptr, const Vec3& was_apart_mm = Vec3::Zero()) {
    HeldContact& h = p.held;
    make_contact(p);
    h.apart_mm = apart_mm(p);
    if (was && friction_.coefficient > 0)
      carry_grip(*was, was_apart_mm, h, h.apart_mm), take_grip(h.grip, friction_, p.contact);
    // What the surfaces show is linear in their triangles, what the springs feel is trilinear in the cells: the gap
    // makes up the difference, so that a contact begins where it is seen to begin.
    h.gap_mm = h.normal.dot(h.apart_mm) - p.s_mm;
    p.contact.gap_mm = float(h.gap_mm - constant::slack_mm);
    p.stale = false;
    out.push_back(p);
    chunk.changed = true;
    chunk.left_mm = 0;
    chunk.nearest_mm = std::min(chunk.nearest_mm, p.s_mm);
    reprojected |= p.s_mm < 0 && h.weight > kNothing;
  };
  const Vec3 at = shown_mm(surface_->place[i].triangle, surface_->place[i].bary);
  size_t b = 0, f = 0;
  while (b < before.size() || f < found.size()) {
    if (f == found.size() || (b < before.size() && before[b].held.sheet < found[f].sheet)) {  // no longer found
      Pair& p = before[b++];
      if (p.s_mm > 0) {
        chunk.changed = true;
      } else {
        reprojected = true;
        leave_foot(p);
        // A pair found in front of the place, whose depth was never tested, does not press: it goes, as long as the
        // place is not damped.
        p.held.weight *= p.held.depth_tested || l.projections > kMostProjections ? 1 - part : 0;
        p.held.depth_tested = true;  // just now: else the pair would be stale at every check, and never stand still
        p.held.facet =
            carried_normal(p.held.triangle, p.held.bary, tissue_.smooth_normal(p.held.triangle, p.held.bary));
        if (p.held.weight > kNothing)
          place(p);
        else
          chunk.changed = true;
      }
    } else if (b == before.size() || found[f].sheet < before[b].held.sheet) {  // new
      Pair p;
      p.held = found[f++];
      p.s_mm = -p.held.gap_mm;
      if (p.s_mm < 0) p.held.weight *= part;
      place(p);
    } else {
      Pair& p = before[b++];
      const HeldContact& n = found[f++];
      if (!p.stale && std::abs(n.weight - p.held.weight) < constant::weight_step) {
        out.push_back(p);
        continue;
      }
      leave_foot(p);
      const HeldContact was = p.held;
      const Vec3 was_apart_mm = apart_mm(p);
      p.held = n;
      if (was.depth_tested && part < 1) {
        p.held.weight = was.weight + part * (n.weight - was.weight);
        p.held.normal = (was.normal + part * (n.normal - was.normal)).normalized();
      }
      p.s_mm = p.held.normal.dot(at - shown_mm(n.triangle, n.bary));
      place(p, &was, was_apart_mm);
    }
  }
  if (reprojected) ++l.projections, ++chunk.reprojected;
}

// Broad phase: the cells that hold the places which are due.
void ContactFinder::find_cells(size_t chunk) {
  Chunk& here = chunk_[chunk];
  here.located.clear(), here.unknown.clear();
  if (!here.due) return;
  std::vector<Located> next;
  next.reserve(here.before.size() + 16);
  std::vector<Point> point;
  std::vector<Around> around;
  std::vector<uint8_t> relation;
  size_t pair = 0, old = 0;
  for (size_t k = here.first; k < here.last; ++k) {
    Group& g = group_[k];
    const size_t begin = pair;
    while (pair < here.pair.size() && size_t(here.pair[pair].held.place) < g.last) ++pair;
    if (g.relist) begin_list(g, {here.pair.data() + begin, pair - begin});
    if (g.due) g.near_mm = 0;
    point.clear();
    for (size_t i = g.first; i < g.last; ++i)
      if (state_[i].due)
        point.push_back({i, (surface_->place[i].X_mm + displacement(surface_->place[i].embedded)).cast<float>()});
    if (!point.empty()) broad_phase(g, point, around, relation);
    size_t queries = 0;
    for (size_t i = g.first; i < g.last; ++i) {
      PlaceState& l = state_[i];
      const size_t was = old, now = here.located.size();
      while (old < here.before.size() && size_t(here.before[old].place) == i) ++old;
      if (l.due) {
        locate(point[queries++], around, here.located), ++here.queries;
        l.due = l.stale || !unmoved({here.located.begin() + ptrdiff_t(now), here.located.end()},
                                    {here.before.begin() + ptrdiff_t(was), here.before.begin() + ptrdiff_t(old)});
        if (!l.due) here.located.resize(now);
      }
      if (l.due)
        next.insert(next.end(), here.located.begin() + ptrdiff_t(now), here.located.end());
      else
        next.insert(next.end(), here.before.begin() + ptrdiff_t(was), here.before.begin() + ptrdiff_t(old));
      for (size_t h = now; h < here.located.size(); ++h)
        if (!tissue_.known(here.located[h].part)) here.unknown.push_back(here.located[h].part);
    }
  }
  here.before.swap(next);
}

bool ContactFinder::unmoved(std::span<const Located> now, std::span<const Located> before) const {
  return std::equal(now.begin(), now.end(), before.begin(), before.end(), [&](const Located& a, const Located& b) {
    const auto moved_mm = [&] { return (a.at - b.at).cwiseProduct(tissue_.size_mm(size_t(a.copy))).norm(); };
    return a.copy == b.copy && a.in == b.in && moved_mm() < constant::slide_mm;
  });
}

void ContactFinder::find_pairs(size_t chunk) {
  Chunk& here = chunk_[chunk];
  if (!here.due) return;
  std::vector<Pair> out;
  out.reserve(here.pair.size() + 16);
  std::vector<HeldContact> found;
  const size_t first = group_[here.first].first, last = group_[here.last - 1].last;
  size_t pair = 0, at = 0;
  for (size_t i = first; i < last; ++i) {
    size_t end = pair;
    while (end < here.pair.size() && size_t(here.pair[end].held.place) == i) ++end;
    const std::span<Pair> before(here.pair.data() + pair, end - pair);
    pair = end;
    if (!state_[i].due) {
      out.insert(out.end(), before.begin(), before.end());
      continue;
    }
    end = at;
    while (end < here.located.size() && size_t(here.located[end].place) == i) ++end;
    found.clear();
    narrow_phase(i, {here.located.data() + at, end - at}, found);
    at = end;
    merge(i, before, found, here, out);
  }
  here.pair.swap(out);
}

bool ContactFinder::follow(std::span<const Vec3f> u, Workers& workers, bool step_begins) {
  ++counts_.checks;
  friction_.step_begins = step_begins;
  if (!motion_.measure(u) && !resumed_ && friction_.coefficient == 0) return false;
  bool changed = std::exchange(resumed_, false);  // the list is that of another moment
  for (size_t i = 0; i < u_.size(); ++i) u_[i] = v4{u[i][0], u[i][1], u[i][2], 0};
  cells_.move(u);
  const auto each = [&](auto&& work) {
    workers.parallel_for(chunk_.size(), kChunks, [&](size_t begin, size_t end) {
      for (size_t c = begin; c < end; ++c) work(c);
    });
  };
  each([&](size_t c) { check(c); });
  since_sorted_mm_ += motion_.most_mm();
  if (std::any_of(chunk_.begin(), chunk_.end(), [](const Chunk& c) { return c.due; })) {
    ++counts_.searches;
    cells_.refit(workers);
    if (since_sorted_mm_ > kSorted_mm) cells_.sort(), since_sorted_mm_ = 0;
    each([&](size_t c) { find_cells(c); });
    std::vector<int32_t> unknown;
    for (const Chunk& c : chunk_) unknown.insert(unknown.end(), c.unknown.begin(), c.unknown.end());
    if (!unknown.empty()) tissue_.learn(unknown, workers);
    each([&](size_t c) { find_pairs(c); });
  }
  if (friction_.coefficient > 0) each([&](size_t c) { grip(c); });
  near_ = false;
  for (Chunk& c : chunk_) {
    changed |= c.changed, near_ |= c.nearest_mm < kNear_mm;
    counts_.queries += c.queries, counts_.reprojected += c.reprojected;
    c.queries = c.reprojected = 0;
  }
  if (!changed) return false;
  contacts_.clear();
  for (const Chunk& c : chunk_)
    for (const Pair& p : c.pair)
      if (p.held.weight > kNothing) contacts_.push_back(p.contact);
  counts_.pairs = contacts_.size(), counts_.damped = 0;
  for (const PlaceState& l : state_) counts_.damped += l.projections > kMostProjections;
  return true;
}

ContactMemory ContactFinder::memory() const {
  ContactMemory m;
  for (const Chunk& c : chunk_)
    for (const Pair& p : c.pair) m.pairs.push_back(p.held);
  for (size_t i = 0; i < state_.size(); ++i)
    if (state_[i].projections > 0 || !state_[i].slid_mm.isZero(0))
      m.damping.push_back({int32_t(i), state_[i].projections, state_[i].slid_mm});
  return m;
}

void ContactFinder::resume(const ContactMemory& m) {
  const auto wrong = [] {
    throw InputError("", 0, "a held contact is of another surface; expected pairs of this one");
  };
  for (const HeldContact& h : m.pairs)
    if (h.place < 0 || size_t(h.place) >= state_.size() || h.triangle < 0 || size_t(h.triangle) >= surface_->tri.size())
      wrong();
  for (const ContactMemory::Damping& d : m.damping)
    if (d.place < 0 || size_t(d.place) >= state_.size()) wrong();
  for (Chunk& c : chunk_) c.pair.clear(), c.before.clear(), c.left_mm = 0;
  resumed_ = true;
  for (PlaceState& l : state_) l = PlaceState();
  for (Group& g : group_)
    g.far_mm = g.near_mm = kNever_mm;  // all look at the next step: what they then find beside is new
  for (const HeldContact& h : m.pairs) {
    Pair p;
    p.held = h;
    make_contact(p);
    chunk_[chunk_of_[size_t(h.place)]].pair.push_back(p);
  }
  for (const ContactMemory::Damping& d : m.damping)
    state_[size_t(d.place)].projections = d.projections, state_[size_t(d.place)].slid_mm = d.slid_mm;
}

}  // namespace limberg
