#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/study/flaps.h"
#include "app/study/patch.h"
#include "app/words/words.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/geometry/vec.h"

namespace limberg::study {

namespace {

// ---- Fusiform excisions

const std::vector<std::string> kFusiform{"ratio",    "prestretch", "cell_mm",   "contact",
                                         "width_mm", "depth_mm",   "spacing_mm"};

Row run_fusiform(const Values& v, const Run& with) {
  const double W = v[4];
  const Figure f = find_procedure("fusiform").figure({W, v[0]});
  Patch patch;
  // An odd number of cells: where half the length is a whole number of them, as by
  // default, both tips lie in the middle of a cell. A tip on the border between two cells
  // opens to its very end, one inside a cell does not, and stands up less by 0.1 mm.
  patch.side_mm = v[2] * (2 * std::floor(std::max(120.0, W * v[0] + 60) / (2 * v[2])) + 1),
  patch.prestretch_percent = v[1], patch.cell_mm = v[2], patch.undermine_mm = 10, patch.contact = v[3] > 0;
  patch.depth_mm = v[5], patch.push_mm = v[6], patch.spacing_mm = v[7];
  for (const double side : {-1, 1}) patch.ears.push_back({side * (W * v[0] / 2 + 2), 0});  // just beyond the tips
  const Done d = carry_out_on(patch, f, with);
  const Seam& s = f.seams[0];
  const double left = d.height_mm(place(f, s.a_from), W / 2), right = d.height_mm(place(f, s.a_to), W / 2);
  double drawn = 0;  // vertex angle: the larger tip's charge
  for (const Charge& c : charges(f)) drawn = std::max(drawn, c.q_deg);
  const double L = W * v[0], vertex = 4 * std::atan(1 / v[0]), R = (L * L + W * W) / (4 * W);
  // The scar as it lies now: along a bank, a little inside its skin.
  const std::vector<Vec2> edge = bank(f, s.a_from, s.a_to, true);
  std::vector<Vec3> scar;
  constexpr int kParts = 100;
  for (int i = 1; i < kParts; ++i)
    if (const auto x = d.map->now_mm(beside(edge, path_length(edge) * i / kParts, 0.05))) scar.push_back(*x);
  // The ends' pieces like the others.
  const double scar_now = path_length(scar) * kParts / std::max(1.0, double(scar.size()) - 1);
  Row r;
  r.figures = {{"ratio", v[0]},
               {"prestretch", v[1]},
               {"cell_mm", v[2]},
               {"contact", v[3]},
               {"width_mm", W},
               {"depth_mm", v[5]},
               {"push_mm", v[6]},
               {"spacing_mm", v[7]},
               {"vertex_deg", drawn},
               {"vertex_form_deg", vertex * kDeg},
               {"scar_mm", path_length(bank(f, s.a_from, s.a_to, true))},
               {"scar_form_mm", R * vertex},
               {"scar_now_mm", scar_now},
               {"ear_mm", std::max(left, right)},
               {"ear_middle_mm", std::max(d.middle_height_mm(place(f, s.a_from), W / 2, 2.5),
                                          d.middle_height_mm(place(f, s.a_to), W / 2, 2.5))},
               {"ear_volume_mm3", d.shape(place(f, s.a_from), W).volume_mm3 + d.shape(place(f, s.a_to), W).volume_mm3},
               {"found_by", double(d.found_by)}};
  add_common(r, d);
  const std::string name = fmt::format("{:g} to 1, {:g} %, {:g} mm", v[0], v[1], v[2]);
  r.title = name;
  return r;
}

std::vector<Bar> bars_fusiform(const std::vector<Row>& rows) {
  double residual = 0, gap = 0, scar = 0, fall = 1e300, vertex = 0, now = 0, apart = 1e300;
  for (const Row& r : rows) {
    residual = std::max(residual, r.at("residual")), gap = std::max(gap, r.at("gap_max_mm"));
    apart = std::min(apart, r.at("spacing_mm") / r.at("cell_mm"));
    scar = std::max(scar, std::abs(r.at("scar_mm") / r.at("scar_form_mm") - 1));
    // The tip of a polygon of 12 chords on each arc is a twelfth narrower than that of the arcs.
    vertex = std::max(vertex, std::abs(r.at("vertex_deg") / (r.at("vertex_form_deg") * 11 / 12) - 1));
    now = std::max(now, std::abs(r.at("scar_now_mm") / r.at("scar_form_mm") - 1));
  }
  for (const auto& g : groups(rows, "ratio", kFusiform))
    for (size_t i = 1; i < g.size(); ++i) fall = std::min(fall, g[i - 1]->at("ear_mm") - g[i]->at("ear_mm"));
  std::vector<Bar> out{
      at_most(english("largest relative residual"), residual, 1e-4, english("at rest, as in operate")),
      at_most(english("largest gap, mm"), gap, 0.2, english("closed")),
      // Displacements run straight through a cell. A bent edge that is held at more
      // places than there are cells cannot lie on the other one everywhere: some stitches
      // pull, those between them push, and what they add up to is no closing force.
      at_least("stitches' spacing over the size of the cells", apart, 1,
               "measured, 4 to 1: 2.5 to 2.6 N in all from 4 to 6 mm in cells of 4 and 5 mm and at 3 mm in cells of 3 "
               "mm; 6.3 and 13 N at 3 mm in cells of 4 and 5 mm"),
      at_most("scar length against the closed form, relative", scar, 0.003,
              "chords of 12 equal pieces of an arc of at most 106 degrees"),
      at_most("vertex angle against the closed form, relative", vertex, 0.003,
              "4 atan(width / length), less what 12 chords of each arc cut off"),
      at_most("length of the closed scar against the closed form, relative", now, 0.1,
              "skin stretches by the prestretch at most along a scar that it was drawn along")};
  if (fall < 1e300)
    out.push_back(at_least("least fall of the dog-ear with the ratio, mm", fall, 0, "narrower tips stand up less"));
  return out;
}

std::vector<NamedChart> charts_fusiform(const std::vector<Row>& rows) {
  return {chart("dog-ear", english("Height of the dog-ears"), rows, "ratio", english("length over width"), "ear_mm",
                english("height, mm"), kFusiform),
          chart("force", english("Sum of the stitches' forces"), rows, "ratio", english("length over width"),
                "closure_force_N", english("force, N"), kFusiform)};
}

}  // namespace

Family fusiform() {
  return {"fusiform",
          english("Spindle-shaped excisions by their ratio of length to width"),
          {{"ratio", "length over width", {2, 3, 4, 5, 6}, 1.5, 8},
           {"prestretch", "of the skin, percent, in all directions", {5}, 0, 30},
           {"cell_mm", "size of the lattice's cells", {4}, 2, 8},
           {"contact", "1: wound surfaces keep each other out", {1}, 0, 1},
           {"width_mm", "of the excision", {16}, 6, 40},
           {"depth_mm", "of cut and undermining", {4}, 1.5, 8},
           {"push_mm", "height of the pushes that look for other equilibria; 0: none", {2}, 0, 10},
           {"spacing_mm", "of the stitches; nearer than cells are large they pull against each other", {4}, 1, 12}},
          run_fusiform,
          bars_fusiform,
          charts_fusiform};
}

}  // namespace limberg::study
