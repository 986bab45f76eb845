#include "sim/lattice/cell_builder.h"

#include <algorithm>

namespace limberg {

int CellComponents::class_of(int32_t sided_face) const {
  const auto it = std::lower_bound(face.begin(), face.end(), sided_face / 2);
  if (it == face.end() || *it != sided_face / 2) return -1;
  return of_side[size_t(it - face.begin())][size_t(sided_face & 1)];
}

std::shared_ptr<const CellComponents> CellBuilder::build(Int3 at, std::span<const int32_t> candidates,
                                                         uint8_t corners_in, const CellHistory& history) {
  enter(at);
  if (surface_.points->fails()) contradiction("made to fail");
  walks_ = unresolved_ = 0;
  const CellComponents* last = history.known && !history.whole ? history.before : nullptr;
  gather(candidates, last);
  if (face_.empty()) return nullptr;
  if (as_before_) {
    auto same = std::make_shared<CellComponents>(*last);
    for (size_t c = 0; c < same->classes.size(); ++c) same->classes[c].old_class = int16_t(c);
    return same;
  }
  for (int k = 0; k < 8; ++k) corner_in_[size_t(k)] = corners_in >> k & 1;
  join_.reset(2 * face_.size() + 8);
  join_faces();
  glued_ = join_;
  join_lattice_edges();
  join_walks();
  auto out = std::make_shared<CellComponents>();
  classify(history, *out);
  measure(*out);
  name_by_volume(history, *out);
  out->edge_state = edge_state_;
  out->walks = walks_;
  out->walks_unresolved = unresolved_;
  return out;
}

// Each lattice edge is walked upwards: every hit says whether there is material before and after it.
void CellBuilder::join_lattice_edges() {
  for (int axis = 0; axis < 3; ++axis)
    for (int corner = 0; corner < 4; ++corner) {
      auto& hits = hit_[size_t(4 * axis + corner)];
      const SubPoint line = edge_corner(axis, corner);
      if (hits.size() > 1)
        std::sort(hits.begin(), hits.end(), [&](int32_t a, int32_t b) {
          const int o = order_on_line(*face_[size_t(a)].plane, *face_[size_t(b)].plane, axis, line);
          return o ? o < 0 : a < b;
        });
      const int low = corner_of_edge(axis, corner, false), high = corner_of_edge(axis, corner, true);
      bool state = corner_in_[size_t(low)];
      int32_t region = corner_member(low);
      for (int32_t h : hits) {
        const LocalFace& f = face_[size_t(h)];
        const int before = side_before(*f.plane, axis), after = 1 - before;
        if (has(f.mat, before) != state) contradiction("material along a lattice edge contradicts a face's bits");
        if (state) join_.unite(region, member(size_t(h), before));
        state = has(f.mat, after);
        region = member(size_t(h), after);
      }
      if (state != corner_in_[size_t(high)]) contradiction("material along a lattice edge contradicts its end");
      join_.unite(region, corner_member(high));  // outside regions are never looked at again
      edge_state_[size_t(4 * axis + corner)] =
          hits.empty() ? 0 : uint8_t(4 | int(corner_in_[size_t(low)]) | int(corner_in_[size_t(high)]) << 1);
    }
}

void CellBuilder::classify(const CellHistory& history, CellComponents& out) {
  const size_t n = join_.size();
  class_of_root_.assign(n, -1);
  int16_t classes = 0;
  auto class_of = [&](int32_t m) {
    int16_t& c = class_of_root_[size_t(join_.find(m))];
    if (c < 0) {
      if (classes == INT16_MAX) contradiction("more than 32767 pieces");
      c = classes++;
    }
    return c;
  };
  out.of_corner.fill(-1);
  for (int k = 0; k < 8; ++k)
    if (corner_in_[size_t(k)]) out.of_corner[size_t(k)] = class_of(corner_member(k));
  const size_t faces = face_.size();
  out.face.resize(faces), out.of_side.resize(faces), out.relation.resize(faces), out.flux.resize(faces);
  for (size_t l = 0; l < faces; ++l) {
    const LocalFace& f = face_[l];
    out.face[l] = f.id;
    out.relation[l] = f.in.bits;
    out.flux[l] = f.flux;
    for (int s = 0; s < 2; ++s) out.of_side[l][size_t(s)] = has(f.mat, s) ? class_of(member(l, s)) : int16_t(-1);
  }
  out.classes.assign(size_t(classes), {});
  for (size_t k = 0; k < 8; ++k)
    if (out.of_corner[k] >= 0) out.classes[size_t(out.of_corner[k])].corners |= uint8_t(1u << k);
  for (size_t l = 0; l < face_.size(); ++l) {
    if (!surface_.is_fixed(face_[l].id)) continue;
    const Plane& p = *face_[l].plane;
    const int axis = projection_axis(p);
    for (int s = 0; s < 2; ++s)
      if (out.of_side[l][size_t(s)] >= 0) {
        const bool high = (p.n[size_t(axis)] > 0) == (s == 1);  // outward normal = away from the material's side
        out.classes[size_t(out.of_side[l][size_t(s)])].fixed_sides |= uint8_t(1u << (2 * axis + int(high)));
      }
  }
  if (history.whole)
    name_classes_of_whole(history, out);
  else if (history.known)
    name_old_classes(history, out);
}

// Every class of a part that faces meet is bounded by one of them, and a sided face has one class in the whole.
void CellBuilder::name_classes_of_whole(const CellHistory& history, CellComponents& out) const {
  const CellComponents& whole = *history.whole;
  std::vector<int16_t> in_whole(out.classes.size(), -1);
  for (size_t l = 0; l < out.face.size(); ++l)
    for (int s = 0; s < 2; ++s) {
      const int16_t mine = out.of_side[l][size_t(s)];
      if (mine < 0) continue;
      const int before = whole.class_of(sided_face(out.face[l], s));
      int16_t& old = in_whole[size_t(mine)];
      if (before < 0 || (old >= 0 && old != before)) contradiction("a part of a cell contradicts the whole");
      old = int16_t(before);
    }
  for (size_t c = 0; c < in_whole.size(); ++c) {
    if (in_whole[c] < 0) contradiction("a piece in a part of a cell has no face");
    out.classes[c].old_class = history.whole_is_named ? whole.classes[size_t(in_whole[c])].old_class : in_whole[c];
  }
}

// The old partition is the new one with both sides of every new wall united. Its groups are named after old classes by
// what has stayed: corners, faces, and pieces of the same original triangle; what is left is matched by elimination.
void CellBuilder::name_old_classes(const CellHistory& history, CellComponents& out) {
  const size_t classes = out.classes.size();
  old_.reset(classes);
  for (size_t l = 0; l < face_.size(); ++l)
    if (face_[l].mat == 3 && surface_.orig[size_t(surface_.faces[size_t(face_[l].id)].orig)].op > history.last_op)
      old_.unite(out.of_side[l][0], out.of_side[l][1]);
  const CellComponents* before = history.before;
  if (!before) {
    for (size_t c = 0; c < classes; ++c) {
      if (old_.find(int32_t(c)) != 0 && history.only_cuts) contradiction("a full cell had more than one class");
      out.classes[c].old_class = 0;
    }
    return;
  }
  std::vector<int16_t> name(classes, -1);
  auto vote = [&](int c, int old_class, bool must_agree) {
    if (c < 0 || old_class < 0) return;
    int16_t& n = name[size_t(old_.find(c))];
    if (n < 0)
      n = int16_t(old_class);
    else if (n != old_class && must_agree)
      contradiction("a cut has joined two pieces");
  };
  for (size_t k = 0; k < 8; ++k) vote(out.of_corner[k], before->of_corner[k], true);
  for (size_t l = 0, b = 0; l < out.face.size(); ++l) {  // both lists ascend
    while (b < before->face.size() && before->face[b] < out.face[l]) ++b;
    if (b == before->face.size()) break;
    if (before->face[b] != out.face[l]) continue;
    for (size_t s = 0; s < 2; ++s) vote(out.of_side[l][s], before->of_side[b][s], true);
  }
  auto unnamed = [&](size_t c) { return old_.find(int32_t(c)) == int32_t(c) && name[c] < 0; };
  auto any_unnamed = [&] {
    for (size_t c = 0; c < classes; ++c)
      if (unnamed(c)) return true;
    return false;
  };
  if (any_unnamed()) {  // divided faces: their original triangle had one class on that side
    for (size_t l = 0; l < out.face.size(); ++l)
      for (int s = 0; s < 2; ++s) {
        const int c = out.of_side[l][size_t(s)];
        if (c < 0 || name[size_t(old_.find(c))] >= 0) continue;
        const int32_t orig = surface_.faces[size_t(out.face[l])].orig;
        int found = -1;
        bool one = true;
        for (size_t b = 0; b < before->face.size(); ++b)
          if (surface_.faces[size_t(before->face[b])].orig == orig && before->of_side[b][size_t(s)] >= 0) {
            one = one && (found < 0 || found == before->of_side[b][size_t(s)]);
            found = before->of_side[b][size_t(s)];
          }
        if (one) vote(c, found, false);
      }
  }
  if (any_unnamed()) {
    std::vector<uint8_t> taken(before->classes.size(), 0);
    for (size_t c = 0; c < classes; ++c)
      if (old_.find(int32_t(c)) == int32_t(c) && name[c] >= 0) taken[size_t(name[c])] = 1;
    std::vector<int> free_class, open_group;
    for (size_t o = 0; o < taken.size(); ++o)
      if (!taken[o]) free_class.push_back(int(o));
    for (size_t c = 0; c < classes; ++c)
      if (unnamed(c)) open_group.push_back(int(c));
    if (before->classes.size() == 1) {
      for (int g : open_group) name[size_t(g)] = 0;
    } else if (open_group.size() == 1 && free_class.size() == 1) {
      name[size_t(open_group[0])] = int16_t(free_class[0]);
    }  // several: name_by_volume
  }
  int groups = 0;
  for (size_t c = 0; c < classes; ++c) groups += old_.find(int32_t(c)) == int32_t(c);
  if (history.only_cuts && groups != int(before->classes.size()))
    contradiction("the pieces with new walls closed are not the pieces of before");
  for (size_t c = 0; c < classes; ++c) out.classes[c].old_class = name[size_t(old_.find(int32_t(c)))];
}

// Several groups without a name hold nothing of before but volume, which a cut does not change: matched in its order.
void CellBuilder::name_by_volume(const CellHistory& history, CellComponents& out) {
  if (!history.known || !history.before || !history.only_cuts) return;
  std::vector<std::pair<double, int>> group, old_class;
  for (size_t c = 0; c < out.classes.size(); ++c) {
    if (out.classes[c].old_class >= 0) continue;
    const int root = old_.find(int32_t(c));
    if (root == int(c)) group.push_back({0, root});
    for (auto& g : group)
      if (g.second == root) g.first += out.classes[c].fraction;
  }
  if (group.empty()) return;
  std::vector<uint8_t> taken(history.before->classes.size(), 0);
  for (const CellClass& c : out.classes)
    if (c.old_class >= 0) taken[size_t(c.old_class)] = 1;
  for (size_t o = 0; o < taken.size(); ++o)
    if (!taken[o]) old_class.push_back({history.before->classes[o].fraction, int(o)});
  if (old_class.size() != group.size()) contradiction("an old piece has no part in the new ones");
  std::sort(group.begin(), group.end());
  std::sort(old_class.begin(), old_class.end());
  for (size_t i = 0; i < group.size(); ++i)
    for (size_t c = 0; c < out.classes.size(); ++c)
      if (old_.find(int32_t(c)) == group[i].second) out.classes[c].old_class = int16_t(old_class[i].second);
}

}  // namespace limberg
