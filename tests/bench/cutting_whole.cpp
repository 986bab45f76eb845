// The whole cut, part by part, as World makes it on the solver thread.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "app/operating_point/cpu_clock.h"
#include "app/session/workers_pool.h"
#include "sim/body/skin.h"
#include "sim/cutting/arrangement/arrangement.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/lattice/embedding.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/lattice/grid_fit.h"
#include "sim/lattice/topology.h"
#include "sim/patient/point_depths.h"
#include "sim/patient/rest_index.h"
#include "tests/bench/cutting.h"
#include "tests/bench/cutting_scene.h"

namespace limberg::bench {

void whole_cut(Result& out, const CuttingSettings& settings, int slab_cells, double cell_mm, int repeats) {
  const auto say = [&](const char* what) {
    if (settings.progress) settings.progress(std::string("whole cut: ") + what);
  };
  say("scene");
  const auto body = std::make_shared<const Body>(wavy_slab(slab_cells));
  const Blade blade = curved_blade(*body, {});
  Arrangement a(body->surface, body->grid);
  a.components();  // as World has asked for them by then
  const LatticeGrid grid = fit_lattice(*body, cell_mm);
  const auto skin = std::make_shared<const Skin>(body);
  const StencilTable stencils(*skin, grid);
  const auto before = build_topology(grid, material_surface(a));
  const auto model_before = assemble_fem(stencils, *before);
  SurfaceView view_before = a.surface_view();
  const auto embedding_before = embed_surface(*before, material_surface(a), view_before);
  const RestIndex index_before(view_before, body->surface.tri.size());
  PointDepths depths_before;
  ViewChange all;
  all.whole = true;
  SharedArray<uint8_t> on_skin_before;
  depths_before.follow(view_before, all, skin, on_skin_before).get();
  InlineWorkers workers;
  const auto solver = make_solver(workers);

  // The same with the machine's workers, as World divides it among them, by the clock on the wall.
  WorkersPool pool(std::max(1, int(std::thread::hardware_concurrency())));
  Times wall;
  say("cuts, by the clock");
  for (int i = 0; i < 3 * repeats; ++i) {
    PointDepths depths = depths_before;
    SharedArray<uint8_t> on_skin = on_skin_before;
    const auto start = std::chrono::steady_clock::now();
    if (const CutResult r = a.cut(blade, 1); !r.ok())
      throw std::runtime_error("bench cutting: a cut was refused: " + r.reason);
    a.sweep_debris(1);
    ViewChange change;
    SurfaceView view;
    Lazy<SharedArray<float>> depth;
    std::unique_ptr<RestIndex> index;
    const auto drawing = pool.submit([&] {
      view = a.surface_view(view_before, before->operations, change);
      index = std::make_unique<RestIndex>(view, index_before, change);
      depth = depths.follow(view, change, skin, on_skin);
    });
    const auto lattice = update_topology(*before, material_surface(a), &pool);
    std::shared_ptr<const FemModel> model;
    const EarlierModel earlier_model{*before, *model_before};
    const auto assembling = pool.submit([&] {
      const MaterialSurface surface = material_surface(a);
      model = assemble_fem(stencils, *lattice, &earlier_model, &surface);
    });
    drawing->wait();
    const auto embedding =
        embed_surface(*lattice, material_surface(a), view, {*before, view_before, embedding_before, change});
    assembling->wait();
    wall.add(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    a.undo();
  }

  constexpr int kParts = 9;
  const char* const name[kParts] = {"arrangement",
                                    "lattice",
                                    "finite elements",
                                    "surface that is drawn",
                                    "its embedding",
                                    "depth of new points: what is needed to find it",
                                    "index for picking",
                                    "solver takes the model (not in the sum)",
                                    "depth of new points, when a picture first asks (not in the sum)"};
  Times part[kParts], sum;
  size_t triangles = 0, cells = 0, nodes = 0;
  int touched = 0;
  say("cuts");
  for (int i = 0; i < repeats; ++i) {
    solver->set_model(model_before, {});
    PointDepths depths = depths_before;  // World remembers those of points that were there
    SharedArray<uint8_t> on_skin = on_skin_before;
    double at = cpu_ms();
    const double start = at;
    int k = 0;
    const auto lap = [&] {
      const double now = cpu_ms();
      part[k++].add(now - at);
      at = now;
    };
    if (const CutResult r = a.cut(blade, 1); !r.ok())
      throw std::runtime_error("bench cutting: a cut was refused: " + r.reason);
    a.sweep_debris(1);
    lap();
    const auto lattice = update_topology(*before, material_surface(a));
    lap();
    const EarlierModel earlier_model{*before, *model_before};
    const MaterialSurface surface = material_surface(a);
    const auto model = assemble_fem(stencils, *lattice, &earlier_model, &surface);
    lap();
    ViewChange change;
    SurfaceView view = a.surface_view(view_before, before->operations, change);
    lap();
    const auto embedding =
        embed_surface(*lattice, material_surface(a), view, {*before, view_before, embedding_before, change});
    lap();
    const Lazy<SharedArray<float>> depth = depths.follow(view, change, skin, on_skin);
    lap();
    const RestIndex index(view, index_before, change);
    lap();
    sum.add(at - start);
    at = cpu_ms();
    solver->set_model(model, lattice->cell_parent);
    lap();
    depths_before.follow(view_before, all, skin, on_skin).get();  // as asked for last
    at = cpu_ms();
    depth.get();
    lap();
    a.undo();
    triangles = view.tri.size(), cells = lattice->cells.size(), nodes = lattice->nodes.size(),
    touched = lattice->touched_cells;
  }
  const std::string label = fmt::format("whole cut, cells of {:g} mm", cell_mm);
  const std::string size =
      fmt::format("{} triangles, {} cell copies, {} nodes, {} cells touched", triangles, cells, nodes, touched);
  const auto add = [&](const std::string& method, const Times& t) {
    std::string how = fmt::format("{}; median of {}, best {:.3f} ms", size, t.ms.size(), t.best());
    Row r;
    r.name = label, r.method = method, r.settings = how, r.time_ms = t.median();
    out.rows.push_back(r);
  };
  for (int k = 0; k < kParts; ++k) add(name[k], part[k]);
  add("sum of the parts: cut to new topology", sum);
  const std::string how = fmt::format("cut to new topology by the clock, {} workers", pool.count());
  add(how, wall);
  if (settings.quick) return;
  out.bars.push_back({"whole cut to new topology at 103 k triangles, 3 mm cells, CPU time on one core (ms)",
                      sum.median(), false, 4, false, sum.median() <= 4, "issue 3: a quarter of a 60 Hz frame"});
  out.bars.push_back({"the same by the clock with all workers, best (ms; means little beside other work)", wall.best(),
                      false, 4, false, wall.best() <= 4, "issue 3: a quarter of a 60 Hz frame"});
}

}  // namespace limberg::bench
