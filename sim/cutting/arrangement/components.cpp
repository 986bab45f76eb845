// Components of the sided surface.
//
// A cut divides faces and adds walls; almost always the surface stays in one piece. That is seen from what is new
// alone: whatever of the old surface a path led through, the path can be led through the new sided faces instead, for
// every broken link now ends at one of them. So if the new sided faces hang together, or are found to by searches that
// start from all their groups at once and go outwards in turns, the component is what it was, with other faces. When a
// search comes to an end without meeting another, something has come off, and all is found afresh.
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/base/union_find.h"
#include "sim/cutting/arrangement/store.h"
#include "sim/geometry/triangle.h"

namespace limberg {

namespace {

// 6 times the signed volume under a sided face, in half-units^3 times 2^20. A sum of such is the same in any order.
int128 volume_under(const ArrangementStore& s, int32_t sided) {
  const Face& f = s.face[sided / 2];
  const Vec3 &a = s.points.approx(f.v[0]), &b = s.points.approx(f.v[1]), &c = s.points.approx(f.v[2]);
  return int128((sided % 2 == 1 ? 0x1p20 : -0x1p20) * a.dot(b.cross(c)));
}

double to_mm3(const ArrangementStore& s, const int128& volume) {
  const double unit = s.grid.half_unit_mm();
  return double(volume) * 0x1p-20 * unit * unit * unit / 6;
}

// Of a component. One so small that its place swallows it (each term is rounded to about a half-unit^3) is measured
// about one of its own corners: the sign tells whether it is a piece.
double measured_mm3(const ArrangementStore& s, int32_t id, const SurfaceComponent& c, const int128& volume) {
  if (std::abs(double(volume)) > 0x1p22 * c.sided_faces) return to_mm3(s, volume);
  const Vec3 o = s.points.approx(s.face[c.first_sided_face / 2].v[0]);
  double sum = 0;
  for (int32_t sided = c.first_sided_face; sided < int32_t(s.component_of.size()); ++sided) {
    const Face& f = s.face[sided / 2];
    if (s.component_of[sided] != id || !f.has_side(sided % 2)) continue;
    const Vec3 a = s.points.approx(f.v[0]) - o, b = s.points.approx(f.v[1]) - o, d = s.points.approx(f.v[2]) - o;
    sum += (sided % 2 == 1 ? 1.0 : -1.0) * a.dot(b.cross(d));
  }
  const double unit = s.grid.half_unit_mm();
  return sum * unit * unit * unit / 6;
}

bool is_fixed(const ArrangementStore& s, int32_t sided) {
  const int32_t o = s.face[sided / 2].orig;
  return s.is_body(o) && s.tag[o] == SurfaceTag::fixed;
}

/// Which group's search has come to a sided face first. Open addressing: searches see few of the faces that there are.
class Reached {
 public:
  Reached() : slot_(1024) {}
  /// The group that was there already, or -1: then `group` is now.
  int32_t enter(int32_t sided, int32_t group) {
    if (2 * used_ >= slot_.size()) {
      std::vector<Slot> old(4 * slot_.size());
      old.swap(slot_);
      for (const Slot& s : old)
        if (s.sided >= 0) slot_[find(s.sided)] = s;
    }
    Slot& s = slot_[find(sided)];
    if (s.sided >= 0) return s.group;
    s = {sided, group};
    ++used_;
    return -1;
  }

 private:
  struct Slot {
    int32_t sided = -1, group = -1;
  };
  size_t find(int32_t sided) const {
    size_t i = (uint32_t(sided) * 0x9e3779b9u >> 7) & (slot_.size() - 1);
    while (slot_[i].sided >= 0 && slot_[i].sided != sided) i = (i + 1) & (slot_.size() - 1);
    return i;
  }
  std::vector<Slot> slot_;
  size_t used_ = 0;
};

}  // namespace

void ArrangementStore::find_components() const {
  if (components_known) return;
  component = {};
  component_of.assign(2 * face.size(), -1);
  std::vector<int32_t> stack;
  for (int32_t start = 0; start < int32_t(2 * face.size()); ++start) {
    if (component_of[start] >= 0 || !face[start / 2].has_side(start % 2)) continue;
    const int32_t id = int32_t(component.all.size());
    SurfaceComponent c;
    c.first_sided_face = start;
    int128 volume = 0;
    stack.push_back(start);
    component_of[start] = id;
    while (!stack.empty()) {
      const int32_t sided = stack.back();
      stack.pop_back();
      ++c.sided_faces;
      c.touches_fixed = c.touches_fixed || is_fixed(*this, sided);
      volume += volume_under(*this, sided);
      for (int k = 0; k < 3; ++k) {
        const int32_t m = mate[sided / 2][size_t(3 * (sided % 2) + k)];
        if (m < 0 || component_of[m / 3] >= 0) continue;
        component_of[m / 3] = id;
        stack.push_back(m / 3);
      }
    }
    c.volume_mm3 = measured_mm3(*this, id, c, volume);
    component.all.push_back(c);
    component.volume.push_back(volume);
  }
  components_known = true;
}

void ArrangementStore::update_components(OperationDelta& delta) {
  if (!components_known) return;
  components_known = false;  // until it has worked out
  const int32_t old_sided = 2 * delta.faces;

  // New sided faces, in groups that hang together by themselves.
  std::vector<int32_t> fresh;
  for (int32_t f : last.added)
    for (int side = 0; side < 2; ++side)
      if (face[f].has_side(side)) fresh.push_back(sided_face(f, side));
  std::vector<int32_t> index(2 * face.size() - size_t(old_sided), -1);
  for (size_t i = 0; i < fresh.size(); ++i) index[size_t(fresh[i] - old_sided)] = int32_t(i);
  UnionFind groups(fresh.size());
  const auto neighbour = [&](int32_t sided, int k) {
    const int32_t m = mate[sided / 2][size_t(3 * (sided % 2) + k)];
    return m < 0 ? -1 : m / 3;
  };
  std::vector<int32_t> of_group(fresh.size(), -1);  // by root: the component that the group hangs on
  std::vector<std::pair<int32_t, int32_t>> beside;  // new sided face by its index, component of an old one next to it
  for (size_t i = 0; i < fresh.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const int32_t n = neighbour(fresh[i], k);
      if (n > fresh[i])  // each pair once
        groups.unite(int32_t(i), index[size_t(n - old_sided)]);
      else if (n >= 0 && n < old_sided)
        beside.push_back({int32_t(i), component_of[n]});
    }
  for (const auto& [i, its] : beside) {
    int32_t& c = of_group[size_t(groups.find(i))];
    if (c >= 0 && c != its) return;  // two components have become one
    c = its;
  }

  // Searches from every group outwards, in turns, until those of one component have met.
  struct Search {
    int32_t group, component;
    std::vector<int32_t> queue;
    size_t next = 0;
  };
  std::vector<Search> search;
  for (size_t i = 0; i < fresh.size(); ++i) {
    if (groups.find(int32_t(i)) != int32_t(i)) continue;
    if (of_group[i] < 0) return;  // a surface of its own
    search.push_back({int32_t(i), of_group[i], {}, 0});
  }
  const auto alone = [&](const Search& s) {  // met by all others of its component?
    for (const Search& t : search)
      if (t.component == s.component && !groups.same(t.group, s.group)) return false;
    return true;
  };
  bool apart = false;
  for (const Search& s : search) apart = apart || !alone(s);
  if (apart) {
    Reached reached;  // by which group
    for (size_t i = 0; i < fresh.size(); ++i)
      for (Search& s : search)
        if (s.group == groups.find(int32_t(i))) s.queue.push_back(fresh[i]);
    while (apart) {
      apart = false;
      for (Search& s : search) {
        if (alone(s)) continue;
        apart = true;
        if (s.next == s.queue.size()) {
          // Its own way is at an end; it may belong to a group that still goes on.
          bool others = false;
          for (const Search& t : search) others = others || (groups.same(t.group, s.group) && t.next < t.queue.size());
          if (!others) return;
          continue;
        }
        const int32_t at = s.queue[s.next++];
        for (int k = 0; k < 3; ++k) {
          const int32_t n = neighbour(at, k);
          if (n < 0) continue;
          if (n >= old_sided) {
            groups.unite(s.group, index[size_t(n - old_sided)]);
            continue;
          }
          const int32_t by = reached.enter(n, s.group);
          if (by < 0)
            s.queue.push_back(n);
          else
            groups.unite(s.group, by);
        }
      }
    }
  }

  // Every component that has lost faces has got new ones.
  std::vector<uint8_t> met(component.all.size(), 0);
  for (const Search& s : search) met[size_t(s.component)] = 1;
  for (int32_t f : last.removed)
    for (int side = 0; side < 2; ++side)
      if ((face[f].mat >> side & 1) && !met[size_t(component_of[sided_face(f, side)])]) return;

  Components now = component;
  component_of.resize(2 * face.size(), -1);
  for (const Search& s : search) of_group[size_t(groups.find(s.group))] = s.component;
  for (size_t i = 0; i < fresh.size(); ++i) {
    const int32_t c = of_group[size_t(groups.find(int32_t(i)))];
    component_of[fresh[i]] = c;
    ++now.all[size_t(c)].sided_faces;
    now.volume[size_t(c)] += volume_under(*this, fresh[i]);
  }
  for (int32_t f : last.removed)
    for (int side = 0; side < 2; ++side)
      if (face[f].mat >> side & 1) {
        const int32_t sided = sided_face(f, side), c = component_of[sided];
        --now.all[size_t(c)].sided_faces;
        now.volume[size_t(c)] -= volume_under(*this, sided);
        delta.component_of.push_back({sided, c});
      }
  for (size_t c = 0; c < now.all.size(); ++c) {
    SurfaceComponent& one = now.all[c];
    if (!met[c]) continue;
    int32_t& at = one.first_sided_face;
    while (!face[at / 2].has_side(at % 2) || component_of[at] != int32_t(c)) ++at;
    one.volume_mm3 = measured_mm3(*this, int32_t(c), one, now.volume[c]);
  }
  for (size_t c = 0; c + 1 < now.all.size(); ++c)
    if (now.all[c].first_sided_face > now.all[c + 1].first_sided_face) return;  // they change their numbers
  delta.component = std::move(component);
  component = std::move(now);
  components_known = true;
}

const std::vector<SurfaceComponent>& Arrangement::components() const {
  store_->find_components();
  return store_->component.all;
}

int32_t Arrangement::component_of(int32_t sided) const {
  store_->find_components();
  return store_->face[sided / 2].has_side(sided % 2) ? store_->component_of[sided] : -1;
}

int32_t Arrangement::loose_component_near(const Vec3& at_mm, double max_distance_mm) const {
  store_->find_components();
  const auto& all = store_->component.all;
  size_t largest = 0;
  for (size_t i = 1; i < all.size(); ++i)
    if (all[i].volume_mm3 > all[largest].volume_mm3) largest = i;
  int32_t best[2] = {-1, -1};  // loose; touching the held side
  double distance[2] = {max_distance_mm, max_distance_mm};
  for (int32_t sided = 0; sided < int32_t(2 * store_->face.size()); ++sided) {
    const int32_t c = store_->face[sided / 2].has_side(sided % 2) ? store_->component_of[sided] : -1;
    if (c < 0 || size_t(c) == largest || all[size_t(c)].volume_mm3 <= 0) continue;
    const Face& f = store_->face[sided / 2];
    const double d =
        (closest_on_triangle(at_mm, point_mm(f.v[0]), point_mm(f.v[1]), point_mm(f.v[2])).point - at_mm).norm();
    const int held = all[size_t(c)].touches_fixed;
    if (d < distance[held] || (d == distance[held] && best[held] < 0)) distance[held] = d, best[held] = c;
  }
  return best[0] >= 0 ? best[0] : best[1];
}

int Arrangement::pieces() const {
  int n = 0;
  for (const SurfaceComponent& c : components()) n += c.volume_mm3 > 0;
  return n;
}

double Arrangement::volume_mm3() const {
  double v = 0;
  for (const SurfaceComponent& c : components()) v += c.volume_mm3;
  return v;
}

}  // namespace limberg
