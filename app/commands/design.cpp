#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "app/commands/numbers.h"
#include "app/commands/session_command.h"
#include "app/design/design_drawing.h"
#include "app/design/design_search.h"
#include "app/program/interrupt.h"
#include "app/report/report_names.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/schema.h"
#include "app/result/tables.h"
#include "app/session/clock.h"
#include "app/session/workers_pool.h"
#include "sim/base/error.h"
#include "sim/commands/procedures/plan_drawing.h"

namespace limberg {

namespace {

struct DesignOptions {
  std::string scene, defect;
  std::vector<std::string> spare;
  std::optional<double> lines_deg;
  DesignTask task;
  int show = 12;
  CommonOptions common;
};

/// rows: a design with its costs.
struct ResultDesign {
  MaybeText design, procedure;
  double turn_deg;
  bool mirrored;
  MaybeText pass;
  double cell_mm, cost, first_pass_cost, force_cost, dog_ear_cost, landmark_cost, suture_force_max_N, closure_force_N,
      dog_ear_mm, landmark_max_mm, excised_mm2, scar_length_mm, residual;
};
void fields(ResultDesign& x, auto&& f) {
  f("design", x.design), f("procedure", x.procedure), f("turn_deg", x.turn_deg), f("mirrored", x.mirrored);
  f("pass", x.pass), f("cell_mm", x.cell_mm), f("cost", x.cost), f("first_pass_cost", x.first_pass_cost);
  f("force_cost", x.force_cost), f("dog_ear_cost", x.dog_ear_cost), f("landmark_cost", x.landmark_cost);
  f("suture_force_max_N", x.suture_force_max_N), f("closure_force_N", x.closure_force_N);
  f("dog_ear_mm", x.dog_ear_mm), f("landmark_max_mm", x.landmark_max_mm), f("excised_mm2", x.excised_mm2);
  f("scar_length_mm", x.scar_length_mm), f("residual", x.residual);
}

/// dropped: a design that cannot be carried out.
struct ResultDropped {
  MaybeText design, reason;
};
void fields(ResultDropped& x, auto&& f) { f("design", x.design), f("reason", x.reason); }

Landmark parse_landmark(const std::string& text) {
  const size_t equals = text.find('=');
  Landmark l;
  double x = 0, y = 0;
  char more = 0;
  if (equals == std::string::npos || equals == 0 ||
      std::sscanf(text.c_str() + equals + 1, "%lf,%lf%c", &x, &y, &more) != 2 || !(std::abs(x) <= 1e4) ||
      !(std::abs(y) <= 1e4))
    throw InputError("--spare", 0, text.substr(0, 60) + " is no named place; expected NAME=X,Y in mm");
  l.name = text.substr(0, equals), l.at = {x, y};
  return l;
}

/// "rhomboid, side 16.2 mm, turned 270°, mirrored"
std::string spoken_design(const Design& d) {
  std::string s = d.plan.procedure;
  for (const auto& [key, value] : d.plan.values) {
    const size_t unit = key.rfind('_');
    s += fmt::format(", {} {:.3g}", key.substr(0, unit), value);
    if (unit != key.npos) s += key.substr(unit) == "_deg" ? "°" : " " + key.substr(unit + 1);
  }
  s += fmt::format(", turned {:g}°{}", d.plan.turn_deg, d.plan.mirrored ? ", mirrored" : "");
  std::replace(s.begin(), s.end(), '_', ' ');
  return s;
}

int design(DesignOptions o) {
  catch_interrupts();
  o.common.prepare();
  Scene scene = open_scene(o.scene);
  if (o.lines_deg) {
    const double a = *o.lines_deg * std::numbers::pi / 180;
    if (scene.source == Scene::Source::block)
      scene.block.tension_direction = Vec3(std::cos(a), std::sin(a), 0);
    else
      scene.obj.tension_direction =
          std::cos(a) * scene.obj.chart_e1.normalized() + std::sin(a) * scene.obj.chart_e2.normalized();
    scene.tension = {};
  }
  o.task.defect = parse_defect(o.defect);
  for (const std::string& s : o.spare) o.task.spare.push_back(parse_landmark(s));
  o.task.spare.insert(o.task.spare.end(), scene.landmarks.begin(), scene.landmarks.end());
  WorkersPool workers(o.common.worker_count());
  Progress progress("design");
  const int64_t start = RealClock::monotonic_ns();
  const auto told = [&](const SearchProgress& p) {
    std::string t = fmt::format("{} of {} designs{}", p.done, p.total, p.fine ? ", the best on fine cells" : "");
    if (p.share > 0.02) {  // what the first ones took says how long the rest will
      const double left_s = double(RealClock::monotonic_ns() - start) * 1e-9 * (1 / p.share - 1);
      t += left_s < 90 ? fmt::format(", about {:.0f} s left", left_s)
                       : fmt::format(", about {:.1f} min left", left_s / 60);
    }
    progress.note(t);
  };
  const std::vector<Design> found = search_designs(scene, o.task, workers, interrupted, told);
  progress.clear();
  const bool cut_short = interrupted();
  if (cut_short) {
    const auto tried = std::count_if(found.begin(), found.end(), [](const Design& d) { return d.dropped.empty(); });
    say(tried ? fmt::format("interrupted; the {} designs that were tried by then are ranked and written", tried)
              : "interrupted; nothing was written");
    if (!tried) return kGoalMissed;
  }
  Result r("design", scene.name);
  if (cut_short) r.set("/interrupted", true);
  r.set("/defect", o.defect);
  ResultTable table;
  table.title = "Designs, best first";
  table.about =
      "Cost: largest force of a stitch over 2.45 N, plus dog-ear over 4 mm, plus displacement of landmarks over 2 mm. "
      "The best of the first pass were carried out "
      "again on fine cells and are ranked among themselves by what they cost there; those in brackets, without a cost, "
      "are ranked by the first pass, and their figures are of its cells.";
  table.columns = {"design",     "cells, mm",   "cost",         "first pass",      "largest stitch, N",
                   "closure, N", "dog-ear, mm", "landmark, mm", "skin taken, mm2", "scar, mm"};
  std::printf("%5s %-58s %6s %7s %7s %8s %9s %8s %9s %8s %7s\n", "", "design", "cells", "cost", "1st", "stitch N",
              "closure N", "ear mm", "landm. mm", "skin mm2", "scar mm");
  int rank = 0, dropped = 0;
  bool any = false, coarse = false;
  for (const Design& d : found) {
    if (!d.dropped.empty()) {
      ++dropped;
      append(r, "/dropped", ResultDropped{d.name(), d.dropped});
      continue;
    }
    any = true, coarse |= !d.fine;
    ++rank;
    append(r, "/rows",
           ResultDesign{d.name(), d.plan.procedure, d.plan.turn_deg, d.plan.mirrored, d.fine ? "fine" : "first",
                        d.cell_mm, d.cost, d.first_cost, d.force_cost, d.ear_cost, d.landmark_cost, d.force_N,
                        d.closure_N, d.dog_ear_mm, d.landmark_mm, d.waste_mm2, d.scar_mm, d.residual});
    const std::string place = d.fine ? std::to_string(rank) : "(" + std::to_string(rank) + ")",
                      cost = d.fine ? short_number(d.cost, 3) : "-";
    table.rows.push_back({place + " " + spoken_design(d), short_number(d.cell_mm), cost, short_number(d.first_cost, 3),
                          short_number(d.force_N, 3), short_number(d.closure_N, 3), short_number(d.dog_ear_mm, 3),
                          short_number(d.landmark_mm, 3), short_number(d.waste_mm2, 3), short_number(d.scar_mm, 3)});
    if (rank <= o.show)
      std::printf("%5s %-58s %6.3g %7s %7.3f %8.3f %9.3f %8.2f %9.2f %8.0f %7.1f\n", place.c_str(), d.name().c_str(),
                  d.cell_mm, cost.c_str(), d.first_cost, d.force_N, d.closure_N, d.dog_ear_mm, d.landmark_mm,
                  d.waste_mm2, d.scar_mm);
    if (o.common.out_dir.empty() || rank > o.task.refine) continue;
    write_whole_file(o.common.out_dir + "/design-" + std::to_string(rank) + ".svg",
                     plan_svg(d.figure, std::to_string(rank) + ". " + d.name()));
    ScriptHeader header{o.scene, d.name(), o.task.spare, d.plan};
    std::string text = to_json_line(header) + "\n";
    for (const Command& c : d.commands) text += to_json_line(c) + "\n";
    write_whole_file(o.common.out_dir + "/design-" + std::to_string(rank) + ".jsonl", text);
  }
  if (rank > o.show) std::printf("      and %d more\n", rank - o.show);
  if (coarse)
    std::printf(
        "in brackets: ranked by the first pass alone (1st), whose costs do not compare with those of fine cells\n");
  if (any) {
    const std::string why = why_first(found[0], found.size() > 1 && found[1].dropped.empty() ? &found[1] : nullptr);
    r.set("/why", why);
    std::printf("why 1: %s\n", why.c_str());
  }
  if (dropped > 0) {
    std::printf("%d dropped:\n", dropped);
    for (const auto& [reason, count] : dropped_by_reason(found)) std::printf("  %3d  %s\n", count, reason.c_str());
  }
  if (!o.common.out_dir.empty() && any) {
    const std::shared_ptr<const Body> body = build_body(scene);
    const Skin skin(body);
    ChartPoint middle(0, 0);
    for (const ChartPoint& p : o.task.defect) middle += p / double(o.task.defect.size());
    const auto hit = skin.at(middle);
    const Vec3 along = hit ? skin.frame(hit->X_mm).along : body->tension_direction;
    write_whole_file(
        o.common.out_dir + "/" + report_names::ranking,
        ranking_svg(found, o.task,
                    std::atan2(along.dot(body->chart_e2), along.dot(body->chart_e1)) * 180 / std::numbers::pi));
  }
  add_table(r, table);
  r.set_ok(any && !cut_short);
  leave_result(r, o.common);
  if (!any) say("no design covers this defect here");
  return any && !cut_short ? kDone : kGoalMissed;
}

}  // namespace

void add_design(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<DesignOptions>();
  CLI::App* c =
      app.add_subcommand("design", "Rank flaps for a defect by closure force, dog-ear and displacement of landmarks");
  c->add_option("SCENE", o->scene, "Scene file, or the name of a shipped scene")->required();
  c->add_option("--defect", o->defect, "Its outline on the chart, mm: circle:X,Y,DIAMETER or X,Y;X,Y;X,Y;...")
      ->required();
  c->add_option("--spare", o->spare, "A landmark, once each")
      ->type_name("NAME=X,Y")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  c->add_option("--lines", o->lines_deg, "Direction of the tension lines on the chart, degrees (default: the scene's)")
      ->check(number_from(-360, 360));
  c->add_option("--types", o->task.types, "Only these procedures (default: all that can cover a defect)")
      ->delimiter(',');
  c->add_option("--turn-step", o->task.turn_step_deg, "Degrees between orientations (default 60)")
      ->check(number_from(5.0, 180.0));
  c->add_option("--coarse-mm", o->task.coarse_mm, "Cells of the first pass (default 5)")->check(number_from(0.5, 50.0));
  c->add_option("--fine-mm", o->task.fine_mm, "Cells of the second (default: the scene's)")
      ->check(number_from(0.5, 50.0));
  c->add_option("--refine", o->task.refine, "How many are carried out again on fine cells and drawn (default 3)")
      ->check(whole_from(0, 100));
  c->add_option("--weight-force", o->task.weight_force, "Of the largest stitch over 2.45 N (default 1)")
      ->check(number_from(0.0, 100.0));
  c->add_option("--weight-ear", o->task.weight_ear, "Of the dog-ear over 4 mm (default 1)")
      ->check(number_from(0.0, 100.0));
  c->add_option("--weight-landmark", o->task.weight_landmark, "Of the landmarks' displacement over 2 mm (default 1)")
      ->check(number_from(0.0, 100.0));
  c->add_option("--undermine-mm", o->task.plan.undermine_margin_mm, "Undermined so far around each figure (default 12)")
      ->check(number_from(0, 1000));
  o->common.add_out(*c), o->common.add_words(*c), o->common.add_json(*c), o->common.add_workers(*c);
  c->footer(
      "Leaves ranking.svg, and design-N.svg and design-N.jsonl of the best, in DIR.\n"
      "Example: limberg design rhomboid --defect circle:0,0,14 --spare lid=0,22 --out out/design");
  c->callback([o, &chosen] { chosen = [o] { return design(*o); }; });
}

}  // namespace limberg
