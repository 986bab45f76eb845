#pragma once
// The operators on 2-simplex meshes: every one answers `done`, or a reason and has changed nothing.
//
//                          change of   V    E    F   chi
//   t1  delete an edge                -2   -3   -1    0    (dual: edge collapse)            inverse: t2
//   t2  split a face                  +2   +3   +1    0    (dual: vertex split)             inverse: t1
//   exchange                           0    0    0    0    (dual: edge flip)                inverse: exchange
//                                                                                           the other way
//   t3  join two faces                 0    0   -2   -2    merges parts, or adds a handle   inverse: t4
//   t4  cut along a contour            0    0   +2   +2    divides, or opens a handle       inverse: t3
//   t3_spokes                        -2k  -3k -(k+2) -2    joins spoke to spoke             inverse: t4_edges
//   t4_edges  cut across edges       +2k  +3k +(k+2) +2    along an exact curve             inverse: t3_spokes
//
// Every operator keeps the invariants of mesh.h. Two lists of conditions go beyond what
// the rotation system itself needs, so that the dual stays a triangulation without double
// edges: t1 asks that no third face touches both faces that it merges (the link condition
// of edge collapses), and the joining operators ask the same of what they bring together.
//
// What an operator did is appended to `delta` (edit.h): undo() takes it
// back exactly, positions and velocities included. The inverse operators
// restore topology; positions and velocities of vertices that had gone
// are set anew, as said at each. Vertices whose neighbours change get
// their reference shape from their place after the operation.
#include <span>
#include <string>

#include "sim/skull/simplex/edit.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg::simplex {

enum class Answer : uint8_t {
  done,
  no_such_vertex,  // a vertex, edge or face named does not exist, or two vertices named are not neighbours
  no_such_edge,
  no_such_face,
  same_edge,           // two different edges of one face were expected
  end_face,            // would change the ring of a hole or of a cut mouth in a way that is not allowed
  locked,              // a vertex is locked
  on_contour,          // a vertex belongs to a kept contour
  face_too_small,      // a face would be left with fewer than three vertices
  already_neighbours,  // two vertices that would become neighbours are so already
  faces_meet_twice,    // two faces would share more than one edge
  same_face,           // two different faces were expected
  shared_vertex,       // the two faces have a vertex in common
  common_face,         // some face touches both faces
  sizes_differ,        // faces with equally many vertices were expected
  not_interleaved,     // the contour does not run through both rings in their order
  too_short,           // a contour has at least three vertices
  not_a_cycle,         // neighbours in the contour are not neighbours in the mesh
  repeated_vertex,     // a vertex (or, across edges, a face) occurs twice in the contour
  too_few_left,        // fewer than three vertices of the contour have their third neighbour on the left
  too_few_right,
  touches_face_twice,  // the contour leaves a face and comes back to it
  does_not_divide,     // the policy asks for two parts
  divides              // the policy asks for one
};
/// The reason as a sentence for people.
const char* sentence(Answer a);

/// What a cut may do to the part that it is made in.
enum class CutPolicy : uint8_t { any, must_divide, must_not_divide };

struct OperatorResult {
  Answer answer = Answer::done;
  int32_t vertex[2] = {-1, -1};  // t2: the new vertices; refusals: where, if known
  int32_t face[2] = {-1,
                     -1};  // t1: the merged face; t2: the halves; cuts: the mouth on the left part, and on the right
  bool divided = false;    // cuts: there is one part more
  explicit operator bool() const { return answer == Answer::done; }
};
/// A refusal, with the vertices that it is about.
inline OperatorResult no(Answer a, int32_t v = -1, int32_t w = -1) {
  OperatorResult o;
  o.answer = a, o.vertex[0] = v, o.vertex[1] = w;
  return o;
}

/// Deletes the edge between p and q with both ends; the faces on its sides become one.
OperatorResult t1(Mesh& mesh, int32_t p, int32_t q, Delta& delta);
Answer may_t1(const Mesh& mesh, int32_t p, int32_t q);

/// Splits a face by a new edge from the middle of one of its edges to the middle of another;
/// the edges are named by the vertex that they leave in the order of the face. vertex[0]
/// lies on the first edge, face[0] is what lies after it. The new vertices go a third of the
/// way from the edge's middle to the other edge's middle, with the velocity of the edge.
OperatorResult t2(Mesh& mesh, int32_t face, int32_t u1, int32_t u2, Delta& delta);
Answer may_t2(const Mesh& mesh, int32_t face, int32_t u1, int32_t u2);
/// The same across the longest direction of the face: by the edges that the plane through its centre, normal to its
/// principal axis, crosses.
OperatorResult t2_across(Mesh& mesh, int32_t face, Delta& delta);

enum class Turn : uint8_t { clockwise, counter_clockwise };
/// Turns the edge p - q by a quarter about its middle, in the plane of its four neighbours: its side faces lose a
/// vertex each, its end faces gain one.
OperatorResult exchange(Mesh& mesh, int32_t p, int32_t q, Turn turn, Delta& delta);
Answer may_exchange(const Mesh& mesh, int32_t p, int32_t q);

/// Cuts along a contour, a cycle of neighbouring vertices. Each vertex goes to the side of its third neighbour.
OperatorResult t4(Mesh& mesh, std::span<const int32_t> contour, CutPolicy policy, Delta& delta);

/// Joins faces x and y: their rings become one contour, which runs against the order of x and along the order of y.
/// Without a contour, the rings are interleaved by their share of arc length, from the nearest pair of vertices on.
OperatorResult t3(Mesh& mesh, int32_t x, int32_t y, Delta& delta);
OperatorResult t3(Mesh& mesh, int32_t x, int32_t y, std::span<const int32_t> contour, Delta& delta);

/// An edge crossed by a closed curve: `right` lies to the right
/// of the curve; the crossing is right + t (left - right) .
struct Crossing {
  int32_t left = -1, right = -1;
  double t = 0.5;  // of the way from left to right, 0..1
};
/// Cuts along a closed curve across edges; successive edges have a face in common. New vertices lie at the crossings.
OperatorResult t4_edges(Mesh& mesh, std::span<const Crossing> curve, CutPolicy policy, Delta& delta);

/// Joins faces x and y of equally many vertices spoke to spoke; both rings disappear.
/// ring_x[0] goes with ring_y[0], where the rings start at the named vertices, x
/// against its order and y along it. -1: the pairing with the least sum of squares.
OperatorResult t3_spokes(Mesh& mesh, int32_t x, int32_t y, Delta& delta, int32_t start_x = -1, int32_t start_y = -1);

/// Removes the component of v. Kept contours in it go with it.
OperatorResult remove_component(Mesh& mesh, int32_t v, Delta& delta);

}  // namespace limberg::simplex
