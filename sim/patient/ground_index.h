#pragma once
// Which triangles of a surface are a ground (skin, flesh, bone), and which of them lie around each vertex: what whoever
// searches or walks on the surface needs.
//
// A GroundIndex belongs to one topology and never changes. It is made when it is first asked for, by whichever thread
// asks first. A session asks on the solver's thread before it publishes a topology, so that the device thread makes
// none; with the topology it is freed.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/base/lazy.h"
#include "sim/base/shared_array.h"
#include "sim/geometry/vec.h"

namespace limberg {

/// What a tool acts on: skin, everything of the flesh (walls and bed too), bone.
enum class Ground : uint8_t { skin = 0, flesh = 1, bone = 2 };

struct GroundIndex {
  std::vector<int32_t> triangle;          // of the view, ascending
  std::vector<int32_t> vertex;            // their corners, each once, ascending
  std::vector<int32_t> star_start, star;  // of each vertex of the view; none where the ground has no triangle

  /// The triangles of the ground around a vertex of the view.
  std::span<const int32_t> around(int32_t v) const {
    if (star_start.empty()) return {};
    const int32_t from = star_start[size_t(v)], to = star_start[size_t(v) + 1];
    return {star.data() + from, size_t(to - from)};
  }
};

/// O(vertices + triangles). `is_ground(t)`: triangle t is of the ground.
template <class IsGround>
GroundIndex make_ground_index(size_t vertices, const SharedArray<Tri>& tri, IsGround&& is_ground) {
  GroundIndex g;
  std::vector<int32_t>& start = g.star_start;
  for (size_t t = 0; t < tri.size(); ++t) {
    if (!is_ground(t)) continue;
    if (start.empty()) start.assign(vertices + 1, 0);
    g.triangle.push_back(int32_t(t));
    for (const int32_t v : tri[t]) ++start[size_t(v) + 1];
  }
  if (g.triangle.empty()) return g;
  for (size_t v = 0; v < vertices; ++v) {
    if (start[v + 1] > 0) g.vertex.push_back(int32_t(v));
    start[v + 1] += start[v];
  }
  g.star.resize(3 * g.triangle.size());
  std::vector<int32_t> fill(start.begin(), start.end() - 1);
  for (const int32_t t : g.triangle)
    for (const int32_t v : tri[size_t(t)]) g.star[size_t(fill[size_t(v)]++)] = t;
  return g;
}

/// The indices of a topology, each made when it is first asked for. A copy begins without: what it is a part of may be
/// changed before somebody asks.
class GroundIndices {
 public:
  GroundIndices() = default;
  GroundIndices(const GroundIndices&) {}
  GroundIndices& operator=(const GroundIndices&) {
    index_ = {};
    return *this;
  }

  template <class Make>
  const GroundIndex& get(Ground ground, Make&& make) const {
    return index_[size_t(ground)].get(make);
  }

 private:
  std::array<Lazy<GroundIndex>, 3> index_;
};

}  // namespace limberg
