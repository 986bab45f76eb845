// The last steps of a cut: divide by what is needed, put the walls in, glue what is dirty, check, or take all back.
#include <algorithm>

#include "sim/cutting/cut_builder.h"

namespace limberg {

namespace {

using Edge = std::pair<int32_t, int32_t>;
Edge edge(int32_t a, int32_t b) { return {std::min(a, b), std::max(a, b)}; }

}  // namespace

bool CutBuilder::NeededPoints::has(int32_t p) const {
  return p >= first_new ? is_new[size_t(p - first_new)] != 0 : std::binary_search(old.begin(), old.end(), p);
}

CutBuilder::Outcome CutBuilder::divide_finally(const Touched& t, PlanarSplit& out,
                                               const NeededPoints& needed_points) const {
  // From the state before the cut, with the needed sub-edges only: tissue that is not cut keeps no scar. Points on
  // borders and junctions that others need go in too, so that all faces around such an edge are divided alike.
  const auto needed = [&](int32_t a, int32_t b) {
    return std::binary_search(t.needed.begin(), t.needed.end(), edge(a, b));
  };
  out.open(store_, t.orig);
  for (size_t i = t.first; i < t.first + t.count; ++i) {
    const Segment& seg = segment_[i];
    const auto along = marks(seg);
    for (size_t j = 0; j < along.size(); ++j) {
      const bool own = (j > 0 && needed(along[j - 1].point, along[j].point)) ||
                       (j + 1 < along.size() && needed(along[j].point, along[j + 1].point));
      const bool forced = along[j].label != PlanarSplit::kFree && needed_points.has(along[j].point);
      if ((own || forced) && !out.insert(along[j].point, along[j].label)) return coincidence;
    }
  }
  for (size_t i = t.first; i < t.first + t.count; ++i) {
    const Segment& seg = segment_[i];
    const auto along = marks(seg);
    for (size_t j = 0; j + 1 < along.size(); ++j)
      if (needed(along[j].point, along[j + 1].point) && !out.enforce(along[j].point, along[j + 1].point, seg.s))
        return coincidence;
  }
  return ok;
}

void CutBuilder::write_division(int32_t o, PlanarSplit& split) {
  OrigTri& orig = store_.orig[size_t(o)];
  split.number_junctions(room_.junction);
  const auto pieces = split.pieces();
  const auto junctions = split.junctions();
  Division d;
  d.first_constraint = uint32_t(store_.division_constraint.size());
  d.constraints = uint32_t(junctions.size());
  store_.division_constraint.insert(store_.division_constraint.end(), junctions.begin(), junctions.end());
  if (o < first_orig_) {
    std::vector<int32_t>& kept = room_.kept;
    kept.clear();
    for (const auto& p : pieces)
      if (p.face >= 0) kept.push_back(p.face);
    std::sort(kept.begin(), kept.end());
    for (int32_t f : store_.faces_of(o)) {
      if (std::binary_search(kept.begin(), kept.end(), f)) continue;
      Face& face = store_.face[size_t(f)];
      if (face.live()) store_.last.removed.push_back(f);
      face.retired = true;
      delta_.retired.push_back(f);
    }
    delta_.orig.push_back({o, orig.live, orig.whole, orig.split, std::nullopt});
    if (orig.split >= 0) delta_.orig.back().division = store_.division[size_t(orig.split)];  // gets a new one below
  }
  d.first_face = uint32_t(store_.division_face.size());
  d.faces = uint32_t(pieces.size());
  store_.division_face.resize(d.first_face + pieces.size());
  store_.division_link.resize(d.first_face + pieces.size());
  orig.live = 0;
  for (size_t i = 0; i < pieces.size(); ++i) {
    const PlanarSplit::Piece& p = pieces[i];
    int32_t f = p.face;
    if (f < 0) {
      f = int32_t(store_.face.size());
      store_.face.push_back({p.v, o, p.mat, false});
      store_.mate.push_back({-1, -1, -1, -1, -1, -1});
      if (p.mat != 0) store_.last.added.push_back(f);
    }
    store_.division_face[d.first_face + i] = f;
    store_.division_link[d.first_face + i] = {p.neighbour, p.label};
    orig.live += store_.face[size_t(f)].live();
  }
  if (d.faces == 1 && d.constraints == 0) {
    orig.whole = store_.division_face.back();
    orig.split = -1;
    store_.division_face.pop_back();
    store_.division_link.pop_back();
    return;
  }
  orig.whole = -1;
  if (orig.split < 0) {
    orig.split = int32_t(store_.division.size());
    store_.division.emplace_back();
  }
  store_.division[size_t(orig.split)] = d;
}

CutBuilder::Outcome CutBuilder::commit(CutResult& result) {
  // What the kept patches are bounded by.
  NeededPoints needed_points;
  needed_points.first_new = delta_.points;
  needed_points.is_new.assign(size_t(store_.points.size() - delta_.points), 0);
  const auto need = [&](int32_t p) {
    if (p >= delta_.points)
      needed_points.is_new[size_t(p - delta_.points)] = 1;
    else
      needed_points.old.push_back(p);
  };
  for (size_t i = 0; i < blade_split_.size(); ++i) {
    const auto pieces = blade_split_[i].pieces();
    for (size_t t = 0; t < pieces.size(); ++t) {
      if (!keep_[piece_first_[i] + t]) continue;
      for (size_t k = 0; k < 3; ++k) {
        if (pieces[t].label[k] < PlanarSplit::kJunction) continue;
        const Edge e = edge(pieces[t].v[k], pieces[t].v[(k + 1) % 3]);
        touched_[barrier_[barrier_first_[i] + size_t(pieces[t].label[k] - PlanarSplit::kJunction)].touched].needed.push_back(e);
        need(e.first);
        need(e.second);
      }
    }
  }
  const auto tidy = [](auto& v) {
    std::sort(v.begin(), v.end());
    v.erase(std::unique(v.begin(), v.end()), v.end());
  };
  tidy(needed_points.old);
  for (size_t i = 0; i < touched_.size(); ++i) {
    Touched& t = touched_[i];
    tidy(t.needed);
    size_t sub_edges = 0;
    bool forced = false;
    for (size_t j = t.first; j < t.first + t.count; ++j) {
      sub_edges += segment_[j].count - 1;
      for (const Mark& m : marks(segment_[j]))
        forced = forced || (m.label != PlanarSplit::kFree && needed_points.has(m.point));
    }
    if (t.needed.empty() && !forced) continue;
    t.changes = true;
    if (t.needed.size() == sub_edges) continue;  // the scratch division is the final one
    PlanarSplit final_split;
    if (divide_finally(t, final_split, needed_points) != ok)
      return fail(coincidence, "a needed junction could not be kept");
    t.scratch = std::move(final_split);
  }

  // Commit. From here on a failure is taken back through delta_.
  store_.points.settle();
  store_.edges.begin_changes();
  last_before_ = std::move(store_.last);
  committing_ = true;
  store_.last = LastOperation{};
  store_.last.kind = LastOperation::cut;
  for (size_t i = 0; i < touched_.size(); ++i)
    if (touched_[i].changes) {
      write_division(touched_[i].orig, touched_[i].scratch);
      if (store_.points.fails()) return fail(coincidence, "made to fail");
    }
  const size_t walls_from = store_.face.size();
  for (size_t i = 0; i < blade_split_.size(); ++i) {
    for (size_t t = 0; t < blade_split_[i].pieces().size(); ++t)
      blade_split_[i].set_material(t, keep_[piece_first_[i] + t] ? kMaterialPlus | kMaterialMinus : 0);
    // Junctions between two pieces that were not kept are none: nothing ends there.
    blade_split_[i].forget_dead_junctions();
    write_division(first_orig_ + int32_t(i), blade_split_[i]);
  }
  for (int32_t f : store_.last.added)
    if (size_t(f) >= walls_from) store_.last.new_walls.push_back(f);

  // The edge map is large and met in no order: what comes next is fetched ahead.
  constexpr size_t kAhead = 8;
  const auto& removed = store_.last.removed;
  const auto& added = store_.last.added;
  store_.edges.make_room(removed.size() + added.size(), int32_t(store_.face.size()) - 1);
  for (size_t i = 0; i < removed.size(); ++i) {
    if (i + kAhead < removed.size()) store_.edges.prefetch(store_.face[size_t(removed[i + kAhead])].v);
    store_.edges.remove(removed[i], store_.face[size_t(removed[i])].v);
  }
  for (size_t i = 0; i < added.size(); ++i) {
    if (i + kAhead < added.size()) store_.edges.prefetch(store_.face[size_t(added[i + kAhead])].v);
    store_.edges.add(added[i], store_.face[size_t(added[i])].v);
  }
  store_.edges.end_changes();
  for (int32_t f : removed) store_.account_sums(f, false);
  for (int32_t f : added) store_.account_sums(f, true);
  accounted_ = true;
  const auto changed = store_.edges.changed();
  for (size_t i = 0; i < changed.size(); ++i) {
    if (i + kAhead < changed.size())
      if (const int32_t h = store_.edges.first(changed[i + kAhead]); h >= 0) {
        __builtin_prefetch(&store_.face[size_t(h / 3)]);
        __builtin_prefetch(&store_.mate[size_t(h / 3)], 1);
      }
    const auto [a, b] = store_.edges.edge(changed[i]);
    if (const char* why = store_.glue_edge(a, b, store_.edges.first(changed[i]), &delta_))
      return fail(coincidence, why);
  }

  // Local invariants: the divided surface encloses the same volume, every side that faces material is glued all round,
  // junctions are edges of both triangles that they join.
  if (store_.volume_residue != delta_.volume_residue) return fail(coincidence, "the volume changed");
  Projection view;
  int32_t viewed = -1;
  for (size_t f = size_t(delta_.faces); f < store_.face.size(); ++f) {
    const Face& face = store_.face[f];
    const Plane& plane = store_.orig[size_t(face.orig)].plane;
    if (face.orig != viewed) view = Projection(plane), viewed = face.orig;
    if (store_.points.turn(plane, view, face.v[0], face.v[1], face.v[2]) <= 0)
      return fail(coincidence, "a face without area");
  }
  for (int32_t f : store_.last.added)
    for (int side = 0; side < 2; ++side)
      for (size_t k = 0; k < 3; ++k) {
        const int32_t h = sided_half_edge(sided_face(f, side), int(k));
        const int32_t m = store_.mate[f][size_t(3 * side) + k];
        if ((m >= 0) != store_.face[f].has_side(side) || (m >= 0 && store_.mate[m / 6][size_t(m % 6)] != h))
          return fail(coincidence, "the surface does not close");
      }
  for (const Touched& t : touched_)
    for (const Edge& e : t.needed)
      if (store_.edges.first(e.first, e.second) < 0) return fail(coincidence, "a junction is missing");

  store_.plant();
  std::sort(store_.last.removed.begin(), store_.last.removed.end());  // new faces have ascending names
  result.op = op_;
  result.wall_faces = int(store_.last.new_walls.size());
  result.blade_point = blade_point_;
  if (store_.points.fails()) return fail(coincidence, "made to fail");
  store_.history.push_back(std::move(delta_));
  store_.update_components(store_.history.back());
  return ok;
}

}  // namespace limberg
