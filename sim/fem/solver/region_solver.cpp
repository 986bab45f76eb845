#include "sim/fem/solver/region_solver.h"

#include <algorithm>

#include "sim/base/error.h"

namespace limberg {

std::unique_ptr<ElasticSolver> make_region_solver(Workers& workers) {
  return std::make_unique<fem::RegionSolver>(make_solver(workers));
}

}  // namespace limberg

namespace limberg::fem {
namespace {

constexpr int32_t kAnchors = 8;

/// The identity as far as it goes.
ParentList parent_list(const std::vector<int32_t>& parent) {
  size_t same = 0;
  while (same < parent.size() && parent[same] == int32_t(same)) ++same;
  ParentList out = ParentList::identity(same);
  for (size_t i = same; i < parent.size(); ++i) out.push_back(parent[i]);
  return out;
}

Vec3 anchor(const Vec3& low, const Vec3& high, int32_t k) {
  return {(k & 1 ? high : low)[0], (k & 2 ? high : low)[1], (k & 4 ? high : low)[2]};
}

void check_point(const EmbeddedPoint& p, size_t nodes, const std::string& of) {
  for (size_t i = 0; i < 8; ++i)
    if (p.w[i] != 0 && (p.node[i] < 0 || size_t(p.node[i]) >= nodes))
      throw InputError("", 0, of + " names a node that the model does not have");
}

}  // namespace

void RegionSolver::set_model(std::shared_ptr<const FemModel> model, const ParentList& cell_parent) {
  const FemModel& m = *model;
  const size_t n = m.X_mm.size(), nc = m.cells.size();
  if (m.fixed.size() != n || m.mass_kg.size() != n || m.parent.size() != n)
    throw InputError("", 0, "a model's fixed, mass and parent lists must have one entry per node");
  const bool first = !whole_;
  if (first && n > 0) {
    low_mm_ = high_mm_ = m.X_mm[0];
    for (const Vec3& X : m.X_mm) low_mm_ = low_mm_.cwiseMin(X), high_mm_ = high_mm_.cwiseMax(X);
    high_mm_ = high_mm_.cwiseMax(low_mm_ + Vec3::Constant(1));  // a box has a volume
  }

  std::vector<uint8_t> here(n, 0);
  std::vector<int32_t> cell_at, cell_place(nc, -1);
  for (size_t c = 0; c < nc; ++c) {
    if (!(m.cells[c].scale > 0)) continue;
    cell_place[c] = int32_t(cell_at.size()), cell_at.push_back(int32_t(c));
    for (int32_t v : m.cells[c].node) here[size_t(v)] = 1;
  }
  for (const HangingNode& h : m.hanging)
    if (here[size_t(h.node)])
      for (size_t k = 0; k < size_t(h.count); ++k) here[size_t(h.master[k])] = 1;
  std::vector<int32_t> node_at(kAnchors, -1), place(n, -1);
  for (size_t v = 0; v < n; ++v)
    if (here[v]) place[v] = int32_t(node_at.size()), node_at.push_back(int32_t(v));

  // Written over a copy of what was present before, so that chunks in which nothing has changed stay shared.
  auto p = std::make_shared<FemModel>();
  if (!first)
    p->X_mm = present().X_mm, p->fixed = present().fixed, p->mass_kg = present().mass_kg, p->cells = present().cells;
  p->cell_mm = m.cell_mm, p->stencils = m.stencils, p->laws = m.laws, p->graded = m.graded;
  p->X_mm.resize(node_at.size(), Vec3::Zero()), p->fixed.resize(node_at.size()), p->mass_kg.resize(node_at.size()),
      p->cells.resize(cell_at.size());
  std::vector<int32_t> parent(node_at.size(), -1);
  for (int32_t k = 0; k < kAnchors; ++k) {
    p->X_mm.set(size_t(k), anchor(low_mm_, high_mm_, k)), p->fixed.set(size_t(k), true), p->mass_kg.set(size_t(k), 0);
    parent[size_t(k)] = first ? -1 : k;
  }
  const auto before = [&](int32_t v) {
    return v < 0 || size_t(v) >= place_.size() ? -1 : place_[size_t(v)] >= 0 ? place_[size_t(v)] : 0;
  };  // absent: at rest, as anchor 0
  for (size_t i = kAnchors; i < node_at.size(); ++i) {
    const size_t v = size_t(node_at[i]);
    p->X_mm.set(i, m.X_mm[v]), p->fixed.set(i, m.fixed[v]), p->mass_kg.set(i, m.mass_kg[v]);
    parent[i] = first ? -1 : before(m.parent[v]);
  }
  p->parent = parent_list(parent);
  std::vector<int32_t> parent_of_cell(cell_at.size(), -1);
  for (size_t i = 0; i < cell_at.size(); ++i) {
    const size_t c = size_t(cell_at[i]);
    HexCell cell = m.cells[c];
    for (int32_t& v : cell.node) v = place[size_t(v)];
    p->cells.set(i, cell);
    const int32_t q = c < cell_parent.size() ? cell_parent[c] : -1;
    if (q >= 0 && size_t(q) < cell_place_.size()) parent_of_cell[i] = cell_place_[size_t(q)];
  }
  for (const BornNode& b : m.born) {
    if (place[size_t(b.node)] < 0) continue;
    BornNode& to = p->born.emplace_back();
    to.node = place[size_t(b.node)];
    for (const auto& [v, w] : b.from) to.from.push_back({before(v), w});
  }
  for (const HangingNode& h : m.hanging) {
    if (place[size_t(h.node)] < 0) continue;
    HangingNode& to = p->hanging.emplace_back(h);
    to.node = place[size_t(h.node)];
    for (size_t k = 0; k < size_t(h.count); ++k) to.master[k] = place[size_t(h.master[k])];
  }
  loads_.clear();
  inner_->set_model(std::move(p), first ? ParentList() : parent_list(parent_of_cell));
  whole_ = std::move(model);
  node_at_ = std::move(node_at), cell_at_ = std::move(cell_at);
  place_ = std::move(place), cell_place_ = std::move(cell_place);
  shown_.assign(n, Vec3f::Zero());
  show();
}

void RegionSolver::show() {
  const std::span<const Vec3f> u = inner_->displacement_mm();
  for (size_t i = kAnchors; i < node_at_.size(); ++i) shown_[size_t(node_at_[i])] = u[i];
}

EmbeddedPoint RegionSolver::find(const EmbeddedPoint& p) const {
  EmbeddedPoint out;
  bool here = true;
  for (size_t i = 0; i < 8; ++i) {
    if (p.w[i] == 0) continue;
    const int32_t v = place_[size_t(p.node[i])];
    here = here && v >= 0;
    out.node[i] = std::max(v, 0), out.w[i] = p.w[i];
  }
  if (here) return out;
  Vec3 X = Vec3::Zero();
  double sum = 0;
  for (size_t i = 0; i < 8; ++i)
    if (p.w[i] != 0) X += double(p.w[i]) * whole_->X_mm[size_t(p.node[i])], sum += double(p.w[i]);
  const Vec3 t = (X / sum - low_mm_).cwiseQuotient(high_mm_ - low_mm_);
  for (size_t k = 0; k < 8; ++k) {
    double w = 1;
    for (int i = 0; i < 3; ++i) w *= (k >> i & 1) ? t[i] : 1 - t[i];
    out.node[k] = int32_t(k), out.w[k] = float(w);
  }
  return out;
}

void RegionSolver::set_springs(std::span<const Spring> springs) {
  if (!whole_) throw InputError("", 0, "springs were given before a model");
  std::vector<Spring> to(springs.begin(), springs.end());
  for (Spring& s : to) {
    const std::string name = "spring " + std::to_string(s.id);
    const auto take = [&](EmbeddedPoint& p) { check_point(p, place_.size(), name), p = find(p); };
    take(s.a);
    for (EmbeddedPoint& p : s.a_wide) take(p);
    if (s.to_world) {
      s.b = {}, s.b_wide.clear();
      continue;
    }
    take(s.b);
    for (EmbeddedPoint& p : s.b_wide) take(p);
  }
  inner_->set_springs(to);
}

void RegionSolver::set_contacts(std::span<const Contact> contacts) {
  if (!whole_) throw InputError("", 0, "contacts were given before a model");
  std::vector<Contact> to(contacts.begin(), contacts.end());
  for (Contact& c : to) {
    check_point(c.a, place_.size(), "a contact"), check_point(c.b, place_.size(), "a contact");
    c.a = find(c.a), c.b = find(c.b);
  }
  inner_->set_contacts(to);
}

void RegionSolver::set_loads(std::span<const DeadLoad> loads) {
  if (!whole_ && !loads.empty()) throw InputError("", 0, "loads were given before a model");
  std::vector<DeadLoad> to(loads.begin(), loads.end());
  for (size_t k = 0; k < to.size(); ++k)
    for (EmbeddedPoint& p : to[k].at) check_point(p, place_.size(), "load " + std::to_string(k + 1)), p = find(p);
  inner_->set_loads(to);
  loads_.assign(loads.begin(), loads.end());
}

std::vector<SupportForce> RegionSolver::support_forces_mN() const {
  std::vector<SupportForce> out = inner_->support_forces_mN();
  for (SupportForce& f : out) f.node = node_at_[size_t(f.node)];
  return out;
}

StepReport RegionSolver::step(const StepSettings& settings) {
  const StepReport r = inner_->step(settings);
  show();
  return r;
}

void RegionSolver::set_displacement_mm(std::span<const Vec3f> u) {
  if (u.size() != shown_.size()) throw InputError("", 0, "a displacement needs one vector per node of the model");
  std::vector<Vec3f> to(node_at_.size(), Vec3f::Zero());
  for (size_t i = kAnchors; i < to.size(); ++i) to[i] = u[size_t(node_at_[i])];
  inner_->set_displacement_mm(to);
  show();
}

void RegionSolver::restore(const SolverState& state) {
  inner_->restore(state);
  show();
}

void RegionSolver::cell_J(std::vector<float>& J) const {
  std::vector<float> here;
  inner_->cell_J(here);
  J.assign(cell_place_.size(), 1.0f);
  for (size_t i = 0; i < here.size(); ++i) J[size_t(cell_at_[i])] = here[i];
}

Mat3 RegionSolver::cell_F(int32_t cell) const {
  const int32_t at = cell_place_[size_t(cell)];
  return at < 0 ? Mat3(Mat3::Identity()) : inner_->cell_F(at);
}

std::string RegionSolver::describe() const {
  return "region of " + std::to_string(cell_at_.size()) + " of " + std::to_string(cell_place_.size()) +
         " cells: " + inner_->describe();
}

}  // namespace limberg::fem
