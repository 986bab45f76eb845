#include "sim/skull/bone/join.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/skull/bone/surface.h"
#include "sim/skull/simplex/dual.h"
#include "sim/skull/simplex/operators.h"

namespace limberg::bone {
namespace {

using simplex::Edit;
using simplex::FaceKind;
using simplex::Mesh;

struct WallFace {
  int32_t face;
  Vec3 centre, normal;
};

std::vector<WallFace> walls_of(const Mesh& m, const std::vector<uint8_t>& in) {
  std::vector<WallFace> out;
  for (int32_t f = 0; f < m.face_slots(); ++f)
    if (m.alive_face(f) && m.kind(f) == FaceKind::wall && in[size_t(m.face_edge[size_t(f)] / 3)])
      out.push_back({f, simplex::face_centre(m, f), simplex::face_area(m, f).vector_mm2.normalized()});
  return out;
}

/// Those of a that face one of b, no further than `far` from it.
std::vector<int32_t> facing(const std::vector<WallFace>& a, const std::vector<WallFace>& b, double far) {
  std::vector<int32_t> out;
  for (const WallFace& f : a)
    if (std::any_of(b.begin(), b.end(), [&](const WallFace& g) {
          return (f.centre - g.centre).norm() <= far && f.normal.dot(g.normal) < -0.3;
        }))
      out.push_back(f.face);
  return out;
}

/// Takes the rungs out of a set of walls: what is left are mouths. Empty: it could not be done.
std::vector<int32_t> open(Mesh& m, const std::vector<int32_t>& walls, simplex::Delta& delta) {
  std::vector<uint8_t> in(m.face_edge.size(), 0);
  for (int32_t f : walls) in[size_t(f)] = 1;
  std::vector<int32_t> rim, behind;
  std::vector<std::pair<int32_t, int32_t>> rungs;
  for (int32_t f : walls)
    m.around(f, [&](int32_t h) {
      const int32_t u = m.from(h), v = m.to(h), g = m.face(m.twin(h));
      rim.push_back(u);
      if (!in[size_t(g)])
        behind.push_back(g);
      else if (u < v)
        rungs.emplace_back(u, v);
    });
  for (auto* list : {&rim, &behind})
    std::sort(list->begin(), list->end()), list->erase(std::unique(list->begin(), list->end()), list->end());
  std::sort(rungs.begin(), rungs.end());
  Edit e(m, delta);
  for (const auto& [p, q] : rungs) {
    if (!m.alive(p) || !m.alive(q) || m.slot(p, q) < 0) return {};
    for (const auto& [v, but] : {std::pair(p, q), std::pair(q, p)}) {
      const size_t k = size_t(m.slot(v, but));
      const int32_t x0 = m.nbr[size_t(v)][(k + 1) % 3], x1 = m.nbr[size_t(v)][(k + 2) % 3];
      if (x0 == x1 || m.slot(x0, x1) >= 0) return {};
      e.replace_neighbour(x0, v, x1), e.replace_neighbour(x1, v, x0);
    }
    e.free_vertex(std::max(p, q)), e.free_vertex(std::min(p, q));
  }
  for (size_t i = walls.size(); i-- > 0;) e.free_face(walls[i]);
  std::erase_if(rim, [&](int32_t v) { return !m.alive(v); });
  std::vector<int32_t> mouths;
  for (int32_t v : rim)
    for (int32_t k = 0; k < 3; ++k)
      if (const int32_t f = m.left[size_t(v)][size_t(k)]; f >= 0 && in[size_t(f)]) {
        int32_t size = 0, h = 3 * v + k;
        do {
          if (++size > 100000) return {};
          h = m.next(h);
        } while (h != 3 * v + k);
        if (size < 3) return {};
        // A mouth may take the slot of a wall, so it is numbered below, when no old mark is left.
        mouths.push_back(-1);
        for (h = 3 * v + k;;) {
          e.save_vertex(h / 3);
          m.left[size_t(h / 3)][size_t(h % 3)] = -1 - int32_t(mouths.size());
          h = m.next(h);
          if (h == 3 * v + k) break;
        }
      }
  for (size_t i = 0; i < mouths.size(); ++i) {
    const int32_t mark = -2 - int32_t(i);
    for (int32_t v : rim)
      for (int32_t k = 0; k < 3 && mouths[i] < 0; ++k)
        if (m.left[size_t(v)][size_t(k)] == mark)
          mouths[i] = e.add_face(FaceKind::cut), e.mark_face(mouths[i], 3 * v + k);
  }
  for (int32_t g : behind)
    for (int32_t v : rim) {
      bool done = false;
      for (int32_t k = 0; k < 3 && !done; ++k)
        if (m.left[size_t(v)][size_t(k)] == g) e.mark_face(g, 3 * v + k), done = true;
      if (done) break;
    }
  for (int32_t v : rim) e.reshape(v);
  return mouths;
}

/// Mean distance of the rings when they lie place upon place; infinite when they have different numbers.
double apart(const Mesh& m, int32_t x, int32_t y) {
  const std::vector<int32_t> a = m.ring(x), b = m.ring(y);
  if (a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double sum = 0;
  for (int32_t v : a) {
    double near = std::numeric_limits<double>::infinity();
    for (int32_t w : b) near = std::min(near, (m.x_mm[size_t(v)] - m.x_mm[size_t(w)]).norm());
    sum += near / double(a.size());
  }
  return sum;
}

std::string join_mouths(Mesh& m, int32_t x, int32_t y, simplex::Delta& d) {
  constexpr double kAsCut_mm = 0.1;
  if (apart(m, x, y) < kAsCut_mm && simplex::t3_spokes(m, x, y, d)) return "";
  if (simplex::t3(m, x, y, d)) return "";
  const simplex::OperatorResult o = simplex::t3_spokes(m, x, y, d);
  return o ? "" : std::string("the cut surfaces cannot be joined: ") + simplex::sentence(o.answer);
}

}  // namespace

std::string join_bones(Mesh& m, int32_t a, int32_t b, const Eigen::Isometry3d& b_in_a, simplex::Delta& delta,
                       std::vector<int32_t>& seam) {
  const std::vector<uint8_t> in_a = component_of(m, a), in_b = component_of(m, b);
  simplex::Delta d;
  Edit e(m, d);
  if (b_in_a.matrix() != Eigen::Isometry3d::Identity().matrix()) {
    for (int32_t v = 0; v < m.slots(); ++v)
      if (in_b[size_t(v)]) {
        e.save_vertex(v);
        m.x_mm[size_t(v)] = m.before_mm[size_t(v)] = b_in_a * m.x_mm[size_t(v)];
      }
  }
  const auto refuse = [&](std::string why) {
    simplex::undo(m, d);
    return why;
  };
  const std::vector<WallFace> wa = walls_of(m, in_a), wb = walls_of(m, in_b);
  double nearest = std::numeric_limits<double>::infinity();
  for (const WallFace& f : wa)
    for (const WallFace& g : wb)
      if (f.normal.dot(g.normal) < -0.3) nearest = std::min(nearest, (f.centre - g.centre).norm());
  if (!(nearest <= kReach_mm))
    return refuse("no cut surfaces of the two face each other within " + std::to_string(int(kReach_mm)) + " mm");
  // Walls are up to a face wide and may have slid along each other.
  const double far = 1.5 * nearest + 4;
  const std::vector<int32_t> x = open(m, facing(wa, wb, far), d), y = open(m, facing(wb, wa, far), d);
  if (x.empty() || y.empty())
    return refuse("the cut surfaces cannot be opened to be joined: a later cut runs through them");
  if (x.size() != y.size())
    return refuse("the cut surfaces that face each other have " + std::to_string(x.size()) + " and " +
                  std::to_string(y.size()) + " rings");
  std::vector<uint8_t> taken(y.size(), 0);
  for (int32_t f : x) {
    size_t best = y.size();
    double least = std::numeric_limits<double>::infinity();
    for (size_t j = 0; j < y.size(); ++j) {
      if (taken[j]) continue;
      // Rings of one table lie nearer to each other than those of different tables.
      double far_off = 0;
      const std::vector<int32_t> ring = m.ring(y[j]);
      m.around(f, [&](int32_t h) {
        double near = std::numeric_limits<double>::infinity();
        for (int32_t w : ring) near = std::min(near, (m.x_mm[size_t(h / 3)] - m.x_mm[size_t(w)]).squaredNorm());
        far_off += std::sqrt(near);
      });
      if (far_off < least) least = far_off, best = j;
    }
    taken[best] = 1;
    // Joined spoke to spoke the rings go, and their neighbours meet.
    for (const int32_t mouth : {f, y[best]})
      for (const int32_t v : m.ring(mouth)) {
        seam.push_back(v);
        for (const int32_t w : m.nbr[size_t(v)]) seam.push_back(w);
      }
    if (std::string bad = join_mouths(m, f, y[best], d); !bad.empty()) return refuse(bad);
  }
  std::sort(seam.begin(), seam.end());
  seam.erase(std::unique(seam.begin(), seam.end()), seam.end());
  std::erase_if(seam, [&](int32_t v) { return !m.alive(v); });
  delta.append(std::move(d));
  return "";
}

}  // namespace limberg::bone
