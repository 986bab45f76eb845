#include "sim/contact/contact_finder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/error.h"

namespace limberg {
namespace {

constexpr size_t kGrain = 32, kChunks = 4, kVertexGrain = 1024;  // places of a chunk, ...
constexpr double kNothing = 1e-4;   // a pair of this weight is left out: its force is below single precision
constexpr double kNear_mm = 0.3;    // clearance of pairs that may press within a few iterations
constexpr double kTurn_mm = 0.08;   // less motion turns no surface by the angle that counts
constexpr double kLeast_mm = 0.005; // pairs are looked at again after so much motion at least
constexpr int kFresh = 2;           // turns in one spot that go all the way
constexpr int kTired = 8;           // the last one

Vec3 displaced(const EmbeddedPoint& e, std::span<const Vec3f> u) {
  Vec3 d = Vec3::Zero();
  double sum = 0;
  for (size_t i = 0; i < 8; ++i)
    if (e.w[i] != 0) d += double(e.w[i]) * u[size_t(e.node[i])].cast<double>(), sum += double(e.w[i]);
  return d / sum;
}

Vec3f moved_by(const EmbeddedPoint& e, std::span<const Vec3f> u) {
  Vec3f d = Vec3f::Zero();
  for (size_t i = 0; i < 8; ++i) d += e.w[i] * u[size_t(e.node[i])];
  return d;
}

}  // namespace

ContactFinder::ContactFinder(std::shared_ptr<const ContactSurface> surface, const FemModel& model, const ContactSettings& settings)
    : surface_(std::move(surface)), settings_(settings), cell_mm_(std::cbrt(model.cell_mm.prod())),
      turn_cos_(std::cos(settings.turn_deg * std::numbers::pi / 180)), tree_(surface_->X_mm, surface_->tri, surface_->sheets.of),
      neighbours_(surface_), motion_(*surface_, model), x_(surface_->X_mm.size()), looked_(surface_->place.size()) {
  Guess none;
  none.fill(-1);
  guess_.assign(surface_->place.size(), none);
  chunk_.resize((surface_->place.size() + kGrain - 1) / kGrain);
  counts_.places = surface_->place.size(), counts_.triangles = surface_->tri.size();
}

Vec3 ContactFinder::facet(int32_t t, std::span<const Vec3f> u) const {
  const Tri& c = surface_->tri[size_t(t)];
  std::array<Vec3, 3> x;
  for (size_t k = 0; k < 3; ++k) x[k] = surface_->X_mm[size_t(c[k])] + displaced(surface_->embedding[size_t(c[k])], u);
  const Vec3 n = area_vector2(x[0], x[1], x[2]);
  const double l = n.norm();
  return l > 0 ? Vec3(n / l) : n;
}

// Which places must look, and which pairs have had their time.
void ContactFinder::check(size_t chunk, std::span<const Vec3f> u) {
  Chunk& here = chunk_[chunk];
  here.changed = here.due = false;
  const size_t first = chunk * kGrain, last = std::min(first + kGrain, looked_.size());
  double moved = 0;
  for (size_t i = first; i < last; ++i) {
    Looked& l = looked_[i];
    const Vec3f at = moved_by(surface_->place[i].embedded, u);
    const double m = motion_.apart(i, at - l.at_mm);
    l.at_mm = at;
    moved = std::max(moved, m);
    l.travelled_mm += m;
    l.stale = false;
    l.due = l.travelled_mm > l.free_mm;
    here.due |= l.due;
  }
  here.left_mm -= moved, here.nearest_mm -= moved;
  if (here.left_mm > 0) return;
  here.left_mm = here.nearest_mm = 1e30;
  for (Pair& p : here.pair) {
    const HeldContact& h = p.held;
    const size_t i = size_t(h.place);
    Looked& l = looked_[i];
    const Vec3 apart = p.rest_apart_mm + displaced(p.contact.a, u) - displaced(p.contact.b, u);
    p.s_mm = h.normal.dot(apart) - h.gap_mm;
    Vec3 slid = apart - h.apart_mm;
    slid -= h.normal.dot(slid) * h.normal;
    double left = h.judged ? (p.s_mm < 0 ? kTurn_mm : p.s_mm + kTurn_mm) : p.s_mm;
    p.stale = left < 0;
    if (!p.stale && p.s_mm < settings_.guard_mm) {
      const bool tired = l.turns > kTired && (l.slid_mm + slid).norm() < settings_.spot_mm;
      if (!tired) {
        const double more = settings_.slide_mm + std::max(0.0, p.s_mm) - slid.norm();
        p.stale = more < 0 || (p.s_mm < 0 && facet(h.triangle, u).dot(h.facet) < turn_cos_);
        left = std::min(left, more);
      }
    }
    here.left_mm = std::min(here.left_mm, std::max(left, kLeast_mm));
    if (h.weight > kNothing) here.nearest_mm = std::min(here.nearest_mm, p.s_mm);
    if (!p.stale) continue;
    l.slid_mm += slid;
    if (l.slid_mm.norm() > settings_.spot_mm) l.slid_mm = Vec3::Zero(), l.turns = 0;
    l.stale = here.due = true;
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
  c.gap_mm = float(f.gap_mm - settings_.slack_mm);
  c.soft_mm = float(settings_.soft_mm);
  c.k_N_per_mm = float(1e-3 * f.weight * settings_.stiffness * place.stiffness_kPa * place.area_mm2 / cell_mm_);
}

// Pairs of one place: what was held goes to what is found, or stays.
void ContactFinder::merge(size_t i, std::span<Pair> before, std::vector<HeldContact>& found, std::span<const Vec3f> u, Chunk& chunk,
                          std::vector<Pair>& out) {
  Looked& l = looked_[i];
  const double part = l.turns < kFresh ? 1 : 1.0 / (l.turns - kFresh + 2);
  bool turned = false;
  const auto place = [&](Pair p) {  // its place and its foot are where they are now; s_mm is given
    HeldContact& h = p.held;
    make_contact(p);
    h.apart_mm = p.rest_apart_mm + displaced(p.contact.a, u) - displaced(p.contact.b, u);
    // What the surfaces show is linear in their triangles, what the springs feel is trilinear in the cells: the gap makes up
    // the difference, so that a contact begins where it is seen to begin.
    h.gap_mm = h.normal.dot(h.apart_mm) - p.s_mm;
    p.contact.gap_mm = float(h.gap_mm - settings_.slack_mm);
    p.stale = false;
    out.push_back(p);
    chunk.changed = true;
    chunk.left_mm = 0;
    chunk.nearest_mm = std::min(chunk.nearest_mm, p.s_mm);
    turned |= p.s_mm < 0 && h.weight > kNothing;
  };
  const Tri& own = surface_->tri[size_t(surface_->place[i].triangle)];
  const Vec3 at = (x_[size_t(own[0])] + x_[size_t(own[1])] + x_[size_t(own[2])]) / 3;
  size_t b = 0, f = 0;
  while (b < before.size() || f < found.size()) {
    if (f == found.size() || (b < before.size() && before[b].held.sheet < found[f].sheet)) {  // no longer found
      Pair& p = before[b++];
      if (!p.stale && (p.s_mm < 0 || !l.due)) {
        out.push_back(p);
      } else if (p.s_mm > 0) {
        chunk.changed = true;
      } else {
        turned = true;
        p.held.weight *= 1 - part;
        p.held.facet = tree_.normal(p.held.triangle);
        if (p.held.weight > kNothing) place(p);
        else chunk.changed = true;
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
      if (!p.stale) {
        out.push_back(p);
        continue;
      }
      const double weight = p.held.weight;
      const Vec3 normal = p.held.normal;
      const bool pressed = p.held.judged;
      p.held = n;
      if (pressed && part < 1) {
        p.held.weight = weight + part * (n.weight - weight);
        p.held.normal = (normal + part * (n.normal - normal)).normalized();
      }
      const Tri& c = surface_->tri[size_t(n.triangle)];
      p.s_mm = p.held.normal.dot(at - n.bary[0] * x_[size_t(c[0])] - n.bary[1] * x_[size_t(c[1])] - n.bary[2] * x_[size_t(c[2])]);
      place(p);
    }
  }
  if (turned) ++l.turns, ++chunk.turned;
}

void ContactFinder::search(size_t chunk, std::span<const Vec3f> u) {
  Chunk& here = chunk_[chunk];
  if (!here.due) return;
  std::vector<Pair> out;
  out.reserve(here.pair.size() + 16);
  std::vector<HeldContact> found;
  const size_t first = chunk * kGrain, last = std::min(first + kGrain, looked_.size());
  size_t pair = 0;
  for (size_t i = first; i < last; ++i) {
    size_t end = pair;
    while (end < here.pair.size() && size_t(here.pair[end].held.place) == i) ++end;
    const std::span<Pair> before(here.pair.data() + pair, end - pair);
    pair = end;
    if (!looked_[i].due && !looked_[i].stale) {
      out.insert(out.end(), before.begin(), before.end());
      continue;
    }
    found.clear();
    if (looked_[i].due) {
      look(i, -1, found);
      looked_[i].travelled_mm = 0;
      ++here.looks;
    } else {
      for (const Pair& p : before)
        if (p.stale) look(i, p.held.sheet, found);
    }
    merge(i, before, found, u, here, out);
  }
  here.pair.swap(out);
}

bool ContactFinder::follow(std::span<const Vec3f> u, Workers& workers) {
  const ContactSurface& s = *surface_;
  ++counts_.checks;
  if (!motion_.measure(u) && !resumed_) return false;
  resumed_ = false;
  workers.parallel_for(chunk_.size(), kChunks, [&](size_t begin, size_t end) {
    for (size_t c = begin; c < end; ++c) check(c, u);
  });
  if (std::any_of(chunk_.begin(), chunk_.end(), [](const Chunk& c) { return c.due; })) {
    ++counts_.searches;
    workers.parallel_for(x_.size(), kVertexGrain, [&](size_t begin, size_t end) {
      for (size_t v = begin; v < end; ++v) x_[v] = s.X_mm[v] + displaced(s.embedding[v], u);
    });
    tree_.refit(x_, workers);
    workers.parallel_for(chunk_.size(), kChunks, [&](size_t begin, size_t end) {
      for (size_t c = begin; c < end; ++c) search(c, u);
    });
  }
  bool changed = false;
  near_ = false;
  for (Chunk& c : chunk_) {
    changed |= c.changed, near_ |= c.nearest_mm < kNear_mm;
    counts_.looks += c.looks, counts_.turned += c.turned;
    c.looks = c.turned = 0;
  }
  if (!changed) return false;
  contacts_.clear();
  for (Chunk& c : chunk_)
    for (const Pair& p : c.pair)
      if (p.held.weight > kNothing) contacts_.push_back(p.contact);
  counts_.pairs = contacts_.size(), counts_.tired = 0;
  for (const Looked& l : looked_) counts_.tired += l.turns > kTired;
  return true;
}

ContactMemory ContactFinder::memory() const {
  ContactMemory m;
  for (const Chunk& c : chunk_)
    for (const Pair& p : c.pair) m.pairs.push_back(p.held);
  for (size_t i = 0; i < looked_.size(); ++i)
    if (looked_[i].turns > 0 || !looked_[i].slid_mm.isZero(0)) m.spots.push_back({int32_t(i), looked_[i].turns, looked_[i].slid_mm});
  return m;
}

void ContactFinder::resume(const ContactMemory& m) {
  const auto wrong = [] { throw InputError("", 0, "a held contact is of another surface; expected pairs of this one"); };
  for (const HeldContact& h : m.pairs)
    if (h.place < 0 || size_t(h.place) >= looked_.size() || h.triangle < 0 || size_t(h.triangle) >= surface_->tri.size()) wrong();
  for (const ContactMemory::Spot& s : m.spots)
    if (s.place < 0 || size_t(s.place) >= looked_.size()) wrong();
  for (Chunk& c : chunk_) c.pair.clear();
  resumed_ = true;
  for (Looked& l : looked_) l = Looked();  // all look at the next step: what they then find beside is new
  for (const HeldContact& h : m.pairs) {
    Pair p;
    p.held = h;
    make_contact(p);
    chunk_[size_t(h.place) / kGrain].pair.push_back(p);
  }
  for (const ContactMemory::Spot& s : m.spots) looked_[size_t(s.place)].turns = s.turns, looked_[size_t(s.place)].slid_mm = s.slid_mm;
}

}  // namespace limberg
