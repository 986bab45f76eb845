// Where the blade meets what exists: broad phase by groups of blade triangles, exact narrow phase, segments.
#include <algorithm>

#include "sim/cutting/cut_builder.h"
#include "sim/cutting/radix_sort.h"

namespace limberg {

namespace {

// Neighbours in the blade's list are mostly neighbours in space: one walk down each tree serves several.
constexpr size_t kGroup = 8;

}  // namespace

void CutBuilder::find_near() {
  // What a cut meets lies all over the store's arrays, so it is asked for in three rounds, each of which fetches what
  // the next one reads: triangles by the trees, their corners' names, the corners.
  const size_t n = blade_.tri.size();
  room_.box.clear();
  for (const IntTriangle& t : room_.triangle) room_.box.push_back(box_around(t.p[0], t.p[1], t.p[2]));
  for (size_t first = 0; first < n; first += kGroup) {
    room_.hit_first.push_back(room_.hit.size());
    IntBox group = room_.box[first];
    for (size_t i = first + 1; i < std::min(first + kGroup, n); ++i) group = box_around(group, room_.box[i]);
    for (const auto& tree : store_.forest)
      tree->boxes.box(group, [&](int32_t t) {
        const int32_t o = tree->first + t;
        const auto* at = reinterpret_cast<const char*>(&store_.orig[size_t(o)]);
        __builtin_prefetch(at);
        __builtin_prefetch(at + sizeof(OrigTri) - 1);
        room_.hit.push_back(o);
      });
  }
  room_.hit_first.push_back(room_.hit.size());
  for (int32_t o : room_.hit)
    if (store_.orig[size_t(o)].live != 0)
      for (int32_t v : store_.orig[size_t(o)].v) store_.points.prefetch(v);
}

CutBuilder::Outcome CutBuilder::intersect() {
  find_near();
  std::array<std::vector<uint32_t>, kGroup>& chosen = room_.chosen;
  for (size_t g = 0; g + 1 < room_.hit_first.size(); ++g) {
    const size_t first = g * kGroup, last = std::min(first + kGroup, blade_.tri.size());
    // The group's boxes, one coordinate beside another.
    std::array<std::array<int32_t, kGroup>, 3> lo, hi;
    for (size_t i = 0; i < kGroup; ++i)
      for (size_t k = 0; k < 3; ++k) {
        const IntBox& b = room_.box[std::min(first + i, last - 1)];
        lo[k][i] = b.lo[int(k)], hi[k][i] = b.hi[int(k)];
      }
    const size_t most = room_.hit_first[g + 1] - room_.hit_first[g];
    std::array<size_t, kGroup> count{};
    for (auto& c : chosen) c.resize(std::max(c.size(), most + 1));
    room_.near.clear();
    for (size_t h = room_.hit_first[g]; h < room_.hit_first[g + 1]; ++h) {
      const OrigTri& o = store_.orig[size_t(room_.hit[h])];
      if (o.live == 0) continue;
      CutScratch::Near& near = room_.near.emplace_back();
      near.orig = room_.hit[h];
      near.triangle.id = o.v;
      for (size_t k = 0; k < 3; ++k) near.triangle.p[k] = store_.points.integer(o.v[k]);
      near.box = box_around(near.triangle.p[0], near.triangle.p[1], near.triangle.p[2]);
      const IntBox& b = near.box;
      std::array<int32_t, kGroup> apart;  // negative: they are
      for (size_t i = 0; i < kGroup; ++i)
        apart[i] = (hi[0][i] - b.lo.x) | (b.hi.x - lo[0][i]) | (hi[1][i] - b.lo.y) | (b.hi.y - lo[1][i]) |
                   (hi[2][i] - b.lo.z) | (b.hi.z - lo[2][i]);
      for (size_t i = 0; i < kGroup; ++i) {
        chosen[i][count[i]] = uint32_t(room_.near.size() - 1);
        count[i] += apart[i] >= 0;
      }
    }
    for (size_t i = first; i < last; ++i)
      for (size_t j = 0; j < count[i - first]; ++j) {
        const CutScratch::Near& near = room_.near[chosen[i - first][j]];
        const Outcome outcome = intersect_with(first_orig_ + int32_t(i), room_.triangle[i], near.orig, near.triangle);
        if (outcome != ok) return outcome;
      }
  }
  // By existing triangle, then by blade triangle: they come by blade triangle.
  radix_sort(segment_, room_.segment_room, bits_of(uint64_t(first_orig_)), [](const Segment& s) { return uint64_t(s.f); });
  return ok;
}

CutBuilder::Outcome CutBuilder::intersect_with(int32_t s, const IntTriangle& ts, int32_t f, const IntTriangle& tf) {
  if (continues_) {
    bool shares = false;
    for (int32_t a : ts.id)
      for (int32_t b : tf.id) shares = shares || a == b;
    if (shares)
      return meet_beyond_shared(ts, tf) || store_.points.fails()
                 ? fail(coincidence, "the blade runs through the wall that it continues")
                 : ok;
  }
  // Points that it shares cannot be redrawn: in their planes lie triangles that the blade never touches.
  const auto& cross = continues_ ? cross_triangles_exactly : cross_triangles;
  const Plane &plane_s = store_.orig[size_t(s)].plane, &plane_f = store_.orig[size_t(f)].plane;
  const Crossing c = cross(ts, plane_s, tf, plane_f);
  if (c.kind == Crossing::apart) return ok;
  if (c.kind == Crossing::coincidence || store_.points.fails())
    return fail(coincidence, "the blade touches the surface in a way that cannot be resolved");
  segment_.push_back({s, f, uint32_t(mark_.size()), 2});
  for (const CrossingEnd& e : c.end) {
    const auto& v = (e.edge_of_s ? ts : tf).id;
    const int32_t a = v[size_t(e.edge)], b = v[size_t(e.edge + 1) % 3];
    const int32_t point = e.edge_of_s ? store_.points.line_plane(a, b, f, plane_f) : store_.points.line_plane(a, b, s, plane_s);
    mark_.push_back({point, e.edge_of_s ? PlanarSplit::kFree : int16_t(e.edge)});
  }
  return ok;
}

}  // namespace limberg
