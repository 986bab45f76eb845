#include "sim/cutting/cut_builder.h"

#include <algorithm>

namespace limberg {

CutBuilder::CutBuilder(ArrangementStore& store, const Blade& blade, std::vector<Int3> vertex)
    : store_(store), blade_(blade), vertex_(std::move(vertex)) {
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

void CutBuilder::abandon() {
  store_.edges.end_changes();
  if (committing_ && !accounted_) {  // taking back starts from a whole edge map
    for (int32_t f : store_.last.removed) store_.account(f, false);
    for (int32_t f : store_.last.added) store_.account(f, true);
  }
  if (store_.components_known) delta_.component = store_.component;  // a try does not touch them before it succeeds
  store_.take_back(delta_);
  if (committing_) store_.last = std::move(last_before_);
}

CutBuilder::Outcome CutBuilder::prepare() {
  tree_ = std::make_shared<OrigTree>();
  tree_->bvh = tree_over(vertex_, blade_.tri);
  const FaultPlan* fault = store_.points.fault;
  if (!fault || !fault->skip_embedding)
    if (const std::string why = check_embedded(vertex_, blade_.tri, tree_->bvh); !why.empty()) {
      reason_ = why;
      return coincidence;
    }
  if (store_.points.fails()) return fail(coincidence, "made to fail");
  op_ = int32_t(store_.op.size());
  first_orig_ = int32_t(store_.orig.size());
  store_.op.push_back({first_orig_, blade_.uv_mm, blade_.strip});
  blade_point_.resize(vertex_.size());
  for (size_t i = 0; i < vertex_.size(); ++i) {
    const int32_t shared = i < blade_.shared_point.size() ? blade_.shared_point[i] : -1;
    continues_ = continues_ || shared >= 0;
    blade_point_[i] = shared >= 0 ? shared : store_.points.add_explicit(vertex_[i]);
  }
  for (const Tri& t : blade_.tri) {
    OrigTri o;
    for (size_t k = 0; k < 3; ++k) o.v[k] = blade_point_[size_t(t[k])];
    o.plane = plane_through(vertex_[size_t(t[0])], vertex_[size_t(t[1])], vertex_[size_t(t[2])]);
    o.op = op_;
    store_.orig.push_back(o);
  }
  return ok;
}

IntTriangle CutBuilder::triangle(int32_t o) const {
  IntTriangle t;
  for (size_t k = 0; k < 3; ++k) t.id[k] = store_.orig[o].v[k], t.p[k] = store_.points.integer(t.id[k]);
  return t;
}

CutBuilder::Outcome CutBuilder::intersect() {
  struct Box {
    Vec3 lo, hi;
  };
  std::vector<Box> box(blade_.tri.size());
  for (size_t i = 0; i < box.size(); ++i) {
    const auto& v = store_.orig[first_orig_ + int32_t(i)].v;
    box[i].lo = box[i].hi = store_.points.approx(v[0]);
    for (size_t k = 1; k < 3; ++k) {
      box[i].lo = box[i].lo.cwiseMin(store_.points.approx(v[k]));
      box[i].hi = box[i].hi.cwiseMax(store_.points.approx(v[k]));
    }
  }
  // Neighbours in the blade's list are mostly neighbours in space: one walk down each tree serves several.
  constexpr size_t kGroup = 8;
  struct Near {
    Box box;
    int32_t orig = 0;
    IntTriangle triangle;
  };
  std::vector<Near> near;
  for (size_t i = 0; i < blade_.tri.size(); ++i) {
    if (i % kGroup == 0) {
      Box group = box[i];
      for (size_t j = i; j < std::min(i + kGroup, box.size()); ++j)
        group.lo = group.lo.cwiseMin(box[j].lo), group.hi = group.hi.cwiseMax(box[j].hi);
      near.clear();
      for (const auto& tree : store_.forest)
        tree->bvh.box(group.lo, group.hi, [&](int32_t t) {
          const int32_t o = tree->first + t;
          if (store_.orig[o].live == 0) return;
          Near& n = near.emplace_back();
          n.orig = o;
          n.triangle = triangle(o);
          const auto& v = store_.orig[o].v;
          const Vec3 &a = store_.points.approx(v[0]), &b = store_.points.approx(v[1]), &c = store_.points.approx(v[2]);
          n.box = {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
        });
    }
    const int32_t s = first_orig_ + int32_t(i);
    const IntTriangle ts = triangle(s);
    for (const Near& n : near) {
      if ((n.box.hi.array() < box[i].lo.array()).any() || (n.box.lo.array() > box[i].hi.array()).any()) continue;
      const Outcome outcome = intersect_with(s, ts, n.orig, n.triangle);
      if (outcome != ok) return outcome;
    }
  }
  std::sort(segment_.begin(), segment_.end(),
            [](const Segment& a, const Segment& b) { return std::tie(a.f, a.s) < std::tie(b.f, b.s); });
  return ok;
}

CutBuilder::Outcome CutBuilder::intersect_with(int32_t s, const IntTriangle& ts, int32_t f, const IntTriangle& tf) {
  bool shares = false;
  for (int32_t a : ts.id)
    for (int32_t b : tf.id) shares = shares || a == b;
  if (shares)
    return meet_beyond_shared(ts, tf) || store_.points.fails()
               ? fail(coincidence, "the blade runs through the wall that it continues")
               : ok;
  // Points that it shares cannot be redrawn: in their planes lie triangles that the blade never touches.
  const auto& cross = continues_ ? cross_triangles_exactly : cross_triangles;
  const Crossing c = cross(ts, store_.orig[s].plane, tf, store_.orig[f].plane);
  if (c.kind == Crossing::apart) return ok;
  if (c.kind == Crossing::coincidence || store_.points.fails())
    return fail(coincidence, "the blade touches the surface in a way that cannot be resolved");
  segment_.push_back({s, f, uint32_t(mark_.size()), 2});
  for (const CrossingEnd& e : c.end) {
    const int32_t owner = e.edge_of_s ? s : f, plane = e.edge_of_s ? f : s;
    const auto& v = store_.orig[owner].v;
    const int32_t point =
        store_.points.line_plane(v[size_t(e.edge)], v[size_t(e.edge + 1) % 3], plane, store_.orig[plane].plane);
    mark_.push_back({point, e.edge_of_s ? PlanarSplit::kFree : int16_t(e.edge)});
  }
  return ok;
}

int16_t CutBuilder::label_of(int32_t point, int32_t orig) const {
  const PointKey key = store_.points.key(point);
  if (key.kind != PointKey::line_plane) return PlanarSplit::kFree;
  return int16_t(store_.edge_of_orig(orig, key.id[0], key.id[1]));  // -1 == kFree: an edge of the other triangle
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
    Touched t;
    t.orig = segment_[i].f;
    t.first = i;
    while (i < segment_.size() && segment_[i].f == t.orig) ++i;
    t.count = i - t.first;
    touched_.push_back(std::move(t));
  }
  std::vector<Mark> between;
  for (Touched& t : touched_) {
    const OrigTri f = store_.orig[t.orig];
    t.scratch.open(store_, t.orig);
    const std::span<const Constraint> junctions =
        f.split >= 0 ? std::span<const Constraint>(store_.division[f.split].constraint) : std::span<const Constraint>();
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
      int axis = 0;
      (store_.points.approx(q) - store_.points.approx(p)).cwiseAbs().maxCoeff(&axis);
      const int forward = store_.points.order(axis, q, p);
      if (forward == 0) return fail(coincidence, "a cut line without length");
      std::sort(between.begin(), between.end(), [&](const Mark& a, const Mark& b) {
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
    for (size_t i = t.first; i < t.first + t.count; ++i)
      for (const Mark& m : marks(segment_[i]))
        if (!t.scratch.insert(m.point, m.label))
          return fail(coincidence, "a point of the cut falls on a junction of earlier cuts");
    for (size_t i = t.first; i < t.first + t.count; ++i) {
      const Segment& seg = segment_[i];
      const auto along = marks(seg);
      for (size_t j = 0; j + 1 < along.size(); ++j) {
        const int32_t a = along[j].point, b = along[j + 1].point;
        if (!t.scratch.enforce(a, b, seg.s))
          return fail(coincidence, "a cut line runs along a junction of earlier cuts");
        auto [piece, k] = t.scratch.find_edge(a, b);
        if (piece < 0) std::tie(piece, k) = t.scratch.find_edge(b, a);
        const auto& here = t.scratch.pieces()[size_t(piece)];
        const int32_t n = here.neighbour[size_t(k)];
        if (n < 0 || t.scratch.pieces()[size_t(n)].mat != here.mat)
          return fail(coincidence, "a cut line runs along a border");
        if (here.mat != 0) barrier_.push_back({seg.s, seg.f, a, b, size_t(&t - touched_.data()), here.mat});
      }
    }
  }
  std::sort(barrier_.begin(), barrier_.end(), [](const Barrier& a, const Barrier& b) {
    return std::tie(a.s, a.f, a.a, a.b) < std::tie(b.s, b.f, b.a, b.b);
  });
  return ok;
}

CutBuilder::Outcome CutBuilder::divide_blade() {
  for (const Barrier& b : barrier_)
    for (int32_t p : {b.a, b.b}) {
      const int16_t k = label_of(p, b.s);
      if (k == PlanarSplit::kFree) continue;
      const auto& v = store_.orig[b.s].v;
      const int32_t u = v[size_t(k)], w = v[size_t(k + 1) % 3];
      edge_point_.push_back({std::min(u, w), std::max(u, w), p});
    }
  std::sort(edge_point_.begin(), edge_point_.end());
  edge_point_.erase(std::unique(edge_point_.begin(), edge_point_.end()), edge_point_.end());

  blade_split_.resize(blade_.tri.size());
  barrier_first_.reserve(blade_.tri.size());
  size_t next = 0;
  for (size_t i = 0; i < blade_.tri.size(); ++i) {
    const int32_t s = first_orig_ + int32_t(i);
    const OrigTri& o = store_.orig[s];
    PlanarSplit& split = blade_split_[i];
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
    for (size_t j = begin; j < next; ++j)
      for (int32_t p : {barrier_[j].a, barrier_[j].b})
        if (label_of(p, s) == PlanarSplit::kFree && !split.insert(p, PlanarSplit::kFree))
          return fail(coincidence, "two cut lines meet on the blade");
    for (size_t j = begin; j < next; ++j)
      if (!split.enforce(barrier_[j].a, barrier_[j].b, barrier_[j].f))
        return fail(coincidence, "cut lines cross on the blade");
  }
  return ok;
}

}  // namespace limberg
