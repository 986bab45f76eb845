#include "app/commands/operate_orders.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "app/assembly/exercise.h"
#include "app/assembly/orders.h"
#include "app/assembly/verdict.h"
#include "app/commands/closure_force.h"
#include "app/commands/this_call.h"
#include "app/program/interrupt.h"
#include "app/result/metrics.h"
#include "app/result/progress.h"
#include "app/result/session_result.h"
#include "sim/patient/soft_tissue.h"

namespace limberg {

namespace {

/// One order of closure: what it cost on the way and where it ended.
struct OrderRow {
  std::string name;
  std::vector<ClosureForce> closure;
  double peak_N = 0, peak_sum_N = 0, end_N = 0, end_max_N = 0, energy_uJ = 0, apart_mm = 0, residual = 0;
};

/// orders
struct ResultOrder {
  MaybeText order;
  double suture_force_peak_N, closure_force_peak_N, suture_force_max_N, closure_force_N, energy_uJ, apart_mm, residual;
};
void fields(ResultOrder& x, auto&& f) {
  f("order", x.order), f("suture_force_peak_N", x.suture_force_peak_N);
  f("closure_force_peak_N", x.closure_force_peak_N), f("suture_force_max_N", x.suture_force_max_N);
  f("closure_force_N", x.closure_force_N), f("energy_uJ", x.energy_uJ), f("apart_mm", x.apart_mm);
  f("residual", x.residual);
}

}  // namespace

int compare_orders(const std::vector<std::string>& orders, double cell_mm, const CommonOptions& common,
                   const Scene& scene, const Script& script, const std::shared_ptr<const Body>& body,
                   WorkersPool& workers) {
  std::vector<OrderRow> rows;
  std::vector<Vec3f> first;
  std::vector<Command> actions;
  for (const ScriptLine& l : script.lines) actions.push_back(l.command);
  std::vector<ResultVerdict> verdict;  // of all orders, with its order before each line
  bool at_rest = true, cut_short = false;
  for (const std::string& how : orders) {
    const Script ordered = reordered(script, how);
    WorldSpec spec = world_spec(scene, body);
    if (cell_mm > 0) spec.cell_mm = cell_mm;
    World world(spec, workers);
    OperationSettings set;
    set.interrupted = interrupted;
    Progress progress("order " + how);
    set.progress = [&](size_t done, size_t total) { progress.show(double(done), double(total), "actions"); };
    const OperationOutcome o = operate(world, scene.tools.max_depth_mm, ordered, set);
    progress.clear();
    if (o.interrupted) {
      if (!rows.empty()) {
        say(fmt::format("interrupted in order {}; the {} before it are told and written", how, rows.size()));
        cut_short = true;
        break;
      }
      say("interrupted; nothing was written");
      return kGoalMissed;
    }
    OrderRow r;
    r.name = how, r.closure = o.closure, r.energy_uJ = o.last.energy_uJ, r.residual = o.last.residual;
    at_rest &= o.last.residual <= 1e-4;
    Snapshot end;
    world.fill(end);
    for (const SutureState& s : end.sutures) {
      r.end_N += double(s.force_N), r.end_max_N = std::max(r.end_max_N, double(s.force_N));
      r.peak_N = std::max({r.peak_N, double(s.peak_N), double(s.force_N)});
    }
    for (const ClosureForce& f : o.closure) r.peak_sum_N = std::max(r.peak_sum_N, f.sum_N);
    if (first.empty()) first = end.x_mm;
    if (first.size() == end.x_mm.size())
      for (size_t v = 0; v < first.size(); ++v)
        r.apart_mm = std::max(r.apart_mm, double((first[v] - end.x_mm[v]).norm()));
    rows.push_back(std::move(r));
    const Metrics metrics = measure_world(world, actions, {script.header.plan, scene.landmarks, {}});
    VerdictOf look;
    look.metrics = &metrics, look.body = body.get(), look.cell_mm = spec.cell_mm, look.wound_level = spec.wound_level,
    look.residual = o.last.residual;
    for (ResultVerdict& v : verdict_of(look)) {
      v.what = how + ": " + v.what;
      verdict.push_back(std::move(v));
    }
  }
  Result result("operate", scene.name);
  ResultRun run;
  run.scene_title = scene.name;
  if (cut_short) run.interrupted = true;
  write_fields(result, "", run);
  ResultTable table;
  table.title = "Orders of closure";
  table.about =
      "The same stitches, tied in another order. Forces are those of states at rest; 'apart' is how far the skin lies "
      "at the end, at most, from where the first order left it.";
  table.columns = {"order",
                   "largest force of a stitch ever, N",
                   "largest sum ever, N",
                   "largest at the end, N",
                   "sum at the end, N",
                   "energy, mJ",
                   "apart, mm"};
  std::printf("%-20s %12s %12s %12s %12s %12s %9s\n", "order", "peak N", "peak sum N", "end max N", "end sum N",
              "energy mJ", "apart mm");
  std::vector<std::pair<std::string, const std::vector<ClosureForce>*>> runs;
  for (size_t i = 0; i < rows.size(); ++i) {
    const OrderRow& r = rows[i];
    std::printf("%-20s %12.4f %12.4f %12.4f %12.4f %12.4f %9.3f\n", r.name.c_str(), r.peak_N, r.peak_sum_N, r.end_max_N,
                r.end_N, 1e-3 * r.energy_uJ, r.apart_mm);
    table.rows.push_back({r.name, short_number(r.peak_N), short_number(r.peak_sum_N), short_number(r.end_max_N),
                          short_number(r.end_N), short_number(1e-3 * r.energy_uJ), short_number(r.apart_mm, 3)});
    append(result, "/orders",
           ResultOrder{r.name, r.peak_N, r.peak_sum_N, r.end_max_N, r.end_N, r.energy_uJ, r.apart_mm, r.residual});
    runs.emplace_back(r.name, &rows[i].closure);
  }
  add_chart(result, "Closure force over the operation", closure_chart(runs));
  add_table(result, table);
  write_fields(result, "", made_by(this_call()));
  worst_first(verdict);
  fill_verdict(result, verdict);
  const bool reached = at_rest && !is_bad(verdict) && !cut_short;
  result.set_ok(reached);
  leave_result(result, common);
  print_verdict(verdict);
  return reached ? kDone : kGoalMissed;
}

}  // namespace limberg
