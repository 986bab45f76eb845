#include "sim/fem/elements/element_system.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <numeric>

namespace limberg::fem {
namespace {

KernelStencil kernel_stencil(const Stencil& s, const Vec3& cell_mm, bool augmented) {
  KernelStencil k{};
  const Vec3 h = cell_size_mm(cell_mm, s.level);
  const Eigen::Matrix<double, 8, 3> B = sample_gradients(s, cell_mm);
  Eigen::Matrix<double, 8, 3> X;
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i) {
      X(a, i) = (a >> i & 1) ? h[i] : 0;
    }
  const Eigen::Matrix<double, 8, 3> Bv = volume_gradients(s, cell_mm);
  Eigen::Matrix<double, 8, 3> f0 = s.K * X - s.p0_kPa * s.volume_mm3 * Bv;
  if (s.rest_mN) f0 = *s.rest_mN;
  if (s.slide_kPa != 0) {  // the slopes at rest of what layers add (layer_slide.h)
    const Vec3 N = s.slide_axes.col(2);
    f0 += s.slide_kPa * s.volume_mm3 * (Bv * N) * N.transpose();
    f0 -= s.p0_kPa * s.volume_mm3 * (B - Bv) * (Mat3::Identity() - N * N.transpose());
    k.slide = float(s.slide_kPa), k.rest = float(s.p0_kPa), k.rest_lambda = float(effective_bulk_kPa(s, true));
    for (int i = 0; i < 3; ++i)
      k.along[i] = float(s.slide_axes(i, 0)), k.across[i] = float(s.slide_axes(i, 1)), k.normal[i] = float(N[i]);
  }
  for (int b = 0; b < 8; ++b)
    for (int a = 0; a < 8; ++a) k.K[8 * b + a] = float(s.K(a, b));
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i) k.f0[4 * a + i] = float(f0(a, i));
  k.centred = (!s.mean_gradients && s.sample == Vec3::Constant(0.5)) || s.slide_kPa != 0;
  for (int e = 0; e < 4; ++e)
    k.bx[e] = float(B(2 * e + 1, 0)), k.by[e] = float(B(2 * (e & 2) + 2 + (e & 1), 1)), k.bz[e] = float(B(4 + e, 2));
  for (int i = 0; i < 3; ++i) k.inv4h[i] = float(1 / (4 * h[i]));
  if (!s.points.empty() && s.points[0].gradients) {  // no box: all its energy is in its points; theta stays 0 here
    k.centred = false;
    for (int e = 0; e < 4; ++e) k.bx[e] = k.by[e] = k.bz[e] = 0;
  }
  k.volume = float(s.volume_mm3);
  k.p0 = float(s.p0_kPa);
  k.ke = float(effective_bulk_kPa(s, augmented));
  const double pen = penalty_kPa(s);
  k.r = uses_multiplier(s, augmented) ? float(s.lambda_kPa / (s.lambda_kPa + pen)) : 0;
  return k;
}

}  // namespace

bool same_stencils(const FemModel& a, const FemModel& b) {
  bool same = a.stencils.size() == b.stencils.size() && a.cell_mm == b.cell_mm && a.laws == b.laws;
  for (size_t c = 0; same && c < a.stencils.chunks(); ++c) same = a.stencils.shares(b.stencils, c);
  return same;
}

ElementSystem::ElementSystem(std::shared_ptr<const FemModel> model, bool augmented, const FemModel* before,
                             const ElementSystem* system_before) {
  const FemModel& m = *model;
  const size_t n = m.X_mm.size(), nc = m.cells.size();
  const bool carry = before && system_before && before->cell_mm == m.cell_mm;
  int32_t same_up_to = 0;  // stencils that are those of before
  if (carry && same_stencils(m, *before)) {
    data_.stencils = system_before->data_.stencils;
    same_up_to = int32_t(m.stencils.size());
    has_multipliers_ = system_before->has_multipliers_;
  } else {
    const auto made = std::make_shared<AlignedArray<KernelStencil>>(m.stencils.size());
    for (size_t i = 0; i < m.stencils.size(); ++i) {
      if (carry && m.stencils.shares(before->stencils, i / SharedArray<Stencil>::kChunk))
        (*made)[i] = (*system_before->data_.stencils)[i], same_up_to += same_up_to == int32_t(i);
      else
        (*made)[i] = kernel_stencil(m.stencils[i], m.cell_mm, augmented);
      has_multipliers_ = has_multipliers_ || (*made)[i].r > 0;
    }
    data_.stencils = made;
  }

  std::vector<uint8_t> changed;
  std::optional<TileOrder> followed;
  if (carry) followed = order_cells(m, *before, system_before->order_, changed);
  order_ = followed ? std::move(*followed) : order_cells(m);
  lay_lanes(followed ? system_before : nullptr, lay_tiles(m, followed ? system_before : nullptr, changed), same_up_to);

  data_.node_slots_begin.assign(n + 1, 0);
  for (int32_t node : data_.slot_node) ++data_.node_slots_begin[size_t(node) + 1];
  std::partial_sum(data_.node_slots_begin.begin(), data_.node_slots_begin.end(), data_.node_slots_begin.begin());
  data_.node_slots.resize(data_.slot_node.size());
  std::vector<int32_t> fill(data_.node_slots_begin.begin(), data_.node_slots_begin.end() - 1);
  for (size_t s = 0; s < data_.slot_node.size(); ++s)
    data_.node_slots[size_t(fill[size_t(data_.slot_node[s])]++)] = int32_t(s);

  slots_.resize(data_.slot_node.size());
  theta_.resize(nc), q_.resize(nc);
  tile_sums_.resize(data_.tiles.size());
}

std::vector<int32_t> ElementSystem::lay_tiles(const FemModel& m, const ElementSystem* earlier,
                                              std::span<const uint8_t> changed) {
  const size_t n = m.X_mm.size(), nc = m.cells.size(), present = order_.present;
  const std::vector<TileKey>& order = order_.key;
  data_.cells.resize(nc);
  slot_of_cell_.resize(nc);
  for (size_t k = present; k < nc; ++k) {
    slot_of_cell_[size_t(order[k].index)] = int32_t(k);
    data_.cells[k] = {};
    data_.cells[k].stencil = m.cells[size_t(order[k].index)].stencil;
  }
  // Tiles of the earlier system of which no cell has changed.
  static const std::vector<Tile> none;
  const std::vector<Tile>& tiles_before = earlier ? earlier->data_.tiles : none;
  std::vector<uint8_t> whole(tiles_before.size(), 1);
  for (size_t t = 0; t < tiles_before.size(); ++t)
    for (int32_t k = tiles_before[t].first_cell; k < tiles_before[t].last_cell && whole[t]; ++k)
      whole[t] = !changed[size_t(earlier->order_.key[size_t(k)].index)];

  std::vector<int32_t> local(n, -1);  // slot of a node in the open tile, or below its first slot: it has none yet
  Tile tile;
  bool numbered = true;  // `local` knows the nodes of the open tile
  size_t next_before = 0;
  std::vector<int32_t> begins;  // per tile
  for (size_t k = 0; k < present;) {
    const int32_t c = order[k].index;
    if (tile_ends(int(k) - tile.first_cell, k > 0 && order[k].tile() != order[k - 1].tile())) {
      tile.last_cell = int32_t(k), tile.last_slot = int32_t(data_.slot_node.size());
      data_.tiles.push_back(tile);
      tile.first_cell = tile.last_cell, tile.first_slot = tile.last_slot;
      numbered = true;
    }
    if (earlier && int32_t(k) == tile.first_cell &&
        size_t(c) < changed.size()) {  // one of the earlier tiles, as it was?
      const int32_t place = earlier->slot_of_cell_[size_t(c)];
      while (next_before < tiles_before.size() && tiles_before[next_before].first_cell < place) ++next_before;
      if (next_before < tiles_before.size() && tiles_before[next_before].first_cell == place && whole[next_before]) {
        const Tile& was = tiles_before[next_before];
        const size_t size = size_t(was.last_cell - was.first_cell);
        if (k + size <= present && order[k + size - 1].index == earlier->order_.key[size_t(was.last_cell) - 1].index) {
          std::copy_n(earlier->data_.cells.data() + was.first_cell, size, data_.cells.data() + k);
          for (size_t i = k; i < k + size; ++i) slot_of_cell_[size_t(order[i].index)] = int32_t(i);
          const auto slots = earlier->data_.slot_node.begin();
          data_.slot_node.insert(data_.slot_node.end(), slots + was.first_slot, slots + was.last_slot);
          numbered = false;
          begins.resize(data_.tiles.size() + 1, -1), begins.back() = int32_t(next_before);
          k += size;
          continue;
        }
      }
    }
    if (!numbered)
      for (size_t s = size_t(tile.first_slot); s < data_.slot_node.size(); ++s)
        local[size_t(data_.slot_node[s])] = int32_t(s);
    numbered = true;
    const HexCell& from = m.cells[size_t(c)];
    slot_of_cell_[size_t(c)] = int32_t(k);
    KernelCell& to = data_.cells[k];
    to.stencil = from.stencil, to.scale = from.scale;
    for (int a = 0; a < 8; ++a) {
      const size_t node = size_t(from.node[size_t(a)]);
      if (local[node] < tile.first_slot)
        local[node] = int32_t(data_.slot_node.size()), data_.slot_node.push_back(int32_t(node));
      to.node[a] = uint16_t(local[node] - tile.first_slot);
    }
    ++k;
  }
  tile.last_cell = int32_t(present), tile.last_slot = int32_t(data_.slot_node.size());
  if (present) data_.tiles.push_back(tile);
  begins.resize(data_.tiles.size(), -1);
  return begins;
}

void ElementSystem::lay_lanes(const ElementSystem* earlier, std::span<const int32_t> tile_before, int32_t same_up_to) {
  const KernelStencil* stencils = data_.stencils->data();
  data_.lanes.resize(data_.tiles.size());
  for (size_t t = 0; t < data_.tiles.size(); ++t) {
    Tile& tile = data_.tiles[t];
    const std::span<const KernelCell> cells(data_.cells.data() + tile.first_cell,
                                            size_t(tile.last_cell - tile.first_cell));
    const auto as_before = [&] {
      if (!earlier || tile_before[t] < 0) return false;
      const Tile& was = earlier->data_.tiles[size_t(tile_before[t])];
      if (was.last_cell - was.first_cell != int32_t(cells.size())) return false;
      const KernelStencil* before = earlier->data_.stencils->data();
      return std::all_of(cells.begin(), cells.end(), [&](const KernelCell& c) {
        return c.stencil < same_up_to ||
               std::memcmp(before + c.stencil, stencils + c.stencil, sizeof(KernelStencil)) == 0;
      });
    };
    data_.lanes[t] = as_before() ? earlier->data_.lanes[size_t(tile_before[t])] : lane_blocks(stencils, cells);
    if (data_.lanes[t]) tile.lanes = {data_.lanes[t]->block.data(), data_.lanes[t]->kind.data()};
  }
}

CellSums ElementSystem::evaluate(const NodeArray& u, NodeArray& g, bool measure, const Engine& engine) {
  const Kernels& k = engine.kernels();
  CellView view = data_.view();
  if (shape_only_) view.stencils = shape_stencils_.data();
  if (plain_) view.stencils = plain_stencils_.data();
  engine.run(data_.tiles.size(), 1, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      Tile tile = data_.tiles[t];
      if (shape_only_ || plain_) tile.lanes = {};  // they hold the usual stencils
      tile_sums_[t] = k.evaluate_tile(view, tile, u.data(), q_.data(), slots_.data(), theta_.data(), measure);
    }
  });
  engine.run(g.size(), 2048, [&](size_t begin, size_t end) { k.sum_slots(view, slots_.data(), begin, end, g.data()); });
  CellSums total;
  for (const CellSums& s : tile_sums_) total.energy += s.energy, total.magnitude += s.magnitude;
  return total;
}

void ElementSystem::shape_only(bool on) {
  shape_only_ = on;
  if (!on || !shape_stencils_.empty()) return;
  shape_stencils_ = *data_.stencils;
  for (KernelStencil& k : shape_stencils_) {
    std::fill(std::begin(k.f0), std::end(k.f0), 0.0f);
    k.p0 = k.ke = k.r = k.slide = 0;
  }
}

void ElementSystem::plain(bool on) {
  if (on == plain_) return;
  plain_ = on;
  if (!on) {
    AlignedArray<float> none;
    settle_multipliers(none);
    return;
  }
  std::fill(q_.begin(), q_.end(), 0.0f);
  if (!plain_stencils_.empty()) return;
  plain_stencils_ = *data_.stencils;
  for (KernelStencil& k : plain_stencils_) k.ke /= 1 - k.r, k.r = 0;
}

bool ElementSystem::overloaded() const {
  constexpr float most = 2;
  constexpr size_t one_in = 64;
  if (!has_multipliers_) return false;
  return one_in * size_t(std::count_if(q_.begin(), q_.end(), [](float q) { return std::fabs(q) > most; })) >= q_.size();
}

bool ElementSystem::update_multipliers(const Engine& engine, double scale_of_increment) {
  if (!has_multipliers_ || shape_only_ || plain_) return false;
  const CellView view = data_.view();
  engine.run(data_.cells.size(), 8192, [&](size_t begin, size_t end) {
    engine.kernels().update_multipliers(view, theta_.data(), q_.data(), float(scale_of_increment), begin, end);
  });
  return true;
}

bool ElementSystem::settle_multipliers(AlignedArray<float>& before, std::span<const int32_t> but) {
  if (!has_multipliers_ || shape_only_ || plain_) return false;
  before = q_;
  for (size_t c = 0; c < data_.cells.size(); ++c) {
    const float r = (*data_.stencils)[size_t(data_.cells[c].stencil)].r;
    if (r > 0) q_[c] = r / (1 - r) * theta_[c];
  }
  for (int32_t cell : but) {
    const size_t c = size_t(slot_of_cell_[size_t(cell)]);
    q_[c] = before[c];
  }
  return true;
}

double ElementSystem::energy_to_primal() const {
  if (plain_) return 0;
  double e = 0;
  for (size_t c = 0; c < data_.cells.size(); ++c) {
    const KernelStencil& s = (*data_.stencils)[size_t(data_.cells[c].stencil)];
    if (s.r == 0) continue;
    const double lambda = double(s.ke) / (1 - double(s.r)), th = double(theta_[c]), x = th + double(q_[c]);
    e += 0.5 * double(data_.cells[c].scale * s.volume) * (lambda * th * th - double(s.ke) * x * x);
  }
  return e;
}

float ElementSystem::min_theta() const {
  float m = theta_.empty() ? 0 : theta_[0];
  for (float t : theta_) m = std::min(m, t);
  return m;
}

int ElementSystem::inverted() const {
  return int(std::count_if(theta_.begin(), theta_.end(), [](float t) { return !(t > -1.0f); }));
}

}  // namespace limberg::fem
