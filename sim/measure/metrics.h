#pragma once
// The figures of an operation, by the names that result.json uses for them.
//
// Everything is computed from one snapshot (positions, stitches, hooks), the elastic solution and exact volumes: plain
// data, nothing is changed. Definitions stand where the figures are made: skin_strain.h, skin_shape.h; forces here.
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sim/fem/elastic_solver.h"
#include "sim/measure/penetration.h"
#include "sim/measure/skin_shape.h"
#include "sim/measure/skin_strain.h"
#include "sim/snapshot.h"
#include "sim/world.h"

namespace limberg {

/// Forces on the tissue from outside. At equilibrium they add up to nothing, whatever the stitches do within.
struct ForceBalance {
  Vec3 hooks_N = Vec3::Zero(), supports_N = Vec3::Zero(), sum_N = Vec3::Zero();
  // |sum| / (|force| of each hook, of the supports' resultant and of both ends of each stitch, added up; at least 10 mN, so
  // that rounding is not called an imbalance where nothing pulls).
  double relative = 0;
};

struct SutureFigure {
  int id = 0;
  double force_N = 0, gap_mm = 0;
  std::array<float, 3> at_mm{};  // the middle of the stitch, in the world
};

struct Metrics {
  int pieces = 0;
  double volume_mm3 = 0, removed_volume_mm3 = 0, initial_volume_mm3 = 0;  // exact, at rest
  double volume_change = 0;      // (volume + removed - initial) / initial: 0 but for rounding, or the cutter is wrong
  double compression = 0;        // present volume of the material over its rest volume, minus 1

  std::vector<SutureFigure> sutures;
  double closure_force_N = 0;    // sum over the stitches
  double suture_force_max_N = 0, suture_gap_max_mm = 0;
  int suture_force_max_id = 0;   // 0: no stitch

  double stretch_max = 1, stretch_p99 = 1;        // of the skin, prestretch included
  double stress_max_kPa = 0, stress_p95_kPa = 0;  // largest principal Cauchy stress in the skin's plane
  double dog_ear_mm = 0, dog_ear_volume_mm3 = 0;  // of the skin within 20 mm of a cut
  Vec3 dog_ear_at_mm = Vec3::Zero();
  double wound_gape_mm = 0, wound_gape_mean_mm = 0;

  Penetration penetration;       // tissue in tissue, at wounds
  double contact_force_N = 0;    // sum of the forces with which wound surfaces press on each other, each pair once

  double min_J = 1;              // det F at the centres of the cells
  int inverted_cells = 0;
  ForceBalance balance;

  std::optional<double> elongation;     // Z-plasty
  std::optional<double> flap_area_mm2;  // present area of the skin of the flap (find_flap)
};

struct RestVolumes {
  int pieces = 0;
  double volume_mm3 = 0, removed_mm3 = 0, initial_mm3 = 0;
};

/// `support_force_mN` as ElasticSolver gives it: what the fixed nodes receive from the material.
ForceBalance force_balance(std::span<const HookState> hooks, std::span<const SutureState> sutures, const Vec3& support_force_mN);

/// `script`: what was done, for figures that belong to a kind of flap; may be empty. The snapshot's topology must be set.
/// About 0.3 s on a block of 60,000 triangles.
Metrics measure(const Snapshot& snapshot, const Skin& skin, const ElasticSolver& solver, const RestVolumes& volumes,
                std::span<const Command> script = {});

inline Metrics measure(const World& world, const Snapshot& snapshot, const Skin& skin, std::span<const Command> script = {}) {
  return measure(snapshot, skin, world.solver(),
                 {world.pieces(), world.volume_mm3(), world.removed_volume_mm3(), world.initial_volume_mm3()}, script);
}

}  // namespace limberg
