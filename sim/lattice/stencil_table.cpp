// Which cell takes which stencil, and which nodes may be held.
#include <algorithm>
#include <cmath>
#include <string>

#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/lattice/held_cells.h"
#include "sim/lattice/layered_cell.h"
#include "sim/lattice/region_cells.h"

namespace limberg {
namespace {

void check_layers(const Body& body) {
  auto fail = [&](const std::string& what) { throw InputError(body.name, 0, what); };
  if (body.layers.empty()) fail("the body has no layer; at least one was expected");
  auto positive = [](double v) { return std::isfinite(v) && v > 0; };
  const auto check = [&](const Material& m, const std::string& name) {
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
  };
  for (const Layer& l : body.layers) {
    check(l.material, "layer '" + l.name + "': ");
    if (!positive(l.thickness_mm)) fail("layer '" + l.name + "': thickness must be above 0 mm");
  }
  for (const auto& r : body.regions) check(r->material(), "region '" + r->name() + "': ");
}

double top_of(const Body& body) {
  double top = -INFINITY;
  for (const Vec3& X : body.surface.X_mm) top = std::max(top, X.z());
  return top;
}

// Whether the only skin is the whole top (greatest z) of a box.
bool skin_on_top(const Body& body) {
  if (!body.is_box) return false;
  const double top = top_of(body);
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

// Beside the exact integrals a cell that the body does not fill keeps a share of its K with the same matter spread
// over the whole cell: for an even gradient that is the same, and nodes far from the matter stay solvable in float.
// More of it makes skin bend too stiffly; slivers, whose own bending is nothing, take more. (A shell of 21,000 nodes
// with kSpread alone stops .12 mm from equilibrium at the residual of 1e-5; so .009 mm.)
constexpr double kSpread = 0.01, kSpreadOfSlivers = 6e-4, kMostSpread = 0.5;
double spread_of(double fraction) {
  if (fraction >= 1 - 1e-6) return 0;
  return std::min(kMostSpread, std::max(kSpread, kSpreadOfSlivers / (fraction * fraction)));
}
constexpr size_t kPartsAtOnce = 4;  // some .1 ms each
// A cell of which the body takes less (by its samples) is taken as one of one layer.
constexpr double kSliver = 1e-3;

std::vector<double> ends_of_layers(const Body& body) {
  std::vector<double> end;
  for (size_t l = 0; l + 1 < body.layers.size(); ++l) end.push_back((l ? end[l - 1] : 0) + body.layers[l].thickness_mm);
  return end;
}

// Where the n-th sample of a cell lies, in cell units.
Vec3 sample_place(int n) {
  return Vec3(n % (kSplit + 1), n / (kSplit + 1) % (kSplit + 1), n / ((kSplit + 1) * (kSplit + 1))) / kSplit;
}

// How much of Skin::Place::thicker_mm a cell has more on one side than on the other, a mm.
Vec3 slope_of_thicker(const CellSamples& samples, const Vec3& h) {
  Vec3 out = Vec3::Zero();
  for (int c = 0; c < 8; ++c) {
    int at = 0;
    for (int a = 2; a >= 0; --a) at = at * (kSplit + 1) + (c >> a & 1) * kSplit;
    for (int a = 0; a < 3; ++a) out[a] += (c >> a & 1 ? 0.25 : -0.25) * samples[size_t(at)].thicker_mm / h[a];
  }
  return out;
}

// A corner of a part, on the grid of its level, and in eighths of a cell.
Int3 corner_of(Int3 at, int k) { return {at.x + (k & 1), at.y + (k >> 1 & 1), at.z + (k >> 2 & 1)}; }
Int3 in_eighths(Int3 corner, int level) {
  const int32_t size = kEighths >> level;
  return {size * corner.x, size * corner.y, size * corner.z};
}

// Samples of a cell of one layer that only the held surface cuts: from the distances of its corners.
CellSamples above_held(const HeldCorners& held, const Skin::Place& place) {
  CellSamples out;
  for (int n = 0; n < kSamples; ++n) {
    const Vec3 at = sample_place(n);
    double d = 0;
    for (size_t c = 0; c < 8; ++c)
      d += held.depth_mm[c] * (c & 1 ? at[0] : 1 - at[0]) * (c & 2 ? at[1] : 1 - at[1]) * (c & 4 ? at[2] : 1 - at[2]);
    out[size_t(n)] = place;
    out[size_t(n)].inside_mm = d;
  }
  return out;
}

}  // namespace

struct StencilTable::Made {
  Stencil stencil;
  double body_mm3 = 0;
  std::shared_ptr<LayeredCell> layered;
  uint8_t held = 0;                  // corners
  std::vector<double> region_mm3{};  // what each region takes; empty: nothing
};

StencilTable::~StencilTable() = default;

StencilTable::StencilTable(const Skin& skin, const LatticeGrid& grid) {
  const Body& body = skin.body();
  check_layers(body);
  matter_ = layer_matter(body, laws_);
  for (const auto& r : body.regions) activation_.push_back(r->activation().value_or(0));
  layer_ends_ = ends_of_layers(body);
  skin_ = &skin, grid_ = grid, is_block_ = skin_on_top(body), top_mm_ = top_of(body);
  region_mm3_.assign(body.regions.size(), 0);
  if (!body.regions.empty()) regions_ = std::make_unique<RegionCells>(skin, layer_ends_);
  of_cell_.assign(size_t(grid.count.x) * size_t(grid.count.y) * size_t(grid.count.z), 0);
  fixed_.assign(size_t(grid.count.x + 1) * size_t(grid.count.y + 1) * size_t(grid.count.z + 1), 0);
  if (is_block_)
    fill_block(body, grid);
  else
    fill_general(skin, grid);
  for (size_t r = 0; r < body.regions.size(); ++r)
    if (!(region_mm3_[r] > 0))
      throw InputError(body.name, 0,
                       "region '" + body.regions[r]->name() +
                           "' takes nothing of the tissue; expected a place in it that no later region covers");
}

void StencilTable::activate(const std::vector<double>& activation) {
  const Body& body = skin_->body();
  for (size_t r = 0; r < body.regions.size(); ++r) {
    if (activation[r] == activation_[r]) continue;
    LayerMatter& m = matter_[body.layers.size() + r];
    for (LawSpec::Constant& c : m.material.law.constants)
      if (c.key == kActivation) c.value = {activation[r]};
    m.response = layer_response(m.material, body.laws.get());
    if (m.points_law >= 0) laws_[size_t(m.points_law)] = m.response.points;
    if (m.whole_law >= 0) laws_[size_t(m.whole_law)] = m.response.whole;
  }
  activation_ = activation;
}

// Samples of neighbouring cells are shared: a layer of cells keeps its upper plane for the next.
class StencilTable::Sampler {
 public:
  Sampler(const Skin& skin, const LatticeGrid& grid)
      : skin_(skin), grid_(grid), nx_(kSplit * grid.count.x + 1), ny_(kSplit * grid.count.y + 1) {}
  /// Of a cell; z must not fall.
  const CellSamples& of(Int3 cell) {
    if (plane_.empty()) plane_.assign(kSplit + 1, std::vector<Skin::Place>(size_t(nx_) * size_t(ny_), kUnknown));
    for (; z_ < cell.z; ++z_) next_layer();
    const Vec3 low = grid_.node_mm(cell), step = grid_.cell_mm() / kSplit;
    for (int k = 0, n = 0; k <= kSplit; ++k)
      for (int j = 0; j <= kSplit; ++j)
        for (int i = 0; i <= kSplit; ++i, ++n) {
          const size_t at = size_t(kSplit * cell.y + j) * size_t(nx_) + size_t(kSplit * cell.x + i);
          Skin::Place& p = plane_[size_t(k)][at];
          if (std::isnan(p.inside_mm)) {
            p = skin_.place(low + step.cwiseProduct(Vec3(i, j, k)), near_);
            known_[size_t(k)].push_back(at);
          }
          out_[size_t(n)] = p;
        }
    return out_;
  }

 private:
  const Skin::Place kUnknown{NAN, NAN, Vec3::Zero()};
  void next_layer() {
    for (size_t k = 0; k < kSplit; ++k) {
      for (size_t at : known_[k]) plane_[k][at] = kUnknown;
      known_[k].clear();
    }
    std::swap(plane_[0], plane_[kSplit]);
    std::swap(known_[0], known_[kSplit]);
  }
  const Skin& skin_;
  LatticeGrid grid_;
  int32_t nx_, ny_, z_ = 0;
  std::vector<std::vector<Skin::Place>> plane_;
  std::array<std::vector<size_t>, kSplit + 1> known_;
  CellSamples out_;
  Skin::Near near_;
};

static uint64_t some_of(const Stencil& s, double body_mm3) {
  Hash64 h;
  for (double x : {s.K(0, 0), s.K(0, 1), s.volume_mm3, s.p0_kPa, body_mm3}) h.add(x + 0.0);  // no zero below zero
  return h.value();
}

int32_t StencilTable::intern(Made made) const {
  const Stencil& s = made.stencil;
  const double body_mm3 = made.body_mm3;
  const auto alike = alike_.find(some_of(s, body_mm3));
  if (alike == alike_.end()) return add(std::move(made));
  for (const int32_t at : alike->second) {
    const size_t i = size_t(at);
    const Stencil& o = std::as_const(stencils_)[i];
    if (body_mm3_[i] == body_mm3 && held_of_[i] == made.held && o.K == s.K && o.volume_mm3 == s.volume_mm3 &&
        o.mu_kPa == s.mu_kPa && o.lambda_kPa == s.lambda_kPa && o.p0_kPa == s.p0_kPa && o.sample == s.sample &&
        o.density_kg_mm3 == s.density_kg_mm3 && o.level == s.level && o.slide_kPa == s.slide_kPa &&
        o.slide_axes == s.slide_axes && o.rest_mN == s.rest_mN && o.mean_gradients == s.mean_gradients &&
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
  return add(std::move(made));
}

namespace {

StretchFrame frame_of_block(const Body& body) {
  StretchFrame frame;
  Vec3 along = body.tension_direction;
  along.z() = 0;
  if (along.norm() > 1e-9) frame.along = along.normalized();
  frame.across = frame.normal.cross(frame.along);
  return frame;
}

}  // namespace

// Row z of a grid over a block.
StencilTable::Made StencilTable::block_row(const LatticeGrid& grid, int32_t k) const {
  const Body& body = skin_->body();
  const Vec3 h = grid.cell_mm();
  const StretchFrame frame = frame_of_block(body);
  const double top = top_mm_;

  const double low = grid.node_mm({0, 0, k}).z(), high = grid.node_mm({0, 0, k + 1}).z();
  Stencil s;
  std::vector<LayerPart> parts;
  auto layered = std::make_shared<LayeredCell>();
  layered->frame = frame;
  layered->depth.at_centre_mm = top - 0.5 * (low + high);
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
        layered->parts.push_back({int(l), l, frame, box_cell_moments(h, {0, 0, a}, {1, 1, b})});
      }
    }
    from = to;
  }
  finish_stencil(s);
  share_cell(s, h, parts, frame);
  if (parts.size() < 2) layered = nullptr;
  return {std::move(s), h.prod(), std::move(layered)};
}

// Whether a cell of a block may be made of something else than its row.
bool StencilTable::unlike_its_row(const CellPlace& place) const {
  if (!regions_ && skin_->even()) return false;
  const LatticeGrid grid = grid_.at_level(place.level);
  const Vec3 h = grid.cell_mm(), centre = grid.node_mm(place.at) + 0.5 * h;
  const double depth_mm = top_mm_ - centre.z();
  const double reach = 0.5 * h.z();
  const std::pair<int, int> within = skin_->layers_within(depth_mm, reach),
                            of_row{skin_->layer_at(depth_mm - reach), skin_->layer_at(depth_mm + reach)};
  if (!skin_->even() && (within.first != within.second || within != of_row)) return true;
  Skin::Near near;
  return regions_ && regions_->reach(centre, place_in_block(centre, near), 0.5 * h.norm());
}

// A place of a block, as though it went on beside its sides and below.
Skin::Place StencilTable::place_in_block(const Vec3& X_mm, Skin::Near& near) const {
  Skin::Place p{1e6, top_mm_ - X_mm.z(), -Vec3::UnitZ()};
  if (!skin_->even()) {
    skin_->depth_mm(X_mm, near.skin);
    p.thicker_mm = p.depth_mm - skin_->in_layers_mm(p.depth_mm, near.skin);
  }
  return p;
}

// A cell of a block of which regions take a part, or whose layers are not as thick everywhere.
StencilTable::Made StencilTable::block_cell(const LatticeGrid& grid, Int3 at) const {
  const Vec3 h = grid.cell_mm(), low = grid.node_mm(at);
  CellSamples samples;
  Skin::Near near;
  for (int n = 0; n < kSamples; ++n) samples[size_t(n)] = place_in_block(low + h.cwiseProduct(sample_place(n)), near);
  const Skin::Place centre = place_in_block(low + 0.5 * h, near);
  return divided_cell(CellCutter(h, layer_ends_), samples, {}, low + 0.5 * h, centre, frame_of_block(skin_->body()));
}

void StencilTable::fill_block(const Body& body, const LatticeGrid& grid) {
  std::vector<int32_t> of_row;
  for (int32_t k = 0; k < grid.count.z; ++k) of_row.push_back(intern(block_row(grid, k)));
  for (size_t c = 0; c < of_cell_.size(); ++c) {
    const Int3 at = grid.cell_at(int32_t(c));
    of_cell_[c] = unlike_its_row({0, at}) ? intern(block_cell(grid, at)) : of_row[size_t(at.z)];
  }

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
  fixed_sides_ = sides, sliding_sides_ = body.sliding_sides;
  for (size_t n = 0; n < fixed_.size(); ++n) {
    const Int3 at = grid.node_at(int32_t(n));
    for (int a = 0; a < 3; ++a) {
      if (at[a] == 0) fixed_[n] |= uint8_t(sides & 1u << (2 * a));
      if (at[a] == grid.count[a]) fixed_[n] |= uint8_t(sides & 1u << (2 * a + 1));
    }
  }
}

namespace {

// A cell that has these parts and nothing else, before they share it.
struct OfParts {
  Stencil stencil;
  std::vector<LayerMatter> blend;  // of layers that regions take a part of
  std::vector<LayerPart> shared;   // one per layer: what the layers that lie on each other are made of
  bool of_regions = false;         // as far as anything there is theirs
  double body_mm3 = 0, spread = 0;
};

// What lies side by side in a layer, as one: it bends as a plate with the layers above and below it.
LayerMatter blend_of(const std::vector<CellPart>& parts, const std::vector<LayerMatter>& matter, int layer) {
  LayerMatter out;
  double volume = 0, most = 0, mu = 0, poisson = 0, along = 0, across = 0;
  for (const CellPart& p : parts) {
    if (p.layer != layer) continue;
    const LayerMatter& m = matter[p.matter];
    const double V = p.moments.volume_mm3();
    if (V > most) out = m, most = V;
    volume += V, mu += V * m.response.matrix_mu_kPa, poisson += V * m.material.poisson;
    along += V * m.material.prestretch_along, across += V * m.material.prestretch_across;
  }
  out.response.matrix_mu_kPa = mu / volume, out.material.poisson = poisson / volume;
  out.material.prestretch_along = along / volume, out.material.prestretch_across = across / volume;
  return out;
}

OfParts of_parts(const Vec3& h, const std::vector<CellPart>& parts, const std::vector<LayerMatter>& matter) {
  OfParts out;
  for (const CellPart& p : parts) out.body_mm3 += p.moments.volume_mm3();
  const double whole = h.prod();
  out.spread = spread_of(out.body_mm3 / whole);
  const CellMoments box = box_cell_moments(h, Vec3::Zero(), Vec3::Ones());
  Stencil& s = out.stencil;
  // The push of the rest pressures is integrated like the pull of K that it balances: no point of the cell has the
  // product of two coordinates of a piece that lies askew.
  Eigen::Matrix<double, 8, 3> push = Eigen::Matrix<double, 8, 3>::Zero();
  bool all_push = true;
  struct OfLayer {
    bool of_regions = false;
    LayerMoments sum;
  };
  std::map<int, OfLayer> of_layer;
  for (const CellPart& p : parts) {
    const double V = p.moments.volume_mm3();
    if (!(V > 1e-9 * out.body_mm3)) continue;
    CellMoments m = box;
    for (double& x : m.of) x *= out.spread * V / whole;
    m.add(p.moments, 1 - out.spread);
    const double before = s.p0_kPa;  // times volume, until the stencil is finished
    add_moments(s, h, m, matter[p.matter], p.frame);
    const LayerMoments shared = layer_moments(h, m);
    push += (s.p0_kPa - before) / m.volume_mm3() * shared.B;
    all_push = all_push && s.p0_kPa > before;
    OfLayer& of = of_layer[p.layer];
    of.of_regions |= p.matter != size_t(p.layer), of.sum.add(shared);
  }
  out.blend.reserve(of_layer.size());
  for (const auto& [layer, of] : of_layer) {
    out.of_regions |= of.of_regions;
    out.shared.push_back(
        {of.of_regions ? &out.blend.emplace_back(blend_of(parts, matter, layer)) : &matter[size_t(layer)], of.sum});
  }
  if (all_push) s.mean_gradients = std::make_shared<const Eigen::Matrix<double, 8, 3>>(push / s.p0_kPa);
  finish_stencil(s);
  return out;
}

}  // namespace

// Of a cell that the surface, a layer's border or a region's crosses.
StencilTable::Made StencilTable::cut_cell(const CellCutter& cutter, const CellSamples& samples, const HeldCorners& held,
                                          const Vec3& centre, const Skin::Place& at_centre) const {
  const Skin::Frame f = skin_->frame(centre);
  return divided_cell(cutter, samples, held, centre, at_centre, {f.along, f.across, f.normal});
}

StencilTable::Made StencilTable::divided_cell(const CellCutter& cutter, const CellSamples& samples,
                                              const HeldCorners& held, const Vec3& centre, const Skin::Place& at_centre,
                                              const StretchFrame& frame) const {
  const Vec3 h = cutter.cell_mm();
  const bool in_region = regions_ && regions_->reach(centre, at_centre, 0.5 * h.norm());
  std::vector<StretchFrame> frames(matter_.size(), frame);
  std::vector<LayerPoint> points;
  std::vector<CellPart> parts;
  std::vector<double> region_mm3;
  if (in_region) {
    frames = regions_->frames(centre, frame);
    points = regions_->points(centre - 0.5 * h, h, samples);
    parts = parts_of(points, frames);
    const size_t layers = skin_->body().layers.size();
    region_mm3.resize(region_mm3_.size(), 0.0);
    for (const CellPart& p : parts)
      if (p.matter >= layers) region_mm3[p.matter - layers] += p.moments.volume_mm3();
  } else {
    const std::vector<CellMoments> moments = cutter.moments(samples);
    for (size_t l = 0; l < moments.size(); ++l) parts.push_back({int(l), l, frame, moments[l]});
  }
  double volume = 0;
  for (const CellPart& p : parts) volume += p.moments.volume_mm3();
  if (volume < kSliver * h.prod()) {
    const int layer = skin_->layer_at(std::max(at_centre.depth_mm, 0.0) - at_centre.thicker_mm);
    const size_t of = in_region ? regions_->matter(centre, at_centre, layer) : size_t(layer);
    Stencil s;
    add_box(s, h, Vec3::Zero(), Vec3::Ones(), matter_[of], frames[of]);
    finish_stencil(s);
    return {std::move(s), h.prod(), nullptr, 0, std::move(region_mm3)};
  }
  OfParts made = of_parts(h, parts, matter_);
  Stencil& s = made.stencil;
  if (held.held &&
      hold_at_surface(s, h, held, in_region ? points : cutter.points(samples), matter_, frames, made.spread))
    return {std::move(s), volume, nullptr, held.held, std::move(region_mm3)};
  share_cell(s, h, made.shared, frame, made.spread > 0, !made.of_regions);
  std::shared_ptr<LayeredCell> layered;
  if (made.shared.size() > 1) {
    layered = std::make_shared<LayeredCell>();
    layered->parts = std::move(parts), layered->frame = frame;
    layered->depth = {at_centre.in_layers_mm(), at_centre.down - slope_of_thicker(samples, h)};
  }
  return {std::move(s), volume, std::move(layered), 0, std::move(region_mm3)};
}

int32_t StencilTable::mixed(int32_t stencil, const std::vector<int32_t>& steps) const {
  LayeredCell& cell = *layered_[size_t(stencil)];
  const auto [it, is_new] = cell.mixed.try_emplace(steps, -1);
  if (!is_new) return it->second;
  double volume = 0, sum = 0;
  for (const CellPart& p : cell.parts) volume += p.moments.volume_mm3();
  for (const int32_t n : steps) sum += n;
  std::vector<CellPart> parts;
  for (const CellPart& p : cell.parts) {
    const int32_t n = steps[size_t(p.layer)];
    if (n <= 0) continue;
    CellPart& part = parts.emplace_back(p);
    part.moments = {};
    part.moments.add(p.moments, volume * n / sum / cell.volume_mm3(size_t(p.layer)));
  }
  const uint8_t level = std::as_const(stencils_)[size_t(stencil)].level;
  const Vec3 h = cell_size_mm(grid_.cell_mm(), level);
  OfParts made = of_parts(h, parts, matter_);
  share_cell(made.stencil, h, made.shared, cell.frame, made.spread > 0, !made.of_regions);
  made.stencil.level = level;
  return it->second = intern({std::move(made.stencil), body_mm3(stencil), nullptr});
}

int32_t StencilTable::add(Made made) const {
  for (size_t r = 0; r < made.region_mm3.size(); ++r) region_mm3_[r] += made.region_mm3[r];
  alike_[some_of(made.stencil, made.body_mm3)].push_back(int32_t(stencils_.size()));
  stencils_.push_back(std::move(made.stencil));
  body_mm3_.push_back(made.body_mm3);
  held_of_.push_back(made.held);
  layered_.push_back(std::move(made.layered));
  return int32_t(stencils_.size()) - 1;
}

void StencilTable::fill_general(const Skin& skin, const LatticeGrid& grid) {
  const Vec3 h = grid.cell_mm();
  const double reach = 0.5 * h.norm(), whole_mm3 = h.prod();
  const std::vector<uint8_t> used = cells_of_body(skin.surface(), grid);
  find_held(skin, grid);
  const CellCutter cutter(h, layer_ends_);
  Sampler sampler(skin, grid);
  std::vector<int32_t> whole(skin.body().layers.size(), -1);  // stencil of a full cell of a layer without prestretch
  Skin::Near near;
  for (size_t c = 0; c < of_cell_.size(); ++c) {
    of_cell_[c] = -1;
    if (!used[c]) continue;
    const Int3 at = grid.cell_at(int32_t(c));
    const Vec3 centre = grid.node_mm(at) + 0.5 * h;
    const Skin::Place place = skin.place(centre, near);
    // Both are 1-Lipschitz in the body.
    const auto [upper, lower] = skin.layers_within(place.depth_mm, reach);
    bool stretched = false;
    for (int l = upper; l <= lower; ++l) stretched = stretched || matter_[size_t(l)].directed();
    const HeldCorners held = held_corners(at);
    const bool cut = place.inside_mm < reach, in_region = regions_ && regions_->reach(centre, place, reach);
    if (in_region) {
      of_cell_[c] = add(cut_cell(cutter, sampler.of(at), held, centre, place));
    } else if (upper == lower && !stretched && !held.held) {
      int32_t& one = whole[size_t(upper)];
      if (one < 0) {
        Stencil s;
        add_box(s, h, Vec3::Zero(), Vec3::Ones(), matter_[size_t(upper)], {});
        finish_stencil(s);
        one = add({std::move(s), whole_mm3, nullptr});
      }
      of_cell_[c] = one;
    } else if (upper == lower && !cut) {
      Stencil s;
      const Skin::Frame f = skin.frame(centre);
      add_box(s, h, Vec3::Zero(), Vec3::Ones(), matter_[size_t(upper)], {f.along, f.across, f.normal});
      finish_stencil(s);
      of_cell_[c] = add({std::move(s), whole_mm3, nullptr});
    } else {
      const bool skin_is_near = upper != lower || std::abs(place.depth_mm) < reach;
      of_cell_[c] = add(cut_cell(cutter, skin_is_near ? sampler.of(at) : above_held(held, place), held, centre, place));
    }
  }
}

// Which nodes are held, and how far those around them are from the surface that holds.
void StencilTable::find_held(const Skin& skin, const LatticeGrid& grid) {
  const TriMesh& surface = skin.body().surface;
  std::vector<int32_t> fixed;
  for (size_t t = 0; t < surface.tri.size(); ++t)
    if (!surface.tag.empty() && surface.tag[t] == SurfaceTag::fixed) fixed.push_back(int32_t(t));
  if (fixed.empty()) return;
  held_surface_ = SidedPatch(surface, fixed);
  const Vec3 h = grid.cell_mm();
  const double near = 0.1 * h.minCoeff(), far = 2 * h.norm();
  for (size_t n = 0; n < fixed_.size(); ++n) {
    const Bvh::Closest hit = skin.surface().closest(grid.node_mm(grid.node_at(int32_t(n))), far);
    if (hit.triangle < 0 || surface.tag[size_t(hit.triangle)] != SurfaceTag::fixed) continue;
    fixed_[n] = hit.distance_mm <= near ? kNearFixed : kFarFixed;
  }
  held_depth_.assign(fixed_.size(), NAN);
}

HeldCorners StencilTable::held_corners(Int3 cell) {
  HeldCorners c;
  if (held_surface_.empty()) return c;
  std::array<size_t, 8> node{};
  uint8_t may = 0;
  for (size_t k = 0; k < 8; ++k) {
    node[k] = size_t(grid_.node_index({cell.x + int(k & 1), cell.y + int(k >> 1 & 1), cell.z + int(k >> 2 & 1)}));
    may |= fixed_[node[k]];
  }
  if (!may) return c;
  for (size_t k = 0; k < 8; ++k) {
    double& d = held_depth_[node[k]];
    Bvh::Closest near;
    if (std::isnan(d)) d = held_surface_.depth_mm(grid_.node_mm(grid_.node_at(int32_t(node[k]))), near);
    c.depth_mm[k] = d;
    if (fixed_[node[k]] == kNearFixed || (fixed_[node[k]] == kFarFixed && d <= 0)) c.held |= uint8_t(1u << k);
  }
  return c;
}

// The same of a part of a cell.
HeldCorners StencilTable::held_part(const LatticeGrid& grid, Int3 at, int level, uint8_t of) const {
  HeldCorners c;
  if (held_surface_.empty()) return c;
  std::array<Int3, 8> corner;
  std::array<uint8_t, 8> may{};
  bool any = false;
  for (int k = 0; k < 8; ++k) {
    corner[size_t(k)] = corner_of(at, k);
    may[size_t(k)] = fixed_candidate(in_eighths(corner[size_t(k)], level));
    any = any || may[size_t(k)];
  }
  if (!any) return c;
  Bvh::Closest near;
  for (size_t k = 0; k < 8; ++k) {
    const double d = c.depth_mm[k] = held_surface_.depth_mm(grid.node_mm(corner[k]), near);
    if (may[k] == kNearFixed || (may[k] == kFarFixed && d <= 0)) c.held |= uint8_t(1u << k);
  }
  c.held &= of;
  return c;
}

// As the loop of fill_general, for one part of a cell.
StencilTable::Made StencilTable::general_part(const LatticeGrid& grid, Int3 at, int level, uint8_t corners) const {
  const Vec3 h = grid.cell_mm(), low = grid.node_mm(at), centre = low + 0.5 * h;
  const double reach = 0.5 * h.norm();
  Skin::Near near;
  const Skin::Place place = skin_->place(centre, near);
  const auto [upper, lower] = skin_->layers_within(place.depth_mm, reach);
  const bool stretched = upper != lower || matter_[size_t(upper)].directed();
  const HeldCorners held = held_part(grid, at, level, corners);
  const bool in_region = regions_ && regions_->reach(centre, place, reach);
  Made made{{}, h.prod(), nullptr};
  if (!in_region && upper == lower && !held.held && (!stretched || !(place.inside_mm < reach))) {
    StretchFrame frame;
    if (stretched) {
      const Skin::Frame f = skin_->frame(centre);
      frame = {f.along, f.across, f.normal};
    }
    add_box(made.stencil, h, Vec3::Zero(), Vec3::Ones(), matter_[size_t(upper)], frame);
    finish_stencil(made.stencil);
  } else {
    CellSamples samples;
    if (held.held && !in_region && upper == lower && !(std::abs(place.depth_mm) < reach))
      samples = above_held(held, place);
    else
      for (int n = 0; n < kSamples; ++n) samples[size_t(n)] = skin_->place(low + h.cwiseProduct(sample_place(n)), near);
    made = cut_cell(CellCutter(h, layer_ends_), samples, held, centre, place);
  }
  return made;
}

StencilTable::Part StencilTable::part_at(const CellPlace& place) const {
  const bool of_row = is_block_ && !unlike_its_row(place);
  return {{place.level, of_row ? -1 : place.at.x, of_row ? -1 : place.at.y, place.at.z}, of_row};
}

StencilTable::Made StencilTable::make_part(const CellPlace& place, bool of_row) const {
  const LatticeGrid grid = grid_.at_level(place.level);
  Made made = of_row      ? block_row(grid, place.at.z)
              : is_block_ ? block_cell(grid, place.at)
                          : general_part(grid, place.at, place.level);
  made.stencil.level = uint8_t(place.level);
  return made;
}

int32_t StencilTable::of_place(const CellPlace& place) const {
  if (place.level == 0) return of_cell(grid_.cell_index(place.at));
  const Part part = part_at(place);
  const auto [it, is_new] = of_part_.try_emplace(part.key, -1);
  if (is_new) {
    const auto ready = ready_.find(part.key);
    const bool made = ready != ready_.end() && ready->second;
    it->second = intern(made ? std::move(*ready->second) : make_part(place, part.of_row));
    if (ready != ready_.end()) ready_.erase(ready);
  }
  return it->second;
}

void StencilTable::make_ready(std::span<const CellPlace> places, Workers& workers) const {
  struct Wanted {
    CellPlace place;
    bool of_row;
    std::unique_ptr<Made>* made;
  };
  std::vector<Wanted> wanted;
  for (const CellPlace& place : places) {
    if (place.level == 0) continue;
    const Part part = part_at(place);
    if (of_part_.contains(part.key)) continue;
    const auto [it, is_new] = ready_.try_emplace(part.key);
    if (!is_new) continue;
    wanted.push_back({place, part.of_row, &it->second});
    if (is_block_ || held_surface_.empty()) continue;
    for (int k = 0; k < 8; ++k)  // noted by one thread, for those that follow
      fixed_candidate(in_eighths(corner_of(place.at, k), place.level));
  }
  workers.parallel_for(wanted.size(), kPartsAtOnce, [&](size_t from, size_t to) {
    for (size_t i = from; i < to; ++i)
      *wanted[i].made = std::make_unique<Made>(make_part(wanted[i].place, wanted[i].of_row));
  });
}

int32_t StencilTable::of_place(const CellPlace& place, uint8_t held) const {
  const auto [it, is_new] = of_held_.try_emplace({place.level, place.at.x, place.at.y, place.at.z, held}, -1);
  if (is_new) {
    Made made = general_part(grid_.at_level(place.level), place.at, place.level, held);
    made.stencil.level = uint8_t(place.level);
    it->second = intern(std::move(made));
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
