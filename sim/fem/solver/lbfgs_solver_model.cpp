// What the solver is given: models, springs, contacts; and what of its state each of them leaves.
#include <algorithm>
#include <cmath>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/fem/model/hanging_nodes.h"
#include "sim/fem/solver/lbfgs_solver.h"

namespace limberg::fem {
namespace {

constexpr double floor_strain = 1e-3;  // what the force scale of a block at rest is taken from
// a cell's material, as a fraction; nodes of fuller ones do not fly about (shipped Z-plasty)
constexpr float sliver = 0.2f;
constexpr size_t small_model = 3000;  // nodes: a shorter history pays there

}  // namespace

int LbfgsSolver::pairs() const {
  return own_.pairs > 0 ? own_.pairs : model_ && model_->X_mm.size() < small_model ? 5 : 8;
}

void LbfgsSolver::set_model(std::shared_ptr<const FemModel> model, const ParentList& cell_parent) {
  const size_t n = model->X_mm.size(), cells = model->cells.size();
  if (model->fixed.size() != n || model->mass_kg.size() != n || model->parent.size() != n)
    throw InputError("", 0, "a model's fixed, mass and parent lists must have one entry per node");
  if (const std::string wrong = check_hanging(*model); !wrong.empty()) throw InputError("", 0, wrong);
  auto elements = std::make_unique<ElementSystem>(model, augmented_, model_.get(), elements_.get());
  const auto carried = [&](const NodeArray& old) {
    NodeArray out(n);
    const size_t same = std::min({model->parent.same(), old.size(), n});
    std::copy_n(old.data(), same, out.data());
    for (size_t i = same; i < n; ++i) {
      const int32_t p = model->parent[i];
      if (p >= 0 && size_t(p) < old.size()) out[i] = old[size_t(p)];
    }
    for (const BornNode& b : model->born) {
      v4 s = {};
      for (auto [p, w] : b.from)
        if (p >= 0 && size_t(p) < old.size()) s += w * load(old[size_t(p)]);
      store(out[size_t(b.node)], s);
    }
    follow_masters(model->hanging, out);
    return out;
  };
  u_ = carried(u_);
  velocity_ = carried(velocity_);
  if (before_s_ > 0) u_before_ = carried(u_before_), velocity_before_ = carried(velocity_before_);
  if (elements_)
    for (size_t c = 0; c < cells && c < cell_parent.size(); ++c)
      if (cell_parent[c] >= 0 && size_t(cell_parent[c]) < elements_->cells())
        elements->set_q(c, elements_->q(size_t(cell_parent[c])));
  elements_ = std::move(elements);
  const bool same_matter = model_ && same_stencils(*model, *model_);
  if (!same_matter || !points_.in_no_stencil()) points_ = MaterialPoints(*model);
  if (!same_matter || !viscous_.in_no_stencil()) {
    ViscousPoints viscous(*model);
    viscous.carry(viscous_, cell_parent, u_);
    viscous_ = std::move(viscous);
  }
  if (!same_matter) {
    floor_weight_.clear();
    for (const Stencil& st : model->stencils)
      floor_weight_.push_back({st.mu_kPa, elementary::pow(st.volume_mm3, 2.0 / 3)});
  }
  model_ = std::move(model);
  fixed_.clear(), sliding_.clear();
  for (size_t i = 0; i < n; ++i)
    if (const Held h = model_->fixed[i]; h.any()) (h.all() ? fixed_ : sliding_).push_back(int32_t(i));
  drop_held(velocity_);
  if (before_s_ > 0) put_held(u_before_, u_), drop_held(velocity_before_);
  std::vector<double> floor(n, 0);
  std::vector<float> fullest(n, 0);
  const SharedArray<HexCell>& present = model_->cells;
  for (size_t chunk = 0; chunk < present.chunks(); ++chunk)
    for (size_t k = 0; k < present.run_length(chunk); ++k) {
      const HexCell& c = present.run(chunk)[k];
      const auto [mu_kPa, area_mm2] = floor_weight_[size_t(c.stencil)];
      const double share = floor_strain * double(c.scale) * mu_kPa * area_mm2;
      for (int32_t v : c.node) floor[size_t(v)] += share, fullest[size_t(v)] = std::max(fullest[size_t(v)], c.scale);
    }
  force_floor_ = 0;
  for (size_t i = 0; i < n; ++i)
    if (!model_->fixed[i].all()) force_floor_ += floor[i] * floor[i];
  force_floor_ = std::sqrt(force_floor_);
  // Of tissue as thin everywhere nothing is a sliver: that has to hang on a fuller cell.
  std::vector<char> aside(n, 1);
  for (size_t chunk = 0; chunk < present.chunks(); ++chunk)
    for (size_t k = 0; k < present.run_length(chunk); ++k) {
      const HexCell& c = present.run(chunk)[k];
      const bool hangs =
          std::any_of(c.node.begin(), c.node.end(), [&](int32_t v) { return fullest[size_t(v)] >= sliver; });
      if (!hangs)
        for (int32_t v : c.node) aside[size_t(v)] = 0;
    }
  of_slivers_.clear();
  for (size_t i = 0; i < n; ++i)
    if (fullest[i] < sliver && aside[i]) of_slivers_.push_back(int32_t(i));
  slivers_.clear();
  int32_t cell = 0;
  for (size_t chunk = 0; chunk < present.chunks(); ++chunk)
    for (size_t k = 0; k < present.run_length(chunk); ++k, ++cell)
      if (const HexCell& c = present.run(chunk)[k]; std::any_of(
              c.node.begin(), c.node.end(), [&](int32_t v) { return fullest[size_t(v)] < sliver && aside[size_t(v)]; }))
        slivers_.push_back(cell);
  for (NodeArray* a : {&g_, &d_, &u_try_, &g_try_}) a->resize(n);
  history_.resize(n, pairs());
  springs_.clear(), spring_rows_.clear();
  stretched_.clear(), lagging_iterations_ = 0;
  forces_ = SpringForces();
  contacts_ = ContactForces();
  load_list_.clear();
  make_loads(), loose_known_ = false;
  hardened_.carry(cell_parent, cells);
  metric_.set_model(hardened_.seen(model_, false), cell_parent);
  force_scale_ = 0, since_update_ = 0;
  tangled_iterations_ = 0, untangling_ = false;
  scale_.forget(), level_watch_ = {}, pairs_are_plain_ = false;
  distance_.forget();
  publish();
}

void LbfgsSolver::set_springs(std::span<const Spring> springs) {
  if (!model_) throw InputError("", 0, "springs were given before a model");
  const int32_t n = int32_t(model_->X_mm.size());
  for (const Spring& s : springs) {
    const auto there = [&](std::span<const HeldPlace> end) {
      return std::all_of(end.begin(), end.end(), [&](const EmbeddedPoint& p) {
        return std::all_of(p.node.begin(), p.node.end(), [&](int32_t i) { return i >= 0 && i < n; });
      });
    };
    if (!there(s.held_a()) || (!s.to_world && !there(s.held_b())))
      throw InputError("", 0, "spring " + std::to_string(s.id) + " names a node that the model does not have");
    if (!(s.k_N_per_mm > 0) || !s.target_mm.allFinite())
      throw InputError("", 0, "spring " + std::to_string(s.id) + " has no positive stiffness or no finite target");
    if (s.thread > 0 && (s.to_world || !(s.thread_mm >= 0)))
      throw InputError("", 0,
                       "spring " + std::to_string(s.id) + " is a span of a thread without two bites and a length");
  }
  std::vector<Spring> sorted(springs.begin(), springs.end());
  std::sort(sorted.begin(), sorted.end(), [](const Spring& a, const Spring& b) { return a.id < b.id; });
  for (size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i].id == sorted[i - 1].id)
      throw InputError("", 0, "two springs have the id " + std::to_string(sorted[i].id));
  const bool same = std::equal(sorted.begin(), sorted.end(), springs_.begin(), springs_.end(), held_alike);
  const auto stands = [](const Spring& a, const Spring& b) { return !a.to_world || a.target_mm == b.target_mm; };
  const bool carried = same && !std::equal(sorted.begin(), sorted.end(), springs_.begin(), stands);
  if (carried) lagging_iterations_ = 0;
  bool drawn = false;
  for (size_t i = 0; same && i < sorted.size(); ++i)
    drawn |= !sorted[i].to_world &&
             (sorted[i].target_mm != springs_[i].target_mm || sorted[i].thread_mm != springs_[i].thread_mm);
  if (drawn) history_.clear();
  if (!same || carried || drawn) level_watch_ = {};
  springs_ = std::move(sorted);
  forces_ = SpringForces(*model_, springs_);
  if (same) return;
  history_.clear();
  make_loads(), loose_known_ = false;  // a piece may be held that was loose, or the other way round
  spring_rows_.clear();
  for (const Spring& s : springs_) spring_rows_.push_back({spring_row(*model_, s), s.lasting || !s.to_world});
  give_metric_springs();
}

void LbfgsSolver::look_at_cells() {
  const bool stretched = stretched_.follow(*model_, u_, augmented_, engine_);
  const bool hardened = !points_.empty() && hardened_.follow(*model_, u_, engine_);
  if (hardened) show_hard_cells();
  if (stretched || hardened) give_metric_springs();
}

void LbfgsSolver::show_hard_cells() {
  metric_.set_model(hardened_.seen(model_, true), ParentList::identity(model_->cells.size()));
}

void LbfgsSolver::give_metric_springs() {
  std::vector<Preconditioner::SpringEntry> rows = spring_rows_;
  for (const SpringRow& r : stretched_.rows()) rows.push_back({r});
  metric_.set_springs(rows);
}

void LbfgsSolver::set_gravity(const Vec3& m_s2) {
  if (!m_s2.allFinite())
    throw InputError("", 0, "gravity is not a number; three finite numbers in m/s^2 were expected");
  if (m_s2 == gravity_m_s2_) return;
  gravity_m_s2_ = m_s2;
  lagging_iterations_ = 0;
  make_loads();
}

void LbfgsSolver::set_loads(std::span<const DeadLoad> loads) {
  if (loads.empty() && load_list_.empty()) return;
  if (!model_) throw InputError("", 0, "loads were given before a model");
  const int32_t n = int32_t(model_->X_mm.size());
  for (size_t k = 0; k < loads.size(); ++k) {
    const std::string name = "load " + std::to_string(k + 1);
    if (loads[k].at.empty() || !loads[k].force_mN.allFinite())
      throw InputError("", 0, name + " has no place or no finite force; both were expected");
    for (const EmbeddedPoint& p : loads[k].at)
      for (int32_t v : p.node)
        if (v < 0 || v >= n) throw InputError("", 0, name + " names a node that the model does not have");
  }
  load_list_.assign(loads.begin(), loads.end());
  make_loads();
}

void LbfgsSolver::make_loads() {
  level_watch_ = {};
  loads_ = model_ ? DeadLoads(*model_, gravity_m_s2_, load_list_, springs_) : DeadLoads();
  loads_.dynamic(!inertia_.empty());
}

void LbfgsSolver::find_loose_pieces() {
  if (loose_known_ || contacts_.empty()) return;
  loose_ = LoosePieces(*model_, springs_), loose_known_ = true;
}

void LbfgsSolver::put_held(NodeArray& a, const NodeArray& from) const {
  const auto value = [&](size_t i) { return from.empty() ? Node4{} : from[i]; };
  for (int32_t i : fixed_) a[size_t(i)] = value(size_t(i));
  for (int32_t i : sliding_) {
    const Node4 v = value(size_t(i));
    for (int k = 0; k < 3; ++k)
      if (model_->fixed[size_t(i)].along(k)) (&a[size_t(i)].x)[k] = (&v.x)[k];
  }
}

void LbfgsSolver::set_contacts(std::span<const Contact> contacts) {
  if (!model_) throw InputError("", 0, "contacts were given before a model");
  level_watch_ = {};
  contacts_.set(*model_, contacts, engine_.workers());
}

}  // namespace limberg::fem
