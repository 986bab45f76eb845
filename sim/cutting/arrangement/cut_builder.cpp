#include "sim/cutting/arrangement/cut_builder.h"

#include <algorithm>

#include "sim/base/text.h"
#include "sim/cutting/arrangement/radix_sort.h"
#include "sim/cutting/arrangement/sign_sort.h"

namespace limberg {

namespace {

CutScratch& scratch_of(ArrangementStore& store) {
  if (!store.scratch) store.scratch = std::make_shared<CutScratch>();
  store.scratch->clear();
  return *store.scratch;
}

}  // namespace

CutBuilder::CutBuilder(ArrangementStore& store, const Blade& blade, std::vector<Int3> vertex)
    : store_(store), blade_(blade), vertex_(std::move(vertex)), room_(scratch_of(store)) {
  delta_ = store.begin_delta(LastOperation::cut);
}

CutBuilder::Outcome CutBuilder::run(CutResult& result) {
  Outcome o = ok;
  try {
    o = prepare();
    if (o == ok) o = intersect();
    if (o == ok) o = take_shared_edges();
    if (o == ok) o = divide();
    if (o == ok) o = divide_blade();
    if (o == ok) o = find_patches(result);
    if (o == ok) o = commit(result);
  } catch (...) {  // out of memory
    abandon();
    throw;
  }
  if (o != ok) abandon();
  return o;
}

// Without asking for memory, which may be what has failed. The components are what they were: a try does not touch them
// before it has succeeded.
void CutBuilder::abandon() {
  store_.edges.end_changes();
  if (in_edges_) {
    for (size_t f = size_t(delta_.faces); f < store_.face.size(); ++f)
      if (const Face& made = store_.face[f]; made.live()) store_.edges.remove(int32_t(f), made.v, made.outer());
  }
  for (int32_t f : delta_.retired) {
    Face& back = store_.face[f];
    back.retired = false;
    if (in_edges_ && back.live()) store_.edges.add(f, back.v, back.outer());
  }
  store_.take_back_arrays(delta_);
  if (committing_) store_.last = std::move(last_before_);
}

CutBuilder::Outcome CutBuilder::prepare() {
  room_.triangle = int_triangles(vertex_, blade_.tri);
  room_.plane.clear();
  room_.box.clear();
  for (const IntTriangle& t : room_.triangle) {
    room_.plane.push_back(plane_through(t.p[0], t.p[1], t.p[2]));
    room_.box.push_back(box_around(t.p[0], t.p[1], t.p[2]));
  }
  const FaultPlan* fault = store_.points.fault;
  if (!fault || !fault->skip_embedding)
    if (const std::string why = check_embedded(room_.triangle, room_.plane, room_.box); !why.empty()) {
      reason_ = why;
      return coincidence;
    }
  if (store_.points.fails()) return fail(coincidence, "made to fail");
  op_ = int32_t(store_.op.size());
  first_orig_ = int32_t(store_.orig.size());
  store_.op.push_back({first_orig_, blade_.uv_mm, blade_.strip, {}});
  blade_point_.resize(vertex_.size());
  for (size_t i = 0; i < vertex_.size(); ++i) {
    const int32_t shared = i < blade_.shared_point.size() ? blade_.shared_point[i] : -1;
    continues_ = continues_ || shared >= 0;
    blade_point_[i] = shared >= 0 ? shared : store_.points.add_explicit(vertex_[i]);
  }
  for (size_t i = 0; i < blade_.tri.size(); ++i) {
    OrigTri o;
    for (size_t k = 0; k < 3; ++k) o.v[k] = blade_point_[size_t(blade_.tri[i][k])];
    room_.triangle[i].id = o.v;
    o.plane = room_.plane[i];
    o.op = op_;
    store_.orig.push_back(o);
  }
  return ok;
}

int16_t CutBuilder::label_of(int32_t point, int32_t orig) const {
  const auto* ends = store_.points.edge_of(point);
  if (!ends) return PlanarSplit::kFree;
  return int16_t(store_.edge_of_orig(orig, (*ends)[0], (*ends)[1]));  // -1 == kFree: an edge of the other triangle
}

bool CutBuilder::crosses(const Constraint& c, const Plane& plane_s, const Plane& plane_g, int32_t p, int32_t q,
                         bool& zero) const {
  const PointStore& points = store_.points;
  if (c.a == p || c.a == q || c.b == p || c.b == q) return false;  // they end in one point, through a shared edge
  const int a = points.side(plane_s, c.a), b = points.side(plane_s, c.b);
  if (a == b && a != 0) return false;
  const int sp = points.side(plane_g, p), sq = points.side(plane_g, q);
  if (sp == sq && sp != 0) return false;
  if (a == 0 || b == 0 || sp == 0 || sq == 0) {
    zero = true;
    return false;
  }
  return true;
}

CutBuilder::Outcome CutBuilder::divide() {
  static_assert(PlanarSplit::kFree == -1);
  for (size_t i = 0; i < segment_.size();) {
    Touched& t = touched_.emplace_back();
    t.orig = segment_[i].f;
    t.first = uint32_t(i);
    t.division = uint32_t(touched_.size() - 1);
    while (i < segment_.size() && segment_[i].f == t.orig) ++i;
    t.count = uint32_t(i) - t.first;
  }
  constexpr size_t kAhead = 4;
  std::vector<Mark>& between = room_.between;
  PlanarSplit& split = room_.split;
  for (size_t at = 0; at < touched_.size(); ++at) {
    Touched& t = touched_[at];
    if (at + kAhead < touched_.size()) {  // met in no order: fetched ahead
      const int32_t whole = store_.orig[touched_[at + kAhead].orig].whole;
      if (whole >= 0) __builtin_prefetch(&store_.face[whole]);
    }
    const OrigTri f = store_.orig[t.orig];
    split.open(store_, t.orig);
    const std::span<const Constraint> junctions = store_.constraints_of(t.orig);
    for (size_t i = t.first; i < t.first + t.count; ++i) {
      Segment& seg = segment_[i];
      const Plane& plane_s = store_.orig[seg.s].plane;
      const int32_t p = marks(seg)[0].point, q = marks(seg)[1].point;
      between.clear();
      for (size_t j = 0; j < junctions.size(); ++j) {
        const Constraint& c = junctions[j];
        const Plane& plane_g = store_.orig[c.partner].plane;
        bool zero = false;
        if (crosses(c, plane_s, plane_g, p, q, zero))
          between.push_back({store_.points.three_planes({t.orig, c.partner, seg.s}, f.plane, plane_g, plane_s),
                             int16_t(PlanarSplit::kJunction + int(j))});
        if (zero) return fail(coincidence, "the blade meets a junction of earlier cuts");
      }
      if (between.empty()) continue;
      // Along the segment. It goes to the end of the list of marks, where there is room.
      const int axis = store_.points.longest_axis(p, q);
      const int forward = store_.points.order(axis, q, p);
      if (forward == 0) return fail(coincidence, "a cut line without length");
      sort_by_signs(between.begin(), between.end(), [&](const Mark& a, const Mark& b) {
        return store_.points.order(axis, b.point, a.point) == forward;
      });
      const Mark ends[2] = {marks(seg)[0], marks(seg)[1]};
      seg.first = uint32_t(mark_.size());
      seg.count = uint32_t(between.size()) + 2;
      mark_.push_back(ends[0]);
      mark_.insert(mark_.end(), between.begin(), between.end());
      mark_.push_back(ends[1]);
      for (size_t j = 1; j + 1 < seg.count; ++j)
        if (store_.points.order(axis, marks(seg)[j + 1].point, marks(seg)[j].point) != forward)
          return fail(coincidence, "two junctions of earlier cuts meet the blade in one point");
    }
    size_t in_the_end = junctions.size();
    for (size_t i = t.first; i < t.first + t.count; ++i) in_the_end += segment_[i].count - 1;
    if (in_the_end > PlanarSplit::kMostJunctions)
      return fail(refused,
                  text("more than %zu cut lines would cross in one triangle of the body", PlanarSplit::kMostJunctions));
    for (size_t i = t.first; i < t.first + t.count; ++i)
      for (const Mark& m : marks(segment_[i]))
        if (!split.insert(m.point, m.label))
          return fail(coincidence, "a point of the cut falls on a junction of earlier cuts");
    for (size_t i = t.first; i < t.first + t.count; ++i) {
      const Segment& seg = segment_[i];
      const auto along = marks(seg);
      for (size_t j = 0; j + 1 < along.size(); ++j) {
        const int32_t a = along[j].point, b = along[j + 1].point;
        if (!split.enforce(a, b, seg.s)) return fail(coincidence, "a cut line runs along a junction of earlier cuts");
        const auto [piece, k] = split.enforced();
        if (piece < 0) continue;  // no material
        const auto& here = split.pieces()[size_t(piece)];
        const int32_t n = here.neighbour[size_t(k)];
        if (n < 0 || split.pieces()[size_t(n)].mat != here.mat)
          return fail(coincidence, "a cut line runs along a border");
        barrier_.push_back({seg.s, seg.f, a, b, label_of(a, seg.s), label_of(b, seg.s), uint32_t(at), here.mat});
        ++t.sub_edges;
      }
    }
    room_.divided.keep(split);
  }
  // By blade triangle, then by existing one (they come so), then by ends.
  radix_sort(barrier_, room_.barrier_room, bits_of(blade_.tri.size()),
             [&](const Barrier& b) { return uint64_t(b.s - first_orig_); });
  for (size_t i = 1; i < barrier_.size(); ++i)
    for (size_t j = i; j > 0 && barrier_[j - 1].s == barrier_[j].s && barrier_[j - 1].f == barrier_[j].f &&
                       std::tie(barrier_[j].a, barrier_[j].b) < std::tie(barrier_[j - 1].a, barrier_[j - 1].b);
         --j)
      std::swap(barrier_[j - 1], barrier_[j]);
  return ok;
}

CutBuilder::Outcome CutBuilder::divide_blade() {
  for (const Barrier& b : barrier_)
    for (const auto& [p, k] : {std::pair(b.a, b.label_a), std::pair(b.b, b.label_b)}) {
      if (k == PlanarSplit::kFree) continue;
      const auto& v = store_.orig[b.s].v;
      const int32_t u = v[size_t(k)], w = v[size_t(k + 1) % 3];
      edge_point_.push_back({std::min(u, w), std::max(u, w), p});
    }
  std::sort(edge_point_.begin(), edge_point_.end());
  edge_point_.erase(std::unique(edge_point_.begin(), edge_point_.end()), edge_point_.end());

  PlanarSplit& split = room_.split;
  barrier_first_.reserve(blade_.tri.size());
  size_t next = 0;
  for (size_t i = 0; i < blade_.tri.size(); ++i) {
    const int32_t s = first_orig_ + int32_t(i);
    const OrigTri& o = store_.orig[s];
    split.open(store_.points, o.plane, o.v);
    for (size_t k = 0; k < 3; ++k) {
      const int32_t lo = std::min(o.v[k], o.v[(k + 1) % 3]), hi = std::max(o.v[k], o.v[(k + 1) % 3]);
      for (auto it = std::lower_bound(edge_point_.begin(), edge_point_.end(), std::array<int32_t, 3>{lo, hi, -1});
           it != edge_point_.end() && (*it)[0] == lo && (*it)[1] == hi; ++it)
        if (!split.insert((*it)[2], int16_t(k))) return fail(coincidence, "two cut lines meet on an edge of the blade");
    }
    const size_t begin = next;
    barrier_first_.push_back(begin);
    while (next < barrier_.size() && barrier_[next].s == s) ++next;
    if (next - begin > PlanarSplit::kMostJunctions)
      return fail(refused, text("one triangle of the blade would be crossed by more than %zu lines",
                                PlanarSplit::kMostJunctions));
    for (size_t j = begin; j < next; ++j)
      for (const auto& [p, k] :
           {std::pair(barrier_[j].a, barrier_[j].label_a), std::pair(barrier_[j].b, barrier_[j].label_b)})
        if (k == PlanarSplit::kFree && !split.insert(p, PlanarSplit::kFree))
          return fail(coincidence, "two cut lines meet on the blade");
    for (size_t j = begin; j < next; ++j)
      if (!split.enforce(barrier_[j].a, barrier_[j].b, barrier_[j].f))
        return fail(coincidence, "cut lines cross on the blade");
    blade_divided_.keep(split);
  }
  return ok;
}

}  // namespace limberg
