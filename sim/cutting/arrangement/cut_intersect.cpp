// Where the blade meets what exists: broad phase by groups of blade triangles, exact narrow phase, segments.
#include <algorithm>
#include <bit>

#include "sim/cutting/arrangement/cut_builder.h"
#include "sim/cutting/arrangement/radix_sort.h"

namespace limberg {

void CutBuilder::find_near() {
  // What a cut meets lies all over the store's arrays, so it is asked for in three rounds, each of which fetches what
  // the next one reads: triangles by the trees, their corners' names, the corners.
  const size_t n = blade_.tri.size();
  for (size_t i = 0; i < n; i = room_.group.back().end()) {
    const BoxGroup& group = room_.group.emplace_back(room_.box, i);
    const auto note = [&](int32_t o, const IntBox& box) {
      const uint32_t members = group.meeting(box);
      if (members == 0) return;
      const auto* at = reinterpret_cast<const char*>(&store_.orig[size_t(o)]);
      __builtin_prefetch(at);
      __builtin_prefetch(at + sizeof(OrigTri) - 1);
      room_.hit.push_back({o, uint32_t(room_.group.size() - 1), members});
    };
    const SlantBox around = slant_box(group.all, std::span(room_.triangle).subspan(i, group.count),
                                      std::span(room_.plane).subspan(i, group.count));
    store_.body_near(around, note);
    store_.blades_near(around, note);
  }
  for (const CutScratch::Hit& h : room_.hit)
    if (const OrigTri& o = store_.orig[size_t(h.orig)]; o.live != 0)
      for (int32_t v : o.v) store_.points.prefetch(v);
}

CutBuilder::Outcome CutBuilder::intersect() {
  find_near();
  auto& chosen = room_.chosen;
  for (auto& c : chosen) c.resize(std::max(c.size(), room_.hit.size() + 1));
  size_t h = 0;
  for (size_t g = 0; g < room_.group.size(); ++g) {
    std::array<size_t, BoxGroup::kMost> count{};
    room_.near.clear();
    for (; h < room_.hit.size() && room_.hit[h].group == g; ++h) {
      const OrigTri& o = store_.orig[size_t(room_.hit[h].orig)];
      if (o.live == 0) continue;
      const uint32_t at = uint32_t(room_.near.size());
      CutScratch::Near& near = room_.near.emplace_back();
      near.orig = room_.hit[h].orig;
      near.triangle.id = o.v;
      for (size_t k = 0; k < 3; ++k) near.triangle.p[k] = store_.points.integer(o.v[k]);
      for (uint32_t members = room_.hit[h].members; members != 0; members &= members - 1) {  // mostly one
        const size_t i = size_t(std::countr_zero(members));
        chosen[i][count[i]++] = at;
      }
    }
    const BoxGroup& group = room_.group[g];
    for (size_t i = 0; i < group.count; ++i)
      for (size_t j = 0; j < count[i]; ++j) {
        const CutScratch::Near& near = room_.near[chosen[i][j]];
        const size_t t = group.first + i;
        const Outcome outcome = intersect_with(first_orig_ + int32_t(t), room_.triangle[t], near.orig, near.triangle);
        if (outcome != ok) return outcome;
      }
  }
  // By existing triangle, then by blade triangle: they come by blade triangle.
  radix_sort(segment_, room_.segment_room, bits_of(uint64_t(first_orig_)),
             [](const Segment& s) { return uint64_t(s.f); });
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
    const int32_t point =
        e.edge_of_s ? store_.points.line_plane(a, b, f, plane_f) : store_.points.line_plane(a, b, s, plane_s);
    mark_.push_back({point, e.edge_of_s ? PlanarSplit::kFree : int16_t(e.edge)});
  }
  return ok;
}

}  // namespace limberg
