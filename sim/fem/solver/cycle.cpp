#include "sim/fem/solver/cycle.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace limberg::fem {
namespace {

// Of the bound 2. Measured on the 30 mm pull at 2k, 8k and 30k nodes (2026-11-21), steps to 0.1 mm: 1.5: 26, 29, 40;
// 1.8: 26, 30, 45; 1.95: 26, 30, 49.
constexpr float relaxation = 1.5f;
// Nodes of a coarse level below which its exact factor is the better answer. Measured (2026-11-21), steps to 0.1 mm: at
// 30k nodes 2 levels 40 and 22 ms to carry over, 3 levels 40 and 15 ms, 4 levels 42; at 8k, 3 levels save 1 ms of 5,
// but a flap of two coarsest cells takes 101 steps instead of 76.
constexpr int32_t bottom_limit = 3000;
constexpr size_t most_levels = 4;
// What one thread takes at a time: some 10 us of work.
constexpr size_t groups_per_chunk = 512, rows_per_chunk = 4096;

AlignedArray<float> smoother(const NodeMatrix& A) {
  AlignedArray<float> s(size_t(A.rows()));
  for (size_t v = 0; v < s.size(); ++v) {
    double sum = 0;
    for (int32_t e = A.begin[v]; e < A.begin[v + 1]; ++e) sum += double(std::fabs(A.value[size_t(e)]));
    s[v] = sum > 0 ? float(double(relaxation) / sum) : 0.0f;
  }
  return s;
}

/// A point of the lattice: its origin, from a cell whose place is written down exactly.
Vec3 lattice_zero(const FemModel& m) {
  for (const HexCell& c : m.cells) {
    if (c.level > 1) continue;
    Vec3 zero = m.X_mm[size_t(c.node[0])];
    for (int i = 0; i < 3; ++i) zero[i] -= 0.5 * double(c.at[size_t(i)]) * m.cell_mm[i];
    return zero;
  }
  // All are smaller: places are rounded down to halves, and by nothing in some cell along each axis.
  Vec3 zero = m.X_mm.empty() ? Vec3(Vec3::Zero()) : m.X_mm[0];
  for (const HexCell& c : m.cells)
    for (int i = 0; i < 3; ++i)
      zero[i] = std::min(zero[i], m.X_mm[size_t(c.node[0])][i] - 0.5 * double(c.at[size_t(i)]) * m.cell_mm[i]);
  return zero;
}

}  // namespace

std::shared_ptr<const ScalarCycle> ScalarCycle::build(std::shared_ptr<const FemModel> model,
                                                      std::vector<SpringRow> springs, double mass_per_s2) {
  auto c = std::make_shared<ScalarCycle>();
  c->model_ = std::move(model), c->springs_ = std::move(springs), c->mass_per_s2_ = mass_per_s2;
  c->zero_mm_ = lattice_zero(*c->model_);
  c->make(nullptr, {});
  return c;
}

std::shared_ptr<const ScalarCycle> ScalarCycle::rebuild(const ScalarCycle& before,
                                                        std::shared_ptr<const FemModel> model,
                                                        const ParentList& cell_parent, std::vector<SpringRow> springs,
                                                        double mass_per_s2) {
  auto c = std::make_shared<ScalarCycle>();
  c->model_ = std::move(model), c->springs_ = std::move(springs), c->mass_per_s2_ = mass_per_s2;
  c->zero_mm_ = before.zero_mm_;
  c->make(&before, cell_parent);
  return c;
}

void ScalarCycle::make(const ScalarCycle* before, const ParentList& cell_parent) {
  const std::vector<uint8_t> free = free_nodes(*model_);
  NodeChange change;
  const bool related = before && before->mass_per_s2_ == mass_per_s2_ &&
                       compare_models(*before->model_, before->springs_, *model_, springs_, cell_parent, change);
  bool carried = related;
  NodeMatrix A = carried ? assemble_rows(*model_, springs_, mass_per_s2_, free, before->level_[0].A, change)
                         : assemble_rows(*model_, springs_, mass_per_s2_, free);
  made_.of_rows = int32_t(std::count(free.begin(), free.end(), 1));
  made_.rows = made_.of_rows;
  if (carried) {
    made_.rows = 0;
    for (size_t v = 0; v < free.size(); ++v) made_.rows += free[v] && change.dirty[v];
  }

  GridLevel grid = grid_level(*model_, zero_mm_, free);
  int32_t unknowns = made_.of_rows;
  size_t of_whole_cells = 0;  // levels
  for (size_t k = 0; k == 0 || (unknowns > bottom_limit && of_whole_cells + 1 < most_levels); ++k) {
    Level& level = level_.emplace_back();
    const Level* old = before && k < before->level_.size() ? &before->level_[k] : nullptr;
    BlockRule rule = model_->graded ? part_rule(grid) : BlockRule{};
    const bool of_parts = rule.parts_below != 0;
    if (!of_parts) {
      rule = old && !old->coarse.rule.parts_below ? old->coarse.rule : block_rule(grid);
      ++of_whole_cells;
    }
    level.coarse = coarsen(grid, rule);
    NodeChange coarse;
    carried = carried && old && compare_coarse(old->coarse, level.coarse, A, change, coarse);
    const NodeMatrix* old_coarse = !carried                        ? nullptr
                                   : k + 1 < before->level_.size() ? &before->level_[k + 1].A
                                                                   : &before->bottom_;
    NodeMatrix next = carried ? galerkin(A, level.coarse, *old_coarse, coarse) : galerkin(A, level.coarse);
    if (k == 0) {
      made_.of_coarse_rows = next.rows();
      made_.coarse_rows = carried ? int32_t(std::count(coarse.dirty.begin(), coarse.dirty.end(), 1)) : next.rows();
    }
    level.groups = group_rows(A.rows(), A.begin.data(), A.column.data(), A.value.data());
    level.scale = smoother(A);
    level.A = std::move(A);
    A = std::move(next);
    grid = level.coarse.level;
    change = std::move(coarse);
    const int32_t finer = unknowns;
    unknowns = A.rows();
    if (!of_parts && unknowns > finer * 3 / 4) break;
  }
  bottom_ = std::move(A);
  factorize_bottom(grid.at);
}

void ScalarCycle::factorize_bottom(std::span<const std::array<int32_t, 3>> at) {
  const std::vector<int32_t> nodes = dissection_order(at);
  for (double shift = floating_shift; shift < 1;
       shift *= 30) {  // weights that nothing tells apart: more of the diagonal
    const ScalarMatrix L = lower_columns(bottom_, shift);
    std::vector<int32_t> order;
    for (int32_t v : nodes)
      if (const int32_t row = L.row_of_node[size_t(v)]; row >= 0) order.push_back(row);
    try {
      factor_ = factorize(L, order);
      return;
    } catch (const std::runtime_error&) {
      factor_ = {};  // without it the cycle still smooths
    }
  }
}

void ScalarCycle::apply(const NodeArray& r, NodeArray& z, Work& work, const Engine& engine) const {
  work.level.resize(level_.size() + 1);
  for (size_t k = 0; k < work.level.size(); ++k) {
    Work::Level& w = work.level[k];
    const size_t n = size_t(k < level_.size() ? level_[k].A.rows() : bottom_.rows());
    if (k > 0 && w.r.size() != n) w.r.resize(n), w.z.resize(n);
    if (k < level_.size() && w.t.size() != n) w.t.resize(n), w.x.resize(n);
  }
  if (work.bottom.size() != size_t(factor_.panels.n())) work.bottom.resize(size_t(factor_.panels.n()));
  descend(0, r.data(), z.data(), work, engine);
}

void ScalarCycle::descend(size_t k, const Node4* r, Node4* z, Work& work, const Engine& engine) const {
  if (k == level_.size()) {
    if (factor_.node_order.empty()) std::fill(z, z + bottom_.rows(), Node4{});
    for (size_t i = 0; i < factor_.node_order.size(); ++i) work.bottom[i] = r[factor_.node_order[i]];
    factor_.panels.solve(work.bottom.data(), engine);
    for (size_t i = 0; i < factor_.node_order.size(); ++i) z[factor_.node_order[i]] = work.bottom[i];
    return;
  }
  const Kernels& kernel = engine.kernels();
  const Level& level = level_[k];
  Work::Level &own = work.level[k], &below = work.level[k + 1];
  const size_t groups = size_t(level.A.rows() + 3) / 4;
  const GroupView A = level.groups.view();
  const float* scale = level.scale.data();
  Node4* x = own.x.data();
  engine.run(groups, 4 * groups_per_chunk, [&](size_t a, size_t b) { kernel.scale_nodes(scale, r, x, a, b); });
  engine.run(groups, groups_per_chunk, [&](size_t a, size_t b) { kernel.residual(A, r, x, own.t.data(), a, b); });
  const Interpolation &R = level.coarse.restrict_, &P = level.coarse.prolong;
  engine.run(size_t(R.rows()), rows_per_chunk / 4, [&](size_t a, size_t b) {
    kernel.weigh(R.begin.data(), R.column.data(), R.weight.data(), own.t.data(), below.r.data(), a, b);
  });
  descend(k + 1, below.r.data(), below.z.data(), work, engine);
  engine.run(size_t(P.rows()), rows_per_chunk, [&](size_t a, size_t b) {
    kernel.weigh_add(P.begin.data(), P.column.data(), P.weight.data(), below.z.data(), x, a, b);
  });
  engine.run(groups, groups_per_chunk, [&](size_t a, size_t b) { kernel.relax(A, scale, r, x, z, a, b); });
}

size_t ScalarCycle::bytes() const {
  size_t b = factor_.panels.bytes() + 4 * (bottom_.column.size() + bottom_.value.size());
  for (const Level& l : level_)
    b += l.groups.bytes() + 4 * (l.A.column.size() + l.A.value.size() + 4 * l.coarse.prolong.column.size());
  return b;
}

bool ScalarCycle::same_matrices(const ScalarCycle& o) const {
  bool same = level_.size() == o.level_.size() && bottom_ == o.bottom_;
  for (size_t k = 0; k < level_.size() && same; ++k)
    same = level_[k].A == o.level_[k].A && level_[k].coarse.rule == o.level_[k].coarse.rule &&
           level_[k].coarse.prolong == o.level_[k].coarse.prolong &&
           level_[k].coarse.restrict_ == o.level_[k].coarse.restrict_;
  return same;
}

std::string ScalarCycle::describe() const {
  std::string s = std::to_string(levels()) + "-level cycle of " + std::to_string(made_.of_rows);
  for (size_t k = 1; k < level_.size(); ++k) s += " / " + std::to_string(level_[k].A.rows());
  return s + " / " + std::to_string(bottom_.rows()) + " nodes, " + std::to_string(bytes() >> 10) + " KiB";
}

}  // namespace limberg::fem
