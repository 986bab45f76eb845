#pragma once
// Changing a mesh so that the change can be taken back exactly: whoever is about to change a vertex or a face saves it
// first. Undoing gives the same bits in every array, the order of the free slots included.
#include <vector>

#include "sim/skull/simplex/mesh.h"

namespace limberg::simplex {

/// What one operation (or several in a row) changed. Empty: nothing.
class Delta {
 public:
  bool empty() const { return step_.empty(); }
  size_t bytes() const;
  /// What `later` did comes after what is here.
  void append(Delta&& later);

 private:
  friend class Edit;
  friend void undo(Mesh& mesh, Delta& delta);
  enum class What : uint8_t {
    vertex,
    face,
    new_vertex,
    new_face,
    reused_vertex,
    reused_face,
    freed_vertex,
    freed_face,
    contours
  };
  struct Vertex {
    Row nbr, left;
    Vec3 x_mm, before_mm;
    VertexShape shape;
    std::array<double, 2> metric;
    uint16_t zone;
    uint8_t flags;
  };
  struct Face {
    int32_t edge, size;
    FaceKind kind;
  };
  struct Step {
    What what;
    int32_t index;
  };
  std::vector<Step> step_;
  std::vector<Vertex> vertex_;
  std::vector<Face> face_;
  std::vector<std::vector<std::vector<int32_t>>> contours_;
};

/// Takes back what the delta holds and empties it. Deltas are undone in the reverse order of their making.
void undo(Mesh& mesh, Delta& delta);

/// The hand that changes a mesh. Appends to the delta it is given.
class Edit {
 public:
  Edit(Mesh& mesh, Delta& delta) : m(mesh), d_(delta) {}
  /// Call before the first change of that vertex or face (again does no harm).
  void save_vertex(int32_t v);
  void save_face(int32_t f);
  void save_contours();
  /// A fresh slot; the caller fills it in. A new vertex copies position, zone and so on from `like`.
  int32_t add_vertex(int32_t like);
  int32_t add_face(FaceKind kind);
  void free_vertex(int32_t v);
  void free_face(int32_t f);
  /// In the row of v, `was` becomes `is`. Saves v.
  void replace_neighbour(int32_t v, int32_t was, int32_t is);
  /// Walks from half-edge h0 and makes its orbit face f: marks,
  /// size, first edge. Saves f and the vertices whose mark changes.
  void mark_face(int32_t f, int32_t h0);
  /// Records the reference shape of v from its present place: its neighbours changed.
  void reshape(int32_t v);

  Mesh& m;

 private:
  Delta& d_;
};

}  // namespace limberg::simplex
