#pragma once
// A 2-simplex mesh: a surface in which every vertex has exactly three neighbours (the dual of a triangulation).
//
// Stored as a rotation system in flat arrays: row v of `nbr` holds the neighbours of v counter-clockwise
// as seen from outside. Nothing else is needed to know the surface. A half-edge h = 3 u + k runs from u
// to nbr[u][k]; the face on its left goes on with v -> the neighbour before u in the row of v. Faces are
// the orbits of that walk; `left` and the face table are a cache of them, kept by every operator.
//
// A hole is a face flagged `hole`, the mouth of a cut one flagged `cut`: neither is drawn,
// pulled or coloured, and its ring is an end contour. So every vertex of an open surface has
// three neighbours too, and there is no second case anywhere. A `wall` is the cut surface of
// bone: drawn and closed, no end; between it and the `surface` runs a crease. A slot that an
// operator has freed holds -1 in its row and is used again by the next one that needs a vertex.
//
// Invariants (find_fault checks all of them): neighbours are mutual and distinct;
// no vertex meets a face twice and no two faces share two edges, so the dual is a
// triangulation without double edges; every face has at least three vertices.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/geometry/vec.h"
#include "sim/skull/simplex/vertex_shape.h"

namespace limberg::simplex {

enum class FaceKind : uint8_t { surface = 0, hole = 1, cut = 2, wall = 3 };
inline bool is_end(FaceKind k) { return k == FaceKind::hole || k == FaceKind::cut; }

enum VertexFlag : uint8_t {
  kLocked = 1,    // does not move; operators leave it alone
  kOnContour = 2  // belongs to a kept contour; operators leave it alone
};

/// Which way the axes of a mesh from a file point. Pictures from a scanner are in left, posterior, superior (DICOM); a
/// head is in right, forwards, up. One is the other turned by half a circle about the third axis.
enum class Axes : uint8_t { unsaid, left_posterior_superior, right_forwards_up };

using Row = std::array<int32_t, 3>;

struct Mesh {
  // One entry per vertex slot.
  std::vector<Row> nbr;                       // -1, -1, -1: a free slot
  std::vector<Row> left;                      // face on the left of half-edge 3 v + k
  std::vector<Vec3> x_mm, before_mm;          // position now and one iteration ago (the difference is the velocity)
  std::vector<VertexShape> shape;             // reference shape, for the shape force
  std::vector<std::array<double, 2>> metric;  // wanted metric parameters e1, e2
  std::vector<uint16_t> zone;                 // which law of motion (motion.h)
  std::vector<uint8_t> flags;                 // VertexFlag
  // One entry per face slot.
  std::vector<int32_t> face_edge;  // a half-edge that has it on its left; -1: a free slot
  std::vector<int32_t> face_size;  // vertices
  std::vector<FaceKind> face_kind;
  // Free slots, used last in first out.
  std::vector<int32_t> free_vertex, free_face;
  // Kept contours: closed cycles of neighbouring vertices (zone borders, planned cuts). contour.h.
  std::vector<std::vector<int32_t>> contour;
  Axes axes = Axes::unsaid;
  uint64_t version = 0;  // counts changes of all but positions and velocities

  int32_t slots() const { return int32_t(nbr.size()); }
  int32_t face_slots() const { return int32_t(face_edge.size()); }
  int32_t vertices() const { return slots() - int32_t(free_vertex.size()); }
  int32_t faces() const { return face_slots() - int32_t(free_face.size()); }
  bool alive(int32_t v) const { return v >= 0 && v < slots() && nbr[size_t(v)][0] >= 0; }
  bool alive_face(int32_t f) const { return f >= 0 && f < face_slots() && face_edge[size_t(f)] >= 0; }

  int32_t from(int32_t h) const { return h / 3; }
  int32_t to(int32_t h) const { return nbr[size_t(h / 3)][size_t(h % 3)]; }
  int32_t face(int32_t h) const { return left[size_t(h / 3)][size_t(h % 3)]; }
  /// Which entry of v's row is u; -1: none.
  int slot(int32_t v, int32_t u) const {
    const Row& r = nbr[size_t(v)];
    return r[0] == u ? 0 : r[1] == u ? 1 : r[2] == u ? 2 : -1;
  }
  /// Half-edge u -> v; -1: they are not neighbours.
  int32_t edge(int32_t u, int32_t v) const {
    const int k = slot(u, v);
    return k < 0 ? -1 : 3 * u + k;
  }
  int32_t twin(int32_t h) const { return edge(to(h), from(h)); }
  int32_t next(int32_t h) const {  // along the face on the left
    const int32_t v = to(h);
    return 3 * v + (slot(v, from(h)) + 2) % 3;
  }
  FaceKind kind(int32_t f) const { return face_kind[size_t(f)]; }

  /// Vertices of a face, counter-clockwise seen from outside.
  std::vector<int32_t> ring(int32_t f) const;
  /// Calls visit(half-edge) around face f.
  template <class Visit>
  void around(int32_t f, Visit&& visit) const {
    const int32_t h0 = face_edge[size_t(f)];
    int32_t h = h0;
    do {
      visit(h);
      h = next(h);
    } while (h != h0);
  }
  LocalFrame frame(int32_t v) const {
    const Row& r = nbr[size_t(v)];
    return local_frame(x_mm[size_t(v)], x_mm[size_t(r[0])], x_mm[size_t(r[1])], x_mm[size_t(r[2])]);
  }
};

/// A mesh from rows and positions: walks the faces and gives every face the kind `surface`. Throws InputError with what
/// find_fault says when the rows are no simplex mesh.
Mesh make_mesh(std::vector<Row> nbr, std::vector<Vec3> x_mm);

/// What is wrong with the mesh, in a sentence; nothing when every invariant holds. O(V).
std::optional<std::string> find_fault(const Mesh& mesh);

/// Euler bookkeeping. chi counts end faces as faces, so that V - E + F = 2 per sphere whatever its holes.
struct Census {
  int64_t vertices = 0, edges = 0, faces = 0;  // faces: end faces included
  int64_t end_contours = 0;
  int64_t components = 0;
  int64_t chi = 0;
  int64_t genus = 0;  // of all components together: (2 components - chi) / 2
  bool operator==(const Census&) const = default;
};
Census census(const Mesh& mesh);

/// Component of every vertex slot (-1: free), numbered by the smallest vertex; returns how many.
int32_t components(const Mesh& mesh, std::vector<int32_t>& of_vertex);

/// Renumbers vertices and faces without free slots, neighbours close together in memory
/// when `by_nearness` (breadth first from the smallest vertex of each component), else
/// in their old order. Returns new numbers of the old vertices (-1: free).
std::vector<int32_t> compact(Mesh& mesh, bool by_nearness = false);

/// Turned so that its axes point right, forwards and up; one whose axes are unsaid is taken for such.
void turn_to_head(Mesh& mesh);

/// The component of vertex v as a mesh of its own: positions, velocities, zones, flags, shapes, end contours and kept
/// contours go along. `old_vertex` (may be null) receives the old number of each of its vertices.
Mesh extract_component(const Mesh& mesh, int32_t v, std::vector<int32_t>* old_vertex = nullptr);
/// Puts a copy of `other` beside what is there; returns the number its vertex 0 gets. `other` is compact.
int32_t append(Mesh& mesh, const Mesh& other);

/// Records the reference shape of every vertex from its present place.
void record_shape(Mesh& mesh, ShapeCode code = ShapeCode::angle);

/// Over rows, kinds of faces, contours, positions, velocities, zones, flags, metric parameters and shapes. The numbers
/// of faces and the free slots do not enter.
uint64_t hash(const Mesh& mesh);
/// Over rows, kinds of faces and contours only.
uint64_t topology_hash(const Mesh& mesh);

}  // namespace limberg::simplex
