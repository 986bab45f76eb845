#include "sim/fem/elements/cell_scatter.h"

namespace limberg::fem {

CellScatter::CellScatter(const std::vector<std::array<int32_t, 8>>& cells, size_t node_count,
                         const std::vector<uint8_t>& corners) {
  const auto used = [&](size_t c) { return corners.empty() ? size_t(8) : size_t(corners[c]); };
  std::vector<int32_t> count(node_count, 0), place(node_count, -1);
  for (size_t c = 0; c < cells.size(); ++c)
    for (size_t a = 0; a < used(c); ++a) ++count[size_t(cells[c][a])];
  begin_.push_back(0);
  for (size_t n = 0; n < node_count; ++n) {
    if (!count[n]) continue;
    place[n] = int32_t(nodes_.size());
    nodes_.push_back(int32_t(n));
    begin_.push_back(begin_.back() + count[n]);
  }
  list_.resize(size_t(begin_.back()));
  std::vector<int32_t> fill(begin_.begin(), begin_.end() - 1);
  for (size_t c = 0; c < cells.size(); ++c)
    for (size_t a = 0; a < used(c); ++a) list_[size_t(fill[size_t(place[size_t(cells[c][a])])]++)] = int32_t(8 * c + a);
}

void CellScatter::add(const std::vector<CellForce>& force, NodeArray& g, bool measure, Workers& workers) const {
  const Node4* corner = reinterpret_cast<const Node4*>(force.data());  // a column of four numbers is a node
  workers.parallel_for(nodes_.size(), 1024, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      v4 sum = {};
      for (int32_t k = begin_[i]; k < begin_[i + 1]; ++k) sum += load(corner[list_[size_t(k)]]);
      if (!measure) sum[3] = 0;
      Node4& n = g[size_t(nodes_[i])];
      store(n, load(n) + sum);
    }
  });
}

}  // namespace limberg::fem
