#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "app/commands/numbers.h"
#include "app/commands/session_command.h"
#include "app/head/build.h"
#include "app/patient/operations.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/tables.h"
#include "app/session/workers_pool.h"
#include "sim/base/error.h"
#include "sim/body/skin.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/commands/procedures/operation.h"
#include "sim/commands/procedures/plan_drawing.h"

namespace limberg {

namespace {

struct ProcedureOptions {
  std::string name, scene = "rhomboid", out, svg;
  std::vector<std::string> settings;
  std::vector<double> at{0, 0};
  Placement placement;
  OperationPlan plan;
  bool replace = false;
};

int list() {
  for (const Procedure& p : procedures()) {
    std::printf("%-13s %s\n", p.name.c_str(), p.about.c_str());
    for (const ProcedureParameter& q : p.parameters)
      std::printf("    %-13s %g (%g to %g): %s\n", q.name.c_str(), q.value, q.lo, q.hi, q.help.c_str());
  }
  std::printf("\non bones, of a scene with a [head]:\n");
  for (const KnownOperation& k : known_operations())
    std::printf("%-15s %s\n    %-13s %g (%g to %g)\n", k.name, k.about, k.parameter, k.usual, k.least, k.most);
  return kDone;
}

/// The value of the one parameter of an operation on bone.
double bone_amount_of(const KnownOperation& k, const std::vector<std::string>& settings) {
  double amount = k.usual;
  for (const std::string& s : settings) {
    const size_t eq = s.find('=');
    size_t used = 0;
    double value = NAN;
    try {
      if (eq != std::string::npos) value = std::stod(s.substr(eq + 1), &used);
    } catch (const std::exception&) {
    }
    if (eq == std::string::npos || s.substr(0, eq) != k.parameter || used != s.size() - eq - 1 ||
        !(value >= k.least && value <= k.most))
      throw InputError("", 0,
                       fmt::format("--set {}: cannot be set; expected {}=VALUE with a value from {:g} to {:g}",
                                   s.substr(0, 60), k.parameter, k.least, k.most));
    amount = value;
  }
  return amount;
}

/// Its script, written from the landmarks and meshes of a scene's head.
int on_bones(const ProcedureOptions& o, const KnownOperation& k) {
  if (!o.svg.empty()) throw InputError(o.svg, 0, "an operation on bone has no plan on the skin; expected no --plan");
  const double amount = bone_amount_of(k, o.settings);
  const Scene scene = open_scene(o.scene);
  if (!scene.head)
    throw InputError(o.scene, 0,
                     std::string("has no [head], which ") + k.name + " is laid on; expected one with bones");
  WorkersPool workers(1);
  HeadParts parts = head_parts(scene, workers);
  OperationGround ground;
  for (bone::NamedMesh& b : parts.bones) ground.bones.emplace_back(b.name, std::move(b.mesh));
  for (const HeadLandmark& l : parts.landmarks) ground.landmarks.push_back({l.name, l.X_mm, 0, l.on_face});
  PlannedOperation p = plan_operation(ground, k.name, amount, workers);
  if (!p.made()) throw InputError(o.scene, 0, fmt::format("{} cannot be laid on this head: {}", k.name, p.why));
  p.script.header.scene = o.scene;
  std::printf("%s\n", p.title.c_str());
  if (!o.out.empty()) {
    write_whole_file(o.out, to_text(p.script));
    std::printf("%zu actions in %s; limberg operate %s %s carries them out\n", p.script.lines.size(), o.out.c_str(),
                o.scene.c_str(), o.out.c_str());
  }
  return kDone;
}

int procedure(ProcedureOptions o) {
  if (o.name.empty()) return list();
  if (!o.svg.empty()) check_writable(o.svg), check_replaces_drawing(o.svg);
  if (!o.out.empty()) {
    check_writable(o.out);
    if (std::error_code ec; !o.replace && std::filesystem::is_regular_file(o.out, ec))
      throw InputError(o.out, 0, "exists already; expected the name of a new file, or --replace");
  }
  for (const KnownOperation& k : known_operations())
    if (o.name == k.name) return on_bones(o, k);
  const Procedure& p = find_procedure(o.name);
  const std::vector<double> values = procedure_values(p, o.settings);
  const Figure figure = p.figure(values);
  const Scene scene = open_scene(o.scene);
  const Skin skin(build_body(scene));
  o.placement.origin = {o.at[0], o.at[1]};
  const OnSkin where(skin, o.placement);
  std::string title = p.name;
  for (size_t i = 0; i < values.size(); ++i) {
    const std::string t = fmt::format(" {}={:g}", p.parameters[i].name, values[i]);
    title += t;
  }
  Script script;
  script.name = o.out;
  script.header = {o.scene, title};
  PlannedProcedure plan{p.name, {}, o.placement.origin, o.placement.turn_deg, o.placement.mirrored};
  for (size_t i = 0; i < values.size(); ++i)
    if (values[i] != p.parameters[i].value) plan.values.emplace_back(p.parameters[i].name, values[i]);
  script.header.plan = plan;
  int line = 1;
  for (Command& c : carry_out(figure, where, o.plan)) script.lines.push_back({++line, std::move(c)});
  std::printf("%s\n", title.c_str());
  for (const Charge& c : charges(figure)) {
    if (std::abs(c.q_deg) < 25) continue;  // spread along a curve
    const ChartPoint at = where.chart(c.meeting.front());
    std::printf("%s of %+.0f degrees where (%.1f, %.1f) comes to lie\n", c.q_deg > 0 ? "dog-ear" : "saddle ", c.q_deg,
                unsigned_zero(at.x()), unsigned_zero(at.y()));
  }
  if (!o.svg.empty()) write_whole_file(o.svg, plan_svg(figure, title));
  if (!o.out.empty()) {
    write_whole_file(o.out, to_text(script));
    std::printf("%zu actions in %s; limberg operate %s %s carries them out\n", script.lines.size(), o.out.c_str(),
                o.scene.c_str(), o.out.c_str());
  }
  return kDone;
}

}  // namespace

void add_procedure(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<ProcedureOptions>();
  CLI::App* c = app.add_subcommand(
      "procedure", "A classical operation laid on any skin or skull: its script, its plan, where it will stand up");
  c->add_option("NAME", o->name, "Which; none: a list with all parameters");
  c->add_option("--scene", o->scene, "Scene file, or the name of a shipped scene (default rhomboid)");
  c->add_option("--set", o->settings, "A parameter")
      ->type_name("NAME=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  c->add_option("--at", o->at, "Where the figure's origin lies on the chart, mm")
      ->type_name("X,Y")
      ->delimiter(',')
      ->expected(2)
      ->check(number_from(-10000, 10000));
  c->add_option("--turn", o->placement.turn_deg, "Turns the figure counter-clockwise, degrees")
      ->check(number_from(-360, 360));
  c->add_flag("--mirror", o->placement.mirrored, "Mirrors it first");
  c->add_option("--depth-mm", o->plan.depth_mm, "Of all cuts (default 4)")->check(number_from(0.01, 200));
  c->add_option("--spacing-mm", o->plan.spacing_mm, "Of stitches (default 4)")->check(number_from(0.1, 1000));
  c->add_option("--buried-mm", o->plan.buried_mm,
                "So deep below the edges a layer of buried stitches is sewn first (default 0: none)")
      ->check(number_from(0, 200));
  c->add_option("--undermine-mm", o->plan.undermine_margin_mm,
                "Undermined so far around the figure (default 12; 0: not)")
      ->check(number_from(0, 1000));
  c->add_option("--out", o->out, "The script to write")->type_name("SCRIPT");
  c->add_option("--plan", o->svg, "The plan as a picture")->type_name("SVG");
  c->add_flag("--replace", o->replace, "Replace SCRIPT if it exists");
  c->footer(
      "Example: limberg procedure bilobed --set diameter_mm=12 --at 0,5 --turn 30 --out bilobed.jsonl --plan "
      "bilobed.svg");
  c->callback([o, &chosen] { chosen = [o] { return procedure(*o); }; });
}

}  // namespace limberg
