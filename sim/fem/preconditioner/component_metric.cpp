#include "sim/fem/preconditioner/component_metric.h"

#include <algorithm>

#include "sim/base/error.h"

namespace limberg::fem {
namespace {

/// Components for which the same nodes are held, as bits: x's first. One number, all bits, where no node slides.
std::vector<unsigned> alike_axes(const FemModel& m) {
  bool same[3][3] = {{true, true, true}, {true, true, true}, {true, true, true}};
  for (const Held& h : m.fixed)
    if (h.some())
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) same[a][b] = same[a][b] && h.along(a) == h.along(b);
  std::vector<unsigned> groups;
  unsigned done = 0;
  for (int a = 0; a < 3; ++a) {
    if (done >> a & 1) continue;
    unsigned group = 0;
    for (int b = a; b < 3; ++b)
      if (same[a][b]) group |= 1u << b;
    groups.push_back(group), done |= group;
  }
  return groups;
}

/// The model of one component: nodes are held whole where it is held.
std::shared_ptr<const FemModel> scalar_model(const FemModel& m, int axis) {
  auto out = std::make_shared<FemModel>(m);
  std::vector<Held> held(m.fixed.size());
  for (size_t v = 0; v < held.size(); ++v) held[v] = m.fixed[v].along(axis);
  out->fixed = held;
  return out;
}

int first_axis(unsigned axes) { return axes & 1 ? 0 : axes & 2 ? 1 : 2; }

void keep_axes(const NodeArray& from, unsigned axes, NodeArray& to) {
  for (size_t i = 0; i < from.size(); ++i)
    to[i] = {axes & 1 ? from[i].x : 0, axes & 2 ? from[i].y : 0, axes & 4 ? from[i].z : 0, 0};
}

}  // namespace

void ComponentMetric::set_model(std::shared_ptr<const FemModel> model, const ParentList& cell_parent) {
  const std::vector<unsigned> groups = alike_axes(*model);
  // Other groups than before: operators begin afresh.
  if (!std::equal(groups.begin(), groups.end(), parts_.begin(), parts_.end(),
                  [](unsigned axes, const Part& p) { return axes == p.axes; })) {
    parts_.clear();
    for (unsigned axes : groups) parts_.push_back({axes, nullptr, std::make_unique<Preconditioner>(workers_, policy_)});
  }
  const bool one = parts_.size() == 1;
  r_.resize(one ? 0 : model->X_mm.size()), z_.resize(one ? 0 : model->X_mm.size());
  for (Part& p : parts_) {
    p.model = one ? model : scalar_model(*model, first_axis(p.axes));
    p.metric->set_model(p.model, cell_parent);
  }
}

void ComponentMetric::set_springs(const std::vector<Preconditioner::SpringEntry>& springs) {
  for (Part& p : parts_) {
    std::vector<Preconditioner::SpringEntry> mine = springs;
    for (Preconditioner::SpringEntry& s : mine) {
      size_t kept = 0;
      for (size_t i = 0; i < s.row.node.size(); ++i)
        if (!p.model->fixed[size_t(s.row.node[i])].any())
          s.row.node[kept] = s.row.node[i], s.row.w[kept] = s.row.w[i], ++kept;
      s.row.node.resize(kept), s.row.w.resize(kept);
    }
    p.metric->set_springs(std::move(mine));
  }
}

void ComponentMetric::begin_step(double mass_per_s2, int adopt_after, bool when_ready,
                                 const std::function<bool(bool)>& adopt_now) {
  for (Part& p : parts_) p.metric->begin_step(mass_per_s2, adopt_after, when_ready, adopt_now);
}

void ComponentMetric::make_ready(double mass_per_s2) {
  for (Part& p : parts_) p.metric->make_ready(mass_per_s2);
}

void ComponentMetric::apply(const NodeArray& r, NodeArray& z) {
  if (parts_.size() == 1) return parts_.front().metric->apply(r, z);
  z.zero();
  for (Part& p : parts_) {
    keep_axes(r, p.axes, r_);
    p.metric->apply(r_, z_);
    for (size_t i = 0; i < z.size(); ++i) {
      if (p.axes & 1) z[i].x = z_[i].x;
      if (p.axes & 2) z[i].y = z_[i].y;
      if (p.axes & 4) z[i].z = z_[i].z;
    }
  }
}

ComponentMetric::Past ComponentMetric::past() const {
  Past past;
  for (const Part& p : parts_) past.push_back(p.metric->past());
  return past;
}

void ComponentMetric::take_up(const Past& past) {
  if (past.size() != parts_.size())
    throw InputError("", 0, "a solver's path is of another model; expected one that was saved with this model");
  for (size_t k = 0; k < parts_.size(); ++k) parts_[k].metric->take_up(*past[k]);
}

bool ComponentMetric::pending() const {
  return std::any_of(parts_.begin(), parts_.end(), [](const Part& p) { return p.metric->pending(); });
}

bool ComponentMetric::on_cycle() const {
  return std::any_of(parts_.begin(), parts_.end(), [](const Part& p) { return p.metric->on_cycle(); });
}

std::string ComponentMetric::describe() const {
  if (parts_.empty()) return "no operator yet";
  std::string all = parts_.front().metric->describe();
  if (parts_.size() > 1)
    all = std::to_string(parts_.size()) + " operators, for components held alike; the first: " + all;
  return all;
}

}  // namespace limberg::fem
