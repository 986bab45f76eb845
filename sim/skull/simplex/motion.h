#pragma once
// Moving a simplex mesh: one iteration of the law of motion (law.h) at a time.
//
//   Motion motion(workers);
//   const Admission a = motion.set_law(law);               // refused, or with alphas reduced to what is stable
//   motion.step(mesh, {.force_mm = pull, .repulsor = hand});
//
// All vertices move at once from the same positions (Jacobi), so results do not depend on the
// number of workers. The mesh may be changed by operators between steps; what is kept about
// it is rebuilt when its version changes. 12 bytes per vertex and a few arrays of doubles;
// with rigidity s >= 2 also the neighbourhoods, about 1 + 1.5 s (s + 1) numbers per vertex.
//
// Rims of end contours are curves: unless their constraint is `shape`, their vertices
// move with respect to their two neighbours on the rim, with the offset from the
// chord, in the directions of the surface normal and of the surface, as their angle.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/base/workers.h"
#include "sim/skull/simplex/law.h"
#include "sim/skull/simplex/mesh.h"
#include "sim/skull/simplex/motion_kernel.h"

namespace limberg::simplex {

/// A finger or cursor that pushes: beta (R - distance) outwards for every vertex nearer than R to the way from `from`
/// to `to` (where it was at the last iteration, and where it is: a fast one does not jump through).
struct Repulsor {
  Vec3 from_mm = Vec3::Zero(), to_mm = Vec3::Zero();
  double radius_mm = 0;
  double beta = 0.5;
};

struct External {
  std::span<const Vec3> force_mm;  // empty, or one per vertex slot: displacement that the vertex is pulled by
  std::span<const Repulsor> repulsor;
};

struct StepReport {
  double max_move_mm = 0;  // longest displacement of this iteration
  double rms_move_mm = 0;
  double repulsion = 1;  // < 1: repulsors were weakened by so much to stay stable
};

class Motion {
 public:
  explicit Motion(Workers& workers) : workers_(workers) {}

  /// Enforces the bound. A refused law is not taken: the one before stays.
  Admission set_law(const Law& law, Excess excess = Excess::reduce);
  const Law& law() const { return law_; }

  /// Throws InputError: forces that are not one per vertex slot, repulsors that are not finite.
  StepReport step(Mesh& mesh, const External& external = {});

  /// F_int of every vertex slot as the law wants it now (zero where nothing moves). Rims as at step.
  void internal_force(const Mesh& mesh, std::vector<Vec3>& force_mm);
  /// Root mean square of F_int over the vertices.
  double rms_force_mm(const Mesh& mesh);

  /// Largest eigenvalue (by size) of -dF_int/dx at the present place, by power iteration on differences. To look at,
  /// for meshes less even than those the table of law.h was made for.
  double measure_lambda(const Mesh& mesh, int iterations = 100);

  /// Mean curvature of every vertex slot, 1/mm.
  void mean_curvature(const Mesh& mesh, std::vector<double>& H_per_mm);
  /// One adaptation of the wanted metric parameters: half way to 1/3 + gain (|H_j| - Hb) / Hb, Hb the mean |H| of the
  /// three neighbours; none below 0.05.
  void adapt_metric(Mesh& mesh, double gain);

 private:
  struct RimVertex {
    int32_t v, before, after, spoke;  // vertex, neighbours along the rim, third neighbour
    int32_t first, size, at;          // its rim within rim_, and its place there
  };
  struct RimOffset {
    Vec3 normal = Vec3::Zero(), side = Vec3::Zero();     // unit, across the chord
    double chord = 0, along_normal = 0, along_side = 0;  // offset over chord
  };
  void prepare(const Mesh& mesh);
  void neighbourhoods(const Mesh& mesh);
  KernelView view(const Mesh& mesh);
  void curvature_pass(const Mesh& mesh, KernelView& v);
  void rim_offsets(const Mesh& mesh);
  Vec3 rim_force(const Mesh& mesh, size_t i) const;
  const KernelZone& zone_of(const Mesh& mesh, int32_t v) const;
  double push(const Mesh& mesh, std::span<const Repulsor> repulsor);

  Workers& workers_;
  Law law_;
  bool have_law_ = false, rebuild_ = true, angle_ = false, curvature_ = false, shape_ = false, wide_ = false;
  uint64_t version_ = 0;
  int iteration_ = 0;
  std::vector<KernelZone> zone_;
  std::vector<KernelShape> shape_of_;
  std::vector<double> phi_, H_;
  std::vector<size_t> near_first_;
  std::vector<int32_t> near_;
  std::vector<RimVertex> rim_;
  std::vector<RimOffset> offset_;
  std::vector<Vec3> push_, rim_next_;
  std::vector<KernelSums> sums_;
};

}  // namespace limberg::simplex
