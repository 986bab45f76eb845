#include "sim/cutting/arrangement/planar_split.h"

#include <algorithm>

namespace limberg {

namespace {

int next3(int k) { return k == 2 ? 0 : k + 1; }
int prev3(int k) { return k == 0 ? 2 : k - 1; }

}  // namespace

void PlanarSplit::open(const PointStore& points, const Plane& plane, const std::array<int32_t, 3>& v) {
  points_ = &points;
  plane_ = &plane;
  view_ = Projection(plane);
  junction_.clear();
  Piece p;
  p.v = v;
  p.neighbour = {-1, -1, -1};
  p.label = {0, 1, 2};
  piece_.reserve(8);
  piece_.assign(1, p);
  last_ = 0;
  spares_ = false;
}

void PlanarSplit::open(const ArrangementStore& store, int32_t o) {
  open(store.points, store.orig[o].plane, store.orig[o].v);
  spares_ = true;
  if (store.orig[o].split < 0) {
    piece_[0].mat = store.face[store.orig[o].whole].mat;
    piece_[0].old = true;
    // The face may start at another corner than the original triangle.
    piece_[0].v = store.face[store.orig[o].whole].v;
    for (size_t k = 0; k < 3 && piece_[0].v != store.orig[o].v; ++k)
      piece_[0].label[k] = int16_t(store.edge_of_orig(o, piece_[0].v[k], piece_[0].v[(k + 1) % 3]));
    return;
  }
  const auto faces = store.faces_of(o);
  const auto links = store.links_of(o);
  const auto junctions = store.constraints_of(o);
  junction_.assign(junctions.begin(), junctions.end());
  piece_.clear();
  piece_.reserve(faces.size() * 2 + 8);
  for (size_t i = 0; i < faces.size(); ++i) {
    const Face& f = store.face[size_t(faces[i])];
    Piece& p = piece_.emplace_back();
    p.v = f.v, p.mat = f.mat, p.old = true;
    for (size_t k = 0; k < 3; ++k) {
      p.neighbour[k] = std::max(links[i][k], -1);
      p.label[k] = links[i][k] < 0    ? int16_t(~links[i][k])
                   : f.inner >> k & 1 ? kFree
                                      : kJunction;  // which one comes next
    }
  }
  thread_local std::vector<EdgeOf> room;
  int16_t label = kJunction;
  for (const auto& [i, k] : list_junctions(piece_, room)) {
    Piece& p = piece_[size_t(i)];
    Piece& q = piece_[size_t(p.neighbour[size_t(k)])];
    p.label[size_t(k)] = q.label[q.edge_towards(i)] = label++;
  }
}

std::span<const PlanarSplit::EdgeOf> PlanarSplit::list_junctions(std::span<const Piece> piece,
                                                                 std::vector<EdgeOf>& room) {
  if (room.size() < 3 * piece.size() + 1) room.resize(3 * piece.size() + 1);
  size_t n = 0;
  for (size_t i = 0; i < piece.size(); ++i)
    for (size_t k = 0; k < 3; ++k) {  // without a branch: which edges are junctions cannot be foreseen
      room[n] = {int32_t(i), int32_t(k)};
      n += size_t(piece[i].label[k] >= kJunction) & size_t(piece[i].neighbour[k] > int32_t(i));
    }
  return std::span(room).first(n);
}

bool PlanarSplit::strictly_between(int32_t a, int32_t p, int32_t b) const {
  // The three are collinear: compare along the axis in which a and b differ most.
  const int axis = points_->longest_axis(a, b);
  const int ab = points_->order(axis, a, b);
  return ab != 0 && points_->order(axis, a, p) == ab && points_->order(axis, p, b) == ab;
}

bool PlanarSplit::insert(int32_t point, int16_t label) {
  const auto is_corner = [&](const Piece& p) { return p.v[0] == point || p.v[1] == point || p.v[2] == point; };
  for (const Piece& p : piece_)
    if (is_corner(p)) return true;
  if (label != kFree) {
    for (size_t t = 0; t < piece_.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const Piece& p = piece_[t];
        if (p.label[size_t(k)] != label || !strictly_between(p.v[size_t(k)], point, p.v[size_t(next3(k))])) continue;
        if (!spared(int32_t(t)) || !spared(p.neighbour[size_t(k)])) split_edge(int32_t(t), k, point);
        return true;
      }
    return false;
  }
  // Walk across edges that have the point on their other side;
  // bounded, because among implicit points a walk may circle.
  std::array<int, 3> side{};
  int32_t t = std::min(last_, int32_t(piece_.size()) - 1), from = -1;
  for (size_t steps = 0; steps < piece_.size(); ++steps) {
    const Piece& p = piece_[size_t(t)];
    int out = -1;
    for (int k = 0; k < 3 && out < 0; ++k) {
      side[size_t(k)] =
          from >= 0 && p.neighbour[size_t(k)] == from ? 1 : orient(p.v[size_t(k)], p.v[size_t(next3(k))], point);
      if (side[size_t(k)] < 0) out = k;
    }
    if (out < 0) return insert_into(t, side, point);
    if (p.neighbour[size_t(out)] < 0) break;
    from = t;
    t = p.neighbour[size_t(out)];
  }
  for (t = 0; t < int32_t(piece_.size()); ++t) {
    const auto& v = piece_[size_t(t)].v;
    bool inside = true;
    for (int k = 0; k < 3 && inside; ++k) {
      side[size_t(k)] = orient(v[size_t(k)], v[size_t(next3(k))], point);
      inside = side[size_t(k)] >= 0;
    }
    if (inside) return insert_into(t, side, point);
  }
  return false;
}

bool PlanarSplit::insert_into(int32_t t, const std::array<int, 3>& side, int32_t point) {
  int edge = -1, zeros = 0;
  for (int k = 0; k < 3; ++k)
    if (side[size_t(k)] == 0) edge = k, ++zeros;
  if (zeros > 1) return false;
  last_ = t;
  if (spared(t)) return true;
  if (zeros == 1) {
    if (piece_[size_t(t)].label[size_t(edge)] != kFree) return false;
    split_edge(t, edge, point);
  } else {
    split_piece(t, point);
  }
  return true;
}

void PlanarSplit::relink(int32_t piece, int32_t from, int32_t to) {
  if (piece >= 0) piece_[piece].neighbour[piece_[piece].edge_towards(from)] = to;
}

void PlanarSplit::split_piece(int32_t t, int32_t point) {
  const Piece old = piece_[t];
  const int32_t n1 = int32_t(piece_.size()), n2 = n1 + 1;
  piece_.resize(piece_.size() + 2);
  const std::array<int32_t, 3> id{t, n1, n2};  // piece k keeps edge k
  for (size_t k = 0; k < 3; ++k) {
    Piece& p = piece_[id[k]];
    p.v = {old.v[k], old.v[(k + 1) % 3], point};
    p.neighbour = {old.neighbour[k], id[(k + 1) % 3], id[(k + 2) % 3]};
    p.label = {old.label[k], kFree, kFree};
    p.mat = old.mat;
    p.old = false;
    if (k > 0) relink(old.neighbour[k], t, id[k]);
  }
}

void PlanarSplit::split_edge(int32_t t, int k, int32_t point) {
  // t = (a, b, c) with a-b its edge k; across it n = (b, a, d). Result: (a, p, c), (p, b, c), (p, a, d), (b, p, d).
  const Piece old = piece_[t];
  const size_t k0 = size_t(k), k1 = size_t(next3(k)), k2 = size_t(prev3(k));
  const int32_t a = old.v[k0], b = old.v[k1], c = old.v[k2], n = old.neighbour[k0];
  const int32_t t2 = int32_t(piece_.size()), n2 = t2 + 1;
  piece_.resize(piece_.size() + (n >= 0 ? 2 : 1));
  const int16_t l = old.label[k0];
  piece_[t] = {{a, point, c}, {n, t2, old.neighbour[k2]}, {l, kFree, old.label[k2]}, old.mat, false};
  piece_[t2] = {{point, b, c}, {n >= 0 ? n2 : -1, old.neighbour[k1], t}, {l, old.label[k1], kFree}, old.mat, false};
  relink(old.neighbour[k1], t, t2);
  if (n < 0) return;
  const Piece other = piece_[n];
  const size_t m0 = other.edge_towards(t), m1 = (m0 + 1) % 3, m2 = (m0 + 2) % 3;
  const int32_t d = other.v[m2];
  piece_[n] = {{point, a, d}, {t, other.neighbour[m1], n2}, {l, other.label[m1], kFree}, other.mat, false};
  piece_[n2] = {{b, point, d}, {t2, n, other.neighbour[m2]}, {l, kFree, other.label[m2]}, other.mat, false};
  relink(other.neighbour[m2], n, n2);
}

void PlanarSplit::flip(int32_t t, int k) {
  // t = (u, v, p), n = (v, u, q): becomes t = (u, q, p), n = (q, v, p).
  const Piece old = piece_[t];
  const size_t k0 = size_t(k), k1 = size_t(next3(k)), k2 = size_t(prev3(k));
  const int32_t n = old.neighbour[k0];
  const Piece other = piece_[n];
  const size_t m0 = other.edge_towards(t), m1 = (m0 + 1) % 3, m2 = (m0 + 2) % 3;
  const int32_t u = old.v[k0], v = old.v[k1], p = old.v[k2], q = other.v[m2];
  piece_[t] = {
      {u, q, p}, {other.neighbour[m1], n, old.neighbour[k2]}, {other.label[m1], kFree, old.label[k2]}, old.mat, false};
  piece_[n] = {
      {q, v, p}, {other.neighbour[m2], old.neighbour[k1], t}, {other.label[m2], old.label[k1], kFree}, old.mat, false};
  relink(other.neighbour[m1], n, t);
  relink(old.neighbour[k1], t, n);
}

void PlanarSplit::set_label(int32_t t, int k, int16_t label) {
  Piece& p = piece_[t];
  p.label[size_t(k)] = label;
  p.old = false;
  if (p.neighbour[size_t(k)] < 0) return;
  Piece& q = piece_[size_t(p.neighbour[size_t(k)])];
  q.label[q.edge_towards(t)] = label;
  q.old = false;
}

bool PlanarSplit::enforce(int32_t a, int32_t b, int32_t partner) {
  const int16_t label = int16_t(kJunction + int(junction_.size()));
  enforced_ = {-1, 0};
  const auto finish = [&](int32_t t, int k) {
    if (piece_[t].label[size_t(k)] != kFree) return false;  // it lies on something that is there already
    if (spared(t)) return true;
    junction_.push_back({a, b, partner});
    set_label(t, k, label);
    enforced_ = {t, k};
    return true;
  };
  thread_local std::vector<std::pair<int32_t, int>> around;  // pieces with the corner a, and which it is of each
  around.clear();
  for (size_t i = 0; i < piece_.size(); ++i) {
    const auto& v = piece_[i].v;
    const int c = (v[1] == a) + 2 * (v[2] == a);
    if (v[size_t(c)] != a) continue;
    if (v[size_t(next3(c))] == b) return finish(int32_t(i), c);
    if (v[size_t(prev3(c))] == b) return finish(int32_t(i), prev3(c));
    around.push_back({int32_t(i), c});
  }
  if (around.empty()) return spares_;  // a lies where nothing can be cut
  // Turns that are zero by construction, which no filter could tell: what was just enforced with the same partner lies
  // on the line of a-b, and so do edges of one label or of one partner with each other.
  const auto turn_to = [&](int32_t c) {
    for (size_t j = junction_.size(); j-- > 0 && junction_[j].partner == partner;)
      if (junction_[j].a == c || junction_[j].b == c) return 0;
    return orient(a, b, c);
  };
  const auto on_one_line = [&](int16_t l, int16_t m) {
    return l != kFree &&
           (l == m || (l >= kJunction && m >= kJunction &&
                       junction_[size_t(l - kJunction)].partner == junction_[size_t(m - kJunction)].partner));
  };
  // The pieces that a-b passes through, from the one at a whose opposite edge it crosses.
  thread_local std::vector<int32_t> corridor;
  thread_local std::vector<std::pair<int32_t, int32_t>> crossing;  // a queue: entries before `done` are through
  corridor.clear();
  crossing.clear();
  int32_t t = -1;
  int k = 0;
  for (size_t i = 0; i < around.size() && t < 0; ++i) {
    const auto [at, c] = around[i];
    if (turn_to(piece_[at].v[size_t(next3(c))]) < 0 && turn_to(piece_[at].v[size_t(prev3(c))]) > 0)
      t = at, k = next3(c);
  }
  if (t < 0) return false;  // a point exactly ahead on the line: a coincidence
  if (spared(t)) return true;
  corridor.push_back(t);
  for (;;) {
    if (piece_[t].label[size_t(k)] != kFree || piece_[t].neighbour[size_t(k)] < 0) return false;
    const int32_t u = piece_[t].v[size_t(k)], v = piece_[t].v[size_t(next3(k))];
    crossing.push_back({u, v});
    const int32_t n = piece_[t].neighbour[size_t(k)];
    corridor.push_back(n);
    const int m = int(piece_[n].edge_towards(t));
    const int32_t w = piece_[n].v[size_t(prev3(m))];
    if (w == b) break;
    const int s = orient(a, b, w);
    if (s == 0) return false;
    // n = (v, u, w): u is right of a-b, v left. Go on through the edge between w and the point on the other side.
    k = s > 0 ? next3(m) : prev3(m);
    t = n;
  }
  // Flip what crosses until nothing does (Sloan). The set of pieces stays the corridor.
  size_t guard = 64 + crossing.size() * crossing.size() * 4;
  for (size_t done = 0; done < crossing.size();) {
    if (guard-- == 0) return false;
    const int32_t u = crossing[done].first, v = crossing[done].second;
    ++done;
    t = -1;
    const auto look_at = [&](int32_t c) {
      const auto& at = piece_[c].v;
      const int e = (at[1] == u) + 2 * (at[2] == u);
      if (at[size_t(e)] == u && at[size_t(next3(e))] == v) t = c, k = e;
    };
    for (size_t i = done - 1; i < std::min(done + 1, corridor.size()) && t < 0; ++i)
      look_at(corridor[i]);  // where it mostly still is
    for (size_t i = 0; i < corridor.size() && t < 0; ++i) look_at(corridor[i]);
    if (t < 0) {
      crossing.push_back({v, u});  // the same edge, named from its other side after a flip
      continue;
    }
    const int32_t n = piece_[t].neighbour[size_t(k)];
    const int m = int(piece_[n].edge_towards(t));
    const int32_t p = piece_[t].v[size_t(prev3(k))], q = piece_[n].v[size_t(prev3(m))];
    if (piece_[t].mat != piece_[n].mat) return false;
    if ((p == a && q == b) || (p == b && q == a)) {  // nothing else crosses any more
      flip(t, k);
      return finish(t, 1);
    }
    const auto &its = piece_[t].label, &across = piece_[n].label;
    const bool flat = on_one_line(its[size_t(prev3(k))], across[size_t(next3(m))]) ||
                      on_one_line(its[size_t(next3(k))], across[size_t(prev3(m))]);
    if (flat || orient(u, q, p) <= 0 || orient(q, v, p) <= 0) {
      crossing.push_back({u, v});
      continue;
    }
    flip(t, k);  // now t = (u, q, p)
    if (p == a || p == b || q == a || q == b) continue;
    if (orient(a, b, p) * orient(a, b, q) < 0) crossing.push_back({p, q});
  }
  return false;
}

void PlanarSplit::make_delaunay() {
  const auto in_circle = [&](int32_t a, int32_t b, int32_t c,
                             int32_t d) {  // d inside the circle through a, b, c (exact)
    const Int3 o = points_->integer(d);
    std::array<int64_t, 3> x, y, l;
    const std::array<int32_t, 3> p{a, b, c};
    for (size_t i = 0; i < 3; ++i) {
      const Int3 q = points_->integer(p[i]);
      x[i] = int64_t(q.x) - o.x;
      y[i] = int64_t(q.y) - o.y;
      l[i] = x[i] * x[i] + y[i] * y[i];
    }
    return int128(x[0] * y[1] - y[0] * x[1]) * l[2] + int128(x[1] * y[2] - y[1] * x[2]) * l[0] +
               int128(x[2] * y[0] - y[2] * x[0]) * l[1] >
           0;
  };
  bool changed = true;
  while (changed) {  // each flip lowers the lifted surface, so this ends
    changed = false;
    for (int32_t t = 0; t < int32_t(piece_.size()); ++t)
      for (int k = 0; k < 3; ++k) {
        const Piece p = piece_[t];
        const int32_t n = p.neighbour[size_t(k)];
        if (n < 0 || p.label[size_t(k)] != kFree) continue;
        const int m = int(piece_[n].edge_towards(t));
        const int32_t q = piece_[n].v[size_t(prev3(m))], u = p.v[size_t(k)], v = p.v[size_t(next3(k))],
                      w = p.v[size_t(prev3(k))];
        if (!in_circle(u, v, w, q) || orient(u, q, w) <= 0 || orient(q, v, w) <= 0) continue;
        flip(t, k);
        changed = true;
      }
  }
}

}  // namespace limberg
