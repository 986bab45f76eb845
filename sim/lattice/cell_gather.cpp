// Which faces meet a cell, and the exact signs they need.
#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "sim/lattice/cell_builder.h"
#include "sim/lattice/contradiction.h"

namespace limberg {
namespace {

/// By the squares that a face reaches through (FaceInCell::squares): the lattice edges, bit 4 axis + corner, that may
/// pierce it. It reaches through both planes of such an edge.
constexpr std::array<uint16_t, 64> kMayPierce = [] {
  std::array<uint16_t, 64> may{};
  for (unsigned squares = 0; squares < 64; ++squares)
    for (unsigned axis = 0; axis < 3; ++axis)
      for (unsigned corner = 0; corner < 4; ++corner) {
        const unsigned i = (axis + 1) % 3, j = (axis + 2) % 3;
        if ((squares >> (2 * i + (corner & 1)) & 1) && (squares >> (2 * j + (corner >> 1)) & 1))
          may[squares] = uint16_t(may[squares] | 1u << (4 * axis + corner));
      }
  return may;
}();

}  // namespace

CellBuilder::CellBuilder(const LatticeGrid& grid, const MaterialSurface& surface)
    : grid_(grid), surface_(surface), known_layers_(1024) {}

void CellBuilder::contradiction(const char* what) const {
  throw Contradiction("lattice cell (" + std::to_string(index_[0]) + "," + std::to_string(index_[1]) + "," +
                      std::to_string(index_[2]) + "): " + what);
}

void CellBuilder::enter(Int3 at) {
  ++entered_;
  index_ = {at.x, at.y, at.z};
  for (int a = 0; a < 3; ++a)
    for (int high = 0; high < 2; ++high)
      bound_[size_t(a)][size_t(high)] = (int64_t(grid_.origin[a]) + int64_t(index_[size_t(a)] + high) * grid_.pitch[a])
                                        << kSubUnitBits;
  for (size_t a = 0; a < 3; ++a)
    for (size_t high = 0; high < 2; ++high) bounds_.half[a][high] = sub_to_half(bound_[a][high]);
  for (size_t axis = 0; axis < 3; ++axis)
    for (size_t corner = 0; corner < 4; ++corner) {
      SubPoint& c = bounds_.edge_corner[axis][corner];
      const size_t i = (axis + 1) % 3, j = (axis + 2) % 3;
      c[axis] = bound_[axis][0];
      c[i] = bound_[i][corner & 1];
      c[j] = bound_[j][corner >> 1];
    }
}

bool CellBuilder::meets(Int3 at, int32_t face) {
  enter(at);
  gather({&face, 1});
  return !face_.empty();
}

std::array<std::array<int32_t, 3>, 3> CellBuilder::layers(int32_t face) const {
  std::array<std::array<int32_t, 3>, 3> q;
  const Face& f = surface_.faces[size_t(face)];
  for (size_t k = 0; k < 3; ++k) {
    KnownLayers& known = known_layers_[(uint32_t(f.v[k]) * 0x9e3779b9u) >> 22];
    if (known.point != f.v[k]) {
      const PointRef p = surface_.points->ref(f.v[k]);
      for (int a = 0; a < 3; ++a) known.layer[size_t(a)] = layer_of(p, a, grid_.origin[a], grid_.pitch[a]);
      known.point = f.v[k];
    }
    q[k] = known.layer;
  }
  return q;
}

bool CellBuilder::pierced(const std::array<PointRef, 3>& p, int axis, const SubPoint& corner) {
  const int s = edge_about_corner(p[0], p[1], axis, corner);
  return s && edge_about_corner(p[1], p[2], axis, corner) == s && edge_about_corner(p[2], p[0], axis, corner) == s;
}

int CellBuilder::corner_of_edge(int axis, int corner, bool high) {
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  return int(high) << axis | (corner & 1) << i | (corner >> 1 & 1) << j;
}

int32_t CellBuilder::local_of(int32_t face) const {
  if (const size_t fresh = size_t(face) - size_t(first_layered_); fresh < fresh_place_.size())
    return fresh_place_[fresh].first == entered_ ? fresh_place_[fresh].second : -1;
  for (size_t i = uint32_t(face) * 0x9e3779b9u;; ++i) {
    const auto& [id, local] = place_[i & (place_.size() - 1)];
    if (id == face) return local;
    if (id < 0) return -1;
  }
}

// What each side is glued to along the edges that meet the cell. Two glued half-edges bound the same material along
// their edge; inside the cell they do so where the edge meets it: they are joined.
void CellBuilder::join_faces() {
  size_t places = 32;
  while (places < 3 * face_.size()) places *= 2;
  place_.assign(places, {-1, -1});
  for (size_t l = 0; l < face_.size(); ++l) {
    face_[l].mate.fill(-1);
    if (const size_t fresh = size_t(face_[l].id) - size_t(first_layered_); fresh < fresh_place_.size()) {
      fresh_place_[fresh] = {entered_, int32_t(l)};
      continue;
    }
    size_t i = uint32_t(face_[l].id) * 0x9e3779b9u;
    while (place_[i & (places - 1)].first >= 0) ++i;
    place_[i & (places - 1)] = {face_[l].id, int32_t(l)};
  }
  for (size_t l = 0; l < face_.size(); ++l) {
    LocalFace& f = face_[l];
    const auto& mate = surface_.mate[size_t(f.id)];
    for (int side = 0; side < 2; ++side) {
      if (!has(f.mat, side)) continue;
      const int32_t me = member(l, side);
      for (int e = 0; e < 3; ++e) {
        int32_t& m = f.mate[size_t(3 * side + e)];
        if (m >= 0 || !f.in.edge(size_t(e))) continue;
        const int32_t h = mate[size_t(3 * side + e)];
        if (h < 0) contradiction("a sided half-edge has no mate");
        const int32_t other = local_of(face_of_half_edge(h));
        if (other < 0) contradiction("a glued face does not meet the cell that their common edge meets");
        m = member(size_t(other), sided_of_half_edge(h) & 1);
        face_[size_t(other)].mate[size_t(h % 6)] = me;
        join_.unite(me, m);
      }
    }
  }
}

// The axis that an edge of a blade or the body, or a part of one, is parallel to; -1: none, or it is no such edge.
int CellBuilder::parallel_axis(int32_t p, int32_t q) const {
  const PointStore& points = *surface_.points;
  const auto *of_p = points.edge_of(p), *of_q = points.edge_of(q);
  int32_t a = p, b = q;
  if (of_p && of_q) {
    a = (*of_p)[0], b = (*of_p)[1];
    if (a != (*of_q)[0] || b != (*of_q)[1]) return -1;
  } else if (of_p || of_q) {
    const auto& ends = of_p ? *of_p : *of_q;
    const int32_t other = of_p ? q : p;
    a = ends[0], b = ends[1];
    if (other != a && other != b) return -1;
  }
  if (!points.is_explicit(a) || !points.is_explicit(b)) return -1;
  const Vec3 &x = points.approx(a), &y = points.approx(b);
  for (int axis = 0; axis < 3; ++axis)
    if (x[(axis + 1) % 3] == y[(axis + 1) % 3] && x[(axis + 2) % 3] == y[(axis + 2) % 3]) return axis;
  return -1;
}

CellBuilder::Shape& CellBuilder::shape(LocalFace& f) {
  if (f.shape >= 0) return shape_[size_t(f.shape)];
  f.shape = shapes_++;
  if (size_t(shapes_) > shape_.size()) shape_.resize(size_t(2 * shapes_));
  Shape& s = shape_[size_t(f.shape)];
  const auto& v = surface_.faces[size_t(f.id)].v;
  for (size_t k = 0; k < 3; ++k) s.p[k] = surface_.points->ref(v[k]);
  s.edge = {-1, -1, -1};
  s.layered = false;
  return s;
}

CellBuilder::Shape& CellBuilder::layered_shape(LocalFace& f) {
  Shape& s = shape(f);
  if (!s.layered) s.layer = layers(f.id), s.layered = true;
  return s;
}

int32_t CellBuilder::edge_between(int32_t a, int32_t b) {
  const uint64_t ends = uint64_t(uint32_t(a)) << 32 | uint32_t(b);
  for (size_t i = size_t(ends * 0x9e3779b97f4a7c15ull >> 40);; ++i) {
    EdgePlace& place = edge_place_[i & (edge_place_.size() - 1)];
    if (place.round != round_) {
      place = {ends, round_, int32_t(edge_.size())};
      edge_.emplace_back();
      return place.edge;
    }
    if (place.ends == ends) return place.edge;
  }
}

void CellBuilder::find_about(const LocalFace& f, const Shape& s, size_t e, EdgeInCell& out) const {
  size_t from = e, to = e == 2 ? 0 : e + 1;
  if (s.turned[e]) std::swap(from, to);
  // Points that lie this far apart along two axes are on no line along an axis.
  const Vec3 way = (*s.p[to].approx - *s.p[from].approx).cwiseAbs();
  constexpr double kNear = 4 * kApproximationError;
  const bool upright = (way[0] <= kNear) + (way[1] <= kNear) + (way[2] <= kNear) >= 2;
  const auto& v = surface_.faces[size_t(f.id)].v;
  out.about = edge_about_corners(s.p[from], s.p[to], upright ? parallel_axis(v[from], v[to]) : -1, bounds_);
  out.known = true;
}

bool CellBuilder::edge_meets(const LocalFace& f, const Shape& s, size_t e) {
  int8_t& known = edge_[size_t(s.edge[e])].meets;
  if (known < 0) known = finds_meeting(f, s, e);
  return known;
}

// Segment against box by separating axes: the three box normals (on exact layers), and the three cross products of the
// edge with the axes. An edge parallel to an axis gives no third kind of plane for it: that projection says nothing.
bool CellBuilder::finds_meeting(const LocalFace& f, const Shape& s, size_t e) {
  const auto& a = s.layer[e];
  const auto& b = s.layer[e == 2 ? 0 : e + 1];
  bool a_in = true, b_in = true;
  int beyond = 0;
  for (size_t k = 0; k < 3; ++k) {
    if ((a[k] < index_[k] && b[k] < index_[k]) || (a[k] > index_[k] && b[k] > index_[k])) return false;
    const bool ak = a[k] == index_[k], bk = b[k] == index_[k];
    a_in = a_in && ak;
    b_in = b_in && bk;
    beyond += !(ak && bk);
  }
  if (a_in || b_in || beyond == 1) return true;  // an end in it, or right through two opposite squares
  return !about(f, s, e).misses_all();
}

bool CellBuilder::pierced_by_edge(const LocalFace& f, const Shape& shape, int axis, int corner) {
  const auto side = [&](size_t e) {
    const int of_edge = about(f, shape, e).of(axis, corner);
    return shape.turned[e] ? -of_edge : of_edge;
  };
  const int s = side(0);
  if (!s || side(1) != s || side(2) != s) return false;
  SubPoint c = edge_corner(axis, corner);
  const int low = plane_at_corner(*f.plane, c);
  c[size_t(axis)] = bound_[size_t(axis)][1];
  return low != plane_at_corner(*f.plane, c);
}

// Which squares an edge that meets the cell pierces.
int8_t CellBuilder::crossed_squares(const LocalFace& f, const Shape& s, size_t e) {
  // Seen along axis v, the coordinates are ((v+1)%3, (v+2)%3). With (u, k) in this order, "corner to the left" and
  // "crossing at greater u than the corner" agree for an edge that rises in k; in the order (k, u) they are opposite. A
  // bound that both ends lie within needs no sign.
  const auto& from = s.layer[e];
  const auto& to = s.layer[e == 2 ? 0 : e + 1];
  uint32_t bits = 0;
  for (size_t k = 0; k < 3; ++k) {
    if (from[k] == to[k]) continue;
    // The signs are those of the edge from its lower point to its higher one.
    const int rising = (from[k] < to[k]) != s.turned[e] ? 1 : -1;
    const int32_t lo = std::min(from[k], to[k]), hi = std::max(from[k], to[k]), at = index_[k];
    for (int high = lo < at ? 0 : 1; high < (hi > at ? 2 : 1); ++high) {
      bool within = true;
      for (size_t step = 1; step <= 2 && within; ++step) {
        const size_t u = k + step < 3 ? k + step : k + step - 3, v = 3 - k - u;
        const bool u_first = step == 2;  // (v + 1) % 3 == u
        for (int u_high = 0; u_high < 2 && within; ++u_high) {
          if (u_high ? from[u] <= index_[u] && to[u] <= index_[u] : from[u] >= index_[u] && to[u] >= index_[u])
            continue;
          const int corner = u_first ? u_high | high << 1 : high | u_high << 1;
          const int past = about(f, s, e).of(int(v), corner) * (u_first ? 1 : -1) * rising;
          within = u_high ? past < 0 : past > 0;
        }
      }
      if (within) bits |= 1u << (2 * k + size_t(high));
    }
  }
  return int8_t(bits);
}

void CellBuilder::note_crossings(LocalFace& f, const Shape& s, int32_t local) {
  for (size_t e = 0; e < 3; ++e) {
    if (!f.in.edge(e)) continue;
    int8_t& known = edge_[size_t(s.edge[e])].crosses;
    if (known < 0) known = crossed_squares(f, s, e);
    for (uint32_t squares = uint32_t(known); squares; squares &= squares - 1) {
      const size_t square = size_t(std::countr_zero(squares));
      crossing_[square].push_back({local, int32_t(e)});
      f.in.bits |= FaceInCell::crossing(square, e);
    }
  }
}

void CellBuilder::take_known(FaceInCell in, int32_t local) {
  for (uint64_t hits = in.hits(); hits; hits &= hits - 1) hit_[size_t(std::countr_zero(hits))].push_back(local);
  for (uint64_t c = in.crossings(); c; c &= c - 1) {
    const int bit = std::countr_zero(c);
    crossing_[size_t(bit / 3)].push_back({local, bit % 3});
  }
}

void CellBuilder::gather(std::span<const int32_t> candidates, const CellComponents* before) {
  face_.clear();
  face_.reserve(candidates.size());
  shapes_ = 0;
  edge_.clear();
  edge_.reserve(3 * candidates.size());
  size_t places = 64;
  while (places < 6 * candidates.size()) places *= 2;
  if (places > edge_place_.size()) edge_place_.assign(places, {});
  ++round_;
  for (auto& h : hit_) h.clear();
  for (auto& c : crossing_) c.clear();
  size_t known = 0, taken_over = 0;
  const size_t last_known = before ? before->face.size() : 0;
  as_before_ = true;
  no_walks_before_ = before && before->walks == 0 && before->walks_unresolved == 0;
  constexpr size_t kAhead = 6;  // faces lie all over the surface's arrays: fetched ahead
  for (size_t next = 0; next < candidates.size(); ++next) {
    const int32_t id = candidates[next];
    if (next + kAhead < candidates.size()) {
      const size_t later = size_t(candidates[next + kAhead]);
      __builtin_prefetch(&surface_.faces[later]);
      __builtin_prefetch(&surface_.mate[later]);
    }
    const Face& source = surface_.faces[size_t(id)];
    if (!source.live()) continue;
    const int32_t local = int32_t(face_.size());
    while (known < last_known && before->face[known] < id) ++known;
    if (known < last_known && before->face[known] == id) {
      const FaceInCell in{before->relation[known]};
      face_.emplace_back(id, &surface_.orig[size_t(source.orig)].plane, source.mat, in, before->flux[known], true);
      if (in.bits >> 10) take_known(in, local);
      for (int side = 0; side < 2; ++side)
        as_before_ = as_before_ && has(source.mat, side) == (before->of_side[known][size_t(side)] >= 0);
      ++taken_over;
      continue;
    }
    const auto layer = grid_layers(id);
    bool apart = false;
    uint8_t squares = 0;
    for (size_t a = 0; a < 3; ++a) {
      const int32_t p = layer[0][a], q = layer[1][a], r = layer[2][a], at = index_[a];
      const int32_t lo = std::min(p, std::min(q, r)), hi = std::max(p, std::max(q, r));
      apart = apart || hi < at || lo > at;
      squares |= uint8_t(int(lo < at) << (2 * a) | int(hi > at) << (2 * a + 1));
    }
    if (apart) continue;
    LocalFace& f = face_.emplace_back(id, &surface_.orig[size_t(source.orig)].plane, source.mat, FaceInCell{},
                                      std::nan(""), false);
    if (squares == 0) {
      f.in.bits = FaceInCell::kWhole;
      continue;
    }
    Shape& s = shape(f);
    s.layer = layer;
    s.layered = true;
    f.in.set_squares(squares);
    bool meets = false;
    for (size_t e = 0; e < 3; ++e) {
      const int32_t from = source.v[e], to = source.v[e == 2 ? 0 : e + 1];
      s.turned[e] = from > to;
      s.edge[e] = edge_between(std::min(from, to), std::max(from, to));
      if (edge_meets(f, s, e)) f.in.set_edge(e), meets = true;
    }
    for (uint32_t may = kMayPierce[squares]; may; may &= may - 1) {
      const int lattice_edge = std::countr_zero(may);
      if (!pierced_by_edge(f, s, lattice_edge / 4, lattice_edge % 4)) continue;
      hit_[size_t(lattice_edge)].push_back(local);
      f.in.bits |= FaceInCell::hit(lattice_edge);
      meets = true;
    }
    if (!meets)
      face_.pop_back(), --shapes_;
    else
      note_crossings(f, s, local);
  }
  as_before_ = as_before_ && before && taken_over == last_known && face_.size() == taken_over;
}

}  // namespace limberg
