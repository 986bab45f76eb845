#include "sim/fem/preconditioner/hardened_cells.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "sim/fem/elements/element_system.h"
#include "sim/fem/elements/material_points.h"

namespace limberg::fem {
namespace {

// The metric is made again when a few cells are so many times as stiff as it has them, or it has them so many times as
// stiff as they are; then all are taken that are off by half as much.
constexpr double kSeenTooSoft = 4, kSeenTooStiff = 16, kSeenOff = 2;
constexpr size_t kFewHardened = 4;  // fewer are left to the history
constexpr size_t kHardGrain = 512;

using Packed = std::array<float, 6>;

Mat3 unpacked(const Packed& p) {
  Mat3 m;
  m << double(p[0]), double(p[3]), double(p[4]), double(p[3]), double(p[1]), double(p[5]), double(p[4]), double(p[5]),
      double(p[2]);
  return m;
}

Packed packed(const Mat3& m) {
  return {float(m(0, 0)), float(m(1, 1)), float(m(2, 2)), float(m(0, 1)), float(m(0, 2)), float(m(1, 2))};
}

/// The points of one law in a stencil, as one.
struct Group {
  const MaterialLaw* law = nullptr;
  Eigen::Matrix<double, 8, 3> B = Eigen::Matrix<double, 8, 3>::Zero();  // grad N, mean
  Mat3 M = Mat3::Zero();                                                // mean
  double part = 0;                                                      // of the points' volume
};

struct Grouped {
  std::vector<Group> group;
  Mat3 D_rest = Mat3::Zero();
};

/// D of a group at the cell's corners, in the rest frame.
Mat3 resistance(const Group& g, const Mat3& F) {
  return g.part * g.M * scalar_stiffness_kPa(*g.law, F * g.M) * g.M.transpose();
}

Grouped grouped(const FemModel& m, const Stencil& s) {
  Grouped out;
  double volume = 0;
  for (const MaterialPoint& p : s.points) volume += p.volume_mm3;
  for (const MaterialPoint& p : s.points) {
    const MaterialLaw* law = m.laws[size_t(p.law)].get();
    auto g = std::find_if(out.group.begin(), out.group.end(), [&](const Group& o) { return o.law == law; });
    if (g == out.group.end()) g = out.group.insert(g, {law});
    const double part = p.volume_mm3 / volume;
    g->B += part * point_gradients(s, p, m.cell_mm), g->M += part * p.M, g->part += part;
  }
  for (Group& g : out.group) {
    g.B /= g.part, g.M /= g.part;
    out.D_rest += resistance(g, Mat3::Identity());
  }
  return out;
}

/// The largest r such that a is r times b along some direction; b is positive definite.
double most_times(const Mat3& a, const Mat3& b) {
  return Eigen::GeneralizedSelfAdjointEigenSolver<Mat3>(a, b, Eigen::EigenvaluesOnly).eigenvalues()[2];
}

Mat3 above_zero(const Mat3& m) {
  const Eigen::SelfAdjointEigenSolver<Mat3> e(m);
  return e.eigenvectors() * e.eigenvalues().cwiseMax(0).asDiagonal() * e.eigenvectors().transpose();
}

}  // namespace

bool HardenedCells::follow(const FemModel& m, const NodeArray& u, const Engine& engine) {
  std::vector<Grouped> of_stencil(m.stencils.size());
  bool any = false;
  for (size_t s = 0; s < of_stencil.size(); ++s)
    if (const auto& p = m.stencils[s].points; !p.empty() && !p[0].gradients)
      of_stencil[s] = grouped(m, m.stencils[s]), any = true;
  if (!any) return false;

  struct Look {
    std::vector<Cell> hard;
    size_t off = 0;
  };
  std::vector<Look> chunk(m.cells.size() / kHardGrain + 1);
  engine.run(m.cells.size(), kHardGrain, [&](size_t begin, size_t end) {
    Look& look = chunk[begin / kHardGrain];
    auto has =
        std::lower_bound(hard_.begin(), hard_.end(), begin, [](const Cell& h, size_t c) { return size_t(h.cell) < c; });
    for (size_t c = begin; c < end; ++c) {
      const bool known = has != hard_.end() && size_t(has->cell) == c;
      const Packed before = known ? has->L : Packed{};
      if (known) ++has;
      const HexCell& cell = m.cells[c];
      const Grouped& of = of_stencil[size_t(cell.stencil)];
      if (of.group.empty() || !(cell.scale > 0)) continue;
      Mat3 D = Mat3::Zero();
      for (const Group& g : of.group) D += resistance(g, gradient_at(g.B, cell, u));
      if (!D.allFinite()) continue;
      const Mat3 now = above_zero(D - of.D_rest);
      const Mat3 rest = m.stencils[size_t(cell.stencil)].mu_kPa * Mat3::Identity();
      const Mat3 is = rest + now, seen = rest + unpacked(before);
      const double soft = most_times(is, seen), stiff = most_times(seen, is);
      look.off += soft > kSeenTooSoft || stiff > kSeenTooStiff;
      if (soft <= kSeenOff && stiff <= kSeenTooStiff / kSeenOff) {
        if (known) look.hard.push_back({int32_t(c), before});
      } else if (most_times(is, rest) > kSeenOff) {
        look.hard.push_back({int32_t(c), packed(now)});
      }
    }
  });
  size_t off = 0;
  for (const Look& l : chunk) off += l.off;
  if (off < kFewHardened) return false;
  hard_.clear();
  for (const Look& l : chunk) hard_.insert(hard_.end(), l.hard.begin(), l.hard.end());
  return true;
}

void HardenedCells::carry(const ParentList& parent, size_t cells) {
  std::vector<Cell> before = std::move(hard_);
  hard_.clear();
  if (before.empty() || parent.size() != cells) return;
  std::vector<int32_t> at;  // of a cell before in `before`, from its first cell on
  at.assign(size_t(before.back().cell) + 1, -1);
  for (size_t k = 0; k < before.size(); ++k) at[size_t(before[k].cell)] = int32_t(k);
  for (size_t c = 0; c < cells; ++c)
    if (const int32_t p = parent[c]; p >= 0 && size_t(p) < at.size() && at[size_t(p)] >= 0)
      hard_.push_back({int32_t(c), before[size_t(at[size_t(p)])].L});
}

std::shared_ptr<const FemModel> HardenedCells::seen(const std::shared_ptr<const FemModel>& model,
                                                    bool of_itself) const {
  if (hard_.empty() && !of_itself) return model;
  auto out = std::make_shared<FemModel>(*model);
  if (of_itself) out->parent = ParentList::identity(model->X_mm.size()), out->born.clear();
  for (const Cell& h : hard_) {
    HexCell cell = model->cells[size_t(h.cell)];
    Stencil s = model->stencils[size_t(cell.stencil)];
    if (s.points.empty()) continue;  // a cut has made another thing of it
    const Mat3 L = unpacked(h.L);
    s.K += points_scalar(*model, s, model->cell_mm);
    for (const MaterialPoint& p : s.points) {
      const auto B = point_gradients(s, p, model->cell_mm);
      s.K += p.volume_mm3 * (B * L * B.transpose());
    }
    s.points.clear();
    cell.stencil = int32_t(out->stencils.size());
    out->stencils.push_back(s);
    out->cells.set(size_t(h.cell), cell);
  }
  return out;
}

}  // namespace limberg::fem
