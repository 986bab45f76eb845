#include "render/render_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "render/colour_map.h"
#include "render/glyphs.h"
#include "render/stitches.h"

namespace limberg {

void SceneBuilder::add_stretch_glyphs(const Snapshot& snapshot) { add_glyphs(scene_.props, stretch_glyphs(snapshot)); }

void SceneBuilder::add_props(const PropMesh& props) {
  const auto first = uint32_t(scene_.props.vertex.size());
  scene_.props.vertex.insert(scene_.props.vertex.end(), props.vertex.begin(), props.vertex.end());
  for (const auto& t : props.tri) scene_.props.tri.push_back({t[0] + first, t[1] + first, t[2] + first});
}

void SceneBuilder::add_lines(const SceneLines& lines) {
  SceneLines& all = scene_.lines;
  all.x_mm.insert(all.x_mm.end(), lines.x_mm.begin(), lines.x_mm.end());
  all.colour.insert(all.colour.end(), lines.colour.begin(), lines.colour.end());
}

const RenderScene& SceneBuilder::show_field(std::span<const float> per_vertex) {
  const TissueMesh& mesh = *scene_.mesh;
  scene_.field.clear();
  if (per_vertex.empty() || per_vertex.size() != mesh.vertices_of_view) return scene_;
  scene_.field.resize(mesh.source.size());
  for (size_t v = 0; v < mesh.source.size(); ++v) scene_.field[v] = per_vertex[size_t(mesh.source[v])];
  return scene_;
}

namespace {

/// Where a plate is bent between its ends: at the place on its way over which bone stands highest, so that it lies on
/// the edge of a step and bridges a gap; half way where none stands over it.
Vec3f bend_of_plate(const RenderScene& scene, const Vec3f& a, const Vec3f& b, const Vec3f& up) {
  constexpr int kPlaces = 15;
  constexpr float kBeside_mm = 4,
                  kHighest_mm = 20;  // bone's vertices are no farther apart; what is higher is other bone
  struct Place {
    float beside2 = kBeside_mm * kBeside_mm, height = 0;
  };
  std::array<Place, kPlaces> place;
  const auto way = [&](int k) { return Vec3f(a + float(k + 1) / (kPlaces + 1) * (b - a)); };
  const TissueMesh& m = *scene.mesh;
  const Vec3f lo = a.cwiseMin(b).array() - kHighest_mm, hi = a.cwiseMax(b).array() + kHighest_mm;
  for (size_t v = 0; v < m.source.size(); ++v) {
    const Vec3f& x = scene.x_mm[v];
    const float slope = scene.normal[v].dot(up);
    if (m.part[v] != Part::bone || slope < 0.3f || (x.array() < lo.array()).any() || (x.array() > hi.array()).any())
      continue;
    for (int k = 0; k < kPlaces; ++k) {
      const Vec3f d = x - way(k);
      const float above = d.dot(up), beside2 = d.squaredNorm() - above * above;
      if (beside2 < place[size_t(k)].beside2 && std::abs(above) < kHighest_mm)
        place[size_t(k)] = {beside2, d.dot(scene.normal[v]) / slope};
    }
  }
  int highest = kPlaces / 2;
  for (int k = 0; k < kPlaces; ++k)
    if (place[size_t(k)].height > std::max(0.0f, place[size_t(highest)].height)) highest = k;
  return way(highest) + std::max(0.0f, place[size_t(highest)].height) * up;
}

/// What the tissue lies against (body/collider.h), smoothly shaded.
PropMesh colliders_of(const Body& body) {
  PropMesh out;
  for (const auto& c : body.colliders) {
    const auto first = uint32_t(out.vertex.size());
    std::vector<Vec3> normal(c->mesh.X_mm.size(), Vec3::Zero());
    for (const Tri& t : c->mesh.tri) {
      const Vec3& a = c->mesh.X_mm[size_t(t[0])];
      const Vec3 n = (c->mesh.X_mm[size_t(t[1])] - a).cross(c->mesh.X_mm[size_t(t[2])] - a);
      for (const int32_t v : t) normal[size_t(v)] += n;
      out.tri.push_back({first + uint32_t(t[0]), first + uint32_t(t[1]), first + uint32_t(t[2])});
    }
    for (size_t v = 0; v < normal.size(); ++v)
      out.vertex.push_back(
          {c->mesh.X_mm[v].cast<float>(), normal[v].normalized().cast<float>(), linear_light(c->colour_of(v)), 0, 0});
  }
  return out;
}

/// A hand would hide a patient that is not larger than it is: there only its last joints are drawn.
void add_gloves(RenderScene& scene, const ToolPose& tool) {
  constexpr float kLarge_mm = 250;  // a hand is 190 mm long
  for (GlovePose g : {tool.glove, tool.other_glove}) {
    g.whole &= !scene.x_mm.empty() && (scene.bounds_max - scene.bounds_min).norm() >= kLarge_mm;
    add_glove(scene.props, g);
  }
}

}  // namespace

void SceneBuilder::show_beds(const Snapshot& snapshot) {
  if (!whole_ || scene_.mesh != whole_ || !snapshot.topology) return;
  if (!bared_) bared_ = std::make_shared<TissueMesh>(without_flaps(*whole_, *snapshot.topology));
  if (bared_->tri.size() == whole_->tri.size()) return;  // nothing was raised
  scene_.mesh = bared_;
  for (const auto& [i, j] : whole_->rim)  // where they are
    scene_.lines.add(snapshot.x_mm[size_t(i)], snapshot.x_mm[size_t(j)], Vec3f(0.9f, 0.75f, 0.55f));
}

void SceneBuilder::seen_from(const Camera& camera) {
  towards_eye_ = camera.eye_mm - camera.target_mm;
  whole_ = nullptr;
}

const RenderScene& SceneBuilder::build(const Snapshot& snapshot, const ToolPose& tool, bool strands) {
  RenderScene& scene = scene_;
  scene.props.clear();
  scene.lines.clear();
  scene.field.clear();
  if (!snapshot.topology || snapshot.x_mm.size() != snapshot.topology->view.X_mm.size()) {
    scene.mesh = std::make_shared<TissueMesh>();
    scene.x_mm.clear(), scene.normal.clear();
    add_tool(scene.props, tool), add_gloves(scene, tool);
    return scene;
  }
  const SurfaceTopology& topology = *snapshot.topology;
  if (!whole_ || whole_->version != topology.version || whole_->hash != topology.hash ||
      whole_->vertices_of_view != topology.view.X_mm.size())
    whole_ = std::make_shared<TissueMesh>(make_tissue_mesh(topology, towards_eye_)), bared_ = nullptr;
  scene.mesh = whole_;
  const TissueMesh& mesh = *scene.mesh;

  scene.x_mm.resize(mesh.source.size());
  for (size_t v = 0; v < mesh.source.size(); ++v) scene.x_mm[v] = snapshot.x_mm[size_t(mesh.source[v])];
  vertex_normals(mesh.tri, scene.x_mm, scene.normal);
  const std::vector<float>& field = snapshot.field.empty() ? snapshot.moved_mm : snapshot.field;
  if (field.size() == snapshot.x_mm.size()) {
    scene.field.resize(mesh.source.size());
    for (size_t v = 0; v < mesh.source.size(); ++v) scene.field[v] = field[size_t(mesh.source[v])];
  }
  scene.bounds_min = Vec3f::Constant(std::numeric_limits<float>::max());
  scene.bounds_max = -scene.bounds_min;
  for (const Vec3f& x : scene.x_mm)
    scene.bounds_min = scene.bounds_min.cwiseMin(x), scene.bounds_max = scene.bounds_max.cwiseMax(x);

  if (against_of_ != topology.body) {
    against_of_ = topology.body;
    against_ = topology.body ? colliders_of(*topology.body) : PropMesh();
  }
  add_props(against_);
  for (size_t i = 0; i < snapshot.sutures.size(); ++i) {
    SutureState s = snapshot.sutures[i];
    const auto same = [&](size_t k) { return k < snapshot.sutures.size() && snapshot.sutures[k].thread == s.thread; };
    const bool goes_on = s.thread != 0 && s.thread == snapshot.sewn.thread;  // the needle is on it: no knot there yet
    if (!same(i - 1) || (!same(i + 1) && !goes_on)) s.thread = 0;            // the ends of a thread have a knot each
    add_stitch(scene, snapshot, s);
  }
  for (const HookState& h : snapshot.hooks)
    if (h.at_mm.allFinite() && h.handle_mm.allFinite()) {
      const NearestSkin at = nearest_skin(scene, h.at_mm);
      add_hook(scene.props, h, at.found ? at.normal : Vec3f(Vec3f::UnitZ()));
    }
  for (const auto& [a, b] : snapshot.plate_mm) {
    const Vec3f at_a = nearest_skin(scene, a, Part::bone).normal,
                at_b = nearest_skin(scene, b, Part::bone).normal;  // (where there is none: up)
    const Vec3f both = at_a + at_b, between = both.norm() > 0.1f ? Vec3f(both.normalized()) : at_a;
    add_plate(scene.props, {a, bend_of_plate(scene, a, b, between), b}, {at_a, between, at_b});
  }
  if (strands)
    for (const auto& [a, b] : topology.strand)
      add_tube(scene.props, std::array{snapshot.x_mm[size_t(a)], snapshot.x_mm[size_t(b)]}, std::array{0.22f, 0.22f},
               {Vec3f(0.80f, 0.58f, 0.13f), 0, 0}, 3);
  if (snapshot.sewn.thread != 0 && snapshot.sewn.end_mm.allFinite()) {
    // It leaves the skin where the last stitch goes in, not at the edge that its bite is held by.
    Vec3f from = snapshot.sewn.end_mm, across = Vec3f::Zero();  // across: out of the wound
    for (const SutureState& k : snapshot.sutures) {
      if (k.thread != snapshot.sewn.thread) continue;
      if ((k.b_mm - k.a_mm).norm() > 0.3f) across = k.b_mm - k.a_mm;
      if (const StitchWay way = stitch_way(scene, snapshot, k); !way.path_mm.empty()) {
        from = way.path_mm.back();
        if ((k.b_mm - k.a_mm).norm() <= 0.3f) across = from - way.path_mm.front();
      }
    }
    const NearestSkin at = nearest_skin(scene, from);
    const Vec3f up = at.found ? at.normal : Vec3f(Vec3f::UnitZ());
    std::vector<Vec3f> lying;
    if (!holds_needle(tool))
      lying = lying_thread(scene, from, across.norm() > 0.1f ? across : Vec3f(up.unitOrthogonal()));
    add_sewn_thread(scene.props, from, up, lying, tool);
  }
  add_tool(scene.props, tool), add_gloves(scene, tool);
  return scene;
}

namespace {

struct Box {
  Vec3f lo = Vec3f::Constant(std::numeric_limits<float>::max());
  Vec3f hi = Vec3f::Constant(-std::numeric_limits<float>::max());
  void add(const Vec3f& p) {
    if (p.allFinite()) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
  }
  bool empty() const { return lo.x() > hi.x(); }
};

}  // namespace

bool operated_box(const Snapshot& snapshot, Vec3f& low_mm, Vec3f& high_mm) {
  Box box;
  if (snapshot.topology && snapshot.topology->view.X_mm.size() == snapshot.x_mm.size()) {
    // At rest and now: the frame shall hold the wound before and after it is closed.
    const SurfaceView& view = snapshot.topology->view;
    const auto& depth = snapshot.topology->depth_mm.get();
    for (size_t t = 0; t < view.tri.size(); ++t)
      if (view.kind[t] == FaceKind::wall)
        for (const int32_t v : view.tri[t]) {
          if (depth.size() == view.X_mm.size() && depth[size_t(v)] > 0.5f) continue;  // the mark on the skin counts
          box.add(view.X_mm[size_t(v)].cast<float>());
          box.add(snapshot.x_mm[size_t(v)]);
        }
  }
  for (const SutureState& s : snapshot.sutures) box.add(s.a_mm), box.add(s.b_mm);
  for (const HookState& h : snapshot.hooks) box.add(h.at_mm);
  if (box.empty()) return false;
  low_mm = box.lo, high_mm = box.hi;
  return true;
}

void skin_box(const Body& body, Vec3f& low_mm, Vec3f& high_mm) {
  Box box;
  for (size_t t = 0; t < body.surface.tri.size(); ++t)
    if (body.surface.tag.empty() || body.surface.tag[t] == SurfaceTag::skin)
      for (const int32_t v : body.surface.tri[t]) box.add(body.surface.X_mm[size_t(v)].cast<float>());
  if (box.empty()) box.add(Vec3f::Zero());
  low_mm = box.lo, high_mm = box.hi;
}

}  // namespace limberg
