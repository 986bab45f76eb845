// Which cell takes which stencil, and which nodes may be held.
#include <algorithm>
#include <cmath>
#include <string>

#include "sim/base/error.h"
#include "sim/lattice/shared_cells.h"
#include "sim/lattice/stencil_integrals.h"

namespace limberg {
namespace {

void check_layers(const Body& body) {
  auto fail = [&](const std::string& what) { throw InputError(body.name, 0, what); };
  if (body.layers.empty()) fail("the body has no layer; at least one was expected");
  for (const Layer& l : body.layers) {
    const Material& m = l.material;
    const std::string name = "layer '" + l.name + "': ";
    auto positive = [](double v) { return std::isfinite(v) && v > 0; };
    if (!positive(m.young_kPa)) fail(name + "Young's modulus must be above 0 kPa");
    if (!std::isfinite(m.poisson) || m.poisson < 0 || m.poisson >= 0.5)
      fail(name + "Poisson's ratio must be in [0, 0.5)");
    if (!positive(m.density_kg_mm3)) fail(name + "density must be above 0");
    double shares = 0;
    for (const PronyTerm& t : m.prony) {
      if (!(t.share > 0) || !positive(t.time_s)) fail(name + "relaxation needs shares and times above 0");
      shares += t.share;
    }
    if (!(shares < 1)) fail(name + "the shares of its relaxation must sum to less than 1");
    if (!positive(m.prestretch_along) || !positive(m.prestretch_across)) fail(name + "prestretch must be above 0");
    if (!positive(l.thickness_mm)) fail(name + "thickness must be above 0 mm");
  }
}

// Whether the only skin is the whole top (greatest z) of a box.
bool skin_on_top(const Body& body) {
  if (!body.is_box) return false;
  double top = -INFINITY;
  for (const Vec3& X : body.surface.X_mm) top = std::max(top, X.z());
  for (size_t t = 0; t < body.surface.tri.size(); ++t) {
    if (body.surface.tag[t] != SurfaceTag::skin) continue;
    for (int32_t v : body.surface.tri[t])
      if (body.surface.X_mm[size_t(v)].z() != top) return false;
  }
  return true;
}

// Cells that the body reaches into: the surface meets their box (a little widened: the answer is in floats), or their
// centre lies inside it by the crossings on the way along x.
std::vector<uint8_t> cells_of_body(const Bvh& surface, const LatticeGrid& grid) {
  const Vec3 h = grid.cell_mm(), origin = grid.node_mm({0, 0, 0});
  std::vector<uint8_t> used(size_t(grid.count.x) * size_t(grid.count.y) * size_t(grid.count.z), 0);
  for (int32_t z = 0; z < grid.count.z; ++z)
    for (int32_t y = 0; y < grid.count.y; ++y) {
      const Vec3 row = origin + h.cwiseProduct(Vec3(0, y + 0.5, z + 0.5));
      const auto hits = surface.line(row, Vec3::UnitX(), 0, h.x() * grid.count.x);
      size_t next = 0;
      int depth = 0;
      for (int32_t x = 0; x < grid.count.x; ++x) {
        for (; next < hits.size() && hits[next].t < h.x() * (x + 0.5); ++next) {
          // A line through an edge reports both its triangles: they are one crossing when both face the same way.
          const bool again = next > 0 && hits[next].t - hits[next - 1].t < 1e-9 * h.x() &&
                             hits[next].from_outside == hits[next - 1].from_outside;
          if (!again) depth += hits[next].from_outside ? 1 : -1;
        }
        const Vec3 low = origin + h.cwiseProduct(Vec3(x, y, z));
        bool inside = depth > 0;
        if (!inside) surface.box(low - 1e-4 * h, low + 1.0001 * h, [&](int32_t) { inside = true; });
        used[size_t(grid.cell_index({x, y, z}))] = inside;
      }
    }
  return used;
}

using BoxLayers = std::array<int, kSplit * kSplit * kSplit>;

// The layer of each of the boxes that a cell is summed from, by the depths of its corners.
BoxLayers boxes_of_layers(const Skin& skin, const double corner[8]) {
  BoxLayers layer;
  for (int b = 0; b < int(layer.size()); ++b) {
    const Vec3 x = (Vec3(b % kSplit, b / kSplit % kSplit, b / (kSplit * kSplit)) + Vec3::Constant(0.5)) / kSplit;
    double d = 0;
    for (int k = 0; k < 8; ++k)
      d += corner[k] * (k & 1 ? x[0] : 1 - x[0]) * (k & 2 ? x[1] : 1 - x[1]) * (k & 4 ? x[2] : 1 - x[2]);
    layer[size_t(b)] = skin.layer_at(d);
  }
  return layer;
}

std::vector<LayerMoments> moments_of_boxes(const Vec3& cell_mm) {
  std::vector<LayerMoments> out;
  for (int b = 0; b < kSplit * kSplit * kSplit; ++b) {
    const Vec3 at(b % kSplit, b / kSplit % kSplit, b / (kSplit * kSplit));
    out.push_back(box_moments(cell_mm, at / kSplit, (at + Vec3::Ones()) / kSplit));
  }
  return out;
}

std::vector<LayerPart> parts_of(const std::vector<LayerMoments>& boxes, const BoxLayers& layer,
                                const std::vector<LayerMatter>& matter) {
  std::vector<LayerPart> parts;
  for (size_t l = 0; l < matter.size(); ++l) {
    LayerPart part{&matter[l], {}};
    for (size_t b = 0; b < boxes.size(); ++b)
      if (layer[b] == int(l)) part.moments.add(boxes[b]);
    if (part.moments.volume_mm3 > 0) parts.push_back(part);
  }
  return parts;
}

}  // namespace

StencilTable::~StencilTable() = default;

StencilTable::StencilTable(const Skin& skin, const LatticeGrid& grid) {
  const Body& body = skin.body();
  check_layers(body);
  matter_ = layer_matter(body, laws_);
  skin_ = &skin, grid_ = grid, is_block_ = skin_on_top(body);
  of_cell_.assign(size_t(grid.count.x) * size_t(grid.count.y) * size_t(grid.count.z), 0);
  fixed_.assign(size_t(grid.count.x + 1) * size_t(grid.count.y + 1) * size_t(grid.count.z + 1), 0);
  if (is_block_)
    fill_block(body, grid);
  else
    fill_general(skin, grid);
}

int32_t StencilTable::intern(const Stencil& s) const {
  for (size_t i = 0; i < stencils_.size(); ++i) {
    const Stencil& o = stencils_[i];
    if (o.K == s.K && o.volume_mm3 == s.volume_mm3 && o.mu_kPa == s.mu_kPa && o.lambda_kPa == s.lambda_kPa &&
        o.p0_kPa == s.p0_kPa && o.sample == s.sample && o.density_kg_mm3 == s.density_kg_mm3 && o.level == s.level &&
        o.slide_kPa == s.slide_kPa && o.slide_axes == s.slide_axes &&
        std::equal(o.points.begin(), o.points.end(), s.points.begin(), s.points.end(),
                   [](const MaterialPoint& p, const MaterialPoint& q) {
                     return p.at == q.at && p.volume_mm3 == q.volume_mm3 && p.law == q.law && p.M == q.M;
                   }) &&
        std::equal(o.viscous.begin(), o.viscous.end(), s.viscous.begin(), s.viscous.end(),
                   [](const ViscousPoint& p, const ViscousPoint& q) {
                     return p.at == q.at && p.volume_mm3 == q.volume_mm3 && p.law == q.law && p.M == q.M;
                   }))
      return int32_t(i);
  }
  stencils_.push_back(s);
  return int32_t(stencils_.size()) - 1;
}

// Row z of a grid over a block.
Stencil StencilTable::block_row(const LatticeGrid& grid, int32_t k) const {
  const Body& body = skin_->body();
  const Vec3 h = grid.cell_mm();
  StretchFrame frame;
  Vec3 along = body.tension_direction;
  along.z() = 0;
  if (along.norm() > 1e-9) frame.along = along.normalized();
  frame.across = frame.normal.cross(frame.along);
  double top = -INFINITY;
  for (const Vec3& X : body.surface.X_mm) top = std::max(top, X.z());

  const double low = grid.node_mm({0, 0, k}).z(), high = grid.node_mm({0, 0, k + 1}).z();
  Stencil s;
  std::vector<LayerPart> parts;
  double from = -INFINITY;  // depth of the layer's upper side; the first reaches up without end, the last down
  for (size_t l = 0; l < body.layers.size(); ++l) {
    const double to = l + 1 == body.layers.size() ? INFINITY : (l ? from : 0) + body.layers[l].thickness_mm;
    const double z1 = std::min(high, top - from), z0 = std::max(low, top - to);
    if (z1 > z0) {
      // Cell units; differences of rounding size are the same as nothing.
      const double a = std::max(0.0, (z0 - low) / h.z()), b = std::min(1.0, (z1 - low) / h.z());
      if (b - a > 1e-9) {
        add_box(s, h, {0, 0, a}, {1, 1, b}, matter_[l], frame);
        parts.push_back({&matter_[l], box_moments(h, {0, 0, a}, {1, 1, b})});
      }
    }
    from = to;
  }
  finish_stencil(s);
  share_cell(s, h, parts, frame);
  return s;
}

void StencilTable::fill_block(const Body& body, const LatticeGrid& grid) {
  std::vector<int32_t> of_row;
  for (int32_t k = 0; k < grid.count.z; ++k) of_row.push_back(intern(block_row(grid, k)));
  for (size_t c = 0; c < of_cell_.size(); ++c) of_cell_[c] = of_row[size_t(grid.cell_at(int32_t(c)).z)];

  // Sides of the box that are fixed, and the planes that stand for them.
  Vec3 lo = body.surface.X_mm[0], hi = lo;
  for (const Vec3& X : body.surface.X_mm) lo = lo.cwiseMin(X), hi = hi.cwiseMax(X);
  uint8_t sides = 0;
  for (size_t t = 0; t < body.surface.tri.size(); ++t) {
    if (body.surface.tag[t] != SurfaceTag::fixed) continue;
    for (int a = 0; a < 3; ++a)
      for (int high = 0; high < 2; ++high) {
        bool on = true;
        for (int32_t v : body.surface.tri[t]) on = on && body.surface.X_mm[size_t(v)][a] == (high ? hi[a] : lo[a]);
        if (on) sides |= uint8_t(1u << (2 * a + high));
      }
  }
  fixed_sides_ = sides;
  for (size_t n = 0; n < fixed_.size(); ++n) {
    const Int3 at = grid.node_at(int32_t(n));
    for (int a = 0; a < 3; ++a) {
      if (at[a] == 0) fixed_[n] |= uint8_t(sides & 1u << (2 * a));
      if (at[a] == grid.count[a]) fixed_[n] |= uint8_t(sides & 1u << (2 * a + 1));
    }
  }
}

void StencilTable::fill_general(const Skin& skin, const LatticeGrid& grid) {
  const Body& body = skin.body();
  const Vec3 h = grid.cell_mm();
  const double reach = 0.5 * h.norm();
  const std::vector<uint8_t> used = cells_of_body(skin.surface(), grid);
  const std::vector<GradientTable> tables = gradient_tables(h);
  const std::vector<LayerMoments> moments = moments_of_boxes(h);
  std::vector<double> node_depth(fixed_.size(), NAN);  // asked for when a layer boundary may be near
  std::vector<int32_t> whole(body.layers.size(), -1);  // stencil of a full cell of a layer without prestretch
  for (size_t c = 0; c < of_cell_.size(); ++c) {
    of_cell_[c] = -1;
    if (!used[c]) continue;
    const Vec3 low = grid.node_mm(grid.cell_at(int32_t(c))), centre = low + 0.5 * h;
    const double depth = skin.depth_mm(centre);
    const int upper = skin.layer_at(depth - reach), lower = skin.layer_at(depth + reach);  // depth is 1-Lipschitz
    bool stretched = false;
    for (int l = upper; l <= lower; ++l) stretched = stretched || matter_[size_t(l)].directed();
    if (upper == lower && !stretched && whole[size_t(upper)] >= 0) {
      of_cell_[c] = whole[size_t(upper)];
      continue;
    }
    StretchFrame frame;
    if (stretched || upper != lower) {
      const Skin::Frame f = skin.frame(centre);
      frame = {f.along, f.across, f.normal};
    }
    Stencil s;
    std::vector<LayerPart> parts;
    if (upper == lower) {
      add_box(s, h, Vec3::Zero(), Vec3::Ones(), matter_[size_t(upper)], frame);
    } else {
      const Int3 at = grid.cell_at(int32_t(c));
      double corner[8];
      for (int k = 0; k < 8; ++k) {
        double& d = node_depth[size_t(grid.node_index({at.x + (k & 1), at.y + (k >> 1 & 1), at.z + (k >> 2 & 1)}))];
        if (std::isnan(d)) d = skin.depth_mm(low + h.cwiseProduct(Vec3(k & 1, k >> 1 & 1, k >> 2 & 1)));
        corner[k] = d;
      }
      const BoxLayers layer = boxes_of_layers(skin, corner);
      s = layered_stencil(h, tables, matter_, layer, frame);
      parts = parts_of(moments, layer, matter_);
    }
    finish_stencil(s);
    share_cell(s, h, parts, frame);
    of_cell_[c] = int32_t(stencils_.size());
    if (upper == lower && !stretched) whole[size_t(upper)] = of_cell_[c];
    stencils_.push_back(s);
  }
  const double near = 0.1 * h.minCoeff(), far = 2 * h.norm();
  for (size_t n = 0; n < fixed_.size(); ++n) {
    const Bvh::Closest hit = skin.surface().closest(grid.node_mm(grid.node_at(int32_t(n))), far);
    if (hit.triangle < 0 || body.surface.tag[size_t(hit.triangle)] != SurfaceTag::fixed) continue;
    fixed_[n] = hit.distance_mm <= near ? kNearFixed : kFarFixed;
  }
}

// As the loop of fill_general, for one part of a cell.
Stencil StencilTable::general_part(const LatticeGrid& grid, Int3 at) const {
  const Vec3 h = grid.cell_mm(), low = grid.node_mm(at), centre = low + 0.5 * h;
  const double depth = skin_->depth_mm(centre), reach = 0.5 * h.norm();
  const int upper = skin_->layer_at(depth - reach), lower = skin_->layer_at(depth + reach);
  StretchFrame frame;
  for (int l = upper; l <= lower; ++l) {
    if (upper == lower && !matter_[size_t(l)].directed()) continue;
    const Skin::Frame f = skin_->frame(centre);
    frame = {f.along, f.across, f.normal};
    break;
  }
  Stencil s;
  std::vector<LayerPart> parts;
  if (upper == lower) {
    add_box(s, h, Vec3::Zero(), Vec3::Ones(), matter_[size_t(upper)], frame);
  } else {
    double corner[8];
    for (int k = 0; k < 8; ++k) corner[k] = skin_->depth_mm(low + h.cwiseProduct(Vec3(k & 1, k >> 1 & 1, k >> 2 & 1)));
    const BoxLayers layer = boxes_of_layers(*skin_, corner);
    s = layered_stencil(h, gradient_tables(h), matter_, layer, frame);
    parts = parts_of(moments_of_boxes(h), layer, matter_);
  }
  finish_stencil(s);
  share_cell(s, h, parts, frame);
  return s;
}

int32_t StencilTable::of_place(const CellPlace& place) const {
  if (place.level == 0) return of_cell(grid_.cell_index(place.at));
  const std::array<int32_t, 4> key{place.level, is_block_ ? 0 : place.at.x, is_block_ ? 0 : place.at.y, place.at.z};
  const auto [it, is_new] = of_part_.try_emplace(key, -1);
  if (is_new) {
    const LatticeGrid grid = grid_.at_level(place.level);
    Stencil s = is_block_ ? block_row(grid, place.at.z) : general_part(grid, place.at);
    s.level = uint8_t(place.level);
    it->second = intern(s);
  }
  return it->second;
}

uint8_t StencilTable::fixed_candidate(Int3 at) const {
  if (at.x % kEighths == 0 && at.y % kEighths == 0 && at.z % kEighths == 0)
    return fixed_[size_t(grid_.node_index({at.x / kEighths, at.y / kEighths, at.z / kEighths}))];
  uint8_t may = 0;
  if (is_block_) {
    for (int a = 0; a < 3; ++a) {
      if (at[a] == 0) may |= uint8_t(fixed_sides_ & 1u << (2 * a));
      if (at[a] == kEighths * grid_.count[a]) may |= uint8_t(fixed_sides_ & 1u << (2 * a + 1));
    }
    return may;
  }
  const auto [it, is_new] = fixed_part_.try_emplace({at.x, at.y, at.z}, uint8_t(0));
  if (!is_new) return it->second;
  const LatticeGrid grid = grid_.at_level(kLevels);
  const Vec3 h = grid.cell_mm();
  const Bvh::Closest hit = skin_->surface().closest(grid.node_mm(at), 2 * grid_.cell_mm().norm());
  if (hit.triangle >= 0 && skin_->body().surface.tag[size_t(hit.triangle)] == SurfaceTag::fixed)
    it->second = hit.distance_mm <= 0.1 * h.minCoeff() ? kNearFixed : kFarFixed;
  return it->second;
}

}  // namespace limberg
