#include <CLI/CLI.hpp>
#include <cstdio>

#include "app/commands/commands.h"

namespace limberg {

namespace {

struct Measure {
  const char *name, *unit, *definition, *error;
};

// Of `metrics` in result.json. Where `operate --cells` is given more than one size the lattice's share of the error is
// estimated for every figure marked so.
constexpr Measure kMeasures[] = {
    {"sutures[].force_N", "N",
     "force of a stitch; of a thread's stitch its tension, or less where the edges press on each other",
     "residual: off by at most the relative residual times the largest force; lattice: --cells"},
    {"sutures[].tied_N, peak_N", "N",
     "the same in the first state at rest (residual 1e-3, all threads tight) after tying, and the largest of all such "
     "states",
     "as force_N; what happens between states at rest is not counted"},
    {"sutures[].gap_mm", "mm", "distance between the two bites", "k = 20 N/mm: 0.05 mm for each N"},
    {"closure_force_N", "N", "sum of all stitches' forces", "--cells"},
    {"closure_line_N_per_m", "N/m", "closure_force_N over scar_length_mm", "--cells"},
    {"closure_energy_mJ", "mJ",
     "elastic energy, threads included, above that of the open wound at rest that neither hook nor stitch holds",
     "single precision: 1e-6 of the whole energy; cuts made after the closure began are in it"},
    {"stretch_max, stretch_p99", "",
     "largest principal stretch of skin triangles, prestretch included; percentile by rest area",
     "--cells; maxima sit at the ends of cuts and grow as cells shrink"},
    {"stress_max_kPa, stress_p95_kPa", "kPa", "largest principal Cauchy stress in the skin's plane, free surface",
     "--cells; maxima grow as cells shrink"},
    {"stress_fibre_angle_deg", "degrees",
     "between the greatest stress and the fibres (tension lines), both as they lie now; mean over the 5 % of the skin "
     "with the greatest stress",
     "undefined where the two stresses differ by less than 2 %"},
    {"compressed_mm2", "mm2", "rest area of skin whose least principal stress is below 0: it would wrinkle", "--cells"},
    {"elongation", "", "Z-plasty: straight distance of the central limb's ends over that at rest", "--cells"},
    {"elongation_planimetric", "", "the same laid into the original skin's tangent plane", "--cells"},
    {"elongation_stereometric", "", "the same over the skin: profile in the upright plane through both ends",
     "chords of skin triangles; folds that lie over one another count once"},
    {"scar_length_mm", "mm", "half of the present length of all edges between skin and wound",
     "an end that is not sewn counts in full"},
    {"wound_gape_mm, wound_gape_mean_mm", "mm", "distance across the wound from its rim; 95 % of the rim gape less",
     "own rim within 3 mm is not looked at"},
    {"step_off_mm, step_off_mean_mm", "mm",
     "part of that way that runs along the skin's normal: one edge higher than the other; 95 % of the rim less",
     "as wound_gape_mm"},
    {"flap_area_mm2", "mm2", "present skin area inside the flap's outline at rest",
     "triangles counted by their centres: up to half a triangle along the outline"},
    {"excised_mm2, waste_mm2", "mm2", "skin taken away, at rest; of it, what lay outside the first excision",
     "exact on flat skin; curved skin is sampled at 0.5 mm"},
    {"dog_ear_mm, dog_ear_volume_mm3", "mm, mm3",
     "highest skin above the original surface within 20 mm of a cut, and the volume above it",
     "--cells; a lattice of 3.5 mm cannot bend skin more sharply than a cell"},
    {"predicted[].charge_deg", "degrees",
     "360 less the tissue angles that the plan sews together in one point (Limberg; Gauss and Bonnet)", "exact"},
    {"predicted[].height_mm, volume_mm3", "mm, mm3",
     "highest skin, and volume above the original surface, within reach_mm of the point: half the way to the next, 2 "
     "to 10 mm",
     "as dog_ear_mm"},
    {"predicted[].deficit_deg", "degrees",
     "360 less the angle that the skin closes round the point now, at 0.8 reach_mm",
     "1 % of stretch towards the point counts as 3.6 degrees"},
    {"landmarks[].displacement_mm", "mm",
     "of a named place of scene, script or lesson, from its place at rest; along and across the tension lines, up",
     "--cells"},
    {"perfusion_least, perfusion_below_40_mm2", "index, mm2",
     "(30 mm - d) / 25 mm, 0 to 1; d: way within the skin to skin that is not undermined; area below 0.4 (Memarzadeh "
     "2016, pigs)",
     "ways up to 10 % too long; the source gives no spread and none for people"},
    {"perfusion_severed_mm2", "mm2", "undermined skin that no way leads to", "squares of 0.5 mm"},
    {"sutures_over_2_5_N, sutures_over_5_N", "",
     "stitches above 2.5 N (Larrabee 1984: necrosis rises) and 5 N (between USP 5-0 and 4-0 knots)", "as force_N"},
    {"penetration_p99_mm, penetration_max_mm", "mm", "tissue in tissue at wounds",
     "read too small at the edge of a part"},
    {"volume_change", "", "(volume + removed - initial) / initial, at rest", "rounding: the cutter is exact"},
};

int measures() {
  for (const Measure& m : kMeasures)
    std::printf("%s%s%s%s\n    %s\n    error: %s\n", m.name, m.unit[0] ? " [" : "", m.unit, m.unit[0] ? "]" : "",
                m.definition, m.error);
  return kDone;
}

}  // namespace

void add_measures(CLI::App& app, Chosen& chosen) {
  CLI::App* c = app.add_subcommand("measures", "Every figure of result.json's metrics: unit, definition, error");
  c->footer("Example: limberg measures");
  c->callback([&chosen] { chosen = [] { return measures(); }; });
}

}  // namespace limberg
