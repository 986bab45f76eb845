#pragma once
// A simplex mesh of the surface where a distance function is zero.
//
// The function is sampled on a grid whose cubes are cut in six tetrahedra about one diagonal, the same way everywhere,
// so that the triangles of neighbouring cubes always fit: the surface is a manifold without any case table, and its
// topology is that of the samples. Blocks of 8 x 8 x 8 cubes whose centre is farther from zero than the Lipschitz bound
// times their radius are skipped. The dual of the triangles is then merged and split to even faces (adapt.h), smoothed,
// and put on the surface by Newton steps along the gradient.
#include <functional>

#include "sim/base/workers.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg {

struct LevelSet {
  std::function<double(const Vec3&)> distance_mm;  // below 0 inside; called from several threads
  double lipschitz = 1;                            // it never changes by more than this a mm
  Vec3 low_mm = Vec3::Zero(),
       high_mm = Vec3::Zero();  // the box that is looked at; a surface that leaves it ends in a hole there
};

struct LevelSetSettings {
  double grid_mm = 3;    // thinner walls are lost
  double edge_mm = 3.5;  // wanted edges
  int smoothing = 4;     // iterations after each pass of adaptation
  int passes = 12;       // of adaptation, at most
  /// The wanted edge by place, at most edge_mm; may be empty. The grid is then graded (graded_grid.h): grid_of_edge
  /// times the edge, at most grid_mm.
  std::function<double(const Vec3&)> edge_at;
  double grid_of_edge = 0.8;
};

struct LevelSetReport {
  int64_t evaluations = 0;                  // of the grid
  int64_t triangles = 0;                    // marched
  int dropped = 0;                          // components besides the largest
  double rms_mm = 0, max_mm = 0;            // distance of the vertices
  double face_rms_mm = 0, face_max_mm = 0;  // of the centres of the faces: what flat faces lose
  int folded = 0;  // vertices whose normal is more than 78 degrees off the gradient (sharp creases)
};

/// Triangles of the surface, outwards counter-clockwise, with shared vertices. Throws InputError when the box or the
/// grid is not finite and positive, or asks for more than 4e8 samples.
void march(const LevelSet& surface, double grid_mm, Workers& workers, std::vector<Vec3>& X_mm, std::vector<Tri>& tri,
           int64_t* evaluations = nullptr);

/// The largest component. Throws InputError as above, or when there is no surface in the box.
simplex::Mesh mesh_level_set(const LevelSet& surface, const LevelSetSettings& settings, Workers& workers,
                             LevelSetReport* report = nullptr);

/// Distance at a place over the length of the gradient, and the gradient; by differences over 0.02 mm.
struct LevelAt {
  double distance_mm = 0;
  Vec3 gradient = Vec3::Zero();
};
LevelAt level_at(const LevelSet& surface, const Vec3& p_mm);

/// The place on the surface that Newton steps along the gradient lead to; false: none within `reach_mm`.
bool put_on_surface(const LevelSet& surface, Vec3& p_mm, double reach_mm);

}  // namespace limberg
