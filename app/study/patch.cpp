#include "app/study/patch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/assembly/operation.h"
#include "app/result/metrics.h"
#include "app/study/planar_law.h"
#include "app/study/wound.h"
#include "sim/commands/procedures/operation.h"
#include "sim/patient/soft_tissue.h"

namespace limberg::study {

namespace {

constexpr double kBlock_mm = 10, kSkin_mm = 1.5, kSkinCell_mm = 1.2;

std::shared_ptr<Body> body_of(const Patch& p) {
  BlockSpec b;
  b.name = "patch";
  b.tension_direction = {0, 1, 0};
  b.skin_cell_mm = kSkinCell_mm;
  if (p.support == Support::fat) {
    b.size_mm = {p.side_mm, p.side_mm, kBlock_mm};
    b.layers = skin_on_fat(kBlock_mm, p.prestretch_percent);
    return std::make_shared<Body>(make_block(b));
  }
  const bool plane = p.support == Support::plane;
  const std::vector<Layer> skin = skin_on_fat(kBlock_mm, p.prestretch_percent);
  // A membrane's thickness says nothing; one cell.
  b.size_mm = {p.side_mm, p.side_mm, plane ? p.cell_mm : kSkin_mm};
  b.layers = {skin[0]};
  if (plane) b.layers[0].material = membrane_material(skin[0].material.mu_kPa(), 1 + p.prestretch_percent / 100);
  auto body = std::make_shared<Body>(make_block(b));
  if (plane) body->laws = laws_with_membrane();
  for (size_t t = 0; t < body->surface.tri.size(); ++t) {  // no bed
    double top = -1e300;
    for (const int32_t v : body->surface.tri[t]) top = std::max(top, body->surface.X_mm[size_t(v)].z());
    if (body->surface.tag[t] == SurfaceTag::fixed && top < -b.size_mm.z() + 1e-6)
      body->surface.tag[t] = SurfaceTag::free;
  }
  return body;
}

OperationPlan plan_of(const Patch& p) {
  OperationPlan plan;
  plan.undermine_margin_mm = p.undermine_mm;
  plan.spacing_mm = p.spacing_mm, plan.inset_mm = p.inset_mm, plan.corner_mm = p.corner_mm;
  plan.depth_mm = p.depth_mm;
  if (p.support == Support::fat) return plan;
  plan.undermine_margin_mm = 0;
  plan.depth_mm = (p.support == Support::plane ? p.cell_mm : kSkin_mm) + 1;  // through
  if (p.support == Support::plane) plan.lift_mm = 0;
  return plan;
}

Script script_of(const std::vector<Command>& commands, const char* name) {
  Script s;
  s.name = name;
  for (const Command& c : commands) s.lines.push_back({int(s.lines.size()) + 1, c});
  return s;
}

/// Hooks near the places that may stand up, moved by the heights given, and let go.
std::vector<Command> pushes(const std::vector<Vec2>& at, const std::vector<double>& height_mm) {
  std::vector<Command> out;
  for (size_t i = 0; i < at.size(); ++i) out.push_back(SetHook{int(i) + 1, at[i]});
  for (size_t i = 0; i < at.size(); ++i) out.push_back(MoveHook{int(i) + 1, {at[i].x(), at[i].y(), height_mm[i]}, 1});
  for (size_t i = 0; i < at.size(); ++i) out.push_back(ReleaseHook{int(i) + 1});
  return out;
}

/// All that is held goes outward from the chart's origin, in steps of at most step_mm, until it is `stretch` times as
/// far away; the tissue comes to rest; and back again.
void draw_taut_and_let_go(World& world, double stretch, double step_mm, const OperationSettings& set) {
  const Body& body = *world.skin()->spec().body;
  const double farthest = 0.5 * (body.box_max_mm - body.box_min_mm).head<2>().norm();
  const int n = std::max(1, int(std::ceil((stretch - 1) * farthest / step_mm)));
  StepSettings s;
  s.max_iterations = set.iterations, s.tolerance = set.rest_residual;
  for (int way = 1; way <= 2 * n; ++way) {
    const double now = 1 + (stretch - 1) * (way <= n ? way : 2 * n - way) / n;
    world.hold_at([&](const Vec3& X) {
      const Vec3 d = X - body.chart_origin_mm;
      return Vec3(X + (now - 1) * (d - d.dot(body.chart_normal()) * body.chart_normal()));
    });
    // Taut, it has to be at rest; on the way it need not.
    for (int i = 0; i < (way == n ? set.rest_steps : 1); ++i) {
      if (set.interrupted && set.interrupted()) return;
      if (world.step(s).residual <= s.tolerance && world.settled()) break;
    }
  }
}

}  // namespace

double Done::height_mm(const Vec2& p, double radius) const { return shape(p, radius).height_mm; }

double Done::middle_height_mm(const Vec2& p, double radius, double even) const {
  double most = 0;
  const double step = even / 2;
  for (double y = -radius; y <= radius; y += step)
    for (double x = -radius; x <= radius; x += step) {
      const Vec2 q(x, y);
      if (q.norm() > radius) continue;
      const auto above = map->mean_height_mm(p + q, even), below = under->mean_height_mm(p + q, even);
      if (above && below) most = std::max(most, 0.5 * (*above + *below));
    }
  return most;
}

DogEar Done::shape(const Vec2& p, double radius) const {
  const Vec3 at = skin->body().chart_origin_mm + p.x() * skin->body().chart_e1 + p.y() * skin->body().chart_e2;
  return dog_ear(shown->topology->view, shown->x_mm, *skin, std::array<Vec3, 1>{at}, radius);
}

Done carry_out_on(const Patch& patch, const Figure& figure, const Run& with) {
  WorldSpec spec;
  spec.body = body_of(patch);
  spec.cell_mm = std::min(patch.cell_mm, spec.body->box_max_mm.z() - spec.body->box_min_mm.z());
  spec.suture_bite_mm = std::min(patch.bite_mm, 0.5 * patch.spacing_mm);
  spec.region_mm = patch.region_mm;
  spec.refine_fronts = patch.support == Support::fat && patch.fronts;
  spec.contact = patch.contact ? ContactChoice::automatic : ContactChoice::off;
  Done done;
  done.skin = std::make_shared<Skin>(spec.body);
  World world(spec, with.workers);

  const double depth = spec.body->box_max_mm.z() - spec.body->box_min_mm.z() + 2;
  done.commands = carry_out(figure, OnSkin(*done.skin, {}), plan_of(patch));
  const std::vector<Command>& commands = done.commands;
  const auto closing = std::find_if(commands.cbegin(), commands.cend(), [](const Command& c) {
    return std::holds_alternative<SetHook>(c) || std::holds_alternative<Suture>(c) ||
           std::holds_alternative<SutureRow>(c);
  });
  OperationSettings set;
  set.interrupted = with.interrupted;
  set.hook_step_mm = 3, set.rest_residual = 1e-4;  // on the way; at the end as in operate
  const OperationOutcome open = operate(world, depth, script_of({commands.cbegin(), closing}, "study"), set);
  {
    Snapshot s;
    world.fill(s);
    if (const auto limb = find_central_limb(commands))
      done.open_elongation = elongation(s.topology->view, s.x_mm, *done.skin, *limb).value_or(0);
  }
  OperationOutcome o = operate(world, depth, script_of({closing, commands.cend()}, "study"), set);
  done.solve_ms = open.solve_ms + o.solve_ms;

  const auto take = [&] {
    world.fill(*done.shown, true);
    done.metrics = measure_world(world, commands);
    done.residual = o.last.residual, done.energy_uJ = o.last.energy_uJ;
  };
  take();
  done.energy_as_closed_uJ = done.energy_uJ;

  // Other equilibria. Each search starts where the last one ended: what is bistable stays where it was put. The heights
  // differ a little from place to place, so that symmetric saddles are left.
  std::vector<double> energies{done.energy_uJ};
  const auto judge = [&](int how) {
    const double e = o.last.energy_uJ;
    // Two states are different when their energies differ by more than what a residual of 1e-5 leaves open.
    if (std::all_of(energies.begin(), energies.end(),
                    [&](double x) { return std::abs(x - e) > 1e-3 * std::abs(x - open.last.energy_uJ); }))
      energies.push_back(e);
    if (e < done.energy_uJ) take(), done.found_by = how;
  };
  const auto stopped = [&] { return with.interrupted && with.interrupted(); };
  if (patch.push_mm > 0 && patch.taut_percent > patch.prestretch_percent && !stopped()) {
    draw_taut_and_let_go(world, (1 + patch.taut_percent / 100) / (1 + patch.prestretch_percent / 100),
                         0.5 * patch.cell_mm, set);
    o = operate(world, depth, script_of({}, "study's rest"), set);
    done.solve_ms += o.solve_ms;
    judge(1);
  }
  if (patch.push_mm > 0 && !patch.ears.empty()) {
    for (const int how : {2, 3}) {
      if (stopped()) break;
      std::vector<double> height;
      for (size_t i = 0; i < patch.ears.size(); ++i)
        height.push_back((how == 2 ? 1 : -1) * patch.push_mm * (1 + 0.1 * double(i)));
      o = operate(world, depth, script_of(pushes(patch.ears, height), "study's push"), set);
      done.solve_ms += o.solve_ms;
      judge(how);
    }
  }
  done.equilibria = int(energies.size());
  done.closing_uJ = done.energy_uJ - open.last.energy_uJ;
  done.map = std::make_shared<SkinMap>(*done.shown);
  done.under = std::make_shared<SkinMap>(*done.shown, SkinMap::Side::under);
  done.nodes = world.skin()->solver().model().X_mm.size();
  return done;
}

void add_common(Row& r, const Done& d) {
  r.figures.insert(r.figures.end(), {{"closure_force_N", d.metrics.closure_force_N},
                                     {"suture_force_max_N", d.metrics.suture_force_max_N},
                                     {"gap_max_mm", d.metrics.suture_gap_max_mm},
                                     {"stretch_p99", d.metrics.stretch_p99},
                                     {"overlap_p99_mm", d.metrics.penetration.p99_mm},
                                     {"residual", d.residual},
                                     {"nodes", double(d.nodes)},
                                     {"solve_ms", d.solve_ms}});
  r.shown = d.shown;
}

std::vector<std::vector<const Row*>> groups(const std::vector<Row>& rows, const std::string& key,
                                            const std::vector<std::string>& parameters) {
  std::vector<std::vector<const Row*>> out;
  for (const Row& r : rows) {
    auto same = [&](const std::vector<const Row*>& g) {
      return std::all_of(parameters.begin(), parameters.end(), [&](const std::string& p) {
        return p == key || g[0]->at(p) == r.at(p) || (std::isnan(g[0]->at(p)) && std::isnan(r.at(p)));
      });
    };
    auto it = std::find_if(out.begin(), out.end(), same);
    if (it == out.end()) it = out.emplace(it);
    it->push_back(&r);
  }
  for (auto& g : out)
    std::sort(g.begin(), g.end(), [&](const Row* a, const Row* b) { return a->at(key) < b->at(key); });
  return out;
}

NamedChart chart(const std::string& name, const std::string& title, const std::vector<Row>& rows, const std::string& x,
                 const std::string& x_title, const std::string& y, const std::string& y_title,
                 const std::vector<std::string>& parameters) {
  NamedChart c;
  c.name = name, c.title = title;
  c.chart.description = title + ", one line for each setting";
  c.chart.x.title = x_title, c.chart.y.title = y_title;
  for (const auto& g : groups(rows, x, parameters)) {
    ChartSeries s;
    s.markers = true;
    for (const std::string& p : parameters) {
      if (p == x || std::all_of(rows.begin(), rows.end(), [&](const Row& r) { return r.at(p) == rows[0].at(p); }))
        continue;
      const std::string t = fmt::format("{}{} {:g}", s.name.empty() ? "" : ", ", p, g[0]->at(p));
      s.name += t;
    }
    for (const Row* r : g) s.x.push_back(r->at(x)), s.y.push_back(r->at(y));
    c.chart.series.push_back(std::move(s));
  }
  return c;
}

}  // namespace limberg::study
