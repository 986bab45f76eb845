#pragma once
// The figures of an operation, by the names that result.json uses for them.
//
// Everything is computed from one snapshot (positions, stitches, hooks), the elastic solution and exact volumes: plain
// data, nothing is changed. Definitions stand where the figures are made: skin_strain.h, skin_shape.h; forces here.
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sim/fem/solver/elastic_solver.h"
#include "sim/measure/elongations.h"
#include "sim/measure/penetration.h"
#include "sim/measure/perfusion.h"
#include "sim/measure/predicted.h"
#include "sim/measure/raw_tissue.h"
#include "sim/measure/skin_shape.h"
#include "sim/measure/skin_strain.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// Forces on the tissue from outside. At equilibrium they add up to nothing, whatever the stitches do within.
struct ForceBalance {
  Vec3 hooks_N = Vec3::Zero(), supports_N = Vec3::Zero(), sum_N = Vec3::Zero();
  Vec3 loads_N = Vec3::Zero();  // weight and loads of the scene, and what colliders press with
  // |sum| / (|force| of each hook, of the loads' and the supports' resultant and of both ends of each stitch, added up;
  // at least 10 mN, so that rounding is not called an imbalance where nothing pulls).
  double relative = 0;
};

struct SutureFigure {
  int id = 0;
  double force_N = 0, gap_mm = 0;
  std::array<float, 3> at_mm{};  // the middle of the stitch, in the world
  int thread = 0;                // stitches of one thread have one number; 0: a thread of its own
  std::optional<double> tied_N;  // in the first state at rest after it was tied; nothing when there was none
  double peak_N = 0;             // the largest of all states at rest, the present one included
};

struct NamedLandmark {
  std::string name;
  ChartPoint at{0, 0};
  std::optional<LandmarkFigure> figure;  // nothing: its skin is gone, or never was
};

struct Metrics {
  int pieces = 0;
  double volume_mm3 = 0, removed_volume_mm3 = 0, initial_volume_mm3 = 0;  // exact, at rest
  double volume_change = 0;  // (volume + removed - initial) / initial: 0 but for rounding, or the cutter is wrong
  double compression = 0;    // present volume of the material over its rest volume, minus 1

  std::vector<SutureFigure> sutures;
  double closure_force_N = 0;  // sum over the stitches
  double suture_force_max_N = 0, suture_gap_max_mm = 0;
  int suture_force_max_id = 0;  // 0: no stitch

  double stretch_max = 1, stretch_p99 = 1;        // of the skin, prestretch included
  double stress_max_kPa = 0, stress_p95_kPa = 0;  // largest principal Cauchy stress in the skin's plane
  double beyond_law_mm2 = 0;                      // SkinStrain
  double dog_ear_mm = 0, dog_ear_volume_mm3 = 0;  // of the skin within 20 mm of a cut
  Vec3 dog_ear_at_mm = Vec3::Zero();
  double wound_gape_mm = 0, wound_gape_mean_mm = 0;
  WoundGape gape;  // with its places; all zero without a wound
  TurnedSkin turned;
  RawTissue raw;
  // Stitches with both bites in one bank of a wound (MeasureAlso), and those that pull with less than kHolds_N.
  std::vector<int> one_bank, slack;

  Penetration penetration;     // tissue in tissue, at wounds
  double contact_force_N = 0;  // sum of the forces with which wound surfaces press on each other, each pair once

  double min_J = 1;  // det F at the centres of the cells
  int inverted_cells = 0;
  double inverted_mm3 = 0;  // tissue in them, at rest; where the largest part of it is
  Vec3 inverted_at_mm = Vec3::Zero();
  ForceBalance balance;

  double suture_force_peak_N = 0;                    // the largest at any time the tissue was at rest
  int sutures_over_2_5_N = 0, sutures_over_5_N = 0;  // now; limits as in the report
  std::optional<double> closure_energy_mJ;           // World::closure_energy_uJ
  double scar_length_mm = 0;                         // half of the rim as it lies now: the scar, once closed
  double closure_line_N_per_m = 0;                   // sum of the stitches' forces over the scar's length
  double step_off_mm = 0, step_off_mean_mm = 0;      // WoundGape::step_mm
  std::optional<double> stress_fibre_angle_deg;      // SkinStrain::angle_deg
  double compressed_mm2 = 0;                         // SkinStrain
  double excised_mm2 = 0;                            // skin taken away, at rest
  std::optional<double>
      waste_mm2;  // of it, outside the first excision's outline: healthy skin given up for the closure
  std::vector<PredictedPoint> predicted;
  std::vector<NamedLandmark> landmarks;
  double landmark_max_mm = 0;
  Perfusion perfused;

  std::optional<double> elongation;  // Z-plasty
  std::optional<Elongations> elongations;
  std::optional<double> flap_area_mm2;  // present area of the skin of the flap (find_flap)
};

struct RestVolumes {
  int pieces = 0;
  double volume_mm3 = 0, removed_mm3 = 0, initial_mm3 = 0;
};

/// `support_force_mN` and `load_force_mN` as ElasticSolver gives them: what the held nodes receive; weight and loads.
ForceBalance force_balance(std::span<const HookState> hooks, std::span<const SutureState> sutures,
                           const Vec3& support_force_mN, const Vec3& load_force_mN = Vec3::Zero());

/// A stitch that pulls with less holds nothing: the weight of a tenth of a gram, about that of its own thread.
inline constexpr double kHolds_N = 1e-3;

/// What is measured beside the tissue itself.
struct MeasureAlso {
  std::optional<PlannedProcedure> plan = {};
  std::vector<Landmark> landmarks = {};
  std::optional<double> closure_energy_uJ = {};
  std::vector<int> one_bank = {};          // SoftTissue::stitches_in_one_bank
  Vec3 collider_force_mN = Vec3::Zero();   // SoftTissue::collider_force_mN
  Vec3 soft_hold_force_mN = Vec3::Zero();  // SoftTissue::soft_hold_force_mN
};

/// `script`: what was done, for figures that belong to a
/// kind of flap; may be empty. The snapshot's topology must
/// be set. About 0.3 s on a block of 60,000 triangles.
Metrics measure(const Snapshot& snapshot, const Skin& skin, const ElasticSolver& solver, const RestVolumes& volumes,
                std::span<const Command> script = {}, const MeasureAlso& also = {});

}  // namespace limberg
