#include "sim/fem/solver/lbfgs_solver.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/fem/model/hanging_nodes.h"
#include "sim/fem/model/held_pieces.h"
#include "sim/fem/solver/stall_watch.h"

namespace limberg {

std::unique_ptr<ElasticSolver> make_solver(Workers& workers) { return std::make_unique<fem::LbfgsSolver>(workers); }

}  // namespace limberg

namespace limberg::fem {
namespace {

constexpr int update_every = 3;   // accepted iterates between multiplier updates
constexpr int max_halvings = 40;  // a scrambled start needs many
constexpr double armijo = 1e-4;
constexpr double slope_left = 0.5;    // Hager & Zhang's sigma is 0.9; an overshoot to .9998 of the slope gains nothing
constexpr double above_floor = 1;     // reached: .4 times (an S-plasty on a face, 27,996 nodes, 2026-11-29)
constexpr double float_noise = 5e-8;  // of a sum of single-precision terms, relative to the sum of their sizes
// Drawn-out cells are looked for when so many iterations have not brought the relative residual down to `lags`. Not
// while a hook is carried: a look takes about as long as two iterations, and what lags then is the hand's doing (60 Hz
// drag of `bench speed`, 30k nodes, nu .499, 2026-11-22: looks at every step left 2.6 iterations a frame of 6.2).
constexpr double lags = 1e-3;
constexpr int lags_for = 10;
// A tangle: so many cells inverted, and so little balance, for so long. Measured (2026-11-21): scrambled blocks of one
// tissue are out of it after some 30 iterations; thin skin on fat in shared cells, 60 and 400 : 1, comes back in 100 of
// 100 scrambles with 40 and with
// 70 (at 100 it leaves eight by itself, folded, at rest in another equilibrium); no shipped operation ever has two
// inverted cells in a hundred.
constexpr double tangled_cells = 0.02, tangled_residual = 0.3;
constexpr int tangled_for = 40, untangle_for = 80;
constexpr double untangled_residual = 0.01;

}  // namespace

bool LbfgsSolver::Value::finite() const { return std::isfinite(energy); }

LbfgsSolver::Value LbfgsSolver::evaluate(const NodeArray& u, NodeArray& g, bool measure) {
  const CellSums cells = elements_->evaluate(u, g, measure, engine_);
  const double springs = forces_.add(u, g, measure);
  Value v{cells.energy + springs, float_noise * (cells.magnitude + springs)};
  if (!contacts_.empty()) {
    const double pressed = contacts_.add(u, g, measure, engine_.workers());
    v.energy += pressed, v.noise += float_noise * pressed;
  }
  if (!points_.empty()) {
    const CellSums p = points_.add(u, g, measure, engine_.workers());
    v.energy += p.energy, v.noise += float_noise * p.magnitude;
  }
  if (viscous_.in_step()) {
    const CellSums p = viscous_.add(u, g, measure, engine_);
    v.energy += p.energy, v.noise += float_noise * p.magnitude;
  }
  if (!inertia_.empty()) {
    double e = 0;
    for (size_t i = 0; i < g.size(); ++i) {
      const v4 r = load(u[i]) - load(inertia_target_[i]);
      const v4 f = inertia_[i] * r;
      const float size = 0.5f * (f[0] * r[0] + f[1] * r[1] + f[2] * r[2]);
      e += double(size);
      store(g[i], load(g[i]) + f);
      if (measure) g[i].w += std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
    }
    v.energy += e, v.noise += float_noise * e;
  }
  if (!loads_.empty()) {
    double size = 0;
    v.energy += loads_.add(u, g, measure, size), v.noise += float_noise * size;
  }
  give_to_masters(model_->hanging, g);
  drop_held(g);
  if (measure) {
    double sum = force_floor_ * force_floor_;
    for (Node4& n : g) sum += double(n.w) * double(n.w), n.w = 0;
    force_scale_ = std::sqrt(sum);
  }
  return v;
}

double LbfgsSolver::relative_residual() const {
  const double g = std::sqrt(engine_.dot(g_, g_));
  return force_scale_ > 0 ? g / force_scale_ : (g > 0 ? 1 : 0);
}

void LbfgsSolver::prepare_dynamics(const StepSettings& s) {
  loads_.dynamic(s.dt_s > 0);
  if (!(s.dt_s > 0)) {
    inertia_.clear();
    return;
  }
  viscous_.begin_step(s.dt_s);
  const size_t n = u_.size();
  const bool two_steps = s.integrator == Integrator::bdf2 && before_s_ == s.dt_s;
  h_s_ = two_steps ? 2 * s.dt_s / 3 : s.dt_s;
  const double a = 1 / (h_s_ * h_s_), c = s.damping_per_s / h_s_;
  if (inertia_target_.size() != n) inertia_target_.resize(n);
  inertia_.resize(n);
  u_base_ = u_;
  const float ahead = float(h_s_ * a / (a + c));
  fall_mm_ = 1000 / (a + c) * gravity_m_s2_;
  constexpr float third = 1.0f / 3;
  for (size_t i = 0; i < n; ++i) {
    v4 v = load(velocity_[i]);
    if (two_steps) {  // as differences, so that a body at rest stays there to the last bit
      store(u_base_[i], load(u_[i]) + third * (load(u_[i]) - load(u_before_[i])));
      v += third * (v - load(velocity_before_[i]));
    }
    inertia_[i] = float(model_->mass_kg[i] * (a + c));
    store(inertia_target_[i], load(u_base_[i]) + ahead * v);
  }
}

// Free flight is then exact before the first iteration; where
// the tissue resists, the old place may be the better start.
void LbfgsSolver::start_where_inertia_leads(Value& value) {
  u_try_ = inertia_target_;
  if (!fall_mm_.isZero(0)) {
    const v4 fall = {float(fall_mm_[0]), float(fall_mm_[1]), float(fall_mm_[2]), 0};
    for (Node4& x : u_try_) store(x, load(x) + fall);
  }
  put_held(u_try_, u_);
  follow_masters(model_->hanging, u_try_);
  const Value ahead = evaluate(u_try_, g_try_, true);
  if (ahead.finite() && engine_.all_finite(g_try_) && ahead.energy < value.energy) {
    u_.swap(u_try_), g_.swap(g_try_);
    value = ahead;
  } else {
    value = evaluate(u_, g_, true);  // the force scale is that of the place we stay at
  }
}

// Backtracking along d_ from u_; on success u_, g_ and value are the new point and the pair is in the history.
LbfgsSolver::Search LbfgsSolver::search(Value& value, double slope) {
  double alpha = 1;
  for (int h = 0; h < max_halvings; ++h) {
    engine_.combine(u_try_, u_, alpha, d_);
    follow_masters(model_->hanging, u_try_);
    const Value t = evaluate(u_try_, g_try_, false);
    bool accept = false, level = false;
    double next = 0.1;
    if (t.finite()) {
      const double change = t.energy - value.energy;
      level = std::fabs(change) <= value.noise + t.noise;
      const double bend = change - alpha * slope;
      if (bend > 0) next = std::clamp(-0.5 * alpha * slope / bend, 0.1, 0.5);
      accept = change <= armijo * alpha * slope;
      if (level) {
        const double end = engine_.dot(g_try_, d_);
        accept = end <= -slope_left * slope;
        if (!accept) next = std::clamp(slope / (slope - end), 0.01, 0.9);  // where the slope would be zero
      }
    }
    if (accept && engine_.all_finite(g_try_)) {
      engine_.subtract(history_.next_s(), u_try_, u_);
      engine_.subtract(history_.next_y(), g_try_, g_);
      history_.push(engine_);
      u_.swap(u_try_), g_.swap(g_try_);
      value = t, level_ = level;
      if (!points_.empty()) scale_.accepted(h > 0, gamma_);
      distance_.moved(u_);
      return Search::moved;
    }
    alpha *= next;
  }
  return Search::stuck;
}

bool LbfgsSolver::every_piece_is_held() const {
  const HeldPieces pieces = held_pieces(*model_, {});
  return std::all_of(model_->cells.begin(), model_->cells.end(),
                     [&](const HexCell& c) { return pieces.held[size_t(c.node[0])].all(); });
}

void LbfgsSolver::begin_or_end_untangling(Value& value, bool dynamic) {
  if (untangling_) {
    elements_->shape_only(true);
    value = evaluate(u_, g_, true);
    if (!dynamic && untangling_iterations_ < untangle_for && relative_residual() > untangled_residual) return;
    untangling_ = false;
  } else if (tangled_iterations_ >= tangled_for && !dynamic && points_.empty() && every_piece_is_held()) {
    untangling_ = true, untangling_iterations_ = 0;
  } else {
    return;
  }
  tangled_iterations_ = 0;
  elements_->shape_only(untangling_);
  for (size_t c = 0; c < elements_->cells(); ++c) elements_->set_q(c, 0);
  since_update_ = 0;
  history_.clear();
  value = evaluate(u_, g_, true);
}

void LbfgsSolver::take_plain_energy(bool plain, Value& value) {
  if (pairs_are_plain_ != plain) history_.clear();
  pairs_are_plain_ = plain;
  if (!plain) return;
  elements_->plain(true);
  since_update_ = 0;
  value = evaluate(u_, g_, true);
}

bool LbfgsSolver::at_floor() {
  uint32_t bits = 1;
  const auto nudged = [&bits](float v) {
    bits = bits * 1664525u + 1013904223u;
    return v == 0 ? v : std::nextafter(v, bits >> 31 ? 2 * v : 0.0f);
  };
  u_try_ = u_;
  for (Node4& n : u_try_) n.x = nudged(n.x), n.y = nudged(n.y), n.z = nudged(n.z);
  put_held(u_try_, u_);
  follow_masters(model_->hanging, u_try_);
  evaluate(u_try_, g_try_, false);
  engine_.subtract(d_, g_try_, g_);
  return engine_.dot(g_, g_) <= above_floor * above_floor * engine_.dot(d_, d_);
}

double LbfgsSolver::direction(const NodeArray& g, const std::function<void(const NodeArray&, NodeArray&)>& metric) {
  gamma_ = history_.direction(g, d_, metric, engine_, scale_.on());
  if (inertia_.empty() && !contacts_.empty()) loose_.shorten(d_);
  return engine_.dot(g, d_);
}

// The gradient at u_ must be in g_.
double LbfgsSolver::next_move_mm(const std::function<void(const NodeArray&, NodeArray&)>& metric) {
  const NodeArray* g = &g_;
  if (AlignedArray<float> q; !untangling_ && elements_->settle_multipliers(q, slivers_)) {
    evaluate(u_, g_try_, false);
    elements_->swap_multipliers(q);
    g = &g_try_;
  }
  direction(*g, metric);
  return engine_.max_node(d_);
}

// Of a step that must first forget or look at its cells nothing can be said yet.
void LbfgsSolver::make_ready(const StepSettings& s) {
  if (model_ && !s.afresh && s.dt_s == 0 && lagging_iterations_ < lags_for) metric_.make_ready(0);
}

StepReport LbfgsSolver::step(const StepSettings& s) {
  if (!model_) throw InputError("", 0, "a step was asked for before a model was given");
  if (s.afresh) forget();
  prepare_dynamics(s), find_loose_pieces();
  // BDF2's first step has the metric of its others.
  const double h = s.integrator == Integrator::bdf2 ? 2 * s.dt_s / 3 : s.dt_s;
  const double mass_per_s2 = s.dt_s > 0 ? 1 / (h * h) + s.damping_per_s / h : 0;
  if (lagging_iterations_ >= lags_for) {
    lagging_iterations_ = 0;
    look_at_cells();
  }
  metric_.begin_step(mass_per_s2, s.adopt_after_steps, s.adopt_when_ready, s.adopt_now);
  const auto metric = [this](const NodeArray& r, NodeArray& z) { metric_.apply(r, z); };

  const bool remember = s.dt_s > 0 && s.integrator == Integrator::bdf2;
  NodeArray u_start, velocity_start;
  if (remember) u_start = u_, velocity_start = velocity_;

  StepReport report;
  Value value = evaluate(u_, g_, true);
  if (!inertia_.empty()) start_where_inertia_leads(value);
  if (!value.finite() || !engine_.all_finite(g_)) {  // nothing can be saved from such a state but the rest shape
    u_.zero(), velocity_.zero(), history_.clear(), before_s_ = 0;
    if (remember) u_start = u_, velocity_start = velocity_;
    for (size_t c = 0; c < elements_->cells(); ++c) elements_->set_q(c, 0);
    prepare_dynamics(s);
    value = evaluate(u_, g_, true);
  }
  if (untangling_ || tangled_iterations_ >= tangled_for) begin_or_end_untangling(value, s.dt_s > 0);
  if (!untangling_) take_plain_energy(elements_->overloaded(), value);
  const auto update = [&] {
    if (since_update_ == 0 || !elements_->update_multipliers(engine_)) return false;
    since_update_ = 0;
    return true;
  };
  level_ = false;
  if (s.dt_s > 0) level_watch_ = {};
  bool looked = true;  // the last evaluation was at u_
  NodeArray u_first;
  if (s.most_move_mm > 0) u_first = u_;
  distance_.begin(u_);
  StallWatch watch;
  while (report.iterations < s.max_iterations) {
    if (s.tolerance > 0 && relative_residual() <= s.tolerance) {
      // A true equilibrium also survives fresh multipliers and a fresh force scale.
      update();
      value = evaluate(u_, g_, true);
      if (relative_residual() <= s.tolerance) break;
    } else if (since_update_ >= update_every && update()) {
      if (elements_->overloaded())
        take_plain_energy(true, value);
      else
        value = evaluate(u_, g_, false);
    }
    if (s.tolerance > 0 && watch.look(relative_residual(), 1)) {
      report.stalled = true;
      break;
    }
    if (s.tolerance > 0 && !level_watch_.at_floor && report.iterations > 0 &&
        level_watch_.suspects(relative_residual(), level_)) {
      level_watch_.at_floor = at_floor();
      looked = false;
    }
    if (s.tolerance > 0 && level_watch_.at_floor) {
      report.stalled = report.at_floor = true;
      break;
    }
    double slope = direction(g_, metric);
    if (!(slope < 0) && history_.count() > 0) {
      history_.clear();
      slope = direction(g_, metric);
    }
    if (!(slope < 0)) break;  // no force left
    looked = search(value, slope) == Search::moved;
    if (!looked) {
      if (history_.count() == 0) {  // the floor of single precision
        report.stalled = s.tolerance > 0;
        report.at_floor = level_watch_.at_floor = report.stalled && at_floor();
        break;
      }
      history_.clear();
      continue;
    }
    ++report.iterations, ++since_update_;
    if (s.should_stop && s.should_stop()) break;
    if (s.most_move_mm > 0) {
      engine_.subtract(d_, u_, u_first);
      for (int32_t i : of_slivers_) d_[size_t(i)] = {};
      if (engine_.max_node(d_) > s.most_move_mm) break;
    }
  }

  if (untangling_) untangling_iterations_ += std::max(1, report.iterations), elements_->shape_only(false);
  if (own_.estimate_error || !looked || untangling_) value = evaluate(u_, g_, true);
  report.residual = relative_residual();
  lagging_iterations_ = report.residual > lags ? lagging_iterations_ + std::max(1, report.iterations) : 0;
  const bool tangled =
      report.residual > tangled_residual && elements_->inverted() > tangled_cells * double(elements_->cells());
  tangled_iterations_ = tangled && !untangling_ ? tangled_iterations_ + report.iterations : 0;
  if (own_.estimate_error) {
    report.distance_mm = distance_(u_, next_move_mm(metric));
  }
  report.energy_uJ = value.energy + elements_->energy_to_primal();
  report.converged = s.tolerance > 0 && report.residual <= s.tolerance;
  report.stalled = report.stalled && !report.converged;
  report.at_floor = report.at_floor && report.stalled;
  report.preconditioner_pending = metric_.pending();
  report.metric_is_cycle = metric_.on_cycle();
  report.inverted_cells = elements_->inverted();
  report.min_J = 1 + double(elements_->min_theta());
  if (s.dt_s > 0) {
    level_watch_ = {};
    const float f = float(1 / h_s_);
    for (size_t i = 0; i < u_.size(); ++i) store(velocity_[i], f * (load(u_[i]) - load(u_base_[i])));
  } else {
    velocity_.zero();
  }
  before_s_ = remember ? s.dt_s : 0;
  if (remember) u_before_.swap(u_start), velocity_before_.swap(velocity_start);
  if (s.dt_s > 0)
    viscous_.end_step(u_);
  else
    viscous_.relax(u_);
  elements_->plain(false);
  publish();
  return report;
}

}  // namespace limberg::fem
