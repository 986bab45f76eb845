#pragma once
// Random cuts of a box of hexahedra, as a lattice makes them: cells are parted along squares, corners that no longer
// hang together become copies, and loose cells may be taken out. Copies keep their order, new ones come after.
#include <map>
#include <set>

#include "models.h"
#include "sim/base/union_find.h"
#include "sim/fem/preconditioner/scalar_matrix.h"

namespace limberg::test {

class CutBox {
 public:
  explicit CutBox(const BoxSpec& spec) : box_(box_model(spec)), spec_(spec) {
    alive_.assign(box_.cells.size(), 1);
    for (size_t c = 0; c < box_.cells.size(); ++c) {
      const auto& at = box_.cells[c].at;
      cell_at_[{at[0], at[1], at[2]}] = int32_t(c);
    }
    make();
  }

  std::shared_ptr<const FemModel> model() const { return model_; }
  const std::vector<int32_t>& cell_parent() const { return cell_parent_; }

  /// A vertical cut between columns, a horizontal one under a patch, or both; a through-cut when deep.
  void cut(Random& r) {
    const auto pick = [&](int n) { return std::min(n - 1, int((r.uniform() + 1) / 2 * n)); };
    const Int3 n = spec_.cells;
    const int axis = pick(3);
    if (axis == 2) {
      const int z = pick(n.z), x0 = pick(n.x), y0 = pick(n.y), x1 = x0 + 1 + pick(4), y1 = y0 + 1 + pick(4);
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) part(x, y, z, 2);
    } else {
      const int m = axis ? n.y : n.x, other = axis ? n.x : n.y;
      const int p = pick(m), q0 = pick(other), q1 = q0 + 1 + pick(other), z0 = pick(n.z);
      for (int z = z0; z < n.z; ++z)
        for (int q = q0; q < q1; ++q) axis ? part(q, p, z, 1) : part(p, q, z, 0);
    }
    make();
  }
  /// Takes a few cells out.
  void excise(Random& r) {
    const auto pick = [&](int n) { return std::min(n - 1, int((r.uniform() + 1) / 2 * n)); };
    const Int3 n = spec_.cells;
    const int x0 = pick(n.x), y0 = pick(n.y), z0 = pick(n.z);
    for (int z = z0; z < n.z; ++z)
      for (int y = y0; y < y0 + 2; ++y)
        for (int x = x0; x < x0 + 2; ++x)
          if (const int32_t c = find(x, y, z); c >= 0) alive_[size_t(c)] = 0;
    make();
  }
  /// A spring between two random places, in the model of now.
  fem::SpringRow spring(Random& r, int id) const {
    const auto place = [&] {
      const HexCell& c =
          model_
              ->cells[std::min(model_->cells.size() - 1, size_t((r.uniform() + 1) / 2 * double(model_->cells.size())))];
      EmbeddedPoint p;
      p.node = c.node;
      for (float& w : p.w) w = 0.125f;
      return p;
    };
    Spring s;
    s.id = id, s.k_N_per_mm = 1, s.a = place(), s.b = place();
    return fem::spring_row(*model_, s);
  }

 private:
  int32_t find(int x, int y, int z) const {
    const auto it = cell_at_.find({2 * x, 2 * y, 2 * z});
    return it == cell_at_.end() ? -1 : it->second;
  }
  void part(int x, int y, int z, int axis) {
    if (const int32_t c = find(x, y, z); c >= 0) parted_.insert({c, axis});
  }
  void make() {
    // Classes of (cell, corner) over squares that are not parted.
    const size_t cells = box_.cells.size();
    UnionFind corners(8 * cells);
    for (size_t c = 0; c < cells; ++c)
      for (int axis = 0; axis < 3; ++axis) {
        std::array<int, 3> at{box_.cells[c].at[0] / 2, box_.cells[c].at[1] / 2, box_.cells[c].at[2] / 2};
        ++at[size_t(axis)];
        const int32_t d = find(at[0], at[1], at[2]);
        if (d < 0 || !alive_[c] || !alive_[size_t(d)] || parted_.count({int32_t(c), axis})) continue;
        for (int a = 0; a < 8; ++a)
          if (a >> axis & 1) corners.unite(int32_t(8 * c) + a, 8 * d + (a ^ (1 << axis)));
      }
    // First the classes that go on, in the order of before, then the others.
    std::map<int32_t, int32_t> number;                      // root -> node
    std::vector<int32_t> parent, from;                      // per node: of which node, and a (cell, corner) in it
    std::vector<std::pair<int32_t, int32_t>> going, fresh;  // (parent, root)
    std::set<int32_t> seen_root, seen_parent;
    for (size_t c = 0; c < cells; ++c)
      for (int a = 0; a < 8 && alive_[c]; ++a) {
        const int32_t p = corners.find(int32_t(8 * c) + a);
        if (!seen_root.insert(p).second) continue;
        const int32_t old = node_of_.empty() ? box_.cells[c].node[size_t(a)] : node_of_[8 * c + size_t(a)];
        (seen_parent.insert(old).second ? going : fresh).push_back({old, p});
      }
    std::sort(going.begin(), going.end());
    going.insert(going.end(), fresh.begin(), fresh.end());
    auto m = std::make_shared<FemModel>();
    m->cell_mm = box_.cell_mm, m->stencils = box_.stencils;
    for (auto [old, p] : going) {
      number[p] = int32_t(m->X_mm.size());
      const size_t v = size_t(box_.cells[size_t(p / 8)].node[size_t(p % 8)]);
      m->X_mm.push_back(box_.X_mm[v]), m->fixed.push_back(box_.fixed[v]), m->mass_kg.push_back(1e-6);
      m->parent.push_back(node_of_.empty() ? -1 : old);
    }
    std::vector<int32_t> index(cells, -1);
    cell_parent_.clear();
    node_of_.assign(8 * cells, -1);
    for (size_t c = 0; c < cells; ++c) {
      if (!alive_[c]) continue;
      HexCell cell = box_.cells[c];
      for (int a = 0; a < 8; ++a)
        node_of_[8 * c + size_t(a)] = cell.node[size_t(a)] = number[corners.find(int32_t(8 * c) + a)];
      index[c] = int32_t(m->cells.size());
      cell_parent_.push_back(index_.empty() ? -1 : index_[c]);
      m->cells.push_back(cell);
    }
    index_ = index;
    model_ = m;
  }

  FemModel box_;
  BoxSpec spec_;
  std::map<std::array<int, 3>, int32_t> cell_at_;
  std::vector<uint8_t> alive_;
  std::set<std::pair<int32_t, int>> parted_;  // (cell, axis): from its neighbour on the + side
  std::vector<int32_t> node_of_, index_;      // of the model of now: per (cell, corner) and per cell of the box
  std::shared_ptr<const FemModel> model_;
  std::vector<int32_t> cell_parent_;
};

}  // namespace limberg::test
