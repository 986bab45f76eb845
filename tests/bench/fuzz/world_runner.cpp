#include "tests/bench/fuzz/world_runner.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>

#include "sim/base/error.h"
#include "sim/body/block.h"
#include "sim/commands/script.h"
#include "sim/cutting/arrangement/arrangement.h"
#include "sim/lattice/topology.h"
#include "sim/patient/soft_tissue.h"
#include "tests/bench/fuzz/checks.h"

namespace limberg::fuzz {

namespace {

/// Where the corners of the surface are, by the arrangement's point (the banks of a cut share one).
std::multimap<int32_t, Vec3f> places(const World& world) {
  Snapshot s;
  world.fill(s);
  const SurfaceView& view = world.topology()->view;
  std::multimap<int32_t, Vec3f> out;
  for (size_t v = 0; v < view.point.size(); ++v) out.emplace(view.point[v], s.x_mm[v]);
  return out;
}

/// 3e-4 mm: positions of 60 mm are rounded to 4e-6, weights of eight corners and a divided cell's parents add to it.
std::string moved(const std::multimap<int32_t, Vec3f>& before, const std::multimap<int32_t, Vec3f>& after) {
  for (const auto& [point, x] : after) {
    const auto [first, last] = before.equal_range(point);
    float nearest = first == last ? 0 : 1e30f;
    for (auto it = first; it != last; ++it) nearest = std::min(nearest, (it->second - x).norm());
    if (nearest > 3e-4f) return "I7: a cut has moved a point of the surface by " + std::to_string(nearest) + " mm";
  }
  return {};
}

bool is_cut(const Command& c) {
  return std::holds_alternative<Incise>(c) || std::holds_alternative<InciseMore>(c) ||
         std::holds_alternative<Undermine>(c) || std::holds_alternative<Excise>(c);
}

}  // namespace

void WorldCounts::add(const WorldCounts& b) {
  acts += b.acts, done += b.done, cuts += b.cuts, refused += b.refused, defects += b.defects;
  undone += b.undone, redone += b.redone, full_checks += b.full_checks;
}

std::string to_text(const WorldCase& c) {
  Script s;
  std::ostringstream scene;
  scene << "fuzz size=" << c.size_mm << " thickness=" << c.thickness_mm << " skin=" << c.skin_cell_mm
        << " cell=" << c.cell_mm << " fronts=" << c.fronts << " steps=" << c.steps << " seed=" << c.seed;
  s.header.scene = scene.str();
  s.header.note = c.violation;
  for (const Command& a : c.acts) s.lines.push_back({int(s.lines.size()) + 2, a});
  return to_text(s);
}

WorldCase world_case(const std::string& text, const std::string& file) {
  const Script s = parse_script(text, file);
  WorldCase c;
  std::istringstream words(s.header.scene);
  std::string word;
  words >> word;
  if (word != "fuzz")
    throw InputError(file, 1,
                     "the scene is " + s.header.scene + "; a patient of the fuzzer was expected (fuzz size=60 ...)");
  while (words >> word) {
    const size_t at = word.find('=');
    const std::string key = word.substr(0, at);
    char* end = nullptr;
    const long long v = at == std::string::npos ? -1 : std::strtoll(word.c_str() + at + 1, &end, 10);
    if (!end || *end != 0 || v < 0 || (key != "seed" && v > 1000))
      throw InputError(file, 1, "the scene has " + word + "; name=number was expected");
    if (key == "size" && v >= 20)
      c.size_mm = int(v);
    else if (key == "thickness" && v > 0)
      c.thickness_mm = int(v);
    else if (key == "skin" && v > 0)
      c.skin_cell_mm = int(v);
    else if (key == "cell" && v > 0)
      c.cell_mm = int(v);
    else if (key == "fronts")
      c.fronts = v != 0;
    else if (key == "steps")
      c.steps = v != 0;
    else if (key == "seed")
      c.seed = uint64_t(v);
    else
      throw InputError(file, 1,
                       "the scene has " + word + "; size, thickness, skin, cell, fronts, steps or seed was expected");
  }
  c.violation = s.header.note;
  for (const ScriptLine& l : s.lines) c.acts.push_back(l.command);
  return c;
}

WorldRunner::WorldRunner(const WorldCase& c, int check_every) : case_(c), check_every_(check_every) {
  case_.acts.clear();
  world_ = make(c.cell_mm);
}

std::unique_ptr<World> WorldRunner::make(int cell_mm) const {
  BlockSpec b;
  b.size_mm = Vec3(case_.size_mm, case_.size_mm, case_.thickness_mm);
  b.skin_cell_mm = case_.skin_cell_mm;
  Material skin, fat;
  skin.young_kPa = 60, skin.poisson = 0.45, skin.prestretch_along = 1.1, skin.prestretch_across = 1.06;
  fat.young_kPa = 12, fat.poisson = 0.45;
  b.layers = {{"skin", 1.5, skin}, {"fat", case_.thickness_mm - 1.5, fat}};
  WorldSpec spec;
  spec.body = std::make_shared<Body>(make_block(b));
  spec.cell_mm = cell_mm;
  spec.refine_fronts = case_.fronts;
  spec.seed = case_.seed;
  return std::make_unique<World>(spec, const_cast<InlineWorkers&>(workers_));
}

void WorldRunner::wait(World& world, double seconds) const {
  if (!case_.steps) return;
  StepSettings s;
  s.max_iterations = 4;
  for (int i = 0; i < int(std::lround(std::min(seconds, 0.1) * 100)); ++i) world.step(s);
}

std::string WorldRunner::apply(const Command& command) {
  ++counts_.acts;
  all_.push_back(command);
  try {
    std::string why = act(command);
    const bool full = check_every_ > 0 && counts_.acts % check_every_ == 0;
    counts_.full_checks += full;
    if (why.empty()) why = check(full);
    return why;
  } catch (const std::exception& e) {
    return std::string("exception: ") + e.what();
  }
}

std::string WorldRunner::act(const Command& command) {
  if (const Wait* w = std::get_if<Wait>(&command)) return wait(*world_, w->seconds), std::string();
  const uint64_t before = world_->full_hash();
  const auto lattice = world_->skin()->lattice();
  const auto x = is_cut(command) ? places(*world_) : std::multimap<int32_t, Vec3f>{};
  const Outcome o = world_->apply(command);
  if (!o.done) {
    ++counts_.refused;
    if (o.reason.empty()) return "refusal: no reason is given";
    if (world_->full_hash() != before) return "rollback: a refused act has changed the state: " + o.reason;
    if (o.reason.find("cannot follow") != std::string::npos || o.reason.find("failed inside") != std::string::npos ||
        o.reason.find("defect") != std::string::npos)
      ++counts_.defects, defects_.push_back(o.reason);
    const bool empty =
        std::holds_alternative<Undo>(command) ? done_.empty() : std::holds_alternative<Redo>(command) && redo_.empty();
    if ((std::holds_alternative<Undo>(command) || std::holds_alternative<Redo>(command)) && !empty)
      return "history: refused: " + o.reason;
    return {};
  }
  ++counts_.done;
  if (std::holds_alternative<Undo>(command)) {
    if (done_.empty()) return "undo: something was taken back that was never done";
    ++counts_.undone;
    const uint64_t expected = done_.back().before;
    redo_.push_back({expected, before});
    done_.pop_back();
    stroke_ = 0;
    return world_->full_hash() == expected ? std::string() : "undo: other bits than before the act";
  }
  if (std::holds_alternative<Redo>(command)) {
    if (redo_.empty()) return "redo: something was made again that was never undone";
    ++counts_.redone;
    const uint64_t expected = redo_.back().after;
    done_.push_back({redo_.back().before, 0});
    redo_.pop_back();
    stroke_ = 0;
    return world_->full_hash() == expected ? std::string() : "redo: other bits than before the undo";
  }
  if (std::holds_alternative<SetHook>(command) || std::holds_alternative<ReleaseHook>(command)) redo_.clear();
  if (std::holds_alternative<Suture>(command) || std::holds_alternative<SutureRow>(command)) {
    done_.push_back({before, 0});
    redo_.clear();
    stroke_ = 0;
  }
  if (!is_cut(command) || world_->skin()->lattice() == lattice) return {};
  ++counts_.cuts;
  const InciseMore* more = std::get_if<InciseMore>(&command);
  if (!more || stroke_ != more->stroke) {
    done_.push_back({before, 0});
    redo_.clear();
  }
  stroke_ = more && !more->last ? more->stroke : 0;
  if (std::string why = check_parents(*lattice, *world_->skin()->lattice(), false); !why.empty()) return why;
  return moved(x, places(*world_));
}

std::string WorldRunner::check(bool full) const {
  const double all = world_->skin()->initial_volume_mm3();
  const Arrangement& a = *world_->skin()->arrangement();
  const LatticeTopology& t = *world_->skin()->lattice();
  if (std::abs(world_->skin()->volume_mm3() + world_->skin()->removed_volume_mm3() - all) > 1e-9 * all)
    return "I4: volume is lost";
  if (t.pieces != a.pieces())
    return "I15: the lattice has " + std::to_string(t.pieces) + " pieces, the surface " + std::to_string(a.pieces());
  if (std::abs(t.volume_mm3 - a.volume_mm3()) > 1e-9 * all) return "I6: the mass differs from the volume";
  const SurfaceView& view = world_->topology()->view;
  for (size_t v = 0; v < view.cell_copy.size(); ++v)
    if (view.cell_copy[v] < 0 || size_t(view.cell_copy[v]) >= t.cells.size())
      return "I8: a corner of the surface that no cell carries";
  if (!full) return {};
  if (std::string why = a.check_all(); !why.empty()) return why;
  if (std::string why = check_topology(t); !why.empty()) return why;
  return check_same(t, *build_topology_like(t, material_surface(a)));
}

std::string WorldRunner::finish() {
  try {
    if (std::string why = check(true); !why.empty()) return why;
    // Again: the same bits; and, when nothing depends on how the tissue lies, the same arrangement on another lattice.
    for (const int cell_mm : {case_.cell_mm, case_.cell_mm - 1}) {
      if (cell_mm != case_.cell_mm && (case_.steps || case_.fronts)) break;
      const std::unique_ptr<World> again = make(cell_mm);
      for (const Command& c : all_)
        if (const Wait* w = std::get_if<Wait>(&c))
          wait(*again, w->seconds);
        else
          again->apply(c);
      if (cell_mm == case_.cell_mm && again->full_hash() != world_->full_hash()) return "replay: other bits";
      if (again->skin()->arrangement()->full_hash() != world_->skin()->arrangement()->full_hash() &&
          again->refused() == world_->refused())
        return "replay: another arrangement";
      if (again->skin()->lattice()->pieces != again->skin()->arrangement()->pieces())
        return "I15: replay, other lattice: its pieces are not the surface's";
    }
    while (!done_.empty())
      if (std::string why = act(Undo{}); !why.empty()) return why;
    return check(true);
  } catch (const std::exception& e) {
    return std::string("exception: ") + e.what();
  }
}

WorldOutcome run_world_case(const WorldCase& c, int check_every) {
  WorldRunner r(c, check_every);
  WorldOutcome o;
  for (; o.act < c.acts.size() && o.violation.empty(); o.act += o.violation.empty())
    o.violation = r.apply(c.acts[o.act]);
  if (o.violation.empty()) o.violation = r.finish();
  o.counts = r.counts();
  o.defects = r.defects();
  return o;
}

}  // namespace limberg::fuzz
