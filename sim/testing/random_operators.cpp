#include "sim/testing/random_operators.h"

#include <algorithm>

#include "sim/skull/simplex/contour.h"
#include "sim/skull/simplex/operators.h"

namespace limberg::simplex {
namespace {

class Dice {  // splitmix64
 public:
  explicit Dice(uint64_t seed) : s_(seed) {}
  uint64_t next() {
    uint64_t z = (s_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  int32_t below(int32_t n) { return int32_t(next() % uint64_t(n)); }
  double uniform() { return double(next() >> 11) * 0x1p-53; }

 private:
  uint64_t s_;
};

int32_t any_vertex(const Mesh& m, Dice& d) {
  for (;;)
    if (const int32_t v = d.below(m.slots()); m.alive(v)) return v;
}
int32_t any_face(const Mesh& m, Dice& d) {
  for (;;)
    if (const int32_t f = d.below(m.face_slots()); m.alive_face(f)) return f;
}

/// A disc of faces about a random one: its border is often a contour.
std::vector<int32_t> any_region(const Mesh& m, Dice& d) {
  std::vector<int32_t> region{any_face(m, d)};
  const int32_t layers = 1 + d.below(3);
  size_t first = 0;
  for (int32_t l = 0; l < layers; ++l) {
    const size_t last = region.size();
    for (; first < last; ++first)
      m.around(region[first], [&](int32_t h) {
        const int32_t g = m.face(m.twin(h));
        if (std::find(region.begin(), region.end(), g) == region.end()) region.push_back(g);
      });
  }
  return region;
}

Vec3 middle(const Mesh& m) {
  Vec3 c = Vec3::Zero();
  for (int32_t v = 0; v < m.slots(); ++v)
    if (m.alive(v)) c += m.x_mm[size_t(v)] / m.vertices();
  return c;
}

}  // namespace

RandomOperators random_operators(const Mesh& start, int64_t operations, uint64_t seed, int64_t length) {
  RandomOperators out;
  Mesh m = start;
  Dice d(seed);
  Delta delta;
  const int32_t size = m.vertices();
  uint64_t stretch = hash(m), now = stretch;
  int64_t since = 0;
  Census before = census(m);
  const auto broke = [&](const std::string& what) {
    out.fault = "operation " + std::to_string(out.operations) + ": " + what;
    return out;
  };
  for (; out.operations < operations; ++out.operations) {
    if (out.operations % std::max<int64_t>(1, length) == 0) {
      m = start, delta = Delta();
      stretch = now = hash(m), since = 0, before = census(m);
      ++out.sequences;
    }
    // Mostly local operators; t1 and t2 so that the size stays.
    const int32_t roll = d.below(100);
    const int kind = roll < 50 ? (m.vertices() > size ? 0 : 1) : roll < 70 ? 2 : 3 + roll % 4;
    OperatorResult o;
    int64_t V = 0, E = 0, F = 0, chi = 0;
    const int32_t p = any_vertex(m, d), q = d.below(20) == 0 ? any_vertex(m, d) : m.nbr[size_t(p)][size_t(d.below(3))];
    if (kind == 0) {
      o = t1(m, p, q, delta), V = -2, E = -3, F = -1;
    } else if (kind == 1) {
      const int32_t f = any_face(m, d);
      const std::vector<int32_t> ring = m.ring(f);
      o = d.below(2) ? t2_across(m, f, delta)
                     : t2(m, f, ring[size_t(d.below(int32_t(ring.size())))],
                          ring[size_t(d.below(int32_t(ring.size())))], delta);
      V = 2, E = 3, F = 1;
    } else if (kind == 2) {
      o = exchange(m, p, q, d.below(2) ? Turn::clockwise : Turn::counter_clockwise, delta);
    } else if (kind == 3) {
      o = t3(m, any_face(m, d), any_face(m, d), delta), F = -2, chi = -2;
    } else if (kind == 4) {
      ContourResult c = contour_of_faces(m, any_region(m, d));
      if (d.below(2)) std::reverse(c.contour.begin(), c.contour.end());
      if (d.below(10) == 0) c = contour_through(m, std::vector<int32_t>{p, any_vertex(m, d), any_vertex(m, d)});
      o = t4(m, c.contour, CutPolicy(d.below(6) == 0 ? 1 + d.below(2) : 0), delta), F = 2, chi = 2;
      for (int i = 0; i < 4 && !o; ++i) o = t4(m, contour_of_faces(m, any_region(m, d)).contour, CutPolicy::any, delta);
    } else if (kind == 5) {
      // Most often mouths of the same size: else the answer is nearly always no.
      const int32_t x = any_face(m, d);
      int32_t y = any_face(m, d);
      for (int i = 0; i < 20 && m.face_size[size_t(y)] != m.face_size[size_t(x)]; ++i) y = any_face(m, d);
      const int64_t k = m.face_size[size_t(x)];
      o = t3_spokes(m, x, y, delta), V = -2 * k, E = -3 * k, F = -(k + 2), chi = -2;
    } else {
      const Vec3 normal = Vec3(d.uniform() - 0.5, d.uniform() - 0.5, d.uniform() - 0.49);
      const PlaneCurves c = curves_of_plane(m, 0.5 * (middle(m) + m.x_mm[size_t(p)]), normal);
      if (!c.curve.empty()) {
        const auto& curve = c.curve[size_t(d.below(int32_t(c.curve.size())))];
        const int64_t k = int64_t(curve.size());
        o = t4_edges(m, curve, CutPolicy::any, delta), V = 2 * k, E = 3 * k, F = k + 2, chi = 2;
      } else {
        o.answer = Answer::too_short;
      }
    }
    ++(o ? out.done : out.refused)[size_t(kind)];
    if (const auto bad = find_fault(m)) return broke(std::string(RandomOperators::name[kind]) + ": " + *bad);
    if (!o) {
      if (hash(m) != now) return broke(std::string(RandomOperators::name[kind]) + " was refused and changed the mesh");
      continue;
    }
    const Census after = census(m);
    if (after.vertices != before.vertices + V || after.edges != before.edges + E || after.faces != before.faces + F ||
        after.chi != before.chi + chi)
      return broke(std::string(RandomOperators::name[kind]) + ": the bookkeeping does not add up");
    if ((kind == 4 || kind == 6) && after.components != before.components + o.divided)
      return broke("a cut said wrongly whether it divides");
    if (after.genus < 0) return broke("the genus is negative");
    before = after, now = hash(m), ++since;
    // A stretch ends: half of them are taken back.
    if (since >= 20) {
      if (d.below(2)) {
        undo(m, delta);
        if (const auto bad = find_fault(m)) return broke("undone: " + *bad);
        if (hash(m) != stretch) return broke("undoing did not give the mesh back");
        before = census(m), now = stretch, ++out.undone;
      }
      delta = Delta();
      stretch = now, since = 0;
    }
  }
  out.hash = hash(m);
  return out;
}

}  // namespace limberg::simplex
