#include "tests/bench/fronts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "app/operating_point/cpu_clock.h"
#include "sim/base/text.h"
#include "sim/body/block.h"
#include "sim/body/skin.h"
#include "sim/cutting/arrangement/arrangement.h"
#include "sim/fem/solver/elastic_solver.h"
#include "sim/lattice/embedding.h"
#include "sim/lattice/fem_assembly.h"
#include "sim/lattice/grid_fit.h"
#include "sim/lattice/topology.h"

namespace limberg::bench {
namespace {

Vec3 along(const SlitSpec& s) {
  const double t = s.angle_deg * std::numbers::pi / 180;
  return {std::cos(t), std::sin(t), 0};
}
Vec3 across(const SlitSpec& s) { return {-along(s).y(), along(s).x(), 0}; }

Body block(const SlitSpec& s) {
  BlockSpec b;
  b.name = "slit";
  b.size_mm = s.block_mm, b.skin_cell_mm = s.skin_cell_mm, b.tension_direction = across(s);
  Layer skin, fat;
  skin.name = "skin", skin.thickness_mm = 1.5;
  skin.material.young_kPa = 60, skin.material.poisson = 0.45;
  skin.material.prestretch_along = 1.10, skin.material.prestretch_across = 1.06;
  fat.name = "fat", fat.thickness_mm = s.block_mm.z() - 1.5;
  fat.material.young_kPa = 15, fat.material.poisson = 0.45;
  fat.material.prestretch_along = 1.08, fat.material.prestretch_across = 1.05;
  b.layers = {skin, fat};
  return make_block(b);
}

Blade blade(const SlitSpec& s, const RestGrid& grid) {
  Blade b;
  const int columns = std::max(2, int(std::ceil((s.to_mm - s.from_mm) / 1.5)) + 1);
  for (int i = 0; i < columns; ++i) {
    const double x = s.from_mm + (s.to_mm - s.from_mm) * i / (columns - 1);
    const Vec3 at = x * along(s) + s.y_mm * across(s);
    b.vertex.push_back(grid.to_grid(at + Vec3::UnitZ())),
        b.vertex.push_back(grid.to_grid(at - s.depth_mm * Vec3::UnitZ()));
  }
  for (int32_t i = 0; i + 1 < columns; ++i) {
    b.tri.push_back({2 * i, 2 * i + 1, 2 * i + 3});
    b.tri.push_back({2 * i, 2 * i + 3, 2 * i + 2});
  }
  b.seed.assign(b.tri.size(), 1);
  return b;
}

/// The two banks as maps from (x, z), x along the slit, to what carries them.
class Banks {
 public:
  Banks(const LatticeTopology& lattice, const SurfaceView& view, const Vec3& along)
      : lattice_(lattice), view_(view), along_(along) {
    for (size_t t = 0; t < view.tri.size(); ++t)
      if (view.kind[t] == FaceKind::wall) wall_.push_back(int32_t(t));
  }
  /// Points of the wall at (x, z): one per bank, or more on an edge of its triangles; none beyond it.
  std::vector<HeldPlace> at(double x, double z) const {
    std::vector<HeldPlace> bank;
    for (int32_t t : wall_) {
      const Tri& v = view_.tri[size_t(t)];
      const Vec3 &a = view_.X_mm[size_t(v[0])], &b = view_.X_mm[size_t(v[1])], &c = view_.X_mm[size_t(v[2])];
      auto area = [&](const Vec3& p, const Vec3& q, double px, double pz) {
        return along_.dot(q - p) * (pz - p.z()) - (q.z() - p.z()) * (px - along_.dot(p));
      };
      const double all = area(a, b, along_.dot(c), c.z());
      if (all == 0) continue;
      const std::array<double, 3> w{area(b, c, x, z) / all, area(c, a, x, z) / all, area(a, b, x, z) / all};
      if (w[0] < 0 || w[1] < 0 || w[2] < 0) continue;
      bank.push_back(embed_point(lattice_, view_, t, w));
    }
    return bank;
  }

 private:
  const LatticeTopology& lattice_;
  const SurfaceView& view_;
  const Vec3 along_;
  std::vector<int32_t> wall_;
};

/// What carries a point, in nodes that do not hang.
std::map<int32_t, double> carriers(const LatticeTopology& t, const EmbeddedPoint& p) {
  std::map<int32_t, double> sum;
  for (size_t k = 0; k < 8; ++k) {
    const LatticeTopology::Hanging* h = t.hanging_at(p.node[k]);
    if (!h)
      sum[p.node[k]] += double(p.w[k]);
    else
      for (size_t m = 0; m < size_t(h->count); ++m) sum[h->master[m]] += double(p.w[k]) / h->count;
  }
  return sum;
}

/// Half the sum of what two points' carriers differ by: 0 for
/// banks that cannot part, 1 for banks with no node in common.
double apart(const LatticeTopology& t, const EmbeddedPoint& a, const EmbeddedPoint& b) {
  std::map<int32_t, double> d = carriers(t, a);
  for (auto [n, w] : carriers(t, b)) d[n] -= w;
  double sum = 0;
  for (auto [n, w] : d) sum += std::abs(w);
  return sum / 2;
}

/// What `open(x, z)` leaves closed at both ends, just below the skin, and at the bottom in the middle.
template <class Open>
void find_closed(const SlitSpec& s, SlitOpening& out, Open&& open) {
  auto closed = [&](auto&& at, double limit) {
    constexpr double kStep_mm = 0.01;
    double open_from = 0;
    while (open_from < limit && !at(open_from)) open_from += kStep_mm;
    double shut_to = open_from - kStep_mm;
    for (int i = 0; i < 12 && open_from > 0; ++i) {  // to micrometres
      const double middle = 0.5 * (shut_to + open_from);
      (at(middle) ? open_from : shut_to) = middle;
    }
    return open_from;
  };
  constexpr double kJustBelow = -0.01;
  const double middle = 0.5 * (s.from_mm + s.to_mm) + 0.013;
  out.closed_low_mm = closed([&](double d) { return open(s.from_mm + d, kJustBelow); }, s.to_mm - s.from_mm);
  out.closed_high_mm = closed([&](double d) { return open(s.to_mm - d, kJustBelow); }, s.to_mm - s.from_mm);
  out.closed_deep_mm = closed([&](double d) { return open(middle, -s.depth_mm + d); }, s.depth_mm);
}

void add_bar(Result& out, const std::string& name, double closed_cells) {
  out.bars.push_back({name, closed_cells, false, 0.25, false, closed_cells <= 0.25,
                      "issue 3: a cut's end within 1/4 of the coarse cell"});
}

}  // namespace

double SlitOpening::closed_cells() const {
  return std::max({closed_low_mm / cell_mm.x(), closed_high_mm / cell_mm.x(), closed_deep_mm / cell_mm.z()});
}

SlitOpening open_slit(const SlitSpec& s, Workers& workers) {
  const auto body = std::make_shared<const Body>(block(s));
  const Skin skin(body);
  Arrangement a(body->surface, body->grid);
  const LatticeGrid grid = fit_lattice(*body, s.cell_mm, s.front_levels ? kLevels : 0);
  const StencilTable stencils(skin, grid);
  auto lattice = build_topology(grid, material_surface(a), s.front_levels);
  const auto solver = make_solver(workers);
  solver->set_model(assemble_fem(stencils, *lattice), {});
  if (const CutResult r = a.cut(blade(s, body->grid), 1); !r.ok())
    throw std::runtime_error("bench cutting: the slit was refused: " + r.reason);

  SlitOpening out;
  out.cell_mm = grid.cell_mm();
  double at = cpu_ms();
  const auto lap = [&] {
    const double now = cpu_ms(), t = now - at;
    at = now;
    return t;
  };
  lattice = update_topology(*lattice, material_surface(a));
  out.lattice_ms = lap();
  const auto model = assemble_fem(stencils, *lattice);
  out.assembly_ms = lap();
  solver->set_model(model, lattice->cell_parent);
  StepSettings settings;
  settings.max_iterations = 20, settings.tolerance = s.residual;
  for (StepReport r; out.iterations < s.max_iterations && !r.converged;) {
    r = solver->step(settings);
    out.iterations += std::max(1, r.iterations), out.reached = r.residual;
  }
  out.solve_ms = lap();
  out.nodes = model->X_mm.size(), out.hanging = model->hanging.size(), out.cells = model->cells.size();

  SurfaceView view = a.surface_view();
  embed_surface(*lattice, material_surface(a), view);
  const Banks banks(*lattice, view, along(s));
  const auto width = [&](double x, double z) {
    double far = 0;
    const auto bank = banks.at(x, z);
    for (size_t i = 1; i < bank.size(); ++i)
      far = std::max(far, (solver->position_mm(bank[i]) - solver->position_mm(bank[0])).norm());
    return far;
  };
  for (double x = s.from_mm; x <= s.to_mm + 1e-9; x += 0.25) {
    out.x_mm.push_back(x), out.width_mm.push_back(width(x, -0.01));
    out.widest_mm = std::max(out.widest_mm, out.width_mm.back());
  }
  find_closed(s, out, [&](double x, double z) { return width(x, z) > 1e-3 * out.widest_mm; });
  return out;
}

SlitOpening slit_in_lattice(const SlitSpec& s) {
  const Body body = block(s);
  Arrangement a(body.surface, body.grid);
  const LatticeGrid grid = fit_lattice(body, s.cell_mm, s.front_levels ? kLevels : 0);
  auto lattice = build_topology(grid, material_surface(a), s.front_levels);
  if (const CutResult r = a.cut(blade(s, body.grid), 1); !r.ok())
    throw std::runtime_error("bench cutting: the slit was refused: " + r.reason);
  SlitOpening out;
  out.cell_mm = grid.cell_mm();
  const double begin = cpu_ms();
  lattice = update_topology(*lattice, material_surface(a));
  out.lattice_ms = cpu_ms() - begin;
  out.nodes = lattice->nodes.size(), out.hanging = lattice->hanging.size(), out.cells = lattice->cells.size();
  SurfaceView view = a.surface_view();
  embed_surface(*lattice, material_surface(a), view);
  const Banks banks(*lattice, view, along(s));
  find_closed(s, out, [&](double x, double z) {
    const auto bank = banks.at(x, z);
    double far = 0;
    for (size_t i = 1; i < bank.size(); ++i) far = std::max(far, apart(*lattice, bank[i], bank[0]));
    return far > 1e-3;
  });
  return out;
}

/// The lattice alone, at every angle and with ends anywhere in a cell.
static void all_angles(Result& out, const CuttingSettings& settings) {
  for (const double cell : {5.0, 3.5, 2.5}) {
    double worst = 0, worst_at = 0;
    size_t nodes[2] = {0, 0}, slits = 0;
    const std::string label = text("slit at any angle, cells of %g mm", cell);
    if (settings.progress) settings.progress(label);
    for (double angle = 0; angle <= 90; angle += settings.quick ? 15 : 7.5)
      for (int place = 0; place < (settings.quick ? 1 : 3); ++place) {
        SlitSpec s;
        s.block_mm = {44, 44, 10}, s.angle_deg = angle, s.cell_mm = cell;
        s.from_mm = -9.2 - 0.31 * cell * place, s.to_mm = 8.1 + 0.37 * cell * place,
        s.depth_mm = 6.1 - 0.2 * cell * place, s.y_mm = 0.37 - 0.23 * cell * place;
        s.front_levels = 2;
        nodes[0] += slit_in_lattice(s).nodes;
        s.front_levels = kLevels;
        const SlitOpening o = slit_in_lattice(s);
        nodes[1] += o.nodes, ++slits;
        const double closed = o.closed_cells();
        if (closed > worst) worst = closed, worst_at = angle;
      }
    Row r;
    r.name = label, r.method = "fronts divided, lattice alone";
    r.settings = text(
        "%zu slits at 0 to 90 degrees; worst closed end %.3f of a cell, at %g degrees; %zu nodes in the mean, %zu with "
        "two divisions only",
        slits, worst, worst_at, nodes[1] / slits, nodes[0] / slits);
    out.rows.push_back(r);
    add_bar(out, text("closed end of a slit at any angle, cells of %g mm (cells)", cell), worst);
  }
}

void fronts(Result& out, const CuttingSettings& settings) {
  InlineWorkers workers;
  const auto bar = [&](const std::string& name, const SlitOpening& o) { add_bar(out, name, o.closed_cells()); };
  for (double cell : settings.quick ? std::vector<double>{5} : std::vector<double>{5, 3.5}) {
    SlitSpec base;
    base.cell_mm = cell;
    if (settings.quick) base.block_mm = {60, 40, 10}, base.from_mm = -8.7, base.to_mm = 11.3;
    struct Case {
      std::string name;
      double cell_mm;
      int levels;
    };
    const std::vector<Case> cases{{text("uniform, %g mm", cell / 4), cell / 4, 0},
                                  {text("uniform, %g mm", cell / 2), cell / 2, 0},
                                  {text("uniform, %g mm", cell), cell, 0},
                                  {"fronts divided once", cell, 1},
                                  {"fronts divided", cell, kLevels}};
    SlitOpening reference;
    const std::string label = text("slit that ends in cells of %g mm", cell);
    for (const Case& c : cases) {
      if (settings.progress) settings.progress(label + ": " + c.name);
      SlitSpec spec = base;
      spec.cell_mm = c.cell_mm, spec.front_levels = c.levels;
      const SlitOpening o = open_slit(spec, workers);
      if (c.cell_mm == cell / 4) reference = o;
      double sum = 0;
      for (size_t i = 0; i < o.width_mm.size(); ++i) sum += std::pow(o.width_mm[i] - reference.width_mm[i], 2);
      Row r;
      r.name = label, r.method = c.name;
      r.time_ms = o.lattice_ms + o.assembly_ms;
      r.error = std::sqrt(sum / double(o.width_mm.size())) / reference.widest_mm;
      r.error_unit = "", r.reference = text("width on the uniform lattice of %g mm", cell / 4);
      r.settings = text("%zu nodes (%zu hang), closed %.2f and %.2f mm at the ends, %.2f at the bottom; widest %.2f mm",
                        o.nodes, o.hanging, o.closed_low_mm, o.closed_high_mm, o.closed_deep_mm, o.widest_mm) +
                   text("; solved in %d iterations, %.0f ms, residual %.1e", o.iterations, o.solve_ms, o.reached);
      out.rows.push_back(r);
      if (c.levels == kLevels) bar(text("closed end of a slit in cells of %g mm, fronts divided (cells)", cell), o);
    }
    if (settings.quick) continue;
    for (const auto& [name, levels] :
         {std::pair{"at 45 degrees to the cells", 0}, std::pair{"at 45 degrees, fronts divided", int(kLevels)}}) {
      if (settings.progress) settings.progress(label + ": " + name);
      SlitSpec spec = base;
      spec.angle_deg = 45, spec.front_levels = levels;
      const SlitOpening o = open_slit(spec, workers);
      Row r;
      r.name = label, r.method = name, r.time_ms = o.lattice_ms + o.assembly_ms;
      r.settings = text("%zu nodes (%zu hang), closed %.2f and %.2f mm at the ends, %.2f at the bottom; widest %.2f mm",
                        o.nodes, o.hanging, o.closed_low_mm, o.closed_high_mm, o.closed_deep_mm, o.widest_mm);
      out.rows.push_back(r);
      if (levels > 0) bar(text("the same at 45 degrees to the cells, cells of %g mm (cells)", cell), o);
    }
  }
  all_angles(out, settings);
}

}  // namespace limberg::bench
