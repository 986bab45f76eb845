#include "sim/measure/table.h"

#include <algorithm>

namespace limberg {
namespace {

#define LIMBERG_OF(figure) [](const Metrics& m) -> std::optional<double> { return figure; }

constexpr Across kFigure = Across::figure, kLength = Across::length;

const Measure kTable[] = {
    // What there is
    {"pieces",
     "",
     "pieces of tissue",
     "connected pieces of the lattice",
     "exact",
     LIMBERG_OF(m.pieces),
     Across::none,
     {},
     true},
    {"volume_mm3", "mm³", "volume", "of all pieces, at rest", "rounding", LIMBERG_OF(m.volume_mm3)},
    {"removed_volume_mm3", "mm³", "volume taken out", "of what was excised, at rest", "rounding",
     LIMBERG_OF(m.removed_volume_mm3)},
    {"initial_volume_mm3", "mm³", "volume before", "of the body before the first cut", "rounding",
     LIMBERG_OF(m.initial_volume_mm3)},
    {"volume_change", "", "change of volume by the cutter", "(volume + removed - initial) / initial, at rest",
     "rounding: the cutter is exact", LIMBERG_OF(m.volume_change)},
    {"compression", "", "compression", "present volume of the material over its volume at rest, less 1", "--cells",
     LIMBERG_OF(m.compression), kFigure},

    // Stitches
    {"sutures[].force_N", "N", "force of a stitch",
     "force of a stitch; of a thread's stitch its tension, or less where the edges press on each other",
     "residual: off by at most the relative residual times the largest force; lattice: --cells"},
    {"sutures[].tied_N", "N", "force when tied",
     "force of a stitch in the first state at rest (residual 1e-3, all threads tight) after it was tied",
     "as force_N; what happens between states at rest is not counted"},
    {"sutures[].peak_N", "N", "largest force so far", "the largest force of a stitch in all such states",
     "as force_N; what happens between states at rest is not counted"},
    {"sutures[].gap_mm", "mm", "gap of a stitch", "distance between the two bites", "k = 20 N/mm: 0.05 mm for each N"},
    {"closure_force_N", "N", "closure force", "sum of all stitches' forces", "--cells", LIMBERG_OF(m.closure_force_N),
     kFigure, kClosureForce_N},
    {"suture_force_max_N", "N", "largest suture force", "the largest of the stitches' forces", "as force_N",
     LIMBERG_OF(m.suture_force_max_N), kFigure, kSutureForce_N},
    {"suture_force_max_id",
     "",
     "stitch with the largest force",
     "its number; 0: there is no stitch",
     "exact",
     LIMBERG_OF(m.suture_force_max_id),
     Across::none,
     {},
     true},
    {"suture_gap_max_mm", "mm", "largest gap of a stitch", "the largest distance between the two bites of a stitch",
     "as gap_mm", LIMBERG_OF(m.suture_gap_max_mm), kLength, kSutureGap_mm},
    {"suture_force_peak_N", "N", "largest suture force so far", "the largest of the stitches' peak forces", "as peak_N",
     LIMBERG_OF(m.suture_force_peak_N), Across::none, kSutureForce_N},
    {"sutures_over_2_5_N",
     "",
     "stitches above 2.5 N",
     "stitches above 2.5 N (Larrabee 1984: necrosis rises)",
     "as force_N",
     LIMBERG_OF(m.sutures_over_2_5_N),
     Across::none,
     {},
     true},
    {"sutures_over_5_N",
     "",
     "stitches above 5 N",
     "stitches above 5 N (between USP 5-0 and 4-0 knots)",
     "as force_N",
     LIMBERG_OF(m.sutures_over_5_N),
     Across::none,
     {},
     true},
    {"closure_line_N_per_m", "N/m", "closure force along the scar", "closure_force_N over scar_length_mm", "--cells",
     LIMBERG_OF(m.closure_line_N_per_m)},
    {"closure_energy_mJ", "mJ", "energy of the closure",
     "elastic energy, threads included, above that of the open wound at rest that neither hook nor stitch holds",
     "single precision: 1e-6 of the whole energy; cuts made after the closure began are in it",
     LIMBERG_OF(m.closure_energy_mJ)},

    // The wound
    {"wound_gape_mm", "mm", "wound gape", "distance across the wound from its rim; 95 % of the rim gape less",
     "own rim within 3 mm is not looked at", LIMBERG_OF(m.wound_gape_mm), kLength},
    {"wound_gape_mean_mm", "mm", "wound gape, mean", "mean distance across the wound from its rim", "as wound_gape_mm",
     LIMBERG_OF(m.wound_gape_mean_mm)},
    {"step_off_mm", "mm", "step-off",
     "part of that way that runs along the skin's normal: one edge higher than the other; 95 % of the rim less",
     "as wound_gape_mm", LIMBERG_OF(m.step_off_mm)},
    {"step_off_mean_mm", "mm", "step-off, mean", "mean of the same", "as wound_gape_mm",
     LIMBERG_OF(m.step_off_mean_mm)},
    {"scar_length_mm", "mm", "scar length", "half of the present length of all edges between skin and wound",
     "an end that is not sewn counts in full", LIMBERG_OF(m.scar_length_mm)},
    {"penetration_p99_mm", "mm", "overlap, 99th percentile", "tissue in tissue at wounds; 99 % of the places less",
     "read too small at the edge of a part", LIMBERG_OF(m.penetration.p99_mm)},
    {"penetration_max_mm", "mm", "deepest overlap", "tissue in tissue at wounds",
     "read too small at the edge of a part", LIMBERG_OF(m.penetration.max_mm)},
    {"penetration_area_mm2", "mm²", "overlapping area", "wound surface that lies in other tissue",
     "as penetration_max_mm", LIMBERG_OF(m.penetration.overlapping_mm2)},
    {"contact_force_N", "N", "contact force", "sum of the forces with which wound surfaces press on each other",
     "as force_N", LIMBERG_OF(m.contact_force_N)},

    // The skin
    {"stretch_p99", "", "stretch, 99th percentile",
     "largest principal stretch of skin triangles, prestretch included; percentile by rest area", "--cells",
     LIMBERG_OF(m.stretch_p99), kFigure},
    {"stretch_max", "", "largest stretch", "largest principal stretch of skin triangles, prestretch included",
     "sits at the ends of cuts and grows as cells shrink", LIMBERG_OF(m.stretch_max)},
    {"stress_p95_kPa", "kPa", "stress, 95th percentile",
     "largest principal Cauchy stress in the skin's plane, free surface; percentile by rest area", "--cells",
     LIMBERG_OF(m.stress_p95_kPa), kFigure},
    {"stress_max_kPa", "kPa", "largest stress", "largest principal Cauchy stress in the skin's plane, free surface",
     "grows as cells shrink", LIMBERG_OF(m.stress_max_kPa)},
    {"stress_fibre_angle_deg", "degrees", "stress across the tension lines",
     "between the greatest stress and the fibres (tension lines), both as they lie now; mean over the 5 % of the skin "
     "with the greatest stress",
     "undefined where the two stresses differ by less than 2 %", LIMBERG_OF(m.stress_fibre_angle_deg)},
    {"compressed_mm2", "mm²", "compressed skin",
     "rest area of skin whose least principal stress is below 0: it would wrinkle", "--cells",
     LIMBERG_OF(m.compressed_mm2)},
    {"dog_ear_mm", "mm", "dog-ear height", "highest skin above the original surface within 20 mm of a cut",
     "--cells; a lattice of 3.5 mm cannot bend skin more sharply than a cell", LIMBERG_OF(m.dog_ear_mm), kLength},
    {"dog_ear_volume_mm3", "mm³", "dog-ear volume", "volume above the original surface within 20 mm of a cut",
     "as dog_ear_mm", LIMBERG_OF(m.dog_ear_volume_mm3), kFigure},
    {"flap_area_mm2", "mm²", "flap area", "present skin area inside the flap's outline at rest",
     "triangles counted by their centres: up to half a triangle along the outline", LIMBERG_OF(m.flap_area_mm2),
     kFigure},
    {"excised_mm2", "mm²", "skin excised", "skin taken away, at rest",
     "exact on flat skin; curved skin is sampled at 0.5 mm", LIMBERG_OF(m.excised_mm2)},
    {"waste_mm2", "mm²", "healthy skin excised", "of the skin taken away, what lay outside the first excision",
     "as excised_mm2", LIMBERG_OF(m.waste_mm2)},
    {"elongation", "", "elongation", "Z-plasty: straight distance of the central limb's ends over that at rest",
     "--cells", LIMBERG_OF(m.elongation), kFigure},
    {"elongation_planimetric", "", "elongation, planimetric", "the same laid into the original skin's tangent plane",
     "--cells",
     LIMBERG_OF(m.elongations ? std::optional<double>(m.elongations->planimetric) : std::optional<double>())},
    {"elongation_stereometric", "", "elongation, stereometric",
     "the same over the skin: profile in the upright plane through both ends",
     "chords of skin triangles; folds that lie over one another count once",
     LIMBERG_OF(m.elongations ? std::optional<double>(m.elongations->stereometric) : std::optional<double>())},

    // What the plan foretold, and places
    {"predicted[].charge_deg", "degrees", "charge",
     "360 less the tissue angles that the plan sews together in one point (Limberg; Gauss and Bonnet)", "exact"},
    {"predicted[].height_mm", "mm", "height at the point",
     "highest skin within reach_mm of the point: half the way to the next, 2 to 10 mm", "as dog_ear_mm"},
    {"predicted[].volume_mm3", "mm³", "volume at the point", "volume above the original surface there",
     "as dog_ear_mm"},
    {"predicted[].deficit_deg", "degrees", "angle deficit",
     "360 less the angle that the skin closes round the point now, at 0.8 reach_mm",
     "1 % of stretch towards the point counts as 3.6 degrees"},
    {"landmarks[].displacement_mm", "mm", "displacement of a landmark",
     "of a named place of scene, script or lesson, from its place at rest; along and across the tension lines, up",
     "--cells"},
    {"landmark_max_mm", "mm", "largest displacement of a landmark", "the largest of the landmarks' displacements",
     "--cells", LIMBERG_OF(m.landmarks.empty() ? std::optional<double>() : std::optional<double>(m.landmark_max_mm))},

    // Blood supply
    {"undermined_mm2", "mm²", "undermined skin", "skin at rest with a cut below it", "squares of 0.5 mm",
     LIMBERG_OF(m.perfused.undermined_mm2)},
    {"perfusion_least", "", "least perfusion index",
     "(30 mm - d) / 25 mm, 0 to 1; d: way within the skin to skin that is not undermined (Memarzadeh 2016, pigs)",
     "ways up to 10 % too long; the source gives no spread and none for people", LIMBERG_OF(m.perfused.least)},
    {"perfusion_farthest_mm", "mm", "farthest from supply",
     "the longest way within the skin to skin that is not undermined", "ways up to 10 % too long",
     LIMBERG_OF(m.perfused.farthest_mm)},
    {"perfusion_below_40_mm2", "mm²", "skin with a perfusion index below 0.4",
     "area of skin whose perfusion index is below 0.4", "as perfusion_least", LIMBERG_OF(m.perfused.below_40_mm2)},
    {"perfusion_severed_mm2", "mm²", "severed skin", "undermined skin that no way leads to", "squares of 0.5 mm",
     LIMBERG_OF(m.perfused.severed_mm2)},

    // The solution
    {"min_J", "", "least J", "least det F at the centres of the cells", "one point a cell", LIMBERG_OF(m.min_J)},
    {"inverted_cells",
     "",
     "inverted cells",
     "cells with det F at most 0 at their centres",
     "one point a cell",
     LIMBERG_OF(m.inverted_cells),
     Across::none,
     {},
     true},
};

#undef LIMBERG_OF

}  // namespace

std::span<const Measure> measure_table() { return kTable; }

const Measure* find_measure(std::string_view name) {
  const auto at = std::find_if(std::begin(kTable), std::end(kTable), [&](const Measure& m) { return m.name == name; });
  return at == std::end(kTable) ? nullptr : at;
}

}  // namespace limberg
