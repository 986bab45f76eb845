#pragma once
// What an Arrangement owns, open to the parts of this library: arrays, the edge map, the record of how to undo.
#include <memory>
#include <optional>

#include "sim/cutting/arrangement/arrangement.h"
#include "sim/cutting/arrangement/box_tree.h"
#include "sim/cutting/arrangement/edge_map.h"
#include "sim/cutting/arrangement/point_store.h"

namespace limberg {

struct CutScratch;

/// One operation that made original triangles: the body (op 0) or a blade.
struct OpRecord {
  int32_t first_orig = 0;
  std::vector<std::array<Eigen::Vector2f, 3>> uv;  // per original triangle
  bool strip = false;                              // Blade::strip
  BoxTree boxes;                                   // over its original triangles; never made again
};

/// Of operations [first, first + count): a box tree over the boxes around each one.
struct OpTree {
  int32_t first = 0, count = 0;
  BoxTree boxes;
};
using Forest = std::vector<std::shared_ptr<const OpTree>>;

/// The components of the sided surface; volumes also as exact sums, so that they do not depend on any order.
struct Components {
  std::vector<SurfaceComponent> all;  // in order of their smallest sided face
  std::vector<int128> volume;         // 6 V in half-units^3, times 2^20
};

/// How a face lies among the others of its original triangle: across each edge
/// the face there, by its place in the division, or ~e where it lies on edge e
/// of the triangle. Edges between two faces are inner ones (Face::inner) or
/// junctions: these come in the order of the division's constraints when faces
/// and their edges are gone through and each is counted once.
using PieceLinks = std::array<int32_t, 3>;

/// Everything needed to take one operation back, and nothing else.
struct OperationDelta {
  LastOperation::Kind kind = LastOperation::none;
  int32_t points = 0, faces = 0, origs = 0, divisions = 0, ops = 0;  // array lengths before
  size_t division_faces = 0, division_constraints = 0;
  Forest forest;                                  // before
  std::vector<int32_t> retired;                   // faces retired
  std::vector<std::pair<int32_t, uint8_t>> mat;   // face, bits before (excision)
  std::vector<std::pair<int32_t, int32_t>> mate;  // sided half-edge, mate before; in order of change
  struct OrigBefore {
    int32_t orig = 0, live = 0, whole = 0, split = 0;
    std::optional<Division> division;  // of a triangle that was divided before
  };
  std::vector<OrigBefore> orig;
  uint64_t hash_sum = 0, volume_residue = 0;
  std::optional<Components> component;  // when the operation changed nothing but their sizes (components.cpp)
  std::vector<std::pair<int32_t, int32_t>> component_of;  // then: of the sided faces that it removed
};

struct ArrangementStore {
  RestGrid grid;
  PointStore points;
  std::vector<Face> face;
  std::vector<std::array<int32_t, 6>> mate;  // per face: [3 * side + k]
  std::vector<OrigTri> orig;
  std::vector<Division> division;
  std::vector<int32_t> division_face;     // of all divisions, earlier ones included: undo goes back to them
  std::vector<PieceLinks> division_link;  // of each of them
  std::vector<Constraint> division_constraint;
  EdgeMap edges;
  std::vector<OpRecord> op;
  Forest forest;                // of blades
  std::vector<SurfaceTag> tag;  // per body triangle
  std::vector<OperationDelta> history;
  LastOperation last;
  std::shared_ptr<CutScratch> scratch;  // working space of cuts (cut_scratch.h), of no meaning between them
  uint64_t hash_sum = 0;                // sum of face_hash over live faces
  uint64_t volume_residue = 0;          // 6 V modulo kPrime

  // Found when asked for, then kept up to date from cut to cut where that is possible (components.cpp).
  mutable bool components_known = false;
  mutable Components component;
  mutable std::vector<int32_t> component_of;  // per sided face; of no meaning without material

  bool is_body(int32_t o) const { return orig[o].op == 0; }
  /// Calls visit(original triangle, its box) for every one of the body whose box meets q, live or not.
  template <class Query, class Visit>
  void body_near(const Query& q, Visit&& visit) const {
    op[0].boxes.box(q, visit);
  }
  /// The same of all blades.
  template <class Query, class Visit>
  void blades_near(const Query& q, Visit&& visit) const {
    for (const auto& tree : forest)
      tree->boxes.box(q, [&](int32_t i) {
        const OpRecord& blade = op[size_t(tree->first + i)];
        blade.boxes.box(q, [&](int32_t t, const IntBox& box) { visit(blade.first_orig + t, box); });
      });
  }
  std::span<const int32_t> faces_of(int32_t o) const {
    const OrigTri& t = orig[o];
    if (t.split < 0) return {&t.whole, size_t(t.whole >= 0)};
    const Division& d = division[size_t(t.split)];
    return {division_face.data() + d.first_face, size_t(d.faces)};
  }
  /// Of faces_of(o), when o is divided.
  std::span<const PieceLinks> links_of(int32_t o) const {
    const Division& d = division[size_t(orig[o].split)];
    return {division_link.data() + d.first_face, size_t(d.faces)};
  }
  std::span<const Constraint> constraints_of(int32_t o) const {
    if (orig[o].split < 0) return {};
    const Division& d = division[size_t(orig[o].split)];
    return {division_constraint.data() + d.first_constraint, size_t(d.constraints)};
  }
  /// Which edge (0, 1, 2) of original triangle o has these end points; -1 if none.
  int edge_of_orig(int32_t o, int32_t a, int32_t b) const {
    const auto& v = orig[o].v;
    for (int k = 0; k < 3; ++k) {
      const int32_t p = v[size_t(k)], q = v[size_t(k + 1) % 3];
      if ((p == a && q == b) || (p == b && q == a)) return k;
    }
    return -1;
  }

  // glue.cpp
  uint64_t face_hash(const Face& f) const;
  uint64_t face_volume_residue(const Face& f) const;  // of its sided faces: 6 V modulo kPrime
  /// Enters a face that is to live into the running sums, or takes it out of them.
  void account_sums(int32_t f, bool in);
  /// The next operation finds a place in the history without asking for memory.
  void make_room_in_history() {
    if (history.size() == history.capacity()) history.reserve(2 * history.size() + 16);
  }
  /// Sets the mates of every live face at the edge a-b by the radial rule; old ones of faces older than `delta` go to
  /// it. Returns a description of the contradiction if there is one, else null.
  const char* glue_edge(int32_t a, int32_t b, OperationDelta* delta) {
    return glue_edge(a, b, edges.first(a, b), delta);
  }
  /// The same where the first half-edge at a-b is known.
  const char* glue_edge(int32_t a, int32_t b, int32_t first, OperationDelta* delta);

  // components.cpp
  void find_components() const;
  /// After a cut: when every component that it went through is still one piece, brings them up to date at the cost of
  /// what has changed. Else they are found afresh when next asked for.
  void update_components(OperationDelta& delta);

  // excise.cpp
  OperationDelta begin_delta(LastOperation::Kind kind) const;
  /// Clears the material bits of the components marked 1; records it in the delta and in `last`. Returns sided faces.
  int32_t clear_components(const std::vector<uint8_t>& marked, OperationDelta& delta);

  /// snap.cpp: does every triangle of the blade lie on walls of earlier cuts, within 50 micrometres and 15 degrees?
  bool is_cut_already(const Blade& blade) const;

  /// check.cpp: what is wrong with the links of a divided triangle; null if nothing. For tests.
  const char* wrong_links(int32_t o) const;

  // undo.cpp; neither asks for memory, given edges.make_room for what returns
  void take_back(OperationDelta& delta);
  /// All of it but the edge map and the components, for one that has not come to these. Retired faces are live by now.
  void take_back_arrays(const OperationDelta& delta);
  /// Makes the box tree of the last operation.
  void plant();
};

/// A face as the radial order around an edge a-b sees it.
struct RadialFace {
  const Plane* plane = nullptr;
  int32_t orig = -1;
  int sense = 1;       // +1 when the face runs a -> b
  int32_t third = -1;  // its third corner
  uint8_t mat = 0;
  int32_t half_edge = -1;  // 3 * face + k
  int sector = 0;          // for sort_radially
  uint8_t ccw_side() const { return sense > 0 ? 0 : 1; }
  bool ccw_material() const { return mat >> ccw_side() & 1; }
  bool cw_material() const { return mat >> (1 - ccw_side()) & 1; }
};

/// Sorts faces counter-clockwise around a -> b, starting anywhere. False when two coincide.
bool sort_radially(const PointStore& points, int32_t a, int32_t b, std::vector<RadialFace>& faces);

}  // namespace limberg
