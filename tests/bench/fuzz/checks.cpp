#include "tests/bench/fuzz/checks.h"

#include <cmath>
#include <span>
#include <vector>

namespace limberg::fuzz {

double body_volume_mm3(const BodySpec& spec) { return spec.size_mm * spec.size_mm * spec.thickness_mm; }

namespace {

/// A number per node that means nothing; hanging ones in the middle of their masters.
std::vector<double> some_state(const LatticeTopology& t) {
  std::vector<double> u(t.nodes.size());
  for (size_t n = 0; n < u.size(); ++n) u[n] = std::sin(1.7 * double(n));
  for (const auto& h : t.hanging) {
    u[size_t(h.node)] = 0;
    for (size_t k = 0; k < size_t(h.count); ++k) u[size_t(h.node)] += u[size_t(h.master[k])] / h.count;
  }
  return u;
}

/// The state of a corner of a cell, in the copy that it was or was a part of.
double state_in(const LatticeTopology& before, const CellCopy& whole, const CellPlace& at, int corner,
                std::span<const double> u) {
  const CellPlace from = before.tree.place(before.grid, whole.cell);
  double sum = 0;
  for (int b = 0; b < 8; ++b) {
    double w = 1;
    for (int a = 0; a < 3; ++a) {
      const double s = double(at.at[a] + (corner >> a & 1)) / (1 << (at.level - from.level)) - from.at[a];
      w *= b >> a & 1 ? s : 1 - s;
    }
    sum += w * u[size_t(whole.node[size_t(b)])];
  }
  return sum;
}

}  // namespace

std::string check_parents(const LatticeTopology& before, const LatticeTopology& after, bool only_cuts) {
  std::vector<double> fraction(before.cells.size(), 0);
  const std::vector<double> u = some_state(before);
  std::vector<double> v(after.nodes.size());
  for (size_t n = 0; n < v.size(); ++n) {
    const int32_t p = after.node_parent[n];
    if (p < 0 || size_t(p) >= u.size()) return "I7: a node copy without parent";
    v[n] = u[size_t(p)];
  }
  for (const auto& b : after.born) {
    v[size_t(b.node)] = 0;
    for (auto [p, w] : b.from) v[size_t(b.node)] += w * u[size_t(p)];
  }
  for (const auto& h : after.hanging) {
    double middle = 0;
    for (size_t k = 0; k < size_t(h.count); ++k) middle += v[size_t(h.master[k])] / h.count;
    if (std::abs(middle - v[size_t(h.node)]) > 1e-12) return "I7: a hanging node starts away from its masters";
  }
  for (size_t i = 0; i < after.cells.size(); ++i) {
    const CellCopy& c = after.cells[i];
    const int32_t parent = after.cell_parent[i];
    if (c.fraction < -1e-9 || c.fraction > 1 + 1e-9) return "I5: a fraction outside 0 to 1";
    if (parent < 0 || size_t(parent) >= before.cells.size()) return "I7: a cell copy without parent";
    const CellCopy& whole = before.cells[size_t(parent)];
    int32_t cell = c.cell;
    double share = 1;
    for (; cell != whole.cell && after.tree.is_part(cell); cell = after.tree.owner(cell)) share /= 8;
    if (cell != whole.cell) return "I7: a parent in another cell";
    fraction[size_t(parent)] += share * c.fraction;
    const CellPlace at = after.tree.place(after.grid, c.cell);
    for (int k = 0; k < 8; ++k)
      if (std::abs(state_in(before, whole, at, k, u) - v[size_t(c.node[size_t(k)])]) > 1e-12)
        return "I7: a node copy's parent is not the one of its cell";
  }
  for (size_t c = 0; c < fraction.size(); ++c)
    if (fraction[c] > before.cells[c].fraction + 1e-10 || (only_cuts && fraction[c] < before.cells[c].fraction - 1e-10))
      return "I5: the children of a cell copy have another volume than it had";
  return {};
}

std::string check_same(const LatticeTopology& updated, const LatticeTopology& built) {
  if (built.cells.size() != updated.cells.size()) return "update: another number of cell copies than when built anew";
  if (built.nodes.size() != updated.nodes.size()) return "update: another number of node copies than when built anew";
  if (built.hanging.size() != updated.hanging.size())
    return "update: another number of hanging nodes than when built anew";
  if (built.links != updated.links) return "update: other links than when built anew";
  if (built.node_in_material != updated.node_in_material) return "update: other nodes in material than when built anew";
  for (size_t c = 0; c < built.components.size(); ++c) {
    const auto &b = built.components[c], &u = updated.components[c];
    if (bool(b) != bool(u)) return "update: a cell with faces has none when built anew";
    if (b && (b->face != u->face || b->of_side != u->of_side || b->of_corner != u->of_corner))
      return "update: other classes than when built anew";
  }
  return {};
}

std::string check_refines(const LatticeTopology& coarse, const LatticeTopology& fine) {
  std::vector<double> volume(coarse.cells.size(), 0);
  for (size_t cell = 0; cell < fine.components.size(); ++cell) {
    if (fine.copies_of(int32_t(cell)) == 0) continue;
    const Int3 at = fine.grid.cell_at(int32_t(cell));
    const Int3 above{at.x / 2, at.y / 2, at.z / 2};
    for (int a = 0; a < 3; ++a)
      if (above[a] >= coarse.grid.count[a]) return "refinement: material beyond the coarse lattice";
    const int32_t big = coarse.grid.cell_index(above);
    const auto& f = fine.components[cell];
    const auto& c = coarse.components[size_t(big)];
    if (!f) {  // full: one copy; the coarse cell's one copy, or the one at a corner that both share
      int cls = -1;
      if (!c) cls = coarse.copies_of(big) == 1 ? 0 : -1;
      const int corner = (at.x & 1) | (at.y & 1) << 1 | (at.z & 1) << 2;
      if (c) cls = c->of_corner[size_t(corner)];
      if (cls < 0) return "refinement: a full fine cell where the coarse one has no material";
      volume[size_t(coarse.copy(big, cls))] += 0.125;
      continue;
    }
    if (!c) return "refinement: a fine cell has faces, the coarse one none";
    std::vector<int> of(f->classes.size(), -1);
    const auto join = [&](int small, int large) {
      if (small < 0) return large < 0;
      if (large < 0 || (of[size_t(small)] >= 0 && of[size_t(small)] != large)) return false;
      of[size_t(small)] = large;
      return true;
    };
    for (size_t i = 0; i < f->face.size(); ++i)
      for (int s = 0; s < 2; ++s)
        if (!join(f->of_side[i][size_t(s)], c->class_of(2 * f->face[i] + s)))
          return "refinement: one piece of a fine cell lies in two of the coarse one";
    const int corner = (at.x & 1) | (at.y & 1) << 1 | (at.z & 1) << 2;
    if (!join(f->of_corner[size_t(corner)], c->of_corner[size_t(corner)]))
      return "refinement: the corner of a fine cell lies in another piece of the coarse one";
    for (size_t k = 0; k < of.size(); ++k) {
      if (of[k] < 0) return "refinement: a piece of a fine cell that no face of it names";
      volume[size_t(coarse.copy(big, of[k]))] += 0.125 * f->classes[k].fraction;
    }
  }
  for (size_t k = 0; k < volume.size(); ++k)
    if (std::abs(volume[k] - coarse.cells[k].fraction) > 1e-9) return "refinement: the volumes do not add up";
  return {};
}

}  // namespace limberg::fuzz
