// Where an iteration's time goes, and what of it no program could save: bytes and arithmetic of each part, counted from
// its formulas, over what this machine streams and multiplies in the same run.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <vector>

#include "app/operating_point/cpu_clock.h"
#include "sim/fem/elements/element_system.h"
#include "sim/fem/preconditioner/cholesky.h"
#include "sim/fem/solver/lbfgs.h"
#include "sim/fem/solver/lbfgs_solver.h"
#include "tests/bench/speed_parts.h"

namespace limberg::bench {
namespace {

using fem::Engine;

/// Multiply-adds of 16 numbers at once in eight independent chains.
#define LIMBERG_MULTIPLY_ADDS(name, attribute, lanes)            \
  attribute float name(long rounds) {                            \
    typedef float vec __attribute__((vector_size(4 * lanes)));   \
    vec a[8], x = {}, y = {};                                    \
    for (int i = 0; i < lanes; ++i) x[i] = 0.999f, y[i] = 1e-3f; \
    for (vec & v : a) v = y;                                     \
    for (long k = 0; k < rounds; ++k)                            \
      for (vec & v : a) v = v * x + y;                           \
    vec sum = a[0];                                              \
    for (int i = 1; i < 8; ++i) sum += a[i];                     \
    return sum[0];                                               \
  }
#if defined(__x86_64__)
LIMBERG_MULTIPLY_ADDS(multiply_512, __attribute__((target("avx512f"), optimize("fp-contract=fast", "unroll-loops"))),
                      16)
LIMBERG_MULTIPLY_ADDS(multiply_256, __attribute__((target("avx2,fma"), optimize("fp-contract=fast", "unroll-loops"))),
                      8)
#endif
LIMBERG_MULTIPLY_ADDS(multiply_128, , 4)

struct Machine {
  double gflops = 0;  // single precision, one core, the widest of the kernels' set
  double gb_s = 0;    // streamed from an array of `bytes`
  size_t bytes = 0;
};

template <class F>
double best_of(int repeats, const F& f) {
  Times t;
  for (int k = 0; k < repeats; ++k) {
    const double start = cpu_ms();
    f();
    t.add(cpu_ms() - start);
  }
  return t.best();
}

double gflops(const std::string& set) {
  constexpr long rounds = 200000;
  int lanes = 4;
  float (*run)(long) = multiply_128;
#if defined(__x86_64__)
  if (set == "avx512") run = multiply_512, lanes = 16;
  if (set == "avx2") run = multiply_256, lanes = 8;
#endif
  volatile float sink = 0;
  const double ms = best_of(5, [&] { sink = sink + run(rounds); });
  return 2.0 * 8 * lanes * double(rounds) / ms * 1e-6;
}

/// Reading two arrays of half that size each with the program's own widest loop.
double gb_s(const Engine& engine, size_t bytes) {
  const size_t n = std::max<size_t>(1024, bytes / 32);
  NodeArray a(n), b(n);
  for (size_t i = 0; i < n; ++i) a[i] = b[i] = {1, 1, 1, 0};
  const int passes = int(std::max<size_t>(1, (64u << 20) / (32 * n)));
  volatile double sink = 0;
  const double ms = best_of(5, [&] {
    for (int k = 0; k < passes; ++k) sink = sink + engine.dot(a, b);
  });
  return 32.0 * double(n) * passes / ms * 1e-6;
}

struct Part {
  const char* name;
  double per_iteration = 1;  // how often
  double bytes = 0, flops = 0;
  double working_set = 0;  // bytes that must be near for it to be fast
  std::function<void()> run;
  Times ms;
};

void profile(const SpeedRun& run, const char* name, int side, int layers) {
  const BenchScene scene = pulled_scene(side, layers, 0.49);
  const auto model = std::make_shared<FemModel>(scene.model);
  const size_t n = model->X_mm.size(), cells = model->cells.size();
  InlineWorkers workers;
  const Engine engine(workers);
  NodeArray u(n), g(n), r(n), z(n), d(n);
  for (size_t i = 0; i < n; ++i)
    if (!model->fixed[i])
      u[i] = r[i] = {0.2f * float(std::sin(double(3 * i))), 0.2f * float(std::sin(double(5 * i))),
                     0.2f * float(std::sin(double(7 * i))), 0};

  std::vector<Part> parts;
  fem::ElementSystem system(model);
  // A cell: 8 x 8 x 3 products of K with u, 8 x 9 for F, 8 x 9 for the forces,
  // about 60 for cofactors, energy and multiplier; it reads 8 corners from the
  // tile, its own 24 bytes, theta and q, and leaves its forces in the tile's slots.
  const double slots = double(system.kernel().slot_node.size());
  const double cell_flops = double(cells) * (2 * (192 + 72 + 72) + 60),
               cell_bytes = double(cells) * 36 + slots * (4 + 32 + 16) + double(n) * 16;
  parts.push_back({"cells: energy and forces",
                   4.0 / 3,
                   cell_bytes,
                   cell_flops,
                   double(n) * 32 + cell_bytes / 2,
                   [&] { system.evaluate(u, g, false, engine); },
                   {}});

  std::shared_ptr<const fem::ScalarCycle> cycle;
  fem::ScalarFactor factor;
  fem::ScalarCycle::Work work;
  NodeArray y;
  if (n <= 10000) {
    factor = fem::factorize(fem::assemble_scalar(*model, {}, 0), workers);
    y.resize(factor.node_order.size());
    const double bytes = double(factor.panels.bytes());
    parts.push_back({"metric: panels, read twice",
                     1,
                     2 * bytes + 96 * double(n),
                     2 * 2 * 3 * bytes / 4,
                     bytes,
                     [&] { factor.panels.solve(y.data(), engine); },
                     {}});
  } else {
    cycle = fem::ScalarCycle::build(model, {}, 0);
    // matrices are read twice (before and after the coarse step), the coarse factor too
    const double bytes = double(cycle->bytes());
    parts.push_back({"metric: cycle, matrices read twice",
                     1,
                     2 * bytes + 160 * double(n),
                     2 * 2 * 3 * bytes / 6,
                     bytes,
                     [&] { cycle->apply(r, z, work, engine); },
                     {}});
  }

  // Two loops over 8 pairs: 16 updates of a vector, each of which reads three and writes one.
  constexpr int pairs = 8;
  fem::LbfgsHistory history;
  history.resize(n, pairs);
  for (int k = 0; k < pairs; ++k) {
    NodeArray &s = history.next_s(), &t = history.next_y();
    for (size_t i = 0; i < n; ++i) {
      const float v = float(std::sin(double(i * size_t(k + 1))));
      s[i] = {v, v, v, 0}, t[i] = {2 * v, 2 * v, 2 * v, 0};
    }
    history.push(engine);
  }
  const auto nothing = [](const NodeArray& from, NodeArray& to) { std::copy(from.begin(), from.end(), to.begin()); };
  parts.push_back({"history: two loops over 8 pairs",
                   1,
                   double(n) * 16 * (2 * pairs * 4 + 4),
                   double(n) * 2 * pairs * 12,
                   double(n) * 16 * (2 * pairs + 2),
                   [&] { history.direction(r, d, nothing, engine); },
                   {}});
  // u + d, the new pair, its three products.
  parts.push_back({"vectors: step and new pair",
                   1,
                   double(n) * 16 * (3 + 3 + 3 + 6),
                   double(n) * 3 * (2 + 1 + 1 + 6),
                   double(n) * 16 * 8,
                   [&] {
                     engine.combine(z, u, 0.5, d);
                     engine.subtract(history.next_s(), z, u);
                     engine.subtract(history.next_y(), g, r);
                     engine.dot(history.next_s(), history.next_y()), engine.dot(history.next_s(), history.next_s()),
                         engine.dot(history.next_y(), history.next_y());
                   },
                   {}});

  // On a face nearly every cell has a stencil of its own: a cell to a lane all the same (lane_blocks.h), or one by one.
  FemModel apart = *model;
  for (size_t i = 0; i < cells; ++i) {
    Stencil own = apart.stencils[size_t(apart.cells[i].stencil)];
    own.volume_mm3 *= 1 + 1e-4 * double(i % 100);
    apart.cells[i].stencil = int32_t(apart.stencils.size()), apart.stencils.push_back(own);
  }
  const fem::ElementSystem own(std::make_shared<FemModel>(std::move(apart)));
  NodeArray own_slots(own.kernel().slot_node.size());
  AlignedArray<float> own_q(cells), own_theta(cells);
  const auto visit = [&](bool lanes) {
    for (fem::Tile tile : own.kernel().tiles) {
      if (!lanes) tile.lanes = {};
      engine.kernels().evaluate_tile(own.kernel().view(), tile, u.data(), own_q.data(), own_slots.data(),
                                     own_theta.data(), false);
    }
  };
  Times own_lanes, own_single;

  Times whole;
  fem::LbfgsSolver solver(workers, true, {}, {0, false});
  for (int repeat = 0; repeat < 7; ++repeat) {
    for (Part& p : parts) {
      p.run();  // warm
      const double start = cpu_ms();
      p.run();
      p.ms.add(cpu_ms() - start);
    }
    for (const bool lanes : {true, false}) {
      visit(lanes);
      const double start = cpu_ms();
      visit(lanes);
      (lanes ? own_lanes : own_single).add(cpu_ms() - start);
    }
    solver.set_model(model, {});
    solver.set_springs(scene.springs);
    StepSettings s;
    s.max_iterations = 0;
    solver.step(s);
    s.max_iterations = n > 50000 ? 12 : 30;
    const double start = cpu_ms();
    const StepReport report = solver.step(s);
    whole.add((cpu_ms() - start) / std::max(1, report.iterations));
  }

  std::string how;
  const std::string label = fmt::format("profile of an iteration, {} nodes", name);
  const double peak = gflops(engine.kernels().name);
  double sum = 0, floor = 0;
  for (const Part& p : parts) {
    const double speed = gb_s(engine, size_t(p.working_set));
    const double memory_ms = p.bytes / speed * 1e-6, arithmetic_ms = p.flops / peak * 1e-6,
                 least = std::max(memory_ms, arithmetic_ms);
    sum += p.per_iteration * p.ms.best(), floor += p.per_iteration * least;
    how = fmt::format(
        "x {:.2f} an iteration; {:.2f} MB, {:.2f} Mflop; floor {:.3f} ms by {} ({:.1f} GB/s from {:.1f} MB, {:.0f} "
        "Gflop/s)",
        p.per_iteration, p.bytes * 1e-6, p.flops * 1e-6, least, memory_ms > arithmetic_ms ? "bytes" : "arithmetic",
        speed, p.working_set * 1e-6, peak);
    run.out.rows.push_back(
        {label, p.name, how, p.ms.best(), false, p.ms.best() / least, "x", "its floor in the same run", true});
  }
  run.out.rows.push_back({label, "cells: each a stencil of its own", "one by one over a cell to a lane; same bits",
                          own_lanes.best(), false, own_single.best() / own_lanes.best(), "x",
                          "a cell to a lane in the same run", true});
  how = fmt::format(
      "{} nodes, {} cells; the parts make {:.3f} ms, their floors {:.3f} ms; {:.1f} iterations in a frame of 16.7 ms, "
      "{:.1f} at the floor",
      n, cells, sum, floor, 16.7 / whole.best(), 16.7 / floor);
  run.out.rows.push_back(
      {label, "a whole iteration", how, whole.best(), false, whole.best() / floor, "x", "the parts' floors", true});
}

}  // namespace

void speed_profile(const SpeedRun& run) {
  const struct {
    const char* name;
    int side, layers;
  } sizes[] = {{"2k", 24, 2}, {"8k", 44, 3}, {"30k", 66, 6}, {"100k", 100, 9}};
  for (const auto& s : sizes) {
    if (run.settings.quick != (s.side == 24)) continue;
    run.say(std::string("profile, ") + s.name + " nodes");
    profile(run, s.name, s.side, s.layers);
  }
  run.out.notes.push_back(
      "profile: the cells' floor counts arithmetic only. Of the kernel's instructions for sixteen cells some 400 are "
      "arithmetic and about as many again bring eight corners of 16 bytes to lanes and their forces back (8 x 16 "
      "loads, inserts, additions and stores): twice the floor; registers of 64 bytes take two cycles each on this "
      "processor, which the peak knows, and loads and stores of 16 bytes fill none of them");
  run.out.notes.push_back(
      "profile: times are the best of 7, warm; a part's floor is the larger of its bytes over the speed at which its "
      "working set streams and its arithmetic over the peak, both measured in this run");
}

double solve_floor_ms(size_t bytes) {
  InlineWorkers workers;
  return double(bytes) / gb_s(Engine(workers), bytes / 2) * 1e-6;
}

}  // namespace limberg::bench
