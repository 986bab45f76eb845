#pragma once
// A model without cuts (box_model) with some of its cells divided, made by geometry alone: what the lattice does is
// tested against this elsewhere, and the elements are tested with it without a lattice.
#include <array>
#include <map>
#include <vector>

#include "sim/fem/model/fem_model.h"

namespace limberg::test {

struct DividedModel {
  FemModel model;                    // nodes of the whole cells keep their numbers
  std::vector<int32_t> cell_parent;  // per cell: the cell it is (a part of)
};

/// `level` per cell of `whole`, 0..2; neighbours must not differ by more than 1. Stencils must be of one material each.
inline DividedModel divide(const FemModel& whole, const std::vector<int>& level) {
  using Place = std::array<int, 3>;  // quarters of a whole cell
  DividedModel d;
  FemModel& m = d.model;
  m.cell_mm = whole.cell_mm;
  m.X_mm = whole.X_mm, m.fixed = whole.fixed;
  m.mass_kg.assign(whole.X_mm.size(), 0);
  const size_t kinds = whole.stencils.size();
  for (int l = 0; l < 3; ++l)
    for (Stencil s : whole.stencils) {  // K grows with the edge, volume with its cube
      s.K /= double(1 << l), s.volume_mm3 /= double(1 << 3 * l), s.level = uint8_t(l);
      m.stencils.push_back(s);
    }
  std::map<Place, int32_t> node;
  auto corner = [](Place low, int size, int k) {
    return Place{low[0] + (k & 1 ? size : 0), low[1] + (k & 2 ? size : 0), low[2] + (k & 4 ? size : 0)};
  };
  for (size_t i = 0; i < whole.X_mm.size(); ++i) m.parent.push_back(int32_t(i));
  for (const HexCell& c : whole.cells)
    for (int k = 0; k < 8; ++k) node[corner({2 * c.at[0], 2 * c.at[1], 2 * c.at[2]}, 4, k)] = c.node[size_t(k)];
  struct Leaf {
    Place low;
    int size;
  };
  std::vector<Leaf> leaves;
  for (size_t c = 0; c < whole.cells.size(); ++c) {
    const HexCell& from = whole.cells[c];
    const int n = 1 << level[c], size = 4 / n;
    const Place base{2 * from.at[0], 2 * from.at[1], 2 * from.at[2]};
    for (int z = 0; z < n; ++z)
      for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
          const Leaf leaf{{base[0] + x * size, base[1] + y * size, base[2] + z * size}, size};
          HexCell cell = from;
          cell.level = uint8_t(level[c]);
          cell.stencil = int32_t(kinds) * level[c] + from.stencil;
          for (size_t a = 0; a < 3; ++a) cell.at[a] = int16_t(leaf.low[a] / 2);
          for (int k = 0; k < 8; ++k) {
            const Place p = corner(leaf.low, size, k);
            auto [it, is_new] = node.try_emplace(p, int32_t(m.X_mm.size()));
            if (is_new) {
              BornNode born;
              born.node = it->second;
              Vec3 X = Vec3::Zero();
              unsigned held = Held(true).axes();
              int32_t nearest = -1;
              float most = 0;
              for (int b = 0; b < 8; ++b) {
                float w = 1;
                for (int a = 0; a < 3; ++a) {
                  const float t = float(p[size_t(a)] - base[size_t(a)]) / 4;
                  w *= b >> a & 1 ? t : 1 - t;
                }
                if (w == 0) continue;
                const int32_t v = from.node[size_t(b)];
                X += double(w) * whole.X_mm[size_t(v)];
                held &= whole.fixed[size_t(v)].axes();
                born.from.push_back({v, w});
                if (w > most) most = w, nearest = v;
              }
              m.X_mm.push_back(X), m.fixed.push_back(Held::axes(held)), m.mass_kg.push_back(0),
                  m.parent.push_back(nearest);
              m.born.push_back(born);
            }
            cell.node[size_t(k)] = it->second;
            m.mass_kg[size_t(it->second)] += from.scale * m.stencils[size_t(cell.stencil)].density_kg_mm3 *
                                             m.stencils[size_t(cell.stencil)].volume_mm3 / 8;
          }
          m.cells.push_back(cell);
          d.cell_parent.push_back(int32_t(c));
          leaves.push_back(leaf);
        }
  }
  std::map<int32_t, HangingNode> hanging;
  for (size_t c = 0; c < leaves.size(); ++c) {
    const Leaf& l = leaves[c];
    if (l.size == 1) continue;
    for (int ax = 0; ax < 3; ++ax)
      for (int high = 0; high < 2; ++high)
        for (int bits = 1; bits < 4;
             ++bits) {  // on the square ax/high: middle of the edges (1, 2) and of the square (3)
          const int u = (ax + 1) % 3, v = (ax + 2) % 3;
          for (int end = 0; end < (bits == 3 ? 1 : 2); ++end) {
            HangingNode h;
            Place p = l.low;
            p[size_t(ax)] += high * l.size;
            const int moving = bits == 1 ? u : v, other = bits == 1 ? v : u;
            p[size_t(moving)] += l.size / 2;
            p[size_t(other)] += bits == 3 ? l.size / 2 : end * l.size;
            const auto it = node.find(p);
            if (it == node.end()) continue;
            h.node = it->second;
            for (int k = 0; k < 8; ++k) {
              if ((k >> ax & 1) != high || (bits != 3 && (k >> other & 1) != end)) continue;
              h.master[size_t(h.count++)] = m.cells[c].node[size_t(k)];
            }
            for (int k = 0; k < h.count; ++k) h.weight[size_t(k)] = 1 / float(h.count);
            m.fixed[size_t(h.node)] = 0;
            hanging[h.node] = h;
          }
        }
  }
  for (auto& [id, h] : hanging) m.hanging.push_back(h);
  return d;
}

/// Levels that leave an undivided rim: 2 within `inner` of the
/// centre (in cells, largest coordinate), 1 within inner + 1.
inline std::vector<int> levels_around(const FemModel& whole, Vec3 centre_mm, double inner) {
  std::vector<int> level;
  for (const HexCell& c : whole.cells) {
    const Vec3 x = (whole.X_mm[size_t(c.node[0])] + whole.X_mm[size_t(c.node[7])]) / 2 - centre_mm;
    const double far = x.cwiseQuotient(whole.cell_mm).cwiseAbs().maxCoeff();
    level.push_back(far < inner ? 2 : far < inner + 1 ? 1 : 0);
  }
  return level;
}

}  // namespace limberg::test
