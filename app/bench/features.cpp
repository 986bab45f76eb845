#include "app/bench/features.h"

#include <malloc.h>

#include <cmath>

#include "app/bench/accuracy_probe.h"
#include "app/bench/cpu_clock.h"
#include "sim/fem/material_points.h"
#include "sim/fem/materials/fibres.h"
#include "sim/fem/materials/isotropic.h"

namespace limberg::bench {
namespace {

double allocated_mb() {
  const auto m = mallinfo2();
  return double(m.uordblks + m.hblkhd) / 1e6;
}

struct Cost {
  double memory_mb = 0, step_ms = 0, step_p95_ms = 0;
  size_t nodes = 0, free_nodes = 0;
  std::string refused;
};

struct Patient {
  WorldSpec spec;
  StepSettings step;
  std::vector<Command> acts;      // before the pull
};

Cost measure(const Patient& p, const Scene& scene) {
  InlineWorkers workers;
  Cost c;
  const double before = allocated_mb();
  WorldSpec spec = p.spec;
  spec.body = build_body(scene);
  auto world = std::make_unique<World>(spec, workers);
  for (const Command& a : p.acts) {
    const Outcome o = world->apply(a);
    if (!o.done && c.refused.empty()) c.refused = o.reason;
    for (int k = 0; k < 3; ++k) world->step(p.step);
  }
  world->apply(SetHook{1, {0, 4}});
  Snapshot shown;
  world->fill(shown);
  const Vec3 at = shown.hooks.empty() ? Vec3::Zero() : Vec3(shown.hooks[0].handle_mm.cast<double>());
  for (int k = 0; k < 5; ++k) world->step(p.step);
  Times frames;
  for (int f = 1; f <= probe_frames; ++f) {
    world->apply(MoveHook{1, at + double(f) / probe_frames * Vec3(0, 6, 6), 0});
    const double start = cpu_ms();
    world->step(p.step);
    frames.add(cpu_ms() - start);
  }
  std::sort(frames.ms.begin(), frames.ms.end());
  c.memory_mb = allocated_mb() - before;
  c.step_ms = frames.median(), c.step_p95_ms = frames.ms[frames.ms.size() * 95 / 100];
  const FemModel& m = world->solver().model();
  c.nodes = m.X_mm.size();
  for (uint8_t f : m.fixed) c.free_nodes += !f;
  return c;
}

void row(Result& out, const std::string& part, const std::string& how, const Cost& c) {
  char text[160];
  std::snprintf(text, sizeof text, "%zu nodes, %zu free, p95 %.2f ms%s", c.nodes, c.free_nodes, c.step_p95_ms, c.refused.empty() ? "" : (", refused: " + c.refused.substr(0, 60)).c_str());
  out.rows.push_back({part, how, text, c.step_ms, false, c.memory_mb, "MB", "the allocator's count; time: one step of 10 iterations", true});
}

}  // namespace

Result features(const Scene& scene, const FeatureSettings& set) {
  Result out;
  const auto say = [&](const char* s) {
    if (set.progress) set.progress(s);
  };
  Patient base;
  base.spec = world_spec(scene, nullptr);
  base.spec.can_cut = true, base.spec.contact = ContactChoice::off, base.spec.refine_fronts = false, base.spec.dynamic = false;
  if (set.quick) base.spec.cell_mm = 2 * scene.cell_mm;
  base.step.max_iterations = 10, base.step.tolerance = 1e-6;
  const double depth = std::min(scene.tools.default_depth_mm, scene.tools.max_depth_mm);
  const Incise incision{{{-20, 0}, {20, 0}}, depth, 90, false};

  say("cutting");
  Patient uncut = base, blunt = base;
  blunt.spec.can_cut = false;
  row(out, "cutting", "off: can_cut = false", measure(blunt, scene));
  const Cost ready = measure(uncut, scene);
  row(out, "cutting", "on, nothing cut", ready);
  Patient cut = base;
  cut.acts = {incision};
  const Cost one = measure(cut, scene);
  row(out, "cutting", "on, one incision of 40 mm", one);

  say("contact");
  Patient touching = cut;
  touching.spec.contact = ContactChoice::automatic;
  Patient idle = uncut;
  idle.spec.contact = ContactChoice::automatic;
  row(out, "contact", "off, one incision", one);
  row(out, "contact", "auto, one incision", measure(touching, scene));
  row(out, "contact", "auto, nothing cut", measure(idle, scene));

  say("fronts");
  Patient fronts = cut;
  fronts.spec.refine_fronts = true;
  row(out, "divided fronts", "off, one incision", one);
  row(out, "divided fronts", "on, one incision", measure(fronts, scene));

  say("drawn incision");
  Patient drawn = base;
  for (int k = 0; k < 4; ++k) drawn.acts.push_back(InciseMore{1, {{-20.0 + 10 * k, 0}, {-10.0 + 10 * k, 0}}, depth, 90, k == 3});
  row(out, "progressive incision", "off: the whole stroke at once", one);
  row(out, "progressive incision", "on: in four pieces", measure(drawn, scene));

  say("undo");
  Patient many = cut;
  for (int k = 1; k <= 8; ++k) many.acts.push_back(Incise{{{-15, 5.0 * k + 3}, {15, 5.0 * k + 3}}, depth, 90, false});
  const Cost nine = measure(many, scene);
  row(out, "undo depth", "1 incision to undo", one);
  row(out, "undo depth", "9 incisions to undo", nine);
  char note[128];
  std::snprintf(note, sizeof note, "undo: %.2f MB for each incision of 30 mm, its wound included", (nine.memory_mb - one.memory_mb) / 8);
  out.notes.push_back(note);

  say("sutures");
  Patient sewn = cut;
  sewn.acts.push_back(SutureRow{{{-18, 1}, {18, 1}}, {{-18, -1}, {18, -1}}, 2});
  row(out, "sutures", "none, one incision", one);
  row(out, "sutures", "19 across the incision", measure(sewn, scene));

  say("dynamics");
  Patient moving = cut;
  moving.spec.dynamic = true, moving.step.dt_s = 1 / scene.steps_per_s;
  row(out, "dynamics", "off: quasi-static", one);
  row(out, "dynamics", "on: one implicit step a frame", measure(moving, scene));

  say("region");
  if (scene.source == Scene::Source::block) {
    Patient region = cut;
    region.spec.region_mm = 40;
    row(out, "region of interest", "off: the whole block", one);
    row(out, "region of interest", "on: 40 mm about the middle, held outside", measure(region, scene));
  }

  say("fibres");
  {  // on plain finite elements: the same cells, with and without fibres in the uppermost ones
    InlineWorkers workers;
    const Probe probe = make_probe(scene, build_body(scene), base.spec.cell_mm, workers);
    auto fibrous = std::make_shared<FemModel>(*probe.model);
    double top = -1e300;
    for (const Vec3& X : fibrous->X_mm) top = std::max(top, X[2]);
    std::vector<uint8_t> upper(fibrous->stencils.size(), 0);
    for (const HexCell& c : fibrous->cells) upper[size_t(c.stencil)] |= fibrous->X_mm[size_t(c.node[7])][2] > top - 1e-6;
    const int32_t law = int32_t(fibrous->laws.size());
    fibrous->laws.push_back(dispersed_fibres({50, 1.5, 0.15}, {{{1, 1, 0}}, {{1, -1, 0}}}));
    for (size_t i = 0; i < upper.size(); ++i)
      if (upper[i])
        for (int q = 0; q < 4; ++q) {
          MaterialPoint p;
          p.at = Vec3(q & 1 ? 0.79 : 0.21, q & 2 ? 0.79 : 0.21, 0.75), p.volume_mm3 = fibrous->stencils[i].volume_mm3 / 8, p.law = law;
          fibrous->stencils[i].points.push_back(p);
        }
    for (const auto& [name, model] : {std::pair<const char*, std::shared_ptr<const FemModel>>{"off", probe.model}, {"on: two families in the uppermost cells", fibrous}}) {
      const double before = allocated_mb();
      const auto solver = make_solver(workers);
      solver->set_model(model, {});
      Spring h = probe.hook;
      Times frames;
      for (int f = 0; f <= probe_frames; ++f) {
        h.target_mm = probe.hook.target_mm + double(f) / probe_frames * probe.pull_mm;
        const double start = cpu_ms();
        solver->set_springs(std::span(&h, 1));
        solver->step(base.step);
        if (f > 0) frames.add(cpu_ms() - start);
      }
      Cost c;
      c.memory_mb = allocated_mb() - before, c.step_ms = frames.median(), c.step_p95_ms = frames.ms.back(), c.nodes = model->X_mm.size();
      for (uint8_t f : model->fixed) c.free_nodes += !f;
      row(out, "fibres (solver alone)", name, c);
    }
  }
  out.notes.push_back("memory: of body, patient and solver together, in rows of fibres of the solver alone");
  return out;
}

}  // namespace limberg::bench
