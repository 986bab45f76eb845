#pragma once
// What the solver thread shows to the others: plain data, copied or shared by version, never written after publishing.
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/base/lazy.h"
#include "sim/body/body.h"
#include "sim/body/skin_image.h"
#include "sim/cutting/arrangement/surface_view.h"
#include "sim/fem/model/fem_model.h"
#include "sim/patient/ground_index.h"

namespace limberg {

/// What a triangle of the view belongs to. Flesh: the finite-element block or surface, whose kinds are those of the
/// view.
enum class Organ : uint8_t { flesh = 0, face = 1, bone = 2, bone_cut = 3 };

/// Changes only when a cut, an excision or an undo does. Immutable, shared by version.
struct SurfaceTopology {
  uint64_t version = 0;
  uint64_t hash = 0;
  SurfaceView view;
  SharedArray<EmbeddedPoint> embedding;  // per view vertex
  Lazy<SharedArray<float>> depth_mm;     // per view vertex: distance below the skin at rest
  Lazy<SharedArray<float>> layers_mm;    // the same as the layers of the body count it (point_depths.h)
  std::shared_ptr<const Body> body;
  std::shared_ptr<const SkinImage> image;  // on the skin, by view.uv; null: there is none
  Organ image_on = Organ::flesh;           // whose skin: of flesh, or a face
  // Of a scene with a head; empty where there is none. Bone and face are of the kind `free` in the view.
  SharedArray<Organ> organ;     // per view triangle; empty: all of it is flesh
  SharedArray<int32_t> object;  // per view triangle: of bone, the number of its fragment; else -1
  // Per view vertex: its own colour, sRGB, and how much of it is seen; empty: surfaces look as their organ does, and so
  // does flesh in which no region has a colour.
  std::vector<std::array<uint8_t, 4>> rgba;
  std::vector<std::array<int32_t, 2>> strand;  // edges of the tissue between face and bone, by view vertices
  std::vector<std::string> landmark;           // names; their places are in the snapshot
  GroundIndices indices;                       // index() makes them

  Organ organ_of(size_t triangle) const { return organ.empty() ? Organ::flesh : organ[triangle]; }
  bool is_ground(size_t triangle, Ground ground) const {
    const Organ o = organ_of(triangle);
    if (ground == Ground::bone) return o == Organ::bone || o == Organ::bone_cut;
    return o == Organ::flesh && (ground == Ground::flesh || view.kind[triangle] == FaceKind::skin);
  }
  /// Its triangles and those around each vertex; made once, when it is first asked for.
  const GroundIndex& index(Ground ground) const {
    return indices.get(ground, [&] {
      return make_ground_index(view.X_mm.size(), view.tri, [&](size_t t) { return is_ground(t, ground); });
    });
  }
  /// On the chart of the body; where there is none, seen from in front.
  ChartPoint to_chart(const Vec3& X_mm) const { return body ? body->to_chart(X_mm) : ChartPoint(X_mm.x(), X_mm.z()); }
};

struct HookState {
  int32_t id = 0;
  Vec3f at_mm, handle_mm;  // on the tissue; where it is pulled to
  Vec3f force_N;
};

struct SutureState {
  int32_t id = 0;
  Vec3f a_mm, b_mm;
  float force_N = 0, gap_mm = 0;  // gap: what the thread leaves open between the two bites, whose middles a and b are
  int32_t thread = 0;             // stitches of one thread have one number; 0: a thread of its own
  // Of states at rest (relative residual at most 1e-3, every thread drawn tight): the force in the first of them, less
  // than 0 as long as there is none, and the largest.
  float tied_N = -1, peak_N = 0;
};

/// The thread that is sewn bite after bite and not tied yet.
struct SewnThread {
  int32_t thread = 0;  // its number; 0: there is none
  int32_t bites = 0;
  bool let_go = false;           // nobody holds its end
  Vec3f end_mm = Vec3f::Zero();  // where its last bite came out, now
};

/// A number that is shown while it changes: a distance, an angle, a gap.
struct LiveFigure {
  std::string name;
  const char* unit = "mm";
  float value = 0;
};

struct Snapshot {
  uint64_t step = 0;        // solver steps done
  int64_t device_tick = 0;  // the newest device tick it has seen
  uint64_t topology_version = 0;
  std::shared_ptr<const SurfaceTopology> topology;  // readers of a session only borrow it
  std::vector<Vec3f> x_mm;                          // per view vertex
  std::vector<float> field;  // per view vertex: skin tension shown (largest principal stretch - 1), may be empty
  std::vector<float>
      moved_mm;  // per view vertex, of a face: how far it is from where it was at first; empty without a face
  std::vector<Vec3f> landmark_mm;              // one per SurfaceTopology::landmark
  std::vector<std::array<Vec3f, 2>> plate_mm;  // the ends of the plates between fragments of bone, on bone
  std::vector<LiveFigure> figures;
  std::vector<HookState> hooks;
  std::vector<SutureState> sutures;
  SewnThread sewn;
  float residual = 0, distance_mm = 0;
  int32_t stage = -1;  // number of stages passed
};

/// Whether there is skin, with a place for each of its points.
inline bool has_surface(const Snapshot& s) {
  return s.topology && !s.topology->view.tri.empty() && s.x_mm.size() == s.topology->view.X_mm.size();
}

}  // namespace limberg
