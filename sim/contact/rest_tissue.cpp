#include "sim/contact/rest_tissue.h"

#include <algorithm>
#include <cmath>

#include "sim/geometry/triangle.h"
#include "sim/lattice/embedding.h"

namespace limberg {
namespace {

constexpr double kTie_mm = 1e-7;      // banks of one cut, the two sides of an edge
constexpr double kWhole = 0.999;      // a cell's fraction
constexpr double kWay_mm = 0.7;       // pieces of a cell that are smaller than this may be missed
constexpr double kOpposite = -0.999;  // cosine between two banks of one cut
constexpr float kRound_mm = 1e-4f;
constexpr size_t kRestGrain = 4;

template <class T>
void unique_sorted(std::vector<T>& v) {
  std::sort(v.begin(), v.end());
  v.erase(std::unique(v.begin(), v.end()), v.end());
}

/// Lists of lists from pairs (owner, member) that are sorted by their owners.
void pack(const std::vector<std::pair<int32_t, int32_t>>& pairs, size_t owners, std::vector<int32_t>& begin,
          std::vector<int32_t>& member) {
  begin.assign(owners + 1, 0);
  member.reserve(pairs.size());
  for (const auto& [o, m] : pairs) ++begin[size_t(o) + 1], member.push_back(m);
  for (size_t i = 0; i < owners; ++i) begin[i + 1] += begin[i];
}

/// The same from pairs (member, owner) that are sorted by their members, and so are the lists that come of it.
void pack_turned(const std::vector<std::pair<int32_t, int32_t>>& pairs, size_t owners, std::vector<int32_t>& begin,
                 std::vector<int32_t>& member) {
  begin.assign(owners + 1, 0);
  for (const auto& [m, o] : pairs) ++begin[size_t(o) + 1];
  for (size_t i = 0; i < owners; ++i) begin[i + 1] += begin[i];
  member.resize(pairs.size());
  std::vector<int32_t> next(begin.begin(), begin.end() - 1);
  for (const auto& [m, o] : pairs) member[size_t(next[size_t(o)]++)] = m;
}

}  // namespace

RestTissue::RestTissue(const ContactSurface& s, const FemModel& model) : surface_(&s) {
  const LatticeTopology& lattice = *s.lattice;
  for (size_t t = 0; t < s.tri.size(); ++t) {
    const Vec3 &a = s.X_mm[size_t(s.tri[t][0])], &b = s.X_mm[size_t(s.tri[t][1])], &c = s.X_mm[size_t(s.tri[t][2])];
    const Vec3 m = (a + b + c) / 3, n = area_vector2(a, b, c);
    corner_.push_back({a, b, c});
    ball_.push_back({m, std::sqrt(std::max({(a - m).squaredNorm(), (b - m).squaredNorm(), (c - m).squaredNorm()}))});
    normal_.push_back(n.norm() > 0 ? n.normalized() : Vec3(0, 0, 0));
  }
  for (size_t f = 0; f + 1 < s.sheets.fan_begin.size(); ++f) {
    Vec3 n = Vec3::Zero();
    for (int32_t t : s.sheets.triangles_of_fan(int32_t(f))) {
      const Tri& c = s.tri[size_t(t)];
      n += area_vector2(s.X_mm[size_t(c[0])], s.X_mm[size_t(c[1])], s.X_mm[size_t(c[2])]);
    }
    fan_normal_.push_back(n.norm() > 0 ? n.normalized() : n);
  }
  // Whose triangles: (copy, triangle).
  std::vector<std::pair<int32_t, int32_t>> own;
  for (size_t t = 0; t < s.tri.size(); ++t) {
    own.push_back({s.carrier[t], int32_t(t)});
    int32_t cell = lattice.cells[size_t(s.carrier[t])].cell;
    for (int32_t v : s.tri[t]) {
      const int32_t c = s.view->cell_copy[size_t(s.vertex[size_t(v)])];
      own.push_back({c, int32_t(t)});
      if (lattice.cells[size_t(c)].cell != cell) cell = -1;
    }
    const auto& v = corner_[t];
    if (cell >= 0 && !lattice.hanging.empty()) {  // parts of a divided cell have one number
      const auto& node = lattice.cells[size_t(s.carrier[t])].node;
      const Vec3 low = model.X_mm[size_t(node[0])].array() - kTie_mm,
                 high = model.X_mm[size_t(node[7])].array() + kTie_mm;
      for (const Vec3& x : v)
        if ((x.array() < low.array()).any() || (x.array() > high.array()).any()) cell = -1;
    }
    if (cell >= 0) continue;
    // It goes through several cells: whose it is along its way.
    const double longest =
        std::sqrt(std::max({(v[1] - v[0]).squaredNorm(), (v[2] - v[1]).squaredNorm(), (v[0] - v[2]).squaredNorm()}));
    const int parts = std::clamp(int(std::ceil(longest / kWay_mm)), 2, 64);
    for (int i = 0; i <= parts; ++i)
      for (int j = 0; i + j <= parts; ++j) {
        const std::array<double, 3> bary{double(i) / parts, double(j) / parts, double(parts - i - j) / parts};
        own.push_back({copy_of_point(lattice, *s.view, s.in_view[t], bary), int32_t(t)});
      }
  }
  unique_sorted(own);
  // Copies that carry something, by node; then all that share a node with one.
  std::vector<uint8_t> touched(model.X_mm.size(), 0);
  std::vector<uint8_t> carries(lattice.cells.size(), 0);
  for (const auto& [c, t] : own)
    if (!carries[size_t(c)]) {
      carries[size_t(c)] = 1;
      for (int32_t n : lattice.cells[size_t(c)].node) touched[size_t(n)] = 1;
    }
  std::vector<int32_t> place(lattice.cells.size(), -1);
  for (size_t c = 0; c < lattice.cells.size(); ++c) {
    const auto& node = lattice.cells[c].node;
    if (std::none_of(node.begin(), node.end(), [&](int32_t n) { return touched[size_t(n)] != 0; })) continue;
    place[c] = int32_t(copy_.size());
    copy_.push_back(int32_t(c));
    node_.insert(node_.end(), node.begin(), node.end());
  }
  unique_sorted(node_);
  std::vector<int32_t> slot_of(model.X_mm.size(), -1);
  for (size_t i = 0; i < node_.size(); ++i) slot_of[size_t(node_[i])] = int32_t(i);
  for (size_t c = 0; c < copy_.size(); ++c) {
    const CellCopy& cell = lattice.cells[size_t(copy_[c])];
    std::array<int32_t, 8> slot{};
    for (size_t k = 0; k < 8; ++k) slot[k] = slot_of[size_t(cell.node[k])];
    slot_.push_back(slot);
    low_.push_back(model.X_mm[size_t(cell.node[0])]);
    size_.push_back(model.X_mm[size_t(cell.node[7])] - low_.back());
    bare_.push_back(!carries[size_t(copy_[c])]);
    whole_.push_back(cell.fraction >= kWhole);
  }
  list_neighbours(lattice, slot_of);
  for (auto& [c, t] : own) c = place[size_t(c)];
  pack(own, copy_.size(), own_begin_, own_);
  wall_least_.assign(copy_.size(), 0), wall_most_.assign(copy_.size(), -1);
  for (const auto& [c, t] : own) {
    if (s.view->kind[size_t(s.in_view[size_t(t)])] != FaceKind::wall) continue;
    const int32_t sheet = s.sheets.of[size_t(t)];
    int32_t &least = wall_least_[size_t(c)], &most = wall_most_[size_t(c)];
    if (most < least) least = most = sheet;
    least = std::min(least, sheet), most = std::max(most, sheet);
  }
  of_part_.assign(copy_.size() * kParts * kParts * kParts, -1);
}

// Who hangs together: copies at the same node, or at a node and one of its masters; those that share a node of their
// own and carry something. Lists are made copy by copy: to sort all pairs at once takes most of a cut.
void RestTissue::list_neighbours(const LatticeTopology& lattice, const std::vector<int32_t>& slot_of) {
  std::vector<std::pair<int32_t, int32_t>> at_node;  // (copy that carries something, slot of one of its nodes)
  std::vector<std::pair<int32_t, int32_t>> all_at;   // (copy, slot of one of its nodes or of a master of one)
  std::vector<int32_t> all_first{0};                 // per copy: its first in all_at
  for (size_t c = 0; c < copy_.size(); ++c) {
    for (size_t k = 0; k < 8; ++k) {
      if (!bare_[c]) at_node.push_back({int32_t(c), slot_[c][k]});
      all_at.push_back({int32_t(c), slot_[c][k]});
      const LatticeTopology::Hanging* h = lattice.hanging_at(lattice.cells[size_t(copy_[c])].node[k]);
      if (!h) continue;
      for (int32_t i = 0; i < h->count; ++i)
        if (const int32_t m = slot_of[size_t(h->master[size_t(i)])]; m >= 0) all_at.push_back({int32_t(c), m});
    }
    all_first.push_back(int32_t(all_at.size()));
  }
  std::vector<int32_t> all_begin, all, begin, carriers, here;
  pack_turned(all_at, node_.size(), all_begin, all);
  pack_turned(at_node, node_.size(), begin, carriers);
  std::vector<size_t> last(copy_.size(), 0);  // the list that it was put into last
  size_t lists = 0;
  const auto add = [&](const std::vector<int32_t>& first, const std::vector<int32_t>& member, int32_t slot) {
    for (int32_t i = first[size_t(slot)]; i < first[size_t(slot) + 1]; ++i)
      if (size_t& l = last[size_t(member[size_t(i)])]; l != lists) l = lists, here.push_back(member[size_t(i)]);
  };
  adjacent_begin_ = around_begin_ = {0};
  for (size_t c = 0; c < copy_.size(); ++c) {
    here.clear(), ++lists;
    for (int32_t i = all_first[c]; i < all_first[c + 1]; ++i) add(all_begin, all, all_at[size_t(i)].second);
    std::sort(here.begin(), here.end());
    adjacent_.insert(adjacent_.end(), here.begin(), here.end());
    adjacent_begin_.push_back(int32_t(adjacent_.size()));
    here.clear(), ++lists;
    for (int32_t slot : slot_[c]) add(begin, carriers, slot);
    std::sort(here.begin(), here.end());
    for (int32_t o : here)
      if (o != int32_t(c)) around_.push_back(o);
    around_begin_.push_back(int32_t(around_.size()));
  }
}

int32_t RestTissue::find(int32_t copy) const {
  const auto at = std::lower_bound(copy_.begin(), copy_.end(), copy);
  return at != copy_.end() && *at == copy ? int32_t(at - copy_.begin()) : -1;
}

int32_t RestTissue::part(size_t c, const Vec3& at) const {
  int32_t part = int32_t(c);
  for (int a = 0; a < 3; ++a)
    part = part * kParts + std::clamp(int32_t((at[a] + kBeyond) / (1 + 2 * kBeyond) * kParts), 0, kParts - 1);
  return part;
}

Vec3 RestTissue::middle(int32_t part, size_t& c) const {
  Vec3 at;
  for (int a = 2; a >= 0; --a) at[a] = (0.5 + part % kParts) / kParts * (1 + 2 * kBeyond) - kBeyond, part /= kParts;
  c = size_t(part);
  return at;
}

// The point of triangle t in the cell of copy c that is nearest to
// Q; false when it has none. `foot` comes as the nearest of all.
bool RestTissue::into_cell(size_t c, int32_t t, const Vec3& Q, Vec3& foot) const {
  const Vec3 low = low_[c], high = low_[c] + size_[c];
  if ((foot.array() >= low.array()).all() && (foot.array() <= high.array()).all()) return true;
  std::array<Vec3, 12> polygon, cut;  // a triangle cut by six planes has nine corners at most
  size_t n = 3;
  for (size_t k = 0; k < 3; ++k) polygon[k] = corner_[size_t(t)][k];
  for (int a = 0; a < 3; ++a)
    for (const double side : {-1.0, 1.0}) {
      const double plane = side < 0 ? -low[a] : high[a];
      size_t m = 0;
      for (size_t k = 0; k < n; ++k) {
        const Vec3 &from = polygon[k], &to = polygon[(k + 1) % n];
        const double f = plane - side * from[a], g = plane - side * to[a];
        if (f >= 0) cut[m++] = from;
        if ((f < 0 && g > 0) || (f > 0 && g < 0)) cut[m++] = from + f / (f - g) * (to - from);
      }
      polygon = cut, n = m;
    }
  if (n == 0) return false;
  double least = 1e30;
  for (size_t k = 0; k + 2 < std::max<size_t>(n, 3); ++k) {
    const Vec3 p =
        closest_on_triangle(Q, polygon[0], polygon[std::min(k + 1, n - 1)], polygon[std::min(k + 2, n - 1)]).point;
    if ((Q - p).squaredNorm() < least) least = (Q - p).squaredNorm(), foot = p;
  }
  return true;
}

// All triangles that can be the nearest of their sheet for a
// point of the part, and all own ones that can decide its side.
void RestTissue::gather(int32_t part, std::vector<Near>& own, std::vector<Near>& others) const {
  const ContactSurface& s = *surface_;
  size_t c = 0;
  const Vec3 at = middle(part, c), Q = rest_mm(c, at);
  const double radius = 0.5 * (1 + 2 * kBeyond) / kParts * size_[c].norm();
  struct Seen {
    int32_t triangle, sheet;
    double d, in_cell;  // to its part in the cell
  };
  double least_in_cell = 1e30;
  std::vector<Seen> seen;
  std::vector<std::pair<int32_t, double>> nearest;  // per sheet
  const auto look = [&](std::span<const int32_t> triangles, double limit, bool own_ones) {
    for (int32_t t : triangles) {
      const int32_t sheet = s.sheets.of[size_t(t)];
      const auto k = std::find_if(nearest.begin(), nearest.end(), [&](const auto& n) { return n.first == sheet; });
      const double most = k == nearest.end() || own_ones ? limit : std::min(limit, k->second + 2 * radius + kTie_mm);
      const Ball& ball = ball_[size_t(t)];
      const double reach = most + ball.radius;
      if ((Q - ball.middle).squaredNorm() > reach * reach || normal_[size_t(t)].isZero(0)) continue;
      const auto& v = corner_[size_t(t)];
      if (std::abs(normal_[size_t(t)].dot(Q - v[0])) > most) continue;
      Vec3 foot = closest_on_triangle(Q, v[0], v[1], v[2]).point;
      const double d = (Q - foot).norm();
      if (d > most) continue;
      const double in_cell = own_ones && into_cell(c, t, Q, foot) ? (Q - foot).norm() : 1e30;
      least_in_cell = std::min(least_in_cell, in_cell);
      seen.push_back({t, sheet, d, in_cell});
      if (k == nearest.end())
        nearest.push_back({sheet, d});
      else
        k->second = std::min(k->second, d);
    }
  };
  const auto keep = [&](std::vector<Near>& out) {
    std::sort(seen.begin(), seen.end(),
              [](const Seen& a, const Seen& b) { return std::pair(a.d, a.triangle) < std::pair(b.d, b.triangle); });
    for (const Seen& k : seen) {
      const auto n = std::find_if(nearest.begin(), nearest.end(), [&](const auto& o) { return o.first == k.sheet; });
      if (k.d > n->second + 2 * radius + kTie_mm && k.in_cell > least_in_cell + 2 * radius + kTie_mm) continue;
      const auto same = [&](const Near& o) { return o.triangle == k.triangle; };
      if ((out.empty() || !same(out.back())) && std::none_of(own.begin(), own.end(), same))
        out.push_back({float(k.d) - kRound_mm, k.triangle, k.sheet});
    }
    seen.clear();
  };
  const std::span<const int32_t> mine(own_.data() + own_begin_[c], size_t(own_begin_[c + 1] - own_begin_[c]));
  look(mine, 1e3, true);
  keep(own);
  for (int32_t i = around_begin_[c]; i < around_begin_[c + 1]; ++i) {
    const size_t o = size_t(around_[size_t(i)]);
    look({own_.data() + own_begin_[o], size_t(own_begin_[o + 1] - own_begin_[o])}, kDeep_mm + radius, false);
  }
  keep(others);
}

void RestTissue::learn(std::span<const int32_t> parts, Workers& workers) {
  std::vector<int32_t> wanted(parts.begin(), parts.end());
  unique_sorted(wanted);
  std::erase_if(wanted, [&](int32_t p) { return known(p); });
  std::vector<std::array<std::vector<Near>, 2>> found(wanted.size());
  workers.parallel_for(wanted.size(), kRestGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) gather(wanted[i], found[i][0], found[i][1]);
  });
  for (size_t i = 0; i < wanted.size(); ++i) {
    List l;
    l.begin = int32_t(near_.size());
    near_.insert(near_.end(), found[i][0].begin(), found[i][0].end());
    l.own = int32_t(near_.size());
    near_.insert(near_.end(), found[i][1].begin(), found[i][1].end());
    l.end = int32_t(near_.size());
    of_part_[size_t(wanted[i])] = int32_t(list_.size());
    list_.push_back(l);
  }
}

// The copy's triangle that is met first on the straight way
// from Q to a place within triangle t, both in the cell, has
// Q's side. Nothing where the way leaves the cell at once.
std::optional<bool> RestTissue::inside_by_way(size_t c, const Vec3& Q, int32_t t, const Vec3& foot) const {
  const Vec3 low = low_[c], high = low_[c] + size_[c];
  for (const double share : {0.2, 0.05, 0.01}) {
    const Vec3 to = foot + share * (ball_[size_t(t)].middle - foot);
    if ((to.array() < low.array()).any() || (to.array() > high.array()).any()) continue;
    double first = 2;
    bool inside = false;
    for (int32_t i = own_begin_[c]; i < own_begin_[c + 1]; ++i) {
      const int32_t o = own_[size_t(i)];
      const auto& v = corner_[size_t(o)];
      const double from = normal_[size_t(o)].dot(Q - v[0]), end = o == t ? 0 : normal_[size_t(o)].dot(to - v[0]);
      if (from == 0 || (o != t && from * end >= 0)) continue;
      const double s = from / (from - end);
      const Vec3 meet = Q + s * (to - Q);
      if (o != t && (closest_on_triangle(meet, v[0], v[1], v[2]).point - meet).norm() > kTie_mm) continue;
      if (std::abs(s - first) * (to - Q).norm() <= kTie_mm)
        inside |= from < 0;  // banks that coincide in one copy: a slit
      else if (s < first)
        first = s, inside = from < 0;
    }
    if (first <= 1) return inside;
  }
  return std::nullopt;
}

void RestTissue::ask(size_t c, const Vec3& at, int32_t part, Answer& answer) const {
  answer.count = 0;
  const bool in = (at.array() >= -1e-6).all() && (at.array() <= 1 + 1e-6).all();
  // In a parted cell nothing is known of a copy without triangles; whatever is round a full one is outside of it.
  answer.inside = in && whole_[c];
  if (bare_[c] && !answer.inside) return;
  const Vec3 Q = rest_mm(c, at);
  size_t same = 0;
  // nothing can be nearer by more than this
  const double off = (at - middle(part, same)).cwiseProduct(size_[c]).norm();
  double nearest = 1e30;
  // Its side of the nearest of the copy's own triangles, as far as they are in the cell: what is nearer beyond the
  // cell's face belongs to a neighbour there. Of two that are as near, at an edge, the one that Q is farthest from
  // edge-on knows; where they disagree, a convex edge is seen from without and a concave one from within. Two banks
  // that coincide in one copy are a slit: it has material on both sides. Where more than two disagree, at a point or
  // where walls cross, the way to one of them tells.
  const List& list = list_[size_t(of_part_[size_t(part)])];
  const bool decides = in && !bare_[c] && !whole_[c];
  double deciding = 1e30, side = 0;
  int32_t by = -1, disagree = 0;
  bool slit = false;
  Vec3 by_foot = Q;
  const auto decide = [&](int32_t t, Vec3 foot) {
    if (!into_cell(c, t, Q, foot)) return;
    const double d = (Q - foot).norm(), height = normal_[size_t(t)].dot(Q - corner_[size_t(t)][0]);
    if (d > deciding + kTie_mm) return;
    const bool tie = d >= deciding - kTie_mm;
    deciding = std::min(d, deciding);
    if (!tie) disagree = 0;
    if (tie && height * side < 0) {
      ++disagree;
      if (std::abs(height + side) <= kTie_mm && normal_[size_t(t)].dot(normal_[size_t(by)]) < kOpposite) {
        slit = true;
        return;
      }
      const bool convex = normal_[size_t(by)].dot(ball_[size_t(t)].middle - corner_[size_t(by)][0]) < 0;
      if (convex != (height > 0)) return;
    } else if (tie && std::abs(height) <= std::abs(side)) {
      return;
    }
    slit = false;
    side = height, by = t, by_foot = foot;
  };
  const auto look = [&](int32_t from, int32_t to, double limit) {
    for (int32_t i = from; i < to; ++i) {
      const auto [least, t, sheet] = near_[size_t(i)];
      size_t f = 0;
      while (f < answer.count && answer.foot[f].sheet != sheet) ++f;
      const double most = f < answer.count ? answer.foot[f].distance_mm + kTie_mm : limit;
      if (double(least) - off > (decides && i < list.own ? std::max(most, deciding + kTie_mm) : most)) continue;
      const auto& v = corner_[size_t(t)];
      if (std::abs(normal_[size_t(t)].dot(Q - v[0])) > std::max(most, (decides ? deciding : nearest) + kTie_mm))
        continue;
      const TrianglePoint foot = closest_on_triangle(Q, v[0], v[1], v[2]);
      const Vec3 r = Q - foot.point;
      const double d = r.norm(), height = normal_[size_t(t)].dot(r);
      nearest = std::min(nearest, d);
      if (decides && i < list.own) decide(t, foot.point);
      if (f == answer.count) {
        if (f == kFeet || d > limit) continue;
        ++answer.count;
      } else {
        const Foot& was = answer.foot[f];
        if (d > was.distance_mm + kTie_mm ||
            (d >= was.distance_mm - kTie_mm && std::abs(height) <= std::abs(was.height_mm) + kTie_mm))
          continue;
      }
      answer.foot[f] = {t, sheet, foot.bary, d, height};
    }
  };
  look(list.begin, list.own, 1e3);
  if (decides) answer.inside = deciding < 1e30 && (side < 0 || slit);
  if (decides && disagree > 1 && !slit) answer.inside = inside_by_way(c, Q, by, by_foot).value_or(answer.inside);
  if (answer.inside) look(list.own, list.end, kDeep_mm);
  if (nearest <= kOn_mm) answer.inside = false;
}

Vec3 RestTissue::smooth_normal(int32_t t, const std::array<double, 3>& bary) const {
  Vec3 n = Vec3::Zero();
  for (size_t k = 0; k < 3; ++k) n += bary[k] * fan_normal_[size_t(surface_->sheets.fan[size_t(t)][k])];
  const double l = n.norm();
  return l > 1e-6 ? Vec3(n / l) : normal_[size_t(t)];
}

}  // namespace limberg
