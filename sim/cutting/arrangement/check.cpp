// Every invariant, everywhere: for tests and for finding defects.
#include <algorithm>

#include "sim/cutting/arrangement/planar_split.h"

namespace limberg {

const char* ArrangementStore::wrong_links(int32_t o) const {
  if (orig[size_t(o)].split < 0)
    return orig[size_t(o)].whole >= 0 && face[size_t(orig[size_t(o)].whole)].inner != 0
               ? "a whole triangle has an inner edge"
               : nullptr;
  const auto faces = faces_of(o);
  const auto junctions = constraints_of(o);
  PlanarSplit split;
  split.open(*this, o);
  const auto links = split.pieces();
  for (size_t i = 0; i < faces.size(); ++i)
    for (size_t k = 0; k < 3; ++k) {
      const auto& v = face[size_t(faces[i])].v;
      const int32_t a = v[k], b = v[(k + 1) % 3], n = links[i].neighbour[k];
      const int label = links[i].label[k];
      if ((face[size_t(faces[i])].inner >> k & 1) != (label == PlanarSplit::kFree))
        return "an inner edge is not known as such";
      if (n < 0) {
        const auto on_edge = [&](int32_t p) {
          const auto* ends = points.edge_of(p);
          const auto& c = orig[size_t(o)].v;
          return ends ? edge_of_orig(o, (*ends)[0], (*ends)[1]) == label
                      : p == c[size_t(label)] || p == c[size_t(label + 1) % 3];
        };
        if (label < 0 || label >= PlanarSplit::kJunction || !on_edge(a) || !on_edge(b))
          return "a piece at no edge of its triangle has no neighbour";
        continue;
      }
      const auto& w = face[size_t(faces[size_t(n)])].v;
      size_t m = 0;
      while (m < 3 && !(w[m] == b && w[(m + 1) % 3] == a)) ++m;
      if (m == 3) return "a piece's neighbour has not their edge";
      if (links[size_t(n)].neighbour[m] != int32_t(i) || links[size_t(n)].label[m] != label)
        return "two pieces disagree about their edge";
      if (label >= 0 && label < PlanarSplit::kJunction) return "an edge of the triangle between two of its pieces";
      if (label < 0) {
        if (face[size_t(faces[i])].mat != face[size_t(faces[size_t(n)])].mat)
          return "material ends at an edge that is no junction";
        for (int side = 0; side < 2; ++side)
          if (face[size_t(faces[i])].has_side(side) && mate[size_t(faces[i])][size_t(3 * side) + k] !=
                                                           sided_half_edge(sided_face(faces[size_t(n)], side), int(m)))
            return "two pieces are not glued at their edge";
        continue;
      }
      if (size_t(label - PlanarSplit::kJunction) >= junctions.size()) return "a junction that is not listed";
      const Constraint& c = junctions[size_t(label - PlanarSplit::kJunction)];
      if (std::minmax(a, b) != std::minmax(c.a, c.b)) return "a junction elsewhere than listed";
    }
  return nullptr;
}

std::string Arrangement::check_all() const {
  const ArrangementStore& s = *store_;
  const auto at = [](const char* what, int64_t i) { return std::string(what) + " at " + std::to_string(i); };
  uint64_t hash_sum = 0, volume = 0;
  std::vector<std::array<int32_t, 3>> sided;  // corners as seen from outside, smallest first
  for (int32_t f = 0; f < int32_t(s.face.size()); ++f) {
    const Face& face = s.face[f];
    if (!face.live()) continue;
    hash_sum += s.face_hash(face);
    volume = mod_add(volume, s.face_volume_residue(face));
    for (int side = 0; side < 2; ++side)
      for (int k = 0; k < 3; ++k) {
        const int32_t m = s.mate[f][size_t(3 * side + k)];
        if ((m >= 0) != face.has_side(side))
          return at("I1: a sided half-edge without mate, or a mate without material, face", f);
        if (m < 0) continue;
        if (s.mate[m / 6][size_t(m % 6)] != 6 * f + 3 * side + k) return at("I1: mate is no involution, face", f);
        const Face& g = s.face[m / 6];
        const int gside = m / 3 % 2, gk = m % 3;
        if (!g.has_side(gside)) return at("I1: mate is not there, face", f);
        const int32_t a = face.v[size_t(k)], b = face.v[size_t(k + 1) % 3];
        const int32_t c = g.v[size_t(gk)], d = g.v[size_t(gk + 1) % 3];
        const bool same_sense = a == c && b == d;
        if (!same_sense && !(a == d && b == c)) return at("I1: mates have different ends, face", f);
        // Seen from outside, side 0 runs backwards; mates must run in opposite senses.
        if (same_sense != (side != gside)) return at("I1: mates run the same way, face", f);
      }
    uint8_t found = 0;
    for (int k = 0; k < 3; ++k)
      for (int32_t h = s.edges.first(face.v[size_t(k)], face.v[size_t(k + 1) % 3]); h >= 0; h = s.edges.next(h))
        if (h == 3 * f + k) found |= uint8_t(1 << k);
    if (found != face.outer()) return at("the edge map has not the outer edges of face", f);
    std::array<int32_t, 3> v = face.v;
    std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    for (int side = 0; side < 2; ++side)
      if (face.has_side(side)) {
        if (side == 0) std::swap(v[1], v[2]);
        sided.push_back(v);
        if (side == 0) std::swap(v[1], v[2]);
      }
  }
  std::sort(sided.begin(), sided.end());
  if (std::adjacent_find(sided.begin(), sided.end()) != sided.end()) return "I9: two sided faces with the same corners";
  if (hash_sum != s.hash_sum) return "the running hash is wrong";
  if (volume != s.volume_residue) return "I4: the running volume is wrong";

  // Gluing afresh must change nothing (I13: sectors agree).
  ArrangementStore& writable = const_cast<ArrangementStore&>(s);
  for (int32_t f = 0; f < int32_t(s.face.size()); ++f)
    for (size_t k = 0; k < 3 && s.face[f].live(); ++k) {
      OperationDelta changes;
      changes.faces = int32_t(s.face.size());
      if (const char* why = writable.glue_edge(s.face[f].v[k], s.face[f].v[(k + 1) % 3], &changes))
        return at((std::string("I13: ") + why + ", face").c_str(), f);
      if (!changes.mate.empty()) return at("gluing afresh differs, face", f);
    }

  for (int32_t o = 0; o < int32_t(s.orig.size()); ++o) {
    const OrigTri& t = s.orig[o];
    int32_t live = 0;
    uint64_t whole = 0, parts = 0;
    Face shape;
    shape.mat = kMaterialMinus;
    shape.v = t.v;
    whole = s.face_volume_residue(shape);
    for (int32_t f : s.faces_of(o)) {
      const Face& face = s.face[f];
      if (face.retired || face.orig != o)
        return at("a division holds a face that is not its own, original triangle", o);
      live += face.live();
      if (orient2d(t.plane, s.points.ref(face.v[0]), s.points.ref(face.v[1]), s.points.ref(face.v[2])) <= 0)
        return at("a face without positive area", f);
      for (int32_t p : face.v)
        if (side_of_plane(t.plane, s.points.ref(p)) != 0) return at("a corner off its plane, face", f);
      shape.v = face.v;
      parts = mod_add(parts, s.face_volume_residue(shape));
    }
    if (const char* why = s.wrong_links(o)) return at((std::string(why) + ", original triangle").c_str(), o);
    if (parts != whole) return at("the division does not cover original triangle", o);
    if (live != t.live) return at("the live count is wrong on original triangle", o);
    // I11: a junction is an edge of both triangles that it joins.
    for (const Constraint& c : constraints_of(o)) {
      const auto edges_on = [&](int32_t triangle, bool& any_live) {
        int n = 0;
        for (int32_t f : s.faces_of(triangle))
          for (size_t k = 0; k < 3; ++k) {
            const int32_t a = s.face[f].v[k], b = s.face[f].v[(k + 1) % 3];
            if ((a == c.a && b == c.b) || (a == c.b && b == c.a)) ++n, any_live = any_live || s.face[f].live();
          }
        return n;
      };
      bool live_here = false, live_there = false;
      if (edges_on(o, live_here) != 2) return at("I11: a junction is not an edge of its own triangle", o);
      if (edges_on(c.partner, live_there) == 0 && live_here)
        // Where the partner's material was taken away it need not know; but no live face of it may run on there.
        for (int32_t f : s.faces_of(c.partner)) {
          const Face& face = s.face[f];
          bool holds = face.live();
          for (size_t k = 0; k < 3 && holds; ++k)
            for (int32_t p : {c.a, c.b})
              holds = holds && orient2d(s.orig[c.partner].plane, s.points.ref(face.v[k]),
                                        s.points.ref(face.v[(k + 1) % 3]), s.points.ref(p)) >= 0;
          if (holds) return at("I11: a live junction is unknown to its partner", o);
        }
    }
  }

  // I3: every component closed: V - E + F even.
  const SurfaceView view = surface_view();
  const auto& all = components();
  std::vector<int64_t> faces(all.size(), 0), vertices(all.size(), 0);
  std::vector<int32_t> component_of_vertex(view.X_mm.size(), -1);
  for (size_t i = 0; i < view.tri.size(); ++i) {
    const int32_t component = component_of(view.sided_face[i]);
    ++faces[size_t(component)];
    for (int32_t v : view.tri[i]) {
      if (component_of_vertex[size_t(v)] >= 0 && component_of_vertex[size_t(v)] != component)
        return "a vertex in two components";
      if (component_of_vertex[size_t(v)] < 0) ++vertices[size_t(component)];
      component_of_vertex[size_t(v)] = component;
    }
  }
  for (size_t c = 0; c < all.size(); ++c)
    if (faces[c] % 2 != 0 || (vertices[c] - faces[c] / 2) % 2 != 0)
      return at("I3: odd Euler characteristic, component", int64_t(c));
  // Components kept from cut to cut are those found afresh.
  if (s.components_known) {
    const Components kept = s.component;
    const std::vector<int32_t> kept_of = s.component_of;
    s.components_known = false;
    s.find_components();
    if (kept.volume != s.component.volume || kept.all.size() != s.component.all.size())
      return "the components are not what they were said to be";
    for (size_t c = 0; c < kept.all.size(); ++c)
      if (kept.all[c].first_sided_face != s.component.all[c].first_sided_face ||
          kept.all[c].sided_faces != s.component.all[c].sided_faces ||
          kept.all[c].touches_fixed != s.component.all[c].touches_fixed)
        return "a component is not what it was said to be";
    for (int32_t i = 0; i < int32_t(kept_of.size()); ++i)
      if (s.face[i / 2].has_side(i % 2) && kept_of[i] != s.component_of[i])
        return at("a sided face is said to be in another component, face", i / 2);
  }
  return {};
}

}  // namespace limberg
