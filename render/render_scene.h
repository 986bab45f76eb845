#pragma once
// What the renderer draws: the tissue's surface made ready for a graphics card, and the props (threads, hooks, tool).
//
// A SceneBuilder turns snapshots into scenes. Everything that only changes with a cut (smoothing groups, texture
// coordinates, layer depths, indices) is worked out once per topology version; positions, normals and the field are
// filled per snapshot.
#include <memory>
#include <span>
#include <vector>

#include "render/props.h"
#include "render/tool_pose.h"
#include "render/view.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// What kind of surface a pixel shows; also the part of an id (see Renderer::draw_ids).
enum class Part : uint8_t {
  none = 0,
  skin = 1,
  wall = 2,
  side = 3,
  suture = 4,
  hook = 5,
  tool = 6,
  bone = 7,
  bone_cut = 8,
  face = 9
};
inline constexpr size_t kParts = 10;

/// Towards the lamp, where x is right, y up and z the way that what is operated on faces: the skin beside cuts; before
/// there are any the chart, or the eye where it looks on the side of a body; of bones, their own axes.
inline const Vec3f kLamp = Vec3f(-0.62f, 0.44f, 0.65f).normalized();

/// The constant half of the tissue's surface. A surface vertex is doubled where shading must not be smooth: between
/// skin, walls and sides, and over sharp edges at rest.
struct TissueMesh {
  uint64_t version = 0, hash = 0;  // of the topology that it was made from
  Vec3f lamp = kLamp;              // unit, in the patient's frame
  size_t vertices_of_view = 0;
  std::vector<int32_t> source;               // per render vertex: vertex of SurfaceView
  std::vector<Vec3f> X_mm;                   // rest position
  std::vector<Eigen::Vector2f> chart_mm;     // texture coordinate: rest position in the skin's chart
  std::vector<float> depth_mm;               // below the skin at rest
  std::vector<float> rim_mm;                 // of skin: distance at rest to the nearest cut edge, at most kRimReach_mm
  Part image_part = Part::skin;              // what wears it
  std::vector<Eigen::Vector2f> uv;           // in `image`; empty where there is none
  std::vector<std::array<uint8_t, 4>> rgba;  // own colours (SurfaceTopology::rgba); empty where there are none
  std::vector<Part> part;                    // skin, wall, side, bone, bone_cut or face
  std::vector<std::array<uint32_t, 3>> tri;  // render vertices; in the order of kTissueParts
  std::vector<int32_t> tri_source;           // triangle of SurfaceView
  size_t skin_triangles = 0, wall_triangles = 0;
  std::array<size_t, kParts> triangles_of{};  // per part
  std::vector<std::array<int32_t, 2>> rim;    // edges between skin and wall (SurfaceView vertices), skin on the left
  std::vector<Layer> layers;
  std::shared_ptr<const SkinImage> image;  // on the skin; null: there is none
  // unit: how the tension lines run on the chart; zero: unknown
  Eigen::Vector2f tension_chart = Eigen::Vector2f::Zero();
  // Where they run differently in different places, per render vertex: cosine and sine of twice their angle on the
  // chart, so that what lies between is their mean; zero where they stand upright on it. Empty: as tension_chart says.
  std::vector<Eigen::Vector2f> tension_twice;
};

/// The parts of a TissueMesh in the order in which they are drawn: the face last, because it may be translucent.
inline constexpr Part kTissueParts[] = {Part::skin, Part::wall, Part::side, Part::bone, Part::bone_cut, Part::face};

inline constexpr float kRimReach_mm = 3;  // so far the skin beside a cut is reddened

/// Thin lines, two ends each: faint where tissue hides them.
struct SceneLines {
  std::vector<Vec3f> x_mm, colour;  // per end; colour: linear RGB
  void clear() { x_mm.clear(), colour.clear(); }
  void add(const Vec3f& a, const Vec3f& b, const Vec3f& rgb) {
    x_mm.insert(x_mm.end(), {a, b}), colour.insert(colour.end(), {rgb, rgb});
  }
};

struct RenderScene {
  std::shared_ptr<const TissueMesh> mesh;
  std::vector<Vec3f> x_mm, normal;  // per render vertex
  std::vector<float> field;         // per render vertex, or empty; of a head without skin: Snapshot::moved_mm
  PropMesh props;
  SceneLines lines;
  Vec3f bounds_min = Vec3f::Zero(), bounds_max = Vec3f::Zero();  // of the tissue
};

class SceneBuilder {
 public:
  /// From where the patient is looked at first: the lamp follows before anything is cut. Not called: the chart's side.
  void seen_from(const Camera& camera);
  /// The scene of a snapshot; valid until the next call. A snapshot without topology gives an empty scene.
  /// `strands`: the tissue between face and bone as a net.
  const RenderScene& build(const Snapshot& snapshot, const ToolPose& tool = {}, bool strands = false);
  // To the scene that was built last:
  /// Adds the skin's principal stretches (glyphs.h).
  void add_stretch_glyphs(const Snapshot& snapshot);
  /// Adds things without mechanics: a drawing on the skin, a room.
  void add_props(const PropMesh& props);
  /// Adds lines. One list each for ends and colours, of equal length.
  void add_lines(const SceneLines& lines);
  /// Shows another field than the snapshot's own: a value per vertex of the view; empty: none.
  const RenderScene& show_field(std::span<const float> per_vertex);
  /// The flaps are left out, so that their beds are seen (without_flaps()).
  void show_beds(const Snapshot& snapshot);

 private:
  RenderScene scene_;
  std::shared_ptr<const Body> against_of_;  // whose colliders these are
  PropMesh against_;
  Vec3f towards_eye_ = Vec3f::Zero();
  std::shared_ptr<const TissueMesh> whole_, bared_;  // of one topology; bared_: null until it is wanted
};

/// The constant half, for a topology. `towards_eye`: from where it is looked at first; zero: not known.
TissueMesh make_tissue_mesh(const SurfaceTopology& topology, const Vec3f& towards_eye = Vec3f::Zero());

/// The same vertices without the triangles of what was raised from its bed: skin under which, seen along the chart's
/// normal, a cut face looks away from the skin, and the walls of that. O(triangles)
TissueMesh without_flaps(const TissueMesh& mesh, const SurfaceTopology& topology);

/// Area-weighted vertex normals (unit; zero where a vertex has no area).
void vertex_normals(const std::vector<std::array<uint32_t, 3>>& tri, const std::vector<Vec3f>& x_mm,
                    std::vector<Vec3f>& normal);

/// A box around what was operated (cut rims at rest and now, sutures, hooks); false when nothing was.
bool operated_box(const Snapshot& snapshot, Vec3f& low_mm, Vec3f& high_mm);
/// A box around the skin at rest.
void skin_box(const Body& body, Vec3f& low_mm, Vec3f& high_mm);

}  // namespace limberg
