// Which part of the blade is real: patches between barriers, inside or outside by unanimous vote, seeded or not.
#include <algorithm>

#include "sim/cutting/arrangement/cut_builder.h"

namespace limberg {

CutBuilder::Outcome CutBuilder::find_patches(CutResult& result) {
  // Pieces go by their numbers among those of the whole blade.
  const size_t pieces_in_all = blade_divided_.all_pieces();
  UnionFind& patch = room_.patch;
  patch.reset(pieces_in_all);
  const auto root = [&](size_t piece) { return size_t(patch.find(int32_t(piece))); };
  const auto unite = [&](size_t a, size_t b) { patch.unite(int32_t(a), int32_t(b)); };

  std::vector<CutScratch::BorderEdge>& border = room_.border;
  std::vector<CutScratch::Vote>& votes = room_.vote;
  std::vector<uint8_t>& seeded = room_.seeded;
  seeded.assign(pieces_in_all, 0);
  for (size_t i = 0; i < blade_divided_.size(); ++i) {
    const auto pieces = blade_divided_.pieces(i);
    const size_t first = blade_divided_.first_piece(i);
    const uint8_t seed = i < blade_.seed.size() ? blade_.seed[i] : uint8_t(1);
    for (size_t t = 0; t < pieces.size(); ++t) {
      const size_t me = first + t;
      if (seed == 2) seeded[me] = 1;
      for (size_t k = 0; k < 3; ++k) {
        const int16_t label = pieces[t].label[k];
        const int32_t a = pieces[t].v[k], b = pieces[t].v[(k + 1) % 3];
        if (label == PlanarSplit::kFree) {
          unite(me, first + size_t(pieces[t].neighbour[k]));
        } else if (label < PlanarSplit::kJunction) {
          border.push_back({std::min(a, b), std::max(a, b), int32_t(me)});
        } else {
          const Barrier& barrier = barrier_[barrier_first_[i] + size_t(label - PlanarSplit::kJunction)];
          const int32_t f = barrier.f;
          // Next to its junction with f the piece lies on the side of f where its third corner is.
          const int side = store_.points.side(store_.orig[f].plane, pieces[t].v[(k + 2) % 3]);
          if (side == 0) return fail(coincidence, "a piece of the blade lies on the surface");
          votes.push_back({int32_t(me), bool(barrier.mat >> (side > 0 ? 0 : 1) & 1)});
          if (seed == 1 && store_.is_body(f)) seeded[me] = 1;
        }
      }
    }
  }
  if (shared_edge_.empty()) {  // nothing but pairs to find: no need to sort
    size_t slots = 64;
    while (slots < border.size()) slots *= 2;  // most are one of two
    std::vector<int32_t>& seen = room_.table;
    seen.assign(slots, -1);
    for (size_t i = 0; i < border.size(); ++i) {
      const CutScratch::BorderEdge& e = border[i];
      size_t at = size_t((uint64_t(uint32_t(e.a)) << 32 | uint32_t(e.b)) * 0x9e3779b97f4a7c15ull >> 32) & (slots - 1);
      while (seen[at] >= 0 && (border[size_t(seen[at])].a != e.a || border[size_t(seen[at])].b != e.b))
        at = (at + 1) & (slots - 1);
      if (seen[at] < 0)
        seen[at] = int32_t(i);
      else
        unite(size_t(e.piece), size_t(border[size_t(seen[at])].piece));
    }
    border.clear();
  }
  std::sort(border.begin(), border.end());
  for (size_t i = 0; i < border.size();) {
    size_t j = i;
    while (j < border.size() && border[j].a == border[i].a && border[j].b == border[i].b) ++j;
    if (std::binary_search(shared_edge_.begin(), shared_edge_.end(), std::pair(border[i].a, border[i].b))) {
      for (size_t m = i; m < j; ++m) {
        const size_t tri = blade_divided_.of_piece(size_t(border[m].piece));
        const auto& v = blade_divided_.pieces(tri)[size_t(border[m].piece) - blade_divided_.first_piece(tri)].v;
        int32_t third = v[0];
        for (int32_t p : v)
          if (p != border[m].a && p != border[m].b) third = p;
        const int vote = vote_at_shared_edge(border[m].a, border[m].b, first_orig_ + int32_t(tri), third);
        if (vote < 0) return fail(coincidence, "the blade lies on the wall that it continues");
        votes.push_back({border[m].piece, vote == 1});
        if (tri < blade_.seed.size() && blade_.seed[tri] == 3) seeded[size_t(border[m].piece)] = 1;
      }
    } else {
      if (j - i > 2) return fail(refused, "more than two triangles of the blade share an edge");
      if (j - i == 2) unite(size_t(border[i].piece), size_t(border[i + 1].piece));
    }
    i = j;
  }

  std::vector<int8_t> inside(pieces_in_all, -1);
  std::vector<uint8_t> seed_of(pieces_in_all, 0);
  for (const CutScratch::Vote& v : votes) {
    int8_t& known = inside[root(size_t(v.piece))];
    if (known >= 0 && known != int8_t(v.inside))
      return fail(coincidence, "the blade is both inside and outside the body");
    known = int8_t(v.inside);
  }
  int patches = 0, kept = 0;
  bool any_inside = false, seed_without_border = false, seed_inside = false;
  for (size_t i = 0; i < pieces_in_all; ++i) {
    if (root(i) == i) ++patches;
    if (seeded[i]) seed_of[root(i)] = 1;
    any_inside = any_inside || inside[root(i)] == 1;
  }
  for (size_t i = 0; i < pieces_in_all; ++i) {
    if (root(i) != i) continue;
    if (seed_of[i] && inside[i] < 0) seed_without_border = true;
    if (seed_of[i] && inside[i] == 1) seed_inside = true, ++kept;
  }
  result.patches = patches;
  result.patches_kept = kept;
  if (!seed_inside) {
    if (seed_without_border)
      return fail(refused, "the blade reaches no skin and no earlier cut: cut the skin first, and begin there");
    return any_inside ? fail(nothing, "nothing that was drawn is in material")
                      : fail(nothing, "the blade meets no material");
  }
  keep_.resize(pieces_in_all);
  for (size_t i = 0; i < keep_.size(); ++i) {
    const size_t r = root(i);
    keep_[i] = inside[r] == 1 && seed_of[r];
  }
  return ok;
}

}  // namespace limberg
