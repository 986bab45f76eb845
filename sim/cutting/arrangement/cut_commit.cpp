// The last steps of a cut: divide by what is needed, put the walls in, glue what is dirty, check, or take all back.
#include <algorithm>

#include "sim/cutting/arrangement/cut_builder.h"

namespace limberg {

namespace {

constexpr size_t kFetchAhead = 8;  // faces and edges that are fetched while others are worked on

}  // namespace

bool CutBuilder::NeededPoints::has(int32_t p) const {
  return p >= first_new ? is_new[size_t(p - first_new)] != 0 : std::binary_search(old.begin(), old.end(), p);
}

CutBuilder::Outcome CutBuilder::divide_finally(uint32_t touched, const NeededPoints& needed_points) {
  // From the state before the cut, with the needed sub-edges only: tissue that is not cut keeps no scar. Points on
  // borders and junctions that others need go in too, so that all faces around such an edge are divided alike.
  const auto needed = [&](int32_t a, int32_t b) {
    return std::binary_search(room_.needed.begin(), room_.needed.end(),
                              CutScratch::NeededEdge{touched, std::min(a, b), std::max(a, b)});
  };
  Touched& t = touched_[touched];
  PlanarSplit& split = room_.split;
  split.open(store_, t.orig);
  for (size_t i = t.first; i < t.first + t.count; ++i) {
    const Segment& seg = segment_[i];
    const auto along = marks(seg);
    for (size_t j = 0; j < along.size(); ++j) {
      const bool own = (j > 0 && needed(along[j - 1].point, along[j].point)) ||
                       (j + 1 < along.size() && needed(along[j].point, along[j + 1].point));
      const bool forced = along[j].label != PlanarSplit::kFree && needed_points.has(along[j].point);
      if ((own || forced) && !split.insert(along[j].point, along[j].label)) return coincidence;
    }
  }
  for (size_t i = t.first; i < t.first + t.count; ++i) {
    const Segment& seg = segment_[i];
    const auto along = marks(seg);
    for (size_t j = 0; j + 1 < along.size(); ++j)
      if (needed(along[j].point, along[j + 1].point) && !split.enforce(along[j].point, along[j + 1].point, seg.s))
        return coincidence;
  }
  t.division = uint32_t(room_.divided.size());
  room_.divided.keep(split);
  return ok;
}

void CutBuilder::glue_inside(std::span<const int32_t> face, std::span<const PlanarSplit::Piece> pieces) {
  // At an inner edge two pieces with the same material meet, and nothing else: each side goes on as the same side.
  for (size_t i = 0; i < pieces.size(); ++i) {
    const PlanarSplit::Piece& p = pieces[i];
    if (p.mat == 0) continue;
    // Without branches: which edges are inner ones cannot be foreseen.
    auto& mate = store_.mate[size_t(face[i])];
    std::array<int32_t, 6> glued;
    int beside_new = 0;
    for (size_t k = 0; k < 3; ++k) {
      const size_t n = size_t(std::max(p.neighbour[k], 0));
      const int32_t across = 6 * face[n] + int32_t(pieces[n].edge_towards(int32_t(i)));
      const int inner = p.label[k] == PlanarSplit::kFree;
      for (size_t side = 0; side < 2; ++side)
        glued[3 * side + k] = (across + 3 * int32_t(side)) | ((inner & p.mat >> side) - 1);  // or -1
      beside_new |= inner & !pieces[n].old;
    }
    if (!p.old) {
      mate = glued;
      continue;
    }
    for (size_t h = 0; h < 6 && beside_new; ++h)
      if (glued[h] >= 0 && !pieces[size_t(p.neighbour[h % 3])].old) {  // an old face beside a new one
        delta_.mate.push_back({6 * face[i] + int32_t(h), mate[h]});
        mate[h] = glued[h];
      }
  }
}

void CutBuilder::retire_replaced(int32_t orig, std::span<const PlanarSplit::Piece> pieces) {
  const auto faces = store_.faces_of(orig);
  for (size_t i = 0; i < faces.size(); ++i) {
    if (pieces[i].old) continue;
    Face& face = store_.face[size_t(faces[i])];
    delta_.retired.push_back(faces[i]);
    if (face.live()) store_.last.removed.push_back(faces[i]);
    face.retired = true;
  }
}

void CutBuilder::write_division(int32_t o, Divisions& from, size_t which) {
  OrigTri& orig = store_.orig[size_t(o)];
  std::vector<Constraint>& junctions = room_.junction;
  from.number_junctions(which, junctions);
  const std::span<const PlanarSplit::Piece> pieces = from.pieces(which);
  Division d;
  d.first_constraint = uint32_t(store_.division_constraint.size());
  d.constraints = uint32_t(junctions.size());
  store_.division_constraint.insert(store_.division_constraint.end(), junctions.begin(), junctions.end());
  const int32_t whole_before = orig.whole;
  const size_t before = orig.split < 0 ? 0 : store_.division[size_t(orig.split)].first_face;  // the faces that it had
  if (o < first_orig_) {
    retire_replaced(o, pieces);
    delta_.orig.push_back({o, orig.live, orig.whole, orig.split, std::nullopt});
    if (orig.split >= 0) delta_.orig.back().division = store_.division[size_t(orig.split)];  // gets a new one below
  }
  d.first_face = uint32_t(store_.division_face.size());
  d.faces = uint32_t(pieces.size());
  orig.live = 0;
  for (size_t i = 0; i < pieces.size(); ++i) {
    const PlanarSplit::Piece& p = pieces[i];
    int32_t f;
    if (p.old) {
      f = whole_before >= 0 ? whole_before : store_.division_face[before + i];
    } else {
      const auto inner = uint8_t((p.label[0] == PlanarSplit::kFree) | (p.label[1] == PlanarSplit::kFree) << 1 |
                                 (p.label[2] == PlanarSplit::kFree) << 2);
      f = int32_t(store_.face.size());
      store_.face.push_back({p.v, o, p.mat, false, inner});
      store_.mate.push_back({-1, -1, -1, -1, -1, -1});
      if (p.mat != 0) store_.last.added.push_back(f);
    }
    store_.division_face.push_back(f);
    PieceLinks& link = store_.division_link.emplace_back();
    for (size_t k = 0; k < 3; ++k)
      link[k] = p.neighbour[k] - (p.label[k] & p.neighbour[k] >> 31);  // ~label where that is -1
    orig.live += store_.face[size_t(f)].live();
  }
  glue_inside(std::span(store_.division_face).subspan(d.first_face), pieces);
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

CutBuilder::NeededPoints CutBuilder::find_needed() {
  NeededPoints needed_points;
  needed_points.first_new = delta_.points;
  needed_points.is_new.assign(size_t(store_.points.size() - delta_.points), 0);
  const auto need = [&](int32_t p) {
    if (p >= delta_.points)
      needed_points.is_new[size_t(p - delta_.points)] = 1;
    else
      needed_points.old.push_back(p);
  };
  for (size_t i = 0; i < blade_divided_.size(); ++i) {
    const auto pieces = blade_divided_.pieces(i);
    for (size_t t = 0; t < pieces.size(); ++t) {
      if (!keep_[blade_divided_.first_piece(i) + t]) continue;
      for (size_t k = 0; k < 3; ++k) {
        if (pieces[t].label[k] < PlanarSplit::kJunction) continue;
        Barrier& b = barrier_[barrier_first_[i] + size_t(pieces[t].label[k] - PlanarSplit::kJunction)];
        touched_[b.touched].needed += !b.needed;
        b.needed = true;
        need(b.a);
        need(b.b);
      }
    }
  }
  std::sort(needed_points.old.begin(), needed_points.old.end());
  for (size_t i = 0; i < touched_.size(); ++i) {
    Touched& t = touched_[i];
    t.changes = t.needed > 0;
    for (size_t j = t.first; j < t.first + t.count && !t.changes; ++j)
      for (const Mark& m : marks(segment_[j]))
        t.changes = t.changes || (m.label != PlanarSplit::kFree && needed_points.has(m.point));
    t.in_part = t.changes && t.needed < t.sub_edges;  // else the division that there is is the final one
  }
  for (const Barrier& b : barrier_)
    if (b.needed && touched_[b.touched].in_part)
      room_.needed.push_back({b.touched, std::min(b.a, b.b), std::max(b.a, b.b)});
  std::sort(room_.needed.begin(), room_.needed.end());
  return needed_points;
}

void CutBuilder::write_walls() {
  const size_t walls_from = store_.face.size();
  for (size_t i = 0; i < blade_divided_.size(); ++i) {
    const auto pieces = blade_divided_.pieces(i);
    for (size_t t = 0; t < pieces.size(); ++t)
      pieces[t].mat = keep_[blade_divided_.first_piece(i) + t] ? kMaterialPlus | kMaterialMinus : 0;
    // Junctions between two pieces that were not kept are none: nothing ends there.
    blade_divided_.forget_dead_junctions(i);
    write_division(first_orig_ + int32_t(i), blade_divided_, i);
  }
  for (int32_t f : store_.last.added)
    if (size_t(f) >= walls_from) store_.last.new_walls.push_back(f);
}

// The edge map is large and met in no order: what comes next is fetched ahead.
void CutBuilder::enter_edges() {
  const auto& removed = store_.last.removed;
  const auto& added = store_.last.added;
  store_.edges.make_room(2 * removed.size() + added.size(), int32_t(store_.face.size()) - 1);  // and for a way back
  in_edges_ = true;
  const auto prefetch = [&](const Face& f) { store_.edges.prefetch(f.v, f.outer()); };
  for (size_t i = 0; i < removed.size(); ++i) {
    if (i + kFetchAhead < removed.size()) prefetch(store_.face[size_t(removed[i + kFetchAhead])]);
    const Face& f = store_.face[size_t(removed[i])];
    store_.edges.remove(removed[i], f.v, f.outer());
  }
  for (size_t i = 0; i < added.size(); ++i) {
    if (i + kFetchAhead < added.size()) prefetch(store_.face[size_t(added[i + kFetchAhead])]);
    const Face& f = store_.face[size_t(added[i])];
    store_.edges.add(added[i], f.v, f.outer());
  }
  store_.edges.end_changes();
  for (int32_t f : removed) store_.account_sums(f, false);
  for (int32_t f : added) store_.account_sums(f, true);
}

const char* CutBuilder::glue_changed() {
  const auto changed = store_.edges.changed();
  for (size_t i = 0; i < changed.size(); ++i) {
    if (i + kFetchAhead < changed.size())
      if (const int32_t h = store_.edges.first(changed[i + kFetchAhead]); h >= 0) {
        __builtin_prefetch(&store_.face[size_t(h / 3)]);
        __builtin_prefetch(&store_.mate[size_t(h / 3)], 1);
      }
    const auto [a, b] = store_.edges.edge(changed[i]);
    if (const char* why = store_.glue_edge(a, b, store_.edges.first(changed[i]), &delta_)) return why;
  }
  return nullptr;
}

const char* CutBuilder::broken_invariant() const {
  if (store_.volume_residue != delta_.volume_residue) return "the volume changed";
  Projection view;
  int32_t viewed = -1;
  for (size_t f = size_t(delta_.faces); f < store_.face.size(); ++f) {
    const Face& face = store_.face[f];
    const Plane& plane = store_.orig[size_t(face.orig)].plane;
    if (face.orig != viewed) view = Projection(plane), viewed = face.orig;
    if (store_.points.turn(plane, view, face.v[0], face.v[1], face.v[2]) <= 0) return "a face without area";
  }
  for (int32_t f : store_.last.added)
    for (int side = 0; side < 2; ++side)
      for (size_t k = 0; k < 3; ++k) {
        const int32_t h = sided_half_edge(sided_face(f, side), int(k));
        const int32_t m = store_.mate[f][size_t(3 * side) + k];
        if ((m >= 0) != store_.face[f].has_side(side) || (m >= 0 && store_.mate[m / 6][size_t(m % 6)] != h))
          return "the surface does not close";
      }
  for (const Barrier& b : barrier_)
    if (b.needed && store_.edges.first(b.a, b.b) < 0) return "a junction is missing";
  return nullptr;
}

CutBuilder::Outcome CutBuilder::commit(CutResult& result) {
  const NeededPoints needed = find_needed();
  for (size_t i = 0; i < touched_.size(); ++i)
    if (touched_[i].in_part && divide_finally(uint32_t(i), needed) != ok)
      return fail(coincidence, "a needed junction could not be kept");

  // From here on a failure is taken back through delta_.
  store_.points.settle();
  store_.make_room_in_history();
  store_.edges.begin_changes();
  last_before_ = std::move(store_.last);
  committing_ = true;
  store_.last = LastOperation{};
  store_.last.kind = LastOperation::cut;
  for (size_t i = 0; i < touched_.size(); ++i)
    if (touched_[i].changes) {
      write_division(touched_[i].orig, room_.divided, touched_[i].division);
      if (store_.points.fails()) return fail(coincidence, "made to fail");
    }
  write_walls();
  enter_edges();
  if (const char* why = glue_changed()) return fail(coincidence, why);
  if (const char* why = broken_invariant()) return fail(coincidence, why);

  store_.plant();
  std::sort(store_.last.removed.begin(), store_.last.removed.end());  // new faces have ascending names
  result.op = op_;
  result.wall_faces = int(store_.last.new_walls.size());
  result.blade_point = blade_point_;
  if (store_.points.fails()) return fail(coincidence, "made to fail");
  try {
    store_.update_components(delta_);
  } catch (const std::bad_alloc&) {  // they are found when next asked for
    delta_.component.reset();
    delta_.component_of.clear();
  }
  store_.history.push_back(std::move(delta_));
  return ok;
}

}  // namespace limberg
