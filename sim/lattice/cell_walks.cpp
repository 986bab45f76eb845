// What no lattice edge sees: closed curves on the squares of a cell, and closed shells inside it.
//
// A closed curve on a square bounds material on its outside or on its inside. If on its outside, that material goes on
// to the left of the curve's leftmost crossing with any horizontal line, up to the next curve or to the left lattice
// edge: they belong together. If on its inside, the leftmost crossing faces right and nothing follows. A crack's curve
// has both sides in one loop; its left-facing side is treated as the first case. If that next curve is closed, too, the
// walk goes on from its own leftmost crossing with the same line, until it comes to what is known or to a curve that
// faces right there. (One step per curve would not do: of two interlocked curves each can lie to the left of the other,
// on two lines.) Shells are treated in the same way along an axis, going on on the square that the axis leaves through.
#include <algorithm>
#include <cmath>

#include "sim/base/union_find.h"
#include "sim/lattice/cell_builder.h"

namespace limberg {

void CellBuilder::join_walks() {
  for (int normal = 0; normal < 3; ++normal)
    for (int high = 0; high < 2; ++high) walk_square(normal, high != 0);
  walk_shells();
}

// Faces pierced by the line along `axis` beyond the cell's low bound (and before `upper`), in order along it.
void CellBuilder::hits_between(int axis, const SubPoint& line, const SubPoint* upper, std::vector<int32_t>& out) {
  out.clear();
  SubPoint low = line;
  low[size_t(axis)] = bound_[size_t(axis)][0];
  for (size_t l = 0; l < face_.size(); ++l) {
    LocalFace& f = face_[l];
    const int64_t n = f.plane->n[size_t(axis)];
    if (n == 0 || !pierced(shape(f).p, axis, line)) continue;
    const int up = n > 0 ? 1 : -1;  // n . c - d grows along the axis with the sign of n: negative below the hit
    if (plane_at_corner(*f.plane, low) != -up) continue;
    if (upper && plane_at_corner(*f.plane, *upper) != up) continue;
    out.push_back(int32_t(l));
  }
  std::sort(out.begin(), out.end(), [&](int32_t a, int32_t b) {
    const int o = order_on_line(*face_[size_t(a)].plane, *face_[size_t(b)].plane, axis, line);
    return o ? o < 0 : a < b;
  });
}

// The member that holds the region just before `below` on the lattice edge (axis, corner).
int32_t CellBuilder::region_on_lattice_edge(int axis, int corner, const SubPoint& below) {
  int32_t region = corner_member(corner_of_edge(axis, corner, false));
  bool state = corner_in_[size_t(corner_of_edge(axis, corner, false))];
  for (int32_t h : hit_[size_t(4 * axis + corner)]) {
    const Plane& plane = *face_[size_t(h)].plane;
    const int up = plane.n[size_t(axis)] > 0 ? 1 : -1;
    if (plane_at_corner(plane, below) != up) break;  // this hit lies beyond
    const int after = 1 - side_before(plane, axis);
    region = member(size_t(h), after);
    state = has(face_[size_t(h)].mat, after);
  }
  if (!state) contradiction("a walk came to a place without material on a lattice edge");
  return region;
}

// Follows the line along `axis` to the leftmost crossing of loop `root` of `own`; when that faces left, joins it with
// what is next to the left, or with left() when the walk reaches the low bound; then from there, until what it has come
// to is open_. False: the line misses the loop.
template <class Left>
bool CellBuilder::walk_left(int axis, const SubPoint& line, UnionFind& own, int32_t root, Left&& left) {
  hits_between(axis, line, nullptr, hits_);
  size_t beyond = hits_.size();  // the walk has come to here
  for (size_t i = 0; i < beyond; ++i) {
    const LocalFace& f = face_[size_t(hits_[i])];
    const int before = side_before(*f.plane, axis);
    const bool faces_left = has(f.mat, before) && own.find(member(size_t(hits_[i]), before)) == root;
    const bool faces_right = has(f.mat, 1 - before) && own.find(member(size_t(hits_[i]), 1 - before)) == root;
    if (!faces_left && !faces_right) continue;
    if (beyond == hits_.size()) ++walks_;
    if (!faces_left) return true;
    const int32_t mine = member(size_t(hits_[i]), before);
    if (i == 0) {
      join_.unite(mine, left());
      return true;
    }
    const LocalFace& next = face_[size_t(hits_[i - 1])];
    const int after = 1 - side_before(*next.plane, axis);
    if (!has(next.mat, after)) contradiction("material along a walk contradicts a face's bits");
    const int32_t other = member(size_t(hits_[i - 1]), after);
    join_.unite(mine, other);
    root = own.find(other);
    if (open_[size_t(root)]) return true;
    beyond = i;
    i = size_t(-1);  // from the left again: the leftmost crossing of the other curve
  }
  if (beyond != hits_.size()) contradiction("a walk has lost the curve that it came to");
  return false;
}

// Whether a curve on the square is closed: does not end at a lattice edge. Most squares have none. From each end of a
// curve it is followed to its other end; what is left over then is closed.
bool CellBuilder::has_loop(int normal, bool high) {
  const std::vector<Crossing>& crossing = crossing_[size_t(2 * normal + int(high))];
  // Per sided face: the two members that its curve goes on with (-1: it ends there).
  if (curve_.size() < 4 * face_.size()) curve_.resize(4 * face_.size());
  for (const Crossing& c : crossing)
    for (int side = 0; side < 2; ++side)
      curve_[size_t(2 * member(size_t(c.local), side))] = curve_[size_t(2 * member(size_t(c.local), side) + 1)] = -1;
  int32_t count = 0;
  for (const Crossing& c : crossing)
    for (int side = 0; side < 2; ++side) {
      if (!has(face_[size_t(c.local)].mat, side)) continue;
      const size_t at = size_t(2 * member(size_t(c.local), side));
      if (curve_[at] < 0) ++count;
      curve_[curve_[at] < 0 ? at : at + 1] = face_[size_t(c.local)].mate[size_t(3 * side + c.edge)];
    }
  for (const Crossing& c : crossing)
    for (int side = 0; side < 2; ++side) {
      int32_t at = member(size_t(c.local), side), last = -1;
      if (curve_[size_t(2 * at)] < 0 || curve_[size_t(2 * at + 1)] >= 0) continue;  // no end, or followed already
      while (at >= 0) {
        int32_t* way = &curve_[size_t(2 * at)];
        const int32_t next = way[0] != last ? way[0] : way[1];
        way[0] = way[1] = -1;
        --count;
        last = at;
        at = next;
      }
    }
  return count != 0;
}

// Curves on the square `normal` = low/high bound: sided faces joined where their glued edge pierces the square.
void CellBuilder::walk_square(int normal, bool high) {
  const std::vector<Crossing>& crossing = crossing_[size_t(2 * normal + int(high))];
  if (crossing.empty()) return;
  // Where all curves were there before, and no closed one among them, there is none now.
  bool known = no_walks_before_;
  for (size_t i = 0; known && i < crossing.size(); ++i) known = face_[size_t(crossing[i].local)].known;
  if (known || !has_loop(normal, high)) return;
  square_.reset(2 * face_.size());
  open_.assign(2 * face_.size(), 0);
  seen_.assign(2 * face_.size(), 0);
  for (const Crossing& c : crossing)
    for (int side = 0; side < 2; ++side)
      if (has(face_[size_t(c.local)].mat, side))
        square_.unite(member(size_t(c.local), side), face_[size_t(c.local)].mate[size_t(3 * side + c.edge)]);
  for (int step = 1; step <= 2; ++step) {  // the four lattice edges of the square
    const int axis = (normal + step) % 3;
    const bool normal_first = (axis + 1) % 3 == normal;
    for (int other = 0; other < 2; ++other) {
      const int corner = normal_first ? int(high) | other << 1 : other | int(high) << 1;
      for (int32_t h : hit_[size_t(4 * axis + corner)])
        for (int side = 0; side < 2; ++side)
          if (has(face_[size_t(h)].mat, side)) open_[size_t(square_.find(member(size_t(h), side)))] = 1;
    }
  }
  bool marked = false;
  for (const Crossing& c : crossing)
    for (int side = 0; side < 2; ++side) {
      const size_t l = size_t(c.local);
      if (!has(face_[l].mat, side)) continue;
      const int32_t root = square_.find(member(l, side));
      if (open_[size_t(root)] || seen_[size_t(root)]) continue;
      seen_[size_t(root)] = 1;
      if (!marked) {  // for the walks, which closed curves are rare to need
        crosses_.assign(3 * face_.size(), 0);
        for (const Crossing& x : crossing) crosses_[3 * size_t(x.local) + size_t(x.edge)] = 1;
        marked = true;
      }
      if (!walk_from_loop(normal, high, (normal + 1) % 3, root) &&
          !walk_from_loop(normal, high, (normal + 2) % 3, root) && !walk_from_speck(normal, high, root))
        ++unresolved_;
    }
}

// With `run` the "horizontal" axis on the square. False when no
// horizontal line crosses the loop: a crack of a level sheet.
bool CellBuilder::walk_from_loop(int normal, bool high, int run, int32_t root) {
  const int rise = 3 - normal - run;
  const int64_t level = bound_[size_t(normal)][high];
  struct Start {
    double extent, middle;
  };
  std::vector<Start> starts;
  for (size_t l = 0; l < face_.size(); ++l) {
    LocalFace& f = face_[l];
    if (f.in.inside()) continue;
    if (!((has(f.mat, 0) && square_.find(member(l, 0)) == root) ||
          (has(f.mat, 1) && square_.find(member(l, 1)) == root)))
      continue;
    double at[3];
    int n = 0;
    const Shape& s = shape(f);
    for (size_t e = 0; e < 3; ++e)
      if (crosses_[3 * l + e]) {
        const Vec3 &a = *s.p[e].approx, &b = *s.p[(e + 1) % 3].approx;
        const double t = (sub_to_half(level) - a[normal]) / (b[normal] - a[normal]);
        at[n++] = a[rise] + t * (b[rise] - a[rise]);
      }
    if (n == 2) starts.push_back({std::abs(at[1] - at[0]), 0.5 * (at[0] + at[1])});
  }
  std::stable_sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.extent > b.extent; });
  if (starts.size() > 8) starts.resize(8);
  for (const Start& s : starts) {
    if (!std::isfinite(s.middle)) continue;
    SubPoint line;
    line[size_t(normal)] = level;
    line[size_t(run)] = bound_[size_t(run)][0];
    line[size_t(rise)] =
        std::clamp<int64_t>(std::llround(s.middle * 0x1p24), bound_[size_t(rise)][0], bound_[size_t(rise)][1]);
    // The left lattice edge of the square runs along `rise`, at the low bound of `run`. Seen along `rise`, the
    // coordinates are those of the next two axes in cyclic order.
    const int corner = (rise + 1) % 3 == normal ? int(high) : int(high) << 1;
    if (walk_left(run, line, square_, root, [&] { return region_on_lattice_edge(rise, corner, line); })) return true;
  }
  return false;
}

// A curve so small that no line meets it: the surface's edges through a point exactly on the square's plane, say. Next
// to that plane it grows in the directions of its edges, which tell whether it bounds material on its inside; then
// nothing follows. If not, its material is that around it: what lies to the left of its place belongs to it.
bool CellBuilder::walk_from_speck(int normal, bool high, int32_t root) {
  const int u = (normal + 1) % 3, v = (normal + 2) % 3;
  const double level = sub_to_half(bound_[size_t(normal)][high]);
  double area2 = 0;  // positive: material inside
  Vec3 place = Vec3::Zero();
  int32_t mine = -1;
  for (size_t l = 0; l < face_.size(); ++l)
    for (int side = 0; side < 2; ++side) {
      if (!has(face_[l].mat, side) || square_.find(member(l, side)) != root) continue;
      Vec2 way[2];
      int n = 0;
      for (size_t e = 0; e < 3 && n < 2; ++e) {
        if (!crosses_[3 * l + e]) continue;
        const Shape& s = shape(face_[l]);
        const Vec3 &a = *s.p[e].approx, &b = *s.p[(e + 1) % 3].approx;
        const Vec3 slope = (b - a) / (b[normal] - a[normal]);
        place = a + (level - a[normal]) * slope;
        way[n++] = Vec2(slope[u], slope[v]);
      }
      if (n < 2) return false;  // it is no closed curve
      mine = member(l, side);
      const double into = side == 0 ? 1.0 : -1.0;  // along the plane's normal
      const Vec2 along(into * double(face_[l].plane->n[size_t(v)]), -into * double(face_[l].plane->n[size_t(u)]));
      // Seen at -slope, that is below the plane; with material to the left of the direction.
      Vec2 from = -way[0], to = -way[1];
      if ((to - from).dot(along) < 0) std::swap(from, to);
      area2 += from.x() * to.y() - from.y() * to.x();
    }
  if (mine < 0 || !place.allFinite()) return false;
  if (area2 > 0) return true;
  SubPoint line;
  line[size_t(normal)] = bound_[size_t(normal)][high];
  line[size_t(u)] = bound_[size_t(u)][0];
  line[size_t(v)] = std::clamp<int64_t>(std::llround(place[v] * 0x1p24), bound_[size_t(v)][0], bound_[size_t(v)][1]);
  hits_between(u, line, nullptr, hits_);
  for (size_t i = hits_.size(); i-- > 0;) {
    const LocalFace& f = face_[size_t(hits_[i])];
    const int after = 1 - side_before(*f.plane, u);
    if (hit_on_line(*f.plane, u, line) >= place[u]) continue;
    if (has(f.mat, after) && square_.find(member(size_t(hits_[i]), after)) == root) continue;
    if (!has(f.mat, after)) return false;
    join_.unite(mine, member(size_t(hits_[i]), after));
    ++walks_;
    return true;
  }
  const int corner = (v + 1) % 3 == normal ? int(high) : int(high) << 1;
  join_.unite(mine, region_on_lattice_edge(v, corner, line));
  ++walks_;
  return true;
}

void CellBuilder::walk_shells() {
  // Closed components all of whose faces lie inside the cell.
  bool any = false;
  for (const LocalFace& f : face_) any = any || f.in.inside();
  if (!any) return;
  open_.assign(glued_.size(), 0);
  seen_.assign(glued_.size(), 0);
  for (size_t l = 0; l < face_.size(); ++l)
    if (!face_[l].in.inside())
      for (int side = 0; side < 2; ++side)
        if (has(face_[l].mat, side)) open_[size_t(glued_.find(member(l, side)))] = 1;
  for (size_t l0 = 0; l0 < face_.size(); ++l0)
    for (int side0 = 0; side0 < 2; ++side0) {
      if (!face_[l0].in.inside() || !has(face_[l0].mat, side0)) continue;
      const int32_t root = glued_.find(member(l0, side0));
      if (open_[size_t(root)] || seen_[size_t(root)]) continue;
      seen_[size_t(root)] = 1;
      bool done = false;  // a level shell is met by lines along one axis only
      for (int axis = 0; axis < 3 && !done; ++axis) done = walk_from_shell(axis, root);
      if (!done) ++unresolved_;
    }
}

// Along `axis` from the faces of the shell that are widest across it.
bool CellBuilder::walk_from_shell(int axis, int32_t root) {
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  struct Start {
    double area;
    size_t face;
  };
  std::vector<Start> starts;
  for (size_t l = 0; l < face_.size(); ++l) {
    LocalFace& f = face_[l];
    if (!((has(f.mat, 0) && glued_.find(member(l, 0)) == root) || (has(f.mat, 1) && glued_.find(member(l, 1)) == root)))
      continue;
    const Shape& s = shape(f);
    const Vec3 u = *s.p[1].approx - *s.p[0].approx, v = *s.p[2].approx - *s.p[0].approx;
    starts.push_back({std::abs(u[b] * v[c] - u[c] * v[b]), l});
  }
  std::stable_sort(starts.begin(), starts.end(), [](const Start& p, const Start& q) { return p.area > q.area; });
  if (starts.size() > 8) starts.resize(8);
  std::vector<int32_t> row;
  for (const Start& s : starts) {
    const Shape& its = shape(face_[s.face]);
    const Vec3 middle = (*its.p[0].approx + *its.p[1].approx + *its.p[2].approx) / 3;
    SubPoint line;
    line[size_t(axis)] = bound_[size_t(axis)][0];
    line[size_t(b)] = std::llround(middle[b] * 0x1p24);
    line[size_t(c)] = std::llround(middle[c] * 0x1p24);
    // The region at the line's point of the low square: left along axis b to the next curve, else to the lattice edge.
    auto left = [&]() -> int32_t {
      hits_between(b, line, &line, row);
      if (row.empty()) {
        SubPoint at = line;
        at[size_t(b)] = bound_[size_t(b)][0];
        return region_on_lattice_edge(c, 0, at);
      }
      const LocalFace& next = face_[size_t(row.back())];
      const int after = 1 - side_before(*next.plane, b);
      if (!has(next.mat, after)) contradiction("material along a walk contradicts a face's bits");
      return member(size_t(row.back()), after);
    };
    if (walk_left(axis, line, glued_, root, left)) return true;
  }
  return false;
}

}  // namespace limberg
