#include "render/stitches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace limberg {

namespace {

constexpr float kBite_mm = 2.2f;  // how far from the wound's edge a stitch enters the skin, for the picture
// a point of the thread is looked for so far above and below the straight line between its ends
constexpr float kReach_mm = 4;
constexpr float kFlat_mm = 0.05f;   // what stands up less does not bend the thread
constexpr float kOpposite = -0.5f;  // cosine
constexpr float kOneWay = 0.7f;     // of the areas' sum, the length of their normals' sum
constexpr int kSamples = 12;        // places between the ends at which the skin's height is taken

// The direction over the wound at a stitch: across the cut's rim nearest to its end a, away from the skin of a.
Vec3f across_rim(const RenderScene& scene, const Snapshot& snapshot, const Vec3f& a, const Vec3f& up) {
  float distance = std::numeric_limits<float>::max();
  Vec3f along = Vec3f::Zero();
  for (const auto& [i, j] : scene.mesh->rim) {
    const Vec3f &p = snapshot.x_mm[size_t(i)], &q = snapshot.x_mm[size_t(j)];
    const float length2 = (q - p).squaredNorm();
    if (length2 < 1e-8f) continue;
    const float t = std::clamp((a - p).dot(q - p) / length2, 0.0f, 1.0f);
    const float d = (p + t * (q - p) - a).squaredNorm();
    if (d < distance) distance = d, along = q - p;
  }
  const Vec3f out = along.cross(up);  // skin lies on the left of its rim, the wound on the right
  return out.norm() > 1e-6f ? Vec3f(out.normalized()) : Vec3f(Vec3f::UnitX());
}

// The skin around a stitch; not what faces it from beyond a gap, as the other lip does.
struct Patch {
  const RenderScene& scene;
  std::vector<uint32_t> triangle;
  Vec3f normal = Vec3f::Zero();  // of all of it; zero: there is none

  Patch(const RenderScene& s, const Vec3f& middle, float radius, const Vec3f& facing) : scene(s) {
    const TissueMesh& m = *scene.mesh;
    std::vector<Vec3f> towards;
    float all = 0;
    for (size_t t = 0; t < m.skin_triangles; ++t) {
      const auto& [a, b, c] = m.tri[t];
      // The ball about the triangle: large ones lie near a place that their corners are far from.
      const Vec3f centre = (scene.x_mm[a] + scene.x_mm[b] + scene.x_mm[c]) / 3;
      const float around =
          std::max({(scene.x_mm[a] - centre).norm(), (scene.x_mm[b] - centre).norm(), (scene.x_mm[c] - centre).norm()});
      if ((centre - middle).norm() > radius + around) continue;
      const Vec3f n = (scene.x_mm[b] - scene.x_mm[a]).cross(scene.x_mm[c] - scene.x_mm[a]);
      triangle.push_back(uint32_t(t)), towards.push_back(n);
      normal += n, all += n.norm();
    }
    // What lies around a wound looks one way, though the nearest vertex may not. Two lips look at each other: then the
    // nearest one says which is meant.
    if (normal.norm() < kOneWay * all) {
      normal.setZero();
      size_t kept = 0;
      for (size_t i = 0; i < triangle.size(); ++i)
        if (towards[i].dot(facing) >= kOpposite * towards[i].norm())
          triangle[kept++] = triangle[i], normal += towards[i];
      triangle.resize(kept);
    }
    const float length = normal.norm();
    normal = length > 1e-6f ? Vec3f(normal / length) : Vec3f(Vec3f::Zero());
  }

  // How far above p the uppermost skin lies, within kReach_mm; none over a wound.
  std::optional<float> height(const Vec3f& p, const Vec3f& up) const {
    std::optional<float> best;
    for (const uint32_t t : triangle) {
      const auto& [ia, ib, ic] = scene.mesh->tri[t];
      const Vec3f a = scene.x_mm[ia] - p, b = scene.x_mm[ib] - p, c = scene.x_mm[ic] - p;
      // Signed volumes of the line and the edges: of one sign where the line goes through.
      const float u = up.dot(b.cross(c)), v = up.dot(c.cross(a)), w = up.dot(a.cross(b)), sum = u + v + w;
      if (!((u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0)) || std::abs(sum) < 1e-12f) continue;
      const float h = up.dot(u * a + v * b + w * c) / sum;
      if (std::abs(h) <= kReach_mm && (!best || h > *best)) best = h;
    }
    return best;
  }
};

}  // namespace

NearestSkin nearest_skin(const RenderScene& scene, const Vec3f& p, Part part) {
  NearestSkin best;
  float distance = std::numeric_limits<float>::max();
  const TissueMesh& m = *scene.mesh;
  for (size_t v = 0; v < m.source.size(); ++v) {
    if (m.part[v] != part) continue;
    const float d = (scene.x_mm[v] - p).squaredNorm();
    if (d < distance && scene.normal[v].squaredNorm() > 0.5f)
      distance = d, best = {scene.x_mm[v], scene.normal[v], true};
  }
  return best;
}

StitchWay stitch_way(const RenderScene& scene, const Snapshot& snapshot, const SutureState& s) {
  if (!s.a_mm.allFinite() || !s.b_mm.allFinite()) return {};
  const NearestSkin at = nearest_skin(scene, s.a_mm);
  if (!at.found) return {};
  const Vec3f gap = s.b_mm - s.a_mm;
  const Patch patch(scene, 0.5f * (s.a_mm + s.b_mm), 0.5f * gap.norm() + kBite_mm + 2, at.normal);
  // Beside a wound the nearest vertex may belong to an edge that is rolled in: the skin around says where up is.
  const Vec3f up = patch.normal.squaredNorm() > 0.5f ? patch.normal : at.normal;
  // An open stitch points from end to end; a closed one has no direction left and takes the wound's.
  Vec3f across = gap.norm() > 1.5f ? Vec3f(gap.normalized()) : across_rim(scene, snapshot, s.a_mm, up);
  across = (across - across.dot(up) * up).normalized();
  if (!across.allFinite()) across = up.unitOrthogonal();

  const Vec3f from = s.a_mm - kBite_mm * across, to = s.b_mm + kBite_mm * across;
  // A taut thread lies on the upper hull of the skin between its holes. x: along, y: above the straight line.
  std::vector<Eigen::Vector2f> hull;
  for (int k = 0; k <= kSamples; ++k) {
    const float t = float(k) / kSamples;
    const Vec3f p = from + t * (to - from);
    std::optional<float> h = patch.height(p, up);
    if (!h && k > 0 && k < kSamples) continue;
    if (!h) h = (nearest_skin(scene, p).x - p).dot(up);
    const Eigen::Vector2f next(t, *h);
    const auto below = [&](const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
      return (b.y() - a.y() - kFlat_mm) * (next.x() - a.x()) <= (next.y() - a.y()) * (b.x() - a.x());
    };
    while (hull.size() > 1 && below(hull[hull.size() - 2], hull.back())) hull.pop_back();
    hull.push_back(next);
  }
  StitchWay way{{}, up};
  for (const Eigen::Vector2f& h : hull) way.path_mm.push_back(from + h.x() * (to - from) + h.y() * up);
  return way;
}

std::vector<Vec3f> lying_thread(const RenderScene& scene, const Vec3f& from, const Vec3f& aside) {
  constexpr float kLong_mm = 14, kStep_mm = 1, kOver_mm = 0.16f, kOff_mm = 3, kBend = 0.07f;
  std::vector<Vec3f> way;
  Vec3f p = from, towards = aside;
  for (float gone = 0; gone < kLong_mm; gone += kStep_mm) {
    const NearestSkin here = nearest_skin(scene, p + kStep_mm * towards.normalized());
    if (!here.found) break;
    const Vec3f n = here.normal.normalized();
    Vec3f flat = towards - towards.dot(n) * n;
    if (!(flat.norm() > 1e-3f)) flat = n.unitOrthogonal();
    flat.normalize();
    const Vec3f next = p + kStep_mm * flat, on = next - (next - here.x).dot(n) * n;
    if ((on - here.x).norm() > kOff_mm) break;
    p = on;
    way.push_back(on + kOver_mm * n);
    towards = flat + kBend * n.cross(flat);
  }
  return way;
}

void add_stitch(RenderScene& scene, const Snapshot& snapshot, const SutureState& s) {
  const StitchWay way = stitch_way(scene, snapshot, s);
  if (!way.path_mm.empty()) add_suture(scene.props, s, way.path_mm, way.up);
}

}  // namespace limberg
