#include "sim/imaging/solid/least_cut.h"

#include <algorithm>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>

namespace limberg::imaging {

namespace {

using Graph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                                 boost::no_property, int32_t, int32_t>;
constexpr float kFirm = 1e6f;  // ties of a set to its end of the network

}  // namespace

LeastCut least_cut(const GridSize& n, const std::vector<uint8_t>& within, const std::vector<uint8_t>& a,
                   const std::vector<uint8_t>& b, const std::function<double(size_t, size_t)>& tie) {
  LeastCut out;
  out.first.assign(within.size(), 0);
  // All nodes of a set are one end of the network: ties within a set do not matter.
  std::vector<int32_t> vertex(within.size(), -1);
  std::vector<size_t> node;
  constexpr int32_t kA = 0, kB = 1;
  int32_t count = 2;
  for (size_t i = 0; i < within.size(); ++i)
    if (within[i]) {
      vertex[i] = a[i] ? kA : b[i] ? kB : count++;
      if (vertex[i] > kB) node.push_back(i);
    }
  // Edges by their source, each beside its way back.
  struct Edge {
    int32_t from, to;
    float tie;
  };
  std::vector<Edge> edges;
  edges.reserve(6 * node.size());
  const auto add = [&](size_t i) {
    neighbours(n, i, [&](size_t j) {
      if (j < i || vertex[j] < 0 || vertex[i] == vertex[j]) return;
      const float t = float(tie(i, j));
      edges.push_back({vertex[i], vertex[j], t}), edges.push_back({vertex[j], vertex[i], t});
    });
  };
  for (size_t i = 0; i < within.size(); ++i)
    if (within[i]) add(i);
  std::vector<int32_t> order(edges.size()), place(edges.size());
  for (size_t e = 0; e < order.size(); ++e) order[e] = int32_t(e);
  std::stable_sort(order.begin(), order.end(),
                   [&](int32_t x, int32_t y) { return edges[size_t(x)].from < edges[size_t(y)].from; });
  for (size_t k = 0; k < order.size(); ++k) place[size_t(order[k])] = int32_t(k);
  std::vector<std::pair<int32_t, int32_t>> pairs(edges.size());
  std::vector<float> capacity(edges.size()), residual(edges.size());
  std::vector<Graph::edge_descriptor> back(edges.size());
  for (size_t k = 0; k < order.size(); ++k) {
    const Edge& e = edges[size_t(order[k])];
    pairs[k] = {e.from, e.to}, capacity[k] = std::min(e.tie, kFirm);
  }
  const Graph g(boost::edges_are_sorted, pairs.begin(), pairs.end(), count);
  for (size_t k = 0; k < order.size(); ++k) {
    const size_t twin = size_t(place[size_t(order[k] ^ 1)]);
    back[k] = Graph::edge_descriptor(pairs[twin].first, int32_t(twin));
  }
  const auto edge_number = get(boost::edge_index, g);
  const auto vertex_number = get(boost::vertex_index, g);
  std::vector<Graph::edge_descriptor> before(static_cast<size_t>(count));
  std::vector<boost::default_color_type> colour(static_cast<size_t>(count));
  std::vector<long> distance(static_cast<size_t>(count));
  boost::boykov_kolmogorov_max_flow(g, boost::make_iterator_property_map(capacity.begin(), edge_number),
                                    boost::make_iterator_property_map(residual.begin(), edge_number),
                                    boost::make_iterator_property_map(back.begin(), edge_number),
                                    boost::make_iterator_property_map(before.begin(), vertex_number),
                                    boost::make_iterator_property_map(colour.begin(), vertex_number),
                                    boost::make_iterator_property_map(distance.begin(), vertex_number), vertex_number,
                                    kA, kB);
  for (size_t i = 0; i < within.size(); ++i)
    if (vertex[i] == kA || (vertex[i] > kB && colour[size_t(vertex[i])] == boost::black_color)) out.first[i] = 1;
  for (size_t i = 0; i < within.size(); ++i)
    if (out.first[i])
      neighbours(n, i, [&](size_t j) {
        if (within[j] && !out.first[j]) out.through.push_back({i, j});
      });
  return out;
}

}  // namespace limberg::imaging
