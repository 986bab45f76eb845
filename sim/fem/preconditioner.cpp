#include "sim/fem/preconditioner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <numeric>

#include "sim/fem/element_system.h"
#include "sim/fem/node_vectors.h"

namespace limberg::fem {
namespace {

constexpr size_t many_columns = 16;  // that many springs outside the factor are worth a new one

/// A time step that changes a little every frame must not ask for a new factor every frame.
bool mass_differs(double a, double b) { return a != b && (a < 0.5 * b || b < 0.5 * a); }

/// Diagonal of the scalar matrix, per node.
std::vector<double> diagonal(const FemModel& m, double mass_per_s2) {
  const double b2 = (1 / (4 * m.cell_mm.array())).square().sum();
  std::vector<double> d(m.X_mm.size(), 0);
  for (size_t i = 0; i < d.size(); ++i) d[i] = mass_per_s2 * m.mass_kg[i];
  for (const HexCell& c : m.cells) {
    const Stencil& s = m.stencils[size_t(c.stencil)];
    const double bulk = effective_bulk_kPa(s, true) * s.volume_mm3 * b2 * double(1 << 2 * s.level);
    for (int a = 0; a < 8; ++a) d[size_t(c.node[size_t(a)])] += double(c.scale) * (s.K(a, a) + bulk);
  }
  return d;
}

}  // namespace

struct Preconditioner::Pending {
  // Written by the job, read after it is done.
  struct Result {
    std::shared_ptr<const ScalarFactor> factor;
    std::atomic<bool> unwanted = false;  // set by the owner when nobody will ask any more
  };
  std::shared_ptr<Result> result = std::make_shared<Result>();
  std::shared_ptr<Workers::Job> job;
  std::vector<SpringRow> folded;
  double mass_per_s2 = 0;
  int steps = 0;
  bool model_is_current = true;
  std::vector<int32_t> ancestor;  // current node -> node of the model that is being factored
};

Preconditioner::Preconditioner(Workers& workers) : workers_(workers) {}
Preconditioner::~Preconditioner() {
  if (!pending_) return;
  pending_->result->unwanted = true;
  pending_->job->wait();
}

void Preconditioner::set_model(std::shared_ptr<const FemModel> model) {
  const std::vector<int32_t>& parent = model->parent;
  auto compose = [&](std::vector<int32_t>& ancestor) {
    std::vector<int32_t> out(model->X_mm.size(), -1);
    for (size_t i = 0; i < out.size(); ++i)
      if (i < parent.size() && parent[i] >= 0 && size_t(parent[i]) < ancestor.size()) out[i] = ancestor[size_t(parent[i])];
    ancestor = std::move(out);
  };
  compose(ancestor_);
  if (pending_) compose(pending_->ancestor), pending_->model_is_current = false;
  model_ = std::move(model);
  springs_.clear();
  factor_is_current_ = false;
  map_factor();
}

void Preconditioner::set_springs(std::vector<SpringEntry> springs) {
  springs_ = std::move(springs);
  columns_dirty_ = true;
}

bool Preconditioner::stale() const { return !factor_is_current_; }

// Rebuilds place_ and jacobi_ for the current factor seen from the current model.
void Preconditioner::map_factor() {
  const FemModel& m = *model_;
  const size_t n = m.X_mm.size();
  place_.assign(n, -1);
  jacobi_.clear();
  columns_.clear(), columns_dirty_ = true;
  std::vector<int32_t> uses;
  if (factor_) {
    int32_t nodes = 0;
    for (int32_t v : factor_->node_order) nodes = std::max(nodes, v + 1);
    std::vector<int32_t> at(size_t(nodes), -1);
    for (size_t k = 0; k < factor_->node_order.size(); ++k) at[size_t(factor_->node_order[k])] = int32_t(k);
    uses.assign(factor_->node_order.size(), 0);
    for (size_t i = 0; i < n; ++i) {
      const int32_t a = ancestor_[i];
      if (m.fixed[i] || a < 0 || a >= nodes) continue;
      place_[i] = at[size_t(a)];
      if (place_[i] >= 0) ++uses[size_t(place_[i])];
    }
    work_.resize(factor_->node_order.size());
  }
  if (factor_is_current_ && factor_) return;
  std::vector<uint8_t> touched(n, 0), ring(n, 0);
  for (size_t i = 0; i < n; ++i) touched[i] = !m.fixed[i] && (place_[i] < 0 || uses[size_t(place_[i])] > 1);
  for (const HangingNode& h : m.hanging) touched[size_t(h.node)] = 0;  // no unknowns: they receive no force, their move is ignored
  for (const HexCell& c : m.cells) {
    bool any = false;
    for (int32_t v : c.node) any = any || touched[size_t(v)];
    if (any)
      for (int32_t v : c.node) ring[size_t(v)] = 1;
  }
  const std::vector<double> d = diagonal(m, factor_mass_);
  jacobi_.assign(n, 0);
  for (size_t i = 0; i < n; ++i)
    if ((ring[i] || touched[i]) && !m.fixed[i] && d[i] > 0) jacobi_[i] = float(1 / d[i]);
}

void Preconditioner::submit(double mass_per_s2) {
  auto p = std::make_unique<Pending>();
  p->mass_per_s2 = mass_per_s2;
  p->ancestor.resize(model_->X_mm.size());
  std::iota(p->ancestor.begin(), p->ancestor.end(), 0);
  for (const SpringEntry& s : springs_)
    if (s.foldable) p->folded.push_back(s.row);
  auto job = [model = model_, springs = p->folded, mass_per_s2, before = factor_, ancestor = ancestor_, result = p->result] {
    try {
      if (result->unwanted) return;
      const ScalarMatrix A = assemble_scalar(*model, springs, mass_per_s2);
      std::vector<int32_t> order;
      if (before) order = inherited_order(A, before->node_order, ancestor);
      result->factor = std::make_shared<ScalarFactor>(factorize(A, order));
    } catch (const std::exception&) {
      result->factor.reset();  // the old operator stays in use
    }
  };
  p->job = workers_.submit(std::move(job));
  pending_ = std::move(p);
}

void Preconditioner::adopt() {
  pending_->job->wait();
  if (pending_->result->factor) {
    factor_ = pending_->result->factor;
    folded_ = std::move(pending_->folded);
    factor_mass_ = pending_->mass_per_s2;
    ancestor_ = std::move(pending_->ancestor);
    factor_is_current_ = pending_->model_is_current;
    map_factor();
  } else {
    factor_is_current_ = pending_->model_is_current;  // nothing better can be had for this model
    if (!factor_) map_factor();
  }
  pending_.reset();
}

void Preconditioner::begin_step(double mass_per_s2, int adopt_after, bool when_ready) {
  if (pending_) {
    ++pending_->steps;
    if (pending_->steps >= adopt_after || (when_ready && pending_->job->done())) adopt();
  }
  bool wanted = !factor_is_current_ || mass_differs(factor_mass_, mass_per_s2);
  if (!wanted && factor_ && !pending_) {
    size_t outside = 0, found = 0;
    for (const SpringEntry& s : springs_) {
      const bool in = std::any_of(folded_.begin(), folded_.end(), [&](const SpringRow& f) { return same_spring(f, s.row); });
      found += in;
      outside += !in && s.foldable;
    }
    wanted = outside > many_columns || found < folded_.size();
  }
  if (wanted && !pending_) {
    submit(mass_per_s2);
    if (!factor_) adopt();  // nothing usable before it
  }
  if (columns_dirty_) update_columns();
}

void Preconditioner::apply_base(const NodeArray& r, NodeArray& z) {
  const size_t n = place_.size();
  const FemModel& m = *model_;
  if (!work_.empty()) {
    if (jacobi_.empty()) {
      for (size_t i = 0; i < n; ++i)
        if (place_[i] >= 0) work_[size_t(place_[i])] = r[i];
    } else {
      work_.zero();
      for (size_t i = 0; i < n; ++i)
        if (place_[i] >= 0) store(work_[size_t(place_[i])], load(work_[size_t(place_[i])]) + load(r[i]));
    }
    factor_->panels.solve(work_.data());
  }
  for (size_t i = 0; i < n; ++i) z[i] = place_[i] >= 0 ? work_[size_t(place_[i])] : Node4{};
  if (!jacobi_.empty())
    for (size_t i = 0; i < n; ++i)
      if (!m.fixed[i]) store(z[i], load(z[i]) + jacobi_[i] * load(r[i]));
}

// Woodbury: (M0 + W C W^T)^-1 r = z0 - Y (C^-1 + W^T Y)^-1 W^T z0,  z0 = M0^-1 r,  Y = M0^-1 W.
void Preconditioner::update_columns() {
  std::vector<Column> old = std::move(columns_);
  columns_.clear();
  std::vector<size_t> fresh;
  const size_t n = model_->X_mm.size();
  for (const SpringEntry& s : springs_) {
    if (std::any_of(folded_.begin(), folded_.end(), [&](const SpringRow& f) { return same_spring(f, s.row); })) continue;
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
  subtract_outer(z, column_data_.data(), column_force_.data(), int(k));
}

std::string Preconditioner::describe() const {
  if (!factor_) return "Jacobi";
  return "panel Cholesky of " + std::to_string(factor_->node_order.size()) + " nodes, " +
         std::to_string(factor_->panels.bytes() >> 10) + " KiB" + (factor_is_current_ ? "" : " (of an earlier cut)") + ", " +
         std::to_string(folded_.size()) + " springs inside, " + std::to_string(columns_.size()) + " beside";
}

}  // namespace limberg::fem
