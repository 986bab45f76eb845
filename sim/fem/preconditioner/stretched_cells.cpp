#include "sim/fem/preconditioner/stretched_cells.h"

#include <Eigen/Eigenvalues>
#include <map>

#include "sim/fem/elements/effective_bulk.h"
#include "sim/fem/elements/element_system.h"
#include "sim/fem/model/masters.h"

namespace limberg::fem {
namespace {

// Measured on the shipped rhomboid with divided fronts (2026-11-22), iterations from drawing the donor stitch to rest:
// with 16 958, with 6 1197, without any not at rest after 2000.
constexpr double kTooSoft = 16;
constexpr double kOff = 4;    // rows are made again where the stiffness is so many times what they have
constexpr size_t kFew = 2;    // one, as a hook makes, is left to the history: a row costs in every iteration
constexpr size_t kMost = 64;  // where more is drawn out it is a tangle, not a stitch
constexpr size_t kStretchedGrain = 2048;

}  // namespace

bool StretchedCells::follow(const FemModel& m, const NodeArray& u, bool augmented, const Engine& engine) {
  std::vector<std::vector<Direction>> of_chunk(m.cells.size() / kStretchedGrain + 1);
  engine.run(m.cells.size(), kStretchedGrain, [&](size_t begin, size_t end) {
    for (size_t c = begin; c < end; ++c) {
      const HexCell& cell = m.cells[c];
      const Stencil& s = m.stencils[size_t(cell.stencil)];
      const double ke = effective_bulk_kPa(s, augmented);
      if (!(cell.scale > 0) || !(ke > 0)) continue;
      const Mat3 F = gradient_at(volume_gradients(s, m.cell_mm), cell, u);
      Mat3 cof;
      for (int i = 0; i < 3; ++i) cof.col(i) = F.col((i + 1) % 3).cross(F.col((i + 2) % 3));
      const double rest = ke + s.mu_kPa, bar = 1 + kTooSoft * rest / ke;
      if (!(cof.squaredNorm() > bar)) continue;
      const Eigen::SelfAdjointEigenSolver<Mat3> eigen(cof.transpose() * cof);
      for (int k = 0; k < 3; ++k)
        if (const double e = eigen.eigenvalues()[k]; e > bar)
          of_chunk[begin / kStretchedGrain].push_back({int32_t(c), double(cell.scale) * ke * s.volume_mm3 * (e - 1),
                                                       ke * (e - 1) / rest, eigen.eigenvectors().col(k)});
    }
  });
  std::vector<Direction> now;
  for (const auto& part : of_chunk) now.insert(now.end(), part.begin(), part.end());
  if (now.size() > kMost) return false;
  if (now.size() < kFew) now.clear();
  if (now.empty() ? found_.empty() : enough(now)) return false;
  found_ = std::move(now);
  rows_.clear();
  const Masters masters(m);
  for (const Direction& d : found_) {
    const HexCell& cell = m.cells[size_t(d.cell)];
    const Eigen::Matrix<double, 8, 3> B = volume_gradients(m.stencils[size_t(cell.stencil)], m.cell_mm);
    std::map<int32_t, double> weight;
    for (int a = 0; a < 8; ++a)
      masters.each(cell.node[size_t(a)], [&](int32_t v, double w) {
        if (!m.fixed[size_t(v)].all()) weight[v] += w * B.row(a).dot(d.N);
      });
    SpringRow& row = rows_.emplace_back();
    row.id = next_id_--, row.k_mN_per_mm = d.lacking;
    for (const auto& [v, w] : weight) row.node.push_back(v), row.w.push_back(w);
  }
  return true;
}

// A cell has one direction that counts, or two in which it is thin alike.
bool StretchedCells::enough(std::span<const Direction> now) const {
  auto held = found_.begin();
  for (const Direction& d : now) {
    while (held != found_.end() && held->cell < d.cell) ++held;
    double has = 0;
    for (auto h = held; h != found_.end() && h->cell == d.cell; ++h) has = std::max(has, h->times);
    if (d.times > kOff * std::max(has, kTooSoft / kOff)) return false;
  }
  return true;
}

}  // namespace limberg::fem
