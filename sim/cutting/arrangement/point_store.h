#pragma once
// All points of an arrangement. An implicit point is found again by what it is made of, never by where it lies.
#include <vector>

#include "sim/cutting/arrangement/fault.h"
#include "sim/geometry/exact/predicates.h"

namespace limberg {

/// What a point is made of.
struct PointKey {
  enum Kind : int32_t { explicit_point, line_plane, three_planes };
  int32_t kind = explicit_point;
  std::array<int32_t, 3>
      id{};  // LPI: edge end points ascending, original triangle; TPI: three original triangles ascending
  bool operator==(const PointKey&) const = default;
};

/// Residues of a point's rational coordinates modulo kPrime: a fingerprint of its exact place, and what the volume
/// test computes with.
using Residues = std::array<uint64_t, 3>;
inline constexpr uint64_t kPrime = (uint64_t(1) << 61) - 1;
inline uint64_t mod_mul(uint64_t a, uint64_t b) {
  const uint128 t = uint128(a) * b;
  const uint64_t r = uint64_t(t & kPrime) + uint64_t(t >> 61);
  return r >= kPrime ? r - kPrime : r;
}
inline uint64_t mod_add(uint64_t a, uint64_t b) { return a + b >= kPrime ? a + b - kPrime : a + b; }
inline uint64_t mod_sub(uint64_t a, uint64_t b) { return a >= b ? a - b : a + kPrime - b; }

class PointStore {
 public:
  int32_t size() const { return int32_t(approx_.size()); }
  void reserve(size_t n) { approx_.reserve(n), implicit_of_.reserve(n); }

  int32_t add_explicit(const Int3& p);
  /// Where the edge a-b of an original triangle meets original triangle `tri`; the same id for the same two things.
  int32_t line_plane(int32_t a, int32_t b, int32_t tri, const Plane& plane);
  int32_t three_planes(std::array<int32_t, 3> tri, const Plane& p0, const Plane& p1, const Plane& p2);
  /// Forgets the points from n on.
  void truncate(int32_t n);

  bool is_explicit(int32_t i) const { return implicit_of_[i] < 0; }
  Int3 integer(int32_t i) const {
    const double* p = approx_[size_t(i)].data();
    return {int32_t(p[0]), int32_t(p[1]), int32_t(p[2])};
  }
  /// Soon to be asked for.
  void prefetch(int32_t i) const { __builtin_prefetch(&approx_[size_t(i)]); }
  const Vec3& approx(int32_t i) const { return approx_[i]; }
  PointRef ref(int32_t i) const {
    const Vec3* approx = &approx_[size_t(i)];
    if (implicit_of_[size_t(i)] < 0) return {approx};
    const Implicit& p = implicit_[size_t(implicit_of_[size_t(i)])];
    return p.is_line_plane() ? PointRef{approx, &line_plane_[size_t(p.form)]}
                             : PointRef{approx, nullptr, &three_planes_[size_t(p.form)]};
  }
  PointKey key(int32_t i) const { return implicit_of_[i] < 0 ? PointKey{} : implicit_[implicit_of_[i]].key; }
  /// For an intersection of an edge: the ends of that edge, ascending; else null.
  const std::array<int32_t, 3>* edge_of(int32_t i) const {
    if (implicit_of_[size_t(i)] < 0) return nullptr;
    const PointKey& k = implicit_[size_t(implicit_of_[size_t(i)])].key;
    return k.kind == PointKey::line_plane ? &k.id : nullptr;
  }
  Homogeneous exact(int32_t i) const { return ref(i).exact(); }
  /// Residues of all points so far, in one go: needs one division for all. residues() asks for it.
  void settle();
  Residues residues(int32_t i) const {
    if (const int32_t k = implicit_of_[size_t(i)]; k >= 0) return residue_[size_t(k)];
    const double* p = approx_[size_t(i)].data();
    Residues r;
    for (size_t k = 0; k < 3; ++k) {
      const int64_t v = int64_t(p[k]);
      r[k] = uint64_t(v + (v >> 63 & int64_t(kPrime)));
    }
    return r;
  }

  // The signs of predicates.h by point ids: every decision among implicit points is made here.
  int side(const Plane& plane, int32_t p) const {
    int s = filtered_side(plane, approx_[size_t(p)]);
    if (s == 0) s = side_of_plane(plane, ref(p));
    if (!fault) return s;
    if (fault->watch) fault->watch->side(plane, ref(p), s);
    return fault->strikes() ? 0 : s;
  }
  int turn(const Plane& plane, int32_t a, int32_t b, int32_t c) const {
    return turn(plane, Projection(plane), a, b, c);
  }
  /// For those who ask often about one plane: `view` is its projection.
  int turn(const Plane& plane, const Projection& view, int32_t a, int32_t b, int32_t c) const {
    int s = filtered_orient2d(view, approx_[size_t(a)], approx_[size_t(b)], approx_[size_t(c)]);
    if (s == 0) s = orient2d(view, ref(a), ref(b), ref(c));
    if (!fault) return s;
    if (fault->watch) fault->watch->turn(plane, ref(a), ref(b), ref(c), s);
    return fault->strikes() ? 0 : s;
  }
  int order(int axis, int32_t a, int32_t b) const {
    int s = filtered_order(axis, approx_[size_t(a)], approx_[size_t(b)]);
    if (s == 0) s = compare_coordinate(axis, ref(a), ref(b));
    if (!fault) return s;
    if (fault->watch) fault->watch->order(axis, ref(a), ref(b), s);
    return fault->strikes() ? 0 : s;
  }
  /// The axis along which two points lie farthest apart.
  int longest_axis(int32_t a, int32_t b) const {
    const double *p = approx_[size_t(a)].data(), *q = approx_[size_t(b)].data();
    const double x = std::abs(q[0] - p[0]), y = std::abs(q[1] - p[1]), z = std::abs(q[2] - p[2]);
    return x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2);
  }
  /// A step that a test may make fail.
  bool fails() const { return fault && fault->strikes(); }
  FaultPlan* fault = nullptr;  // tests only

 private:
  struct Implicit {
    PointKey key;
    int32_t point = 0;
    int32_t form = 0;  // of line_plane_ or three_planes_
    bool is_line_plane() const { return key.kind == PointKey::line_plane; }
  };
  void make_room();  // for one more point: adding it cannot fail half-way
  static uint64_t hash(const PointKey& k) {
    uint64_t h = uint64_t(k.kind);
    for (int32_t i : k.id) h = (h ^ uint32_t(i)) * 0x9e3779b97f4a7c15ull, h ^= h >> 29;
    return h * 0xff51afd7ed558ccdull ^ h >> 32;
  }
  /// Where the key is, or the empty place at which the search ends. Other points are told apart by their tags, without
  /// being looked at.
  size_t place(const PointKey& key, uint64_t h) const {
    const size_t mask = table_.size() - 1;
    const uint32_t tag = uint32_t(h >> 32);
    size_t at = size_t(h) & mask;
    while (table_[at].index >= 0 && !(table_[at].tag == tag && implicit_[size_t(table_[at].index)].key == key))
      at = (at + 1) & mask;
    return at;
  }
  /// Room for one more, then place().
  size_t place_for(const PointKey& key);
  int32_t add_implicit(size_t place, const PointKey& key, const Vec3& approx, int32_t form);

  std::vector<Vec3> approx_;          // explicit points: exact
  std::vector<int32_t> implicit_of_;  // -1: explicit
  std::vector<Implicit> implicit_;
  std::vector<NarrowHomogeneous> line_plane_;
  std::vector<Homogeneous> three_planes_;
  std::vector<Residues> residue_;  // of the implicit points that settle() has seen
  struct Entry {
    uint32_t tag = 0;
    int32_t index = -1;  // of implicit_; -1: empty
  };
  std::vector<Entry>
      table_;  // open addressing by key. Points leave in reverse order of coming, so a place that is emptied
               // never lies inside another's search
};

}  // namespace limberg
