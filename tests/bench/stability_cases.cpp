#include "tests/bench/stability_cases.h"

#include <cmath>
#include <utility>

#include "sim/fem/elements/material_points.h"
#include "sim/fem/materials/fibres.h"
#include "sim/fem/materials/isotropic.h"
#include "sim/fem/model/box_model.h"
#include "tests/bench/layered_block.h"

namespace limberg::bench {
namespace {

struct Random {  // SplitMix64
  uint64_t state = 17;
  double uniform() {
    uint64_t z = (state += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    z ^= z >> 31;
    return double(z >> 11) * 0x1p-52 - 1;
  }
};

BoxSpec block(double poisson = 0.45) {
  BoxSpec b;
  b.cells = {12, 12, 2}, b.size_mm = {60, 60, 10}, b.young_bottom_kPa = 18, b.poisson = poisson, b.fix_sides = true;
  return b;
}

enum class Start { scramble, point, plane, mirror, half_inverted };
constexpr const char* start_name[] = {"random scramble", "all at one point", "all on a plane", "mirrored",
                                      "half inverted"};

std::vector<Vec3f> displaced(const FemModel& m, Start start, uint64_t seed = 17) {
  Random r{seed};
  std::vector<Vec3f> u(m.X_mm.size(), Vec3f::Zero());
  for (size_t i = 0; i < u.size(); ++i) {
    const Vec3 X = m.X_mm[i];
    Vec3 x = X;
    switch (start) {
      case Start::scramble:
        x = Vec3(30 * r.uniform(), 30 * r.uniform(), 5 + 5 * r.uniform());
        break;
      case Start::point:
        x = Vec3(0, 0, 5);
        break;
      case Start::plane:
        x[2] = 5;
        break;
      case Start::mirror:
        x[2] = 10 - X[2];
        break;
      case Start::half_inverted:
        if (X[0] > 0) x[2] = 10 - X[2];
        break;
    }
    if (!m.fixed[i]) u[i] = (x - X).cast<float>();
  }
  return u;
}

Spring hook(const FemModel& m, const Vec3& at, const Vec3& move, double k_N_per_mm) {
  Spring s;
  s.id = 1, s.to_world = true, s.k_N_per_mm = k_N_per_mm, s.a = embed(m, at), s.target_mm = at + move;
  return s;
}

/// Zero-length sutures between two lines on the upper face, all at once: the skin between them must fold or go under.
std::vector<Spring> sutures(const FemModel& m, int count, double half_gap_mm) {
  std::vector<Spring> all;
  for (int i = 0; i < count; ++i) {
    const double y = -20 + 40.0 * i / std::max(1, count - 1);
    Spring s;
    s.id = i + 1, s.k_N_per_mm = 20, s.a = embed(m, {-half_gap_mm, y, 10}), s.b = embed(m, {half_gap_mm, y, 10});
    all.push_back(s);
  }
  return all;
}

FemModel with_law(const FemModel& from, const LawPtr& law, double lambda_kPa) {
  FemModel m = from;
  m.laws = {law};
  for (Stencil& s : m.stencils) s = fem::law_stencil(m.cell_mm, 0, *law, lambda_kPa, s.density_kg_mm3);
  return m;
}

struct List {
  std::vector<StabilityCase> all;
  StabilityCase& add(const char* family, std::string name, FemModel m) {
    StabilityCase c;
    c.family = family, c.name = std::move(name), c.model = std::make_shared<FemModel>(std::move(m));
    all.push_back(std::move(c));
    return all.back();
  }
};

void bad_starts(List& l) {
  for (double nu : {0.47, 0.499, 0.4999})
    for (int s = 0; s < 5; ++s) {
      auto& c = l.add("start",
                      std::string(start_name[s]) + ", nu " +
                          (nu == 0.47    ? ".47"
                           : nu == 0.499 ? ".499"
                                         : ".4999"),
                      box_model(block(nu)));
      c.start = displaced(*c.model, Start(s));
      c.poisson = nu;
    }
}

void law_cases(List& l) {
  const double mu = 60 / 2.9, lambda = 10 * mu;
  const std::vector<std::pair<const char*, LawPtr>> list = {
      {"Ogden alpha 9", ogden({{2 * mu / 9, 9}})},
      {"Mooney-Rivlin", mooney_rivlin(0.3 * mu, 0.2 * mu)},
      {"corotated", corotated(mu)},
      {"dispersed fibres", sum_of({neo_hookean(mu), dispersed_fibres({3 * mu, 1, 0.1}, {{Vec3::UnitX()}})})}};
  for (const auto& [name, law] : list)
    for (Start s : {Start::scramble, Start::mirror}) {
      auto& c = l.add("law", std::string(name) + ", " + start_name[int(s)], with_law(box_model(block()), law, lambda));
      c.start = displaced(*c.model, s);
      c.has_laws = true, c.one_material = false;
    }
}

void contrast(List& l) {
  for (bool checkered : {false, true})
    for (bool scramble : {false, true}) {
      BoxSpec b = block();
      b.young_bottom_kPa = 0.06, b.young_top_kPa = 6e4;
      FemModel m = box_model(b);
      if (checkered)
        for (HexCell& c : m.cells) c.stencil = (c.at[0] / 2 + c.at[1] / 2 + c.at[2] / 2) % 2;
      auto& c = l.add("stiffness contrast 1e6",
                      std::string(checkered ? "checkered" : "layers") + (scramble ? ", scramble" : ", hook"), m);
      c.one_material = false;
      if (scramble)
        c.start = displaced(m, Start::scramble);
      else
        c.load = {hook(m, {5, 3, 0}, {0, 0, -20}, 0.5)}, c.hold_steps = 20;
    }
}

// 1.5 mm of skin in the uppermost of three rows of 3.3 mm cells: skin and fat share a cell and slide in it.
void shared_cells(List& l) {
  for (const double contrast : {60.0, 400.0})
    for (Start s : {Start::scramble, Start::mirror, Start::half_inverted}) {
      auto& c = l.add(
          "shared cells",
          std::string("skin in a cell of fat, ") + (contrast == 60 ? "60" : "400") + " : 1, " + start_name[int(s)],
          shared_cell_block(contrast));
      c.start = displaced(*c.model, s);
      c.one_material = false;
    }
}

void slivers(List& l) {
  for (double fraction : {1e-2, 1e-4, 1e-6})
    for (bool scramble : {false, true}) {
      FemModel m = box_model(block());
      Random r;
      for (HexCell& c : m.cells)
        if (r.uniform() > 0.7) c.scale = float(fraction);
      auto& c = l.add("slivers",
                      "a sixth of the cells 1e" + std::to_string(int(std::lround(std::log10(fraction)))) +
                          (scramble ? ", scramble" : ", hook"),
                      m);
      c.one_material = false;
      if (scramble)
        c.start = displaced(m, Start::scramble);
      else
        c.load = {hook(m, {5, 3, 10}, {-10, 0, 25}, 0.5)}, c.hold_steps = 20;
    }
}

void steps(List& l) {
  for (double dt : {1e-3, 1e-2, 0.1, 1.0}) {
    auto& c = l.add("time step",
                    "let go from a 25 mm pull, dt " + std::string(dt == 1e-3   ? "1 ms"
                                                                  : dt == 1e-2 ? "10 ms"
                                                                  : dt == 0.1  ? "0.1 s"
                                                                               : "1 s"),
                    box_model(block()));
    c.load = {hook(*c.model, {5, 3, 10}, {-10, 0, 25}, 0.5)}, c.hold_steps = 20;
    c.dt_s = dt, c.damping_per_s = 10;
  }
}

void pulls(List& l) {
  for (double newton : {1.0, 10.0, 100.0, 1000.0}) {
    FemModel m = box_model(block());
    auto& c = l.add("hook", "pull of about " + std::to_string(int(newton)) + " N", m);
    c.load = {hook(m, {5, 3, 10}, {0, 0, newton / 0.5}, 0.5)}, c.hold_steps = 40;
  }
  FemModel m = box_model(block());
  auto& c = l.add("hook", "teleport of ten lengths", m);
  c.load = {hook(m, {5, 3, 10}, {0, 0, 10}, 0.5)}, c.hold_steps = 20;
  c.teleport = {hook(m, {5, 3, 10}, {600, 0, 0}, 0.5)};
}

void stitches(List& l) {
  for (double nu : {0.45, 0.499}) {
    BoxSpec b = block(nu);
    b.cells = {24, 24, 2};
    b.hole_length_mm = 0;
    FemModel m = box_model(b);
    auto& c = l.add("sutures", nu == 0.45 ? "100 zero-length at once, nu .45" : "100 zero-length at once, nu .499", m);
    c.load = sutures(m, 100, 3), c.hold_steps = 60, c.must_reach = true;
  }
}

void floating(List& l) {
  // Not the scramble: a free plate may come to rest folded through itself, in a true equilibrium of its own. Not the
  // point: with nothing held, no direction is better than another.
  for (Start s : {Start::plane, Start::mirror, Start::half_inverted}) {
    BoxSpec b = block();
    b.fix_sides = false;
    auto& c = l.add("floating piece", start_name[int(s)], box_model(b));
    c.start = displaced(*c.model, s), c.floating = true;
  }
  BoxSpec b = block();
  b.fix_sides = false;
  auto& c = l.add("floating piece", "thrown, dt 10 ms: momentum", box_model(b));
  c.floating = true, c.dt_s = 0.01, c.throw_mm_per_s = {300, -200, 500};
}

void everything(List& l) {
  BoxSpec b = block(0.4999);
  b.young_bottom_kPa = 0.06, b.young_top_kPa = 6e4;
  FemModel m = box_model(b);
  Random r;
  for (HexCell& c : m.cells)
    if (r.uniform() > 0.7) c.scale = 1e-6f;
  auto& c = l.add("everything", "contrast 1e6, nu .4999, slivers 1e-6, scramble, 1 kN, 40 sutures", m);
  c.start = displaced(m, Start::scramble);
  c.load = sutures(m, 40, 3);
  Spring h = hook(m, {5, 3, 10}, {0, 0, 2000}, 0.5);
  h.id = 1000;
  c.load.push_back(h);
  c.hold_steps = 10;
  c.one_material = false;
}

// The slab of speed_slab.cpp and the inversion tests that its peers were put to: 150 steps of 10 ms. Most of them lose
// their neo-Hookean body in the first steps of scramble, flat and mirror.
void slab(List& l) {
  const auto model = [](bool whole_bottom) {
    BoxSpec b;
    b.cells = {24, 24, 2}, b.size_mm = {120, 120, 10}, b.young_bottom_kPa = b.young_top_kPa = 100, b.poisson = 0.45;
    FemModel m = box_model(b);
    for (size_t i = 0; i < m.X_mm.size(); ++i)
      m.fixed[i] = m.X_mm[i][2] < 1e-9 &&
                   (whole_bottom || std::fabs(m.X_mm[i][0]) > 60 - 1e-9 || std::fabs(m.X_mm[i][1]) > 60 - 1e-9);
    return m;
  };
  const auto add = [&](const std::string& name, bool whole_bottom) -> StabilityCase& {
    auto& c = l.add("peers' slab", name, model(whole_bottom));
    c.dt_s = 0.01, c.damping_per_s = 10, c.length_mm = 120, c.young_kPa = 100;
    return c;
  };
  auto& press = add("press: the middle pushed 20 mm through 10 mm", true);
  press.load = {hook(*press.model, {0, 0, 10}, {0, 0, -20}, 100)}, press.hold_steps = 150, press.ramp_steps = 100;
  for (double speed : {20.0, 200.0}) {
    auto& lift = add("pull of 20 mm at " + std::to_string(int(speed)) + " mm/s", false);
    lift.load = {hook(*lift.model, {0, 0, 10}, {0, 0, 20}, 100)}, lift.ramp_steps = int(std::lround(2000 / speed)),
    lift.hold_steps = lift.ramp_steps + 50;
  }
  const char* names[] = {"scramble", "flat", "mirror"};
  const Start starts[] = {Start::scramble, Start::plane, Start::mirror};
  for (int s = 0; s < 3; ++s) {
    auto& c = add(names[s], false);
    c.start = displaced(*c.model, starts[s]);
    if (starts[s] == Start::scramble)
      for (Vec3f& u : c.start) u[0] *= 2, u[1] *= 2;  // over the whole slab
  }
}

}  // namespace

FemModel shared_cell_block(double contrast) {
  LayeredBlock b;
  b.cells = {18, 18, 3}, b.size_mm = {60, 60, 10}, b.skin_kPa = 15 * contrast;
  FemModel m = layered_block(b);
  for (size_t i = 0; i < m.X_mm.size(); ++i) {
    const Vec3& X = std::as_const(m.X_mm)[i];
    m.fixed.set(i, std::fabs(X[0]) > 30 - 1e-9 || std::fabs(X[1]) > 30 - 1e-9);
  }
  return m;
}

std::vector<StabilityCase> stability_cases(bool one_per_family) {
  List l;
  bad_starts(l), law_cases(l), contrast(l), shared_cells(l), slivers(l), steps(l), pulls(l), stitches(l), floating(l),
      everything(l), slab(l);
  if (!one_per_family) return std::move(l.all);
  std::vector<StabilityCase> few;
  for (StabilityCase& c : l.all)
    if (few.empty() || few.back().family != c.family) few.push_back(std::move(c));
  return few;
}

std::shared_ptr<const FemModel> corotated_twin(const FemModel& model) {
  auto m = std::make_shared<FemModel>(model);
  m->laws.clear();
  for (Stencil& s : m->stencils) {
    // Lame's lambda (fem_model.h: reparametrised)
    const LawPtr law = corotated_full(s.mu_kPa, s.lambda_kPa - s.mu_kPa);
    m->laws.push_back(law);
    s = fem::law_stencil(m->cell_mm, int32_t(m->laws.size()) - 1, *law, 0, s.density_kg_mm3);
  }
  return m;
}

}  // namespace limberg::bench
