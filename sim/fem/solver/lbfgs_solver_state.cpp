// What the solver shows and gives back: displacements, states to return to, forces, deformation of cells.
#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/fem/model/hanging_nodes.h"
#include "sim/fem/solver/lbfgs_solver.h"

namespace limberg {

Vec3 ElasticSolver::position_mm(const EmbeddedPoint& p) const {
  const std::span<const Vec3f> u = displacement_mm();
  Vec3 x = Vec3::Zero();
  double sum = 0;
  for (size_t i = 0; i < 8; ++i) {
    if (p.w[i] == 0) continue;
    const size_t n = size_t(p.node[i]);
    x += double(p.w[i]) * (model().X_mm[n] + u[n].cast<double>());
    sum += double(p.w[i]);
  }
  return sum > 0 ? Vec3(x / sum) : x;
}

Vec3 ElasticSolver::support_force_mN() const {
  Vec3 sum = Vec3::Zero();
  for (const SupportForce& f : support_forces_mN()) sum += f.force_mN;
  return sum;
}

}  // namespace limberg

namespace limberg::fem {
namespace {

struct LbfgsPath final : SolverPath {
  ComponentMetric::Past metric;
  StretchedCells stretched;
  HardenedCells hardened;
  int lagging_iterations = 0;
};

}  // namespace

std::shared_ptr<const SolverPath> LbfgsSolver::path() const {
  auto path = std::make_shared<LbfgsPath>();
  path->metric = metric_.past(), path->lagging_iterations = lagging_iterations_;
  path->stretched = stretched_, path->hardened = hardened_;
  return path;
}

void LbfgsSolver::take_up(const SolverPath& path) {
  const auto& p = dynamic_cast<const LbfgsPath&>(path);
  stretched_ = p.stretched, lagging_iterations_ = p.lagging_iterations;
  if (!(hardened_ == p.hardened)) {
    hardened_ = p.hardened;
    show_hard_cells();
  }
  metric_.take_up(p.metric);
  give_metric_springs();
}

void LbfgsSolver::forget() {
  tangled_iterations_ = 0, untangling_ = false;
  history_.clear();
  scale_.forget();
  level_watch_ = {};
  distance_.forget();
}

void LbfgsSolver::publish() {
  shown_.resize(u_.size());
  for (size_t i = 0; i < u_.size(); ++i) shown_[i] = {u_[i].x, u_[i].y, u_[i].z};
}

void LbfgsSolver::set_displacement_mm(std::span<const Vec3f> u) {
  if (u.size() != u_.size()) throw InputError("", 0, "a displacement needs one vector per node of the model");
  for (size_t i = 0; i < u.size(); ++i) u_[i] = {u[i][0], u[i][1], u[i][2], 0};
  follow_masters(model_->hanging, u_);
  velocity_.zero(), before_s_ = 0;
  forget();
  publish();
}

SolverState LbfgsSolver::save() const {
  const auto flat = [](const NodeArray& from) {
    std::vector<float> to;
    to.reserve(3 * from.size());
    bool any = false;
    for (size_t i = 0; i < from.size(); ++i)
      for (const float v : {from[i].x, from[i].y, from[i].z}) to.push_back(v), any = any || v != 0 || std::signbit(v);
    return any ? to : std::vector<float>();
  };
  SolverState s;
  s.displacement_mm = flat(u_);
  s.velocity_mm_s = flat(velocity_);
  s.since_update = since_update_;
  s.before_s = before_s_;
  if (before_s_ > 0) s.displacement_before_mm = flat(u_before_), s.velocity_before_mm_s = flat(velocity_before_);
  s.memory = viscous_.memory();
  if (!elements_ || !elements_->has_multipliers()) return s;
  s.pressure.resize(elements_->cells());
  bool any = false;
  for (size_t c = 0; c < s.pressure.size(); ++c) any = (s.pressure[c] = elements_->q(c)) != 0 || any;
  if (!any) s.pressure.clear();
  return s;
}

void LbfgsSolver::restore(const SolverState& s) {
  const auto fits = [](const std::vector<float>& v, size_t n) { return v.empty() || v.size() == n; };
  if (!model_ || !fits(s.displacement_mm, 3 * u_.size()) || !fits(s.velocity_mm_s, 3 * u_.size()) ||
      !fits(s.displacement_before_mm, 3 * u_.size()) || !fits(s.velocity_before_mm_s, 3 * u_.size()) ||
      !fits(s.pressure, elements_->cells()) || !viscous_.fits(s.memory))
    throw InputError("", 0, "a solver's state is of another model; expected one that was saved with this model");
  const auto fill = [](NodeArray& to, const std::vector<float>& from) {
    for (size_t i = 0; i < to.size(); ++i)
      to[i] = from.empty() ? Node4{} : Node4{from[3 * i], from[3 * i + 1], from[3 * i + 2], 0};
  };
  fill(u_, s.displacement_mm);
  fill(velocity_, s.velocity_mm_s);
  before_s_ = s.before_s;
  if (before_s_ > 0) {
    u_before_.resize(u_.size()), velocity_before_.resize(u_.size());
    fill(u_before_, s.displacement_before_mm), fill(velocity_before_, s.velocity_before_mm_s);
  }
  for (size_t c = 0; c < elements_->cells(); ++c) elements_->set_q(c, s.pressure.empty() ? 0 : s.pressure[c]);
  since_update_ = s.since_update;
  viscous_.restore(s.memory);
  forget();
  publish();
}

Vec3 LbfgsSolver::spring_force_mN(int32_t id) const {
  const int i = forces_.find(id);
  return i < 0 ? Vec3::Zero() : forces_.force_mN(size_t(i), u_);
}

double LbfgsSolver::contact_force_mN(size_t i) const { return i < contacts_.size() ? contacts_.force_mN(i, u_) : 0; }

Vec3 LbfgsSolver::contact_friction_mN(size_t i) const {
  return i < contacts_.size() ? contacts_.friction_mN(i, u_) : Vec3::Zero();
}

std::vector<SupportForce> LbfgsSolver::support_forces_mN() const {
  NodeArray g(u_.size());
  elements_->evaluate(u_, g, false, engine_);
  forces_.add(u_, g, false);
  ContactForces(contacts_).add(u_, g, false);
  points_.add(u_, g, false, engine_.workers());
  if (double size = 0; !loads_.empty()) loads_.add(u_, g, false, size);
  give_to_masters(model_->hanging, g);
  std::vector<SupportForce> out;
  for (size_t i = 0; i < g.size(); ++i) {
    const Held held = model_->fixed[i];
    if (!held.any()) continue;
    SupportForce& f = out.emplace_back(SupportForce{int32_t(i), Vec3::Zero()});
    for (int k = 0; k < 3; ++k)
      if (held.along(k)) f.force_mN[k] = -double((&g[i].x)[k]);
  }
  return out;
}

double LbfgsSolver::first_move_mm(std::span<const SupportForce> forces) {
  NodeArray r(u_.size()), z(u_.size());
  for (const SupportForce& f : forces) {
    Node4& at = r[size_t(f.node)];
    at.x += float(f.force_mN[0]), at.y += float(f.force_mN[1]), at.z += float(f.force_mN[2]);
  }
  give_to_masters(model_->hanging, r);
  drop_held(r);
  metric_.apply(r, z);
  return engine_.max_node(z);
}

double LbfgsSolver::next_move_mm(std::span<const uint8_t> marked) const {
  float most = 0;
  for (size_t i = 0; i < marked.size() && i < d_.size(); ++i)
    if (marked[i] == 1) most = std::max(most, d_[i].x * d_[i].x + d_[i].y * d_[i].y + d_[i].z * d_[i].z);
  return std::sqrt(double(most));
}

void LbfgsSolver::cell_J(std::vector<float>& J) const {
  J.resize(model_->cells.size());
  const SharedArray<HexCell>& cells = model_->cells;
  for (size_t c = 0; c < J.size(); ++c)
    J[c] =
        float(gradient_at(volume_gradients(model_->stencils[size_t(cells[c].stencil)], model_->cell_mm), cells[c], u_)
                  .determinant());
}

Mat3 LbfgsSolver::cell_F(int32_t cell) const {
  const SharedArray<HexCell>& cells = model_->cells;
  const HexCell& c = cells[size_t(cell)];
  return gradient_at(sample_gradients(model_->stencils[size_t(c.stencil)], model_->cell_mm), c, u_);
}

std::string LbfgsSolver::describe() const {
  return "L-BFGS(" + std::to_string(pairs()) + ") on " + metric_.describe() +
         (elements_ && elements_->has_multipliers() ? ", augmented-Lagrangian pressure" : ", primal");
}

}  // namespace limberg::fem
