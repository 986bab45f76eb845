#pragma once
// Whose tissue is at a point of the rest body, and which way leads out of it.
//
// A place lies in other tissue exactly when a cell copy that is not its own holds it and
// has material there. Where in the copy it lies follows from inverting the copy's
// trilinear map (moving_cells.h): a point Q of the rest body. At rest nothing overlaps and
// no surface is folded, so the shortest way from Q to the surface of the copy's tissue is
// the way out, at corners and in thin flaps too, whatever the place's own tissue looks
// like. (Distance in material space: Fisher and Lin 2001; for embedding lattices McAdams
// et al. 2011.) Rest never changes between cuts, so what may be nearest is noted once for
// each small part of a copy's space, when something first comes to lie there.
//
//   kept    copies that carry touchable surface, and those that share a node with one; what is deeper is not believed
//   own     a copy's own triangles: those of which it carries a part. Where several copies
//           share a cell, the nearest of them, as far as it lies in the cell, tells
//           whether Q is in the copy's material: the cell is convex, so nothing of the
//           copy lies between. Banks coincide at rest; only its own bank counts for a copy
//   around  triangles of copies that share a node with it: ways out for what is deep
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sim/base/workers.h"
#include "sim/contact/contact_surface.h"

namespace limberg {

class RestTissue {
 public:
  static constexpr double kBeyond = 0.15;  // edges of a cell: so far around it a copy's surface is known, too
  static constexpr double kOn_mm = 0.005;  // nearer to the surface than this a point lies on it: outside
  static constexpr double kDeep_mm = 3;    // ways out that are longer are not looked for
  static constexpr size_t kFeet = 8;

  struct Foot {  // the nearest point of a sheet
    int32_t triangle = -1, sheet = -1;
    std::array<double, 3> bary{};
    double distance_mm = 0, height_mm = 0;  // |Q - foot|; along the triangle's normal: negative behind it
  };
  struct Answer {
    bool inside = false;  // Q lies in the copy's material, by more than kOn_mm
    size_t count = 0;     // sheets within kDeep_mm
    std::array<Foot, kFeet> foot;
  };

  RestTissue(const ContactSurface& surface, const FemModel& model);

  // Copies kept, by their numbers here.
  size_t size() const { return copy_.size(); }
  int32_t copy(size_t c) const { return copy_[c]; }                         // ascending
  int32_t find(int32_t copy) const;                                         // -1: not kept
  const std::array<int32_t, 8>& slots(size_t c) const { return slot_[c]; }  // its nodes, as places in nodes()
  const std::vector<int32_t>& nodes() const { return node_; }               // of the model, ascending
  const Vec3& low_mm(size_t c) const { return low_[c]; }
  const Vec3& size_mm(size_t c) const { return size_[c]; }
  Vec3 rest_mm(size_t c, const Vec3& at) const { return low_[c] + at.cwiseProduct(size_[c]); }

  /// Do two kept copies hang together, be it over a node that hangs on the other's?
  bool adjacent(size_t a, size_t b) const { return std::ranges::binary_search(adjacent(a), int32_t(b)); }
  std::span<const int32_t> adjacent(size_t c) const {
    return {adjacent_.data() + adjacent_begin_[c], size_t(adjacent_begin_[c + 1] - adjacent_begin_[c])};
  }
  /// A copy without triangles in a parted cell: where its material lies is not known.
  bool is_empty(size_t c) const { return bare_[c] && !whole_[c]; }
  /// Does copy c carry a wall of another sheet than this (-1: any wall)? Kin that do not are the tissue around a place.
  bool has_other_wall(size_t c, int32_t sheet) const {
    return wall_least_[c] <= wall_most_[c] && (wall_least_[c] != sheet || wall_most_[c] != sheet);
  }

  /// The part of copy c's space around `at` (edges of the cell, from its low corner).
  int32_t part(size_t c, const Vec3& at) const;
  bool known(int32_t part) const { return of_part_[size_t(part)] >= 0; }
  /// Finds what may be nearest in these parts; each may be named more than once.
  void learn(std::span<const int32_t> parts, Workers& workers);
  /// `at` in copy c, in a part that is known. The nearest point of each sheet, own sheets first.
  void ask(size_t c, const Vec3& at, int32_t part, Answer& answer) const;

  /// Between corners it goes linearly (sheets.h).
  Vec3 smooth_normal(int32_t triangle, const std::array<double, 3>& bary) const;

 private:
  static constexpr int kParts = 5;  // along an edge, kBeyond on both sides included
  struct Ball {
    Vec3 middle;
    double radius;
  };
  struct Near {
    float d = 0;  // from the middle of the part, rounded down
    int32_t triangle = 0, sheet = 0;
  };
  struct List {
    int32_t begin = 0, own = 0, end = 0;  // in near_: own triangles up to `own`, others up to `end`, nearest first
  };
  void list_neighbours(const LatticeTopology& lattice, const std::vector<int32_t>& slot_of);
  Vec3 middle(int32_t part, size_t& c) const;  // in edges of the cell of copy c
  bool into_cell(size_t c, int32_t triangle, const Vec3& Q, Vec3& foot_mm) const;
  std::optional<bool> inside_by_way(size_t c, const Vec3& Q, int32_t t, const Vec3& foot) const;
  void gather(int32_t part, std::vector<Near>& own, std::vector<Near>& others) const;

  const ContactSurface* surface_ = nullptr;
  std::vector<int32_t> copy_, node_;
  std::vector<std::array<int32_t, 8>> slot_;
  std::vector<int32_t> adjacent_begin_, adjacent_;  // kept copies that hang together with it
  std::vector<Vec3> low_, size_;
  std::vector<uint8_t> bare_;                    // no triangles of its own
  std::vector<uint8_t> whole_;                   // full of material
  std::vector<int32_t> wall_least_, wall_most_;  // sheets of walls that it carries
  std::vector<int32_t> own_begin_, own_;         // triangles of each copy
  std::vector<int32_t> around_begin_, around_;   // kept copies that share a node with it and carry something
  std::vector<Ball> ball_;                       // around each triangle
  std::vector<std::array<Vec3, 3>> corner_;      // of each triangle
  std::vector<Vec3> normal_, fan_normal_;
  std::vector<int32_t> of_part_;  // per part: its list, or -1
  std::vector<List> list_;
  std::vector<Near> near_;
};

}  // namespace limberg
