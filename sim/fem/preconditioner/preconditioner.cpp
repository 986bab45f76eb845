#include "sim/fem/preconditioner/preconditioner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <new>
#include <numeric>

namespace limberg::fem {
namespace {

constexpr size_t many_columns = 16;  // that many springs outside the operator are worth a new one
constexpr size_t models_kept = 3;    // besides the current one
constexpr double most_fill = 1.3;    // growth of an inherited order's factor beyond which a fresh order pays

/// A time step that changes a little every frame must not ask for a new factor every frame.
bool mass_differs(double a, double b) { return a != b && (a < 0.5 * b || b < 0.5 * a); }

}  // namespace

struct MetricPast {
  std::shared_ptr<const Preconditioner::Recipe> factor, pending;  // null: there was none
  std::weak_ptr<const ScalarFactor> factor_made;
  int steps = 0;  // that the pending one was waited for
  bool has_no_factor = false;
  size_t factor_bytes = 0;  // Operators::ordered_bytes
  bool has_cycle = false;
  std::vector<SpringRow> cycle_springs;
  double cycle_mass = 0;
  std::weak_ptr<const ScalarCycle> cycle_made;
  Preconditioner::NodeList order_from, ancestor;
  size_t ordered_bytes = 0;
};

struct Preconditioner::Pending {
  // Written by the job, read after it is done.
  struct Result {
    std::shared_ptr<const ScalarFactor> factor;
    size_t ordered_bytes = 0;            // of the factor whose order was last found afresh
    std::atomic<bool> unwanted = false;  // set by the owner when nobody will ask any more
    std::atomic<bool> begun = false;     // set by the job before it looks at `unwanted`
  };
  std::shared_ptr<Result> result = std::make_shared<Result>();
  std::shared_ptr<Workers::Job> job;
  std::shared_ptr<const Recipe> recipe;
  int steps = 0;
};

Preconditioner::Preconditioner(Workers& workers, MetricPolicy policy)
    : engine_(workers, policy.kernels ? *policy.kernels : default_kernels()), policy_(policy) {}
Preconditioner::~Preconditioner() {
  drop_pending();
  for (const auto& p : dropped_) p->job->wait();
}

// A job for a model that is gone is never used, done or not: so results do not depend on how fast it was.
void Preconditioner::drop_pending() {
  std::erase_if(dropped_, [](const auto& p) { return p->job->done(); });
  if (!pending_) return;
  pending_->result->unwanted = true;
  if (pending_->result->begun)
    dropped_.push_back(std::move(pending_));
  else
    pending_->job->wait();  // returns at once: the job will see that it is unwanted
  pending_.reset();
}

void Preconditioner::set_model(std::shared_ptr<const FemModel> model, const ParentList& cell_parent) {
  drop_pending();
  const ParentList& parent = model->parent;
  std::vector<int32_t> ancestor(model->X_mm.size(), -1);
  for (size_t i = 0; i < ancestor.size(); ++i)
    if (parent[i] >= 0 && size_t(parent[i]) < ancestor_->size()) ancestor[i] = (*ancestor_)[size_t(parent[i])];
  ancestor_ = std::make_shared<std::vector<int32_t>>(std::move(ancestor));
  if (now_.cycle) cycle_before_ = now_.cycle;
  if (cycle_before_ && &cycle_before_->model() != now_.model.get()) cycle_before_.reset();
  cell_parent_ = cell_parent;

  if (now_.factor || now_.cycle) kept_.push_front(std::move(now_));
  now_ = {};
  now_.model = std::move(model);
  for (size_t k = 0; k < kept_.size(); ++k)
    if (same_model(*kept_[k].model, *now_.model)) {
      now_ = std::move(kept_[k]);
      kept_.erase(kept_.begin() + long(k));
      break;
    }
  if (kept_.size() > models_kept) kept_.pop_back();
  springs_.clear();
  factor_is_current_ = false;
  if (now_.factor) use_factor();
  operator_changed();
}

void Preconditioner::set_springs(std::vector<SpringEntry> springs) {
  springs_ = std::move(springs);
  columns_dirty_ = true;
}

std::vector<SpringRow> Preconditioner::foldable() const {
  std::vector<SpringRow> rows;
  for (const SpringEntry& s : springs_)
    if (s.foldable) rows.push_back(s.row);
  return rows;
}

std::span<const SpringRow> Preconditioner::folded() const {
  if (factor_is_current_) return now_.recipe->folded;
  return now_.cycle ? now_.cycle->springs() : std::span<const SpringRow>();
}

/// True when so many springs have come, or any has gone, that the operator in use should be made again.
bool Preconditioner::springs_have_changed() const {
  size_t outside = 0, found = 0;
  for (const SpringEntry& s : springs_) {
    const auto in = folded();
    const bool inside = std::any_of(in.begin(), in.end(), [&](const SpringRow& f) { return same_spring(f, s.row); });
    found += inside;
    outside += !inside && s.foldable;
  }
  return outside > many_columns || found < folded().size();
}

void Preconditioner::use_factor() {
  factor_is_current_ = true;
  // A copy: the factor itself is not to live as long as recipes that were written after it.
  order_from_ = std::make_shared<std::vector<int32_t>>(now_.factor->node_order), ordered_bytes_ = now_.ordered_bytes;
  std::vector<int32_t> itself(now_.model->X_mm.size());
  std::iota(itself.begin(), itself.end(), 0);
  ancestor_ = std::make_shared<std::vector<int32_t>>(std::move(itself));
  place_.assign(now_.model->X_mm.size(), -1);
  for (size_t k = 0; k < now_.factor->node_order.size(); ++k) place_[size_t(now_.factor->node_order[k])] = int32_t(k);
  work_.resize(now_.factor->node_order.size());
  operator_changed();
}

std::shared_ptr<const Preconditioner::Recipe> Preconditioner::next_recipe(double mass_per_s2) const {
  return std::make_shared<Recipe>(Recipe{foldable(), mass_per_s2, order_from_, ancestor_, ordered_bytes_});
}

void Preconditioner::submit(std::shared_ptr<const Recipe> recipe) {
  auto p = std::make_unique<Pending>();
  p->recipe = recipe;
  auto job = [model = now_.model, recipe, result = p->result, &workers = engine_.workers()] {
    try {
      result->begun = true;
      if (result->unwanted) return;
      const ScalarMatrix A = assemble_scalar(*model, recipe->folded, recipe->mass_per_s2);
      std::shared_ptr<const ScalarFactor> factor;
      result->ordered_bytes = recipe->ordered_bytes;
      if (recipe->order_from)
        factor =
            std::make_shared<ScalarFactor>(factorize(A, inherited_order(A, *recipe->order_from, *recipe->ancestor)));
      if (!factor || double(factor->panels.bytes()) > most_fill * double(recipe->ordered_bytes)) {
        factor = std::make_shared<ScalarFactor>(factorize(A, workers));
        result->ordered_bytes = factor->panels.bytes();
      }
      result->factor = std::move(factor);
    } catch (const std::bad_alloc&) {
      throw;  // what a session comes to must not depend on what else takes memory
    } catch (const std::exception&) {
      result->factor.reset();  // the cycle stays in use
    }
  };
  p->job = engine_.workers().submit(std::move(job));
  pending_ = std::move(p);
}

void Preconditioner::adopt() {
  try {
    pending_->job->wait();
  } catch (...) {  // no memory: who goes on all the same, goes on with the cycle
    pending_.reset();
    now_.has_no_factor = true;
    throw;
  }
  if (pending_->result->factor) {
    now_.factor = pending_->result->factor;
    now_.recipe = pending_->recipe;
    now_.ordered_bytes = pending_->result->ordered_bytes;
    use_factor();
  } else {
    now_.has_no_factor = true;
  }
  pending_.reset();
}

std::shared_ptr<const MetricPast> Preconditioner::past() const {
  auto past = std::make_shared<MetricPast>();
  if (now_.factor) past->factor = now_.recipe, past->factor_made = now_.factor, past->factor_bytes = now_.ordered_bytes;
  if (pending_) past->pending = pending_->recipe, past->steps = pending_->steps;
  past->has_no_factor = now_.has_no_factor;
  if (now_.cycle) {
    past->has_cycle = true;
    past->cycle_springs.assign(now_.cycle->springs().begin(), now_.cycle->springs().end());
    past->cycle_mass = now_.cycle->mass_per_s2();
    past->cycle_made = now_.cycle;
  }
  past->order_from = order_from_, past->ancestor = ancestor_, past->ordered_bytes = ordered_bytes_;
  return past;
}

void Preconditioner::take_up(const MetricPast& past) {
  drop_pending();
  now_.factor.reset(), now_.recipe.reset(), now_.cycle.reset(), cycle_before_.reset();
  factor_is_current_ = false;
  now_.has_no_factor = past.has_no_factor;
  order_from_ = past.order_from, ancestor_ = past.ancestor, ordered_bytes_ = past.ordered_bytes;
  if (past.has_cycle) {
    now_.cycle = past.cycle_made.lock();
    if (!now_.cycle) now_.cycle = ScalarCycle::build(now_.model, past.cycle_springs, past.cycle_mass);
  }
  if (past.factor) {
    if (auto made = past.factor_made.lock()) {
      now_.factor = std::move(made), now_.recipe = past.factor, now_.ordered_bytes = past.factor_bytes;
      use_factor();
    } else {
      submit(past.factor);
      adopt();
    }
  }
  if (past.pending) submit(past.pending), pending_->steps = past.steps;
  operator_changed();
}

void Preconditioner::make_cycle(double mass_per_s2) {
  if (now_.cycle) {  // the same model with other springs or another time step
    now_.cycle = ScalarCycle::rebuild(*now_.cycle, now_.model, {}, foldable(), mass_per_s2);
  } else if (cycle_before_) {
    now_.cycle = ScalarCycle::rebuild(*cycle_before_, now_.model, cell_parent_, foldable(), mass_per_s2);
  } else {
    now_.cycle = ScalarCycle::build(now_.model, foldable(), mass_per_s2);
  }
  cycle_before_.reset();
  operator_changed();
}

bool Preconditioner::needs_cycle(double mass_per_s2) const {
  return !factor_is_current_ &&
         (!now_.cycle || mass_differs(now_.cycle->mass_per_s2(), mass_per_s2) || springs_have_changed());
}

// With a factor on its way it may not come to a cycle; a scene opens with its factor.
void Preconditioner::make_ready(double mass_per_s2) {
  const bool opens = kept_.empty() && !now_.cycle;
  if (now_.model && !pending_ && !opens && needs_cycle(mass_per_s2)) make_cycle(mass_per_s2);
}

void Preconditioner::begin_step(double mass_per_s2, int adopt_after, bool when_ready,
                                const std::function<bool(bool)>& adopt_now) {
  if (pending_) {
    ++pending_->steps;
    const auto now = [&] {
      const bool there = pending_->job->done();
      return adopt_now ? adopt_now(there) : there;
    };
    if (pending_->steps >= adopt_after || (when_ready && now())) adopt();
  }
  if (int32_t(now_.model->X_mm.size()) <= policy_.factor_up_to_nodes && !pending_ && !now_.has_no_factor) {
    if (!factor_is_current_ || mass_differs(now_.recipe->mass_per_s2, mass_per_s2) || springs_have_changed()) {
      const bool first = !factor_is_current_ && kept_.empty() && !now_.cycle;
      submit(next_recipe(mass_per_s2));
      if (first) adopt();  // a scene opens with its factor
    }
  }
  if (needs_cycle(mass_per_s2)) make_cycle(mass_per_s2);
  if (columns_dirty_) update_columns();
}

void Preconditioner::apply_base(const NodeArray& r, NodeArray& z) {
  if (!factor_is_current_) return now_.cycle->apply(r, z, cycle_work_, engine_);
  constexpr size_t nodes_per_chunk = 4096;
  const std::vector<int32_t>& node = now_.factor->node_order;
  if (!work_.empty()) {
    engine_.run(node.size(), nodes_per_chunk, [&](size_t begin, size_t end) {
      for (size_t k = begin; k < end; ++k) work_[k] = r[size_t(node[k])];
    });
    now_.factor->panels.solve(work_.data(), engine_);
  }
  engine_.run(place_.size(), nodes_per_chunk, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) z[i] = place_[i] >= 0 ? work_[size_t(place_[i])] : Node4{};
  });
}

// Woodbury: (M0 + W C W^T)^-1 r = z0 - Y (C^-1 + W^T Y)^-1 W^T z0,  z0 = M0^-1 r,  Y = M0^-1 W.
void Preconditioner::update_columns() {
  std::vector<Column> old = std::move(columns_);
  columns_.clear();
  std::vector<size_t> fresh;
  const std::span<const SpringRow> inside = folded();
  const size_t n = now_.model->X_mm.size();
  for (const SpringEntry& s : springs_) {
    if (std::any_of(inside.begin(), inside.end(), [&](const SpringRow& f) { return same_spring(f, s.row); })) continue;
    if (s.row.node.empty()) continue;
    Column c;
    c.row = s.row;
    for (Column& o : old)
      if (!o.y.empty() && same_spring(o.row, s.row) && o.row.node == s.row.node) {
        c.y = std::move(o.y);
        break;
      }
    if (c.y.empty()) fresh.push_back(columns_.size());
    columns_.push_back(std::move(c));
  }
  NodeArray r(n), z(n);
  for (size_t f = 0; f < fresh.size(); f += 3) {
    r.zero();
    const size_t end = std::min(fresh.size(), f + 3);
    for (size_t k = f; k < end; ++k) {
      const SpringRow& row = columns_[fresh[k]].row;
      for (size_t i = 0; i < row.node.size(); ++i) (&r[size_t(row.node[i])].x)[k - f] = float(row.w[i]);
    }
    apply_base(r, z);
    for (size_t k = f; k < end; ++k) {
      AlignedArray<float>& y = columns_[fresh[k]].y;
      y.resize(n);
      for (size_t i = 0; i < n; ++i) y[i] = (&z[i].x)[k - f];
    }
  }
  const Eigen::Index k = Eigen::Index(columns_.size());
  Eigen::MatrixXd S(k, k);
  for (Eigen::Index i = 0; i < k; ++i)
    for (Eigen::Index j = 0; j < k; ++j) {
      const SpringRow& row = columns_[size_t(i)].row;
      double v = i == j ? 1 / row.k_mN_per_mm : 0;
      for (size_t a = 0; a < row.node.size(); ++a) v += row.w[a] * double(columns_[size_t(j)].y[size_t(row.node[a])]);
      S(i, j) = v;
    }
  S = (0.5 * (S + S.transpose())).eval();
  const Eigen::LLT<Eigen::MatrixXd> llt(S);
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(k, k);  // springs that cannot be told apart: left to the history
  if (k && llt.info() == Eigen::Success) inverse = llt.solve(Eigen::MatrixXd::Identity(k, k));
  capacitance_.resize(size_t(k * k));
  for (Eigen::Index i = 0; i < k; ++i)
    for (Eigen::Index j = 0; j < k; ++j) capacitance_[size_t(i * k + j)] = inverse(i, j);
  column_data_.clear();
  for (const Column& c : columns_) column_data_.push_back(c.y.data());
  column_force_.resize(size_t(k));
  columns_dirty_ = false;
}

void Preconditioner::apply(const NodeArray& r, NodeArray& z) {
  apply_base(r, z);
  const size_t k = columns_.size();
  if (k == 0) return;
  std::vector<std::array<double, 3>> t(k);
  for (size_t j = 0; j < k; ++j) {
    const SpringRow& row = columns_[j].row;
    std::array<double, 3> s{};
    for (size_t i = 0; i < row.node.size(); ++i) {
      const Node4& v = z[size_t(row.node[i])];
      s[0] += row.w[i] * double(v.x), s[1] += row.w[i] * double(v.y), s[2] += row.w[i] * double(v.z);
    }
    t[j] = s;
  }
  for (size_t i = 0; i < k; ++i) {
    double x = 0, y = 0, zz = 0;
    for (size_t j = 0; j < k; ++j) {
      const double c = capacitance_[i * k + j];
      x += c * t[j][0], y += c * t[j][1], zz += c * t[j][2];
    }
    column_force_[i] = {float(x), float(y), float(zz), 0};
  }
  engine_.subtract_outer(z, column_data_.data(), column_force_.data(), int(k));
}

std::string Preconditioner::describe() const {
  if (!now_.factor && !now_.cycle) return "no operator yet";
  const std::string what = factor_is_current_
                               ? "panel Cholesky of " + std::to_string(now_.factor->node_order.size()) + " nodes, " +
                                     std::to_string(now_.factor->panels.bytes() >> 10) + " KiB"
                               : now_.cycle->describe() + (pending_ ? " (while a factor is made)" : "");
  return what + ", " + std::to_string(folded().size()) + " springs inside, " + std::to_string(columns_.size()) +
         " beside";
}

}  // namespace limberg::fem
