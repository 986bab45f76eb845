#include "sim/imaging/fit/graded_grid.h"

#include <cmath>
#include <unordered_set>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/imaging/fit/march_tet.h"

namespace limberg {
namespace {

constexpr double kCube_mm = 16;
constexpr int kHalvings = 6;
constexpr int64_t kUnits = int64_t(1) << kHalvings;  // of a cube's side
constexpr int kBits = 21;                            // of a coordinate in a node's name

/// Nodes by name: three whole coordinates, in units of the smallest cube.
using Node = int64_t;
Node node_of(int64_t x, int64_t y, int64_t z) { return x | y << kBits | z << (2 * kBits); }
std::array<int64_t, 3> units_of(Node n) {
  constexpr int64_t mask = (int64_t(1) << kBits) - 1;
  return {n & mask, n >> kBits & mask, n >> (2 * kBits)};
}
Node middle_of(Node a, Node b) { return (a + b) / 2; }  // coordinates are even wherever an edge is halved

struct Tet {
  std::array<Node, 4> v;
  int8_t tag = 3;         // the edge that is halved goes from v[0] to v[tag]
  int8_t generation = 0;  // three of them halve a cube
};

using Edges = std::unordered_set<std::array<int64_t, 2>, EdgeHash>;
std::array<int64_t, 2> edge_of(Node a, Node b) { return {std::min(a, b), std::max(a, b)}; }

std::array<Tet, 2> halves(const Tet& t) {
  const auto k = size_t(t.tag);
  const Node z = middle_of(t.v[0], t.v[k]);
  std::array<Tet, 2> out{t, t};
  for (Tet& h : out) h.tag = int8_t(t.tag > 1 ? t.tag - 1 : 3), h.generation = int8_t(t.generation + 1);
  out[0].v[k] = z;
  for (size_t i = 0; i < k; ++i) out[1].v[i] = t.v[i + 1];
  out[1].v[k] = z;
  return out;
}

}  // namespace

void march_graded(const LevelSet& s, const std::function<double(const Vec3&)>& cell_mm, Workers& workers,
                  std::vector<Vec3>& X, std::vector<Tri>& tri, int64_t* evaluations) {
  const Vec3 size = s.high_mm - s.low_mm;
  if (!size.allFinite() || !(size.minCoeff() > 0)) throw InputError("", 0, "a box with extent was expected");
  if (size.maxCoeff() > 4000) throw InputError("", 0, "a box of at most 4 m was expected");
  // Cubes fill the box to a part of one, which scales them a little: the surface ends at the box.
  std::array<int64_t, 3> cubes{};
  Vec3 unit;
  for (size_t a = 0; a < 3; ++a) {
    cubes[a] = std::max<int64_t>(1, int64_t(std::ceil(size[Eigen::Index(a)] / kCube_mm - 1e-9)));
    unit[Eigen::Index(a)] = size[Eigen::Index(a)] / double(cubes[a] * kUnits);
  }
  const auto place = [&](Node n) {
    const auto u = units_of(n);
    return Vec3(s.low_mm + unit.cwiseProduct(Vec3(double(u[0]), double(u[1]), double(u[2]))));
  };
  std::vector<Tet> open;
  constexpr int kPath[6][2] = {{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}};
  for (int64_t k = 0; k < cubes[2]; ++k)
    for (int64_t j = 0; j < cubes[1]; ++j)
      for (int64_t i = 0; i < cubes[0]; ++i)
        for (const auto& path : kPath) {
          std::array<int64_t, 3> at{i * kUnits, j * kUnits, k * kUnits};
          Tet t;
          t.v[0] = node_of(at[0], at[1], at[2]);
          at[size_t(path[0])] += kUnits, t.v[1] = node_of(at[0], at[1], at[2]);
          at[size_t(path[1])] += kUnits, t.v[2] = node_of(at[0], at[1], at[2]);
          t.v[3] = node_of((i + 1) * kUnits, (j + 1) * kUnits, (k + 1) * kUnits);
          open.push_back(t);
        }
  int64_t asked = 0;
  Edges halved;
  std::vector<Tet> leaf;
  std::vector<uint8_t> wanted;
  while (!open.empty()) {
    wanted.assign(open.size(), 0);
    workers.parallel_for(open.size(), 512, [&](size_t b, size_t e) {
      for (size_t i = b; i < e; ++i) {
        const Tet& t = open[i];
        if (t.generation >= 3 * kHalvings) continue;
        Vec3 x[4], c = Vec3::Zero();
        for (size_t k = 0; k < 4; ++k) x[k] = place(t.v[k]), c += 0.25 * x[k];
        const double side = kCube_mm * elementary::pow(0.5, t.generation / 3.);
        if (side <= 1.1 * cell_mm(c) && side <= 1.1 * cell_mm(x[0]) && side <= 1.1 * cell_mm(x[3])) continue;
        double r = 0;
        for (const Vec3& p : x) r = std::max(r, (p - c).norm());
        wanted[i] = std::abs(s.distance_mm(c)) <= s.lipschitz * r;
      }
    });
    asked += int64_t(open.size());
    std::vector<Tet> next;
    for (size_t i = 0; i < open.size(); ++i) {
      if (!wanted[i]) {
        leaf.push_back(open[i]);
        continue;
      }
      halved.insert(edge_of(open[i].v[0], open[i].v[size_t(open[i].tag)]));
      for (const Tet& h : halves(open[i])) next.push_back(h);
    }
    open = std::move(next);
  }
  // Until no leaf has a halved edge.
  for (bool again = true; again;) {
    again = false;
    std::vector<Tet> kept, check = std::move(leaf);
    while (!check.empty()) {
      const Tet t = check.back();
      check.pop_back();
      bool cut = false;
      for (size_t a = 0; a < 4 && !cut; ++a)
        for (size_t b = a + 1; b < 4 && !cut; ++b) cut = halved.count(edge_of(t.v[a], t.v[b])) > 0;
      if (!cut) {
        kept.push_back(t);
        continue;
      }
      again |= halved.insert(edge_of(t.v[0], t.v[size_t(t.tag)])).second;
      for (const Tet& h : halves(t)) check.push_back(h);
    }
    leaf = std::move(kept);
  }
  std::vector<Node> nodes;
  for (const Tet& t : leaf) nodes.insert(nodes.end(), t.v.begin(), t.v.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  std::vector<double> value(nodes.size());
  workers.parallel_for(nodes.size(), 512, [&](size_t b, size_t e) {
    for (size_t i = b; i < e; ++i) value[i] = s.distance_mm(place(nodes[i]));
  });
  asked += int64_t(nodes.size());
  const auto value_of = [&](Node n) {
    return value[size_t(std::lower_bound(nodes.begin(), nodes.end(), n) - nodes.begin())];
  };
  std::vector<Patch> patch(1);
  for (Tet& t : leaf) {
    const Vec3 a = place(t.v[0]);
    if ((place(t.v[1]) - a).cross(place(t.v[2]) - a).dot(place(t.v[3]) - a) < 0) std::swap(t.v[0], t.v[1]);
    march_tet(t.v, {value_of(t.v[0]), value_of(t.v[1]), value_of(t.v[2]), value_of(t.v[3])}, patch[0]);
  }
  number_vertices(
      patch, place, [&](Node n, const Vec3&) { return value_of(n); }, X, tri);
  if (evaluations) *evaluations = asked;
}

}  // namespace limberg
