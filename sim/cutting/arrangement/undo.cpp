// Taking an operation back exactly, and the forest of box trees.
#include "sim/cutting/arrangement/store.h"

namespace limberg {

void ArrangementStore::take_back(OperationDelta& d) {
  // Bits return first (debris may have been swept from faces that the operation made); then faces made by the operation
  // leave the edge map and those it retired return.
  for (size_t i = d.mat.size(); i-- > 0;) {
    const auto& [f, bits] = d.mat[i];
    const bool was_in = face[f].live();
    face[f].mat = bits;
    if (!was_in) edges.add(f, face[f].v, face[f].outer());
  }
  for (size_t f = size_t(d.faces); f < face.size(); ++f)
    if (face[f].live()) edges.remove(int32_t(f), face[f].v, face[f].outer());
  for (int32_t f : d.retired) {
    face[f].retired = false;
    if (face[f].live()) edges.add(f, face[f].v, face[f].outer());
  }
  take_back_arrays(d);
  components_known = components_known && d.component;
  if (components_known) {
    component = std::move(*d.component);
    component_of.resize(2 * face.size());
    for (const auto& [sided, c] : d.component_of) component_of[sided] = c;
  }
}

void ArrangementStore::take_back_arrays(const OperationDelta& d) {
  for (size_t i = d.mate.size(); i-- > 0;) mate[d.mate[i].first / 6][size_t(d.mate[i].first % 6)] = d.mate[i].second;
  face.resize(size_t(d.faces));
  mate.resize(size_t(d.faces));
  for (size_t i = d.orig.size(); i-- > 0;) {
    const OperationDelta::OrigBefore& b = d.orig[i];
    OrigTri& o = orig[b.orig];
    o.live = b.live;
    o.whole = b.whole;
    o.split = b.split;
    if (b.division) division[b.split] = *b.division;
  }
  division.resize(size_t(d.divisions));
  division_face.resize(d.division_faces);
  division_link.resize(d.division_faces);
  division_constraint.resize(d.division_constraints);
  orig.resize(size_t(d.origs));
  op.resize(size_t(d.ops));
  points.truncate(d.points);
  forest = d.forest;
  hash_sum = d.hash_sum;
  volume_residue = d.volume_residue;
}

void ArrangementStore::plant() {
  OpRecord& last_op = op.back();
  std::vector<std::array<Int3, 3>> corner;
  corner.reserve(orig.size() - size_t(last_op.first_orig));
  for (size_t o = size_t(last_op.first_orig); o < orig.size(); ++o) {
    const auto& v = orig[o].v;
    corner.push_back({points.integer(v[0]), points.integer(v[1]), points.integer(v[2])});
  }
  last_op.boxes = BoxTree(corner);
  if (op.size() == 1) return;  // the body
  // Trees over blades merge when the older is not larger than twice the newer: few trees, each blade moved seldom.
  auto tree = std::make_shared<OpTree>();
  tree->first = int32_t(op.size()) - 1, tree->count = 1;
  while (!forest.empty() && forest.back()->count <= 2 * tree->count) {
    tree->first = forest.back()->first;
    tree->count += forest.back()->count;
    forest.pop_back();
  }
  corner.clear();
  for (size_t i = size_t(tree->first); i < op.size(); ++i) {
    const IntBox all = op[i].boxes.all();
    corner.push_back({all.lo, all.hi, all.lo});
  }
  tree->boxes = BoxTree(corner);
  forest.push_back(std::move(tree));
}

}  // namespace limberg
