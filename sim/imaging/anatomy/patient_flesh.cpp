#include "sim/imaging/anatomy/patient_flesh.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "sim/base/error.h"
#include "sim/geometry/point_tree.h"
#include "sim/geometry/sided_patch.h"
#include "sim/geometry/triangle.h"
#include "sim/geometry/validate.h"
#include "sim/imaging/fit/graded_grid.h"
#include "sim/imaging/fit/thinning.h"
#include "sim/imaging/io/surface_file.h"
#include "sim/imaging/synthetic/head_shape.h"

namespace limberg {
namespace {

constexpr double kSkinCell_mm = 4, kLeastCell_mm = 1.6, kCellOfDepth = 0.42;  // a shell has holes below two cells
constexpr double kEdgeOfCell = 0.9;
constexpr double kRoundSides_mm = 1.5;
constexpr double kAlongNormal_mm = 1e-3;  // a ray begins so far below the skin
constexpr double kNear_mm = 24;           // farther from the skin than this its distance matters no more
// A mesh that touches itself where shapes are sharp is made again in other cells.
constexpr double kTries[] = {1, 0.9, 1.1, 0.8, 0.7};
constexpr double kRounded_mm = 1e-3;  // as files have them
// The depth changes by kFleshSlope a mm along the skin; where the nearest place leaps, in folds, it may leap with it.
constexpr double kFleshLipschitz = 2;

/// Depth of each vertex of the skin: to bone along its normal, and no steeper than kFleshSlope along edges.
std::vector<double> depths(const TriMesh& skin, const SidedPatch& on_skin, const Bvh& bone,
                           std::vector<uint8_t>& over_bone) {
  const size_t n = skin.X_mm.size();
  std::vector<double> depth(n, kFleshDepth_mm);
  over_bone.assign(n, 0);
  for (size_t v = 0; v < n; ++v) {
    const Vec3& normal = on_skin.corner_normal(int32_t(v));
    const auto hits = bone.line(skin.X_mm[v] - kAlongNormal_mm * normal, -normal, 0, kFleshDepth_mm);
    if (hits.empty()) continue;
    over_bone[v] = 1, depth[v] = std::max(kLeastFlesh_mm, hits.front().t);
  }
  std::vector<std::vector<int32_t>> beside(n);
  for (const Tri& t : skin.tri)
    for (int k = 0; k < 3; ++k) beside[size_t(t[size_t(k)])].push_back(t[size_t(k + 1) % 3]);
  using Item = std::pair<double, int32_t>;
  std::priority_queue<Item, std::vector<Item>, std::greater<>> open;
  for (size_t v = 0; v < n; ++v) open.push({depth[v], int32_t(v)});
  while (!open.empty()) {
    const auto [d, v] = open.top();
    open.pop();
    if (d > depth[size_t(v)]) continue;
    for (const int32_t w : beside[size_t(v)])
      if (const double most = d + kFleshSlope * (skin.X_mm[size_t(v)] - skin.X_mm[size_t(w)]).norm();
          most < depth[size_t(w)])
        depth[size_t(w)] = most, open.push({most, w});
  }
  return depth;
}

/// Where the skin's mesh ends.
std::vector<Vec3> rim_of(const simplex::Mesh& m) {
  std::vector<Vec3> rim;
  for (int32_t v = 0; v < m.slots(); ++v)
    if (m.alive(v) && std::any_of(m.left[size_t(v)].begin(), m.left[size_t(v)].end(),
                                  [&](int32_t f) { return simplex::is_end(m.kind(f)); }))
      rim.push_back(m.x_mm[size_t(v)]);
  return rim;
}

/// What keeps the surface from being a body; nothing: it can be one.
std::string fault_of(const PatientFlesh& f) {
  Vec3 low = f.X_mm.front(), high = low;
  for (const Vec3& x : f.X_mm) low = low.cwiseMin(x), high = high.cwiseMax(x);
  RestGrid grid{0.5 * (low + high)};
  while (!grid.fits(low) || !grid.fits(high)) grid.unit_mm *= 2;
  TriMesh m;
  m.tri = f.tri;
  for (const Vec3& x : f.X_mm) m.X_mm.push_back(grid.to_mm(grid.to_grid(x)));
  try {
    validate_surface(m, grid, "");
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

}  // namespace

PatientFlesh make_patient_flesh(const PatientModel& p, Workers& workers) {
  if (p.face.slots() == 0) throw InputError("", 0, "the picture shows no skin; soft tissue needs some");
  TriMesh skin;
  {
    Surface s = triangles_of(p.face);
    skin.X_mm = std::move(s.x_mm), skin.tri = std::move(s.tri);
  }
  const SidedPatch on_skin(skin);
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const Vec3& X : skin.X_mm)
    if (X.y() >= kFleshBack_mm) low = low.cwiseMin(X), high = high.cwiseMax(X);
  if (!(low.x() < high.x())) throw InputError("", 0, "no skin lies before the ear canals; a face was expected there");
  Surface bones;
  for (const PatientBone& b : p.bone) append(bones, triangles_of(b.mesh));
  std::vector<uint8_t> over_bone;
  const std::vector<double> depth = depths(skin, on_skin, Bvh(bones.x_mm, bones.tri), over_bone);
  const std::vector<Vec3> rim = rim_of(p.face);
  const PointTree near_rim(rim);

  struct At {
    double s = 0, depth = kFleshDepth_mm;  // to the skin, below 0 within; of the tissue there
    double rim = -kFleshRim_mm;            // above 0: nearer than kFleshRim_mm to where the skin ends, along the skin
    bool over_bone = false;
  };
  const auto at = [&](const Vec3& x) {
    const Bvh::Closest c = on_skin.bvh().closest(x, kNear_mm);
    if (c.triangle < 0) return At{kNear_mm};
    At a{(x - c.point_mm).dot(on_skin.side_normal(c)) < 0 ? -c.distance_mm : c.distance_mm, 0};
    const Tri& corners = skin.tri[size_t(c.triangle)];
    for (size_t k = 0; k < 3; ++k) a.depth += c.bary[k] * depth[size_t(corners[k])];
    const size_t nearest = size_t(std::max_element(c.bary.begin(), c.bary.end()) - c.bary.begin());
    a.over_bone = over_bone[size_t(corners[nearest])] != 0;
    // At the foot: beyond the end, too, nearness to the skin's rim would be depth below it.
    if (!rim.empty()) a.rim = kFleshRim_mm - near_rim.nearest(c.point_mm).distance;
    return a;
  };
  const auto sides = [](const Vec3& x, const At& a) { return std::max(kFleshBack_mm - x.y(), a.rim); };
  LevelSet set;
  set.lipschitz = kFleshLipschitz;
  set.low_mm = low - Vec3::Constant(4), set.high_mm = high + Vec3::Constant(4);
  set.low_mm.y() = kFleshBack_mm - 4;
  set.distance_mm = [&](const Vec3& x) {
    const At a = at(x);
    return shape::smax(std::max(a.s, -a.s - a.depth), sides(x, a), kRoundSides_mm);
  };
  PatientFlesh f;
  std::string wrong;
  for (const double times : kTries) {
    const auto cell = [&](const Vec3& x) {
      return times * std::clamp(kCellOfDepth * at(x).depth, kLeastCell_mm, kSkinCell_mm);
    };
    f = {};
    march_graded(set, cell, workers, f.X_mm, f.tri);
    if (f.tri.empty()) throw InputError("", 0, "no soft tissue was found before the ear canals");
    keep_largest(f.X_mm, f.tri);
    thin_edges(f.X_mm, f.tri, set, [&](const Vec3& x) { return kEdgeOfCell * cell(x); });
    for (Vec3& x : f.X_mm) x = kRounded_mm * (x / kRounded_mm).array().round();
    if (wrong = fault_of(f); wrong.empty()) break;
  }
  if (!wrong.empty()) throw InputError("", 0, "its surface is not sound: " + wrong);
  double skin_mm2 = 0, over_mm2 = 0;
  for (const Tri& t : f.tri) {
    const Vec3 &a = f.X_mm[size_t(t[0])], &b = f.X_mm[size_t(t[1])], &c = f.X_mm[size_t(t[2])];
    const Vec3 middle = (a + b + c) / 3;
    const At m = at(middle);
    const double e = sides(middle, m), d = -m.s - m.depth;
    const FleshPart part = m.s >= std::max(d, e) ? FleshPart::skin
                           : e > d               ? FleshPart::side
                           : m.over_bone         ? FleshPart::bone
                                                 : FleshPart::deep;
    f.part.push_back(part);
    if (part != FleshPart::skin) continue;
    const double area = 0.5 * area_vector2(a, b, c).norm();
    skin_mm2 += area, over_mm2 += m.over_bone ? area : 0;
  }
  f.over_bone = skin_mm2 > 0 ? over_mm2 / skin_mm2 : 0;
  return f;
}

}  // namespace limberg
