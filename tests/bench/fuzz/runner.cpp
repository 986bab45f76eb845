#include "tests/bench/fuzz/runner.h"

#include <algorithm>
#include <cmath>

#include "sim/cutting/arrangement/store.h"
#include "tests/bench/fuzz/checks.h"

namespace limberg::fuzz {

void Counts::add(const Counts& b) {
  operations += b.operations, cuts += b.cuts, done += b.done, nothing += b.nothing, by_rule += b.by_rule;
  folded += b.folded, refused += b.refused, tries += b.tries, excised += b.excised, undone += b.undone;
  redone += b.redone, replayed += b.replayed, faults += b.faults, faults_rolled_back += b.faults_rolled_back;
  full_checks += b.full_checks;
}

Runner::Runner(const Case& c, const Settings& settings) : case_(c), settings_(settings) {
  case_.ops.clear();
  grid_ = make_lattice(c, c.cell_mm);
  a_ = std::make_unique<Arrangement>(make_body(c.body), RestGrid{});
  if (settings.with_lattice) t_ = build_topology(grid_, material_surface(*a_), c.front_levels);
  plan_.skip_embedding = settings.skip_embedding;
  if (settings.skip_embedding) a_->set_fault(&plan_);
  body_volume_ = a_->store().volume_residue;
  volume_mm3_ = a_->volume_mm3();
}

Runner::~Runner() = default;

std::string Runner::apply(const Op& op) {
  ++counts_.operations;
  try {
    std::string why = carry_out(op);
    if (why.empty()) why = check(settings_.check_every > 0 && counts_.operations % settings_.check_every == 0);
    return why;
  } catch (const std::exception& e) {
    return std::string("exception: ") + e.what();
  }
}

std::string Runner::carry_out(const Op& op) {
  const int32_t number = number_++;
  switch (op.kind) {
    case Op::cut:
      return cut(op, number);
    case Op::excise:
      return excise(op, number);
    case Op::undo:
      return undo();
    case Op::redo:
      return redo();
    case Op::replay:
      return replay(op);
    case Op::fault:
      return fault(op);
  }
  return {};
}

Blade Runner::blade_of(const Op& op) const {
  Blade b;
  b.vertex = op.vertex;
  b.tri = op.tri;
  b.seed = op.seed_of_tri;
  b.shared_point.assign(b.vertex.size(), -1);
  for (size_t i = 0; i < op.shared.size(); ++i) {
    const auto& [from, vertex] = op.shared[i];
    if (from < 0) continue;
    for (const Made& m : made_)
      if (m.number == from && size_t(vertex) < m.blade_point.size()) {
        b.shared_point[i] = m.blade_point[size_t(vertex)];
        b.vertex[i] = a_->explicit_point(b.shared_point[i]);
      }
  }
  return b;
}

std::string Runner::cut(const Op& op, int32_t number, int first_try) {
  const uint64_t full = a_->full_hash(), volume = a_->store().volume_residue;
  const int pieces = a_->pieces();
  const std::vector<int32_t> added = a_->last_operation().added, removed = a_->last_operation().removed;
  const auto lattice_before = t_;
  const CutResult r = last_cut = a_->cut(blade_of(op), op.seed, first_try);
  ++counts_.cuts;
  if (!r.ok()) {
    if (r.reason.empty()) return "refusal: no reason is given";
    if (a_->full_hash() != full) return "rollback: a cut that was not made has changed the state";
    if (a_->last_operation().added != added || a_->last_operation().removed != removed)
      return "rollback: a cut that was not made has changed the record of the last operation";
    if (r.status == CutResult::nothing_to_cut)
      ++counts_.nothing;
    else if (r.tries < 8)
      ++counts_.by_rule;
    else if (r.reason == "the blade runs through itself" || r.reason == "the blade has a triangle without area" ||
             r.reason == "the blade runs through the wall that it continues")
      ++counts_.folded;
    else
      ++counts_.refused, counts_.tries += r.tries;
    return {};
  }
  ++counts_.done;
  counts_.tries += r.tries;
  undone_.clear();
  if (a_->store().volume_residue != volume) return "I4: a cut has changed the exact volume";
  if (a_->pieces() < pieces) return "pieces: a cut has joined pieces";
  made_.push_back({number, op, r.blade_point, full, lattice_before, r.tries});
  if (const std::string why = update_lattice(true); !why.empty()) return why;
  if (op.sweep_mm3 < 0) return {};
  const DebrisResult swept = a_->sweep_debris(op.sweep_mm3);
  if (swept.pieces == 0) return {};
  volume_mm3_ -= swept.volume_mm3;
  const auto middle = t_;
  if (const std::string why = update_lattice(false); !why.empty() || !t_) return why;
  t_ = skip_version(*middle, *t_);
  return check_parents(*lattice_before, *t_, false);
}

int32_t Runner::component_of_rank(int which) const {
  const auto& all = a_->components();
  std::vector<int32_t> order;
  for (size_t i = 0; i < all.size(); ++i)
    if (all[i].volume_mm3 > 0) order.push_back(int32_t(i));
  if (order.size() < 2) return -1;
  std::stable_sort(order.begin(), order.end(),
                   [&](int32_t x, int32_t y) { return all[size_t(x)].volume_mm3 < all[size_t(y)].volume_mm3; });
  return order[size_t(which) % order.size()];
}

std::string Runner::excise(const Op& op, int32_t number) {
  const int32_t c = component_of_rank(op.which);
  if (c < 0) return {};
  const uint64_t full = a_->full_hash();
  const int pieces = a_->pieces();
  const auto lattice_before = t_;
  const ExciseResult e = a_->excise(c);
  if (!e.done) return "excision: refused: " + e.reason;
  ++counts_.excised;
  undone_.clear();
  volume_mm3_ -= e.volume_mm3;
  if (a_->pieces() != pieces - 1) return "excision: not exactly one piece has gone";
  made_.push_back({number, op, {}, full, lattice_before, 0});
  return update_lattice(false);
}

std::string Runner::undo() {
  if (made_.empty()) return a_->undo() ? "undo: something was taken back that was never done" : std::string();
  const uint64_t after = a_->full_hash();
  if (!a_->undo()) return "undo: refused";
  ++counts_.undone;
  const Made& m = made_.back();
  if (a_->full_hash() != m.full_before) return "undo: the full hash is not the one of before";
  t_ = m.lattice_before;
  undone_.push_back({m.op, m.number, after, m.tries});
  made_.pop_back();
  volume_mm3_ = a_->volume_mm3();
  return {};
}

std::string Runner::redo() {
  if (undone_.empty()) return {};
  const std::vector<Undone> rest(undone_.begin(), undone_.end() - 1);
  const Undone again = undone_.back();
  // Every other time straight from the try that went right, as a redo does that wants to lose no time.
  const int first_try = number_ % 2 ? again.tries - 1 : 0;
  const std::string why =
      again.op.kind == Op::cut ? cut(again.op, again.number, first_try) : excise(again.op, again.number);
  if (!why.empty()) return why;
  ++counts_.redone;
  if (a_->full_hash() != again.full_after) return "redo: the full hash is not the one of before the undo";
  undone_ = rest;
  return {};
}

std::string Runner::replay(const Op& op) {
  ++counts_.replayed;
  Case c = case_;
  if (op.cell_mm > 0) c.cell_mm = case_.cell_mm;
  Runner other(c, {0, false, settings_.skip_embedding});
  for (const Made& m : made_) {
    other.number_ = m.number;
    if (const std::string why = other.apply(m.op); !why.empty()) return "replay: " + why;
  }
  if (other.made_.size() != made_.size()) return "replay: other operations were made";
  if (other.a_->full_hash() != a_->full_hash()) return "replay: the full hash differs";
  if (!settings_.with_lattice || op.cell_mm <= 0) return {};
  const auto fine = build_topology(make_lattice(case_, op.cell_mm), material_surface(*a_));
  if (const std::string why = check_topology(*fine); !why.empty()) return "replay, other lattice: " + why;
  if (fine->pieces != a_->pieces()) return "I15: replay, other lattice: its pieces are not the surface's";
  if (std::abs(fine->volume_mm3 - a_->volume_mm3()) > 1e-9 * body_volume_mm3(case_.body))
    return "I6: replay, other lattice: the volume differs";
  return op.cell_mm == case_.cell_mm / 2 && case_.front_levels == 0 ? check_refines(*t_, *fine) : std::string();
}

std::string Runner::fault(const Op& op) {
  ++counts_.faults;
  const uint64_t full = a_->full_hash();
  const std::vector<int32_t> added = a_->last_operation().added;
  const Blade blade = blade_of(op);
  FaultPlan plan;
  FaultPlan* const normal = a_->store().points.fault;
  // How many signs and steps there are.
  a_->set_fault(&plan);
  const CutResult count = a_->cut(blade, op.seed);
  const auto finish = [&](std::string why) {
    a_->set_fault(normal);
    if (why.empty() && a_->full_hash() != full) why = "fault: the state has changed";
    return why;
  };
  if (op.in_lattice) {
    if (!count.ok()) return finish({});
    if (!t_) return a_->undo(), finish({});
    FaultPlan lattice;
    a_->set_fault(&lattice);
    update_topology(*t_, material_surface(*a_));
    lattice.at = std::min(lattice.calls - 1, int64_t(op.place * double(lattice.calls)));
    lattice.until = lattice.at + 1;
    lattice.calls = 0;
    lattice.kind = op.thrown ? FaultPlan::thrown : FaultPlan::zero;
    const uint64_t before = t_->hash();
    bool failed = false;
    try {
      update_topology(*t_, material_surface(*a_));
    } catch (const std::exception&) {
      failed = true;
      ++counts_.faults_rolled_back;
    }
    if (!failed && lattice.struck > 0) return finish("fault: the lattice update has hidden a failure");
    if (t_->hash() != before) return finish("fault: a failed update has changed the lattice");
    a_->undo();
    return finish({});
  }
  if (count.ok()) a_->undo();
  if (a_->full_hash() != full) return finish("undo: the full hash is not the one of before");
  plan.kind = op.thrown ? FaultPlan::thrown : FaultPlan::zero;
  plan.at = std::min(plan.calls - 1, int64_t(op.place * double(plan.calls)));
  plan.until = op.lasting ? INT64_MAX : plan.at + 1;
  plan.calls = 0;
  CutResult r;
  try {
    r = a_->cut(blade, op.seed);
  } catch (const std::bad_alloc&) {
  }
  a_->set_fault(normal);
  if (!r.ok()) {
    ++counts_.faults_rolled_back;
    if (a_->full_hash() == full && a_->last_operation().kind != LastOperation::undone && !count.ok() &&
        a_->last_operation().added != added)
      return finish("fault: the record of the last operation has changed");
    if (const std::string why = a_->check_all(); !why.empty()) return finish("fault: " + why);
    return finish({});
  }
  // A later try went right, or the zero did not matter: then it is a cut like any other.
  if (const std::string why = a_->check_all(); !why.empty()) return finish("fault: a wrong cut was made: " + why);
  a_->undo();
  return finish({});
}

std::string Runner::update_lattice(bool only_cuts) {
  if (!settings_.with_lattice) return {};
  const auto before = t_;
  t_ = update_topology(*before, material_surface(*a_));
  return check_parents(*before, *t_, only_cuts);
}

std::string Runner::check(bool full) {
  const double scale = body_volume_mm3(case_.body);
  if (std::abs(a_->volume_mm3() - volume_mm3_) > 1e-10 * scale) return "I4: the volume has drifted";
  if (t_) {
    if (t_->pieces != a_->pieces())
      return "I15: the lattice has " + std::to_string(t_->pieces) + " pieces, the surface " +
             std::to_string(a_->pieces());
    if (t_->walks_unresolved) return "lattice: a closed curve was not resolved";
    if (std::abs(t_->volume_mm3 - a_->volume_mm3()) > 1e-9 * scale) return "I6: the mass differs from the volume";
  }
  if (!full) return {};
  ++counts_.full_checks;
  if (const std::string why = a_->check_all(); !why.empty()) return why;
  if (!t_) return {};
  if (const std::string why = check_topology(*t_); !why.empty()) return "lattice: " + why;
  return check_same(*t_, *build_topology_like(*t_, material_surface(*a_)));
}

Outcome run_case(const Case& c, const Settings& settings) {
  Outcome out;
  try {
    Runner r(c, settings);
    for (size_t i = 0; i < c.ops.size(); ++i) {
      out.violation = r.apply(c.ops[i]);
      out.counts = r.counts();
      if (!out.violation.empty()) {
        out.op = int32_t(i);
        return out;
      }
    }
    // And all of it back.
    while (!r.made().empty()) {
      Op back;
      back.kind = Op::undo;
      out.violation = r.apply(back);
      if (!out.violation.empty()) {
        out.op = int32_t(c.ops.size());
        return out;
      }
    }
  } catch (const std::exception& e) {
    out.violation = std::string("exception: ") + e.what();
  }
  return out;
}

}  // namespace limberg::fuzz
