#pragma once
// The work room of cells.h: computes the components of one cell after another, reusing its memory.
//
//   gather()       which faces meet the cell, exactly                           cell_gather.cpp
//   join_faces()   sided faces along glued edges                                cell_gather.cpp
//   join_lattice_edges()  what the 12 lattice edges run through                 cell_builder.cpp
//   join_walks()   closed curves on the squares, closed shells inside            cell_walks.cpp
//   classify()     classes, corners, old classes                                 cell_builder.cpp
//   measure()      volumes                                                       cell_volume.cpp
#include <memory>
#include <span>
#include <vector>

#include "sim/base/union_find.h"
#include "sim/cutting/arrangement/point_store.h"
#include "sim/lattice/cells.h"
#include "sim/lattice/lattice_signs.h"

namespace limberg {

/// How a face lies in a cell, as bits. A face never moves, so what was found once holds in every later version.
struct FaceInCell {
  uint64_t bits = 0;
  static constexpr uint64_t kWhole = 15;               // all edges meet the cell, all corners lie in it
  bool edge(size_t e) const { return bits >> e & 1; }  // edge e meets the cell
  void set_edge(size_t e) { bits |= uint64_t(1) << e; }
  bool inside() const { return bits >> 3 & 1; }                // all corners lie in it
  uint8_t squares() const { return uint8_t(bits >> 4 & 63); }  // bit 2 axis + high: it reaches through that plane
  void set_squares(uint8_t s) { bits |= uint64_t(s) << 4; }
  static uint64_t hit(int lattice_edge) {
    return uint64_t(1) << (10 + lattice_edge);
  }  // 4 axis + corner: that edge pierces it
  static uint64_t crossing(size_t square, size_t e) {
    return uint64_t(1) << (22 + 3 * square + e);
  }  // its edge e pierces the square
  uint64_t hits() const { return bits >> 10 & 0xfff; }
  uint64_t crossings() const { return bits >> 22; }
};

/// What a cell was before, for CellClass::old_class.
struct CellHistory {
  bool known = false;                      // false: first build, no parents
  const CellComponents* before = nullptr;  // null: no face met the cell (one class if it was material)
  int32_t last_op = 0;                     // walls of later operations are new
  bool only_cuts = true;                   // false: material was taken away, so old classes may have vanished
  const CellComponents* whole =
      nullptr;                  // what the cell is a part of was this: old_class is its class; nothing else counts
  bool whole_is_named = false;  // ... or what that class was before
};

class CellBuilder {
 public:
  CellBuilder(const LatticeGrid& grid, const MaterialSurface& surface);
  CellBuilder(const LatticeGrid& grid, MaterialSurface&& surface) = delete;  // it is not kept

  /// Components of the cell at `at` of the grid, from candidate faces (ascending, may hold dead ones and faces that
  /// miss the cell). `corners_in`: bit per corner that lies in the material. Null when no live face meets the cell.
  std::shared_ptr<const CellComponents> build(Int3 at, std::span<const int32_t> candidates, uint8_t corners_in,
                                              const CellHistory& history);

  /// Whether a live face meets the cell.
  bool meets(Int3 at, int32_t face);
  /// Whether one of the faces has a crack front in the cell: an edge where its two sides are glued to each other.
  bool holds_front(Int3 at, std::span<const int32_t> faces);
  /// How far from its front, square to it and along the crack, the
  /// cell reaches at most: in edges of the cell (up to 6 % more
  /// where the crack runs askew), 0 without a front. This is what
  /// stays closed of the crack in a cell that is not divided.
  double front_reach(Int3 at, std::span<const int32_t> faces);

  /// Layers of the corners of a face: [corner][axis].
  using Layers = std::array<std::array<int32_t, 3>, 3>;
  Layers layers(int32_t face) const;
  /// Those of faces first, first + 1, ... when they have been found already. Must outlive what is built then.
  void know_layers(int32_t first, std::span<const Layers> of_face) {
    first_layered_ = first, of_face_ = of_face;
    fresh_place_.assign(of_face.size(), {0, -1});
  }
  /// Whether the lattice line along `axis` through `corner` pierces the face's projection (any position along it).
  static bool pierced(const std::array<PointRef, 3>& p, int axis, const SubPoint& corner);

 private:
  struct LocalFace {
    LocalFace(int32_t its_id, const Plane* its_plane, uint8_t material, FaceInCell how, double its_flux, bool was_there)
        : id(its_id), plane(its_plane), in(how), flux(its_flux), mat(material), known(was_there) {}
    int32_t id;
    int32_t shape = -1;  // into shape_, once its corners have been asked for
    const Plane* plane;
    FaceInCell in;
    double flux;  // NaN: not known
    std::array<int32_t, 6>
        mate;  // [3 * side + edge], where the edge meets the cell: the glued member; set by join_faces()
    uint8_t mat;
    bool known;  // it was in the cell before
  };
  /// Where the corners of a face lie. Most faces are known from the version before and never need it.
  struct Shape {
    std::array<PointRef, 3> p;
    Layers layer;                             // when layered
    std::array<int32_t, 3> edge{-1, -1, -1};  // into edge_, once gather() has asked for them
    std::array<bool, 3> turned{};             // the face has the edge from its higher point to its lower one
    bool layered = false;
  };
  /// An edge of faces that are new in the cell, from its lower point to its higher one. Two faces meet there, or more:
  /// what is found for one of them holds for all.
  struct EdgeInCell {
    EdgeSigns about;  // when known
    bool known = false;
    int8_t meets = -1;    // the cell; -1: not asked yet
    int8_t crosses = -1;  // bit 2 axis + high: it pierces that square of the cell; -1: not asked yet
  };
  Shape& shape(LocalFace& f);
  Shape& layered_shape(LocalFace& f);
  int32_t edge_between(int32_t a, int32_t b);
  Layers grid_layers(int32_t face) const {
    const size_t k = size_t(face - first_layered_);
    return face >= first_layered_ && k < of_face_.size() ? of_face_[k] : layers(face);
  }
  // Sided face as a member of the partition; corner as a member.
  static int32_t member(size_t local, int side) { return int32_t(2 * local) + side; }
  int32_t corner_member(int corner) const { return int32_t(2 * face_.size()) + corner; }

  // Along +axis: the side of face f that lies before the hit, and after it.
  static int side_before(const Plane& plane, int axis) { return plane.n[size_t(axis)] > 0 ? 1 : 0; }
  static bool has(uint8_t mat, int side) { return mat >> side & 1; }

  bool is_front(int32_t face, size_t edge) const;
  double reach_from(int32_t face, size_t edge) const;
  void enter(Int3 at);
  /// `before`: what the cell held in the last version; what is known of its faces is taken over.
  void gather(std::span<const int32_t> candidates, const CellComponents* before = nullptr);
  void take_known(FaceInCell in, int32_t local);
  bool edge_meets(const LocalFace& f, const Shape& s, size_t edge);
  bool finds_meeting(const LocalFace& f, const Shape& s, size_t edge);
  const EdgeSigns& about(const LocalFace& f, const Shape& s, size_t edge) {
    EdgeInCell& e = edge_[size_t(s.edge[edge])];
    if (!e.known) find_about(f, s, edge, e);
    return e.about;
  }
  void find_about(const LocalFace& f, const Shape& s, size_t edge, EdgeInCell& out) const;
  int parallel_axis(int32_t p, int32_t q) const;
  int8_t crossed_squares(const LocalFace& f, const Shape& s, size_t edge);
  void note_crossings(LocalFace& f, const Shape& s, int32_t local);
  bool pierced_by_edge(const LocalFace& f, const Shape& s, int axis,
                       int corner);  // by the cell's lattice edge, within its length
  int32_t local_of(int32_t face) const;
  void join_faces();
  void join_lattice_edges();
  void join_walks();
  bool has_loop(int normal, bool high);
  void walk_square(int normal, bool high);
  bool walk_from_loop(int normal, bool high, int run, int32_t root);
  bool walk_from_speck(int normal, bool high, int32_t root);
  bool walk_from_shell(int axis, int32_t root);
  void walk_shells();
  template <class Left>
  bool walk_left(int axis, const SubPoint& line, UnionFind& own, int32_t root, Left&& left);
  int32_t region_on_lattice_edge(int axis, int corner, const SubPoint& below);
  void hits_between(int axis, const SubPoint& line, const SubPoint* upper, std::vector<int32_t>& out);
  void classify(const CellHistory& history, CellComponents& out);
  void name_classes_of_whole(const CellHistory& history, CellComponents& out) const;
  void name_old_classes(const CellHistory& history, CellComponents& out);
  double flux_of(LocalFace& f);
  void measure(CellComponents& out);
  void name_by_volume(const CellHistory& history, CellComponents& out);
  [[noreturn]] void contradiction(const char* what) const;

  LatticeGrid grid_;
  const MaterialSurface& surface_;
  std::array<int32_t, 3> index_{};
  std::array<std::array<int64_t, 2>, 3> bound_{};  // sub-units, [axis][high]
  CellBounds bounds_;
  std::array<bool, 8> corner_in_{};

  const SubPoint& edge_corner(int axis, int corner) const { return bounds_.edge_corner[size_t(axis)][size_t(corner)]; }
  static int corner_of_edge(int axis, int corner, bool high);

  std::vector<LocalFace> face_;  // ascending by id
  int32_t first_layered_ = 0;
  std::span<const Layers> of_face_;
  std::vector<Shape> shape_;  // the first shapes_ of them
  int32_t shapes_ = 0;
  std::vector<EdgeInCell> edge_;
  /// Open addressing by end points; valid in the gathering that entered it.
  struct EdgePlace {
    uint64_t ends = 0, round = 0;
    int32_t edge = -1;
  };
  std::vector<EdgePlace> edge_place_;
  uint64_t round_ = 0;
  bool no_walks_before_ = false;  // of the cell: no closed curve on its squares, no closed shell in it
  bool as_before_ = false;        // the same faces with the same material as in the last version
  std::vector<std::pair<int32_t, int32_t>> place_;  // open addressing: id of a face, its place in face_
  // The same for the faces of know_layers(), of which most are
  // met again and again: by id, valid in the cell entered last.
  std::vector<std::pair<uint64_t, int32_t>> fresh_place_;
  uint64_t entered_ = 0;
  /// Layers of points: a point is met by several faces and cells. One place per few points, taken by the last.
  struct KnownLayers {
    int32_t point = -1;
    std::array<int32_t, 3> layer{};
  };
  mutable std::vector<KnownLayers> known_layers_;
  std::array<std::vector<int32_t>, 12> hit_;  // local faces along each lattice edge, ascending
  struct Crossing {
    int32_t local, edge;
  };
  std::array<std::vector<Crossing>, 6>
      crossing_;  // edges that pierce each square of the cell (2 axis + high), ascending
  std::array<uint8_t, 12> edge_state_{};
  UnionFind join_, square_, old_;
  UnionFind glued_;  // sided faces joined along glued edges only
  std::vector<int32_t> hits_;
  std::vector<uint8_t> open_, seen_, crosses_;
  std::vector<int32_t> curve_;  // of has_loop
  std::vector<int16_t> class_of_root_;
  std::vector<double> volume_;
  int walks_ = 0, unresolved_ = 0;
};

}  // namespace limberg
