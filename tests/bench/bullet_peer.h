#pragma once
// Bullet's deformable body (btDeformableMultiBodyDynamicsWorld, neo-Hookean, implicit) as a peer of the benches.
//
// Its settings are those under which it works best here: projection instead of Lagrange
// multipliers (with the latter nothing moves where nodes are held), the mass
// preconditioner, one Newton step a time step, damping 0.1. The body has one material, so a
// model's cells must agree in theirs. Springs between embedded points are a force class of
// ours: its API has none. Without LIMBERG_BULLET nothing of this is built but has_bullet().
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "sim/fem/model/fem_model.h"

namespace limberg::bench {

bool has_bullet();

/// Bullet's energy as a law: mu/2 (|F|^2 - 3) - mu/2 log(|F|^2 + 1)
/// + lambda/2 (J - 1 - 3/4 mu/lambda)^2, less its value at rest.
LawPtr bullet_law(double mu_kPa, double lambda_kPa);
/// mu and lambda of that law for small strains as of Young's modulus and Poisson's ratio (Smith, de Goes, Kim 2018).
std::array<double, 2> bullet_constants(double young_kPa, double poisson);

/// Five tetrahedra for every cell, mirrored in every other one, so that squares agree.
std::vector<std::array<int32_t, 4>> five_tets(const FemModel& hexahedra);
/// The same nodes and masses, tetrahedra of Bullet's law.
FemModel tet_twin(const FemModel& hexahedra, double mu_kPa, double lambda_kPa);

class BulletBody {
 public:
  /// Nodes of `model` that are fixed are held. Throws std::runtime_error where Bullet is not built in.
  BulletBody(const FemModel& model, double mu_kPa, double lambda_kPa, double damping = 0.1);
  ~BulletBody();
  void set_springs(std::span<const Spring> springs);
  void set_displacement_mm(std::span<const Vec3f> u);
  void set_velocity(const Vec3& mm_per_s);
  void step(double dt_s);
  std::vector<Vec3> displacement_mm() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg::bench
