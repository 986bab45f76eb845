#include "sim/body/obj.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <numeric>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/base/quoted.h"
#include "sim/base/whole_file.h"
#include "sim/body/block.h"
#include "sim/geometry/enclosed_volume.h"
#include "sim/geometry/io/mesh_file.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

using Corner = ObjText::Corner;
struct RawMesh {
  std::vector<Vec3> v;
  std::vector<Eigen::Vector2f> vt;
  std::vector<std::array<Corner, 3>> tri;
  std::vector<int32_t> line, material;  // per triangle
  std::vector<Vec3f> rgb;               // per vertex, or none
};

// Cuts a polygon into triangles by clipping ears in the plane of its mean (Newell) normal.
class Clipper {
 public:
  // Appends triples of positions in `p`; false when no ear is left (crossing itself, or without area).
  bool operator()(const std::vector<Vec3>& p, std::vector<std::array<int, 3>>& out) {
    Vec3 n = Vec3::Zero();
    for (size_t i = 0; i < p.size(); ++i) n += (p[i] - p[0]).cross(p[(i + 1) % p.size()] - p[0]);
    int axis = 0;
    if (!(n.cwiseAbs().maxCoeff(&axis) > 0)) return false;
    const double flip = n[axis] > 0 ? 1 : -1;
    q_.clear();
    for (const Vec3& x : p) q_.push_back({flip * x[(axis + 1) % 3], x[(axis + 2) % 3]});
    ring_.resize(p.size());
    std::iota(ring_.begin(), ring_.end(), 0);
    while (ring_.size() > 3) {
      const size_t m = ring_.size();
      size_t best = m;
      for (size_t i = 0; i < m && best == m; ++i)
        if (is_ear(i)) best = i;
      if (best == m) return false;
      out.push_back({ring_[(best + m - 1) % m], ring_[best], ring_[(best + 1) % m]});
      ring_.erase(ring_.begin() + std::ptrdiff_t(best));
    }
    out.push_back({ring_[0], ring_[1], ring_[2]});
    return turn(ring_[0], ring_[1], ring_[2]) > 0;
  }

 private:
  double turn(int a, int b, int c) const {
    const Vec2 u = q_[size_t(b)] - q_[size_t(a)], v = q_[size_t(c)] - q_[size_t(a)];
    return u.x() * v.y() - u.y() * v.x();
  }
  bool is_ear(size_t i) const {
    const size_t m = ring_.size();
    const int a = ring_[(i + m - 1) % m], b = ring_[i], c = ring_[(i + 1) % m];
    if (!(turn(a, b, c) > 0)) return false;
    for (int k : ring_)
      if (k != a && k != b && k != c && turn(a, b, k) >= 0 && turn(b, c, k) >= 0 && turn(c, a, k) >= 0) return false;
    return true;
  }
  std::vector<Vec2> q_;
  std::vector<int> ring_;
};

RawMesh cut_into_triangles(ObjText& text, const std::string& file) {
  if (text.v.empty()) throw InputError(file, 0, "no vertices; expected a surface in an OBJ, PLY or STL file");
  if (text.face.empty()) throw InputError(file, 0, "no faces; expected a surface in an OBJ, PLY or STL file");
  RawMesh mesh{std::move(text.v), std::move(text.vt), {}, {}, {}, std::move(text.rgb)};
  Clipper clip;
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> ears;
  for (const ObjText::Face& f : text.face) {
    const Corner* corner = text.corner.data() + f.first;
    ears.clear();
    if (f.corners == 3) {
      ears.push_back({0, 1, 2});
    } else {
      points.clear();
      for (size_t k = 0; k < f.corners; ++k) points.push_back(mesh.v[size_t(corner[k].v)]);
      if (!clip(points, ears))
        throw InputError(file, f.line,
                         fmt::format("a face with {} corners cannot be cut into triangles; expected a simple polygon "
                                     "with an area",
                                     f.corners));
    }
    for (const auto& e : ears) {
      mesh.tri.push_back({corner[e[0]], corner[e[1]], corner[e[2]]});
      mesh.line.push_back(f.line);
      mesh.material.push_back(f.material);
    }
  }
  return mesh;
}

void check(const ObjSpec& s) {
  const auto fail = [&](const std::string& what) { throw InputError(s.path, 0, what); };
  if (!std::isfinite(s.scale_to_mm) || s.scale_to_mm <= 0) fail("scale to mm must be a finite number above 0");
  if (!s.deep_direction.allFinite() || s.deep_direction.norm() < 1e-9) fail("deep direction must not be zero");
  if (!(s.deep_angle_deg >= 0 && s.deep_angle_deg <= 180)) fail("deep angle must lie between 0 and 180 degrees");
  if (s.deep_center_mm && !s.deep_center_mm->allFinite()) fail("deep center is not finite");
  if (std::isnan(s.deep_plane_mm)) fail("deep plane is not a number");
  if (!s.chart_origin_mm.allFinite() || !s.chart_e1.allFinite() || !s.chart_e2.allFinite() ||
      s.chart_e1.cross(s.chart_e2).norm() < 1e-6 * s.chart_e1.norm() * s.chart_e2.norm() || s.chart_e1.norm() < 1e-9)
    fail("chart axes must be two finite directions that are not parallel");
  if (!s.tension_direction.allFinite() || s.tension_direction.norm() < 1e-9) fail("tension direction must not be zero");
}

// Snaps, welds and drops what collapses. Fills body.grid, body.surface, and of its triangles lines and materials.
void to_grid(RawMesh& raw, const ObjSpec& spec, Body& body, std::vector<int32_t>& lines,
             std::vector<int32_t>& materials) {
  std::vector<uint8_t> used(raw.v.size(), 0);
  for (const auto& t : raw.tri)
    for (const Corner& c : t) used[size_t(c.v)] = 1;
  Vec3 lo = Vec3::Constant(std::numeric_limits<double>::infinity()), hi = -lo;
  for (size_t i = 0; i < raw.v.size(); ++i) {
    if (!used[i]) continue;
    raw.v[i] *= spec.scale_to_mm;
    lo = lo.cwiseMin(raw.v[i]);
    hi = hi.cwiseMax(raw.v[i]);
  }
  const double extent = (hi - lo).maxCoeff();
  if (!(extent <= ObjLimits::extent_mm && extent >= ObjLimits::min_extent_mm))
    throw InputError(
        spec.path, 0,
        fmt::format("the surface is {:.3g} mm long; expected {:g} to {:g} (are its numbers mm? scale_to_mm "
                    "in a scene and limberg check --unit say what they are)",
                    extent, ObjLimits::min_extent_mm, ObjLimits::extent_mm));
  body.grid.unit_mm = rest_unit_mm(0.5 * extent);
  // A whole number of mm as origin keeps coordinates readable and every snapped vertex exact in double.
  for (int k = 0; k < 3; ++k) body.grid.origin_mm[k] = std::round(0.5 * (lo[k] + hi[k]));
  if (!body.grid.fits(lo) || !body.grid.fits(hi)) body.grid.unit_mm *= 2;

  struct Snapped {
    Int3 p;
    int32_t v;
  };
  std::vector<Snapped> snapped;
  for (size_t i = 0; i < raw.v.size(); ++i)
    if (used[i]) snapped.push_back({body.grid.to_grid(raw.v[i]), int32_t(i)});
  std::sort(snapped.begin(), snapped.end(),
            [](const Snapped& a, const Snapped& b) { return a.p != b.p ? a.p < b.p : a.v < b.v; });
  std::vector<int32_t> twin(raw.v.size(), -1), first(raw.v.size(), -1);
  for (size_t i = 0; i < snapped.size(); ++i)
    twin[size_t(snapped[i].v)] =
        i > 0 && snapped[i].p == snapped[i - 1].p ? twin[size_t(snapped[i - 1].v)] : snapped[i].v;
  TriMesh& m = body.surface;
  for (size_t i = 0; i < raw.v.size(); ++i)
    if (used[i] && twin[i] == int32_t(i)) {  // in the order of the file
      first[i] = int32_t(m.X_mm.size());
      m.X_mm.push_back(body.grid.to_mm(body.grid.to_grid(raw.v[i])));
      if (!raw.rgb.empty()) body.rgb.push_back(raw.rgb[i]);
    }
  for (size_t t = 0; t < raw.tri.size(); ++t) {
    Tri tri;
    std::array<Eigen::Vector2f, 3> uv;
    for (size_t k = 0; k < 3; ++k) {
      const Corner& c = raw.tri[t][k];
      tri[k] = first[size_t(twin[size_t(c.v)])];
      uv[k] = c.vt >= 0 ? raw.vt[size_t(c.vt)] : Eigen::Vector2f(0, 0);
    }
    if (tri[0] == tri[1] || tri[1] == tri[2] || tri[2] == tri[0]) continue;
    m.tri.push_back(tri);
    m.uv.push_back(uv);
    lines.push_back(raw.line[t]);
    materials.push_back(raw.material[t]);
  }
  if (m.tri.empty())
    throw InputError(spec.path, 0, "every face collapses on the rest grid; expected a surface (is the scale right?)");
}

void tag_by_direction(TriMesh& m, const ObjSpec& spec) {
  const Vec3 deep = spec.deep_direction.normalized();
  const double c = elementary::cos(spec.deep_angle_deg * std::numbers::pi / 180);
  for (const Tri& t : m.tri) {
    const Vec3 &p = m.X_mm[size_t(t[0])], &q = m.X_mm[size_t(t[1])], &r = m.X_mm[size_t(t[2])];
    const bool beyond = std::min({p.dot(deep), q.dot(deep), r.dot(deep)}) > spec.deep_plane_mm;
    const Vec3 inwards = spec.deep_center_mm ? (*spec.deep_center_mm - (p + q + r) / 3).normalized() : deep;
    const bool held = beyond || area_vector2(p, q, r).normalized().dot(inwards) > c;
    m.tag.push_back(held ? SurfaceTag::fixed : SurfaceTag::skin);
  }
}

SurfaceTag tag_of(ObjTag::What what) {
  switch (what) {
    case ObjTag::What::skin:
    case ObjTag::What::mucosa:
      return SurfaceTag::skin;
    case ObjTag::What::held:
      return SurfaceTag::fixed;
    case ObjTag::What::held_softly:
    case ObjTag::What::cut:
      break;
  }
  return SurfaceTag::free;
}

void tag_by_material(TriMesh& m, std::vector<float>& soft_kPa_mm, const ObjSpec& spec,
                     const std::vector<std::string>& names, const std::vector<int32_t>& material,
                     const std::vector<int32_t>& lines) {
  std::vector<const ObjTag*> of(names.size(), nullptr);
  for (const ObjTag& tag : spec.tags) {
    const auto at = std::find(names.begin(), names.end(), tag.material);
    if (at == names.end())
      throw InputError(spec.path, 0,
                       "has no faces of material " + limberg::quoted(tag.material) +
                           ", which is tagged; expected usemtl " + limberg::quoted(tag.material));
    of[size_t(at - names.begin())] = &tag;
  }
  for (size_t t = 0; t < m.tri.size(); ++t) {
    const ObjTag* tag = material[t] >= 0 ? of[size_t(material[t])] : nullptr;
    if (!tag)
      throw InputError(spec.path, lines[t],
                       material[t] < 0 ? "a face before the first usemtl, in a surface whose materials are tagged; "
                                         "expected a material"
                                       : "a face of material " + limberg::quoted(names[size_t(material[t])]) +
                                             ", which is not tagged; expected a [[body.tag]] for it");
    m.tag.push_back(tag_of(tag->what));
    if (tag->what != ObjTag::What::held_softly) continue;
    soft_kPa_mm.resize(m.tri.size(), 0);
    soft_kPa_mm[t] = float(tag->stiffness_kPa_mm);
  }
}

}  // namespace

Body parse_obj(std::string_view text, const ObjSpec& spec, SurfaceReport* report) {
  check(spec);
  if (text.size() > ObjLimits::file_bytes) throw InputError(spec.path, 0, "the file is larger than 512 MB");
  constexpr ObjTextLimits kLimits{ObjLimits::vertices, ObjLimits::triangles, ObjLimits::polygon_corners};
  ObjText read = parse_mesh_file(text, spec.path, kLimits);
  RawMesh raw = cut_into_triangles(read, spec.path);
  Body body;
  std::vector<int32_t> lines, materials;
  to_grid(raw, spec, body, lines, materials);
  const bool turned = turn_outwards(body.surface);
  SurfaceReport found = validate_surface(body.surface, body.grid, spec.path, lines);
  found.turned = turned;
  if (report) *report = found;

  TriMesh& m = body.surface;
  if (spec.tags.empty())
    tag_by_direction(m, spec);
  else
    tag_by_material(m, body.soft_kPa_mm, spec, read.material, materials, lines);
  if (std::find(m.tag.begin(), m.tag.end(), SurfaceTag::skin) == m.tag.end())
    throw InputError(
        spec.path, 0,
        spec.tags.empty()
            ? "the deep side covers the whole surface; expected some skin (see deep_direction, deep_angle_deg)"
            : "no face is tagged as skin or mucosa; expected some skin");

  body.name = std::filesystem::path(spec.path).stem().string();
  body.paints = read.material, body.paint_of = std::move(materials);
  body.layers = spec.layers;
  if (body.layers.empty()) body.layers.push_back({"tissue", 1000, Material{}});
  body.tension_direction = spec.tension_direction.normalized();
  body.chart_origin_mm = spec.chart_origin_mm;
  body.chart_e1 = spec.chart_e1.normalized();
  body.chart_e2 = (spec.chart_e2 - spec.chart_e2.dot(body.chart_e1) * body.chart_e1).normalized();
  body.box_min_mm = body.box_max_mm = m.X_mm[0];
  for (const Vec3& X : m.X_mm) {
    body.box_min_mm = body.box_min_mm.cwiseMin(X);
    body.box_max_mm = body.box_max_mm.cwiseMax(X);
  }
  return body;
}

Body load_obj(const ObjSpec& spec, SurfaceReport* report) {
  return parse_obj(read_whole_file(spec.path, ObjLimits::file_bytes, "an OBJ surface"), spec, report);
}

}  // namespace limberg
