#include "app/import/peer_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>

#include "sim/base/error.h"
#include "sim/base/quoted.h"
#include "sim/geometry/io/obj_text.h"
#include "sim/geometry/triangle.h"

namespace limberg {
namespace {

constexpr ObjTextLimits kPeerObjLimits{500'000, 1'000'000, 3};
constexpr double kLongest_mm = 1000;

int material_number(const std::string& name, const std::string& file, int line) {
  int number = 0;
  const auto [end, ec] = std::from_chars(name.data(), name.data() + name.size(), number);
  // "1.004": a material that its editor has doubled
  if (ec != std::errc() || (end != name.data() + name.size() && *end != '.') || number < 0 || number > 99)
    throw InputError(file, line,
                     "material " + limberg::quoted(name) + " is no number; expected those of the peer, 1 to 8");
  return number;
}

void join(PeerModel& m) {
  std::map<std::pair<int32_t, int32_t>, std::pair<int32_t, int>> edge;
  m.across.assign(m.mesh.tri.size(), {-1, -1, -1});
  for (size_t t = 0; t < m.mesh.tri.size(); ++t)
    for (size_t k = 0; k < 3; ++k) edge.insert({{m.mesh.tri[t][k], m.mesh.tri[t][(k + 1) % 3]}, {int32_t(t), int(k)}});
  for (const auto& [ends, here] : edge)
    if (const auto mate = edge.find({ends.second, ends.first}); mate != edge.end())
      m.across[size_t(here.first)][size_t(here.second)] = mate->second.first;
}

void find_normals(PeerModel& m) {
  m.normal.assign(m.mesh.X_mm.size(), Vec3::Zero());
  for (const Tri& t : m.mesh.tri) {
    const Vec3 n = area_vector2(m.mesh.X_mm[size_t(t[0])], m.mesh.X_mm[size_t(t[1])], m.mesh.X_mm[size_t(t[2])]);
    for (int32_t v : t) m.normal[size_t(v)] += n;
  }
  for (Vec3& n : m.normal) n = n.norm() > 0 ? Vec3(n.normalized()) : Vec3::UnitZ();
}

}  // namespace

Vec3 PeerModel::at(int32_t t, const std::array<double, 3>& bary) const {
  Vec3 X = Vec3::Zero();
  for (size_t k = 0; k < 3; ++k) X += bary[k] * mesh.X_mm[size_t(mesh.tri[size_t(t)][k])];
  return X;
}

Vec3 PeerModel::normal_at(int32_t t, const std::array<double, 3>& bary) const {
  Vec3 n = Vec3::Zero();
  for (size_t k = 0; k < 3; ++k) n += bary[k] * normal[size_t(mesh.tri[size_t(t)][k])];
  return n.norm() > 1e-9 ? Vec3(n.normalized()) : normal[size_t(mesh.tri[size_t(t)][0])];
}

std::optional<double> PeerModel::depth_mm(int32_t t, const std::array<double, 3>& bary) const {
  double depth = 0;
  for (size_t k = 0; k < 3; ++k) {
    const size_t v = size_t(mesh.tri[size_t(t)][k]);
    if (bary[k] == 0) continue;
    if (!deep_mm[v].allFinite()) return std::nullopt;
    depth += bary[k] * (deep_mm[v] - mesh.X_mm[v]).norm();
  }
  return depth;
}

double PeerModel::median_depth_mm() const {
  std::vector<double> depths;
  for (size_t v = 0; v < deep_mm.size(); ++v)
    if (deep_mm[v].allFinite()) depths.push_back((deep_mm[v] - mesh.X_mm[v]).norm());
  if (depths.empty()) return 0;
  std::nth_element(depths.begin(), depths.begin() + std::ptrdiff_t(depths.size() / 2), depths.end());
  return depths[depths.size() / 2];
}

PeerModel parse_peer_model(std::string_view obj, const std::string& file, const PeerScene& scene, const PeerBed* bed,
                           const std::string& bed_file, double unit_mm) {
  const ObjText text = parse_obj_text(obj, file, kPeerObjLimits);
  if (text.v.empty() || text.face.empty())
    throw InputError(file, 0, "no surface; expected an OBJ file with v, vt, usemtl and f statements");
  PeerModel m;
  m.file = file, m.unit_mm = unit_mm;
  std::vector<int> number(text.material.size(), -1);
  bool skin = false;
  for (const ObjText::Face& f : text.face) {
    if (f.material < 0) throw InputError(file, f.line, "a face without a material; expected usemtl before it");
    int& material = number[size_t(f.material)];
    if (material < 0) material = material_number(text.material[size_t(f.material)], file, f.line);
    Tri tri;
    std::array<Eigen::Vector2f, 3> uv;
    for (size_t k = 0; k < 3; ++k) {
      const ObjText::Corner& c = text.corner[f.first + k];
      if (c.vt < 0) throw InputError(file, f.line, "a face without texture; expected v/vt for every corner");
      tri[k] = c.v, uv[k] = text.vt[size_t(c.vt)];
    }
    m.mesh.tri.push_back(tri), m.mesh.uv.push_back(uv), m.material.push_back(material);
    skin = skin || material == peer_material::skin;
  }
  if (!skin) throw InputError(file, 0, "no face is of material 2; expected skin");
  m.low_mm = Vec3::Constant(std::numeric_limits<double>::infinity()), m.high_mm = -m.low_mm;
  for (const Vec3& v : text.v) m.mesh.X_mm.push_back(unit_mm * v);
  for (const Tri& t : m.mesh.tri)
    for (int32_t v : t)
      m.low_mm = m.low_mm.cwiseMin(m.mesh.X_mm[size_t(v)]), m.high_mm = m.high_mm.cwiseMax(m.mesh.X_mm[size_t(v)]);
  const Vec3 size = m.high_mm - m.low_mm;
  if (!(size.maxCoeff() <= kLongest_mm) || !(size.maxCoeff() >= 1))
    throw InputError(file, 0,
                     fmt::format("the model is {:g} mm long; expected 1 to 1000 (see --unit-mm)", size.maxCoeff()));
  join(m), find_normals(m);
  m.all = Bvh(m.mesh.X_mm, m.mesh.tri);
  m.deep_mm.assign(m.mesh.X_mm.size(), Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
  if (bed)
    for (size_t i = 0; i < bed->vertex.size(); ++i) {
      if (size_t(bed->vertex[i]) >= m.deep_mm.size())
        throw InputError(bed_file, int(i) + 1,
                         fmt::format("names vertex {}; the model has {}", bed->vertex[i], m.deep_mm.size()));
      m.deep_mm[size_t(bed->vertex[i])] = unit_mm * bed->deep[i];
    }
  // The edge of the finest cell of the peer's lattice, as its program takes it.
  const double longest = size.maxCoeff() + 2e-4 * size.norm();
  m.history_mm =
      scene.subdivisions > 0 && scene.levels > 0 ? longest / scene.subdivisions / std::exp2(scene.levels - 1) : 0;
  return m;
}

namespace {

struct TextureSpot {
  int32_t triangle = -1;
  std::array<double, 3> bary{};
  double off = std::numeric_limits<double>::infinity();  // in the texture's units
};

/// The place of a texture that is nearest to (u, v) among the triangles of a material.
TextureSpot on_texture(const PeerModel& m, int material, const Vec2& p) {
  TextureSpot best;
  for (size_t t = 0; t < m.mesh.tri.size() && best.off > 0; ++t) {
    if (m.material[t] != material) continue;
    const Vec2 a = m.mesh.uv[t][0].cast<double>(), b = m.mesh.uv[t][1].cast<double>(),
               c = m.mesh.uv[t][2].cast<double>();
    const Vec2 ab = b - a, ac = c - a, ap = p - a;
    const double area = ab.x() * ac.y() - ab.y() * ac.x();
    if (!(std::abs(area) > 1e-12)) continue;  // some triangles have no area on the texture
    const double w1 = (ap.x() * ac.y() - ap.y() * ac.x()) / area, w2 = (ab.x() * ap.y() - ab.y() * ap.x()) / area;
    std::array<double, 3> w{1 - w1 - w2, w1, w2};
    double off = 0;
    if (*std::min_element(w.begin(), w.end()) < -1e-9) {  // outside: its nearest point, edge by edge
      const Vec2 corner[3] = {a, b, c};
      off = std::numeric_limits<double>::infinity();
      for (size_t k = 0; k < 3; ++k) {
        const Vec2 e = corner[(k + 1) % 3] - corner[k];
        const double s = std::clamp((p - corner[k]).dot(e) / std::max(e.squaredNorm(), 1e-30), 0.0, 1.0);
        const double d = (corner[k] + s * e - p).norm();
        if (d >= off) continue;
        off = d, w = {0, 0, 0}, w[k] = 1 - s, w[(k + 1) % 3] = s;
      }
    }
    if (off < best.off) best = {int32_t(t), w, off};
  }
  return best;
}

constexpr double kOnTexture = 0.003;  // a place may lie so far beside the texture: half a pixel of the usual picture

}  // namespace

SurfaceSpot walk_to(const PeerModel& m, const SurfaceSpot& start, const Vec3& to, double reach_mm) {
  SurfaceSpot best = start;
  double least = (start.at_mm - to).squaredNorm();
  const int material = m.material[size_t(start.triangle)];
  std::vector<int32_t> open{start.triangle};
  std::vector<int32_t> seen{start.triangle};  // sorted: patches are small
  while (!open.empty()) {
    const int32_t t = open.back();
    open.pop_back();
    const Tri& c = m.mesh.tri[size_t(t)];
    const Vec3 &p = m.mesh.X_mm[size_t(c[0])], &q = m.mesh.X_mm[size_t(c[1])], &r = m.mesh.X_mm[size_t(c[2])];
    const auto near = closest_on_triangle(to, p, q, r);
    if (const double d = (near.point - to).squaredNorm(); d < least) least = d, best = {t, near.bary, near.point};
    for (int32_t n : m.across[size_t(t)]) {
      if (n < 0 || m.material[size_t(n)] != material) continue;
      const auto at = std::lower_bound(seen.begin(), seen.end(), n);
      if (at != seen.end() && *at == n) continue;
      seen.insert(at, n);
      const Tri& d = m.mesh.tri[size_t(n)];
      const auto from = closest_on_triangle(start.at_mm, m.mesh.X_mm[size_t(d[0])], m.mesh.X_mm[size_t(d[1])],
                                            m.mesh.X_mm[size_t(d[2])]);
      if ((from.point - start.at_mm).norm() <= reach_mm) open.push_back(n);
    }
  }
  return best;
}

std::optional<FoundPlace> find_place(const PeerModel& m, const PeerPlace& place, std::string& reason) {
  namespace pm = peer_material;
  const bool of_skin = place.material >= pm::cut_side && place.material <= pm::muscle;
  int texture = place.material == pm::undermined_periosteum ? pm::periosteum : of_skin ? pm::skin : place.material;
  TextureSpot t = on_texture(m, place.material, place.uv);
  if (t.off > kOnTexture && texture != place.material) t = on_texture(m, texture, place.uv);
  if (!(t.off <= kOnTexture)) {
    reason = fmt::format("no triangle of material {} lies at ({:.4f}, {:.4f}) of the texture", texture, place.uv.x(),
                         place.uv.y());
    return std::nullopt;
  }
  if (m.history_mm == 0 && place.displacement != Vec3::Zero()) {
    reason = "the scene does not say how long a displacement is (maxDimMegatetSubdivs, nTetSizeLevels)";
    return std::nullopt;
  }
  FoundPlace f;
  f.start = {t.triangle, t.bary, m.at(t.triangle, t.bary)};
  const Vec3 way = m.history_mm * place.displacement;
  const double reach = 1.3 * way.norm() + 1;
  f.spot = walk_to(m, f.start, f.start.at_mm + way, reach);
  f.moved_mm = (f.spot.at_mm - f.start.at_mm - way).norm();
  if (of_skin && m.material[size_t(t.triangle)] == pm::skin) {
    // A cut face lies where the skin ends. What is displaced is the point below the skin.
    f.inner = true;
    Vec3 deep = Vec3::Zero();
    for (size_t k = 0; k < 3; ++k) {
      const size_t v = size_t(m.mesh.tri[size_t(t.triangle)][k]);
      deep += t.bary[k] * (m.deep_mm[v].allFinite() ? m.deep_mm[v] : m.mesh.X_mm[v]);
    }
    f.inner_mm = deep + way;
    f.spot = walk_to(m, f.start, f.inner_mm, reach + (deep - f.start.at_mm).norm());
    f.moved_mm = 0;
  }
  return f;
}

}  // namespace limberg
