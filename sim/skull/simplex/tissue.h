#pragma once
// Tissue between a face and a skull: a 3-simplex mesh, in which every vertex has exactly four neighbours.
//
// Extruding a patch of a 2-simplex mesh would give five. So the primal is built and its dual taken: the triangles
// whose nodes are the face centres of the face's region are stacked in layers of prisms down to the skull, each
// prism is cut in three tetrahedra (every quad's diagonal starts at its lower node, so neighbours agree), and
//
//   one vertex per tetrahedron, joined across shared triangles;
//   one per boundary triangle, joined to its tetrahedron and to
//   the boundary triangles across its three edges:   3 layers |T| + 2 |T| + 2 layers
//                                                    |border| vertices, all of degree four
//
// The vertices over the top triangles are the vertices of the face's region, one to one; those
// under the bottom are anchored on the skull. Both kinds are set by `follow`; the others move.
//
//   smoothing   to the mean of the four neighbours; fills the space evenly. Rest lengths are recorded after it
//   springs     F_i = sum_j f(l_ij) along the edges, stiffer with
//               elongation; skull fixed, the face receives the opposite
//   shape       to sum_j k_ij (P_j + (R_i + R_j)/2 (X_i - X_j)) / sum_j k_ij:
//               the rest shape X of a vertex and its neighbours, turned as
//               these have turned (R: the rotation with the least sum k_ij |P_j
//               - P_i - R_i (X_j - X_i)|^2). Exact for rigid motions; the
//               energy is that of Sorkine and Alexa 2007 with conductances of
//               the tissue for weights, which for small displacements is
//               Laplace's equation: the tissue passes on what its neighbours do
//
// Springs alone do not hold a shape: two springs per vertex stand against three unknowns.
// `zero_energy_modes` counts what they leave free; with both surfaces held it is 0.6 to 0.9
// per free vertex. A share of the shape force (TissueLaw::shape) holds that. (Delingette,
// Subsol, Cotin, Pignon 1994; the construction and the count are this program's.)
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/base/workers.h"
#include "sim/commands/head_command.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg {
class Bvh;
}

namespace limberg::simplex {

enum class TissueRole : uint8_t { inside, side, face, skull };
enum class Stiffening : uint8_t { none, biphasic, quadratic, exponential };

/// Force of a spring over its rest stiffness, e = (l - l0) / l0.
struct SpringLaw {
  Stiffening kind = Stiffening::biphasic;
  double knee = 0.15;  // biphasic: elongation from which the stiffness is `ratio` times as large
  double ratio = 6;
  double c = 10;  // quadratic: k = k0 (1 + c e^2); exponential: f = (k0 l0 / c) (exp(c e) - 1)
  double force_over_k0(double l, double l0) const;  // mm
  /// No less than the tangent nor, in tension, than the secant stiffness; without jumps: forces are divided by it, and
  /// a pull that jumped where a spring stiffens would never rest.
  double tangent_over_k0(double l, double l0) const;
};

/// What finite elements need of the tetrahedra that they are made of.
struct TissueFloor {
  double shape = 0;         // the least mean ratio (below) of a tetrahedron; 0: any that has a volume
  double thickness_mm = 0;  // the least length of a column, from bone to skin
};
/// 12 (3 V)^(2/3) / (sum of the squares of the six edges): 1 for a regular tetrahedron, 0 for a flat one, below 0 for
/// one that is turned inside out (Liu and Joe 1994, On the shape of tetrahedra from bisection; as remembered).
double mean_ratio(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

struct TissueSettings {
  int layers = 1;         // 1..16
  double young_kPa = 10;  // k_ij = E A_ij / l_ij, A_ij the primal triangle that the edge crosses; 0: all k_ij = 1 mN/mm
  double skin_kPa = 0;    // of the top layer, which is skin and fat; 0: as the others
  double max_thickness_mm = 100;  // farther is no opposite side
  TissueFloor floor;              // a tissue below it is refused,
  bool mend = false;              // or its feet are placed so that it is met (tissue_feet.h)
};

struct BoneAnchor {
  int32_t vertex = -1;              // of the tissue
  int32_t skull[3] = {-1, -1, -1};  // vertices of the skull that carry it
  double weight[3] = {0, 0, 0};
  double height_mm = 0;          // over their plane
  Mat3 axes = Mat3::Identity();  // that turn with them, as they stood when the tissue was made
};
/// Right-handed axes that turn with the three vertices of the skull that an anchor names.
Mat3 axes_of(const BoneAnchor& anchor, const Mesh& skull);

struct Tissue {
  std::vector<std::array<int32_t, 4>> nbr;
  std::vector<Vec3> x_mm, before_mm;
  std::vector<TissueRole> role;
  std::vector<std::array<double, 4>> rest_mm, k_mN_per_mm;  // per neighbour
  std::vector<Vec3> x0_mm;                                  // places at rest
  std::vector<Mat3> turn;                                   // R, as the last turn_shape left it
  std::vector<Vec3> bent_mm;                      // sum_j k_ij (R_i + R_j)/2 (X_i - X_j) / sum_j k_ij, of the same
  std::vector<std::pair<int32_t, int32_t>> link;  // tissue vertex, face vertex
  std::vector<BoneAnchor> anchor;
  // The primal: nodes from the skull (layer 0) to the face, and tetrahedra of positive volume.
  std::vector<Vec3> node_mm;
  std::vector<std::array<int32_t, 4>> tet;
  int layers = 0;
  int hovering = 0;  // nodes of the lowest layer that do not stand on bone
  int32_t vertices() const { return int32_t(nbr.size()); }
};

/// How well shaped, and how thick.
struct TissueQuality {
  double least_ratio = 1, low_ratio = 1;                               // mean ratio: the least, and what 1 % are below
  double thinnest_mm = 0, median_mm = 0, p95_mm = 0, thickest_mm = 0;  // lengths of columns
  int columns = 0, hovering = 0;                                       // nodes of a layer
};
TissueQuality quality_of(const Tissue& tissue);

/// What build_tissue answers: a tissue, or the reason why there is none.
struct TissueResult {
  Tissue tissue;
  std::string reason;
  // Vertices of the face over what does not meet the floor, where that is the reason; of several that touch the worst.
  std::vector<int32_t> unsound;
  explicit operator bool() const { return reason.empty(); }
};

/// `face_region`: vertices of the face. Their dual triangles must form one patch without pinched corners, none on a
/// rim. The opposite places are where the normals of the face, inwards, meet the part of the skull that `skull_region`
/// covers (the faces around those vertices; empty: all of it), else its nearest places, evened out over the patch until
/// every prism has a positive volume; where that is not to be had (over the mouth, say), the lowest nodes stay above
/// the bone, carried by it. With `mend` feet are placed one by one instead, and the thickness stays what it is where
/// nothing folds. The result is smoothed and its rest shape and stiffnesses recorded.
TissueResult build_tissue(const Mesh& face, std::span<const int32_t> face_region, const Mesh& skull,
                          std::span<const int32_t> skull_region, const TissueSettings& settings, Workers& workers);

/// The way to the opposite side: along the normal of the face, inwards, where bone lies there and is not much farther
/// than the nearest bone, else to that. False: none within `farthest_mm`.
bool way_to_bone(const Bvh& bone, const Vec3& top, const Vec3& normal, double farthest_mm, Vec3& way_mm);

/// Vertices within so many mm of v along edges, v first: a region as a cursor paints it.
std::vector<int32_t> region_around(const Mesh& mesh, int32_t v, double radius_mm);

/// Vertices within a closed line on the mesh, seen along the line's own normal: those on the same side of the mesh as
/// the one nearest to the line's middle, which is first. Empty where the line encloses nothing.
std::vector<int32_t> region_within(const Mesh& mesh, std::span<const Vec3> outline_mm);

/// Of a region what build_tissue takes: no vertex on a rim, one part (that of the first vertex that is left), nowhere
/// pinched. A region that is such already comes back as it is.
std::vector<int32_t> patch_of(const Mesh& mesh, std::vector<int32_t> region);

/// Places the ends where the face and the skull are now.
void follow(Tissue& tissue, const Mesh& face, const Mesh& skull);

struct TissueLaw {
  TissueKind mode = TissueKind::springs;  // not finite_elements: those are an elastic body (face_elasticity.h)
  SpringLaw spring;
  double shape = 0;     // springs: share of the mode shape that is mixed in, 0..1
  double gamma = 0.35;  // damping
  // below 2 - gamma: forces are over the stiffness of their vertex, so that eigenvalues lie below 2
  double alpha = 0.8;
};

struct TissueStep {
  double max_move_mm = 0;
  double longest_elongation = 0;  // (l - l0) / l0
  double alpha = 0;               // as used: reduced where the bound asks for it
};
/// One iteration of the vertices inside and on the sides. Throws InputError on a law that no alpha makes stable, and on
/// finite elements.
TissueStep step(Tissue& tissue, const TissueLaw& law, Workers& workers);

/// Turns the rest shape of every vertex as its neighbours have turned by now: a few steps of a polar decomposition from
/// where it stood (Mueller, Bender, Chentanez and Macklin 2016), so to be called every few iterations.
void turn_shape(Tissue& tissue, Workers& workers);

/// What the tissue does to the face: adds to `force_mm` (per vertex slot of the face) the force on its linked vertices
/// over their stiffness, as the external force of motion.h, of stiffness 2 or less: of the springs, and of the shape by
/// its share (TissueLaw::shape). Shape pushes as well as it pulls, which springs do not: under compression they fold
/// into the motions that they leave free (zero_energy_modes). `force_mN` (may be null): the springs' force in mN. The
/// mode smoothing has no influence.
void pull_face(const Tissue& tissue, const TissueLaw& law, std::vector<Vec3>& force_mm,
               std::vector<Vec3>* force_mN = nullptr);

void record_rest(Tissue& tissue);

/// Degrees of freedom, springs that act on them, and motions (to
/// first order) that no spring resists, with both ends held.
struct ZeroModes {
  int64_t dofs = 0, springs = 0, modes = 0;
  bool estimate = false;  // by the pivots of a sparse factor instead of an orthogonal one
};
/// Rank of the rigidity matrix at the present place: dense and
/// orthogonal up to so many degrees of freedom (0.1 s for 1000, 3 s
/// for 3000), beyond by the pivots of a sparse L D L^T of its Gram
/// matrix, which is quick and may miscount nearly dependent springs.
ZeroModes zero_energy_modes(const Tissue& tissue, int64_t dense_up_to = 1500);

/// What is wrong with the tissue, in a sentence; nothing when all is well.
std::optional<std::string> find_fault(const Tissue& tissue);
uint64_t hash(const Tissue& tissue);

}  // namespace limberg::simplex
