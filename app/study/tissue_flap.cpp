// The shipped rhomboid flap on the shipped patch of skin, by what is not known of the tissue.
//
// Scene rhomboid with other constants in its two layers; the figure lies as in recordings/rhomboid.jsonl. Cells may be
// coarser than the scene's, so that a member takes a tenth of a second; what that changes is a parameter like others.
// A seed moves the figure by a part of a cell: where the lattice's planes lie under a cut is nobody's choice, and how
// much a figure depends on it is the lattice's share of its scatter.
#include <fmt/format.h>

#include <algorithm>
#include <random>

#include "app/assembly/operation.h"
#include "app/assembly/patient_of_scene.h"
#include "app/study/flaps.h"
#include "app/study/patch.h"
#include "app/words/words.h"
#include "sim/base/error.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/commands/procedures/operation.h"
#include "sim/measure/skin_shape.h"
#include "sim/measure/skin_strain.h"

namespace limberg::study {

namespace {

constexpr double kTissueSide_mm = 20, kTissueMargin_mm = 16, kTissueTurn_deg = -30;
constexpr double kAtRestOfTissue = 1e-4;

/// Values in the order of the family's parameters.
struct OfTissue {
  enum : size_t {
    angle,
    skin_kPa,
    prestretch,
    thickness,
    poisson,
    fat_kPa,
    seed,
    cell,
    halvings,
    skin_cell,
    contact,
    quick
  };
};

Scene scene_of_tissue(const Values& v) {
  Scene scene = open_scene("rhomboid");
  std::vector<Layer>& layers = scene.block.layers;
  Material &skin = layers.front().material, &fat = layers.back().material;
  // Across, and in the fat, the same part of the skin's prestretch along as in the scene.
  const double of_scene = skin.prestretch_along - 1, now = v[OfTissue::prestretch] / 100;
  for (Material* m : {&fat, &skin}) {
    m->prestretch_along = 1 + (m->prestretch_along - 1) / of_scene * now;
    m->prestretch_across = 1 + (m->prestretch_across - 1) / of_scene * now;
    m->poisson = v[OfTissue::poisson];
  }
  skin.young_kPa = v[OfTissue::skin_kPa], fat.young_kPa = v[OfTissue::fat_kPa];
  layers.front().thickness_mm = v[OfTissue::thickness];
  layers.back().thickness_mm = scene.block.size_mm.z() - v[OfTissue::thickness];
  scene.block.skin_cell_mm = v[OfTissue::skin_cell];
  scene.cell_mm = v[OfTissue::cell], scene.wound_level = int(v[OfTissue::halvings]);
  if (v[OfTissue::contact] <= 0) scene.contact = ContactChoice::off;
  return scene;
}

/// Up to half a cell to either side; seed 0: none.
ChartPoint shift_of(double seed, double cell_mm) {
  if (seed == 0) return {0, 0};
  std::mt19937 bits{uint32_t(seed)};
  const auto part = [&] { return double(bits()) / 4294967296.0 - 0.5; };
  const double x = part(), y = part();
  return {x * cell_mm, y * cell_mm};
}

/// Figures of the closed flap, as measure() defines them, without those that a study of thousands has no time for.
void add_figures(Row& r, const World& world, const Skin& skin) {
  Snapshot s;
  world.fill(s);
  const SurfaceView& view = s.topology->view;
  double sum = 0, most = 0, gap = 0;
  for (const SutureState& u : s.sutures) {
    sum += double(u.force_N);
    most = std::max(most, double(u.force_N)), gap = std::max(gap, double(u.gap_mm));
  }
  const SkinStrain strain = skin_strain(view, s.x_mm, skin.body());
  r.figures.insert(r.figures.end(),
                   {{"closure_force_N", sum},
                    {"suture_force_max_N", most},
                    {"suture_gap_max_mm", gap},
                    {"wound_gape_mm", wound_gape(view, s.x_mm).gape_mm},
                    {"dog_ear_mm", dog_ear(view, s.x_mm, skin, rim_mm(view), kTissueSide_mm).height_mm},
                    {"stretch_p99", strain.stretch_p99},
                    {"stress_p95_kPa", strain.stress_p95_kPa}});
}

Row run_tissue(const Values& v, const Run& with) {
  const Scene scene = scene_of_tissue(v);
  const std::shared_ptr<const Body> body = build_body(scene);
  const Skin skin(body);
  World world(world_spec(scene, body), with.workers);
  const Figure figure = v[OfTissue::angle] == 60
                            ? find_procedure("rhomboid").figure({kTissueSide_mm, 60})
                            : find_procedure("webster").figure({kTissueSide_mm, v[OfTissue::angle]});
  OperationPlan plan;
  plan.depth_mm = scene.tools.default_depth_mm, plan.spacing_mm = scene.tools.default_spacing_mm;
  plan.undermine_margin_mm = kTissueMargin_mm;
  const Placement where{shift_of(v[OfTissue::seed], scene.cell_mm), kTissueTurn_deg, false};
  Script script;
  script.name = "study";
  for (const Command& c : carry_out(figure, OnSkin(skin, where), plan))
    script.lines.push_back({int(script.lines.size()) + 1, c});
  OperationSettings set;
  set.interrupted = with.interrupted;
  set.rest_residual = 1e-4;  // on the way; at the end as in operate
  if (v[OfTissue::quick] > 0) set.hook_step_mm = 10, set.rest_residual = 1e-2, set.final_residual = 1e-4;
  const OperationOutcome o = operate(world, scene.tools.max_depth_mm, script, set);
  // Drawn from wide ranges, some skins fold or snap and find no rest; their forces are none.
  if (o.last.residual > kAtRestOfTissue && !o.interrupted)
    throw InputError("", 0,
                     fmt::format("does not come to rest: relative residual {:.2g}; expected at most {:g}",
                                 o.last.residual, kAtRestOfTissue));
  Row r;
  const Family family = tissue_flap();
  for (size_t i = 0; i < v.size(); ++i) r.figures.emplace_back(family.parameters[i].name, v[i]);
  add_figures(r, world, skin);
  r.figures.insert(r.figures.end(),
                   {{"residual", o.last.residual}, {"nodes", double(world.skin()->solver().model().X_mm.size())}});
  return r;
}

std::vector<Bar> bars_of_tissue(const std::vector<Row>& rows) {
  double residual = 0, gap = 0;
  for (const Row& r : rows)
    residual = std::max(residual, r.at("residual")), gap = std::max(gap, r.at("suture_gap_max_mm"));
  return {at_most(english("largest relative residual"), residual, kAtRestOfTissue, english("at rest")),
          at_most(english("largest gap of a stitch, mm"), gap, 0.2, english("closed"))};
}

std::vector<NamedChart> charts_of_tissue(const std::vector<Row>& rows) {
  std::vector<std::string> parameters;
  for (const Parameter& p : tissue_flap().parameters) parameters.push_back(p.name);
  return {chart("force", english("Closure force"), rows, "skin_kPa", english("stiffness of the skin, kPa"),
                "closure_force_N", english("force, N"), parameters)};
}

}  // namespace

Family tissue_flap() {
  Family f{
      "tissue",
      english("The shipped rhomboid flap by what is not known of the tissue, and by where the lattice's cells lie"),
      {{"flap_angle", "of the flap's tip, degrees (60: Limberg's; less: Webster's)", {60}, 20, 60},
       {"skin_kPa", "Young's modulus of the skin", {60}, 2, 2000},
       {"prestretch_percent",
        "of the skin along its tension lines; across, and of the fat, in the scene's proportion",
        {10},
        0.1,
        40},
       {"thickness_mm", "of the skin", {1.5}, 0.4, 4},
       {"poisson", "ratio of both layers", {0.45}, 0.3, 0.495},
       {"fat_kPa", "Young's modulus of the fat with its septa", {15}, 0.5, 200},
       {"seed", "of where in a cell of the lattice the figure's origin lies; 0: on the chart's", {0}, 0, 1000000},
       {"cell_mm", "size of the lattice's cells", {5}, 1.5, 12},
       {"halvings", "of the cells at the wound", {2}, 0, 3},
       {"skin_mm", "size of the skin's triangles", {0.8}, 0.6, 4},
       {"contact", "1: wound surfaces keep each other out", {1}, 0, 1},
       {"quick",
        "1: hooks go in steps of 10 mm, nothing settles on the way, at rest to 1e-4; 0: as in operate",
        {0},
        0,
        1}},
      run_tissue,
      bars_of_tissue,
      charts_of_tissue};
  f.outcomes = {"closure_force_N", "suture_force_max_N", "wound_gape_mm",
                "dog_ear_mm",      "stretch_p99",        "stress_p95_kPa"};
  return f;
}

}  // namespace limberg::study
