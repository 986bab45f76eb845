// Taking components of the sided surface away: their material bits are cleared, nothing else.
#include <algorithm>
#include <utility>

#include "sim/cutting/arrangement/store.h"

namespace limberg {

OperationDelta ArrangementStore::begin_delta(LastOperation::Kind kind) const {
  OperationDelta d;
  d.kind = kind;
  d.points = points.size();
  d.faces = int32_t(face.size());
  d.origs = int32_t(orig.size());
  d.divisions = int32_t(division.size());
  d.division_faces = division_face.size();
  d.division_constraints = division_constraint.size();
  d.ops = int32_t(op.size());
  d.forest = forest;
  d.hash_sum = hash_sum;
  d.volume_residue = volume_residue;
  return d;
}

int32_t ArrangementStore::clear_components(const std::vector<uint8_t>& marked, OperationDelta& d) {
  int32_t cleared = 0;
  // From here on nothing asks for memory.
  const auto cleared_side = [&](int32_t f, int side) {
    return face[f].has_side(side) && marked[size_t(component_of[sided_face(f, side)])];
  };
  size_t count = 0;
  for (int32_t f = 0; f < int32_t(face.size()); ++f) count += cleared_side(f, 0) || cleared_side(f, 1);
  std::vector<int32_t> origs, gone, changed;
  for (auto* list : {&origs, &gone, &changed}) list->reserve(count);
  for (auto* list : {&last.removed, &last.changed}) list->reserve(list->size() + count);
  d.mat.reserve(d.mat.size() + count);
  d.mate.reserve(d.mate.size() + 6 * count);
  d.orig.reserve(d.orig.size() + count);
  for (int32_t f = 0; f < int32_t(face.size()); ++f) {
    Face& t = face[f];
    uint8_t clear = 0;
    for (int side = 0; side < 2; ++side)
      if (cleared_side(f, side)) clear = uint8_t(clear | 1 << side);
    if (!clear) continue;
    d.mat.push_back({f, t.mat});
    hash_sum -= face_hash(t);
    volume_residue = mod_sub(volume_residue, face_volume_residue(t));
    for (int side = 0; side < 2; ++side) {
      if (!(clear >> side & 1)) continue;
      ++cleared;
      for (int k = 0; k < 3; ++k) {
        int32_t& m = mate[f][size_t(3 * side + k)];
        d.mate.push_back({sided_half_edge(sided_face(f, side), k), m});
        m = -1;  // its mates go with it: a component is closed under gluing
      }
    }
    t.mat = uint8_t(t.mat & ~clear);
    if (t.live()) {
      hash_sum += face_hash(t);
      volume_residue = mod_add(volume_residue, face_volume_residue(t));
      changed.push_back(f);
    } else {
      edges.remove(f, t.v, t.outer());
      gone.push_back(f);
      origs.push_back(t.orig);
    }
  }
  std::sort(origs.begin(), origs.end());
  for (size_t i = 0; i < origs.size(); ++i) {
    OrigTri& o = orig[origs[i]];
    if (i == 0 || origs[i] != origs[i - 1]) d.orig.push_back({origs[i], o.live, o.whole, o.split, std::nullopt});
    --o.live;
  }
  // What the operation as a whole did: a face that it made and took away again was never there.
  const auto made_now = [&](int32_t f) { return std::binary_search(last.added.begin(), last.added.end(), f); };
  for (int32_t f : gone)
    if (!made_now(f)) last.removed.push_back(f);
  for (int32_t f : changed)
    if (!made_now(f)) last.changed.push_back(f);
  const auto dead = [&](int32_t f) { return !face[f].live(); };
  std::erase_if(last.added, dead);
  std::erase_if(last.new_walls, dead);
  std::erase_if(last.changed, dead);
  for (auto* list : {&last.removed, &last.changed}) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
  components_known = false;
  d.component.reset();
  return cleared;
}

ExciseResult Arrangement::excise(int32_t which) {
  ExciseResult result;
  const auto& all = components();
  if (which < 0 || size_t(which) >= all.size()) {
    result.reason = "there is no such component to take away";
    return result;
  }
  if (all.size() == 1) {
    result.reason = "this would take the whole body away";
    return result;
  }
  ArrangementStore& s = *store_;
  OperationDelta d = s.begin_delta(LastOperation::excision);
  std::vector<uint8_t> marked(all.size(), 0);
  marked[size_t(which)] = 1;
  result.volume_mm3 = all[size_t(which)].volume_mm3;
  s.make_room_in_history();
  LastOperation before = std::exchange(s.last, LastOperation{});
  s.last.kind = LastOperation::excision;
  try {
    result.sided_faces = s.clear_components(marked, d);
  } catch (...) {
    s.last = std::move(before);
    throw;
  }
  result.done = true;
  s.history.push_back(std::move(d));
  return result;
}

namespace {

/// Marks what a sweep takes: loose pieces below a size, if anything is left beside them.
DebrisResult mark_debris(const std::vector<SurfaceComponent>& all, double below_mm3, std::vector<uint8_t>& marked) {
  DebrisResult result;
  marked.assign(all.size(), 0);
  for (size_t i = 0; i < all.size(); ++i) {
    if (all[i].touches_fixed || all[i].volume_mm3 >= below_mm3 || all[i].volume_mm3 <= 0) continue;
    marked[i] = 1;
    ++result.pieces;
    result.volume_mm3 += all[i].volume_mm3;
  }
  return size_t(result.pieces) == all.size() ? DebrisResult{} : result;
}

}  // namespace

DebrisResult Arrangement::find_debris(double below_mm3) const {
  std::vector<uint8_t> marked;
  return store_->history.empty() ? DebrisResult{} : mark_debris(components(), below_mm3, marked);
}

DebrisResult Arrangement::sweep_debris(double below_mm3) {
  ArrangementStore& s = *store_;
  if (s.history.empty()) return {};
  std::vector<uint8_t> marked;
  const DebrisResult result = mark_debris(components(), below_mm3, marked);
  if (result.pieces > 0) s.clear_components(marked, s.history.back());
  return result;
}

}  // namespace limberg
